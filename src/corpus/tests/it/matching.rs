//! What motion matching computes, part by part.

mod controller;
mod like;
mod steering;
