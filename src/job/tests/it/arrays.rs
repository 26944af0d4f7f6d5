//! Tests of arrays against separate kinematics, closed forms, and facts in the files.

mod converted;
mod joblib;
mod max;
mod robot;

use std::fs;

use crate::kinematics::{Capture, Column, Root, distance, multiply, turn};
use mocap::arrays::{ArrayOptions, Arrays, Contacts, Moment, Rotation, RotationSpace, Space};
use mocap::glam::{Quat, Vec3};
use mocap::scene::{Keys, NodeKind, RotationOrder, UpAxis};
use mocap::{Binding, Code, Importer, Pose, Scene, SkeletonMesh, Trs};

/// The tolerance as a fraction of the skeleton's height.
const TOLERANCE: f64 = 1e-5;

/// Five dialects: a plain file, a root that adds to its OFFSET, a joint with six moving channels, joints with different
/// rotation orders, and NaN values.
const DIALECTS: [(&str, Root); 5] = [
    ("cmu_12_01_walk", Root::Replace),
    ("additive_root_walk", Root::Add),
    ("perception_neuron_moving_positions", Root::Replace),
    ("cmu_mixed_rotation_orders", Root::Replace),
    ("nan_tokens", Root::Add),
];

fn bytes(name: &str) -> Vec<u8> {
    fs::read(format!("../../fixtures/real/{name}.bvh")).unwrap()
}

fn import(name: &str) -> Scene {
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    importer.read(&bytes(name), name).unwrap()
}

fn motion(name: &str, options: &ArrayOptions) -> Arrays {
    Arrays::of(&import(name), options).unwrap()
}

/// The three values of `row`.
fn point(values: &[f32], row: usize) -> [f64; 3] {
    std::array::from_fn(|axis| f64::from(values[3 * row + axis]))
}

/// The largest distance of `positions`, frames x joints x 3, from the joint positions by the text of the file.
fn largest_error(positions: &[f32], capture: &Capture, root: Root) -> f64 {
    let joints = capture.nodes.len();
    assert_eq!(positions.len(), 3 * joints * capture.rows.len());
    let frames = (0..capture.rows.len()).map(|frame| (frame, capture.placements(frame, root)));
    let errors = frames.flat_map(|(frame, placements)| {
        let rows = placements.into_iter().enumerate();
        rows.map(move |(joint, placement)| distance(point(positions, frame * joints + joint), placement.position))
            .collect::<Vec<_>>()
    });
    // NaN would make every comparison false.
    errors.fold(0.0, |largest, error| if error <= largest { largest } else { error })
}

#[test]
fn positions_are_those_of_the_kinematics() {
    for (name, root) in DIALECTS {
        let capture = Capture::parse(&bytes(name));
        let motion = motion(name, &ArrayOptions::default());
        let error = largest_error(&motion.positions, &capture, root) / capture.height(root);
        assert!(error <= TOLERANCE, "{name}: {error:e} of height");
        let names: Vec<&str> = motion.joints().iter().map(|joint| joint.name.as_str()).collect();
        let expected: Vec<&str> = capture.nodes.iter().map(|node| node.name.as_str()).collect();
        assert_eq!(names, expected);
        for (joint, node) in motion.joints().iter().zip(&capture.nodes) {
            assert_eq!(joint.parent, node.parent);
            assert_eq!(joint.offset.to_array(), node.offset.map(|value| value as f32));
        }
    }
}

#[test]
fn the_csv_holds_the_same_positions() {
    for (name, root) in DIALECTS {
        let capture = Capture::parse(&bytes(name));
        let text = motion(name, &ArrayOptions::default()).to_csv();
        let mut positions: Vec<f32> = Vec::new();
        for (row, line) in text.lines().skip(2).enumerate() {
            let fields: Vec<&str> = line.split(',').collect();
            let (frame, joint) = (row / capture.nodes.len(), row % capture.nodes.len());
            assert_eq!(
                (fields[0], fields[2]),
                (frame.to_string().as_str(), capture.nodes[joint].name.as_str())
            );
            positions.extend(fields[3..6].iter().map(|field| field.parse::<f32>().unwrap()));
        }
        let error = largest_error(&positions, &capture, root) / capture.height(root);
        assert!(error <= TOLERANCE, "{name}: {error:e} of height");
    }
}

/// The values of an array of 32-bit floats in an uncompressed archive, found by file name.
fn floats_in(archive: &[u8], name: &str) -> Vec<f32> {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(archive)).unwrap();
    let mut file = archive.by_name(&format!("{name}.npy")).unwrap();
    let mut npy = Vec::new();
    std::io::Read::read_to_end(&mut file, &mut npy).unwrap();
    let header = usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    assert_eq!((10 + header) % 64, 0, "the values are not aligned");
    let values = npy[10 + header..].chunks_exact(4);
    values
        .map(|value| f32::from_le_bytes(value.try_into().unwrap()))
        .collect()
}

#[test]
fn the_npz_holds_the_same_positions() {
    for (name, root) in DIALECTS {
        let capture = Capture::parse(&bytes(name));
        let archive = motion(name, &ArrayOptions::default()).to_npz();
        let error = largest_error(&floats_in(&archive, "positions"), &capture, root) / capture.height(root);
        assert!(error <= TOLERANCE, "{name}: {error:e} of height");
    }
}

#[test]
fn every_form_of_rotation_is_that_of_the_kinematics() {
    let capture = Capture::parse(&bytes("cmu_mixed_rotation_orders"));
    let joints = capture.nodes.len();
    let in_world = |rotation| {
        ArrayOptions::new()
            .rotation(rotation)
            .rotation_space(RotationSpace::World)
    };
    let read = |rotation| motion("cmu_mixed_rotation_orders", &in_world(rotation));
    let (matrices, six, quaternions) = (read(Rotation::Matrix), read(Rotation::SixD), read(Rotation::Quaternion));
    for frame in 0..capture.rows.len() {
        for (joint, placement) in capture.placements(frame, Root::Replace).iter().enumerate() {
            let row = frame * joints + joint;
            let expected = placement.rotation.as_flattened();
            let found = &matrices.rotations[9 * row..][..9];
            let is_close = |(a, b): (&f32, &f64)| (f64::from(*a) - b).abs() < 1e-5;
            assert!(
                found.iter().zip(expected).all(is_close),
                "{frame} {joint}: {found:?}, {expected:?}"
            );

            let columns = [0, 3, 6, 1, 4, 7].map(|place| expected[place]);
            assert!(six.rotations[6 * row..][..6].iter().zip(&columns).all(is_close));

            // The matrix of a quaternion, element by element.
            let [x, y, z, w]: [f64; 4] = std::array::from_fn(|i| f64::from(quaternions.rotations[4 * row + i]));
            let first_column = [
                1.0 - 2.0 * (y * y + z * z),
                2.0 * (x * y + w * z),
                2.0 * (x * z - w * y),
            ];
            let expected = [0, 3, 6].map(|place| expected[place]);
            assert!(distance(first_column, expected) < 1e-5);
        }
    }
}

#[test]
fn euler_angles_are_those_of_the_file() {
    let name = "cmu_mixed_rotation_orders";
    let capture = Capture::parse(&bytes(name));
    let options = ArrayOptions::new().rotation(Rotation::Euler);
    let motion = motion(name, &options);
    let joints = capture.nodes.len();
    assert_eq!(motion.joints()[0].rotation_order, Some(RotationOrder::Zyx));
    for (frame, row) in capture.rows.iter().enumerate() {
        let mut column = 0;
        for (joint, node) in capture.nodes.iter().enumerate() {
            let angles = point(&motion.rotations, frame * joints + joint);
            for driven in &node.columns {
                if let Column::Rotation(axis) = *driven {
                    // The file keeps the middle angle within a quarter turn, so its angles are unique.
                    let turns = (angles[axis] - row[column]) / 360.0;
                    assert!(
                        (turns - turns.round()).abs() * 360.0 < 1e-2,
                        "{frame} {}: {angles:?}",
                        node.name
                    );
                }
                column += 1;
            }
        }
    }
}

#[test]
fn seen_from_the_root_and_from_the_parent_the_chain_is_the_same() {
    let name = "cmu_short";
    let world = motion(name, &ArrayOptions::default());
    let space = |space| motion(name, &ArrayOptions::new().space(space));
    let (root, local) = (space(Space::Root), space(Space::Local));
    let joints = world.joints().len();
    for frame in 0..world.frames {
        let hips = point(&world.positions, frame * joints);
        for joint in 0..joints {
            let row = frame * joints + joint;
            let expected: [f64; 3] = std::array::from_fn(|axis| point(&world.positions, row)[axis] - hips[axis]);
            assert!(distance(point(&root.positions, row), expected) < 1e-4);
            if joint > 0 {
                // CMU's joints below the root have no position channels.
                let offset = local.joints()[joint].offset.to_array().map(f64::from);
                assert!(distance(point(&local.positions, row), offset) < 1e-5);
            }
        }
    }
    assert_eq!(point(&local.positions, 0), point(&world.positions, 0));
}

#[test]
fn what_is_left_out_does_not_break_the_chain() {
    let options = |joints: Option<&str>| {
        ArrayOptions::new()
            .joints(joints.map(str::to_owned))
            .space(Space::Local)
            .rotation(Rotation::Matrix)
    };
    let world = motion("cmu_short", &ArrayOptions::default());
    let some = motion("cmu_short", &options(Some("^(Hips|LeftFoot|LeftToeBase)$")));
    let names: Vec<&str> = some.joints().iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["Hips", "LeftFoot", "LeftToeBase"]);
    let parents: Vec<_> = some.joints().iter().map(|joint| joint.parent).collect();
    assert_eq!(parents, [None, Some(0), Some(1)]);
    let index = |name: &str| world.joints().iter().position(|joint| joint.name == name).unwrap();
    let (foot, toe) = (index("LeftFoot"), index("LeftToeBase"));
    for frame in 0..world.frames {
        // Follows the listed chain down: each position is rotated by the rotations above.
        let mut position = [0.0; 3];
        let mut rotation = turn(0, 0.0);
        for (joint, everywhere) in [(0, 0), (1, foot), (2, toe)] {
            let local = point(&some.positions, 3 * frame + joint);
            let turned: [f64; 3] = std::array::from_fn(|i| (0..3).map(|k| rotation[i][k] * local[k]).sum());
            position = std::array::from_fn(|axis| position[axis] + turned[axis]);
            let expected = point(&world.positions, frame * world.joints().len() + everywhere);
            assert!(
                distance(position, expected) < 1e-3,
                "{frame} {joint}: {position:?}, {expected:?}"
            );
            let own = &some.rotations[9 * (3 * frame + joint)..][..9];
            let own = std::array::from_fn(|i| std::array::from_fn(|k| f64::from(own[3 * i + k])));
            rotation = multiply(rotation, own);
        }
    }
}

#[test]
fn unit_axes_frames_and_length_are_those_asked_for() {
    let scene = import("lecture_Test");
    let options = ArrayOptions::new()
        .metres_per_unit(1.0)
        .out_metres_per_unit(0.01)
        .up(UpAxis::Y)
        .out_up(UpAxis::Z)
        .frames_per_second(20.0)
        .first(Moment::Seconds(0.2))
        .last(Moment::Frame(5))
        .velocities(true);
    let motion = Arrays::of(&scene, &options).unwrap();
    // The file has ten frames per second, the output twenty. Frame k of the output is frame 2 + k / 2 of the file.
    assert_eq!((motion.frames, motion.frame_rate()), (7, 20.0));
    // The shoulder is at (0.1 (n + 1), 0.02 n, 0). The old y becomes z, and a metre becomes 100 units.
    let joints = motion.joints().len();
    for frame in 0..7 {
        let n = 2.0 + f64::from(frame as u8) / 2.0;
        let expected = [10.0 * (n + 1.0), 0.0, 2.0 * n];
        assert!(distance(point(&motion.positions, frame * joints), expected) < 1e-4);
        // (0.1, 0.02) metres per tick, at ten ticks per second.
        let velocity = point(motion.velocities.as_ref().unwrap(), frame * joints);
        assert!(distance(velocity, [100.0, 0.0, 20.0]) < 1e-2, "{velocity:?}");
    }
    assert_eq!(motion.joints()[1].offset.x, 200.0);
    assert_eq!(
        (motion.header.metres_per_unit, motion.header.up),
        (Some(0.01), Some(UpAxis::Z))
    );
}

/// The file's frame time is .0083333, which means 1/120.
#[test]
fn a_quarter_of_a_rounded_rate_is_every_fourth_frame() {
    let scene = import("cmu_12_01_walk");
    let at = |frames_per_second| {
        let options = ArrayOptions::new()
            .frames_per_second(frames_per_second)
            .first(Moment::Frame(1))
            .last(Moment::Frame(521));
        Arrays::of(&scene, &options).unwrap()
    };
    let (all, quarter) = (at(None), at(Some(30.0)));
    assert_eq!((all.frames, quarter.frames, quarter.frame_rate()), (521, 131, 30.0));
    let row = 3 * all.joints().len();
    for (few, every) in quarter.positions.chunks(row).zip(all.positions.chunks(row).step_by(4)) {
        assert_eq!(few, every);
    }
}

#[test]
fn a_foot_is_on_the_ground_while_it_is_low_and_slow() {
    // One joint that rests for five frames, rises by a metre per frame for two frames, and rests at this height.
    let heights = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0];
    let rows: String = heights.iter().map(|height| format!("0 {height} 0\n")).collect();
    let text = format!(
        "HIERARCHY\nROOT Foot\n{{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n}}\n\
         MOTION\nFrames: {}\nFrame Time: 0.1\n{rows}",
        heights.len()
    );
    let scene = Importer::new().read(text.as_bytes(), "foot.bvh").unwrap();
    let options = |height| {
        ArrayOptions::new()
            .contacts(Contacts::new().height(height))
            .metres_per_unit(1.0)
            .up(UpAxis::Y)
    };
    let contacts = |height| Arrays::of(&scene, &options(height)).unwrap().contacts.unwrap();
    // In frame 4, the joint is low, but its speed by central differences is already 5 m/s.
    assert_eq!(
        contacts(0.05),
        [true, true, true, true, false, false, false, false, false]
    );
    assert_eq!(contacts(3.0), [true, true, true, true, false, false, false, true, true]);
}

#[test]
fn a_walk_stands_on_one_foot_or_both_although_a_rest_pose_comes_first() {
    let options = ArrayOptions::new().contacts(Contacts::new().feet("^(Left|Right)ToeBase$".to_owned()));
    let motion = motion("cmu_12_01_walk", &options);
    let contacts = motion.contacts.as_ref().unwrap();
    let index = |name: &str| motion.joints().iter().position(|joint| joint.name == name).unwrap();
    let (left, right) = (index("LeftToeBase"), index("RightToeBase"));
    let count = |test: fn(bool, bool) -> bool| {
        let frames = contacts.chunks(motion.joints().len());
        frames.filter(|frame| test(frame[left], frame[right])).count() as f64 / motion.frames as f64
    };
    // In a walking cycle, a foot stands for about 60 % and swings for 40 %: Perry, Gait Analysis, 1992.
    for stance in [count(|left, _| left), count(|_, right| right)] {
        assert!((0.4..0.75).contains(&stance), "{stance}");
    }
    assert!(count(|left, right| left || right) > 0.85);
}

#[test]
fn without_motion_there_are_joints_and_no_frames() {
    let motion = motion("latin1_name_no_motion", &ArrayOptions::new().velocities(true));
    assert_eq!(
        (motion.frames, motion.frame_rate(), motion.positions.len()),
        (0, 0.0, 0)
    );
    assert!(!motion.joints().is_empty());
    assert!(!motion.to_npz().is_empty());
    assert_eq!(motion.to_csv().lines().count(), 2);
}

#[test]
fn the_header_tells_where_the_numbers_come_from() {
    let motion = motion("nan_tokens", &ArrayOptions::default());
    let header: serde_json::Value = serde_json::from_str(&motion.header.to_json()).unwrap();
    assert_eq!(header["provenance"]["root_offset"]["policy"], "add");
    assert_eq!(header["provenance"]["source"]["name"], "nan_tokens");
    assert_eq!(header["provenance"]["frames"], 120);
    assert_eq!(header["rotation"], "quat");
}

#[test]
fn options_without_a_meaning_are_refused() {
    let scene = import("lecture_Test");
    let wrong = [
        ArrayOptions::new().first(Moment::Frame(10)),
        ArrayOptions::new()
            .first(Moment::Seconds(0.5))
            .last(Moment::Seconds(0.2)),
        ArrayOptions::new().joints("nobody".to_owned()),
        ArrayOptions::new().joints("(".to_owned()),
        ArrayOptions::new().frames_per_second(0.0),
        ArrayOptions::new().metres_per_unit(f64::NAN),
        ArrayOptions::new().contacts(Contacts::default()),
    ];
    for options in wrong {
        let error = Arrays::of(&scene, &options).unwrap_err();
        assert_eq!(error.code(), Code::InvalidValue, "{error}");
    }
    let options = ArrayOptions::new().frames_per_second(1e6);
    assert_eq!(Arrays::of(&scene, &options).unwrap_err().code(), Code::LimitExceeded);
}

/// Compares blocks of frames with single frames. The separate kinematics of these tests lacks these cases: formats with
/// groups and scales, times between frames, and frames that two threads share.
#[test]
fn blocks_of_frames_are_as_good_as_single_poses() {
    let files = [
        "cmu_short.bvh",
        "perception_neuron_moving_positions.bvh",
        "cmu_02_01.amc",
        "run.fbx",
        "optotrak.c3d",
    ];
    let named = files.map(|file| mocap::import(format!("../../fixtures/real/{file}")).unwrap());
    let large = import("cmu_01_01");
    let mut scaled = import("cmu_short");
    for (index, channel) in scaled.animations[0].channels.iter_mut().enumerate() {
        let scale = |key: usize| Vec3::splat(1.0 + 0.01 * (index + key) as f32);
        channel.scaling_keys = match index % 2 {
            0 => Keys::constant(scale(0)),
            _ => Keys::every_tick((0..40).map(scale).collect()),
        };
    }
    for scene in named.iter().chain([&large, &scaled]) {
        for frames_per_second in [None, Some(47.0)] {
            let options = ArrayOptions::new()
                .frames_per_second(frames_per_second)
                .rotation_space(RotationSpace::World);
            let motion = Arrays::of(scene, &options).unwrap();
            let joints: Vec<usize> = (0..scene.nodes.len())
                .filter(|&node| scene.nodes[node].kind != NodeKind::Group)
                .collect();
            assert_eq!(motion.joints().len(), joints.len());
            let animation = &scene.animations[0];
            let binding = Binding::new(scene, animation);
            let mut pose = Pose::rest(scene);
            let cuts = scene.cuts(0);
            // A hidden marker has no position.
            let gaps = scene.points_with_gaps(animation);
            for frame in 0..motion.frames {
                let tick = frame as f64 * animation.ticks_per_second / motion.frame_rate();
                if cuts.contains(&(tick as usize)) {
                    continue;
                }
                pose.sample(&binding, animation, tick);
                let places = joints.iter().map(|&node| pose.node_to_world[node].w_axis.truncate());
                let farthest = places.map(Vec3::length).fold(0.0, f32::max);
                for (joint, &node) in joints.iter().enumerate() {
                    let row = frame * joints.len() + joint;
                    let expected = pose.node_to_world[node];
                    let position = Vec3::from_slice(&motion.positions[3 * row..]);
                    if gaps[node].is_some_and(|keys| !keys.is_seen(tick)) {
                        assert!(position.is_nan(), "{frame} {joint}: {position}");
                    } else {
                        let error = position.distance(expected.w_axis.truncate());
                        assert!(error <= 1e-6 * farthest, "{frame} {joint}: {error}");
                    }
                    let rotation = Quat::from_slice(&motion.rotations[4 * row..]);
                    let alike = rotation.dot(Trs::from_matrix(expected).rotation).abs();
                    assert!(alike > 1.0 - 1e-5, "{frame} {joint}: {alike}");
                }
            }
        }
    }
    assert!(large.animations[0].frame_count() * large.nodes.len() * 7 > 1 << 19);
}
