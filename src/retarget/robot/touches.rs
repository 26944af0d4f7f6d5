//! Pushes links apart that penetrate each other, from round to round of a window.
//!
//! A term pushes two penetrating links apart. In the next round they no longer penetrate each other. Without the term
//! they would move back, and half of the frames would end with a penetration. So a term stays while it pushes, and is
//! removed if it would pull.

use std::collections::BTreeSet;

use super::collision::Collisions;
use super::kinematics::{Kinematics, RobotPose};
use super::terms::Terms;

/// The allowed depth of a penetration, in metres: less than half of the 10 mm that a report counts.
const TOUCHING: f64 = 0.004;

/// In the first round, a penetration counts if its depth is above [`TOUCHING`] less this length, in metres. An earlier
/// round may have pushed the links apart.
const NEAR: f64 = 0.002;

/// The separation term of two links in one frame.
#[derive(Clone, Debug)]
struct PushTerm {
    frame: usize,
    pair: usize,
    /// The excess depth of the penetration, in metres.
    error: f64,
    /// Unknowns of the frame, each with the separation that its change causes.
    row: Vec<(usize, f64)>,
}

/// The separation terms in the frames of a window.
#[derive(Clone, Debug, Default)]
pub(super) struct LinkSeparation {
    pushes: Vec<PushTerm>,
    /// The frames and pairs whose terms pushed in the previous round.
    held: BTreeSet<(usize, usize)>,
    is_first: bool,
    /// The weight of the penetration depth, in 1/m^2.
    weight: f64,
}

impl LinkSeparation {
    pub(super) fn new(weight: f64) -> Self {
        Self {
            weight,
            ..Self::default()
        }
    }

    /// Starts a window.
    pub(super) fn begin(&mut self) {
        self.held.clear();
        self.is_first = true;
    }

    /// Adds the terms of a frame.
    pub(super) fn add(
        &mut self,
        kinematics: &Kinematics,
        collisions: &Collisions,
        frame: usize,
        pose: &RobotPose,
        terms: &mut Terms,
    ) {
        let least = |pair: usize| match self.held.contains(&(frame, pair)) {
            true => f64::NEG_INFINITY,
            false if self.is_first => TOUCHING - NEAR,
            false => TOUCHING,
        };
        let touching = collisions.touching(pose, least);
        let pushes = touching.map(|touch| {
            let error = touch.depth - TOUCHING;
            PushTerm {
                frame,
                pair: touch.pair,
                error,
                row: terms
                    .add_apart(kinematics, pose, touch.points, touch.along, self.weight, error)
                    .to_vec(),
            }
        });
        self.pushes.extend(pushes);
    }

    /// Keeps the terms that still push after a step. The step has the frames that start at `first`, each with `size`
    /// unknowns.
    pub(super) fn settle(&mut self, step: &[f64], first: usize, size: usize) {
        self.is_first = false;
        for push in self.pushes.drain(..) {
            let of_frame = &step[(push.frame - first) * size..];
            let apart: f64 = push.row.iter().map(|&(unknown, by)| by * of_frame[unknown]).sum();
            let key = (push.frame, push.pair);
            match apart < push.error {
                true => self.held.insert(key),
                false => self.held.remove(&key),
            };
        }
    }
}
