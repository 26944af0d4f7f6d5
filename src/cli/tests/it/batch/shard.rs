//! Tests that a shard takes an even part of the files.

use mocap_cli::internals::{Input, Shard};

#[test]
fn every_file_is_in_one_part() {
    let parts: Vec<Shard> = (1..=5).map(|part| format!("{part}/5").parse().unwrap()).collect();
    let mut sizes = [0; 5];
    for number in 0..1000 {
        let input = Input {
            path: "anywhere".into(),
            relative: format!("takes/{number}.bvh"),
            bytes: 0,
            problem: None,
            clip: None,
        };
        let of: Vec<usize> = (0..5).filter(|&part| parts[part].has(&input)).collect();
        assert_eq!(of.len(), 1);
        sizes[of[0]] += 1;
    }
    // The standard deviation of a part is below 13.
    assert!(sizes.iter().all(|size| (150..250).contains(size)), "{sizes:?}");
}

#[test]
fn what_is_no_part_is_refused() {
    for text in ["0/2", "3/2", "1", "1/0", "a/b", "1/2/3", "-1/2"] {
        assert!(text.parse::<Shard>().is_err(), "{text}");
    }
}
