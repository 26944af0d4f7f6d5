// Reads the source clips and the compressed clips as transforms of nodes at every frame. No code of mocap takes part:
// glTF is unpacked by meshoptimizer's JavaScript, packed clips by packed.js.

import { numbersOf } from "../../interop/glb.js";
import { unpacked } from "../../interop/meshopt.js";

/** The distance in metres from a joint to the three points that represent its skin, as in ACL. */
const SHELL = 0.03;

/**
 * @typedef {{ rotation: number[], translation: number[], scale: number[] }} Local
 * @typedef {{ names: string[], parents: number[], times: number[], at: (seconds: number) => Local[] }} Clip
 */

function lerp(a, b, share) {
  return a.map((value, component) => value + share * (b[component] - value));
}

function normalised(quaternion) {
  const length = Math.hypot(...quaternion);
  return quaternion.map((value) => value / length);
}

/** Interpolates two quaternions the shorter way, component by component, as most engines do. */
export function nlerp(a, b, share) {
  const dot = a.reduce((sum, value, component) => sum + value * b[component], 0);
  return normalised(lerp(a, dot < 0 ? b.map((value) => -value) : b, share));
}

function trackOf(file, { input, output, interpolation = "LINEAR" }, path) {
  const times = numbersOf(file, input);
  const values = numbersOf(file, output);
  const width = values.length / times.length;
  const valueOf = (key) => Array.from(values.subarray(key * width, (key + 1) * width));
  let next = 0;
  const at = (seconds) => {
    if (next > 0 && times[next - 1] > seconds) next = 0;
    while (next < times.length && times[next] <= seconds) next += 1;
    if (next === 0) return valueOf(0);
    if (next === times.length || interpolation === "STEP") return valueOf(next - 1);
    const share = (seconds - times[next - 1]) / (times[next] - times[next - 1]);
    if (share === 0) return valueOf(next - 1);
    return path === "rotation" ? nlerp(valueOf(next - 1), valueOf(next), share) : lerp(valueOf(next - 1), valueOf(next), share);
  };
  return { times, at };
}

/** The first animation of a .glb file. @returns {Promise<Clip>} */
export async function openGlb(path) {
  const file = await unpacked(path);
  const { nodes, animations = [] } = file.json;
  const parents = nodes.map(() => -1);
  nodes.forEach((node, index) => node.children?.forEach((child) => (parents[child] = index)));
  const tracks = nodes.map(() => ({}));
  let times = [0];
  for (const { sampler, target } of animations[0]?.channels ?? []) {
    const track = trackOf(file, animations[0].samplers[sampler], target.path);
    tracks[target.node][target.path] = track.at;
    if (track.times.length > times.length) times = Array.from(track.times);
  }
  const at = (seconds) =>
    nodes.map(({ translation = [0, 0, 0], rotation = [0, 0, 0, 1], scale = [1, 1, 1] }, node) => ({
      translation: tracks[node].translation?.(seconds) ?? translation,
      rotation: normalised(tracks[node].rotation?.(seconds) ?? rotation),
      scale: tracks[node].scale?.(seconds) ?? scale,
    }));
  return { names: nodes.map(({ name }) => name), parents, times, at };
}

function product([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

function turned([x, y, z, w], [a, b, c]) {
  const [tx, ty, tz] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

/** The position of every node, and of the three points of its shell. @param {Local[]} locals */
function points(locals, parents) {
  const world = new Array(locals.length);
  const worldOf = (node) => {
    if (world[node]) return world[node];
    const { translation, rotation, scale } = locals[node];
    const parent = parents[node] < 0 ? null : worldOf(parents[node]);
    world[node] = parent
      ? {
          place: turned(parent.rotation, translation.map((value) => value * parent.scale)).map((value, axis) => value + parent.place[axis]),
          rotation: product(parent.rotation, rotation),
          scale: parent.scale * scale[0],
        }
      : { place: translation, rotation, scale: scale[0] };
    return world[node];
  };
  return locals.map((_, node) => {
    const { place, rotation } = worldOf(node);
    const shell = [[SHELL, 0, 0], [0, SHELL, 0], [0, 0, SHELL]].map((arm) => turned(rotation, arm).map((value, axis) => value + place[axis]));
    return [place, ...shell];
  });
}

/**
 * The largest errors in metres of a joint's position and of a point of its shell, at any frame of the source.
 *
 * @param {Clip} source
 * @param {Clip} lossy
 */
export function errorsOf(source, lossy) {
  const places = lossy.names && new Map(lossy.names.map((name, node) => [name, node]));
  const nodes = source.names.map((name, node) => (places ? places.get(name) : node));
  let [joints, shells] = [0, 0];
  source.times.forEach((seconds, frame) => {
    const expected = points(source.at(seconds), source.parents);
    const found = points(lossy.at(seconds, frame), lossy.parents);
    expected.forEach((points, node) => {
      points.forEach((point, index) => {
        const other = found[nodes[node]][index];
        const distance = Math.hypot(point[0] - other[0], point[1] - other[1], point[2] - other[2]);
        if (index === 0) joints = Math.max(joints, distance);
        shells = Math.max(shells, distance);
      });
    });
  });
  return { joints, shells };
}
