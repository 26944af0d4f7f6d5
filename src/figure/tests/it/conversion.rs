//! `Conversion`, and its guesses in written files.

use mocap::convert::{FirstFrame, Moment, RestPoseSource, RootMotion};
use mocap::figure::{Figure, Survey, Unit};
use mocap::glam::Vec3;
use mocap::gltf::{Document, GltfOptions};
use mocap::scene::report::AppliedStep;
use mocap::scene::{Scene, Topic, UpAxis};
use mocap::{Code, Conversion};

fn survey_of(scene: &Scene) -> Survey {
    Figure::new(scene).survey
}

fn import(file: &str) -> Scene {
    mocap::import(format!("../../fixtures/real/{file}")).unwrap()
}

fn topics(conversion: &Conversion, scene: &mut Scene) -> Vec<Topic> {
    let assumptions = conversion.apply(scene).unwrap();
    assumptions.iter().map(|assumption| assumption.topic).collect()
}

#[test]
fn the_default_brings_metres_and_says_what_it_guessed() {
    let source = import("cmu_short.bvh");
    let mut scene = source.clone();
    let assumptions = Conversion::new().apply(&mut scene).unwrap();
    // The first frame is a rest pose. The conversion reports this, although it keeps the frame.
    let expected = [(Topic::FirstFrame, "rest-pose"), (Topic::Unit, "cmu"), (Topic::Up, "y")];
    let found: Vec<_> = assumptions.iter().map(|one| (one.topic, &*one.choice)).collect();
    assert_eq!(found, expected);
    let recorded = &scene.metadata.assumptions;
    assert_eq!(recorded[..3], assumptions);
    let figure: Vec<_> = recorded[3..].iter().map(|one| (one.topic, &*one.choice)).collect();
    assert_eq!(
        figure,
        [
            (Topic::Humanoid, "yes"),
            (Topic::Facing, "z"),
            (Topic::RestPose, "t-pose"),
            (Topic::Sides, "agree")
        ]
    );
    assert!(
        recorded
            .iter()
            .all(|one| one.confidence.is_some() && !one.reason.is_empty())
    );
    assert_eq!(
        scene.metadata.steps,
        [AppliedStep::ConvertUnits {
            metres_per_unit: 0.0254 / 0.45,
            up: UpAxis::Y,
            out_metres_per_unit: 1.0,
            out_up: UpAxis::Y,
        }]
    );
    assert_eq!(
        (scene.metadata.metres_per_unit, scene.metadata.up),
        (Some(1.0), Some(UpAxis::Y))
    );
    for (before, after) in std::iter::zip(&source.nodes, &scene.nodes) {
        let expected = before.transform.w_axis.truncate().as_dvec3() * (0.0254 / 0.45);
        assert_eq!(after.transform.w_axis.truncate(), expected.as_vec3());
    }
}

#[test]
fn a_scene_that_was_converted_stays_as_it_is() {
    for file in ["cmu_short.bvh", "cmu_02_01.amc", "py_c3d_motion.c3d", "z_up_dab.bvh"] {
        let mut once = import(file);
        Conversion::new().apply(&mut once).unwrap();
        let mut twice = once.clone();
        let guessed = topics(&Conversion::new(), &mut twice);
        assert!(
            !guessed.contains(&Topic::Unit) && !guessed.contains(&Topic::Up),
            "{file}: {guessed:?}"
        );
        assert_eq!((once.nodes, once.animations), (twice.nodes, twice.animations), "{file}");
    }
}

#[test]
fn what_is_named_is_not_guessed() {
    let mut scene = import("lecture_Test.bvh");
    let named = Conversion::new().metres_per_unit(0.5).up(UpAxis::Z);
    assert_eq!(topics(&named, &mut scene), []);
    // The shoulder of frame n is at (0.1 (n + 1), 0.02 n, 0). The conversion halves it and turns y to -z.
    let last = scene.animations[0].channels[0].position_keys.values[9];
    assert!(last.abs_diff_eq(Vec3::new(0.5, 0.0, -0.09), 1e-6), "{last}");

    // An AMC file's skeleton states its unit.
    let mut scene = import("cmu_02_01.amc");
    assert_eq!(topics(&Conversion::new(), &mut scene), [Topic::Up]);
}

#[test]
fn units_that_are_kept_stay_unknown() {
    let source = import("lecture_Test.bvh");
    let mut scene = source.clone();
    assert_eq!(topics(&Conversion::new().keep_units(true), &mut scene), []);
    assert!(std::mem::take(&mut scene.metadata.keeps_unknown_unit));
    assert_eq!(scene, source);

    // A stated value is recorded, and no number changes.
    let kept = Conversion::new().keep_units(true);
    let mut named = source.clone();
    assert_eq!(
        topics(&kept.clone().metres_per_unit(0.01).up(UpAxis::Z), &mut named),
        []
    );
    assert_eq!(
        (named.metadata.metres_per_unit, named.metadata.up),
        (Some(0.01), Some(UpAxis::Z))
    );
    assert_eq!((&named.nodes, &named.animations), (&source.nodes, &source.animations));

    // The unit or the axis can be converted alone. Then only this value is guessed.
    let mut turned = source.clone();
    let guessed = topics(&kept.clone().up(UpAxis::Z).out_up(UpAxis::Y), &mut turned);
    assert_eq!(guessed, []);
    assert_eq!(
        (turned.metadata.metres_per_unit, turned.metadata.up),
        (None, Some(UpAxis::Y))
    );
    let mut scaled = source.clone();
    assert_eq!(topics(&kept.out_metres_per_unit(0.01), &mut scaled), [Topic::Unit]);
    assert_eq!(
        (scaled.metadata.metres_per_unit, scaled.metadata.up),
        (Some(0.01), None)
    );
}

/// The shoulder of frame n is at (0.1 (n + 1), 0.02 n, 0).
#[test]
fn the_unit_and_the_up_axis_of_the_output_are_those_asked_for() {
    let last = |conversion: Conversion| {
        let mut scene = import("lecture_Test.bvh");
        conversion.apply(&mut scene).unwrap();
        (
            scene.animations[0].channels[0].position_keys.values[9],
            scene.nodes[1].transform.w_axis.x,
        )
    };
    let named = || Conversion::new().metres_per_unit(0.01).up(UpAxis::Y);
    // Two of the output's units are 2 cm.
    let (shoulder, elbow) = last(named().out_metres_per_unit(0.001).out_up(UpAxis::Z));
    assert!(shoulder.abs_diff_eq(Vec3::new(10.0, 0.0, 1.8), 1e-5), "{shoulder}");
    assert_eq!(elbow, 20.0);
    // A file with +Z up does not change.
    let (shoulder, _) = last(Conversion::new().metres_per_unit(1.0).up(UpAxis::Z).out_up(UpAxis::Z));
    assert_eq!(shoulder, Vec3::new(1.0, 0.18, 0.0));
    for wrong in [0.0, f64::NAN] {
        let error = Conversion::new().out_metres_per_unit(wrong).check().unwrap_err();
        assert_eq!(error.code(), Code::InvalidValue);
    }
}

#[test]
fn the_ground_is_found_where_z_is_up_too() {
    let source = import("z_up_dab.bvh");
    let heights = |scene: &Scene| -> Vec<f32> {
        let keys = &scene.animations[0].channels[0].position_keys;
        keys.values.iter().map(|position| position.z).collect()
    };
    let mut scene = source.clone();
    let in_place = Conversion::new().keep_units(true).root(RootMotion::InPlace);
    assert_eq!(topics(&in_place, &mut scene), [Topic::Up]);
    assert!(heights(&source).iter().any(|height| *height != heights(&source)[0]));
    for (before, after) in std::iter::zip(heights(&source), heights(&scene)) {
        assert!((before - after).abs() < 1e-4, "{before} {after}");
    }
    let values = &scene.animations[0].channels[0].position_keys.values;
    let start = values[0];
    assert!(values.iter().all(|at| (at.x, at.y) == (start.x, start.y)));
    assert_eq!(scene.metadata.up, Some(UpAxis::Z));
}

/// The frame time of the file is .0083333, a rounded 1/120.
#[test]
fn the_rate_that_was_meant_is_said_where_it_is_taken() {
    let rate = |frames_per_second: f64| {
        let mut scene = import("cmu_short.bvh");
        let conversion = Conversion::new().frame_rate(frames_per_second);
        let assumptions = conversion.apply(&mut scene).unwrap();
        // The recorded step tells readers of the output.
        let recorded = scene.metadata.assumptions.iter();
        assert!(recorded.clone().all(|assumption| assumption.topic != Topic::FrameRate));
        let said = assumptions.into_iter().find(|one| one.topic == Topic::FrameRate);
        (said.map(|said| said.to_string()), scene.animations[0].frame_count())
    };
    let meant = "frame-rate: 120, because the frame time 0.008333300 is 1/120 rounded to 7 decimals (sure)";
    assert_eq!(rate(30.0), (Some(meant.to_owned()), 19));
    assert_eq!(rate(24.0), (Some(meant.to_owned()), 15));
    // At 50 per second, most frames fall between two frames of the file, whether its rate is 120 or 1/.0083333.
    assert_eq!(rate(50.0), (None, 31));
}

#[test]
fn frames_are_named_by_their_numbers_in_the_file() {
    let at = |conversion: Conversion| {
        let mut scene = import("lecture_Test.bvh");
        conversion.keep_units(true).apply(&mut scene).unwrap();
        // The shoulder of frame n is at x = 0.1 (n + 1).
        let keys = &scene.animations[0].channels[0].position_keys;
        let frame = |x: f32| (10.0 * x).round() as u32 - 1;
        (frame(keys.values[0].x), frame(keys.values[keys.len() - 1].x), scene)
    };
    let ends = |conversion: Conversion| {
        let (first, last, _) = at(conversion);
        (first, last)
    };
    let new = Conversion::new;
    assert_eq!(ends(new().first_frame(FirstFrame::Drop)), (1, 9));
    assert_eq!(ends(new().first_frame(FirstFrame::DropRestPose)), (0, 9));
    assert_eq!(ends(new().trim(Moment::Frame(3), None)), (3, 9));
    assert_eq!(ends(new().trim(None, Moment::Frame(900))), (0, 9));
    assert_eq!(ends(new().trim(Moment::Seconds(0.24), Moment::Seconds(0.5))), (2, 5));
    assert_eq!(
        ends(
            new()
                .first_frame(FirstFrame::Drop)
                .trim(Moment::Frame(0), Moment::Frame(4))
        ),
        (1, 4)
    );
    // The rest pose is taken from frame 1, before this frame is trimmed.
    let (_, _, scene) = at(new().rest(RestPoseSource::Frame(1)).trim(Moment::Frame(3), None));
    assert!((scene.nodes[0].transform.w_axis.x - 0.2).abs() < 1e-6);
}

#[test]
fn a_conversion_without_meaning_changes_nothing() {
    let positive = "must be finite and above 0, got";
    let new = Conversion::new;
    let cases = [
        (new().frame_rate(0.0), format!("frame rate {positive} 0")),
        (new().frame_rate(-30.0), format!("frame rate {positive} -30")),
        (new().frame_rate(f64::NAN), format!("frame rate {positive} NaN")),
        (new().frame_rate(f64::INFINITY), format!("frame rate {positive} inf")),
        (new().metres_per_unit(0.0), format!("metres per unit {positive} 0")),
        (
            new().metres_per_unit(f64::NAN),
            format!("metres per unit {positive} NaN"),
        ),
        (
            new().trim(Moment::Seconds(-1.0), None),
            "a time must be at least 0 seconds, got -1".to_owned(),
        ),
        (
            new().trim(None, Moment::Seconds(f64::NAN)),
            "a time must be at least 0 seconds, got NaN".to_owned(),
        ),
        (
            new().trim(Moment::Frame(10), None),
            "the part to keep begins after the last frame; expected at most frame 9, 0.900 seconds from the start; \
             found frame 10"
                .to_owned(),
        ),
        (
            new().trim(Moment::Seconds(0.5), Moment::Frame(2)),
            "the part to keep ends before it begins; expected frame 5 or a later one; found frame 2".to_owned(),
        ),
        (
            new().rest(RestPoseSource::Frame(10)),
            "the frame of the rest pose is after the last frame; expected at most frame 9, 0.900 seconds from the \
             start; found frame 10"
                .to_owned(),
        ),
    ];
    let source = import("lecture_Test.bvh");
    for (conversion, message) in cases {
        let mut scene = source.clone();
        let error = conversion.root(RootMotion::Extract).apply(&mut scene).unwrap_err();
        assert_eq!(
            (error.code(), error.diagnostic().to_string()),
            (Code::InvalidValue, message)
        );
        assert_eq!(scene, source);
    }
}

#[test]
fn writing_what_is_not_in_metres_gives_a_warning() {
    let warnings = |scene: &Scene| {
        let document = Document::new(scene, &GltfOptions::default()).unwrap();
        let warnings = document.report().warnings.clone();
        warnings
            .into_iter()
            .map(|warning| (warning.code, warning.message))
            .collect::<Vec<_>>()
    };
    let nobody = "glTF is in metres, but the unit of the scene is not stated";
    let mut scene = import("lecture_Test.bvh");
    assert_eq!(warnings(&scene), [(Code::UnknownUnit, nobody.to_owned())]);
    scene.metadata.metres_per_unit = Some(1.0);
    assert_eq!(warnings(&scene), []);

    let millimetres = "glTF is in metres, but the scene is in units of 0.001 m";
    let mut scene = import("py_c3d_motion.c3d");
    assert_eq!(warnings(&scene), [(Code::UnknownUnit, millimetres.to_owned())]);
    Conversion::new().apply(&mut scene).unwrap();
    assert_eq!(warnings(&scene), []);
}

/// The report also has the warnings of the export.
#[test]
fn an_export_returns_its_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let scene = import("lecture_Test.bvh");
    for name in ["a.glb", "a.gltf"] {
        let report = mocap::Exporter::new().export(&scene, folder.path().join(name)).unwrap();
        assert_eq!(report.warnings[0].code, Code::UnknownUnit);
        assert!(report.warnings[0].help.as_ref().unwrap().contains("Conversion"));
    }
}

/// The reason names the missing part. Three bodies show no axis: a head alone, feet alone, and a head at the position
/// of the feet.
#[test]
fn an_up_axis_that_nothing_shows_says_why() {
    let reason = |joints: &[(&str, f32)]| {
        let mut text = "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 1 Zrotation\n".to_owned();
        for (name, y) in joints {
            text += &format!(
                "JOINT {name}\n{{\nOFFSET 0 {y} 0\nCHANNELS 1 Zrotation\nEnd Site\n{{\nOFFSET 0 0 0\n}}\n}}\n"
            );
        }
        let rows = format!("0 {}\n", "0 ".repeat(joints.len())).repeat(2);
        text += &format!("}}\nMOTION\nFrames: 2\nFrame Time: 0.1\n{rows}");
        let scene = mocap::Importer::new().read(text.as_bytes(), "a.bvh").unwrap();
        survey_of(&scene).up.reason
    };
    let feet = [("LeftFoot", -8.0), ("RightFoot", -8.0)];
    let with_head = |y: f32, feet: &[(&'static str, f32)]| reason(&[&[("head", y)], feet].concat());
    assert_eq!(
        reason(&[("arm", 2.0)]),
        "no joint is called head or foot, and most files are Y up"
    );
    assert_eq!(with_head(6.0, &[]), "no joint is called foot, and most files are Y up");
    assert_eq!(reason(&feet), "no joint is called head, and most files are Y up");
    assert_eq!(
        with_head(-8.0, &feet),
        "the head and the feet are at the same point, and most files are Y up"
    );
    let found = with_head(6.0, &feet);
    assert!(
        found.starts_with("the vector from the feet to the head is (0.0000, 14.0000, 0.0000)"),
        "{found}"
    );
}

#[test]
fn a_survey_knows_what_the_file_states() {
    let mut scene = import("cmu_short.bvh");
    assert_eq!(survey_of(&scene).metres_per_unit, Unit::Cmu.metres());
    scene.metadata.metres_per_unit = Some(0.01);
    let found = survey_of(&scene);
    assert_eq!((found.metres_per_unit, found.unit.value), (0.01, Unit::Cmu));
    assert_eq!(found.assumption(Topic::Unit), None);
}

/// In this file, the sides in the joint names are the sides in a camera's picture, so left and right are exchanged.
#[test]
fn names_of_the_wrong_side_are_said() {
    let mut scene = import("kinect_openni.bvh");
    let assumptions = Conversion::new().apply(&mut scene).unwrap();
    let sides: Vec<_> = assumptions.iter().filter(|one| one.topic == Topic::Sides).collect();
    assert_eq!(sides.len(), 1);
    assert_eq!(sides[0].choice, "opposite");
    let recorded = scene.metadata.assumptions.iter();
    assert_eq!(recorded.filter(|one| one.topic == Topic::Sides).count(), 1);
}
