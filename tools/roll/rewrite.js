// Writes a motion with other joint frames: every joint keeps its world position in every frame, but its axes have
// another orientation in the bone.

import { writeBvh } from "./bvh.js";
import { aboutAxis, across, cross, dot, fromColumns, identity, inverse, length, multiply, normalize, random, randomRotation, rotate } from "./math.js";

/** Joint frames with random rotations. */
export function turnedAtRandom(motion, seed) {
  const next = random(seed);
  return withFrames(motion, motion.joints.map(({ isEnd }) => (isEnd ? identity : randomRotation(next))));
}

/** Joint frames in which the OFFSET of the first child is along +X, with a random roll by quarter turns. */
export function alongX(motion, seed) {
  const next = random(seed);
  const frames = motion.joints.map((_, index) => {
    const quarter = aboutAxis([1, 0, 0], (Math.floor(4 * next()) * Math.PI) / 2);
    const child = motion.joints.find(({ parent, offset }) => parent === index && length(offset) > 1e-6);
    if (!child) return identity;
    const x = normalize(child.offset);
    const helper = Math.abs(x[1]) < 0.9 ? [0, 1, 0] : [0, 0, 1];
    const y = normalize(across(helper, x));
    return multiply(fromColumns(x, y, cross(x, y)), quarter);
  });
  return withFrames(motion, frames);
}

/**
 * Joint frames in which the bone is along an axis, and along the opposite axis on the right side of the body, as in 3ds
 * Max and Unreal. The other axes are as near as possible to the body's axes. Without an axis, the frames do not change.
 */
export function alongAxes(motion, axis) {
  const right = new Set(Object.entries(motion.bones).filter(([bone]) => bone.startsWith("right")).map(([, joint]) => joint));
  const frames = motion.joints.map((_, index) => {
    const child = axis && motion.joints.find(({ parent, offset }) => parent === index && length(offset) > 1e-6);
    if (!child) return identity;
    const along = normalize(child.offset);
    const from = right.has(index) ? axis.map((part) => -part) : axis;
    const about = cross(from, along);
    if (length(about) > 1e-6) return aboutAxis(about, Math.atan2(length(about), dot(from, along)));
    return dot(from, along) > 0 ? identity : aboutAxis([0, 0, 1], Math.PI);
  });
  return withFrames(motion, frames);
}

/**
 * Joint frames for which the rest pose is the pose of a row, as if the skeleton was bound in the middle of a motion.
 */
export function restingAt(motion, row) {
  return withFrames(motion, motion.poses[row].rotations.map(inverse));
}

/** `frames[joint]` is the rotation from the new axes of a joint to its old ones. */
function withFrames({ joints, seconds, poses }, frames) {
  const moved = joints.map((joint) => ({
    ...joint,
    offset: joint.parent < 0 ? joint.offset : rotate(inverse(frames[joint.parent]), joint.offset),
  }));
  const turned = poses.map(({ places, rotations }) => ({
    places,
    rotations: rotations.map((rotation, joint) => multiply(rotation, frames[joint])),
  }));
  const moving = new Set(joints.flatMap(({ channels, parent }, index) => (parent >= 0 && channels.length > 3 ? [index] : [])));
  return writeBvh(moved, seconds, turned, moving);
}

/** The longest part of a motion in which the arms are not raised sideways, as first and last row. */
export function withoutTPose({ poses }, bones) {
  const isRaised = ({ places }, side) => {
    const way = (from, to) => normalize(places[bones[to]].map((value, axis) => value - places[bones[from]][axis]));
    return Math.abs(dot(way(`${side}UpperArm`, `${side}LowerArm`), way("hips", bones.neck === undefined ? "head" : "neck"))) < 0.35;
  };
  let [best, start] = [[0, 0], 0];
  poses.forEach((pose, row) => {
    if (isRaised(pose, "left") && isRaised(pose, "right")) start = row + 1;
    else if (row + 1 - start > best[1] - best[0]) best = [start, row + 1];
  });
  return best;
}
