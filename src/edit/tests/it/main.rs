//! The integration tests of steps and motion graphs: one program, because linking is slow, with one module per subject.

mod clean;
mod edit;
mod graph;
mod lock;
mod positions;
mod spline;
mod text;
