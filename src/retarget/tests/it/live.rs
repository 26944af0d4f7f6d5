//! VMC, with packets that the tests build byte by byte by the specification of OSC 1.0. `tools/vmc` tests both ends
//! with another author's library.

mod vmc;

use glam::{Quat, Vec3};
use mocap::live::{VmcBridge, VmcCleaner, VmcRecorder};
use mocap::scene::HumanoidBone as Bone;
use mocap::{Code, Scene};

/// An OSC string: zeros follow the text, at least one, up to a multiple of four bytes.
fn text(text: &str) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize((bytes.len() + 4) / 4 * 4, 0);
    bytes
}

fn message(address: &str, name: Option<&str>, numbers: &[f32]) -> Vec<u8> {
    let types = format!(",{}{}", name.map_or("", |_| "s"), "f".repeat(numbers.len()));
    let mut bytes = [text(address), text(&types)].concat();
    bytes.extend(name.map(text).unwrap_or_default());
    bytes.extend(numbers.iter().flat_map(|number| number.to_be_bytes()));
    bytes
}

fn bone(name: &str, numbers: [f32; 7]) -> Vec<u8> {
    message("/VMC/Ext/Bone/Pos", Some(name), &numbers)
}

fn time(seconds: f32) -> Vec<u8> {
    message("/VMC/Ext/T", None, &[seconds])
}

fn recorded(packets: &[Vec<u8>]) -> Scene {
    let mut recorder = VmcRecorder::new();
    packets.iter().for_each(|packet| recorder.hear(packet, 0.0));
    assert_eq!(recorder.counts().malformed, 0);
    recorder.scene().unwrap()
}

#[test]
fn a_pose_of_unity_is_mirrored_and_timed_by_the_clock_of_its_sender() {
    // A quarter turn about +Y: in Unity from +Z to +X, and so in a scene from +Z to -X.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turned = [0.1, 0.9, 0.2, 0.0, half, 0.0, half];
    let packets = [
        time(5.0),
        bone("Hips", [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
        bone("LeftUpperLeg", [-0.1, -0.05, 0.0, 0.0, 0.0, 0.0, 1.0]),
        time(5.05),
        bone("Hips", turned),
        time(5.15),
        bone("Hips", turned),
    ];
    let scene = recorded(&packets);
    let animation = &scene.animations[0];
    assert_eq!((animation.ticks_per_second, animation.duration), (20.0, 3.0));
    assert_eq!(scene.nodes[1].humanoid_bone, Some(Bone::LeftUpperLeg));
    // The left leg of a figure that faces +Z is at +X.
    assert_eq!(scene.nodes[1].transform.w_axis.truncate(), Vec3::new(0.1, -0.05, 0.0));
    let hips = &animation.channels[0];
    assert_eq!(hips.rotation_keys.ticks, Some(vec![0.0, 1.0, 3.0]));
    assert_eq!(hips.position_keys.values[1], Vec3::new(-0.1, 0.9, 0.2));
    let forward = hips.rotation_keys.values[1] * Vec3::Z;
    assert!(forward.distance(Vec3::NEG_X) < 1e-6, "{forward}");
}

#[test]
fn the_root_moves_the_hips_and_a_bone_that_comes_again_ends_the_frame() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let root = message(
        "/VMC/Ext/Root/Pos",
        Some("root"),
        &[1.0, 0.0, 0.0, 0.0, half, 0.0, half],
    );
    let hips = bone("Hips", [0.0, 1.0, 0.5, 0.0, 0.0, 0.0, 1.0]);
    let spine = bone("Spine", [0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let packets = [root, hips.clone(), spine.clone(), hips, spine];
    let scene = recorded(&packets);
    let keys = &scene.animations[0].channels[0];
    assert_eq!(keys.position_keys.values.len(), 2);
    // In Unity: 0.5 along +Z, rotated to +X, and 1 along +X.
    assert!(keys.position_keys.values[0].distance(Vec3::new(-1.5, 1.0, 0.0)) < 1e-6);
    let expected = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    assert!(keys.rotation_keys.values[0].angle_between(expected) < 1e-3);
}

#[test]
fn what_is_malformed_is_counted_and_nothing_without_hips_is_a_motion() {
    let hips = bone("Hips", [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let mut recorder = VmcRecorder::new();
    let mut hear = |packet: &[u8]| {
        recorder.hear(packet, 0.0);
        recorder.counts().malformed
    };
    assert_eq!(hear(b""), 1);
    assert_eq!(hear(b"hello"), 2);
    assert_eq!(hear(&hips[..hips.len() - 3]), 3);
    assert_eq!(hear(&bone("Hips", [f32::NAN, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0])), 4);
    assert_eq!(hear(&bone("Hips", [1e30, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0])), 5);
    assert_eq!(hear(&bone("Hips", [0.0; 7])), 6);
    assert_eq!(hear(&message("/VMC/Ext/Bone/Pos", Some("Hips"), &[1.0])), 7);
    assert_eq!(hear(&time(f32::INFINITY)), 8);
    // Bundles that are nested without end.
    let mut nested = Vec::new();
    for _ in 0..3000 {
        let length = u32::try_from(nested.len()).unwrap().to_be_bytes();
        nested.splice(0..0, [b"#bundle\0\0\0\0\0\0\0\0\x01", &length[..]].concat());
    }
    assert_eq!(hear(&nested), 9);
    // These messages are not malformed.
    assert_eq!(hear(&bone("LastBone", [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0])), 9);
    assert_eq!(hear(&message("/VMC/Ext/Blend/Val", Some("Joy"), &[0.5])), 9);
    let counts = recorder.counts();
    assert_eq!(
        (counts.packets, counts.others, counts.blend_shapes, counts.frames),
        (11, 1, 1, 0)
    );
    assert_eq!(recorder.scene().unwrap_err().code(), Code::NoMotion);
}

/// A stream is returned half a second later without its noise. Messages that are not about bones stay with their frame.
#[test]
fn a_stream_is_given_back_without_its_noise() {
    let mut cleaner = VmcCleaner::new(0.5).unwrap();
    let (mut state, mut given) = (1_u64, Vec::new());
    let mut noise = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        0.15 * ((state >> 40) as f32 / (1u64 << 24) as f32 - 0.5)
    };
    let angle = |frame: usize| 0.3 * (0.05 * frame as f32).sin();
    let mut spoiled = 0.0;
    for frame in 0..120 {
        let wrong = Quat::from_scaled_axis(Vec3::new(noise(), noise(), noise()));
        let [x, y, z, w] = (Quat::from_rotation_y(angle(frame)) * wrong).to_array();
        spoiled += wrong.angle_between(Quat::IDENTITY) / 120.0;
        let seconds = frame as f32 / 60.0;
        let packets = [
            time(seconds),
            bone("Hips", [0.0, 1.0, 0.0, x, y, z, w]),
            message("/VMC/Ext/Blend/Val", Some("Joy"), &[frame as f32]),
        ];
        given.extend(
            packets
                .iter()
                .flat_map(|packet| cleaner.hear(packet, f64::from(seconds))),
        );
    }
    // A frame ends as the next begins.
    assert_eq!(given.len(), 120 - 30 - 1);
    given.extend(cleaner.finish());
    assert_eq!(given.len(), 120);
    let mut recorder = VmcRecorder::new();
    given.iter().for_each(|packet| recorder.hear(packet, 0.0));
    let counts = recorder.counts();
    assert_eq!((counts.frames, counts.blend_shapes, counts.malformed), (120, 120, 0));
    let scene = recorder.scene().unwrap();
    let keys = &scene.animations[0].channels[0].rotation_keys.values;
    let left = keys
        .iter()
        .enumerate()
        .map(|(frame, key)| key.angle_between(Quat::from_rotation_y(-angle(frame))));
    let left = left.sum::<f32>() / 120.0;
    assert!(left < 0.25 * spoiled, "{left} of {spoiled}");
}

#[test]
fn a_stream_with_other_bones_or_none_loses_nothing() {
    let hips = |x: f32| bone("Hips", [x, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let mut cleaner = VmcCleaner::new(0.1).unwrap();
    let mut given = Vec::new();
    for frame in 0..50 {
        let seconds = f64::from(frame) / 60.0;
        given.extend(cleaner.hear(&time(seconds as f32), seconds));
        given.extend(cleaner.hear(&hips(0.01 * frame as f32), seconds));
        if frame >= 30 {
            given.extend(cleaner.hear(&bone("Spine", [0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0]), seconds));
        }
        given.extend(cleaner.hear(b"hello", seconds));
    }
    given.extend(cleaner.finish());
    let mut recorder = VmcRecorder::new();
    given.iter().for_each(|packet| recorder.hear(packet, 0.0));
    assert_eq!((recorder.counts().frames, recorder.counts().malformed), (50, 0));
    // Without any bone, messages pass unchanged.
    let mut cleaner = VmcCleaner::new(0.5).unwrap();
    let packets = (0..3).flat_map(|frame| cleaner.hear(&time(frame as f32), 0.0)).count();
    assert_eq!((packets, cleaner.finish().len()), (2, 1));
    for delay in [-0.1, 10.5, f64::NAN] {
        assert_eq!(VmcCleaner::new(delay).unwrap_err().code(), Code::InvalidValue);
    }
}

/// Blend shapes are expressions, by the names of VRM 0 and 1.0, and the eyes are the gaze. The file has both.
#[test]
fn blend_shapes_and_eyes_are_kept_in_a_vrm_animation() {
    let shape = |name: &str, value: f32| message("/VMC/Ext/Blend/Val", Some(name), &[value]);
    let half = (0.1_f32).sin_cos();
    let mut recorder = VmcRecorder::new();
    for frame in 0..4 {
        let value = 0.25 * frame as f32;
        let mut packets = vec![time(frame as f32 / 30.0)];
        for (name, parent) in SKELETON {
            packets.push(bone(name, [parent[0], parent[1], parent[2], 0.0, 0.0, 0.0, 1.0]));
        }
        packets.push(bone("LeftEye", [-0.03, 0.06, 0.08, 0.0, half.0, 0.0, half.1]));
        packets.push(bone("RightEye", [0.03, 0.06, 0.08, 0.0, half.0, 0.0, half.1]));
        packets.extend([
            shape("Joy", value),
            shape("Blink_L", 1.0),
            shape("tongueOut", 1.5),
            shape("Angry", 0.0),
        ]);
        packets.push(message("/VMC/Ext/Blend/Val", Some("Fun"), &[]));
        packets.iter().for_each(|packet| recorder.hear(packet, 0.0));
    }
    assert_eq!((recorder.counts().blend_shapes, recorder.counts().malformed), (16, 4));
    let scene = recorder.scene().unwrap();
    assert!(scene.validate().is_empty());
    let bytes = mocap::Exporter::new()
        .write(&scene, mocap::Format::Vrma)
        .unwrap()
        .into_bytes()
        .unwrap();
    for scene in [scene, mocap::Importer::new().read(&bytes, "take.vrma").unwrap()] {
        let face = |name: &str| {
            let nodes = scene.nodes.iter().filter(|node| node.face.is_some());
            let node = nodes.clone().find(|node| node.face.as_ref().unwrap().name() == name);
            let node = node.unwrap_or_else(|| panic!("no {name} in {nodes:?}"));
            let channels = &scene.animations[0].channels;
            channels
                .iter()
                .find(|channel| channel.node_name == node.name)
                .unwrap()
                .clone()
        };
        for tick in 0..4 {
            let weight = face("happy").position_keys.sample(f64::from(tick)).unwrap().x;
            assert!((weight - 0.25 * tick as f32).abs() < 1e-3, "{weight}");
        }
        assert!((face("blinkLeft").position_keys.values[0].x - 1.0).abs() < 1e-3);
        // Weights are from 0 to 1.
        assert!((face("tongueOut").position_keys.values[0].x - 1.0).abs() < 1e-3);
        // 0.2 radians to the right of the figure, which is -X.
        let gaze = face("lookAt").rotation_keys.values[0] * Vec3::Z;
        assert!(
            gaze.distance(Vec3::new(-0.2_f32.sin(), 0.0, 0.2_f32.cos())) < 1e-3,
            "{gaze}"
        );
        assert!(
            scene
                .nodes
                .iter()
                .all(|node| node.face.as_ref().is_none_or(|face| face.name() != "angry"))
        );
    }
}

/// The required bones of a humanoid, with their offsets in Unity's axes: left is -X.
const SKELETON: [(&str, [f32; 3]); 17] = [
    ("Hips", [0.0, 0.95, 0.0]),
    ("Spine", [0.0, 0.1, 0.0]),
    ("Chest", [0.0, 0.15, 0.0]),
    ("Neck", [0.0, 0.25, 0.0]),
    ("Head", [0.0, 0.1, 0.0]),
    ("LeftUpperLeg", [-0.09, -0.05, 0.0]),
    ("LeftLowerLeg", [0.0, -0.42, 0.0]),
    ("LeftFoot", [0.0, -0.4, 0.0]),
    ("RightUpperLeg", [0.09, -0.05, 0.0]),
    ("RightLowerLeg", [0.0, -0.42, 0.0]),
    ("RightFoot", [0.0, -0.4, 0.0]),
    ("LeftUpperArm", [-0.16, 0.18, 0.0]),
    ("LeftLowerArm", [-0.27, 0.0, 0.0]),
    ("LeftHand", [-0.25, 0.0, 0.0]),
    ("RightUpperArm", [0.16, 0.18, 0.0]),
    ("RightLowerArm", [0.27, 0.0, 0.0]),
    ("RightHand", [0.25, 0.0, 0.0]),
];

/// The packets of a frame in which every bone rotates.
fn turned(frame: usize) -> Vec<Vec<u8>> {
    let seconds = frame as f32 / 60.0;
    let mut packets = vec![time(seconds)];
    for (index, (name, [x, y, z])) in SKELETON.iter().enumerate() {
        let angle = 0.4 * (3.0 * seconds + index as f32).sin();
        let [i, j, k, w] = Quat::from_scaled_axis(angle * Vec3::new(0.3, 0.8, 0.5)).to_array();
        let lift = if index == 0 { 0.05 * angle } else { 0.0 };
        packets.push(bone(name, [*x + lift, *y + lift, *z, i, j, k, w]));
    }
    packets.push(message("/VMC/Ext/Blend/Val", Some("Joy"), &[0.5]));
    packets
}

fn heard(packets: &[Vec<u8>]) -> Scene {
    let mut recorder = VmcRecorder::new();
    packets.iter().for_each(|packet| recorder.hear(packet, 0.0));
    recorder.scene().unwrap()
}

/// A stream that is bridged to the sender's own body does not change. Every pose is sent with the packet of its last
/// bone, and messages that are not about bones pass.
#[test]
fn a_stream_is_bridged_onto_a_body_pose_by_pose() {
    let all: Vec<Vec<u8>> = (0..60).flat_map(turned).collect();
    let own = heard(&all);
    let mut bridge = VmcBridge::onto(&own).unwrap();
    let mut given = Vec::new();
    for frame in 0..60 {
        for (place, packet) in turned(frame).iter().enumerate() {
            let out = bridge.hear(packet, 0.0);
            // The first frame ends when the second begins, because its bones are not known before.
            if frame > 1 {
                let is_last = place == SKELETON.len();
                assert_eq!(
                    out.iter()
                        .any(|packet| packet.windows(8).any(|part| part == b"Bone/Pos")),
                    is_last
                );
            }
            given.extend(out);
        }
        assert!(bridge.hear(b"hello", 0.0).is_empty());
    }
    let counts = bridge.counts();
    assert_eq!((counts.frames, counts.malformed, counts.blend_shapes), (60, 60, 60));
    assert!(bridge.problem().is_none());
    let mut recorder = VmcRecorder::new();
    given.iter().for_each(|packet| recorder.hear(packet, 0.0));
    assert_eq!((recorder.counts().frames, recorder.counts().blend_shapes), (60, 60));
    let bridged = recorder.scene().unwrap();
    for (ours, theirs) in bridged.animations[0].channels.iter().zip(&own.animations[0].channels) {
        for (a, b) in ours.rotation_keys.values.iter().zip(&theirs.rotation_keys.values) {
            assert!(a.angle_between(*b).to_degrees() < 0.1, "{}", ours.node_name);
        }
        for (a, b) in ours.position_keys.values.iter().zip(&theirs.position_keys.values) {
            assert!(a.distance(*b) < 1e-3, "{}: {a} {b}", ours.node_name);
        }
    }
}

/// A robot gets JSON within the limits of its joints.
#[test]
fn a_stream_is_bridged_onto_a_robot() {
    let robot = mocap::Importer::new()
        .import_robot("../../fixtures/robots/h1.urdf")
        .unwrap();
    let mut bridge = VmcBridge::onto_robot(&robot);
    let packets = (0..20).flat_map(turned);
    let given: Vec<Vec<u8>> = packets.flat_map(|packet| bridge.hear(&packet, 0.0)).collect();
    assert_eq!(given.len(), 20);
    for packet in &given {
        let said: serde_json::Value = serde_json::from_slice(packet).unwrap();
        let joints = said["joints"].as_object().unwrap();
        assert_eq!(joints.len(), robot.dof_names().len());
        for link in &robot.links {
            let Some(at) = joints.get(&link.joint.name).and_then(serde_json::Value::as_f64) else {
                continue;
            };
            let limits = &link.joint.limits;
            assert!(
                at >= limits.lower - 1e-6 && at <= limits.upper + 1e-6,
                "{}",
                link.joint.name
            );
        }
        let height = said["root"]["position"][2].as_f64().unwrap();
        assert!((0.5..1.3).contains(&height), "{height}");
    }
}

/// A stream without hips is not a body, and the bridge reports this. When the bones of a body arrive, poses are sent.
#[test]
fn a_stream_that_is_no_body_yet_waits() {
    let own = heard(&(0..2).flat_map(turned).collect::<Vec<_>>());
    let mut bridge = VmcBridge::onto(&own).unwrap().json();
    for frame in 0..3 {
        let spine = bone("Spine", [0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert!(
            [time(frame as f32), spine]
                .iter()
                .all(|packet| bridge.hear(packet, 0.0).is_empty())
        );
    }
    assert_eq!(bridge.problem().map(mocap::Error::code), Some(Code::NoMotion));
    let given: Vec<Vec<u8>> = (200..210)
        .flat_map(turned)
        .flat_map(|packet| bridge.hear(&packet, 0.0))
        .collect();
    assert!(given.len() >= 9 && bridge.problem().is_none());
    let said: serde_json::Value = serde_json::from_slice(&given[5]).unwrap();
    assert!(said["bones"]["hips"]["position"].is_array() && said["bones"]["leftHand"]["rotation"].is_array());
    // Without a humanoid, there is no bridge.
    let arm = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    assert!(VmcBridge::onto(&arm).is_err());
}

/// The sender's clock as a 64-bit float, which senders that have run for days need.
fn exact_time(seconds: f64) -> Vec<u8> {
    [text("/VMC/Ext/T"), text(",d"), seconds.to_be_bytes().to_vec()].concat()
}

/// The name of a case, the sender's clock at a frame, and the number of its jumps.
type Case<'a> = (&'a str, &'a dyn Fn(usize) -> f64, u64);

/// A sender with 30 frames per second is recorded for 3 seconds, while its clock jumps or fails. The receiver's clock
/// determines the length of the take.
#[test]
fn a_jump_of_the_senders_clock_is_bridged_by_the_time_of_arrival() {
    const FRAMES: usize = 91;
    let fps = |frame: usize| frame as f64 / 30.0;
    let from = |start: f64| {
        move |frame: usize| {
            if frame < 40 {
                fps(frame)
            } else {
                start + fps(frame - 40)
            }
        }
    };
    let cases: [Case<'_>; 12] = [
        ("no jump", &fps, 0),
        ("5 hours forward", &from(18_000.0), 1),
        ("to the largest number", &from(f64::MAX), 0),
        ("backwards", &|frame| 18_000.0 - from(18_000.0)(frame), 0),
        (
            "back to 0 from 5 hours",
            &|frame| {
                if frame < 40 {
                    18_000.0 + fps(frame)
                } else {
                    fps(frame - 40)
                }
            },
            1,
        ),
        ("wraps at 1000", &|frame| (998.0 + fps(frame)) % 1000.0, 1),
        ("NaN once", &|frame| if frame == 40 { f64::NAN } else { fps(frame) }, 0),
        ("negative at first", &|frame| fps(frame) - 0.1, 0),
        (
            "one value far off",
            &|frame| if frame == 40 { 1e9 } else { fps(frame) },
            2,
        ),
        ("stands still", &|_| 7.0, 0),
        ("absent", &|_| f64::NAN, 0),
        (
            "two senders",
            &|frame| {
                if frame % 2 == 0 {
                    fps(frame)
                } else {
                    9000.0 + fps(frame)
                }
            },
            90,
        ),
    ];
    for (name, clock, jumps) in cases {
        let mut recorder = VmcRecorder::new();
        for frame in 0..FRAMES {
            // Packets are up to 8 ms late.
            let arrival = 500.0 + fps(frame) + 0.002 * (frame * 7 % 5) as f64;
            recorder.hear(&exact_time(clock(frame)), arrival);
            recorder.hear(
                &bone("Hips", [0.01 * frame as f32, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
                arrival,
            );
        }
        let scene = recorder.scene().unwrap();
        let animation = &scene.animations[0];
        let keys = &animation.channels[0].position_keys;
        assert_eq!(keys.values.len(), FRAMES, "{name}");
        let seconds = animation.duration / animation.ticks_per_second;
        assert!((seconds - 3.0).abs() < 0.1, "{name}: {seconds} s");
        let warned: u64 = scene.warnings.iter().map(|warning| warning.count).sum();
        assert_eq!(warned, jumps, "{name}: {:?}", scene.warnings);
        if name == "5 hours forward" {
            let message = &scene.warnings[0].message;
            assert_eq!(scene.warnings[0].code, Code::ClockJump);
            // Frame 40 is due at 1.33 s.
            assert!(
                message.contains("forward by 17998.6") && message.contains("at 1.3"),
                "{message}"
            );
        }
    }
}

/// The gap between two runs of a sender is the time without packets.
#[test]
fn a_sender_that_begins_again_leaves_the_gap_of_its_arrival() {
    let mut recorder = VmcRecorder::new();
    for frame in 0..60 {
        let (begun, waited) = if frame < 30 { (50.0, 0.0) } else { (-1.0, 12.0) };
        let seconds = f64::from(frame) / 30.0;
        recorder.hear(&exact_time(begun + seconds), seconds + waited);
        recorder.hear(&bone("Hips", [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]), seconds + waited);
    }
    let scene = recorder.scene().unwrap();
    let animation = &scene.animations[0];
    assert_eq!(
        (animation.ticks_per_second, animation.duration),
        (30.0, 59.0 + 12.0 * 30.0)
    );
    assert!(
        scene.warnings[0].message.contains("jumped back by"),
        "{:?}",
        scene.warnings
    );
}

/// Neither a jump of the clock nor a frame without a time gives a joint more time for a movement.
#[test]
fn a_robot_keeps_its_velocity_limits_across_a_jump_of_the_clock() {
    let robot = mocap::Importer::new()
        .import_robot("../../fixtures/robots/h1.urdf")
        .unwrap();
    let mut bridge = VmcBridge::onto_robot(&robot);
    let mut before: Option<serde_json::Value> = None;
    for frame in 0..12 {
        // The pose changes in frame 6.
        let mut packets = turned(if frame < 6 { frame } else { 90 });
        match frame {
            6 => packets[0] = exact_time(18_000.0),
            7.. => packets[0] = exact_time(18_000.0 + (frame - 6) as f64 / 60.0),
            _ => {}
        }
        if frame == 9 {
            packets[0] = exact_time(f64::NAN);
        }
        let arrival = 700.0 + frame as f64 / 60.0;
        for packet in packets.iter().flat_map(|packet| bridge.hear(packet, arrival)) {
            let said: serde_json::Value = serde_json::from_slice(&packet).unwrap();
            let joints = |said: &serde_json::Value, name: &str| said["joints"][name].as_f64();
            for joint in robot.links.iter().map(|link| &link.joint) {
                let now = joints(&said, &joint.name);
                let then = before.as_ref().and_then(|before| joints(before, &joint.name));
                let Some((now, then)) = now.zip(then) else { continue };
                let speed = (now - then).abs() * 60.0;
                assert!(
                    speed <= joint.limits.velocity.unwrap_or(f64::INFINITY) * 1.01 + 1e-6,
                    "frame {frame}: {} {speed}",
                    joint.name
                );
            }
            before = Some(said);
        }
    }
    assert_eq!(bridge.counts().frames, 12);
}
