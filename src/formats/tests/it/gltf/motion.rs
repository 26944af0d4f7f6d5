//! Tests channels, times and constant tracks of glTF files.

use std::collections::HashSet;

use gltf::animation::Property;
use mocap::glam::{DVec3, Quat, Vec3};
use mocap::gltf::{Document, GltfOptions};
use mocap::scene::Keys;

use super::read::Read;
use super::scenes::{assert_same_motion, walker, with_skinned_mesh, world_of_scene};

#[test]
fn every_key_puts_every_node_where_the_scene_does() {
    let scene = with_skinned_mesh(walker(50));
    let read = Read::scene(&scene);
    assert_same_motion(&scene, &read, 50, 170.0 * 1e-6);
    assert_eq!(
        read.names(),
        ["Hips", "Leg", "EndSite_Leg", "Neck", "EndSite_Neck", "SkeletonMesh"]
    );
}

#[test]
fn only_what_moves_is_a_channel_and_all_channels_share_their_times() {
    let read = Read::scene(&walker(50));
    let animation = read.document.animations().next().unwrap();
    assert_eq!(animation.name(), Some("Walk"));
    let targets: Vec<_> = animation
        .channels()
        .map(|channel| {
            (
                channel.target().node().name().unwrap().to_owned(),
                channel.target().property(),
            )
        })
        .collect();
    let expected = [
        ("Hips", Property::Translation),
        ("Hips", Property::Rotation),
        ("Leg", Property::Rotation),
        // The track has one key, because the joint is bent all the time, unlike at rest.
        ("Neck", Property::Rotation),
    ];
    assert_eq!(targets, expected.map(|(name, property)| (name.to_owned(), property)));
    let inputs: HashSet<_> = animation.samplers().map(|sampler| sampler.input().index()).collect();
    assert_eq!(inputs.len(), 2);

    // The node of the neck has no rotation.
    let (translation, rotation, _) = read.document.nodes().nth(3).unwrap().transform().decomposed();
    assert_eq!(translation, [0.0, 60.0, 0.0]);
    assert!(Quat::from_array(rotation).abs_diff_eq(Quat::IDENTITY, 1e-7));
}

#[test]
fn constant_tracks_can_be_kept() {
    let options = GltfOptions::new().keep_constant(true);
    let scene = walker(50);
    let read = Read::glb(&options.write_glb(&scene).unwrap());
    let animation = read.document.animations().next().unwrap();
    let keys: Vec<_> = animation
        .channels()
        .map(|channel| channel.sampler().output().count())
        .collect();
    assert_eq!(keys, [50, 50, 1, 50, 1, 1]);
    assert!(
        animation
            .channels()
            .all(|channel| channel.target().property() != Property::Scale)
    );
    assert_same_motion(&scene, &read, 50, 170.0 * 1e-6);
}

#[test]
fn times_of_a_million_frames_at_a_kilohertz_increase() {
    let frames = 1_000_000;
    let mut scene = walker(2);
    scene.animations[0].ticks_per_second = 1000.0;
    scene.animations[0].channels.truncate(1);
    scene.animations[0].channels[0].position_keys = Keys::constant(Vec3::ZERO);
    scene.animations[0].channels[0].rotation_keys = Keys::every_tick(
        (0..frames)
            .map(|frame| Quat::from_rotation_z(frame as f32 * 1e-6))
            .collect(),
    );
    let read = Read::scene(&scene);
    let sampler = read.document.animations().next().unwrap().samplers().last().unwrap();
    let times = read.floats(&sampler.input());
    assert_eq!(times.len(), frames);
    assert_eq!(times[0], 0.0);
    assert!(times.is_sorted_by(|a, b| a < b));
    assert_eq!(times[frames - 1], 999.999);
}

#[test]
fn keys_that_32_bit_times_cannot_tell_apart_are_dropped_and_counted() {
    let mut scene = walker(2);
    scene.animations[0].ticks_per_second = 1.0;
    scene.animations[0].channels.truncate(1);
    let channel = &mut scene.animations[0].channels[0];
    channel.position_keys = Keys::constant(Vec3::ZERO);
    // 32-bit floats near 2^24 are first 1 and then 2 apart.
    channel.rotation_keys.ticks = Some(vec![16_777_215.0, 16_777_216.0, 16_777_216.25, 16_777_218.0]);
    channel.rotation_keys.values = [0.0, 0.1, 0.2, 0.3].map(Quat::from_rotation_x).to_vec();
    let document = Document::new(&scene, &GltfOptions::default()).unwrap();
    assert_eq!(document.report().dropped_keys, 1);
    let read = Read::glb(&document.to_glb().unwrap());
    let sampler = read.document.animations().next().unwrap().samplers().last().unwrap();
    assert_eq!(
        read.floats(&sampler.input()),
        [16_777_215.0, 16_777_216.0, 16_777_218.0]
    );
    assert_eq!(sampler.output().count(), 3);
}

#[test]
fn quaternions_are_unit_and_continuous() {
    let mut scene = walker(40);
    for (frame, value) in scene.animations[0].channels[1]
        .rotation_keys
        .values
        .iter_mut()
        .enumerate()
    {
        *value *= if frame % 2 == 0 { 1.5 } else { -0.5 };
    }
    let read = Read::scene(&scene);
    let outputs = read
        .document
        .animations()
        .next()
        .unwrap()
        .samplers()
        .map(|sampler| sampler.output());
    for output in outputs.filter(|output| output.dimensions() == gltf::accessor::Dimensions::Vec4) {
        let floats = read.floats(&output);
        let rotations: Vec<_> = floats.chunks_exact(4).map(|q| Quat::from_slice(q).as_dquat()).collect();
        assert!(rotations.iter().all(|rotation| (rotation.length() - 1.0).abs() < 1e-7));
        assert!(rotations.windows(2).all(|pair| pair[0].dot(pair[1]) > 0.0));
    }
    assert_same_motion(&scene, &read, 40, 170.0 * 1e-6);
}

#[test]
fn joints_of_one_name_keep_their_own_motion() {
    let mut scene = walker(20);
    scene.nodes[3].name = "Leg".into();
    scene.animations[0].channels[2].node_name = "Leg".into();
    let read = Read::scene(&scene);
    assert_same_motion(&scene, &read, 20, 170.0 * 1e-6);
    assert_eq!(read.names()[3], "Leg_2");
}

#[test]
fn a_take_that_stands_still_keeps_its_length() {
    let mut scene = walker(2);
    scene.animations[0].channels.remove(0);
    scene.animations[0].channels.remove(0);
    scene.animations[0].duration = 240.0;
    let read = Read::scene(&scene);
    let animation = read.document.animations().next().unwrap();
    let samplers: Vec<_> = animation.samplers().collect();
    // The two channels belong to the neck, which stays bent, and to the hips, which stay where they are.
    assert_eq!(samplers.len(), 2);
    assert_eq!(read.floats(&samplers[1].input()), [0.0, 2.0]);
    assert_same_motion(&scene, &read, 2, 1e-4);
}

#[test]
fn a_scale_that_moves_is_a_track() {
    let mut scene = walker(3);
    let scales = [1.0, 2.0, 4.0].map(Vec3::splat).to_vec();
    scene.animations[0].channels[1].scaling_keys = Keys::every_tick(scales);
    let read = Read::scene(&scene);
    let tip = read.world((1.0_f64 / 120.0) as f32)[2].w_axis.truncate();
    let leg = world_of_scene(&scene, 1)[1];
    assert!(tip.distance(leg.transform_point3(2.0 * DVec3::new(0.0, -80.0, 3.0))) < 1e-3);
}
