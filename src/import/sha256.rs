//! The SHA-256 of a file, computed piece by piece while it is read.

use sha2::{Digest, Sha256};

/// The hash of the first bytes of a file.
pub(super) struct Sha256Sum<'a> {
    bytes: &'a [u8],
    hasher: Sha256,
    /// The number of bytes in it.
    added: usize,
}

impl<'a> Sha256Sum<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            hasher: Sha256::new(),
            added: 0,
        }
    }

    /// Adds the bytes before `end` that were not added yet.
    pub(super) fn add_up_to(&mut self, end: usize) {
        if let Some(bytes) = self.bytes.get(self.added..end) {
            self.hasher.update(bytes);
            self.added = end;
        }
    }

    /// Adds all bytes that were not added yet.
    pub(super) fn add_all(&mut self) {
        self.add_up_to(self.bytes.len());
    }

    /// As `sha256sum` prints it. All bytes were added.
    pub(super) fn finish(self) -> String {
        let digest = self.hasher.finalize();
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
