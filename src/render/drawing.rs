//! A picture as a list of shapes, for both PNG and SVG.

/// Red, green and blue from 0 to 255 in sRGB, and an opacity from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color {
    /// Red, green and blue.
    pub rgb: [u8; 3],
    /// 0 is invisible, 1 is opaque.
    pub opacity: f32,
}

impl Color {
    /// An opaque colour from `0xRRGGBB`.
    pub const fn hex(rgb: u32) -> Self {
        let [_, red, green, blue] = rgb.to_be_bytes();
        Self {
            rgb: [red, green, blue],
            opacity: 1.0,
        }
    }

    /// Interpolates from this colour to `other`; `fraction` is from 0 to 1.
    #[must_use]
    pub fn mix(self, other: Self, fraction: f32) -> Self {
        let mut rgb = self.rgb;
        for (from, to) in rgb.iter_mut().zip(other.rgb) {
            *from = (f32::from(*from) + (f32::from(to) - f32::from(*from)) * fraction).round() as u8;
        }
        Self { rgb, ..self }
    }
}

/// A point in a drawing, in pixels from the left and from the top.
pub(super) type Point = [f32; 2];

/// The part of a text that is at the position of its shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Anchor {
    /// The start.
    #[default]
    Start,
    /// The middle.
    Middle,
    /// The end.
    End,
}

/// A pixel rectangle of a drawing: red, green, blue and opacity, row by row.
#[derive(Clone, Debug, PartialEq)]
#[doc(hidden)]
pub struct Pixels {
    pub left: usize,
    pub top: usize,
    pub width: usize,
    pub height: usize,
    pub rgba: Vec<u8>,
}

/// A shape. It covers the shapes before it.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A filled polygon.
    Polygon {
        /// The corners.
        points: Vec<Point>,
        /// The fill colour.
        color: Color,
    },
    /// Connected line segments with round ends.
    Line {
        /// The points.
        points: Vec<Point>,
        /// The width in pixels.
        width: f32,
        /// The colour of the line.
        color: Color,
    },
    /// A filled circle.
    Circle {
        /// The centre.
        center: Point,
        /// Radius in pixels.
        radius: f32,
        /// The fill colour.
        color: Color,
    },
    /// A rectangle of pixels.
    Pixels(Pixels),
    /// One line of text.
    Text {
        /// The position of the anchor, on the baseline.
        at: Point,
        /// The text.
        text: String,
        /// Height of the font in pixels.
        size: f32,
        /// The part of the text that is at the position.
        anchor: Anchor,
        /// The colour of the letters.
        color: Color,
    },
}

/// A picture that can be written as PNG or SVG.
///
/// [`Drawing::sheet`](crate::Drawing::sheet) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Drawing {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The colour of the background.
    pub(super) background: Color,
    /// The shapes, from back to front.
    #[doc(hidden)]
    pub shapes: Vec<Shape>,
    /// A description of the picture, for the title of the SVG.
    pub(super) title: String,
}

impl Drawing {
    /// An empty picture.
    #[doc(hidden)]
    pub fn new(width: u32, height: u32, background: Color, title: impl Into<String>) -> Self {
        Self {
            width,
            height,
            background,
            shapes: Vec::new(),
            title: title.into(),
        }
    }

    pub(super) fn polygon(&mut self, points: Vec<Point>, color: Color) {
        self.shapes.push(Shape::Polygon { points, color });
    }

    pub(super) fn rectangle(&mut self, [left, top]: Point, [right, bottom]: Point, color: Color) {
        self.polygon(vec![[left, top], [right, top], [right, bottom], [left, bottom]], color);
    }

    pub(super) fn line(&mut self, points: Vec<Point>, width: f32, color: Color) {
        self.shapes.push(Shape::Line { points, width, color });
    }

    pub(super) fn circle(&mut self, center: Point, radius: f32, color: Color) {
        self.shapes.push(Shape::Circle { center, radius, color });
    }

    pub(super) fn pixels(&mut self, pixels: Pixels) {
        self.shapes.push(Shape::Pixels(pixels));
    }

    #[doc(hidden)]
    pub fn text(&mut self, at: Point, text: impl Into<String>, size: f32, anchor: Anchor, color: Color) {
        self.shapes.push(Shape::Text {
            at,
            text: text.into(),
            size,
            anchor,
            color,
        });
    }
}
