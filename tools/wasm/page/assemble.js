// Writes the drop page as one file: the template and the player of `mocap view`, and the reader with its WebAssembly.
//
//   node assemble.js OUT.html

import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { Script } from "node:vm";

import { load } from "../package/index.js";
import { fromBase128, toBase128 } from "./base128.js";
import { leanCode } from "./lean_code.js";
import { leanModule, unusedEncodings } from "./lean_module.js";
import { fromLzma } from "./lzma.js";

const here = import.meta.dirname;
const view = join(here, "../../../src/render/view");
const read = (path) => readFileSync(path, "utf8");

/** The page loads nothing and connects to nothing. It starts a worker from bytes in the page, and compiles WebAssembly. */
const POLICY = [
  "default-src 'none'",
  "connect-src 'none'",
  "script-src 'unsafe-inline' 'wasm-unsafe-eval'",
  "worker-src blob:",
  "style-src 'unsafe-inline'",
  "img-src data:",
  "form-action 'none'",
  "base-uri 'none'",
].join("; ");

/** Removes indentation and comments from source text, as src/render/build.rs does. */
function lean(source) {
  const lines = source.split("\n").map((line) => line.trim());
  let isComment = false;
  const kept = lines.filter((line) => {
    if (line.startsWith("/**")) isComment = true;
    const isKept = line !== "" && !line.startsWith("//") && !isComment;
    if (line.endsWith("*/")) isComment = false;
    return isKept;
  });
  return `${kept.join("\n")}\n`;
}

/** Joins a module and its imports to one script without imports. Each module comes after the modules that it imports. */
function bundled(path, known = new Set()) {
  if (known.has(path)) return "";
  known.add(path);
  const source = read(path);
  const imports = Array.from(source.matchAll(/^import .* from "(.*)";$/gm), ([, from]) => resolve(dirname(path), from));
  const before = imports.map((from) => bundled(from, known)).join("");
  return before + lean(source).replace(/^import .*\n/gm, "").replace(/^export /gm, "");
}

/**
 * Checks a joined script. Its modules share one namespace, so a name declared twice is an error here instead of in a browser.
 */
function checkedScript(path) {
  // A page from a file cannot start a module worker. The worker gets its WebAssembly from the page.
  const script = bundled(path).replaceAll("import.meta.url", "location.href");
  new Script(script, { filename: path });
  return script;
}

const element = (id, type, content) => {
  if (/<\/script/i.test(content)) throw new Error(`${id} would end its element`);
  return `<script type="${type}" id="${id}">${content}</script>`;
};

const worker = checkedScript(join(here, "worker.js"));
const whole = readFileSync(join(here, "../package/mocap.wasm"));
const survey = join(here, "../../../src/corpus/survey/card");
const { packages } = JSON.parse(execFileSync("cargo", ["metadata", "--format-version=1"], { cwd: here, maxBuffer: 1 << 28, stdio: ["ignore", "pipe", "ignore"] }));
const encodings = packages.find(({ name }) => name === "encoding_rs");
const tables = unusedEncodings(read(join(dirname(encodings.manifest_path), "src/data.rs")));
if (!tables.length) throw new Error("the tables of encoding_rs are not found in its source");
const wasm = leanCode(leanModule(whole, [view, survey].flatMap((folder) => readdirSync(folder).map((name) => join(folder, name))).filter((path) => /\.(js|css|html)$/.test(path)).map(read).concat(tables)));
// The header states the total size, which is unknown with a pipe.
const packed = execFileSync("xz", ["--format=lzma", "--lzma1=preset=9e,lc=4,pb=0", "--stdout"], { input: wasm, maxBuffer: 2 * wasm.length });
packed.writeBigUInt64LE(BigInt(wasm.length), 5);
const wasmText = toBase128(packed);
if (!wasm.equals(fromLzma(fromBase128(wasmText)))) throw new Error("the WebAssembly in the page is not what it was made from");
/** A few seconds of a walk for an empty page, packed within 0.1 mm. */
async function walkOf(path) {
  const mocap = await load(whole);
  const walk = mocap.read(read(path), "walk.bvh", { skeletonMesh: "none" });
  return walk.convert({ firstFrame: "auto" }).toMclip({ maxError: 1e-4 });
}

const parts = {
  title: "mocap",
  policy: POLICY,
  style: lean(read(join(view, "page.css")) + read(join(here, "desk.css"))),
  buttons: read(join(here, "buttons.html")),
  desk: read(join(here, "desk.html")),
  data: "{}",
  keys: element("worker", "text/plain", worker),
  skins: element("wasm", "application/octet-stream", wasmText),
  textures: element("walk", "application/octet-stream", toBase128(await walkOf(join(here, "../../../fixtures/real/cmu_12_01_walk.bvh")))),
  script: checkedScript(join(here, "drop.js")),
  downloads: "",
};
const page = read(join(view, "page.html")).replace(/\{\{(\w+)\}\}/g, (_, name) => {
  if (!(name in parts)) throw new Error(`the page has no place called ${name}`);
  return parts[name];
});
writeFileSync(process.argv[2], page);
console.error(`${process.argv[2]}: ${Buffer.byteLength(page)} bytes, of which WebAssembly ${Buffer.byteLength(wasmText)}`);
