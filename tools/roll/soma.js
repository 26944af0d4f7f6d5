// A motion with known rotations, which are the identity in the T-pose, as the truth for roll.

import { fileURLToPath } from "node:url";

import { writeBvh } from "./bvh.js";
import { fromColumns, inverse, rotate, sub } from "./math.js";
import { readNpz } from "./npz.js";

/** The 30 joints of SOMA's skeleton with their parents, from nv-tlabs/kimodo. */
const JOINTS =
  "Hips Spine1 Spine2 Chest Neck1 Neck2 Head Jaw LeftEye RightEye LeftShoulder LeftArm LeftForeArm LeftHand LeftHandThumbEnd LeftHandMiddleEnd RightShoulder RightArm RightForeArm RightHand RightHandThumbEnd RightHandMiddleEnd LeftLeg LeftShin LeftFoot LeftToeBase RightLeg RightShin RightFoot RightToeBase".split(" ");
const PARENTS = [-1, 0, 1, 2, 3, 4, 5, 6, 6, 6, 3, 10, 11, 12, 13, 13, 3, 16, 17, 18, 19, 19, 0, 22, 23, 24, 0, 26, 27, 28];

/** The joints of the bones that every skeleton has. */
const BONES = {
  hips: 0,
  head: JOINTS.indexOf("Head"),
  ...Object.fromEntries(
    ["Left", "Right"].flatMap((side) =>
      Object.entries({ UpperArm: "Arm", LowerArm: "ForeArm", Hand: "Hand", UpperLeg: "Leg", LowerLeg: "Shin", Foot: "Foot" }).map(([bone, name]) => [
        side.toLowerCase() + bone,
        JOINTS.indexOf(side + name),
      ]),
    ),
  ),
};

/** The clip as BVH: unchanged, with OFFSETs along +X, with random joint frames, and cuts of these files. */
export function* soma(turnedAtRandom, alongX) {
  const path = fileURLToPath(new URL("../../fixtures/arrays/kimodo_soma_01.npz", import.meta.url));
  const { posed_joints: joints, global_rot_mats: matrices } = readNpz(path);
  const [frames, count] = joints.shape;
  const seconds = 1 / 30;
  const poses = Array.from({ length: frames }, (_, frame) => ({
    places: Array.from({ length: count }, (_, joint) => [...joints.data.subarray(3 * (frame * count + joint), 3 * (frame * count + joint) + 3)].map((value) => 100 * value)),
    rotations: Array.from({ length: count }, (_, joint) => {
      const m = matrices.data.subarray(9 * (frame * count + joint), 9 * (frame * count + joint) + 9);
      return fromColumns([m[0], m[3], m[6]], [m[1], m[4], m[7]], [m[2], m[5], m[8]]);
    }),
  }));
  const first = poses[0];
  const offsets = PARENTS.map((parent, joint) => (parent < 0 ? first.places[joint] : rotate(inverse(first.rotations[parent]), sub(first.places[joint], first.places[parent]))));
  const skeleton = JOINTS.map((name, joint) => ({ name, parent: PARENTS[joint], offset: offsets[joint], channels: [], isEnd: false }));
  const motion = { joints: skeleton, seconds, poses };
  const half = Math.floor(frames / 2);
  for (const [cut, from, to] of [["whole", 0, frames], ["first half", 0, half], ["second half", half, frames]]) {
    const part = { ...motion, poses: poses.slice(from, to) };
    yield { label: `soma ${cut}`, text: writeBvh(skeleton, seconds, part.poses), poses: part.poses, seconds, bones: BONES };
    yield { label: `soma ${cut}, along +X`, text: alongX(part, 3), poses: part.poses, seconds, bones: BONES };
    for (const seed of [1, 2]) {
      yield { label: `soma ${cut}, frames at random ${seed}`, text: turnedAtRandom(part, seed), poses: part.poses, seconds, bones: BONES };
    }
  }
}
