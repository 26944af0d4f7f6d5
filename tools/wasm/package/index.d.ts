import type {
  Axis, BoneNames, CharacterTargetOptions, EditStep, Job, InputCallOptions, RobotFormatName, RobotTargetOptions, SizeCallOptions, SourceFramesOptions,
  SourceSpaceOptions, StepName, Unit, WrittenExtension, BvhOutputCallOptions,
} from "./options.js";

export * from "./options.js";

declare global {
  // Without `lib: ["esnext.disposable"]` TypeScript does not know it; with it, this says the same again.
  interface SymbolConstructor {
    readonly dispose: unique symbol;
  }
}

/** A file and its name. The extension tells the format if the contents do not. */
export interface File {
  name: string;
  bytes: Bytes;
}

export type Bytes = Uint8Array | ArrayBuffer | string;

/** A time: seconds from the start, or a frame of the file, from 0. */
export type Moment = { seconds: number } | { frame: number };

/**
 * The joints of bones of the VRM humanoid; null for a bone that there is not. Others are searched for. `follow` has joints
 * that follow a bone, or another joint, instead of their parents.
 */
export type Bones = Record<string, string | null | Record<string, string>>;

export interface ReadOptions extends InputCallOptions {
  /** Whether a track that never changes is one key. Default: true. */
  collapseKeys?: boolean;
  /** Whether to compute the SHA-256 of the file, for `metadata.origin`. Default: true; reading takes half as long without. */
  hash?: boolean;
  /** The mesh that shows the skeleton in a `.glb`. Default: `"skinned"`. */
  skeletonMesh?: "skinned" | "segmented" | "none";
  /** Read the meshes of a glTF file. */
  gltfMeshes?: boolean;
  /** Read the morph targets of meshes too, for the sliders of a player. */
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
  /** The first moment to keep. */
  first?: Moment;
  /** The last moment to keep. */
  last?: Moment;
  /** What joints are called in the result: the names of a program or of a collection, or one for each bone. */
  names?: BoneNames | Bones;
}

/** How far a file may be from the scene. */
export type ErrorOptions = Omit<SizeCallOptions, "compress">;

export interface GlbOptions extends ErrorOptions {
  /** How keys are stored. Default: `"none"`, as 32-bit floats. */
  compress?: SizeCallOptions["compress"];
  /** Write constant tracks as animation channels too. */
  keepConstant?: boolean;
  /** Leave out the meshes, the materials and all else beside the skeleton and its motion; in FBX the skin. */
  skeletonOnly?: boolean;
}

export type BvhOptions = BvhOutputCallOptions;

export interface EditOptions {
  /** The second motions of those steps that take one, in their order. */
  others?: Scene[];
  /** Which joint is which bone, where the guess is wrong. */
  bones?: Bones;
}

export interface RetargetOptions extends CharacterTargetOptions {
  /** Bones of the motion. */
  bones?: Bones;
  /** Bones of the character. */
  characterBones?: Bones;
  /** The name of the clip. Default: the name of the motion's file. */
  name?: string;
  /** Whether `toPlayer` shows how far limbs point from those of the motion. Default: `false`. */
  limbAngles?: boolean;
}

/** Something that is wrong with a file, and where it is. Lines and columns are counted from 1. */
export interface Diagnostic {
  code: string;
  message: string;
  severity?: "error" | "warning";
  file?: string;
  line?: number;
  column?: number;
  /** Characters from `column` on. */
  length?: number;
  /** The line, or the part of a long one. */
  text?: string;
  /** Where it is in a file of JSON. */
  pointer?: string;
  joint: string | null;
  expected: string | null;
  found: string | null;
  help: string | null;
  /** How often it occurs. */
  count: number;
}

/** A decision that the file does not state. */
export interface Assumption {
  topic: string;
  choice: string;
  reason: string;
  confidence?: "sure" | "likely" | "unsure";
}

/**
 * An error. `code` is one of the library's, or `"out-of-memory"`, `"defect"` or `"freed"`. After `"out-of-memory"` and
 * `"defect"` the scenes that were read before are gone; the module goes on with fresh memory.
 */
export class MocapError extends Error {
  readonly code: string;
  /** The message without where it is. */
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
 * The keys of one track. `values` and `ticks` are views into the module's memory, made when they are asked for: use them
 * before the next call of the module, or copy them with `slice()`.
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
  /** The index of the node; null where it drives none. */
  node: number | null;
  positions: Keys;
  rotations: Keys;
  scales: Keys;
}

export interface Animation {
  name: string;
  ticksPerSecond: number;
  /** From the first frame to the last, in ticks. */
  duration: number;
  frameCount: number;
  channels: Channel[];
}

export interface Node {
  name: string;
  kind: "joint" | "end_site" | "group";
  /** The index of the parent, which stands before its children; null on the root. */
  parent: number | null;
  rotationOrder: string | null;
  /** The lines of the file that describe it. */
  source: { name: number; offset: number | null; channels: number | null } | null;
  humanoidBone: string | null;
  /** What the node of a VRM animation is on a face: X of its translation is the weight of an expression, its rotation the gaze. */
  face: { preset: string } | { custom: string } | { look_at: { offset_from_head?: [number, number, number] } } | null;
  /** Node to parent at rest, 16 numbers column by column; a view, as those of `Keys`. */
  readonly transform: Float32Array;
}

/** Matrices of all nodes, 16 numbers each, column by column; views, until the scene is posed again. */
export interface Pose {
  nodeToWorld: Float32Array;
  nodeToParent: Float32Array;
}

/** A file that was written, and what there is to say about it. */
export interface Written {
  bytes: Uint8Array;
  assumptions: Assumption[];
  warnings: Diagnostic[];
  /** Of a written format: `nodes`, `notes`, `renamed` and `achieved`, the error. */
  report?: Record<string, unknown>;
}

/** Columns over time. Row `i` is at `i / frameRate` seconds. */
export interface Table {
  frameRate: number;
  frameCount: number;
  /** The names of the columns. */
  columns: string[];
  /** The unit of each column, such as `"deg"`, `"m"` or `"N"`; of analog channels that of the file, which may be empty. */
  units: string[];
  /** Row after row, with a value for each column; a copy. */
  values: Float64Array;
  /** What was decided or left out. */
  notes: string[];
}

/** What a C3D file has beside markers; lengths in metres, +Y up, times in seconds from the first frame. */
export interface Recorded {
  events: { time: number; label: string; context: string; subject: string }[];
  analog_rate: number;
  samples_per_frame: number;
  channels: { name: string; unit: string }[];
  plates: Record<string, unknown>[];
}

/** What `Scene.chain` returns; matrices are rows. */
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
  /** The angles of a J in degrees, in this order; positive ones turn counter-clockwise for a viewer towards whom the axis points. */
  degrees?: [number, number, number];
}

/** How well a skeleton that was solved from markers explains them; lengths in metres. */
export interface Solved {
  markers: Record<string, unknown>[];
  rms_of_seconds: number[];
  joints: Record<string, unknown>[];
  swaps: Record<string, unknown>[];
}

/** A scene in the module's memory. It never changes. `free()` or `using` frees it at once, the garbage collector some time. */
export class Scene {
  private constructor();
  readonly nodes: Node[];
  readonly animations: Animation[];
  readonly meshCount: number;
  /** As in the JSON of `mocap dump --json`. */
  readonly metadata: Record<string, unknown>;
  readonly warnings: Diagnostic[];
  /** What was decided when this scene was converted. `Mocap.check` has all that a file leaves open. */
  readonly assumptions: Assumption[];
  /** Of a retargeted scene, how far it is from its source; of an edited one, what each step changed: as `--json` prints it. */
  readonly reports?: Record<string, unknown>[];
  pose(tick: number, animation?: number): Pose;
  /**
   * The matrices from the root to a joint at a tick of the first animation, T = J0 L1 J1 L2 J2 ..., each apart; `point` is attached to the
   * joint, in its axes.
   */
  chain(joint: string, tick?: number, point?: [number, number, number] | null): Chain;
  /** A copy in metres with +Y up, or as the options say. */
  convert(options?: ConvertOptions): Scene;
  /**
   * A copy whose first animation steps have changed in their order, those of `mocap edit`: `["mirror", {step: "smooth",
   * "cut-off": 8}]`. Lengths in steps are metres. A rest pose in the first frame is changed with it: `convert` drops it.
   */
  edit(steps: EditStep[], options?: EditOptions): Scene;
  /** This motion on a character that `Mocap.readCharacter` has read. */
  retarget(character: Scene, options?: RetargetOptions): Scene;
  /**
   * Begins a motion of this skeleton on a robot that comes pose by pose. With two passes, the default, joints are smooth and
   * frames come 0.6 s later, with one 0.1 s. `fps` is from 1 to 1000, and the rate of the first animation by default.
   */
  robotStream(robot: Scene, options?: RobotStreamOptions): RobotStream;
  /**
   * A figure of this character that is led by motion matching: by the motions of scenes, on any skeletons, or of a database
   * that `mocap index --pack` wrote. With `mirror`, motions of scenes are there with left and right exchanged too.
   */
  controller(moves: Scene[] | Bytes, options?: { mirror?: boolean }): Controller;
  /** In metres with +Y up. Of a retargeted glTF or VRM character: its file with the clip added; a `.gltf` stays one. */
  toGlb(options?: GlbOptions): Uint8Array;
  /** The motion of a humanoid as a VRM animation. */
  toVrma(options?: GlbOptions): Uint8Array;
  /** The first animation as a packed clip, in metres with +Y up. Joints are at most `maxError` metres from their positions: 0.001 by default. */
  toMclip(options?: ErrorOptions): Uint8Array;
  /** As binary FBX in centimetres with +Y up. */
  toFbx(options?: ErrorOptions): Uint8Array;
  /** In the unit and the axes of the scene. */
  toBvh(options?: BvhOptions): string;
  /** A row for each frame and joint. */
  toCsv(): string;
  /** A contact sheet: poses over time, as `mocap sheet` draws them. */
  toPng(options?: { name?: string }): Uint8Array;
  /**
   * The numbers of a motion on a robot, where this is one: `retarget` onto what `readCharacter` returns of URDF or MJCF. `write`
   * makes files of them too, in a layout of `RobotFormatName`.
   */
  robotMotion(): RobotMotion;
  /** The clip for the player of `mocap view`, as the drop page shows it. */
  toPlayer(name: string): PlayerClip;
  /** The joint angles of a humanoid in degrees, as biomechanics states them, and the position of its pelvis; docs/biomechanics.md. */
  jointAngles(): Table;
  /** Of each force plate of a C3D file: the force of the ground, the centre of pressure, the free moment; docs/markers.md. */
  groundForces(): Table;
  /** The analog channels of a C3D file. */
  analog(): Table;
  /** Heel strikes, toe offs, strides and their means, as `mocap gait --json` prints them. */
  gait(): Record<string, unknown>;
  /** Events, channels and force plates of a C3D file; null where it has none. */
  readonly recorded: Recorded | null;
  /** How a skeleton was solved from markers; null for others. */
  readonly solved: Solved | null;
  /** As `mocap dump --raw --json`. */
  toJson(): string;
  /**
   * As those above, with warnings and assumptions: "csv", "json", "png", the extension of a written format, or the layout
   * of a robot. A `.gltf` has its buffer within. An option that has no effect on the format is an error.
   */
  write(format: WrittenExtension | RobotFormatName | "csv" | "json" | "png", options?: GlbOptions | BvhOptions): Written;
  free(): void;
  [Symbol.dispose](): void;
}

/** What the player of `mocap view` draws; src/render/view/clip.js says what the description holds. */
export interface PlayerClip {
  description: Record<string, unknown>;
  /** The bytes that the description names by these ids. */
  blocks: [string, Uint8Array][];
  /** What is not shown of the skin, and why. */
  leftOut: string[];
  /** What the file does not state. */
  assumptions: Assumption[];
  rootOffset: { policy: "replace" | "add"; reason: string; confidence: string } | null;
}

/**
 * A packed clip, whose pose at any tick is computed from the packed form. `free()` or `using` frees it at once, the garbage
 * collector some time.
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
  /** The numbers of a pose: ten a node. */
  readonly poseLength: number;
  /**
   * Fills `pose` with ten numbers a node, from the node to its parent, and returns it: translation x, y, z, rotation x, y, z,
   * w, scale x, y, z. Before the first tick that of the first, after the last that of the last. It allocates nothing.
   */
  sample(tick: number, pose: Float32Array): Float32Array;
  free(): void;
  [Symbol.dispose](): void;
}

/** A motion on a robot: +Z is up. Frame after frame stand together. */
export interface RobotMotion {
  /** Frames a second. */
  fps: number;
  frames: number;
  /** The joints that move, with their limits in radians or metres; `null` where there is none. */
  joints: { name: string; lower: number | null; upper: number | null; velocity?: number }[];
  /** Whether the left and the right foot of the source are at rest. */
  contacts: [boolean, boolean][];
  /** The base: x, y, z in metres. */
  rootPositions: Float64Array;
  /** Its rotation: x, y, z, w. */
  rootRotations: Float64Array;
  /** The joints, in radians or metres. */
  positions: Float64Array;
}

export interface RobotStreamOptions extends RobotTargetOptions {
  /** Poses a second. Default: the rate of the first animation. */
  fps?: number;
  /** Bones of the motion. */
  bones?: Bones;
  /** Links of the robot. */
  characterBones?: Bones;
}

/** Frames of a robot, with the numbers of `RobotMotion`. */
export type RobotFrames = Pick<RobotMotion, "frames" | "contacts" | "rootPositions" | "rootRotations" | "positions">;

/**
 * A motion on a robot while it comes: poses in, frames out, `delay` seconds later. `free()` or `using` frees it at once, the
 * garbage collector some time.
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
  /** Takes the next pose: matrices of all nodes to their parents, 16 numbers each. Gives the frame whose time has come; null at first. */
  push(nodeToParent: ArrayLike<number>): RobotFrames | null;
  /** The frames that are left, at the end. */
  finish(): RobotFrames;
  /** How well the frames of the last 30 s sit on the robot, as `mocap robot --json` prints it; null before the first frame. */
  report(): Record<string, unknown> | null;
  free(): void;
  [Symbol.dispose](): void;
}

/**
 * A figure that goes where it is asked to, by jumps between the frames of its motions (docs/search.md). It begins at the
 * origin and looks along +Z. Nothing is allocated for a frame. `free()` or `using` frees it at once, the garbage collector
 * some time.
 *
 *     const figure = hero.controller([walk, run], { mirror: true });
 *     figure.steer(stick.x, stick.z);                      // 60 times a second
 *     draw(figure.nodeToWorld);
 */
export class Controller {
  private constructor();
  readonly nodeCount: number;
  /** The frames of all motions, 60 in a second. */
  readonly frames: number;
  /** x and z of where it stands, in metres, then x and z of where it looks; a view. */
  readonly root: Float32Array;
  /** Matrices of all nodes of the character, in metres with +Y up, 16 numbers each, column by column; views. */
  readonly nodeToWorld: Float32Array;
  readonly nodeToParent: Float32Array;
  /**
   * Goes on by a frame, a sixtieth of a second, with a velocity over the ground in metres per second, looking along another
   * vector, or where it goes if that is zero. Velocity and direction change smoothly. Seen from behind a figure that looks
   * along +Z, right is along -X.
   */
  steer(x: number, z: number, lookX?: number, lookZ?: number): void;
  /** Goes on by a frame: 12 numbers, x and z of where it is to be in 20, 40 and 60 frames, then x and z of where it looks. */
  follow(trajectory: ArrayLike<number>): void;
  free(): void;
  [Symbol.dispose](): void;
}

/** The module, ready to read. */
export class Mocap {
  /** In the main thread of Chromium `load()` makes it: there a module of more than 8 MB cannot be waited for. */
  constructor(module: WebAssembly.Module, instance?: WebAssembly.Instance);
  /** Reads a file, or several that belong together, such as `.amc` and `.asf`. */
  read(bytes: Bytes, name: string, options?: ReadOptions): Scene;
  read(files: File[], options?: ReadOptions): Scene;
  /** Reads a character for `Scene.retarget`, or a robot of URDF or MJCF. */
  readCharacter(bytes: Bytes, name: string, options?: ReadOptions): Scene;
  readCharacter(files: File[], options?: ReadOptions): Scene;
  /** Opens a packed clip (`.mclip`), to sample poses from it without unpacking it. `read` makes a scene of it instead. */
  openClip(bytes: Bytes, name?: string): PackedClip;
  /**
   * Does a job on files in memory, as `mocap run` does it on a disk: `{source: {inputs: ["walk.bvh"]}, steps: ["mirror"],
   * write: {output: "walk.glb"}}`. `mocap run --print-job` prints the job of a command line.
   * Nothing is written: the files of the output are in the answer. A job with `graph` compares motions to a motion graph, one
   * with `walk: {seconds: 60}` makes a walk over it, of the clips at once or of a graph and its clips.
   */
  run(job: Job, files: File[]): JobReport;
  /** The steps of `Scene.edit`, with what each does and takes. */
  readonly steps: StepInfo[];
  /** What is wrong with a file, and what it leaves open; it never throws for what the file holds. */
  check(bytes: Bytes, name: string, options?: ReadOptions): Checked;
  check(files: File[], options?: ReadOptions): Checked;
  /** Bytes of memory that the module has taken. */
  readonly memory: number;
}

export interface StepInfo {
  name: StepName;
  help: string;
  /** Whether it takes a second motion, of `EditOptions.others`. */
  takesOther: boolean;
  /** Its options: `takes` is as the help of the command line has it, such as `HZ` or `true|false`; `words` are those of a `WORD`. */
  keys: { name: string; takes: string; words?: string[] }[];
}

/** What a job has done. */
export interface JobReport {
  /** The files of the output; the last is the one that the job names. */
  files: { name: string; bytes: Uint8Array }[];
  /** What was decided, chosen and left out, a sentence each. */
  notes: string[];
  warnings: Diagnostic[];
  /** What the inputs have and the output has not, counted by kind; each is a warning too. */
  losses?: { kind: string; count: number }[];
  /** What each step changed. */
  steps?: object[];
  /** How well each motion is the same on the other body. */
  clips?: object[];
  /** The rows of a survey. */
  survey?: object[];
  /** How large the motion graph is. */
  graph?: { clips: number; transitions: number; seconds: number; kept_seconds: number; left_out: string[] };
  /**
   * What the walk over a motion graph is: when its transitions begin in seconds, the distance of the farthest in metres; how
   * near it is to the path that it follows, in metres and degrees.
   */
  walk?: {
    frames: number;
    seconds: number;
    transitions: number[];
    largest_distance: number;
    path: null | { length: number; mean_distance: number; largest_distance: number; mean_angle: number; largest_angle: number };
    feet: object | null;
  };
  /** What is worse than the job allows. */
  problem?: string;
}

export interface Checked {
  status: "ok" | "warning" | "error";
  diagnostics: Diagnostic[];
  assumptions: Assumption[];
}

/**
 * Loads `mocap.wasm`, by default the one beside this module: its address, its bytes, or a module that is compiled already.
 * What is no WebAssembly, such as the page that a server sends in place of a file, is an error that says so.
 */
export function load(source?: string | URL | ArrayBuffer | Uint8Array | WebAssembly.Module): Promise<Mocap>;
