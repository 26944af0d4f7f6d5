//! A walk over a graph: pieces of clips, one after another.

use std::fmt;

use glam::DVec2;
use serde::Serialize;

use super::GraphTransition;
use super::distance::Alignment;
use super::network::Network;

/// A walk over a graph, of which [`Walk::motion`](crate::graph::report::Walk::motion) makes a motion.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Walk {
    /// The pieces in their order. From each to the next, for the length of a window, the two are blended.
    pub pieces: Vec<WalkPiece>,
    /// Frames per second of the pieces.
    pub rate: f64,
    /// The frames of a window.
    pub window: usize,
    /// How each piece is moved over the ground.
    pub(crate) placements: Vec<Alignment>,
    /// How each frame is moved over the ground so that it is on the path; none of a walk without one.
    pub(crate) bends: Vec<Bend>,
    /// How near it is to the path.
    pub(crate) followed: Option<WalkPath>,
    /// The length that was asked for, in seconds; what is beyond is cut.
    pub(crate) length: f64,
}

/// A piece of a clip in a walk.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct WalkPiece {
    /// The clip.
    pub clip: usize,
    /// The frame with which the blend from the piece before ends.
    pub first: usize,
    /// The frame with which the blend to the next piece begins.
    pub last: usize,
    /// How far the moments are apart between which the walk passed to this piece, in metres; 0 of the first.
    pub distance: f32,
}

/// How near a walk is to the path that it follows: where the mean of the body is, and where it goes over a second.
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
    /// How far from the path the figure is, in metres, in the mean.
    pub mean_distance: f64,
    /// At most.
    pub largest_distance: f64,
    /// By how much it goes in another direction than the path, in degrees, in the mean.
    pub mean_angle: f64,
    /// At most.
    pub largest_angle: f64,
}

/// A path is followed that is left by no more than this, in metres and degrees.
const FOLLOWED: (f64, f64) = (0.1, 10.0);

impl fmt::Display for WalkPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.2} m from the path in the mean and {:.2} m at most, {:.0} degrees and {:.0}",
            self.mean_distance, self.largest_distance, self.mean_angle, self.largest_angle
        )?;
        match self.largest_distance <= FOLLOWED.0 && self.largest_angle <= FOLLOWED.1 {
            true => Ok(()),
            false => f.write_str(
                ": the clips have no moves that follow it nearer; add clips that turn as the path does, mirror them, or \
                 raise the threshold",
            ),
        }
    }
}

impl Walk {
    /// A walk that begins in a frame of a clip, which is moved by `placement`.
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

    /// Continues to the frame at which a transition leaves the clip, and then to its target.
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

    /// Goes on in the clip to a frame.
    pub(super) fn stay_until(&mut self, frame: usize) {
        if let Some(piece) = self.pieces.last_mut() {
            piece.last = frame.max(piece.first);
        }
    }

    /// The frames of the walk at its rate, without the first.
    pub(super) fn frames(&self) -> usize {
        let within: usize = self.pieces.iter().map(|piece| piece.last - piece.first).sum();
        within + self.pieces.len().saturating_sub(1) * (self.window - 1)
    }

    /// How long it is, in seconds.
    pub fn seconds(&self) -> f64 {
        (self.frames() as f64 / self.rate).min(self.length)
    }
}

/// How a frame of a walk is moved over the ground: turned about where the figure is, and shifted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bend {
    pub(super) centre: DVec2,
    pub(super) moved: DVec2,
    pub(super) turn: f64,
}

impl Bend {
    /// The bend at a frame and a fraction.
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

/// The weight of the second clip in a transition: equation 3 of the paper. Its speed has no jump at both ends, and is
/// smaller between them than that of smoother curves, so that joints are hardly faster than in the clips.
pub(crate) fn smooth(part: f64) -> f64 {
    part * part * (3.0 - 2.0 * part)
}
