//! Tests of the parts of motion matching.

mod controller;
mod like;
mod steering;
