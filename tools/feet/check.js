// Runs `mocap retarget` and `mocap edit` with and without a foot lock, and compares the speed of feet. See README.md.

import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { readBvh } from "../roll/bvh.js";
import { poseAt, readGltf } from "../roll/gltf.js";
import { length, rotate, sub } from "../roll/math.js";
import { bonesOf, upright } from "../roll/measure.js";
import { compare, jointsOf } from "./measure.js";

const TOP = fileURLToPath(new URL("../../", import.meta.url));
const MOCAP = process.env.MOCAP;
/** The largest ratio of a speed and of an acceleration to their values without a lock. */
const [SPEED, ACCELERATION] = [1.2, 1.5];
/** The largest sliding speed of feet in contact above the sliding speed of the source's feet, in metres a second. */
const MORE_SLIDE = 0.005;

const truth = JSON.parse(readFileSync(join(TOP, "fixtures/skeletons/truth.json"), "utf8")).files;
const words = process.argv.slice(2);
const options = words.filter((word) => word.startsWith("-"));
const isLoud = options.includes("--all");
const option = (name) => options.find((word) => word.startsWith(`--${name}=`))?.slice(name.length + 3);
const names = option("characters")?.split(",") ?? ["human_default", "human_cmu", "human_vrm1", "human_game_engine"];
const folder = mkdtempSync(join(tmpdir(), "feet-"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));

/** The hand-made map of a file: its own map, or the map of the fixture of the same name. */
function mapOf(path) {
  const beside = join(dirname(path), "truth.json");
  const own = existsSync(beside) ? Object.entries(JSON.parse(readFileSync(beside, "utf8")).files ?? {}) : [];
  const of = ([name]) => basename(name) === basename(path);
  return [...own, ...Object.entries(truth)].find(of)?.[1];
}

function mocap(...args) {
  return spawnSync(MOCAP, [...args, "--force"], { encoding: "utf8", maxBuffer: 1 << 28 });
}

/** The joints of the legs in every frame of a file that mocap wrote. */
function sampled(path, bonesByName, times) {
  const scene = readGltf(path);
  const bones = bonesOf(bonesByName, scene.names);
  const joints = jointsOf(bones);
  const nodes = joints.map(([, node]) => node);
  const at = (time) => Object.fromEntries(poseAt(scene, time, nodes).places.map((place, index) => [joints[index][0], place]));
  return times.map(at);
}

/**
 * The motion of a source. A BVH file is read directly; `mocap convert` makes glTF of other formats, without options.
 */
function sourceOf(path) {
  const map = mapOf(path);
  if (!map?.humanoid || !map.map) return undefined;
  if (path.endsWith(".bvh")) {
    const { joints, seconds, poses } = readBvh(path, map.root_offset?.startsWith("add"));
    if (poses.length < 4) return undefined;
    const bones = jointsOf(bonesOf(map, joints.map(({ name }) => name)));
    const turn = upright(map.up);
    const frame = ({ places }) => Object.fromEntries(bones.map(([bone, joint]) => [bone, rotate(turn, places[joint])]));
    return { path, seconds, frames: poses.map(frame) };
  }
  const glb = join(folder, "source.glb");
  const args = path.endsWith(".asf") ? [path.replace(/\.asf$/, "_01.amc")] : [path];
  if (mocap("convert", ...args, glb).status !== 0) return undefined;
  const { tracks } = readGltf(glb);
  const times = tracks.map((track) => track.times).reduce((a, b) => (b.length > a.length ? b : a), []);
  if (times.length < 4) return undefined;
  const seconds = (times.at(-1) - times[0]) / (times.length - 1);
  return { path: args[0], seconds, frames: sampled(glb, map, times.map((_, frame) => frame * seconds)) };
}

const legOf = (frame) =>
  Math.max(...["left", "right"].map((side) => length(sub(frame[`${side}UpperLeg`], frame[`${side}LowerLeg`])) + length(sub(frame[`${side}LowerLeg`], frame[`${side}Foot`]))));

/** A source scaled to the leg length of the target. */
function scaled({ frames }, target) {
  const factor = legOf(target[0]) / legOf(frames[0]);
  return frames.map((frame) => Object.fromEntries(Object.entries(frame).map(([bone, place]) => [bone, place.map((value) => value * factor)])));
}

/** The number of frames of a file that mocap wrote. */
const framesOf = (path) => Math.max(1, ...readGltf(path).tracks.map(({ times }) => times.length));

/**
 * A motion with locked feet and with free feet, and its source. The first frame of the source may be a rest pose, which
 * is omitted.
 */
function judge({ seconds, frames }, locked, free, map) {
  const source = { seconds, frames: frames.length - framesOf(locked) === 1 ? frames.slice(1) : frames };
  const times = source.frames.map((_, frame) => frame * seconds);
  const [is, was] = [locked, free].map((path) => sampled(path, map, times));
  return compare(scaled(source, was), was, is, seconds);
}

const row = ({ speed, acceleration, slide }) =>
  [speed.source, speed.free, speed.lock, speed.ratio, acceleration.source, acceleration.free, acceleration.lock, acceleration.ratio, slide.source * 100, slide.free * 100, slide.lock * 100]
    .map((value) => value.toFixed(2).padStart(8))
    .join("");

const counts = { passed: 0, failed: 0 };
let worst = { speed: 0, acceleration: 0, slide: -Infinity };

function count(label, found) {
  const more = found.slide.contacts > 0 ? found.slide.lock - Math.max(found.slide.source, 0) : 0;
  const isRight = found.speed.ratio <= SPEED && found.acceleration.ratio <= ACCELERATION && more <= MORE_SLIDE;
  counts[isRight ? "passed" : "failed"] += 1;
  worst = {
    speed: Math.max(worst.speed, found.speed.ratio),
    acceleration: Math.max(worst.acceleration, found.acceleration.ratio),
    slide: Math.max(worst.slide, more),
  };
  const at = `  ${found.acceleration.bone} in frame ${found.acceleration.frame}`;
  if (isLoud || !isRight) console.log(`${label.padEnd(56)}${row(found)}${isRight ? "" : `${at}  FAILED`}`);
}

const HEAD = ["v source", "free", "lock", "ratio", "a source", "free", "lock", "ratio", "s source", "free", "lock"];
console.log(`${"motion on character".padEnd(56)}${HEAD.map((name) => name.padStart(8)).join("")}`);

const own = Object.keys(truth).filter((path) => path.startsWith("real/") && !path.endsWith(".c3d"));
const files = [...own.map((path) => join(TOP, "fixtures", path)), ...words.filter((word) => !word.startsWith("-"))];
for (const path of files.filter((file) => !option("only") || file.includes(option("only")))) {
  const source = sourceOf(path);
  if (!source) continue;
  const name = basename(source.path);
  const [locked, free] = [join(folder, "locked.gltf"), join(folder, "free.gltf")];
  for (const character of names) {
    const target = join(TOP, "fixtures/skeletons", `${character}.gltf`);
    const onto = (feet, out) => mocap("retarget", source.path, "--character", target, "--feet", feet, "--hands", "free", "-o", out);
    if (onto("lock", locked).status === 0 && onto("free", free).status === 0) {
      count(`${name} on ${character}`, judge(source, locked, free, truth[`skeletons/${character}.gltf`]));
    }
  }
  const edited = (out, ...steps) => mocap("edit", source.path, ...steps.flatMap((step) => ["--step", step]), "-o", out);
  if (edited(locked, "foot-lock").status === 0 && mocap("convert", source.path, free, "--drop-first-frame", "auto").status === 0) {
    count(`${name}, edited`, judge(source, locked, free, mapOf(path)));
  }
}
console.log(`largest ratio of speeds ${worst.speed.toFixed(2)}, of accelerations ${worst.acceleration.toFixed(2)}; slide above the source's at most ${(worst.slide * 100).toFixed(2)} cm/s`);
console.log(`${counts.passed} passed, ${counts.failed} failed`);
process.exitCode = counts.failed > 0 ? 1 : 0;
