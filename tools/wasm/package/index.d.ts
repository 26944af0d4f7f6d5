import type {
  Axis, BoneNames, CharacterTargetOptions, EditStep, Job, InputCallOptions, RobotFormatName, RobotTargetOptions, SizeCallOptions, SourceFramesOptions,
  SourceSpaceOptions, StepName, Unit, WrittenExtension, BvhOutputCallOptions,
} from "./options.js";

export * from "./options.js";

declare global {
  // TypeScript without `lib: ["esnext.disposable"]` lacks this symbol. With the lib, this declaration repeats it.
  interface SymbolConstructor {
    readonly dispose: unique symbol;
  }
}

/** A file and its name. The extension determines the format if the contents do not. */
export interface File {
  name: string;
  bytes: Bytes;
}

export type Bytes = Uint8Array | ArrayBuffer | string;

/** A time: seconds from the start, or a frame of the file, from 0. */
export type Moment = { seconds: number } | { frame: number };

/**
 * The joints of the VRM humanoid's bones; null for an absent bone. mocap finds the other bones. `follow` has joints that follow
 * a bone or another joint instead of their parents.
 */
export type Bones = Record<string, string | null | Record<string, string>>;

export interface ReadOptions extends InputCallOptions {
  /** Whether to reduce a constant track to one key. Default: true. */
  collapseKeys?: boolean;
  /**
   * Whether to compute the SHA-256 of the file, for `metadata.origin`. Default: true. Without the hash, reading takes half as
   * long.
   */
  hash?: boolean;
  /** The mesh that shows the skeleton in a `.glb`. Default: `"skinned"`. */
  skeletonMesh?: "skinned" | "segmented" | "none";
  /** Read the meshes of a glTF file. */
  gltfMeshes?: boolean;
  /** Also read the morph targets of meshes, for the sliders of a player. */
  morphTargets?: boolean;
}

export interface ConvertOptions extends SourceSpaceOptions, SourceFramesOptions {
  /** The unit of the result. Default: metres. */
  outUnit?: Unit;
  /** The up axis of the result. Default: `"y"`. */
  outUp?: Axis;
  /** Keep the unit and the axes of the file, unless `outUnit` or `outUp` is given. */
  keepUnits?: boolean;
  bones?: Bones;
  /** The first time to keep. */
  first?: Moment;
  /** The last time to keep. */
  last?: Moment;
  /** The names of joints in the result: a naming scheme of a program or dataset, or a name for each bone. */
  names?: BoneNames | Bones;
}

/** The error bound of a file. */
export type ErrorOptions = Omit<SizeCallOptions, "compress">;

export interface GlbOptions extends ErrorOptions {
  /** The storage of keys. Default: `"none"`, 32-bit floats. */
  compress?: SizeCallOptions["compress"];
  /** Also write constant tracks as animation channels. */
  keepConstant?: boolean;
  /** Write only the skeleton and its motion, without meshes and materials; in FBX, without the skin. */
  skeletonOnly?: boolean;
}

export type BvhOptions = BvhOutputCallOptions;

export interface EditOptions {
  /** The second motions of the steps that take one, in order. */
  others?: Scene[];
  /** The joints of bones, to correct mocap's choice. */
  bones?: Bones;
}

export interface RetargetOptions extends CharacterTargetOptions {
  /** Bones of the motion. */
  bones?: Bones;
  /** Bones of the character. */
  characterBones?: Bones;
  /** The name of the clip. Default: the name of the motion's file. */
  name?: string;
  /** Whether `toPlayer` shows the angles between the limbs and the source's limbs. Default: `false`. */
  limbAngles?: boolean;
}

/** A problem of a file, with its location. Lines and columns are counted from 1. */
export interface Diagnostic {
  code: string;
  message: string;
  severity?: "error" | "warning";
  file?: string;
  line?: number;
  column?: number;
  /** The number of characters, starting at `column`. */
  length?: number;
  /** The line, or a part of a long line. */
  text?: string;
  /** The location in a JSON file, as a JSON Pointer. */
  pointer?: string;
  joint: string | null;
  expected: string | null;
  found: string | null;
  help: string | null;
  /** The number of occurrences. */
  count: number;
}

/** A decision about a value that the file does not state. */
export interface Assumption {
  topic: string;
  choice: string;
  reason: string;
  confidence?: "sure" | "likely" | "unsure";
}

/**
 * An error. `code` is a code of the library, or `"out-of-memory"`, `"defect"` or `"freed"`. After `"out-of-memory"` and
 * `"defect"`, all earlier scenes are invalid. The module continues with fresh memory.
 */
export class MocapError extends Error {
  readonly code: string;
  /** The message without the location. */
  readonly reason: string;
  readonly file?: string;
  readonly line?: number;
  readonly column?: number;
  readonly length?: number;
  readonly text?: string;
  readonly pointer?: string;
  readonly joint?: string;
  readonly expected?: string;
  readonly found?: string;
  readonly help?: string;
  readonly warnings: Diagnostic[];
}

/**
 * The keys of one track. `values` and `ticks` are views into the module's memory, made on each access. Use them before the next
 * call of the module, or copy them with `slice()`.
 */
export interface Keys {
  /** The number of keys. */
  readonly length: number;
  /** x, y, z of each key, or x, y, z, w of a rotation. */
  readonly values: Float32Array;
  /** The tick of each key. */
  readonly ticks: Float64Array;
  /** Whether the ticks are 0, 1, 2, ... */
  readonly isEveryTick: boolean;
}

export interface Channel {
  nodeName: string;
  /** The index of the node; null if the channel drives none. */
  node: number | null;
  positions: Keys;
  rotations: Keys;
  scales: Keys;
}

export interface Animation {
  name: string;
  ticksPerSecond: number;
  /** The duration in ticks, from the first frame to the last. */
  duration: number;
  frameCount: number;
  channels: Channel[];
}

export interface Node {
  name: string;
  kind: "joint" | "end_site" | "group";
  /** The index of the parent; null for the root. Parents precede their children. */
  parent: number | null;
  rotationOrder: string | null;
  /** The lines of the file that define the node. */
  source: { name: number; offset: number | null; channels: number | null } | null;
  humanoidBone: string | null;
  /**
   * The role of a VRM animation's node for the face. X of the translation is the weight of an expression. The rotation is the
   * gaze.
   */
  face: { preset: string } | { custom: string } | { look_at: { offset_from_head?: [number, number, number] } } | null;
  /** The rest transform relative to the parent: 16 numbers in column-major order; a view, as in `Keys`. */
  readonly transform: Float32Array;
}

/** The matrices of all nodes, 16 numbers each, in column-major order. The views are valid until the scene is posed again. */
export interface Pose {
  nodeToWorld: Float32Array;
  nodeToParent: Float32Array;
}

/** A written file, with its warnings and report. */
export interface Written {
  bytes: Uint8Array;
  assumptions: Assumption[];
  warnings: Diagnostic[];
  /** The report of a written format: `nodes`, `notes`, `renamed`, and the error `achieved`. */
  report?: Record<string, unknown>;
}

/** A table over time. Row `i` is at `i / frameRate` seconds. */
export interface Table {
  frameRate: number;
  frameCount: number;
  /** The names of the columns. */
  columns: string[];
  /**
   * The unit of each column, such as `"deg"`, `"m"` or `"N"`. The unit of an analog channel is the file's, which may be empty.
   */
  units: string[];
  /** The values row by row, with a value for each column; a copy. */
  values: Float64Array;
  /** Decisions, and skipped data. */
  notes: string[];
}

/** The data of a C3D file besides markers. Lengths are in metres with +Y up, times in seconds from the first frame. */
export interface Recorded {
  events: { time: number; label: string; context: string; subject: string }[];
  analog_rate: number;
  samples_per_frame: number;
  channels: { name: string; unit: string }[];
  plates: Record<string, unknown>[];
}

/** The result of `Scene.chain`. Matrices are lists of rows. */
export interface Chain {
  chain: ChainMatrix[];
  pointInWorld: [number, number, number] | null;
}

export interface ChainMatrix {
  /** `J0`, `L1`, `J1`, ... */
  symbol: string;
  joint: string;
  node: number;
  matrix: number[][];
  /** The product up to this matrix. */
  product: number[][];
  /** The order of the angles of a J, such as `ZYX` for Rz Ry Rx. */
  order?: string;
  /**
   * The angles of a J in degrees, in this order. Positive angles turn counter-clockwise for a viewer towards whom the axis
   * points.
   */
  degrees?: [number, number, number];
}

/** The residuals of a skeleton that was solved from markers; lengths in metres. */
export interface Solved {
  markers: Record<string, unknown>[];
  rms_of_seconds: number[];
  joints: Record<string, unknown>[];
  swaps: Record<string, unknown>[];
  filled: { joint: string; first: number; last: number }[];
  frames: number;
}

/**
 * A scene in the module's memory. A scene never changes. `free()` or `using` frees it immediately, the garbage collector later.
 */
export class Scene {
  private constructor();
  readonly nodes: Node[];
  readonly animations: Animation[];
  readonly meshCount: number;
  /** The metadata, as in the JSON of `mocap dump --json`. */
  readonly metadata: Record<string, unknown>;
  readonly warnings: Diagnostic[];
  /** The assumptions of the conversion to this scene. `Mocap.check` returns everything that a file does not state. */
  readonly assumptions: Assumption[];
  /** The report on a retargeted scene's quality, or on the changes of each edit step, as `--json` prints it. */
  readonly reports?: Record<string, unknown>[];
  pose(tick: number, animation?: number): Pose;
  /**
   * The separate matrices from the root to a joint at a tick of the first animation, T = J0 L1 J1 L2 J2 ... `point` is in the
   * joint's coordinate frame.
   */
  chain(joint: string, tick?: number, point?: [number, number, number] | null): Chain;
  /** Returns a copy in metres with +Y up, or in the unit and axes of the options. */
  convert(options?: ConvertOptions): Scene;
  /**
   * Returns a copy whose animations are edited by steps in order. The steps are steps of `mocap edit`: `["mirror", {step:
   * "smooth", "cut-off": 8}]`. Lengths in steps are in metres. Steps also change a rest pose in the first frame; `convert`
   * drops the pose first.
   */
  edit(steps: EditStep[], options?: EditOptions): Scene;
  /** Retargets this motion to a character from `Mocap.readCharacter`. */
  retarget(character: Scene, options?: RetargetOptions): Scene;
  /**
   * Begins to retarget a live motion of this skeleton to a robot, pose by pose. With two passes (the default), joints are
   * smooth and the delay is 0.6 s. With one pass, the delay is 0.1 s. `fps` is from 1 to 1000; the default is the rate of the
   * first animation.
   */
  robotStream(robot: Scene, options?: RobotStreamOptions): RobotStream;
  /**
   * Scores a motion of a robot against this reference, as `mocap score` does. The motion is the result of `retarget` to the
   * robot, or a file with the positions of its joints that was read with the robot as `body`. Returns the report with `scores`
   * and `verdict`; docs/scores.md defines the scores.
   */
  score(motion: Scene, robot: Scene, options?: { bones?: Bones }): Record<string, unknown>;
  /**
   * Makes a figure of this character that motion matching steers. The motions come from scenes with any skeletons, or from a
   * database that `mocap index --pack` wrote. With `mirror`, the figure also uses the mirror images of the scenes' motions.
   */
  controller(moves: Scene[] | Bytes, options?: { mirror?: boolean }): Controller;
  /**
   * Returns GLB in metres with +Y up. For a retargeted glTF or VRM character, returns its file with the clip added; a `.gltf`
   * stays a `.gltf`.
   */
  toGlb(options?: GlbOptions): Uint8Array;
  /** Returns the motion of a humanoid as a VRM animation. */
  toVrma(options?: GlbOptions): Uint8Array;
  /**
   * The first animation as a packed clip, in metres with +Y up. Joints stay within `maxError` metres of their positions
   * (default: 0.001).
   */
  toMclip(options?: ErrorOptions): Uint8Array;
  /** Returns binary FBX in centimetres with +Y up. */
  toFbx(options?: ErrorOptions): Uint8Array;
  /** Returns BVH in the unit and the axes of the scene. */
  toBvh(options?: BvhOptions): string;
  /** Returns CSV with a row for each frame and joint. */
  toCsv(): string;
  /** Draws a contact sheet: poses over time, as `mocap sheet` does. */
  toPng(options?: { name?: string }): Uint8Array;
  /**
   * The joint values of a robot's motion. The scene must be the result of `retarget` to a robot that `readCharacter` has read
   * from URDF or MJCF. `write` makes files of these values, in a layout of `RobotFormatName`.
   */
  robotMotion(): RobotMotion;
  /** The clip in the format of `mocap view`'s player, which the drop page uses. */
  toPlayer(name: string): PlayerClip;
  /**
   * The joint angles of a humanoid in degrees, by biomechanical conventions, and the position of its pelvis; see
   * docs/biomechanics.md.
   */
  jointAngles(): Table;
  /** The ground reaction force, centre of pressure and free moment of each force plate of a C3D file; see docs/markers.md. */
  groundForces(): Table;
  /** The analog channels of a C3D file. */
  analog(): Table;
  /**
   * Heel strikes, toe offs, strides and means of a person, or the names of an animal's gaits, as `mocap gait --json`
   * prints them.
   */
  gait(): Record<string, unknown>;
  /** Events, channels and force plates of a C3D file; null if it has none. */
  readonly recorded: Recorded | null;
  /** The residuals of a skeleton solved from markers; null for other scenes. */
  readonly solved: Solved | null;
  /** Returns the JSON of `mocap dump --raw --json`. */
  toJson(): string;
  /**
   * Writes a file, with warnings and assumptions. `format` is "csv", "json", "png", the extension of a written format, or a
   * layout of a robot. A `.gltf` has its buffer embedded. An option without effect on the format is an error.
   */
  write(format: WrittenExtension | RobotFormatName | "csv" | "json" | "png", options?: GlbOptions | BvhOptions): Written;
  free(): void;
  [Symbol.dispose](): void;
}

/** The input of `mocap view`'s player; src/render/view/clip.js documents the description. */
export interface PlayerClip {
  description: Record<string, unknown>;
  /** The ids in the description, with their bytes. */
  blocks: [string, Uint8Array][];
  /** The parts of the skin that are not shown, with reasons. */
  leftOut: string[];
  /** Assumptions about values that the file does not state. */
  assumptions: Assumption[];
  rootOffset: { policy: "replace" | "add"; reason: string; confidence: string } | null;
}

/**
 * A packed clip, from which poses can be decoded at any tick. `free()` or `using` frees it immediately, the garbage collector
 * later.
 *
 *     const clip = mocap.openClip(bytes);
 *     const pose = new Float32Array(clip.poseLength);
 *     clip.sample(seconds * clip.ticksPerSecond, pose);
 */
export class PackedClip {
  private constructor();
  readonly nodes: { name: string; parent: number | null; isEndSite: boolean }[];
  readonly ticksPerSecond: number;
  /** The last tick; the first is 0. */
  readonly duration: number;
  readonly frameCount: number;
  /** The largest distance of a joint from its position in the source, in metres. */
  readonly maxError: number;
  /** The bytes of the file. */
  readonly bytes: number;
  /** The number of values of a pose: ten per node. */
  readonly poseLength: number;
  /**
   * Fills and returns `pose`, with ten numbers per node, relative to its parent: translation x, y, z, rotation x, y, z, w,
   * scale x, y, z. Ticks outside the clip give the first or last pose. The call allocates no memory.
   */
  sample(tick: number, pose: Float32Array): Float32Array;
  free(): void;
  [Symbol.dispose](): void;
}

/** A motion of a robot, with +Z up. Values are stored frame by frame. */
export interface RobotMotion {
  /** Frames per second. */
  fps: number;
  frames: number;
  /** The joints that move, with their limits in radians or metres; `null` without a limit. */
  joints: { name: string; lower: number | null; upper: number | null; velocity?: number }[];
  /** Whether the left and the right foot of the source are at rest. */
  contacts: [boolean, boolean][];
  /** The base: x, y, z in metres. */
  rootPositions: Float64Array;
  /** The rotation of the base: x, y, z, w. */
  rootRotations: Float64Array;
  /** The joints, in radians or metres. */
  positions: Float64Array;
}

export interface RobotStreamOptions extends Omit<RobotTargetOptions, "timeScale"> {
  /** Poses per second. Default: the rate of the first animation. */
  fps?: number;
  /** Bones of the motion. */
  bones?: Bones;
  /** Links of the robot. */
  characterBones?: Bones;
}

/** Frames of a robot, with the values of `RobotMotion`. */
export type RobotFrames = Pick<RobotMotion, "frames" | "contacts" | "rootPositions" | "rootRotations" | "positions">;

/**
 * Retargets a stream of poses to a robot, with a delay of `delay` seconds. `free()` or `using` frees it immediately, the
 * garbage collector later.
 *
 *     const stream = skeleton.robotStream(g1, { fps: 60 });
 *     const frame = stream.push(skeleton.pose(tick).nodeToParent);    // 60 times a second
 *     if (frame) send(frame.positions);
 */
export class RobotStream {
  private constructor();
  /** The joints, in the order of `positions`. */
  readonly jointNames: string[];
  readonly delay: number;
  /**
   * Takes the next pose: matrices of all nodes relative to their parents, 16 numbers each. Returns the finished frame; null at
   * first.
   */
  push(nodeToParent: ArrayLike<number>): RobotFrames | null;
  /** Ends the stream, and returns the remaining frames. */
  finish(): RobotFrames;
  /** The quality of the frames of the last 30 s, as `mocap robot --json` prints it; null before the first frame. */
  report(): Record<string, unknown> | null;
  free(): void;
  [Symbol.dispose](): void;
}

/**
 * A figure steered by motion matching (docs/search.md). It begins at the origin and faces +Z. A frame allocates no memory.
 * `free()` or `using` frees the figure immediately, the garbage collector later.
 *
 *     const figure = hero.controller([walk, run], { mirror: true });
 *     figure.steer(stick.x, stick.z);                      // 60 times a second
 *     draw(figure.nodeToWorld);
 */
export class Controller {
  private constructor();
  readonly nodeCount: number;
  /** The number of frames of all motions, at 60 frames per second. */
  readonly frames: number;
  /** The figure's position (x and z in metres), then its facing (x and z); a view. */
  readonly root: Float32Array;
  /** World matrices of all nodes of the character, in metres with +Y up, 16 numbers each, in column-major order; views. */
  readonly nodeToWorld: Float32Array;
  readonly nodeToParent: Float32Array;
  /**
   * Advances by one frame, 1/60 s, with a velocity over the ground in m/s. The figure faces the vector `look`, or the direction
   * of its velocity if `look` is zero. Velocity and facing change smoothly. Seen from behind a figure that faces +Z, right is
   * -X.
   */
  steer(x: number, z: number, lookX?: number, lookZ?: number): void;
  /**
   * Advances by one frame. The 12 numbers are x and z of the wanted positions in 20, 40 and 60 frames, then x and z of the
   * wanted facings.
   */
  follow(trajectory: ArrayLike<number>): void;
  free(): void;
  [Symbol.dispose](): void;
}

/** The module, ready to read. */
export class Mocap {
  /**
   * In Chromium's main thread, call `load()` instead, because this thread cannot instantiate modules above 8 MB synchronously.
   */
  constructor(module: WebAssembly.Module, instance?: WebAssembly.Instance);
  /** Reads a file, or several files that belong together, such as `.amc` and `.asf`. */
  read(bytes: Bytes, name: string, options?: ReadOptions): Scene;
  read(files: File[], options?: ReadOptions): Scene;
  /** Reads a character for `Scene.retarget`, or a robot of URDF or MJCF. */
  readCharacter(bytes: Bytes, name: string, options?: ReadOptions): Scene;
  readCharacter(files: File[], options?: ReadOptions): Scene;
  /** Opens a packed clip (`.mclip`) to decode single poses. `read` decodes the whole clip to a scene instead. */
  openClip(bytes: Bytes, name?: string): PackedClip;
  /**
   * Runs a job on files in memory, as `mocap run` does on a disk: `{source: {inputs: ["walk.bvh"]}, steps: ["mirror"], write:
   * {output: "walk.glb"}}`. `mocap run --print-job` prints the job of a command line. The result has the output files; nothing
   * is written to a disk. A job with `graph` makes a motion graph. A job with `walk: {seconds: 60}` makes a walk over a graph;
   * its inputs are clips, or a graph and its clips.
   */
  run(job: Job, files: File[]): JobReport;
  /** The steps of `Scene.edit`, with their effects and options. */
  readonly steps: StepInfo[];
  /**
   * Returns the problems of a file, and the properties that it does not state. Contents of the file never cause an exception.
   */
  check(bytes: Bytes, name: string, options?: ReadOptions): Checked;
  check(files: File[], options?: ReadOptions): Checked;
  /** The memory of the module, in bytes. */
  readonly memory: number;
}

export interface StepInfo {
  name: StepName;
  help: string;
  /** Whether the step takes a second motion from `EditOptions.others`. */
  takesOther: boolean;
  /**
   * The options of the step. `takes` is the value in the command line's help, such as `HZ` or `true|false`; `words` are the
   * possible values of a `WORD`.
   */
  keys: { name: string; takes: string; words?: string[] }[];
}

/** The report of a job. */
export interface JobReport {
  /** The output files; the last file has the name in the job. */
  files: { name: string; bytes: Uint8Array }[];
  /** Decisions, chosen options and skipped data, one sentence each. */
  notes: string[];
  warnings: Diagnostic[];
  /** The data of the inputs that the output lacks, counted by kind; each kind is also a warning. */
  losses?: { kind: string; count: number }[];
  /** The changes of each step. */
  steps?: object[];
  /** The retargeting quality of each motion. */
  clips?: object[];
  /** The rows of a survey. */
  survey?: object[];
  /** The size of the motion graph. */
  graph?: { clips: number; transitions: number; seconds: number; kept_seconds: number; left_out: string[] };
  /**
   * The walk over a motion graph: the begins of its transitions in seconds, the largest distance of a transition in metres, and
   * the deviation from its path in metres and degrees.
   */
  walk?: {
    frames: number;
    seconds: number;
    transitions: number[];
    largest_distance: number;
    path: null | { length: number; mean_distance: number; largest_distance: number; mean_angle: number; largest_angle: number };
    feet: object | null;
  };
  /** The result that is worse than the job allows. */
  problem?: string;
}

export interface Checked {
  status: "ok" | "warning" | "error";
  diagnostics: Diagnostic[];
  assumptions: Assumption[];
}

/**
 * Loads `mocap.wasm`. `source` is its address, its bytes or a compiled module; the default is the file beside this script.
 * Other contents, such as an error page of a server, cause an error with an explanation.
 */
export function load(source?: string | URL | ArrayBuffer | Uint8Array | WebAssembly.Module): Promise<Mocap>;
