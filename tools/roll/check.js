// Runs `mocap retarget` and judges its output. See README.md.

import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";

import { cutOf, readBvh, restOf } from "./bvh.js";
import { poseAt, readGltf } from "./gltf.js";
import { between, inverse, multiply } from "./math.js";
import { characterVariant } from "./characters.js";
import { bends, bonesOf, compare, difference } from "./measure.js";
import { soma } from "./soma.js";
import { alongX, turnedAtRandom, withoutTPose } from "./rewrite.js";
import { variant } from "./variants.js";

const TOP = fileURLToPath(new URL("../../", import.meta.url));
const MOCAP = process.env.MOCAP ?? join(TOP, "target/debug/mocap");
const CHARACTERS = ["human_default", "human_cmu", "human_vrm1", "human_game_engine"];
/** The number of compared frames of a motion. */
const FRAMES = 150;
/**
 * If roll or trunk have a larger error than this, in degrees, and the verdict is not poor, the output is silently
 * wrong.
 */
const SILENT = 30;
/** The largest mean difference in degrees that a law allows. */
const LAW = 2;
/** The number of named bones of a run that breaks a law, the worst first. */
const WORST = 6;
/** The largest difference from known rotations: SOMA bends its knees by 5 degrees in the T-pose, a character does not. */
const TRUTH = 6;

const { files } = JSON.parse(readFileSync(join(TOP, "fixtures/skeletons/truth.json"), "utf8"));
const words = process.argv.slice(2);
const [parts, options] = [words.filter((word) => !word.startsWith("-")), words.filter((word) => word.startsWith("-"))];
const isChosen = (part) => parts.length === 0 || parts.includes(part);
const isLoud = options.includes("--all");
const numberOf = (name, usual) => Number(options.find((word) => word.startsWith(`--${name}=`))?.split("=")[1] ?? usual);
const [variants, seed] = [numberOf("variants", 3), numberOf("seed", 1)];
const only = options.find((word) => word.startsWith("--only="))?.slice(7);
const folder = mkdtempSync(join(tmpdir(), "roll-"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));

const all = [...CHARACTERS, "human_apose", "human_vrm0"].map((name) => {
  const path = join(TOP, "fixtures/skeletons", `${name}.gltf`);
  const scene = readGltf(path);
  const truth = files[`skeletons/${name}.gltf`];
  return { name, path, rest: poseAt(scene), parents: scene.parents, bones: bonesOf(truth, scene.names), facing: truth.facing_rest };
});
const characters = all.slice(0, CHARACTERS.length);
const [chosen] = characters.filter(({ name }) => name === "human_vrm1");

const sources = Object.entries(files)
  .filter(([path, { humanoid, map }]) => humanoid && map && path.endsWith(".bvh") && (!only || path.includes(only)))
  .map(([path, truth]) => ({ name: basename(path, ".bvh"), path: join(TOP, "fixtures", path), truth }));

/** The motion of a file, read by this judge. */
function read({ path, truth }) {
  const motion = readBvh(path, truth.root_offset?.startsWith("add"));
  const stands = /^[TAI]-pose/.test(truth.rest_pose) && truth.facing_rest;
  const rest = stands ? { rest: restOf(motion), facing: truth.facing_rest } : {};
  const parents = motion.joints.map(({ parent }) => parent);
  return { ...motion, ...rest, parents, bones: bonesOf(truth, motion.joints.map(({ name }) => name)), up: truth.up };
}

/**
 * Retargets a file of `count` frames: the verdict, the poses of the character at rows of the file, and the first row
 * that has one. A rest pose in the first frame is no motion, and mocap omits it.
 */
function retarget(path, character, count, seconds, feet = "lock") {
  const out = join(folder, "out.gltf");
  const done = spawnSync(MOCAP, ["retarget", path, "--character", character.path, "-o", out, "--feet", feet, "--hands", "free", "--json", "--force"], { encoding: "utf8", maxBuffer: 1 << 28 });
  if (done.status !== 0) return { refused: done.stderr.trim().split("\n").at(0) };
  const report = JSON.parse(done.stdout);
  const { verdict, guessed } = report.at(-1);
  const scene = readGltf(out);
  const end = Math.max(0, ...scene.tracks.map(({ times }) => times.at(-1)));
  const first = Math.round(end / seconds) + 1 === count - 1 ? 1 : 0;
  return { verdict, guessed: guessed.map(({ bone }) => bone), first, poseOf: (row) => poseAt(scene, (row - first) * seconds) };
}

function rowsOf({ poses }) {
  const step = Math.max(1, Math.ceil(poses.length / FRAMES));
  return poses.map((_, row) => row).filter((row) => row % step === 0);
}

/** One run: retargets a motion, in a file of any form, to a character. */
function judge(motion, path, character) {
  const { refused, verdict, first, poseOf } = retarget(path, character, motion.poses.length, motion.seconds);
  if (refused) return { refused };
  const rows = rowsOf(motion).filter((row) => row >= first);
  const poses = rows.map(poseOf);
  const found = compare({ ...motion, poses: rows.map((row) => motion.poses[row]) }, { ...character, poses });
  const isSilent = verdict !== "poor" && Math.max(found.roll, found.trunk) > SILENT;
  return { ...found, verdict, poses, isSilent };
}

const number = (value) => (value === undefined ? "-" : value.toFixed(1)).padStart(6);

function line(name, found) {
  if (found.refused) return `${name.padEnd(58)} refused: ${found.refused.slice(0, 90)}`;
  const worst = Object.entries(found.rolls).sort(([, a], [, b]) => Math.abs(b) - Math.abs(a))[0]?.[0] ?? "";
  const { direction, roll, trunk, head, palm, feet, verdict, isSilent } = found;
  return `${name.padEnd(58)} ${[direction, roll, trunk, head, palm, feet].map(number).join(" ")}  ${verdict.padEnd(5)}${isSilent ? " SILENT" : ""} ${worst}`;
}

const totals = [];

/** Judges the runs of a part, and prints and counts the wrong runs. */
function part(name, runs) {
  if (!isChosen(name)) return;
  console.log(`\n${name.padEnd(58)} direct.  roll  trunk   head   palm   feet  verdict`);
  const counts = { name, runs: 0, refused: 0, directions: 0, rolls: 0, seen: 0, silent: 0 };
  for (const { label, motion, path, character } of runs()) {
    const found = judge(motion, path, character);
    counts.runs += 1;
    if (found.refused) counts.refused += 1;
    else {
      counts.directions += found.direction <= 3 ? 1 : 0;
      counts.seen += Object.keys(found.rolls).length > 0 ? 1 : 0;
      counts.rolls += Object.keys(found.rolls).length > 0 && found.roll <= 10 ? 1 : 0;
      counts.silent += found.isSilent ? 1 : 0;
    }
    const isRight = !found.refused && found.roll <= 10 && found.trunk <= 10 && (found.head ?? 0) < 45 && (found.palm ?? 0) < 30;
    if (isLoud || !isRight) console.log(line(label, found));
  }
  totals.push(counts);
}

/** Whether a report marks the rotation of a bone as guessed; for the trunk, the report names the hips. */
function isGuessed(bone, guessed) {
  return guessed.has(/spine|chest/i.test(bone) ? "hips" : bone);
}

/** Judges whether other files of a motion give the same motion of a character. */
function law(name, runs) {
  if (!isChosen(name)) return;
  console.log(`\n${name}: bones with a mean difference above ${LAW} degrees`);
  const counts = { name, runs: 0, held: 0, beyond: 0 };
  for (const { label, whole, motion, path, first } of runs()) {
    const one = retarget(whole.path, chosen, whole.poses.length, whole.seconds, "free");
    const other = retarget(path, chosen, motion.poses.length, motion.seconds, "free");
    counts.runs += 1;
    if (one.refused && other.refused) {
      counts.held += 1;
      continue;
    }
    if (one.refused || other.refused) {
      console.log(`${label.padEnd(58)} refused: ${(one.refused ?? other.refused).slice(0, 90)}`);
      continue;
    }
    const rows = rowsOf(motion).filter((row) => row + first >= one.first && row >= other.first);
    const poses = [rows.map((row) => one.poseOf(row + first)), rows.map(other.poseOf)];
    const bones = difference(...poses, chosen.bones);
    const guessed = new Set([...one.guessed, ...other.guessed]);
    const worst = bones.find(({ bone }) => !isGuessed(bone, guessed))?.degrees ?? 0;
    counts.held += worst <= LAW ? 1 : 0;
    counts.beyond += worst > SILENT ? 1 : 0;
    const words = bones.slice(0, WORST).map(({ bone, degrees }) => `${bone} ${degrees.toFixed(1)}${isGuessed(bone, guessed) ? " (guessed)" : ""}`);
    if (isLoud || worst > LAW) console.log(`${label.padEnd(58)} ${one.verdict} ${other.verdict} ${words.join(", ")}`);
  }
  totals.push(counts);
}

function written(name, text) {
  const path = join(folder, name);
  writeFileSync(path, text);
  return path;
}

function* moving() {
  for (const source of sources) {
    const motion = read(source);
    if (motion.poses.length > 0) yield { source, motion };
  }
}

part("whole", function* () {
  for (const { source, motion } of moving()) {
    for (const character of characters) yield { label: `${source.name} on ${character.name}`, motion, path: source.path, character };
  }
});

/** Three parts of a motion: the first tenth or 20 frames, a part around the middle, and the end. */
function* cuts() {
  for (const { source, motion } of moving()) {
    const count = motion.poses.length;
    if (count < 60) continue;
    const size = Math.max(20, Math.floor(count / 5));
    for (const from of [Math.floor(count * 0.1), Math.floor(count / 2), count - size]) {
      const to = Math.min(from + size, count);
      const path = written(`${source.name}.bvh`, cutOf(motion, from, to));
      yield { label: `${source.name} ${from}..${to}`, source, whole: { ...motion, path: source.path }, motion: { ...motion, poses: motion.poses.slice(from, to) }, path, first: from };
    }
  }
}

part("cuts", function* () {
  for (const cut of cuts()) yield { ...cut, label: `${cut.label} on ${chosen.name}`, character: chosen };
});
law("cuts-law", cuts);

const FORMS = ["glb", "fbx", "mclip", "vrma"];

law("forms", function* () {
  for (const { source, motion } of moving()) {
    for (const form of FORMS) {
      const path = join(folder, `${source.name}.${form}`);
      const done = spawnSync(MOCAP, ["convert", source.path, path, "--force"], { encoding: "utf8" });
      // A body without a required bone of VRM cannot be a VRM animation. Any other refusal breaks the law.
      if (done.status !== 0 && form === "vrma" && /humanoid/.test(done.stderr)) continue;
      yield { label: `${source.name}.${form}`, whole: { ...motion, path: source.path }, motion, path, first: 0 };
    }
  }
});

function* rewritten(text, name) {
  for (const { source, motion } of moving()) {
    // No file has the information of the source's rest pose any more.
    const seen = { ...motion, rest: undefined };
    yield { label: `${source.name} ${name}`, whole: { ...motion, path: source.path }, motion: seen, path: written(`${source.name}.bvh`, text(motion, 7)), first: 0 };
  }
}

for (const [name, text] of [["along-x", alongX], ["random-frames", turnedAtRandom]]) {
  part(name, function* () {
    for (const run of rewritten(text, name)) {
      for (const character of characters) yield { ...run, label: `${run.label} on ${character.name}`, character };
    }
  });
  law(`${name}-law`, () => rewritten(text, name));
}

/**
 * Compares two files without information in their rest poses. Both must give the same result. This does not hold for a
 * standing rest pose and the hinges of its motion. Knees and elbows must bend.
 */
law("seeds-law", function* () {
  for (const { source, motion } of moving()) {
    if (!bends(motion)) continue;
    const [path, other] = [7, 8].map((seed) => written(`${source.name}-${seed}.bvh`, turnedAtRandom(motion, seed)));
    yield { label: source.name, whole: { ...motion, path }, motion, path: other, first: 0 };
  }
});

/** Bones along +X, and no frame in which the arms are raised. */
part("without-t-pose", function* () {
  for (const { source, motion } of moving()) {
    if (motion.bones.leftUpperArm === undefined) continue;
    const [from, to] = withoutTPose(motion, motion.bones);
    if (to - from < 20) continue;
    const cut = { ...motion, rest: undefined, poses: motion.poses.slice(from, to) };
    const path = written(`${source.name}.bvh`, alongX(cut, 11));
    yield { label: `${source.name} ${from}..${to} on ${chosen.name}`, motion: cut, path, character: chosen };
  }
});

/** Each motion in the style of other programs: other names, frames, axes, size, proportions and parts. */
function* varied(frames) {
  for (const { source, motion } of moving()) {
    for (let number = 0; number < variants; number += 1) {
      const key = 1000 * seed + number + 17 * sources.indexOf(source);
      const made = variant(motion, key, frames);
      const character = characters[key % characters.length];
      yield { label: `${source.name} ${key}: ${made.how} on ${character.name}`, motion: made.motion, path: written(`${source.name}.bvh`, made.text), character };
    }
  }
}
part("variants", () => varied());

/** Files whose rest pose is a moment of the motion, as if the skeleton was bound in the middle of a motion. */
part("moments", () => varied("of a moment"));

/** Characters in the style of other programs, each with every motion in turn. */
part("characters", function* () {
  const motions = [...moving()].filter(({ motion }) => motion.poses.length > 1);
  for (let number = 0; number < 28 * variants; number += 1) {
    const key = 1000 * seed + number;
    const { source, motion } = motions[number % motions.length];
    const { text, character } = characterVariant(all[Math.floor(number / motions.length) % all.length], key);
    const path = written("character.gltf", text);
    yield { label: `${key}: ${source.name} on ${character.name}`, motion, path: source.path, character: { ...character, path } };
  }
});

/**
 * The rotation of a hand whose palm faces up at rest to the T-pose's palm: half a turn about the arm. Only the chosen
 * character may have such a hand.
 */
function palmDown(bone) {
  const [, side] = bone.match(/^(left|right)Hand$/) ?? [];
  if (!side) return [0, 0, 0, 1];
  const at = (finger) => chosen.rest.places[chosen.bones[`${side}${finger}Proximal`]];
  return at("Index")[2] > at("Little")[2] ? [0, 0, 0, 1] : [1, 0, 0, 0];
}

/** A motion whose rotations are the identity in the T-pose: each bone of a character in T-pose has the same rotation. */
function truth() {
  if (!isChosen("truth")) return;
  console.log("\ntruth                                                      worst mean of a bone, degrees");
  const counts = { name: "truth", runs: 0, held: 0, beyond: 0 };
  for (const { label, text, poses, seconds, bones } of soma(turnedAtRandom, alongX)) {
    const rows = rowsOf({ poses });
    const { refused, poseOf } = retarget(written("soma.bvh", text), chosen, poses.length, seconds);
    counts.runs += 1;
    if (refused) {
      console.log(`${label.padEnd(58)} refused: ${refused}`);
      continue;
    }
    const moved = rows.map(poseOf);
    const errors = Object.entries(bones).map(([bone, joint]) => {
      // If several joints share the twist of a thigh or an upper arm, the last joint has the whole twist.
      const last = /Upper/.test(bone) ? chosen.parents[chosen.bones[bone.replace("Upper", "Lower")]] : chosen.bones[bone];
      const rest = inverse(multiply(palmDown(bone), chosen.rest.rotations[last]));
      const angles = rows.map((row, frame) => between(poses[row].rotations[joint], multiply(moved[frame].rotations[last], rest)));
      return [bone, angles.reduce((sum, value) => sum + value, 0) / angles.length];
    });
    errors.sort(([, a], [, b]) => b - a);
    counts.held += errors[0][1] <= TRUTH ? 1 : 0;
    counts.beyond += errors[0][1] > SILENT ? 1 : 0;
    console.log(`${label.padEnd(58)} ${errors.slice(0, 5).map(([bone, value]) => `${bone} ${value.toFixed(1)}`).join(", ")}`);
  }
  totals.push(counts);
}
truth();

console.log();
for (const { name, runs, refused, directions, rolls, seen, silent, held, beyond } of totals) {
  if (held === undefined) {
    console.log(`| \`${name}\` | ${runs} | ${refused} | ${directions} of ${runs - refused} | ${rolls} of ${seen} | ${silent} |`);
  } else console.log(`| \`${name}\` | ${runs} | ${held} | ${beyond} |`);
}
const failed = totals.reduce((sum, { runs, held, silent }) => sum + (silent ?? runs - held), 0);
const passed = totals.reduce((sum, { runs }) => sum + runs, 0) - failed;
console.log(`${passed} passed, ${failed} failed`);
process.exitCode = failed > 0 ? 1 : 0;
