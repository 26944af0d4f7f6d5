//! A page with a player: one HTML file without external resources.
//!
//! The player is plain JavaScript in `view/`. It draws with WebGL 2, or with a 2D canvas if WebGL 2 is missing.
//! `build.rs` joins the modules of the player to one script. `player.js` plays clips from any data source. `page.js`
//! passes the data of this page to `player.js`.
//!
//! The page contains the motion as base64 bytes, in blocks of frames. JSON numbers would take three times the space and
//! most of the loading time. `pack.rs` documents the encoding and its precision.
//!
//! The drop page of `tools/wasm` uses the same template and the same player. The clips of the drop page are
//! [`PlayerClip`]s.

mod data;
mod listing;
mod marks;
#[doc(hidden)]
pub(crate) mod morphs;
#[doc(hidden)]
pub(crate) mod pack;
pub(crate) mod skin;

use std::borrow::Cow;
use std::collections::HashMap;

use mocap_edit::report::DetectedContacts;
use mocap_figure::Figure;
use mocap_figure::LimbAngles;
use mocap_scene::error::visible;
use serde::Serialize;

use self::data::{Description, describe};
pub use self::listing::ListingEntry;
use self::marks::bytes_of;
use self::morphs::MorphMotion;
use self::pack::Storage;
use self::skin::{PackedSkin, skin_of};
use super::built::{script, style};
use super::figure::Clip;
use super::svg::escape;

/// A clip on a page.
///
/// [`Page`](crate::Page) has an example.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct PageClip<'a> {
    /// The clip itself.
    pub clip: Clip<'a>,
    /// The figure of the scene. Default: [`Figure::new`].
    pub figure: Option<&'a Figure>,
    /// The `.glb` file for the download button; see `GltfOptions::write_glb`. Without this file, the button explains
    /// how to make one.
    pub glb: Option<&'a [u8]>,
    /// The bytes of the BVH source file. The page can save the file, and shows its lines next to the matrices.
    pub source: Option<&'a [u8]>,
    /// The ground contacts of the feet; see [`ContactOptions::detect`](mocap_edit::ContactOptions::detect).
    pub contacts: Option<&'a DetectedContacts>,
    /// The angles between the limbs and the limbs of the source motion; see `PoseRetargeter::limb_angles`.
    pub limb_angles: Option<&'a [LimbAngles]>,
}

impl<'a> PageClip<'a> {
    /// A clip with only its motion and its skin.
    pub fn new(clip: Clip<'a>) -> Self {
        Self {
            clip,
            figure: None,
            glb: None,
            source: None,
            contacts: None,
            limb_angles: None,
        }
    }

    /// Sets [`figure`](Self#structfield.figure), or unsets it.
    #[must_use]
    pub fn figure(mut self, figure: impl Into<Option<&'a Figure>>) -> Self {
        self.figure = figure.into();
        self
    }

    /// Sets [`glb`](Self#structfield.glb), or unsets it.
    #[must_use]
    pub fn glb(mut self, glb: impl Into<Option<&'a [u8]>>) -> Self {
        self.glb = glb.into();
        self
    }

    /// Sets [`source`](Self#structfield.source), or unsets it.
    #[must_use]
    pub fn source(mut self, source: impl Into<Option<&'a [u8]>>) -> Self {
        self.source = source.into();
        self
    }

    /// Sets [`contacts`](Self#structfield.contacts), or unsets it.
    #[must_use]
    pub fn contacts(mut self, contacts: impl Into<Option<&'a DetectedContacts>>) -> Self {
        self.contacts = contacts.into();
        self
    }

    /// Sets [`limb_angles`](Self#structfield.limb_angles), or unsets it.
    #[must_use]
    pub fn limb_angles(mut self, angles: impl Into<Option<&'a [LimbAngles]>>) -> Self {
        self.limb_angles = angles.into();
        self
    }
}

const PAGE: &str = include_str!("view/page.html");
#[derive(Serialize)]
struct PageData {
    clips: Vec<Description>,
}

/// A page that plays `clips` together, side by side or overlaid.
///
/// The keys of a clip are packed if they take more than 4 MiB. The page states the resulting joint error. In every
/// frame this error is at most a ten thousandth of the figure's reach (0.1 mm for a person). For motions of more than
/// 128 MiB (half an hour at 120 frames per second), it is at most 15 ten thousandths (1.4 mm for a person). A page with
/// an hour of motion takes about 20 MB.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::gltf::GltfOptions;
/// use mocap::render::{Clip, Page, PageClip};
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let glb = GltfOptions::default().write_glb(&scene)?;
/// let clip = PageClip::new(Clip { name: "Test", scene: &scene }).glb(&glb[..]);
/// let page = Page::new(&[clip]);
/// assert!(page.html.starts_with("<!doctype html>"));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Page {
    /// The HTML file.
    pub html: String,
    /// The size of the keys in bytes.
    pub motion: usize,
    /// The size of the skins in bytes: vertices, faces and weights.
    pub skins: usize,
    /// The size of the textures in bytes.
    pub textures: usize,
    /// The size of the download files in bytes.
    pub downloads: usize,
    /// For each clip, the parts of its skin that are not shown, and why.
    pub left_out: Vec<Vec<String>>,
}

/// A clip in the player's format: JSON text, and blocks of bytes with the numbers, to which the text refers.
///
/// [`PlayerClip::new`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct PlayerClip {
    /// The entry of `clips` in the page's JSON, with the ids of the blocks.
    pub description: String,
    /// The id and the bytes of each block.
    pub blocks: Vec<(String, Vec<u8>)>,
    /// The parts of the clip's skin that are not shown, and why.
    pub left_out: Vec<String>,
}

impl PlayerClip {
    /// Packs a clip for a player that is already loaded.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::render::{Clip, PageClip, PlayerClip};
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let packed = PlayerClip::new(&PageClip::new(Clip { name: "Test", scene: &scene }));
    /// assert!(packed.description.starts_with("{\"name\":\"Test\",\"file\":"));
    /// assert!(packed.description.contains("\"facts\":\"0.9 s, 10 frames at 10 fps"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn new(clip: &PageClip<'_>) -> Self {
        let mut blocks = Vec::new();
        let put = &mut |_: BlockKind, id: &str, bytes: Cow<'_, [u8]>| blocks.push((id.to_owned(), bytes.into_owned()));
        let (description, left_out) = pack_clip(clip, 0, Storage::Rows, &mut SharedBlocks::default(), put);
        Self {
            description: json(&description),
            blocks,
            left_out,
        }
    }
}

impl Page {
    /// The page of these clips. Clips with equal skins share one skin.
    pub fn new(clips: &[PageClip<'_>]) -> Self {
        let (mut keys, mut skins, mut textures, mut downloads) = Default::default();
        let mut report = Self::default();
        let mut descriptions = Vec::new();
        let mut shared = SharedBlocks::default();
        for (index, clip) in clips.iter().enumerate() {
            let put = &mut |kind: BlockKind, id: &str, bytes: Cow<'_, [u8]>| {
                let part: &mut String = match kind {
                    BlockKind::Keys => &mut keys,
                    BlockKind::Skin => &mut skins,
                    BlockKind::Texture => &mut textures,
                    BlockKind::Download => &mut downloads,
                };
                push_block(part, id, &bytes);
            };
            let (description, left_out) = pack_clip(clip, index, Storage::Clips, &mut shared, put);
            report.left_out.push(left_out);
            descriptions.push(description);
        }
        report.motion = keys.len();
        report.skins = skins.len();
        report.textures = textures.len();
        report.downloads = downloads.len();
        let names: Vec<_> = clips.iter().map(|page| page.clip.name).collect();
        // Inside a script element, only `<` can end the element early.
        let data = json(&PageData { clips: descriptions }).replace('<', "\\u003c");
        let title = escape(&visible(&names.join(", ")));
        report.html = page(&title, &data, [&keys, &skins, &textures, &downloads]);
        report
    }

    /// The page without clips. A program replaces `{{data}}` by the JSON of the clips, and `{{blocks}}` by the blocks
    /// of the clips.
    #[doc(hidden)]
    pub fn without_clips() -> String {
        page("mocap", "{{data}}", ["{{blocks}}", "", "", ""])
    }
}

fn page(title: &str, data: &str, [keys, skins, textures, downloads]: [&str; 4]) -> String {
    filled(PAGE, |name| match name {
        "title" => title.into(),
        "policy" => POLICY.into(),
        "style" => style().into(),
        "script" => script().into(),
        "data" => data.into(),
        "keys" => keys.into(),
        "skins" => skins.into(),
        "textures" => textures.into(),
        "downloads" => downloads.into(),
        // The drop page has its own buttons and its own panel here.
        "buttons" | "desk" => "".into(),
        unknown => unreachable!("the page has no placeholder called {unknown}"),
    })
}

/// The `Content-Security-Policy` of a page: it loads nothing and connects to nothing.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";

/// The contents of a block of bytes.
#[derive(Clone, Copy)]
enum BlockKind {
    Keys,
    Skin,
    Texture,
    Download,
}

/// The blocks of all skins and textures so far, so that equal blocks are stored once.
#[derive(Default)]
struct SharedBlocks(HashMap<Vec<u8>, String>);

impl SharedBlocks {
    /// The id of a block. A new block is passed to `put`.
    fn id(&mut self, kind: BlockKind, bytes: &[u8], put: &mut impl FnMut(BlockKind, &str, Cow<'_, [u8]>)) -> String {
        if let Some(id) = self.0.get(bytes) {
            return id.clone();
        }
        let id = format!("shared-{}", self.0.len());
        put(kind, &id, bytes.into());
        self.0.insert(bytes.to_vec(), id.clone());
        id
    }
}

/// The description of a clip, and the parts of its skin that are not shown. Its blocks are passed to `put` one after
/// another.
fn pack_clip(
    clip: &PageClip<'_>,
    index: usize,
    storage: Storage,
    shared: &mut SharedBlocks,
    put: &mut impl FnMut(BlockKind, &str, Cow<'_, [u8]>),
) -> (Description, Vec<String>) {
    let (mut description, blocks) = describe(clip, index, storage);
    for (id, block) in std::iter::zip(&description.blocks, blocks) {
        put(BlockKind::Keys, id, block.into());
    }
    if let (Some(limbs), Some(angles)) = (&description.limbs, clip.limb_angles) {
        put(BlockKind::Keys, &limbs.id, bytes_of(angles).into());
    }
    let (skin, mut left_out) = skin_of(clip.clip.scene);
    if let Some(PackedSkin { motion, .. }) = &skin {
        let frames = clip.clip.frames() as usize;
        match MorphMotion::new(clip.clip.scene, frames, motion, format!("morphs-{index}")) {
            Ok(Some((morphs, bytes))) => {
                put(BlockKind::Keys, &morphs.id, bytes.into());
                description.morphs = Some(morphs);
            }
            Ok(None) => {}
            Err(note) => left_out.push(note),
        }
    }
    description.skin = skin.map(|PackedSkin { mut skin, bytes, .. }| {
        skin.id = shared.id(BlockKind::Skin, &bytes, put);
        for block in &mut skin.textures {
            let bytes = &clip.clip.scene.textures[block.source].bytes;
            block.id = shared.id(BlockKind::Texture, bytes, put);
        }
        skin
    });
    description.warnings.extend(left_out.iter().cloned());
    if let (Some(id), Some(glb)) = (&description.glb, clip.glb) {
        put(BlockKind::Download, id, glb.into());
    }
    if let (Some(file), Some(source)) = (&description.source, clip.source) {
        put(BlockKind::Download, &file.id, source.into());
    }
    (description, left_out)
}

fn json(data: &impl Serialize) -> String {
    serde_json::to_string(data).expect("the data has neither maps nor numbers that JSON lacks")
}

/// An element that holds bytes and is not executed.
fn push_block(page: &mut String, id: &str, bytes: &[u8]) {
    use base64::Engine;
    page.push_str(&format!("<script type=\"application/octet-stream\" id=\"{id}\">"));
    base64::engine::general_purpose::STANDARD.encode_string(bytes, page);
    page.push_str("</script>\n");
}

/// Replaces every `{{name}}` of a template. Replacements are not searched again.
pub fn filled<'a>(template: &str, value: impl Fn(&str) -> Cow<'a, str>) -> String {
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
