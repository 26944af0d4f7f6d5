//! Tests that the comparison finds differences. Both programs' answers are Assimp's answers on a probe, and one of them
//! is changed.

use crate::assimp_json;
use crate::report::Report;
use crate::scene::{Scene, Track};
use crate::source::Source;

const PROBE: &str = include_str!("../probes/near_origin.bvh");
const RAW: &str = include_str!("../probes/near_origin.none.json");
const PROCESSED: &str = include_str!("../probes/near_origin.MaxQuality+Debone.json");

/// The rest position of the probe's root.
const ROOT_OFFSET: [f64; 3] = [0.004, 0.008, -0.006];

fn assimp(json: &str) -> Scene {
    assimp_json::read(json)
        .expect("the JSON of assimp-dump")
        .expect("a scene")
}

fn report(bvh: &str, processed: bool, assimp: Scene, ours: Scene) -> Report {
    let mut report = Report::default();
    report.answers(&Source::new(bvh.as_bytes()), processed, &Ok(assimp), &Ok(ours));
    report
}

/// The explanations of the differences after a change of mocap's scene.
fn explanations(json: &str, change: impl Fn(&mut Scene)) -> Vec<Option<&'static str>> {
    let mut ours = assimp(json);
    change(&mut ours);
    let report = report(PROBE, json == PROCESSED, assimp(json), ours);
    report.findings.iter().map(|finding| finding.explanation).collect()
}

fn unit(vector: &mut [f64]) {
    let length = vector.iter().map(|part| part * part).sum::<f64>().sqrt();
    vector.iter_mut().for_each(|part| *part /= length);
}

#[test]
fn a_scene_equals_itself() {
    for json in [RAW, PROCESSED] {
        assert_eq!(explanations(json, |_| {}), []);
    }
    // 13 of nodes, 113 of meshes, 2 of materials, 22 of the animation.
    assert_eq!(report(PROBE, false, assimp(RAW), assimp(RAW)).equal, 150);
}

#[test]
fn any_changed_value_is_unexplained() {
    let changes: &[fn(&mut Scene)] = &[
        |scene| scene.nodes[1].name.push('x'),
        |scene| scene.nodes[2].parent = Some(0),
        |scene| scene.nodes[1].matrix[7] += 2e-5,
        |scene| scene.nodes[1].meshes.push(0),
        |scene| scene.nodes.truncate(2),
        |scene| scene.meshes.truncate(0),
        |scene| scene.meshes[0].name.push('x'),
        |scene| scene.meshes[0].material = 1,
        |scene| scene.meshes[0].vertices[5][1] += 2e-5,
        |scene| scene.meshes[0].normals[40][2] += 2e-5,
        |scene| scene.meshes[0].normals[40][2] *= -1.0,
        |scene| scene.meshes[0].faces.swap(0, 1),
        |scene| scene.meshes[0].faces[3].swap(1, 2),
        |scene| scene.meshes[0].bones[1].name.push('x'),
        |scene| scene.meshes[0].bones[1].offset[3] -= 2e-5,
        |scene| scene.meshes[0].bones[1].weights[4].0 += 1,
        |scene| scene.meshes[0].bones[1].weights.truncate(11),
        |scene| scene.materials[0].two_sided = false,
        |scene| scene.animations.truncate(0),
        |scene| scene.animations[0].name.push('x'),
        |scene| scene.animations[0].duration += 1.0,
        |scene| scene.animations[0].ticks_per_second *= 1.0001,
        |scene| scene.animations[0].channels[1].node.push('x'),
        |scene| scene.animations[0].channels.truncate(1),
        |scene| scene.animations[0].channels[0].positions[1].value[1] += 2e-5,
        |scene| scene.animations[0].channels[0].positions.truncate(1),
        |scene| scene.animations[0].channels[1].positions[0].value[2] = f64::NAN,
        |scene| scene.animations[0].channels[1].rotations[0].tick = 0.5,
        |scene| scene.animations[0].channels[1].rotations[1].value.swap(1, 2),
        |scene| {
            let rotation = &mut scene.animations[0].channels[1].rotations[1].value;
            rotation.iter_mut().for_each(|part| *part = -*part);
        },
        |scene| scene.animations[0].channels[1].scalings[0].value[0] = 2.0,
    ];
    for (index, change) in changes.iter().enumerate() {
        let found = explanations(RAW, change);
        assert!(!found.is_empty(), "change {index} is not found");
        assert!(
            found.iter().all(Option::is_none),
            "change {index} is explained: {found:?}"
        );
    }
}

#[test]
fn the_tolerance_is_one_in_a_hundred_thousand() {
    let moved = |by: f64| explanations(RAW, |scene| scene.meshes[0].vertices[5][1] += by).len();
    assert_eq!((moved(0.9e-5), moved(1.1e-5)), (0, 1));
}

#[test]
fn rotations_farther_from_double_precision_than_assimps_are_unexplained() {
    let turned = |by: f64| explanations(RAW, |scene| scene.animations[0].channels[1].rotations[1].value[0] += by);
    assert_eq!(turned(1e-9), []);
    assert_eq!(turned(5e-6), [None]);
}

#[test]
fn unit_normals_are_explained_where_they_only_change_length() {
    let normals = |scene: &mut Scene| scene.meshes[0].normals.iter_mut().for_each(|normal| unit(normal));
    assert_eq!(explanations(RAW, normals), [Some("normal-not-unit"); 48]);
    // Debone does not change the root's mesh, because the root is near the origin.
    assert_eq!(explanations(PROCESSED, normals), [Some("normal-not-unit"); 12]);
    let turned = |scene: &mut Scene| {
        normals(scene);
        scene.meshes[0].normals[0].swap(0, 1);
    };
    assert_eq!(
        explanations(PROCESSED, turned)
            .iter()
            .filter(|reason| reason.is_none())
            .count(),
        1
    );
}

#[test]
fn a_mesh_near_the_origin_may_stand_in_its_nodes_space_and_nowhere_else() {
    let moved = |by: f64| {
        move |scene: &mut Scene| {
            for vertex in &mut scene.meshes[0].vertices {
                vertex
                    .iter_mut()
                    .zip(ROOT_OFFSET)
                    .for_each(|(part, offset)| *part -= offset * by);
            }
        }
    };
    assert_eq!(
        explanations(PROCESSED, moved(1.0)),
        [Some("near-origin-untransformed"); 12]
    );
    assert_eq!(explanations(PROCESSED, moved(0.9)), [None; 12]);
}

#[test]
fn the_root_offset_may_be_added_where_the_first_position_is_zero() {
    let added = |assimp: Scene, bvh: &str| {
        let mut ours = assimp.clone();
        for key in &mut ours.animations[0].channels[0].positions {
            key.value
                .iter_mut()
                .zip(ROOT_OFFSET)
                .for_each(|(part, offset)| *part += offset);
        }
        let report = report(bvh, false, assimp, ours);
        report
            .findings
            .iter()
            .map(|finding| finding.explanation)
            .collect::<Vec<_>>()
    };
    assert_eq!(added(assimp(RAW), PROBE), [None, None]);
    let mut starts_at_zero = assimp(RAW);
    let positions = &mut starts_at_zero.animations[0].channels[0].positions;
    positions[0].value = vec![0.0; 3];
    positions[1].value = vec![0.0, 0.001, 0.0];
    let relative = PROBE
        .replace("0.2 0.9 0.1 5", "0 0 0 5")
        .replace("0.3 0.9 0.1 6", "0 0.001 0 6");
    assert_eq!(added(starts_at_zero, &relative), [Some("root-offset-added"); 2]);
}

#[test]
fn dropped_positions_are_explained_where_ours_are_the_files() {
    // Five channels: Assimp gives one key at the OFFSET.
    let five = PROBE
        .replace("CHANNELS 6", "CHANNELS 5")
        .replacen(" Yrotation", "", 1)
        .replace("10 15 20", "10 20")
        .replace("11 16 21", "11 21");
    let mut assimps = assimp(RAW);
    let mut ours = assimp(RAW);
    for scene in [&mut assimps, &mut ours] {
        // Their rotations come from six channels; omit them on both sides.
        scene.animations[0]
            .channels
            .iter_mut()
            .for_each(|channel| channel.rotations.clear());
    }
    let keys = &mut assimps.animations[0].channels[0].positions;
    keys.truncate(1);
    keys[0].value = ROOT_OFFSET.to_vec();
    let explanations = |ours: Scene| {
        let report = report(&five, false, assimps.clone(), ours);
        report
            .findings
            .iter()
            .map(|finding| finding.explanation)
            .collect::<Vec<_>>()
    };
    assert_eq!(explanations(ours.clone()), [Some("position-channels-dropped"); 2]);
    assert_eq!(ours.animations[0].channels[0].keys(Track::Position).len(), 2);
    ours.animations[0].channels[0].positions[0].value[1] += 0.01;
    assert_eq!(explanations(ours), [Some("position-channels-dropped"), None]);
}

#[test]
fn a_refusal_is_explained_by_its_own_reason_alone() {
    let refused = |message: &str, bvh: &str| {
        let mut report = Report::default();
        let refusal = Err(message.to_owned());
        report.answers(&Source::new(bvh.as_bytes()), true, &refusal, &Ok(Scene::default()));
        report.findings[0].explanation
    };
    let message = "Validation failed: aiMesh::mBones[1], name = \"Spine\" has the same name as aiMesh::mBones[0]";
    assert_eq!(
        refused(message, &PROBE.replace("Hips", "Spine")),
        Some("duplicate-names")
    );
    assert_eq!(refused(message, PROBE), None);
    assert_eq!(refused("out of memory", &PROBE.replace("Hips", "Spine")), None);
}
