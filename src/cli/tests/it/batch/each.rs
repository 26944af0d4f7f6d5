//! Work on many files with a panic on one file.

use mocap_cli::internals::{Input, InputArgs, find, for_each};

#[test]
fn a_panic_on_one_file_does_not_stop_the_others() {
    let paths = ["a.bvh", "b.bvh", "c.bvh", "d.bvh"].map(std::path::PathBuf::from);
    let inputs = find(&paths, &InputArgs { allow_empty: false }).map_err(drop).unwrap();
    for threads in [1, 2] {
        let work = |input: &Input| match input.relative.as_str() {
            "b.bvh" => panic!("a defect"),
            name => format!("{name} is read"),
        };
        let mut results = vec![String::new(); 4];
        let sink = |index: usize, result: String| -> Result<(), ()> {
            results[index] = result;
            Ok(())
        };
        for_each(
            &inputs,
            threads,
            work,
            |input| format!("{} failed", input.relative),
            sink,
        )
        .unwrap();
        assert_eq!(
            results,
            ["a.bvh is read", "b.bvh failed", "c.bvh is read", "d.bvh is read"]
        );
    }
}
