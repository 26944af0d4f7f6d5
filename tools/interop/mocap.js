// The command-line tool, and the files of the checks.

import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, readdirSync } from "node:fs";
import { basename, extname, join } from "node:path";
import { fileURLToPath } from "node:url";

const FIXTURES = fileURLToPath(new URL("../../fixtures/", import.meta.url));
const MOTION_FILES = [".bvh", ".amc", ".c3d", ".fbx"];
/** The real files that mocap must refuse, with the codes of their errors. */
export const REFUSED = JSON.parse(readFileSync(new URL("exceptions.json", import.meta.url))).refused;

/** Runs `mocap` and returns its output. Throws if it fails. */
export function mocap(...args) {
  return execFileSync(process.env.MOCAP, args, {
    encoding: "utf8",
    maxBuffer: 1 << 30,
    stdio: ["ignore", "pipe", "pipe"],
  });
}

/** Converts `input` to `output`, whose extension determines the format. */
export function convert(input, output, ...options) {
  mocap("convert", input, output, ...options);
  return output;
}

/** The nodes of a file at a tick: name, parent's name and world position. */
export function pose(file, tick) {
  return JSON.parse(mocap("pose", file, "--tick", String(tick), "--world", "--json")).nodes;
}

/** The readable motion files in a folder of fixtures, as paths. */
export function fixtures(folder) {
  return readdirSync(join(FIXTURES, folder))
    .filter((name) => MOTION_FILES.includes(extname(name)) && !REFUSED.some(({ file }) => file === name))
    .sort()
    .map((name) => join(FIXTURES, folder, name));
}

/** One real file by name. */
export function realFixture(name) {
  return join(FIXTURES, "real", name);
}

/** One file that was made for the project, by name. */
export function madeFixture(name) {
  return join(FIXTURES, "made", name);
}

/** One file of the skeletons by name. */
export function skeletonFixture(name) {
  return join(FIXTURES, "skeletons", name);
}

/** A folder for the files that one part writes. */
export function subfolder(folder, name) {
  const path = join(folder, name);
  mkdirSync(path, { recursive: true });
  return path;
}

/** The name of a fixture's output, which is unique even if two formats hold the same take. */
export function outputName(input, extension) {
  return basename(input).replaceAll(".", "_") + extension;
}
