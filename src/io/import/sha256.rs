//! Computes the SHA-256 of a file piece by piece while the file is read.

use sha2::{Digest, Sha256};

/// The running hash of a file.
#[derive(Clone, Default)]
pub(super) struct Sha256Sum {
    hasher: Sha256,
    /// The number of bytes that were hashed.
    added: usize,
}

impl Sha256Sum {
    /// The hash of `bytes`.
    pub(super) fn of(bytes: &[u8]) -> String {
        let mut sum = Self::default();
        sum.add(bytes);
        sum.finish()
    }

    /// Adds the next bytes.
    pub(super) fn add(&mut self, bytes: &[u8]) {
        self.hasher.update(bytes);
        self.added += bytes.len();
    }

    /// Adds the first `end` bytes of `bytes`, without the bytes that were added before.
    pub(super) fn add_up_to(&mut self, bytes: &[u8], end: usize) {
        if let Some(bytes) = bytes.get(self.added..end) {
            self.add(bytes);
        }
    }

    /// Returns the hash as `sha256sum` prints it.
    pub(super) fn finish(self) -> String {
        let digest = self.hasher.finalize();
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
