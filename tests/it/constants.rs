//! Each constant has its own line, with its unit and its reason.

use crate::source::sources;

/// The comment of a fractional number must have one of these words: its unit, or the kind of the number.
const UNITS: &str = "1/m 1/rad Hz angle bytes chord coefficients cosine cosines degree degrees deviation deviations \
    difference distance exponent factor factors fraction frames length lengths log-odds logarithm m/m m/s metre metres \
    multiple number numbers opacity parts part percentile pixels points quotient radian radians ratio ratios rounding \
    samples score second seconds sine size slope square squared squares steps tangents times turn units variance weight \
    weights width height infinities quaternion rate rates ticks share component alpha inch bits decimals \
    newtons coefficient scale fractions integer mantissa cost half unit linear minutes tick chords";

/// Words that connect a number with its reason, its source, or its use.
const REASONS: [&str; 22] = [
    ": ",
    "; ",
    ", ",
    "(",
    "`",
    " as ",
    " at ",
    " because ",
    " below ",
    " beyond ",
    " by ",
    " for ",
    " from ",
    " in ",
    " of ",
    " since ",
    " so that ",
    " than ",
    " that ",
    " where ",
    " which ",
    " within ",
];

/// The smallest number of words in the comment of a whole number: the counted items, and the reason of their number.
const FEWEST_WORDS: usize = 3;

/// The missing part of the comment of a constant on a line; `None` if nothing is missing, and for any other line. Whole
/// numbers of a fixed width are codes, masks and versions of formats, without a unit.
fn problem(lines: &[&str], line: usize) -> Option<&'static str> {
    let (before, code) = lines[line].split_once("const ")?;
    if !before.trim().is_empty() && !before.trim().starts_with("pub") {
        return None;
    }
    let (name, rest) = code.split_once(": ")?;
    let (kind, value) = rest.split_once('=')?;
    let is_name = name
        .chars()
        .all(|letter| letter.is_ascii_uppercase() || letter.is_ascii_digit() || letter == '_');
    let has = |kinds: &[&str]| {
        let mut words = kind.split(|letter: char| !letter.is_ascii_alphanumeric());
        words.any(|word| kinds.contains(&word))
    };
    if !is_name || !has(&["f32", "f64", "usize"]) || value.trim_start().starts_with(['"', 'b']) {
        return None;
    }
    let above = lines[..line].iter().rev().map(|line| line.trim());
    let above = above.skip_while(|line| line.starts_with("#["));
    let comment: Vec<&str> = above.take_while(|line| line.starts_with("//")).collect();
    let comment: Vec<&str> = comment
        .iter()
        .rev()
        .map(|line| line.trim_start_matches('/').trim())
        .collect();
    let comment = comment.join(" ");
    let words = || comment.split(|letter: char| letter.is_whitespace() || ",;:.()".contains(letter));
    let is_unit = |word: &str| UNITS.split_whitespace().any(|unit| unit.eq_ignore_ascii_case(word));
    if comment.is_empty() {
        return Some("it has no comment of its own");
    }
    if !has(&["f32", "f64"]) {
        let count = words().filter(|word| !word.is_empty()).count();
        return (count < FEWEST_WORDS).then_some("its comment does not say what it counts");
    }
    if !words().any(is_unit) && !["1/", "m/s", "rad/s", "2^"].iter().any(|unit| comment.contains(unit)) {
        return Some("its comment has no unit");
    }
    let has_reason = REASONS.iter().any(|word| comment.contains(word));
    (!has_reason).then_some("its comment has no reason")
}

#[test]
fn every_numeric_constant_has_its_unit_and_its_reason() {
    let mut found = Vec::new();
    for source in sources() {
        let lines: Vec<&str> = source.text.lines().collect();
        for line in 0..lines.len() {
            if let Some(problem) = problem(&lines, line) {
                found.push(format!(
                    "{}:{}: {problem}: {}",
                    source.path,
                    line + 1,
                    lines[line].trim()
                ));
            }
        }
    }
    assert!(
        found.is_empty(),
        "a constant has a comment of its own, with its unit, and its source or reason:\n{}",
        found.join("\n")
    );
}

#[test]
fn constants_without_unit_or_reason_are_found() {
    let of = |text: &str| {
        let lines: Vec<&str> = text.lines().collect();
        problem(&lines, lines.len() - 1)
    };
    let documented = [
        "/// The largest step in radians: farther away the linear terms do not hold.\nconst LARGEST: f64 = 0.5;",
        "/// Frames of a window: some steps.\npub(super) const FRAMES: usize = 192;",
        "pub const MARK: u16 = 7;",
        "const NAME: &str = \"a\";",
        "    #[allow(dead_code)]\n    let step = 0.5;",
        "/// The weight of a metre.\n#[rustfmt::skip]\nconst HEAVY: f64 = 1.0;",
    ];
    for text in documented {
        assert_eq!(of(text), None, "{text}");
    }
    let bare = [
        "const LARGEST: f64 = 0.5;",
        "/// The first in metres: a.\nconst FIRST: f64 = 1.0;\npub(crate) const SECOND: f64 = 2.0;",
        "/// The largest: it is not seen.\nconst LARGEST: f64 = 0.5;",
        "/// Metres.\nconst HEIGHT: f32 = 1.7;",
        "/// Frames.\nconst FRAMES: usize = 192;",
        "/// The ends.\nconst ENDS: [(&str, f64); 2] = [",
    ];
    for text in bare {
        assert!(of(text).is_some(), "{text}");
    }
}
