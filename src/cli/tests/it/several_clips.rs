//! Commands on files with several clips: every clip is changed, or the named one among the others.

use std::fs;

use mocap::glam::Mat4;
use mocap::{Exporter, Importer, Pose, Scene};

use crate::program::Folder;

/// The clips of the files: their names, and how many frames each has.
const CLIPS: [(&str, usize); 3] = [("long", 60), ("short", 20), ("middle", 40)];

/// A motion of three clips, which are parts of a walk that begin at these frames. The first frame of the walk is a rest
/// pose.
fn parts(whole: &Scene, firsts: [usize; 3]) -> Scene {
    let mut scene = whole.clone();
    scene.animations.clear();
    for ((name, frames), first) in std::iter::zip(CLIPS, firsts) {
        let mut clip = whole.animations[0].clone();
        for channel in &mut clip.channels {
            let part = first..first + frames;
            if let Some(part) = channel.position_keys.values.get(part.clone()) {
                channel.position_keys.values = part.to_vec();
            }
            if let Some(part) = channel.rotation_keys.values.get(part) {
                channel.rotation_keys.values = part.to_vec();
            }
        }
        clip.name = name.to_owned();
        clip.duration = frames as f64 - 1.0;
        scene.animations.push(clip);
    }
    scene.metadata.metres_per_unit = Some(1.0);
    scene
}

/// A folder with files of three clips.
fn folder() -> Folder {
    let folder = Folder::of_real(&["cmu_12_01_walk.bvh"]);
    let whole = mocap::import(folder.path("cmu_12_01_walk.bvh")).unwrap();
    for name in ["in.glb", "in.fbx", "in.usda"] {
        let scene = parts(&whole, [1, 31, 61]);
        Exporter::new().export(&scene, folder.path(name)).unwrap();
    }
    let scene = parts(&whole, [1, 0, 61]);
    Exporter::new().export(&scene, folder.path("rest.fbx")).unwrap();
    folder
}

fn import(folder: &Folder, name: &str) -> Scene {
    Importer::new().import(folder.path(name)).unwrap()
}

/// The largest difference between the positions of a clip's nodes and the same positions in another file, whose clip
/// plays backwards or forwards.
fn largest_distance(before: &Scene, after: &Scene, clip: usize, is_reversed: bool) -> f32 {
    let last = before.animations[clip].duration;
    assert_eq!(after.animations[clip].duration, last);
    let places = |scene: &Scene, tick: f64| -> Vec<Mat4> { Pose::at_tick(scene, clip, tick).unwrap().node_to_world };
    let off = |tick: f64| {
        let other = if is_reversed { last - tick } else { tick };
        let pairs = std::iter::zip(places(before, other), places(after, tick));
        pairs
            .map(|(a, b)| a.w_axis.truncate().distance(b.w_axis.truncate()))
            .fold(0.0, f32::max)
    };
    [0.0, 5.0, last - 2.0, last].into_iter().map(off).fold(0.0, f32::max)
}

#[test]
fn every_clip_is_changed_and_reported() {
    let folder = folder();
    for name in ["in.glb", "in.fbx", "in.usda"] {
        let output = name.replace("in", "out");
        let said = folder.succeeds(&format!("edit {name} -o {output} --step reverse --verify"));
        for (clip, _) in CLIPS {
            assert!(said.contains(&format!("reverse of clip \"{clip}\": ")), "{said}");
        }
        let (before, after) = (import(&folder, name), import(&folder, &output));
        for clip in 0..3 {
            let off = largest_distance(&before, &after, clip, true);
            assert!(off < 1e-4, "{name}, {clip}: {off}");
            assert!(largest_distance(&before, &after, clip, false) > 0.05, "{name}, {clip}");
        }
    }
}

#[test]
fn a_named_clip_is_changed_among_the_others() {
    let folder = folder();
    for name in ["in.glb", "in.fbx", "in.usda"] {
        let output = name.replace("in", "out");
        let said = folder.succeeds(&format!("edit {name} -o {output} --step reverse --clip short --verify"));
        assert!(!said.contains("long") && !said.contains("middle"), "{said}");
        let (before, after) = (import(&folder, name), import(&folder, &output));
        let names: Vec<&str> = after.animations.iter().map(|clip| clip.name.as_str()).collect();
        assert_eq!(names, CLIPS.map(|(name, _)| name), "{name}");
        for clip in 0..3 {
            let off = largest_distance(&before, &after, clip, clip == 1);
            assert!(off < 1e-4, "{name}, {clip}: {off}");
        }
        let said = folder.ends_with(2, &format!("edit {name} -o x{output} --step reverse --clip shorts"));
        assert!(said.contains("did you mean \"short\"?"), "{said}");
    }
    // The other clips keep their frames, too.
    folder.succeeds("edit in.fbx -o slow.fbx --step smooth --clip short --fps 60 --verify");
    let frames: Vec<usize> = import(&folder, "slow.fbx")
        .animations
        .iter()
        .map(mocap::scene::Animation::frame_count)
        .collect();
    assert!(frames[1] < 20 && frames[0] >= 60, "{frames:?}");
}

/// Changes of the skeleton concern all clips, and move no joint.
#[test]
fn a_change_of_the_skeleton_changes_all_clips_at_once() {
    let folder = folder();
    for options in ["", " --clip short"] {
        let said = folder.succeeds(&format!(
            "edit in.fbx -o out.fbx --step bone-axis --step reverse --verify --force{options}"
        ));
        assert_eq!(said.matches("bone-axis").count(), 1, "{said}");
        let (before, after) = (import(&folder, "in.fbx"), import(&folder, "out.fbx"));
        for clip in 0..3 {
            let off = largest_distance(&before, &after, clip, options.is_empty() || clip == 1);
            assert!(off < 1e-4, "{options}, {clip}: {off}");
        }
    }
}

#[test]
fn an_output_with_one_clip_needs_a_name() {
    let folder = folder();
    for command in [
        "edit in.fbx -o out.bvh --step reverse",
        "clean in.glb -o out.bvh",
        "clean in.glb -o out.npz",
    ] {
        let said = folder.ends_with(2, command);
        assert!(
            said.contains("the file has several clips, but the output holds one") && said.contains("--clip"),
            "{said}"
        );
        assert!(said.contains("0 \"long\", 1 \"short\", 2 \"middle\""), "{said}");
    }
    folder.succeeds("edit in.fbx -o out.bvh --step reverse --clip middle");
    assert_eq!(import(&folder, "out.bvh").animations[0].frame_count(), 40);
    fs::create_dir(folder.path("many")).unwrap();
    fs::copy(folder.path("in.fbx"), folder.path("many/in.fbx")).unwrap();
    folder.succeeds("edit many -o outs/ --to bvh --step reverse");
    for (clip, frames) in CLIPS {
        let written = import(&folder, &format!("outs/in/{clip}.bvh"));
        assert_eq!(written.animations[0].frame_count(), frames, "{clip}");
    }
}

#[test]
fn the_report_of_clean_has_every_clip() {
    let folder = folder();
    folder.succeeds("clean in.fbx -o out.fbx --report all.json");
    let reports: serde_json::Value = serde_json::from_slice(&folder.read("all.json")).unwrap();
    let clips: Vec<&str> = reports
        .as_array()
        .unwrap()
        .iter()
        .map(|report| report["clip"].as_str().unwrap())
        .collect();
    assert_eq!(clips, CLIPS.map(|(name, _)| name));
    folder.succeeds("clean in.fbx -o out.fbx --report one.json --clip 2 --force");
    let report: serde_json::Value = serde_json::from_slice(&folder.read("one.json")).unwrap();
    assert_eq!(report["clip"], "middle");
    assert_eq!(import(&folder, "out.fbx").animations.len(), 3);
}

/// A file beside the output is about one clip, and the command says which.
#[test]
fn contacts_are_of_the_named_clip() {
    let folder = folder();
    let frames = |name: &str| {
        let found: serde_json::Value = serde_json::from_slice(&folder.read(name)).unwrap();
        found["frames"].as_u64().unwrap()
    };
    let said = folder.succeeds("edit in.fbx -o out.fbx --step mirror --contacts first.json");
    assert!(
        said.contains("clip: 0 \"long\" of 3; --clip selects another clip"),
        "{said}"
    );
    folder.succeeds("edit in.fbx -o out.fbx --step mirror --contacts named.json --clip short --force");
    assert_eq!((frames("first.json"), frames("named.json")), (60, 20));
}

/// Each clip is cut at its own end, and loses its own rest pose.
#[test]
fn a_part_of_each_clip_is_kept() {
    let folder = folder();
    let frames = |name: &str| -> Vec<usize> {
        let scene = import(&folder, name);
        scene
            .animations
            .iter()
            .map(mocap::scene::Animation::frame_count)
            .collect()
    };
    folder.succeeds("convert in.fbx end.fbx --trim 10f.. --verify");
    assert_eq!(frames("end.fbx"), [50, 10, 30]);
    folder.succeeds("convert in.fbx first.fbx --drop-first-frame yes --verify");
    assert_eq!(frames("first.fbx"), [59, 19, 39]);
    let said = folder.succeeds("edit rest.fbx -o rested.fbx --step reverse --verify");
    assert_eq!(frames("rested.fbx"), [60, 19, 40]);
    assert!(
        said.contains("clip 1 \"short\": the first frame, a rest pose, is dropped"),
        "{said}"
    );
    let said = folder.ends_with(2, "convert in.fbx late.fbx --trim 30f..");
    assert!(
        said.contains("clip 1 \"short\": the part to keep begins after the last frame"),
        "{said}"
    );
}

/// Each clip is a motion of the table.
#[cfg(feature = "parquet")]
#[test]
fn a_table_has_every_clip() {
    let folder = folder();
    folder.succeeds("pack in.fbx -o packed");
    let inputs: Vec<String> = folder
        .records("packed")
        .iter()
        .map(|record| record["input"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(inputs, ["in.fbx/long", "in.fbx/middle", "in.fbx/short"]);
    let scene = import(&folder, "packed/part-00000.parquet");
    let frames: Vec<usize> = scene
        .animations
        .iter()
        .map(mocap::scene::Animation::frame_count)
        .collect();
    assert_eq!(frames.iter().sum::<usize>(), 120, "{frames:?}");
    folder.succeeds("pack in.fbx -o named --clip short");
    assert_eq!(folder.records("named").len(), 1);
}
