// A loader for three.js with the result of its BVHLoader: `{ skeleton, clip }`. The types are in three.d.ts.

import {
  AnimationClip,
  Bone,
  FileLoader,
  Loader,
  LoaderUtils,
  PropertyBinding,
  QuaternionKeyframeTrack,
  Skeleton,
  VectorKeyframeTrack,
} from "three";
import { load } from "./index.js";

let ready;

export class MocapLoader extends Loader {
  animateBonePositions = true;
  animateBoneRotations = true;
  /** Options of Scene.convert(); `{}` for metres with +Y up. With null, lengths are in the file's unit, as in BVHLoader. */
  convert = null;
  #mocap;

  constructor(manager, mocap) {
    super(manager);
    this.#mocap = mocap;
  }

  /** Loads the module. Call it before parse(). */
  async init() {
    this.#mocap ??= await (ready ??= load());
    return this;
  }

  load(url, onLoad, onProgress, onError) {
    const failed = (error) => {
      if (onError) onError(error);
      else console.error(error);
      this.manager.itemError(url);
    };
    const loader = new FileLoader(this.manager);
    loader.setPath(this.path);
    loader.setResponseType("arraybuffer");
    loader.setRequestHeader(this.requestHeader);
    loader.setWithCredentials(this.withCredentials);
    const parse = async (bytes) => {
      await this.init();
      return this.parse(bytes, LoaderUtils.extractUrlBase(url) === "./" ? url : url.split("/").pop());
    };
    loader.load(url, (bytes) => parse(bytes).then(onLoad).catch(failed), onProgress, onError);
  }

  parse(data, name = "motion.bvh") {
    if (!this.#mocap) throw new Error("MocapLoader: await init() before parse()");
    const read = this.#mocap.read(data, name, { skeletonMesh: "none", hash: false });
    const converted = this.convert ? read.convert(this.convert) : read;
    try {
      return { skeleton: skeletonOf(converted), clip: this.#clip(converted), warnings: read.warnings };
    } finally {
      read.free();
      converted.free();
    }
  }

  #clip(scene) {
    const [animation] = scene.animations;
    if (!animation) return new AnimationClip("animation", 0, []);
    const { ticksPerSecond, channels } = animation;
    const names = boneNames(scene.nodes);
    const every = new Map();
    // Tracks with a key for every tick share their times.
    const times = (keys) => {
      if (!keys.isEveryTick) return Float32Array.from(keys.ticks, (tick) => tick / ticksPerSecond);
      const known = every.get(keys.length) ?? Float32Array.from({ length: keys.length }, (_, tick) => tick / ticksPerSecond);
      every.set(keys.length, known);
      return known;
    };
    const tracks = [];
    for (const { node, positions, rotations } of channels) {
      if (node === null) continue;
      const name = names[node];
      // Copy the keys, because the clip outlives the scene.
      if (this.animateBonePositions && positions.length > 0) {
        tracks.push(new VectorKeyframeTrack(`${name}.position`, times(positions), positions.values.slice()));
      }
      if (this.animateBoneRotations && rotations.length > 0) {
        tracks.push(new QuaternionKeyframeTrack(`${name}.quaternion`, times(rotations), rotations.values.slice()));
      }
    }
    return new AnimationClip(animation.name || "animation", animation.duration / ticksPerSecond, tracks);
  }
}

function skeletonOf(scene) {
  const names = boneNames(scene.nodes);
  const bones = scene.nodes.map((node, index) => {
    const bone = new Bone();
    bone.name = names[index];
    if (bone.name !== node.name) bone.userData.name = node.name;
    bone.matrix.fromArray(node.transform);
    bone.matrix.decompose(bone.position, bone.quaternion, bone.scale);
    return bone;
  });
  scene.nodes.forEach(({ parent }, index) => {
    if (parent !== null) bones[parent].add(bones[index]);
  });
  // The skeleton is bound in its rest pose.
  bones[0]?.updateMatrixWorld(true);
  return new Skeleton(bones);
}

/** Unique names of bones, without the characters that three.js reserves. */
function boneNames(nodes) {
  const taken = new Set();
  return nodes.map(({ name }) => {
    const base = PropertyBinding.sanitizeNodeName(name);
    let free = base;
    for (let number = 2; taken.has(free); number++) free = `${base}_${number}`;
    taken.add(free);
    return free;
  });
}
