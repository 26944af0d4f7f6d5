//! Memory that programs read and write through plain pointers, freed all at once.

use std::alloc::{Layout, dealloc};
use std::ptr;

/// Owns every block that a scene points to.
///
/// A program may change a scene, its counts and pointers included. What is freed is known here and not read from the
/// scene, so that no such change leaks or frees twice.
#[derive(Default)]
pub(crate) struct Arena {
    blocks: Vec<(*mut u8, Layout)>,
}

impl Arena {
    /// Moves values here and returns a pointer to the first; NULL if there are none, as in Assimp. The place is
    /// valid as long as the arena.
    pub(crate) fn keep<T: Copy>(&mut self, values: Vec<T>) -> *mut T {
        let values = values.into_boxed_slice();
        let layout = Layout::for_value(&*values);
        if layout.size() == 0 {
            return ptr::null_mut();
        }
        let first = Box::into_raw(values).cast::<T>();
        self.blocks.push((first.cast(), layout));
        first
    }

    /// Moves one value here.
    pub(crate) fn keep_one<T: Copy>(&mut self, value: T) -> *mut T {
        self.keep(vec![value])
    }

    /// Moves values here, and returns an array of pointers to each of them.
    pub(crate) fn keep_pointers<T: Copy>(&mut self, values: Vec<T>) -> *mut *mut T {
        let count = values.len();
        let first = self.keep(values);
        let pointers = (0..count).map(|index| first.wrapping_add(index)).collect();
        self.keep(pointers)
    }
}

impl Drop for Arena {
    fn drop(&mut self) {
        for &(block, layout) in &self.blocks {
            // SAFETY: `keep` took the block out of a box of this layout, and its values are `Copy`, so none has
            // anything of its own to free.
            unsafe { dealloc(block, layout) };
        }
    }
}
