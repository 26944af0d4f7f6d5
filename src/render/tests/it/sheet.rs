//! Tests contact sheets: pictures with several poses of a clip in a row.

use glam::{Mat4, Vec3};
use mocap::scene::{Node, NodeId, Scene};

use crate::drawing::{points, texts};
use mocap::render::{Clip, Drawing, SheetOptions};
use mocap_render::internals::{Pixels, Shape};

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
    let mut scene = importer.import("../../fixtures/characters/arnaud.fbx").unwrap();
    let (height, [shadow, skin]) = pixels(&scene);
    assert!(skin.top > 0, "the skin begins at the top of the picture");
    assert!(skin.top + skin.height < height);
    // The light comes from straight above, so the shadow is as wide as the skin.
    assert_eq!((shadow.left, shadow.width), (skin.left, skin.width));
    assert!(shadow.top > skin.top && 3 * shadow.height < skin.height);
    // A control far from the skin does not make the picture of the skin smaller.
    let control = Node {
        name: "Control".to_owned(),
        parent: Some(NodeId::new(0)),
        transform: Mat4::from_translation(Vec3::splat(10.0)),
        ..scene.nodes[0].clone()
    };
    scene.nodes.push(control);
    assert_eq!(pixels(&scene).1[1].height, skin.height);
}

/// The height of a sheet with one pose, and the pixels of the shadow and of the skin.
fn pixels(scene: &Scene) -> (usize, [Pixels; 2]) {
    let drawing = Drawing::sheet(&[Clip::new("hero", scene)], &SheetOptions::default().poses(1));
    let height = drawing.height as usize;
    let pixels = drawing.shapes.into_iter().filter_map(|shape| match shape {
        Shape::Pixels(pixels) => Some(pixels),
        _ => None,
    });
    (height, pixels.collect::<Vec<_>>().try_into().ok().unwrap())
}

/// The first frame of this file is a T-pose, which is not part of the motion.
#[test]
fn a_sheet_begins_after_the_rest_pose() {
    let scene = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let drawing = Drawing::sheet(&[Clip::new("walk", &scene)], &SheetOptions::default().poses(2));
    let all = texts(&drawing);
    let times: Vec<&str> = all
        .iter()
        .map(|(text, _)| &**text)
        .filter(|text| text.ends_with(" s"))
        .collect();
    assert_eq!(times, ["4.36 s", "0.01 s", "4.36 s"]);
}
