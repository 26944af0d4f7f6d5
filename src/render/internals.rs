//! Items for the tests of this package.

pub use crate::drawing::{Anchor, Color, Pixels, Shape};
pub use crate::euler::unwrapped;
pub use crate::image_size::image_size;
pub use crate::raster::png_of;
pub use crate::svg::number;
pub use crate::terminal::wrapped;
pub use crate::view::skin::strongest_four;

pub mod figure {
    pub use crate::figure::{DrawnClip, Link, Side, links, short, shown};
}
pub mod morphs {
    pub use crate::view::morphs::{MOVED_BYTES, Morph, Morphs, PackedMorphs};
}
pub mod pack {
    pub use crate::view::pack::{
        Packed, Part, ROTATION_PRECISION, Row, Storage, Track, Tracks, pack_rotations, pack_row,
    };
}
pub mod palette {
    pub use crate::palette::{MOST, Palette, median_cut};
}
pub mod plot {
    pub use crate::plot::{Scale, thinned};
}
pub mod surface {
    pub use crate::surface::{Buffer, SAMPLES};
}
pub mod texture {
    pub use crate::texture::{Image, Paint};
}
pub mod theme {
    pub use crate::theme::{INK, LEFT, PAPER, RULE, SHADOW};
}
pub mod view {
    pub use crate::built::script;
    pub use crate::view::filled;
}
