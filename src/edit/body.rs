//! What a step knows of the figure: its bones, its up axis and its size.

use glam::Vec3;

use crate::error::{Code, Diagnostic, Result};
use crate::figure::contacts;
use crate::figure::{Figure, Humanoid, HumanoidBone, Side, humanoid};
use crate::scene::{NodeId, NodeKind, Scene};

/// The figure of a scene.
pub(super) struct Body {
    pub(super) humanoid: Humanoid,
    /// The direction that is up in the world.
    pub(super) up: Vec3,
    /// Metres in one unit of the scene.
    pub(super) metres: f32,
}

/// The joints of a leg.
pub(super) struct Leg {
    pub(super) thigh: NodeId,
    pub(super) knee: NodeId,
    pub(super) ankle: NodeId,
}

impl Body {
    /// Finds the bones, unless `known` has them.
    pub(super) fn new(scene: &Scene, known: Option<&Humanoid>) -> Result<Self> {
        let humanoid = known.cloned().unwrap_or_else(|| humanoid(scene));
        if !humanoid.found {
            let message = format!("the skeleton is not a humanoid: {}", humanoid.reason);
            return Err(Diagnostic::new(Code::NotHumanoid, message).into());
        }
        let figure = Figure::with_bones(scene, humanoid);
        Ok(Self {
            up: figure.up.value.direction().unwrap_or(Vec3::Y),
            metres: figure.survey.metres_per_unit as f32,
            humanoid: figure.humanoid,
        })
    }

    pub(super) fn leg(&self, side: Side) -> Option<Leg> {
        let joint = |bone: HumanoidBone| self.humanoid.joint(bone.on(side));
        Some(Leg {
            thigh: joint(HumanoidBone::LeftUpperLeg)?,
            knee: joint(HumanoidBone::LeftLowerLeg)?,
            ankle: joint(HumanoidBone::LeftFoot)?,
        })
    }

    /// The node at the ball of the foot.
    pub(super) fn toes(&self, scene: &Scene, side: Side) -> Option<NodeId> {
        contacts::ball(scene, &self.humanoid, side)
    }
}

/// Metres in one unit of the scene.
pub(super) fn metres_per_unit(scene: &Scene) -> f32 {
    let stated = scene.metadata.metres_per_unit;
    stated.unwrap_or_else(|| Figure::new(scene).survey.metres_per_unit) as f32
}

/// `node` and all nodes below it.
pub(super) fn and_below(scene: &Scene, node: NodeId) -> impl Iterator<Item = NodeId> {
    let below = move |index: &usize| scene.nodes[*index].parent.is_some_and(|parent| parent >= node);
    std::iter::once(node).chain((node.index() + 1..scene.nodes.len()).take_while(below).map(NodeId::new))
}

/// The node whose translation moves the whole figure: `hips`, or the nearest above it with a moving position; else the
/// topmost joint.
pub(super) fn mover(scene: &Scene, hips: NodeId, moves: impl Fn(NodeId) -> bool) -> NodeId {
    let above = |node: &NodeId| scene.nodes[node.index()].parent;
    let mut chain =
        std::iter::successors(Some(hips), above).filter(|node| scene.nodes[node.index()].kind == NodeKind::Joint);
    let all: Vec<NodeId> = chain.by_ref().collect();
    let moving = all.iter().copied().find(|node| moves(*node));
    moving.or(all.last().copied()).unwrap_or(hips)
}
