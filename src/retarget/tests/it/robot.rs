//! Tests of the parts of retargeting to robots.

mod balance;
mod band;
mod branches;
mod capsule;
mod collision;
mod cones;
mod drawn;
mod dynamics;
mod feasibility;
mod fingers;
mod floor;
mod given;
mod sole;
mod solver;
mod swing;
mod verdict;
mod window;
