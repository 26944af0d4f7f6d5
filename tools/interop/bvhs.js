// The BVH files that mocap writes, from every format that it reads.

import { readFileSync } from "node:fs";
import { basename, extname, join } from "node:path";

import { convert, fixtures, outputName, pose, realFixture, subfolder } from "./mocap.js";

/** The formats that are converted to glTF first. */
const OVER_GLTF = ["cmu_short.bvh", "lecture_Test.bvh", "mocopi_jump_six_channels.bvh", "rokoko_dance.bvh"];

/**
 * Writes all BVH files, or a sample: from real BVH, AMC and FBX files directly, and from some over glTF. Returns the
 * source and the written file of each. C3D is omitted, because markers without links are no skeleton.
 */
export function writeBvhs(folder, sample) {
  const outputs = subfolder(folder, "bvh");
  const inputs = fixtures("real").filter((input) => extname(input) !== ".c3d");
  const written = sample
    .some(inputs, OVER_GLTF.length)
    .map((input) => ({ input, output: convert(input, join(outputs, outputName(input, ".bvh"))) }));
  for (const name of sample.some(OVER_GLTF, OVER_GLTF.length)) {
    const between = convert(realFixture(name), join(outputs, outputName(name, "_between.glb")));
    written.push({ input: between, output: convert(between, join(outputs, outputName(name, "_over_gltf.bvh"))) });
  }
  return written;
}

/** The joints of a written BVH file, in its order: name, OFFSET, whether it has position channels, whether it is an End Site. */
export function jointsOf(path) {
  const text = readFileSync(path, "utf8");
  const joints = [];
  const pattern = /^\s*(ROOT|JOINT|End Site)[ \t]*(.*)\n\s*\{\n\s*OFFSET (\S+) (\S+) (\S+)\n(\s*CHANNELS.*)?/gm;
  for (const [, keyword, name, x, y, z, channels] of text.matchAll(pattern)) {
    joints.push({
      name,
      isEndSite: keyword === "End Site",
      hasOffset: [x, y, z].some((value) => Number(value) !== 0),
      hasPositions: (channels ?? "").includes("position"),
    });
  }
  const frames = Number(/^Frames: (\d+)$/m.exec(text)[1]);
  const frameTime = Number(/^Frame Time: (\S+)$/m.exec(text)[1]);
  return { joints, frames, frameTime };
}

/** The indices of a written file's joints in its source. The written file omits the nodes above the first ROOT. */
export function placesBelow(input, tick, joints) {
  return pose(input, tick)
    .slice(-joints.length)
    .map((node) => node.translation);
}

/** The name of a written file in messages. */
export const nameOf = ({ input, output }) => `${basename(input)} as ${basename(output)}`;
