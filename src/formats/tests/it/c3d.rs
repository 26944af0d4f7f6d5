//! C3D: real files, compared with the numbers of another reader, and files in every encoding, built here.

#![allow(clippy::unwrap_used, reason = "a failed assumption in a test is the test's failure")]

mod bytes;
mod recorded;

use mocap::glam::Vec3;
use mocap::scene::{NodeKind, Scene};
use mocap::{Code, Importer, Limits, SkeletonMesh};

fn import(name: &str) -> Scene {
    mocap::import(format!("../../fixtures/real/{name}.c3d")).unwrap()
}

fn channel(scene: &Scene, marker: usize) -> &mocap::scene::Channel {
    &scene.animations[0].channels[marker]
}

/// The data of a file, as the Python package c3d 0.5 reads it. Positions are as in the file, with z up.
struct Real {
    name: &'static str,
    rate: f64,
    frames: usize,
    /// The labels of the first two markers.
    labels: [&'static str; 2],
    markers: usize,
    /// Some positions, each as frame, marker and position.
    positions: &'static [(usize, usize, [f32; 3])],
    /// The number of markers that are hidden in some frame, and the total number of frames in which they are hidden.
    gaps: (usize, usize),
}

const REAL: [Real; 3] = [
    Real {
        name: "py_c3d_motion",
        rate: 50.0,
        frames: 450,
        labels: ["RFT1", "RFT2"],
        markers: 26,
        positions: &[
            (0, 0, [248.583_34, 226.833_34, 37.416_668]),
            (0, 25, [-18.0, 183.166_67, 947.416_7]),
            (225, 1, [191.583_34, 812.333_4, 88.416_67]),
            (449, 0, [324.583_34, 2248.0, 33.75]),
        ],
        gaps: (10, 226),
    },
    Real {
        name: "optotrak",
        rate: 30.0,
        frames: 29,
        labels: ["Marker_1", "Marker_2"],
        markers: 54,
        positions: &[
            (0, 0, [326.313_75, 328.631_13, -366.170_62]),
            (14, 53, [1_223.693_6, 343.414_28, -285.675_75]),
            (28, 1, [317.574_65, 319.392_46, -498.704_35]),
        ],
        gaps: (3, 59),
    },
    Real {
        name: "hand_take",
        rate: 60.0,
        frames: 412,
        labels: ["Reference", "Hips"],
        markers: 63,
        positions: &[
            (0, 1, [0.0, -44.194_588, 910.988_16]),
            (411, 62, [98.966_896, 16.228_833, 24.343_248]),
        ],
        // `Reference` is at 0, 0, 0 with the residual 0 in every frame, like labels that are never seen.
        gaps: (1, 412),
    },
];

#[test]
fn real_files_have_the_numbers_that_another_reader_finds() {
    for real in REAL {
        let scene = import(real.name);
        let animation = &scene.animations[0];
        assert_eq!(animation.ticks_per_second, real.rate, "{}", real.name);
        assert_eq!(animation.frame_count(), real.frames, "{}", real.name);
        assert_eq!(scene.nodes.len(), real.markers + 1, "{}", real.name);
        assert_eq!(
            [0, 1].map(|i| scene.nodes[i + 1].name.as_str()),
            real.labels,
            "{}",
            real.name
        );
        assert_eq!(scene.metadata.metres_per_unit, Some(0.001), "{}", real.name);
        for &(frame, marker, [x, y, z]) in real.positions {
            let position = channel(&scene, marker).position_keys.sample(frame as f64).unwrap();
            let expected = Vec3::new(x, z, -y);
            assert!(
                position.abs_diff_eq(expected, 1e-3),
                "{}: {position} {expected}",
                real.name
            );
        }
        let gaps: Vec<usize> = (0..real.markers)
            .map(|marker| match channel(&scene, marker).position_keys.len() {
                // A still marker has one key.
                1 => 0,
                keys => real.frames - keys,
            })
            .filter(|&missing| missing > 0)
            .collect();
        assert_eq!((gaps.len(), gaps.iter().sum()), real.gaps, "{}", real.name);
        let warned = scene
            .warnings
            .iter()
            .filter(|warning| warning.code == Code::Gap)
            .count();
        assert_eq!(warned, real.gaps.0, "{}", real.name);
    }
}

#[test]
fn a_file_that_is_cut_off_is_read_as_far_as_it_goes() {
    let scene = import("optotrak");
    let counts = scene
        .warnings
        .iter()
        .find(|warning| warning.code == Code::MissingFrames)
        .unwrap();
    assert_eq!(
        counts.to_string(),
        "1120 of 1149 frames are missing: the file is cut off, or states a wrong number; expected 1149 frames of 864 bytes \
         from byte 3584 on; found 29 in a file of 28640 bytes; \
         help: the available frames were read; export or download the file again"
    );
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Processor {
    Intel,
    Dec,
    Sgi,
}

/// A small file with two markers and three frames. The second marker is hidden in the second frame.
struct Sample {
    processor: Processor,
    is_real: bool,
    y_screen: &'static [u8],
    /// The label of a point that has angles and is not a marker.
    angles: &'static [u8],
}

const POSITIONS: [[[f32; 3]; 2]; 3] = [
    [[1.5, -2.5, 3.0], [10.0, 20.0, 30.0]],
    [[2.5, -2.5, 3.5], [0.0, 0.0, 0.0]],
    [[3.5, -2.5, 4.0], [12.0, 22.0, -32.0]],
];

impl Sample {
    fn word(&self, value: i16) -> [u8; 2] {
        match self.processor {
            Processor::Sgi => value.to_be_bytes(),
            _ => value.to_le_bytes(),
        }
    }

    fn real(&self, value: f32) -> [u8; 4] {
        match self.processor {
            Processor::Intel => value.to_le_bytes(),
            Processor::Sgi => value.to_be_bytes(),
            Processor::Dec => {
                let [a, b, c, d] = (value * 4.0).to_le_bytes();
                [c, d, a, b]
            }
        }
    }

    fn group(&self, id: i8, name: &str) -> Vec<u8> {
        let mut bytes = vec![name.len() as u8, (-id).cast_unsigned()];
        bytes.extend(name.as_bytes());
        bytes.extend(self.word(3));
        bytes.push(0);
        bytes
    }

    fn parameter(&self, id: i8, name: &str, kind: i8, dimensions: &[u8], data: &[u8]) -> Vec<u8> {
        let mut bytes = vec![name.len() as u8, id.cast_unsigned()];
        bytes.extend(name.as_bytes());
        bytes.extend(self.word(5 + dimensions.len() as i16 + data.len() as i16));
        bytes.extend([kind.cast_unsigned(), dimensions.len() as u8]);
        bytes.extend(dimensions);
        bytes.extend(data);
        bytes.push(0);
        bytes
    }

    fn bytes(&self) -> Vec<u8> {
        let scale = if self.is_real { -0.5 } else { 0.5 };
        let mut header = vec![2, 0x50];
        for word in [2, 1, 1, 3, 10] {
            header.extend(self.word(word));
        }
        header.extend(self.real(scale));
        header.extend(self.word(3));
        header.extend(self.word(1));
        header.extend(self.real(100.0));
        header.resize(512, 0);

        let code = match self.processor {
            Processor::Intel => 84,
            Processor::Dec => 85,
            Processor::Sgi => 86,
        };
        let mut parameters = vec![1, 0x50, 1, code];
        parameters.extend(self.group(1, "POINT"));
        parameters.extend(self.parameter(1, "USED", 2, &[], &self.word(2)));
        parameters.extend(self.parameter(1, "SCALE", 4, &[], &self.real(scale)));
        parameters.extend(self.parameter(1, "RATE", 4, &[], &self.real(100.0)));
        parameters.extend(self.parameter(1, "LABELS", -1, &[4, 2], b"HEADLeg "));
        parameters.extend(self.parameter(1, "UNITS", -1, &[2], b"cm"));
        parameters.extend(self.parameter(1, "Y_SCREEN", -1, &[2], self.y_screen));
        if !self.angles.is_empty() {
            parameters.extend(self.parameter(1, "ANGLES", -1, &[self.angles.len() as u8, 1], self.angles));
            parameters.extend(self.parameter(1, "ANGLE_UNITS", -1, &[3], b"deg"));
        }
        parameters.resize(512, 0);

        let mut data = Vec::new();
        for (frame, points) in POSITIONS.iter().enumerate() {
            for (marker, position) in points.iter().enumerate() {
                let residual = if (frame, marker) == (1, 1) { -1 } else { 0 };
                for &coordinate in position {
                    match self.is_real {
                        true => data.extend(self.real(coordinate)),
                        false => data.extend(self.word((coordinate / 0.5) as i16)),
                    }
                }
                match self.is_real {
                    true => data.extend(self.real(f32::from(residual))),
                    false => data.extend(self.word(residual)),
                }
            }
            // An analog sample.
            match self.is_real {
                true => data.extend(self.real(7.0)),
                false => data.extend(self.word(7)),
            }
        }
        [header, parameters, data].concat()
    }
}

const SAMPLE: Sample = Sample {
    processor: Processor::Intel,
    is_real: true,
    y_screen: b"+Z",
    angles: b"",
};

fn read(bytes: &[u8]) -> mocap::Result<Scene> {
    Importer::new().skeleton_mesh(SkeletonMesh::None).read(bytes, "a.c3d")
}

#[test]
fn every_encoding_says_the_same() {
    for processor in [Processor::Intel, Processor::Dec, Processor::Sgi] {
        for is_real in [false, true] {
            let sample = Sample {
                processor,
                is_real,
                ..SAMPLE
            };
            let scene = read(&sample.bytes()).unwrap();
            let names: Vec<&str> = scene.nodes.iter().map(|node| node.name.as_str()).collect();
            assert_eq!(names, ["Markers", "HEAD", "Leg"], "{processor:?} {is_real}");
            assert_eq!(scene.nodes[0].kind, NodeKind::Group);
            assert_eq!(scene.metadata.metres_per_unit, Some(0.01));
            assert_eq!(scene.animations[0].ticks_per_second, 100.0);
            assert_eq!(scene.animations[0].duration, 2.0);
            for (marker, frames) in [(0, vec![0, 1, 2]), (1, vec![0, 2])] {
                let keys = &channel(&scene, marker).position_keys;
                let expected: Vec<(f64, Vec3)> = frames
                    .into_iter()
                    .map(|frame: usize| (frame as f64, POSITIONS[frame][marker]))
                    .map(|(tick, [x, y, z])| (tick, Vec3::new(x, z, -y)))
                    .collect();
                let found: Vec<(f64, Vec3)> = (0..keys.len())
                    .map(|index| (keys.tick(index), keys.values[index]))
                    .collect();
                assert_eq!(found, expected, "{processor:?} {is_real}");
            }
            let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
            assert_eq!(warnings, ["the marker was not seen in 1 of 3 frames; joint \"Leg\""]);
            let topics: Vec<&str> = scene
                .metadata
                .assumptions
                .iter()
                .map(|one| one.topic.as_str())
                .collect();
            assert_eq!(topics, ["up-axis", "analog"]);
        }
    }
}

#[test]
fn the_axis_that_points_up_is_the_one_that_the_file_names() {
    let up = Sample {
        y_screen: b"+Y",
        ..SAMPLE
    };
    let scene = read(&up.bytes()).unwrap();
    assert_eq!(channel(&scene, 0).position_keys.values[0], Vec3::from(POSITIONS[0][0]));
}

/// The sample with some bytes replaced.
fn with(changes: &[(usize, &[u8])]) -> Vec<u8> {
    let mut bytes = SAMPLE.bytes();
    for (offset, changed) in changes {
        bytes[*offset..offset + changed.len()].copy_from_slice(changed);
    }
    bytes
}

#[test]
fn broken_files_are_refused_with_their_message() {
    let read = |bytes: &[u8]| Importer::new().format(mocap::Format::C3d).read(bytes, "a.c3d");
    let labels = SAMPLE.bytes().windows(6).position(|six| six == b"LABELS").unwrap() + 10;
    let cut_off = "help: the file is cut off: export or download it again";
    let help = "help: check that the extension matches the contents of the file, and that the file is not compressed";
    let expected = "expected a block number, the byte 0x50, and processor 84, 85 or 86 in that block";
    for (bytes, message) in [
        (Vec::new(), "the file is empty".to_owned()),
        (
            b"P".to_vec(),
            format!("the file is not C3D; {expected}; found a file of one byte; {help}"),
        ),
        (
            with(&[(1, b"K")]),
            format!("the file is not C3D; {expected}; found the bytes 0x02 0x4b; {help}"),
        ),
        (
            with(&[(515, &[90])]),
            format!("the file is not C3D; {expected}; found the processor 90, at byte 515; {help}"),
        ),
        (
            SAMPLE.bytes()[..512].to_vec(),
            format!("the file ends before its parameters; expected parameters at byte 512; found 512 bytes; {cut_off}"),
        ),
        (
            // The number of blocks is 0, and the file is truncated inside the name of a parameter.
            [&with(&[(514, &[0])])[..560], &[]].concat(),
            format!(
                "the file is cut off inside the list of parameters; expected 4 more bytes at byte 557; found 3; {cut_off}"
            ),
        ),
        (
            // 255 labels of 255 letters do not fit into a section of 512 bytes.
            with(&[(labels, &[255, 255])]),
            format!(
                "the parameter \"LABELS\" reaches beyond the end of its section; expected 65025 more bytes at byte {}; \
                 found {}; help: export the file again",
                labels + 2,
                1024 - labels - 2
            ),
        ),
        (
            // The first block of the data, from the header only and without its parameter.
            with(&[(16, &[0, 0])]),
            "the file does not state where its data begins; expected a block number, 1 or more, in POINT:DATA_START; \
             found 0; help: export the file again"
                .to_owned(),
        ),
    ] {
        let error = read(&bytes).unwrap_err();
        assert_eq!(error.diagnostic().to_string(), message);
    }
}

/// The counts of the header are a claim. Padding in the last block is not data, but further records are.
#[test]
fn frames_behind_those_that_are_stated_are_read() {
    let one = with(&[(8, &[1, 0])]);
    let read_frames = |bytes: &[u8]| {
        let scene = read(bytes).unwrap();
        let warned = scene
            .warnings
            .iter()
            .filter(|warning| warning.code == Code::FrameCount)
            .count();
        (scene.animations[0].frame_count(), warned)
    };
    assert_eq!(read_frames(&SAMPLE.bytes()), (3, 0));
    assert_eq!(read_frames(&one), (3, 1));
    let mut zeros = one.clone();
    zeros.resize(1024 + 4 * 512, 0);
    assert_eq!(read_frames(&zeros), (3, 1));
    // Old writers pad the last block with its previous contents.
    let mut filled = one.clone();
    filled.resize(1024 + 512, 7);
    assert_eq!(read_frames(&filled), (1, 0));
    let mut stated = SAMPLE.bytes();
    stated.resize(1024 + 512, 7);
    assert_eq!(read_frames(&stated), (3, 0));
    let limits = Limits::new().max_values(17);
    let refused = Importer::new().limits(limits).read(&one, "a.c3d").unwrap_err();
    assert_eq!(refused.code(), Code::LimitExceeded);
}

#[test]
fn angles_of_a_model_are_no_markers() {
    let sample = Sample {
        angles: b"Leg",
        ..SAMPLE
    };
    let scene = read(&sample.bytes()).unwrap();
    let names: Vec<&str> = scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["Markers", "HEAD"]);
    let outputs = &scene.metadata.recorded.as_ref().unwrap().outputs;
    assert_eq!(
        (outputs.len(), outputs[0].name.as_str(), outputs[0].unit.as_str()),
        (1, "Leg", "deg")
    );
    // These values are not rotated, unlike positions.
    let values = &outputs[0].values;
    assert_eq!(
        (&values[..3], &values[6..]),
        (&POSITIONS[0][1][..], &POSITIONS[2][1][..])
    );
    assert!(values[3..6].iter().all(|value| value.is_nan()));
    // A label without a point changes nothing.
    let sample = Sample {
        angles: b"Arm",
        ..SAMPLE
    };
    let (scene, plain) = (read(&sample.bytes()).unwrap(), read(&SAMPLE.bytes()).unwrap());
    assert_eq!(
        (scene.nodes, scene.metadata.recorded),
        (plain.nodes, plain.metadata.recorded)
    );
}

/// For a label that is never seen, some systems write zeros with the residual 0. Measured points have a residual above
/// 0.
#[test]
fn a_label_at_the_origin_in_every_frame_is_never_seen() {
    let at = |frame: usize, marker: usize| 1024 + frame * 36 + marker * 16;
    let planted = |marker: usize, residual: f32| {
        let mut bytes = SAMPLE.bytes();
        for frame in 0..3 {
            bytes[at(frame, marker)..][..12].fill(0);
            bytes[at(frame, marker) + 12..][..4].copy_from_slice(&residual.to_le_bytes());
        }
        read(&bytes).unwrap()
    };
    let keys = |scene: &Scene| [0, 1].map(|marker| channel(scene, marker).position_keys.len());
    let never = planted(0, 0.0);
    assert_eq!(keys(&never), [0, 2]);
    let messages: Vec<String> = never.warnings.iter().map(ToString::to_string).collect();
    let expected = "the marker was not seen in 3 of 3 frames; in 3 of these frames, the file has the position 0, 0, 0; joint \"HEAD\"";
    assert_eq!(messages[0], expected);
    assert_eq!(keys(&planted(0, 0.4)), [1, 2]);
    assert_eq!(keys(&planted(1, 0.0)), [3, 0]);
}

#[test]
fn a_rate_of_zero_asks_for_one() {
    let rate = SAMPLE.bytes().windows(4).rposition(|four| four == b"RATE").unwrap() + 8;
    let bytes = with(&[(20, &[0; 4]), (rate, &[0; 4])]);
    assert_eq!(read(&bytes).unwrap_err().code(), Code::FrameTime);
    let scene = Importer::new().retime(50.0).read(&bytes, "a.c3d").unwrap();
    assert_eq!(scene.animations[0].ticks_per_second, 50.0);
}

#[test]
fn claims_beyond_the_limits_are_refused() {
    let limited = |limits: Limits| {
        Importer::new()
            .limits(limits)
            .read(&SAMPLE.bytes(), "a.c3d")
            .map_err(|error| error.code())
    };
    let nodes = |max_nodes| limited(Limits::new().max_nodes(max_nodes));
    let values = |max_values| limited(Limits::new().max_values(max_values));
    assert!(nodes(3).is_ok() && values(18).is_ok());
    assert_eq!(nodes(2), Err(Code::LimitExceeded));
    assert_eq!(values(17), Err(Code::LimitExceeded));
}

#[test]
fn a_claim_of_many_points_takes_no_memory() {
    // 32767 points in a file of a few hundred bytes, so not one record is complete.
    let used = SAMPLE.bytes().windows(4).position(|four| four == b"USED").unwrap() + 8;
    let scene = read(&with(&[(used, &[0xFF, 0x7F])])).unwrap();
    assert!(scene.animations.is_empty());
    // Words are unsigned, so this count is 65534, not -2.
    let scene = read(&with(&[(used, &[0xFE, 0xFF])])).unwrap();
    let message = scene.warnings[0].to_string();
    assert!(
        message.contains("of 1048548 bytes from byte 1024 on; found 0 in a file of"),
        "{message}"
    );
}

#[test]
fn every_damage_is_an_error_or_a_valid_scene() {
    // In builds with debug assertions, as in these tests, the importer validates its scenes.
    let importer = Importer::new()
        .format(mocap::Format::C3d)
        .skeleton_mesh(SkeletonMesh::None);
    let mut read = 0;
    for processor in [Processor::Intel, Processor::Dec, Processor::Sgi] {
        let original = Sample { processor, ..SAMPLE }.bytes();
        for position in 0..original.len() {
            let _ = importer.read(&original[..position], "cut.c3d");
            // Most bytes of the blocks are padding.
            if original[position] == 0 && position % 8 != 0 {
                continue;
            }
            for byte in [0, 1, 0x7F, 0x80, 0xFF] {
                let mut bytes = original.clone();
                bytes[position] = byte;
                read += usize::from(importer.read(&bytes, "changed.c3d").is_ok());
            }
        }
    }
    assert!(read > 1000, "{read}");
}

#[test]
fn numbers_that_nothing_can_be_computed_with_are_told() {
    let place = |name: &[u8], skip: usize| {
        SAMPLE
            .bytes()
            .windows(name.len())
            .rposition(|part| part == name)
            .unwrap()
            + name.len()
            + skip
    };
    let (rate, scale) = (place(b"RATE", 4), place(b"SCALE", 4));
    for number in [2e-41_f32, 1e-5, 2e6, 3e38] {
        let bytes = with(&[(rate, &number.to_le_bytes())]);
        assert_eq!(read(&bytes).unwrap_err().code(), Code::FrameTime, "{number}");
    }
    for number in [2e-41_f32, 1e-13, 3e38, f32::NEG_INFINITY] {
        let number = number.to_le_bytes();
        let bytes = with(&[(scale, &number), (12, &number)]);
        assert_eq!(read(&bytes).unwrap_err().code(), Code::NumberRange);
    }
    // The first marker's x in the second frame. A record has 9 numbers.
    for number in [3e38, -1.1e18, f32::NAN, f32::INFINITY] {
        let scene = read(&with(&[(1024 + 36, &number.to_le_bytes())])).unwrap();
        let warning = &scene.warnings[0];
        assert_eq!(warning.code, Code::NonFiniteValue);
        assert!(
            warning
                .to_string()
                .contains("frame 1 is not finite, or beyond 1e18; expected a coordinate at byte 1060"),
            "{warning}"
        );
        assert_eq!(channel(&scene, 0).position_keys.len(), 2);
    }
}

/// The sample with parameters that fill a second block. The section states `stated` blocks.
fn with_two_blocks_of_parameters(stated: u8) -> Vec<u8> {
    let bytes = SAMPLE.bytes();
    let list = bytes[512..1024].iter().rposition(|byte| *byte != 0).unwrap() + 512 + 2;
    let mut long = bytes[..list].to_vec();
    for name in ["DESCRIPTION", "DESCRIPTION2"] {
        long.extend(SAMPLE.parameter(1, name, -1, &[200], &[b'x'; 200]));
    }
    long.extend(SAMPLE.parameter(1, "MOVIE_ID", -1, &[3], b"abc"));
    assert!((1024..1536).contains(&long.len()), "{}", long.len());
    long.resize(1536, 0);
    long.extend(&bytes[1024..]);
    long[514] = stated;
    // The data begins one block later.
    long[16] = 4;
    long
}

#[test]
fn parameters_are_read_beyond_a_count_of_blocks_that_is_too_small() {
    let expected = read(&SAMPLE.bytes()).unwrap();
    for stated in [1, 2, 0] {
        let scene = read(&with_two_blocks_of_parameters(stated)).unwrap();
        assert_eq!(
            (&scene.nodes, &scene.animations),
            (&expected.nodes, &expected.animations),
            "{stated}"
        );
        let told = scene.warnings.iter().any(|warning| warning.code == Code::HeaderCount);
        assert_eq!(told, stated == 1);
    }
    // The start of the data is unknown, so nothing shows that the list continues.
    let mut bytes = with_two_blocks_of_parameters(1);
    bytes[16] = 3;
    let error = read(&bytes).unwrap_err().to_string();
    assert!(error.contains("reaches beyond the end of its section"), "{error}");
}

#[test]
fn the_size_of_the_file_decides_between_two_numbers_of_analog_samples() {
    let analog = |used: i16, rate: f32| {
        let bytes = SAMPLE.bytes();
        let list = bytes[512..1024].iter().rposition(|byte| *byte != 0).unwrap() + 512 + 2;
        let mut long = bytes[..list].to_vec();
        long.extend(SAMPLE.group(2, "ANALOG"));
        long.extend(SAMPLE.parameter(2, "USED", 2, &[], &SAMPLE.word(used)));
        long.extend(SAMPLE.parameter(2, "RATE", 4, &[], &SAMPLE.real(rate)));
        long.resize(1024, 0);
        // Records have two markers and six samples: three channels at twice the rate.
        for record in bytes[1024..].chunks_exact(36) {
            long.extend(&record[..32]);
            long.extend([0x11; 24]);
        }
        long
    };
    let expected = read(&SAMPLE.bytes()).unwrap();
    let scene = read(&analog(3, 200.0)).unwrap();
    assert_eq!(scene.animations, expected.animations);
    assert_eq!(scene.warnings[0].code, Code::HeaderCount);
    assert!(
        scene.warnings[0].to_string().contains("expected 6 per frame"),
        "{}",
        scene.warnings[0]
    );
    // The reader keeps the header's counts if no other numbers fit better.
    for (used, rate) in [(3, 100.0), (2, 200.0), (-1, 200.0), (3, f32::NAN), (2, 3e38), (0, 0.0)] {
        let scene = read(&analog(used, rate)).unwrap();
        assert!(
            scene
                .warnings
                .iter()
                .all(|warning| !warning.message.contains("the number in the parameters was used")),
            "{used} {rate}"
        );
    }
}

/// The pose of a segment: its label, the columns of its rotation, and its origin.
type Planted = (&'static str, [[f32; 3]; 3], [f32; 3]);

/// The axes of a standing segment: +X to the right, +Y forward, +Z up.
const STANDS: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A C3D file with the group ROTATION, in the layout of C-Motion. Each segment has 17 floats in each frame: the matrix
/// column by column, and the residual. Some segments are missing in the second of three frames.
fn with_rotations(poses: &[Planted], markers: u16, lost: &str) -> Vec<u8> {
    let sample = &SAMPLE;
    let mut header = vec![2, 0x50];
    for word in [markers as i16, 0, 1, 3, 10] {
        header.extend(sample.word(word));
    }
    header.extend(sample.real(-1.0));
    header.extend(sample.word(5));
    header.extend(sample.word(0));
    header.extend(sample.real(85.0));
    header.resize(512, 0);
    let mut parameters = vec![1, 0x50, 3, 84];
    parameters.extend(sample.group(1, "POINT"));
    parameters.extend(sample.parameter(1, "USED", 2, &[], &sample.word(markers as i16)));
    parameters.extend(sample.parameter(1, "SCALE", 4, &[], &sample.real(-1.0)));
    parameters.extend(sample.parameter(1, "RATE", 4, &[], &sample.real(85.0)));
    parameters.extend(sample.parameter(1, "DATA_START", 2, &[], &sample.word(5)));
    parameters.extend(sample.parameter(1, "UNITS", -1, &[2], b"mm"));
    parameters.extend(sample.group(2, "ROTATION"));
    parameters.extend(sample.parameter(2, "USED", 2, &[], &sample.word(poses.len() as i16)));
    parameters.extend(sample.parameter(2, "RATIO", 2, &[], &sample.word(1)));
    parameters.extend(sample.parameter(2, "DATA_START", 2, &[], &sample.word(6)));
    let label = |pose: &Planted| format!("{:16}", format!("{}_4X4", pose.0)).into_bytes();
    let labels: Vec<u8> = poses.iter().flat_map(label).collect();
    parameters.extend(sample.parameter(2, "LABELS", -1, &[16, poses.len() as u8], &labels));
    parameters.resize(3 * 512, 0);
    let mut points = Vec::new();
    for number in 0..3 * 4 * u32::from(markers) {
        points.extend(sample.real(if number % 4 == 3 { 0.0 } else { number as f32 }));
    }
    points.resize(512, 0);
    let mut data = Vec::new();
    for frame in 0..3 {
        for (label, columns, origin) in poses {
            for (column, last) in columns.iter().chain([origin]).zip([0.0, 0.0, 0.0, 1.0]) {
                column.iter().for_each(|number| data.extend(sample.real(*number)));
                data.extend(sample.real(last));
            }
            let residual = if frame == 1 && *label == lost { -1.0 } else { 0.0 };
            data.extend(sample.real(residual));
        }
    }
    [header, parameters, points, data].concat()
}

/// A standing body with its left knee bent by 60 degrees and its right arm lifted to the side. Its feet have Visual3D's
/// axes: +Z from the toes to the ankle.
fn theia() -> Vec<Planted> {
    let (sin, cos) = 60_f32.to_radians().sin_cos();
    // The proximal end of the shank of a bent knee is above and in front of its distal end.
    let bent = [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]];
    let foot = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]];
    let bent_foot = [[1.0, 0.0, 0.0], [0.0, sin, cos], [0.0, -cos, sin]];
    let lifted = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
    let ankle = [-90.0, -400.0 * sin, 500.0 - 400.0 * cos];
    vec![
        ("worldbody", STANDS, [0.0, 0.0, 0.0]),
        ("pelvis", STANDS, [0.0, 0.0, 950.0]),
        ("torso", STANDS, [0.0, 0.0, 1100.0]),
        ("head", STANDS, [0.0, 0.0, 1550.0]),
        ("l_thigh", STANDS, [-90.0, 0.0, 900.0]),
        ("l_shank", bent, [-90.0, 0.0, 500.0]),
        ("l_foot", bent_foot, ankle),
        (
            "l_toes",
            bent_foot,
            [-90.0, ankle[1] + 150.0 * cos, ankle[2] - 150.0 * sin],
        ),
        ("r_thigh", STANDS, [90.0, 0.0, 900.0]),
        ("r_shank", STANDS, [90.0, 0.0, 500.0]),
        ("r_foot", foot, [90.0, 0.0, 100.0]),
        ("r_toes", foot, [90.0, 150.0, 100.0]),
        ("l_uarm", STANDS, [-200.0, 0.0, 1450.0]),
        ("l_larm", STANDS, [-200.0, 0.0, 1150.0]),
        ("l_hand", STANDS, [-200.0, 0.0, 900.0]),
        ("r_uarm", lifted, [200.0, 0.0, 1450.0]),
        ("r_larm", lifted, [500.0, 0.0, 1450.0]),
        ("r_hand", lifted, [750.0, 0.0, 1450.0]),
    ]
}

#[test]
fn the_segments_of_theia_are_a_skeleton() {
    let poses = theia();
    let scene = read(&with_rotations(&poses, 0, "r_hand")).unwrap();
    assert_eq!(scene.animations[0].frame_count(), 3);
    assert!((scene.animations[0].ticks_per_second - 85.0).abs() < 1e-3);
    for frame in 0..3 {
        let pose = mocap::Pose::at_tick(&scene, 0, f64::from(frame)).unwrap();
        for (label, _, [x, y, z]) in &poses[1..] {
            let node = scene.nodes.iter().position(|node| node.name == *label).unwrap();
            let own = pose.node_to_world[node].w_axis.truncate();
            // +Z of the laboratory is +Y of the scene.
            assert!(own.distance(Vec3::new(*x, *z, -y)) < 0.01, "{label}: {own}");
        }
    }
    let messages: Vec<&str> = scene.warnings.iter().map(|warning| warning.message.as_str()).collect();
    assert!(
        messages.iter().any(|said| said.contains("worldbody_4X4")),
        "{messages:?}"
    );
    assert!(
        messages.iter().any(|said| said.contains("1 of 3 frames")),
        "{messages:?}"
    );
    // In the rest pose all segments are upright.
    let rest = mocap::Pose::rest(&scene);
    let at = |label: &str| {
        let node = scene.nodes.iter().position(|node| node.name == label).unwrap();
        rest.node_to_world[node].w_axis.truncate()
    };
    assert!(
        at("l_shank").distance(Vec3::new(90.0, 450.0, 0.0) - Vec3::Y * 50.0) < 0.01,
        "{}",
        at("l_shank")
    );
    assert!(
        (at("r_toes") - at("r_foot")).distance(Vec3::Z * 150.0) < 0.01,
        "{}",
        at("r_toes")
    );
    assert!(
        (at("l_toes") - at("l_foot")).distance(Vec3::Z * 150.0) < 0.01,
        "{}",
        at("l_toes")
    );
    let angles = mocap::biomechanics::JointAngles::of(&scene).unwrap();
    for (column, wanted) in [
        ("knee_angle_l", 60.0),
        ("knee_angle_r", 0.0),
        ("ankle_angle_l", 0.0),
        ("hip_flexion_l", 0.0),
        ("arm_add_r", -90.0),
        ("elbow_flex_r", 0.0),
        ("pro_sup_l", 0.0),
        ("pro_sup_r", 0.0),
    ] {
        let angle = angles.column(column).unwrap().next().unwrap();
        assert!((angle - wanted).abs() < 0.1, "{column}: {angle}");
    }
}

#[test]
fn markers_of_a_file_with_rotations_stay_and_the_rotations_are_said_to_be_skipped() {
    let scene = read(&with_rotations(&theia(), 2, "")).unwrap();
    let names: Vec<&str> = scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["Markers", "Point_1", "Point_2"]);
    assert_eq!(scene.animations[0].frame_count(), 3);
    let said = |warning: &&mocap::Diagnostic| warning.message.contains("18 segments in ROTATION");
    assert_eq!(scene.warnings.iter().filter(said).count(), 1);
    // Segments that form no body do not become one. A truncated file is read up to its last complete frame.
    let legs = |pose: &&Planted| !pose.0.ends_with("thigh");
    let other: Vec<_> = theia().iter().filter(legs).copied().collect();
    assert_eq!(read(&with_rotations(&other, 0, "")).unwrap().nodes.len(), 1);
    // A fraction of a segment is not a segment.
    let (mut fraction, count) = (with_rotations(&theia(), 2, ""), theia().len() as i16);
    let [word, real] = [(2, SAMPLE.word(count).to_vec()), (4, SAMPLE.real(0.4).to_vec())]
        .map(|(kind, data)| SAMPLE.parameter(2, "USED", kind, &[], &data));
    let at = fraction.windows(word.len()).position(|bytes| bytes == word).unwrap();
    fraction.splice(at..at + word.len(), real.iter().copied());
    fraction.drain(4 * 512..4 * 512 + real.len() - word.len());
    assert_eq!(read(&fraction).unwrap().nodes.len(), 3);
    let whole = with_rotations(&theia(), 0, "");
    let cut = read(&whole[..whole.len() - 4]).unwrap();
    assert_eq!(cut.animations[0].frame_count(), 2);
}
