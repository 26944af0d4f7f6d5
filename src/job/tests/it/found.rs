//! Tests that a command searches the bones of a skeleton only once.

use mocap_figure::found::searches;

/// Runs a job on a file of `fixtures/real` with these further keys, and counts the searches.
fn searches_of(keys: &str, output: &str) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join(output);
    let job = format!(
        r#"{{"source": {{"inputs": ["../../fixtures/real/cmu_01_01.bvh"], "frames": {{"drop-first-frame": "auto", "fps": 30}}}},
            {keys} "write": {{"output": {output:?}}}}}"#
    );
    let job = mocap::job::Job::from_json(&job).unwrap();
    searches(|| drop(job.run().unwrap()))
}

#[test]
fn one_retargeting_finds_its_source_and_its_target_once() {
    let onto = |file: &str| format!(r#""target": {{"character": {{"file": "../../fixtures/{file}"}}}},"#);
    assert_eq!(searches_of(&onto("skeletons/human_default.gltf"), "out.gltf"), 2);
    // The file states the bones of a VRM character.
    assert_eq!(searches_of(&onto("characters/human_vrm0.vrm"), "out.vrm"), 1);
    let steps = format!(
        r#"{} "steps": ["mirror", "smooth"],"#,
        onto("skeletons/human_default.gltf")
    );
    assert_eq!(searches_of(&steps, "out.gltf"), 2);
    let onto = r#""target": {"skeleton": {"file": "../../fixtures/real/rokoko_dance.bvh"}},"#;
    assert_eq!(searches_of(onto, "out.bvh"), 2);
    assert_eq!(searches_of(onto, "out.vrma"), 2);
}

#[test]
fn one_motion_on_a_robot_finds_its_source_once() {
    let onto = r#""target": {"robot": {"file": "../../fixtures/robots/h1.urdf"}},"#;
    assert_eq!(searches_of(onto, "out.csv"), 1);
}

#[test]
fn one_edit_finds_its_source_once() {
    let steps = r#""steps": ["root-motion", "mirror", "foot-lock", "smooth", "t-pose-first", "loop"],"#;
    assert_eq!(searches_of(steps, "out.bvh"), 1);
    assert_eq!(searches_of(steps, "out.vrma"), 1);
    assert_eq!(searches_of("", "out.glb"), 1);
}

/// Does the work of `mocap view` for a page that shows a file and a robot side by side.
#[cfg(feature = "render")]
#[test]
fn one_page_finds_its_source_once() {
    use mocap_edit::ContactOptions;
    use mocap_figure::Conversion;
    use mocap_figure::{Figure, HumanoidMap};
    use mocap_io::Importer;
    use mocap_render::{Clip, Page, PageClip};
    use mocap_retarget::{RetargetOptions, Retargeter};

    let mut scene = mocap_io::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let robot = Importer::new().import_robot("../../fixtures/robots/h1.urdf").unwrap();
    let found = searches(|| {
        let figure = Figure::mapped(&scene, &HumanoidMap::new()).unwrap();
        let (figure, _) = Conversion::new()
            .keep_units(true)
            .apply_to(&mut scene, &figure)
            .unwrap();
        let mut in_metres = scene.clone();
        Conversion::new().apply_to(&mut in_metres, &figure).unwrap();
        let contacts = ContactOptions::default()
            .detect(&scene, 0, Some(&figure.humanoid))
            .unwrap();
        let mut retargeting = Retargeter::onto(robot, RetargetOptions::new()).unwrap();
        let source = retargeting.prepare_figure(scene.clone(), &figure).unwrap();
        retargeting.add(source).unwrap();
        let clip = Clip {
            name: "walk",
            scene: &scene,
        };
        Page::new(&[PageClip::new(clip).figure(&figure).contacts(&contacts)]);
    });
    assert_eq!(found, 1);
}
