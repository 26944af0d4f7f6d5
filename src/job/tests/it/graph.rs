//! Tests of jobs for motion graphs and walks.

use mocap::job::Job;

use crate::cut;

#[test]
fn jobs_say_what_a_graph_and_a_walk_do_not_heed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cmu_12_01_walk.bvh");
    std::fs::write(&file, cut::first_frames("real/cmu_12_01_walk.bvh", 240)).unwrap();
    let walk = |walk: &str| format!(r#""graph": {{"rate": 15}}, "walk": {walk}, "write": {{"output": "a.bvh"}}"#);
    let source = format!(r#""source": {{"inputs": [{file:?}]}}"#);
    for (rest, what) in [
        (
            r#""graph": {}, "write": {"output": "a.glb"}"#.to_owned(),
            "must end in .json",
        ),
        (r#""graph": {}, "matrix": "a.bvh""#.to_owned(), ".png or .npy"),
        (r#""graph": {"rate": -1}"#.to_owned(), "frame rate"),
        (r#""graph": {"window": 1e9}"#.to_owned(), "a window must have"),
        (
            r#""graph": {"threshold": 1e-9}"#.to_owned(),
            "no endless path through the clips",
        ),
        (r#""graph": {"on": "none.bvh"}"#.to_owned(), "none.bvh"),
        (walk("{}"), "one of seconds"),
        (walk(r#"{"seconds": 5, "path": [[0, 0], [1, 0]]}"#), "one of seconds"),
        (walk(r#"{"seconds": 1e30}"#), "at most 86400"),
        (walk(r#"{"path": [[0, 0], [1e30, 0]]}"#), "a path is at most"),
        (walk(r#"{"through": ["cmu_12_01_walk", "turn"]}"#), "no clip turn"),
        (walk(r#"{"seconds": 5}"#).replace("a.bvh", "out/"), "a folder"),
        (
            walk(r#"{"seconds": 5}"#).replace(r#""graph": {"rate": 15},"#, ""),
            "no motion graph",
        ),
    ] {
        let job = format!("{{{source}, {rest}}}");
        let error = Job::from_json(&job).unwrap().make(&[]).unwrap_err();
        assert!(error.to_string().contains(what), "{job}: {error}");
    }
    for (inputs, rest, what) in [
        ("", r#""graph": {}"#, "no input"),
        (r#""../../fixtures/real""#, r#""graph": {}"#, "is a folder"),
        (
            r#""a.json", "b.json""#,
            r#""walk": {"seconds": 5}, "write": {"output": "a.bvh"}"#,
            "a walk uses one graph",
        ),
    ] {
        let job = format!(r#"{{"source": {{"inputs": [{inputs}]}}, {rest}}}"#);
        let error = Job::from_json(&job).unwrap().make(&[]).unwrap_err();
        assert!(error.to_string().contains(what), "{job}: {error}");
    }
}
