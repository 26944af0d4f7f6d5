//! `Retargeter`: its steps and their order, which every interface shares.

use mocap::convert::Moment;
use mocap::gltf::Character;
use mocap::retarget::report::ClipReport;
use mocap::retarget::report::RetargetedClip;
use mocap::retarget::{RetargetOptions, Retargeter, SourceMotion, Target};
use mocap::scene::Scene;
use mocap::scene::report::AppliedStep;
use mocap::{Code, Conversion, Importer};

const WALK: &str = "../../fixtures/real/cmu_12_01_walk.bvh";
const SHORT: &str = "../../fixtures/real/cmu_short.bvh";
const CHARACTER: &str = "../../fixtures/skeletons/human_vrm1.gltf";
const ROBOT: &str = "../../fixtures/robots/h1.urdf";

fn import(file: &str) -> Scene {
    mocap::import(file).unwrap()
}

fn character() -> Character {
    Importer::new().gltf_meshes(true).import_character(CHARACTER).unwrap()
}

fn names(clips: &[RetargetedClip]) -> Vec<&str> {
    clips.iter().map(|clip| clip.animation.name.as_str()).collect()
}

/// In CMU's files the first frame is a rest pose.
#[test]
fn a_rest_pose_in_the_first_frame_is_left_out_for_every_target() {
    let frames = import(SHORT).animations[0].frame_count();
    let robot = Importer::new().import_robot(ROBOT).unwrap();
    for target in [Target::from(character()), import(WALK).into(), robot.into()] {
        let retargeting = Retargeter::new(import(SHORT), target, RetargetOptions::new()).unwrap();
        let clip = &retargeting.clips()[0];
        assert_eq!(clip.animation.frame_count(), frames - 1);
        assert_eq!(clip.provenance.frames, frames as u64 - 1);
        assert_eq!(
            retargeting.sources().next().unwrap().scene().metadata.metres_per_unit,
            Some(1.0)
        );
    }
}

#[test]
fn clips_have_names_that_no_other_clip_of_the_output_has() {
    let mut retargeting = Retargeter::onto(character(), RetargetOptions::new()).unwrap();
    for name in ["walk", "walk", "run"] {
        let source = retargeting.prepare(import(SHORT)).unwrap();
        retargeting.add(source.named(name)).unwrap();
    }
    assert_eq!(names(retargeting.clips()), ["walk", "walk_2", "run"]);
    for clip in retargeting.clips() {
        assert_eq!(clip.report.body().unwrap().clip, clip.animation.name);
    }
    let file = retargeting.character_file().unwrap().unwrap().into_bytes().unwrap();

    // The clips of the character also count, unless they are dropped.
    let moving = Importer::new().read_character(
        mocap::MemoryFile {
            name: "moving.gltf",
            bytes: &file,
        },
        &[],
    );
    let moving = Target::from(moving.unwrap());
    for (replace, expected, clips) in [(false, "run_2", 4), (true, "run", 1)] {
        let options = RetargetOptions::new().replace_animations(replace);
        let mut more = Retargeter::onto(moving.clone(), options).unwrap();
        let source = more.prepare(import(SHORT)).unwrap();
        more.add(source.named("run")).unwrap();
        assert_eq!(names(more.clips()), [expected]);
        let written = more.character_file().unwrap().unwrap().into_bytes().unwrap();
        let written = Importer::new().read(&written, "more.gltf").unwrap();
        assert_eq!(written.animations.len(), clips);
    }
}

#[test]
fn a_source_with_several_motions_gives_a_clip_of_each() {
    let mut scene = import(SHORT);
    scene.animations[0].name = "first".to_owned();
    let second = mocap::scene::Animation {
        name: "second".to_owned(),
        ..scene.animations[0].clone()
    };
    scene.animations.push(second);
    let retargeting = Retargeter::new(scene, character(), RetargetOptions::new()).unwrap();
    assert_eq!(names(retargeting.clips()), ["first", "second"]);
    let selected = |clip: &RetargetedClip| clip.provenance.steps.first().cloned();
    let of = |index| Some(AppliedStep::SelectClip { index });
    assert_eq!(
        retargeting.clips().iter().map(selected).collect::<Vec<_>>(),
        [of(0), of(1)]
    );
}

#[test]
fn the_provenance_says_where_a_motion_is_from_and_onto_what_it_went() {
    let retargeting = Retargeter::new(import(SHORT), character(), RetargetOptions::new()).unwrap();
    let provenance = &retargeting.clips()[0].provenance;
    assert_eq!(provenance.source.as_ref().unwrap().name, "cmu_short.bvh");
    let Some(AppliedStep::Retarget { onto, lock_feet, .. }) = provenance.steps.last() else {
        panic!("{:?}", provenance.steps);
    };
    assert_eq!(onto.source.as_ref().unwrap().name, "human_vrm1.gltf");
    assert!(lock_feet);
    // A written scene has the same record.
    let scene = retargeting.scene();
    assert_eq!(scene.metadata.origin.unwrap().name, "cmu_short.bvh");
    assert_eq!(scene.metadata.steps.len(), provenance.steps.len());
}

#[test]
fn what_cannot_be_moved_is_an_error_and_changes_nothing() {
    let code = |result: mocap::Result<Retargeter>| result.unwrap_err().code();
    let arm = import("../../fixtures/real/lecture_Test.bvh");
    assert_eq!(
        code(Retargeter::onto(arm.clone(), RetargetOptions::new())),
        Code::NotHumanoid
    );
    let wrong = [(mocap::figure::HumanoidBone::Head, Some("Hat".to_owned()))];
    let target_bones = RetargetOptions::new().target_bones(wrong.clone().into());
    assert_eq!(code(Retargeter::onto(character(), target_bones)), Code::InvalidValue);
    let source_bones = RetargetOptions::new().source_bones(wrong.into());
    assert_eq!(
        code(Retargeter::new(import(SHORT), character(), source_bones)),
        Code::InvalidValue
    );

    let mut retargeting = Retargeter::new(import(SHORT), character(), RetargetOptions::new()).unwrap();
    let refused = retargeting.add(SourceMotion::converted(arm)).unwrap_err();
    assert_eq!(refused.code(), Code::NotHumanoid);
    let still = Scene {
        animations: Vec::new(),
        ..import(SHORT)
    };
    let refused = retargeting.add(SourceMotion::converted(still)).unwrap_err();
    assert_eq!(refused.code(), Code::NoMotion);
    assert_eq!(names(retargeting.clips()), ["cmu_short"]);
    assert_eq!(retargeting.sources().count(), 1);
}

/// The mean of the limbs' angles equals the mean in the report.
#[test]
fn the_angles_of_the_limbs_are_those_of_the_report() {
    let options = RetargetOptions::new().lock_feet(false);
    let retargeting = Retargeter::new(import(SHORT), character(), options).unwrap();
    let ClipReport::Body(report) = &retargeting.clips()[0].report else {
        panic!("the target is a character");
    };
    let angles = retargeting.limb_angles(0).unwrap();
    for limb in &report.limbs {
        let found = angles.iter().find(|angles| angles.bone == limb.bone).unwrap();
        let largest = found.degrees.iter().copied().fold(0.0, f32::max);
        assert!((f64::from(largest) - limb.max_degrees).abs() < 1e-3, "{limb:?}");
    }
    assert_eq!(retargeting.limb_angles(1), None);
}

/// A limb of a robot is between links, and these links give its angles.
#[test]
fn the_angles_of_the_limbs_of_a_robot_are_those_of_its_report() {
    let robot = Importer::new().import_robot("../../fixtures/robots/h1.urdf").unwrap();
    let links = robot.links.len();
    let retargeting = Retargeter::new(import(SHORT), robot, RetargetOptions::new()).unwrap();
    let ClipReport::Robot(report) = &retargeting.clips()[0].report else {
        panic!("the target is a robot");
    };
    let angles = retargeting.limb_angles(0).unwrap();
    assert!(report.limbs.len() >= 8 && angles.len() >= report.limbs.len());
    for limb in &report.limbs {
        let found = angles.iter().find(|angles| angles.bone == limb.bone).unwrap();
        assert!(found.node.index() < links && found.degrees.len() == report.frames);
        let sum: f64 = found.degrees.iter().map(|degrees| f64::from(*degrees)).sum();
        assert!(
            (sum / report.frames as f64 - limb.mean_degrees).abs() < 1e-3,
            "{limb:?}"
        );
    }
}

/// Rest poses in which the figure does not stand. Only the motion shows the T-pose of their bones.
#[test]
fn a_part_of_a_motion_on_a_character_is_that_part_of_the_whole() {
    for file in [
        "real/rokoko_dance.bvh",
        "skeletons/vicon_sword_attack.bvh",
        "skeletons/animics_all_along_z.bvh",
    ] {
        let source = import(&format!("../../fixtures/{file}"));
        let moved = |conversion: Conversion| {
            let options = RetargetOptions::new()
                .lock_feet(false)
                .keep_hands(false)
                .conversion(conversion);
            let retargeting = Retargeter::new(source.clone(), character(), options).unwrap();
            retargeting.into_clips().remove(0).animation
        };
        let count = source.animations[0].frame_count() as u64;
        let (first, last) = (count / 3, count / 3 + 20);
        let whole = moved(Conversion::new());
        let part = moved(Conversion::new().trim(Moment::Frame(first), Moment::Frame(last)));
        assert_eq!(part.frame_count() as u64, last - first + 1);
        for (of_whole, of_part) in std::iter::zip(&whole.channels, &part.channels) {
            let at = |frame: u64| of_whole.rotation_keys.values[frame as usize % of_whole.rotation_keys.values.len()];
            for (frame, rotation) in (first..).zip(&of_part.rotation_keys.values) {
                let off = rotation.angle_between(at(frame)).to_degrees();
                assert!(
                    off < 0.1,
                    "{file}: {} at frame {frame}: {off} degrees",
                    of_whole.node_name
                );
            }
        }
    }
}
