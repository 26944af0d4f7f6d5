//! Tests of the parts of packed clips.

mod bits;
mod sample;
