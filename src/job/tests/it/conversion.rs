//! Tests that a `Conversion` agrees with the arrays, and that its output is verified.

use mocap::arrays::{ArrayOptions, Arrays};
use mocap::figure::{Humanoid, HumanoidBone, HumanoidMap};
use mocap::gltf::GltfOptions;
use mocap::scene::{Scene, Topic, UpAxis};
use mocap::verify::report::Verification;
use mocap::{Conversion, Pose};

fn import(file: &str) -> Scene {
    mocap::import(format!("../../fixtures/real/{file}")).unwrap()
}

#[test]
fn a_map_of_the_bones_decides_the_unit() {
    let source = import("cmu_short.bvh");
    let found = Humanoid::of(&source);
    let name = |bone| source.nodes[found.bones[&bone].joint.index()].name.clone();
    let mut numbered = source.clone();
    for (index, node) in numbered.nodes.iter_mut().enumerate() {
        node.name = format!("J{index}");
    }
    // The map says that the neck joint is the head. The body is then fewer units tall, so each unit is longer.
    let neck = source
        .nodes
        .iter()
        .position(|node| node.name == name(HumanoidBone::Neck))
        .unwrap();
    let map = HumanoidMap::from([
        (HumanoidBone::Head, Some(format!("J{neck}"))),
        (HumanoidBone::Neck, None),
    ]);
    let reason = |bones: HumanoidMap| {
        let mut scene = numbered.clone();
        let guesses = Conversion::new().bones(bones.clone()).apply(&mut scene).unwrap();
        let unit = guesses.into_iter().find(|guess| guess.topic == Topic::Unit).unwrap();
        let options = ArrayOptions::new().out_metres_per_unit(1.0).bones(bones);
        let of_arrays = Arrays::of(&numbered, &options).unwrap().header.provenance.assumptions;
        assert_eq!(of_arrays, std::slice::from_ref(&unit));
        unit.reason
    };
    assert_ne!(reason(HumanoidMap::new()), reason(map));
}

/// The writer of this file counts the rows of pictures from above, so +Y points down. After the conversion, the figure
/// stands on its feet.
#[test]
fn what_stands_with_y_down_is_turned() {
    let mut scene = mocap::import("../../fixtures/skeletons/animics_all_along_z.bvh").unwrap();
    let source = scene.clone();
    let assumptions = Conversion::new().apply(&mut scene).unwrap();
    let up = assumptions.iter().find(|one| one.topic == Topic::Up).unwrap();
    assert_eq!(up.choice, "-y");
    assert_eq!(scene.metadata.up, Some(UpAxis::Y));
    let bones = Humanoid::of(&source);
    let [head, foot] = [HumanoidBone::Head, HumanoidBone::LeftFoot].map(|bone| bones.joint(bone).unwrap());
    for tick in [0.0, 10.0, 50.0] {
        let height = |scene: &Scene| {
            let pose = Pose::at_tick(scene, 0, tick).unwrap();
            pose.position(head).y - pose.position(foot).y
        };
        assert!(height(&source) < 0.0 && height(&scene) > 1.0, "{} m", height(&scene));
    }
    let glb = GltfOptions::default().write_glb(&scene).unwrap();
    let report = Verification::of(&source, &glb).unwrap();
    assert!(report.is_within(1e-4), "{report:?}");
}
