//! In every command, `--fps` resamples at the same speed, and `--retime` changes the playback speed.

use mocap::gltf::BufferPlace;
use mocap::verify::Verifier;
use mocap::{Conversion, Exporter, Importer, Scene};

use crate::at_root;
use crate::program::Folder;

/// 75 frames at 120 frames per second.
fn folder() -> Folder {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    folder.write(
        "robot.urdf",
        &std::fs::read(at_root("fixtures/robots/h1.urdf")).unwrap(),
    );
    folder
}

/// The frame rate and the number of frames of a command's output `out.glb`.
fn frames(folder: &Folder, arguments: &str) -> (f64, usize) {
    folder.succeeds(arguments);
    let scene = mocap::import(folder.path("out.glb")).unwrap();
    let clip = scene.animations.last().unwrap();
    (clip.ticks_per_second.round(), clip.frame_count())
}

#[test]
fn the_rate_has_one_meaning_in_every_command_that_writes_motion() {
    let folder = folder();
    let job =
        |part: &str| format!(r#"{{"source": {{"inputs": ["cmu_short.bvh"]{part}, "write": {{"output": "out.glb"}}}}"#);
    folder.write("plain.json", job("}").as_bytes());
    folder.write("fps.json", job(r#", "frames": {"fps": 30}}"#).as_bytes());
    folder.write("retime.json", job(r#"}, "read": {"retime": 30}"#).as_bytes());
    for command in [
        "convert cmu_short.bvh out.glb",
        "edit cmu_short.bvh -o out.glb --step in-place",
        "retarget cmu_short.bvh --to-skeleton cmu_short.bvh -o out.glb",
        "robot cmu_short.bvh --robot robot.urdf -o out.glb",
        "run",
    ] {
        let with = |option: &str| match (command, option) {
            ("run", "") => "run plain.json".to_owned(),
            ("run", _) => format!("run {}.json", &option[2..option.len() - 3]),
            _ => format!("{command} {option}").trim_end().to_owned(),
        };
        let (rate, count) = frames(&folder, &with(""));
        assert_eq!(rate, 120.0, "{command}");
        assert!([74, 75].contains(&count), "{command}: {count}");
        let seconds = (count - 1) as f64 / 120.0;
        // Every fourth frame; an incomplete interval at the end is lost.
        let fewer = (seconds * 30.0 + 1e-3).floor() as usize + 1;
        assert_eq!(frames(&folder, &with("--fps 30")), (30.0, fewer), "{command}");
        assert_eq!(frames(&folder, &with("--retime 30")), (30.0, count), "{command}");
    }
}

#[test]
fn the_rate_has_one_meaning_in_pages_and_arrays() {
    let folder = folder();
    let said = |arguments: &str, name: &str| {
        folder.succeeds(arguments);
        String::from_utf8(folder.read(name)).unwrap()
    };
    let page = |option: &str| {
        said(
            &format!("view cmu_short.bvh -o out.html --trim 1f.. {option}"),
            "out.html",
        )
    };
    assert!(page("--fps 30").contains(r#""frames":19,"ticksPerSecond":30.0"#));
    assert!(page("--retime 30").contains(r#""frames":74,"ticksPerSecond":30.0"#));
    let rows = |option: &str| said(&format!("fk cmu_short.bvh -o out.csv {option}"), "out.csv");
    for (option, frames) in [("--fps 30", 19), ("--retime 30", 75)] {
        let text = rows(option);
        assert!(
            text.contains(r#""frame_rate":30.0"#),
            "{}",
            text.lines().next().unwrap()
        );
        assert_eq!(
            text.lines().filter(|line| line.contains(",Hips,")).count(),
            frames,
            "{option}"
        );
    }
}

#[test]
fn verify_knows_both() {
    let folder = folder();
    for command in [
        "convert cmu_short.bvh out.glb",
        "convert cmu_short.bvh out.fbx",
        "convert cmu_short.bvh out.bvh --sidecar --force --drop-first-frame auto",
        "edit cmu_short.bvh -o out.glb --step smooth",
        "edit cmu_short.bvh -o out.bvh --step smooth --sidecar --force",
    ] {
        if cfg!(not(feature = "fbx")) && command.contains("fbx") {
            continue;
        }
        let name = command.split(' ').find(|word| word.starts_with("out")).unwrap();
        for option in [
            "--fps 30",
            "--retime 30",
            "--retime 30 --fps 60",
            "--retime 60 --clip 0",
        ] {
            folder.succeeds(&format!("{command} {option} --verify"));
            folder.succeeds(&format!("verify cmu_short.bvh {name}"));
        }
    }
    // Without a sidecar, BVH does not record the rate, so the caller states it.
    folder.succeeds("convert cmu_short.bvh slow.bvh --retime 30");
    folder.refuses("verify cmu_short.bvh slow.bvh", 1, "ends at");
    folder.succeeds("verify cmu_short.bvh slow.bvh --retime 30");
}

/// Two clips with different rates get one rate. Each is compared with its source.
#[test]
fn every_clip_of_a_file_is_retimed() {
    let folder = folder();
    let clip = |rate: f64, name: &str| {
        let mut scene = Importer::new()
            .retime(rate)
            .import(folder.path("cmu_short.bvh"))
            .unwrap();
        Conversion::new().apply(&mut scene).unwrap();
        scene.animations[0].name = name.to_owned();
        scene
    };
    let mut two: Scene = clip(24.0, "slow");
    two.animations.extend(clip(120.0, "fast").animations);
    two.metadata = Scene::default().metadata;
    two.metadata.metres_per_unit = Some(1.0);
    two.metadata.up = Some(mocap::scene::UpAxis::Y);
    let exporter = Exporter::new().buffer(BufferPlace::Embedded);
    let bytes = exporter.write_as(&two, "two.gltf").unwrap().into_bytes().unwrap();
    // If a file states its rate, all clips have this rate.
    let mut json: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    json["asset"].as_object_mut().unwrap().remove("extras");
    folder.write("two.gltf", json.to_string().as_bytes());
    // The rate of the first clip.
    folder.succeeds("convert two.gltf out.glb --retime 24 --verify");
    let verified = Verifier::new()
        .files(folder.path("two.gltf"), folder.path("out.glb"))
        .unwrap();
    assert!(verified.is_within(1e-4), "{verified:?}");
    let scene = mocap::import(folder.path("out.glb")).unwrap();
    for clip in &scene.animations {
        let seconds = clip.duration / clip.ticks_per_second;
        assert!((seconds - 74.0 / 24.0).abs() < 1e-3, "{}: {seconds}", clip.name);
    }
}
