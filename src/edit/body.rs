//! What a step needs to know of the figure: its bones, its knees, its size, and the node that moves it.

use glam::Vec3;
use mocap_figure::body::Body;
use mocap_figure::report::Quadruped;
use mocap_figure::{Creature, Figure, Humanoid, HumanoidBone, Side};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::directions::rotation_of;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, NodeKind, Scene};

use super::StepInput;

/// The joints of a leg.
pub(super) struct Leg {
    pub(super) thigh: NodeId,
    pub(super) knee: NodeId,
    pub(super) ankle: NodeId,
}

/// The figure of a scene. Fails if the figure is no humanoid. The bones come from `known`; without `known`, mocap finds
/// them.
pub(super) fn figure_of(scene: &Scene, known: Option<&Humanoid>) -> Result<Figure> {
    let humanoid = known.cloned().unwrap_or_else(|| Humanoid::of(scene));
    if !humanoid.found {
        let message = format!("the skeleton is not a humanoid: {}", humanoid.reason);
        return Err(Diagnostic::new(Code::NotHumanoid, message).into());
    }
    Ok(Figure::with_bones(scene, humanoid))
}

/// The figure of a scene and the joints of its body parts, if the figure is an animal on four legs.
pub(super) fn animal_of(scene: &Scene, known: Option<&Humanoid>) -> Option<(Figure, Quadruped)> {
    let humanoid = known.cloned().unwrap_or_else(|| Humanoid::of(scene));
    if humanoid.creature != Some(Creature::FourLegged) {
        return None;
    }
    let figure = Figure::with_bones(scene, humanoid);
    let animal = figure.quadruped(scene)?.clone();
    Some((figure, animal))
}

/// The body of a scene: its figure, and the coordinate frames of its bones in the T-pose. Fails if the figure is no
/// humanoid.
pub(super) fn body_of(scene: &Scene, known: Option<&Humanoid>) -> Result<Body> {
    Body::of_figure(scene, figure_of(scene, known)?, "figure")
}

impl Leg {
    pub(super) fn new(humanoid: &Humanoid, side: Side) -> Option<Self> {
        let joint = |bone: HumanoidBone| humanoid.joint(bone.on(side));
        Some(Self {
            thigh: joint(HumanoidBone::LeftUpperLeg)?,
            knee: joint(HumanoidBone::LeftLowerLeg)?,
            ankle: joint(HumanoidBone::LeftFoot)?,
        })
    }
}

/// The length of the hinge axis that the rest pose gives. Each frame of the motion gives an axis whose length is the
/// sine of the knee's angle. The rest pose has a shorter axis, so that it counts less than the motion.
const HINGE_AT_REST: f32 = 0.05;

/// The hinge axis of a knee according to the rest pose, in the coordinate frame of the thigh. The axis points to the
/// left of the figure. The axis is short, so it counts only if the knee hardly bends in the motion.
#[doc(hidden)]
pub fn knee_at_rest(rest: &Pose, figure: &Figure, thigh: NodeId) -> Vec3 {
    let rotation = rotation_of(&rest.node_to_world[thigh.index()]);
    HINGE_AT_REST * (rotation.inverse() * figure.figure_to_world().x_axis)
}

/// The figure of a scene. It may be a humanoid or any other skeleton.
pub(super) fn any_figure_of(scene: &Scene, input: &StepInput<'_>) -> Figure {
    let humanoid = input.bones().cloned().unwrap_or_else(|| Humanoid::of(scene));
    Figure::with_bones(scene, humanoid)
}

/// Metres in one unit of the scene.
pub(super) fn metres_per_unit(scene: &Scene, input: &StepInput<'_>) -> f32 {
    let guessed = || any_figure_of(scene, input).survey.metres_per_unit;
    scene.metadata.metres_per_unit.unwrap_or_else(guessed) as f32
}

/// `node` and all nodes below it.
pub(super) fn and_below(scene: &Scene, node: NodeId) -> impl Iterator<Item = NodeId> {
    let below = move |index: &usize| scene.nodes[*index].parent.is_some_and(|parent| parent >= node);
    std::iter::once(node).chain((node.index() + 1..scene.nodes.len()).take_while(below).map(NodeId::new))
}

/// The node whose translation moves the whole figure. This node is the first joint whose position moves, from `hips`
/// upwards. If no position moves, this node is the topmost joint.
pub(super) fn mover(scene: &Scene, hips: NodeId, moves: impl Fn(NodeId) -> bool) -> NodeId {
    let above = |node: &NodeId| scene.nodes[node.index()].parent;
    let mut chain =
        std::iter::successors(Some(hips), above).filter(|node| scene.nodes[node.index()].kind == NodeKind::Joint);
    let all: Vec<NodeId> = chain.by_ref().collect();
    let moving = all.iter().copied().find(|node| moves(*node));
    moving.or(all.last().copied()).unwrap_or(hips)
}
