// Lets the user correct the bone of a joint.

import { make } from "../../../src/render/view/dom.js";

/** The bones of a VRM humanoid. */
const HUMANOID_BONES = (
  "hips spine chest upperChest neck head leftEye rightEye jaw leftUpperLeg leftLowerLeg leftFoot leftToes " +
  "rightUpperLeg rightLowerLeg rightFoot rightToes leftShoulder leftUpperArm leftLowerArm leftHand " +
  "rightShoulder rightUpperArm rightLowerArm rightHand leftThumbMetacarpal leftThumbProximal leftThumbDistal " +
  "leftIndexProximal leftIndexIntermediate leftIndexDistal leftMiddleProximal leftMiddleIntermediate " +
  "leftMiddleDistal leftRingProximal leftRingIntermediate leftRingDistal leftLittleProximal " +
  "leftLittleIntermediate leftLittleDistal rightThumbMetacarpal rightThumbProximal rightThumbDistal " +
  "rightIndexProximal rightIndexIntermediate rightIndexDistal rightMiddleProximal rightMiddleIntermediate " +
  "rightMiddleDistal rightRingProximal rightRingIntermediate rightRingDistal rightLittleProximal " +
  "rightLittleIntermediate rightLittleDistal"
).split(" ");

/** A selection of a joint's bone. `choose` is called with the name of the bone, or nothing. */
export function boneChoice(bone, choose) {
  const options = HUMANOID_BONES.map((name) => make("option", { value: name }, name));
  const select = make("select", { id: "bone-choice", onchange: (event) => choose(event.target.value) }, make("option", { value: "" }, "no bone"), ...options);
  select.value = bone?.name ?? "";
  return make("div", { class: "choice" }, make("label", { for: "bone-choice" }, "It is"), select);
}

/** The user's bones of a file after one more choice: the joint gets the new bone instead of its previous bone. */
export function withBone(chosen, { name, bone }, wanted) {
  const bones = { ...chosen };
  if (bone) bones[bone.name] = null;
  if (wanted) bones[wanted] = name;
  return bones;
}
