// Steers a figure with keys and a stick by motion matching in the browser, at 60 frames per second.
//
// The address can select the files: ?moves=walks.mdb&character=hero.glb. ?yaw=1.2 sets the direction of the camera.

import { load } from "../package/index.js";
import { Batch } from "../../../src/render/view/batch.js";
import { OrbitCamera, listenToPointers } from "../../../src/render/view/camera.js";
import { NO_BONE, PALETTE, THEMES } from "../../../src/render/view/colors.js";
import { GlRenderer } from "../../../src/render/view/renderer_gl.js";
import { normalize } from "../../../src/render/view/math.js";

/** The speed at the edge of the stick, and with Shift, in m/s. */
const [WALK, RUN] = [1.3, 2.6];
/** The figure's frames per second, and the largest number of frames to catch up after a pause. */
const [RATE, MOST_STEPS] = [60, 6];
/** The dead zone of a gamepad's stick, as a fraction of its range. */
const DEAD_ZONE = 0.15;
/** The height of the camera's target, the distance of the camera, and the reach of the figure, in metres. */
const [HEIGHT, DISTANCE, REACH] = [0.9, 4.2, 0.9];
/** The radius of the drawn shadow around the figure, in metres, and the side of the shadow map, in pixels. */
const [SHADOW_REACH, SHADOW_SIZE] = [1.7, 512];
/** Below the first frame rate, the picture gets coarser. Above the second, it slowly gets finer. */
const [FEWEST, MOST] = [57, 59];
/** The coarsest resolution, in picture pixels per page pixel along one side. */
const COARSEST = 0.5;
/** The largest width of a bone, and its width relative to its length. */
const [WIDEST, SLENDERNESS] = [0.035, 0.14];
/** A longer link does not belong to a body. */
const LONGEST_LINK = 0.8;

const byId = (id) => document.getElementById(id);
const canvas = byId("picture");
const address = new URLSearchParams(location.search);
const keys = new Set();
const stick = { x: 0, y: 0 };

/** The combined input of keys, stick and gamepad: right and forward, at most 1 long. */
function asked() {
  const held = (...names) => (names.some((name) => keys.has(name)) ? 1 : 0);
  let x = held("KeyD", "ArrowRight") - held("KeyA", "ArrowLeft") + stick.x;
  let y = held("KeyW", "ArrowUp") - held("KeyS", "ArrowDown") + stick.y;
  for (const gamepad of navigator.getGamepads?.() ?? []) {
    if (!gamepad || Math.hypot(gamepad.axes[0], gamepad.axes[1]) < DEAD_ZONE) continue;
    // The y axis of a gamepad points down.
    x += gamepad.axes[0];
    y -= gamepad.axes[1];
  }
  const length = Math.max(1, Math.hypot(x, y));
  return { x: x / length, y: y / length };
}

function listen() {
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    keys.add(event.code);
    if (event.code.startsWith("Arrow")) event.preventDefault();
  });
  addEventListener("keyup", (event) => keys.delete(event.code));
  // The page gets no event for a key that is released outside it.
  addEventListener("blur", () => keys.clear());
  const pad = byId("stick");
  const move = (event) => {
    const box = pad.getBoundingClientRect();
    const [x, y] = [(2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height];
    const length = Math.max(1, Math.hypot(x, y));
    Object.assign(stick, { x: x / length, y: y / length });
    byId("knob").style.transform = `translate(${stick.x * 40}px, ${stick.y * -40}px)`;
  };
  const release = () => {
    Object.assign(stick, { x: 0, y: 0 });
    byId("knob").style.transform = "";
  };
  pad.addEventListener("pointerdown", (event) => { pad.setPointerCapture(event.pointerId); move(event); });
  pad.addEventListener("pointermove", (event) => { if (pad.hasPointerCapture(event.pointerId)) move(event); });
  pad.addEventListener("pointerup", release);
  pad.addEventListener("pointercancel", release);
}

/** The links of the body, from each joint to its parent. */
function linksOf(hero) {
  const side = ({ name }) => (/left|(^|[_.-])l([_.-]|$)/i.test(name) ? 0 : /right|(^|[_.-])r([_.-]|$)/i.test(name) ? 1 : 2);
  const colors = [PALETTE[0], PALETTE[1], NO_BONE];
  const ofBody = ({ kind, parent }) => kind !== "group" && parent !== null && hero.nodes[parent].kind === "joint";
  return hero.nodes.flatMap((node, id) => (ofBody(node) ? [{ id, parent: node.parent, color: colors[side(node)] }] : []));
}

/** The new resolution in picture pixels per page pixel, for the measured frame rate. */
function finer(fineness, frames) {
  const finest = Math.min(2, devicePixelRatio || 1);
  if (frames < FEWEST) return Math.max(COARSEST, fineness * Math.max(0.5, Math.sqrt(frames / RATE)));
  return frames > MOST ? Math.min(finest, fineness * 1.05) : fineness;
}

async function fetched(file) {
  const response = await fetch(file);
  if (!response.ok) throw new Error(`${file}: ${response.status}. tools/wasm/demo/build makes it`);
  return new Uint8Array(await response.arrayBuffer());
}

async function start() {
  const character = address.get("character") ?? "hero.glb";
  const [mocap, moves, bytes] = await Promise.all([load(), fetched(address.get("moves") ?? "moves.mdb"), fetched(character)]);
  const hero = mocap.read(bytes, character, { skeletonMesh: "none" });
  const figure = hero.controller(moves);
  const links = linksOf(hero);
  const camera = new OrbitCamera();
  camera.home = { yaw: Number(address.get("yaw") ?? Math.PI - 0.5), pitch: 0.3, distance: DISTANCE };
  camera.reset();
  listen();
  listenToPointers(canvas, camera, { changed() {}, hover() {}, choose() {}, grab: () => null });
  const renderer = new GlRenderer(canvas, () => {}, SHADOW_SIZE);
  const view = {
    bones: new Batch(), rods: new Batch(), balls: new Batch(), skins: [], clips: [], bonesShade: true,
    reach: REACH, ground: 0, gridStep: 0.2, sun: normalize([0.35, 1, 0.45]), groundExtent: 14, shadowReach: SHADOW_REACH, target: camera.target,
  };
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let [before, owed, frames, spent, steps, since] = [performance.now(), 0, 0, 0, 0, performance.now()];
  let fineness = Math.min(2, devicePixelRatio || 1);

  function step() {
    const { x, y } = asked();
    const speed = keys.has("ShiftLeft") || keys.has("ShiftRight") ? RUN : WALK;
    // Right and forward of the camera, over the ground.
    const [sin, cos] = [Math.sin(camera.yaw), Math.cos(camera.yaw)];
    figure.steer(speed * (cos * x - sin * y), speed * (-sin * x - cos * y));
    return speed * Math.hypot(x, y);
  }

  function fill() {
    for (const batch of [view.bones, view.rods, view.balls]) batch.clear();
    const world = figure.nodeToWorld;
    const at = (id) => world.subarray(16 * id + 12, 16 * id + 15);
    for (const { id, parent, color } of links) {
      const [from, to] = [at(parent), at(id)];
      const length = Math.hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
      if (length < LONGEST_LINK) view.bones.add(from, to, Math.min(SLENDERNESS * length, WIDEST), color);
    }
  }

  function draw(now) {
    requestAnimationFrame(draw);
    const last = before;
    owed = Math.min(owed + ((now - before) / 1000) * RATE, MOST_STEPS);
    before = now;
    for (; owed >= 1; owed -= 1) {
      const begin = performance.now();
      step();
      spent += performance.now() - begin;
      steps++;
    }
    fill();
    const [x, z] = figure.root;
    camera.target[0] += 0.1 * (x - camera.target[0]);
    camera.target[1] = HEIGHT;
    camera.target[2] += 0.1 * (z - camera.target[2]);
    view.target = camera.target;
    const size = [canvas.clientWidth * fineness, canvas.clientHeight * fineness].map(Math.round);
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    view.camera = camera.see(canvas.width / Math.max(1, canvas.height));
    view.theme = THEMES[dark.matches ? "dark" : "light"];
    renderer.draw(view);
    frames++;
    if (now - since < 1000) return;
    const rates = { frames: (1000 * frames) / (now - since), microseconds: (1000 * spent) / Math.max(1, steps) };
    byId("said").textContent = `${rates.frames.toFixed(0)} frames a second; ${rates.microseconds.toFixed(0)} µs for the figure each; ${figure.frames} frames of motion`;
    globalThis.demo.rates = rates;
    // Ignore the frame rate of a page in the background, which draws nothing.
    if (now - last < 500) fineness = finer(fineness, rates.frames);
    [frames, spent, steps, since] = [0, 0, 0, now];
  }

  // For tests and the console.
  globalThis.demo = { figure, hero, camera, view };
  requestAnimationFrame(draw);
  canvas.focus();
}

start().catch((error) => {
  byId("said").textContent = `${error.message}${error.help ? `; ${error.help}` : ""}`;
});
