// A clip: nodes, their tracks, and forward kinematics, T = J0 L1 J1 L2 ...
//
// The properties of a clip, from any data source:
//   name, facts          text
//   file                 the name of the file, if no step changed the motion; else null
//   frames, ticksPerSecond, metresPerUnit
//   up                   the axis that points up in the file: "+y", "-z", ...
//   size                 reach: the distance from the centre of the figure to its farthest joint; floor: the height of the
//                        lowest joint; both in metres with +Y up
//   anchors              the nodes whose centroid the camera follows
//   warnings, assumptions   lists of text
//   packingError         the largest distance of a joint from its position in the file, in metres
//   humanoid             whether the skeleton is a humanoid
//   skin                 a skin (see skin.js), or null
//   isTurned             whether the page turns the figure by 180 degrees, so that the viewer sees its front
//   contacts             points of feet: node, bone, and intervals, lists of first and last frame at rest
//   limbs                null, or the angles between the limbs and another clip's limbs: nodes (at the start of each limb),
//                        bones, frames, angles (in steps; all frames of the first limb, then of the next), step (in
//                        degrees), mean, largest
//   morphs               null, or the weights of animated morph targets: sliders (slider, least, step), frames, weights
//                        (in steps above the least; all frames of the first slider, then of the next slider)
//   nodes                parents first. Each has name, kind ("joint", "end_site", "group"), parent (-1: none), side, bone
//                        (null, or name, side, confidence, reason), inBody, isShown, isLinked (to its parent), lines, order,
//                        turns, moves, and the tracks translation, rotation, scale. A track has values (Float32Array)
//                        of one tick (keys 1) or of every tick.
//   firstTick            the first tick of the motion, after a rest pose
//   load(frame)          decodes the values of a frame, if necessary
//   glb()                the bytes of a .glb, or a promise of them, or null
//   source               null, or the original file: name, and bytes()

import { add, boxAround, clamp, compose, dot, inverseLinear, matrixAngles, multiply, nearestAngles, rotationOf, scale, slerp, sub } from "./math.js";
import { Curves } from "./curves.js";
import { Posing } from "./posing.js";

// Rows of the matrix that rotates the file's up axis to +Y.
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
    // Rows of the matrix from the file's axes to the page's axes.
    const signs = this.isTurned ? [-1, 1, -1] : [1, 1, 1];
    this.rows = TO_Y_UP[this.up].map((row, axis) => scale(row, signs[axis]));
    // The matrices in the current pose, from each node to its parent and to the world.
    this.locals = this.nodes.map(() => null);
    this.world = this.nodes.map(() => null);
    this.children = this.nodes.map(() => []);
    this.nodes.forEach((node, id) => node.parent >= 0 && this.children[node.parent].push(id));
    this.posing = new Posing(this);
    this.duration = Math.max(0, this.frames - 1);
    this.seconds = this.duration / this.ticksPerSecond;
    // The translation from the file's world to the page's world, which is in metres with +Y up.
    this.shift = [0, 0, 0];
    this.pose(0);
  }

  // The value of a track at a tick. The values are groups of `size` numbers.
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

  // The tick at a time in seconds. After its end, a clip stays at its last tick.
  tickAt(seconds) {
    const tick = Math.min(seconds * this.ticksPerSecond, this.duration);
    // Round, because seconds times a rate misses whole ticks by a rounding error.
    return Math.abs(tick - Math.round(tick)) < 1e-6 ? Math.round(tick) : tick;
  }

  // Parents precede their children, so forward kinematics is one loop.
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

  // Rotates a node and its descendants in the current pose, about the node's position. `rotation` is in the axes of the
  // world.
  rotate(id, rotation) {
    const { parent } = this.nodes[id];
    const local = this.locals[id];
    const toWorld = parent < 0 ? compose([0, 0, 0], [0, 0, 0, 1], [1, 1, 1]) : this.world[parent];
    const turn = multiply(compose([0, 0, 0], rotation, [1, 1, 1]), multiply(toWorld, local));
    const turned = multiply(inverseLinear(toWorld), turn);
    this.locals[id] = [...turned.slice(0, 12), ...local.slice(12)];
    // Nodes are depth-first, so the descendants of a node directly follow it.
    for (let below = id; below < this.nodes.length && (below === id || this.nodes[below].parent >= id); below++) this.updateWorld(below);
  }

  // The weights of all sliders of the skin at a tick, from the file's motion.
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

  // The nodes from the root to this node.
  chain(id) {
    const chain = [];
    for (let node = id; node >= 0; node = this.nodes[node].parent) chain.unshift(node);
    return chain;
  }

  // The world matrix of one node at any tick.
  worldAt(id, tick) {
    return this.chain(id).map((node) => this.local(node, tick)).reduce(multiply);
  }

  filePosition(id) { return this.world[id].slice(12, 15); }

  toPage(point) {
    return add(this.rows.map((row) => dot(row, point) * this.metresPerUnit), this.shift);
  }

  // The transform of toPage as a matrix.
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

  // The centre of the bounding box of the drawn figure.
  middle() {
    const [low, high] = boxAround(this.drawn.filter((_, id) => this.nodes[id].inBody));
    return scale(add(low, high), 0.5);
  }

  // The smoothed path of the anchors for the camera, without the sway of the hips.
  smoothAnchor(tick) {
    const half = 0.35 * this.ticksPerSecond;
    // At most a dozen markers are enough for the centroid.
    const anchors = this.anchors.filter((_, i) => i % Math.ceil(this.anchors.length / 12) === 0);
    let sum = [0, 0, 0];
    for (let i = -4; i <= 4; i++) {
      const at = clamp(tick + (i * half) / 4, 0, this.duration);
      for (const id of anchors) sum = add(sum, this.pagePositionAt(id, at));
    }
    return scale(sum, 1 / (9 * anchors.length));
  }

  // The curves of a joint over all frames, sampled on demand.
  curves(id) {
    if (this.cached?.id !== id) this.cached = new Curves(this, id);
    return this.cached;
  }

  // The Euler angles of a joint in the current pose, in the order of its channels.
  angles(id) {
    const frame = Math.floor(this.tick);
    const known = this.cached?.id === id && frame < this.cached.filled;
    const { angles, goals } = this.posing;
    // Return the set angles: in gimbal lock the matrix does not determine them.
    if (angles.has(id) && !goals.size) return [...angles.get(id)];
    const near = angles.get(id) ?? (known ? this.cached.rows.euler.map((row) => row[frame]) : [0, 0, 0]);
    return nearestAngles(near, matrixAngles(this.locals[id], this.nodes[id].order));
  }

  // The rotation of a joint relative to its parent in the current pose. Without a manual pose, this is the file's
  // rotation.
  rotationNow(id) {
    return this.posing.isPosed ? rotationOf(this.angles(id), this.nodes[id].order) : Array.from(this.rotation(id, this.tick));
  }
}
