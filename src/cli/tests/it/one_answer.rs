//! All commands find the same ground and the same bones for a file.

use mocap::Importer;
use mocap::figure::Figure;
use serde_json::Value;

use crate::cut;
use crate::program::Folder;
use crate::sample::Sample;

/// Rest poses of every kind, several units and up axes, feet with and without toes.
const FILES: [&str; 8] = [
    "real/cmu_12_01_walk.bvh",
    "real/rokoko_dance.bvh",
    "real/motionbuilder_vicon_walk.bvh",
    "real/mocopi_jump_six_channels.bvh",
    "real/biovision_example1.bvh",
    "real/z_up_dab.bvh",
    "skeletons/accad_run_turn.bvh",
    "real/cmu_02_01.amc",
];

/// The tested frames of each file.
const FRAMES: usize = 200;

/// Humanoids from more than ten sources.
const GROUNDS: [&str; 29] = [
    "real/additive_root_pose.bvh",
    "real/additive_root_walk.bvh",
    "real/biovision_example1.bvh",
    "real/cmu_01_01.bvh",
    "real/cmu_12_01_walk.bvh",
    "real/cmu_mixed_rotation_orders.bvh",
    "real/cmu_salsa_poser_names.bvh",
    "real/cmu_short.bvh",
    "real/hip_knee_ankle_names.bvh",
    "real/kinect_openni.bvh",
    "real/makehuman_fly_one_frame.bvh",
    "real/makehuman_zombie_walk.bvh",
    "real/mocopi_jump_six_channels.bvh",
    "real/motionbuilder_vicon_walk.bvh",
    "real/nan_tokens.bvh",
    "real/perception_neuron_moving_positions.bvh",
    "real/rokoko_dance.bvh",
    "real/run.fbx",
    "real/slimevr_headset_root.bvh",
    "real/z_up_dab.bvh",
    "skeletons/accad_run_turn.bvh",
    "skeletons/animics_all_along_z.bvh",
    "skeletons/blender_rigify_names.bvh",
    "skeletons/bvhtoolbox_walk01.bvh",
    "skeletons/rosemotion_robin.bvh",
    "skeletons/snu_character1_boxes.bvh",
    "skeletons/vicon_sword_attack.bvh",
    "skeletons/xsens_names_tpose.bvh",
    "characters/arnaud.fbx",
];

/// Long takes of [`GROUNDS`]. The test also writes the first frames of each take as a file.
const BEGINNINGS: [&str; 11] = [
    "real/cmu_01_01.bvh",
    "real/cmu_12_01_walk.bvh",
    "real/cmu_salsa_poser_names.bvh",
    "real/hip_knee_ankle_names.bvh",
    "real/kinect_openni.bvh",
    "real/makehuman_zombie_walk.bvh",
    "real/mocopi_jump_six_channels.bvh",
    "real/motionbuilder_vicon_walk.bvh",
    "real/perception_neuron_moving_positions.bvh",
    "real/rokoko_dance.bvh",
    "real/z_up_dab.bvh",
];

/// The number of a key in a page's JSON; `None` if it is absent or null.
fn number_of(page: &str, key: &str) -> Option<f64> {
    let key = format!("\"{key}\":");
    let start = page.find(&key)? + key.len();
    let end = page[start..].find([',', '}']).unwrap();
    page[start..start + end].trim().parse().ok()
}

/// The bones and the T-pose of the figure in the output of every command.
#[test]
fn every_command_has_one_map() {
    let mut random = Sample::new();
    for file in FILES.into_iter().filter(|file| file.ends_with(".bvh")) {
        let folder = Folder::of_real(&[]);
        let text = cut::some_frames(&mut random, file, FRAMES);
        folder.write("in.bvh", text.as_bytes());
        let said: Value = serde_json::from_slice(&folder.run("skeleton in.bvh --json").stdout).unwrap();
        let scene = Importer::new().read(text.as_bytes(), "in.bvh").unwrap();
        let figure = Figure::new(&scene);
        for (bone, joint) in said["humanoid"]["bones"].as_object().unwrap() {
            let found = figure.humanoid.bones.iter().find(|(found, _)| found.as_str() == bone);
            let node = found.unwrap().1.joint;
            assert_eq!(joint["joint"], scene.nodes[node.index()].name, "{file}: {bone}");
        }
        let t_pose = figure.t_pose(&scene).unwrap();
        let largest = said["t_pose"]["largest_rotation"].as_f64().unwrap();
        assert!(
            (largest - f64::from(t_pose.largest_rotation())).abs() < 1e-3,
            "{file}: {largest}"
        );
        folder.succeeds("sheet in.bvh --t-pose -o sheet.svg");
        let drawn = String::from_utf8(folder.read("sheet.svg")).unwrap();
        let facts = [
            format!("{largest:.0}° from the rest pose at most"),
            format!("{} bones", said["humanoid"]["bones"].as_object().unwrap().len()),
        ];
        for fact in facts {
            assert!(drawn.contains(&format!(">{fact}</text>")), "{file}: {fact}");
        }
    }
}

/// The height of the ground in metres, from `skeleton`.
fn ground_of(folder: &Folder, file: &str) -> f64 {
    let said: Value = serde_json::from_slice(&folder.run(&format!("skeleton {file} --json")).stdout).unwrap();
    said["floor"]["value"].as_f64().unwrap() * said["unit"]["metres"].as_f64().unwrap()
}

/// The height of the ground in forty files, from ten commands, in metres.
#[test]
fn ten_commands_have_one_ground() {
    /// A written file has rounded numbers.
    const WRITTEN: f64 = 1e-3;
    const SAME: f64 = 1e-4;
    /// The stride between the tried files.
    const PARTS: usize = 8;
    let whole = GROUNDS.map(|file| (file, None));
    let beginnings = BEGINNINGS.map(|file| (file, Some(FRAMES / 2)));
    let files = whole.into_iter().chain(beginnings);
    assert_eq!(files.clone().count(), 40);
    for (file, frames) in Sample::new().some(files, PARTS) {
        let folder = Folder::of_real(&[]);
        let input = format!("in.{}", file.rsplit('.').next().unwrap());
        let bytes = match frames {
            Some(frames) => cut::first_frames(file, frames).into_bytes(),
            None => std::fs::read(format!("../../fixtures/{file}")).unwrap(),
        };
        folder.write(&input, &bytes);
        let ground = ground_of(&folder, &input);
        let is_ground = |command: &str, height: f64, within: f64| {
            assert!(
                (height - ground).abs() < within,
                "{file} {frames:?}: {command} has {height}, not {ground}"
            );
        };
        for format in ["glb", "fbx", "bvh"] {
            folder.succeeds(&format!("convert {input} converted.{format}"));
            is_ground(format, ground_of(&folder, &format!("converted.{format}")), WRITTEN);
        }
        folder.succeeds(&format!("view {input} -o page.html"));
        let page = String::from_utf8(folder.read("page.html")).unwrap();
        is_ground("view", number_of(&page, "floor").unwrap(), SAME);
        folder.succeeds(&format!("survey {input} -o survey.jsonl --html survey.html"));
        let survey = String::from_utf8(folder.read("survey.html")).unwrap();
        // A clip with one frame has no moving figure.
        if let Some(height) = number_of(&survey, "floor") {
            is_ground("survey", 0.01 * height, SAME);
        }
        folder.succeeds(&format!("clean {input} -o cleaned.glb --report report.json"));
        let report = String::from_utf8(folder.read("report.json")).unwrap();
        // If no foot is ever slow, `clean` measures no floor.
        if let Some(height) = number_of(&report[report.find("\"before\"").unwrap()..], "floor_height") {
            is_ground("clean", height, SAME);
        }
        let grounded = folder.run(&format!("edit {input} -o grounded.glb --step ground --json"));
        let changed: Value = serde_json::from_slice(&grounded.stdout).unwrap();
        let changed = &changed[0]["changed"];
        // Slope and drift are removed before the height is measured.
        if let (Some(height), true, true) = (
            changed["height"].as_f64(),
            changed["slope"].is_null(),
            changed["drift"].is_null(),
        ) {
            is_ground("ground", height, SAME);
        }
        folder.succeeds(&format!(
            "edit {input} -o reversed.bvh --step reverse --contacts-file contacts.json"
        ));
        let contacts: Value = serde_json::from_slice(&folder.read("contacts.json")).unwrap();
        let of_edit = contacts["floor"].as_f64().unwrap();
        let reversed = ground_of(&folder, "reversed.bvh");
        assert!((of_edit - reversed).abs() < WRITTEN, "{file}: {of_edit} and {reversed}");
        let scene = Importer::new().read(&bytes, &input).unwrap();
        let figure = Figure::new(&scene);
        let of_library = figure.ground(&scene).unwrap().value * figure.survey.metres_per_unit;
        is_ground("the library", of_library, 1e-6);
    }
}
