//! The world position of every node of real files in every frame, compared with the separate kinematics.

use std::fs;

use crate::kinematics::{Capture, Placement, Root, Vector, distance};
use mocap::process::SkeletonMesh;
use mocap::scene::{NodeId, RootOffset, Scene};
use mocap::{Binding, Code, Importer, Pose};

/// The largest allowed distance of a node from its expected position, as a fraction of the skeleton's height.
const TOLERANCE: f64 = 1e-5;

/// The expected properties of a real file.
struct Real {
    name: &'static str,
    /// Whether the root's position is relative to its OFFSET or to the origin.
    root: Root,
    /// The number of rows of the motion.
    frames: usize,
    /// The expected warnings.
    warnings: &'static [Code],
}

const fn plain(name: &'static str, frames: usize) -> Real {
    Real {
        name,
        root: Root::Replace,
        frames,
        warnings: &[],
    }
}

/// The valid real files. The counts of frames were read from the files with a text editor.
const REAL: &[Real] = &[
    plain("lecture_Test", 10),
    Real {
        root: Root::Add,
        ..plain("additive_root_pose", 1)
    },
    Real {
        root: Root::Add,
        ..plain("additive_root_walk", 47)
    },
    plain("biovision_example1", 2),
    plain("blender_two_joints", 20),
    plain("channels_0_tracked_points", 100),
    plain("cmu_01_01", 2752),
    plain("cmu_12_01_walk", 524),
    plain("cmu_mixed_rotation_orders", 125),
    plain("cmu_salsa_poser_names", 1198),
    plain("cmu_short", 75),
    plain("hip_knee_ankle_names", 2998),
    plain("kinect_openni", 1206),
    Real {
        warnings: &[Code::NoMotion],
        ..plain("latin1_name_no_motion", 0)
    },
    plain("leap_hand_end_site_lowercase", 333),
    plain("makehuman_fly_one_frame", 1),
    plain("makehuman_zombie_walk", 31),
    plain("mocopi_jump_six_channels", 802),
    plain("motionbuilder_vicon_walk", 1064),
    Real {
        root: Root::Add,
        warnings: &[Code::NonFiniteValue],
        ..plain("nan_tokens", 120)
    },
    plain("perception_neuron_moving_positions", 422),
    Real {
        warnings: &[Code::RepeatedOffset, Code::RepeatedChannels],
        ..plain("repeated_offset_lines", 3)
    },
    plain("rokoko_dance", 1007),
    plain("rotation_before_position", 4),
    plain("slimevr_headset_root", 237),
    plain("z_up_dab", 339),
    plain("zero_offsets", 570),
];

fn path(name: &str) -> String {
    format!("../../fixtures/real/{name}.bvh")
}

fn import(name: &str) -> Scene {
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    importer.import(path(name)).unwrap_or_else(|error| panic!("{error}"))
}

/// The largest distance of any node from its position in `capture`, over all frames, and the height of the skeleton.
fn largest_error(scene: &Scene, capture: &Capture, root: Root) -> f64 {
    let mut pose = Pose::rest(scene);
    let mut largest = compare(&pose, &capture.rest());
    if let Some(animation) = scene.animations.first() {
        let binding = Binding::new(scene, animation);
        for frame in 0..capture.rows.len() {
            pose.sample(&binding, animation, frame as f64);
            largest = largest.max(compare(&pose, &capture.placements(frame, root)));
        }
    }
    largest
}

fn compare(pose: &Pose, placements: &[Placement]) -> f64 {
    let far = |(index, placement): (usize, &Placement)| {
        let position = pose.position(NodeId::new(index)).to_array().map(f64::from);
        // NaN would pass every comparison, so it counts as infinitely far.
        let far = distance(position, placement.position);
        if far.is_nan() { f64::INFINITY } else { far }
    };
    placements.iter().enumerate().map(far).fold(0.0, f64::max)
}

#[test]
fn every_node_stands_where_the_kinematics_puts_it_at_every_frame() {
    for real in REAL {
        let scene = import(real.name);
        let capture = Capture::parse(&fs::read(path(real.name)).unwrap());

        let graph: Vec<_> = scene
            .nodes
            .iter()
            .map(|node| (&*node.name, node.parent.map(NodeId::index)))
            .collect();
        let expected: Vec<_> = capture.nodes.iter().map(|node| (&*node.name, node.parent)).collect();
        assert_eq!(graph, expected, "{}", real.name);

        assert_eq!(capture.rows.len(), real.frames, "{}", real.name);
        assert_eq!(scene.animations.len(), usize::from(real.frames > 0), "{}", real.name);
        for animation in &scene.animations {
            assert_eq!(animation.duration, real.frames as f64 - 1.0, "{}", real.name);
        }

        let height = capture.height(real.root);
        let error = largest_error(&scene, &capture, real.root);
        assert!(error <= TOLERANCE * height, "{}: {error} of {height}", real.name);
    }
}

#[test]
fn real_files_warn_of_what_deviates_and_of_nothing_else() {
    for real in REAL {
        let codes: Vec<Code> = import(real.name).warnings.iter().map(|warning| warning.code).collect();
        assert_eq!(codes, real.warnings, "{}", real.name);
    }
}

#[test]
fn the_root_offset_is_added_exactly_where_the_file_means_that() {
    for real in REAL {
        let policy = import(real.name).metadata.root_offset.map(|used| used.policy);
        if real.root == Root::Add {
            assert_eq!(policy, Some(RootOffset::Add), "{}", real.name);
        } else {
            assert_ne!(policy, Some(RootOffset::Add), "{}", real.name);
        }
    }
}

#[test]
fn the_root_offset_policy_can_be_forced() {
    let bytes = fs::read(path("mocopi_jump_six_channels")).unwrap();
    let capture = Capture::parse(&bytes);
    for (policy, root) in [(RootOffset::Replace, Root::Replace), (RootOffset::Add, Root::Add)] {
        let importer = Importer::new().skeleton_mesh(SkeletonMesh::None).root_offset(policy);
        let scene = importer.read(&bytes, "forced.bvh").unwrap();
        let (error, height) = (largest_error(&scene, &capture, root), capture.height(root));
        assert!(error <= TOLERANCE * height, "{policy:?}: {error} of {height}");
    }
}

/// The numbers that the lecture states for its own example.
#[test]
fn the_lecture_example_has_the_numbers_of_the_lecture() {
    let scene = mocap::import(path("lecture_Test")).unwrap();
    assert_eq!(
        (scene.animations.len(), scene.materials.len(), scene.meshes.len()),
        (1, 1, 4)
    );

    let nodes: Vec<(&str, Vector, &[usize])> = scene
        .nodes
        .iter()
        .map(|node| {
            let translation = node.transform.w_axis.truncate().to_array().map(f64::from);
            (&*node.name, translation, &*node.meshes)
        })
        .collect();
    assert_eq!(
        nodes,
        [
            ("Shoulder", [0.0, 0.0, 0.0], &[0_usize] as &[usize]),
            ("Elbow", [2.0, 0.0, 0.0], &[1]),
            ("Wrist", [1.5, 0.0, 0.0], &[2]),
            ("EndSite_Wrist", [0.5, 0.0, 0.0], &[3]),
        ]
    );

    let animation = &scene.animations[0];
    assert_eq!(animation.duration, 9.0);
    assert!(
        (animation.ticks_per_second - 10.0).abs() < 1e-12,
        "{}",
        animation.ticks_per_second
    );
    let keys = |keys: &dyn Fn(&mocap::scene::Channel) -> usize| animation.channels.iter().map(keys).collect::<Vec<_>>();
    assert_eq!(keys(&|channel| channel.position_keys.len()), [10, 1, 1]);
    assert_eq!(keys(&|channel| channel.rotation_keys.len()), [10, 10, 10]);
    assert_eq!(
        animation.channels[0].position_keys.values[9].to_array(),
        [1.0, 0.18, 0.0]
    );

    let wrist = animation.channels[2].rotation_keys.values[9].to_array();
    let (sin, cos) = 40_f64.to_radians().sin_cos();
    for (component, expected) in wrist.into_iter().zip([0.0, 0.0, sin, cos]) {
        assert!((f64::from(component) - expected).abs() < 1e-6, "{wrist:?}");
    }

    // T(P) R(50) T(2,0) R(100) T(1.5,0) R(80) T(0.5,0) in a plane, so the angles of the links are 50, 150 and 230
    // degrees.
    let along = |length: f64, degrees: f64| (length * degrees.to_radians().cos(), length * degrees.to_radians().sin());
    let links = [(1.0, 0.18), along(2.0, 50.0), along(1.5, 150.0), along(0.5, 230.0)];
    let tip = links
        .iter()
        .fold([0.0; 3], |[x, y, z], link| [x + link.0, y + link.1, z]);
    let pose = Pose::at_tick(&scene, 0, 9.0).unwrap();
    let position = pose.position(NodeId(3)).to_array().map(f64::from);
    assert!(distance(position, tip) < TOLERANCE * 4.0, "{position:?}, {tip:?}");
}

#[test]
fn rows_of_the_wrong_length_are_refused_with_both_numbers() {
    // The file has 188 rows: 125 with 110 values and 63 with 112, for 108 channels. The first row has 112 values.
    let error = mocap::import(path("brekel_wrong_row_length")).unwrap_err();
    assert_eq!(error.code(), Code::RowLength);
    let message = error.to_string();
    assert!(message.contains("108") && message.contains("112"), "{message}");
    assert_eq!(error.location().map(|location| location.line), Some(210), "{message}");
}

#[test]
fn brackets_around_numbers_are_refused_at_the_first_one() {
    let error = mocap::import(path("brackets_in_numbers")).unwrap_err();
    assert_eq!(error.code(), Code::InvalidNumber);
    assert_eq!(
        error.location().map(|location| (location.line, location.column)),
        Some((91, 1)),
        "{error}"
    );
}
