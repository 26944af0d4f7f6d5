// Plays a .glb file in double precision, without a glTF library: the world positions of its nodes at a time.

import { numbersOf } from "./glb.js";
import { compose, multiply } from "./matrix.js";
import { unpacked } from "./meshopt.js";

function lerp(a, b, share) {
  return a.map((value, component) => value + share * (b[component] - value));
}

/** The shorter way between two quaternions. */
function slerp(a, b, share) {
  const dot = a.reduce((sum, value, component) => sum + value * b[component], 0);
  const end = dot < 0 ? b.map((value) => -value) : b;
  const angle = Math.acos(Math.min(1, Math.abs(dot)));
  // For quaternions this near to each other, the sines below would divide rounding errors by each other.
  if (angle < 1e-6) return lerp(a, end, share);
  const [from, to] = [Math.sin((1 - share) * angle), Math.sin(share * angle)].map((sine) => sine / Math.sin(angle));
  return a.map((value, component) => from * value + to * end[component]);
}

/** The value of a track at a time; constant before the first key and after the last. */
function trackOf(file, { input, output, interpolation = "LINEAR" }, path) {
  if (!["LINEAR", "STEP"].includes(interpolation)) throw new Error(`no way to play ${interpolation}`);
  const times = numbersOf(file, input);
  const values = numbersOf(file, output);
  const width = values.length / times.length;
  const valueOf = (key) => [...values.subarray(key * width, (key + 1) * width)];
  const between = path === "rotation" ? slerp : lerp;
  let next = 0;
  return (seconds) => {
    if (next > 0 && times[next - 1] > seconds) next = 0;
    while (next < times.length && times[next] <= seconds) next += 1;
    if (next === 0) return valueOf(0);
    if (next === times.length || interpolation === "STEP") return valueOf(next - 1);
    const share = (seconds - times[next - 1]) / (times[next] - times[next - 1]);
    return share === 0 ? valueOf(next - 1) : between(valueOf(next - 1), valueOf(next), share);
  };
}

/**
 * How a client treats a quaternion whose length is not 1, for example after coarse quantization. Babylon uses the
 * quaternion unchanged, so that it stretches the figure; three.js normalises interpolated quaternions over a small
 * angle.
 *
 * @typedef {"unchanged" | "normalised"} Reading
 */

function normalised(quaternion) {
  const length = Math.hypot(...quaternion);
  return quaternion.map((value) => value / length);
}

/**
 * Opens a file. `indexOf` finds a node by name; `placesAt` returns the position of every node, in the order of the
 * file.
 *
 * @param {string} path
 * @returns {Promise<{ indexOf: Map<string, number>, placesAt: (seconds: number, reading?: Reading) => number[][] }>}
 */
export async function open(path) {
  const file = await unpacked(path);
  const { nodes, animations = [] } = file.json;
  const parents = nodes.map(() => -1);
  nodes.forEach((node, index) => node.children?.forEach((child) => (parents[child] = index)));
  const order = [];
  const visit = (index) => {
    order.push(index);
    nodes[index].children?.forEach(visit);
  };
  parents.forEach((parent, index) => parent < 0 && visit(index));

  const tracks = nodes.map(() => ({}));
  for (const { channels, samplers } of animations) {
    for (const { sampler, target } of channels) {
      tracks[target.node][target.path] = trackOf(file, samplers[sampler], target.path);
    }
  }
  const placesAt = (seconds, reading = "unchanged") => {
    const worlds = [];
    for (const index of order) {
      const node = nodes[index];
      if (node.matrix) throw new Error(`${path}: a node has a matrix`);
      const { translation, rotation, scale } = tracks[index];
      const turn = rotation?.(seconds) ?? node.rotation ?? [0, 0, 0, 1];
      const local = compose(
        translation?.(seconds) ?? node.translation ?? [0, 0, 0],
        reading === "normalised" ? normalised(turn) : turn,
        scale?.(seconds) ?? node.scale ?? [1, 1, 1],
      );
      worlds[index] = parents[index] < 0 ? local : multiply(worlds[parents[index]], local);
    }
    return worlds.map((world) => world.slice(12, 15));
  };
  return { indexOf: new Map(nodes.map(({ name }, index) => [name, index])), placesAt };
}
