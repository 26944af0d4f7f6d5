//! A page that lists the clips of a folder.

use mocap_scene::error::visible;

use super::super::figure::Clip;
use super::super::sheet::thumbnail;
use super::super::svg::escape;
use super::filled;

const PAGE: &str = include_str!("listing.html");

/// An entry in a list of clips.
///
/// [`ListingEntry::page`] has an example.
#[derive(Clone, Debug)]
pub struct ListingEntry {
    name: String,
    link: Option<String>,
    thumbnail: String,
    facts: String,
    notes: Vec<String>,
}

impl ListingEntry {
    /// An entry for a clip whose player is at `link`, relative to the list.
    pub fn new(clip: &Clip<'_>, link: &str) -> Self {
        Self {
            name: clip.name.to_owned(),
            link: Some(link.to_owned()),
            thumbnail: thumbnail(clip, 300, 150).to_svg(),
            facts: clip.facts(),
            notes: clip.scene.warnings.iter().map(ToString::to_string).collect(),
        }
    }

    /// An entry for a file that could not be read.
    pub fn failed(name: &str, error: &str) -> Self {
        Self {
            name: name.to_owned(),
            link: None,
            thumbnail: String::new(),
            facts: "not read".to_owned(),
            notes: vec![error.to_owned()],
        }
    }

    fn html(&self) -> String {
        let name = escape(&visible(&self.name));
        let (facts, thumbnail) = (escape(&self.facts), &self.thumbnail);
        let heading = match &self.link {
            Some(link) => format!(
                "<a href=\"{}\">{thumbnail}<strong>{name}</strong></a>",
                escape(&encoded(link))
            ),
            None => format!("<strong>{name}</strong>"),
        };
        let notes: String = self
            .notes
            .iter()
            .map(|note| format!("<li>{}</li>", escape(&visible(note))))
            .collect();
        let notes = match (self.notes.len(), &self.link) {
            (0, _) => String::new(),
            (_, None) => format!("<ul>{notes}</ul>"),
            (1, _) => format!("<details><summary>1 warning</summary><ul>{notes}</ul></details>"),
            (count, _) => format!("<details><summary>{count} warnings</summary><ul>{notes}</ul></details>"),
        };
        format!("<li data-name=\"{name}\">{heading}<p>{facts}</p>{notes}</li>\n")
    }
}

/// A relative URL with reserved characters percent-encoded.
fn encoded(link: &str) -> String {
    let mut encoded = String::new();
    for byte in link.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' => encoded.push(char::from(byte)),
            _ => encoded.push_str(&format!("%{byte:02X}")),
        }
    }
    encoded
}

impl ListingEntry {
    /// A page that lists clips with a picture, their length and their warnings, and links to the player of each clip.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::render::{Clip, ListingEntry};
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let entry = ListingEntry::new(&Clip { name: "Test", scene: &scene }, "clips/Test.html");
    /// assert!(ListingEntry::page("My clips", &[entry]).contains("<a href=\"clips/Test.html\">"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn page(title: &str, entries: &[Self]) -> String {
        let count = match entries.len() {
            1 => "1 file".to_owned(),
            count => format!("{count} files"),
        };
        filled(PAGE, |name| match name {
            "title" => escape(&visible(title)).into(),
            "count" => count.as_str().into(),
            "entries" => entries.iter().map(Self::html).collect::<String>().into(),
            unknown => unreachable!("the page has no placeholder called {unknown}"),
        })
    }
}
