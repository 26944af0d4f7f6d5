//! Tests of marker gaps in arrays: NaN stands for a hidden marker, in written and read arrays.

use mocap::arrays::{ArrayOptions, Arrays};
use mocap::{Format, Importer, Scene};

/// B is visible in frames 1 and 3 at one place, and C in no frame.
const TAKE: &str = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n10\t5\t3\tm\n\
    Frame#\tTime\tA\t\t\tB\t\t\tC\t\t\n\
    1\t0.0\t1\t2\t3\t\t\t\t0\t0\t0\n2\t0.1\t1\t2\t4\t7\t8\t9\t0\t0\t0\n3\t0.2\t1\t2\t5\t\t\t\t0\t0\t0\n\
    4\t0.3\t1\t2\t6\t7\t8\t9\t0\t0\t0\n5\t0.4\t1\t2\t7\t\t\t\t0\t0\t0\n";

fn seen(scene: &Scene, marker: usize) -> Vec<bool> {
    let keys = &scene.animations[0].channels[marker].position_keys;
    (0..5).map(|frame| keys.is_seen(f64::from(frame))).collect()
}

#[test]
fn gaps_are_not_a_number_there_and_back() {
    let scene = Importer::new().read(TAKE.as_bytes(), "a.trc").unwrap();
    let expected = [[true; 5], [false, true, false, true, false], [false; 5]];
    let arrays = Arrays::of(&scene, &ArrayOptions::default()).unwrap();
    for (row, position) in arrays.positions.chunks_exact(3).enumerate() {
        let (frame, marker) = (row / 3, row % 3);
        let is_seen = position.iter().all(|number| number.is_finite());
        assert_eq!(is_seen, expected[marker][frame], "{marker} {frame}");
        assert!(is_seen || position.iter().all(|number| number.is_nan()));
    }
    for (name, bytes) in [("a.csv", arrays.to_csv().into_bytes()), ("a.npz", arrays.to_npz())] {
        let back = Importer::new().read(&bytes, name).unwrap();
        assert_eq!(back.validate(), []);
        assert!(matches!(back.metadata.format, Some(Format::Csv | Format::Npz)));
        for (marker, expected) in expected.iter().enumerate() {
            assert_eq!(seen(&back, marker), expected, "{name} {marker}");
        }
    }
}
