//! Tests how a motion is packed for the player page.

mod clip_block;

use mocap::glam::{Quat, Vec4};
use mocap::{Binding, Trs};
use mocap_render::internals::pack::{Packed, Part, ROTATION_PRECISION, Row, Storage, Tracks, pack_rotations, pack_row};

#[test]
fn a_row_is_within_its_precision_in_the_fewest_bytes() {
    let wave: Row = (0..1000).map(|frame| (frame as f32 * 0.01).sin()).collect();
    let widths = [(1.0, 1), (1e-2, 1), (1e-4, 2), (1e-7, 3), (0.0, 4)].map(|(precision, width)| {
        let mut bytes = Vec::new();
        let unpacked = pack_row(&wave, precision, &mut bytes);
        let header = if width == 4 { 1 } else { 13 };
        assert_eq!(bytes.len(), header + width * wave.len(), "precision {precision}");
        for (value, unpacked) in wave.iter().zip(unpacked) {
            let error = f64::from(value - unpacked).abs();
            assert!(
                error <= precision + 1e-7 * f64::from(width < 4),
                "{error} > {precision}"
            );
        }
        usize::from(bytes[0])
    });
    assert_eq!(widths, [1, 1, 2, 3, 4]);
    let mut bytes = Vec::new();
    assert_eq!(pack_row(&vec![0.25; 1000], 0.0, &mut bytes), [0.25; 1000]);
    assert_eq!(bytes.len(), 13);
}

#[test]
fn joints_stay_within_the_bound() {
    let scene = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let animation = &scene.animations[0];
    let mut tracks = Tracks::new(&scene, animation.frame_count() as u64);
    for (node, channel) in Binding::new(&scene, animation).driven() {
        let channel = &animation.channels[channel];
        let rest = Trs::from_matrix(scene.nodes[node.index()].transform);
        for (part, keys) in [
            (Part::Translation, channel.position_keys.len()),
            (Part::Rotation, channel.rotation_keys.len()),
        ] {
            if keys > 1 {
                tracks.push(node.index(), part, channel, rest);
            }
        }
    }
    let bytes = |packed: &Packed| packed.blocks.iter().map(Vec::len).sum::<usize>();
    // The walker is about 30 units high.
    assert_eq!(tracks.pack(Storage::Clips, 15.0, 0.06).max_error, 0.0);
    let rows = |is_exact, reach| tracks.pack_blocks(is_exact, None, reach);
    let (exact, packed) = (rows(true, 15.0), rows(false, 15.0));
    assert_eq!(exact.max_error, 0.0);
    assert!(
        packed.max_error > 0.0 && packed.max_error <= 1.5e-3,
        "{}",
        packed.max_error
    );
    assert!(
        bytes(&packed) * 5 < bytes(&exact) * 2,
        "{} of {}",
        bytes(&packed),
        bytes(&exact)
    );
    // An error bound too small for two bytes gets finer steps, and an impossible bound gets exact values.
    let (fine, exact_too) = (rows(false, 0.15), rows(false, 1e-9));
    assert!(fine.max_error <= 1.5e-5 && bytes(&fine) > bytes(&packed));
    assert_eq!((exact_too.max_error, bytes(&exact_too)), (0.0, bytes(&exact)));
}

#[test]
fn a_rotation_keeps_its_sign_and_its_length() {
    let rotation = |frame: usize| Quat::from_rotation_y(0.002 * frame as f32).to_array();
    for sign in [1.0, -1.0] {
        let rows: Vec<Row> = (0..4)
            .map(|c| (0..1000).map(|frame| sign * rotation(frame)[c]).collect())
            .collect();
        let mut bytes = Vec::new();
        let unpacked = pack_rotations(&rows, ROTATION_PRECISION, &mut bytes);
        // x and z are constant zero, w is omitted, and y takes two bytes per frame.
        assert_eq!(bytes.len(), 1 + 3 * 13 + 2 * 1000);
        for frame in 0..1000 {
            let at = |rows: &[Row]| Vec4::from_array([0, 1, 2, 3].map(|c| rows[c][frame]));
            assert!(at(&rows).distance(at(&unpacked)) < 4e-5);
            assert!((at(&unpacked).length() - 1.0).abs() < 1e-6);
        }
    }
}
