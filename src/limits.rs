//! How much of a machine one file may claim.

use crate::error::{Code, Diagnostic};

/// Upper bounds for what a reader accepts, each checked before anything is allocated for it.
///
/// A count in a file is a claim, not a size: a reader compares it with these limits and with the bytes that are
/// there. The defaults hold every motion file we know of with a wide margin.
///
/// ```
/// use mocap::{Importer, Limits};
///
/// let tight = Limits { max_nodes: 2, ..Limits::default() };
/// let text = b"HIERARCHY ROOT a { JOINT b { JOINT c { } } } MOTION Frames: 0 Frame Time: 0.1";
/// let error = Importer::new().limits(tight).read(text, "deep.bvh").unwrap_err();
/// assert_eq!(error.code().as_str(), "limit-exceeded");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one input file. Default: 4 GiB.
    pub max_bytes: u64,
    /// Nodes of one scene: joints and end sites. Default: 65,536.
    pub max_nodes: usize,
    /// Nodes from a root to its deepest descendant. Default: 1,024.
    pub max_depth: usize,
    /// Bytes of one name. Default: 256.
    pub max_name_bytes: usize,
    /// Animated values of one file: frames times channels. Default: 2^30.
    pub max_values: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_bytes: 4 << 30,
            max_nodes: 65_536,
            max_depth: 1_024,
            max_name_bytes: 256,
            max_values: 1 << 30,
        }
    }
}

/// What a reader says of a claim beyond the limits.
pub(crate) fn limit_exceeded(expected: String, found: String) -> Diagnostic {
    Diagnostic::new(Code::LimitExceeded, "the file claims more than the limits allow").expected_found(expected, found)
}
