// Checks files with fewer keys in every client: three.js, Babylon, ufbx, Assimp and Blender put every joint within the
// largest error of the source, in FBX and in glTF.

import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { basename, extname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { NullEngine } from "@babylonjs/core/Engines/nullEngine.js";
import { ImportMeshAsync } from "@babylonjs/core/Loading/sceneLoader.js";
import { Scene } from "@babylonjs/core/scene.js";
import "@babylonjs/loaders/FBX/index.js";
import "@babylonjs/loaders/glTF/2.0/index.js";
import { AnimationMixer, LoopOnce, Vector3 } from "three";
import { FBXLoader } from "three/addons/loaders/FBXLoader.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

import { millimetres, toleranceFor } from "../compare.js";
import { describe } from "../glb.js";
import { convert, fixtures, outputName, pose, subfolder } from "../mocap.js";

/** Files that a client shows wrongly even with every key. */
const EXCUSED = JSON.parse(readFileSync(new URL("../exceptions.json", import.meta.url))).clients;
/** The requested largest error in metres. */
const BOUND = 0.001;
/** Frames to look at in each file. */
const FRAMES = 16;
/** Assimp's limit in metres: it prints six digits, whose errors add up along chains. */
const ASSIMP_DIGITS = 2e-4;
const FBX_TOOLS = fileURLToPath(new URL("../../fbx/", import.meta.url));
const CLIENTS_SCRIPT = fileURLToPath(new URL("../clients.py", import.meta.url));
const { PYTHON_CLIENTS, BLENDER_PYTHON } = process.env;

/** The files that are written from each source. Assimp 5.2 reads normalised integers of rotations as floats. */
const FORMS = {
  fbx: { extension: ".fbx", options: [], metres: 0.01, clients: ["three.js", "Babylon", "ufbx", "Assimp", "Blender", "Blender's Python"] },
  "glb, int16": { extension: ".glb", options: ["--compress", "int16"], metres: 1, clients: ["three.js", "Babylon", "Blender"] },
  "glb, none": { extension: ".glb", options: ["--compress", "none"], metres: 1, clients: ["three.js", "Babylon", "Assimp", "Blender"] },
};

/** For each client: the positions of a file's nodes by name, one map for each of these times in seconds. */
const PLACES = {
  "three.js": inThree,
  Babylon: inBabylon,
  ufbx: (path, seconds) => inPython("ufbx", path, seconds),
  Assimp: (path, seconds, metres) => inPython("assimp", path, seconds, metres),
  Blender: (path, seconds) => inBlender(path, seconds, extname(path) === ".fbx" ? "wm.fbx_import" : "import_scene.gltf"),
  "Blender's Python": (path, seconds) => inBlender(path, seconds, "import_scene.fbx"),
};

async function inThree(path, seconds, metres) {
  const bytes = readFileSync(path);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const isFbx = extname(path) === ".fbx";
  const loaded = isFbx ? new FBXLoader().parse(buffer, "") : await new GLTFLoader().parseAsync(buffer, "");
  const group = isFbx ? loaded : loaded.scene;
  const mixer = new AnimationMixer(group);
  for (const clip of loaded.animations) {
    const action = mixer.clipAction(clip).setLoop(LoopOnce, 1);
    action.clampWhenFinished = true;
    action.play();
  }
  return seconds.map((time) => {
    mixer.setTime(time);
    group.updateMatrixWorld(true);
    const places = new Map();
    group.traverse((object) => {
      const place = object.getWorldPosition(new Vector3()).multiplyScalar(metres);
      places.set(object.userData.originalName ?? object.userData.name ?? object.name, place.toArray());
    });
    return places;
  });
}

async function inBabylon(path, seconds, metres) {
  const engine = new NullEngine();
  const scene = new Scene(engine);
  scene.useRightHandedSystem = true;
  const data = `data:application/octet-stream;base64,${readFileSync(path).toString("base64")}`;
  const { animationGroups } = await ImportMeshAsync(data, scene, { pluginExtension: extname(path) });
  animationGroups.forEach((group) => group.start(false));
  const all = seconds.map((time) => {
    for (const group of animationGroups) group.goToFrame(time * group.targetedAnimations[0].animation.framePerSecond);
    const places = new Map();
    for (const node of scene.transformNodes) {
      node.computeWorldMatrix(true);
      places.set(node.name, node.getAbsolutePosition().scale(metres).asArray());
    }
    return places;
  });
  engine.dispose();
  return all;
}

const asMaps = (frames) => frames.map((frame) => new Map(Object.entries(frame)));

function inPython(client, path, seconds, metres = 1) {
  const args = [CLIENTS_SCRIPT, client, path, String(metres), ...seconds.map(String)];
  return asMaps(JSON.parse(execFileSync(PYTHON_CLIENTS, args, { encoding: "utf8", maxBuffer: 1 << 30 })));
}

function inBlender(path, seconds, importer) {
  const input = JSON.stringify([{ file: path, seconds, importer }]);
  const printed = execFileSync(BLENDER_PYTHON, [join(FBX_TOOLS, "blender.py")], { input, encoding: "utf8", maxBuffer: 1 << 30 });
  const [answer] = JSON.parse(printed.trim().split("\n").at(-1));
  if (answer.refusal) throw new Error(answer.refusal);
  return answer.places.map((frame) => new Map(answer.bones.map((bone, index) => [bone, frame[index]])));
}

/** A sentence about missing and wrong positions of a client, and the largest distance. */
function faults(places, expected, allowed) {
  let [worst, sentence] = [0, undefined];
  const names = expected.map((node) => node.name);
  for (const { name, translation } of expected) {
    // The file renames nodes whose names repeat.
    if (names.indexOf(name) !== names.lastIndexOf(name)) continue;
    const place = places.get(name);
    if (place === undefined) return { worst: Infinity, sentence: `no ${name}` };
    const off = Math.hypot(...place.map((value, axis) => value - translation[axis]));
    if (!(off <= worst)) worst = off;
    if (!(off <= allowed)) sentence ??= `${name} ${millimetres(off)} off`;
  }
  return { worst, sentence };
}

async function checkFile(results, input, outputs, worst) {
  const truth = convert(input, join(outputs, outputName(input, "_truth.glb")), "--skeleton-only");
  const { nodes, frames, frameTime } = describe(truth);
  if (frames < 2) return;
  const spread = Array.from({ length: FRAMES }, (_, step) => Math.round((step * (frames - 1)) / (FRAMES - 1)));
  const ticks = [...new Set(spread)];
  // The groups of a source are not in the file.
  const isKept = (_, index) => nodes[index].isJoint || nodes[index].extras?.end_site;
  const expected = ticks.map((tick) => pose(truth, tick).filter(isKept));
  for (const [form, { extension, options, metres, clients }] of Object.entries(FORMS)) {
    const name = outputName(input, `_${form.replace(", ", "_")}${extension}`);
    const output = convert(input, join(outputs, name), "--skeleton-only", "--max-error", "1mm", ...options);
    for (const client of clients.filter((client) => BLENDER_PYTHON || !client.startsWith("Blender"))) {
      const isIt = ({ file, client: excused }) => file === basename(input) && excused === client;
      if (form === "fbx" && EXCUSED.some(isIt)) continue;
      await results.guard(`${basename(input)}, ${form}, ${client}`, async () => {
        const all = await PLACES[client](output, ticks.map((tick) => tick * frameTime), metres);
        all.forEach((places, index) => {
          const tolerance = toleranceFor(expected[index].map((node) => node.translation));
          const allowed = BOUND + tolerance + (client === "Assimp" ? ASSIMP_DIGITS : 0);
          const { worst: off, sentence } = faults(places, expected[index], allowed);
          results.check(!sentence, `${basename(input)}, ${form}, tick ${ticks[index]}: ${client} has ${sentence}`);
          const cell = `${client} | ${form}`;
          if (tolerance < 0.00011 && !(off <= (worst.get(cell) ?? 0))) worst.set(cell, off);
        });
      });
    }
  }
}

export async function run(results, folder, sample) {
  const outputs = subfolder(folder, "clients");
  const worst = new Map();
  // In `cmu_short.bvh`, the three axes of a position have most of their keys at different frames.
  const inputs = fixtures("real").filter((input) => !input.endsWith(".c3d"));
  const first = inputs.filter((input) => basename(input) === "cmu_short.bvh");
  for (const input of new Set([...first, ...sample.some(inputs, 8)])) {
    await results.guard(basename(input), () => checkFile(results, input, outputs, worst));
  }
  if (!BLENDER_PYTHON) results.note("left out: Blender, because BLENDER_PYTHON names no Python");
  for (const [cell, off] of worst) results.note(`${cell} | ${millimetres(off)}`);
}
