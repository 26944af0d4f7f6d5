//! Acclaim's skeletons and motions, compared with separate kinematics and with CMU's conversion to BVH.

#![allow(clippy::unwrap_used, reason = "a failed assumption in a test is the test's failure")]

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use crate::kinematics::{Capture, Matrix, Root, Vector, distance, multiply, turn};
use mocap::glam::Vec3;
use mocap::scene::{NodeId, NodeKind, Scene, Topic};
use mocap::{Binding, Code, Importer, Limits, Pose};

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A bone, read directly from the text of CMU's files, which all have the same layout.
struct Bone {
    link: Vector,
    axis: Vector,
    dof: Vec<usize>,
    parent: String,
}

fn numbers<'a>(words: impl Iterator<Item = &'a str>) -> Vec<f64> {
    words.filter_map(|word| word.parse().ok()).collect()
}

fn axis_index(letter: char) -> usize {
    "xyz".find(letter.to_ascii_lowercase()).unwrap()
}

/// The bones by name, and their names from the root outwards.
fn parse_skeleton(text: &str) -> (HashMap<String, Bone>, Vec<String>) {
    let (bone_data, hierarchy) = text.split_once(":hierarchy").unwrap();
    let mut bones = HashMap::new();
    for block in bone_data.split("begin").skip(1) {
        let line = |keyword: &str| {
            let mut lines = block.lines().map(str::trim);
            lines
                .find_map(|line| line.strip_prefix(keyword))
                .map(str::split_whitespace)
        };
        let direction = numbers(line("direction ").unwrap());
        let length = numbers(line("length ").unwrap())[0];
        let dof = line("dof ").map(|words| words.map(|word| axis_index(word.chars().nth(1).unwrap())).collect());
        bones.insert(
            line("name ").unwrap().next().unwrap().to_owned(),
            Bone {
                link: [0, 1, 2].map(|i| direction[i] * length),
                axis: numbers(line("axis ").unwrap()).try_into().unwrap(),
                dof: dof.unwrap_or_default(),
                parent: String::new(),
            },
        );
    }
    let mut order = vec!["root".to_owned()];
    let families = hierarchy
        .lines()
        .map(str::trim)
        .filter(|line| !["", "begin", "end"].contains(line));
    for family in families {
        let mut names = family.split_whitespace();
        let parent = names.next().unwrap();
        for child in names {
            bones.get_mut(child).unwrap().parent = parent.to_owned();
            order.push(child.to_owned());
        }
    }
    (bones, order)
}

/// The frames, each with the values of every bone that it names.
fn parse_motion(text: &str) -> Vec<HashMap<&str, Vec<f64>>> {
    let mut frames: Vec<HashMap<&str, Vec<f64>>> = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with(['#', ':'])) {
        let mut words = line.split_whitespace();
        let first = words.next().unwrap();
        if first.parse::<u32>().is_ok() {
            frames.push(HashMap::new());
        } else {
            frames.last_mut().unwrap().insert(first, numbers(words));
        }
    }
    frames
}

fn apply(matrix: Matrix, vector: Vector) -> Vector {
    matrix.map(|row| std::iter::zip(row, vector).map(|(a, b)| a * b).sum())
}

fn transpose(matrix: Matrix) -> Matrix {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[column][row]))
}

/// The product of rotations about axes, the first rotation first.
fn turns(rotations: impl Iterator<Item = (usize, f64)>) -> Matrix {
    rotations.fold(IDENTITY, |matrix, (axis, degrees)| {
        multiply(turn(axis, degrees), matrix)
    })
}

/// The two ends of every bone in a frame. The vector from the near to the far end is rotated into the bone's own axes,
/// in which the motion rotates it. Then it is rotated back, and by the rotations of all bones above.
fn ends(
    bones: &HashMap<String, Bone>,
    order: &[String],
    frame: &HashMap<&str, Vec<f64>>,
) -> HashMap<String, (Vector, Vector)> {
    let root = &frame["root"];
    let position = [root[0], root[1], root[2]];
    let rotation = turns((0..3).zip(root[3..].iter().copied()));
    let mut rotations = HashMap::from([("root", rotation)]);
    let mut ends = HashMap::from([("root".to_owned(), (position, position))]);
    for name in &order[1..] {
        let bone = &bones[name];
        let axes = turns((0..3).zip(bone.axis));
        let values = frame.get(name.as_str()).cloned().unwrap_or_default();
        let motion = turns(bone.dof.iter().copied().zip(values));
        let local = multiply(multiply(axes, motion), transpose(axes));
        let rotation = multiply(rotations[bone.parent.as_str()], local);
        let near = ends[&bone.parent].1;
        let link = apply(rotation, bone.link);
        rotations.insert(name, rotation);
        ends.insert(name.clone(), (near, [0, 1, 2].map(|i| near[i] + link[i])));
    }
    ends
}

fn node_id(scene: &Scene, name: &str) -> Option<NodeId> {
    scene.nodes.iter().position(|node| node.name == name).map(NodeId::new)
}

fn to_vector(point: Vec3) -> Vector {
    point.as_dvec3().to_array()
}

/// The longest side of the box around the first frame.
fn height(ends: &HashMap<String, (Vector, Vector)>) -> f64 {
    let along = || ends.values().map(|(_, far)| far[1]);
    along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
}

#[test]
fn every_bone_begins_and_ends_where_its_own_kinematics_puts_it() {
    for (skeleton, clip, frame_count) in [("cmu_01", "cmu_01_01", 2751), ("cmu_02", "cmu_02_01", 343)] {
        let scene = mocap::import(format!("../../fixtures/real/{clip}.amc")).unwrap();
        assert_eq!(scene.warnings, []);
        let asf = fs::read_to_string(format!("../../fixtures/real/{skeleton}.asf")).unwrap();
        let amc = fs::read_to_string(format!("../../fixtures/real/{clip}.amc")).unwrap();
        let (bones, order) = parse_skeleton(&asf);
        let frames = parse_motion(&amc);
        assert_eq!((bones.len(), frames.len()), (30, frame_count));
        let animation = &scene.animations[0];
        assert_eq!(animation.duration, (frame_count - 1) as f64);

        let tolerance = 1e-5 * height(&ends(&bones, &order, &frames[0]));
        let binding = Binding::new(&scene, animation);
        let mut pose = Pose::rest(&scene);
        for (tick, frame) in frames.iter().enumerate() {
            pose.sample(&binding, animation, tick as f64);
            let ends = ends(&bones, &order, frame);
            for (node, matrix) in scene.nodes.iter().zip(&pose.node_to_world) {
                let position = to_vector(matrix.w_axis.truncate());
                let (near, far) = ends[node.name.trim_start_matches("EndSite_")];
                let expected = if node.kind == NodeKind::EndSite { far } else { near };
                let error = distance(position, expected);
                assert!(error < tolerance, "{clip}, {} at {tick}: {error}", node.name);
            }
        }
    }
}

/// The joints of the conversion, each with the bone that begins at its position.
const TRUNK_AND_LEGS: [(&str, &str); 14] = [
    ("Hips", "root"),
    ("LHipJoint", "lhipjoint"),
    ("LeftUpLeg", "lfemur"),
    ("LeftLeg", "ltibia"),
    ("LeftFoot", "lfoot"),
    ("LeftToeBase", "ltoes"),
    ("RHipJoint", "rhipjoint"),
    ("RightUpLeg", "rfemur"),
    ("RightLeg", "rtibia"),
    ("RightFoot", "rfoot"),
    ("RightToeBase", "rtoes"),
    ("LowerBack", "lowerback"),
    ("Spine", "upperback"),
    ("Spine1", "thorax"),
];

const ABOVE_THORAX: [(&str, &str); 11] = [
    ("Neck", "lowerneck"),
    ("Neck1", "upperneck"),
    ("Head", "head"),
    ("LeftShoulder", "lclavicle"),
    ("LeftArm", "lhumerus"),
    ("LeftForeArm", "lradius"),
    ("LeftHand", "lwrist"),
    ("RightShoulder", "rclavicle"),
    ("RightArm", "rhumerus"),
    ("RightForeArm", "rradius"),
    ("RightHand", "rwrist"),
];

const LEFT_HAND: [(&str, &str); 3] = [
    ("LeftFingerBase", "lhand"),
    ("LFingers", "lfingers"),
    ("LThumb", "lthumb"),
];

const RIGHT_HAND: [(&str, &str); 3] = [
    ("RightFingerBase", "rhand"),
    ("RFingers", "rfingers"),
    ("RThumb", "rthumb"),
];

/// The conversion omits the links of three bones: the thorax and both wrists. Children of their far ends become
/// children of their near ends. So joints beyond such a link are compared relative to the first joint beyond the link.
const ALIGNED: [(&[(&str, &str)], bool); 4] = [
    (&TRUNK_AND_LEGS, false),
    (&ABOVE_THORAX, true),
    (&LEFT_HAND, true),
    (&RIGHT_HAND, true),
];

#[test]
fn joints_stand_where_the_conversion_to_bvh_has_them() {
    let scene = mocap::import("../../fixtures/real/cmu_01_01.amc").unwrap();
    let capture = Capture::parse(&fs::read("../../fixtures/real/cmu_01_01.bvh").unwrap());
    let animation = &scene.animations[0];
    let binding = Binding::new(&scene, animation);
    let mut pose = Pose::rest(&scene);
    let tolerance = 0.01 * capture.height(Root::Replace);
    assert_eq!(capture.rows.len(), animation.frame_count() + 1);
    for tick in 0..animation.frame_count() {
        pose.sample(&binding, animation, tick as f64);
        // The conversion begins with a T-pose, so its frames are one later.
        let placements = capture.placements(tick + 1, Root::Replace);
        let in_conversion = |name: &str| {
            let joint = capture.nodes.iter().position(|node| node.name == name);
            placements[joint.unwrap()].position
        };
        let in_original = |name: &str| to_vector(pose.position(node_id(&scene, name).unwrap()));
        for (names, is_relative) in ALIGNED {
            let shift = match is_relative {
                true => subtract(in_original(names[0].1), in_conversion(names[0].0)),
                false => [0.0; 3],
            };
            for (joint, bone) in names {
                let error = distance(subtract(in_original(bone), shift), in_conversion(joint));
                assert!(error < tolerance, "{bone} at {tick}: {error}");
            }
        }
    }
}

fn subtract(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] - b[i])
}

#[test]
fn what_the_files_do_not_say_is_told() {
    let assumption = |scene: &Scene, topic| {
        let mut assumptions = scene.metadata.assumptions.iter();
        assumptions
            .find(|assumption| assumption.topic == topic)
            .map(|assumption| assumption.choice.clone())
    };
    let scene = mocap::import("../../fixtures/real/cmu_02_01.amc").unwrap();
    assert_eq!(scene.animations[0].ticks_per_second, 120.0);
    assert_eq!(
        assumption(&scene, Topic::FrameRate).as_deref(),
        Some("120 frames a second")
    );
    assert_eq!(
        assumption(&scene, Topic::Unit).as_deref(),
        Some("a unit of length is 0.05644 m")
    );

    let scene = Importer::new()
        .retime(60.0)
        .import("../../fixtures/real/cmu_02_01.amc")
        .unwrap();
    assert_eq!(scene.animations[0].ticks_per_second, 60.0);
    assert_eq!(assumption(&scene, Topic::FrameRate), None);
}

#[test]
fn a_skeleton_alone_stands_in_its_rest_pose() {
    let scene = mocap::import("../../fixtures/real/cmu_01.asf").unwrap();
    assert_eq!(scene.warnings[0].code, Code::NoMotion);
    assert!(scene.animations.is_empty());
    let pose = Pose::rest(&scene);
    // The direction of lhipjoint times its length.
    let femur = pose.position(node_id(&scene, "lfemur").unwrap());
    assert!(
        femur.abs_diff_eq(Vec3::new(1.363_057, -1.794_627, 0.839_291), 1e-5),
        "{femur}"
    );
}

/// A root, an arm that rotates about its own axes, and a hand.
const SKELETON: &str = include_str!("../../../../fixtures/made/tiny.asf");

const MOTION: &str = include_str!("../../../../fixtures/made/tiny.amc");

/// A folder with a skeleton and motions.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(skeletons: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in skeletons {
            fs::write(folder.path().join(name), text).unwrap();
        }
        Self(folder)
    }

    fn import(&self, name: &str, motion: &str) -> mocap::Result<Scene> {
        let path = self.0.path().join(name);
        fs::write(&path, motion).unwrap();
        mocap::import(path)
    }

    /// The message of an error, without the path of the folder.
    fn message(&self, name: &str, motion: &str) -> String {
        let folder = format!("{}/", self.0.path().display());
        self.import(name, motion).unwrap_err().to_string().replace(&folder, "")
    }
}

#[test]
fn a_bone_turns_about_its_own_axes() {
    let folder = Folder::new(&[("tiny.asf", SKELETON)]);
    let scene = folder.import("tiny_1.amc", MOTION).unwrap();
    let position = |name: &str, tick| {
        let pose = Pose::at_tick(&scene, 0, tick).unwrap();
        pose.position(node_id(&scene, name).unwrap()).round()
    };
    let names: Vec<&str> = scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["root", "arm", "hand", "EndSite_hand"]);
    // The arm's own x axis points along the world's y. So its link does not change, and the hand rotates from x to -z.
    // The root then rotates y to -x.
    assert_eq!(position("hand", 0.0), Vec3::new(-1.0, 2.0, 3.0));
    let hand = Pose::at_tick(&scene, 0, 0.0)
        .unwrap()
        .position(node_id(&scene, "EndSite_hand").unwrap());
    assert!(hand.abs_diff_eq(Vec3::new(-1.0, 2.0, 2.5), 1e-6), "{hand}");
    // A rotation about the arm's z, which is the world's z, moves its link from y to -x.
    assert_eq!(position("hand", 1.0), Vec3::new(-1.0, 2.0, 3.0));
}

#[test]
fn the_skeleton_is_the_named_one_else_that_of_the_prefix_else_the_only_one() {
    let wrong = SKELETON.replace("hand", "paw");
    let has_hand = |scene: &Scene| node_id(scene, "hand").is_some();
    let only = Folder::new(&[("person.asf", SKELETON)]);
    assert!(has_hand(&only.import("walk.amc", MOTION).unwrap()));

    let several = Folder::new(&[("02.asf", &wrong), ("02_b.ASF", SKELETON), ("0.asf", &wrong)]);
    assert!(has_hand(&several.import("02_b_01.amc", MOTION).unwrap()));
    assert!(!has_hand(&several.import("02_01.amc", MOTION).unwrap()));
    assert_eq!(
        several.message("walk.amc", MOTION),
        "walk.amc: error[missing-file]: the motion needs a skeleton, an .asf file; \
         expected an .asf file in the same folder: one whose name is a prefix of walk.amc, or the only one; found 0.asf, 02.asf, 02_b.ASF; \
         help: name it: `skeleton` 0.asf"
    );
    let named = Importer::new().skeleton(several.0.path().join("02_b.ASF"));
    assert!(has_hand(&named.import(several.0.path().join("walk.amc")).unwrap()));
    assert!(has_hand(&named.read(MOTION.as_bytes(), "from memory.amc").unwrap()));

    let none = Folder::new(&[]);
    assert!(none.message("walk.amc", MOTION).contains("; found none; "));
    let memory = Importer::new().read(MOTION.as_bytes(), "walk.amc").unwrap_err();
    assert_eq!(memory.code(), Code::MissingFile);
}

#[test]
fn broken_skeletons_are_refused_with_their_message() {
    for (from, to, expected) in [
        (
            "length 2",
            "length two",
            "tiny.asf:20:12: error[invalid-number]: \"two\" is not a number; joint \"arm\"; \
            expected the length of the bone; found \"two\"",
        ),
        (
            "direction 0 1 0",
            "direction 0 1",
            "tiny.asf:19:17: error[invalid-number]: a number is missing after this \
            word; joint \"arm\"; expected the Z value of \"direction\"; found the end of the line",
        ),
        (
            "axis 0 0 90 XYZ",
            "axis 0 0 90 XXZ",
            "tiny.asf:21:17: error[unexpected-token]: \"XXZ\" is not allowed \
            here; joint \"arm\"; expected an order of axes, such as XYZ; found \"XXZ\"",
        ),
        (
            "dof rx rz",
            "dof rx rw",
            "tiny.asf:22:12: error[unknown-channel]: \"rw\" is not a channel; joint \"arm\"; \
            expected tx, ty, tz, rx, ry, rz or l; found \"rw\"",
        ),
        (
            "    name hand\n",
            "",
            "tiny.asf:26:3: error[missing-keyword]: this bone has no name; \
            expected name, and the name of the bone; found end",
        ),
        (
            "name hand",
            "name arm",
            "tiny.asf:28:10: error[unexpected-token]: a second bone is called \"arm\"; \
            help: give each bone a unique name, because the hierarchy and the motion refer to it; \
            the first one is in line 18",
        ),
        (
            "root arm",
            "root leg",
            "tiny.asf:35:10: error[unexpected-token]: no bone is called \"leg\"; \
            expected the name of a bone in :bonedata, or root; found \"leg\"; \
            help: add the bone to :bonedata, or remove it here",
        ),
        (
            "root arm",
            "root aarm",
            "tiny.asf:35:10: error[unexpected-token]: no bone is called \"aarm\"; \
            expected the name of a bone in :bonedata, or root; found \"aarm\"; help: did you mean arm?",
        ),
        (
            "length 2",
            "length nan",
            "tiny.asf:20:12: error[non-finite-offset]: a number of a bone must be finite and below 1e18; \
            joint \"arm\"; expected the length of the bone; found \"nan\"",
        ),
        (
            "direction 0 1 0\n    length 2",
            "direction 0 1e10 0\n    length 1e10",
            "tiny.asf:18:10: error[non-finite-offset]: the length of a bone must be below 1e18; joint \"arm\"",
        ),
        (
            "    length 2\n",
            "",
            "tiny.asf:16:3: error[missing-keyword]: this bone has no length; joint \"arm\"; \
            expected length, and a number; found end",
        ),
        (
            "  end\n:hierarchy",
            ":hierarchy",
            "tiny.asf:32:1: error[unexpected-token]: \":hierarchy\" is not allowed here; joint \"hand\"; \
            expected end; found \":hierarchy\"; \
            help: the bone that begins in line 26 has no end; the file lacks the word end",
        ),
        (
            "hand\n  end\n",
            "hand\n",
            "tiny.asf:36:13: error[unexpected-end]: the file ends inside a hierarchy; \
            expected end; found the end of the file; \
            help: the hierarchy that begins in line 34 has no end; the file is cut off or lacks the word end",
        ),
        (
            "arm hand",
            "arm hand arm",
            "tiny.asf:36:14: error[unexpected-token]: \"arm\" already has a parent; \
            help: name each bone once, after its parent, and do not name the root as a child",
        ),
        (
            "    arm hand\n",
            "",
            "tiny.asf:28:10: error[missing-keyword]: a bone is not in the hierarchy; joint \"hand\"; \
            help: name it in :hierarchy after its parent",
        ),
        (
            "root arm\n    arm hand",
            "arm hand\n    hand arm",
            "tiny.asf:18:10: error[unexpected-token]: the hierarchy has \
            a cycle; joint \"arm\"; help: every chain of bones must lead back to the root",
        ),
        (
            ":hierarchy\n  begin\n    root arm\n    arm hand\n  end\n",
            "",
            "tiny.asf:32:6: error[unexpected-end]: the \
            file has no :hierarchy; expected :hierarchy; found the end of the file",
        ),
        (
            "orientation",
            "orientatoin",
            "tiny.asf:14:3: error[unexpected-token]: \"orientatoin\" is not allowed \
            here; expected order, axis, position or orientation; found \"orientatoin\"",
        ),
    ] {
        assert!(SKELETON.contains(from), "{from}");
        let text = SKELETON.replacen(from, to, 1);
        let error = Importer::new().read(text.as_bytes(), "tiny.asf").unwrap_err();
        assert_eq!(error.to_string(), expected);
        // If a motion refers to the same skeleton, the error still names the skeleton's file.
        let folder = Folder::new(&[("tiny.asf", &text)]);
        assert_eq!(folder.message("tiny_1.amc", MOTION), expected);
    }
}

#[test]
fn broken_motions_are_refused_with_their_message() {
    let folder = Folder::new(&[("tiny.asf", SKELETON)]);
    for (from, to, expected) in [
        (
            "arm 90 0",
            "arm 90 O",
            "a.amc:5:8: error[invalid-number]: \"O\" is not a number; joint \"arm\"; \
            expected a value of the bone; found \"O\"",
        ),
        (
            "arm 90 0",
            "arm 90",
            "a.amc:5:1: error[row-length]: the line has the wrong number of values; joint \"arm\"; \
            expected 2 values, as the skeleton states; found 1; \
            help: check that tiny.asf is the skeleton of the same person",
        ),
        (
            "arm 90 0",
            "leg 90 0",
            "a.amc:5:1: error[unexpected-token]: no bone is called \"leg\"; expected the number \
            of a frame, or the name of a bone of the skeleton; found \"leg\"; help: check that tiny.asf is the \
            skeleton of the same person",
        ),
        (
            "arm 90 0",
            "Arm 90 0",
            "a.amc:5:1: error[unexpected-token]: no bone is called \"Arm\"; expected the number \
            of a frame, or the name of a bone of the skeleton; found \"Arm\"; help: did you mean arm? If not, check \
            that tiny.asf is the skeleton of the same person",
        ),
        (
            "2\nroot",
            "99999999999999999999\nroot",
            "a.amc:6:1: error[invalid-number]: \"99999999999999999999\" is too large for a frame number; \
            expected 2, or another whole number below 2^64; found \"99999999999999999999\"",
        ),
        (
            "2\nroot",
            "root",
            "a.amc:6:1: error[unexpected-token]: the bone occurs twice in this frame; joint \"root\"; \
            help: put the number of the next frame before the bone",
        ),
        (
            "1\nroot",
            "root",
            "a.amc:3:1: error[unexpected-token]: \"root\" is not allowed here; expected the number \
            of the first frame; found \"root\"",
        ),
        (
            ":DEGREES",
            ":GRADS",
            "a.amc:2:1: error[unexpected-token]: \":GRADS\" is not allowed here; expected \
            :FULLY-SPECIFIED, :DEGREES, :RADIANS; found \":GRADS\"",
        ),
    ] {
        assert!(MOTION.contains(from), "{from}");
        assert_eq!(folder.message("a.amc", &MOTION.replacen(from, to, 1)), expected);
    }
}

#[test]
fn motions_with_flaws_are_read_and_the_flaws_told() {
    let folder = Folder::new(&[("tiny.asf", SKELETON)]);
    let third = format!("{MOTION}3\nroot 1 2 3 0 0 0\narm 0 90\n");
    for (motion, warning) in [
        (
            third.replace("3\nroot", "5\nroot"),
            "frame numbers are not consecutive; the frames were read in the order of the \
            file; expected 3; found 5",
        ),
        (
            third.replacen("arm 0 90\n", "", 1),
            "1 of 3 frames have no value for the bone; joint \"arm\"",
        ),
        (
            third.replace("arm 90 0", "arm nan 0"),
            "the value is not finite; the last finite value was used; joint \
            \"arm\"; expected a finite number; found \"nan\"",
        ),
        (
            third.replace("arm 90 0", "arm 90,5 0"),
            "numbers have decimal commas, which were read as decimal points",
        ),
        (
            format!("{third}4\nroot 1 2"),
            "the file ends inside its last frame, which was dropped; expected 2 bones; \
            found 0; help: the file is cut off: export or download it again",
        ),
        (
            ":DEGREES\n".to_owned(),
            "the file has no frames: the scene has a skeleton and no animation",
        ),
    ] {
        let scene = folder.import("a.amc", &motion).unwrap();
        let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(warnings, [warning]);
    }
    let gap = folder.import("a.amc", &third.replacen("arm 0 90\n", "", 1)).unwrap();
    assert_eq!(gap.animations[0].channels[1].rotation_keys.ticks, Some(vec![0.0, 2.0]));
}

#[test]
fn radians_are_radians() {
    let folder = Folder::new(&[("tiny.asf", SKELETON)]);
    let quarter = std::f64::consts::FRAC_PI_2.to_string();
    let motion = MOTION.replace(":DEGREES", ":RADIANS").replace("90", &quarter);
    let scene = folder.import("a.amc", &motion).unwrap();
    let expected = folder.import("b.amc", MOTION).unwrap();
    assert_eq!(scene.animations, expected.animations);
}

#[test]
fn claims_beyond_the_limits_are_refused() {
    let limits = |change: fn(&mut Limits)| {
        let mut limits = Limits::default();
        change(&mut limits);
        Importer::new().limits(limits)
    };
    let skeleton = |change| {
        limits(change)
            .read(SKELETON.as_bytes(), "tiny.asf")
            .map_err(|error| error.code())
    };
    assert!(skeleton(|limits| limits.max_nodes = 4).is_ok());
    assert_eq!(skeleton(|limits| limits.max_nodes = 3), Err(Code::LimitExceeded));
    assert!(skeleton(|limits| limits.max_depth = 3).is_ok());
    assert_eq!(skeleton(|limits| limits.max_depth = 2), Err(Code::LimitExceeded));

    let folder = Folder::new(&[("tiny.asf", SKELETON), ("tiny_1.amc", MOTION)]);
    let motion = |change| {
        limits(change)
            .import(folder.0.path().join("tiny_1.amc"))
            .map_err(|error| error.code())
    };
    assert!(motion(|limits| limits.max_values = 16).is_ok());
    assert_eq!(motion(|limits| limits.max_values = 15), Err(Code::LimitExceeded));
}

/// The bytes that replace a byte: characters with a meaning in these files, and characters without one.
const BYTES: &[u8] = b"\0\t\n #+,-.0:9E_e(XxR\x80\xff";

fn damaged(original: &[u8]) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for position in 0..original.len() {
        all.push(original[..position].to_vec());
        all.push([&original[..position], &original[position + 1..]].concat());
        for &byte in BYTES {
            let mut changed = original.to_vec();
            changed[position] = byte;
            all.push(changed);
        }
    }
    all
}

#[test]
fn every_damage_is_an_error_or_a_valid_scene() {
    // In builds with debug assertions, as in these tests, the importer validates its scenes.
    for bytes in damaged(SKELETON.as_bytes()) {
        let _ = Importer::new()
            .format(mocap::Format::AsfAmc)
            .read(&bytes, Path::new("damaged.asf"));
    }
    let folder = Folder::new(&[("tiny.asf", SKELETON)]);
    let importer = Importer::new()
        .format(mocap::Format::AsfAmc)
        .skeleton(folder.0.path().join("tiny.asf"));
    let mut read = 0;
    for bytes in damaged(MOTION.as_bytes()) {
        read += usize::from(importer.read(&bytes, Path::new("damaged.amc")).is_ok());
    }
    assert!(read > 0, "the skeleton was not found");
}
