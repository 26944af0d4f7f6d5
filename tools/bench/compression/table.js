// Compares bytes and errors of compressed clips of mocap, ACL, gltfpack and gltf-transform. See run.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { cpus, tmpdir } from "node:os";
import { basename, join } from "node:path";
import { parseArgs } from "node:util";

import { fixtures, mocap } from "../../interop/mocap.js";
import { PACKERS } from "../../interop/packers.js";
import { readGlb } from "../../interop/glb.js";
import { inChromium } from "./browser.js";
import { errorsOf, openGlb } from "./clips.js";
import { decodeTimes } from "./decode.js";
import { openPacked } from "./packed.js";

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { acl: { type: "string" }, bench: { type: "string" }, keep: { type: "boolean", default: false } },
});

/** The largest errors, in millimetres. */
const BOUNDS = [0.1, 1, 5];
/** The compressed forms that mocap writes. */
const FORMS = ["int16", "meshopt", "meshopt-khr", "mclip"];
/** The writers that also bound the error of a shell 3 cm from the joints, as ACL does. */
const WITH_SHELL = ["meshopt", "meshopt-khr", "mclip"].map((form) => `${form}, shell`);
const boundsShell = (writer) => writer === "ACL" || WITH_SHELL.includes(writer);
/** The packers that keep the skeleton and every key. */
const OTHERS = PACKERS.filter(({ name }) => ["gltfpack -kn -cc -af 0", "gltf-transform meshopt"].includes(name));
/** Bytes of a joint in one of ACL's raw samples: rotation, translation and scale as floats. */
const RAW = 40;

const folder = mkdtempSync(join(tmpdir(), "mocap-compression-"));
const failures = [];

/** @typedef {{ clip: string, bound: number | null, writer: string, bytes: number, raw: number, joints: number, shells: number, extra?: object }} Row */
/** @type {Row[]} */
const rows = [];

const isHumanoid = (file) => {
  try {
    return JSON.parse(mocap("skeleton", file, "--json")).humanoid.found;
  } catch {
    return false;
  }
};

/** Writes the samples for acl.cpp, and reads them back. */
function compressWithAcl(source, bound) {
  const [input, output] = [join(folder, "acl.in"), join(folder, "acl.out")];
  const { parents, times } = source;
  const rate = times.length > 1 ? (times.length - 1) / times.at(-1) : 1;
  const bytes = Buffer.alloc(12 + 4 * parents.length + RAW * parents.length * times.length);
  bytes.writeUInt32LE(parents.length, 0);
  bytes.writeUInt32LE(times.length, 4);
  bytes.writeFloatLE(rate, 8);
  let at = 12;
  for (const parent of parents) at = bytes.writeInt32LE(parent, at);
  for (const seconds of times) {
    for (const { rotation, translation, scale } of source.at(seconds)) {
      for (const value of [...rotation, ...translation, ...scale]) at = bytes.writeFloatLE(value, at);
    }
  }
  writeFileSync(input, bytes);
  const said = JSON.parse(execFileSync(options.acl, [input, String(bound / 1000), output], { encoding: "utf8" }));
  const found = readFileSync(output);
  const poseOf = (frame) =>
    parents.map((_, node) => {
      const floats = Array.from({ length: 10 }, (_, index) => found.readFloatLE(RAW * (frame * parents.length + node) + 4 * index));
      return { rotation: floats.slice(0, 4), translation: floats.slice(4, 7), scale: floats.slice(7) };
    });
  return { said, lossy: { parents, times, at: (_, frame) => poseOf(frame) } };
}

/**
 * Whether an error exceeds the bound: the error of a joint, and of the shell if the writer bounds it too.
 * @param {Row} row
 */
function isOver({ writer, bound, joints, shells }) {
  return (boundsShell(writer) ? Math.max(joints, shells) : joints) > bound / 1000;
}

/** The input of the decode times: the longest clip at the middle bound, with bytes in base64. */
const decoded = { clip: "", frames: 0, packed: {}, clips: {} };

function keepToDecode(clip, frames, writer, path) {
  if (frames > decoded.frames) Object.assign(decoded, { clip, frames, packed: {}, clips: {} });
  if (clip !== decoded.clip) return;
  const base64 = (bytes) => Buffer.from(bytes).toString("base64");
  if (writer === "mclip") {
    decoded.clips[writer] = base64(readFileSync(path));
    return;
  }
  const { json, bin } = readGlb(path);
  const packings = json.bufferViews.map(({ extensions = {} }) => extensions.EXT_meshopt_compression ?? extensions.KHR_meshopt_compression);
  const views = packings.filter(Boolean).map(({ byteOffset = 0, ...view }) => ({ ...view, byteOffset }));
  if (views.length > 0) decoded.packed[writer] = { views, bytes: base64(bin) };
}

/** The number of frames of a file at its own rate. @type {Map<string, number>} */
const framesOf = new Map();

async function measure(file, fps) {
  const clip = `${basename(file)}${fps ? ` at ${fps}` : ""}`;
  const rate = fps ? ["--fps", String(fps)] : [];
  const plain = join(folder, "plain.glb");
  mocap("convert", file, plain, "--force", "--quiet", "--mesh", "none", ...rate);
  const source = await openGlb(plain);
  // The row for 30 frames a second would repeat a clip whose own rate is 30.
  if (source.times.length < 2 || (fps && source.times.length === framesOf.get(file))) return;
  framesOf.set(file, source.times.length);
  const raw = RAW * source.parents.length * source.times.length;
  const add = (writer, bound, bytes, lossy, extra) => rows.push({ clip, bound, writer, bytes, raw, ...errorsOf(source, lossy), extra });
  for (const bound of BOUNDS) {
    if (options.acl) {
      const { said, lossy } = compressWithAcl(source, bound);
      add("ACL", bound, said.bytes, lossy, said);
    }
    for (const writer of [...FORMS, ...WITH_SHELL]) {
      const [form, shell] = writer.split(", ");
      const isPacked = form === "mclip";
      const output = join(folder, isPacked ? "out.mclip" : "out.glb");
      const more = isPacked ? [] : ["--mesh", "none", "--compress", form];
      if (shell) more.push("--shell-distance", "3cm");
      try {
        mocap("convert", file, output, "--force", "--quiet", ...rate, ...more, "--max-error", `${bound}mm`);
      } catch (error) {
        failures.push(`${clip}, ${writer}, ${bound} mm: ${String(error.stderr).trim().split("\n")[0]}`);
        continue;
      }
      const lossy = isPacked ? { ...openPacked(output), names: undefined } : await openGlb(output);
      add(writer, bound, statSync(output).size, lossy);
      if (bound === BOUNDS[1] && !shell) keepToDecode(clip, source.times.length, form, output);
    }
  }
  for (const { name, pack } of OTHERS) {
    const output = join(folder, "packed.glb");
    try {
      pack(plain, output);
      add(name, null, statSync(output).size, await openGlb(output));
      keepToDecode(clip, source.times.length, name, output);
    } catch (error) {
      failures.push(`${clip}, ${name}: ${String(error.message).split("\n")[0]}`);
    }
  }
  process.stderr.write(`${clip}\n`);
}

const millimetres = (metres) => (metres * 1000).toFixed(4);
const count = (number) => number.toLocaleString("en");
const sum = (numbers) => numbers.reduce((total, number) => total + number, 0);

function printSums() {
  console.log("| bound, mm | writer | clips | bytes | raw to bytes | bytes relative to ACL | clips larger than ACL | largest error of a joint, mm | largest error of the shell, mm | clips over the bound |");
  console.log("|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|");
  for (const bound of [...BOUNDS, null]) {
    for (const writer of new Set(rows.filter((row) => row.bound === bound).map((row) => row.writer))) {
      const mine = rows.filter((row) => row.bound === bound && row.writer === writer);
      const acl = mine.map((row) => rows.find((other) => other.clip === row.clip && other.bound === bound && other.writer === "ACL"));
      const bytes = sum(mine.map((row) => row.bytes));
      const ofAcl = acl.every(Boolean) ? (bytes / sum(acl.map((row) => row.bytes))).toFixed(3) : "-";
      const larger = acl.every(Boolean) ? mine.filter((row, index) => row.bytes > acl[index].bytes).length : "-";
      const over = bound === null ? "-" : mine.filter(isOver).length;
      console.log(
        `| ${bound ?? "none"} | ${writer} | ${mine.length} | ${count(bytes)} | ${(sum(mine.map((row) => row.raw)) / bytes).toFixed(1)} | ${ofAcl} | ${larger} | ${millimetres(Math.max(...mine.map((row) => row.joints)))} | ${millimetres(Math.max(...mine.map((row) => row.shells)))} | ${over} |`,
      );
    }
  }
}

function printClips() {
  const bytesOf = (clip, writer, bound) => {
    const row = rows.find((row) => row.clip === clip && row.writer === writer && row.bound === bound);
    return row ? `${count(row.bytes)}${bound !== null && isOver(row) ? " !" : ""}` : "-";
  };
  const writers = ["ACL", ...FORMS];
  console.log(`\n| clip | ${BOUNDS.flatMap((bound) => writers.map((writer) => `${writer} ${bound}`)).join(" | ")} |`);
  console.log(`|---|${BOUNDS.flatMap(() => writers.map(() => "--:|")).join("")}`);
  for (const clip of new Set(rows.map((row) => row.clip))) {
    console.log(`| ${clip} | ${BOUNDS.flatMap((bound) => writers.map((writer) => bytesOf(clip, writer, bound))).join(" | ")} |`);
  }
}

function printSpeed() {
  const acl = rows.filter((row) => row.writer === "ACL" && row.bound === BOUNDS[0]);
  if (acl.length === 0) return;
  console.log("");
  for (const bound of BOUNDS) {
    const mine = rows.filter((row) => row.writer === "ACL" && row.bound === bound);
    const speed = sum(mine.map((row) => row.raw)) / sum(mine.map((row) => row.extra.encode)) / 1e6;
    console.log(`ACL at ${bound} mm: ${speed.toFixed(1)} MB of raw samples compressed a second.`);
  }
  console.log("\n| clip | ACL's pose, us | of 64 clips, us |");
  console.log("|---|--:|--:|");
  for (const { clip, extra } of acl) console.log(`| ${clip} | ${extra.random} | ${extra.clips} |`);
}

/** The times in Node and in Chromium to unpack a whole file, and to decode a pose of a packed clip. */
async function printDecoding() {
  const { MeshoptDecoder } = await import(new URL("../../interop/node_modules/meshoptimizer/meshopt_decoder.mjs", import.meta.url));
  const { load } = await import("../../wasm/package/index.js");
  await MeshoptDecoder.ready;
  const bytesOf = (text) => new Uint8Array(Buffer.from(text, "base64"));
  const node = decodeTimes({
    decoder: MeshoptDecoder,
    mocap: await load(),
    packed: Object.fromEntries(Object.entries(decoded.packed).map(([name, { views, bytes }]) => [name, { views, bytes: bytesOf(bytes) }])),
    clips: Object.fromEntries(Object.entries(decoded.clips).map(([name, bytes]) => [name, bytesOf(bytes)])),
  });
  const browser = await inChromium(decoded);
  console.log(`\nDecoding ${decoded.clip}, ${decoded.frames} frames, at ${BOUNDS[1]} mm; Chromium ${browser.version}:\n`);
  console.log("| file | what | Node | Chromium |");
  console.log("|---|---|--:|--:|");
  for (const name of Object.keys(node.unpack)) {
    console.log(`| ${name} | the whole file unpacked, ms | ${node.unpack[name].toFixed(2)} | ${browser.unpack[name].toFixed(2)} |`);
  }
  for (const name of Object.keys(node.pose)) {
    console.log(`| ${name} | a pose at a random tick, us | ${node.pose[name].toFixed(2)} | ${browser.pose[name].toFixed(2)} |`);
  }
}

const chosen = positionals.length > 0 ? positionals : fixtures("real").filter(isHumanoid);
for (const file of chosen) {
  for (const fps of [null, 30]) {
    try {
      await measure(file, fps);
    } catch (error) {
      failures.push(`${basename(file)}: ${error.message.split("\n")[0]}`);
    }
  }
}
console.log(`${cpus()[0].model}, Node ${process.version}, ${new Date().toISOString().slice(0, 10)}\n`);
printSums();
printClips();
printSpeed();
try {
  await printDecoding();
} catch (error) {
  failures.push(`decode times: ${error.message.split("\n")[0]}`);
}
if (options.bench) {
  // This package is built without the reader of FBX.
  const files = chosen.filter((file) => !file.endsWith(".fbx"));
  try {
    console.log(`\n${execFileSync(options.bench, ["packed", ...files], { encoding: "utf8" })}`);
  } catch (error) {
    failures.push(`poses and encoding: ${String(error.stderr).trim().split("\n")[0]}`);
  }
}
for (const failure of failures) console.log(`\nnot measured: ${failure}`);
if (options.keep) writeFileSync("rows.json", JSON.stringify(rows));
rmSync(folder, { recursive: true });
