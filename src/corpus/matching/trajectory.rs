//! The wanted path of a figure.

use glam::Vec3;

/// The wanted positions and facings of a figure in 20, 40 and 60 frames, at 60 frames per second. Positions are in the
/// world, in metres. Heights are ignored.
///
/// [`Controller`](super::Controller) has an example.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Trajectory {
    /// The wanted positions in 20, 40 and 60 frames.
    pub positions: [Vec3; 3],
    /// The wanted facings in 20, 40 and 60 frames.
    pub directions: [Vec3; 3],
}

impl Trajectory {
    /// Makes a trajectory of positions and facings.
    pub fn new(positions: [Vec3; 3], directions: [Vec3; 3]) -> Self {
        Self { positions, directions }
    }
}
