//! Tests of maps of bones, in files and in jobs.

use mocap::figure::{HumanoidBone, HumanoidMap};
use mocap::job::BoneMap;

/// The map in a file with this text.
fn of_file(text: &str) -> mocap::Result<HumanoidMap> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.json");
    std::fs::write(&path, text).unwrap();
    BoneMap::File(path).bones()
}

fn refusal(text: &str) -> String {
    of_file(text).unwrap_err().diagnostic().message.clone()
}

#[test]
fn a_map_says_the_same_in_a_file_in_a_report_and_in_a_job() {
    let in_job = serde_json::from_str(r#"{"hips": "Pelvis", "jaw": null, "follow": {"FootIK.L": "leftFoot"}}"#);
    let in_job: BoneMap = in_job.unwrap();
    let maps = [
        in_job.bones(),
        of_file(r#"{"bones": {"hips": "Pelvis", "jaw": null}, "follow": {"FootIK.L": "leftFoot"}}"#),
        of_file(
            r#"{"humanoid": {"bones": {"hips": {"joint": "Pelvis", "reason": "its name says so"}, "jaw": null},
            "follow": {"FootIK.L": "leftFoot"}}}"#,
        ),
    ];
    for map in maps {
        let map = map.unwrap();
        assert_eq!(map.len(), 2);
        assert_eq!(map[&HumanoidBone::Hips].as_deref(), Some("Pelvis"));
        assert_eq!(map[&HumanoidBone::Jaw], None);
        assert_eq!(map.follow, [("FootIK.L".to_owned(), "leftFoot".to_owned())].into());
    }
    let alone = of_file(r#"{"follow": {"Hat": "head"}}"#).unwrap();
    assert!(alone.bones.is_empty() && alone.follow["Hat"] == "head");
}

#[test]
fn a_bone_that_there_is_not_is_answered_with_the_nearest() {
    assert_eq!(
        refusal(r#"{"bones": {"lefthand": "Hand"}}"#),
        r#"unknown bone "lefthand"; did you mean "leftHand"? at line 1 column 21"#
    );
    assert_eq!(
        refusal(r#"{"bones": {"tentacle": "Arm9"}}"#),
        r#"unknown bone "tentacle": bones have the names of VRM, such as "leftUpperLeg" at line 1 column 21"#
    );
    assert!(refusal("{}").starts_with(r#"there is no object "bones""#));
}
