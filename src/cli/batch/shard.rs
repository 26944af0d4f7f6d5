//! One part of the files, for runs on several machines.

use std::str::FromStr;

use sha2::{Digest, Sha256};

use super::inputs::Input;

/// `i/n`: part `i`, from 1, of `n`.
///
/// A hash of a file's relative path determines its part. All machines agree without communication, and a new file does
/// not change the parts of other files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    part: u64,
    parts: u64,
}

impl Shard {
    pub fn has(self, input: &Input) -> bool {
        let hash = Sha256::digest(input.relative.as_bytes());
        let (start, _) = hash.split_first_chunk().expect("a hash has 32 bytes");
        u64::from_le_bytes(*start) % self.parts == self.part - 1
    }

    /// `2-of-8`, for file names.
    pub(crate) fn name(self) -> String {
        format!("{}-of-{}", self.part, self.parts)
    }

    /// The shard of this [`name`](Self::name).
    pub(crate) fn of_name(name: &str) -> Option<Self> {
        name.replacen("-of-", "/", 1).parse().ok()
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text
            .split_once('/')
            .and_then(|(part, parts)| Some((part.parse().ok()?, parts.parse().ok()?)));
        match parsed {
            Some((part, parts)) if 1 <= part && part <= parts => Ok(Self { part, parts }),
            _ => Err("not i/n with i from 1 to n, as in 2/8".to_owned()),
        }
    }
}
