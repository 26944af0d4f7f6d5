//! Rasterizes a drawing.

use std::sync::LazyLock;

use mocap_scene::error::{Code, Diagnostic, Result};
use tiny_skia::{
    ColorU8, FillRule, IntSize, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, PixmapPaint, PremultipliedColorU8,
    Stroke, Transform,
};
use ttf_parser::{Face, OutlineBuilder};

use super::built::font;
use super::drawing::{Anchor, Color, Drawing, Pixels, Point, Shape};

/// The largest width and the largest height in pixels.
pub(super) const LARGEST_SIDE: u32 = 16_384;

/// The largest number of pixels in a picture: 256 MB in memory.
const MOST_PIXELS: u64 = 1 << 26;

impl Drawing {
    /// The drawing as a PNG file. Equal drawings give equal bytes.
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] if the width or the height is 0 or more than 16,384 pixels. Also if the picture has more
    /// than 67,108,864 pixels.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        Ok(png_of(self.width, self.height, png::ColorType::Rgb, &self.to_rgb()?))
    }

    /// Red, green and blue of every pixel, row by row from the top.
    pub(super) fn to_rgb(&self) -> Result<Vec<u8>> {
        let pixmap = self.paint()?;
        let opaque = pixmap.pixels().iter().copied();
        Ok(opaque
            .flat_map(|pixel: PremultipliedColorU8| [pixel.red(), pixel.green(), pixel.blue()])
            .collect())
    }

    fn paint(&self) -> Result<Pixmap> {
        // Check the limit before allocating memory.
        check_size(self.width, self.height, Code::LimitExceeded)?;
        let mut pixmap = Pixmap::new(self.width, self.height)
            .ok_or_else(|| wrong_size(self.width, self.height, Code::LimitExceeded))?;
        let [red, green, blue] = self.background.rgb;
        pixmap.fill(tiny_skia::Color::from_rgba8(red, green, blue, 255));
        for shape in &self.shapes {
            paint_shape(&mut pixmap, shape);
        }
        Ok(pixmap)
    }
}

/// A PNG file of pixels with 8 bits per component.
pub fn png_of(width: u32, height: u32, color: png::ColorType, pixels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder
        .write_header()
        .expect("a header of two lengths above 0 is valid");
    writer
        .write_image_data(pixels)
        .expect("there are width x height pixels, and memory takes all");
    writer.finish().expect("memory takes all");
    bytes
}

/// Refuses pictures that are empty or too large. The error has this code.
pub(super) fn check_size(width: u32, height: u32, code: Code) -> Result<()> {
    let within = |side: u32| (1..=LARGEST_SIDE).contains(&side);
    let pixels = u64::from(width) * u64::from(height);
    match within(width) && within(height) && pixels <= MOST_PIXELS {
        true => Ok(()),
        false => Err(wrong_size(width, height, code).into()),
    }
}

fn wrong_size(width: u32, height: u32, code: Code) -> Diagnostic {
    Diagnostic::new(code, "the size of the picture is not valid").expected_found(
        format!("1 to {LARGEST_SIDE} pixels in width and height, and {MOST_PIXELS} in all"),
        format!("{width} x {height}"),
    )
}

fn paint_shape(pixmap: &mut Pixmap, shape: &Shape) {
    match shape {
        Shape::Polygon { points, color } => {
            fill(pixmap, polyline(points, true), *color);
        }
        Shape::Line { points, width, color } => {
            let stroke = Stroke {
                width: *width,
                line_cap: LineCap::Round,
                line_join: LineJoin::Round,
                ..Stroke::default()
            };
            if let Some(path) = polyline(points, false) {
                pixmap.stroke_path(&path, &paint_of(*color), &stroke, Transform::identity(), None);
            }
        }
        Shape::Circle {
            center: [x, y],
            radius,
            color,
        } => {
            fill(pixmap, PathBuilder::from_circle(*x, *y, *radius), *color);
        }
        Shape::Pixels(pixels) => blend(pixmap, pixels),
        Shape::Text {
            at,
            text,
            size,
            anchor,
            color,
        } => {
            let shift = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5,
                Anchor::End => 1.0,
            };
            let [x, y] = *at;
            fill(
                pixmap,
                outline(text, [x - shift * text_width(text, *size), y], *size),
                *color,
            );
        }
    }
}

/// Blends pixels over the picture.
fn blend(pixmap: &mut Pixmap, pixels: &Pixels) {
    let paint = PixmapPaint::default();
    let Some(size) = IntSize::from_wh(pixels.width as u32, pixels.height as u32) else {
        return;
    };
    let premultiplied = pixels
        .rgba
        .as_chunks::<4>()
        .0
        .iter()
        .flat_map(|[red, green, blue, alpha]| {
            let color = ColorU8::from_rgba(*red, *green, *blue, *alpha).premultiply();
            [color.red(), color.green(), color.blue(), color.alpha()]
        });
    if let Some(over) = Pixmap::from_vec(premultiplied.collect(), size) {
        let (left, top) = (pixels.left as i32, pixels.top as i32);
        pixmap.draw_pixmap(left, top, over.as_ref(), &paint, Transform::identity(), None);
    }
}

/// Fills a path. `path` is `None` for shapes that are empty or not finite; they are not painted.
fn fill(pixmap: &mut Pixmap, path: Option<Path>, color: Color) {
    if let Some(path) = path {
        pixmap.fill_path(&path, &paint_of(color), FillRule::Winding, Transform::identity(), None);
    }
}

fn paint_of(color: Color) -> Paint<'static> {
    let [red, green, blue] = color.rgb;
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, (color.opacity.clamp(0.0, 1.0) * 255.0).round() as u8);
    paint
}

fn polyline(points: &[Point], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (index, [x, y]) in points.iter().enumerate() {
        match index {
            0 => path.move_to(*x, *y),
            _ => path.line_to(*x, *y),
        }
    }
    if closed {
        path.close();
    }
    path.finish()
}

static FACE: LazyLock<Face<'static>> =
    LazyLock::new(|| Face::parse(font().leak(), 0).expect("the font comes with the program"));

/// The width of `text` in a font of `size` pixels.
pub(super) fn text_width(text: &str, size: f32) -> f32 {
    let face = &*FACE;
    let units: u32 = text.chars().map(|letter| u32::from(advance(face, letter))).sum();
    units as f32 * size / f32::from(face.units_per_em())
}

/// `text`, shortened with an ellipsis if it does not fit.
pub(super) fn shortened(text: &str, size: f32, width: f32) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let mut short: String = text.to_owned();
    while short.pop().is_some() {
        let candidate = format!("{}…", short.trim_end());
        if text_width(&candidate, size) <= width {
            return candidate;
        }
    }
    "…".to_owned()
}

fn advance(face: &Face<'_>, letter: char) -> u16 {
    let glyph = face.glyph_index(letter).unwrap_or_default();
    face.glyph_hor_advance(glyph).unwrap_or(0)
}

/// The outlines of the letters, from left to right. A letter that the font lacks becomes a box.
fn outline(text: &str, [x, y]: Point, size: f32) -> Option<Path> {
    let face = &*FACE;
    let scale = size / f32::from(face.units_per_em());
    let mut pen = Pen {
        path: PathBuilder::new(),
        x,
        y,
        scale,
    };
    for letter in text.chars() {
        face.outline_glyph(face.glyph_index(letter).unwrap_or_default(), &mut pen);
        pen.x += f32::from(advance(face, letter)) * scale;
    }
    pen.path.finish()
}

/// Receives outlines in font units, with y up.
struct Pen {
    path: PathBuilder,
    x: f32,
    y: f32,
    scale: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.scale, self.y - y * self.scale)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}
