// Reads the nodes and the motion of a .gltf or .glb file, and poses them, without code of mocap.

import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";

import { add, fromColumns, identity, multiply, rotate, unit } from "./math.js";

const WIDTH = { SCALAR: 1, VEC3: 3, VEC4: 4 };
const TYPES = {
  5120: ["getInt8", 1, 127],
  5121: ["getUint8", 1, 255],
  5122: ["getInt16", 2, 32767],
  5123: ["getUint16", 2, 65535],
  5126: ["getFloat32", 4, 1],
};

/** @returns {{ nodes, parents: number[], names: string[], tracks }} `tracks` belong to the last animation */
export function readGltf(path) {
  const bytes = readFileSync(path);
  let [json, bin] = [undefined, undefined];
  if (bytes.toString("latin1", 0, 4) === "glTF") {
    const size = bytes.readUInt32LE(12);
    json = JSON.parse(bytes.toString("utf8", 20, 20 + size));
    bin = bytes.subarray(28 + size);
  } else json = JSON.parse(bytes.toString("utf8"));
  const bufferOf = ({ uri }) => {
    if (uri === undefined) return bin;
    return uri.startsWith("data:") ? Buffer.from(uri.slice(uri.indexOf(",") + 1), "base64") : readFileSync(join(dirname(path), decodeURI(uri)));
  };
  const buffers = new Map();
  const buffer = (index) => buffers.get(index) ?? buffers.set(index, bufferOf(json.buffers[index])).get(index);
  const parents = json.nodes.map(() => -1);
  json.nodes.forEach(({ children = [] }, index) => children.forEach((child) => (parents[child] = index)));
  const numbers = (index) => {
    const { type, componentType, count, bufferView, byteOffset = 0, normalized } = json.accessors[index];
    const [read, bytesEach, most] = TYPES[componentType];
    const view = json.bufferViews[bufferView];
    const data = buffer(view.buffer);
    const at = new DataView(data.buffer, data.byteOffset + (view.byteOffset ?? 0) + byteOffset);
    const stride = view.byteStride ?? WIDTH[type] * bytesEach;
    return Array.from({ length: count }, (_, element) =>
      Array.from({ length: WIDTH[type] }, (_, column) => {
        const value = at[read](element * stride + column * bytesEach, true);
        return normalized ? Math.max(value / most, -1) : value;
      }),
    );
  };
  const animation = json.animations?.at(-1);
  const tracks = (animation?.channels ?? [])
    .filter(({ target }) => target.node !== undefined && target.path !== "weights")
    .map(({ sampler, target }) => {
      const { input, output, interpolation } = animation.samplers[sampler];
      if (interpolation === "CUBICSPLINE") throw new Error(`${path}: cubic splines`);
      return { ...target, times: numbers(input).flat(), values: numbers(output), isStep: interpolation === "STEP" };
    });
  const names = json.nodes.map(({ name, extras }) => extras?.source_name ?? name);
  return { nodes: json.nodes, parents, names, tracks };
}

/**
 * The nodes in the world at a time in seconds; without a time, at rest. `wanted` are the returned nodes; the default is
 * all nodes. @returns {import("./bvh.js").Pose}
 */
export function poseAt({ nodes, parents, tracks }, time, wanted = nodes.map((_, index) => index)) {
  const local = nodes.map(restOfNode);
  const above = new Set();
  for (const node of wanted) for (let at = node; at >= 0 && !above.has(at); at = parents[at]) above.add(at);
  const moving = time === undefined ? [] : tracks.filter(({ node }) => above.has(node));
  for (const track of moving) local[track.node][track.path] = valueAt(track, time);
  const world = [];
  const of = (index) => {
    if (index < 0) return { place: [0, 0, 0], rotation: identity, scale: [1, 1, 1] };
    world[index] ??= (() => {
      const [above, { translation, rotation, scale }] = [of(parents[index]), local[index]];
      return {
        place: add(above.place, rotate(above.rotation, translation.map((value, axis) => value * above.scale[axis]))),
        rotation: multiply(above.rotation, rotation),
        // In these files, no skeleton is below a scale that differs by axis.
        scale: scale.map((value, axis) => value * above.scale[axis]),
      };
    })();
    return world[index];
  };
  const all = wanted.map((index) => of(index));
  return { places: all.map(({ place }) => place), rotations: all.map(({ rotation }) => rotation) };
}

function restOfNode({ translation = [0, 0, 0], rotation = identity, scale = [1, 1, 1], matrix }) {
  if (!matrix) return { translation, rotation, scale };
  const columns = [0, 4, 8].map((at) => matrix.slice(at, at + 3));
  const sizes = columns.map((column) => Math.hypot(...column));
  const turned = fromColumns(...columns.map((column, axis) => column.map((value) => value / sizes[axis])));
  return { translation: matrix.slice(12, 15), rotation: turned, scale: sizes };
}

function valueAt({ times, values, path, isStep }, time) {
  // Finds the first key after the time by binary search.
  let [first, next] = [0, times.length];
  while (first < next) {
    const half = (first + next) >> 1;
    if (times[half] > time + 1e-6) next = half;
    else first = half + 1;
  }
  if (next === 0 || next === times.length || isStep) return values[Math.max(next - 1, 0)];
  const share = (time - times[next - 1]) / (times[next] - times[next - 1]);
  const [from, to] = [values[next - 1], values[next]];
  const sign = path === "rotation" && from.reduce((sum, value, axis) => sum + value * to[axis], 0) < 0 ? -1 : 1;
  const mixed = from.map((value, axis) => value * (1 - share) + sign * to[axis] * share);
  return path === "rotation" ? unit(mixed) : mixed;
}
