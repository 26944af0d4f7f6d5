//! Tests of reading arrays of other programs. The results are compared with joints that NumPy has posed
//! (`tools/arrays/make_fixtures.py`) and with the positions in the files. Hostile files are refused.

#![allow(clippy::unwrap_used, reason = "a failed assumption in a test is the test's failure")]

use std::collections::BTreeMap;
use std::fs;

use mocap::arrays::{ArrayOptions, Arrays, BodyArrays, BodyLayout, Rotation, RotationSpace};
use mocap::figure::vrm_humanoid;
use mocap::glam::Vec3;
use mocap::scene::{HumanoidBone, NodeId, Topic, UpAxis};
use mocap::{Code, Importer, Pose, Scene};
use serde::Deserialize;

fn path(name: &str) -> String {
    format!("../../fixtures/arrays/{name}")
}

fn import(name: &str) -> Scene {
    mocap::import(path(name)).unwrap()
}

/// The joint positions that NumPy computes from a file: frames x joints x 3, in the order of the layout, with +Y up.
#[derive(Deserialize)]
struct Expected {
    frame_rate: f64,
    positions: Vec<Vec<[f32; 3]>>,
}

fn expected() -> BTreeMap<String, Expected> {
    serde_json::from_str(&fs::read_to_string(path("expected.json")).unwrap()).unwrap()
}

/// The largest distance of a joint from its expected position. The scene is depth-first but the layout is not, so
/// joints are found by name.
fn farthest(scene: &Scene, names: &[&str], positions: &[Vec<[f32; 3]>]) -> f32 {
    let nodes: Vec<NodeId> = names
        .iter()
        .map(|name| NodeId::new(scene.nodes.iter().position(|node| node.name == *name).unwrap()))
        .collect();
    let mut farthest = 0_f32;
    for (frame, joints) in positions.iter().enumerate() {
        let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
        for (node, place) in std::iter::zip(&nodes, joints) {
            farthest = farthest.max(pose.position(*node).distance(Vec3::from(*place)));
        }
    }
    farthest
}

/// The names of SMPL's family, as its publishers order them.
fn smpl_names(count: usize) -> Vec<String> {
    let body = "pelvis left_hip right_hip spine1 left_knee right_knee spine2 left_ankle right_ankle spine3 left_foot \
                right_foot neck left_collar right_collar head left_shoulder right_shoulder left_elbow right_elbow \
                left_wrist right_wrist";
    let mut names: Vec<String> = body.split_whitespace().map(str::to_owned).collect();
    let mut hands = Vec::new();
    for side in ["left", "right"] {
        for finger in ["index", "middle", "pinky", "ring", "thumb"] {
            hands.extend((1..=3).map(|number| format!("{side}_{finger}{number}")));
        }
    }
    match count {
        24 => names.extend(["left_hand".to_owned(), "right_hand".to_owned()]),
        52 => names.extend(hands),
        55 => {
            names.extend(["jaw", "left_eye_smplhf", "right_eye_smplhf"].map(str::to_owned));
            names.extend(hands);
        }
        _ => {}
    }
    names
}

/// Two models store vertices as SMPL does, one of them with a sparse matrix. The file of the motion has the
/// coefficients of the body's shape.
#[test]
fn a_model_gives_lengths_and_shape() {
    let text = fs::read_to_string(path("expected_bodies.json")).unwrap();
    let expected: BTreeMap<String, Vec<Vec<[f32; 3]>>> = serde_json::from_str(&text).unwrap();
    assert_eq!(expected.len(), 2);
    for (model, positions) in expected {
        let scene = Importer::new()
            .body(path(&model))
            .import(path("shaped_smplh.npz"))
            .unwrap();
        let names = smpl_names(52);
        let names: Vec<&str> = names.iter().take(positions[0].len()).map(String::as_str).collect();
        let off = farthest(&scene, &names, &positions);
        assert!(off < 1e-5, "{model}: {off} m");
        let said = scene
            .metadata
            .assumptions
            .iter()
            .find(|said| said.topic == Topic::Body)
            .unwrap();
        assert!(said.reason.contains("coefficients of the file"), "{}", said.reason);
    }
}

#[test]
fn a_figure_gives_lengths() {
    let figure = "../../fixtures/real/cmu_12_01_walk.bvh";
    let scene = Importer::new().body(figure).import(path("shaped_smplh.npz")).unwrap();
    let own = BodyArrays::new(&mocap::import(figure).unwrap()).unwrap();
    let rest = Pose::rest(&scene);
    let place = |name: &str| {
        let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
        rest.position(NodeId::new(node))
    };
    let names = smpl_names(55);
    let stated = |name: &str| {
        let joint = names.iter().position(|own| own == name).unwrap();
        let [x, y, z] = [0, 1, 2].map(|axis| own.rest_joints[3 * joint + axis] as f32);
        Vec3::new(x, y, z)
    };
    for [from, to] in [
        ["left_hip", "left_knee"],
        ["right_knee", "right_ankle"],
        ["left_shoulder", "left_elbow"],
        ["pelvis", "head"],
    ] {
        let (found, expected) = (place(to) - place(from), stated(to) - stated(from));
        assert!(found.distance(expected) < 1e-5, "{from} {to}: {found} {expected}");
    }
}

#[test]
fn a_body_that_cannot_be_used_is_an_error() {
    let on = |body: &str, motion: &str| Importer::new().body(body).import(motion).unwrap_err();
    let model = path("body_smplh.npz");
    for has_lengths in ["kimodo_soma_01.npz", "points_smpl22.npy"] {
        assert_eq!(
            on(&model, &path(has_lengths)).code(),
            Code::InvalidValue,
            "{has_lengths}"
        );
    }
    assert_eq!(
        on(&model, "../../fixtures/real/cmu_short.bvh").code(),
        Code::InvalidValue
    );
    let shaped = path("shaped_smplh.npz");
    assert_eq!(
        on("../../fixtures/real/optotrak.c3d", &shaped).code(),
        Code::NotHumanoid
    );
    assert!(on("nosuch.npz", &shaped).to_string().contains("nosuch.npz"));
    // A model that lacks a necessary part, and a truncated model.
    let bytes = fs::read(path("body_smpl.pkl")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let cut = folder.path().join("cut.pkl");
    fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    assert_eq!(on(cut.to_str().unwrap(), &shaped).code(), Code::UnexpectedEnd);
    let other = folder.path().join("other.pkl");
    let at = bytes.windows(7).position(|window| window == b"indices").unwrap();
    let mut renamed = bytes;
    renamed[at] = b'X';
    fs::write(&other, renamed).unwrap();
    assert_eq!(on(other.to_str().unwrap(), &shaped).code(), Code::MissingKeyword);
}

#[test]
fn joints_are_where_numpy_poses_them() {
    for (file, expected) in expected() {
        let scene = import(&file);
        let count = expected.positions[0].len();
        let names = smpl_names(count);
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        assert_eq!((scene.nodes.len(), names.len()), (count, count), "{file}");
        assert_eq!(scene.animations[0].ticks_per_second, expected.frame_rate, "{file}");
        assert_eq!(scene.animations[0].frame_count(), expected.positions.len(), "{file}");
        let farthest = farthest(&scene, &names, &expected.positions);
        assert!(farthest < 1e-5, "{file}: {farthest} m");
        assert_eq!(scene.metadata.up, Some(UpAxis::Y));
    }
}

/// One motion in six files: dictionaries in three protocols, tensors, and rows without names. These files have no
/// lengths, so only rotations are compared.
#[test]
fn one_motion_is_equal_in_every_file() {
    let options = ArrayOptions::new().rotation_space(RotationSpace::World);
    let first = Arrays::of(&import("smplx_protocol_4.pkl"), &options).unwrap();
    let joint =
        |motion: &mocap::arrays::Arrays, name: &str| motion.joints().iter().position(|joint| joint.name == name);
    for (file, rate) in [("gvhmr.pt", 30.0), ("motion_x_322.npy", 30.0), ("phuma_69.npy", 30.0)] {
        let scene = import(file);
        let other = Arrays::of(&scene, &options).unwrap();
        assert_eq!((other.frames, other.frame_rate()), (2, rate), "{file}");
        let assumed = |topic| scene.metadata.assumptions.iter().any(|said| said.topic == topic);
        assert!(assumed(Topic::Body) && assumed(Topic::FrameRate), "{file}");
        assert_eq!(assumed(Topic::Layout), file.ends_with(".npy"), "{file}");
        for name in smpl_names(22) {
            let (own, others) = (joint(&first, &name).unwrap(), joint(&other, &name).unwrap());
            for frame in 0..2 {
                let at = |motion: &mocap::arrays::Arrays, joint: usize| {
                    let begin = 4 * (frame * motion.joints().len() + joint);
                    mocap::glam::Quat::from_slice(&motion.rotations[begin..begin + 4])
                };
                let angle = at(&first, own).angle_between(at(&other, others)).to_degrees();
                assert!(angle < 0.1, "{file}: {name} is {angle} degrees off");
            }
        }
    }
}

/// Kimodo's file has positions in addition to its rotations.
#[test]
fn kimodo_poses_its_own_positions() {
    let scene = import("kimodo_soma_01.npz");
    assert_eq!((scene.nodes.len(), scene.animations[0].frame_count()), (30, 150));
    // The values that `numpy.load` prints of posed_joints: Hips, Neck1 and RightToeBase, the joints 0, 4 and 29.
    let names = ["Hips", "Neck1"];
    let positions = vec![vec![
        [0.0, 1.000_736_7, 0.056_332_9],
        [-2.051_517_4e-5, 1.459_016_3, 0.068_064_28],
    ]];
    assert!(farthest(&scene, &names, &positions) < 1e-5);
    let bone = |name: &str| scene.nodes.iter().find(|node| node.name == name).unwrap().humanoid_bone;
    assert_eq!(bone("LeftShin"), Some(HumanoidBone::LeftLowerLeg));
    assert_eq!(bone("Neck2"), None);
}

/// Our own arrays, in each form of rotations, are read back to a scene that gives equal arrays.
#[test]
fn own_arrays_come_back() {
    for name in [
        "real/cmu_short.bvh",
        "real/lecture_Test.bvh",
        "real/perception_neuron_moving_positions.bvh",
    ] {
        let scene = mocap::import(format!("../../fixtures/{name}")).unwrap();
        for rotation in [Rotation::Quaternion, Rotation::SixD, Rotation::Matrix, Rotation::Euler] {
            for space in [RotationSpace::Local, RotationSpace::World] {
                let first = Arrays::of(&scene, &ArrayOptions::new().rotation(rotation).rotation_space(space)).unwrap();
                let back = Importer::new().read(&first.to_npz(), "own.npz").unwrap();
                let plain = ArrayOptions::new()
                    .rotation(Rotation::Matrix)
                    .rotation_space(RotationSpace::World);
                let (first, again) = (Arrays::of(&scene, &plain).unwrap(), Arrays::of(&back, &plain).unwrap());
                assert_eq!(first.joints(), again.joints(), "{name}");
                assert_eq!(
                    (first.frames, first.frame_rate()),
                    (again.frames, again.frame_rate()),
                    "{name}"
                );
                let largest = |values: &[f32]| values.iter().fold(1_f32, |most, value| most.max(value.abs()));
                let off = |first: &[f32], again: &[f32]| {
                    std::iter::zip(first, again).fold(0_f32, |most, (a, b)| most.max((a - b).abs())) / largest(first)
                };
                assert!(
                    off(&first.positions, &again.positions) < 2e-6,
                    "{name}: {rotation:?} {space:?}"
                );
                assert!(
                    off(&first.rotations, &again.rotations) < 2e-5,
                    "{name}: {rotation:?} {space:?}"
                );
            }
        }
    }
}

/// CSV and Parquet have the numbers of the `.npz`, bit by bit. So their scenes are equal, and so are the outputs of
/// `fk`.
#[test]
fn tables_come_back_as_the_archive_does() {
    for name in [
        "real/cmu_short.bvh",
        "real/lecture_Test.bvh",
        "real/perception_neuron_moving_positions.bvh",
    ] {
        let mut scene = mocap::import(format!("../../fixtures/{name}")).unwrap();
        // Names that a table must quote, and a name that a spreadsheet would calculate.
        scene.nodes[1].name = "=a,\"b\"".to_owned();
        for rotation in [Rotation::Quaternion, Rotation::SixD, Rotation::Matrix, Rotation::Euler] {
            let options = ArrayOptions::new().rotation(rotation).velocities(true);
            let arrays = Arrays::of(&scene, &options).unwrap();
            let read = |bytes: &[u8], name: &str| Importer::new().read(bytes, name).unwrap();
            let archive = read(&arrays.to_npz(), "own.npz");
            let table = read(arrays.to_csv().as_bytes(), "own.csv");
            let sheet = read(arrays.to_csv_for_spreadsheet().as_bytes(), "own.csv");
            for other in [&table, &sheet] {
                assert_eq!(archive.nodes, other.nodes, "{name} {rotation:?}");
                assert_eq!(archive.animations, other.animations, "{name} {rotation:?}");
            }
            #[cfg(feature = "parquet")]
            {
                use mocap::arrays::table;
                let clips = table::clips(&[("broken", Err("empty file")), ("Motion", Ok(&arrays))], &options);
                for bytes in [
                    arrays.to_parquet("Motion").unwrap(),
                    table::to_parquet([clips]).unwrap(),
                ] {
                    let other = read(&bytes, "own.parquet");
                    assert_eq!(archive.nodes, other.nodes, "{name} {rotation:?}");
                    assert_eq!(archive.animations, other.animations, "{name} {rotation:?}");
                }
            }
        }
    }
}

/// Joints of several trees, and a selection of joints, have no common root. A list may have parents first in any order.
#[test]
fn arrays_of_several_roots_have_one_parent() {
    let scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let options = ArrayOptions::new().joints("Arm|Hand$".to_owned());
    let chosen = Arrays::of(&scene, &options).unwrap();
    let roots = chosen.joints().iter().filter(|joint| joint.parent.is_none()).count();
    assert!(roots > 1);
    let back = Importer::new().read(&chosen.to_npz(), "own.npz").unwrap();
    assert_eq!(back.validate(), []);
    let again = Arrays::of(&back, &ArrayOptions::new()).unwrap();
    assert_eq!(again.joints(), chosen.joints());
    let off = |(a, b): (&f32, &f32)| (a - b).abs();
    assert!(
        std::iter::zip(&chosen.positions, &again.positions)
            .map(off)
            .fold(0.0, f32::max)
            < 1e-4
    );
}

#[test]
fn tables_that_are_no_motion_or_are_damaged_say_where() {
    let scene = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let own = Arrays::of(&scene, &ArrayOptions::new()).unwrap().to_csv();
    let lines: Vec<&str> = own.lines().collect();
    let without = |line: usize| {
        let kept: Vec<&str> = lines
            .iter()
            .enumerate()
            .filter(|(at, _)| *at != line)
            .map(|(_, line)| *line)
            .collect();
        kept.join("\n") + "\n"
    };
    let far = "frame,joint,x,y,z\n0,a,1,2,3\n900000000000,a,1,2,3\n";
    for (text, part) in [
        (without(5), "line 6: the row does not have the next frame or joint"),
        (lines[..3].join("\n"), "the first frame does not have all joints"),
        (lines[..3].join("\n") + "\n0,0", "number of cells"),
        (own.replacen(",0.1,", ",zero,", 1), "line 3: the cell x is not a number"),
        ("file,clip,frames,score\n".to_owned(), "its columns are not positions"),
        (far.to_owned(), "the frames from 0 to 900000000000"),
        ("frame,joint,x,y,z\n".to_owned(), "the table has no rows"),
        (
            "frame,joint,x,y,z\none,a,1,2,3\n".to_owned(),
            "line 2: the frame is not a whole number",
        ),
        (
            "a_x,a_y,a_z,b_x,b_y,b_z,c_x,c_y,c_z\n1,2,3\n".to_owned(),
            "line 2: the row has fewer cells",
        ),
    ] {
        let found = error(text.as_bytes(), "table.csv").to_string();
        assert!(found.contains(part), "{part}: {found}");
    }
}

/// A table that ends inside a frame keeps the frames before it. The capture has 10 frames.
#[test]
fn a_table_that_is_cut_off_has_its_whole_frames() {
    let scene = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let own = Arrays::of(&scene, &ArrayOptions::new()).unwrap().to_csv();
    let without_last_row = &own[..own.trim_end().rfind('\n').unwrap() + 1];
    let wide = "a_x,a_y,a_z,b_x,b_y,b_z,c_x,c_y,c_z\n1,2,3,4,5,6,7,8,9\n1,2,3,4,5,6,7,8,9\n1,2,3\n";
    for (text, frames) in [(without_last_row, 9), (&own[..own.len() - 9], 9), (wide, 2)] {
        let scene = Importer::new().retime(30.0).read(text.as_bytes(), "table.csv").unwrap();
        assert_eq!(scene.animations[0].frame_count(), frames);
        let [warning] = &*scene.warnings else {
            panic!("{:?}", scene.warnings)
        };
        assert!(
            warning.code == Code::RowLength && warning.message.contains("which was dropped"),
            "{warning}"
        );
    }
}

/// Tables of points, with names, gaps and a frame rate that a person has read from the text.
#[test]
fn tables_of_positions_are_points() {
    let wide = "Time;Hip_X;Hip_Y;Hip_Z;Knee.x;Knee.y;Knee.z;x_Toe;y_Toe;z_Toe;note\r\n\
                0;0;1;0;0;0.5;0;0;0;0.1;first\r\n0.02;0;1;0;;;;0;0;0.2;\r\n0.04;0;1;0;0;0.5;0.2;0;NaN;0.3;\r\n";
    let long = "frame,time,joint,x,y,z\n7,0,Hip,0,1,0\n7,0,Knee,0,0.5,0\n7,0,Toe,0,0,0.1\n8,0.02,Toe,0,0,0.2\n\
                8,0.02,Hip,0,1,0\n9,0.04,Hip,0,1,0\n9,0.04,Knee,0,0.5,0.2\n";
    for text in [wide, long] {
        let scene = Importer::new().read(text.as_bytes(), "points.csv").unwrap();
        let names: Vec<&str> = scene.nodes.iter().skip(1).map(|node| node.name.as_str()).collect();
        assert_eq!(names, ["Hip", "Knee", "Toe"]);
        let animation = &scene.animations[0];
        assert_eq!((animation.ticks_per_second, animation.duration), (50.0, 2.0));
        let knee = &animation.channels[1].position_keys;
        assert_eq!((knee.tick(0), knee.tick(1)), (0.0, 2.0), "the gap has no key");
        assert_eq!(knee.values, [Vec3::new(0.0, 0.5, 0.0), Vec3::new(0.0, 0.5, 0.2)]);
        assert_eq!(animation.channels[2].position_keys.values.len(), 2);
    }
    let scene = Importer::new().read(wide.as_bytes(), "points.csv").unwrap();
    assert!(scene.warnings.iter().any(|warning| {
        warning
            .to_string()
            .contains("1 columns of the table are not positions: note")
    }));
}

/// Page sizes and value counts may be wrong. Every third byte of a small file is changed.
#[cfg(feature = "parquet")]
#[test]
fn a_parquet_file_with_changed_bytes_is_an_error_or_a_scene() {
    let scene = mocap::import("../../fixtures/dialects/plain.bvh").unwrap();
    let bytes = Arrays::of(&scene, &ArrayOptions::new())
        .unwrap()
        .to_parquet("plain")
        .unwrap();
    let (mut read, mut refused) = (0, 0);
    for at in (0..bytes.len()).step_by(3) {
        for value in [0, 0x7f, 0xff, bytes[at] ^ 1, bytes[at] ^ 0x80] {
            let mut changed = bytes.clone();
            changed[at] = value;
            match Importer::new()
                .format(mocap::Format::Parquet)
                .read(&changed, "changed.parquet")
            {
                Ok(_) => read += 1,
                Err(_) => refused += 1,
            }
        }
    }
    assert!(read > 100 && refused > 100, "{read} read, {refused} refused");
}

/// Every written layout is read back. Joints are within 0.1 mm, and rotations within 0.01 degrees, of a VRM animation,
/// whose code does not know SMPL.
#[test]
fn layouts_that_are_written_come_back() {
    let mut scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    mocap::Conversion::new().apply(&mut scene).unwrap();
    let truth = vrm_humanoid(&scene, None).unwrap();
    let body = BodyArrays::new(&scene).unwrap();
    for layout in BodyLayout::ALL {
        if layout == BodyLayout::HumanMl3d {
            continue; // it has no rotations
        }
        let back = Importer::new().read(&body.write(layout).unwrap(), "a.npz").unwrap();
        assert_eq!(back.animations[0].frame_count(), 75);
        assert!((back.animations[0].ticks_per_second - scene.animations[0].ticks_per_second).abs() < 1e-9);
        let (mut off, mut turned) = (0_f32, 0_f32);
        for frame in 0..75 {
            let poses = [&truth, &back].map(|scene| Pose::at_tick(scene, 0, f64::from(frame)).unwrap());
            for (index, node) in back.nodes.iter().enumerate() {
                let Some(bone) = node.humanoid_bone else { continue };
                let Some(own) = truth.nodes.iter().position(|own| own.humanoid_bone == Some(bone)) else {
                    continue;
                };
                off = off.max(
                    poses[0]
                        .position(NodeId::new(own))
                        .distance(poses[1].position(NodeId::new(index))),
                );
                let [a, b] = [poses[0].node_to_world[own], poses[1].node_to_world[index]];
                // The cosine of a small angle is too coarse, so the chord between the axes is used.
                turned = turned.max(
                    (a.x_axis - b.x_axis)
                        .length()
                        .max((a.y_axis - b.y_axis).length())
                        .to_degrees(),
                );
            }
        }
        eprintln!("{}: {off} m, {turned} degrees", layout.as_str());
        assert!(
            off < 1e-4 && turned < 0.01,
            "{}: {off} m, {turned} degrees",
            layout.as_str()
        );
    }
}

/// The joints of HumanML3D's numbers equal the source joints, up to a motion of the whole body.
#[test]
fn humanml3d_comes_back() {
    let scene = import("points_smpl22.npy");
    let body = BodyArrays::new(&scene).unwrap();
    let (rows, kimodo) = (
        body.write(BodyLayout::HumanMl3d).unwrap(),
        body.write(BodyLayout::Kimodo).unwrap(),
    );
    let [back, first] = [
        Importer::new().read(&rows, "a.npy").unwrap(),
        Importer::new().read(&kimodo, "a.npz").unwrap(),
    ];
    assert_eq!(back.animations[0].frame_count(), 59);
    let distances = |scene: &Scene, frame: usize| -> Vec<f32> {
        let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
        let names = smpl_names(22);
        let at = |name: &String| {
            pose.position(NodeId::new(
                scene.nodes.iter().position(|node| node.name == *name).unwrap(),
            ))
        };
        let places: Vec<Vec3> = names.iter().map(at).collect();
        places
            .iter()
            .flat_map(|a| places.iter().map(|b| a.distance(*b)).collect::<Vec<_>>())
            .collect()
    };
    for frame in 0..59 {
        let pairs = std::iter::zip(distances(&back, frame), distances(&first, frame));
        let off = pairs.fold(0_f32, |most, (a, b)| most.max((a - b).abs()));
        assert!(off < 1e-3, "frame {frame}: {off} m");
    }
}

#[test]
fn positions_alone_are_points() {
    let scene = import("points_fortran.npy");
    assert_eq!((scene.nodes.len(), scene.animations[0].frame_count()), (6, 4));
    // The value of `numpy.load(...)[3, 4]`.
    let last = scene.animations[0].channels[4].position_keys.values[3];
    assert!(last.distance(Vec3::from(LAST_POINT)) < 1e-6, "{last}");
}

/// The values that NumPy prints of the last point of `points_fortran.npy`.
const LAST_POINT: [f32; 3] = [0.691_847_86, 2.555_667, 0.434_677_8];

fn error(bytes: &[u8], name: &str) -> mocap::Error {
    Importer::new().read(bytes, name).unwrap_err()
}

#[test]
fn a_pickle_that_would_run_code_is_refused_by_name() {
    let error = mocap::import(path("hostile.pkl")).unwrap_err();
    assert_eq!(error.code(), Code::UnexpectedToken);
    assert!(
        error.to_string().contains("the pickle calls \"posix.system\""),
        "{error}"
    );
    for call in [
        "builtins\neval",
        "os\nsystem",
        "numpy\nload",
        "torch\nload",
        "collections\nCounter",
    ] {
        let bytes = format!("\u{0}c{call}\n.").into_bytes();
        let bytes = [&[0x80, 2][..], &bytes[1..]].concat();
        let name = call.replace('\n', ".");
        assert!(self::error(&bytes, "a.pkl").to_string().contains(&name), "{name}");
    }
}

#[test]
fn what_is_wrong_is_named_with_its_array_and_its_shape() {
    let npy = |shape: &str, bytes: usize| {
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
        let length = u16::try_from(header.len()).unwrap().to_le_bytes();
        [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &vec![0; bytes]].concat()
    };
    let cases = [
        (npy("(4, 70)", 4 * 70 * 8), Code::MissingKeyword, "(4, 70)"),
        (
            npy("(4, 69)", 100),
            Code::UnexpectedEnd,
            "2208 bytes for the shape (4, 69)",
        ),
        (npy("(99999999999, 69)", 100), Code::UnexpectedEnd, "(99999999999, 69)"),
        (
            npy("(18446744073709551615, 18446744073709551615)", 8),
            Code::UnexpectedEnd,
            "fewer bytes",
        ),
        (npy("()", 8), Code::MissingKeyword, "known"),
        (npy("nonsense", 8), Code::UnexpectedToken, "'shape'"),
        (b"\x93NUMPY".to_vec(), Code::UnexpectedToken, "6 bytes"),
        (Vec::new(), Code::EmptyFile, "empty"),
    ];
    for (bytes, code, words) in cases {
        let error = error(&bytes, "a.npy");
        assert_eq!(error.code(), code, "{error}");
        assert!(error.to_string().contains(words), "{error} has no {words}");
    }
    // A motion may have one frame or none.
    for (frames, keys) in [(0, 0), (1, 1)] {
        let scene = Importer::new()
            .read(&npy(&format!("({frames}, 5, 3)"), frames * 120), "a.npy")
            .unwrap();
        let found = scene
            .animations
            .first()
            .map_or(0, |motion| motion.channels[0].position_keys.len());
        assert_eq!(found, keys);
    }
}

/// Every prefix of a file gives an error or a scene, but never more frames.
#[test]
fn cut_files_are_refused() {
    for name in [
        "smplx_protocol_4.pkl",
        "amass_smpl.npz",
        "amass_smplx_deflated.npz",
        "gvhmr.pt",
        "phuma_69.npy",
    ] {
        let bytes = fs::read(path(name)).unwrap();
        for length in (0..bytes.len()).step_by(37) {
            assert!(
                Importer::new().read(&bytes[..length], name).is_err(),
                "{name}: {length} bytes"
            );
        }
    }
}

/// A table is several times as large as the arrays. So Parquet gets the table in parts, which a reader does not notice.
#[cfg(feature = "parquet")]
#[test]
fn a_long_table_is_made_in_parts() {
    let scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let options = ArrayOptions::new()
        .velocities(true)
        .contacts(Some(mocap::arrays::Contacts::default()));
    let mut motion = Arrays::of(&scene, &options).unwrap();
    assert_eq!(motion.tables("short").count(), 1);
    let times = (3 << 20) / motion.rows() / 2;
    motion.frames *= times;
    motion.positions = motion.positions.repeat(times);
    motion.rotations = motion.rotations.repeat(times);
    motion.velocities = motion.velocities.map(|velocities| velocities.repeat(times));
    motion.contacts = motion.contacts.map(|contacts| contacts.repeat(times));
    let parts: Vec<_> = motion.tables("long").collect();
    assert_eq!(parts.len(), 2);
    assert!(parts.iter().all(|part| part.num_rows() <= 1 << 20));
    let whole = motion.to_table("long");
    let (first, second) = (parts[0].num_rows(), parts[1].num_rows());
    assert_eq!(first + second, whole.num_rows());
    assert!(parts[0] == whole.slice(0, first) && parts[1] == whole.slice(first, second));
}

#[cfg(feature = "parquet")]
#[test]
fn a_clip_that_is_too_long_for_a_row_is_refused() {
    let scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let mut motion = Arrays::of(&scene, &ArrayOptions::default()).unwrap();
    assert!(mocap::arrays::table::check_row(&motion).is_ok());
    // Zeros that nobody reads take no memory.
    motion.positions = vec![0.0; (1 << 27) - motion.rotations.len()];
    assert!(mocap::arrays::table::check_row(&motion).is_ok());
    motion.positions = vec![0.0; motion.positions.len() + 1];
    let error = mocap::arrays::table::check_row(&motion).unwrap_err();
    assert_eq!(error.code(), Code::LimitExceeded);
    assert_eq!(error.diagnostic().found.as_deref(), Some("134217729 numbers"));
}
