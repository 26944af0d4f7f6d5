// FBX with fewer keys: three.js's FBXLoader and Babylon's loader put every joint within the largest error of the source.

import { readFileSync } from "node:fs";
import { basename, join } from "node:path";

import { NullEngine } from "@babylonjs/core/Engines/nullEngine.js";
import { ImportMeshAsync } from "@babylonjs/core/Loading/sceneLoader.js";
import { Scene } from "@babylonjs/core/scene.js";
import "@babylonjs/loaders/FBX/index.js";
import { AnimationMixer, LoopOnce, Vector3, REVISION } from "three";
import { FBXLoader } from "three/addons/loaders/FBXLoader.js";

import { millimetres, toleranceFor } from "../compare.js";
import { describe } from "../glb.js";
import { convert, fixtures, outputName, pose, subfolder } from "../mocap.js";

/** Files that a client shows wrongly, with every key too. */
const EXCUSED = JSON.parse(readFileSync(new URL("../exceptions.json", import.meta.url))).fbx;
/** The largest error that is asked for, in metres. */
const BOUND = 0.001;
/** Metres in a unit of the files. */
const CENTIMETRE = 0.01;
/** Frames to look at in each file. */
const FRAMES = 16;
/** A file as three.js has it: where joints are at a time, by name. */
function inThree(path) {
  const bytes = readFileSync(path);
  const group = new FBXLoader().parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength), "");
  const mixer = new AnimationMixer(group);
  for (const clip of group.animations) {
    const action = mixer.clipAction(clip).setLoop(LoopOnce, 1);
    action.clampWhenFinished = true;
    action.play();
  }
  return async (seconds) => {
    mixer.setTime(seconds);
    group.updateMatrixWorld(true);
    const places = new Map();
    group.traverse((object) => {
      const place = object.getWorldPosition(new Vector3()).multiplyScalar(CENTIMETRE);
      places.set(object.userData.originalName ?? object.name, place.toArray());
    });
    return places;
  };
}

/** A file as Babylon has it. */
async function inBabylon(path, engine) {
  const scene = new Scene(engine);
  scene.useRightHandedSystem = true;
  const data = `data:application/octet-stream;base64,${readFileSync(path).toString("base64")}`;
  const { animationGroups } = await ImportMeshAsync(data, scene, { pluginExtension: ".fbx" });
  animationGroups.forEach((group) => group.start(false));
  return async (seconds) => {
    for (const group of animationGroups) {
      group.goToFrame(seconds * group.targetedAnimations[0].animation.framePerSecond);
    }
    const places = new Map();
    for (const node of scene.transformNodes) {
      node.computeWorldMatrix(true);
      places.set(node.name, node.getAbsolutePosition().scale(CENTIMETRE).asArray());
    }
    return places;
  };
}

export async function run(results, folder, sample) {
  const outputs = subfolder(folder, "fbx");
  const engine = new NullEngine();
  const worst = new Map();
  // Of `cmu_short.bvh` the axes of a position have most of their keys at different frames.
  const inputs = fixtures("real").filter((input) => !input.endsWith(".c3d"));
  const first = inputs.filter((input) => basename(input) === "cmu_short.bvh");
  for (const input of new Set([...first, ...sample.some(inputs, 8)])) {
    await results.guard(basename(input), async () => {
      const truth = convert(input, join(outputs, outputName(input, ".glb")), "--skeleton-only");
      const { nodes, frames, frameTime } = describe(truth);
      if (frames < 2) return;
      const output = convert(input, join(outputs, outputName(input, ".fbx")), "--skeleton-only", "--max-error", "1mm");
      const clients = { "three.js": inThree(output), Babylon: await inBabylon(output, engine) };
      const spread = Array.from({ length: FRAMES }, (_, step) => Math.round((step * (frames - 1)) / (FRAMES - 1)));
      // The action of three.js ends with the last frame.
      for (const tick of new Set(spread)) {
        // The groups of a source are not in the file.
        const expected = pose(truth, tick).filter((_, index) => nodes[index].isJoint || nodes[index].extras?.end_site);
        const names = expected.map((node) => node.name);
        const allowed = BOUND + toleranceFor(expected.map((node) => node.translation));
        for (const [client, placesAt] of Object.entries(clients)) {
          if (EXCUSED.some(({ file, client: excused }) => file === basename(input) && excused === client)) continue;
          const places = await placesAt(tick * frameTime);
          for (const { name, translation } of expected) {
            // What has a name twice is called otherwise in the file.
            if (names.indexOf(name) !== names.lastIndexOf(name)) continue;
            const place = places.get(name);
            if (!results.check(place !== undefined, `${basename(input)}: ${client} has no ${name}`)) continue;
            const off = Math.hypot(...place.map((value, axis) => value - translation[axis]));
            results.check(off <= allowed, `${basename(input)}, tick ${tick}: ${client} has ${name} ${millimetres(off)} off`);
            if (!(off <= (worst.get(client) ?? 0))) worst.set(client, off);
          }
        }
      }
    });
  }
  engine.dispose();
  for (const [client, off] of worst) results.note(`${client}${client === "three.js" ? ` r${REVISION}` : ""}: at most ${millimetres(off)} off`);
}
