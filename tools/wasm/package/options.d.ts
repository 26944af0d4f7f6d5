// Written by `MOCAP_WRITE=1 cargo test -p mocap-bindings`, from the documentation of Rust: do not edit.

import type { File } from "./index.js";

/** The options for reading the files of a job. */
export interface InputCallOptions {
  /** Read all rows of the motion, including those beyond the declared number of frames. */
  allRows?: boolean;
  /**
   * The body for arrays of rotations, such as AMASS files. FILE is a model of SMPL, SMPL-H or SMPL-X (.npz or .pkl), or a
   * file of any format with a figure. For arrays of a robot, FILE is the robot. Default: generic proportions, 1.70 m tall.
   */
  body?: File;
  /**
   * The animation to use of a file that has several: its name, or its number from 0; name:3 is the animation whose name is 3.
   * With all, a command for one motion uses the first.
   */
  clip?: Clips;
  /** Format of the input. Default: found from its contents, or else from its extension. */
  format?: Format;
  /**
   * The joints of a file of positions, to solve their rotations. A JSON file, or one of smpl22, smpl24, coco17, h36m,
   * mediapipe33, openpose25, mhr70, mhr127. Default: arrays with the joints of SMPL are solved.
   */
  joints?: string;
  /**
   * Lengths of bones that are solved from positions: the median over all frames; or the length in each frame, so that joints
   * match their positions.
   */
  lengths?: Lengths;
  /**
   * Solve a skeleton from the markers of a file. auto: a known marker set; auto:NAME: the markers of one subject; FILE: a
   * JSON object from labels to landmarks. Default: markers stay points.
   */
  markers?: string;
  /** Play at this number of frames per second: the motion keeps its frames, and becomes slower or faster. */
  retime?: number;
  /** How the root's OFFSET and its position channels combine. Default: `"auto"`. */
  rootOffset?: RootOffset;
  /** A static trial: markers of a standing person. It may have more markers than the motion. */
  static?: File;
  /** Treat every warning as an error. */
  strict?: boolean;
}

/** The unit and the up axis of the inputs. */
export interface SourceSpaceOptions {
  /** Unit of length of the input: auto, m, dm, cm, mm, inch, cmu (5.6444 cm), or metres in one unit. */
  unit?: Unit;
  /** The up axis of the input; auto: from the feet to the head. */
  up?: SourceUp;
}

/** The frames to use from the inputs. They are selected before the unit and the axes are converted. */
export interface SourceFramesOptions {
  /** Whether to drop the first frame; auto: drop it if it is a rest pose and the motion jumps after it. Default: `"keep"`. */
  firstFrame?: "auto" | "drop" | "keep";
  /**
   * Resample to this number of frames per second, at the same playback speed. For an input without a valid rate, set its
   * rate.
   */
  frameRate?: number;
  /** Rest pose: zero (as in the file; in BVH all rotations are 0), t-pose, a-pose (arms 45 degrees down), or frame:N. */
  rest?: RestPoseSource;
  /** The root motion: kept, removed, or moved to a joint above the root. Default: `"keep"`. */
  root?: "keep" | "inPlace" | "extract";
  /** Insert the T-pose before the first frame, on the floor. */
  tPoseFirst?: boolean;
}

/** Compression options: fewer keys and bits, within a largest error. */
export interface SizeCallOptions {
  /** How to store the keys. Default with a largest error: int16, otherwise none. */
  compress?: "none" | "int16";
  /**
   * Remove keys and bits, but keep every joint and end site within this distance of its position in every frame, such as 1mm.
   * Fails if the format cannot keep this distance. Default with a compression: 1mm.
   */
  maxError?: Length;
  /**
   * Also keep points at this distance around each joint, such as the skin, within the largest error. ACL uses 3cm. Default:
   * 0, only joints and end sites.
   */
  shellDistance?: Length;
}

/** Options of BVH. */
export interface BvhOutputCallOptions {
  /** Which joints have position channels. Default: `"auto"`. */
  channels?: Channels;
  /** Decimals of every number. Default: enough to read back the same motion. */
  digits?: number;
  /** Order of the rotation channels. Default: each joint's own, or else ZXY. */
  order?: RotationOrder;
}

/** A character. */
export interface CharacterTargetOptions {
  /**
   * Feet in ground contact: lock holds a foot still while the source foot is in contact, free does not correct it. On a
   * character, lock applies only if the foot would slide more than the source foot. Default: `"lock"`.
   */
  feet?: Feet;
  /**
   * Hands that touch the body, each other or the floor: keep moves a hand to the place that the source hand touches, free
   * keeps the directions of the arms. Default: `"keep"`.
   */
  hands?: Hands;
  /** Scale of the path over the ground: auto, in proportion to the leg length; none, as in the source; or a factor. */
  scale?: Scale;
}

/** A robot. */
export interface RobotTargetOptions {
  /**
   * Feet in ground contact: lock holds a foot still while the source foot is in contact, free does not correct it. On a
   * character, lock applies only if the foot would slide more than the source foot. Default: `"lock"`.
   */
  feet?: Feet;
  /**
   * Height of the floor: auto, under the feet in contact; z=0, at height 0 of the motion's file; keep, at its mean height in
   * the motion, without changing heights. auto also lowers a foot that is slightly above the floor. Default: `"auto"`.
   */
  floor?: Floor;
  /**
   * Number of solver passes: 1 solves frame by frame, which is faster; 2 then solves all frames of a window together. The
   * second pass moves joints smoothly and without jumps, within the velocity limits of the robot's file. Default: 2.
   */
  passes?: 1 | 2;
  /**
   * Playback speed: auto slows a motion down just as far as the robot's limits of velocity and effort need, and a factor sets
   * the speed. The frame rate does not change.
   */
  timeScale?: TimeScale;
}

/** The extensions of the formats that are written. */
export type WrittenExtension = "bvh" | "vrma" | "glb" | "gltf" | "trc" | "fbx" | "usda" | "usdz" | "mclip" | "vmd";

/** The layouts of the numbers of a motion on a robot. */
export type RobotFormatName =
  | "npz"
  | "pkl"
  | "csv"
  | "qpos"
  | "gmr"
  | "unitree-csv"
  | "mjlab"
  | "beyondmimic"
  | "isaaclab"
  | "protomotions"
  | "mimickit"
  | "twist"
  | "asap"
  | "max"
  | "dynamics";

/** One piece of work, as `mocap run` takes it. Its kind has only the options that do something in it. */
export type Job = MotionJob | SurveyJob | GraphJob | WalkJob;

/** an angle of 0 degrees or more. */
export type Angle = number | `${number}`;

/** The joint of each bone, in a file or here. */
export type BoneMap = string | Record<string, string | null | Record<string, string>>;

/**
 * The naming scheme of a program or dataset for the joints of a humanoid.
 * `"vrm"`: The bones of the VRM 1.0 humanoid, such as `leftUpperLeg`.
 * `"mixamo"`: The skeletons of Mixamo, such as `mixamorig:LeftUpLeg`.
 * `"unreal"`: The mannequin of Unreal Engine, such as `thigh_l`.
 * `"cmu"`: BVH files of the CMU database, such as `LeftUpLeg`, with `LowerBack` as the spine.
 * `"godot"`: Godot's humanoid profile, such as `LeftUpperLeg`.
 * `"unity"`: Unity's humanoid avatars, such as `LeftUpperLeg`.
 * `"mhr"`: The Momentum Human Rig, such as `l_upleg`.
 * `"soma"`: SOMA, such as `LeftLeg`.
 */
export type BoneNames = "vrm" | "mixamo" | "unreal" | "cmu" | "godot" | "unity" | "mhr" | "soma";

/** Options of BVH. */
export interface BvhOutputOptions {
  /** Which joints have position channels. Default: `"auto"`. */
  channels?: Channels;
  /** Decimals of every number. Default: enough to read back the same motion. */
  digits?: number | null;
  /** Order of the rotation channels. Default: each joint's own, or else ZXY. */
  order?: RotationOrder | null;
  /** For a .bvh OUTPUT, also write OUTPUT.json with its provenance. Every command reads this file, including verify. */
  sidecar?: boolean;
}

/**
 * The joints with position channels.
 * `"auto"`: The ROOT, and joints whose position differs from their OFFSET in some frame.
 * `"3"`: Only the ROOT. Other joints keep their position of the first frame, and their position motion is lost.
 * `"6"`: Every joint.
 */
export type Channels = "auto" | "3" | "6";

/** A character. */
export interface CharacterTarget {
  /**
   * Feet in ground contact: lock holds a foot still while the source foot is in contact, free does not correct it. On a
   * character, lock applies only if the foot would slide more than the source foot. Default: `"lock"`.
   */
  feet?: Feet;
  /** The file of the character or the skeleton; for a robot, URDF or MuJoCo's MJCF. Default: `""`. */
  file?: string;
  /**
   * Hands that touch the body, each other or the floor: keep moves a hand to the place that the source hand touches, free
   * keeps the directions of the arms. Default: `"keep"`.
   */
  hands?: Hands;
  /**
   * Read the bones of the target from this JSON file, as `mocap skeleton --json` prints it for the target. Bones that the
   * file omits are searched for.
   */
  map?: BoneMap | null;
  /**
   * Largest allowed angle in degrees; beyond it, the job fails after writing, with the exit code 1. Four angles count: the
   * angle of a limb in any frame, and the mean angles of a limb's roll, of a line of the trunk and of a palm.
   */
  "max-angle"?: Angle | null;
  /** The names of the clips, in the order of the motions. Default: the names in the files. */
  "names-of-clips"?: string[];
  /** Drop the animations of the character. By default they are kept. */
  "replace-animations"?: boolean;
  /** Scale of the path over the ground: auto, in proportion to the leg length; none, as in the source; or a factor. */
  scale?: Scale;
}

export interface CleanWeights {
  /**
   * Largest distance over the ground from the resting place of a foot at which the foot still counts as in contact. Smoothing
   * makes a foot come to rest slowly. Unit: m. Default: `0.03`.
   */
  "contact-distance"?: number;
  /**
   * Longest gap between two contacts at one place at which mocap joins the contacts. A foot does not leave its place and
   * return in less than half a swing. Unit: s. Default: `0.15`.
   */
  "contact-gap"?: number;
  /**
   * Largest height of a foot above its resting level in a contact. It includes a heel that rolls off, but not a swing. Unit:
   * m. Default: `0.08`.
   */
  "contact-height"?: number;
  /**
   * Largest speed of a foot in contact after noise was removed. The residual of 2 degrees of noise moves a foot in stance by
   * about 0.2 m/s. Unit: m/s. Default: `0.4`.
   */
  "contact-speed"?: number;
  /**
   * Cost of an exchange of left and right limbs, added to the median change from frame to frame. It is twice the noise of an
   * estimate from video, so that noise does not cause an exchange. Unit: degrees. Default: `4.0`.
   */
  exchange?: number;
  /**
   * Time in which the weight of a hand contact rises and falls: three frames of video, so that arms do not jerk. Unit: s.
   * Default: `0.1`.
   */
  "hand-blend"?: number;
  /**
   * Distance between the centres of two hands that touch, for a body of 1.7 m: half of the thickness of each hand, and some
   * noise. Unit: m. Default: `0.13`.
   */
  "hand-distance"?: number;
  /**
   * Factor of `hand_distance` and `hand_speed` at which the weight of a hand contact is 0. Up to `hand_distance`, the weight
   * is 1. In between, the weight decreases, so that no joint jumps. Unit: 1. Default: `1.4`.
   */
  "hand-fade"?: number;
  /**
   * Largest distance by which mocap moves an arm to restore a hand contact, and by which the hand may miss this contact. The
   * noise of an estimate from video is not larger. Unit: m. Default: `0.1`.
   */
  "hand-noise"?: number;
  /**
   * Speed of a hand relative to the body below which the hand counts as resting on the body. A hand that passes by is faster.
   * Unit: m/s. Default: `0.15`.
   */
  "hand-speed"?: number;
  /**
   * Distance that counts as much as a radian, if mocap smooths positions and rotations together. The direction of a bone that
   * is shorter than this distance is less precise than its rotation. Unit: m. Default: `0.03`.
   */
  "joint-length"?: number;
  /**
   * Mean change of a bone, as a fraction of its length, above which the change is intended, as in a cartoon. Unit: 1.
   * Default: `0.15`.
   */
  "largest-length-change"?: number;
  /**
   * Largest angle by which a joint rotates towards its smoothed position: five times the noise of an estimate from video.
   * Unit: degrees. Default: `15.0`.
   */
  "largest-turn"?: number;
  /**
   * Least standard deviation of the noise of a rotation that mocap removes. Marker systems have less noise. Estimates from
   * video have 1 to 3 degrees. `tools/clean/check` tests this value. Unit: degrees. Default: `0.5`.
   */
  "least-angle"?: number;
  /**
   * Least standard deviation of position noise. It also applies to the displacement of the farthest joint by the noise of an
   * angle. Marker systems have less than 1 mm. Unit: m. Default: `0.0015`.
   */
  "least-distance"?: number;
  /**
   * Mean logarithm of the residuals above which a frame was certainly dropped. Of 42 clean cuts of 3 to 8 s at 30 and 60 Hz,
   * none has more than 0.22. In a test, 144 frames were removed while a joint rotated by 60 degrees per second: 142 have more
   * than 0.24. Unit: 1. Default: `0.23`.
   */
  "least-evidence"?: number;
  /**
   * As `least_evidence`, for a doubled frame. This value is lower, because the doubled frame itself is visible. Unit: 1.
   * Default: `0.02`.
   */
  "least-evidence-of-doubled"?: number;
  /**
   * Mean speed of feet in contact below which mocap does not lock them, if `clean` found little noise. Takes of marker
   * systems reach 0.18 m/s in runs, because contacts begin and end in motion. Unit: m/s. Default: `0.2`.
   */
  "least-skate"?: number;
  /**
   * Least speed of a joint, or of the body in body lengths, at which a dropped frame is inserted. Below 20 degrees per
   * second, changes between frames show only the rounding of a file. Unit: rad/s. Default: `0.35`.
   */
  "least-speed"?: number;
  /**
   * Mean change of a bone length from frame to frame above which the bone gets a constant length. Rounding of positions in
   * files causes smaller changes. Unit: m. Default: `0.001`.
   */
  "length-noise"?: number;
  /** Longest run of held frames that mocap fills. A longer run is a frozen pose, and may be intended. Unit: s. Default: `0.5`. */
  "longest-held"?: number;
  /**
   * Jerk that the smoother allows, as a fraction of the jerk that predicts the motion best. The smoother needs less jerk than
   * a prediction, because it also uses the frames after each frame. The value was chosen on seed 1 of `tools/clean`. If the
   * smoother cuts the peaks of the motion, mocap tries twice and eight times this value. Unit: 1. Default: `0.5`.
   */
  smoothing?: number;
  /**
   * Mixing factor of two positions of a joint: 0 is the position that its smoothed rotations give, 1 is its smoothed
   * position. The errors of both positions are almost independent, so a mean is better than either. The value was chosen on
   * seed 1 of `tools/clean`. Unit: 1. Default: `0.8`.
   */
  world?: number;
}

/** The animations of a file to keep. */
export type Clips = number | string;

/**
 * The storage of animation keys.
 * `"none"`: 32-bit floats, which every client reads.
 * `"int16"`: Rotations as 16-bit normalised integers, half the size. This is core glTF without an extension, but Assimp reads
 * wrong values.
 * `"meshopt"`: Streams of `EXT_meshopt_compression`, which the file then requires. Needs the feature `meshopt`.
 * `"meshopt-khr"`: Streams of `KHR_meshopt_compression` version 1, slightly smaller. The file then requires the extension.
 * Needs the feature `meshopt`.
 */
export type Compression = "none" | "int16" | "meshopt" | "meshopt-khr";

/** Options of FBX. */
export interface FbxOutputOptions {
  /** Where to store the rotations of the rest pose. Default: rotation; for the target maya pre-rotation. */
  "fbx-rest"?: FbxRest | null;
  /** Version of the file. Default: `"7.5"`. */
  "fbx-version"?: FbxVersion;
  /** The program whose conventions the file follows: unit, axes, root, frame rate. */
  target?: FbxTarget | null;
  /** Where to store the images of textures. Default: `"embedded"`. */
  textures?: FbxTextures;
}

/**
 * Which property stores the rotations of the rest pose.
 * `"rotation"`: `Lcl Rotation`, as Blender writes: curves have the complete rotation.
 * `"pre-rotation"`: `PreRotation`, which Maya shows as joint orient: all rotations of the rest pose are zero. Assimp 5.2
 * applies the pre-rotation of animated joints twice.
 */
export type FbxRest = "rotation" | "pre-rotation";

/**
 * A program whose conventions the file follows. `docs/fbx.md` has the source of each convention.
 * `"blender"`: Blender: centimetres with +Y up, and +Y of joints along their bones unless an option sets the bone axis.
 * `"unreal"`: Unreal Engine: centimetres with +Z up, no node above the skeleton, a whole frame rate.
 * `"unity"`: Unity: metres with +Y up.
 * `"maya"`: Maya: centimetres with +Y up, the rest pose as joint orient.
 * `"motionbuilder"`: MotionBuilder: centimetres with +Y up, a root named `Reference`, a whole frame rate.
 */
export type FbxTarget = "blender" | "unreal" | "unity" | "maya" | "motionbuilder";

/**
 * Where the images of textures are stored.
 * `"embedded"`: In the file itself.
 * `"beside"`: In separate files beside the FBX file.
 */
export type FbxTextures = "embedded" | "beside";

/**
 * The version of an FBX file.
 * `"7.4"`: 7.4, of FBX 2014 and 2015: files of at most 4 GiB.
 * `"7.5"`: 7.5, of FBX 2016 and newer.
 */
export type FbxVersion = "7.4" | "7.5";

/**
 * Treatment of feet in contact.
 * `"lock"`: A foot is held still while the source foot is in ground contact.
 * `"free"`: Feet are not corrected.
 */
export type Feet = "lock" | "free";

/** The one file of a survey or of a motion graph. */
export interface FileOutputOptions {
  /** Whether the output may replace a file that may be a source. An input is never replaced. */
  force?: boolean;
  /** The file to write; its extension names the format. - is standard output. Default: nothing is written. */
  output?: string;
  /** The output format, as a file extension, if it differs from the extension of the output. */
  to?: string | null;
}

/**
 * What a conversion does with the first frame. In some files, such as a conversion of the CMU database, the first frame is a
 * rest pose.
 * `"auto"`: Drop the first frame if it is a rest pose and the motion jumps after it.
 * `"yes"`: Drop the first frame.
 * `"no"`: Keep the first frame.
 */
export type FirstFrame = "auto" | "yes" | "no";

/**
 * The height of the floor for a motion on a robot.
 * `"auto"`: Under the feet in stance. If a foot in stance is above the floor by up to 6 cm, the whole robot is lowered. A
 * robot that would be below the floor is raised.
 * `"z=0"`: At height 0 of the source's file. A robot that would be below this height is raised.
 * `"keep"`: At its mean height in the source. Heights do not change, even below the floor.
 */
export type Floor = "auto" | "z=0" | "keep";

export interface FootLockWeights {
  /**
   * Largest ratio of the acceleration of a foot joint to its acceleration without the lock. Above this ratio, mocap relaxes
   * the lock. A released foot must catch up with its swing. `tools/feet/check` measures this ratio on the motions of
   * `fixtures/real`. Unit: 1. Default: `1.5`.
   */
  "acceleration-ratio"?: number;
  /**
   * Goal of relaxing a lock, as a fraction of `speed_ratio` and `acceleration_ratio`. The margin of 3 % is for two effects:
   * keys are rounded, and relaxing the lock in the next frame changes the speed in this frame. Unit: 1. Default: `0.97`.
   */
  aim?: number;
  /**
   * Time before and after a frame in which mocap looks for the largest speed and acceleration without the lock. The lock may
   * move an acceleration to another frame. This time is half of the time of a footstep in a walk. Unit: s. Default: `0.25`.
   */
  around?: number;
  /**
   * Time in which a lock fades out before a frame that is above a ratio, and fades in after this frame. It is shorter than
   * the default of the option `blend` of `foot-lock` (0.2 s). Unit: s. Default: `0.15`.
   */
  ease?: number;
  /**
   * Time constant with which a locked foot follows a source foot that slides in contact: the time of four footsteps in a
   * walk. A body whose feet always slide therefore does not leave its feet behind. Unit: s. Default: `2.0`.
   */
  "gives-way"?: number;
  /**
   * Cost of a change of a foot's height, relative to an equal change of its knee. In a nearly straight leg, a millimetre of
   * height moves the knee by centimetres. In such a leg, mocap therefore changes the height of the foot, and spares the knee.
   * Unit: 1. Default: `10.0`.
   */
  "knee-height"?: number;
  /**
   * Largest angle by which a foot rotates to follow the source's foot: 34 degrees. A person's ankle bends 20 degrees up and
   * 50 degrees down (American Academy of Orthopaedic Surgeons, Joint Motion, 1965). Unit: rad. Default: `0.6`.
   */
  "largest-turn"?: number;
  /**
   * Least fraction by which one round of relaxing reduces a lock. With this minimum, few rounds are enough. Unit: 1. Default:
   * `0.2`.
   */
  "least-step"?: number;
  /**
   * Fraction of the highest speed and of the largest acceleration of the motion that a foot may always have. A quarter is not
   * visible as a jerk. Unit: 1. Default: `0.25`.
   */
  moving?: number;
  /**
   * Height, in lengths of the leg, below which the source's foot is on the ground, for a retargeted motion. Above three times
   * this height, the foot is in the air. The height is 3 cm for an adult. The detection of contacts allows more, 5 cm (option
   * `height` of `foot-lock`). Unit: leg. Default: `0.04`.
   */
  "on-the-ground"?: number;
  /**
   * Height, in lengths of the leg, by which a foot may stay above its goal before mocap lowers the hips: 8 mm for an adult.
   * Unit: leg. Default: `0.01`.
   */
  slack?: number;
  /**
   * Largest ratio of the speed of a foot joint to its speed without the lock. Above this ratio, mocap relaxes the lock. A
   * speed that is a fifth higher is not visible. `tools/feet/check` measures this ratio on the motions of `fixtures/real`.
   * Unit: 1. Default: `1.2`.
   */
  "speed-ratio"?: number;
  /**
   * Acceleration that a foot may always have: a fifth of gravity, less than a shift of the weight causes. Unit: m/s^2.
   * Default: `2.0`.
   */
  "still-acceleration"?: number;
  /** Speed that a foot may always have. A slower movement is not visible. Unit: m/s. Default: `0.1`. */
  "still-speed"?: number;
  /**
   * Fraction of its full length to which a leg may be stretched, unless the motion stretches it more. The knee of a leg of
   * 0.84 m is then 13 mm off the straight line, which is not visible. Unit: 1. Default: `0.9995`.
   */
  stretch?: number;
}

/**
 * A file format, by the name that users type.
 * `"bvh"`: Biovision Hierarchy: `bvh`.
 * `"gltf"`: glTF 2.0, `.glb` and `.gltf`: `gltf`.
 * `"vrma"`: VRM animation: `vrma`.
 * `"asf-amc"`: Acclaim skeleton and motion: `asf-amc`.
 * `"c3d"`: C3D, markers over time: `c3d`.
 * `"trc"`: TRC, markers over time in text: `trc`.
 * `"fbx"`: Autodesk FBX: `fbx`.
 * `"usd"`: Universal Scene Description: `usd`.
 * `"vmd"`: MikuMikuDance motion: `vmd`.
 * `"pmx"`: MikuMikuDance model: `pmx`.
 * `"bip"`: Biped of 3ds Max: `bip`.
 * `"urdf"`: Unified Robot Description Format: `urdf`.
 * `"mjcf"`: Robot model for MuJoCo: `mjcf`.
 * `"mclip"`: Packed clip of this crate: `mclip`.
 * `"npz"`: NumPy arrays: `npz`.
 * `"npy"`: One NumPy array: `npy`.
 * `"torch"`: PyTorch tensors: `torch`.
 * `"pickle"`: Arrays in a Python pickle: `pickle`.
 * `"csv"`: Text tables: `csv`.
 * `"parquet"`: Column tables: `parquet`.
 * `"mot"`: OpenSim joint angles: `mot`.
 */
export type Format =
  | "bvh"
  | "gltf"
  | "vrma"
  | "asf-amc"
  | "c3d"
  | "trc"
  | "fbx"
  | "usd"
  | "vmd"
  | "pmx"
  | "bip"
  | "urdf"
  | "mjcf"
  | "mclip"
  | "npz"
  | "npy"
  | "torch"
  | "pickle"
  | "csv"
  | "parquet"
  | "mot";

/** Compares motions, and writes their motion graph. */
export interface GraphJob {
  /** The options for comparing the frames. */
  graph: GraphJobOptions;
  /**
   * The file for the distance matrix of two clips, or of one clip with itself: a .png picture or a .npy array. In the
   * picture, lighter means more similar, and red dots are transitions.
   */
  matrix?: string | null;
  /** The options for reading the inputs. */
  read?: InputOptions;
  /** The inputs, and the caller's statements about them. */
  source?: GraphSources;
  /** The graph. */
  write?: FileOutputOptions;
  steps?: never;
  survey?: never;
  target?: never;
  verify?: never;
  walk?: never;
  weights?: never;
}

/** Options for comparing the frames of motions. */
export interface GraphJobOptions {
  /**
   * Retarget all clips to this body before the comparison, as mocap retarget does, for clips of several skeletons. Any
   * motion, glTF, VRM or FBX file of a humanoid.
   */
  on?: string | null;
  /** Frames per second at which clips are compared. Default: `30.0`. */
  rate?: number;
  /** Largest distance for a transition between two frames, as a mean over the joints, such as 6cm. Default: `"0.06m"`. */
  threshold?: Length;
  /** Also keep transitions into and out of the largest strongly connected component. */
  whole?: boolean;
  /** Length in seconds of the compared window, and of a transition. Default: 1/3. */
  window?: number;
}

/** The inputs of a motion graph. */
export interface GraphSources {
  /** The motion files. */
  inputs?: string[];
  /** The unit and the up axis of the inputs. */
  space?: SourceSpace;
}

/**
 * Treatment of hands in contact.
 * `"keep"`: A hand touches the same place on the target as the source hand.
 * `"free"`: Hands follow from the directions of the arms.
 */
export type Hands = "keep" | "free";

/** The options for reading the files of a job. */
export interface InputOptions {
  /** Read all rows of the motion, including those beyond the declared number of frames. */
  "all-rows"?: boolean;
  /**
   * The body for arrays of rotations, such as AMASS files. FILE is a model of SMPL, SMPL-H or SMPL-X (.npz or .pkl), or a
   * file of any format with a figure. For arrays of a robot, FILE is the robot. Default: generic proportions, 1.70 m tall.
   */
  body?: string | null;
  /**
   * The animation to use of a file that has several: its name, or its number from 0; name:3 is the animation whose name is 3.
   * With all, a command for one motion uses the first.
   */
  clip?: Clips;
  /** Format of the input. Default: found from its contents, or else from its extension. */
  from?: Format | null;
  /**
   * The joints of a file of positions, to solve their rotations. A JSON file, or one of smpl22, smpl24, coco17, h36m,
   * mediapipe33, openpose25, mhr70, mhr127. Default: arrays with the joints of SMPL are solved.
   */
  joints?: string | null;
  /**
   * Lengths of bones that are solved from positions: the median over all frames; or the length in each frame, so that joints
   * match their positions.
   */
  lengths?: Lengths | null;
  /**
   * Solve a skeleton from the markers of a file. auto: a known marker set; auto:NAME: the markers of one subject; FILE: a
   * JSON object from labels to landmarks. Default: markers stay points.
   */
  markers?: string | null;
  /** Play at this number of frames per second: the motion keeps its frames, and becomes slower or faster. */
  retime?: number | null;
  /** How the root's OFFSET and its position channels combine. Default: `"auto"`. */
  "root-offset"?: RootOffset;
  /** The skeleton of an .amc motion. Default: the .asf file in its folder with the same prefix, or the only .asf file. */
  skeleton?: string | null;
  /** A static trial: markers of a standing person. It may have more markers than the motion. */
  static?: string | null;
  /** Treat every warning as an error. */
  strict?: boolean;
}

/** The target to which a job retargets its motions. Each kind has only its own options. */
export type JobTarget = { character: CharacterTarget } | { skeleton: SkeletonTarget } | { robot: RobotTarget };

/** The weights of solvers that differ from their defaults. `docs/weights.md` lists all weights. */
export interface JobWeights {
  /** Weights of the step clean. */
  clean?: CleanWeights;
  /** Weights of foot lock: of the step foot-lock, and of retargeting to a character, a skeleton or a robot. */
  "foot-lock"?: FootLockWeights;
  /** Weights of solving a skeleton from markers. */
  markers?: MarkerWeights;
  /** Weights of retargeting to a robot. */
  robot?: RobotWeights;
}

/** The names of a humanoid's joints in the output. */
export type JointNames = BoneNames | string | Record<string, string | null>;

/** a length of 0 or more: metres, or a number with the unit m, cm, mm or um, such as 1mm. */
export type Length = number | `${number}` | `${number}${"m" | "cm" | "mm" | "um"}`;

/**
 * The bone lengths of a skeleton that is solved from points.
 * `"median"`: The median of each length over the frames: bones keep their lengths, and joints are near their points.
 * `"moving"`: The lengths of each frame: joints are at their points, and bones change their lengths.
 */
export type Lengths = "median" | "moving";

export interface MarkerWeights {
  /**
   * Standard deviation of the rotation of a knee or an elbow outside its hinge axis: 5 degrees. In a gait, knees bend
   * sideways and twist by 5 to 10 degrees (Ramsey and Wretenberg, Clin. Biomech. 14, 1999). Unit: rad. Default: `0.087`.
   */
  "beside-hinge"?: number;
  /**
   * Largest distance between a marker and its expected position. A marker farther away is a reflection, or belongs to another
   * object. Skin slides at most half of this distance. Unit: m. Default: `0.08`.
   */
  ghost?: number;
  /**
   * Standard deviation of the hip centre about the position that a regression computes from the markers of the pelvis.
   * Harrington et al., J. Biomech. 40 (2007), state 3 to 8 mm per coordinate for markers on bones. Markers on clothes are
   * less precise. Unit: m. Default: `0.012`.
   */
  hip?: number;
  /**
   * Standard deviation of a joint about its pose in the previous frame, for joints that markers do not determine: 20 degrees.
   * This value is so large that it hardly affects joints with visible markers. Unit: rad. Default: `0.35`.
   */
  hold?: number;
  /**
   * Weight of a frame whose marker errors come only from sliding skin, relative to a frame whose errors are independent. Skin
   * slides almost equally in neighbouring frames, so their errors are not independent. Unit: 1. Default: `0.05`.
   */
  "independent-slide"?: number;
  /** Least standard deviation of a marker about its offset: the noise of cameras. Unit: m. Default: `0.001`. */
  "least-slide"?: number;
  /**
   * Standard deviation of a bone length about its first estimate. The estimate uses two centres with errors from `on_bone` to
   * `trunk`. Unit: m. Default: `0.03`.
   */
  length?: number;
  /**
   * Standard deviation of the offset of a marker on a bone. It is the accuracy with which people place markers: 6 to 25 mm
   * (Della Croce et al., Gait & Posture 21, 2005). Unit: m. Default: `0.012`.
   */
  "on-bone"?: number;
  /**
   * Standard deviation of the offset of a marker on a muscle: half of the width of a thigh. Marker protocols do not define
   * the exact position of such a marker. Unit: m. Default: `0.04`.
   */
  "on-muscle"?: number;
  /**
   * Distance of a marker from its expected position at which the marker has a quarter of its full weight (Geman and McClure's
   * function). Skin does not slide that far. Unit: m. Default: `0.05`.
   */
  outlier?: number;
  /**
   * Largest standard deviation of a marker about its offset. mocap starts with this value, and reduces it if the markers of
   * the take slide less. Skin slides by 5 to 30 mm (Leardini et al., Gait & Posture 21, 2005). Unit: m. Default: `0.01`.
   */
  slide?: number;
  /**
   * Ratio of two distances of markers from their expected positions: with exchanged labels, to without. Below this ratio,
   * mocap exchanges the labels. Thus markers that pass each other keep their labels. Unit: 1. Default: `0.4`.
   */
  swap?: number;
  /**
   * Distance of a marker from its expected position above which the marker may have the label of another marker. Skin slides
   * up to this distance. Unit: m. Default: `0.03`.
   */
  swapped?: number;
  /**
   * Standard deviation of the joint centres of trunk and shoulders. No regression of all their coordinates is known. Unit: m.
   * Default: `0.02`.
   */
  trunk?: number;
}

/**
 * How the skeleton of a file without meshes is drawn.
 * `"segmented"`: One mesh per node.
 * `"skinned"`: One mesh with bones.
 * `"none"`: No mesh.
 */
export type MeshStyle = "segmented" | "skinned" | "none";

/** Reads motions, changes them, retargets them, and writes the result. */
export interface MotionJob {
  /** The options for reading the inputs. */
  read?: InputOptions;
  /** The inputs, and the caller's statements about them. */
  source?: Sources;
  /**
   * Steps that change the motion, in this order. They change every clip of an input. If the job names a clip, they change
   * this clip, and the output keeps the others.
   */
  steps?: EditStep[];
  /** The target of retargeting. Default: the motions keep their skeletons. */
  target?: JobTarget | null;
  /** Whether to compare the output with its source. */
  verify?: boolean;
  /** The weights of solvers that differ from their defaults. */
  weights?: JobWeights;
  /** The output. */
  write?: OutputOptions;
  graph?: never;
  matrix?: never;
  survey?: never;
  walk?: never;
}

/**
 * The axis of a joint at rest that points along its bone.
 * `"y"`: +Y, as Blender draws bones; joints bend about +X.
 * `"x"`: +X, as in Unreal; joints bend about +Z.
 * `"none"`: Joints keep the axes of the input.
 */
export type OutBoneAxis = "y" | "x" | "none";

/** The unit and the up axis of an output. */
export interface OutSpace {
  /** Unit of length of the output: m, dm, cm, mm, inch, cmu, or metres in one unit. Default: the input's; glTF is in metres. */
  "out-unit"?: Unit | null;
  /** Up axis of the output. Default: the input's; glTF has +Y up. */
  "out-up"?: OutUp | null;
}

/**
 * The up axis of an output.
 * `"y"`: +Y.
 * `"z"`: +Z.
 */
export type OutUp = "y" | "z";

/** The output of a job, and its options. Options that the format does not support are refused. */
export interface OutputOptions {
  /**
   * Rotate the axes of joints at rest so that this axis points along the bone, and another is the bending axis. Positions do
   * not change. Blender draws bones along +Y. Default: none; for the target blender y.
   */
  "bone-axis"?: OutBoneAxis | null;
  /** Options of BVH. */
  bvh?: BvhOutputOptions;
  /** Embed the buffer in a .gltf file, instead of writing a separate .bin file. */
  embed?: boolean;
  /** Options of FBX. */
  fbx?: FbxOutputOptions;
  /** Whether the output may replace a file that may be a source. An input is never replaced. */
  force?: boolean;
  /** Keep constant tracks in the animation. By default they become part of the rest pose. */
  "keep-constant"?: boolean;
  /** How to draw the skeleton of a file without meshes. Default: skinned; for .fbx none. */
  mesh?: MeshStyle | null;
  /**
   * Names of joints in the output: vrm, mixamo, unreal, cmu, godot, unity, mhr, soma, or a JSON file. The file has {"bones":
   * {"hips": "NAME", ...}}, as `mocap skeleton --json` prints. Default: the names in the input.
   */
  names?: JointNames | null;
  /**
   * The file to write; its extension names the format. - is standard output. If output is an existing folder or ends in /,
   * `mocap run` writes one file for each motion. Default: `""`.
   */
  output?: string;
  /** Write only the skeleton and its motion, without the meshes, materials and other contents of the input. */
  "skeleton-only"?: boolean;
  /** Fewer keys and bits. */
  smaller?: SizeOptions;
  /** The unit and the up axis of the output. */
  space?: OutSpace;
  /**
   * The output format, as a file extension, if it differs from the extension of the output. Or the name of an array layout,
   * such as amass, humanml3d, qpos or gmr.
   */
  to?: string | null;
}

/**
 * The worst allowed verdict of a motion on a robot.
 * `"good"`: Only good motions.
 * `"feasible"`: Good and fair motions that the robot can perform with its masses and effort limits.
 * `"fair"`: Good and fair motions.
 */
export type RequiredVerdict = "good" | "feasible" | "fair";

/** zero (the rest pose of the file), t-pose, a-pose, or frame:N. */
export type RestPoseSource = "zero" | "t-pose" | "a-pose" | `frame:${number}`;

/** A robot. */
export interface RobotTarget {
  /**
   * Feet in ground contact: lock holds a foot still while the source foot is in contact, free does not correct it. On a
   * character, lock applies only if the foot would slide more than the source foot. Default: `"lock"`.
   */
  feet?: Feet;
  /** The file of the character or the skeleton; for a robot, URDF or MuJoCo's MJCF. Default: `""`. */
  file?: string;
  /**
   * Height of the floor: auto, under the feet in contact; z=0, at height 0 of the motion's file; keep, at its mean height in
   * the motion, without changing heights. auto also lowers a foot that is slightly above the floor. Default: `"auto"`.
   */
  floor?: Floor;
  /**
   * Read the bones of the target from this JSON file, as `mocap skeleton --json` prints it for the target. Bones that the
   * file omits are searched for.
   */
  map?: BoneMap | null;
  /** The names of the clips, in the order of the motions. Default: the names in the files. */
  "names-of-clips"?: string[];
  /**
   * Number of solver passes: 1 solves frame by frame, which is faster; 2 then solves all frames of a window together. The
   * second pass moves joints smoothly and without jumps, within the velocity limits of the robot's file. Default: 2.
   */
  passes?: number | null;
  /**
   * Fail after writing, with the exit code 1, if the verdict of a motion is worse than this. feasible refuses poor motions,
   * and motions that the robot cannot perform with its masses and effort limits.
   */
  require?: RequiredVerdict | null;
  /** Scale of the path over the ground: auto, in proportion to the leg length; none, as in the source; or a factor. */
  scale?: Scale;
  /**
   * Playback speed: auto slows a motion down just as far as the robot's limits of velocity and effort need, and a factor sets
   * the speed. The frame rate does not change.
   */
  "time-scale"?: TimeScale;
  /** Keep joints within the velocity limits of the robot's file, also with one pass. */
  "velocity-limits"?: boolean;
}

export interface RobotWeights {
  /**
   * Difference between the acceleration of a joint and its acceleration in the first pass without jitter. `tools/robot/check`
   * measures the jitter. Unit: s^4/rad^2. Default: `3e-6`.
   */
  acceleration?: number;
  /**
   * Position of an ankle in the air in the second pass. It is a hundredth of `foot_place`, so that the swing becomes smooth.
   * Unit: 1/m^2. Default: `100.0`.
   */
  "air-place"?: number;
  /**
   * Penetration depth of two links. 3 cm cost as much as a radian of a direction. It is a tenth of `foot_place`, so that feet
   * in stance keep their place. Unit: 1/m^2. Default: `1000.0`.
   */
  apart?: number;
  /**
   * Difference between the acceleration of the base and its acceleration in the first pass without jitter. The base carries
   * the mass of the robot, so the floor cannot provide the force that jitter needs. The angular acceleration of the base has
   * ten times the weight `acceleration`. Unit: s^4/m^2. Default: `0.001`.
   */
  "base-acceleration"?: number;
  /**
   * Standard deviation of the Gaussian that removes the jitter from the accelerations of the base. It halves amplitudes at 3
   * Hz, because people walk with two footsteps per second. Unit: s. Default: `0.06`.
   */
  "base-smoothing"?: number;
  /**
   * Change of the joints of a limb from frame to frame at 30 frames per second, when a limb is solved again. A radian costs
   * as much as a radian of a direction. Unit: 1/rad^2. Default: `1.0`.
   */
  "branch-change"?: number;
  /**
   * Largest weight of a position when a limb is solved again. 3 cm cost as much as 20 degrees. These are the limits from
   * which on a limb is solved again. Unit: 1/m^2. Default: `130.0`.
   */
  "branch-place"?: number;
  /**
   * Rotation of a foot in the air about the axes that the ankle drives. It is below the weight of a limb's direction (1), so
   * that the foot follows the leg. Unit: 1/rad^2. Default: `0.3`.
   */
  foot?: number;
  /** Fraction of `foot` about the up axis. The hip turns a foot about this axis, not the ankle. Unit: 1. Default: `0.3`. */
  "foot-heading"?: number;
  /**
   * Position of an ankle, or of the sole of a foot in stance, and depth below the floor. A centimetre costs as much as a
   * radian of a direction, so that feet do not slide. `tools/robot/check` measures the sliding. Unit: 1/m^2. Default:
   * `10000.0`.
   */
  "foot-place"?: number;
  /**
   * Rotation of a hand. It is below the weight of a limb's direction (1), so that a wrist with few joints does not turn the
   * forearm away from its direction. Unit: 1/rad^2. Default: `0.2`.
   */
  hand?: number;
  /**
   * Rotation of the head. It is below the weight of the trunk's rotation (1), so that a neck with few joints does not bend
   * the trunk. Unit: 1/rad^2. Default: `0.3`.
   */
  head?: number;
  /**
   * Largest distance between a foot in stance and the source's foot: less than half a foot. At a larger distance, the source
   * has already left the place of the contact. Unit: m. Default: `0.1`.
   */
  "held-distance"?: number;
  /**
   * Position of the hips. A third of a metre costs as much as a radian: legs cannot stretch, so the hips give way. The weight
   * also converts the velocity of the base (m/s) to the velocity of a joint (rad/s). Unit: 1/m^2. Default: `9.0`.
   */
  "hips-place"?: number;
  /**
   * Change of a joint from the previous frame in the first pass. A radian costs as much as 0.02 rad of a direction, so it
   * only decides between equally good solutions. Unit: 1/rad^2. Default: `0.0004`.
   */
  hold?: number;
  /**
   * Standard deviation of the Gaussian that removes the jitter from the accelerations of joints. It halves amplitudes at 5
   * Hz, because limbs are faster than the base. Unit: s. Default: `0.04`.
   */
  "joint-smoothing"?: number;
  /**
   * Time constant in which the weight of an ankle changes between air and ground: a fifth of the swing of a walk, which takes
   * 0.4 s. Unit: s. Default: `0.08`.
   */
  nearing?: number;
  /**
   * Time constant in which a foot that leaves the ground returns to the source's foot: a third of the swing of a walk, which
   * takes 0.4 s. Unit: s. Default: `0.12`.
   */
  "return-time"?: number;
  /**
   * Additional weight in contact: a foot in stance has the weight `foot` × (1 + `standing`), so that it is flat.
   * `tools/robot/check` measures the distance of soles from the floor. Unit: 1. Default: `12.0`.
   */
  standing?: number;
  /**
   * Largest weight of the height of a foot in the second pass. It is below `foot_place`: if a foot cannot reach its goal, the
   * height deviates before the position over the ground. A separate term keeps feet above the floor. Unit: 1/m^2. Default:
   * `3000.0`.
   */
  "standing-height"?: number;
  /**
   * Part of the change of a joint between two frames that is above the velocity limit of the robot's file. A tenth of a
   * radian costs as much as a radian of a direction. mocap cuts off the part that remains. Unit: 1/rad^2. Default: `100.0`.
   */
  "step-limit"?: number;
  /**
   * Roll of a limb, and rotation of a foot about an axis that no ankle joint drives. It is a hundredth of the weight of a
   * limb's direction (1), so that it only decides what directions leave undetermined. Unit: 1/rad^2. Default: `0.01`.
   */
  twist?: number;
  /**
   * Velocity of a joint in the second pass. 16 rad/s, faster than human limbs, cost as much as 0.01 rad of a direction. Unit:
   * s^2/rad^2. Default: `4e-7`.
   */
  velocity?: number;
}

/**
 * What a conversion does with root motion.
 * `"keep"`: Keep root motion in the root joint.
 * `"in-place"`: Remove root motion.
 * `"extract"`: Move root motion to a new joint above the root.
 */
export type RootMotion = "keep" | "in-place" | "extract";

/**
 * How a root's OFFSET and its position channels combine.
 * `"auto"`: Adds in two cases. The root's position is near zero in the first frame or in the median of all frames, but the
 * OFFSET is not zero. Or the position stays near zero along an OFFSET that puts the feet on the floor. Otherwise, replaces.
 * `"replace"`: The position channels replace the OFFSET, as in Assimp and Blender.
 * `"add"`: The position channels are added to the OFFSET.
 */
export type RootOffset = "auto" | "replace" | "add";

/** The order of a node's three rotations about its axes. */
export type RotationOrder = "XYZ" | "XZY" | "YXZ" | "YZX" | "ZXY" | "ZYX";

/** auto (the ratio of the leg lengths), none (as in the source), or a factor above 0. */
export type Scale = number | "auto" | "none" | `${number}`;

/**
 * How clips are selected, or which clips a split keeps together.
 * `"quality"`: Select no bad clips, and no near-duplicates.
 * `"diversity"`: Select clips that are far apart.
 * `"person"`: Keep the clips of a person in one part.
 * `"skeleton"`: Keep the clips of a skeleton in one part.
 * `"near-duplicate"`: Keep near-duplicates in one part.
 */
export type SelectBy = "quality" | "diversity" | "person" | "skeleton" | "near-duplicate";

/** Compression options: fewer keys and bits, within a largest error. */
export interface SizeOptions {
  /** How to store the keys. Default with a largest error: int16, otherwise none. */
  compress?: Compression | null;
  /**
   * Remove keys and bits, but keep every joint and end site within this distance of its position in every frame, such as 1mm.
   * Fails if the format cannot keep this distance. Default with a compression: 1mm.
   */
  "max-error"?: Length | null;
  /**
   * Also keep points at this distance around each joint, such as the skin, within the largest error. ACL uses 3cm. Default:
   * 0, only joints and end sites.
   */
  "shell-distance"?: Length | null;
}

/** Only the skeleton of a file. */
export interface SkeletonTarget {
  /**
   * Feet in ground contact: lock holds a foot still while the source foot is in contact, free does not correct it. On a
   * character, lock applies only if the foot would slide more than the source foot. Default: `"lock"`.
   */
  feet?: Feet;
  /** The file of the character or the skeleton; for a robot, URDF or MuJoCo's MJCF. Default: `""`. */
  file?: string;
  /**
   * Hands that touch the body, each other or the floor: keep moves a hand to the place that the source hand touches, free
   * keeps the directions of the arms. Default: `"keep"`.
   */
  hands?: Hands;
  /**
   * Read the bones of the target from this JSON file, as `mocap skeleton --json` prints it for the target. Bones that the
   * file omits are searched for.
   */
  map?: BoneMap | null;
  /** Largest allowed angle in degrees, as for a character. */
  "max-angle"?: Angle | null;
  /** The names of the clips, in the order of the motions. Default: the names in the files. */
  "names-of-clips"?: string[];
  /** Scale of the path over the ground: auto, in proportion to the leg length; none, as in the source; or a factor. */
  scale?: Scale;
}

/** The frames to use from the inputs. They are selected before the unit and the axes are converted. */
export interface SourceFrames {
  /** Whether to drop the first frame; auto: drop it if it is a rest pose and the motion jumps after it. Default: `"no"`. */
  "drop-first-frame"?: FirstFrame;
  /**
   * Resample to this number of frames per second, at the same playback speed. For an input without a valid rate, set its
   * rate.
   */
  fps?: number | null;
  /** Rest pose: zero (as in the file; in BVH all rotations are 0), t-pose, a-pose (arms 45 degrees down), or frame:N. */
  rest?: RestPoseSource;
  /** The root motion: kept, removed, or moved to a joint above the root. Default: `"keep"`. */
  root?: RootMotion;
  /** Insert the T-pose before the first frame, on the floor. */
  "t-pose-first"?: boolean;
  /** Part to keep, both ends included: A..B in seconds, or Af..Bf in frames; either end is optional. */
  trim?: TimeRange | null;
}

/** The bones of the inputs, if the guess is wrong or not wanted. */
export type SourceMap = BoneMap;

/** The unit and the up axis of the inputs. */
export interface SourceSpace {
  /** Unit of length of the input: auto, m, dm, cm, mm, inch, cmu (5.6444 cm), or metres in one unit. */
  unit?: Unit;
  /** The up axis of the input; auto: from the feet to the head. */
  up?: SourceUp;
}

/** The up axis of the inputs. */
export type SourceUp = Axis;

/** The inputs of a job. */
export interface Sources {
  /** The frames to use from the inputs. */
  frames?: SourceFrames;
  /** The motion files. */
  inputs?: string[];
  /** The joint of each bone, if the guess is wrong: a JSON file, or the names here. */
  map?: SourceMap;
  /** The unit and the up axis of the inputs. */
  space?: SourceSpace;
  /** The second motions, which steps join, blend or layer with the first; a step counts them from 2. */
  with?: string[];
}

/** Surveys motions: one row for each clip, in the report and in the written table. */
export interface SurveyJob {
  /** The options for reading the inputs. */
  read?: InputOptions;
  /** The inputs. */
  source?: SurveySources;
  /** The options of the survey. */
  survey: SurveyOptions;
  /** The table. */
  write?: FileOutputOptions;
  graph?: never;
  matrix?: never;
  steps?: never;
  target?: never;
  verify?: never;
  walk?: never;
  weights?: never;
}

/** Options of a survey: thresholds, the clips to keep, and further files next to the table. */
export interface SurveyOptions {
  /**
   * How to select: diversity, or quality,diversity, which first drops bad clips and near-duplicates. For a split, clips with
   * the same value stay in one part: person, skeleton, near-duplicate. Default: quality,diversity, and near-duplicate for a
   * split.
   */
  by?: SelectBy[];
  /** Fail if a kept clip has this verdict or a worse one: the exit code is 1, and the report has a problem. */
  "fail-on"?: string | null;
  /** Write a page that shows the dataset: counts, the worst and typical clips as moving figures, near-duplicates, a map. */
  html?: string | null;
  /** Write the findings as SARIF, which code hosts show next to files. */
  sarif?: string | null;
  /** Keep this number or percentage of clips, as diverse as possible. */
  select?: string | null;
  /**
   * Split the clips into parts of these fractions, such as 0.8,0.1,0.1. The column `split` has train, validation or test;
   * with two parts train or test.
   */
  split?: number[];
  /**
   * Threshold from which a clip is bad, KIND=BAD, or thresholds for suspect and bad, KIND=SUSPECT..BAD, such as skate=2; inf
   * turns a kind off; repeatable.
   */
  threshold?: string[];
  /** Keep the rows for which this is true, such as "skate < 1 and not twin". */
  where?: string | null;
}

/** The inputs of a survey. */
export interface SurveySources {
  /** The motion files, and `.jsonl` files of earlier surveys. */
  inputs?: string[];
}

/** A..B in seconds, or Af..Bf in frames; either end is optional. */
export type TimeRange = `${string}..${string}`;

/** auto (as slow as the limits of the robot need), or a factor of the speed above 0. */
export type TimeScale = number | "auto" | `${number}`;

/** auto, m, dm, cm, mm, inch, cmu (5.6444 cm), or metres in one unit. */
export type Unit = number | "auto" | "m" | "dm" | "cmu" | "inch" | "cm" | "mm";

/** auto, y, z, -y or -z. */
export type Axis = "auto" | "y" | "z" | "-y" | "-z";

/** A walk over a motion graph. The job changes, retargets and writes the walk like the motion of a file. */
export interface WalkJob {
  /** The options for comparing the frames of the input clips. Without them, the input is a graph file. */
  graph?: GraphJobOptions | null;
  /** The options for reading the clips. */
  read?: InputOptions;
  /** The graph file; with `graph`, the clips. */
  source?: WalkSources;
  /** Steps that change the walk, in this order. */
  steps?: EditStep[];
  /** The target of retargeting. Default: the walk keeps its skeleton. */
  target?: JobTarget | null;
  /** The goal of the walk. */
  walk: WalkOptions;
  /** The weights of solvers that differ from their defaults. */
  weights?: JobWeights;
  /** The output. */
  write?: OutputOptions;
  matrix?: never;
  survey?: never;
  verify?: never;
}

/** The goal of a walk over a motion graph: a duration, a path, or a list of clips. */
export interface WalkOptions {
  /** Walk along a path over the ground, through these points in metres: x and z if +Y is up, x and y if +Z is up. */
  path?: [number, number][] | null;
  /** Walk for this number of seconds, and prefer rarely visited frames. */
  seconds?: number | null;
  /** Random seed of a walk of a given duration: another seed gives another walk. Default: `1`. */
  seed?: number;
  /** Walk through these clips in this order, by the cheapest transitions. CLIP@SECONDS is a time in a clip. */
  through?: string[];
}

/** The inputs of a walk. */
export interface WalkSources {
  /** The graph file, or the clips. */
  inputs?: string[];
  /** The unit and the up axis of the clips. */
  space?: SourceSpace;
  /** The second motions, which steps join, blend or layer with the walk; a step counts them from 2. */
  with?: string[];
}

/** The names of the steps of `mocap edit`. */
export type StepName =
  | "foot-lock"
  | "mirror"
  | "smooth"
  | "despike"
  | "fill"
  | "clean"
  | "loop"
  | "concat"
  | "blend"
  | "layer"
  | "warp"
  | "in-between"
  | "trim"
  | "resample"
  | "drop-first-frame"
  | "in-place"
  | "root-motion"
  | "reverse"
  | "rest"
  | "t-pose-first"
  | "bone-axis"
  | "reach"
  | "pin"
  | "look-at"
  | "ground"
  | "turn";

/** A step as text, `"smooth:cut-off=8"`, or its name with its options. */
export type EditStep =
  | StepName
  | `${StepName}:${string}`
  | FootLockStep
  | MirrorStep
  | SmoothStep
  | DespikeStep
  | FillStep
  | CleanStep
  | LoopStep
  | ConcatStep
  | BlendStep
  | LayerStep
  | WarpStep
  | InBetweenStep
  | TrimStep
  | ResampleStep
  | DropFirstFrameStep
  | InPlaceStep
  | RootMotionStep
  | ReverseStep
  | RestStep
  | TPoseFirstStep
  | BoneAxisStep
  | ReachStep
  | PinStep
  | LookAtStep
  | GroundStep
  | TurnStep;

/** Holds each foot still during ground contact, and keeps it above the floor. */
export interface FootLockStep {
  step: "foot-lock";
  /**
   * Seconds before a contact during which the correction of the foot fades in, and after a contact during which it fades out.
   * Default: 0.2.
   */
  blend?: number;
  /** During a contact, the largest height of a foot above the height at which it rests, in metres. Default: 0.05. */
  height?: number;
  /** During a contact, the largest speed of a foot, in metres per second. Default: 0.25. */
  speed?: number;
  /** A contact ends when the height or the speed of the foot is above this factor times `height` or `speed`. Default: 1.6. */
  release?: number;
  /** The shortest contact, in seconds. The step ignores shorter contacts. Default: 0.08. */
  shortest?: number;
  /** The shortest gap between two contacts, in seconds. If a gap is shorter, both contacts become one. Default: 0.05. */
  gap?: number;
  /** The height of the floor along the up axis, in metres. Default: the height at which the feet rest. */
  floor?: number;
  /**
   * The largest distance by which the step may move a joint that is not part of a foot, in metres. If a full lock would move
   * a knee or the hips farther, a part of the sliding remains. Default: none, no limit.
   */
  "largest-change"?: number;
  /** The weights of the lock that differ from their defaults. Default: none. */
  weights?: { [name: string]: number };
}

/**
 * Mirrors a motion: the right side of the figure moves as the left side did, and the left side as the right side did. The
 * mirror is a vertical plane, whose normal is the mean direction to the figure's left. A figure that walks forward still
 * walks forward.
 */
export interface MirrorStep {
  step: "mirror";
}

/**
 * Removes fast changes from the rotations and positions of all joints, or of chosen joints. The result does not depend on the
 * axes of the joints, and a joint may rotate by any angle. The first and the last frame do not change. Frames outside `range`
 * do not change, except the frames within `ease` seconds of the range.
 */
export interface SmoothStep {
  step: "smooth";
  /** The filter. Default: Butterworth. */
  filter?: "butterworth" | "gaussian";
  /**
   * The cut-off frequency in Hz: the filter keeps slower changes, and removes faster ones. Default: 6, which is above the
   * frequencies of a walk.
   */
  "cut-off"?: number;
  /** The part of the body to filter. Default: the whole body; with `joints`, only these joints. */
  part?: "upper" | "legs" | "arms" | "head";
  /**
   * The joints to filter, by the name of a joint or of a bone. The step does not filter the joints below these joints. With
   * `part`, the step filters both the part and these joints.
   */
  joints?: string[];
  /** The time range to filter. Default: the whole motion. */
  range?: string;
  /**
   * Seconds before the range during which the effect of the filter fades in, and after the range during which it fades out.
   * Default: 0.2.
   */
  ease?: number;
}

/**
 * Replaces spikes. A spike is a rotation or a position that jumps away for a few frames and comes back. The new values are
 * interpolated between the frames before and after the spike.
 */
export interface DespikeStep {
  step: "despike";
  /**
   * The smallest distance of a spike from the frames before and after it, as a multiple of the median of such distances in
   * the frames around. Default: 8.
   */
  threshold?: number;
  /** The smallest jump of a rotation, in degrees. Default: 3. */
  angle?: number;
  /** The smallest jump of a position, as a fraction of the total length of all bones. Default: 0.02. */
  distance?: number;
  /** The longest spike, in frames. Default: 3. */
  longest?: number;
}

/**
 * Fills gaps. A gap is a run of frames in which every joint exactly repeats the frame before. Capture programs write such
 * frames while the cameras do not see the markers. The step replaces the gap by a cubic curve, which has the speeds of the
 * motion before and after the gap. For markers and other points without a skeleton, a gap is a run of frames in which the
 * cameras did not see the point.
 */
export interface FillStep {
  step: "fill";
  /** The longest gap to fill, in seconds. In a longer gap, the figure may be still on purpose. Default: 0.5. */
  longest?: number;
  /** The shortest gap to fill, in seconds. Default: 0, which also fills a single repeated frame. */
  shortest?: number;
}

/**
 * Cleans a motion. It repairs timing, flips, noise, bone lengths, floor and foot contacts, in this order. A repair that finds
 * no defect does not change the motion. If the skeleton is not a humanoid, the step does not repair floor and contacts.
 */
export interface CleanStep {
  step: "clean";
  /** Repair timing: frames that repeat the frame before, and missing frames. Default: `true`. */
  time?: boolean;
  /** Remove flips: rotations that jump for some frames and return. Default: `true`. */
  flips?: boolean;
  /** Remove noise from rotations and positions. Default: `true`. */
  noise?: boolean;
  /** Keep the length of each bone constant. Default: `true`. */
  lengths?: boolean;
  /** Correct the height and slope of the floor and the drift of the body. Default: `true`. */
  floor?: boolean;
  /** Stop foot sliding during ground contact. Default: `true`. */
  contacts?: boolean;
  /** The weights of the cleaning that differ from their defaults. Default: none. */
  weights?: { [name: string]: number };
}

/**
 * Cuts a motion to a loop. Without `frames`, the loop starts and ends at the two frames whose poses, speeds and foot contacts
 * match best. The last frame equals the first frame, except for the position over the ground. Joint velocities are continuous
 * at the seam, where the loop starts again.
 */
export interface LoopStep {
  step: "loop";
  /** The first and the last frame of the loop. Default: the two frames that match best. */
  frames?: [number, number];
  /** The shortest loop to look for, in seconds. Default: 0.6. */
  shortest?: number;
  /** The longest loop to look for, in seconds. Default: 4. */
  longest?: number;
  /** Seconds after the seam during which the difference between the first and the last pose fades out. Default: 0.3. */
  blend?: number;
  /** Whether the loop stays in place instead of travelling over the ground from cycle to cycle. Default: `false`. */
  "in-place"?: boolean;
}

/**
 * Appends a second motion, which has the same joints. At the seam, the last frame of the first motion and the first frame of
 * the second motion become one frame. So `concat` restores a motion that was cut in two. The scene gets the warning
 * `poses-apart` if the poses at the seam differ by more than 45 degrees or 30 cm, or the speeds by more than 1 m/s. With
 * `within`, the step joins the two most similar frames near the end of the first motion and near the start of the second
 * motion. To compare two frames, it uses the distance of motion graphs, over a third of a second around each frame.
 */
export interface ConcatStep {
  step: "concat";
  /** The second motion among the motions of a job, counted from 2. Default: the next. */
  with?: number;
  /** Seconds after the seam during which the difference between the two poses fades out. Default: 0.3. */
  blend?: number;
  /**
   * Whether to move and turn the second motion so that it begins at the position and heading at which the first motion ends.
   * Default: `true`.
   */
  align?: boolean;
  /**
   * The step searches this many seconds at the end of the first motion and at the beginning of the second motion for the two
   * most similar frames. Default: 0, which keeps both motions completely.
   */
  within?: number;
}

/**
 * Mixes a motion with a second motion, which has the same joints. Weight 0 gives the first motion, weight 1 the second
 * motion. Dynamic time warping aligns the poses of both motions in time. So the step mixes two footsteps at the same phase.
 * The duration is the weighted mean of both durations. The step mixes movements over the ground relative to the heading of
 * each figure: two walks in different directions give a walk in a direction between them. The scene gets the warning
 * `poses-apart` if two mixed poses differ by more than 45 degrees or 30 cm. This comparison ignores position and heading over
 * the ground. With `within`, the step drops frames at the beginning of one motion and at the end of one motion, so that both
 * motions begin and end in similar poses. To compare two frames, it uses the distance of motion graphs, over a third of a
 * second around each frame. With `within`, the second motion also begins at the position and in the heading of the first
 * motion.
 */
export interface BlendStep {
  step: "blend";
  /** The second motion among the motions of a job, counted from 2. Default: the next. */
  with?: number;
  /** The fraction of the second motion: one number, or pairs of a time and a fraction. Default: 0.5 all the time. */
  weight?: number | [number, number][];
  /**
   * The step searches this many seconds at the beginning and at the end of both motions for the most similar frames. Default:
   * 0, which mixes both motions completely.
   */
  within?: number;
}

/**
 * Takes the rotations of a part of the body from a second motion, which has the same joints. A rotation is relative to the
 * parent joint. Both motions start at the same time. If the second motion ends first, the part of the body keeps its last
 * pose.
 */
export interface LayerStep {
  step: "layer";
  /** The second motion among the motions of a job, counted from 2. Default: the next. */
  with?: number;
  /** The part of the body. Default: the spine and all joints above it, with the arms. */
  part?: "upper" | "legs" | "arms" | "head";
}

/** Makes parts of a motion faster or slower, or bends its path over the ground. */
export interface WarpStep {
  step: "warp";
  /**
   * Pairs of an old and a new time, in seconds. From pair to pair, both times increase. Time 0 stays time 0, unless the first
   * new time is 0.
   */
  moments?: [number, number][];
  /** The factor by which the whole motion becomes faster. It must be above 0; 0.5 is half the speed. */
  speed?: number;
  /** Points over the ground through which the figure passes, in metres. All points have a time, or none has one. */
  path?: { seconds?: number | null; at: [number, number] }[];
  /** The facing of the figure: it turns with the path, or keeps its old facing. Default: along. */
  facing?: "along" | "kept";
}

/** Makes a keyframe animation: keeps the poses of chosen frames, the keys, and interpolates all other frames. */
export interface InBetweenStep {
  step: "in-between";
  /** The frames whose poses the step keeps. It always keeps the first and the last frame, too. */
  keys?: number[];
  /** Frames whose number is a multiple of this number are also keys. Default: 0, no further keys. */
  every?: number;
  /**
   * The interpolation between keys. Default: squad, whose speed does not jump at a key. A speed that is constant over the
   * keys stays constant.
   */
  interpolation?: "slerp" | "squad";
}

/** Keeps one time range of a motion, and drops the frames before and after it. */
export interface TrimStep {
  step: "trim";
  /** The first and the last time to keep. Default: the whole motion. */
  range?: string;
}

/** Gives a motion another frame rate. The speed of the motion does not change. */
export interface ResampleStep {
  step: "resample";
  /** Frames per second. Default: 30. */
  rate?: number;
}

/** Drops the first frame if it is a rest pose. Some programs write the rest pose as the first frame. */
export interface DropFirstFrameStep {
  step: "drop-first-frame";
  /** Whether to drop the first frame even if it is not a rest pose. Default: `false`. */
  always?: boolean;
}

/** Keeps the root above the point over which it starts. The height and the rotation of the root do not change. */
export interface InPlaceStep {
  step: "in-place";
}

/** Takes the horizontal motion away from the root and gives it to a new joint, which becomes the parent of the root. */
export interface RootMotionStep {
  step: "root-motion";
}

/** Plays a motion backwards: the last frame becomes the first frame. A second `reverse` restores the motion. */
export interface ReverseStep {
  step: "reverse";
}

/** Makes the T-pose or the A-pose the rest pose. The motion does not change. */
export interface RestStep {
  step: "rest";
  /** The pose. Default: the T-pose. */
  pose?: "t-pose" | "a-pose";
}

/**
 * Inserts a frame before the first frame. In the new frame, the figure stands in the T-pose on the floor, at the point over
 * which the motion starts.
 */
export interface TPoseFirstStep {
  step: "t-pose-first";
}

/**
 * Turns the coordinate frame of every joint in the rest pose. One axis then points to the next joint, and another is the axis
 * about which the joint bends. The positions of the joints do not change, neither in the rest pose nor in the motion.
 */
export interface BoneAxisStep {
  step: "bone-axis";
  /** The axis that points along the bone. Default: +Y. */
  axis?: "y" | "x";
}

/**
 * Brings a hand or a foot to a target during a time range. The wrist, the ankle or the joint `tip` reaches the target. The
 * limb moves to the target before the range, stays there during the range, and moves back after the range. The upper and the
 * lower bone of the limb turn. The elbow or the knee bends about the same axis as in the rest of the motion. A hand turns
 * with its forearm, but a foot keeps its rotation in the world. Nothing else changes.
 */
export interface ReachStep {
  step: "reach";
  /** The limb. Default: the right hand. */
  limb?: "left-hand" | "right-hand" | "left-foot" | "right-foot";
  /** The target: a point of the world in metres, or the name of a node. It must be given. */
  to: string | [number, number, number];
  /** The position of the point to reach, in the coordinate frame of the target, in metres. Default: the origin of the target. */
  offset?: [number, number, number];
  /** For a skeleton without known limbs: the first joint of the chain that moves. It replaces `limb`. Default: none. */
  start?: string;
  /**
   * The joint that comes to the target. It is the wrist, the ankle or a joint below. With `start`, it is a joint below
   * `start`. Default: the wrist or the ankle; with `start`, the only end effector below `start`.
   */
  tip?: string;
  /** The time range during which the limb is at the target. Default: the whole motion. */
  range?: string;
  /** Duration of the movement to the target before the range, in seconds. Default: 0.4. */
  "ease-in"?: number;
  /** Duration of the movement back after the range, in seconds. Default: 0.4. */
  "ease-out"?: number;
}

/**
 * Holds a hand or a foot at the object that it touches, the target. During a contact, the limb keeps its mean position in the
 * coordinate frame of the target. The target may move and rotate. If the limb is too short to reach this position, it comes
 * as near as possible. A contact is the given range. Without a range, it is every time during which the limb is near the
 * target and slow relative to the target. The bones turn as in `reach`. Nothing else changes. For feet on the floor, use
 * `foot-lock`, which lets a foot roll.
 */
export interface PinStep {
  step: "pin";
  /** The limb. Default: the right hand. */
  limb?: "left-hand" | "right-hand" | "left-foot" | "right-foot";
  /**
   * The target that the limb touches: a point of the world in metres, or the name of a node. Default: the mean position of
   * the limb in `range`, which must then be given.
   */
  to?: string | [number, number, number];
  /** For a skeleton without known limbs: the first joint of the chain that moves. It replaces `limb`. Default: none. */
  start?: string;
  /**
   * The joint that touches the target. It is the wrist, the ankle or a joint below. With `start`, it is a joint below
   * `start`. Default: the wrist or the ankle; with `start`, the only end effector below `start`.
   */
  tip?: string;
  /** The time range of the contact. Default: the step finds the contacts by `distance` and `speed`. */
  range?: string;
  /**
   * If the step finds the contacts: the largest distance between `tip` and the origin of the target, in metres. Default: 0.3,
   * because joints are inside the body.
   */
  distance?: number;
  /** If the step finds the contacts: the largest speed of `tip` relative to the target, in metres per second. Default: 0.25. */
  speed?: number;
  /** Duration of the movement to the target before a contact, and of the movement back after it, in seconds. Default: 0.2. */
  blend?: number;
}

/**
 * Turns neck and head so that, during a time range, the figure looks at a target. The line of sight then goes through the
 * target. This line points forward from the middle between the eyes, or from the head joint if the skeleton has no eyes. The
 * neck takes a fraction of the rotation, and the head takes the remaining rotation. If the target is farther to the side than
 * `limit`, the figure no longer looks exactly at the target: the head stops at most 15 degrees after the limit. The figure
 * does not look at a target behind its back. The step adds at most 400 degrees of rotation per second. If the target moves
 * faster, the turn starts earlier and ends later.
 */
export interface LookAtStep {
  step: "look-at";
  /** The target: a point of the world in metres, or the name of a node. It must be given. */
  at: string | [number, number, number];
  /** The fraction of the rotation that the neck takes. Default: 0.4. */
  neck?: number;
  /**
   * The angle between the direction that the trunk faces and the direction to the target, in degrees. Up to this angle, the
   * figure looks exactly at the target. Default: 80.
   */
  limit?: number;
  /** The time range during which the figure looks at the target. Default: the whole motion. */
  range?: string;
  /** Duration of the turn to the target before the range, in seconds. Default: 0.4. */
  "ease-in"?: number;
  /** Duration of the turn back after the range, in seconds. Default: 0.4. */
  "ease-out"?: number;
}

/**
 * Puts a motion on the floor at height 0. The step removes the slope of the floor and the drift of the body, as `clean` does.
 * Then it moves the figure so that the floor is exactly at height 0. The slope of a hill or of stairs, and the drift on a
 * treadmill, do not change: `docs/cleaning-algorithm.md` describes how mocap detects them.
 */
export interface GroundStep {
  step: "ground";
}

/**
 * Rotates a motion about the vertical line through the figure's position in the first frame. The step rotates by a given
 * angle, or until the figure faces a given direction in the first frame. It also rotates everything else that the animation
 * moves. Give either `by` or `facing`.
 */
export interface TurnStep {
  step: "turn";
  /** The angle in degrees, counterclockwise as seen from above. */
  by?: number;
  /** The axis of the scene along which the figure faces in the first frame of the result. */
  facing?: "x" | "-x" | "y" | "-y" | "z" | "-z";
}
