//! Tests the reading of numbers in text files.

use mocap_formats::internals::number::parse;

fn value(word: &str) -> Option<(f64, usize)> {
    parse(word.as_bytes()).map(|number| (number.value, number.length))
}

#[test]
fn every_spelling_of_a_finite_number() {
    for (word, expected) in [
        (".0083333", 0.0083333),
        ("5.", 5.0),
        ("+1.5", 1.5),
        ("1E2", 100.0),
        ("-3.10327e-015", -3.10327e-15),
        ("007", 7.0),
        ("0,5", 0.5),
        ("-1,25e1", -12.5),
    ] {
        assert_eq!(value(word), Some((expected, word.len())), "{word}");
    }
    assert!(parse(b"-0").is_some_and(|zero| zero.value.is_sign_negative()));
}

#[test]
fn what_is_not_finite_is_seen_as_such() {
    for word in [
        "nan",
        "NaN",
        "-nan",
        "nan(ind)",
        "-nan(0x8000)",
        "1.#QNAN",
        "-1.#IND00",
        "1.#INF",
        "inf",
        "-Infinity",
        "1e400",
        "4e38",
        "-1.5e18",
    ] {
        let number = parse(word.as_bytes()).unwrap();
        assert!(
            !number.value.is_finite() && number.length == word.len(),
            "{word}: {number:?}"
        );
    }
}

#[test]
fn a_number_ends_where_another_begins() {
    assert_eq!(value("0.0-5.0"), Some((0.0, 3)));
    assert_eq!(value("1,2,3"), Some((1.2, 3)));
    assert_eq!(value("1,"), Some((1.0, 1)));
}

#[test]
fn words_are_no_numbers() {
    for word in ["", "-", ".", "abc", "[0.1", "+-1", "--1"] {
        assert_eq!(value(word), None, "{word}");
    }
}
