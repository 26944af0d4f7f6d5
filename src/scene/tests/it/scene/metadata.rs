//! Tests the names of metadata in JSON.

use mocap::Format;
use mocap::scene::{Assumption, Topic};
use mocap_scene::scene::format_name;
use serde::{Deserialize, Serialize};

#[test]
fn names_in_json_are_those_that_print() {
    for format in Format::ALL {
        assert_eq!(serde_json::to_value(format).unwrap(), format.as_str());
        assert_eq!(format.as_str().to_uppercase().parse::<Format>().unwrap(), format);
    }
    let topics = [
        Topic::Unit,
        Topic::Up,
        Topic::FrameRate,
        Topic::FirstFrame,
        Topic::RootOffset,
        Topic::JointPositions,
        Topic::UpAxis,
        Topic::Meshes,
        Topic::Analog,
        Topic::Events,
        Topic::Interpolation,
        Topic::Layout,
        Topic::Body,
        Topic::Hands,
        Topic::Markers,
        Topic::Other,
    ];
    for topic in topics {
        assert_eq!(serde_json::to_value(topic).unwrap(), topic.as_str());
    }
}

/// A file of a later version may have unknown topics.
#[test]
fn unknown_names_in_json_are_read_as_none_and_other() {
    let text = r#"{"topic": "gravity", "choice": "9.81", "reason": "it is Earth"}"#;
    assert_eq!(serde_json::from_str::<Assumption>(text).unwrap().topic, Topic::Other);

    #[derive(Serialize, Deserialize)]
    struct Named(#[serde(with = "format_name")] Option<Format>);
    for (text, format) in [("\"nosuch\"", None), ("\"\"", None), ("\"c3d\"", Some(Format::C3d))] {
        assert_eq!(serde_json::from_str::<Named>(text).unwrap().0, format);
    }
    assert_eq!(serde_json::to_string(&Named(None)).unwrap(), "\"\"");
}
