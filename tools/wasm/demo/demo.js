// A figure that is walked with keys and stick: motion matching in the browser, 60 times a second.
//
// The address may say what is shown: ?moves=walks.mdb&character=hero.glb; ?yaw=1.2 is where the camera looks from.

import { load } from "../package/index.js";
import { Batch } from "../../../src/render/view/batch.js";
import { OrbitCamera, listenToPointers } from "../../../src/render/view/camera.js";
import { NO_BONE, PALETTE, THEMES } from "../../../src/render/view/colors.js";
import { GlRenderer } from "../../../src/render/view/renderer_gl.js";
import { normalize } from "../../../src/render/view/math.js";

/** Metres per second of the stick at its edge, and with Shift. */
const [WALK, RUN] = [1.3, 2.6];
/** Frames of the figure in a second, and the most that are made up for after a pause. */
const [RATE, MOST_STEPS] = [60, 6];
/** A stick of a gamepad that is this near to its centre is at its centre. */
const DEAD_ZONE = 0.15;
/** Height of what the camera looks at, how far away it is, and how far the figure reaches: metres. */
const [HEIGHT, DISTANCE, REACH] = [0.9, 4.2, 0.9];
/** How far around the figure its shadow is drawn, in metres, and in how many pixels along one side. */
const [SHADOW_REACH, SHADOW_SIZE] = [1.7, 512];
/** Where fewer frames a second are drawn, the picture gets coarser; where more are, finer again, but slowly. */
const [FEWEST, MOST] = [57, 59];
/** Pixels of the coarsest picture for each of the page, along one side. */
const COARSEST = 0.5;
/** Of a bone: its width at most, and its width for its length. */
const [WIDEST, SLENDERNESS] = [0.035, 0.14];
/** A link longer than this is none of a body. */
const LONGEST_LINK = 0.8;

const byId = (id) => document.getElementById(id);
const canvas = byId("picture");
const address = new URLSearchParams(location.search);
const keys = new Set();
const stick = { x: 0, y: 0 };

/** What the keys, the stick and a gamepad ask for together: right and forward, at most 1 long. */
function asked() {
  const held = (...names) => (names.some((name) => keys.has(name)) ? 1 : 0);
  let x = held("KeyD", "ArrowRight") - held("KeyA", "ArrowLeft") + stick.x;
  let y = held("KeyW", "ArrowUp") - held("KeyS", "ArrowDown") + stick.y;
  for (const gamepad of navigator.getGamepads?.() ?? []) {
    if (!gamepad || Math.hypot(gamepad.axes[0], gamepad.axes[1]) < DEAD_ZONE) continue;
    // A gamepad's y is down.
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
  // A key that is let go elsewhere is never heard of.
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

/** The links of the body: from a joint to the one above it. */
function linksOf(hero) {
  const side = ({ name }) => (/left|(^|[_.-])l([_.-]|$)/i.test(name) ? 0 : /right|(^|[_.-])r([_.-]|$)/i.test(name) ? 1 : 2);
  const colors = [PALETTE[0], PALETTE[1], NO_BONE];
  const ofBody = ({ kind, parent }) => kind !== "group" && parent !== null && hero.nodes[parent].kind === "joint";
  return hero.nodes.flatMap((node, id) => (ofBody(node) ? [{ id, parent: node.parent, color: colors[side(node)] }] : []));
}

/** How fine the picture is to be, in pixels for each of the page, where so many frames a second were drawn. */
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
    // Right and forward as the camera sees them, over the ground.
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
    // A page in the background draws nothing, which says nothing of its speed.
    if (now - last < 500) fineness = finer(fineness, rates.frames);
    [frames, spent, steps, since] = [0, 0, 0, now];
  }

  // For who looks at it from outside.
  globalThis.demo = { figure, hero, camera, view };
  requestAnimationFrame(draw);
  canvas.focus();
}

start().catch((error) => {
  byId("said").textContent = `${error.message}${error.help ? `; ${error.help}` : ""}`;
});
