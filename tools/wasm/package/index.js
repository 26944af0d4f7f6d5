// Reads motion capture files with the library `mocap`, compiled to WebAssembly. The types are in index.d.ts.

import { MocapError, bytesOf, flat } from "./error.js";
import { compile } from "./load.js";

export { MocapError };

const encoder = new TextEncoder();
const decoder = new TextDecoder();
const dispose = Symbol.dispose ?? Symbol.for("Symbol.dispose");

/** Files that others refer to. */
const BESIDE = /\.(asf|bin|png|jpe?g|webp|ktx2)$/i;

/** Calls that the drop page does not make. They have a separate entry point. */
const OTHER = new Set([
  "check", "run", "table", "report", "openClip", "controller", "robotStream", "robotPush", "robotFinish", "robotReport",
  "chain", "score",
]);

/** One instance of the module, and the memory of its scenes. */
class Instance {
  /** The reason why the instance has ended, if it has. */
  ended;

  constructor(instance) {
    this.exports = instance.exports;
  }

  /** Runs `call`. A trap ends the instance, because its state is then undefined. */
  run(call) {
    if (this.ended) {
      const help = "read the file again";
      throw new MocapError({ code: "freed", message: `the memory of this scene is gone, because ${this.ended}`, help });
    }
    try {
      return call(this.exports);
    } catch (error) {
      if (error instanceof MocapError) throw error;
      throw this.end(error);
    }
  }

  /** The error of a trap. */
  end(error) {
    let said = "";
    try {
      said = this.text(this.exports.mocap_panic(), this.exports.mocap_panic_length());
    } catch {
      // Ignore the error: the memory stays as it is.
    }
    const isMemory = said === "" && /unreachable/.test(error.message);
    this.ended = isMemory ? "there was not enough memory" : `of a defect: ${said || error.message}`;
    const finding = isMemory
      ? { code: "out-of-memory", message: "there is not enough memory", help: "free scenes that are not needed, or read a smaller file" }
      : { code: "defect", message: `a defect of the library: ${said || error.message}`, help: "please report it with the file" };
    return new MocapError(finding);
  }

  /** Sends a request with files, and returns the answer. `bytes` is a copy. */
  call(request, files = []) {
    return this.run((exports) => {
      const inputs = [encoder.encode(JSON.stringify(request)), ...files];
      for (const input of inputs) {
        const address = exports.mocap_input(input.length) >>> 0;
        if (address === 0) {
          const message = `there is not enough memory for the ${input.length} bytes of the file`;
          throw new MocapError({ code: "out-of-memory", message, help: "free scenes that are not needed" });
        }
        // An allocation may have moved the memory.
        new Uint8Array(exports.memory.buffer, address, input.length).set(input);
      }
      const failed = OTHER.has(request.call) ? exports.mocap_call_other() : exports.mocap_call();
      const part = (index) => [exports.mocap_output(index) >>> 0, exports.mocap_output_length(index) >>> 0];
      const answer = JSON.parse(this.text(...part(0)));
      if (failed) throw new MocapError(answer.error, answer.warnings);
      return { answer, bytes: new Uint8Array(exports.memory.buffer, ...part(1)).slice() };
    });
  }

  text(address, length) {
    return decoder.decode(new Uint8Array(this.exports.memory.buffer, address >>> 0, length));
  }

  floats(address, length) {
    return this.run((exports) => new Float32Array(exports.memory.buffer, address, length));
  }

  doubles(address, length) {
    return this.run((exports) => new Float64Array(exports.memory.buffer, address, length));
  }

  free(scene) {
    if (!this.ended) this.exports.mocap_free(scene);
  }

  freeClip(clip) {
    if (!this.ended) this.exports.mocap_clip_free(clip);
  }

  freeController(controller) {
    if (!this.ended) this.exports.mocap_controller_free(controller);
  }

  freeRobotStream(stream) {
    if (!this.ended) this.exports.mocap_robot_stream_free(stream);
  }
}

/** Frees unreachable scenes. */
const forgotten = new FinalizationRegistry(({ instance, scene }) => instance.free(scene));

/** Frees unreachable packed clips. */
const forgottenClips = new FinalizationRegistry(({ instance, clip }) => instance.freeClip(clip));

/** Frees unreachable figures. */
const forgottenControllers = new FinalizationRegistry(({ instance, controller }) => instance.freeController(controller));

/** Frees unreachable robot streams. */
const forgottenRobotStreams = new FinalizationRegistry(({ instance, stream }) => instance.freeRobotStream(stream));

/** Keys of one track: views into the module's memory. */
class Keys {
  #scene;
  #at;
  #width;

  constructor(scene, at, width) {
    this.#scene = scene;
    this.#at = at;
    this.#width = width;
  }

  get length() {
    return this.#at.length;
  }

  get values() {
    return this.#scene.view("floats", this.#at.values, this.#at.length * this.#width);
  }

  get ticks() {
    const { ticks, length } = this.#at;
    return ticks === undefined ? Float64Array.from({ length }, (_, tick) => tick) : this.#scene.view("doubles", ticks, length);
  }

  get isEveryTick() {
    return this.#at.ticks === undefined;
  }
}

/** A scene in the module's memory. */
export class Scene {
  #instance;
  #number;
  #freed = false;

  constructor(instance, described) {
    const { scene, nodes, transforms, animations, meshes, metadata, warnings, assumptions, reports } = described;
    this.#instance = instance;
    this.#number = scene;
    const owner = this;
    this.nodes = nodes.map((node, index) => ({
      ...node,
      get transform() {
        return owner.view("floats", transforms + 64 * index, 16);
      },
    }));
    this.animations = animations.map(({ channels, ...animation }) => ({
      ...animation,
      frameCount: Math.trunc(animation.duration) + 1,
      channels: channels.map(({ nodeName, node, positions, rotations, scales }) => ({
        nodeName,
        node,
        positions: new Keys(this, positions, 3),
        rotations: new Keys(this, rotations, 4),
        scales: new Keys(this, scales, 3),
      })),
    }));
    this.meshCount = meshes;
    this.metadata = metadata;
    this.warnings = warnings.map(flat);
    this.assumptions = assumptions;
    if (reports) this.reports = reports;
    forgotten.register(this, { instance, scene }, this);
  }

  /** A view of `length` numbers at an address. */
  view(kind, address, length) {
    this.#check();
    return this.#instance[kind](address, length);
  }

  #check() {
    if (this.#freed) throw new MocapError({ code: "freed", message: "the scene was freed", help: "read the file again" });
  }

  pose(tick, animation = 0) {
    this.#check();
    return this.#instance.run((exports) => {
      const world = exports.mocap_pose(this.#number, animation, tick) >>> 0;
      if (world === 0) {
        const message = `there is no animation ${animation}: there are ${this.animations.length}, counted from 0`;
        throw new MocapError({ code: "invalid-value", message });
      }
      const parent = exports.mocap_pose_to_parent(this.#number) >>> 0;
      const view = (address) => new Float32Array(exports.memory.buffer, address, 16 * this.nodes.length);
      return { nodeToWorld: view(world), nodeToParent: view(parent) };
    });
  }

  chain(joint, tick = 0, point = null) {
    this.#check();
    return this.#instance.call({ call: "chain", scene: this.#number, joint, tick, point }).answer;
  }

  convert(options = {}) {
    return this.#derived({ call: "convert", scene: this.#number, options });
  }

  edit(steps, { others = [], bones = {} } = {}) {
    for (const other of others) this.#checkOther(other, "the second motion of a step must be a Scene", "the two motions");
    const numbers = others.map((other) => other.#number);
    return this.#derived({ call: "edit", scene: this.#number, steps, others: numbers, bones });
  }

  #checkOther(other, what, both) {
    if (!(other instanceof Scene)) throw new TypeError(what);
    other.#check();
    if (other.#instance !== this.#instance) {
      const message = `${both} were not read by the same module`;
      throw new MocapError({ code: "invalid-value", message, help: "read both again" });
    }
  }

  retarget(character, options = {}) {
    this.#checkOther(character, "the character must be the result of readCharacter", "the motion and the character");
    return this.#derived({ call: "retarget", scene: this.#number, character: character.#number, options });
  }

  robotStream(robot, options = {}) {
    this.#checkOther(robot, "the robot must be the result of readCharacter for a URDF or MJCF file", "the skeleton and the robot");
    const request = { call: "robotStream", scene: this.#number, robot: robot.#number, options };
    return new RobotStream(this.#instance, this.#instance.call(request).answer);
  }

  score(motion, robot, { bones = {} } = {}) {
    this.#checkOther(motion, "the motion must be a Scene", "the reference and the motion");
    this.#checkOther(robot, "the robot must be the result of readCharacter for a URDF or MJCF file", "the motion and the robot");
    const request = { call: "score", scene: this.#number, motion: motion.#number, robot: robot.#number, bones };
    return this.#instance.call(request).answer;
  }

  controller(moves, { mirror = false } = {}) {
    this.#check();
    const request = { call: "controller", character: this.#number, mirror };
    if (!Array.isArray(moves)) return new Controller(this.#instance, this.#instance.call(request, [bytesOf(moves)]).answer);
    for (const motion of moves) this.#checkOther(motion, "a motion of a figure must be a Scene", "the motion and the character");
    const motions = moves.map((motion) => motion.#number);
    return new Controller(this.#instance, this.#instance.call({ ...request, motions }).answer);
  }

  #derived(request) {
    this.#check();
    return new Scene(this.#instance, this.#instance.call(request).answer);
  }

  #table(columns) {
    this.#check();
    const { answer, bytes } = this.#instance.call({ call: "table", scene: this.#number, columns });
    const values = new Float64Array(bytes.buffer);
    return { ...answer, frameCount: values.length / answer.columns.length, values };
  }

  #report(report) {
    this.#check();
    return this.#instance.call({ call: "report", scene: this.#number, report }).answer;
  }

  jointAngles() {
    return this.#table("angles");
  }

  groundForces() {
    return this.#table("forces");
  }

  analog() {
    return this.#table("analog");
  }

  gait() {
    return this.#report("gait");
  }

  get recorded() {
    return this.#report("recorded");
  }

  get solved() {
    return this.#report("solved");
  }

  #write(format, options) {
    this.#check();
    const { answer, bytes } = this.#instance.call({ call: "write", scene: this.#number, format, options });
    return { bytes, ...answer, warnings: answer.warnings.map(flat) };
  }

  write(format, options = {}) {
    return this.#write(format, options);
  }

  toGlb(options = {}) {
    return this.#write("glb", options).bytes;
  }

  toVrma(options = {}) {
    return this.#write("vrma", options).bytes;
  }

  toMclip(options = {}) {
    return this.#write("mclip", options).bytes;
  }

  toFbx(options = {}) {
    return this.#write("fbx", options).bytes;
  }

  toBvh(options = {}) {
    return decoder.decode(this.#write("bvh", options).bytes);
  }

  toCsv() {
    return decoder.decode(this.#write("csv", {}).bytes);
  }

  toPng(options = {}) {
    return this.#write("png", options).bytes;
  }

  toPlayer(name) {
    this.#check();
    const { answer, bytes } = this.#instance.call({ call: "view", scene: this.#number, name });
    let at = 0;
    const blocks = answer.blocks.map(([id, length]) => [id, bytes.slice(at, (at += length))]);
    return { ...answer, blocks };
  }

  robotMotion() {
    this.#check();
    const { answer, bytes } = this.#instance.call({ call: "robotMotion", scene: this.#number });
    const joints = answer.joints.map((joint) => ({ ...joint, velocity: joint.velocity ?? undefined }));
    return { ...answer, joints, ...robotNumbers(answer.frames, bytes) };
  }

  toJson() {
    return decoder.decode(this.#write("json", {}).bytes);
  }

  free() {
    if (this.#freed) return;
    this.#freed = true;
    forgotten.unregister(this);
    this.#instance.free(this.#number);
  }

  [dispose]() {
    this.free();
  }
}

/** Numbers of a node in the pose of a packed clip. */
const POSE_FLOATS = 10;

/** A packed clip in the module's memory. */
export class PackedClip {
  #instance;
  #number;
  #address;
  /** The last sampled pose. */
  #pose;
  #freed = false;

  constructor(instance, described) {
    const { clip, pose, ...rest } = described;
    this.#instance = instance;
    this.#number = clip;
    this.#address = pose;
    Object.assign(this, rest);
    this.poseLength = POSE_FLOATS * this.nodes.length;
    this.#pose = instance.floats(pose, this.poseLength);
    forgottenClips.register(this, { instance, clip }, this);
  }

  /** Allocates no memory, because the view of the module's memory is kept. */
  sample(tick, pose) {
    const instance = this.#instance;
    if (this.#freed || instance.ended) this.#fail();
    if (pose.length < this.poseLength) {
      throw new RangeError(`a pose of ${this.nodes.length} nodes has ${this.poseLength} numbers, and there is room for ${pose.length}`);
    }
    try {
      instance.exports.mocap_clip_sample(this.#number, tick);
    } catch (error) {
      throw instance.end(error);
    }
    // When the memory grows, it gets a new buffer.
    if (this.#pose.length === 0) this.#pose = instance.floats(this.#address, this.poseLength);
    pose.set(this.#pose);
    return pose;
  }

  #fail() {
    if (this.#freed) throw new MocapError({ code: "freed", message: "the packed clip was freed", help: "open it again" });
    this.#instance.run(() => {});
  }

  free() {
    if (this.#freed) return;
    this.#freed = true;
    forgottenClips.unregister(this);
    this.#instance.freeClip(this.#number);
  }

  [dispose]() {
    this.free();
  }
}

/** The number of values of a trajectory, and of the root of a figure. */
const [TRAJECTORY_FLOATS, ROOT_FLOATS] = [12, 4];

/** The frames of a robot: positions of the base, its rotations, positions of the joints. */
function robotNumbers(frames, bytes) {
  const numbers = new Float64Array(bytes.buffer);
  const [root, turns] = [3 * frames, 7 * frames];
  return { rootPositions: numbers.subarray(0, root), rootRotations: numbers.subarray(root, turns), positions: numbers.subarray(turns) };
}

/** A stream of poses to a robot, in the module's memory. */
export class RobotStream {
  #instance;
  #number;
  #freed = false;

  constructor(instance, { stream, jointNames, delay }) {
    this.#instance = instance;
    this.#number = stream;
    this.jointNames = jointNames;
    this.delay = delay;
    forgottenRobotStreams.register(this, { instance, stream }, this);
  }

  #call(call, files) {
    if (this.#freed) throw new MocapError({ code: "freed", message: "the stream was freed", help: "begin another" });
    return this.#instance.call({ call, stream: this.#number }, files);
  }

  #frames({ answer, bytes }) {
    return { ...answer, ...robotNumbers(answer.frames, bytes) };
  }

  push(nodeToParent) {
    const numbers = Float32Array.from(nodeToParent);
    const frame = this.#frames(this.#call("robotPush", [new Uint8Array(numbers.buffer)]));
    return frame.frames > 0 ? frame : null;
  }

  finish() {
    return this.#frames(this.#call("robotFinish"));
  }

  report() {
    return this.#call("robotReport").answer.report;
  }

  free() {
    if (this.#freed) return;
    this.#freed = true;
    forgottenRobotStreams.unregister(this);
    this.#instance.freeRobotStream(this.#number);
  }

  [dispose]() {
    this.free();
  }
}

/** A figure of motion matching in the module's memory. */
export class Controller {
  #instance;
  #number;
  #at;
  /** Views of the module's memory. They are kept, so that a frame allocates no memory. */
  #views;
  #freed = false;

  constructor(instance, { controller, nodeCount, frames, ...at }) {
    this.#instance = instance;
    this.#number = controller;
    this.#at = at;
    this.nodeCount = nodeCount;
    this.frames = frames;
    this.#see();
    forgottenControllers.register(this, { instance, controller }, this);
  }

  #see() {
    const of = (address, length) => this.#instance.floats(address, length);
    const { root, trajectory, toWorld, toParent } = this.#at;
    this.#views = {
      root: of(root, ROOT_FLOATS),
      trajectory: of(trajectory, TRAJECTORY_FLOATS),
      nodeToWorld: of(toWorld, 16 * this.nodeCount),
      nodeToParent: of(toParent, 16 * this.nodeCount),
    };
  }

  /** The views, renewed if the memory has grown. */
  get #memory() {
    if (this.#freed) throw new MocapError({ code: "freed", message: "the figure was freed", help: "make it again" });
    if (this.#instance.ended) this.#instance.run(() => {});
    if (this.#views.root.length === 0) this.#see();
    return this.#views;
  }

  get root() {
    return this.#memory.root;
  }

  get nodeToWorld() {
    return this.#memory.nodeToWorld;
  }

  get nodeToParent() {
    return this.#memory.nodeToParent;
  }

  steer(x, z, lookX = 0, lookZ = 0) {
    this.#memory;
    try {
      this.#instance.exports.mocap_controller_steer(this.#number, x, z, lookX, lookZ);
    } catch (error) {
      throw this.#instance.end(error);
    }
  }

  follow(trajectory) {
    const room = this.#memory.trajectory;
    if (trajectory.length !== TRAJECTORY_FLOATS) {
      throw new RangeError(`a trajectory has ${TRAJECTORY_FLOATS} numbers, not ${trajectory.length}`);
    }
    room.set(trajectory);
    try {
      this.#instance.exports.mocap_controller_follow(this.#number);
    } catch (error) {
      throw this.#instance.end(error);
    }
  }

  free() {
    if (this.#freed) return;
    this.#freed = true;
    forgottenControllers.unregister(this);
    this.#instance.freeController(this.#number);
  }

  [dispose]() {
    this.free();
  }
}

/** The module, ready to read. */
export class Mocap {
  #module;
  #instance;
  /** The instance that replaces an ended instance. */
  #spare;

  constructor(module, instance = new WebAssembly.Instance(module, {})) {
    this.#module = module;
    this.#instance = new Instance(instance);
    this.#keepSpare();
  }

  /** Chromium's main thread can only instantiate a module of this size asynchronously, so prepare an instance ahead. */
  async #keepSpare() {
    this.#spare = undefined;
    this.#spare = await WebAssembly.instantiate(this.#module, {}).catch(() => undefined);
  }

  /** The instance, or a fresh instance if the last one has ended. */
  get #alive() {
    if (this.#instance.ended) {
      this.#instance = new Instance(this.#spare ?? new WebAssembly.Instance(this.#module, {}));
      this.#keepSpare();
    }
    return this.#instance;
  }

  read(...args) {
    return this.#scene("read", args);
  }

  readCharacter(...args) {
    return this.#scene("readCharacter", args);
  }

  run(job, files) {
    const names = files.map(({ name }) => name);
    const { answer, bytes } = this.#alive.call({ call: "run", job, files: names }, files.map((file) => bytesOf(file.bytes)));
    let at = 0;
    const written = answer.files.map(({ name, bytes: length }) => ({ name, bytes: bytes.slice(at, (at += length)) }));
    return { ...answer, files: written, warnings: answer.warnings.map(flat) };
  }

  /** The steps of `Scene.edit`. */
  get steps() {
    return this.#alive.call({ call: "steps" }).answer.steps;
  }

  check(...args) {
    const { answer } = this.#call("check", args);
    return { ...answer, diagnostics: answer.diagnostics.map(flat) };
  }

  openClip(bytes, name = "clip.mclip") {
    const instance = this.#alive;
    return new PackedClip(instance, instance.call({ call: "openClip", files: [name] }, [bytesOf(bytes)]).answer);
  }

  /** The memory of the module, in bytes. The module reuses freed memory for the next file. */
  get memory() {
    return this.#alive.exports.memory.buffer.byteLength;
  }

  #scene(call, args) {
    const instance = this.#alive;
    return new Scene(instance, this.#call(call, args).answer);
  }

  #call(call, args) {
    const isList = Array.isArray(args[0]);
    const files = isList ? [...args[0]] : [{ bytes: args[0], name: args[1] ?? "" }];
    const options = { ...(isList ? args[1] : args[2]) };
    // The main file, which refers to the others, comes first.
    const first = files.findIndex((file) => !BESIDE.test(file.name));
    if (first > 0) files.unshift(...files.splice(first, 1));
    for (const key of ["body", "static"]) {
      const own = options[key];
      if (!own) continue;
      // Another file may have the same name. A folder distinguishes them.
      const name = files.some((file) => file.name === own.name) ? `${key}/${own.name}` : own.name;
      files.push({ name, bytes: own.bytes });
      options[key] = name;
    }
    const request = { call, files: files.map((file) => file.name), options };
    return this.#alive.call(request, files.map((file) => bytesOf(file.bytes)));
  }
}

export async function load(source) {
  // Bundlers recognize this expression, and copy the file to their output.
  const module = await compile(source, () => new URL("mocap.wasm", import.meta.url), "mocap.wasm");
  return new Mocap(module, await WebAssembly.instantiate(module, {}));
}
