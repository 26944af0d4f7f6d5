// The fallback without WebGL 2: draws the same scene with lines and polygons of a 2D canvas, from back to front.

import { css } from "./dom.js";
import { project } from "./math.js";

export class FlatRenderer {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.name = "Canvas 2D";
  }

  draw(view) {
    const { canvas, pen } = this;
    const { worldToClip } = view.camera;
    this.place = (point) => {
      const [x, y, depth] = project(worldToClip, point);
      return [(0.5 + 0.5 * x) * canvas.width, (0.5 - 0.5 * y) * canvas.height, depth];
    };
    pen.fillStyle = css(view.theme.background);
    pen.fillRect(0, 0, canvas.width, canvas.height);
    this.drawGround(view);
    this.drawShadows(view);

    const things = [];
    for (const kind of ["bones", "rods", "balls"]) {
      for (let i = 0; i < view[kind].count; i++) {
        const { from, to, width, color } = view[kind].at(i);
        const [a, b] = [this.place(from), this.place(to)];
        if (a[2] > 0 && b[2] > 0) things.push({ kind, a, b, width, color, depth: 0.5 * (a[2] + b[2]) });
      }
    }
    things.sort((one, other) => other.depth - one.depth);
    for (const thing of things) this.drawThing(thing, this.pixelsPerUnit(view, thing.depth));
  }

  pixelsPerUnit(view, depth) { return (0.5 * this.canvas.height * view.camera.focal) / depth; }

  drawThing({ kind, a, b, width, color }, scale) {
    const { pen } = this;
    if (kind === "balls") {
      pen.fillStyle = css(color);
      pen.beginPath();
      pen.arc(a[0], a[1], Math.max(1, width * scale), 0, 2 * Math.PI);
      pen.fill();
    } else if (kind === "rods") {
      this.stroke([a, b], css(color), Math.max(1, 2 * width * scale));
    } else {
      const way = [b[0] - a[0], b[1] - a[1]];
      const size = Math.hypot(...way) || 1;
      const aside = [(-way[1] / size) * width * scale, (way[0] / size) * width * scale];
      const light = aside[0] + aside[1] < 0 ? 1 : -1;
      for (const [side, shade] of [[light, 1.12], [-light, 0.82]]) {
        pen.fillStyle = css(Array.from(color, (part) => Math.min(1, part * shade)));
        pen.beginPath();
        pen.moveTo(a[0], a[1]);
        pen.lineTo(a[0] + 0.16 * way[0] + side * aside[0], a[1] + 0.16 * way[1] + side * aside[1]);
        pen.lineTo(b[0], b[1]);
        pen.fill();
      }
    }
  }

  drawGround({ target, ground, gridStep, groundExtent, theme }) {
    const lines = Math.min(16, Math.floor(groundExtent / gridStep));
    const [x, z] = [target[0], target[2]].map((value) => Math.round(value / gridStep) * gridStep);
    const half = lines * gridStep;
    for (let i = -lines; i <= lines; i++) {
      const aside = i * gridStep;
      // Draw lines in pieces, because a point behind the camera has no position on the screen.
      for (let j = -lines; j < lines; j++) {
        const along = [j * gridStep, (j + 1) * gridStep];
        const color = css(theme.grid, 1 - Math.hypot(aside, along[0]) / (1.1 * half));
        this.stroke(along.map((step) => this.place([x + aside, ground, z + step])), color, 1);
        this.stroke(along.map((step) => this.place([x + step, ground, z + aside])), color, 1);
      }
    }
  }

  drawShadows(view) {
    for (let i = 0; i < view.bones.count; i++) {
      const { from, to, width } = view.bones.at(i);
      const ends = [from, to].map((point) => this.place([point[0], view.ground, point[2]]));
      this.stroke(ends, css([0, 0, 0], 0.12), Math.max(2, 2 * width * this.pixelsPerUnit(view, ends[0][2])));
    }
  }

  stroke(points, color, width) {
    if (points.some((point) => point[2] <= 0)) return;
    const { pen } = this;
    pen.strokeStyle = color;
    pen.lineWidth = width;
    pen.lineCap = "round";
    pen.beginPath();
    points.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    pen.stroke();
  }
}
