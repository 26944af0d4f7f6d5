//! Lists the contents of a drawing, for other tests.

use mocap::render::Drawing;
use mocap_render::internals::Shape;

/// Every text with the position of its anchor.
pub(crate) fn texts(drawing: &Drawing) -> Vec<(&str, [f32; 2])> {
    let texts = drawing.shapes.iter().filter_map(|shape| match shape {
        Shape::Text { text, at, .. } => Some((text.as_str(), *at)),
        _ => None,
    });
    texts.collect()
}

pub(crate) fn points(shape: &Shape) -> Vec<[f32; 2]> {
    match shape {
        Shape::Polygon { points, .. } | Shape::Line { points, .. } => points.clone(),
        Shape::Circle { center, .. } => vec![*center],
        Shape::Text { at, .. } => vec![*at],
        Shape::Pixels(pixels) => vec![[pixels.left as f32, pixels.top as f32]],
    }
}
