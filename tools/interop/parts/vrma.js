// Checks VRM animations of mocap: three-vrm poses a VRM character with them. The poses must equal the source's motion,
// which three.js' BVHLoader reads. With `--all`, the crate vrm-runtime and, if installed, Blender's VRM add-on pose the
// character too.

import { readFileSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";

import { VRMLoaderPlugin, VRMUtils } from "@pixiv/three-vrm";
import { VRMAnimationLoaderPlugin, createVRMAnimationClip } from "@pixiv/three-vrm-animation";
import { AnimationMixer, LoopOnce, Matrix4, Quaternion, Vector3 } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

import { stepsOf, ticksOf } from "../compare.js";
import { glbOf, readGlb } from "../glb.js";
import { convert, mocap, outputName, realFixture, skeletonFixture, subfolder } from "../mocap.js";
import { buildVrmRuntime, canBlender, posesInBlender } from "../vrm.js";
import { messagesAbout } from "./validator.js";
import { loadBvh } from "./three.js";

/** The largest error of a bone in degrees. */
const TOLERANCE = 0.1;
/** The largest error of the hips in metres. */
const SAME_PLACE = 0.0002;

/**
 * BVH files of humanoids that three.js reads as mocap does. In some, three.js adds the root's OFFSET to its position.
 */
const WITH_OFFSET = ["accad_run_turn.bvh", "bvhtoolbox_walk01.bvh", "vicon_sword_attack.bvh"].map(skeletonFixture);
const SOURCES = [
  realFixture("cmu_short.bvh"),
  realFixture("cmu_12_01_walk.bvh"),
  realFixture("cmu_salsa_poser_names.bvh"),
  realFixture("hip_knee_ankle_names.bvh"),
  realFixture("z_up_dab.bvh"),
  ...WITH_OFFSET,
];

/** Limbs and their directions in the T-pose: bone, end, direction. */
const LIMBS = ["left", "right"].flatMap((side) => {
  const outwards = new Vector3(side === "left" ? 1 : -1, 0, 0);
  const down = new Vector3(0, -1, 0);
  return [
    [`${side}UpperArm`, `${side}LowerArm`, outwards],
    [`${side}LowerArm`, `${side}Hand`, outwards],
    [`${side}UpperLeg`, `${side}LowerLeg`, down],
    [`${side}LowerLeg`, `${side}Foot`, down],
  ];
});

/** A VRM 1.0 character: the skeleton of a fixture, with its known humanoid bones. */
function writeCharacter(path) {
  const name = "human_vrm1.gltf";
  const json = JSON.parse(readFileSync(skeletonFixture(name), "utf8"));
  const { map } = JSON.parse(readFileSync(skeletonFixture("truth.json"), "utf8")).files[`skeletons/${name}`];
  const node = (joint) => ({ node: json.nodes.findIndex((node) => node.name === joint) });
  json.extensionsUsed = ["VRMC_vrm"];
  json.extensions = {
    VRMC_vrm: {
      specVersion: "1.0",
      meta: { name, authors: ["mocap"], licenseUrl: "https://vrm.dev/licenses/1.0/" },
      humanoid: { humanBones: Object.fromEntries(Object.entries(map).map(([bone, joint]) => [bone, node(joint)])) },
    },
  };
  writeFileSync(path, glbOf(json, Buffer.alloc(0)));
  return path;
}

async function parse(path, plugin) {
  const bytes = readFileSync(path);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const loader = new GLTFLoader();
  loader.register(plugin);
  return await loader.parseAsync(buffer, "");
}

/**
 * The character's poses in three-vrm: at each time, the rotation of each bone relative to the T-pose, and the position
 * of the hips.
 */
async function posesInThree(character, animation, times) {
  const { vrm } = (await parse(character, (parser) => new VRMLoaderPlugin(parser))).userData;
  VRMUtils.rotateVRM0(vrm);
  const [vrmAnimation] = (await parse(animation, (parser) => new VRMAnimationLoaderPlugin(parser))).userData.vrmAnimations;
  vrm.scene.updateMatrixWorld(true);
  const bones = Object.entries(vrm.humanoid.humanBones).map(([bone, { node }]) => [bone, node]);
  const turn = (node) => node.getWorldQuaternion(new Quaternion());
  const rest = new Map(bones.map(([bone, node]) => [bone, turn(node).invert()]));
  const [restHips, animationHips] = [vrm.humanoid.normalizedRestPose.hips.position[1], vrmAnimation.restHipsPosition.y];
  const mixer = new AnimationMixer(vrm.scene);
  const action = mixer.clipAction(createVRMAnimationClip(vrmAnimation, vrm)).setLoop(LoopOnce, 1);
  action.clampWhenFinished = true;
  action.play();
  return times.map((seconds) => {
    mixer.setTime(seconds);
    vrm.update(0);
    vrm.scene.updateMatrixWorld(true);
    const hips = vrm.humanoid.getRawBoneNode("hips").getWorldPosition(new Vector3());
    return {
      turns: new Map(bones.map(([bone, node]) => [bone, turn(node).multiply(rest.get(bone))])),
      hips: hips.multiplyScalar(animationHips / restHips),
    };
  });
}

/** The source's poses: at each tick, the rotation and the position of each bone in the axes of the file. */
function posesInSource(input, output, ticks) {
  const provenance = readGlb(output).json.asset.extras.mocap;
  const { sourceTick, change } = stepsOf(provenance);
  const { joints, showTime } = loadBvh(input);
  const { bones } = JSON.parse(mocap("skeleton", input, "--json")).humanoid;
  const origin = new Vector3(...change([0, 0, 0]));
  const columns = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => new Vector3(...change(axis)).sub(origin).normalize());
  const axes = new Quaternion().setFromRotationMatrix(new Matrix4().makeBasis(...columns));
  const found = Object.entries(bones).map(([bone, { joint }]) => [bone, joints.find(({ name }) => name === joint)]);
  return ticks.map((tick) => {
    showTime(sourceTick(tick) * provenance.source.frame_time);
    const turn = (joint) => axes.clone().multiply(joint.getWorldQuaternion(new Quaternion()));
    const place = (joint) => new Vector3(...change(joint.getWorldPosition(new Vector3()).toArray()));
    return new Map(found.filter(([, joint]) => joint).map(([bone, joint]) => [bone, { turn: turn(joint), place: place(joint) }]));
  });
}

const degrees = (angle) => (angle * 180) / Math.PI;
/**
 * Angles in degrees between two directions and between two rotations. They use sines, because cosines are too coarse
 * for small angles.
 */
const betweenWays = (a, b) => degrees(Math.atan2(a.clone().cross(b).length(), a.dot(b)));
const betweenTurns = (a, b) => {
  const { x, y, z, w } = a.clone().multiply(b.clone().invert());
  return degrees(2 * Math.atan2(Math.hypot(x, y, z), Math.abs(w)));
};

/** Compares a reader's poses with the source's poses; returns the largest angle in degrees. */
function compare(results, name, ticks, poses, expected, hasHips) {
  let worst = 0;
  const check = (tick, what, angle) => {
    results.check(angle <= TOLERANCE, `${name}, tick ${tick}: ${what} has an error of ${angle.toFixed(3)} degrees`);
    if (!(angle <= worst)) worst = angle;
  };
  ticks.forEach((tick, index) => {
    const [pose, source] = [poses[index], expected[index]];
    for (const [bone, end, direction] of LIMBS) {
      if (!pose.turns.has(bone) || !source.has(bone) || !source.has(end)) continue;
      const way = source.get(end).place.clone().sub(source.get(bone).place);
      if (way.length() < 1e-4) continue;
      check(tick, `the direction of ${bone}`, betweenWays(direction.clone().applyQuaternion(pose.turns.get(bone)), way));
    }
    for (const [bone, { turn }] of source) {
      if (!pose.turns.has(bone)) continue;
      const since = (now, first) => now.clone().multiply(first.clone().invert());
      const ours = since(pose.turns.get(bone), poses[0].turns.get(bone));
      check(tick, `the turn of ${bone}`, betweenTurns(ours, since(turn, expected[0].get(bone).turn)));
    }
    if (hasHips && pose.hips) {
      const off = pose.hips.distanceTo(source.get("hips").place);
      results.check(off <= SAME_PLACE, `${name}, tick ${tick}: the hips are ${(1000 * off).toFixed(2)} mm off`);
    }
  });
  return worst;
}

export async function run(results, folder, sample) {
  const outputs = subfolder(folder, "vrma");
  const character = writeCharacter(join(outputs, "character.vrm"));
  const readers = [{ reader: "three-vrm", poses: posesInThree, isStraight: true }];
  if (sample.isAll) readers.push({ reader: "vrm-runtime", poses: buildVrmRuntime(), isStraight: true });
  // Between frames, Blender interpolates from key to key along a curve.
  if (sample.isAll && canBlender()) readers.push({ reader: "Blender", poses: posesInBlender, isStraight: false });
  const worst = new Map(readers.map(({ reader }) => [reader, 0]));
  const forms = [[], ["--max-error", "0.02mm", "--compress", "none"], ["--trim", "5f..50f"]];
  for (const [place, input] of sample.some(SOURCES, 2).entries()) {
    const options = forms[place % forms.length];
    const name = [basename(input), ...options].join(" ");
    await results.guard(name, async () => {
      const output = convert(input, join(outputs, outputName(input, ".vrma")), ...options);
      const messages = await messagesAbout(output, "vrma");
      results.check(messages.length === 0, `${name}: ${messages.slice(0, 3).join("\n    ")}`);
      const { frames, frame_time: frameTime } = readGlb(output).json.asset.extras.mocap;
      for (const { reader, poses, isStraight } of readers) {
        const ticks = ticksOf(frames).filter((tick) => isStraight || Number.isInteger(tick));
        const expected = posesInSource(input, output, ticks);
        const times = ticks.map((tick) => tick * frameTime);
        const found = await poses(character, output, times, 1 / frameTime);
        const angle = compare(results, `${name}, ${reader}`, ticks, found, expected, !WITH_OFFSET.includes(input));
        worst.set(reader, Math.max(worst.get(reader), angle));
      }
    });
  }
  for (const [reader, angle] of worst) results.note(`${reader}: largest error of a bone ${angle.toFixed(3)} degrees`);
}
