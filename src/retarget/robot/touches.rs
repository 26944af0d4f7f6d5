//! Links that are pushed apart, from round to round of a window.
//!
//! A term pushes links apart that are in each other. In the next round they are apart, and without the term they would
//! go back: half of the frames would end in each other. So a term stays as long as it pushes, and is removed if it
//! would pull.

use std::collections::BTreeSet;

use super::collision::Collisions;
use super::kinematics::{Kinematics, RobotPose};
use super::terms::Terms;

/// The depth in metres by which links may be in each other: less than half of the 10 mm that a report counts.
const TOUCHING: f64 = 0.004;

/// The depth in metres below [`TOUCHING`] from which on links count in the first round: a round before may have pushed
/// them apart.
const NEAR: f64 = 0.002;

/// The term of two links in one frame.
#[derive(Clone, Debug)]
struct PushTerm {
    frame: usize,
    pair: usize,
    /// How far they are too deep, in metres.
    error: f64,
    /// Unknowns of the frame, and how far a change of each brings the links apart.
    row: Vec<(usize, f64)>,
}

/// The links that are pushed apart in the frames of a window.
#[derive(Clone, Debug, Default)]
pub(super) struct LinkSeparation {
    pushes: Vec<PushTerm>,
    /// Frames and pairs whose terms pushed in the round before.
    held: BTreeSet<(usize, usize)>,
    is_first: bool,
    /// The weight of a metre of depth, in 1/m^2.
    weight: f64,
}

impl LinkSeparation {
    pub(super) fn new(weight: f64) -> Self {
        Self {
            weight,
            ..Self::default()
        }
    }

    /// Begins a window.
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

    /// Keeps the terms that push after a step of the frames from `first`, each of `size` unknowns.
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
