// Runs the parts, which are files under parts/, and counts the results.

import { mkdirSync, mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { parseArgs } from "node:util";

import { Results } from "./results.js";
import { Sample } from "./sample.js";

const PARTS = [
  "validator",
  "verify",
  "three",
  "babylon",
  "bvh",
  "clients",
  "faces",
  "vrma",
  "characters",
  "browser",
  "extremes",
  "compress",
  "bounds",
  "corpus",
];
/** This part needs its own Python environment (see README.md), so it only runs when named. */
const PARTS_BY_NAME = ["blender", "retarget"];

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: { all: { type: "boolean", default: false }, keep: { type: "string" } },
});
const unknown = positionals.filter((name) => ![...PARTS, ...PARTS_BY_NAME].includes(name));
if (unknown.length > 0) {
  console.error(`no part is called ${unknown.join(", ")}; there are ${[...PARTS, ...PARTS_BY_NAME].join(", ")}`);
  process.exit(2);
}

const folder = values.keep ?? mkdtempSync(join(tmpdir(), "mocap-interop-"));
mkdirSync(folder, { recursive: true });
const results = new Results();
const sample = Sample.chosen(values.all);
for (const part of positionals.length > 0 ? positionals : PARTS) {
  console.log(`\n${part}`);
  const { run } = await import(`./parts/${part}.js`);
  await run(results, folder, sample);
}
console.log(`\nfiles and pictures are in ${folder}`);
console.log(`${results.passed} passed, ${results.failed} failed`);
process.exit(results.failed === 0 ? 0 : 1);
