//! The chain of joints that a step moves to a target. The chain is a limb of a humanoid, or a chain that the user names
//! by its first joint.

use std::collections::BTreeMap;
use std::iter::successors;

use glam::Vec3;
use mocap_figure::HumanoidBone;
use mocap_figure::names::node_named;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::ik::{ChainOptions, Goal};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene};

use super::StepInput;
use super::body::{and_below, any_figure_of, body_of};
use super::frames::Frames;
use super::limb::{Limb, LimbChain};
use super::target::{ReachTarget, TargetJoint, is_below};

/// The joints that rotate, and the tip that moves to the target.
pub(super) struct Chain {
    /// The joints that rotate, the topmost first. In a chain that is no limb, the last joint is the tip, which does not
    /// rotate.
    pub(super) joints: Vec<NodeId>,
    pub(super) tip: NodeId,
    pub(super) metres_per_unit: f64,
    /// The limb of a humanoid, which bends at its elbow or knee. `None` if the user named the chain by its first joint.
    pub(super) limb: Option<LimbChain>,
    bones: BTreeMap<HumanoidBone, NodeId>,
}

impl Chain {
    /// The chain from the joint `start` to the joint `tip`. Without `start`, the chain is `limb`, and `tip` is the
    /// wrist, the ankle or a joint below.
    pub(super) fn new(
        scene: &Scene,
        input: &StepInput<'_>,
        limb: Limb,
        [start, tip]: [Option<&str>; 2],
    ) -> Result<Self> {
        let Some(start) = start else {
            let body = body_of(scene, input.bones()).map_err(|error| {
                let mut diagnostic = error.diagnostic().clone();
                let help =
                    "without a humanoid, `start=JOINT` names the first joint of the chain that moves to the target";
                diagnostic.help.get_or_insert_with(|| help.to_owned());
                diagnostic
            })?;
            let limb = LimbChain::new(scene, &body, limb, tip)?;
            return Ok(Self {
                joints: limb.joints().to_vec(),
                tip: limb.tip,
                metres_per_unit: body.metres_per_unit,
                limb: Some(limb),
                bones: body.bones,
            });
        };
        if limb != Limb::default() {
            return refused(
                "start names a chain of joints, and limb names a limb of a humanoid: give only one of them",
            );
        }
        let figure = any_figure_of(scene, input);
        let bones = figure.humanoid.bones.iter().map(|(bone, found)| (*bone, found.joint));
        let bones: BTreeMap<HumanoidBone, NodeId> = bones.collect();
        let node = |name: &str| node_named(scene, name, |bone| bones.get(&bone).copied());
        let start = node(start)?;
        let tip = match tip {
            Some(tip) => node(tip)?,
            None => only_end(scene, start)?,
        };
        if !is_below(scene, tip, start) {
            let [start, tip] = [start, tip].map(|node| &scene.nodes[node.index()].name);
            return refused(format!("tip must be a joint below {start:?}, got {tip:?}"));
        }
        let above = |node: &NodeId| scene.nodes[node.index()].parent.filter(|_| *node != start);
        let mut joints: Vec<NodeId> = successors(Some(tip), above).collect();
        joints.reverse();
        Ok(Self {
            joints,
            tip,
            metres_per_unit: figure.survey.metres_per_unit,
            limb: None,
            bones,
        })
    }

    /// Finds the joint of the target. Refuses a joint that moves with the chain.
    pub(super) fn find(&self, scene: &Scene, target: &ReachTarget) -> Result<TargetJoint> {
        let bone = |bone| self.bones.get(&bone).copied();
        target.find(scene, bone, self.metres_per_unit, &self.joints[..1])
    }

    /// Sets the hinge axis of a limb to the mean axis about which the limb bends in `frames`.
    pub(super) fn see_hinge(&mut self, scene: &Scene, frames: &Frames) {
        if let Some(limb) = &mut self.limb {
            limb.see_hinge(scene, frames);
        }
    }

    /// The centre and the radius of a ball that contains all points that the tip can reach in a pose. The tip may be
    /// unable to reach points near the centre.
    pub(super) fn reach(&self, pose: &Pose) -> (Vec3, f32) {
        match &self.limb {
            Some(limb) => limb.reach(pose),
            None => {
                let lengths = self.joints.windows(2);
                let lengths = lengths.map(|pair| pose.position(pair[0]).distance(pose.position(pair[1])));
                (pose.position(self.joints[0]), lengths.sum())
            }
        }
    }

    /// Rotates the joints of a chain that is no limb, so that its tip comes to `goal`. Returns the remaining distance,
    /// in units of the scene.
    pub(super) fn bend(&self, pose: &mut Pose, goal: Vec3) -> f32 {
        /// The distance from the goal at which the solver stops, in metres.
        const TOLERANCE: f64 = 1e-5;
        let options = ChainOptions::new().tolerance((TOLERANCE / self.metres_per_unit) as f32);
        pose.bend_chain(&self.joints, &Goal::at(goal), &options)
    }
}

/// The end effector below the joint `start`. Fails unless exactly one end effector is below.
fn only_end(scene: &Scene, start: NodeId) -> Result<NodeId> {
    let last = and_below(scene, start).last().unwrap_or(start);
    let ends: Vec<NodeId> = scene
        .end_effectors()
        .filter(|end| start < *end && *end <= last)
        .collect();
    let name = |node: &NodeId| format!("{:?}", scene.nodes[node.index()].name);
    match ends[..] {
        [end] => Ok(end),
        [] => refused(format!(
            "a chain cannot start at {}: no joint is below it",
            name(&start)
        )),
        _ => {
            let some = ends.iter().take(5).map(name).collect::<Vec<_>>().join(", ");
            let count = ends.len();
            refused(format!(
                "{count} chains begin at {}: name the tip of the chain to move, such as {some}",
                name(&start)
            ))
        }
    }
}

fn refused<T>(message: impl Into<String>) -> Result<T> {
    Err(Diagnostic::new(Code::InvalidValue, message).into())
}
