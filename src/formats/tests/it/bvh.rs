//! The parts that read and write BVH.

mod angles;
mod block;
mod channel;
mod layout;
mod number;
mod pieces;
mod short;
