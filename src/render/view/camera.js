// A camera that orbits a point, moved by mouse, touch and keys.

import { add, clamp, cross, dot, multiply, scale } from "./math.js";

export class OrbitCamera {
  constructor() {
    this.target = [0, 1, 0];
    this.home = { yaw: 0.6, pitch: 0.22, distance: 4 };
    this.reset();
  }

  reset() { Object.assign(this, this.home); }

  orbit(right, up) {
    this.yaw -= right;
    this.pitch = clamp(this.pitch + up, -1.5, 1.55);
  }

  zoom(factor) { this.distance = clamp(this.distance * factor, this.home.distance * 0.02, this.home.distance * 40); }

  // Moves the camera by fractions of the visible height.
  pan(right, up) {
    const size = (2 * this.distance) / this.focal;
    const { x, y } = this.axes();
    this.target = add(this.target, add(scale(x, -right * size), scale(y, up * size)));
  }

  get focal() { return 1 / Math.tan(0.3); }

  axes() {
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    const z = [sy * cp, sp, cy * cp];
    const x = [cy, 0, -sy];
    return { x, y: cross(z, x), z };
  }

  see(aspect) {
    const { x, y, z } = this.axes();
    const eye = add(this.target, scale(z, this.distance));
    const worldToCamera = [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0,
      -dot(x, eye), -dot(y, eye), -dot(z, eye), 1];
    const [near, far] = [this.distance * 0.02, this.distance * 60];
    // The visible width of a narrow screen equals the visible height of a wide screen.
    const focal = this.focal * Math.min(1, aspect * 1.25);
    const toClip = [focal / aspect, 0, 0, 0, 0, focal, 0, 0, 0, 0, (far + near) / (near - far), -1,
      0, 0, (2 * far * near) / (near - far), 0];
    return { worldToClip: multiply(toClip, worldToCamera), eye, focal };
  }
}

// One pointer turns the camera, or moves it with Shift or another button. Two pointers zoom and move it. A press
// without a movement selects. `grab` may return a handler of the drag; then the drag does not move the camera.
export function listenToPointers(canvas, camera, { changed, hover, choose, grab }) {
  const pointers = new Map();
  let held = null;
  let moved = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    moved = pointers.size === 1 ? 0 : Infinity;
    held = pointers.size === 1 && event.button === 0 && !event.shiftKey ? grab(event) : null;
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return hover(event);
    const now = [event.clientX, event.clientY];
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    moved += Math.abs(dx) + Math.abs(dy);
    const height = canvas.clientHeight;
    if (pointers.size === 2) {
      const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      const spread = (place) => Math.hypot(place[0] - other[0], place[1] - other[1]) || 1;
      camera.zoom(spread(before) / spread(now));
      camera.pan(dx / 2 / height, dy / 2 / height);
    } else if (moved > 4 && held) {
      held(event);
    } else if (moved > 4) {
      if (event.shiftKey || event.buttons & 6) camera.pan(dx / height, dy / height);
      else camera.orbit((dx / height) * 4, (dy / height) * 4);
    }
    pointers.set(event.pointerId, now);
    changed();
  });
  const release = (event) => {
    if (pointers.delete(event.pointerId) && event.type === "pointerup" && moved <= 4) choose(event);
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("pointerleave", () => hover(null));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    camera.zoom(Math.exp(clamp(event.deltaY, -100, 100) * 0.0025));
    changed();
  }, { passive: false });
}
