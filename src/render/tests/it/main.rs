//! The integration tests of pictures: one program, because linking is slow, with one module per subject.

mod drawing;
mod euler;
mod figure;
mod image_size;
mod limits;
mod palette;
mod plot;
mod render;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/sample.rs"]
mod sample;
mod sheet;
mod surface;
mod svg;
mod terminal;
mod texture;
mod view;
