// Samples limbs and feet of a moving figure with three.js, to judge retargeting without code of mocap.

import { AnimationMixer, LoopOnce, Vector3 } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

import { glbOf, readGlb } from "./glb.js";

/** A joint of a foot is in contact if its height above its resting level is less than this, in metres, ... */
const CONTACT_HEIGHT = 0.03;
/** ... and less fast over the ground than this, in metres a second. */
const CONTACT_SPEED = 0.15;
/** ... for this long, in seconds: a swinging foot is slow for a frame where it turns back. */
const CONTACT_TIME = 0.08;
/** The depth below the floor that counts, in metres. */
const BELOW = 0.01;
/** The largest height of a sole's vertex at rest, in metres, and the number of sampled vertices per foot. */
const SOLE = 0.02;
const VERTICES = 60;

const SIDES = ["left", "right"];
const LIMBS = SIDES.flatMap((side) => [
  [`${side}UpperLeg`, `${side}LowerLeg`],
  [`${side}LowerLeg`, `${side}Foot`],
  [`${side}UpperArm`, `${side}LowerArm`],
  [`${side}LowerArm`, `${side}Hand`],
]);

/**
 * A .glb file with one motion, loaded by three.js. Pictures and extensions are omitted, because Node decodes none.
 *
 * @param {string} path
 */
async function load(path) {
  const { json, bin } = readGlb(path);
  for (const name of ["images", "textures", "materials", "samplers", "extensions", "extensionsUsed", "extensionsRequired"]) {
    delete json[name];
  }
  for (const mesh of json.meshes ?? []) for (const primitive of mesh.primitives) delete primitive.material;
  const bytes = glbOf(json, bin);
  const gltf = await new GLTFLoader().parseAsync(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), "");
  const objects = new Map();
  gltf.scene.traverse((object) => {
    const node = gltf.parser.associations.get(object)?.nodes;
    const name = json.nodes[node]?.extras?.source_name ?? json.nodes[node]?.name;
    if (node !== undefined && !objects.has(name)) objects.set(name, object);
  });
  return { gltf, objects, clip: gltf.animations.at(-1) };
}

/** The name of the joint of each bone. If the names of a figure exchange left and right, so do its bones here. */
export function bonesOf({ map, sides }) {
  const isExchanged = sides?.names === "opposite" || sides === "opposite";
  const other = (bone) => bone.replace(/^(left|right)/, (side) => (side === "left" ? "right" : "left"));
  return Object.fromEntries(Object.entries(map).map(([bone, name]) => [isExchanged ? other(bone) : bone, name]));
}

/** Vertices of the soles, spread over them. */
function solesOf(gltf, feet) {
  const soles = [];
  gltf.scene.traverse((mesh) => {
    if (!mesh.isSkinnedMesh) return;
    const { skinIndex, skinWeight, position } = mesh.geometry.attributes;
    const isOfFoot = mesh.skeleton.bones.map((bone) => {
      for (let above = bone; above; above = above.parent) if (feet.includes(above)) return true;
      return false;
    });
    const place = new Vector3();
    const found = [];
    for (let vertex = 0; vertex < position.count; vertex += 1) {
      let weight = 0;
      for (let slot = 0; slot < 4; slot += 1) {
        if (isOfFoot[skinIndex.getComponent(vertex, slot)]) weight += skinWeight.getComponent(vertex, slot);
      }
      if (weight < 0.99) continue;
      mesh.getVertexPosition(vertex, place);
      if (place.applyMatrix4(mesh.matrixWorld).y < SOLE) found.push(vertex);
    }
    const step = Math.max(1, Math.floor(found.length / (2 * VERTICES)));
    soles.push({ mesh, vertices: found.filter((_, index) => index % step === 0) });
  });
  return soles;
}

/**
 * Samples a file frame by frame. `bones` has the joint of each bone by name.
 *
 * @param {string} path
 * @param {Record<string, string>} bones
 */
export async function sample(path, bones) {
  const { gltf, objects, clip } = await load(path);
  const joint = (bone) => objects.get(bones[bone]);
  const feet = SIDES.map((side) => {
    const ankle = joint(`${side}Foot`);
    return ankle && [ankle, joint(`${side}Toes`) ?? ankle.children.find((child) => child.isBone || child.isObject3D)];
  });
  gltf.scene.updateMatrixWorld(true);
  const place = new Vector3();
  const at = (object) => object.getWorldPosition(place).toArray();
  const rest = feet.map((foot) => foot?.filter(Boolean).map((object) => at(object)[1]));
  const soles = solesOf(gltf, feet.map((foot) => foot?.[0]).filter(Boolean));
  const soleAtRest = lowestOf(soles);
  const mixer = new AnimationMixer(gltf.scene);
  if (clip) {
    const action = mixer.clipAction(clip).setLoop(LoopOnce, 1);
    action.clampWhenFinished = true;
    action.play();
  }
  const times = clip ? clip.tracks.map((track) => track.times).reduce((a, b) => (b.length > a.length ? b : a)) : [0];
  const limbs = LIMBS.map(([from, to]) => [joint(from), joint(to)]);
  const frames = [];
  for (const time of times) {
    mixer.setTime(time);
    gltf.scene.updateMatrixWorld(true);
    frames.push({
      feet: feet.map((foot) => foot?.filter(Boolean).map(at)),
      limbs: limbs.map(([from, to]) => (from && to ? at(to).map((value, axis) => value - from.getWorldPosition(place).toArray()[axis]) : undefined)),
      sole: lowestOf(soles),
    });
  }
  return { times, frames, rest, soleAtRest, hasFeet: feet.every(Boolean) };
}

/** The height of the lowest vertex. */
function lowestOf(soles) {
  const place = new Vector3();
  let lowest = Infinity;
  for (const { mesh, vertices } of soles) {
    for (const vertex of vertices) {
      mesh.getVertexPosition(vertex, place);
      lowest = Math.min(lowest, place.applyMatrix4(mesh.matrixWorld).y);
    }
  }
  return lowest;
}

/** The resting level of each joint of a foot: the fifth percentile of the lower of both feet. */
function levels({ frames }) {
  const count = Math.min(...frames[0].feet.map((foot) => foot.length));
  return Array.from({ length: count }, (_, joint) => {
    const heights = frames.map(({ feet }) => Math.min(...feet.map((foot) => foot[joint][1]))).sort((a, b) => a - b);
    return heights[Math.floor((heights.length - 1) / 20)];
  });
}

/** The fraction of frames in which a joint of a foot is more than `BELOW` under its resting height. */
function shareBelow({ frames }, heights) {
  const isBelow = ({ feet }) =>
    feet.some((foot, side) => foot.some(([, y], joint) => y < heights[side][joint] - BELOW));
  return frames.filter(isBelow).length / frames.length;
}

/**
 * Compares a motion with its retargeted copy. Returns the mean angle of the limbs in degrees, the speed of feet in
 * contact in m/s, and the fraction of frames below the floor. Joints and, with a mesh, soles count as below the floor.
 */
export function compare(source, target) {
  const feet = source.hasFeet && target.hasFeet ? compareFeet(source, target) : undefined;
  return { degrees: degreesOf(source, target), feet };
}

function compareFeet(source, target) {
  const rest = levels(source);
  const speed = ({ times, frames }, frame, side, joint) => {
    const [before, after] = [frame, frame + 1].map((index) => frames[index].feet[side][joint]);
    return Math.hypot(after[0] - before[0], after[2] - before[2]) / (times[frame + 1] - times[frame]);
  };
  let [contacts, was, is] = [0, 0, 0];
  const steps = Math.max(0, Math.min(source.frames.length, target.frames.length) - 1);
  for (const side of [0, 1]) {
    let run = [];
    for (let frame = 0; frame <= steps; frame += 1) {
      const slowest = frame < steps ? slowestInContact(frame, side) : undefined;
      if (slowest) {
        run.push({ frame, ...slowest });
        continue;
      }
      const lasts = run.length > 0 ? source.times[frame] - source.times[run[0].frame] : 0;
      for (const { frame: at, joint, speed: before } of lasts < CONTACT_TIME ? [] : run) {
        contacts += 1;
        was += before;
        is += speed(target, at, side, joint);
      }
      run = [];
    }
  }
  /** The slowest joint of a source foot that is low and slow in two successive frames. */
  function slowestInContact(frame, side) {
    const joints = Math.min(rest.length, target.frames[frame].feet[side].length);
    const low = [...Array(joints).keys()].filter(
      (joint) => source.frames[frame].feet[side][joint][1] < rest[joint] + CONTACT_HEIGHT,
    );
    const speeds = low.map((joint) => ({ joint, speed: speed(source, frame, side, joint) }));
    const slowest = speeds.reduce((a, b) => (a && a.speed <= b.speed ? a : b), undefined);
    return slowest && slowest.speed < CONTACT_SPEED ? slowest : undefined;
  }
  const ownLevels = source.rest.map(() => rest);
  const soleFrames = target.frames.filter(({ sole }) => sole < Math.min(target.soleAtRest, 0) - BELOW);
  return {
    contacts,
    skateBefore: was / Math.max(contacts, 1),
    skate: is / Math.max(contacts, 1),
    belowBefore: shareBelow({ frames: source.frames.map(({ feet }) => ({ feet: feet.map((foot) => foot.slice(0, rest.length)) })) }, ownLevels),
    below: shareBelow(target, target.rest),
    soleBelow: Number.isFinite(target.soleAtRest) ? soleFrames.length / target.frames.length : undefined,
  };
}

/** The mean angle between limbs, after the rotation about the up axis that aligns them best. */
function degreesOf(source, target) {
  const pairs = source.frames
    .slice(0, target.frames.length)
    .flatMap(({ limbs }, frame) => limbs.map((limb, index) => [limb, target.frames[frame].limbs[index]]))
    .filter(([a, b]) => a && b && Math.hypot(...a) > 0 && Math.hypot(...b) > 0)
    .map((pair) => pair.map((way) => way.map((value) => value / Math.hypot(...way))));
  let [across, along] = [0, 0];
  for (const [a, b] of pairs) {
    across += a[2] * b[0] - a[0] * b[2];
    along += a[0] * b[0] + a[2] * b[2];
  }
  const turn = Math.atan2(across, along);
  const [sine, cosine] = [Math.sin(turn), Math.cos(turn)];
  const angles = pairs.map(([[x, y, z], b]) => {
    const a = [cosine * x + sine * z, y, cosine * z - sine * x];
    const normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    return Math.atan2(Math.hypot(...normal), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
  });
  return (angles.reduce((sum, angle) => sum + angle, 0) / Math.max(angles.length, 1)) * (180 / Math.PI);
}
