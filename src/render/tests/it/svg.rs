//! Tests drawings that are written as SVG.

use mocap::render::Drawing;
use mocap_render::internals::{Anchor, Color, number};

#[test]
fn a_name_cannot_break_out_of_its_text() {
    let mut drawing = Drawing::new(10, 10, Color::hex(0), "<b>");
    drawing.text(
        [1.0, 2.0],
        "a</text><script>&\"\u{1}",
        8.0,
        Anchor::End,
        Color {
            opacity: 0.5,
            ..Color::hex(0xFF8000)
        },
    );
    let svg = drawing.to_svg();
    assert!(svg.contains("<title>&lt;b&gt;</title>"));
    assert!(svg.contains(
        "<text x=\"1\" y=\"2\" font-size=\"8\" text-anchor=\"end\" fill=\"#ff8000\" fill-opacity=\"0.50\">\
         a&lt;/text&gt;&lt;script&gt;&amp;&quot;</text>"
    ));
}

#[test]
fn numbers_are_short() {
    assert_eq!([12.0, -0.04, 1.25, 3.96].map(number), ["12", "0", "1.2", "4"]);
}
