// Common parts of the checks of inverse kinematics: positions, random tasks from a seed, and the examples of the
// library.

import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

export const distance = (a, b) => Math.hypot(...a.map((value, axis) => value - b[axis]));
export const plus = (a, b) => a.map((value, axis) => value + b[axis]);
export const minus = (a, b) => a.map((value, axis) => value - b[axis]);

/**
 * The path of a library example: beside the program, or in the tests' build folder, so that nothing is compiled twice.
 */
export function exampleProgram(name) {
  const root = fileURLToPath(new URL("../../target", import.meta.url));
  const programs = [dirname(process.env.MOCAP), join(root, "debug")].map((folder) => join(folder, "examples", name));
  const found = programs.find(existsSync);
  assert.ok(found, `${programs.join(" and ")} are not there: cargo build --example ${name}`);
  return found;
}

/** Pseudorandom numbers from a seed. */
export function randomOf(seed) {
  let state = seed >>> 0 || 1;
  return (most) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return ((state / 2 ** 32) * 2 - 1) * most;
  };
}
