//! Tests of option values as text and as JSON.

use std::fmt;
use std::str::FromStr;

use mocap::convert::{RestPoseSource, TimeRange};
use mocap::job::{Angle, Length, UnitChoice, UpChoice};
use mocap::retarget::Scale;

/// A printed value is read as the same value.
fn round_trips<T: FromStr<Err = String> + fmt::Display + PartialEq + fmt::Debug>(texts: &[&str]) {
    for text in texts {
        let value: T = text.parse().unwrap();
        assert_eq!(value.to_string().parse::<T>().unwrap(), value, "{text}");
    }
}

#[test]
fn every_value_that_is_printed_is_read_again() {
    round_trips::<Length>(&["1mm", "0.5cm", "3um", "2m", "0.001", "0"]);
    round_trips::<UnitChoice>(&["auto", "cm", "cmu", "0.0254"]);
    round_trips::<UpChoice>(&["auto", "y", "z", "-y", "-z"]);
    round_trips::<TimeRange>(&["..", "1..", "..480f", "1.5..4", "120f..480f"]);
    round_trips::<RestPoseSource>(&["zero", "frame:0", "frame:7", "t-pose", "a-pose"]);
    round_trips::<Scale>(&["auto", "none", "1.25"]);
    round_trips::<Angle>(&["0", "12.5"]);
}

#[test]
fn json_takes_texts_and_numbers() {
    let lengths: Vec<Length> = serde_json::from_str(r#"["1mm", 0.001]"#).unwrap();
    assert_eq!(lengths[0], lengths[1]);
    let error = serde_json::from_str::<Length>("\"long\"").unwrap_err().to_string();
    assert!(error.starts_with("\"long\": not a length, such as 1mm"), "{error}");
    assert!(
        serde_json::from_str::<UnitChoice>("[]")
            .unwrap_err()
            .to_string()
            .contains("a string or a number")
    );
}
