// Checks extreme inputs, which it makes: a very long motion, very many joints, no motion, one joint, awkward names.
// Also checks the size of one fixture's default file.

import { statSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { millimetres } from "../compare.js";
import { describe, numbersOf, readGlb } from "../glb.js";
import { convert, mocap, realFixture, subfolder } from "../mocap.js";
import { messagesAbout } from "./validator.js";

/** The size of the smallest file of this take that another writer makes with every frame: Blender 5.0.1. */
const MAX_BYTES_OF_CMU_01_01 = 1_260_000;
/** The largest error of a default file, in metres; see parts/verify.js. */
const MAX_ERROR = 0.00002;
/**
 * In a take of 1000 s, times are rounded by up to 31 microseconds. At up to 4.7 m/s, the joints move this distance in
 * that time.
 */
const MAX_ERROR_OF_LONG_TAKE = 0.00015;

const ROTATION = "CHANNELS 3 Zrotation Xrotation Yrotation";
const ALL_CHANNELS = "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation";

/** A BVH file in metres of a chain of joints with these names, 1.8 m long. `row` gives the values of a frame. */
function chain(names, { frames, frameTime, row }) {
  const step = 1.8 / names.length;
  const lines = ["HIERARCHY"];
  names.forEach((name, depth) => {
    lines.push(`${depth === 0 ? "ROOT" : "JOINT"} ${name}`, "{", `OFFSET 0 ${depth === 0 ? 0 : step} 0`);
    lines.push(depth === 0 ? ALL_CHANNELS : ROTATION);
  });
  lines.push("End Site", "{", `OFFSET 0 ${step} 0`, "}", ...names.map(() => "}"));
  if (frames !== undefined) {
    lines.push("MOTION", `Frames: ${frames}`, `Frame Time: ${frameTime}`);
    for (let frame = 0; frame < frames; frame += 1) lines.push(row(frame).join(" "));
  }
  return `${lines.join("\n")}\n`;
}

/** A root that walks back and forth at 1 m/s at most, and angles that swing differently for each joint. */
function swinging(joints, frameTime) {
  return (frame) => {
    const seconds = frame * frameTime;
    const values = [Math.sin(seconds).toFixed(6), 1, 0];
    for (let joint = 0; joint < joints; joint += 1) {
      for (const axis of [1, 2, 3]) values.push((20 * Math.sin(axis * seconds + joint)).toFixed(4));
    }
    return values;
  };
}

/** Writes and converts a file, checks it with the validator and `mocap verify`, and returns the path of the result. */
async function checkedFile(results, outputs, name, text, maxError = MAX_ERROR) {
  const input = join(outputs, `${name}.bvh`);
  writeFileSync(input, text);
  const output = convert(input, join(outputs, `${name}.glb`), "--unit", "m");
  const messages = await messagesAbout(output, "default");
  results.check(messages.length === 0, `${name}: ${messages.slice(0, 3).join("\n    ")}`);
  const { max_error, missing } = JSON.parse(mocap("verify", input, output, "--json", "--max-error", "1000m"));
  results.check(max_error < maxError, `${name}: ${millimetres(max_error)} off`);
  results.check(missing.length === 0, `${name}: missing ${missing.join(", ")}`);
  results.note(`${name}: ${statSync(output).size} bytes, at most ${millimetres(max_error)} off`);
  return output;
}

async function aMillionFrames(results, outputs) {
  const frames = 1_000_000;
  const text = chain(["Hips", "Chest"], { frames, frameTime: 0.001, row: swinging(2, 0.001) });
  const output = await checkedFile(results, outputs, "a_million_frames", text, MAX_ERROR_OF_LONG_TAKE);
  const { json } = describe(output);
  const times = numbersOf(readGlb(output), json.animations[0].samplers[0].input);
  const falling = times.findIndex((time, frame) => frame > 0 && !(time > times[frame - 1]));
  results.check(times.length === frames, `a_million_frames: ${times.length} times`);
  results.check(falling === -1, `a_million_frames: time ${falling} does not increase`);
  results.check(times[0] === 0 && times.at(-1) === Math.fround(999.999), `a_million_frames: ${times[0]}..${times.at(-1)} s`);
}

async function threeHundredJoints(results, outputs) {
  const names = Array.from({ length: 300 }, (_, index) => `Joint${index}`);
  const text = chain(names, { frames: 20, frameTime: 0.01, row: swinging(300, 0.01) });
  const output = await checkedFile(results, outputs, "three_hundred_joints", text);
  results.check(describe(output).json.skins[0].joints.length === 301, "three_hundred_joints: some are not in the skin");
}

async function noMotion(results, outputs) {
  const output = await checkedFile(results, outputs, "no_motion", chain(["Hips", "Chest"], {}));
  results.check(describe(output).json.animations === undefined, "no_motion: has an animation");
  const still = chain(["Hips", "Chest"], { frames: 0, frameTime: 0.01 });
  await checkedFile(results, outputs, "zero_frames", still);
}

async function oneJoint(results, outputs) {
  const text = `HIERARCHY\nROOT Tracker\n{\nOFFSET 0 0 0\n${ALL_CHANNELS}\n}\nMOTION\nFrames: 2\nFrame Time: 0.01\n0 1 0 0 0 0\n1 1 0 0 90 0\n`;
  const output = await checkedFile(results, outputs, "one_joint", text);
  const { json } = describe(output);
  results.check(json.skins?.length === 1 && json.meshes?.length === 1, "one_joint: no skin or no mesh");
}

async function awkwardNames(results, outputs) {
  const names = ["a/b[c]", "abc", "a.b:c", "Arm", "Arm", "", "mixamorig:Hips", "Bip01 R Hand", "\u00c4rmel", "a_b_c"];
  const text = chain(names, { frames: 3, frameTime: 0.01, row: swinging(names.length, 0.01) });
  const output = await checkedFile(results, outputs, "awkward_names", text);
  const { nodes } = describe(output);
  const written = nodes.map((node) => node.name);
  results.check(new Set(written).size === nodes.length, `awkward_names: not unique: ${written}`);
  // A name as three.js changes it: underscores for blanks, without these characters.
  const cleaned = written.map((name) => name.replace(/\s/g, "_").replace(/[[\].:/]/g, ""));
  results.check(new Set(cleaned).size === nodes.length, `awkward_names: not unique in three.js: ${cleaned}`);
  results.check(written.every((name) => name !== ""), "awkward_names: a name is empty");
  const kept = nodes.map((node) => node.sourceName).slice(0, names.length);
  results.check(names.every((name, index) => name === "" || name === kept[index]), `awkward_names: sources are ${kept}`);
  results.note(`awkward_names: ${nodes.map((node) => `"${node.sourceName}" is "${node.name}"`).join(", ")}`);
}

function size(results, outputs) {
  const output = convert(realFixture("cmu_01_01.bvh"), join(outputs, "cmu_01_01.glb"));
  const bytes = statSync(output).size;
  results.check(bytes <= MAX_BYTES_OF_CMU_01_01, `cmu_01_01: ${bytes} bytes`);
  results.note(`cmu_01_01: ${bytes} bytes`);
}

export async function run(results, folder, sample) {
  const outputs = subfolder(folder, "extremes");
  const slow = sample.isAll ? [aMillionFrames] : [];
  for (const body of [...slow, threeHundredJoints, noMotion, oneJoint, awkwardNames, size]) {
    await results.guard(body.name, () => body(results, outputs));
  }
}
