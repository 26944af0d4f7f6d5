// Compares bytes and errors of mocap's files with gltfpack's and gltf-transform's versions of its default file: one
// table per clip, and the limits.

import { mkdirSync, mkdtempSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { parseArgs } from "node:util";

import { millimetres, stepsOf } from "./compare.js";
import { describe } from "./glb.js";
import { errorsOf, placesOfSource } from "./measure.js";
import { convert, realFixture, subfolder } from "./mocap.js";
import { PACKERS, YARDSTICK } from "./packers.js";
import { Results } from "./results.js";

/**
 * Six skeletons. The first must keep every fixed limit below, and three of the others the limit relative to gltfpack.
 */
const CLIPS = [
  "cmu_01_01.bvh",
  "cmu_salsa_poser_names.bvh",
  "rokoko_dance.bvh",
  "motionbuilder_vicon_walk.bvh",
  "mocopi_jump_six_channels.bvh",
  "perception_neuron_moving_positions.bvh",
];

/** Bounds in millimetres, and the largest allowed bytes of mocap's file within each bound for the first clip. */
const BOUNDED = [
  { form: "int16", bound: 1, limit: 560_000 },
  { form: "meshopt", bound: 1, limit: 140_000 },
  { form: "meshopt", bound: 5, limit: 80_000 },
  { form: "meshopt-khr", bound: 1 },
];

/**
 * The largest ratio of mocap's bytes to gltfpack's bytes at the same error, and the number of other clips that must
 * keep it.
 */
const SHARE_OF_GLTFPACK = 0.8;
const CLIPS_WITHIN_SHARE = 3;

/** The page into which --write puts the tables, between these lines. */
const PAGE = new URL("README.md", import.meta.url);
const BEGIN = "<!-- begin: written by tools/interop/sizes --write -->";
const END = "<!-- end -->";

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: { keep: { type: "string" }, write: { type: "boolean" } },
});
if (values.write && positionals.length > 0) throw new Error("--write needs every clip");
const folder = values.keep ?? mkdtempSync(join(tmpdir(), "mocap-sizes-"));
mkdirSync(folder, { recursive: true });
const results = new Results();

/** @typedef {{ writer: string, bytes: number, most: number, rms: number, hasSkin: boolean }} Row */

/** The ratio to gltfpack's bytes, for each clip. @type {Map<string, number>} */
const shares = new Map();

const tables = [];
/** Prints a line of the tables. */
function print(line) {
  tables.push(line);
  console.log(line);
}

const count = (number) => number.toLocaleString("en");

/** @param {Row} row */
function printRow({ writer, bytes, most, rms, hasSkin }) {
  const inMillimetres = [most, rms].map((error) => (error * 1000).toFixed(4));
  print(`| ${writer} | ${count(bytes)} | ${inMillimetres.join(" | ")} | ${hasSkin ? "yes" : "no"} |`);
}

async function measureClip(clip) {
  const input = realFixture(clip);
  const outputs = subfolder(folder, clip);
  /** @type {Map<string, Row>} */
  const rows = new Map();
  const pathOf = (writer) => join(outputs, `${writer.replaceAll(/[^a-z0-9.-]+/g, "_")}.glb`);

  const plain = convert(input, pathOf("mocap, default"), "--mesh", "none");
  const { provenance } = describe(plain);
  if (provenance.root_offset.policy !== "replace") throw new Error(`${clip} adds to the OFFSET, which bvh.js does not`);
  const source = placesOfSource(input, stepsOf(provenance).change);

  const { names, frames } = source;
  print(`\n### ${clip}: ${count(statSync(input).size)} bytes of text, ${names.length} nodes, ${count(frames.length)} frames\n`);
  print("| writer | bytes | largest error, mm | RMS error, mm | skin kept |");
  print("|---|--:|--:|--:|:-:|");
  const add = (writer, write) =>
    results.guard(`${clip}, ${writer}`, async () => {
      const path = pathOf(writer);
      write(path);
      const hasSkin = describe(path).json.skins?.length > 0;
      const row = { writer, bytes: statSync(path).size, ...(await errorsOf(path, source)), hasSkin };
      rows.set(writer, row);
      printRow(row);
    });

  /** Adds a file that mocap must keep within a bound in millimetres. */
  const addBounded = async (writer, form, bound) => {
    await add(writer, (path) => convert(input, path, "--mesh", "none", "--compress", form, "--max-error", `${bound}mm`));
    const row = rows.get(writer);
    if (row) results.check(row.most * 1000 <= bound, `${clip}, ${writer}: ${millimetres(row.most)} off, over the bound of ${bound} mm`);
    return row;
  };

  await add("mocap, default", () => {});
  for (const { form, bound, limit } of BOUNDED) {
    const row = await addBounded(`mocap, ${form}, ${bound} mm`, form, bound);
    if (row && limit && clip === CLIPS[0]) results.check(row.bytes <= limit, `${clip}, ${row.writer}: ${row.bytes} bytes, over ${limit}`);
  }
  for (const { name, pack } of PACKERS) await add(name, (path) => pack(plain, path));

  const yardstick = rows.get(YARDSTICK.name);
  // Rounds down, so that the bound is not wider than gltfpack's error.
  const bound = Math.floor(yardstick.most * 1e7) / 1e4;
  const row = await addBounded(`mocap, meshopt, ${bound} mm, the error of ${YARDSTICK.name}`, "meshopt", bound);
  if (!row) return;
  const share = row.bytes / yardstick.bytes;
  print(`\nAt the error of \`${YARDSTICK.name}\`, mocap needs ${share.toFixed(4)} of its bytes.`);
  shares.set(clip, share);
}

for (const clip of positionals.length > 0 ? positionals : CLIPS) await results.guard(clip, () => measureClip(clip));
if (positionals.length === 0) {
  const within = CLIPS.slice(1).filter((clip) => shares.get(clip) <= SHARE_OF_GLTFPACK);
  results.check(
    within.length >= CLIPS_WITHIN_SHARE,
    `at most ${SHARE_OF_GLTFPACK} of gltfpack's bytes in ${within.length} clips, wanted ${CLIPS_WITHIN_SHARE}`,
  );
}
if (values.write) {
  const [before, rest] = readFileSync(PAGE, "utf8").split(BEGIN);
  const after = rest.slice(rest.indexOf(END));
  writeFileSync(PAGE, `${before}${BEGIN}\n${tables.join("\n")}\n\n${after}`);
}
console.log(`\nfiles are in ${folder}`);
console.log(`${results.passed} passed, ${results.failed} failed`);
process.exit(results.failed === 0 ? 0 : 1);
