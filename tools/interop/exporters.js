// Programs that write glTF with their own defaults. mocap must read these files correctly.

import { execFileSync } from "node:child_process";
import { chmodSync, readFileSync, writeFileSync } from "node:fs";
import { extname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { AnimationClip, Bone, Group, InterpolateDiscrete, QuaternionKeyframeTrack, Scene, VectorKeyframeTrack } from "three";
import { BVHLoader } from "three/addons/loaders/BVHLoader.js";
import { GLTFExporter } from "three/addons/exporters/GLTFExporter.js";

import { load } from "./parts/three.js";

const PROGRAMS = fileURLToPath(new URL("node_modules/.bin/", import.meta.url));
const BLENDER_SCRIPT = fileURLToPath(new URL("blender/export_gltf.py", import.meta.url));

const run = (program, ...args) => execFileSync(program, args, { stdio: ["ignore", "pipe", "pipe"] });

/** The parts of a browser that GLTFExporter needs. */
globalThis.FileReader ??= class {
  readAsArrayBuffer(blob) {
    blob.arrayBuffer().then((buffer) => this.#end(buffer));
  }
  readAsDataURL(blob) {
    blob.arrayBuffer().then((buffer) => this.#end(`data:${blob.type};base64,${Buffer.from(buffer).toString("base64")}`));
  }
  #end(result) {
    this.result = result;
    this.onloadend?.();
  }
};

async function exportFromThree(scene, animations, output, options = {}) {
  const binary = extname(output) === ".glb";
  const written = await new GLTFExporter().parseAsync(scene, { binary, animations, onlyVisible: false, ...options });
  writeFileSync(output, binary ? Buffer.from(written) : JSON.stringify(written));
}

/** A BVH file as three.js reads it. */
async function bvhFromThree(input, output, options) {
  const { skeleton, clip } = new BVHLoader().parse(readFileSync(input, "utf8"));
  const scene = new Scene();
  scene.add(skeleton.bones[0]);
  await exportFromThree(scene, [clip], output, options);
}

async function glbFromThree(input, output, options) {
  const { gltf } = await load(input);
  await exportFromThree(gltf.scene, gltf.animations, output, options);
}

/** A track of in-tangent, value and out-tangent at each time, as three.js reads cubic curves. */
function curve(Track, name, times, values) {
  const track = new Track(name, times, values);
  const createInterpolant = () => {
    throw new Error("a track that is only exported");
  };
  createInterpolant.isInterpolantFactoryMethodGLTFCubicSpline = true;
  track.createInterpolant = createInterpolant;
  return track;
}

/** A key whose tangents bend the curve before it and after it. */
const tangents = (value) => [...value.map((number) => 1 - number), ...value, ...value.map((number) => 2 * number)];

/** Clips with steps, curves, uneven times and scales, on bones below a rotated and scaled group. */
export async function madeInThree(output, options) {
  const bones = ["hips", "spine", "head"].map((name, depth) => {
    const bone = new Bone();
    bone.name = name;
    bone.position.set(0.1 * depth, depth === 0 ? 0 : 0.5, -0.05 * depth);
    return bone;
  });
  bones.reduce((parent, bone) => parent.add(bone) && bone);
  const group = new Group();
  group.rotation.set(0.3, -0.7, 0.2);
  group.scale.set(2, 1.5, 0.5);
  group.add(bones[0]);
  const scene = new Scene();
  scene.add(group);
  const times = [0.25, 0.3, 0.9, 2.125];
  const turns = [0, 0, 0, 1, 0.6, 0, 0, 0.8, 0, -0.28, 0.96, 0, 0.5, 0.5, -0.5, -0.5];
  const places = [0, 0.5, 0, 0.4, 0.1, 0.2, -1, 0, 3, 0, 0, 0];
  const scales = [1, 1, 1, 2, 0.5, 1, 1, 3, 1, 0.1, 1, 1];
  const clips = [
    new AnimationClip("uneven", -1, [
      new QuaternionKeyframeTrack("hips.quaternion", times, turns),
      new VectorKeyframeTrack("spine.position", times.slice(1), places.slice(3)),
      new VectorKeyframeTrack("spine.scale", times, scales),
    ]),
    new AnimationClip("steps", -1, [
      new QuaternionKeyframeTrack("spine.quaternion", times, turns, InterpolateDiscrete),
      new VectorKeyframeTrack("hips.position", times, places, InterpolateDiscrete),
      new VectorKeyframeTrack("group.position", [1], [1, 2, 3]),
    ]),
    new AnimationClip("curves", -1, [
      curve(QuaternionKeyframeTrack, "spine.quaternion", times, turns.flatMap((_, at) => (at % 4 ? [] : tangents(turns.slice(at, at + 4))))),
      curve(VectorKeyframeTrack, "hips.position", times, places.flatMap((_, at) => (at % 3 ? [] : tangents(places.slice(at, at + 3))))),
    ]),
  ];
  group.name = "group";
  await exportFromThree(scene, clips, output, options);
}

const gltfpack = (...options) => ({
  name: ["gltfpack", ...options].join(" "),
  takes: [".glb", ".gltf"],
  write: (input, output) => run(`${PROGRAMS}gltfpack`, ...options, "-i", input, "-o", output),
});

const gltfTransform = (...command) => ({
  name: ["gltf-transform", ...command].join(" "),
  takes: [".glb", ".gltf"],
  write: (input, output) => run(`${PROGRAMS}gltf-transform`, command[0], input, output, ...command.slice(1)),
});

/** `takes` lists the formats of the inputs. `extension` is the extension of the output, if it is not .glb. */
export const EXPORTERS = [
  { name: "three.js of BVH", takes: [".bvh"], write: bvhFromThree },
  { name: "three.js of BVH, .gltf", takes: [".bvh"], extension: ".gltf", write: bvhFromThree },
  { name: "three.js", takes: [".glb"], write: glbFromThree },
  { name: "three.js, trs", takes: [".glb"], write: (input, output) => glbFromThree(input, output, { trs: true }) },
  gltfpack(),
  gltfpack("-kn"),
  gltfpack("-noq"),
  gltfpack("-c"),
  gltfpack("-cc", "-af", "0"),
  gltfpack("-cc", "-ce", "khr"),
  gltfTransform("copy"),
  gltfTransform("optimize"),
  gltfTransform("resample"),
  gltfTransform("sparse"),
  gltfTransform("draco"),
  gltfTransform("meshopt"),
];

/** Programs with a large installation. */
export const LARGE_EXPORTERS = [
  { name: "Assimp", takes: [".bvh", ".fbx"], write: (input, output) => run("assimp", "export", input, output, "-fglb2") },
  {
    name: "FBX2glTF",
    takes: [".fbx"],
    write: (input, output, packages) => {
      const program = join(packages, "fbx2gltf/package/bin/Linux/FBX2glTF");
      chmodSync(program, 0o755);
      run(program, "--binary", "--input", input, "--output", output.slice(0, -extname(output).length));
    },
  },
];

/** Blender, if BLENDER_PYTHON names a Python with bpy. */
export const BLENDER = [[], ["unsampled"]].map((options) => ({
  name: ["Blender", ...options].join(", "),
  takes: [".bvh", ".fbx", ".glb"],
  write: (input, output) => run(process.env.BLENDER_PYTHON, BLENDER_SCRIPT, input, output, ...options),
}));
