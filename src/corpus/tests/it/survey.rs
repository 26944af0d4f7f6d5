//! The guesses about real files, compared with the statements of their makers.

use mocap::Scene;
use mocap::figure::{Confidence, Figure, Survey, Unit};
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, Topic, UpAxis};

fn survey_of(scene: &Scene) -> Survey {
    Figure::new(scene).survey
}

fn import(file: &str) -> Scene {
    mocap::import(format!("../../fixtures/real/{file}")).unwrap()
}

#[test]
fn units_of_real_files() {
    // CMU's conversions have their own unit. The other files state or imply their units.
    let files = [
        ("cmu_01_01.bvh", Unit::Cmu),
        ("cmu_12_01_walk.bvh", Unit::Cmu),
        ("perception_neuron_moving_positions.bvh", Unit::Centimetre),
        ("mocopi_jump_six_channels.bvh", Unit::Centimetre),
        ("kinect_openni.bvh", Unit::Centimetre),
        // MakeHuman states that its unit is a decimetre.
        ("makehuman_fly_one_frame.bvh", Unit::Decimetre),
        ("makehuman_zombie_walk.bvh", Unit::Decimetre),
    ];
    for (file, unit) in files {
        let guess = survey_of(&import(file)).unit;
        assert_eq!(
            (guess.value, guess.confidence),
            (unit, Confidence::Sure),
            "{file}: {}",
            guess.reason
        );
    }
}

/// Biovision captured in inches. Only the lengths of the bones show this unit.
#[test]
fn inches_are_likely_and_no_more() {
    let guess = survey_of(&import("biovision_example1.bvh")).unit;
    assert_eq!((guess.value, guess.confidence), (Unit::Inch, Confidence::Likely));
}

#[test]
fn a_hand_and_an_arm_leave_the_unit_open() {
    for file in [
        "leap_hand_end_site_lowercase.bvh",
        "lecture_Test.bvh",
        "zero_offsets.bvh",
    ] {
        let found = survey_of(&import(file));
        assert_eq!(found.unit.confidence, Confidence::Unsure, "{file}");
        assert_eq!(
            (found.up.value, found.up.confidence),
            (UpAxis::Y, Confidence::Unsure),
            "{file}"
        );
    }
}

/// A person of CMU's database who squats all the time has the size of a person who stands, in decimetres. The rest pose
/// does not squat.
#[test]
fn a_squat_in_the_unit_of_cmu_is_not_taken_for_decimetres() {
    let mut scene = import("cmu_12_01_walk.bvh");
    for channel in &mut scene.animations[0].channels {
        let bend = match channel.node_name.as_str() {
            "LeftUpLeg" | "RightUpLeg" => -2.2,
            "LeftLeg" | "RightLeg" => 2.4,
            "LowerBack" => 0.7,
            _ => 0.0,
        };
        for rotation in &mut channel.rotation_keys.values {
            *rotation *= Quat::from_rotation_x(bend);
        }
    }
    let unit = survey_of(&scene).unit;
    assert_eq!(unit.value, Unit::Cmu);
}

#[test]
fn what_a_scene_states_is_not_guessed() {
    for file in ["optotrak.c3d", "run.fbx"] {
        let found = survey_of(&import(file));
        assert_eq!(
            (found.up.value, found.up_is_stated, found.unit_is_stated),
            (UpAxis::Y, true, true),
            "{file}"
        );
        assert_eq!(found.assumptions(), [], "{file}");
    }
    // The markers of a lying person: the largest component of the direction from the feet to the head is along z.
    let mut lying = import("z_up_dab.bvh");
    assert_eq!(survey_of(&lying).up.value, UpAxis::Z);
    lying.metadata.up = Some(UpAxis::Y);
    assert_eq!(survey_of(&lying).up.value, UpAxis::Y);
}

#[test]
fn the_cmu_unit_is_an_inch_divided_by_its_length_factor() {
    assert!((Unit::Cmu.metres() - 0.056_444).abs() < 1e-6);
}

#[test]
fn up_is_from_the_feet_to_the_head() {
    for (file, up) in [
        ("z_up_dab.bvh", UpAxis::Z),
        ("makehuman_zombie_walk.bvh", UpAxis::Z),
        ("cmu_01_01.bvh", UpAxis::Y),
    ] {
        let guess = survey_of(&import(file)).up;
        assert_eq!(
            (guess.value, guess.confidence),
            (up, Confidence::Sure),
            "{file}: {}",
            guess.reason
        );
    }
}

/// A chain of two nodes that does not move, at `1 / frame_time` frames per second.
fn still(frame_time: f64) -> Scene {
    let animation = Animation {
        ticks_per_second: frame_time.recip(),
        duration: 1.0,
        ..Animation::default()
    };
    Scene {
        nodes: vec![Node::default()],
        animations: vec![animation],
        ..Scene::default()
    }
}

#[test]
fn rounded_frame_times_are_known_for_what_they_mean() {
    let rounded = [
        (0.0083333, 120.0),
        (0.008333, 120.0),
        (0.033333, 30.0),
        (0.0333, 30.0),
        (0.033, 30.0),
        (0.016667, 60.0),
        (0.0166667, 60.0),
        (0.041667, 24.0),
        (0.033367, 30_000.0 / 1001.0),
    ];
    for (frame_time, rate) in rounded {
        assert_eq!(
            survey_of(&still(frame_time)).frame_rate.map(|guess| guess.value),
            Some(rate),
            "{frame_time}"
        );
    }
    for exact in [0.01, 0.008, 0.04, 0.005, 1.0 / 120.0, 0.018752, 0.1] {
        assert_eq!(survey_of(&still(exact)).frame_rate, None, "{exact}");
    }
}

#[test]
fn a_rest_pose_in_front_is_a_cut() {
    let cmu = import("cmu_12_01_walk.bvh");
    assert!(survey_of(&cmu).first_frame_is_rest_pose);
    assert_eq!(cmu.cuts(0), [0]);

    for file in [
        "perception_neuron_moving_positions.bvh",
        "cmu_mixed_rotation_orders.bvh",
        "lecture_Test.bvh",
    ] {
        let scene = import(file);
        assert!(!survey_of(&scene).first_frame_is_rest_pose, "{file}");
        assert!(scene.cuts(0).is_empty(), "{file}");
    }
}

/// A limb of length 1 that rotates by `angles`, frame by frame.
fn limb(angles: &[f32]) -> Scene {
    let tip = Node {
        parent: Some(NodeId(0)),
        transform: Mat4::from_translation(Vec3::X),
        ..Node::default()
    };
    let rotation_keys = Keys::every_tick(angles.iter().map(|angle| Quat::from_rotation_z(*angle)).collect());
    let animation = Animation {
        ticks_per_second: 30.0,
        duration: angles.len() as f64 - 1.0,
        channels: vec![Channel {
            rotation_keys,
            ..Channel::default()
        }],
        ..Animation::default()
    };
    Scene {
        nodes: vec![Node::default(), tip],
        animations: vec![animation],
        ..Scene::default()
    }
}

#[test]
fn a_punch_is_no_cut_and_two_takes_in_a_row_are() {
    // A strike that accelerates and stops, with up to 0.6 rad per frame.
    let punch: Vec<f32> = [0.0, 0.01, 0.05, 0.2, 0.6, 0.5, 0.15, 0.05, 0.01]
        .iter()
        .scan(0.0, |sum, step| {
            *sum += step;
            Some(*sum)
        })
        .collect();
    assert!(limb(&punch).cuts(0).is_empty());

    let two_takes = [0.0, 0.01, 0.02, 0.03, 0.04, 1.5, 1.51, 1.52, 1.53, 1.54];
    assert_eq!(limb(&two_takes).cuts(0), [4]);
}

#[test]
fn decisions_come_out_in_words() {
    let topics: Vec<_> = survey_of(&import("cmu_01_01.bvh"))
        .assumptions()
        .into_iter()
        .map(|a| (a.topic, a.choice))
        .collect();
    let expected = [
        (Topic::Unit, "cmu"),
        (Topic::Up, "y"),
        (Topic::FrameRate, "120"),
        (Topic::FirstFrame, "rest-pose"),
    ];
    assert_eq!(topics, expected.map(|(topic, choice)| (topic, choice.to_owned())));
}

/// A figure with the head above the feet in the rest pose. Its root lies down towards `z` and moves by `step` in each
/// frame.
fn lying(step: Vec3) -> Scene {
    let child = |name: &str, offset| Node {
        name: name.into(),
        parent: Some(NodeId(0)),
        transform: Mat4::from_translation(offset),
        ..Node::default()
    };
    let mut scene = limb(&[0.0; 20]);
    scene.nodes = vec![
        Node::default(),
        child("head", 0.8 * Vec3::Y),
        child("foot", -0.9 * Vec3::Y),
    ];
    let root = &mut scene.animations[0].channels[0];
    root.position_keys = Keys::every_tick((0..20).map(|frame| frame as f32 * step).collect());
    root.rotation_keys = Keys::constant(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2));
    scene
}

#[test]
fn a_swimmer_is_not_taken_for_a_figure_that_stands() {
    let swimmer = survey_of(&lying(0.2 * Vec3::Z)).up;
    assert_eq!(
        (swimmer.value, swimmer.confidence),
        (UpAxis::Y, Confidence::Likely),
        "{}",
        swimmer.reason
    );
    // The head stays above a floor. So +Z is up, and the figure does not stand as in the rest pose.
    let walker = survey_of(&lying(0.2 * Vec3::X)).up;
    assert_eq!(
        (walker.value, walker.confidence),
        (UpAxis::Z, Confidence::Likely),
        "{}",
        walker.reason
    );
}

#[test]
fn a_stated_unit_is_not_guessed() {
    let mut scene = import("cmu_short.bvh");
    scene.metadata.metres_per_unit = Some(0.056_444);
    let found = survey_of(&scene);
    assert!(found.unit_is_stated);
    assert!(
        found
            .assumptions()
            .iter()
            .all(|assumption| assumption.topic != Topic::Unit)
    );
}

/// A body along X at rest does not decide between Y and Z. Its small extents along Y and Z are noise.
#[test]
fn a_body_along_x_leaves_the_up_axis_open() {
    for noise in [Vec3::ZERO, 1e-4 * Vec3::Z, -1e-4 * Vec3::Z, 0.05 * Vec3::Z] {
        let mut scene = lying(Vec3::ZERO);
        scene.nodes[1].transform = Mat4::from_translation(0.8 * Vec3::X + noise);
        scene.nodes[2].transform = Mat4::from_translation(-0.9 * Vec3::X);
        for root in [Quat::IDENTITY, Quat::from_rotation_x(0.3)] {
            scene.animations[0].channels[0].rotation_keys = Keys::constant(root);
            let up = survey_of(&scene).up;
            assert_eq!(
                (up.value, up.confidence),
                (UpAxis::Y, Confidence::Unsure),
                "{}",
                up.reason
            );
        }
    }
}
