// Reads and writes BVH, and poses its joints, without code of mocap.

import { readFileSync } from "node:fs";

import { aboutAxis, add, eulerZyx, identity, inverse, multiply, rotate } from "./math.js";

const AXES = { X: [1, 0, 0], Y: [0, 1, 0], Z: [0, 0, 1] };

/**
 * @typedef {{ name: string, parent: number, offset: number[], channels: string[], isEnd: boolean }} Joint
 * @typedef {{ places: number[][], rotations: number[][] }} Pose in the world of the file, by joint
 * @typedef {{ joints: Joint[], seconds: number, poses: Pose[], text?: { head: string, rows: string[] } }} Motion
 */

/** @returns {Motion} With `isAdded`, the root's positions are added to its OFFSET. */
export function readBvh(path, isAdded = false) {
  const [hierarchy, motion] = readFileSync(path, "latin1").split(/^\s*MOTION\s*$/im);
  const joints = hierarchyOf(hierarchy.split(/\s+/).filter(Boolean));
  if (motion === undefined) return { joints, seconds: 0, poses: [] };
  const lines = motion.split(/[\r\n]+/).map((line) => line.trim()).filter(Boolean);
  const rows = lines.slice(2);
  const seconds = Number(lines[1].split(/\s+/).at(-1));
  let last;
  const poses = rows.map((row) => {
    const values = row.split(/[\s,]+/).map(Number);
    // A value that is no number becomes the value of the last frame.
    last = values.map((value, column) => (Number.isFinite(value) ? value : (last?.[column] ?? 0)));
    return poseOf(joints, last, isAdded);
  });
  return { joints, seconds, poses, text: { head: `${hierarchy}MOTION\n`, rows } };
}

/** Writes rows `from` to `to` of a file without changes. */
export function cutOf({ text, seconds }, from, to) {
  const rows = text.rows.slice(from, to);
  return `${text.head}Frames: ${rows.length}\nFrame Time: ${seconds}\n${rows.join("\n")}\n`;
}

function hierarchyOf(words) {
  const joints = [];
  const open = [];
  for (let at = 0; at < words.length; at += 1) {
    const word = words[at].toUpperCase();
    if (word === "ROOT" || word === "JOINT") {
      const name = [];
      while (words[at + 1] !== "{") name.push(words[(at += 1)]);
      joints.push({ name: name.join(" "), parent: open.at(-1) ?? -1, offset: [0, 0, 0], channels: [], isEnd: false });
    } else if (word === "END") {
      at += 1;
      joints.push({ name: "", parent: open.at(-1), offset: [0, 0, 0], channels: [], isEnd: true });
    } else if (word === "{") {
      open.push(joints.length - 1);
    } else if (word === "}") {
      open.pop();
    } else if (word === "OFFSET") {
      joints.at(-1).offset = words.slice(at + 1, at + 4).map(Number);
      at += 3;
    } else if (word === "CHANNELS") {
      const count = Number(words[at + 1]);
      joints.at(-1).channels = words.slice(at + 2, at + 2 + count);
      at += 1 + count;
    }
  }
  return joints;
}

/** The joints in the world: position channels replace the OFFSET, and rotations apply in the order of the file. */
function poseOf(joints, row, isAdded) {
  const pose = { places: [], rotations: [] };
  let column = 0;
  for (const { parent, offset, channels } of joints) {
    const place = [...offset];
    let turned = identity;
    for (const channel of channels) {
      const value = row[column];
      column += 1;
      const axis = channel[0].toUpperCase();
      if (/position$/i.test(channel)) {
        const index = "XYZ".indexOf(axis);
        place[index] = value + (isAdded && parent < 0 ? offset[index] : 0);
      } else turned = multiply(turned, aboutAxis(AXES[axis], (value * Math.PI) / 180));
    }
    set(pose, parent, place, turned);
  }
  return pose;
}

function set(pose, parent, place, turned) {
  if (parent < 0) {
    pose.places.push(place);
    pose.rotations.push(turned);
    return;
  }
  pose.places.push(add(pose.places[parent], rotate(pose.rotations[parent], place)));
  pose.rotations.push(multiply(pose.rotations[parent], turned));
}

/** The pose in which all rotations are 0. */
export function restOf({ joints }) {
  const pose = { places: [], rotations: [] };
  for (const { parent, offset } of joints) set(pose, parent, offset, identity);
  return pose;
}

/**
 * The text of a BVH file with these poses. `offset` of each joint is in the axes of its parent; joints of `moving`, by
 * index, have position channels too, like the root.
 */
export function writeBvh(joints, seconds, poses, moving = new Set()) {
  const children = joints.map((_, index) => joints.flatMap(({ parent }, child) => (parent === index ? [child] : [])));
  const order = [];
  const hasPosition = (index) => joints[index].parent < 0 || moving.has(index);
  const block = (index, indent) => {
    const { name, parent, offset, isEnd } = joints[index];
    const head = isEnd ? "End Site" : `${parent < 0 ? "ROOT" : "JOINT"} ${name}`;
    const position = hasPosition(index) ? "6 Xposition Yposition Zposition" : "3";
    if (!isEnd) order.push(index);
    return [
      `${indent}${head}\n${indent}{\n${indent}\tOFFSET ${offset.map((value) => value.toFixed(6)).join(" ")}\n`,
      isEnd ? "" : `${indent}\tCHANNELS ${position} Zrotation Yrotation Xrotation\n`,
      ...children[index].map((child) => block(child, `${indent}\t`)),
      `${indent}}\n`,
    ].join("");
  };
  const roots = joints.flatMap(({ parent }, index) => (parent < 0 ? [block(index, "")] : []));
  const row = ({ places, rotations }) =>
    order
      .flatMap((index) => {
        const { parent } = joints[index];
        const back = parent < 0 ? identity : inverse(rotations[parent]);
        const place = parent < 0 ? places[index] : rotate(back, places[index].map((value, axis) => value - places[parent][axis]));
        return [...(hasPosition(index) ? place : []), ...eulerZyx(multiply(back, rotations[index]))];
      })
      .map((value) => value.toFixed(6))
      .join(" ");
  return `HIERARCHY\n${roots.join("")}MOTION\nFrames: ${poses.length}\nFrame Time: ${seconds}\n${poses.map(row).join("\n")}\n`;
}
