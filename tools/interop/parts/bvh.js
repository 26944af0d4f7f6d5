// Checks BVH files of mocap in three.js: every joint is at its position in the source, as `mocap pose` prints it.

import { readFileSync } from "node:fs";

import { AnimationMixer, LoopOnce, Vector3 } from "three";
import { BVHLoader } from "three/addons/loaders/BVHLoader.js";

import { jointsOf, nameOf, placesBelow, writeBvhs } from "../bvhs.js";
import { largestDistance, millimetres, ticksOf, toleranceFor } from "../compare.js";

/** three.js adds position channels to the OFFSET. In the format and in mocap, they replace the OFFSET. */
const addsOffset = ({ hasOffset, hasPositions }) => hasOffset && hasPositions;

function load(path) {
  const { skeleton, clip } = new BVHLoader().parse(readFileSync(path, "utf8"));
  const mixer = new AnimationMixer(skeleton.bones[0]);
  const action = mixer.clipAction(clip).setLoop(LoopOnce, 1);
  action.clampWhenFinished = true;
  action.play();
  return (seconds) => {
    mixer.setTime(seconds);
    skeleton.bones[0].updateMatrixWorld(true);
    return skeleton.bones.map((bone) => bone.getWorldPosition(new Vector3()).toArray());
  };
}

export async function run(results, folder, sample) {
  let worst = { distance: 0, file: "none" };
  let compared = 0;
  let added = 0;
  for (const file of writeBvhs(folder, sample)) {
    await results.guard(nameOf(file), () => {
      const { joints, frames, frameTime } = jointsOf(file.output);
      if (joints.some(addsOffset)) {
        added += 1;
        return;
      }
      compared += 1;
      const placesAt = load(file.output);
      for (const tick of ticksOf(frames)) {
        const places = placesAt(tick * frameTime);
        const expected = placesBelow(file.input, tick, joints);
        const tolerance = toleranceFor(expected);
        const distance = largestDistance(places, expected);
        results.check(distance <= tolerance, `${nameOf(file)}, tick ${tick}: ${millimetres(distance)} off`);
        if (distance / tolerance > worst.distance) worst = { distance: distance / tolerance, file: nameOf(file) };
      }
    });
  }
  results.note(`three.js reads ${compared} of them, at most ${(100 * worst.distance).toFixed(1)} % of the tolerance off, in ${worst.file}`);
  results.note(`${added} more, all from BVH, have an OFFSET and a position on one joint, which three.js adds`);
}
