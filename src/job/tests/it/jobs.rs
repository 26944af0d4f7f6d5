//! Tests of jobs that the library runs: refused jobs, and equal results in memory and on a disk.

use std::fs;

use mocap::convert::{FirstFrame, Moment};
use mocap::job::{InputOptions, Job};
use mocap::retarget::robot::RobotMotion;
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::{Conversion, MemoryFile};

#[test]
fn a_wrong_job_says_where() {
    for (json, expected) in [
        ("", "the job: it must be a JSON object"),
        ("{", "the job: the text is not JSON: EOF while parsing an object"),
        ("[]", "the job: it must be a JSON object"),
        (r#"{} {}"#, "the job: text follows the JSON object"),
        (
            r#"{"wirte": {}}"#,
            "the job: wirte: a motion job has no wirte; known keys: read, source, steps, target, weights, write, verify",
        ),
        (
            r#"{"write": {"smaller": {"max-error": "far"}}}"#,
            "the job: write.smaller: \"far\": not a length, such as 1mm",
        ),
        (
            r#"{"source": {"frames": {"fps": "fast"}}}"#,
            "the job: source.frames.fps: expected a number; found string \"fast\" at line 1 column ",
        ),
        (
            r#"{"target": {"animal": {}}}"#,
            "the job: target: expected character, skeleton, robot; found animal",
        ),
        // An option of another kind of target.
        (
            r#"{"target": {"robot": {"file": "h1.urdf", "max-angle": 3}}}"#,
            "the job: target.robot.max-angle: a motion job has no max-angle in target.robot; known keys: file, map, scale, feet, \
             names-of-clips, passes, velocity-limits, floor, time-scale, require",
        ),
        (
            r#"{"target": {"skeleton": {"file": "a.bvh", "velocity-limits": true}}}"#,
            "the job: target.skeleton.velocity-limits: a motion job has no velocity-limits in target.skeleton",
        ),
        (
            r#"{"target": {"skeleton": {"file": "a.bvh", "replace-animations": true}}}"#,
            "the job: target.skeleton.replace-animations: a motion job has no replace-animations in target.skeleton",
        ),
        (
            r#"{"target": {"character": {"file": "a.glb", "passes": 1}}}"#,
            "the job: target.character.passes: a motion job has no passes in target.character",
        ),
        (
            r#"{"target": {"character": {"file": "a.glb", "feet": "glue"}}}"#,
            "the job: target.character.feet: expected lock, free; found glue",
        ),
        (r#"{"steps": ["shake"]}"#, "there is no step \"shake\""),
        // A key of another kind of job.
        (
            r#"{"survey": {}, "steps": ["mirror"]}"#,
            "the job: steps: a survey job has no steps",
        ),
        (
            r#"{"target": {"robot": {"file": "h1.urdf"}}, "survey": {}}"#,
            "the job: target: a survey job has no target",
        ),
        (
            r#"{"graph": {}, "steps": ["mirror"]}"#,
            "the job: steps: a graph job has no steps",
        ),
        (
            r#"{"graph": {}, "survey": {}}"#,
            "the job: survey: a graph job has no survey",
        ),
        (
            r#"{"graph": {}, "walk": {"seconds": 5}, "survey": {}}"#,
            "the job: survey: a walk job has no survey",
        ),
        (
            r#"{"walk": {"seconds": 5}, "verify": true}"#,
            "the job: verify: a walk job has no verify",
        ),
        (
            r#"{"walk": {"seconds": 5}, "graph": {"matrix": "a.png"}}"#,
            "the job: graph.matrix: a walk job has no matrix in graph",
        ),
        (
            r#"{"matrix": "a.png", "write": {"output": "a.glb"}}"#,
            "the job: matrix: a motion job has no matrix",
        ),
        // A nested key of another kind of job.
        (
            r#"{"survey": {}, "source": {"frames": {"fps": 30}}}"#,
            "the job: source.frames: a survey job has no frames in source; known keys: inputs",
        ),
        (
            r#"{"survey": {}, "write": {"output": "a.csv", "mesh": "none"}}"#,
            "the job: write.mesh: a survey job has no mesh in write; known keys: output, to, force",
        ),
        (
            r#"{"graph": {}, "source": {"map": {"hips": "a"}}}"#,
            "the job: source.map: a graph job has no map in source; known keys: inputs, space",
        ),
        (
            r#"{"walk": {"seconds": 5}, "source": {"frames": {}}}"#,
            "the job: source.frames: a walk job has no frames in source; known keys: inputs, with, space",
        ),
        (
            r#"{"walk": {"seconds": "long"}}"#,
            "the job: walk.seconds: expected a number; found string \"long\"",
        ),
        (r#"{"survey": {}, "survey": {}}"#, "duplicate field `survey`"),
    ] {
        let error = Job::from_json(json).unwrap_err();
        let message = &error.diagnostic().message;
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn a_misspelled_word_of_a_job_has_a_near_one() {
    for (json, near) in [
        (r#"{"wirte": {}}"#, "write"),
        (r#"{"source": {"input": []}}"#, "inputs"),
        (r#"{"target": {"robt": {}}}"#, "robot"),
        (r#"{"survey": {}, "write": {"ouput": "a.csv"}}"#, "output"),
    ] {
        let error = Job::from_json(json).unwrap_err();
        let help = error.diagnostic().help.clone();
        assert_eq!(help, Some(format!("did you mean {near}?")), "{json}");
    }
}

/// The keys of an object determine the kind of its job, whatever their order.
#[test]
fn the_keys_of_a_job_tell_its_kind() {
    let kind = |json: &str| match Job::from_json(json).unwrap() {
        Job::Motion(_) => "motion",
        Job::Survey(_) => "survey",
        Job::Graph(_) => "graph",
        Job::Walk(_) => "walk",
        _ => "another",
    };
    for (json, expected) in [
        ("{}", "motion"),
        (
            r#"{"source": {"inputs": ["a.bvh"]}, "write": {"output": "a.glb"}}"#,
            "motion",
        ),
        (r#"{"survey": {}}"#, "survey"),
        (
            r#"{"write": {"output": ""}, "survey": {"threshold": ["skate=2"]}}"#,
            "survey",
        ),
        (r#"{"source": {"inputs": ["a.bvh"]}, "graph": {}}"#, "graph"),
        (r#"{"graph": {}, "walk": {"seconds": 5}}"#, "walk"),
        (r#"{"walk": {"seconds": 5}, "graph": {}}"#, "walk"),
        (r#"{"walk": {"seconds": 5}, "steps": ["mirror"]}"#, "walk"),
    ] {
        assert_eq!(kind(json), expected, "{json}");
    }
}

#[test]
fn a_job_refuses_what_its_format_does_not_take() {
    let refused = |write: &str| {
        let json = format!(r#"{{"source": {{"inputs": ["../../fixtures/real/lecture_Test.bvh"]}}, "write": {write}}}"#);
        let error = Job::from_json(&json).unwrap().run().unwrap_err();
        (error.code().as_str(), error.diagnostic().message.clone())
    };
    let (code, message) = refused(r#"{"output": "a.glb", "bvh": {"digits": 3}}"#);
    assert_eq!(code, "invalid-value");
    assert!(message.starts_with("`digits` has no effect on"), "{message}");
    assert_eq!(refused(r#"{"output": "a.xyz"}"#).0, "unknown-format");
    let (code, message) = refused("{}");
    assert_eq!(code, "unknown-format");
    assert!(message.starts_with("the output has no name: "), "{message}");
    assert_eq!(
        refused(r#"{"output": "../../fixtures/real/lecture_Test.bvh", "force": true}"#).0,
        "output-is-input"
    );
}

/// Options of another format, of another body and of a folder are refused, and so are outputs that are inputs.
#[test]
fn a_job_refuses_what_would_do_nothing() {
    const WALK: &str = r#""source": {"inputs": ["../../fixtures/real/cmu_short.bvh"]}"#;
    let refused = |rest: &str, expected: &str| {
        let json = format!("{{{WALK}, {rest}}}");
        let error = Job::from_json(&json).unwrap().run().unwrap_err();
        assert!(error.to_string().contains(expected), "{json}: {error}");
    };
    let hero = r#""target": {"character": {"file": "../../fixtures/skeletons/human_vrm1.gltf"}}"#;
    let robot = r#""target": {"robot": {"file": "../../fixtures/robots/h1.urdf"}}"#;
    for (write, expected) in [
        (
            r#""output": "a.gltf", "bvh": {"digits": 3}"#,
            "`digits` has no effect on glTF",
        ),
        (
            r#""output": "a.gltf", "keep-constant": true"#,
            "`keep_constant` has no effect on a character, because mocap keeps the contents",
        ),
        (r#""output": "a.glb""#, "must end in .gltf, like the character's file"),
        (
            r#""output": "a.gltf", "smaller": {"shell-distance": "3cm"}"#,
            "`shell_distance` would do nothing",
        ),
        (
            r#""output": "a.bvh", "space": {"out-unit": "cm"}, "embed": true"#,
            "`embed` has no effect",
        ),
        (
            r#""output": "../../fixtures/skeletons/human_vrm1.gltf", "force": true"#,
            "output-is-input",
        ),
    ] {
        refused(&format!(r#"{hero}, "write": {{{write}}}"#), expected);
    }
    for (write, expected) in [
        (
            r#""output": "a.npz", "smaller": {"max-error": "1mm"}"#,
            "`max_error` has no effect on the joint positions of a robot",
        ),
        (r#""output": "a.xyz""#, "must end in .npz, .pkl, .csv, .bvh"),
        (r#""output": "out/", "to": "csv""#, "run it with mocap run"),
        (
            r#""output": "-", "to": "csv""#,
            "standard output, which only mocap run supports",
        ),
    ] {
        refused(&format!(r#"{robot}, "write": {{{write}}}"#), expected);
    }
    for frames in [r#""rest": "t-pose""#, r#""root": "extract""#] {
        let source = WALK.replace("}", &format!(r#", "frames": {{{frames}}}}}"#));
        let json = format!(r#"{{{source}, "write": {{"output": "a.vrma"}}}}"#);
        let error = Job::from_json(&json).unwrap().run().unwrap_err();
        assert!(error.to_string().contains("has no effect on "), "{json}: {error}");
    }
    for kind in ["character", "skeleton"] {
        let named = format!(
            r#""target": {{"{kind}": {{"file": "../../fixtures/robots/h1.urdf"}}}}, "write": {{"output": "a.bvh"}}"#
        );
        refused(
            &named,
            "h1.urdf: error[invalid-value]: the target is a robot, not a character",
        );
    }
    // The file of the character is not passed through, so there are no animations to replace.
    let replacing = hero.replace(r#".gltf""#, r#".gltf", "replace-animations": true"#);
    refused(
        &format!(r#"{replacing}, "write": {{"output": "a.fbx"}}"#),
        "`replace_animations` would do nothing",
    );
    // A second motion is an input too.
    let with = r#"{"source": {"inputs": ["../../fixtures/real/lecture_Test.bvh"], "with": ["../../fixtures/real/cmu_short.bvh"]},
        "steps": ["concat"], "write": {"output": "../../fixtures/real/cmu_short.bvh", "force": true}}"#;
    let error = Job::from_json(with).unwrap().run().unwrap_err();
    assert_eq!(error.code().as_str(), "output-is-input");
    // These formats hold one motion only, and no motion is dropped silently.
    let two = format!(
        r#"{{"source": {{"inputs": ["../../fixtures/real/cmu_short.bvh", "../../fixtures/real/cmu_short.bvh"],
        "frames": {{"trim": "0..0.1"}}}}, {robot}, "write": {{"output": "two.csv"}}}}"#
    );
    let error = Job::from_json(&two).unwrap().run().unwrap_err();
    assert!(
        error.to_string().contains("holds one motion; name only one motion"),
        "{error}"
    );
}

/// The search for a robot's T-pose uses the rest pose at the beginning of the motion, whatever part is used.
#[test]
fn a_part_of_a_motion_on_a_robot_is_that_part_of_the_whole() {
    let robot = mocap::Importer::new()
        .import_robot("../../fixtures/robots/h1.urdf")
        .unwrap();
    let moved = |conversion: Conversion, first: FirstFrame| {
        let mut walk = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
        Conversion::new()
            .keep_units(true)
            .first_frame(first)
            .apply(&mut walk)
            .unwrap();
        // The solver works frame by frame, so that a frame does not depend on later frames.
        let options = RetargetOptions::new().lock_feet(false).passes(1).conversion(conversion);
        let moved = Retargeter::new(walk, robot.clone(), options).unwrap();
        moved.clips()[0].robot_motion.clone().unwrap()
    };
    let whole = moved(Conversion::new(), FirstFrame::Keep);
    let part = moved(Conversion::new().trim(None, Moment::Frame(30)), FirstFrame::Keep);
    assert_eq!((whole.frames(), part.frames()), (74, 30));
    let apart = |other: &RobotMotion| {
        let pairs = std::iter::zip(whole.dof_of(0), other.dof_of(0));
        pairs.map(|(a, b)| (a - b).abs().to_degrees()).fold(0.0, f64::max)
    };
    assert!(apart(&part) < 0.01, "{} degrees", apart(&part));
    // Without the rest pose in the first frame the ground is the same, because a rest pose has no ground contact.
    let without = moved(Conversion::new(), FirstFrame::Drop);
    assert!(apart(&without) < 0.01, "{} degrees", apart(&without));
}

#[test]
fn a_job_runs_in_memory_as_on_a_disk() {
    let motion = fs::read("../../fixtures/real/cmu_short.bvh").unwrap();
    let hero = fs::read("../../fixtures/skeletons/human_vrm1.gltf").unwrap();
    let robot = fs::read("../../fixtures/robots/h1.urdf").unwrap();
    let files = [
        MemoryFile {
            name: "../../fixtures/real/cmu_short.bvh",
            bytes: &motion,
        },
        MemoryFile {
            name: "../../fixtures/skeletons/human_vrm1.gltf",
            bytes: &hero,
        },
        MemoryFile {
            name: "../../fixtures/robots/h1.urdf",
            bytes: &robot,
        },
    ];
    for (onto, output) in [
        ("", "a.glb"),
        ("", "a.gltf"),
        (
            r#""target": {"character": {"file": "../../fixtures/skeletons/human_vrm1.gltf"}},"#,
            "a.gltf",
        ),
        (
            r#""target": {"robot": {"file": "../../fixtures/robots/h1.urdf"}},"#,
            "a.csv",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(output);
        let json = format!(
            r#"{{"source": {{"inputs": ["../../fixtures/real/cmu_short.bvh"], "frames": {{"trim": "0..0.5"}}}}, {onto} "write": {{"output": {path:?}}}}}"#
        );
        let job = Job::from_json(&json).unwrap();
        job.run().unwrap();
        let (written, report) = job.run_in_memory(&files).unwrap();
        let in_memory = written.files.iter().map(|file| file.bytes().into_owned());
        let on_disk = report
            .files
            .iter()
            .map(|file| fs::read(folder.path().join(&file.name)).unwrap());
        assert!(in_memory.eq(on_disk), "{json}");
    }
    let job = Job::from_json(r#"{"source": {"inputs": ["b.bvh"]}, "write": {"output": "b.glb"}}"#).unwrap();
    assert_eq!(job.run_in_memory(&files).unwrap_err().code().as_str(), "missing-file");
}

/// A clip whose name is a number, or the word for all clips, is selected by `name:`. The name in a job's report can be
/// used again.
#[test]
fn a_clip_with_the_name_of_a_number_is_reached() {
    let mut scene = mocap::import("../../fixtures/dialects/plain.bvh").unwrap();
    scene.animations = ["1", "all", "0"]
        .map(|name| mocap::scene::Animation {
            name: name.to_owned(),
            ..scene.animations[0].clone()
        })
        .to_vec();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("clips.glb");
    mocap::Exporter::new().export(&scene, &file).unwrap();
    for (text, names) in [
        ("0", &["1"][..]),
        ("name:0", &["0"]),
        ("name:1", &["1"]),
        ("name:all", &["all"]),
        ("all", &["1", "all", "0"]),
    ] {
        let reading: InputOptions = serde_json::from_value(serde_json::json!({"clip": text})).unwrap();
        let again: InputOptions = serde_json::from_str(&serde_json::to_string(&reading).unwrap()).unwrap();
        assert_eq!(again, reading, "{text}");
        let found = again.importer().import(&file).unwrap();
        assert!(
            found
                .animations
                .iter()
                .map(|clip| clip.name.as_str())
                .eq(names.iter().copied()),
            "{text}"
        );
    }
}
