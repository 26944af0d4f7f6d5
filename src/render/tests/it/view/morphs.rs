//! Tests the morph targets of the player page.

use mocap::glam::Vec3;
use mocap::scene::{Mesh, MorphTarget};
use mocap_render::internals::morphs::{MOVED_BYTES, Morphs};

fn mesh(name: &str, offset: Vec3) -> Mesh {
    Mesh {
        vertices: vec![Vec3::ZERO; 2],
        morph_targets: vec![MorphTarget {
            name: name.to_owned(),
            weight: 0.25,
            vertex_ids: vec![1],
            offsets: vec![offset],
            normal_offsets: vec![Vec3::new(0.0, -1.0, 0.5)],
            ..MorphTarget::default()
        }],
        ..Mesh::default()
    }
}

#[test]
fn targets_of_one_name_are_one_slider() {
    let meshes = [
        mesh("smile", Vec3::X),
        mesh("smile", Vec3::new(0.0, -2.0, 0.0)),
        mesh("blink", Vec3::Z),
    ];
    let mut morphs = Morphs::new(&meshes.iter().collect::<Vec<_>>(), 3 * MOVED_BYTES, &mut Vec::new());
    for (index, mesh) in meshes.iter().enumerate() {
        morphs.push(mesh, 2 * index);
    }
    let packed = morphs.pack();
    let names: Vec<_> = packed
        .morphs
        .iter()
        .map(|morph| (morph.name.as_str(), morph.count))
        .collect();
    assert_eq!(names, [("smile", 2), ("blink", 1)]);
    assert_eq!(packed.moved.len() + packed.normals.len(), 3 * MOVED_BYTES);
    let words: Vec<u32> = packed.moved.as_chunks::<4>().0[..3]
        .iter()
        .map(|word| u32::from_le_bytes(*word))
        .collect();
    assert_eq!(words, [1, 3, 5]);
    // The second vertex of the smile moves down by 2, the full range.
    let steps = packed.moved[12..]
        .as_chunks::<2>()
        .0
        .iter()
        .map(|half| i16::from_le_bytes(*half));
    let steps: Vec<i16> = steps.collect();
    assert_eq!(steps[3..6], [0, -i16::MAX, 0]);
    assert!((f32::from(steps[0]) * packed.morphs[0].step - 1.0).abs() < 1e-4);
    assert_eq!(packed.normals[..3], [0, (-63_i8) as u8, 32]);
}

#[test]
fn targets_beyond_the_room_are_left_out_with_a_note() {
    let mesh = mesh("smile", Vec3::X);
    let mut notes = Vec::new();
    let mut morphs = Morphs::new(&[&mesh], MOVED_BYTES - 1, &mut notes);
    morphs.push(&mesh, 0);
    assert!(morphs.pack().morphs.is_empty() && notes.len() == 1);
}
