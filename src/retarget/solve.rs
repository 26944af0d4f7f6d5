//! Computes the pose of the target from watched joints of the source: for one pose, or for as many at once as a vector
//! has lanes.

use mocap_figure::rotations::{Points, Rotations};
use mocap_figure::watched::WatchedPose;
use mocap_scene::math::soa::single::LANES;
use mocap_scene::math::wide;

use super::plan::Plan;
use super::root::Root;
use super::rules::{BoneTwist, ParentRule};

/// The computed values of `N` poses.
#[derive(Clone, Debug)]
pub(super) struct Solved<const N: usize> {
    pub(super) seen: WatchedPose<N>,
    /// The rotations of the source's joints since the T-pose.
    frames: Vec<Rotations<N>>,
    /// The twists that several joints share.
    twisted: Vec<BoneTwist<N>>,
    /// The rotations of the driven joints, from their axes to the axes of the figure.
    turned: Vec<Rotations<N>>,
    /// The rotations of the driven joints relative to their parents.
    pub(super) to_parent: Vec<Rotations<N>>,
    /// The translation of the hips relative to their parent.
    pub(super) hips: Points<N>,
}

impl<const N: usize> Solved<N> {
    /// Allocates memory for a plan. `joints` is the number of watched joints of the source.
    pub(super) fn new(plan: &Plan, joints: usize) -> Self {
        Self {
            seen: WatchedPose::new(joints),
            frames: vec![Rotations::IDENTITY; plan.tracks.len()],
            twisted: vec![BoneTwist::default(); plan.twists.len()],
            turned: vec![Rotations::IDENTITY; plan.drives.len()],
            to_parent: vec![Rotations::IDENTITY; plan.drives.len()],
            hips: Points::ZERO,
        }
    }

    /// Computes the target from the watched joints.
    #[inline(always)]
    pub(super) fn solve(&mut self, plan: &Plan, root: &Root) {
        for (frame, track) in self.frames.iter_mut().zip(&plan.tracks) {
            *frame = track.frame(&self.seen);
        }
        for (twisted, twist) in self.twisted.iter_mut().zip(&plan.twists) {
            *twisted = twist.at(&self.frames);
        }
        for (index, drive) in plan.drives.iter().enumerate() {
            let turned = drive.frame(&self.frames, &self.twisted) * Rotations::all(drive.frame_to_joint.to_array());
            self.turned[index] = turned;
            let world_to_parent = match drive.above {
                ParentRule::Still(world_to_parent) => Rotations::all(world_to_parent.to_array()),
                ParentRule::Drive { drive, between: None } => self.turned[drive].conjugate(),
                ParentRule::Drive {
                    drive,
                    between: Some(between),
                } => Rotations::all(between.to_array()) * self.turned[drive].conjugate(),
            };
            self.to_parent[index] = (world_to_parent * turned).normalize();
        }
        if let Some(hips) = plan.hips {
            self.hips = root.hips(&self.seen, self.turned[hips]);
        }
    }
}

wide::dispatch! {
    /// Calls [`Solved::solve`] for a block of poses, compiled with AVX2 if the processor has it.
    pub(super) fn solve_block(solved: &mut Solved<LANES>, plan: &Plan, root: &Root) {
        solved.solve(plan, root);
    }
}
