//! What is asked of a figure.

use glam::Vec3;

/// The wanted places and facings of a figure in 20, 40 and 60 frames, at 60 frames a second. They are in the world, in
/// metres; heights do not count.
///
/// [`Controller`](super::Controller) has an example.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Trajectory {
    /// Where it is.
    pub positions: [Vec3; 3],
    /// Where it looks.
    pub directions: [Vec3; 3],
}

impl Trajectory {
    /// Of these positions and directions.
    pub fn new(positions: [Vec3; 3], directions: [Vec3; 3]) -> Self {
        Self { positions, directions }
    }
}
