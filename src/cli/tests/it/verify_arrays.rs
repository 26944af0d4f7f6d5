//! Tests that `mocap verify` accepts and rejects arrays like the library.

#[test]
fn the_program_says_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.npz");
    let run = |arguments: &[&str]| {
        let output = crate::program::run(arguments);
        assert!(
            output.status.success(),
            "{arguments:?}: {}",
            crate::program::words(&output)
        );
        String::from_utf8(output.stdout).unwrap()
    };
    let (source, output) = ("fixtures/real/cmu_short.bvh", output.to_str().unwrap());
    run(&[
        "fk",
        source,
        "-o",
        output,
        "--unit",
        "inch",
        "--out-unit",
        "m",
        "--fps",
        "30",
    ]);
    let said = run(&["verify", source, output]);
    assert!(
        said.starts_with("19 frames, 31 joints, 7 end sites: error 0.0"),
        "{said}"
    );
}
