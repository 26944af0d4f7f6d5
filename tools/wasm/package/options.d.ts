// Written by `MOCAP_WRITE=1 cargo test -p mocap-bindings`, from the documentation of Rust: do not edit.

import type { File } from "./index.js";

/** How the files of a job are read. */
export interface InputCallOptions {
  /** Read all rows of the motion, including those beyond the declared number of frames. */
  allRows?: boolean;
  /**
   * The body for arrays of rotations, such as AMASS files. FILE is a model of SMPL, SMPL-H or SMPL-X (.npz or .pkl), or a
   * file of any format with a figure. Default: generic proportions, 1.70 m tall.
   */
  body?: File;
  /** The animation to use of a file that has several: its name, or its number from 0; name:3 is the animation whose name is 3. */
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
  /** Rest pose: zero (all rotations 0, as in the file), t-pose, a-pose (arms 45 degrees down), or frame:N. */
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
   * Largest allowed angle in degrees; beyond it, the job fails after writing, with the exit code 1. Four angles are checked:
   * of a limb in any frame, and the means of a limb's roll, a line of the trunk and a palm.
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
   * Distance over the ground from the resting place of a foot within which it belongs to the contact. Smoothing makes a foot
   * come to rest slowly. Unit: m. Default: `0.03`.
   */
  "contact-distance"?: number;
  /**
   * Longest gap between two contacts at one place that are joined. A foot does not leave its place and return in less than
   * half a swing. Unit: s. Default: `0.15`.
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
   * Time in which the weight of a meeting rises and falls: three frames of video, so that arms do not jerk. Unit: s. Default:
   * `0.1`.
   */
  "hand-blend"?: number;
  /**
   * Distance between the centres of two hands that meet, for a body of 1.7 m: two half palms and some noise. Unit: m.
   * Default: `0.13`.
   */
  "hand-distance"?: number;
  /**
   * Factor of `hand_distance` at which a meeting no longer counts. Between both distances its weight decreases, so that
   * nothing jumps. Unit: 1. Default: `1.4`.
   */
  "hand-fade"?: number;
  /**
   * Largest distance by which an arm is moved to a meeting, and by which a hand may miss it. The noise of an estimate from
   * video is not larger. Unit: m. Default: `0.1`.
   */
  "hand-noise"?: number;
  /**
   * Speed of a hand relative to the body below which the hand rests there. A hand that passes by is faster. Unit: m/s.
   * Default: `0.15`.
   */
  "hand-speed"?: number;
  /**
   * Distance of a position that counts as much as a radian of a rotation, if both are smoothed. The direction of a shorter
   * bone is less precise than its rotation. Unit: m. Default: `0.03`.
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
   * Least standard deviation of joint noise. Marker systems have less noise; estimates from video have 1 to 3 degrees.
   * `tools/clean/check` tests it. Unit: degrees. Default: `0.5`.
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
   * As `least_evidence`, for a doubled frame. It is lower, because the doubled frame itself is visible. Unit: 1. Default:
   * `0.02`.
   */
  "least-evidence-of-doubled"?: number;
  /**
   * Mean speed of feet in contact below which they are not locked, if nothing else was changed. Marker systems reach this
   * speed in runs, because contacts begin and end in motion. Unit: m/s. Default: `0.2`.
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
  /** Longest run of held frames that is filled. A longer run is a frozen pose, and may be intended. Unit: s. Default: `0.5`. */
  "longest-held"?: number;
  /**
   * Jerk that the smoother allows, as a fraction of the jerk that predicts the motion best. The smoother uses both sides of a
   * moment, and a prediction only one, so the smoother needs less. Chosen on seed 1 of `tools/clean`. If it cuts the peaks of
   * the motion, twice and eight times this value are tried. Unit: 1. Default: `0.5`.
   */
  smoothing?: number;
  /**
   * Fraction of the way from a joint's position by smoothed rotations to its smoothed position. The errors of both are almost
   * independent, so a mean is better than either. Chosen on seed 1 of `tools/clean`. Unit: 1. Default: `0.8`.
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
 * The treatment of the first frame. In some files, such as a conversion of the CMU database, it is a rest pose.
 * `"auto"`: Drop the first frame if it is a rest pose and the motion jumps after it.
 * `"yes"`: Drop the first frame.
 * `"no"`: Keep the first frame.
 */
export type FirstFrame = "auto" | "yes" | "no";

/**
 * The height of the floor for a motion on a robot.
 * `"auto"`: Under the feet in stance. A foot that stands up to 6 cm too high is lowered with the whole robot, and a robot
 * that would be below the floor is raised.
 * `"z=0"`: At height 0 of the source's file. A robot that would be below this height is raised.
 * `"keep"`: At its mean height in the source. Heights do not change, even below the floor.
 */
export type Floor = "auto" | "z=0" | "keep";

export interface FootLockWeights {
  /**
   * Largest ratio of accelerations, as `speed_ratio`. A foot that is released has to catch up with its swing.
   * `tools/feet/check` measures it on every motion. Unit: 1. Default: `1.5`.
   */
  "acceleration-ratio"?: number;
  /**
   * Fraction of both ratios at which relaxing aims. The margin allows for the rounding of keys, and for changes of the next
   * frame. Unit: 1. Default: `0.97`.
   */
  aim?: number;
  /**
   * Time before and after a frame in which the largest speed and acceleration without the lock are taken. The lock may move
   * an acceleration to another frame. It is a quarter of a footstep in a walk. Unit: s. Default: `0.25`.
   */
  around?: number;
  /**
   * Time in which a lock is relaxed before a frame, and returns after it. It is below the 0.2 s in which shifts ease out.
   * Unit: s. Default: `0.15`.
   */
  ease?: number;
  /**
   * Time constant in which a locked foot follows a source that slides in contact. It is two footsteps of a walk. So a body
   * whose feet always slide does not leave its feet behind. Unit: s. Default: `2.0`.
   */
  "gives-way"?: number;
  /**
   * Cost of a change of the height of a foot, relative to a change of its knee. If a foot moves by a millimetre, the knee of
   * a nearly straight leg moves by centimetres, so the foot gives way. Unit: 1. Default: `10.0`.
   */
  "knee-height"?: number;
  /**
   * Largest angle by which a foot rotates to follow the source's foot. It is 34 degrees, within the range of an ankle: 20 and
   * 50 degrees (American Academy of Orthopaedic Surgeons, Joint Motion, 1965). Unit: rad. Default: `0.6`.
   */
  "largest-turn"?: number;
  /** Least fraction by which a round of relaxing changes a lock, so that few rounds are enough. Unit: 1. Default: `0.2`. */
  "least-step"?: number;
  /**
   * Fraction of the highest speed and of the largest acceleration of the motion that a foot may always have. A quarter is not
   * visible as a jerk. Unit: 1. Default: `0.25`.
   */
  moving?: number;
  /**
   * Height, in lengths of the leg, below which the source's foot is on the ground, for a retargeted motion. It is 3 cm for an
   * adult, below the 5 cm of contacts. Above three times this height, the foot is in the air. Unit: leg. Default: `0.04`.
   */
  "on-the-ground"?: number;
  /**
   * Height, in lengths of the leg, by which a foot may stay above its goal before the hips are lowered: 8 mm for an adult.
   * Unit: leg. Default: `0.01`.
   */
  slack?: number;
  /**
   * Largest ratio of the speed of a foot joint to its speed without the lock. Above it the lock is relaxed. A speed that is a
   * fifth higher is not visible. `tools/feet/check` measures it on every motion. Unit: 1. Default: `1.2`.
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
  /** How the frames are compared. */
  graph: GraphJobOptions;
  /**
   * The file for the distance matrix of two clips, or of one clip with itself: a .png picture or a .npy array. In the
   * picture, lighter means more similar, and red dots are transitions.
   */
  matrix?: string | null;
  /** How the inputs are read. */
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
  /** Length in seconds of the compared window, and of a transition. Default: `0.3333333333333333`. */
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

/** How the files of a job are read. */
export interface InputOptions {
  /** Read all rows of the motion, including those beyond the declared number of frames. */
  "all-rows"?: boolean;
  /**
   * The body for arrays of rotations, such as AMASS files. FILE is a model of SMPL, SMPL-H or SMPL-X (.npz or .pkl), or a
   * file of any format with a figure. Default: generic proportions, 1.70 m tall.
   */
  body?: string | null;
  /** The animation to use of a file that has several: its name, or its number from 0; name:3 is the animation whose name is 3. */
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
   * object. Skin slides at most half as far. Unit: m. Default: `0.08`.
   */
  ghost?: number;
  /**
   * Standard deviation of the hip centre about its regression. Harrington et al., J. Biomech. 40 (2007), state 3 to 8 mm per
   * coordinate for markers on bones. Markers on clothes are less precise. Unit: m. Default: `0.012`.
   */
  hip?: number;
  /**
   * Standard deviation of a joint about its pose in the previous frame, for joints that markers do not determine: 20 degrees.
   * It is so large that it hardly affects joints with visible markers. Unit: rad. Default: `0.35`.
   */
  hold?: number;
  /**
   * Weight of a frame, as a fraction of an independent frame, if skin sliding displaces its markers. Skin slides almost
   * equally in neighbouring frames. Unit: 1. Default: `0.05`.
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
   * Standard deviation of the offset of a marker on a muscle, whose position protocols do not define: half of the width of a
   * thigh. Unit: m. Default: `0.04`.
   */
  "on-muscle"?: number;
  /**
   * Distance of a marker from its expected position at which it has a quarter of its weight (Geman and McClure's function).
   * Skin does not slide that far. Unit: m. Default: `0.05`.
   */
  outlier?: number;
  /**
   * Standard deviation of a marker about its offset, until the take determines it. Skin slides by 5 to 30 mm (Leardini et
   * al., Gait & Posture 21, 2005). Unit: m. Default: `0.01`.
   */
  slide?: number;
  /**
   * Ratio of distances below which two labels are exchanged. The exchanged label must be clearly nearer, so that markers that
   * pass each other keep their labels. Unit: 1. Default: `0.4`.
   */
  swap?: number;
  /**
   * Distance from its expected position above which a marker may have the label of another marker. Skin slides up to this
   * distance. Unit: m. Default: `0.03`.
   */
  swapped?: number;
  /**
   * Standard deviation of the centres of trunk joints and shoulders, for which no regression of all coordinates is known.
   * Unit: m. Default: `0.02`.
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
  /** How the inputs are read. */
  read?: InputOptions;
  /** The inputs, and the caller's statements about them. */
  source?: Sources;
  /** Steps that change the motion, in this order. With a step, only the first animation of an input is used. */
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
 * `"feasible"`: Good and fair ones that the robot can perform, by its masses and efforts.
 * `"fair"`: Good and fair motions.
 */
export type RequiredVerdict = "good" | "feasible" | "fair";

/** zero (all rotations 0, as in the file), t-pose, a-pose, or frame:N. */
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
   * and those that the robot cannot perform by its masses and efforts.
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
   * Difference of the acceleration of the base, as `acceleration`. The base carries the mass of the robot, so the floor
   * cannot provide the force of its jitter. Its angular acceleration has ten times `acceleration`. Unit: s^4/m^2. Default:
   * `0.001`.
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
   * Rotation of a foot in the air about the axes that the ankle drives. It is below a direction's weight, so that the foot
   * follows the leg. Unit: 1/rad^2. Default: `0.3`.
   */
  foot?: number;
  /** Fraction of `foot` about the up axis. The hip turns a foot about this axis, not the ankle. Unit: 1. Default: `0.3`. */
  "foot-heading"?: number;
  /**
   * Position of an ankle, or of the sole of a foot in stance, and depth below the floor. A centimetre costs as much as a
   * radian of a direction, so that feet do not slide. `tools/robot/check` measures it. Unit: 1/m^2. Default: `10000.0`.
   */
  "foot-place"?: number;
  /**
   * Rotation of a hand. It is below a direction's weight, so that a wrist with few joints does not bend the forearm. Unit:
   * 1/rad^2. Default: `0.2`.
   */
  hand?: number;
  /**
   * Rotation of the head. It is below a direction's weight, so that a neck with few joints does not bend the trunk. Unit:
   * 1/rad^2. Default: `0.3`.
   */
  head?: number;
  /**
   * Largest distance between a foot in stance and the source's foot: less than half a foot. At a larger distance, the source
   * has already left the place of the contact. Unit: m. Default: `0.1`.
   */
  "held-distance"?: number;
  /**
   * Position of the hips. It also weighs the velocity of the base (m/s) against the velocity of a joint (rad/s). A third of a
   * metre costs as much as a radian: legs cannot stretch, so the hips give way. Unit: 1/m^2. Default: `9.0`.
   */
  "hips-place"?: number;
  /**
   * Change of a joint from the previous frame in the first pass. A radian costs as much as 0.02 rad of a direction, so it
   * only decides between equally good solutions. Unit: 1/rad^2. Default: `0.0004`.
   */
  hold?: number;
  /**
   * Standard deviation of the Gaussian for joints. It halves amplitudes at 5 Hz, because limbs are faster than the base.
   * Unit: s. Default: `0.04`.
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
   * Largest weight of the height of a foot in the second pass. It is below `foot_place`, so that heights give way before
   * positions over the ground. The floor has a separate term. Unit: 1/m^2. Default: `3000.0`.
   */
  "standing-height"?: number;
  /**
   * Part of the change of a joint between frames above the velocity limit of the robot's file. A tenth of a radian costs as
   * much as a radian of a direction. The remaining part is cut off. Unit: 1/rad^2. Default: `100.0`.
   */
  "step-limit"?: number;
  /**
   * Roll of a limb, and rotation of a foot about an axis that no ankle joint drives. It is a hundredth of a direction's
   * weight, so that it only decides what directions leave undetermined. Unit: 1/rad^2. Default: `0.01`.
   */
  twist?: number;
  /**
   * Velocity of a joint in the second pass. 16 rad/s, faster than human limbs, cost as much as 0.01 rad of a direction. Unit:
   * s^2/rad^2. Default: `4e-7`.
   */
  velocity?: number;
}

/**
 * The treatment of root motion.
 * `"keep"`: Keep root motion in the root joint.
 * `"in-place"`: Remove root motion.
 * `"extract"`: Move root motion to a new joint above the root.
 */
export type RootMotion = "keep" | "in-place" | "extract";

/**
 * How a root's OFFSET and its position channels combine.
 * `"auto"`: Adds if the OFFSET is not near zero but the root's position is, in the first frame or in the median of all
 * frames. Replaces otherwise.
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
  /** Rest pose: zero (all rotations 0, as in the file), t-pose, a-pose (arms 45 degrees down), or frame:N. */
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
  /** How the inputs are read. */
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
  /** How the clips are read. */
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
  /** Random seed of a walk with --seconds: another seed gives another walk. Default: `1`. */
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

/** Holds feet still in contact and above the floor. */
export interface FootLockStep {
  step: "foot-lock";
  /** Seconds in which a shift fades out after a contact, and fades in before a contact. Default: 0.2. */
  blend?: number;
  /** The largest height of a foot in contact above the level of rest, in metres. Default: 0.05. */
  height?: number;
  /** The largest speed of a foot in contact, in metres per second. Default: 0.25. */
  speed?: number;
  /** The factor of height or speed at which a foot leaves a contact. Default: 1.6. */
  release?: number;
  /** The shortest contact, in seconds; shorter ones are dropped. Default: 0.08. */
  shortest?: number;
  /** The shortest gap between two contacts, in seconds; shorter ones are closed. Default: 0.05. */
  gap?: number;
  /** The height of the floor along the up axis, in metres. Default: where the feet rest. */
  floor?: number;
  /**
   * The largest change of any other joint, in metres. If locking a foot would move a knee or the hips farther, a part of the
   * sliding remains. Default: none, no foot slides.
   */
  "largest-change"?: number;
  /** The weights of the lock that differ from their defaults. Default: none. */
  weights?: { [name: string]: number };
}

/**
 * Mirrors a motion across the mean plane of the figure: the right side moves as the left side did. A figure that walks
 * forward still walks forward.
 */
export interface MirrorStep {
  step: "mirror";
}

/**
 * Filters rotations and positions of all joints or of some. Rotations are averaged in the tangent space of each rotation: no
 * axis is preferred, and a joint may rotate by any angle. The first and the last frame do not change. Frames outside the
 * range and its ease time do not change.
 */
export interface SmoothStep {
  step: "smooth";
  /** The filter. Default: Butterworth. */
  filter?: "butterworth" | "gaussian";
  /** The cut-off in Hz. Default: 6, which keeps a walk. */
  "cut-off"?: number;
  /** The part of the body. Default: everything, unless joints are named. */
  part?: "upper" | "legs" | "arms" | "head";
  /** Joints by their names or the names of bones, without the joints below them. With `part`, they are added to the part. */
  joints?: string[];
  /** The part of the motion. Default: the whole. */
  range?: string;
  /** Fade time of the filter before and after the range, in seconds. Default: 0.2. */
  ease?: number;
}

/**
 * Replaces spikes, which are rotations and positions that leave the motion for a few frames and come back. The frames before
 * and after are interpolated.
 */
export interface DespikeStep {
  step: "despike";
  /** The least distance of a spike from its neighbours, as a multiple of the distances in the frames around it. Default: 8. */
  threshold?: number;
  /** The smallest jump of a rotation, in degrees. Default: 3. */
  angle?: number;
  /** The smallest jump of a position, as a fraction of the distance between the ends of the skeleton. Default: 0.02. */
  distance?: number;
  /** The longest spike, in frames. Default: 3. */
  longest?: number;
}

/**
 * Fills gaps: frames in which every joint exactly repeats the frame before, as programs write them for unseen markers. A
 * cubic curve with the speeds before and after the gap continues the motion. For markers and other points without a skeleton,
 * a gap is the frames in which a point was not seen.
 */
export interface FillStep {
  step: "fill";
  /** The longest gap to fill, in seconds. A longer hold may be intended. Default: 0.5. */
  longest?: number;
  /** The shortest gap to fill, in seconds. Default: 0, two equal frames. */
  shortest?: number;
}

/**
 * Cleans a motion: repairs timing, flips, noise, bone lengths, floor and foot contacts, in this order. Parts without a defect
 * do not change. If the skeleton is not a humanoid, floor and contacts are not changed.
 */
export interface CleanStep {
  step: "clean";
  /** Repair timing: held, duplicated and dropped frames. Default: `true`. */
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
 * Cuts a motion to a loop. Its last frame equals its first frame in pose, speed and contacts; only the position over the
 * ground differs. Joint velocities are continuous at the seam.
 */
export interface LoopStep {
  step: "loop";
  /** The first and the last frame of the loop. Default: the two frames that match best. */
  frames?: [number, number];
  /** The shortest loop to look for, in seconds. Default: 0.6. */
  shortest?: number;
  /** The longest loop to look for, in seconds. Default: 4. */
  longest?: number;
  /** Seconds in which the difference of the poses fades out after the seam. Default: 0.3. */
  blend?: number;
  /** Whether the loop stays in place instead of travelling over the ground from cycle to cycle. Default: `false`. */
  "in-place"?: boolean;
}

/**
 * Appends a second motion, which has the same joints. The first frame of the second motion is the last of the first, so that
 * two parts of a cut motion are restored. The scene gets the warning `PosesApart` if the poses at the seam differ by more
 * than 45 degrees or 30 cm, or the speeds by more than 1 m/s. `within` searches for the most similar pair of an end frame and
 * a start frame near the seam. The measure is the distance of motion graphs, over windows of a third of a second.
 */
export interface ConcatStep {
  step: "concat";
  /** The second motion among the motions of a job, counted from 2. Default: the next. */
  with?: number;
  /** Seconds in which the difference of the poses fades out after the seam. Default: 0.3. */
  blend?: number;
  /** Whether the second motion begins at the position and heading at which the first motion ends. Default: `true`. */
  align?: boolean;
  /**
   * Seconds at the end of the first and at the beginning of the second motion in which the most similar frames are joined.
   * Default: 0, which keeps both motions completely.
   */
  within?: number;
}

/**
 * Mixes with a second motion, which has the same joints. Weight 0 gives the first motion, 1 the second. Dynamic time warping
 * of the poses aligns both in time, so that a step meets a step. The duration is the weighted mean of both durations. Steps
 * over the ground are mixed in the heading of each figure: two walks in different directions give a walk in a direction
 * between. The scene gets the warning `PosesApart` if mixed poses differ by more than 45 degrees or 30 cm, wherever the
 * figures stand. With `within`, one motion may start later, and one may end earlier, so that the ends match best. The measure
 * is the distance of motion graphs, over windows of a third of a second. The second motion then begins at the place and in
 * the heading of the first.
 */
export interface BlendStep {
  step: "blend";
  /** The second motion among the motions of a job, counted from 2. Default: the next. */
  with?: number;
  /** The fraction of the second motion. Default: 0.5 all the time. */
  weight?: number | [number, number][];
  /**
   * Seconds at the beginning and at the end of both motions in which the most similar frames are searched. Default: 0, which
   * mixes both motions completely.
   */
  within?: number;
}

/**
 * Takes the rotations of a part of the body, relative to their parents, from a second motion with the same joints, at the
 * same time. After the end of the second motion, its last pose is held.
 */
export interface LayerStep {
  step: "layer";
  /** The second motion among the motions of a job, counted from 2. Default: the next. */
  with?: number;
  /** The part of the body. Default: the spine and all above it. */
  part?: "upper" | "legs" | "arms" | "head";
}

/** Makes parts of a motion faster or slower, or bends its path over the ground. */
export interface WarpStep {
  step: "warp";
  /** Pairs of a time in the motion and its new time, in seconds, both increasing. The start does not change. */
  moments?: [number, number][];
  /** The factor of the speed of the whole motion, above 0. */
  speed?: number;
  /** Points over the ground through which the figure passes, in metres, each with or without its time. */
  path?: { seconds?: number | null; at: [number, number] }[];
  /** The facing of the figure: along the path, or as before. Default: along. */
  facing?: "along" | "kept";
}

/** Keyframe animation: keeps the poses of chosen frames, and interpolates the others. */
export interface InBetweenStep {
  step: "in-between";
  /** The frames whose poses are kept. The first and the last frame are always kept. */
  keys?: number[];
  /** The distance in frames of further keys. Default: 0, no others. */
  every?: number;
  /** The interpolation between keys. Default: squad, which keeps constant speeds and has no jumps of speed. */
  interpolation?: "slerp" | "squad";
}

/** Keeps a part of a motion. */
export interface TrimStep {
  step: "trim";
  /** The first and the last time to keep. Default: the whole motion. */
  range?: string;
}

/** Gives a motion another frame rate at the same speed. */
export interface ResampleStep {
  step: "resample";
  /** Frames per second. Default: 30. */
  rate?: number;
}

/** Drops the first frame if it is a rest pose, as in some files. */
export interface DropFirstFrameStep {
  step: "drop-first-frame";
  /** Whether to drop the first frame even if it is not a rest pose. Default: `false`. */
  always?: boolean;
}

/** Keeps the root above its start point. Its height and its rotation do not change. */
export interface InPlaceStep {
  step: "in-place";
}

/** Moves the motion of the root over the ground to a new joint above it. */
export interface RootMotionStep {
  step: "root-motion";
}

/** Plays a motion backwards: its last frame becomes its first. A second `reverse` restores it. */
export interface ReverseStep {
  step: "reverse";
}

/** Makes the T-pose or the A-pose the rest pose. The motion does not change. */
export interface RestStep {
  step: "rest";
  /** The pose. Default: the T-pose. */
  pose?: "t-pose" | "a-pose";
}

/** Inserts the T-pose before the first frame, on the floor at the start point. */
export interface TPoseFirstStep {
  step: "t-pose-first";
}

/**
 * Turns the frame of every joint at rest so that one of its axes points to the next joint, and another is the bending axis.
 * Nothing moves, neither at rest nor in motion.
 */
export interface BoneAxisStep {
  step: "bone-axis";
  /** The axis that points along the bone. Default: +Y. */
  axis?: "y" | "x";
}

/**
 * Brings a hand or a foot to a target in a range of a motion: the wrist or the ankle, or a joint below it. The limb stays at
 * the target during the range. It moves to the target before the range, and back after it. Two bones turn by the law of
 * cosines, about the axis about which the limb bends in the motion. A hand turns with its forearm, a foot keeps its rotation
 * in the world. Nothing else changes.
 */
export interface ReachStep {
  step: "reach";
  /** The limb. Default: the right hand. */
  limb?: "left-hand" | "right-hand" | "left-foot" | "right-foot";
  /** The target. It must be given. */
  to: string | [number, number, number];
  /** The point to reach, from the origin of the target in metres along its axes. Default: the origin. */
  offset?: [number, number, number];
  /** The first joint of a chain of any skeleton, instead of a limb. Default: none. */
  start?: string;
  /**
   * The joint that moves to the target, at or below the hand or the foot, or below `start`. Default: the wrist or the ankle,
   * or the only end effector below `start`.
   */
  tip?: string;
  /** The range in which the limb is at the target. Default: the whole motion. */
  range?: string;
  /** Duration of the movement to the target before the range, in seconds. Default: 0.4. */
  "ease-in"?: number;
  /** Duration of the movement back after the range, in seconds. Default: 0.4. */
  "ease-out"?: number;
}

/**
 * Holds a hand or a foot at the object that it touches. The limb keeps its mean position in the frame of the target, which
 * may move and rotate. If the limb is too short, it comes as near as possible. The limb is held in a given range, or in every
 * range in which it is near the target and slow relative to it. Two bones, or the joints of a chain, turn as in `reach`.
 * Nothing else changes. Use `foot-lock` for feet on the floor, because it lets them roll.
 */
export interface PinStep {
  step: "pin";
  /** The limb. Default: the right hand. */
  limb?: "left-hand" | "right-hand" | "left-foot" | "right-foot";
  /** The target that the limb touches. Default: the world, at the position of the limb. */
  to?: string | [number, number, number];
  /** The first joint of a chain of any skeleton, instead of a limb. Default: none. */
  start?: string;
  /**
   * The joint that touches the target, at or below the hand or the foot, or below `start`. Default: the wrist or the ankle,
   * or the only end effector below `start`.
   */
  tip?: string;
  /** The range of the contact. Default: detected. */
  range?: string;
  /** The largest distance of a detected contact from the target, in metres. Default: 0.3, from joint to joint. */
  distance?: number;
  /** The largest speed of a detected contact relative to the target, in metres per second. Default: 0.25. */
  speed?: number;
  /** Blend time before and after a contact, in seconds. Default: 0.2. */
  blend?: number;
}

/**
 * Turns neck and head so that the figure looks at a target in a range of a motion. The line of sight goes through the target.
 * It starts between the eyes, or at the joint of the head, and points forward. The neck takes a fraction of the rotation, the
 * head the rest. Beyond the limit, an angle from the facing of the trunk, the head stays behind smoothly. The figure does not
 * look at a target behind its back. The head follows a faster target with at most 400 degrees per second: it starts earlier
 * and arrives later.
 */
export interface LookAtStep {
  step: "look-at";
  /** The target. It must be given. */
  at: string | [number, number, number];
  /** The fraction of the rotation that the neck takes. Default: 0.4. */
  neck?: number;
  /**
   * The largest angle between the facing of the trunk and the target at which the figure looks at the target, in degrees.
   * Default: 80.
   */
  limit?: number;
  /** The range in which the figure looks at the target. Default: the whole motion. */
  range?: string;
  /** Duration of the turn to the target before the range, in seconds. Default: 0.4. */
  "ease-in"?: number;
  /** Duration of the turn back after the range, in seconds. Default: 0.4. */
  "ease-out"?: number;
}

/**
 * Puts a motion on the floor at height 0. It removes the slope of the floor and the drift of the body as `clean` does, and
 * then the height, however small. Hills, stairs and treadmills do not change: `docs/cleaning-algorithm.md` describes their
 * detection.
 */
export interface GroundStep {
  step: "ground";
}

/**
 * Turns a motion about the vertical through the figure's place in the first frame. It turns by an angle, or until the figure
 * faces a direction in that frame. Everything that the animation moves turns too.
 */
export interface TurnStep {
  step: "turn";
  /** The angle in degrees, counterclockwise as seen from above. */
  by?: number;
  /** The axis of the scene along which the figure looks in the first frame. */
  facing?: "x" | "-x" | "y" | "-y" | "z" | "-z";
}
