//! The addresses of keys and matrices.

use mocap::scene::Keys;
use serde::Serialize;

/// Keys: the address of the values, and the address of the ticks if they are not 0, 1, 2, ...
#[derive(Serialize)]
pub(crate) struct KeysAt {
    length: usize,
    values: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    ticks: Option<usize>,
}

impl KeysAt {
    pub(crate) fn new<T>(keys: &Keys<T>) -> Self {
        Self {
            length: keys.len(),
            values: keys.values.as_ptr().addr(),
            ticks: keys.ticks.as_ref().map(|ticks| ticks.as_ptr().addr()),
        }
    }
}
