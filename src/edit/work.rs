//! The data that the parts of a cleaning share.

use glam::{DVec3, Mat4, Vec3};
use mocap_figure::{Figure, Humanoid};
use mocap_scene::error::Result;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Scene};

use crate::StepInput;
use crate::body::and_below;
use crate::clean_weights::CleanWeights;
use crate::frames::Frames;

/// The frames that the cleaning changes, and facts about the body.
#[derive(Clone)]
pub(super) struct Work<'a> {
    pub(super) scene: &'a Scene,
    pub(super) frames: Frames<'a>,
    pub(super) figure: &'a Figure,
    /// For each frame, whether its values were interpolated, because the source did not measure them. Empty if there is
    /// no such frame.
    pub(super) missing: Vec<bool>,
    /// The axis of a camera along which the body jittered; `None` if no such axis was found.
    pub(super) depth: Option<DVec3>,
    /// The metres in one unit of the scene.
    pub(super) metres: f32,
    pub(super) up: Vec3,
    pub(super) weights: CleanWeights,
    /// For each node, the distance of the farthest node below it in the rest pose, in metres.
    reach: &'a [f32],
}

impl<'a> Work<'a> {
    pub(super) fn new(scene: &'a Scene, figure: &'a Figure, reach: &'a [f32], animation: usize) -> Result<Self> {
        Ok(Self {
            scene,
            frames: Frames::reading(scene, animation, &[])?,
            figure,
            missing: Vec::new(),
            depth: None,
            metres: figure.metres(),
            up: figure.up_direction(),
            weights: CleanWeights::default(),
            reach,
        })
    }

    /// The figure of a scene, whether it is a humanoid or not.
    pub(super) fn figure(scene: &Scene, input: &StepInput<'_>) -> Figure {
        let bones = input.bones().cloned().unwrap_or_else(|| Humanoid::of(scene));
        Figure::with_bones(scene, bones)
    }

    /// For each node, the distance of the farthest node below it in the rest pose, in metres.
    pub(super) fn reaches(scene: &Scene, figure: &Figure) -> Vec<f32> {
        let rest = Pose::rest(scene);
        let reach = |node: NodeId| {
            let distance = |below: NodeId| rest.position(below).distance(rest.position(node));
            and_below(scene, node).map(distance).fold(0.0, f32::max) * figure.metres()
        };
        (0..scene.nodes.len()).map(|node| reach(NodeId::new(node))).collect()
    }

    pub(super) fn reach(&self, node: NodeId) -> f32 {
        self.reach[node.index()]
    }

    /// Whether the skeleton is a humanoid.
    pub(super) fn is_humanoid(&self) -> bool {
        self.figure.humanoid.found
    }

    /// The length of a leg in the rest pose, from the hip to the ankle, in metres.
    pub(super) fn leg(&self) -> Option<f32> {
        let rest = Pose::rest(self.scene);
        let position_of = |bone: Bone| Some(rest.position(self.figure.humanoid.joint(bone)?));
        let knee = position_of(Bone::LeftLowerLeg)?;
        let length = knee.distance(position_of(Bone::LeftUpperLeg)?) + knee.distance(position_of(Bone::LeftFoot)?);
        Some(length * self.metres)
    }

    /// The index of the node that carries the whole body. It is the topmost moving node among the hips and the nodes
    /// above them.
    pub(super) fn carrier(&self) -> Option<usize> {
        let hips = self.figure.humanoid.joint(Bone::Hips)?;
        let above = |node: &NodeId| self.scene.nodes[node.index()].parent;
        let chain = std::iter::successors(Some(hips), above);
        let column = |node: NodeId| self.frames.nodes().binary_search(&node).ok();
        chain.filter_map(column).last()
    }

    /// Whether all scales are 1, so that no node is scaled.
    pub(super) fn has_no_scale(&self) -> bool {
        let rest = Pose::rest(self.scene);
        let is_one = |scale: Vec3| scale.abs_diff_eq(Vec3::ONE, 1e-3);
        (0..self.frames.len().min(1)).all(|frame| self.frames.row(frame).iter().all(|trs| is_one(trs.scale)))
            && rest
                .node_to_parent
                .iter()
                .all(|matrix| is_one(Trs::from_matrix(*matrix).scale))
    }

    /// Moves the whole body in each frame by `motion`, which gives a rigid motion of the world for this frame.
    pub(super) fn carry(&mut self, column: usize, motion: impl Fn(usize) -> Mat4) {
        let node = self.frames.nodes()[column];
        let rest = Pose::rest(self.scene);
        let parent = self.scene.nodes[node.index()].parent;
        let parent = parent.map_or(Mat4::IDENTITY, |parent| rest.node_to_world[parent.index()]);
        let inverse = parent.inverse();
        let mut track = self.frames.track(column);
        for (frame, trs) in track.iter_mut().enumerate() {
            let moved = Trs::from_matrix(inverse * motion(frame) * parent * trs.matrix());
            trs.translation = moved.translation;
            trs.rotation = mocap_scene::math::quaternion::in_hemisphere_of(trs.rotation, moved.rotation);
        }
        self.frames.set_track(column, &track);
    }
}
