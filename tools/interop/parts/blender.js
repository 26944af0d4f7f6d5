// Checks files in Blender, the Python package bpy: one armature with a bone for every joint, its mesh, and the bones'
// positions. Reads the default files, the compressed files that Blender accepts, and the BVH files that mocap writes.
// BLENDER_PYTHON names a Python with bpy; README.md describes its installation.

import { execFileSync } from "node:child_process";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";

import { jointsOf, nameOf, placesBelow, writeBvhs } from "../bvhs.js";
import { largestDistance, millimetres, stepsOf, ticksOf, toleranceFor } from "../compare.js";
import { describe } from "../glb.js";
import { convert, fixtures, outputName, pose, subfolder } from "../mocap.js";

/** Runs a script of the folder `blender`. Returns its answers to the requests, and Blender's version. */
function ask(script, requests) {
  const printed = execFileSync(
    process.env.BLENDER_PYTHON ?? "python3",
    [fileURLToPath(new URL(`../blender/${script}`, import.meta.url))],
    { input: JSON.stringify(requests), encoding: "utf8", maxBuffer: 1 << 30, stdio: ["pipe", "pipe", "ignore"] },
  );
  const [version, ...answers] = JSON.parse(printed.trim().split("\n").at(-1));
  return { version, answers };
}

/** `bound` is the bound in metres within which the file was compressed; it is added to the limit of every client. */
const FORMS = [
  { form: "default", options: [], bound: 0 },
  ...["int16", "meshopt", "meshopt-khr"].map((form) => ({
    form,
    options: ["--compress", form, "--max-error", "1mm"],
    bound: 0.001,
  })),
];

function checkAnswer(results, { input, output, ticks, form, bound }, answer) {
  const name = `${basename(input)}, ${form}`;
  const { nodes, provenance, between } = describe(output);
  const joints = nodes.filter((node) => node.isJoint);
  results.check(answer.armatures === 1, `${name}: ${answer.armatures} armatures`);
  results.check(answer.meshes === 1, `${name}: ${answer.meshes} meshes on the armature`);
  const boneOf = new Map(answer.bones.map((bone, index) => [bone, index]));
  const missing = joints.filter((joint) => !boneOf.has(joint.name)).map((joint) => joint.name);
  results.check(missing.length === 0, `${name}: no bones for ${missing.join(", ")}`);
  results.check(
    answer.bones.length === joints.length + between.length,
    `${name}: ${answer.bones.length} bones for ${joints.length} joints and ${between.length} nodes between`,
  );
  if (missing.length > 0) return 0;
  let worst = 0;
  const { sourceTick, change } = stepsOf(provenance);
  ticks.forEach((tick, index) => {
    const expected = pose(input, sourceTick(tick)).map((node) => change(node.translation));
    const places = joints.map((joint) => answer.places[index][boneOf.get(joint.name)]);
    const ofJoints = expected.filter((_, node) => nodes[node].isJoint);
    const distance = largestDistance(places, ofJoints);
    const tolerance = toleranceFor(ofJoints);
    results.check(distance <= bound + tolerance, `${name}, tick ${tick}: ${millimetres(distance)} off`);
    if (tolerance < 0.00011 && distance > worst) worst = distance;
  });
  return worst;
}

/** The BVH files. Blender has no bones for End Sites. */
function runBvh(results, folder, sample) {
  const files = writeBvhs(folder, sample).map((file) => {
    const { joints, frames } = jointsOf(file.output);
    return { ...file, joints, ticks: ticksOf(frames).filter(Number.isInteger) };
  });
  const { answers } = ask("bvh_places.py", files.map(({ output, ticks }) => ({ file: output, frames: ticks })));
  let worst = { share: 0, file: "none" };
  files.forEach((file, place) => {
    const { bones, places } = answers[place];
    const count = file.joints.filter((joint) => !joint.isEndSite).length;
    if (!results.check(bones.length === count, `${nameOf(file)}: ${bones.length} bones for ${count} joints`)) return;
    file.ticks.forEach((tick, index) => {
      const all = placesBelow(file.input, tick, file.joints);
      const expected = all.filter((_, joint) => !file.joints[joint].isEndSite);
      const tolerance = toleranceFor(all);
      const distance = largestDistance(places[index], expected);
      results.check(distance <= tolerance, `${nameOf(file)}, frame ${tick}: ${millimetres(distance)} off`);
      if (distance / tolerance > worst.share) worst = { share: distance / tolerance, file: nameOf(file) };
    });
  });
  results.note(`${files.length} BVH files: at most ${(100 * worst.share).toFixed(1)} % of the tolerance off, in ${worst.file}`);
}

export async function run(results, folder, sample) {
  runBvh(results, folder, sample);
  for (const [place, { form, options, bound }] of FORMS.entries()) {
    const outputs = subfolder(folder, `blender/${form}`);
    const files = sample.share(fixtures("real"), place, FORMS.length).map((input) => {
      const output = convert(input, join(outputs, outputName(input, ".glb")), ...options);
      const { json, frames, frameTime } = describe(output);
      // A compressed file keeps its bound in the frames of its source, but not between them.
      const ticks = ticksOf(Math.max(frames, 1)).filter((tick) => bound === 0 || Number.isInteger(tick));
      return { input, output, frameTime, ticks, form, bound, requires: json.extensionsRequired ?? [] };
    });
    const requests = files.map(({ output, frameTime, ticks }) => ({
      file: output,
      frames_per_second: frameTime > 0 ? 1 / frameTime : 24,
      seconds: ticks.map((tick) => tick * frameTime),
    }));
    const { version, answers } = ask("places.py", requests);
    let worst = { distance: 0, file: "none" };
    const refusals = [];
    files.forEach((file, index) => {
      const { refusal } = answers[index];
      if (refusal) {
        // Blender may refuse a file only because of a required extension; a file without compressed data requires none.
        refusals.push(refusal.split("\n").at(-1));
        results.check(file.requires.length > 0, `${basename(file.input)}, ${form}: ${refusal}`);
        return;
      }
      const distance = checkAnswer(results, file, answers[index]);
      if (distance > worst.distance) worst = { distance, file: basename(file.input) };
    });
    for (const refusal of new Set(refusals)) results.note(`Blender ${version}, ${form}: refused, "${refusal}"`);
    const requiring = files.filter(({ requires }) => requires.length > 0).length;
    results.check([0, requiring].includes(refusals.length), `${form}: ${refusals.length} of ${requiring} files refused`);
    const error = `${millimetres(worst.distance)} from the source, in ${worst.file}`;
    const played = files.length - refusals.length;
    results.note(`Blender ${version}, ${form}: ${played} files; figures of human size at most ${error}`);
  }
}
