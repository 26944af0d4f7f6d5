//! Tests the measured error of a compressed clip.

use std::slice;
use std::sync::Arc;

use mocap::compress::{KeyFrames, RotationFormat, Track};
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind, Scene};
use mocap_compress::internals::key_frames::every_frame;
use mocap_compress::internals::measure::{FrameErrors, Measurement, measure, measure_lanes};
use mocap_compress::internals::{CompressedTrack, QuantizedRotation, RawClip};

const FRAMES: usize = 14;
const LAST: usize = FRAMES - 1;

/// A joint at the origin that rotates about z by `degrees` over all frames. Its end site is one metre away on the x
/// axis.
fn rotating(degrees: f32) -> Scene {
    let node = |index: usize| Node {
        name: ["Joint", "End"][index].into(),
        kind: [NodeKind::Joint, NodeKind::EndSite][index],
        parent: index.checked_sub(1).map(NodeId::new),
        transform: Mat4::from_translation(Vec3::X * index as f32),
        ..Node::default()
    };
    Scene {
        nodes: (0..2).map(node).collect(),
        animations: vec![Animation {
            ticks_per_second: 30.0,
            duration: LAST as f64,
            channels: vec![Channel {
                node_name: "Joint".into(),
                node: None,
                position_keys: Keys::constant(Vec3::ZERO),
                rotation_keys: Keys::every_tick((0..FRAMES).map(|frame| rotation(degrees, frame)).collect()),
                scaling_keys: Keys::constant(Vec3::ONE),
            }],
            ..Animation::default()
        }],
        ..Scene::default()
    }
}

fn rotation(degrees: f32, frame: usize) -> Quat {
    Quat::from_rotation_z((degrees * frame as f32 / LAST as f32).to_radians())
}

/// The angle at a frame, and the angle at the last frame.
fn angles(degrees: f32, frame: usize) -> (f64, f64) {
    let all = f64::from(degrees).to_radians();
    (all * frame as f64 / LAST as f64, all)
}

/// Tracks for [`rotating`] with keys at `key_frames`. `key` gives the value and the ambiguous components of each.
fn tracks(key_frames: KeyFrames, key: impl Fn(usize) -> (Quat, u8)) -> Vec<CompressedTrack> {
    let key = |frame: &u32| {
        let (value, ambiguous) = key(*frame as usize);
        QuantizedRotation {
            stored: [0; 4],
            value,
            ambiguous,
        }
    };
    let keys = key_frames.iter().map(key).collect();
    vec![
        CompressedTrack {
            translation: Track::Constant(Vec3::ZERO),
            rotation: Track::Animated {
                format: RotationFormat::Float32,
                key_frames: Arc::new(key_frames),
                keys,
            },
            curves: None,
        },
        CompressedTrack {
            translation: Track::Constant(Vec3::X),
            rotation: Track::Constant(Quat::IDENTITY),
            curves: None,
        },
    ]
}

/// The largest error at every frame.
fn measured(degrees: f32, tracks: &[CompressedTrack]) -> Vec<f64> {
    let scene = rotating(degrees);
    let clip = RawClip::new(&scene, &scene.animations[0], 0.0).unwrap();
    let times: Vec<f32> = clip.ticks.iter().map(|tick| (tick / 30.0) as f32).collect();
    let measurement = Measurement {
        clip: &clip,
        tracks,
        times: &times,
        raw_rounding: 0.0,
        weights: &[],
    };
    let mut errors = FrameErrors::new(FRAMES);
    measure(&measurement, slice::from_ref(&(0..FRAMES)), &mut errors);

    // Without wide vectors, the results are equal bit by bit. In ranges whose length is no multiple of the number of
    // lanes, the results are nearly equal.
    let mut plain = FrameErrors::new(FRAMES);
    measure_lanes(&measurement, slice::from_ref(&(0..FRAMES)), &mut plain);
    assert_eq!(errors.largest, plain.largest);
    let mut parts = FrameErrors::new(FRAMES);
    measure(&measurement, &[0..3, 3..4, 4..9, 9..FRAMES], &mut parts);
    for (all, part) in std::iter::zip(&errors.largest, &parts.largest) {
        assert!((all - part).abs() < 1e-15, "{all}, not {part}");
    }
    errors.largest
}

/// Compares within the rounding of 32-bit quaternions: some 1e-7 rad, which is some 1e-7 m at a distance of one metre.
fn assert_near(found: &[f64], expected: impl Fn(usize) -> f64) {
    for (frame, found) in found.iter().enumerate() {
        let expected = expected(frame);
        assert!(
            (found - expected).abs() < 3e-7,
            "frame {frame}: {found}, not {expected}"
        );
    }
}

/// Nlerp moves along the chord, not along the arc. Let `A` be half the angle between the keys. Half the angle at
/// `alpha` is then `a`, with `tan a = alpha sin A / (1 - alpha + alpha cos A)`.
#[test]
fn nlerp_is_the_decoder_with_the_largest_error() {
    // The angles are on both sides of the angle below which slerp uses a series.
    for degrees in [12.0, 21.0, 24.0, 100.0, 170.0] {
        let found = measured(
            degrees,
            &tracks(vec![0, LAST as u32], |frame| (rotation(degrees, frame), 0)),
        );
        assert_near(&found, |frame| {
            let (angle, all) = angles(degrees, frame);
            let (alpha, half) = (frame as f64 / LAST as f64, all / 2.0);
            let chord = 2.0 * (alpha * half.sin()).atan2(1.0 - alpha + alpha * half.cos());
            2.0 * ((chord - angle) / 2.0).sin().abs()
        });
    }
}

/// The matrix of a quaternion of length `l` is `I + l^2 (R - I)`, where `R` is the matrix of the rotation.
#[test]
fn a_length_other_than_1_stretches_for_decoders_that_do_not_normalize() {
    let length = 1.01;
    let longer = |frame| (rotation(60.0, frame) * length, 0);
    let found = measured(60.0, &tracks(every_frame(FRAMES), longer));
    let square = f64::from(length).powi(2);
    assert_near(&found, |frame| {
        let (angle, _) = angles(60.0, frame);
        (square - 1.0) * 2.0 * (angle / 2.0).sin()
    });
}

/// The end site is one metre away, so its error is the angle by which implementations of a decoder may differ.
#[test]
fn ambiguity_counts_as_error() {
    let ambiguous = |frame| (rotation(60.0, frame), if frame == 5 { 3 } else { 0 });
    let found = measured(60.0, &tracks(every_frame(FRAMES), ambiguous));
    assert_near(
        &found,
        |frame| if frame == 5 { 2.0 * 3f64.sqrt() / 32767.0 } else { 0.0 },
    );
}

#[test]
fn the_worst_frame_is_named() {
    let scene = rotating(60.0);
    let clip = RawClip::new(&scene, &scene.animations[0], 0.0).unwrap();
    let mut errors = FrameErrors::new(FRAMES);
    (errors.largest[4], errors.nodes[4]) = (0.5, 1);
    (errors.largest[7], errors.nodes[7]) = (0.25, 0);
    errors.squares[4] = 0.25 * (2 * FRAMES) as f64;
    let found = errors.summary(&clip);
    assert_eq!((found.max, found.node, found.tick, found.rms), (0.5, 1, 4.0, 0.5));
    assert_eq!(errors.by_node(3), [0.25, 0.5, 0.0]);
}
