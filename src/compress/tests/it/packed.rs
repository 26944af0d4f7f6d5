//! The parts of packed clips.

mod bits;
mod sample;
