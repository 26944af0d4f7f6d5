//! Defines a walk through a motion graph: pieces of clips, one after another.

use std::fmt;

use glam::DVec2;
use serde::Serialize;

use super::GraphTransition;
use super::distance::Alignment;
use super::network::Network;

/// A walk: a path through a motion graph. [`Walk::motion`](crate::graph::report::Walk::motion) turns it into a motion.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Walk {
    /// The pieces in order. Successive pieces are blended over the length of a window.
    pub pieces: Vec<WalkPiece>,
    /// The frame rate at which the frames of the pieces are counted, in frames per second.
    pub rate: f64,
    /// The number of frames of a window, over which two pieces are blended.
    pub window: usize,
    /// For each piece, the rigid motion over the ground that moves the clip to its position in the walk.
    pub(crate) placements: Vec<Alignment>,
    /// For each frame, the shift and the turn that bring the figure onto the path. Empty for a walk without a path.
    pub(crate) bends: Vec<Bend>,
    /// How near the walk is to its path. `None` for a walk without a path.
    pub(crate) followed: Option<WalkPath>,
    /// The requested duration in seconds. Later frames are cut off.
    pub(crate) length: f64,
}

/// A piece of a clip in a walk.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct WalkPiece {
    /// The index of the clip in the graph.
    pub clip: usize,
    /// The frame at which the blend from the previous piece ends.
    pub first: usize,
    /// The frame at which the blend to the next piece begins.
    pub last: usize,
    /// The distance between the two windows of the transition to this piece, in metres. It is 0 for the first piece.
    pub distance: f32,
}

/// How far a walk is from its path. The position of the figure is the mean of its joints, and its direction is measured
/// over one second.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::graph::{GraphBuilder, GraphOptions};
///
/// let clip = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let mut builder = GraphBuilder::new(&GraphOptions::new())?;
/// builder.add("walk.bvh", &clip)?;
/// let graph = builder.build()?;
/// let found = builder.network(&graph)?.along(&[[0.0, 0.0], [0.0, 8.0]])?;
/// let path = found.motion(&[(&clip, 0)])?.1.path.unwrap();
/// assert!(path.largest_distance < 0.1 && path.largest_angle < 10.0);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WalkPath {
    /// The length of the path, in metres.
    pub length: f64,
    /// The mean distance of the figure from the path, in metres.
    pub mean_distance: f64,
    /// The largest distance of the figure from the path, in metres.
    pub largest_distance: f64,
    /// The mean angle between the direction in which the figure moves and the direction of the path, in degrees.
    pub mean_angle: f64,
    /// The largest angle between the direction in which the figure moves and the direction of the path, in degrees.
    pub largest_angle: f64,
}

/// The largest distance in metres and the largest angle in degrees at which a walk follows its path.
const FOLLOWED: (f64, f64) = (0.1, 10.0);

impl fmt::Display for WalkPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "mean distance from the path {:.2} m, largest {:.2} m; mean angle {:.0} degrees, largest {:.0}",
            self.mean_distance, self.largest_distance, self.mean_angle, self.largest_angle
        )?;
        match self.largest_distance <= FOLLOWED.0 && self.largest_angle <= FOLLOWED.1 {
            true => Ok(()),
            false => f.write_str(
                ": these clips follow the path no more closely; add clips that turn as the path does, mirror them, or \
                 raise the threshold",
            ),
        }
    }
}

impl Walk {
    /// Begins a walk at a frame of a clip. `placement` moves the clip over the ground.
    pub(super) fn begin(network: &Network<'_>, clip: usize, frame: usize, placement: Alignment) -> Self {
        Self {
            pieces: vec![WalkPiece {
                clip,
                first: frame,
                last: frame,
                distance: 0.0,
            }],
            rate: network.rate,
            window: network.window.frames(),
            placements: vec![placement],
            bends: Vec::new(),
            followed: None,
            length: f64::INFINITY,
        }
    }

    /// Continues the walk in its clip up to the start of a transition, and then by the transition to its target.
    pub(super) fn take(&mut self, network: &Network<'_>, exit: &GraphTransition) {
        let own = self.placements.last().copied().unwrap_or(Alignment::NONE);
        self.stay_until(exit.from[1]);
        self.pieces.push(WalkPiece {
            clip: exit.to[0],
            first: exit.to[1],
            last: exit.to[1],
            distance: exit.distance,
        });
        self.placements.push(own.after(&network.alignment(exit)));
    }

    /// Continues the walk in its clip to a frame.
    pub(super) fn stay_until(&mut self, frame: usize) {
        if let Some(piece) = self.pieces.last_mut() {
            piece.last = frame.max(piece.first);
        }
    }

    /// The number of frames of the walk at the rate of the graph, without the first frame.
    pub(super) fn frames(&self) -> usize {
        let within: usize = self.pieces.iter().map(|piece| piece.last - piece.first).sum();
        within + self.pieces.len().saturating_sub(1) * (self.window - 1)
    }

    /// The duration of the walk, in seconds.
    pub fn seconds(&self) -> f64 {
        (self.frames() as f64 / self.rate).min(self.length)
    }
}

/// A rotation about the figure's position and a shift over the ground, for one frame of a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bend {
    pub(super) centre: DVec2,
    pub(super) moved: DVec2,
    pub(super) turn: f64,
}

impl Bend {
    /// The bend at a fractional frame.
    pub(crate) fn at(bends: &[Self], frame: f64) -> Option<Alignment> {
        let last = bends.len().checked_sub(1)?;
        let first = (frame.max(0.0) as usize).min(last);
        let (from, to, part) = (bends[first], bends[(first + 1).min(last)], frame - first as f64);
        let part = part.clamp(0.0, 1.0);
        let (centre, moved) = (from.centre.lerp(to.centre, part), from.moved.lerp(to.moved, part));
        let turn = from.turn + part * (to.turn - from.turn);
        Some(Alignment {
            turn,
            offset: centre + moved - DVec2::from_angle(turn).rotate(centre),
            distance: 0.0,
        })
    }
}

/// The weight of the second clip in a transition, by equation 3 of Kovar, Gleicher and Pighin. `part` is the fraction
/// of the transition that is done. The speed of this curve does not jump at either end. Smoother curves are steeper in
/// the middle, so joints would move faster than in the clips.
pub(crate) fn smooth(part: f64) -> f64 {
    part * part * (3.0 - 2.0 * part)
}
