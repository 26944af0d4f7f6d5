//! Numbers as motion capture programs print them.

use mocap_scene::limits::is_plausible;

/// A number at the start of a word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    /// NaN for every spelling of "not a number". Infinite for infinity, and for numbers that are too large for
    /// kinematics.
    pub value: f64,
    /// The length in bytes.
    pub length: usize,
    /// Whether the decimal separator is a comma.
    pub(crate) comma: bool,
}

/// Infinities and NaN as Microsoft's C runtime prints them with `printf`.
const MICROSOFT: [(&str, f64); 4] = [
    ("1.#QNAN", f64::NAN),
    ("1.#IND", f64::NAN),
    ("1.#SNAN", f64::NAN),
    ("1.#INF", f64::INFINITY),
];

/// The number at the start of `word`, correctly rounded.
///
/// The rest of the word may follow. The caller decides whether the rest is another number (`0.0-5.0`) or an error.
pub fn parse(word: &[u8]) -> Option<Number> {
    let digits = word.strip_prefix(b"-").or(word.strip_prefix(b"+")).unwrap_or(word);
    let sign = word.len() - digits.len();
    for (spelling, value) in MICROSOFT {
        let start = digits.get(..spelling.len());
        if start.is_some_and(|start| start.eq_ignore_ascii_case(spelling.as_bytes())) {
            // The runtime pads the spelling to the precision: 1.#IND00.
            let padding = digits[spelling.len()..]
                .iter()
                .take_while(|byte| **byte == b'0')
                .count();
            return Some(Number {
                value,
                length: sign + spelling.len() + padding,
                comma: false,
            });
        }
    }
    let mut number = parse_point(word)?;
    if word.get(number.length) == Some(&b',') && word.get(number.length + 1).is_some_and(u8::is_ascii_digit) {
        number = parse_comma(word)?;
    }
    if !number.value.is_nan() && !is_plausible(number.value) {
        number.value = f64::INFINITY.copysign(number.value);
    }
    Some(number)
}

fn parse_point(word: &[u8]) -> Option<Number> {
    // The parser accepts no plus sign.
    let plus = usize::from(word.first() == Some(&b'+') && word.get(1) != Some(&b'-'));
    let (value, length) = fast_float2::parse_partial::<f64, _>(&word[plus..]).ok()?;
    let length = length + plus;
    // glibc prints the payload too: -nan(ind), nan(0x8000).
    let payload = match word[length..] {
        [b'(', ref rest @ ..] if value.is_nan() => rest.iter().position(|&byte| byte == b')').map_or(0, |end| end + 2),
        _ => 0,
    };
    Some(Number {
        value,
        length: length + payload,
        comma: false,
    })
}

fn parse_comma(word: &[u8]) -> Option<Number> {
    // The largest number of bytes of a number in a motion file. A longer word is not a number.
    const LONGEST: usize = 64;
    let mut buffer = [0; LONGEST];
    let copy = buffer.get_mut(..word.len())?;
    copy.copy_from_slice(word);
    *copy.iter_mut().find(|byte| **byte == b',')? = b'.';
    let number = parse_point(copy)?;
    Some(Number { comma: true, ..number })
}
