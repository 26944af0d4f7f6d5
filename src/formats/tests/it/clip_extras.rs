//! The extras of clips: every step and every glTF writer keeps them, and events keep their place in the motion. The
//! expected times are computed by hand.

use mocap::retarget::{RetargetOptions, Retargeter, apply_steps};
use mocap::scene::report::{DataKind, DataLoss};
use mocap::{Export, Exporter, Format, FormatInfo, Importer, Scene};
use serde_json::{Value, json};

/// A file with one clip of 1 s at 30 frames per second, in which an arm and a morph target move.
fn file(extras: &Value) -> Vec<u8> {
    let text = std::fs::read_to_string("../../fixtures/made/arm_and_face.gltf").unwrap();
    let mut file: Value = serde_json::from_str(&text).unwrap();
    for animation in file["animations"].as_array_mut().unwrap() {
        animation["extras"] = extras.clone();
    }
    serde_json::to_vec(&file).unwrap()
}

fn extras() -> Value {
    json!({
        "loop": true,
        "note": "by hand",
        "events": [{ "time": 0.2, "name": "lift" }, { "time": 0.8, "name": "drop" }],
        "spans": [{ "start": 0.1, "end": 0.5, "name": "rise" }],
    })
}

/// The extras of the last animation of a glTF file, without the entries of this program.
fn written(export: &Export) -> Value {
    let bytes = export.files.last().unwrap().bytes();
    let text = gltf::Glb::from_slice(&bytes).map_or(bytes.to_vec(), |glb| glb.json.to_vec());
    let file: Value = serde_json::from_slice(&text).unwrap();
    let mut extras = file["animations"].as_array().unwrap().last().unwrap()["extras"].clone();
    extras.as_object_mut().map(|members| members.remove("mocap"));
    extras
}

/// The clip after some steps.
fn edited(steps: &[&str]) -> (Scene, Value) {
    let mut scene = Importer::new().read(&file(&extras()), "arm.gltf").unwrap();
    scene.keep_animation(scene.animations.len() - 1);
    let steps = ["resample:rate=100"].iter().chain(steps).filter(|_| !steps.is_empty());
    let steps: Vec<_> = steps.map(|step| step.parse().unwrap()).collect();
    apply_steps(&mut scene, &steps, &[], None).unwrap();
    let written = written(&Exporter::new().write(&scene, Format::Gltf).unwrap());
    (scene, written)
}

/// The times of events by name, and the span.
fn times(extras: &Value) -> Vec<(String, f64)> {
    let events = extras["events"].as_array().unwrap().iter();
    let event = |event: &Value| {
        (
            event["name"].as_str().unwrap().to_owned(),
            event["time"].as_f64().unwrap(),
        )
    };
    events.map(event).collect()
}

fn expect(steps: &[&str], events: &[(&str, f64)], span: Option<[f64; 2]>) {
    let (_, extras) = edited(steps);
    let found = times(&extras);
    assert_eq!(found.len(), events.len(), "{steps:?}: {extras}");
    for ((name, time), (wanted, at)) in found.iter().zip(events) {
        assert!(name == wanted && (time - at).abs() < 2e-4, "{steps:?}: {extras}");
    }
    let found = extras["spans"].as_array().unwrap().first();
    let found = found.map(|found| ["start", "end"].map(|key| found[key].as_f64().unwrap()));
    assert_eq!(found.is_some(), span.is_some(), "{steps:?}: {extras}");
    for (found, wanted) in found.iter().flatten().zip(span.iter().flatten()) {
        assert!((found - wanted).abs() < 2e-4, "{steps:?}: {extras}");
    }
    assert_eq!(
        (&extras["loop"], &extras["note"]),
        (&json!(true), &json!("by hand")),
        "{steps:?}"
    );
}

#[test]
fn events_stay_with_their_moments() {
    let (scene, same) = edited(&[]);
    assert_eq!(same, extras());
    let end = scene.animations[0].duration / scene.animations[0].ticks_per_second;
    let (lift, drop) = ("lift", "drop");
    expect(&["smooth"], &[(lift, 0.2), (drop, 0.8)], Some([0.1, 0.5]));
    expect(&["resample:rate=60"], &[(lift, 0.2), (drop, 0.8)], Some([0.1, 0.5]));
    expect(
        &["reverse"],
        &[(lift, end - 0.2), (drop, end - 0.8)],
        Some([end - 0.5, end - 0.1]),
    );
    expect(&["warp:speed=2"], &[(lift, 0.1), (drop, 0.4)], Some([0.05, 0.25]));
    // Events outside the trimmed range are removed, and the span keeps its part within the clip.
    expect(&["trim:range=0.4..0.9"], &[(drop, 0.4)], Some([0.0, 0.1]));
    expect(&["trim:range=0.6..0.9"], &[(drop, 0.2)], None);
    expect(
        &["trim:range=0.4..0.9", "warp:speed=0.5"],
        &[(drop, 0.8)],
        Some([0.0, 0.2]),
    );
}

#[test]
fn extras_that_are_no_object_and_none_are_kept() {
    for (own, expected) in [
        (json!([1, "two"]), json!({ "extras": [1, "two"] })),
        (json!(7), json!({ "extras": 7 })),
        (Value::Null, json!({})),
        (json!({ "time": "noon", "t": {} }), json!({ "time": "noon", "t": {} })),
    ] {
        let scene = Importer::new().read(&file(&own), "arm.gltf").unwrap();
        let export = Exporter::new().write(&scene, Format::Gltf).unwrap();
        assert_eq!(written(&export), expected);
    }
}

#[test]
fn a_retargeted_clip_has_the_extras_of_its_source() {
    let walk = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let mut walk = Importer::new()
        .read(
            &Exporter::new()
                .write(&walk, Format::Gltf)
                .unwrap()
                .into_bytes()
                .unwrap(),
            "walk.glb",
        )
        .unwrap();
    walk.set_clip_extras(0, extras());
    let character = Importer::new()
        .import_character("../../fixtures/characters/human_vrm0.vrm")
        .unwrap();
    let export = Retargeter::new(walk, character, RetargetOptions::new()).unwrap();
    let found = written(&export.character_file().unwrap().unwrap());
    // The clip ends before the second event. Its rest pose, one frame at 120 frames per second, is dropped.
    let [(name, time)] = &times(&found)[..] else {
        panic!("{found}");
    };
    assert!(name == "lift" && (time - (0.2 - 1.0 / 120.0)).abs() < 1e-4, "{found}");
    assert_eq!(found["loop"], json!(true));
}

#[test]
fn formats_without_extras_say_that_they_are_lost() {
    let scene = Importer::new().read(&file(&extras()), "arm.gltf").unwrap();
    let clips = scene.animations.len() as u64;
    for format in [Format::Bvh, Format::Fbx, Format::Usd] {
        let losses = FormatInfo::of(format).losses(&scene, Default::default());
        assert!(
            losses.contains(&DataLoss::new(DataKind::Extras, clips)),
            "{format}: {losses:?}"
        );
    }
    let losses = FormatInfo::of(Format::Gltf).losses(&scene, Default::default());
    assert!(losses.iter().all(|loss| loss.kind != DataKind::Extras), "{losses:?}");
}
