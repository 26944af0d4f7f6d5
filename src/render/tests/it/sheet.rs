//! Tests contact sheets: pictures with several poses of a clip in a row.

use crate::drawing::{points, texts};
use mocap::render::{Clip, Drawing, SheetOptions};
use mocap_render::internals::Shape;

#[test]
fn a_sheet_has_a_row_a_clip_and_every_pose_in_its_row() {
    let names = [
        "cmu_short",
        "leap_hand_end_site_lowercase",
        "makehuman_zombie_walk",
        "z_up_dab",
    ];
    let scenes = names.map(|name| mocap::import(format!("../../fixtures/real/{name}.bvh")).unwrap());
    let clips: Vec<_> = std::iter::zip(names, &scenes)
        .map(|(name, scene)| Clip { name, scene })
        .collect();
    let options = SheetOptions::default().poses(5);
    let drawing = Drawing::sheet(&clips, &options);
    let all = texts(&drawing);
    let times = all
        .iter()
        .filter(|(text, _)| text.ends_with(" s") && !text.contains(','))
        .count();
    assert_eq!(
        times,
        5 * clips.len() + clips.len(),
        "a time a pose, and the length of each clip"
    );
    let starts: Vec<f32> = ["cmu_short", "makehuman_zombie_walk"]
        .iter()
        .map(|name| all.iter().find(|(text, _)| text == name).unwrap().1[1])
        .collect();
    assert!(starts[0] < starts[1]);
    for shape in &drawing.shapes {
        for [x, y] in points(shape) {
            let inside = (0.0..=drawing.width as f32).contains(&x) && (0.0..=drawing.height as f32).contains(&y);
            assert!(inside, "{shape:?} is outside");
        }
    }
}

/// The head of this character is above its highest joint, by more than the margin.
#[test]
fn a_skin_is_inside_the_picture() {
    let importer = mocap::Importer::new().skeleton_mesh(mocap::SkeletonMesh::Own);
    let scene = importer.import("../../fixtures/characters/arnaud.fbx").unwrap();
    let clips = [Clip {
        name: "arnaud",
        scene: &scene,
    }];
    let drawing = Drawing::sheet(&clips, &SheetOptions::default().poses(1));
    let skin = drawing.shapes.iter().find_map(|shape| match shape {
        Shape::Pixels(pixels) => Some(pixels),
        _ => None,
    });
    let skin = skin.unwrap();
    assert!(skin.top > 0, "the skin begins at the top of the picture");
    assert!(skin.top + skin.height < drawing.height as usize);
}
