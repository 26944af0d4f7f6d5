//! Reads the parameter section: values by group and name.

use std::collections::HashMap;
use std::ops::Range;

use mocap_scene::error::Diagnostic;

use super::Failure;
use super::bytes::{Bytes, Processor};
use crate::text::decode_name;

/// The values of one parameter.
#[derive(Clone, Debug, PartialEq)]
enum Values {
    Texts(Vec<String>),
    /// Numbers with the sizes of their array, fastest index first.
    Numbers(Vec<f64>, Vec<usize>),
}

/// The parameters of a file.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Parameters {
    /// Whether the list has an end mark.
    pub(super) is_ended: bool,
    /// Values by group number and name, in capitals.
    values: HashMap<(i8, String), Values>,
    /// Group numbers by name, in capitals.
    groups: HashMap<String, i8>,
}

/// Reads the section, which is the range `section` of the file.
pub(super) fn read(file: &[u8], section: Range<usize>, processor: Processor) -> Result<Parameters, Failure> {
    let mut parameters = Parameters::default();
    let is_whole = section.end < file.len();
    let mut bytes = Bytes::new(&file[..section.end], processor);
    bytes.set_offset(section.start);
    // An empty name, or the end of the section, ends the list.
    while let Ok(length) = bytes.byte() {
        if length == 0 {
            parameters.is_ended = true;
            break;
        }
        // A negative length locks the parameter for editors. A reader ignores the sign.
        let length = length.cast_signed().unsigned_abs();
        let in_list = |failure: Failure| in_parameter(*failure, None, is_whole);
        let id = bytes.byte().map_err(in_list)?.cast_signed();
        let name = text(bytes.take(length.into()).map_err(in_list)?).to_ascii_uppercase();
        let start = bytes.offset();
        let to_next = bytes.word().map_err(in_list)?;
        if id < 0 {
            parameters.groups.entry(name).or_insert(id);
        } else {
            let values =
                read_values(&mut bytes, processor).map_err(|failure| in_parameter(*failure, Some(&name), is_whole))?;
            // A group has the number -n, its parameters n.
            parameters.values.insert((-id, name), values);
        }
        if to_next == 0 {
            parameters.is_ended = true;
            break;
        }
        bytes.set_offset(start + usize::from(to_next));
    }
    Ok(parameters)
}

/// The error for a parameter that is longer than the remaining bytes: its length is wrong, or the file is cut off.
fn in_parameter(mut diagnostic: Diagnostic, name: Option<&str>, is_whole: bool) -> Failure {
    let what = name.map_or("the list of parameters".to_owned(), |name| {
        format!("the parameter {name:?}")
    });
    if is_whole {
        diagnostic.message = format!("{what} reaches beyond the end of its section");
        diagnostic.help = Some("export the file again".to_owned());
    } else {
        diagnostic.message = format!("the file is cut off inside {what}");
    }
    Box::new(diagnostic)
}

/// Reads type, dimensions and values.
fn read_values(bytes: &mut Bytes<'_>, processor: Processor) -> Result<Values, Failure> {
    let kind = bytes.byte()?.cast_signed();
    let dimension_count = bytes.byte()?;
    let dimensions: Vec<usize> = bytes
        .take(dimension_count.into())?
        .iter()
        .map(|&size| size.into())
        .collect();
    let count = dimensions
        .iter()
        .fold(1, |count: usize, &size| count.saturating_mul(size));
    Ok(match kind {
        -1 => {
            let taken = bytes.take(count)?;
            // The first dimension is the length of a string. Without dimensions there is a single letter.
            let length = dimensions.first().copied().unwrap_or(1).max(1);
            Values::Texts(taken.chunks_exact(length).map(text).collect())
        }
        2 => {
            let (words, _) = bytes.take(count.saturating_mul(2))?.as_chunks::<2>();
            let number = |&word: &[u8; 2]| f64::from(processor.word(word).cast_signed());
            Values::Numbers(words.iter().map(number).collect(), dimensions)
        }
        4 => {
            let (words, _) = bytes.take(count.saturating_mul(4))?.as_chunks::<4>();
            Values::Numbers(words.iter().map(|&word| processor.real(word)).collect(), dimensions)
        }
        // Type 1 is bytes. The reader needs no values of other types.
        _ => Values::Numbers(
            bytes.take(count)?.iter().map(|&byte| f64::from(byte)).collect(),
            dimensions,
        ),
    })
}

/// Text without trailing spaces and NUL bytes.
pub(super) fn text(bytes: &[u8]) -> String {
    let end = bytes
        .iter()
        .rposition(|&byte| !matches!(byte, 0 | b' '))
        .map_or(0, |last| last + 1);
    decode_name(&bytes[..end]).trim_start().to_owned()
}

impl Parameters {
    fn get(&self, group: &str, name: &str) -> Option<&Values> {
        let id = *self.groups.get(group)?;
        self.values.get(&(id, name.to_owned()))
    }

    fn numbers(&self, group: &str, name: &str) -> Option<&[f64]> {
        match self.get(group, name)? {
            Values::Numbers(numbers, _) => Some(numbers),
            Values::Texts(_) => None,
        }
    }

    fn texts(&self, group: &str, name: &str) -> Option<&[String]> {
        match self.get(group, name)? {
            Values::Texts(texts) => Some(texts),
            Values::Numbers(..) => None,
        }
    }

    /// The first number of a parameter.
    pub(super) fn number(&self, group: &str, name: &str) -> Option<f64> {
        self.numbers(group, name)?.first().copied()
    }

    /// The first text of a parameter, unless it is empty.
    pub(super) fn text(&self, group: &str, name: &str) -> Option<&str> {
        let text = self.texts(group, name)?.first()?;
        (!text.is_empty()).then_some(text)
    }

    /// The number of frames of a long recording, which the header cannot hold. The parameters have the first and the
    /// last frame, as two words each.
    pub(super) fn frames(&self) -> Option<u64> {
        let last = self.field("ACTUAL_END_FIELD")?;
        last.checked_sub(self.first_frame()?).map(|frames| frames + 1)
    }

    /// The number of the first frame of long recordings.
    pub(super) fn first_frame(&self) -> Option<u64> {
        self.field("ACTUAL_START_FIELD")
    }

    fn field(&self, name: &str) -> Option<u64> {
        match self.numbers("TRIAL", name)? {
            // These words are unsigned.
            &[low, high, ..] => Some(u64::from(low as i16 as u16) + (u64::from(high as i16 as u16) << 16)),
            _ => None,
        }
    }

    /// The strings of a parameter: 255 in `LABELS`, as many in `LABELS2`, and so on.
    pub(super) fn all_texts(&self, group: &str, name: &str) -> Vec<&str> {
        let parts = parts(name).map_while(|part| self.texts(group, &part));
        parts.flatten().map(String::as_str).collect()
    }

    /// Like [`all_texts`](Self::all_texts), for numbers.
    pub(super) fn all_numbers(&self, group: &str, name: &str) -> Vec<f64> {
        let parts = parts(name).map_while(|part| self.numbers(group, &part));
        parts.flatten().copied().collect()
    }

    /// The numbers of an array of objects, and the count of numbers per object. The first `sizes` sizes belong to one
    /// object, and the next size is the number of objects. Some writers omit the number of objects if there is a single
    /// one.
    pub(super) fn array(&self, group: &str, name: &str, sizes: usize) -> Option<(&[f64], usize)> {
        match self.get(group, name)? {
            Values::Numbers(numbers, dimensions) => Some((numbers, dimensions.iter().take(sizes).product())),
            Values::Texts(_) => None,
        }
    }

    /// The sizes of an array, fastest index first.
    pub(super) fn sizes(&self, group: &str, name: &str) -> &[usize] {
        match self.get(group, name) {
            Some(Values::Numbers(_, sizes)) => sizes,
            _ => &[],
        }
    }

    /// The names of the points.
    pub(super) fn labels(&self) -> Vec<&str> {
        self.all_texts("POINT", "LABELS")
    }

    /// The number of analog channels.
    pub(super) fn analog_channels(&self) -> Option<usize> {
        // The value is an unsigned word.
        Some(usize::from(self.number("ANALOG", "USED")? as i64 as u16))
    }

    /// Analog samples per record: the samples of each channel at its rate, which is a multiple of the point rate.
    pub(super) fn analog_samples(&self, point_rate: f64) -> Option<usize> {
        let channels = self.analog_channels()?;
        let samples = (self.number("ANALOG", "RATE")? / point_rate).round();
        let is_possible = (1.0..=f64::from(u16::MAX)).contains(&samples);
        is_possible.then(|| channels * samples as usize)
    }
}

/// The names of a continued parameter: `LABELS`, `LABELS2`, and so on.
fn parts(name: &str) -> impl Iterator<Item = String> {
    (1..).map(move |part| match part {
        1 => name.to_owned(),
        part => format!("{name}{part}"),
    })
}
