//! A drawing as SVG text.

use std::fmt::Write;

use super::drawing::{Anchor, Color, Drawing, Pixels, Point, Shape};
use super::raster::png_of;

impl Drawing {
    /// The drawing as an SVG document. Equal drawings give equal bytes.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::render::{Clip, Drawing, SheetOptions};
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let drawing = Drawing::sheet(&[Clip { name: "Test", scene: &scene }], &SheetOptions::default());
    /// assert!(drawing.to_svg().starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1600\""));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn to_svg(&self) -> String {
        let mut svg = String::new();
        self.write_svg(&mut svg).expect("writing to a string cannot fail");
        svg
    }

    fn write_svg(&self, svg: &mut String) -> std::fmt::Result {
        let Self { width, height, .. } = self;
        writeln!(
            svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"DejaVu Sans, Verdana, sans-serif\" \
             stroke-linecap=\"round\" stroke-linejoin=\"round\">"
        )?;
        writeln!(svg, "<title>{}</title>", escape(&self.title))?;
        writeln!(
            svg,
            "<rect width=\"{width}\" height=\"{height}\"{}/>",
            paint("fill", self.background)
        )?;
        for shape in &self.shapes {
            write_shape(svg, shape)?;
        }
        svg.write_str("</svg>\n")
    }
}

fn write_shape(svg: &mut String, shape: &Shape) -> std::fmt::Result {
    match shape {
        Shape::Polygon { points, color } => {
            writeln!(svg, "<path d=\"{}z\"{}/>", path(points), paint("fill", *color))
        }
        Shape::Line { points, width, color } => writeln!(
            svg,
            "<path d=\"{}\" fill=\"none\" stroke-width=\"{}\"{}/>",
            path(points),
            number(*width),
            paint("stroke", *color)
        ),
        Shape::Circle { center, radius, color } => writeln!(
            svg,
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\"{}/>",
            number(center[0]),
            number(center[1]),
            number(*radius),
            paint("fill", *color)
        ),
        Shape::Pixels(pixels) => {
            use base64::Engine;
            let Pixels {
                left,
                top,
                width,
                height,
                rgba,
            } = pixels;
            let png = png_of(*width as u32, *height as u32, png::ColorType::Rgba, rgba);
            let data = base64::engine::general_purpose::STANDARD.encode(png);
            writeln!(
                svg,
                "<image x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" \
                 href=\"data:image/png;base64,{data}\"/>"
            )
        }
        Shape::Text {
            at,
            text,
            size,
            anchor,
            color,
        } => {
            let anchor = match anchor {
                Anchor::Start => "",
                Anchor::Middle => " text-anchor=\"middle\"",
                Anchor::End => " text-anchor=\"end\"",
            };
            writeln!(
                svg,
                "<text x=\"{}\" y=\"{}\" font-size=\"{}\"{anchor}{}>{}</text>",
                number(at[0]),
                number(at[1]),
                number(*size),
                paint("fill", *color),
                escape(text)
            )
        }
    }
}

/// `M x y x y ...`: the path starts at the first point, and has lines to the other points.
fn path(points: &[Point]) -> String {
    let mut path = String::from("M");
    for (index, [x, y]) in points.iter().enumerate() {
        let space = if index == 0 { "" } else { " " };
        path.push_str(&format!("{space}{} {}", number(*x), number(*y)));
    }
    path
}

/// A number with one decimal: tenths of a pixel are enough.
pub fn number(value: f32) -> String {
    let text = format!("{value:.1}");
    let text = text.strip_suffix(".0").unwrap_or(&text);
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn paint(
    attribute: &str,
    Color {
        rgb: [red, green, blue],
        opacity,
    }: Color,
) -> String {
    let color = format!(" {attribute}=\"#{red:02x}{green:02x}{blue:02x}\"");
    if opacity < 1.0 {
        format!("{color} {attribute}-opacity=\"{opacity:.2}\"")
    } else {
        color
    }
}

/// Escapes text for XML: special characters become entities. Control characters, which XML forbids, are dropped.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            character if character.is_control() => {}
            character => escaped.push(character),
        }
    }
    escaped
}
