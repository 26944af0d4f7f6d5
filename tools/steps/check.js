// Runs `mocap edit` with steps that move a limb or the head to a target, and judges the output. See README.md.

import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { readBvh } from "../roll/bvh.js";
import { add, inverse, length, normalize, rotate, scale, sub } from "../roll/math.js";
import { bonesOf } from "../roll/measure.js";

const TOP = fileURLToPath(new URL("../../", import.meta.url));
const MOCAP = process.env.MOCAP;
/** The largest distance in metres of a limb from its target, if the limb is long enough. */
const REACHED = 0.001;
/** The largest ratio to the source's acceleration outside the ease-in and ease-out. */
const ACCELERATION = 1.3;
/** A smaller acceleration, in m/s2, is no movement. */
const STILL = 2;
/** A limb is long enough if the target is within this fraction of its length. */
const LONG_ENOUGH = 0.999;
/**
 * Nearer than this fraction of its length, a limb is folded, and a small sideways movement of the goal swings it about.
 */
const FOLDED = 0.3;
/** The seconds around a frame out of reach in which a limb blends. */
const PASSING = 0.2;
/** The seconds in which a step eases in and out. */
const EASE = 0.4;

const LIMBS = {
  "left-hand": ["leftUpperArm", "leftLowerArm", "leftHand"],
  "right-hand": ["rightUpperArm", "rightLowerArm", "rightHand"],
  "left-foot": ["leftUpperLeg", "leftLowerLeg", "leftFoot"],
  "right-foot": ["rightUpperLeg", "rightLowerLeg", "rightFoot"],
};

const truth = JSON.parse(readFileSync(join(TOP, "fixtures/skeletons/truth.json"), "utf8")).files;
const words = process.argv.slice(2);
const options = words.filter((word) => word.startsWith("-"));
const isLoud = options.includes("--all");
const only = options.find((word) => word.startsWith("--only="))?.slice(7);
const folder = mkdtempSync(join(tmpdir(), "steps-"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));

/** The hand-made map of a file: its own map, or the map of the fixture of the same name. */
function mapOf(path) {
  const beside = join(dirname(path), "truth.json");
  const own = existsSync(beside) ? Object.entries(JSON.parse(readFileSync(beside, "utf8")).files ?? {}) : [];
  return [...own, ...Object.entries(truth)].find(([name]) => basename(name) === basename(path))?.[1];
}

const most = (values) => values.reduce((a, b) => Math.max(a, b), 0);

/** The largest acceleration of a joint; `counts` must hold for all three frames of an acceleration. */
function acceleration(poses, joint, seconds, counts = () => true) {
  const at = poses.map(({ places }) => places[joint]);
  const of = (frame) => length(add(sub(at[frame + 1], scale(at[frame], 2)), at[frame - 1])) / seconds ** 2;
  const frames = at.map((_, frame) => frame).slice(1, -1);
  return most(frames.filter((frame) => [-1, 0, 1].every((by) => counts(frame + by))).map(of));
}

/** The comparison of an output with its source; lengths are in metres. */
function judge(source, result, { limb, bones, metres, range, seconds, targets, goal }) {
  const chain = limb.map((bone) => bones[bone]);
  const reach = (pose) => length(sub(pose.places[chain[1]], pose.places[chain[0]])) + length(sub(pose.places[chain[2]], pose.places[chain[1]]));
  const long = reach(source[0]);
  const [upper, lower] = [1, 2].map((at) => length(sub(source[0].places[chain[at]], source[0].places[chain[at - 1]])));
  const short = Math.abs(upper - lower) / long;
  let farthest = 0;
  let outOfReach = 0;
  const passing = Math.ceil(PASSING / seconds);
  const away = source.map((pose, frame) => length(sub(goal(pose, result[frame]), pose.places[chain[0]])) / long);
  const isNear = (of) => (frame) => away.slice(Math.max(0, frame - passing), frame + passing + 1).some(of);
  const isOut = isNear((part) => part > LONG_ENOUGH || part < short + 1 - LONG_ENOUGH);
  const isHard = isNear((part) => part > LONG_ENOUGH || part < FOLDED);
  for (let frame = range[0]; frame <= range[1]; frame += 1) {
    const to = goal(source[frame], result[frame]);
    if (!isOut(frame)) farthest = Math.max(farthest, length(sub(to, result[frame].places[chain[2]])) * metres);
    else outOfReach += 1;
  }
  const ease = Math.ceil(EASE / seconds);
  const isEase = (frame) => (frame < range[0] && frame >= range[0] - ease) || (frame > range[1] && frame <= range[1] + ease);
  const isInside = (frame) => frame >= range[0] && frame <= range[1];
  const joints = chain.slice(1);
  const was = most([...joints, ...targets].map((joint) => acceleration(source, joint, seconds) * metres));
  const is = most(joints.map((joint) => acceleration(result, joint, seconds, (frame) => !isEase(frame) && !(isInside(frame) && isHard(frame))) * metres));
  const below = new Set(chain.slice(0, 1));
  source.joints.forEach(({ parent }, joint) => below.has(parent) && below.add(joint));
  const moved = most(source.flatMap(({ places }, frame) => places.map((place, joint) => (below.has(joint) ? 0 : length(sub(place, result[frame].places[joint])) * metres))));
  return { farthest, outOfReach, frames: range[1] - range[0] + 1, was, is, ratio: is / Math.max(was, STILL), moved };
}

const counts = { passed: 0, failed: 0 };
let worst = { farthest: 0, ratio: 0 };

function count(label, found) {
  const isRight = found.farthest <= REACHED && found.ratio <= ACCELERATION && found.moved < 1e-4;
  counts[isRight ? "passed" : "failed"] += 1;
  worst = { farthest: Math.max(worst.farthest, found.farthest), ratio: Math.max(worst.ratio, found.ratio) };
  const numbers = [found.farthest * 1000, found.outOfReach, found.frames, found.was, found.is, found.ratio];
  if (isLoud || !isRight) console.log(`${label.padEnd(72)}${numbers.map((value) => value.toFixed(2).padStart(9)).join("")}${isRight ? "" : "  FAILED"}`);
}

/** The motion of a file, and the options that `mocap` needs. */
function sourceOf(path) {
  const map = mapOf(path);
  if (!map?.humanoid || !map.map) return undefined;
  const { joints, seconds, poses } = readBvh(path, map.root_offset?.startsWith("add"));
  if (poses.length < 12) return undefined;
  return { bones: bonesOf(map, joints.map(({ name }) => name)), joints, seconds, poses, metres: map.unit_m };
}

/** The map states the unit, because targets are in metres. */
function run(path, metres, step) {
  const out = join(folder, "out.bvh");
  const done = spawnSync(MOCAP, ["edit", path, "-o", out, "--force", "--unit", String(metres), "--step", step], { encoding: "utf8" });
  return done.status === 0 ? readBvh(out).poses : console.log(`${basename(path)} ${step}: ${done.stderr}`);
}

/**
 * Runs a step, and judges it. `goal` returns the target of the limb from the poses of a frame before and after the
 * step.
 */
function tried(path, source, [limb, step, targets, goal]) {
  const middle = Math.floor(source.poses.length / 2);
  const half = Math.max(1, Math.floor(Math.min(source.poses.length / 5, 1 / source.seconds)));
  const range = [middle - half, middle + half];
  const text = `${step},range=${range[0]}f..${range[1]}f`;
  const result = run(path, source.metres, text);
  if (!result) return (counts.failed += 1);
  const poses = source.poses.slice(source.poses.length - result.length);
  poses.joints = source.joints;
  count(`${basename(path)} ${text}`, judge(poses, result, { ...source, limb: LIMBS[limb], range, targets, goal }));
}

/** The steps that are tested on a motion. */
function* steps({ bones, poses, metres }) {
  const middle = poses[Math.floor(poses.length / 2)];
  for (const [limb, chain] of Object.entries(LIMBS)) {
    const [start, , end] = chain.map((bone) => middle.places[bones[bone]]);
    if (!start || !end) continue;
    // A point near the end of the limb: somewhat nearer to the first joint, and 20 cm aside.
    const hips = middle.places[bones.hips];
    const aside = scale(normalize(sub(start, hips)), 0.2 / metres);
    const point = add(add(start, scale(sub(end, start), 0.75)), aside);
    if (![...point].every(Number.isFinite)) continue;
    yield [limb, `reach:limb=${limb},to=${point.map((value) => (value * metres).toFixed(5)).join("/")}`, [], () => point];
    if (limb.endsWith("hand")) {
      const other = limb === "left-hand" ? "rightHand" : "leftHand";
      for (const bone of ["head", other, "hips"].filter((bone) => bones[bone] !== undefined)) {
        if (![...point].every(Number.isFinite)) continue;
    yield [limb, `reach:limb=${limb},to=${bone}`, [bones[bone]], (before) => before.places[bones[bone]]];
      }
    }
  }
}

const HEAD = ["mm off", "too far", "frames", "a source", "a result", "ratio"];
console.log(`${"motion and step".padEnd(72)}${HEAD.map((name) => name.padStart(9)).join("")}`);
const own = Object.keys(truth).filter((path) => path.endsWith(".bvh"));
const files = [...own.map((path) => join(TOP, "fixtures", path)), ...words.filter((word) => !word.startsWith("-"))];
const sample = (_, place) => !options.includes("--sample") || place % 4 === 1;
for (const path of files.filter(sample).filter((file) => !only || file.includes(only))) {
  const source = sourceOf(path);
  if (source) for (const step of steps(source)) tried(path, source, step);
}
console.log(`largest distance ${(worst.farthest * 1000).toFixed(3)} mm, largest ratio of accelerations ${worst.ratio.toFixed(2)}`);
console.log(`${counts.passed} passed, ${counts.failed} failed`);
process.exitCode = counts.failed > 0 ? 1 : 0;
