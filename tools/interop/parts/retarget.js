// Judges every motion of a humanoid on every character, with locked feet, in three.js: limbs, feet in contact, the
// floor.

import { existsSync, readFileSync, readdirSync } from "node:fs";
import { basename, extname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { bonesOf, compare, sample as sampleFile } from "../feet.js";
import { mocap, outputName, subfolder } from "../mocap.js";

const FIXTURES = fileURLToPath(new URL("../../../fixtures/", import.meta.url));
/** The largest speed of feet in contact above the speed of the source's feet, in metres a second. */
const MORE_SKATE = 0.005;
/** The largest fraction of frames below the floor. */
const MOST_BELOW = 0.01;
/** The largest mean error of limbs, in degrees. */
const MOST_DEGREES = 3;
const TRUTH = JSON.parse(readFileSync(join(FIXTURES, "skeletons/truth.json"))).files;

/** Motions, each with its bones. An ASF file is the skeleton of the AMC files beside it. */
function motions() {
  const found = [];
  for (const [name, truth] of Object.entries(TRUTH)) {
    if (!truth.humanoid || basename(name).startsWith("human_")) continue;
    const file = join(FIXTURES, name);
    const takes = readdirSync(join(file, "..")).filter((take) => take.startsWith(`${basename(name, ".asf")}_`) && take.endsWith(".amc"));
    const files = extname(name) === ".asf" ? takes.map((take) => join(file, "..", take)) : [file];
    found.push(...files.map((path) => ({ path, bones: bonesOf(truth) })));
  }
  return found;
}

/** The characters with meshes: of the fixtures, or of the folder that MOCAP_CHARACTERS names. */
function characters() {
  const folder = process.env.MOCAP_CHARACTERS;
  if (!folder) {
    const names = Object.keys(TRUTH).filter((name) => basename(name).startsWith("human_"));
    return names.map((name) => ({ path: join(FIXTURES, name), bones: bonesOf(TRUTH[name]) }));
  }
  const { characters: known } = JSON.parse(readFileSync(join(folder, "humanoid.json")));
  return Object.entries(known).map(([name, truth]) => ({ path: join(folder, name), bones: bonesOf(truth) }));
}

const centimetres = (metres) => (100 * metres).toFixed(1).padStart(6);
const percent = (share) => (share === undefined ? "     -" : (100 * share).toFixed(1).padStart(6));

export async function run(results, folder, sample) {
  const outputs = subfolder(folder, "retarget");
  const targets = characters();
  const worst = { skate: 0, below: 0, soleBelow: 0, degrees: 0 };
  console.log("  motion | character | contacts | skate source, target cm/s | below floor source, target, soles % | limbs degrees");
  for (const [index, motion] of motions().entries()) {
    await results.guard(basename(motion.path), async () => {
      const converted = join(outputs, outputName(motion.path, ".glb"));
      try {
        // Omits a rest pose before the motion, as `mocap retarget` does.
        mocap("convert", motion.path, converted, "--mesh", "none", "--drop-first-frame", "auto");
      } catch (error) {
        results.note(`${basename(motion.path)}: left out: ${error.stderr?.toString().trim().split("\n")[0]}`);
        return;
      }
      const source = await sampleFile(converted, motion.bones);
      if (source.frames.length < 2) return;
      for (const target of sample.isAll ? targets : [targets[(index + sample.seed) % targets.length]]) {
        const name = `${basename(motion.path)} on ${basename(target.path)}`;
        await results.guard(name, async () => {
          const output = join(outputs, `${outputName(motion.path, "")}_${basename(target.path, extname(target.path))}.glb`);
          const isSkeleton = extname(target.path) === ".gltf";
          mocap("retarget", motion.path, isSkeleton ? "--to-skeleton" : "--character", target.path, "-o", output, "--feet", "lock", "--force");
          const { degrees, feet } = compare(source, await sampleFile(output, target.bones));
          results.check(degrees <= MOST_DEGREES, `${name}: mean limb error ${degrees.toFixed(2)} degrees`);
          worst.degrees = Math.max(worst.degrees, degrees);
          if (!feet) return;
          const { contacts, skateBefore, skate, belowBefore, below, soleBelow } = feet;
          console.log(
            `  ${basename(motion.path).padEnd(38)} ${basename(target.path).padEnd(22)} ${String(contacts).padStart(6)} ${centimetres(skateBefore)} ${centimetres(skate)} ${percent(belowBefore)} ${percent(below)} ${percent(soleBelow)} ${degrees.toFixed(2).padStart(6)}`,
          );
          results.check(skate <= skateBefore + MORE_SKATE, `${name}: feet in contact slide ${centimetres(skate)} cm/s, ${centimetres(skateBefore)} in the source`);
          results.check(below <= MOST_BELOW, `${name}: ${percent(below)} % of frames are below the floor`);
          results.check((soleBelow ?? 0) <= MOST_BELOW, `${name}: the soles are below the floor in ${percent(soleBelow)} % of frames`);
          worst.skate = Math.max(worst.skate, skate - skateBefore);
          worst.below = Math.max(worst.below, below);
          worst.soleBelow = Math.max(worst.soleBelow, soleBelow ?? 0);
        });
      }
    });
  }
  results.note(
    `worst: ${centimetres(worst.skate)} cm/s more than the source, ${percent(worst.below)} % of frames below the floor, ${percent(worst.soleBelow)} % with soles below it, mean limb error ${worst.degrees.toFixed(2)} degrees`,
  );
}
