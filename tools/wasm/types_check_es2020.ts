// A program without `using`, which is compiled for the library of 2020 but not run.

import { load, type Scene } from "./package/index.js";

export async function walk(bytes: Uint8Array): Promise<Uint8Array> {
  const mocap = await load();
  const scene: Scene = mocap.read(bytes, "walk.bvh");
  const glb = scene.toGlb();
  scene.free();
  return glb;
}
