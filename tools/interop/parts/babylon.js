// Checks files in Babylon without a screen (NullEngine): a Skeleton with a bone for every joint, and the joints'
// positions.

import { readFileSync } from "node:fs";
import { basename, join } from "node:path";

import { Engine } from "@babylonjs/core/Engines/engine.js";
import { NullEngine } from "@babylonjs/core/Engines/nullEngine.js";
import { Scene } from "@babylonjs/core/scene.js";
import { ImportMeshAsync } from "@babylonjs/core/Loading/sceneLoader.js";
import "@babylonjs/loaders/glTF/2.0/index.js";

import { largestDistance, millimetres, ticksOf, toleranceFor } from "../compare.js";
import { describe } from "../glb.js";
import { convert, fixtures, outputName, pose, subfolder } from "../mocap.js";

/** Babylon counts the frames of every animation at this rate. */
const FRAMES_PER_SECOND = 60;

async function checkFile(results, engine, input, output) {
  const name = basename(input);
  const { json, nodes: written, between, frames, frameTime } = describe(output);
  // Babylon makes bones of the root of a skin, even if it is no joint, and of the nodes between the root and the
  // joints.
  const bones = [...json.skins[0].joints, json.skins[0].skeleton, ...between.map(({ index }) => index)];
  const boneCount = new Set(bones).size;
  const scene = new Scene(engine);
  // Without this setting, the loader mirrors the whole file under an additional node.
  scene.useRightHandedSystem = true;
  const data = `data:model/gltf-binary;base64,${readFileSync(output).toString("base64")}`;
  const { skeletons, animationGroups, transformNodes } = await ImportMeshAsync(data, scene, { pluginExtension: ".glb" });
  results.check(
    skeletons.length === 1 && skeletons[0].bones.length === boneCount,
    `${name}: ${skeletons.map((skeleton) => skeleton.bones.length)} bones where ${boneCount} were expected`,
  );
  const nodeByName = new Map(transformNodes.map((node) => [node.name, node]));
  const nodes = written.map((node) => nodeByName.get(node.name));
  let worst = 0;
  if (results.check(nodes.every(Boolean), `${name}: a node is missing`)) {
    animationGroups.forEach((group) => group.start(false));
    for (const tick of ticksOf(Math.max(frames, 1))) {
      animationGroups.forEach((group) => group.goToFrame(tick * frameTime * FRAMES_PER_SECOND));
      nodes.forEach((node) => node.computeWorldMatrix(true));
      const places = nodes.map((node) => node.getAbsolutePosition().asArray());
      const distance = largestDistance(places, pose(output, tick).map((node) => node.translation));
      const tolerance = toleranceFor(places);
      results.check(distance <= tolerance, `${name}, tick ${tick}: ${millimetres(distance)} off`);
      if (tolerance < 0.00011 && distance > worst) worst = distance;
    }
  }
  scene.dispose();
  return worst;
}

export async function run(results, folder, sample) {
  const outputs = subfolder(folder, "babylon");
  const engine = new NullEngine();
  let worst = { distance: 0, file: "none" };
  for (const input of sample.some(fixtures("real"), 2)) {
    await results.guard(basename(input), async () => {
      const output = convert(input, join(outputs, outputName(input, ".glb")));
      const distance = await checkFile(results, engine, input, output);
      if (distance > worst.distance) worst = { distance, file: basename(input) };
    });
  }
  engine.dispose();
  results.note(`Babylon ${Engine.Version}: figures of human size at most ${millimetres(worst.distance)} off, in ${worst.file}`);
}
