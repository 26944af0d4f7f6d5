// Code of a user of the package, which is compiled with the types but not run.

import { loadBvh } from "./package/bvh.js";
import { MocapError, load, type Scene } from "./package/index.js";

const mocap = await load();

function walk(bytes: Uint8Array): Float32Array {
  using scene: Scene = mocap.read(bytes, "walk.bvh", { rootOffset: "add", clip: 0, hash: false });
  using metres = scene.convert({ unit: "cm", up: "-z", first: { seconds: 1 }, last: { frame: 90 }, root: "inPlace", rest: "frame:3", names: "mixamo" });
  const glb: Uint8Array = metres.toGlb({ compress: "int16", maxError: 0.001, shellDistance: 0.03 });
  const keys = metres.animations[0]?.channels[0]?.rotations.values.slice();
  return keys ?? new Float32Array(glb.length);
}

try {
  walk(new Uint8Array());
  const motion = mocap.read([{ name: "01.asf", bytes: "" }, { name: "01_01.amc", bytes: new ArrayBuffer(0) }]);
  mocap.read("", "take.npy", { body: { name: "SMPL.pkl", bytes: "" }, joints: "smpl22", lengths: "moving" });
  const solved = mocap.read("", "take.c3d", { markers: "auto", static: { name: "standing.c3d", bytes: "" } });
  const [first]: Float64Array = solved.jointAngles().values;
  console.log(first, solved.groundForces().columns, solved.analog().units, solved.gait().cadence);
  console.log(solved.solved?.swaps.length, solved.recorded?.events.map(({ time, label }) => `${time} ${label}`));
  motion.edit(["mirror", { step: "smooth", "cut-off": 8 }, "concat"], { others: [motion] }).reports?.at(0);
  const character = mocap.readCharacter(new Uint8Array(), "hero.vrm");
  const moved = motion.retarget(character, { scale: 1.1, feet: "free", limbAngles: true });
  const picture: Uint8Array = moved.toPng({ name: "walk" });
  moved.toPlayer("walk").blocks.map(([id, block]) => `${id}: ${block.length}, ${picture.length}`);
  using clip = mocap.openClip(moved.toMclip({ maxError: 0.005 }));
  clip.sample(0.5 * clip.ticksPerSecond, new Float32Array(clip.poseLength)).at(10 * clip.nodes.length - 1);
  const { joints, positions } = motion.retarget(mocap.readCharacter("", "g1.urdf")).robotMotion();
  const angles: Float64Array = positions.subarray(0, joints.length);
  using stream = motion.robotStream(mocap.readCharacter("", "g1.urdf"), { fps: 60, passes: 1, floor: "keep" });
  const frame = stream.push(motion.pose(0).nodeToParent);
  console.log(stream.delay, frame?.positions.length === stream.jointNames.length, stream.finish().contacts, stream.report());
  const small: Uint8Array = (await loadBvh())("HIERARCHY", { skeletonMesh: false });
  angles.set(small);
  using figure = character.controller([motion], { mirror: true });
  figure.steer(0, 1.2);
  figure.follow([0, 1, 0, 2, 0, 3, 0, 1, 0, 1, 0, 1]);
  const place: Float32Array = character.controller(new Uint8Array()).root;
  console.log(place[0], figure.nodeToWorld.length === 16 * figure.nodeCount, figure.frames);
  moved.write("vrma").warnings.map((warning) => warning.code);
} catch (error) {
  if (error instanceof MocapError) console.log(error.code, error.line, error.column, error.joint, error.help);
}

// @ts-expect-error an unknown axis
mocap.read("", "a.bvh").convert({ up: "x" });

// Each line has a mistake: a misspelt option, a wrong word, an option of another kind.
const scene = mocap.read("", "a.bvh");
// @ts-expect-error
mocap.read("", "a.bvh", { rootOfset: "add" });
// @ts-expect-error
mocap.read("", "a.bvh", { rootOffset: "ad" });
// @ts-expect-error
mocap.read("", "a.bvh", { format: "bhv" });
// @ts-expect-error a file, not its name
mocap.read("", "a.npz", { body: "SMPL.pkl" });
// @ts-expect-error
scene.convert({ fps: 30 });
// @ts-expect-error
scene.convert({ firstFrame: "yes" });
// @ts-expect-error
scene.convert({ rest: "tpose" });
// @ts-expect-error
scene.convert({ unit: "miles" });
// @ts-expect-error
scene.toGlb({ maxEror: 0.001 });
// @ts-expect-error
scene.toGlb({ compress: "meshopt" });
// @ts-expect-error an unknown unit
scene.toGlb({ maxError: "1 inch" });
// @ts-expect-error
scene.toBvh({ channels: 6 });
// @ts-expect-error
scene.write("bhv");
// @ts-expect-error
scene.edit(["miror"]);
// @ts-expect-error
scene.edit([{ step: "smooth", cutoff: 8 }]);
// @ts-expect-error
scene.edit([{ step: "smooth", part: "wings" }]);
// @ts-expect-error an option of another step
scene.edit([{ step: "mirror", "cut-off": 8 }]);
// @ts-expect-error
scene.retarget(scene, { feet: "off" });
// @ts-expect-error
scene.robotStream(scene, { passes: 3 });
mocap.run({ source: { inputs: ["a.bvh"], frames: { trim: "0..1" } }, steps: ["fill", { step: "trim", range: "0f..9f" }], write: { output: "a.glb", smaller: { "max-error": "1mm" } } }, []);
mocap.run({ source: { inputs: ["a.bvh"] }, target: { character: { file: "hero.vrm", scale: 1.1 } }, write: { output: "a.vrm" } }, []);
mocap.run({ source: { inputs: ["a.bvh"] }, survey: { where: "skate < 1" }, write: { output: "a.csv" } }, []);
// @ts-expect-error
mocap.run({ sorce: { inputs: ["a.bvh"] }, write: { output: "a.glb" } }, []);
// @ts-expect-error
mocap.run({ source: { inputs: ["a.bvh"] }, write: { output: "a.glb", smaller: { maxError: 0.001 } } }, []);
// @ts-expect-error
mocap.run({ source: { inputs: ["a.bvh"], space: { up: "x" } }, write: { output: "a.glb" } }, []);
// @ts-expect-error an option of a robot
mocap.run({ source: { inputs: ["a.bvh"] }, target: { character: { file: "hero.vrm", passes: 1 } }, write: { output: "a.vrm" } }, []);
// @ts-expect-error a survey has no steps
mocap.run({ source: { inputs: ["a.bvh"] }, survey: {}, steps: ["mirror"] }, []);
// @ts-expect-error
mocap.run({ source: { inputs: ["a.bvh"] }, steps: [{ step: "turn", by: "left" }], write: { output: "a.glb" } }, []);
