//! Reads the side, the part of the body and the number from the name of a joint. All code that interprets names of
//! joints uses this module.

pub mod words;

use mocap_scene::error::{Code, Diagnostic, Result, nearest};
use mocap_scene::scene::{HumanoidBone, NodeId, Scene, Side};

use self::words::{AnimalPart, FINGER_WORDS, FINGERS_WITHIN, FingerKind, HELPERS, Meaning, NOISE, Part, meaning};

/// The meaning of a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Name {
    /// Left or right, if the name has a side.
    pub side: Option<Side>,
    /// The parts of the body that the name can mean.
    pub meaning: Meaning,
    /// The finger of the joint.
    pub finger: Option<FingerKind>,
    /// Whether the joint helps another joint, as twist joints do, or is the end of another joint.
    pub is_helper: bool,
    /// Whether it is a twist joint, which takes a part of a bone's twist.
    pub is_twist: bool,
    /// The part of an animal that the name means, if people do not have the part.
    pub(crate) animal: Option<AnimalPart>,
    /// The name without its side, to find the joint of the other side.
    pub(crate) without_side: String,
    /// The numbers in the name, as written.
    pub numbers: Vec<String>,
}

impl Name {
    /// Reads the name of a joint.
    pub fn read(name: &str) -> Self {
        // Removes a namespace, as in `mixamorig:Hips`, or the path of a node, which some programs write.
        let name = name.rsplit([':', '|', '/']).next().unwrap_or(name);
        let starts_as_helper = name.starts_with("__");
        let words = split(name);
        let mut numbers = Vec::new();
        let mut letters = Vec::new();
        for word in words {
            if word.starts_with(|c: char| c.is_ascii_digit()) {
                numbers.push(word);
            } else {
                letters.push(word);
            }
        }
        let mut side = take_side(&mut letters);
        let mut is_helper = starts_as_helper || letters.iter().any(|word| HELPERS.contains(&&**word));
        // `L5` and `T12` are vertebrae: the `l` is no left side.
        let vertebra = match (letters.as_slice(), numbers.as_slice(), side) {
            ([], [number], Some(Side::Left)) => meaning(&format!("l{number}")),
            ([letter], [number], None) if letter == "t" => meaning(&format!("t{number}")),
            _ => &[],
        };
        if !vertebra.is_empty() {
            return Self {
                meaning: vertebra,
                without_side: "vertebra".to_owned(),
                numbers,
                ..Self::default()
            };
        }
        let joined = letters.concat();
        let is_twist = letters.iter().any(|word| is_twist(word));
        is_helper |= is_twist;
        let animal = letters.iter().find_map(|word| AnimalPart::of(word));
        let is_of_foot = ["foot", "toe"].iter().any(|word| joined.contains(word));
        let mut finger = finger_of(&joined, &letters).filter(|_| !is_of_foot);
        let mut found = meaning_of(&letters);
        if found.is_empty() && side.is_none() && finger.is_none() {
            // `lhumerus`, `hipright`: a side joined to a word.
            for word in &letters {
                if let Some((glued, meaning)) = glued_side(word) {
                    (side, found) = (Some(glued), meaning);
                    break;
                }
            }
        }
        // `lthumb`: a side joined to a finger.
        if found.is_empty()
            && side.is_none()
            && let Some(first) = letters.first()
            && let Some(stripped) = first.strip_prefix(['l', 'r']).filter(|stripped| stripped.len() <= 7)
            && let Some(kind) = finger_of(stripped, &[stripped.to_owned()]).filter(|_| !is_of_foot)
        {
            side = Some(if first.starts_with('l') {
                Side::Left
            } else {
                Side::Right
            });
            finger = Some(kind);
        }
        if finger.is_some() {
            found = &[(Part::Finger, 1.0)];
        }
        // With a side, `hip` is the joint of the thigh.
        if side.is_some() && found == meaning("hip") {
            found = meaning("thigh");
        } else if side.is_some() && found == meaning("pelvis") {
            found = meaning("hipjoint");
        }
        // MikuMikuDance: `左足IK`, `左肩P`, `左足D` double a joint.
        if !name.is_ascii() && (name.ends_with(['P', 'C', 'D']) || name.ends_with("IK")) {
            is_helper = true;
        }
        Self {
            side,
            meaning: found,
            finger,
            is_helper,
            is_twist,
            animal,
            without_side: joined,
            numbers,
        }
    }

    /// How well the name fits `part`, at most 1. The value is 0 if the name has no meaning, and below 0 if it means
    /// another bone.
    pub(crate) fn fits(&self, part: Part) -> f32 {
        let weight = self
            .meaning
            .iter()
            .find(|(other, _)| *other == part)
            .map(|(_, weight)| *weight);
        match weight {
            Some(_) if self.is_helper => 0.0,
            Some(weight) => weight,
            None if self.is_helper => -0.7,
            None if self.meaning.is_empty() => 0.0,
            None => -1.0,
        }
    }

    /// Whether the name means `part` and nothing else.
    pub(crate) fn says(&self, part: Part) -> bool {
        !self.is_helper
            && self
                .meaning
                .first()
                .is_some_and(|(first, weight)| *first == part && *weight >= 0.5)
    }

    /// Whether `other` is the name of the same joint on the other side.
    pub fn mirrors(&self, other: &Self) -> bool {
        self.side.is_some()
            && other.side.is_some()
            && self.side != other.side
            && self.without_side == other.without_side
            && self.numbers == other.numbers
    }

    /// For each name of a list, the index of the name of the same thing on the other side. In MikuMikuDance, only the
    /// right one of some pairs of morph targets has a side: `ウィンク` and `ウィンク右`.
    pub fn pairs(names: &[&str]) -> Vec<Option<usize>> {
        let read: Vec<Self> = names.iter().map(|name| Self::read(name)).collect();
        let is_pair = |a: &Self, b: &Self| a.mirrors(b) && !a.without_side.is_empty();
        let is_of_mmd = |index: usize, other: usize| {
            let (right, left) = (&read[index], &read[other]);
            let is_alike = right.without_side == left.without_side && right.numbers == left.numbers;
            names[index].contains('右') && left.side.is_none() && is_alike
        };
        let mut pairs = vec![None; names.len()];
        let mut pair = |fits: &dyn Fn(usize, usize) -> bool| {
            for index in 0..names.len() {
                let is_free = |other: &usize| pairs[*other].is_none() && pairs[index].is_none();
                if let Some(other) = (0..names.len()).find(|other| is_free(other) && fits(index, *other)) {
                    (pairs[index], pairs[other]) = (Some(other), Some(index));
                }
            }
        };
        pair(&|index, other| is_pair(&read[index], &read[other]));
        pair(&is_of_mmd);
        pairs
    }
}

/// The katakana of the half-width characters from U+FF66 on.
const KATAKANA: &str =
    "ヲァィゥェォャュョッーアイウエオカキクケコサシスセソタチツテトナニヌネノハヒフヘホマミムメモヤユヨラリルレロワン";

/// The words of a name, without its numbers, in lower case.
#[cfg(feature = "robots")]
pub(crate) fn words(name: &str) -> Vec<String> {
    let mut words = split(name);
    words.retain(|word| !word.starts_with(|c: char| c.is_ascii_digit()));
    words
}

/// Splits at characters other than letters and digits, between letters and digits, and at capitals that begin a word.
/// Words are in lower case. `LHipJoint` gives `l`, `hip`, `joint`; `Bip01 L Toe0` gives `bip`, `01`, `l`, `toe`, `0`.
fn split(name: &str) -> Vec<String> {
    let usual_width = |c: char| match c {
        '\u{FF01}'..='\u{FF5E}' => char::from_u32(c as u32 - 0xFEE0).unwrap_or(c),
        '\u{FF66}'..='\u{FF9D}' => KATAKANA.chars().nth(c as usize - 0xFF66).unwrap_or(c),
        _ => c,
    };
    let letters: Vec<char> = name.chars().map(usual_width).collect();
    let mut words = Vec::new();
    let mut word = String::new();
    for (index, &letter) in letters.iter().enumerate() {
        let before = index.checked_sub(1).map(|before| letters[before]);
        let begins = before.is_some_and(|before| {
            let next_is_lower = letters.get(index + 1).is_some_and(|next| next.is_lowercase());
            before.is_ascii_digit() != letter.is_ascii_digit()
                || (before.is_lowercase() && letter.is_uppercase())
                || (before.is_uppercase() && letter.is_uppercase() && next_is_lower)
                || is_side_sign(before)
                || is_side_sign(letter)
        });
        if (begins || !letter.is_alphanumeric()) && !word.is_empty() {
            words.push(std::mem::take(&mut word));
        }
        if letter.is_alphanumeric() {
            word.extend(letter.to_lowercase());
        }
    }
    if !word.is_empty() {
        words.push(word);
    }
    words
}

fn is_side_sign(letter: char) -> bool {
    matches!(letter, '左' | '右')
}

/// Removes the word of the side from `words`, and returns the side.
fn take_side(words: &mut Vec<String>) -> Option<Side> {
    for (index, word) in words.iter().enumerate() {
        let side = match word.as_str() {
            "l" | "left" | "lft" | "lt" | "左" | "izquierda" | "izq" | "esquerda" | "esq" | "gauche" | "links"
            | "linker" | "linke" | "linkes" | "lf" => Side::Left,
            "r" | "right" | "rgt" | "rt" | "右" | "derecha" | "der" | "direita" | "dir" | "droite" | "droit"
            | "rechts" | "rechter" | "rechte" | "rechtes" | "rght" => Side::Right,
            _ => continue,
        };
        words.remove(index);
        return Some(side);
    }
    for word in words.iter_mut() {
        for (spelt, side) in [("left", Side::Left), ("right", Side::Right)] {
            let rest = word.strip_prefix(spelt).or_else(|| word.strip_suffix(spelt));
            if let Some(rest) = rest.filter(|rest| !rest.is_empty()) {
                *word = rest.to_owned();
                return Some(side);
            }
        }
    }
    None
}

/// Whether a word means a twist joint. Such words are `twist`, `roll`, and words that end with these, such as
/// `forearmroll`. Exceptions are words such as `controller` and `scroll`.
fn is_twist(word: &str) -> bool {
    let has_part = |rest: &str| !meaning(rest).is_empty() || glued_side(rest).is_some();
    word == "roll"
        || word == "rollbone"
        || word.contains("twist")
        || word
            .strip_suffix("roll")
            .or_else(|| word.strip_prefix("roll"))
            .is_some_and(has_part)
}

/// The side and the meaning of a word with a joined side, such as `lhumerus`.
fn glued_side(word: &str) -> Option<(Side, Meaning)> {
    [('l', Side::Left), ('r', Side::Right)]
        .into_iter()
        .find_map(|(letter, side)| {
            let rest = word.strip_prefix(letter).or_else(|| word.strip_suffix(letter))?;
            let found = meaning(rest);
            (!found.is_empty()).then_some((side, found))
        })
}

/// The meaning of the longest sequence of words with a meaning. Of two equally long sequences, the later one.
fn meaning_of(words: &[String]) -> Meaning {
    let whole = meaning(&words.concat());
    if !whole.is_empty() {
        return whole;
    }
    let telling: Vec<&str> = words
        .iter()
        .map(String::as_str)
        .filter(|word| !NOISE.contains(word))
        .collect();
    for length in (1..=telling.len()).rev() {
        for row in telling.windows(length).rev() {
            let found = meaning(&row.concat());
            if !found.is_empty() {
                return found;
            }
        }
    }
    &[]
}

fn finger_of(joined: &str, words: &[String]) -> Option<FingerKind> {
    let within = FINGERS_WITHIN
        .iter()
        .find(|(_, spellings)| spellings.iter().any(|spelling| joined.contains(spelling)));
    let as_word = || {
        FINGER_WORDS
            .iter()
            .find(|(_, spellings)| words.iter().any(|word| spellings.contains(&&**word)))
    };
    // `Spine_Mid` and `MidHip` are in the middle of the body, not joints of the middle finger.
    let is_of_trunk = || {
        words
            .iter()
            .any(|word| matches!(word.as_str(), "spine" | "hip" | "back" | "shoulder" | "chest"))
    };
    within
        .or_else(|| as_word().filter(|_| !is_of_trunk()))
        .map(|(finger, _)| *finger)
}

/// The node with the name `name`, or the joint of the bone with this name.
pub fn node_named(scene: &Scene, name: &str, joint: impl Fn(HumanoidBone) -> Option<NodeId>) -> Result<NodeId> {
    let plain = |name: &str| name.replace(['-', '_', ' '], "").to_lowercase();
    let of_name = scene.nodes.iter().position(|node| node.name == name).map(NodeId::new);
    let bone = || {
        HumanoidBone::ALL
            .iter()
            .find(|bone| plain(bone.as_str()) == plain(name))
    };
    if let Some(node) = of_name.or_else(|| joint(*bone()?)) {
        return Ok(node);
    }
    let unknown = match bone() {
        Some(bone) => format!("no joint has the bone {}", bone.as_str()),
        None => format!("no node or bone is called {name:?}"),
    };
    let names = scene.nodes.iter().map(|node| node.name.as_str());
    let bones = HumanoidBone::ALL.iter().filter(|bone| joint(**bone).is_some());
    let bones = bones.map(|bone| bone.as_str());
    let unknown = Diagnostic::new(Code::InvalidValue, unknown);
    Err(match nearest(name, names.chain(bones)) {
        Some(near) => unknown.help(format!("did you mean {near}?")),
        None => unknown.help("`mocap skeleton FILE` prints the bones, and `mocap dump FILE` prints every node"),
    }
    .into())
}
