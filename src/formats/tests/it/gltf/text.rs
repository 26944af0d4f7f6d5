//! Tests the JSON text of glTF files.

use gltf_json::{Index, Root};
use mocap_formats::internals::gltf::{Animation, Channel, Sampler, ShortNumbers, Target, write};
use serde::Serialize;
use serde_json::Serializer;

#[test]
fn numbers_keep_their_value() {
    let numbers = [
        0.0,
        -0.0,
        1.0,
        -20.0,
        0.5,
        1e-7,
        0.1,
        16_777_216.0,
        1e20,
        f32::MIN_POSITIVE,
        f32::MAX,
    ];
    let mut text = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut text, ShortNumbers::default());
    numbers.serialize(&mut serializer).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.starts_with("[0,-0,1,-20,0.5,1e-7,0.1,16777216,"), "{text}");
    let read: Vec<f32> = serde_json::from_str(&text).unwrap();
    assert_eq!(
        read.iter().map(|n| n.to_bits()).collect::<Vec<_>>(),
        numbers.map(f32::to_bits)
    );
}

#[test]
fn only_what_differs_from_the_default_is_written() {
    let animation = Animation {
        name: None,
        channels: vec![Channel {
            sampler: 0,
            target: Target {
                node: Index::new(3),
                path: "rotation",
            },
        }],
        samplers: vec![Sampler {
            input: Index::new(1),
            output: Index::new(2),
        }],
        extras: None,
    };
    let text = write(&Root::default(), std::slice::from_ref(&animation)).unwrap();
    let text = String::from_utf8(text).unwrap();
    let expected = r#""animations":[{"channels":[{"sampler":0,"target":{"node":3,"path":"rotation"}}],"samplers":[{"input":1,"output":2}]}]}"#;
    assert!(text.ends_with(expected), "{text}");
    let text = String::from_utf8(write(&Root::default(), &[]).unwrap()).unwrap();
    assert!(!text.contains("animations"), "{text}");
}
