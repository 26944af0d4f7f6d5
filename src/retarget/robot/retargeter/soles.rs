//! The positions of the twin's soles, and the lowering of the robot for them.

use glam::DVec3;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, Scene};

use super::super::floor::{Floor, drops};
use super::super::following::lowest;
use super::super::motion::RobotMotion;
use super::{RobotRetargeter, feet_at_rest};

impl RobotRetargeter {
    /// The points of both soles of the twin in each frame.
    pub(super) fn sole_points(&mut self, held: &Animation, frames: usize) -> Vec<[Vec<DVec3>; 2]> {
        let binding = Binding::new(&self.twin.scene, held);
        let mut twin = Pose::rest(&self.twin.scene);
        let points = (0..frames).map(|frame| {
            twin.sample(&binding, held, frame as f64);
            self.following.aim(&twin, 0.0);
            self.following.sole_points()
        });
        points.collect()
    }

    /// The lowering of the robot in each frame, for the floor of the options.
    pub(super) fn drops(&self, soles: &[[Vec<DVec3>; 2]], fps: f64, contacts: &[[bool; 2]]) -> Vec<f64> {
        match self.options.floor {
            Floor::Auto if self.options.lock_feet => {
                let heights = |soles: &[Vec<DVec3>; 2]| soles.each_ref().map(|sole| lowest(sole));
                let heights: Vec<[f64; 2]> = soles.iter().map(heights).collect();
                drops(&heights, contacts, fps)
            }
            Floor::Zero => vec![-self.retargeter.source_floor(); contacts.len()],
            _ => vec![0.0; contacts.len()],
        }
    }

    /// The smooth raise of the robot in each frame, so that no sole and no link is below the floor.
    pub(in super::super) fn raised(&self, motion: &RobotMotion) -> Vec<f64> {
        match self.options.floor {
            Floor::Keep => vec![0.0; motion.frames()],
            _ => self.measured(motion).raised(&self.collisions),
        }
    }

    pub(super) fn contacts_of(&self, source: &Scene, animation: &Animation) -> Vec<[bool; 2]> {
        let frames = animation.frame_count();
        let Ok(found) = self.retargeter.contacts(source, animation) else {
            return vec![[false; 2]; frames];
        };
        feet_at_rest(&found, frames)
    }
}
