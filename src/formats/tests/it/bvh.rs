//! The parts of the BVH reader and writer.

mod angles;
mod block;
mod channel;
mod layout;
mod number;
mod pieces;
mod short;
