// A clip: nodes, their tracks, and forward kinematics, T = J0 L1 J1 L2 ...
//
// What a clip is made of, wherever it comes from:
//   name, facts          text
//   file                 the file that it is of, where nothing was done to it; else null
//   frames, ticksPerSecond, metresPerUnit
//   up                   the axis that points up in the file: "+y", "-z", ...
//   size                 reach: from the middle of the figure to its farthest joint; floor: the height of the lowest
//                        joint; both in metres with +Y up
//   anchors              the nodes whose middle the camera follows
//   warnings, assumptions   lists of text
//   packingError         metres between a joint here and in the file, at most
//   humanoid             whether it is one
//   skin                 what skin.js describes, or null
//   isTurned             whether the page shows it from behind what the file calls its front
//   contacts             points of feet: node, bone, and intervals, lists of first and last frame at rest
//   limbs                null, or how far limbs point from those of another clip: nodes (where they start), bones, frames, angles
//                        (of each frame, limb after limb, in steps), step (in degrees), mean, largest
//   morphs               null, or the weights of morph targets that move: sliders (slider, least, step), frames, weights (steps above
//                        the least of each frame, slider after slider)
//   nodes                parents first; of each name, kind ("joint", "end_site", "group"), parent (-1: none), side, bone
//                        (null, or name, side, confidence, reason), inBody, isShown, isLinked (to its parent), lines, order, turns, moves, and the tracks
//                        translation, rotation, scale: values (Float32Array) of one tick (keys 1) or every tick
//   firstTick            where it begins, after a rest pose; 0 where it is not stated
//   load(frame)          makes the values of a frame ready, if they are not
//   glb()                the bytes of a .glb, or a promise of them, or null
//   source               null, or the file as it was: name, and bytes()

import { add, boxAround, clamp, compose, dot, inverseLinear, matrixAngles, multiply, nearestAngles, rotationOf, scale, slerp, sub } from "./math.js";
import { Curves } from "./curves.js";
import { Posing } from "./posing.js";

// Rows of the matrix that turns the file's up into +Y.
const TO_Y_UP = {
  "+y": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  "-y": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
  "+z": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
  "-z": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
  "+x": [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
  "-x": [[0, 1, 0], [-1, 0, 0], [0, 0, 1]],
};

export class Clip {
  constructor(data, index) {
    Object.assign(this, data);
    this.index = index;
    // Rows of the matrix from the file's axes to the page's.
    const signs = this.isTurned ? [-1, 1, -1] : [1, 1, 1];
    this.rows = TO_Y_UP[this.up].map((row, axis) => scale(row, signs[axis]));
    // Of this picture: each node to its parent, and to the world.
    this.locals = this.nodes.map(() => null);
    this.world = this.nodes.map(() => null);
    this.children = this.nodes.map(() => []);
    this.nodes.forEach((node, id) => node.parent >= 0 && this.children[node.parent].push(id));
    this.posing = new Posing(this);
    this.duration = Math.max(0, this.frames - 1);
    this.seconds = this.duration / this.ticksPerSecond;
    // From the file's world to the page's, which is in metres with +Y up.
    this.shift = [0, 0, 0];
    this.pose(0);
  }

  // The value of a track at a tick: numbers in groups of `size`.
  value({ values, keys }, size, tick) {
    const position = clamp(tick, 0, keys - 1);
    const before = Math.floor(position);
    const share = position - before;
    const start = before * size;
    if (keys > 1) this.load(before);
    const a = values.subarray(start, start + size);
    if (share === 0) return a;
    this.load(before + 1);
    const b = values.subarray(start + size, start + 2 * size);
    return size === 4 ? slerp(a, b, share) : [0, 1, 2].map((i) => a[i] + (b[i] - a[i]) * share);
  }

  translation(id, tick) { return this.value(this.nodes[id].translation, 3, tick); }
  rotation(id, tick) { return this.value(this.nodes[id].rotation, 4, tick); }
  scaling(id, tick) { return this.value(this.nodes[id].scale, 3, tick); }
  local(id, tick) { return compose(this.translation(id, tick), this.rotation(id, tick), this.scaling(id, tick)); }

  // The tick at a time of all clips; a clip that is over stays at its last.
  tickAt(seconds) {
    const tick = Math.min(seconds * this.ticksPerSecond, this.duration);
    // Seconds times a rate misses whole ticks by a rounding error.
    return Math.abs(tick - Math.round(tick)) < 1e-6 ? Math.round(tick) : tick;
  }

  // Parents stand before their children, so the kinematics is one loop.
  pose(tick) {
    if (tick !== this.tick) this.posing.reset();
    this.tick = tick;
    this.nodes.forEach((_, id) => {
      this.locals[id] = this.posing.local(id, tick) ?? this.local(id, tick);
      this.updateWorld(id);
    });
    this.posing.applyGoals();
    this.drawn = this.nodes.map((_, id) => this.pagePosition(id));
  }

  updateWorld(id) {
    const { parent } = this.nodes[id];
    this.world[id] = parent < 0 ? this.locals[id] : multiply(this.world[parent], this.locals[id]);
  }

  // Turns a node about its own position by a rotation along the axes of the world, with all nodes below it, in this picture.
  rotate(id, rotation) {
    const { parent } = this.nodes[id];
    const local = this.locals[id];
    const toWorld = parent < 0 ? compose([0, 0, 0], [0, 0, 0, 1], [1, 1, 1]) : this.world[parent];
    const turn = multiply(compose([0, 0, 0], rotation, [1, 1, 1]), multiply(toWorld, local));
    const turned = multiply(inverseLinear(toWorld), turn);
    this.locals[id] = [...turned.slice(0, 12), ...local.slice(12)];
    // Depth-first order: those below a node come right after it.
    for (let below = id; below < this.nodes.length && (below === id || this.nodes[below].parent >= id); below++) this.updateWorld(below);
  }

  // The weights of all sliders of the skin at a tick, as the file moves them.
  morphWeights(tick) {
    const { sliders, weights, frames } = this.morphs;
    const all = this.skin.morphs.map(({ weight }) => weight);
    const before = clamp(Math.floor(tick), 0, frames - 1);
    sliders.forEach(({ slider, least, step }, row) => {
      const [a, b] = [before, Math.min(before + 1, frames - 1)].map((frame) => weights[row * frames + frame]);
      all[slider] = least + step * (a + (b - a) * clamp(tick - before, 0, 1));
    });
    return all;
  }

  // From the root to the node.
  chain(id) {
    const chain = [];
    for (let node = id; node >= 0; node = this.nodes[node].parent) chain.unshift(node);
    return chain;
  }

  // The matrix of one node alone, at any tick.
  worldAt(id, tick) {
    return this.chain(id).map((node) => this.local(node, tick)).reduce(multiply);
  }

  filePosition(id) { return this.world[id].slice(12, 15); }

  toPage(point) {
    return add(this.rows.map((row) => dot(row, point) * this.metresPerUnit), this.shift);
  }

  // The same as toPage, as a matrix.
  get pageMatrix() {
    const column = (axis) => [...this.rows.map((row) => row[axis] * this.metresPerUnit), 0];
    return [...column(0), ...column(1), ...column(2), ...this.shift, 1];
  }

  toFile(point) {
    const turned = scale(sub(point, this.shift), 1 / this.metresPerUnit);
    return [0, 1, 2].map((axis) => this.rows.reduce((sum, row, i) => sum + row[axis] * turned[i], 0));
  }

  pagePosition(id) { return this.toPage(this.filePosition(id)); }
  pagePositionAt(id, tick) { return this.toPage(this.worldAt(id, tick).slice(12, 15)); }

  // The middle of the box around the figure as it is drawn.
  middle() {
    const [low, high] = boxAround(this.drawn.filter((_, id) => this.nodes[id].inBody));
    return scale(add(low, high), 0.5);
  }

  // The way of the anchors without the sway of the hips, for a camera to follow.
  smoothAnchor(tick) {
    const half = 0.35 * this.ticksPerSecond;
    // Many markers are where a few of them are.
    const anchors = this.anchors.filter((_, i) => i % Math.ceil(this.anchors.length / 12) === 0);
    let sum = [0, 0, 0];
    for (let i = -4; i <= 4; i++) {
      const at = clamp(tick + (i * half) / 4, 0, this.duration);
      for (const id of anchors) sum = add(sum, this.pagePositionAt(id, at));
    }
    return scale(sum, 1 / (9 * anchors.length));
  }

  // The curves of a joint over all frames.
  curves(id) {
    if (this.cached?.id !== id) this.cached = new Curves(this, id);
    return this.cached;
  }

  // The angles of a joint in this picture, as its channels give them.
  angles(id) {
    const frame = Math.floor(this.tick);
    const known = this.cached?.id === id && frame < this.cached.filled;
    const { angles, goals } = this.posing;
    // In gimbal lock the matrix would not tell them.
    if (angles.has(id) && !goals.size) return [...angles.get(id)];
    const near = angles.get(id) ?? (known ? this.cached.rows.euler.map((row) => row[frame]) : [0, 0, 0]);
    return nearestAngles(near, matrixAngles(this.locals[id], this.nodes[id].order));
  }

  // Its rotation to the parent in this picture: that of the file, if nobody has posed the clip.
  rotationNow(id) {
    return this.posing.isPosed ? rotationOf(this.angles(id), this.nodes[id].order) : Array.from(this.rotation(id, this.tick));
  }
}
