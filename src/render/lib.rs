//! Pictures of motion: contact sheets, movies, curves, a terminal screen, and a page with a player.
//!
//! All pictures are drawn in software, with the same scene and kinematics as the rest of the crate. Equal scenes and
//! options give equal bytes. A [`Drawing`] can be written as PNG or SVG, a [`Movie`] as GIF or animated PNG.
//!
//! Pictures show the world with +Y up. mocap infers the up axis of the file (`mocap_figure`).

// Only tests may call `unwrap` and print.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

mod built;
mod camera;
mod drawing;
mod euler;
mod figure;
mod image_size;
#[doc(hidden)]
pub mod internals;
mod matrix;
mod movie;
#[doc(hidden)]
mod palette;
mod plot;
mod raster;
mod sheet;
#[doc(hidden)]
mod surface;
mod svg;
mod t_pose;
mod terminal;
#[doc(hidden)]
mod texture;
#[doc(hidden)]
mod theme;
mod view;

pub use self::drawing::Drawing;
pub use self::figure::Clip;
#[doc(hidden)]
pub use self::matrix::distance_matrix_png;
pub use self::movie::{Movie, MovieOptions};
pub use self::plot::PlotOptions;
pub use self::sheet::SheetOptions;
#[doc(hidden)]
pub use self::t_pose::TPoseClip;
#[doc(hidden)]
pub use self::terminal::ScreenOptions;
#[doc(hidden)]
pub use self::view::{ListingEntry, PlayerClip};
pub use self::view::{Page, PageClip};
