// Checks characters with motions of `mocap retarget`: the Khronos validator finds only errors and warnings that the
// character had before. CHARACTERS names a folder of more characters.

import { readdirSync } from "node:fs";
import { basename, extname, join } from "node:path";

import { mocap, realFixture, skeletonFixture, subfolder } from "../mocap.js";
import { messagesAbout } from "./validator.js";

/** The skeletons of the fixtures, which have no meshes. */
const SKELETONS = ["human_apose", "human_cmu", "human_default", "human_game_engine", "human_vrm0", "human_vrm1"];

function characters() {
  const folder = process.env.CHARACTERS;
  const isCharacter = (name) => [".glb", ".gltf", ".vrm"].includes(extname(name));
  const more = folder === undefined ? [] : readdirSync(folder).filter(isCharacter).map((name) => join(folder, name));
  return [...SKELETONS.map((name) => skeletonFixture(`${name}.gltf`)), ...more];
}

/** The number of each error and warning of the validator, without its position in the file. */
async function complaintsAbout(path) {
  const counts = new Map();
  for (const message of await messagesAbout(path, "characters")) {
    const [severity, code] = message.split(" ");
    if (severity === "error" || severity === "warning") counts.set(`${severity} ${code}`, (counts.get(`${severity} ${code}`) ?? 0) + 1);
  }
  return counts;
}

export async function run(results, folder, sample) {
  const outputs = subfolder(folder, "characters");
  const inputs = sample.some(characters(), 2);
  for (const character of inputs) {
    const name = basename(character);
    await results.guard(name, async () => {
      const output = join(outputs, name);
      mocap("retarget", realFixture("cmu_short.bvh"), realFixture("cmu_12_01_walk.bvh"), character, "-o", output);
      const before = await complaintsAbout(character);
      for (const [complaint, count] of await complaintsAbout(output)) {
        results.check(count <= (before.get(complaint) ?? 0), `${name}: ${count} times ${complaint}`);
      }
      results.check(true, name);
    });
  }
  results.note(`${inputs.length} characters`);
}
