//! `mocap skeleton`.

use serde_json::Value;

/// The output of `mocap skeleton --json`: the fields that scripts rely on, then further fields.
#[test]
fn the_json_has_the_t_pose_beside_the_figure() {
    let output = crate::program::run(&["skeleton", "--json", "fixtures/real/rokoko_dance.bvh"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    for field in ["unit", "up", "facing", "root_offset", "rest_pose", "sides"] {
        assert!(
            found[field]["confidence"].is_string() && found[field]["reason"].is_string(),
            "{field}"
        );
    }
    assert_eq!(found["unit"]["name"], "cm");
    assert_eq!(found["humanoid"]["bones"]["hips"]["joint"], "Hips");
    let pose = &found["t_pose"];
    assert_eq!(pose["source"], "computed");
    let bones = pose["bones"].as_object().unwrap();
    assert_eq!(bones.len(), found["humanoid"]["bones"].as_object().unwrap().len());
    let mut largest = 0.0;
    for (bone, turn) in bones {
        let part = |place: usize| turn["rotation"][place].as_f64().unwrap();
        let [x, y, z, w] = [0, 1, 2, 3].map(part);
        assert!(((x * x + y * y + z * z + w * w) - 1.0).abs() < 1e-5, "{bone}");
        let degrees = turn["degrees"].as_f64().unwrap();
        assert!(
            (2.0 * w.abs().min(1.0).acos().to_degrees() - degrees).abs() < 0.1,
            "{bone}: {degrees}"
        );
        largest = f64::max(largest, degrees);
    }
    assert_eq!(pose["largest_rotation"].as_f64(), Some(largest));
}

/// `--explain` of a rejected skeleton ends with the deciding reason.
#[test]
fn an_explanation_of_a_refusal_ends_with_its_reason() {
    let dog = std::fs::read_to_string("../../fixtures/real/cmu_short.bvh").unwrap();
    // The feet get the names of paws.
    let dog = dog.replace("LeftFoot", "LeftPaw").replace("RightFoot", "RightPaw");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dog.bvh");
    std::fs::write(&file, dog).unwrap();
    let output = crate::program::run(&["skeleton", file.to_str().unwrap(), "--explain"]);
    let text = String::from_utf8(output.stdout).unwrap();
    let last = text.lines().last().unwrap();
    assert_eq!(last, "refused: \"LeftPaw\" is a part of an animal on four legs");
}
