// Checks the default file of every fixture in Node, with three.js' GLTFLoader and AnimationMixer.

import { readFileSync } from "node:fs";
import { basename, join } from "node:path";

import { AnimationMixer, Box3, LoopOnce, SkeletonHelper, Vector3, REVISION } from "three";
import { BVHLoader } from "three/addons/loaders/BVHLoader.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";

import { largestDistance, millimetres, stepsOf, ticksOf, toleranceFor } from "../compare.js";
import { describe } from "../glb.js";
import { convert, fixtures, outputName, pose, subfolder } from "../mocap.js";

/**
 * The allowed excess of the skinned mesh's box over the figure's size, as a fraction: the radius of a knob is 0.18 of
 * its link's length.
 */
const THICKNESS = 0.2;
/** Half the size of the octahedron that replaces a figure without extent, in metres. */
const MARKER_RADIUS = 0.0101;

/**
 * The real files that three.js reads as mocap does. three.js always adds the OFFSET to position channels, and does not
 * know some dialects; in these files, neither matters.
 */
const READ_ALIKE = new Set([
  "additive_root_pose.bvh",
  "additive_root_walk.bvh",
  "blender_two_joints.bvh",
  "cmu_01_01.bvh",
  "cmu_12_01_walk.bvh",
  "cmu_mixed_rotation_orders.bvh",
  "cmu_salsa_poser_names.bvh",
  "cmu_short.bvh",
  "hip_knee_ankle_names.bvh",
  "kinect_openni.bvh",
  "lecture_Test.bvh",
  "slimevr_headset_root.bvh",
  "z_up_dab.bvh",
  "zero_offsets.bvh",
]);

/** A file loaded by three.js: the objects of its nodes, and a function that poses them at a time. */
export async function load(path) {
  const bytes = readFileSync(path);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const gltf = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).parseAsync(buffer, "");
  const objectOfNode = new Map();
  gltf.scene.traverse((object) => {
    const node = gltf.parser.associations.get(object)?.nodes;
    if (node !== undefined && !objectOfNode.has(node)) objectOfNode.set(node, object);
  });
  const mixer = new AnimationMixer(gltf.scene);
  for (const clip of gltf.animations) {
    const action = mixer.clipAction(clip).setLoop(LoopOnce, 1);
    action.clampWhenFinished = true;
    action.play();
  }
  const showTime = (seconds) => {
    mixer.setTime(seconds);
    gltf.scene.updateMatrixWorld(true);
  };
  return { gltf, objectOfNode, showTime };
}

/** The world positions of objects. */
export function placesOf(objects) {
  return objects.map((object) => object.getWorldPosition(new Vector3()).toArray());
}

/** The joints of a BVH file loaded by three.js, in the order of the file, and a function that poses them at a time. */
export function loadBvh(path) {
  const { skeleton, clip } = new BVHLoader().parse(readFileSync(path, "utf8"));
  const [root] = skeleton.bones;
  const mixer = new AnimationMixer(root);
  const action = mixer.clipAction(clip).setLoop(LoopOnce, 1);
  action.clampWhenFinished = true;
  action.play();
  const showTime = (seconds) => {
    mixer.setTime(seconds);
    root.updateMatrixWorld(true);
  };
  return { joints: skeleton.bones.filter((bone) => bone.name !== "ENDSITE"), showTime };
}

/** Whether the skinned mesh follows its joints: its box contains the joints' box, and is hardly larger. */
function meshFollows(scene) {
  const meshBox = new Box3();
  const joints = new Set();
  scene.traverse((object) => {
    if (!object.isSkinnedMesh) return;
    object.computeBoundingBox();
    meshBox.union(object.boundingBox.clone().applyMatrix4(object.matrixWorld));
    const { skinIndex } = object.geometry.attributes;
    for (let vertex = 0; vertex < skinIndex.count; vertex += 1) joints.add(object.skeleton.bones[skinIndex.getX(vertex)]);
  });
  const jointBox = new Box3();
  for (const place of placesOf([...joints])) jointBox.expandByPoint(new Vector3(...place));
  const size = jointBox.getSize(new Vector3()).length();
  const slack = 0.001 * size;
  return (
    meshBox.clone().expandByScalar(slack).containsBox(jointBox) &&
    jointBox.expandByScalar(Math.max(slack + THICKNESS * size, MARKER_RADIUS)).containsBox(meshBox)
  );
}

async function checkFile(results, input, output) {
  const name = basename(input);
  const { json, nodes, frames, frameTime, provenance } = describe(output);
  const { gltf, objectOfNode, showTime } = await load(output);
  const objects = nodes.map((node) => objectOfNode.get(node.index));
  if (!results.check(objects.every(Boolean), `${name}: a node is missing`)) return 0;

  const bones = objects.filter((object) => object.isBone);
  const joints = nodes.filter((node) => node.isJoint);
  results.check(joints.length > 0 && bones.length === joints.length, `${name}: ${bones.length} bones for ${joints.length} joints`);
  const moved = new Set((json.animations ?? []).flatMap(({ channels }) => channels.map(({ target }) => target.node)));
  const stray = nodes.filter((node) => !node.isJoint && (moved.has(node.index) || node.extras?.end_site));
  results.check(stray.length === 0, `${name}: moves and is no joint: ${stray.map((node) => node.name).join(", ")}`);
  const helper = new SkeletonHelper(gltf.scene);
  results.check(helper.bones.length === joints.length, `${name}: SkeletonHelper has ${helper.bones.length} bones`);
  const hasLinks = bones.some((bone) => bone.parent.isBone);
  results.check(!hasLinks || helper.geometry.attributes.position.count > 0, `${name}: SkeletonHelper is empty`);
  const names = new Set(objects.map((object) => object.name));
  results.check(names.size === nodes.length, `${name}: names are equal once three.js has cleaned them`);
  results.check(gltf.animations.length === (json.animations ?? []).length, `${name}: an animation is missing`);

  const { sourceTick, change } = stepsOf(provenance);
  const bvh = READ_ALIKE.has(name) ? loadBvh(input) : undefined;
  let worst = 0;
  for (const tick of ticksOf(Math.max(frames, 1))) {
    showTime(tick * frameTime);
    const places = placesOf(objects);
    const own = pose(output, tick);
    const named = own.every((node, index) => node.name === nodes[index].sourceName);
    results.check(named, `${name}: mocap reads other names from its own file`);
    const tolerance = toleranceFor(places);
    const compare = (what, found, expected) => {
      const distance = largestDistance(found, expected);
      results.check(distance <= tolerance, `${name}, tick ${tick}: ${millimetres(distance)} from ${what}`);
      if (tolerance < 0.00011 && distance > worst) worst = distance;
    };
    const ofSource = pose(input, sourceTick(tick)).map((node) => change(node.translation));
    compare("mocap's pose of the file", places, own.map((node) => node.translation));
    compare("mocap's pose of the source", places, ofSource);
    if (bvh) {
      bvh.showTime(sourceTick(tick) * provenance.source.frame_time);
      const withChannels = places.filter((_, index) => !nodes[index].extras?.end_site);
      compare("what three.js makes of the source", withChannels, placesOf(bvh.joints).map(change));
    }
    // The meshes of an FBX file come from the file, and need not be around its joints: `src/formats/tests/it/fbx.rs`
    // compares their vertices.
    const isOwn = name.endsWith(".fbx");
    results.check(isOwn || meshFollows(gltf.scene), `${name}, tick ${tick}: the mesh is not where the joints are`);
  }
  return worst;
}

export async function run(results, folder, sample) {
  const outputs = subfolder(folder, "three");
  let worst = { distance: 0, file: "none" };
  for (const input of sample.some([...fixtures("real"), ...fixtures("dialects")], 2)) {
    await results.guard(basename(input), async () => {
      const output = convert(input, join(outputs, outputName(input, ".glb")));
      const distance = await checkFile(results, input, output);
      if (distance > worst.distance) worst = { distance, file: basename(input) };
    });
  }
  results.note(`three.js r${REVISION}: figures of human size at most ${millimetres(worst.distance)} off, in ${worst.file}`);
}
