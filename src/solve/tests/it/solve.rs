//! Tests of solving rotations from positions: the positions are restored, and bones have the roll of the file.

#![allow(clippy::unwrap_used, reason = "a failed assumption in a test is the test's failure")]

use std::collections::BTreeMap;
use std::fs;

use mocap::figure::{Humanoid, HumanoidBone as Bone, vrm_humanoid};
use mocap::glam::{Quat, Vec3};
use mocap::scene::NodeId;
use mocap::solve::Lengths;
use mocap::{Code, Conversion, Importer, Pose, Scene};

use crate::sample::Sample;

/// An `.npy` file of 32-bit numbers, in NumPy's format version 1.0.
fn npy(shape: &[usize], values: &[f32]) -> Vec<u8> {
    let shape: String = shape.iter().map(|length| format!("{length},")).collect();
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({shape}), }}\n");
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    let values: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &values].concat()
}

/// The positions of bones, and their rotations from the T-pose, indexed by bone, then frame.
struct Truth {
    bones: Vec<Bone>,
    places: Vec<Vec<Vec3>>,
    rotations: BTreeMap<Bone, Vec<Quat>>,
    rate: f64,
}

impl Truth {
    /// The motion of a humanoid. The true rotations come from a VRM animation of the motion. Solving does not use them.
    fn of(mut scene: Scene, frames: usize) -> Option<Self> {
        Conversion::new().apply(&mut scene).ok()?;
        let found = Humanoid::of(&scene);
        let rate = scene.animations.first()?.ticks_per_second;
        if !found.found {
            return None;
        }
        let normalized = vrm_humanoid(&scene, None).ok()?;
        let frames = frames.min(scene.animations[0].frame_count());
        let bones: Vec<Bone> = Bone::ALL
            .iter()
            .copied()
            .filter(|bone| found.bones.contains_key(bone))
            .collect();
        let mut places = vec![Vec::new(); bones.len()];
        let mut rotations = BTreeMap::<Bone, Vec<Quat>>::new();
        for frame in 0..frames {
            let pose = Pose::at_tick(&scene, 0, frame as f64).unwrap();
            for (bone, places) in std::iter::zip(&bones, &mut places) {
                places.push(pose.position(found.bones[bone].joint));
            }
            rotations_at(&normalized, frame, &mut rotations);
        }
        Some(Self {
            bones,
            places,
            rotations,
            rate,
        })
    }

    /// The joints as a JSON set: the parent of each bone is the nearest existing bone above.
    fn joints(&self) -> String {
        let parent = |bone: &Bone| {
            std::iter::successors(bone.parent(), |above| above.parent()).find(|above| self.bones.contains(above))
        };
        let joint = |bone: &Bone| match parent(bone) {
            Some(parent) => format!(
                r#"{{"name": "{0}", "bone": "{0}", "parent": "{1}"}}"#,
                bone.as_str(),
                parent.as_str()
            ),
            None => format!(r#"{{"name": "{0}", "bone": "{0}"}}"#, bone.as_str()),
        };
        format!("[{}]", self.bones.iter().map(joint).collect::<Vec<_>>().join(","))
    }

    /// The changes of distances that would be constant in rigid parts: from a bone to the bone above, and between two
    /// bones on one parent.
    fn stretch(&self) -> f32 {
        let place = |bone: Bone| self.bones.iter().position(|own| *own == bone);
        let parent = |bone: &Bone| std::iter::successors(bone.parent(), |above| above.parent()).find_map(place);
        let mut most = 0_f32;
        for (own, bone) in self.bones.iter().enumerate() {
            let Some(above) = parent(bone) else { continue };
            let on_one = (0..own).filter(|other| parent(&self.bones[*other]) == Some(above));
            for other in on_one.chain([above]) {
                let lengths = std::iter::zip(&self.places[own], &self.places[other]).map(|(a, b)| a.distance(*b));
                let (least, largest) = lengths.fold((f32::MAX, 0_f32), |(a, b), length| (a.min(length), b.max(length)));
                most = most.max(largest - least);
            }
        }
        most
    }

    fn solved(&self) -> Scene {
        let folder = tempfile::tempdir().unwrap();
        let joints = folder.path().join("joints.json");
        fs::write(&joints, self.joints()).unwrap();
        let (frames, count) = (self.places[0].len(), self.bones.len());
        let values: Vec<f32> = (0..frames)
            .flat_map(|frame| self.places.iter().flat_map(move |places| places[frame].to_array()))
            .collect();
        let file = folder.path().join("points.npy");
        fs::write(&file, npy(&[frames, count, 3], &values)).unwrap();
        let importer = Importer::new().joints(joints.to_str().unwrap()).retime(self.rate);
        importer.import(&file).unwrap()
    }
}

/// Adds the world rotations of the bones of a scene whose rest pose has no rotations.
fn rotations_at(scene: &Scene, frame: usize, rotations: &mut BTreeMap<Bone, Vec<Quat>>) {
    let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
    for (index, node) in scene.nodes.iter().enumerate() {
        if let Some(bone) = node.humanoid_bone {
            let rotation = Quat::from_mat4(&pose.node_to_world[index]).normalize();
            rotations.entry(bone).or_default().push(rotation);
        }
    }
}

/// The measures of a file.
#[derive(Debug, Default)]
struct Found {
    /// The largest distance of a joint, in metres.
    off: f32,
    stretch: f32,
    /// The number of frames with bent limbs, and the number of frames among them in which the roll is within 10
    /// degrees.
    bent: usize,
    near: usize,
    /// The number of these frames in which the roll is within 10 degrees of a constant angle of the limb. The hinges of
    /// some files differ from a T-pose by such an angle.
    near_constant: usize,
    /// The bone with the largest error, and its frame.
    worst: Option<(Bone, usize)>,
    /// The largest change of a limb's roll from one frame to the next, in degrees, and the largest change in the file
    /// itself.
    flip: f32,
}

/// Two bones with a hinge between them, and the end of the second bone.
const LIMBS: [[Bone; 3]; 4] = [
    [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand],
    [Bone::RightUpperArm, Bone::RightLowerArm, Bone::RightHand],
    [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot],
    [Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot],
];

fn measure(truth: &Truth) -> Found {
    let solved = truth.solved();
    let mut found = Found {
        stretch: truth.stretch(),
        ..Found::default()
    };
    let node = |bone: Bone| {
        NodeId::new(
            solved
                .nodes
                .iter()
                .position(|node| node.humanoid_bone == Some(bone))
                .unwrap(),
        )
    };
    let mut rotations = BTreeMap::<Bone, Vec<Quat>>::new();
    for frame in 0..truth.places[0].len() {
        let pose = Pose::at_tick(&solved, 0, frame as f64).unwrap();
        for (bone, places) in std::iter::zip(&truth.bones, &truth.places) {
            let off = pose.position(node(*bone)).distance(places[frame]);
            if off > found.off {
                (found.off, found.worst) = (off, Some((*bone, frame)));
            }
        }
        rotations_at(&solved, frame, &mut rotations);
    }
    for limb in LIMBS {
        {
            let [upper, _, _] = limb;
            let place = |bone: Bone| truth.bones.iter().position(|own| *own == bone);
            let (Some(a), Some(b), Some(c)) = (place(limb[0]), place(limb[1]), place(limb[2])) else {
                continue;
            };
            let (Some(own), Some(file)) = (rotations.get(&upper), truth.rotations.get(&upper)) else {
                continue;
            };
            let along = |frame: usize| (truth.places[b][frame] - truth.places[a][frame]).normalize_or_zero();
            let mut before: Option<Quat> = None;
            let mut twists = Vec::new();
            for frame in 0..own.len() {
                let below = (truth.places[c][frame] - truth.places[b][frame]).normalize_or_zero();
                let bend = along(frame).angle_between(below).to_degrees();
                let twist = twist(own[frame] * file[frame].inverse(), along(frame));
                if bend > 20.0 {
                    found.bent += 1;
                    found.near += usize::from(twist.abs() <= 10.0);
                    twists.push(twist);
                }
                // A file may begin with a T-pose from which the motion jumps.
                if let Some(before) = before.filter(|_| frame > 1) {
                    // The rotation beyond the limb's own rotation.
                    let carried = Quat::from_rotation_arc(along(frame - 1), along(frame)) * before;
                    found.flip = found
                        .flip
                        .max(self::twist(own[frame] * carried.inverse(), along(frame)).abs());
                }
                before = Some(own[frame]);
            }
            twists.sort_unstable_by(f32::total_cmp);
            let median = twists.get(twists.len() / 2).copied().unwrap_or(0.0);
            found.near_constant += twists.iter().filter(|twist| (**twist - median).abs() <= 10.0).count();
        }
    }
    found
}

/// The angle of a rotation about an axis, in degrees.
fn twist(rotation: Quat, axis: Vec3) -> f32 {
    let along = Vec3::new(rotation.x, rotation.y, rotation.z).dot(axis);
    let angle = 2.0 * along.atan2(rotation.w).to_degrees();
    (angle + 180.0).rem_euclid(360.0) - 180.0
}

/// Files in which a humanoid moves.
fn files() -> Vec<std::path::PathBuf> {
    let mut files: Vec<_> = fs::read_dir("../../fixtures/real")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| ["bvh", "fbx", "amc"].contains(&path.extension().unwrap().to_str().unwrap()))
        .collect();
    files.extend(std::env::var_os("MOCAP_MOTIONS").into_iter().flat_map(|folder| {
        fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect::<Vec<_>>()
    }));
    files.sort();
    files
}

/// Files whose positions are not restored within 2 mm, and the reasons.
const OPEN: [(&str, &str); 4] = [
    (
        "makehuman_fly_one_frame.bvh",
        "it lies, so that another axis is taken for up",
    ),
    ("nan_tokens.bvh", "it lies, so that another axis is taken for up"),
    ("motionbuilder_vicon_walk.bvh", "the head, by 68 mm: not understood"),
    ("hip_knee_ankle_names.bvh", "a hand, by 3.4 mm: not understood"),
];

/// With `MOCAP_MOTIONS=FOLDER`, also the files of a folder.
#[test]
fn positions_come_back_and_limbs_are_turned_as_in_the_file() {
    let (mut bent, mut near, mut near_constant, mut bad) = (0, 0, 0, Vec::new());
    for file in Sample::new().some(files(), 4) {
        let Ok(scene) = mocap::import(&file) else { continue };
        let Some(truth) = Truth::of(scene, 300) else { continue };
        let found = measure(&truth);
        eprintln!("{}: {found:?}", file.display());
        (bent, near) = (bent + found.bent, near + found.near);
        near_constant += found.near_constant;
        let is_open = OPEN.iter().any(|(name, _)| file.ends_with(name));
        if !is_open && found.stretch < 0.0005 && found.off >= 0.002 || found.flip >= 60.0 {
            bad.push(format!("{}: {found:?}", file.display()));
        }
    }
    eprintln!("{near} of {bent} frames with a bent limb within 10 degrees, {near_constant} but for a constant");
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

/// The solver finds the rotations from which NumPy computed the positions.
#[test]
fn a_figure_of_round_lengths_is_solved() {
    let scene = mocap::import("../../fixtures/arrays/points_smpl22.npy").unwrap();
    let bytes = fs::read("../../fixtures/arrays/points_smpl22_rotations.npy").unwrap();
    let matrices: Vec<f32> = bytes[128..]
        .as_chunks::<4>()
        .0
        .iter()
        .map(|value| f32::from_le_bytes(*value))
        .collect();
    let bones = [
        (1, Bone::LeftUpperLeg),
        (2, Bone::RightUpperLeg),
        (4, Bone::LeftLowerLeg),
        (5, Bone::RightLowerLeg),
        (16, Bone::LeftUpperArm),
        (17, Bone::RightUpperArm),
        (18, Bone::LeftLowerArm),
        (19, Bone::RightLowerArm),
        (0, Bone::Hips),
    ];
    for frame in 0..60 {
        let mut rotations = BTreeMap::new();
        rotations_at(&scene, frame, &mut rotations);
        for (joint, bone) in bones {
            let row = &matrices[9 * (22 * frame + joint)..][..9];
            let truth = Quat::from_mat3(&mocap::glam::Mat3::from_cols_slice(row).transpose());
            let angle = rotations[&bone][0].angle_between(truth).to_degrees();
            assert!(angle < 0.5, "{bone:?} in frame {frame}: {angle} degrees");
        }
    }
}

/// A table of positions whose bones change their lengths. Joints are at the positions of the table in every frame.
#[test]
fn moving_lengths_keep_every_position() {
    let joints = ["hips", "leftUpperLeg", "leftLowerLeg", "leftFoot"];
    let place = |joint: usize, frame: usize| {
        let (joint, time) = (joint as f32, frame as f32 * 0.1);
        let length = 0.4 + 0.05 * (3.0 * time + joint).sin();
        Vec3::new(
            0.1 * joint + time,
            1.2 - length * joint,
            0.2 * (2.0 * time).sin() * joint * joint,
        )
    };
    let mut text = "frame,joint,x,y,z\n".to_owned();
    for frame in 0..20 {
        for (joint, name) in joints.iter().enumerate() {
            let at = place(joint, frame);
            text += &format!("{frame},{name},{},{},{}\n", at.x, at.y, at.z);
        }
    }
    let set: Vec<String> = std::iter::zip(joints, [None, Some("hips"), Some("leftUpperLeg"), Some("leftLowerLeg")])
        .map(|(name, parent)| {
            let parent = parent.map_or("null".to_owned(), |parent| format!("\"{parent}\""));
            format!("{{\"name\": \"{name}\", \"bone\": \"{name}\", \"parent\": {parent}}}")
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("joints.json");
    fs::write(&file, format!("[{}]", set.join(", "))).unwrap();
    let table = folder.path().join("points.csv");
    fs::write(&table, &text).unwrap();
    let farthest = |lengths: Option<Lengths>| {
        let mut importer = Importer::new().joints(file.to_string_lossy());
        if let Some(lengths) = lengths {
            importer = importer.lengths(lengths);
        }
        let scene = importer.import(&table).unwrap();
        let node = |name: &str| NodeId::new(scene.nodes.iter().position(|node| node.name == name).unwrap());
        let off = |frame: usize| {
            let pose = Pose::at_tick(&scene, 0, frame as f64).unwrap();
            let distance = |(joint, name): (usize, &&str)| pose.position(node(name)).distance(place(joint, frame));
            joints.iter().enumerate().map(distance).fold(0.0, f32::max)
        };
        (0..20).map(off).fold(0.0, f32::max)
    };
    assert!(
        farthest(Some(Lengths::Moving)) < 1e-5,
        "{}",
        farthest(Some(Lengths::Moving))
    );
    assert!(farthest(Some(Lengths::Median)) > 0.01);
    assert_eq!(farthest(None), farthest(Some(Lengths::Median)));
    // A gap is reported once, and filled linearly.
    let gap: Vec<&str> = text.lines().filter(|line| !line.starts_with("5,leftFoot")).collect();
    fs::write(&table, gap.join("\n")).unwrap();
    let scene = Importer::new().joints(file.to_string_lossy()).import(&table).unwrap();
    let gaps: Vec<String> = scene
        .warnings
        .iter()
        .filter(|one| one.code == Code::Gap)
        .map(ToString::to_string)
        .collect();
    assert!(
        gaps.len() == 1 && gaps[0].contains("1 of 20 frames: positions were interpolated"),
        "{gaps:?}"
    );
    let needless = Importer::new()
        .lengths(Lengths::Moving)
        .import("../../fixtures/real/lecture_Test.bvh")
        .unwrap_err();
    assert!(needless.to_string().contains("nothing is solved here"), "{needless}");
}

#[test]
fn what_does_not_go_with_the_points_is_named() {
    let import = |joints: &str| {
        Importer::new()
            .joints(joints)
            .import("../../fixtures/arrays/points_fortran.npy")
            .unwrap_err()
    };
    let error = import("coco17");
    assert_eq!(error.code(), Code::InvalidValue);
    assert!(
        error.to_string().contains("17 points, or their names; missing: nose"),
        "{error}"
    );
    assert!(
        import("nosuch").to_string().contains("smpl22, smpl24, coco17"),
        "{}",
        import("nosuch")
    );
    // An array without names matches a set by the number of points. The set takes the points in the order of the array,
    // and needs each point.
    for (name, count) in [
        ("coco17", 17),
        ("h36m", 17),
        ("mediapipe33", 33),
        ("openpose25", 25),
        ("mhr70", 70),
        ("mhr127", 127),
        ("smpl24", 24),
    ] {
        let values: Vec<f32> = (0..3 * 2 * count).map(|value| (value as f32 * 0.7).sin()).collect();
        let scene = Importer::new()
            .joints(name)
            .read(&npy(&[2, count, 3], &values), "a.npy")
            .unwrap();
        assert!(
            scene
                .nodes
                .iter()
                .any(|node| node.humanoid_bone == Some(Bone::LeftLowerLeg)),
            "{name}"
        );
        // All points are in one place, and some are NaN.
        for value in [0.0, f32::NAN] {
            let read = Importer::new()
                .joints(name)
                .read(&npy(&[2, count, 3], &vec![value; 6 * count]), "a.npy");
            assert_eq!(read.is_ok(), value == 0.0, "{name}");
        }
    }
}
