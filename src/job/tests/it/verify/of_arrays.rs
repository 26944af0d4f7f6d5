//! Tests that compare arrays, `.npz` and `.csv`, with the motion that they were made from.

use mocap::arrays::{ArrayOptions, Arrays, Contacts, Moment, Rotation, RotationSpace, Space};
use mocap::scene::UpAxis;
use mocap::verify::Verifier;
use mocap::verify::report::FindingKind;
use mocap::verify::report::Verification;

use crate::sample::{Sample, is_all};

fn bytes(file: &str, options: &ArrayOptions) -> Vec<u8> {
    let scene = mocap::import(format!("../../fixtures/real/{file}")).unwrap();
    Arrays::of(&scene, options).unwrap().to_npz()
}

fn csv_of(file: &str, options: &ArrayOptions) -> String {
    let scene = mocap::import(format!("../../fixtures/real/{file}")).unwrap();
    Arrays::of(&scene, options).unwrap().to_csv()
}

fn verified(file: &str, bytes: &[u8]) -> mocap::Result<Verification> {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.npz");
    std::fs::write(&output, bytes).unwrap();
    Verifier::new().files(format!("../../fixtures/real/{file}"), output)
}

#[test]
fn whatever_they_hold_is_right() {
    let rotations = [Rotation::Quaternion, Rotation::SixD, Rotation::Matrix, Rotation::Euler];
    let spaces = [Space::World, Space::Root, Space::Local];
    let others = [
        ArrayOptions::default(),
        ArrayOptions::new().out_metres_per_unit(0.01).out_up(UpAxis::Z),
        ArrayOptions::new()
            .up(UpAxis::Z)
            .out_up(UpAxis::Y)
            .joints("Hips|Foot|Head|Hand|Arm".to_owned()),
        ArrayOptions::new()
            .frames_per_second(50.0)
            .first(Moment::Seconds(0.05))
            .last(Moment::Seconds(0.3)),
    ];
    let files = ["cmu_short.bvh", "rotation_before_position.bvh", "z_up_dab.bvh"];
    // A third of all combinations covers every rotation, space, option and file.
    let first = Sample::new().below(3);
    for (index, rotation) in rotations.into_iter().enumerate() {
        for (place, space) in spaces.into_iter().enumerate() {
            for (number, other) in others.iter().enumerate() {
                if (index + 2 * place + number) % 3 != first && !is_all() {
                    continue;
                }
                let options = other
                    .clone()
                    .rotation(rotation)
                    .space(space)
                    .rotation_space([RotationSpace::Local, RotationSpace::World][(index + place) % 2]);
                let file = files[(index + place + number) % files.len()];
                let found = verified(file, &bytes(file, &options)).unwrap();
                let of_csv = verified(file, csv_of(file, &options).as_bytes()).unwrap();
                let compared = |found: &Verification| {
                    let counts = (found.frames, found.joints, found.end_sites);
                    (found.max_error, found.rotation_error, counts)
                };
                assert_eq!(compared(&of_csv), compared(&found), "{file} {options:?}");
                assert!(of_csv.findings.is_empty(), "{file} {options:?}: {of_csv:?}");
                assert!(found.is_within(1e-5), "{file} {options:?}: {found:?}");
                assert!(
                    found.frames > 0 && found.joints + found.end_sites > 2,
                    "{file} {options:?}: {found:?}"
                );
                assert_eq!(found.missing.is_empty(), options.joints.is_none(), "{file} {options:?}");
            }
        }
    }
}

#[test]
fn what_is_wrong_is_found() {
    let file = "cmu_short.bvh";
    let scene = mocap::import(format!("../../fixtures/real/{file}")).unwrap();
    let right = Arrays::of(&scene, &ArrayOptions::default()).unwrap();
    let with = |change: &dyn Fn(&mut mocap::arrays::Arrays)| {
        let mut wrong = right.clone();
        change(&mut wrong);
        verified(file, &wrong.to_npz()).unwrap()
    };
    // A tenth of a unit is 5.6 mm.
    let found = with(&|wrong| wrong.positions[3 * (40 * 38 + 7) + 1] += 0.1);
    assert!((found.max_error - 0.00564).abs() < 1e-4, "{found:?}");
    let worst = found.worst.unwrap();
    assert_eq!((worst.frame, &worst.joint), (40, &right.joints()[7].name));
    let found = with(&|wrong| wrong.rotations[4 * (40 * 38 + 7)] += 0.2);
    assert!(
        found.max_error < 1e-6 && found.rotation_error.unwrap() > 1e-3,
        "{found:?}"
    );
    let found = with(&|wrong| wrong.positions[5] = f32::NAN);
    assert!(!found.is_within(1.0), "{found:?}");
    let found = with(&|wrong| {
        wrong.frames -= 1;
        wrong.positions.truncate(74 * 38 * 3);
        wrong.rotations.truncate(74 * 38 * 4);
    });
    assert_eq!(found.findings[0].kind, FindingKind::MissingFrames);
    let found = with(&|wrong| wrong.header.joints[9].parent = Some(2));
    assert_eq!(found.findings[0].kind, FindingKind::MovedJoint);
    let found = with(&|wrong| wrong.header.joints[9].offset.x += 0.1);
    assert_eq!(found.findings[0].kind, FindingKind::Offset);
    let found = with(&|wrong| wrong.header.joints[9].rotation_order = Some(mocap::scene::RotationOrder::Xyz));
    assert_eq!(found.findings[0].kind, FindingKind::RotationOrder);
    let found = with(&|wrong| wrong.header.frame_rate = 60.0);
    assert_eq!(found.findings[0].kind, FindingKind::Provenance);
    let found = with(&|wrong| wrong.header.metres_per_unit = Some(0.01));
    assert_eq!(found.findings[0].kind, FindingKind::Unit);
    let found = with(&|wrong| wrong.header.up = Some(UpAxis::Z));
    assert_eq!(found.findings[0].kind, FindingKind::UpAxis);
    let found = with(&|wrong| wrong.header.provenance.frames += 1);
    assert_eq!(found.findings[0].kind, FindingKind::Provenance);
    let found = with(&|wrong| wrong.velocities = Some(wrong.positions.clone()));
    assert_eq!(found.findings[0].kind, FindingKind::Velocity);
    let found = verified("cmu_12_01_walk.bvh", &right.to_npz()).unwrap();
    assert!(!found.is_within(1e-3), "{found:?}");
    let error = verified("lecture_Test.bvh", &right.to_npz()).unwrap_err();
    assert!(error.to_string().contains("is not in its source"), "{error}");
}

/// Arrays may have more than their source: a unit or an axis that the caller stated or the output needed, and computed
/// velocities and contacts.
#[test]
fn a_header_that_states_more_than_the_source_is_right() {
    let file = "cmu_short.bvh";
    let more = [
        ArrayOptions::new().metres_per_unit(0.01),
        ArrayOptions::new().up(UpAxis::Z).velocities(true),
        ArrayOptions::new().contacts(Contacts::default()).velocities(true),
        ArrayOptions::new()
            .out_up(UpAxis::Z)
            .velocities(true)
            .frames_per_second(30.0),
    ];
    for options in more {
        for bytes in [bytes(file, &options), csv_of(file, &options).into_bytes()] {
            let found = verified(file, &bytes).unwrap();
            assert!(found.is_within(1e-4), "{options:?}: {found:?}");
        }
    }
}

/// Other readers take names and parents from the arrays next to the header, or from the header itself.
#[test]
fn arrays_that_are_not_those_of_the_header_are_an_error() {
    let whole = bytes("lecture_Test.bvh", &ArrayOptions::default());
    // The header has four bytes for each character.
    let wide = |text: &str| -> Vec<u8> { text.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect() };
    let (from, to) = (wide("\"name\":\"Elbow\""), wide("\"name\":\"Elbov\""));
    let at = whole.windows(from.len()).position(|window| window == from).unwrap();
    let mut changed = whole.clone();
    changed[at..at + to.len()].copy_from_slice(&to);
    let error = verified("lecture_Test.bvh", &with_sums(&changed)).unwrap_err();
    assert!(error.to_string().contains("`names` differs from the header"), "{error}");
}

/// The archive with the checksums of its entries updated.
fn with_sums(archive: &[u8]) -> Vec<u8> {
    let mut archive = archive.to_vec();
    let find = |archive: &[u8], mark: &[u8]| -> Vec<usize> {
        let places = archive.windows(4).enumerate().filter(|(_, window)| *window == mark);
        places.map(|(at, _)| at).collect()
    };
    let number = |archive: &[u8], at: usize| u32::from_le_bytes(archive[at..at + 4].try_into().unwrap()) as usize;
    for listed in find(&archive, b"PK\x01\x02") {
        let (size, local) = (number(&archive, listed + 24), number(&archive, listed + 42));
        let lengths = number(&archive, local + 26);
        let begin = local + 30 + (lengths & 0xffff) + (lengths >> 16);
        let sum = zlib_rs::crc32::crc32(0, &archive[begin..begin + size]).to_le_bytes();
        archive[local + 14..local + 18].copy_from_slice(&sum);
        archive[listed + 16..listed + 20].copy_from_slice(&sum);
    }
    archive
}

#[test]
fn a_broken_archive_is_an_error() {
    let whole = bytes("lecture_Test.bvh", &ArrayOptions::default());
    for length in (4..whole.len()).step_by(97) {
        let error = verified("lecture_Test.bvh", &whole[..length]).unwrap_err();
        assert_eq!(error.code().as_str(), "invalid-arrays", "{length}: {error}");
    }
    // A flipped byte gives an error or other numbers, but no panic. Zip has a checksum for stored entries.
    for at in (4..whole.len()).step_by(31) {
        let mut broken = whole.clone();
        broken[at] ^= 0x41;
        let _ = verified("lecture_Test.bvh", &broken);
    }
}

#[test]
fn a_broken_table_is_an_error_or_found() {
    let file = "lecture_Test.bvh";
    let whole = csv_of(file, &ArrayOptions::default());
    let refused = |text: &str| {
        let error = verified(file, text.as_bytes()).unwrap_err();
        assert_eq!(error.code().as_str(), "invalid-arrays", "{error}");
        error.diagnostic().message.clone()
    };
    for length in (4..whole.len()).step_by(97).chain([whole.len() - 1]) {
        let text = &whole[..length];
        // A whole frame is missing, or none.
        match text.ends_with('\n') && text.lines().count() % 4 == 2 {
            true => assert!(
                !verified(file, text.as_bytes()).unwrap().findings.is_empty(),
                "{length}"
            ),
            false => drop(refused(text)),
        }
    }
    let rows: Vec<&str> = whole.lines().collect();
    let without = |row: usize| [&rows[..row], &rows[row + 1..]].concat().join("\n") + "\n";
    assert!(refused(&without(5)).contains("line 6 is not frame 0 of joint \"EndSite_Wrist\""));
    assert_eq!(
        refused(&without(rows.len() - 1)),
        "the last frame does not have all joints"
    );
    let missing = rows[..rows.len() - 4].join("\n") + "\n";
    let found = verified(file, missing.as_bytes()).unwrap();
    assert_eq!(found.findings[0].kind, FindingKind::MissingFrames);
    let found = verified(file, whole.replacen(",Elbow,2", ",Elbow,3", 1).as_bytes()).unwrap();
    assert!(!found.is_within(0.1), "{found:?}");
}

#[test]
fn names_in_tables_may_be_anything() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("take.bvh");
    let text = std::fs::read_to_string("../../fixtures/real/lecture_Test.bvh").unwrap();
    std::fs::write(&source, text.replacen("ROOT Shoulder", "ROOT =1+1, \"a\"", 1)).unwrap();
    let motion = Arrays::of(&mocap::import(&source).unwrap(), &ArrayOptions::default()).unwrap();
    assert!(motion.joints()[0].name.starts_with("=1+1, \""));
    let output = folder.path().join("out.csv");
    for table in [motion.to_csv(), motion.to_csv_for_spreadsheet()] {
        std::fs::write(&output, table).unwrap();
        assert!(Verifier::new().files(&source, &output).unwrap().is_within(1e-5));
    }
}
