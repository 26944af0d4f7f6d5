//! Draws the distances of all frames of two clips as a matrix.

use mocap_edit::graph::DistanceMatrix;
use mocap_scene::error::{Code, Result};

use super::raster::check_size;

/// The largest side of the picture in pixels. In a larger matrix, a pixel shows the smallest distance of several pairs
/// of frames.
const LARGEST: usize = 2048;

/// The smallest distance in metres at which a pixel is black.
const BLACK: f32 = 0.5;

/// The radius in pixels of the dot that marks a pair of frames. The second constant is its colour.
const DOT: usize = 1;
const MARK: [u8; 3] = [220, 30, 40];

/// Draws a matrix as PNG, as in the paper on motion graphs. The frames of the first clip run from top to bottom, the
/// frames of the second clip from left to right. Lighter pixels are more similar poses. The cells in `marked`, as row
/// and column, get a red dot.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::graph::{GraphBuilder, GraphOptions};
/// use mocap::render::distance_matrix_png;
///
/// let walk = mocap::import("fixtures/real/cmu_short.bvh")?;
/// let mut builder = GraphBuilder::new(&GraphOptions::new())?;
/// builder.add("walk.bvh", &walk)?;
/// let png = distance_matrix_png(&builder.matrix(0, 0)?, &[])?;
/// assert!(png.starts_with(b"\x89PNG"));
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// [`Code::LimitExceeded`] for a matrix without rows or columns.
pub fn distance_matrix_png(matrix: &DistanceMatrix, marked: &[[usize; 2]]) -> Result<Vec<u8>> {
    const STEADY: &str = "the header is one of a picture of this size, and memory takes all";
    let block = matrix.rows.max(matrix.columns).div_ceil(LARGEST).max(1);
    let (height, width) = (matrix.rows.div_ceil(block), matrix.columns.div_ceil(block));
    check_size(width as u32, height as u32, Code::LimitExceeded)?;
    let mut least = vec![f32::INFINITY; width * height];
    for (index, distance) in matrix.values.iter().enumerate() {
        let (row, column) = (index / matrix.columns / block, index % matrix.columns / block);
        let pixel = &mut least[row * width + column];
        *pixel = pixel.min(*distance);
    }
    let light = |distance: &f32| (255.0 * (1.0 - (distance / BLACK).min(1.0))).round() as u8;
    let mut pixels: Vec<[u8; 3]> = least.iter().map(|distance| [light(distance); 3]).collect();
    for [row, column] in marked {
        let around = |middle: usize, side: usize| middle.saturating_sub(DOT)..=(middle + DOT).min(side - 1);
        for row in around(row / block, height) {
            for column in around(column / block, width) {
                pixels[row * width + column] = MARK;
            }
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect(STEADY);
    writer.write_image_data(pixels.as_flattened()).expect(STEADY);
    writer.finish().expect(STEADY);
    Ok(bytes)
}
