//! Tests of the weights of solvers in a job.

use mocap::job::{Job, JobWeights, MotionJob};

const WALK: &str = "../../fixtures/real/cmu_short.bvh";

fn job(rest: &str) -> MotionJob {
    let text = format!(r#"{{"source": {{"inputs": ["{WALK}"]}}, {rest}}}"#);
    match Job::from_json(&text).unwrap() {
        Job::Motion(job) => job,
        other => panic!("{other:?}"),
    }
}

/// The bytes of the output. The job writes the output into a folder of its own.
fn output(rest: &str, extension: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(rest);
    job.write.output = folder.path().join("out").with_extension(extension);
    job.run().unwrap();
    std::fs::read(&job.write.output).unwrap()
}

#[test]
fn stated_defaults_change_nothing_and_other_weights_do() {
    let robot = r#""target": {"robot": {"file": "../../fixtures/robots/h1.urdf", "passes": 1}}"#;
    for (of, kind, default, other) in [
        (robot, "robot", r#"{"hand": 0.2}"#, r#"{"hips-place": 90}"#),
        (robot, "foot-lock", r#"{"aim": 0.97}"#, r#"{"on-the-ground": 0.2}"#),
        (
            r#""steps": ["foot-lock"]"#,
            "foot-lock",
            r#"{"around": 0.25}"#,
            r#"{"acceleration-ratio": 0.2}"#,
        ),
        (
            r#""steps": ["clean"]"#,
            "clean",
            r#"{"smoothing": 0.5}"#,
            r#"{"least-skate": 0.001}"#,
        ),
    ] {
        let extension = if of == robot { "csv" } else { "glb" };
        let usual = output(of, extension);
        let with = |weights: &str| output(&format!(r#"{of}, "weights": {{"{kind}": {weights}}}"#), extension);
        assert!(with(default) == usual, "{kind}: {default}");
        assert!(with(other) != usual, "{kind}: {other}");
    }
}

/// A step is recorded with its weights, so that `verify` repeats it.
#[test]
fn an_output_is_verified_with_the_weights_of_its_steps() {
    let folder = tempfile::tempdir().unwrap();
    let mut job =
        job(r#""steps": ["foot-lock"], "weights": {"foot-lock": {"acceleration-ratio": 0.2}}, "verify": true"#);
    job.write.output = folder.path().join("out.glb");
    let report = job.run().unwrap();
    assert!(
        report
            .verification
            .is_some_and(|verification| verification.is_within(1e-3))
    );
}

/// The step's own weights take precedence over the job's weights.
#[test]
fn a_step_has_its_weights_as_text_and_as_json() {
    let text = "foot-lock:weights=acceleration-ratio:0.2+aim:0.9";
    let json = r#""steps": [{"step": "foot-lock", "weights": {"acceleration-ratio": 0.2, "aim": 0.9}}]"#;
    let of_text = output(&format!(r#""steps": ["{text}"]"#), "glb");
    assert!(of_text == output(json, "glb"));
    let both = format!(r#"{json}, "weights": {{"foot-lock": {{"acceleration-ratio": 1.0}}}}"#);
    assert!(of_text == output(&both, "glb"));
    let step: mocap::edit::EditStep = text.parse().unwrap();
    assert_eq!(step.to_string().parse::<mocap::edit::EditStep>().unwrap(), step);
}

#[test]
fn weights_out_of_range_and_unknown_ones_are_refused() {
    let mut wrong = job(r#""steps": ["foot-lock"], "weights": {"robot": {"hand": 1000}}"#);
    wrong.write.output = "never.glb".into();
    let error = wrong.run().unwrap_err();
    assert_eq!(
        error.diagnostic().message,
        "the weight hand of robot must be from 0.0002 to 200, got 1000"
    );
    for value in ["-1", "0", "1e300"] {
        let text = format!(r#""steps": [{{"step": "foot-lock", "weights": {{"ease": {value}}}}}]"#);
        let mut wrong = job(&text);
        wrong.write.output = "never.glb".into();
        let error = wrong.run().unwrap_err();
        assert!(
            error
                .diagnostic()
                .message
                .starts_with("the weight ease of foot-lock must be"),
            "{error}"
        );
    }
    assert!(serde_json::from_str::<JobWeights>(r#"{"robot": {"hnad": 1}}"#).is_err());
    assert_eq!(serde_json::to_string(&JobWeights::default()).unwrap(), "{}");
}
