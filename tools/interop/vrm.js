// Programs that pose a VRM character with a VRM animation. They give the rotation of each bone relative to the T-pose
// at each time, in the axes of glTF. three-vrm is in parts/vrma.js.

import { execFileSync, spawnSync } from "node:child_process";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { Quaternion } from "three";

const python = process.env.BLENDER_PYTHON;
const pathOf = (file) => fileURLToPath(new URL(file, import.meta.url));

/** Runs a program that prints its poses as JSON. */
function ask(program, args, input) {
  const stdio = ["pipe", "pipe", "ignore"];
  const printed = execFileSync(program, args, { input, encoding: "utf8", maxBuffer: 1 << 30, stdio });
  return JSON.parse(printed.trim().split("\n").at(-1));
}

const posesOf = (answer, rotation) =>
  answer.map((turns) => ({ turns: new Map(Object.entries(turns).map(([bone, turn]) => [bone, rotation(turn)])) }));

/**
 * Whether Blender with the VRM add-on is available: BLENDER_PYTHON names a Python with both; README.md describes its
 * installation.
 */
export function canBlender() {
  return python !== undefined && spawnSync(python, ["-c", "import bpy, io_scene_vrm"]).status === 0;
}

export async function posesInBlender(character, animation, times, rate) {
  const request = { character, animation, frames_per_second: rate, seconds: times };
  const answer = ask(python, [pathOf("blender/vrma.py")], JSON.stringify(request));
  return posesOf(answer, ([w, x, y, z]) => new Quaternion(x, z, -y, w));
}

/** Builds the program around the crate vrm-runtime. */
export function buildVrmRuntime() {
  const manifest = pathOf("vrm-runtime/Cargo.toml");
  const target = join(process.env.CARGO_TARGET_DIR ?? pathOf("../../target"), "vrm-runtime");
  const options = { env: { ...process.env, CARGO_TARGET_DIR: target }, stdio: ["ignore", "ignore", "inherit"] };
  execFileSync("cargo", ["build", "--quiet", "--locked", "--manifest-path", manifest], options);
  const program = join(target, "debug/mocap-vrm-runtime");
  return async (character, animation, times) =>
    posesOf(ask(program, [character, animation, ...times.map(String)]), (turn) => new Quaternion(...turn));
}
