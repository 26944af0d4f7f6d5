// The work of every host: reads a walk and poses it, with the package and with its loader for three.js.

import { AnimationMixer, Vector3 } from "three";
import { load } from "mocap-wasm";
import { MocapLoader } from "mocap-wasm/three";

/** The position of a joint at a frame of the file, from both. */
export async function play(bytes, joint, frame) {
  const mocap = await load();
  const scene = mocap.read(bytes, "walk.bvh");
  const node = scene.nodes.findIndex(({ name }) => name === joint);
  const posed = Array.from(scene.pose(frame).nodeToWorld.slice(16 * node + 12, 16 * node + 15));
  const { ticksPerSecond, frameCount } = scene.animations[0];
  scene.free();
  const { skeleton, clip } = (await new MocapLoader().init()).parse(bytes, "walk.bvh");
  const mixer = new AnimationMixer(skeleton.bones[0]);
  mixer.clipAction(clip).play();
  mixer.setTime(frame / ticksPerSecond);
  skeleton.bones[0].updateMatrixWorld(true);
  const bone = skeleton.bones.find(({ name }) => name === joint);
  return { frameCount, posed, mixed: bone.getWorldPosition(new Vector3()).toArray() };
}
