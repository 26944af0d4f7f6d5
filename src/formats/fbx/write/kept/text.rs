//! Converts a text FBX file to a binary FBX file. The text states no types of values, so the names of elements and the
//! types of properties determine the types of values. The names are those that Autodesk's SDK and Blender write.

use std::borrow::Cow;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::super::document::named;
use super::super::encode::{self, Array, Element, Value};
use super::super::{CREATOR, FbxVersion};
use super::tree::DEEPEST;

/// The first version whose objects have numbers.
const FIRST: i64 = 7000;

/// The sections that the encoder writes itself.
const OF_ENCODER: [&str; 3] = ["FileId", "CreationTime", "Creator"];

/// The types of properties with integers of 32 bits.
const INTEGERS: [&str; 8] = [
    "Action",
    "Blob",
    "Bool",
    "Integer",
    "Visibility Inheritance",
    "bool",
    "enum",
    "int",
];

/// The types of properties with integers of 64 bits.
const LONGS: [&str; 4] = ["KTime", "LongLong", "Time", "ULongLong"];

/// The elements with decimal numbers.
const DOUBLES: [&str; 10] = [
    "AudioColor",
    "CameraOrthoZoom",
    "Default",
    "DeformPercent",
    "Link_DeformAcuracy",
    "LookAt",
    "ModelUVScaling",
    "ModelUVTranslation",
    "Position",
    "Up",
];

/// The elements whose numbers have 64 bits: ids and times.
const LONG_ELEMENTS: [&str; 5] = ["Document", "LocalTime", "Node", "ReferenceTime", "RootNode"];

/// The lists of decimal numbers.
const DOUBLE_LISTS: [&str; 18] = [
    "Binormals",
    "BinormalsW",
    "Colors",
    "EdgeCrease",
    "FullWeights",
    "Matrix",
    "Normals",
    "NormalsW",
    "Points",
    "Tangents",
    "TangentsW",
    "Transform",
    "TransformAssociateModel",
    "TransformLink",
    "UV",
    "VertexCrease",
    "Vertices",
    "Weights",
];

/// The bytes of the binary file.
///
/// # Errors
/// The reason why the text cannot be converted, as a phrase.
pub(super) fn binary(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "its text is not UTF-8".to_owned())?;
    let number = text.split_once("FBXVersion:").map(|(_, rest)| rest.trim_start());
    let number = number.and_then(|rest| rest.split(|c: char| !c.is_ascii_digit()).next()?.parse::<i64>().ok());
    let number = number.ok_or("its text states no version")?;
    if number < FIRST {
        return Err(format!("it is text of the version {number}, below {FIRST}"));
    }
    let version = match number < i64::from(FbxVersion::V7500.number()) {
        true => FbxVersion::V7400,
        false => FbxVersion::V7500,
    };
    let mut reader = Reader { text, at: 0, version };
    let sections = reader.elements(&Place::default(), 0);
    let sections = sections.ok_or_else(|| format!("its text is not understood in line {}", reader.line()))?;
    let sections = sections
        .into_iter()
        .filter(|section| !OF_ENCODER.contains(&section.name()));
    encode::file(sections.collect(), version, CREATOR).map_err(|error| error.to_string())
}

/// The place of an element.
#[derive(Clone, Copy, Default)]
struct Place<'a> {
    /// The name of the parent.
    parent: &'a str,
    /// Whether the parent is a section.
    is_below_section: bool,
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    version: FbxVersion,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn line(&self) -> usize {
        1 + self.text[..self.at].matches('\n').count()
    }

    /// Skips white space, and comments to the end of their line.
    fn skip(&mut self) {
        loop {
            let rest = self.rest().trim_start();
            self.at = self.text.len() - rest.len();
            if !rest.starts_with(';') {
                return;
            }
            self.at += rest.find('\n').unwrap_or(rest.len());
        }
    }

    fn take(&mut self, mark: char) -> bool {
        let found = self.rest().starts_with(mark);
        self.at += if found { mark.len_utf8() } else { 0 };
        found
    }

    /// The text before the next of these characters.
    fn before(&mut self, ends: impl Fn(char) -> bool) -> &'a str {
        let rest = self.rest();
        let found = &rest[..rest.find(ends).unwrap_or(rest.len())];
        self.at += found.len();
        found
    }

    /// The elements up to a closing brace, or to the end of the file.
    fn elements(&mut self, place: &Place<'_>, depth: usize) -> Option<Vec<Element<'a>>> {
        let mut found = Vec::new();
        loop {
            self.skip();
            if self.rest().is_empty() {
                return (depth == 0).then_some(found);
            }
            if self.take('}') {
                return (depth > 0).then_some(found);
            }
            found.push(self.element(place, depth)?);
        }
    }

    fn element(&mut self, place: &Place<'_>, depth: usize) -> Option<Element<'a>> {
        let name = self.before(|c| c == ':' || c.is_whitespace());
        (self.take(':') && depth < DEEPEST && u8::try_from(name.len()).is_ok()).then_some(())?;
        let mut element = Element::new(name);
        let (mut count, mut kind) = (0, None);
        let mut continues = false;
        loop {
            self.at = self.text.len() - self.rest().trim_start_matches([' ', '\t', '\r']).len();
            match self.rest().chars().next() {
                Some(',') => {
                    self.at += 1;
                    continues = true;
                    continue;
                }
                Some('\n' | ';') if continues => {
                    self.skip();
                    continue;
                }
                Some('{') => {
                    self.at += 1;
                    let below = Place {
                        parent: name,
                        is_below_section: depth == 0,
                    };
                    return Some(element.block().children(self.elements(&below, depth + 1)?));
                }
                None | Some('\n' | ';' | '}') => return Some(element),
                Some('*') => return Some(element.with(self.list(name)?)),
                Some('"') => {
                    let text = self.string()?;
                    if name == "P" && count == 1 {
                        kind = Some(text.clone());
                    }
                    element = element.with(of_text(place, name, count, text)?);
                }
                Some(_) => {
                    let word = self.before(|c| c == ',' || c == '{' || c == '}' || c.is_whitespace());
                    element = element.with(match name {
                        "FBXVersion" => Value::Int(self.version.number() as i32),
                        _ => of_word(place, (name, kind.as_deref()), count, word)?,
                    });
                }
            }
            (count, continues) = (count + 1, false);
        }
    }

    fn string(&mut self) -> Option<Cow<'a, str>> {
        self.at += 1;
        let text = self.before(|c| c == '"');
        self.take('"').then_some(())?;
        Some(match text.contains('&') {
            true => text
                .replace("&quot;", "\"")
                .replace("&cr;", "\r")
                .replace("&lf;", "\n")
                .into(),
            false => text.into(),
        })
    }

    /// A list of numbers, such as `*3 { a: 0,1,2 }`.
    fn list(&mut self, name: &str) -> Option<Value<'a>> {
        self.before(|c| c == '{');
        let inside = self.rest().strip_prefix('{')?.split('}').next()?;
        self.at += inside.len() + 2;
        let numbers = inside.trim().strip_prefix("a:").unwrap_or_default().trim();
        let words = || numbers.split(',').map(str::trim).filter(|word| !word.is_empty());
        let doubles = || {
            words()
                .map(|word| word.parse::<f64>().ok())
                .collect::<Option<Vec<f64>>>()
        };
        Some(Value::Array(match name {
            "KeyTime" => Array::longs(words().map(|word| word.parse().ok()).collect::<Option<Vec<i64>>>()?),
            "KeyValueFloat" | "KeyAttrDataFloat" => {
                Array::floats(words().map(|word| word.parse().ok()).collect::<Option<Vec<f32>>>()?)
            }
            _ if DOUBLE_LISTS.contains(&name) || name.starts_with("KnotVector") => Array::doubles(doubles()?),
            _ => match words().map(|word| word.parse().ok()).collect::<Option<Vec<i32>>>() {
                Some(numbers) => Array::ints(numbers),
                None => Array::doubles(doubles()?),
            },
        }))
    }
}

/// A text in quotes. Names of objects have the class at their end in a binary file, and images are bytes.
fn of_text<'a>(place: &Place<'_>, name: &str, index: usize, text: Cow<'a, str>) -> Option<Value<'a>> {
    let is_name = match name {
        "SceneInfo" => index == 0,
        "Media" | "TextureName" => true,
        _ => place.is_below_section && place.parent == "Objects" && index == 1,
    };
    if let Some((class, own)) = text.split_once("::").filter(|_| is_name) {
        return Some(Value::Text(named(own, class).into()));
    }
    Some(match name {
        "BinaryData" | "Content" => Value::Bytes(STANDARD.decode(text.trim()).ok()?.into()),
        _ => Value::Text(text),
    })
}

/// A number or a letter. `kind` is the type of a property.
fn of_word<'a>(place: &Place<'_>, (name, kind): (&str, Option<&str>), index: usize, word: &str) -> Option<Value<'a>> {
    let is_id = place.is_below_section && place.parent == "Objects" && index == 0;
    let is_long = match kind {
        Some(kind) => LONGS.contains(&kind),
        None => is_id || LONG_ELEMENTS.contains(&name) || name == "C" && place.parent == "Connections",
    };
    let is_integer = match kind {
        Some(kind) => INTEGERS.contains(&kind),
        None => !DOUBLES.contains(&name),
    };
    if let ([letter], true) = (word.as_bytes(), word.chars().all(char::is_alphabetic)) {
        return Some(Value::Letter(*letter));
    }
    Some(match word.parse::<i64>() {
        Ok(number) if is_long => Value::Long(number),
        Ok(number) if kind == Some("Short") => Value::Short(i16::try_from(number).ok()?),
        Ok(number) if is_integer => i32::try_from(number).map_or(Value::Long(number), Value::Int),
        _ => Value::Double(word.parse().ok()?),
    })
}
