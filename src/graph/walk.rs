//! A walk over a graph: pieces of clips, one after another.

use super::GraphTransition;
use super::distance::Alignment;
use super::network::Network;

/// A walk over a graph, of which [`Walk::motion`](crate::graph::Walk::motion) makes a motion.
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
            length: f64::INFINITY,
        }
    }

    /// Goes on to where a transition leaves the clip, and to where it leads.
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
