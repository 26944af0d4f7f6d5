// Reads the motion of a BVH file in double precision, without mocap, as the reference for written files. It reads plain
// BVH, the form of the clips of sizes.js, and no dialects.

import { readFileSync } from "node:fs";

import { fromTranslation, multiply, rotation } from "./matrix.js";

/**
 * @typedef {{ name: string, parent: number, offset: number[], channels: string[] }} Joint
 * @typedef {{ joints: Joint[], frameTime: number, rows: Float64Array[] }} Motion
 */

/**
 * The joints in the order of the file, a parent before its children, and the rows of the motion. An End Site is a joint
 * without channels, called as mocap calls it.
 *
 * @returns {Motion}
 */
export function readBvh(path) {
  const [hierarchy, motion] = readFileSync(path, "utf8").split(/^\s*MOTION\s*$/m);
  const joints = readHierarchy(hierarchy.split(/\s+/).filter(Boolean));
  const [frames, seconds, ...values] = motion.replace(/Frames:|Frame Time:/g, "").split(/\s+/).filter(Boolean).map(Number);
  const width = joints.reduce((sum, { channels }) => sum + channels.length, 0);
  if (values.length !== frames * width || values.some(Number.isNaN)) {
    throw new Error(`${path}: ${values.length} values, where ${frames} rows of ${width} were expected`);
  }
  const rows = Array.from({ length: frames }, (_, row) => Float64Array.from(values.slice(row * width, (row + 1) * width)));
  return { joints, frameTime: seconds, rows };
}

/** @returns {Joint[]} */
function readHierarchy(words) {
  const joints = [];
  const open = [];
  for (let at = 0; at < words.length; at += 1) {
    const last = joints.at(-1);
    if (words[at] === "ROOT" || words[at] === "JOINT") {
      joints.push({ name: words[(at += 1)], parent: open.at(-1) ?? -1, offset: [], channels: [] });
    } else if (words[at] === "End") {
      at += 1;
      const parent = open.at(-1);
      joints.push({ name: `EndSite_${joints[parent].name}`, parent, offset: [], channels: [] });
    } else if (words[at] === "{") {
      open.push(joints.length - 1);
    } else if (words[at] === "}") {
      open.pop();
    } else if (words[at] === "OFFSET") {
      last.offset = words.slice(at + 1, at + 4).map(Number);
      at += 3;
    } else if (words[at] === "CHANNELS") {
      const count = Number(words[at + 1]);
      last.channels = words.slice(at + 2, at + 2 + count);
      at += 1 + count;
    } else if (words[at] !== "HIERARCHY") {
      throw new Error(`${words[at]} in the hierarchy`);
    }
  }
  return joints;
}

/**
 * The world position of every joint in a row of the motion, in the units of the file. Position channels replace the
 * OFFSET. Rotation channels apply in the order of the file, the first outermost.
 *
 * @param {Motion} motion
 * @returns {number[][]}
 */
export function placesInRow({ joints }, row) {
  const worlds = [];
  let column = 0;
  for (const { parent, offset, channels } of joints) {
    const place = [...offset];
    let turn = fromTranslation([0, 0, 0]);
    for (const channel of channels) {
      const axis = "XYZ".indexOf(channel[0]);
      const value = row[column];
      column += 1;
      if (channel.endsWith("position")) place[axis] = value;
      else turn = multiply(turn, rotation(axis, (value * Math.PI) / 180));
    }
    const local = multiply(fromTranslation(place), turn);
    worlds.push(parent < 0 ? local : multiply(worlds[parent], local));
  }
  return worlds.map((world) => world.slice(12, 15));
}
