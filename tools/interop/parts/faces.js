// Checks curves of morph targets in three.js and Babylon: in the original file, and after a step that changes its
// times.

import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { NullEngine } from "@babylonjs/core/Engines/nullEngine.js";
import { ImportMeshAsync } from "@babylonjs/core/Loading/sceneLoader.js";
import { Scene } from "@babylonjs/core/scene.js";
import "@babylonjs/loaders/glTF/2.0/index.js";
import { AnimationMixer, LoopOnce } from "three";

import { glbOf } from "../glb.js";
import { madeFixture, mocap, subfolder } from "../mocap.js";
import { load } from "./three.js";
import { messagesAbout } from "./validator.js";

/** The weights of each fixture's first animation at a time in seconds, from its definition in fixtures/README.md. */
const FILES = {
  "arm_and_face.gltf": (seconds) => [seconds],
  "face_alone.gltf": (seconds) => [seconds, seconds < 0.5 ? 1 - 1.5 * seconds : 0.5 * (1 - seconds)],
};
/** The change of the file, and the source's time for a time of the output, in seconds. */
const CHANGES = {
  convert: { args: ["convert"], source: (seconds) => seconds },
  trim: { args: ["convert", "--trim", "0.2s..1s"], source: (seconds) => seconds + 0.2 },
  resample: { args: ["convert", "--fps", "50"], source: (seconds) => seconds },
  retime: { args: ["convert", "--retime", "60"], source: (seconds) => 2 * seconds },
  reverse: { args: ["edit", "--step", "reverse"], source: (seconds) => 1 - seconds },
  warp: { args: ["edit", "--step", "warp:speed=0.5"], source: (seconds) => seconds / 2 },
};
/**
 * The compared times of the output in seconds: before the end of every changed file, and not at a bend between two
 * frames.
 */
const SECONDS = [0, 0.1, 0.25, 0.3, 0.4];
/** The error of single precision in times and weights. */
const ALLOWED = 1e-4;

/** Hints and information messages are about kept items and about missing parts of the fixtures. */
const isSerious = (message) => /^(error|warning)/i.test(message);

/** Converts a `.gltf` file with one embedded buffer to `.glb`, which keeps the buffer in a chunk. */
function writePacked(input, output) {
  const json = JSON.parse(readFileSync(input, "utf8"));
  const [buffer] = json.buffers;
  const bin = Buffer.from(buffer.uri.slice(buffer.uri.indexOf(",") + 1), "base64");
  delete buffer.uri;
  writeFileSync(output, glbOf(json, bin));
  return output;
}

async function inThree(path) {
  const { gltf } = await load(path);
  const mixer = new AnimationMixer(gltf.scene);
  mixer.clipAction(gltf.animations[0]).setLoop(LoopOnce, 1).play();
  const meshes = [];
  gltf.scene.traverse((object) => object.morphTargetInfluences && meshes.push(object));
  return (seconds) => {
    mixer.setTime(seconds);
    return [...meshes[0].morphTargetInfluences];
  };
}

async function inBabylon(path, engine) {
  const scene = new Scene(engine);
  const data = `data:model/gltf-binary;base64,${readFileSync(path).toString("base64")}`;
  const { meshes, animationGroups } = await ImportMeshAsync(data, scene, { pluginExtension: ".glb" });
  const targets = meshes.find((mesh) => mesh.morphTargetManager).morphTargetManager;
  animationGroups.forEach((group) => group.stop());
  animationGroups[0].start(false);
  return (seconds) => {
    const [{ animation }] = animationGroups[0].targetedAnimations;
    animationGroups[0].goToFrame(seconds * animation.framePerSecond);
    return Array.from({ length: targets.numTargets }, (_, index) => targets.getTarget(index).influence);
  };
}

export async function run(results, folder) {
  const outputs = subfolder(folder, "faces");
  const engine = new NullEngine();
  let worst = 0;
  for (const [file, weightsAt] of Object.entries(FILES)) {
    const input = writePacked(madeFixture(file), join(outputs, file.replace(".gltf", ".glb")));
    for (const [change, { args, source }] of Object.entries(CHANGES)) {
      const name = `${file}, ${change}`;
      await results.guard(name, async () => {
        const output = join(outputs, `${file.replace(".gltf", "")}_${change}.glb`);
        const [command, ...options] = args;
        mocap(command, input, "-o", output, "--clip", "0", ...options);
        const messages = (await messagesAbout(output, "default")).filter(isSerious);
        results.check(messages.length === 0, `${name}: ${messages.slice(0, 3).join("\n    ")}`);
        const clients = { "three.js": await inThree(output), Babylon: await inBabylon(output, engine) };
        for (const [client, playedAt] of Object.entries(clients)) {
          for (const seconds of SECONDS) {
            const [played, expected] = [playedAt(seconds), weightsAt(source(seconds))];
            const off = Math.max(...expected.map((weight, target) => Math.abs(weight - played[target])));
            results.check(off <= ALLOWED, `${name}, ${seconds} s: ${client} has ${played}, not ${expected}`);
            if (!(off <= worst)) worst = off;
          }
        }
      });
    }
  }
  engine.dispose();
  results.note(`weights of morph targets at most ${worst.toExponential(1)} off in three.js and Babylon`);
}
