//! Selects the animations to keep.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use mocap_scene::error::{Code, Diagnostic, Result, nearest};
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::AppliedStep;

/// The animations of a file to keep.
///
/// [`Importer::clips`](crate::Importer::clips) has an example.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "ClipText", into = "String")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(with = "ClipText"))]
#[non_exhaustive]
pub enum Clips {
    /// All animations.
    #[default]
    All,
    /// The animation with this index, from 0.
    Index(usize),
    /// The first animation with this name.
    Name(String),
}

impl FromStr for Clips {
    type Err = std::convert::Infallible;

    /// Parses `all`, an index from 0, or else a name. The prefix `name:` makes the rest a name, even `all` or `3`.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match (text, text.strip_prefix(NAME), text.parse()) {
            (_, Some(name), _) => Self::Name(name.to_owned()),
            ("all", ..) => Self::All,
            (_, _, Ok(index)) => Self::Index(index),
            (name, ..) => Self::Name(name.to_owned()),
        })
    }
}

/// Writes the text that [`Clips::from_str`] parses.
impl fmt::Display for Clips {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str("all"),
            Self::Index(index) => index.fmt(f),
            Self::Name(name) if name.parse() == Ok(self.clone()) => f.write_str(name),
            Self::Name(name) => write!(f, "{NAME}{name}"),
        }
    }
}

/// The prefix of a clip name that would otherwise have another meaning.
const NAME: &str = "name:";

impl From<Clips> for String {
    fn from(clips: Clips) -> Self {
        clips.to_string()
    }
}

/// The value in a JSON file: a name, or a number from 0.
#[derive(Deserialize)]
#[serde(untagged, expecting = "the name of a clip, or its number from 0")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
enum ClipText {
    Index(usize),
    Name(String),
}

impl From<ClipText> for Clips {
    fn from(text: ClipText) -> Self {
        match text {
            ClipText::Index(index) => Self::Index(index),
            ClipText::Name(name) => match name.parse() {
                Ok(clips) => clips,
                Err(never) => match never {},
            },
        }
    }
}

impl Clips {
    /// Drops all animations but the chosen one.
    #[doc(hidden)]
    pub fn select(&self, scene: &mut Scene) -> Result<()> {
        if let Some(index) = self.index_in(scene)? {
            scene.keep_animation(index);
            scene.metadata.steps.push(AppliedStep::SelectClip { index });
        }
        Ok(())
    }

    /// The index of the chosen animation; `None` for all.
    #[doc(hidden)]
    pub fn index_in(&self, scene: &Scene) -> Result<Option<usize>> {
        let index = match self {
            Self::All => return Ok(None),
            Self::Index(index) => Some(*index).filter(|&index| index < scene.animations.len()),
            Self::Name(name) => scene.animations.iter().position(|clip| clip.name == *name),
        };
        if index.is_none() {
            let names = scene.animations.iter().enumerate();
            let known: Vec<_> = names
                .map(|(index, clip)| format!("{index} \"{}\"", clip.name))
                .collect();
            let found = match self {
                Self::Name(name) => format!("\"{name}\""),
                Self::Index(index) => format!("{index}"),
                Self::All => String::new(),
            };
            let known = if known.is_empty() {
                "no clip".to_owned()
            } else {
                known.join(", ")
            };
            let diagnostic =
                Diagnostic::new(Code::InvalidValue, "the file does not have this clip").expected_found(known, found);
            let near = match self {
                Self::Name(name) => nearest(name, scene.animations.iter().map(|clip| clip.name.as_str())),
                _ => None,
            };
            return Err(match near {
                Some(near) => diagnostic.help(format!("did you mean \"{near}\"?")).into(),
                None => diagnostic.into(),
            });
        }
        Ok(index)
    }
}
