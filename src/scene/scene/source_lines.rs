//! The source lines of a node.

use serde::{Deserialize, Serialize};

/// The lines of a file that describe a node, from 1.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceLines {
    /// The line of the name: BVH's ROOT, JOINT or End Site.
    pub name: usize,
    /// The line of the offset from the parent: BVH's OFFSET.
    pub offset: Option<usize>,
    /// The line of the channels: BVH's CHANNELS.
    pub channels: Option<usize>,
}
