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
    /// Animated values of one file: frames times channels. Default: 2^30. A format in which few bytes can claim a long
    /// take, FBX or glTF, may have 4 million, and 256 more for each byte of the file, where that is less.
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

impl Limits {
    /// Values that a file may expand to, where few bytes can claim a long take: curves, or keys far apart.
    ///
    /// The limit grows with the file, so that the memory it takes does not leave all proportion to it. 256 a byte is
    /// more than one joint of a hundred that moves, the others having one key.
    pub(crate) fn expanded_values(&self, bytes: &[u8]) -> u64 {
        const ANY_FILE: u64 = 4 << 20;
        const PER_BYTE: u64 = 256;
        self.max_values.min(ANY_FILE + PER_BYTE * bytes.len() as u64)
    }
}

/// The farthest a joint may be from its parent, in the file's unit: kinematics squares and adds such numbers, and the
/// results must still be finite in 32 bits.
pub(crate) const FARTHEST: f64 = 1e18;

/// What a reader says of a claim beyond the limits.
pub(crate) fn limit_exceeded(expected: String, found: String) -> Diagnostic {
    Diagnostic::new(Code::LimitExceeded, "the file claims more than the limits allow").expected_found(expected, found)
}
