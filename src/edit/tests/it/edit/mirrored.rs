//! Tests of mirroring.

use mocap::edit::{Mirror, Step, StepInput};
use mocap::figure::{Humanoid, HumanoidBone, Side};
use mocap::glam::DMat3;
use mocap::scene::{Keys, Mesh, MorphTarget};

use super::*;

/// Skeletons with different names, rest poses and offsets on both sides.
const CLIPS: [&str; 8] = [
    "cmu_12_01_walk.bvh",
    "motionbuilder_vicon_walk.bvh",
    "cmu_salsa_poser_names.bvh",
    "mocopi_jump_six_channels.bvh",
    "rokoko_dance.bvh",
    "perception_neuron_moving_positions.bvh",
    "kinect_openni.bvh",
    "run.fbx",
];

fn largest_distance(a: &[Vec<DVec3>], b: &[Vec<DVec3>]) -> f64 {
    let all = a.iter().flatten().zip(b.iter().flatten());
    all.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

#[test]
fn twice_is_the_identity_and_once_keeps_the_bones() {
    for file in CLIPS {
        let before = import(file);
        let mut scene = before.clone();
        let report = Mirror::new().apply(&mut scene, &StepInput::new()).unwrap();
        assert_bones_keep_their_lengths(&before, &scene);
        assert_eq!(scene.validate(), [], "{file}");
        assert!(
            report.pairs >= 8 && report.without_partner.is_empty(),
            "{file}: {report:?}"
        );
        Mirror::new().apply(&mut scene, &StepInput::new()).unwrap();
        let off = largest_distance(&exact_positions(&before), &exact_positions(&scene));
        assert!(off < 1e-6, "{file}: {off}");
    }
}

/// In a mirrored motion, two joints have the distance that their opposite joints have in the source. The signed volume
/// between hips, head, hand and foot changes its sign.
#[test]
fn each_side_does_what_the_other_did() {
    use HumanoidBone::*;
    // The left and right sides of this skeleton are equal within a micrometre. The sides of CMU's skeletons differ
    // more.
    let scene = import("motionbuilder_vicon_walk.bvh");
    let mut other = scene.clone();
    Mirror::new().apply(&mut other, &StepInput::new()).unwrap();
    let found = Humanoid::of(&scene);
    let node = |bone: HumanoidBone| found.joint(bone).unwrap().index();
    let (before, after) = (positions(&scene), positions(&other));
    for (old, new) in before.iter().zip(&after) {
        for (a, b) in [
            (LeftHand, RightFoot),
            (LeftHand, RightHand),
            (LeftFoot, RightFoot),
            (LeftHand, Head),
            (LeftLowerLeg, RightLowerArm),
        ] {
            let was = old[node(a)].distance(old[node(b)]);
            let is = new[node(a.mirrored())].distance(new[node(b.mirrored())]);
            assert!((was - is).abs() < 1e-5, "{a:?} {b:?}: {was} {is}");
        }
        let volume = |at: &[Vec3], mirrored: bool| {
            let [a, b, c, d] =
                [Hips, Head, LeftHand, LeftFoot].map(|bone| at[node(if mirrored { bone.mirrored() } else { bone })]);
            (b - a).cross(c - a).dot(d - a)
        };
        assert!((volume(old, false) + volume(new, true)).abs() < 1e-5);
    }
}

#[test]
fn a_walk_goes_on_the_same_way() {
    let scene = import("cmu_12_01_walk.bvh");
    let mut other = scene.clone();
    Mirror::new().apply(&mut other, &StepInput::new()).unwrap();
    let hips = Humanoid::of(&scene).joint(HumanoidBone::Hips).unwrap().index();
    let (before, after) = (positions(&scene), positions(&other));
    assert!(before[0][hips].distance(after[0][hips]) < 1e-6);
    let way = |at: &[Vec<Vec3>]| (at[200][hips] - at[0][hips]).normalize();
    assert!(way(&before).dot(way(&after)) > 0.95, "{} {}", way(&before), way(&after));
}

/// The distances between all bones of a figure and of its mirror image differ by no more than its sides differ.
/// Rokoko's hands are rotated by half a turn relative to each other. The run's rest pose has one leg ahead, and its
/// legs are attached to the spine off-centre, by 2.4 cm.
#[test]
fn sides_may_be_turned_and_bent_differently_at_rest() {
    for (file, most) in [
        ("rokoko_dance.bvh", 1e-5),
        ("run.fbx", 0.05),
        ("perception_neuron_moving_positions.bvh", 1e-5),
    ] {
        let scene = import(file);
        let mut other = scene.clone();
        let report = Mirror::new().apply(&mut other, &StepInput::new()).unwrap();
        assert!(report.largest_asymmetry < 0.5 * most, "{file}: {report:?}");
        let bones = Humanoid::of(&scene).bones;
        let (before, after) = (exact_positions(&scene), exact_positions(&other));
        for (old, new) in before.iter().zip(&after).step_by(10) {
            for (a, joint_a) in &bones {
                for (b, joint_b) in &bones {
                    let was = old[joint_a.joint.index()].distance(old[joint_b.joint.index()]);
                    let [a, b] = [a, b].map(|bone| new[bones[&bone.mirrored()].joint.index()]);
                    assert!(
                        (was - a.distance(b)).abs() < f64::from(most),
                        "{file}: {was} {}",
                        a.distance(b)
                    );
                }
            }
        }
    }
}

/// Positions do not show the roll of a bone. The offsets show it, and so does the mean posture of the files, as NumPy
/// computes it: the frames of both sides are reflections along an axis.
#[test]
fn each_bone_is_turned_about_itself_as_its_partner_was() {
    use HumanoidBone::*;
    let (x, z) = ([-1.0, 1.0, 1.0], [1.0, 1.0, -1.0]);
    let arm = [[LeftUpperArm, LeftLowerArm], [LeftLowerArm, LeftHand]];
    let leg = [[LeftUpperLeg, LeftLowerLeg], [LeftLowerLeg, LeftFoot]];
    // The two sides of the last body differ, so the directions of its bones may differ by this number of degrees.
    for (file, arms, legs, degrees) in [
        ("real/motionbuilder_vicon_walk.bvh", x, x, 0.1),
        ("real/cmu_12_01_walk.bvh", x, x, 0.1),
        ("skeletons/vicon_sword_attack.bvh", z, z, 0.1),
        ("skeletons/accad_run_turn.bvh", z, x, 4.0),
    ] {
        let scene = mocap::import(format!("../../fixtures/{file}")).unwrap();
        let mut other = scene.clone();
        Mirror::new().apply(&mut other, &StepInput::new()).unwrap();
        let found = Humanoid::of(&scene);
        let last = scene.animations[0].duration;
        for tick in [1.0, (last / 2.0).floor(), last] {
            let [before, after] = [&scene, &other].map(|scene| Pose::at_tick(scene, 0, tick).unwrap());
            let rotation = |pose: &Pose, [upper, lower]: [HumanoidBone; 2]| {
                let to_world = |bone| pose.node_to_world[found.joint(bone).unwrap().index()].as_dmat4();
                DMat3::from_mat4(to_world(upper)).transpose() * DMat3::from_mat4(to_world(lower))
            };
            let limbs = arm
                .map(|bones| (bones, arms))
                .into_iter()
                .chain(leg.map(|bones| (bones, legs)));
            for ((bones, signs), side) in limbs.flat_map(|limb| Side::ALL.map(|side| (limb, side))) {
                let bones = bones.map(|bone| bone.on(side));
                let reflection = DMat3::from_diagonal(DVec3::from_array(signs));
                let wanted = reflection * rotation(&before, bones.map(HumanoidBone::mirrored)) * reflection;
                let off = rotation(&after, bones).transpose() * wanted;
                let cosine = (off.x_axis.x + off.y_axis.y + off.z_axis.z - 1.0) / 2.0;
                let angle = cosine.clamp(-1.0, 1.0).acos().to_degrees();
                assert!(angle < degrees, "{file} {bones:?} at {tick}: {angle} degrees");
            }
        }
    }
}

/// The morph targets of a mesh exchange their keys with the targets of the other side. A target without keys gives the
/// weight that it has at rest.
#[test]
fn morph_targets_change_sides() {
    let target = |name: &str, weight: f32, keys: Option<[f32; 2]>| MorphTarget {
        name: name.to_owned(),
        weight,
        weight_keys: keys
            .map(|[a, b]| Keys::at_ticks(vec![a, b], vec![0.0, 100.0]))
            .into_iter()
            .collect(),
        ..MorphTarget::default()
    };
    let mut scene = import("cmu_12_01_walk.bvh");
    scene.meshes.push(Mesh {
        morph_targets: vec![
            target("eyeBlinkLeft", 0.0, Some([0.0, 1.0])),
            target("jawOpen", 0.0, Some([0.25, 0.5])),
            target("eyeBlinkRight", 0.0, Some([0.75, 0.5])),
            target("mouthSmile_R", 0.125, None),
            target("mouthSmile_L", 0.0, Some([0.0, 0.375])),
            target("左眉上", 0.0, None),
            target("右眉上", 0.0, None),
        ],
        ..Mesh::default()
    });
    let report = Mirror::new().apply(&mut scene, &StepInput::new()).unwrap();
    assert_eq!(report.morph_pairs, 3);
    let keys = |index: usize| {
        let keys = scene.meshes.last().unwrap().morph_targets[index].weight_keys.first();
        keys.map(|keys| keys.values.clone()).unwrap_or_default()
    };
    assert_eq!(
        (keys(0), keys(2), keys(1)),
        (vec![0.75, 0.5], vec![0.0, 1.0], vec![0.25, 0.5])
    );
    assert_eq!((keys(3), keys(4)), (vec![0.0, 0.375], vec![0.125]));
    assert!(keys(5).is_empty() && keys(6).is_empty());
}
