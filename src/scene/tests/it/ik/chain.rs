//! Tests chains of joints that reach a goal.

use mocap::glam::{DQuat, Mat4, Quat, Vec3};
use mocap::scene::{Node, NodeId};
use mocap::{Pose, Scene, Trs};
use mocap_scene::ik::{ChainOptions, Goal, JointLimit};
use proptest::prelude::*;

fn unit() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-1f32..1.0).prop_filter_map("no direction", |toward| Vec3::from(toward).try_normalize())
}

/// A chain of 3 to 8 bones of 5 to 50 cm.
fn bones() -> impl Strategy<Value = Vec<Vec3>> {
    prop::collection::vec(
        (unit(), 0.05f32..0.5).prop_map(|(toward, length)| toward * length),
        3..8,
    )
}

fn rotation() -> impl Strategy<Value = Quat> {
    (unit(), -3f32..3.0).prop_map(|(axis, angle)| Quat::from_axis_angle(axis, angle))
}

fn pose_of(bones: &[Vec3]) -> (Pose, Vec<NodeId>) {
    let node = |(index, bone): (usize, &Vec3)| Node {
        parent: index.checked_sub(1).map(NodeId::new),
        transform: Mat4::from_translation(*bone),
        ..Node::default()
    };
    let offsets = std::iter::once(&Vec3::ZERO).chain(bones);
    let scene = Scene {
        nodes: offsets.enumerate().map(node).collect(),
        ..Scene::default()
    };
    (Pose::rest(&scene), (0..=bones.len()).map(NodeId::new).collect())
}

fn turned(bones: &[Vec3], rotations: &[Quat]) -> Pose {
    let (mut pose, _) = pose_of(bones);
    for (matrix, rotation) in pose.node_to_parent.iter_mut().zip(rotations) {
        *matrix *= Mat4::from_quat(*rotation);
    }
    pose.update_world();
    pose
}

/// The angle of a rotation. It is exact for small angles, unlike an arc cosine.
fn angle(rotation: Quat) -> f32 {
    2.0 * rotation.xyz().length().atan2(rotation.w.abs())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10_000))]

    #[test]
    fn a_goal_within_reach_is_reached(bones in bones(), rotations in prop::collection::vec(rotation(), 8)) {
        let (mut pose, nodes) = pose_of(&bones);
        let goal = turned(&bones, &rotations).position(nodes[bones.len()]);
        let distance = pose.bend_chain(&nodes, &Goal::at(goal), &ChainOptions::default());
        prop_assert!(distance < 1e-3, "{distance}");
        for (index, bone) in bones.iter().enumerate() {
            let length = pose.position(nodes[index]).distance(pose.position(nodes[index + 1]));
            prop_assert!((length - bone.length()).abs() < 1e-6);
        }
    }

}

proptest! {
    #[test]
    fn beyond_reach_the_chain_is_straight_towards_the_goal(bones in bones(), toward in unit(), beyond in 1.001f32..1e4) {
        let (mut pose, nodes) = pose_of(&bones);
        let reach: f32 = bones.iter().map(|bone| bone.length()).sum();
        pose.bend_chain(&nodes, &Goal::at(toward * (reach * beyond)), &ChainOptions::default());
        let mut length = 0.0;
        for (bone, node) in bones.iter().zip(&nodes[1..]) {
            length += bone.length();
            prop_assert!(pose.position(*node).distance(toward * length) < 1e-5);
        }
    }

    #[test]
    fn no_joint_leaves_its_limit(bones in bones(), goal in unit(), swing in 0.05f32..1.5, twist in 0.0f32..1.0) {
        let (mut pose, nodes) = pose_of(&bones);
        let cone = |bone: &Vec3| JointLimit::Cone { rest: Quat::IDENTITY, axis: *bone, swing, twist };
        let mut limits: Vec<JointLimit> = bones.iter().map(cone).collect();
        limits[1] = JointLimit::Hinge { rest: Quat::IDENTITY, axis: Vec3::X, min: -0.2, max: swing };
        let options = ChainOptions::default().limits(limits.clone());
        pose.bend_chain(&nodes, &Goal::at(goal), &options);
        for (index, bone) in bones.iter().enumerate() {
            let rotation = Trs::from_matrix(pose.node_to_parent[index]).rotation;
            if index == 1 {
                prop_assert!(rotation.y.abs() < 1e-4 && rotation.z.abs() < 1e-4);
                let by = 2.0 * rotation.x.atan2(rotation.w);
                prop_assert!((-0.201..swing + 1e-3).contains(&by), "{by}");
            } else {
                let swung = (rotation * *bone).angle_between(*bone);
                prop_assert!(swung < swing + 1e-3, "{swung} of {swing}");
                let [from, to] = [*bone, rotation * *bone].map(|bone| bone.as_dvec3().normalize());
                prop_assert!(angle(DQuat::from_rotation_arc(from, to).as_quat().inverse() * rotation) < twist + 1e-3);
            }
        }
    }

    /// A chain may stop in a pose in which the rotation of no single joint brings the end nearer. Such a pose is near
    /// the goal.
    #[test]
    fn a_goal_within_the_limits_is_approached(bones in bones(), rotations in prop::collection::vec((unit(), -0.5f32..0.5), 8)) {
        let rotations: Vec<Quat> = rotations.iter().map(|(axis, by)| Quat::from_axis_angle(*axis, *by)).collect();
        let (mut pose, nodes) = pose_of(&bones);
        let end = nodes[bones.len()];
        let goal = turned(&bones, &rotations).position(end);
        let before = pose.position(end).distance(goal);
        let limit = |bone: &Vec3| JointLimit::Cone { rest: Quat::IDENTITY, axis: *bone, swing: 0.6, twist: 0.6 };
        let options = ChainOptions::default().limits(bones.iter().map(limit).collect::<Vec<_>>());
        let distance = pose.bend_chain(&nodes, &Goal::at(goal), &options);
        prop_assert!(distance <= 1e-3 || distance < 0.5 * before, "{distance} of {before}");
    }

    #[test]
    fn no_goal_gives_a_pose_that_is_not_finite(bones in bones(), values in prop::array::uniform3(prop_oneof![
        Just(0.0f32), Just(f32::NAN), Just(f32::INFINITY), Just(f32::MAX), Just(-1e-30), -2f32..2.0,
    ])) {
        let limits = [Vec::new(), vec![JointLimit::Cone { rest: Quat::IDENTITY, axis: Vec3::ZERO, swing: 1.0, twist: 0.1 }; 3]];
        for limits in limits {
            let (mut pose, nodes) = pose_of(&bones);
            let options = ChainOptions::default().limits(limits);
            pose.bend_chain(&nodes, &Goal::at(Vec3::from(values)), &options);
            prop_assert!(pose.node_to_world.iter().all(Mat4::is_finite));
        }
    }
}

#[test]
fn a_rotation_and_half_a_weight() {
    let (mut pose, nodes) = pose_of(&[Vec3::X, Vec3::X, Vec3::X]);
    let quarter = Quat::from_rotation_y(1.0);
    let mut goal = Goal::at(Vec3::new(1.0, 1.0, 0.0)).with_rotation(quarter);
    (goal.position_weight, goal.rotation_weight) = (0.5, 0.5);
    pose.bend_chain(&nodes, &goal, &ChainOptions::default());
    assert!(pose.position(nodes[3]).distance(Vec3::new(2.0, 0.5, 0.0)) < 1e-3);
    // Half of the rotation from the chain's own rotation to the rotation of the goal.
    let mut without = pose_of(&[Vec3::X, Vec3::X, Vec3::X]).0;
    let mut position = goal;
    position.rotation = None;
    without.bend_chain(&nodes, &position, &ChainOptions::default());
    let rotation = |pose: &Pose| Trs::from_matrix(pose.node_to_world[3]).rotation;
    let (whole, half) = (
        quarter * rotation(&without).inverse(),
        rotation(&pose) * rotation(&without).inverse(),
    );
    assert!((angle(half) - 0.5 * angle(whole)).abs() < 1e-4);
}
