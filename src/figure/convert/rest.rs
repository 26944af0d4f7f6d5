//! Sets the T-pose or the A-pose as the rest pose, and inserts the T-pose before the motion.

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::Pose;
use mocap_scene::process;
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::{AppliedStep, StepRecord};

use super::{Conversion, RestPoseSource};
use crate::{Figure, TPose};

/// The angle of the arms of an A-pose below horizontal, in degrees. MakeHuman, Unreal and Mixamo use 40 to 55 degrees.
const A_POSE: f32 = 45.0;

impl Conversion {
    /// Whether to insert the T-pose before the first frame, for programs that read BVH. The T-pose stands on the floor
    /// of the motion, at the point over which the motion begins.
    ///
    /// Default: `false`. With `true`, the frame numbers of the motion are one higher. The T-pose is inferred from the
    /// kept frames, at their rate.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    /// use mocap::convert::RestPoseSource;
    ///
    /// let mut scene = mocap::import("fixtures/real/rokoko_dance.bvh")?;
    /// let frames = scene.animations[0].frame_count();
    /// Conversion::new().rest(RestPoseSource::TPose).t_pose_first(true).apply(&mut scene)?;
    /// assert_eq!(scene.animations[0].frame_count(), frames + 1);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn t_pose_first(mut self, t_pose_first: bool) -> Self {
        self.t_pose_first = t_pose_first;
        self
    }

    /// The requested standing rest pose; `None` if none is requested.
    pub(super) fn standing(&self, scene: &Scene, figure: &Figure) -> Result<Option<Pose>> {
        let pose = |t_pose: &TPose| match self.rest {
            RestPoseSource::APose => Some(t_pose.with_lowered_arms(scene, A_POSE)),
            RestPoseSource::TPose => Some(t_pose.pose.clone()),
            RestPoseSource::InFile | RestPoseSource::Frame(_) => None,
        };
        let is_asked_for = matches!(self.rest, RestPoseSource::TPose | RestPoseSource::APose);
        if !(is_asked_for || self.t_pose_first) {
            return Ok(None);
        }
        let t_pose = figure.t_pose(scene).ok_or_else(|| {
            let message = format!("there is no T-pose: {}", figure.humanoid.reason);
            Diagnostic::new(Code::NotHumanoid, message)
                .help("name the bones of the skeleton in a {map}, or take the pose of a frame: {rest} frame:N")
        })?;
        if is_asked_for {
            process::can_zero_rest_rotations(scene)?;
        }
        Ok(pose(t_pose).map(|pose| t_pose.at_rest(scene, pose)))
    }

    /// Records the rest pose, for steps that depend on it.
    pub(super) fn record_rest(&self, scene: &mut Scene) {
        scene.metadata.steps.push(AppliedStep::Edit {
            edit: StepRecord(serde_json::json!({ "step": "rest", "pose": self.rest })),
            with: None,
            bones: self.bones.bones.clone(),
        });
    }

    /// Inserts the T-pose before the motion, and sets a standing pose as the rest pose.
    pub(super) fn stand(&self, scene: &mut Scene, mut standing: Option<Pose>, figure: &Figure) -> Result<()> {
        if self.t_pose_first {
            // A reader can infer the same T-pose from the written frames.
            let figure = Figure::with_bones(scene, figure.humanoid.clone());
            standing = self.standing(scene, &figure)?;
            for animation in 0..scene.animations.len() {
                let first = figure
                    .t_pose(scene)
                    .map(|t_pose| t_pose.on_floor(scene, &figure, animation));
                if let Some(first) = first {
                    process::put_first(scene, animation, &first);
                }
            }
            scene.metadata.steps.push(AppliedStep::Edit {
                edit: StepRecord(serde_json::json!({ "step": "t-pose-first" })),
                with: None,
                bones: self.bones.bones.clone(),
            });
        }
        if self.t_pose_first && standing.is_some() {
            self.record_rest(scene);
        }
        if let Some(standing) = standing {
            process::set_rest_pose(scene, &standing);
        }
        Ok(())
    }
}
