// Writes a motion in the style of another program: with other names, joint frames, axes, size, proportions and parts.
// The movement of the body stays the same, so that the judge knows the right result.

import { restOf } from "./bvh.js";
import { aboutAxis, add, inverse, multiply, random, rotate, scale } from "./math.js";
import { AXES, upright } from "./measure.js";
import { alongAxes, alongX, restingAt, turnedAtRandom, withoutTPose } from "./rewrite.js";

/** Names of bones in other programs: first the trunk's names, then the names of a side, in which `S` means the side. */
export const NAMES = {
  biped: [["Pelvis", "Spine", "Spine1", "Spine2", "Neck", "Head"], ["Clavicle", "UpperArm", "Forearm", "Hand", "Thigh", "Calf", "Foot", "Toe0"], (name, side) => (side ? `Bip01 ${side[0].toUpperCase()} ${name}` : `Bip01 ${name}`)],
  mixamo: [["Hips", "Spine", "Spine1", "Spine2", "Neck", "Head"], ["Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase"], (name, side) => `mixamorig:${side === "left" ? "Left" : side ? "Right" : ""}${name}`],
  unreal: [["pelvis", "spine_01", "spine_02", "spine_03", "neck_01", "head"], ["clavicle", "upperarm", "lowerarm", "hand", "thigh", "calf", "foot", "ball"], (name, side) => (side ? `${name}_${side[0]}` : name)],
  xsens: [["Pelvis", "L5", "L3", "T8", "Neck", "Head"], ["Shoulder", "UpperArm", "ForeArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toe"], (name, side) => `${side === "left" ? "Left" : side ? "Right" : ""}${name}`],
  smpl: [["Pelvis", "Spine1", "Spine2", "Spine3", "Neck", "Head"], ["Collar", "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle", "Foot"], (name, side) => (side ? `${side[0].toUpperCase()}_${name}` : name)],
  daz: [["hip", "abdomen", "chest", "chest2", "neck", "head"], ["Collar", "Shldr", "ForeArm", "Hand", "Thigh", "Shin", "Foot", "Toe"], (name, side) => (side ? `${side[0]}${name}` : name)],
  unity: [["Hips", "Spine", "Chest", "UpperChest", "Neck", "Head"], ["Shoulder", "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toes"], (name, side) => (side ? `${name}_${side[0].toUpperCase()}` : name)],
  soma: [["Hips", "Spine1", "Spine2", "Chest", "Neck1", "Head"], ["Shoulder", "Arm", "ForeArm", "Hand", "Leg", "Shin", "Foot", "ToeBase"], (name, side) => `${side === "left" ? "Left" : side ? "Right" : ""}${name}`],
  mmd: [["下半身", "上半身", "上半身2", "上半身3", "首", "頭"], ["肩", "腕", "ひじ", "手首", "足", "ひざ", "足首", "つま先"], (name, side) => `${side === "left" ? "左" : side ? "右" : ""}${name}`],
  rigify: [["hips", "spine", "chest", "upper_chest", "neck", "head"], ["shoulder", "upper_arm", "forearm", "hand", "thigh", "shin", "foot", "toe"], (name, side) => (side ? `${name}.${side[0].toUpperCase()}` : name)],
  anatomy: [["sacrum", "lumbar", "thoracic", "sternum", "cervical", "skull"], ["scapula", "humerus", "radius", "hand", "femur", "tibia", "talus", "toes"], (name, side) => (side ? `${name}_${side[0]}` : name)],
  numbers: [[], [], () => undefined],
};
const TRUNK = ["hips", "spine", "chest", "upperChest", "neck", "head"];
const SIDE = ["Shoulder", "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toes"];
const FINGER = /^(left|right)(Thumb|Index|Middle|Ring|Little)(\w+)$/;

/** The joints with the names of a system; joints without a name in the system get numbers. */
export function named(joints, bones, system) {
  const [trunk, sides, write] = NAMES[system];
  const nameOf = (bone) => {
    const [, side, part] = bone.match(/^(left|right)(.*)$/) ?? [undefined, undefined, bone];
    const word = side ? sides[SIDE.indexOf(part)] : trunk[TRUNK.indexOf(bone)];
    const [, , finger, phalanx] = bone.match(FINGER) ?? [];
    const digit = finger && sides.length > 0 ? `${finger}${1 + ["Metacarpal", "Proximal", "Intermediate", "Distal"].indexOf(phalanx)}` : undefined;
    return word ?? digit ? write(word ?? digit, side) : undefined;
  };
  const found = new Map(Object.entries(bones).map(([bone, joint]) => [joint, nameOf(bone)]));
  return joints.map((joint, index) => ({ ...joint, name: found.get(index) ?? `Joint_${index}` }));
}

const turn = (rotation) => ({ places, rotations }) => ({
  places: places.map((place) => rotate(rotation, place)),
  rotations: rotations.map((was) => multiply(multiply(rotation, was), inverse(rotation))),
});
const other = (bone) => bone.replace(/^(left|right)/, (side) => (side === "left" ? "right" : "left"));

/** The mirrored body: left and right are exchanged. */
function mirrored(motion) {
  const flip = ([x, y, z]) => [-x, y, z];
  return {
    ...motion,
    facing: motion.facing && flip(motion.facing),
    joints: motion.joints.map((joint) => ({ ...joint, offset: flip(joint.offset) })),
    poses: motion.poses.map(({ places, rotations }) => ({ places: places.map(flip), rotations: rotations.map(([x, y, z, w]) => [x, -y, -z, w]) })),
    bones: Object.fromEntries(Object.entries(motion.bones).map(([bone, joint]) => [other(bone), joint])),
  };
}

/** Bones with other lengths and the same directions: legs, arms and trunk each have a factor. */
function reshaped(motion, next) {
  const factors = { Leg: 0.85 + 0.3 * next(), Arm: 0.85 + 0.3 * next(), trunk: 0.85 + 0.3 * next() };
  const { joints, bones } = motion;
  const kinds = joints.map(({ parent }) => {
    const above = Object.entries(bones).find(([, joint]) => joint === parent)?.[0] ?? "";
    return /Arm$/.test(above) ? factors.Arm : /Leg$/.test(above) ? factors.Leg : /^(spine|chest|upperChest)$/.test(above) ? factors.trunk : 1;
  });
  const poses = motion.poses.map(({ places, rotations }) => {
    const moved = [];
    joints.forEach(({ parent }, index) => {
      const way = parent < 0 ? places[index] : places[index].map((value, axis) => value - places[parent][axis]);
      moved.push(parent < 0 ? way : add(moved[parent], scale(way, kinds[index])));
    });
    return { places: moved, rotations };
  });
  return { ...motion, poses, joints: joints.map((joint, index) => ({ ...joint, offset: scale(joint.offset, kinds[index]) })) };
}

const pick = (next, list) => list[Math.floor(next() * list.length)];

/**
 * A motion of a humanoid in the style of another program, by a seed: `{ motion, text, how }`. The caller may choose the
 * joint frames; otherwise the seed does.
 */
export function variant(source, seed, chosen) {
  const next = random(seed);
  const how = [];
  let motion = { ...source, rest: undefined, facing: source.rest && AXES[source.facing] };
  const part = pick(next, ["whole", "whole", "no T-pose", "part"]);
  const count = motion.poses.length;
  let [from, to] = [0, count];
  if (part === "no T-pose" && motion.bones.leftUpperArm !== undefined) [from, to] = withoutTPose(motion, motion.bones);
  if (part === "part") {
    const size = Math.min(count, Math.max(60, Math.floor(count * (0.2 + 0.5 * next()))));
    from = Math.floor(next() * (count - size));
    to = from + size;
  }
  if (to - from < 30) [from, to] = [0, count];
  if (to - from < count) how.push(`${from}..${to}`);
  motion.poses = motion.poses.slice(from, to);
  if (next() < 0.3) {
    motion = mirrored(motion);
    how.push("mirrored");
  }
  if (next() < 0.4) {
    motion = reshaped(motion, next);
    how.push("reshaped");
  }
  const up = pick(next, ["+Y", "+Y", "+Z"]);
  const heading = aboutAxis([0, 1, 0], pick(next, [0, 0, 0.5, 1, 1.5, 0.23]) * Math.PI);
  const stood = multiply(multiply(inverse(upright(up)), heading), upright(motion.up));
  const size = pick(next, [1, 1, 0.01, 0.0254, 100]);
  const changed = turn(stood);
  motion.poses = motion.poses.map((pose) => {
    const { places, rotations } = changed(pose);
    return { places: places.map((place) => scale(place, size)), rotations };
  });
  motion.joints = motion.joints.map((joint) => ({ ...joint, offset: scale(rotate(stood, joint.offset), size) }));
  motion = { ...motion, up, facing: motion.facing && rotate(stood, motion.facing) };
  how.push(`up ${up}`, `size ${size}`);
  const system = pick(next, Object.keys(NAMES));
  const names = named(motion.joints, motion.bones, system);
  motion.joints = names;
  const drawn = pick(next, ["as they are", "as they are", "+X", "+Y mirrored", "+X mirrored", "random", "of a moment"]);
  const frames = chosen ?? drawn;
  how.push(system, `frames ${frames}`);
  // With other frames, the rest pose has no information.
  if (motion.facing && frames === "as they are") motion.rest = restOf(motion);
  const write = {
    "as they are": () => alongAxes(motion, undefined),
    "+X": () => alongX(motion, seed),
    "+Y mirrored": () => alongAxes(motion, [0, 1, 0]),
    "+X mirrored": () => alongAxes(motion, [1, 0, 0]),
    random: () => turnedAtRandom(motion, seed),
    "of a moment": () => restingAt(motion, Math.floor(next() * motion.poses.length)),
  }[frames];
  return { motion, text: write(), how: how.join(", ") };
}
