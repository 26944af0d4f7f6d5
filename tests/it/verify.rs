//! That verify finds what is wrong, says where, and finds nothing where nothing is wrong.

use std::path::PathBuf;

use mocap::glam::{Quat, Vec3};
use mocap::gltf::{GltfOptions, write_glb};
use mocap::process::{convert_units, in_place, resample, root_motion, trim};
use mocap::scene::{Channel, UpAxis};
use mocap::verify::{FindingKind, Verification, Verifier, verify};
use mocap::{Code, Exporter, Importer, Limits, RootOffset, Scene, SkeletonMesh};

use crate::cut;
use crate::sample::Sample;

fn fixture(file: &str) -> String {
    format!("{}/fixtures/real/{file}", env!("CARGO_MANIFEST_DIR"))
}

fn import(file: &str) -> Scene {
    Importer::new()
        .skeleton_mesh(SkeletonMesh::Skinned)
        .import(fixture(file))
        .unwrap()
}

fn glb(scene: &Scene) -> Vec<u8> {
    write_glb(scene, &GltfOptions::default()).unwrap()
}

/// `glb` without what this crate says about itself in it.
fn as_of_another_program(glb: &[u8]) -> Vec<u8> {
    let place = glb.windows(7).position(|window| window == b"\"mocap\"").unwrap();
    let mut changed = glb.to_vec();
    changed[place..place + 7].copy_from_slice(b"\"other\"");
    changed
}

#[test]
fn every_step_is_replayed_from_the_provenance() {
    type Step = fn(&mut Scene);
    let steps: [(Step, usize); 7] = [
        (|_| (), 339),
        (|scene| convert_units(scene, 0.0254, UpAxis::Z), 339),
        (|scene| trim(scene, 100.0, 200.0), 101),
        (
            |scene| {
                trim(scene, 50.0, 300.0);
                trim(scene, 50.0, 150.0);
                convert_units(scene, 0.01, UpAxis::Y);
            },
            101,
        ),
        (
            |scene| {
                trim(scene, 1.0, f64::INFINITY);
                convert_units(scene, 0.0254, UpAxis::Z);
                in_place(scene);
            },
            338,
        ),
        (
            |scene| {
                convert_units(scene, 0.0254, UpAxis::Z);
                root_motion(scene);
            },
            339,
        ),
        (
            |scene| {
                let rate = scene.animations[0].ticks_per_second;
                resample(scene, 2.0 * rate, &Limits::default()).unwrap();
                convert_units(scene, 0.0254, UpAxis::Z);
            },
            677,
        ),
    ];
    let source = import("z_up_dab.bvh");
    for (index, (step, frames)) in steps.into_iter().enumerate() {
        let mut scene = source.clone();
        step(&mut scene);
        let verified = verify(&source, &glb(&scene)).unwrap();
        // The skeleton is 44 of the file's units tall, so this is 1e-6 of its height.
        let tolerance = 44.0 * verified.metres_per_unit * 1e-6;
        assert!(verified.max_error < 2.0 * tolerance, "steps {index}: {verified:?}");
        assert_eq!((verified.frames, verified.joints), (frames, 34), "steps {index}");
        assert!(verified.missing.is_empty() && verified.missing_end_sites.is_empty());
        assert!(verified.has_provenance);
    }
}

#[test]
fn a_joint_that_is_off_is_named_with_its_frame_and_distance() {
    let source = import("cmu_short.bvh");
    let mut scene = source.clone();
    convert_units(&mut scene, 0.01, UpAxis::Y);
    let tip = scene
        .nodes
        .iter()
        .find(|node| node.name == "EndSite_LeftToeBase")
        .unwrap();
    let offset = tip.transform.w_axis.truncate().as_dvec3();
    let toes = |channel: &&mut Channel| channel.node_name == "LeftToeBase";
    let channel = scene.animations[0].channels.iter_mut().find(toes).unwrap();
    let rotation = &mut channel.rotation_keys.values[40];
    *rotation *= Quat::from_rotation_x(0.1);

    // A turn by 0.1 about X moves the tip along a chord of the circle around X on which it stands.
    let expected = 2.0 * f64::sin(0.05) * offset.y.hypot(offset.z);
    let verified = verify(&source, &glb(&scene)).unwrap();
    assert!(
        (verified.max_error - expected).abs() < 1e-6,
        "{} is not {expected}",
        verified.max_error
    );
    let worst = verified.worst.unwrap();
    assert_eq!((worst.joint.as_str(), worst.frame), ("EndSite_LeftToeBase", 40));
    assert!((worst.seconds - 40.0 * 0.008_333_3).abs() < 1e-9);
    let mean_square = expected * expected / (75.0 * 38.0);
    assert!((verified.rms_error - mean_square.sqrt()).abs() < 1e-6);
}

#[test]
fn resampling_is_compared_at_its_own_frames_and_its_loss_is_a_figure_of_its_own() {
    let source = import("cmu_12_01_walk.bvh");
    let lost = [60.0, 30.0, 25.0].map(|rate| {
        let mut scene = source.clone();
        resample(&mut scene, rate, &Limits::default()).unwrap();
        convert_units(&mut scene, 0.056_444, UpAxis::Y);
        let verified = verify(&source, &glb(&scene)).unwrap();
        assert!(verified.is_within(1e-5), "{rate}: {verified:?}");
        assert!(verified.frames < 270);
        let lost = verified.resampling.unwrap();
        assert!((519..=524).contains(&lost.frames), "{lost:?}");
        lost.max_error
    });
    assert!(lost[0] > 1e-5 && lost[1] > lost[0], "{lost:?}");
    // A T-pose that was smeared over a frame of a thirtieth would be half a metre off.
    assert!(lost[1] < 0.03, "{lost:?}");
}

/// The frame time .0083333 means 1/120, so that this changes no frame, and the time of each by a part in 250,000.
#[test]
fn the_rate_that_a_rounded_frame_time_means_loses_nothing() {
    let source = import("cmu_12_01_walk.bvh");
    let mut scene = source.clone();
    resample(&mut scene, 120.0, &Limits::default()).unwrap();
    convert_units(&mut scene, 0.056_444, UpAxis::Y);
    let verified = verify(&source, &glb(&scene)).unwrap();
    assert_eq!(verified.frames, 524);
    assert!(verified.max_error < 2e-6, "{verified:?}");
}

#[test]
fn files_of_other_programs_are_compared_by_name_and_size() {
    let source = import("z_up_dab.bvh");
    let mut scene = source.clone();
    convert_units(&mut scene, 0.0254, UpAxis::Z);
    for (node, name) in [(0, "mixamorig:Hips"), (1, "SPINE"), (2, "Spine 1")] {
        let old = std::mem::replace(&mut scene.nodes[node].name, name.into());
        for channel in &mut scene.animations[0].channels {
            if channel.node_name == old {
                channel.node_name = name.into();
            }
        }
    }
    let verified = verify(&source, &as_of_another_program(&glb(&scene))).unwrap();
    assert!(!verified.has_provenance);
    assert_eq!(verified.missing, ["Hips"]);
    assert_eq!((verified.frames, verified.joints), (339, 33));
    assert!((verified.metres_per_unit / 0.0254 - 1.0).abs() < 1e-5);
    assert!(verified.max_error < 1e-4, "{verified:?}");
}

#[test]
fn a_file_that_ends_early_is_compared_as_far_as_it_goes() {
    let source = import("z_up_dab.bvh");
    let mut scene = source.clone();
    trim(&mut scene, 0.0, 99.0);
    let verified = verify(&source, &as_of_another_program(&glb(&scene))).unwrap();
    assert_eq!(verified.frames, 339);
    assert_eq!(kinds(&verified), [FindingKind::MissingFrames]);
    assert!(!verified.is_within(f64::INFINITY));
}

fn kinds(verified: &Verification) -> Vec<FindingKind> {
    verified.findings.iter().map(|finding| finding.kind).collect()
}

/// What somebody does to a scene without a word about it in the file.
#[test]
fn every_attack_is_found() {
    type Attack = fn(&mut Scene);
    fn rename(scene: &mut Scene, from: &str, to: &str) {
        let node = scene.nodes.iter_mut().find(|node| node.name == from).unwrap();
        node.name = to.into();
        let channels = scene.animations.iter_mut().flat_map(|clip| &mut clip.channels);
        for channel in channels.filter(|channel| channel.node_name == from) {
            channel.node_name = to.into();
        }
    }
    let attacks: [(&str, Attack, &[FindingKind]); 8] = [
        (
            "one frame of all",
            |scene| trim(scene, 0.0, 0.0),
            &[
                FindingKind::Provenance,
                FindingKind::MissingFrames,
                FindingKind::MissingFrames,
            ],
        ),
        (
            "the last frame dropped",
            |scene| trim(scene, 0.0, 73.0),
            &[FindingKind::Provenance, FindingKind::MissingFrames],
        ),
        (
            "the first frame dropped",
            |scene| trim(scene, 1.0, 74.0),
            &[FindingKind::Provenance, FindingKind::MissingFrames],
        ),
        (
            "slower",
            |scene| scene.animations[0].ticks_per_second *= 0.9,
            &[FindingKind::ExtraFrames],
        ),
        (
            "renamed",
            |scene| rename(scene, "Head", "Kopf"),
            &[FindingKind::MissingJoint, FindingKind::ExtraJoint],
        ),
        (
            "left and right swapped",
            |scene| {
                rename(scene, "LeftLeg", "swap");
                rename(scene, "RightLeg", "LeftLeg");
                rename(scene, "swap", "RightLeg");
            },
            &[FindingKind::MovedJoint],
        ),
        (
            "another clip",
            |scene| {
                let mut clip = scene.animations[0].clone();
                clip.name = "other".into();
                scene.animations.push(clip);
            },
            &[FindingKind::ExtraClip],
        ),
        (
            "no clip",
            |scene| scene.animations.clear(),
            &[FindingKind::Provenance, FindingKind::MissingClip],
        ),
    ];
    let source = import("cmu_short.bvh");
    for (name, attack, expected) in attacks {
        let mut scene = source.clone();
        convert_units(&mut scene, 0.056_444, UpAxis::Y);
        let steps = scene.metadata.steps.clone();
        attack(&mut scene);
        scene.metadata.steps = steps;
        let verified = verify(&source, &glb(&scene)).unwrap();
        assert_eq!(kinds(&verified), expected, "{name}: {:?}", verified.findings);
        assert!(!verified.is_within(f64::INFINITY), "{name}");
    }
}

#[test]
fn a_turn_that_moves_no_joint_is_found() {
    let source = import("z_up_dab.bvh");
    let mut scene = source.clone();
    convert_units(&mut scene, 0.0254, UpAxis::Z);
    let verified = verify(&source, &glb(&scene)).unwrap();
    assert!(verified.turn_error.unwrap() < 1e-6, "{verified:?}");
    let has_children = |id: usize| {
        scene
            .nodes
            .iter()
            .any(|node| node.parent.is_some_and(|parent| parent.index() == id))
    };
    let leaf = (0..scene.nodes.len()).find(|id| !has_children(*id)).unwrap();
    let turn = mocap::glam::Mat4::from_rotation_x(0.1);
    scene.nodes[leaf].transform *= turn;
    let verified = verify(&source, &glb(&scene)).unwrap();
    assert!(verified.max_error < 1e-5, "{verified:?}");
    // A point 3 cm from a joint that turns by 0.1 about X: the chord of its circle.
    let chord = 2.0 * 0.03 * f64::sin(0.05);
    assert!((verified.turn_error.unwrap() - chord).abs() < 1e-5, "{verified:?}");
    assert!(!verified.is_within(1e-3));
}

#[test]
fn bvh_is_compared_as_its_reader_reads_it() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.bvh");
    let mut random = Sample::new();
    for file in ["cmu_short.bvh", "z_up_dab.bvh", "rokoko_dance.bvh", "py_c3d_motion.c3d"] {
        let mut source = PathBuf::from(fixture(file));
        if file.ends_with(".bvh") {
            let text = cut::some_frames(&mut random, &format!("real/{file}"), 100);
            source = folder.path().join(file);
            std::fs::write(&source, text).unwrap();
        }
        let scene = mocap::import(&source).unwrap();
        Exporter::new().overwrite(true).export(&scene, &output).unwrap();
        let verified = Verifier::new().files(&source, &output).unwrap();
        assert!(verified.is_within(1e-4), "{file}: {verified:?}");
        let mut shorter = scene.clone();
        trim(&mut shorter, 0.0, 5.0);
        Exporter::new().overwrite(true).export(&shorter, &output).unwrap();
        let verified = Verifier::new().files(&source, &output).unwrap();
        assert!(
            kinds(&verified).contains(&FindingKind::MissingFrames),
            "{file}: {verified:?}"
        );
    }
}

#[test]
fn a_file_of_another_skeleton_is_refused() {
    let error = verify(&import("lecture_Test.bvh"), &glb(&import("cmu_short.bvh"))).unwrap_err();
    assert!(error.to_string().contains("no joint"), "{error}");
}

#[test]
fn a_file_of_no_known_format_is_refused() {
    let error = verify(&import("lecture_Test.bvh"), b"no motion").unwrap_err();
    assert_eq!(error.code(), Code::UnknownFormat);
    // A file is what it is itself.
    let source = fixture("lecture_Test.bvh");
    assert!(Verifier::new().files(&source, &source).unwrap().is_within(1e-9));
}

#[test]
fn a_still_skeleton_is_compared_at_rest() {
    let source = import("latin1_name_no_motion.bvh");
    let verified = verify(&source, &glb(&source)).unwrap();
    assert_eq!(
        (verified.frames, verified.joints, verified.max_error < 1e-5),
        (1, 23, true)
    );
    let mut moved = source.clone();
    moved.nodes[3].transform.w_axis += Vec3::X.extend(0.0);
    assert!((verify(&source, &glb(&moved)).unwrap().max_error - 1.0).abs() < 1e-5);
}

#[test]
fn files_are_read_as_the_conversion_read_them() {
    let folder = tempfile::tempdir().unwrap();
    let source = fixture("cmu_short.bvh");
    let importer = Importer::new().root_offset(RootOffset::Add).retime(25.0);
    let scene = importer.import(&source).unwrap();
    for name in ["a b.gltf", "a.glb"] {
        let output = folder.path().join(name);
        Exporter::new().export(&scene, &output).unwrap();
        let verified = Verifier::new().files(&source, &output).unwrap();
        assert_eq!(verified.frames, 75);
        assert!(verified.max_error < 1e-4, "{verified:?}");
    }
    let error = Verifier::new()
        .files(&source, folder.path().join("none.glb"))
        .unwrap_err();
    assert_eq!(error.code().as_str(), "io");
}

mod of_arrays {
    use mocap::arrays::{ArrayOptions, Moment, Rotation, RotationSpace, Space, arrays};
    use mocap::scene::UpAxis;
    use mocap::verify::{FindingKind, Verification, Verifier};

    use crate::sample::{Sample, is_all};

    fn bytes(file: &str, options: &ArrayOptions) -> Vec<u8> {
        let scene = mocap::import(format!("fixtures/real/{file}")).unwrap();
        arrays(&scene, options).unwrap().to_npz()
    }

    fn csv_of(file: &str, options: &ArrayOptions) -> String {
        let scene = mocap::import(format!("fixtures/real/{file}")).unwrap();
        arrays(&scene, options).unwrap().to_csv()
    }

    fn verified(file: &str, bytes: &[u8]) -> mocap::Result<Verification> {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("out.npz");
        std::fs::write(&output, bytes).unwrap();
        Verifier::new().files(format!("fixtures/real/{file}"), output)
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
        // A third of all, with every rotation, space, option and file.
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
                    let compared =
                        |found: &Verification| (found.max_error, found.turn_error, found.frames, found.joints);
                    assert_eq!(compared(&of_csv), compared(&found), "{file} {options:?}");
                    assert!(of_csv.findings.is_empty(), "{file} {options:?}: {of_csv:?}");
                    assert!(found.is_within(1e-5), "{file} {options:?}: {found:?}");
                    assert!(found.frames > 0 && found.joints > 2, "{file} {options:?}: {found:?}");
                    assert_eq!(found.missing.is_empty(), options.joints.is_none(), "{file} {options:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_wrong_is_found() {
        let file = "cmu_short.bvh";
        let scene = mocap::import(format!("fixtures/real/{file}")).unwrap();
        let right = arrays(&scene, &ArrayOptions::default()).unwrap();
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
        assert!(found.max_error < 1e-6 && found.turn_error.unwrap() > 1e-3, "{found:?}");
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
        let found = verified("cmu_12_01_walk.bvh", &right.to_npz()).unwrap();
        assert!(!found.is_within(1e-3), "{found:?}");
        let error = verified("lecture_Test.bvh", &right.to_npz()).unwrap_err();
        assert!(error.to_string().contains("is not in its source"), "{error}");
    }

    #[test]
    fn a_broken_archive_is_an_error() {
        let whole = bytes("lecture_Test.bvh", &ArrayOptions::default());
        for length in (4..whole.len()).step_by(97) {
            let error = verified("lecture_Test.bvh", &whole[..length]).unwrap_err();
            assert_eq!(error.code().as_str(), "invalid-arrays", "{length}: {error}");
        }
        // A flipped byte is an error or other numbers, but no panic; zip has a sum for what is stored.
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
        let text = std::fs::read_to_string("fixtures/real/lecture_Test.bvh").unwrap();
        std::fs::write(&source, text.replacen("ROOT Shoulder", "ROOT =1+1, \"a\"", 1)).unwrap();
        let motion = arrays(&mocap::import(&source).unwrap(), &ArrayOptions::default()).unwrap();
        assert!(motion.joints()[0].name.starts_with("=1+1, \""));
        let output = folder.path().join("out.csv");
        for table in [motion.to_csv(), motion.to_csv_for_spreadsheet()] {
            std::fs::write(&output, table).unwrap();
            assert!(Verifier::new().files(&source, &output).unwrap().is_within(1e-5));
        }
    }

    #[cfg(feature = "cli")]
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
        assert!(said.starts_with("19 frames, 38 joints: 0.0"), "{said}");
    }
}

mod sidecar;
mod truth;
mod verdicts;
