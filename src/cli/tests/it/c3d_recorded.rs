//! Data of C3D files besides markers: events, analog channels and force plates, compared with the numbers of another
//! reader.

#![allow(clippy::unwrap_used, reason = "a failed assumption in a test is the test's failure")]

use mocap::Importer;
use mocap::biomechanics::TimeSeries;

use crate::at_root;
use crate::program::Folder;

/// The values that ezc3d reads at sample 40 of the file from `tools/markers/plates.py`, with +Z up. There is a row for
/// each of three plates, of type 2, 3 and 4. The first column has the force in N, the second the centre of pressure in
/// mm, the third the free moment in N mm.
const PLATES: [[[f64; 3]; 3]; 3] = [
    [
        [-57.85903, -33.69977, 779.14866],
        [169.27582, 140.04022, 0.0],
        [0.0, 0.0, -1122.45364],
    ],
    [
        [-45.31587, -49.29313, 779.14866],
        [874.75088, 134.74319, 0.0],
        [0.0, 0.0, -1122.45377],
    ],
    [
        [-28.64519, -61.2984, 779.74288],
        [1580.28755, 124.41176, 0.0],
        [0.0, 0.0, -1136.52079],
    ],
];

/// The values of `tools/markers/plates.py` for plates of type 5, 6 and 7 at sample 40.
const PLANTED: [[[f64; 3]; 3]; 3] = [
    [
        [-57.85903, -33.69977, 779.14866],
        [173.59768, 144.18379, 0.0],
        [0.0, 0.0, -1122.45369],
    ],
    [
        [-45.31588, -49.29313, 779.14866],
        [876.49570, 136.64115, 0.0],
        [0.0, 0.0, -1122.45369],
    ],
    [
        [-28.72479, -60.48329, 779.14866],
        [1581.49330, 130.29180, 0.0],
        [0.0, 0.0, -1122.45369],
    ],
];

const SAMPLE: usize = 40;

fn assert_forces(forces: &TimeSeries, plates: &[[[f64; 3]; 3]; 3], tolerance: f64) {
    assert_eq!(
        (forces.frame_rate, forces.frames(), forces.columns.len()),
        (400.0, 80, 27)
    );
    for (plate, expected) in plates.iter().enumerate() {
        let kinds = [
            ("ground_force_*_v", 1.0),
            ("ground_force_*_p", 1e-3),
            ("ground_moment_*_m", 1e-3),
        ];
        for ((name, metres), [x, y, z]) in kinds.into_iter().zip(expected) {
            for (axis, value) in [("x", *x), ("y", *z), ("z", -y)] {
                let name = format!("{}{axis}", name.replace('*', &(plate + 1).to_string()));
                let found = forces.column(&name).unwrap().nth(SAMPLE).unwrap();
                assert!(
                    (found - value * metres).abs() < tolerance,
                    "{name}: {found} {}",
                    value * metres
                );
            }
        }
    }
}

#[test]
fn plates_with_matrices_give_the_forces_that_were_put_in() {
    let scene = mocap::import(at_root("fixtures/made/plates_5_6_7.c3d")).unwrap();
    // The file has raw values of 1e5 in single precision.
    assert_forces(&TimeSeries::ground_forces(&scene).unwrap(), &PLANTED, 1e-3);
    // A plate of type 5, 6 or 7 without its matrix has no forces.
    let mut bytes = std::fs::read(at_root("fixtures/made/plates_5_6_7.c3d")).unwrap();
    let name = bytes.windows(10).position(|window| window == b"CAL_MATRIX").unwrap();
    bytes[name] = b'X';
    let without = Importer::new().read(&bytes, "plates.c3d").unwrap();
    let error = TimeSeries::ground_forces(&without).unwrap_err().to_string();
    assert!(
        error.contains("plate 2 was skipped: no calibration matrix of 12 x 12 numbers"),
        "{error}"
    );
}

#[test]
fn plates_give_the_forces_that_another_reader_finds() {
    let scene = mocap::import(at_root("fixtures/made/plates.c3d")).unwrap();
    let forces = TimeSeries::ground_forces(&scene).unwrap();
    assert_forces(&forces, &PLATES, 1e-4);
    let analog = TimeSeries::analog(&scene).unwrap();
    let found = analog.column("EMG").unwrap().nth(SAMPLE).unwrap();
    assert!((found / -2.542_101_590_941_384e-5 - 1.0).abs() < 1e-5, "{found}");
    // Nobody stands on the plate yet.
    assert_eq!(forces.column("ground_force_1_px").unwrap().next(), Some(0.0));
    let recorded = scene.metadata.recorded.unwrap();
    // The file begins at frame 11, so 0.14 s after frame 1 is 0.04 s after the first frame.
    let events: Vec<(&str, &str, f64)> = recorded
        .events
        .iter()
        .map(|event| (event.label.as_str(), event.context.as_str(), event.time))
        .collect();
    assert_eq!(
        [events[0].0, events[0].1, events[2].1],
        ["Foot Strike", "Left", "Right"]
    );
    assert!(
        (events[0].2 - 0.04).abs() < 1e-6 && (events[2].2 - 0.15).abs() < 1e-6,
        "{events:?}"
    );
    // A rate stated by the caller scales all times equally.
    let faster = Importer::new()
        .retime(200.0)
        .import(at_root("fixtures/made/plates.c3d"))
        .unwrap();
    let recorded = faster.metadata.recorded.unwrap();
    assert_eq!(recorded.analog_rate, 800.0);
    assert!((recorded.events[0].time - 0.02).abs() < 1e-6);
}

/// Samples of two plates, minus the mean of frames 1 to 10, the range in `FORCE_PLATFORM:ZERO`. ezc3d's force at sample
/// 1244 is (-39.5116, 22.4299, 838.5556). The mean of its forces at the first 40 samples is (-26.1762, 0.0525,
/// 21.2040).
#[test]
fn a_baseline_is_taken_out_of_real_plates() {
    let forces =
        TimeSeries::ground_forces(&mocap::import(at_root("fixtures/real/py_c3d_motion.c3d")).unwrap()).unwrap();
    for (axis, value) in [("x", -13.3353), ("y", 817.3516), ("z", -22.3773)] {
        let found = forces
            .column(&format!("ground_force_1_v{axis}"))
            .unwrap()
            .nth(1244)
            .unwrap();
        assert!((found - value).abs() < 1e-3, "{axis}: {found}");
    }
}

#[test]
fn broken_plates_and_channels_are_left_out_with_a_word() {
    let bytes = std::fs::read(at_root("fixtures/made/plates.c3d")).unwrap();
    let read = |bytes: &[u8]| Importer::new().read(bytes, "plates.c3d").unwrap();
    let place = |name: &str| {
        bytes
            .windows(name.len())
            .position(|window| window == name.as_bytes())
            .unwrap()
    };
    // The name, the offset of the next parameter, the type and the sizes precede the values.
    let mut unknown = bytes.clone();
    unknown[place("TYPE") + 4 + 2 + 3] = 99;
    let forces = TimeSeries::ground_forces(&read(&unknown)).unwrap();
    assert!(
        forces
            .notes
            .iter()
            .any(|note| note.contains("plate 1") && note.contains("type 99")),
        "{:?}",
        forces.notes
    );
    assert_eq!(forces.columns.len(), 18);
    let mut far = bytes.clone();
    far[place("CHANNEL") + 7 + 2 + 4] = 200;
    let scene = read(&far);
    assert!(
        scene
            .warnings
            .iter()
            .any(|warning| warning.message.contains("1 of 3 force plates were skipped"))
    );
    // A file cut within the data has only the complete frames, with their samples.
    let scene = read(&bytes[..bytes.len() - 4000]);
    let recorded = scene.metadata.recorded.unwrap();
    let frames = scene.animations[0].frame_count();
    assert!(
        frames < 20
            && recorded
                .channels
                .iter()
                .all(|channel| channel.values.len() == 4 * frames)
    );
    let none = TimeSeries::ground_forces(&mocap::import(at_root("fixtures/real/optotrak.c3d")).unwrap()).unwrap_err();
    assert!(none.to_string().contains("no force plates"), "{none}");
}

#[test]
fn forces_are_written_as_opensim_and_as_tables_and_replace_only_their_like() {
    let folder = Folder::of_real(&[]);
    folder.write("p.c3d", &std::fs::read(at_root("fixtures/made/plates.c3d")).unwrap());
    for name in ["f.mot", "f.sto", "f.csv", "f.mot", "f.sto"] {
        let output = folder.run(&format!("forces p.c3d -o {name} --quiet"));
        assert!(
            output.status.success(),
            "{name}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let text = String::from_utf8(folder.read("f.mot")).unwrap();
    assert!(text.starts_with(
        "mocap forces\nversion=1\nnRows=80\nnColumns=28\ninDegrees=no\nendheader\ntime\tground_force_1_vx\t"
    ));
    folder.refuses("forces p.c3d -o p.c3d", 2, "p.c3d");
    folder.refuses("forces p.c3d -o f.bvh", 2, ".parquet");
    folder.write("their.mot", b"Coordinates\nversion=1\n");
    folder.refuses("analog p.c3d -o their.mot", 1, "their.mot");
    folder.write("w.bvh", &std::fs::read(at_root("fixtures/real/cmu_short.bvh")).unwrap());
    folder.refuses("analog w.bvh -o a.csv", 1, "no analog channels");
}

/// The command reports gaps in one line, for any number of markers with gaps.
#[test]
fn gaps_of_markers_are_one_line_of_every_command() {
    let folder = Folder::with(&[]);
    // In the first frame each marker has a residual of -1.
    let mut bytes = std::fs::read(at_root("fixtures/made/plates.c3d")).unwrap();
    let scene = mocap::Importer::new().read(&bytes, "plates.c3d").unwrap();
    let markers = scene.nodes.len() - 1;
    assert!(markers > 1);
    let data = 512 * (usize::from(u16::from_le_bytes([bytes[16], bytes[17]])) - 1);
    for marker in 0..markers {
        bytes[data + 16 * marker + 12..][..4].copy_from_slice(&(-1_f32).to_le_bytes());
    }
    folder.write("lost.c3d", &bytes);
    for command in ["forces lost.c3d -o forces.mot", "convert lost.c3d -o lost.trc"] {
        let said = folder.succeeds(command);
        let warned = said.lines().filter(|line| line.contains("warning[gap]"));
        assert_eq!(warned.count(), 1, "{said}");
    }
}

#[test]
fn a_strict_output_lacks_nothing_of_its_input() {
    let folder = Folder::with(&[]);
    folder.write(
        "plates.c3d",
        &std::fs::read(at_root("fixtures/made/plates.c3d")).unwrap(),
    );
    let said = folder.succeeds("convert plates.c3d -o loose.trc");
    assert!(
        said.contains("warning[not-carried-over]: 3 force plates are not in the output"),
        "{said}"
    );
    let said = folder.ends_with(1, "convert plates.c3d -o strict.trc --strict");
    assert!(
        said.contains("error[not-carried-over]") && said.contains("3 force plates"),
        "{said}"
    );
    assert!(!folder.path("strict.trc").exists());
}
