//! BVH of characters whose joints are rotated at rest. Without rotations, the BVH is in the characters' bind pose, and
//! its motion equals the characters' motion. Separate kinematics read the text.

use std::path::Path;

use crate::kinematics::{self, Capture, Placement, Root};
use mocap::convert::RestPoseSource;
use mocap::retarget::{RetargetOptions, Retargeter, Target};
use mocap::{Conversion, Exporter, Format, Importer, Pose, Scene};

/// The largest allowed error, in metres.
const ALLOWED: f64 = 1e-5;

/// A motion on a character, in metres.
fn moving(character: &str) -> Scene {
    let path = Path::new("../../fixtures/characters").join(character);
    let target = Target::import(path, &Importer::new()).unwrap();
    let motion = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let retargeting = Retargeter::new(motion, target, RetargetOptions::new()).unwrap();
    retargeting.scene_in_metres().unwrap()
}

fn text(scene: &Scene) -> String {
    let bytes = Exporter::new().write(scene, Format::Bvh).unwrap().into_bytes().unwrap();
    String::from_utf8(bytes).unwrap()
}

/// The largest distance of a joint of the text from its position in a pose.
fn distance(scene: &Scene, pose: &Pose, capture: &Capture, placements: &[Placement]) -> f64 {
    let mut largest: f64 = 0.0;
    let mut found = 0;
    for (joint, placement) in std::iter::zip(&capture.nodes, placements) {
        let Some(node) = scene.nodes.iter().position(|node| node.name == joint.name) else {
            continue;
        };
        let place = pose.node_to_world[node].w_axis.as_dvec4().truncate().to_array();
        largest = largest.max(kinematics::distance(place, placement.position));
        found += 1;
    }
    assert!(found > 20, "{found}");
    largest
}

/// The joints without rotations. The root has its position in the pose.
fn still(scene: &Scene, pose: &Pose, capture: &Capture) -> Vec<Placement> {
    let root = scene
        .nodes
        .iter()
        .position(|node| node.name == capture.nodes[0].name)
        .unwrap();
    let place = pose.node_to_world[root].w_axis.as_dvec4().truncate().to_array();
    let mut placements = capture.rest();
    let own = placements[0].position;
    for placement in &mut placements {
        placement.position = std::array::from_fn(|axis| placement.position[axis] - own[axis] + place[axis]);
    }
    placements
}

#[test]
fn without_rotations_a_character_stands_in_its_bind_pose_and_it_moves_as_it_did() {
    for character in [
        "human_default.glb",
        "human_game_engine.glb",
        "human_vrm0.vrm",
        "arnaud.fbx",
    ] {
        let scene = moving(character);
        let written = text(&scene);
        let capture = Capture::parse(written.as_bytes());
        for tick in [0, 20, 73] {
            let pose = Pose::at_tick(&scene, 0, tick as f64).unwrap();
            let off = distance(&scene, &pose, &capture, &capture.placements(tick, Root::Replace));
            assert!(off < ALLOWED, "{character} at {tick}: {off}");
        }
        let rest = Pose::rest(&scene);
        let off = distance(&scene, &rest, &capture, &still(&scene, &rest, &capture));
        assert!(off < ALLOWED, "{character} at rest: {off}");
    }
}

#[test]
fn a_frame_becomes_the_rest_pose_of_bvh() {
    let mut scene = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let before = scene.clone();
    let conversion = Conversion::new().keep_units(true).rest(RestPoseSource::Frame(30));
    conversion.apply(&mut scene).unwrap();
    let written = text(&scene);
    let capture = Capture::parse(written.as_bytes());
    let at = |tick: f64| Pose::at_tick(&before, 0, tick).unwrap();
    // 0.01 mm in CMU's unit. A metre has 17.7 of these units.
    let allowed = ALLOWED * 17.7;
    let rest = still(&before, &at(30.0), &capture);
    assert!(distance(&before, &at(30.0), &capture, &rest) < allowed);
    let moving = capture.placements(100, Root::Replace);
    assert!(distance(&before, &at(100.0), &capture, &moving) < allowed);
}
