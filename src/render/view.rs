//! A page with a player: one HTML file without external resources.
//!
//! The player is plain JavaScript in `view/`, drawn with WebGL 2, or with a 2D canvas without it. The page has the
//! motion as base64 of 32-bit floats, track by track, because JSON numbers would take three times the space and most of
//! the loading time.

mod data;
mod listing;

use serde::Serialize;

use self::data::{Description, Floats, describe};
pub use self::listing::{ListingEntry, listing};
use super::figure::Clip;
use super::svg::escape;

/// A clip on a page.
#[derive(Clone, Copy, Debug)]
pub struct PageClip<'a> {
    /// The clip itself.
    pub clip: Clip<'a>,
    /// The `.glb` file of the download button; see [`gltf::write_glb`](crate::format::gltf::write_glb).
    pub glb: &'a [u8],
}

const PAGE: &str = include_str!("view/page.html");
const STYLE: &str = include_str!("view/page.css");

/// The scripts of the player; each uses only those before it.
const SCRIPT: [&str; 10] = [
    include_str!("view/math.js"),
    include_str!("view/clip.js"),
    include_str!("view/batch.js"),
    include_str!("view/renderer_gl.js"),
    include_str!("view/renderer_2d.js"),
    include_str!("view/camera.js"),
    include_str!("view/chart.js"),
    include_str!("view/panel.js"),
    include_str!("view/stage.js"),
    include_str!("view/controls.js"),
];

#[derive(Serialize)]
struct PageData<'a> {
    clips: Vec<Description<'a>>,
}

/// A page that plays `clips` together, side by side or overlaid.
///
/// ```
/// use mocap::render::{Clip, PageClip, page};
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let glb = mocap::gltf::write_glb(&scene, &Default::default())?;
/// let html = page(&[PageClip { clip: Clip { name: "Test", scene: &scene }, glb: &glb }]);
/// assert!(html.starts_with("<!doctype html>"));
/// # Ok::<(), mocap::Error>(())
/// ```
pub fn page(clips: &[PageClip<'_>]) -> String {
    let mut blocks = String::new();
    let mut descriptions = Vec::new();
    for (index, PageClip { clip, glb }) in clips.iter().enumerate() {
        let mut floats = Floats::default();
        descriptions.push(describe(clip, index, &mut floats));
        push_block(&mut blocks, &format!("clip-{index}"), &floats.into_bytes());
        push_block(&mut blocks, &format!("glb-{index}"), glb);
    }
    let names: Vec<_> = clips.iter().map(|page| page.clip.name).collect();
    let data = PageData { clips: descriptions };
    let data = serde_json::to_string(&data).expect("the data has neither maps nor numbers that JSON lacks");
    // Inside a script element only `<` can end it early.
    let data = data.replace('<', "\\u003c");
    filled(PAGE, |name| match name {
        "title" => escape(&names.join(", ")),
        "style" => lean(STYLE),
        "script" => SCRIPT.map(lean).concat(),
        "data" => data.clone(),
        "blocks" => blocks.clone(),
        unknown => unreachable!("the page has no place called {unknown}"),
    })
}

/// An element that holds bytes and is not run.
fn push_block(page: &mut String, id: &str, bytes: &[u8]) {
    use base64::Engine;
    page.push_str(&format!("<script type=\"application/octet-stream\" id=\"{id}\">"));
    base64::engine::general_purpose::STANDARD.encode_string(bytes, page);
    page.push_str("</script>\n");
}

/// A template with every `{{name}}` replaced. Replacements are not searched again.
fn filled(template: &str, value: impl Fn(&str) -> String) -> String {
    let mut text = String::new();
    let mut rest = template;
    while let Some((before, (name, after))) = rest
        .split_once("{{")
        .and_then(|(before, from_name)| Some((before, from_name.split_once("}}")?)))
    {
        text.push_str(before);
        text.push_str(&value(name));
        rest = after;
    }
    text + rest
}

/// Source text without indentation and comments.
fn lean(source: &str) -> String {
    let lines = source.lines().map(str::trim);
    let kept = lines.filter(|line| !line.is_empty() && !line.starts_with("//"));
    kept.flat_map(|line| [line, "\n"]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_is_small() {
        let bytes: usize = SCRIPT.map(lean).iter().map(String::len).sum();
        assert!(bytes < 60_000, "{bytes} bytes");
    }

    #[test]
    fn a_template_is_filled_once() {
        let value = |name: &str| format!("<{name} {{{{x}}}}>");
        assert_eq!(filled("a {{b}} c {{d}}{", value), "a <b {{x}}> c <d {{x}}>{");
    }
}
