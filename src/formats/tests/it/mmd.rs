//! MikuMikuDance: a motion on its model as another program poses it, a motion on generic proportions, and broken files.

mod bezier;
mod generic;
mod names;

use std::fs;
use std::path::Path;

use mocap::figure::vrm_humanoid;
use mocap::glam::Vec3;
use mocap::retarget::{RetargetOptions, Retargeter, SourceMotion};
use mocap::scene::report::{DataKind, DataLoss};
use mocap::scene::{Face, HumanoidBone};
use mocap::{Code, Conversion, Exporter, Format, Importer, Pose, Scene};

const MOTION: &str = "../../fixtures/made/dancer.vmd";
const MODEL: &str = "../../fixtures/made/dancer.pmx";

/// The positions of bones in some frames, in units of the model, from babylon-mmd 1.3: `tools/mmd/judge.py --expected`.
/// At frame 55, the IK of the left leg is off.
#[rustfmt::skip]
const POSITIONS: &[(usize, &str, [f32; 3])] = &[
    (0, "頭", [0.0684, 17.2000, 0.0121]),
    (0, "左目", [0.1724, 18.0534, 0.8957]),
    (0, "左手首", [4.2059, 13.7355, 3.1590]),
    (0, "右手首", [-5.0787, 12.9895, -1.9678]),
    (0, "左ひざ", [1.0000, 6.2000, 0.2000]),
    (0, "左足首", [1.0500, 1.2000, -0.2000]),
    (0, "右ひざ", [-1.1458, 6.2018, 0.1465]),
    (0, "右つま先", [-0.8095, 0.0153, 0.8851]),
    (0, "左ひざD", [1.0000, 6.2000, 0.2000]),
    (0, "髪", [0.2750, 19.1686, -0.5554]),
    (0, "長い名前の骨の先", [0.5133, 18.2944, -1.2104]),
    (12, "頭", [0.5679, 15.8440, -1.2053]),
    (12, "左目", [0.4077, 16.7769, -0.4153]),
    (12, "左手首", [2.2625, 16.7467, 3.4407]),
    (12, "右手首", [-3.8634, 11.3956, -4.1134]),
    (12, "左ひざ", [-0.1364, 7.4218, 3.5961]),
    (12, "左足首", [1.5303, 3.2852, 1.2996]),
    (12, "右ひざ", [-1.9954, 5.9495, 1.4954]),
    (12, "右つま先", [-1.1220, 0.2495, 0.3980]),
    (12, "左ひざD", [-0.1364, 7.4218, 3.5961]),
    (12, "髪", [0.9029, 17.9433, -1.6951]),
    (12, "長い名前の骨の先", [1.3167, 17.0145, -2.1600]),
    (20, "頭", [1.0686, 15.6384, -1.9391]),
    (20, "左目", [0.8307, 16.6817, -1.3267]),
    (20, "左手首", [1.8661, 17.3732, 2.5673]),
    (20, "右手首", [-3.2990, 11.0039, -4.0067]),
    (20, "左ひざ", [-0.6912, 7.5519, 3.5081]),
    (20, "左足首", [1.8503, 3.3995, 2.2998]),
    (20, "右ひざ", [-2.4759, 6.2154, 1.1595]),
    (20, "右つま先", [-1.3308, 0.4254, 0.0419]),
    (20, "左ひざD", [-0.6912, 7.5519, 3.5081]),
    (20, "髪", [1.5343, 17.6482, -2.5661]),
    (20, "長い名前の骨の先", [1.9694, 16.6499, -2.8193]),
    (33, "頭", [-0.4094, 16.1223, -1.5877]),
    (33, "左目", [-0.2125, 17.2053, -1.0324]),
    (33, "左手首", [3.0317, 18.1603, 1.1666]),
    (33, "右手首", [-3.3247, 11.7406, 0.6643]),
    (33, "左ひざ", [1.3604, 6.6402, 3.0127]),
    (33, "左足首", [1.5380, 2.2550, 0.5834]),
    (33, "右ひざ", [-1.1546, 5.7984, 1.9078]),
    (33, "右つま先", [-1.6601, 0.7305, -0.5664]),
    (33, "左ひざD", [1.3604, 6.6402, 3.0127]),
    (33, "髪", [-0.5142, 17.9520, -2.6480]),
    (33, "長い名前の骨の先", [-0.3277, 16.9315, -3.0648]),
    (45, "頭", [-1.0142, 16.6503, -0.9366]),
    (45, "左目", [-0.7861, 17.7333, -0.3934]),
    (45, "左手首", [2.5779, 18.6883, 1.6176]),
    (45, "右手首", [-3.5929, 12.2931, 1.4354]),
    (45, "左ひざ", [0.9700, 5.9517, 0.6319]),
    (45, "左足首", [1.2488, 1.2157, -0.9977]),
    (45, "右ひざ", [-1.3867, 6.0072, 1.7140]),
    (45, "右つま先", [-1.9500, 1.0360, -1.1569]),
    (45, "左ひざD", [0.9700, 5.9517, 0.6319]),
    (45, "髪", [-1.1850, 18.3613, -2.1408]),
    (45, "長い名前の骨の先", [-1.0226, 17.3408, -2.5675]),
    (55, "頭", [-1.0142, 16.6503, -0.9366]),
    (55, "左目", [-0.7861, 17.7333, -0.3934]),
    (55, "左手首", [2.5779, 18.6883, 1.6176]),
    (55, "右手首", [-3.5929, 12.2931, 1.4354]),
    (55, "左ひざ", [0.5593, 6.2144, -1.2796]),
    (55, "左足首", [0.5372, 1.7435, -3.5541]),
    (55, "右ひざ", [-1.3867, 6.0072, 1.7140]),
    (55, "右つま先", [-1.9500, 1.0360, -1.1569]),
    (55, "左ひざD", [0.5593, 6.2144, -1.2796]),
    (55, "髪", [-1.1850, 18.3613, -2.1408]),
    (55, "長い名前の骨の先", [-1.0226, 17.3408, -2.5675]),
];

fn node(scene: &Scene, name: &str) -> usize {
    let found = scene.nodes.iter().position(|node| node.name == name);
    found.unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn a_motion_on_its_model_is_as_another_program_poses_it() {
    let scene = Importer::new().import(MOTION).unwrap();
    assert!(scene.validate().is_empty());
    let animation = &scene.animations[0];
    assert_eq!((animation.ticks_per_second, animation.duration), (30.0, 59.0));
    for (frame, name, position) in POSITIONS {
        let pose = Pose::at_tick(&scene, 0, *frame as f64).unwrap();
        let ours = pose.node_to_world[node(&scene, name)].w_axis.truncate();
        // In single precision, loops of IK end slightly apart.
        assert!(
            ours.distance(Vec3::from(*position)) < 0.003,
            "{name} at {frame}: {ours}"
        );
    }
    let said: Vec<String> = scene.metadata.assumptions.iter().map(ToString::to_string).collect();
    assert!(
        said.iter()
            .any(|said| said.contains("dancer.pmx") && said.contains("names this model")),
        "{said:?}"
    );
    assert!(said.iter().any(|said| said.contains("2 keys of cameras")), "{said:?}");
    let screen = mocap::render::Clip {
        name: MOTION,
        scene: &scene,
    }
    .screen(&mocap::render::ScreenOptions::default());
    assert!(
        screen.lines().any(|line| line.starts_with("interpolation ")),
        "{screen}"
    );
    let left_out: Vec<_> = scene
        .warnings
        .iter()
        .map(|warning| (warning.code, warning.joint.as_deref()))
        .collect();
    assert_eq!(left_out, [(Code::IgnoredChannel, Some("無い骨"))]);
}

#[test]
fn morphs_are_a_face_and_those_that_never_show_are_left_out() {
    let scene = Importer::new().import(MOTION).unwrap();
    let faces: Vec<&Face> = scene.nodes.iter().filter_map(|node| node.face.as_ref()).collect();
    let (blink, grin) = (Face::Preset("blink".to_owned()), Face::Custom("にやり".to_owned()));
    assert_eq!(faces.len(), 2, "{faces:?}");
    let weight = |face: &Face, frame: f64| {
        let index = scene
            .nodes
            .iter()
            .position(|node| node.face.as_ref() == Some(face))
            .unwrap();
        Pose::at_tick(&scene, 0, frame).unwrap().node_to_parent[index].w_axis.x
    };
    assert_eq!(
        [0.0, 5.0, 10.0, 15.0, 40.0].map(|frame| weight(&blink, frame)),
        [0.0, 0.5, 1.0, 0.5, 0.0]
    );
    assert!(
        [0.0, 59.0]
            .iter()
            .all(|frame| (weight(&grin, *frame) - 0.6).abs() < 1e-6)
    );
}

#[test]
fn a_model_alone_is_a_skeleton_that_states_its_bones() {
    let scene = Importer::new().import(MODEL).unwrap();
    assert_eq!((scene.metadata.format, scene.animations.len()), (Some(Format::Pmx), 0));
    assert!(scene.warnings.iter().any(|warning| warning.code == Code::NoMotion));
    let bone = |name: &str| scene.nodes[node(&scene, name)].humanoid_bone;
    assert_eq!(bone("下半身"), Some(HumanoidBone::Hips));
    assert_eq!(bone("センター"), None);
    assert_eq!(
        scene.nodes[node(&scene, "上半身")].parent.unwrap().index(),
        node(&scene, "下半身")
    );
    assert_eq!(bone("右ひじ"), Some(HumanoidBone::RightLowerArm));
    assert_eq!(bone("左ひざD"), None);
    let names: Vec<&str> = scene
        .nodes
        .iter()
        .filter(|node| node.face.is_some())
        .map(|node| &*node.name)
        .collect();
    assert_eq!(names, ["まばたき", "あ", "にやり"]);
    // The file is left-handed, and the model faces -Z.
    let pose = Pose::rest(&scene);
    let at = |name: &str| pose.node_to_world[node(&scene, name)].w_axis.truncate();
    assert!(at("左手首").x > 1.0 && at("左つま先").z > 1.0);
    assert_eq!(scene.metadata.metres_per_unit, Some(0.08));
}

/// Without a model, the scene has the bones of nearly all models. The legs reach their goals, and a body of 1.7 m
/// stands on the ground.
#[test]
fn a_motion_without_a_model_is_read_onto_generic_proportions() {
    let bytes = fs::read(MOTION).unwrap();
    let mut scene = Importer::new().read(&bytes, "dancer.vmd").unwrap();
    assert!(scene.validate().is_empty());
    let said = scene
        .metadata
        .assumptions
        .iter()
        .find(|said| said.choice == "generic proportions");
    assert!(said.is_some_and(|said| said.reason.contains("踊り子") && said.reason.contains("as the skeleton")));
    Conversion::new().apply(&mut scene).unwrap();
    let rest = Pose::rest(&scene);
    let height = |name: &str| rest.node_to_world[node(&scene, name)].w_axis.y;
    assert!(
        (height("左足首") - 0.066).abs() < 0.01 && (height("頭") - 1.54).abs() < 0.05,
        "{}",
        height("頭")
    );
    for frame in [0.0, 20.0, 45.0] {
        let pose = Pose::at_tick(&scene, 0, frame).unwrap();
        let at = |name: &str| pose.node_to_world[node(&scene, name)].w_axis.truncate();
        assert!(at("左足首").distance(at("左足ＩＫ")) < 0.01, "{frame}");
        assert!(at("右足首").distance(at("右足ＩＫ")) < 0.01, "{frame}");
    }
    let by_name = Importer::new().skeleton(MODEL).read(&bytes, "other.vmd").unwrap();
    assert_eq!(
        by_name.nodes,
        Importer::new().import(MOTION).unwrap().nodes[..].to_vec()
    );
}

/// If several models are next to a motion, the reader takes the model that the motion names.
#[test]
fn of_several_models_the_named_one_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let copy = |from: &str, to: &str| fs::copy(from, folder.path().join(to)).map(drop).unwrap();
    copy(MOTION, "take.vmd");
    copy(MODEL, "b.pmx");
    fs::write(folder.path().join("a.pmx"), "PMX broken").unwrap();
    let scene = Importer::new().import(folder.path().join("take.vmd")).unwrap();
    assert!(
        scene
            .metadata
            .assumptions
            .iter()
            .any(|said| said.choice == "the model of b.pmx")
    );
    copy(MODEL, "take.pmx");
    let scene = Importer::new().import(folder.path().join("take.vmd")).unwrap();
    assert!(
        scene
            .metadata
            .assumptions
            .iter()
            .any(|said| said.choice == "the model of take.pmx")
    );
}

fn code_of(bytes: &[u8], name: &str) -> Result<Scene, Code> {
    Importer::new()
        .read(bytes, Path::new(name))
        .map_err(|error| error.code())
}

#[test]
fn files_that_are_cut_or_state_too_much_are_errors() {
    let [motion, model] = [MOTION, MODEL].map(|path| fs::read(path).unwrap());
    for length in (30..motion.len()).step_by(7) {
        match code_of(&motion[..length], "a.vmd") {
            Err(code) => assert_eq!(code, Code::UnexpectedEnd, "{length}"),
            Ok(scene) => assert!(scene.validate().is_empty(), "{length}"),
        }
    }
    for length in (4..model.len() - 90).step_by(3) {
        let code = code_of(&model[..length], "a.pmx").unwrap_err();
        assert_eq!(code, Code::UnexpectedEnd, "{length}");
    }
    // The file states 4 billion keys, and a last frame after four years.
    let mut many = motion.clone();
    many[50..54].fill(0xFF);
    assert_eq!(code_of(&many, "a.vmd").unwrap_err(), Code::UnexpectedEnd);
    let mut late = motion.clone();
    late[54 + 15..54 + 19].fill(0xFF);
    assert_eq!(code_of(&late, "a.vmd").unwrap_err(), Code::LimitExceeded);
    let old = [b"Pmx ".as_slice(), &[0; 40]].concat();
    let read = Importer::new().format(Format::Pmx).read(&old, "a.pmx");
    assert_eq!(read.unwrap_err().code(), Code::UnreadableFormat);
    let older = [b"Pmd\0\0\x80\x3F".as_slice(), &[0; 40]].concat();
    assert_eq!(code_of(&older, "a.pmd").unwrap_err(), Code::UnreadableFormat);
}

/// Keys with values that are not finite are dropped and reported.
#[test]
fn keys_that_are_no_numbers_are_left_out() {
    let mut bytes = fs::read(MOTION).unwrap();
    // The position of the second key of the centre, and the rotation of the third key.
    let key = |index: usize| 54 + 111 * index;
    bytes[key(1) + 19..key(1) + 23].copy_from_slice(&f32::NAN.to_le_bytes());
    bytes[key(2) + 31..key(2) + 47].fill(0);
    let scene = Importer::new().skeleton(MODEL).read(&bytes, "dancer.vmd").unwrap();
    let left_out: Vec<_> = scene
        .warnings
        .iter()
        .filter(|warning| warning.code == Code::NonFiniteValue)
        .collect();
    assert_eq!(left_out.len(), 2);
    assert_eq!(left_out[0].joint.as_deref(), Some("センター"));
    assert!(scene.validate().is_empty());
}

/// Bytes after the last table do not belong to the motion, and are reported.
#[test]
fn bytes_behind_the_last_table_are_said() {
    let whole = fs::read(MOTION).unwrap();
    let more = [whole.as_slice(), b"more"].concat();
    let [whole_scene, scene] =
        [&whole, &more].map(|bytes| Importer::new().skeleton(MODEL).read(bytes, "a.vmd").unwrap());
    let trailing = |scene: &Scene| {
        let mut said = scene
            .warnings
            .iter()
            .filter(|warning| warning.code == Code::TrailingText);
        said.next().cloned()
    };
    assert!(trailing(&whole_scene).is_none());
    let said = trailing(&scene).unwrap();
    let begin = format!("from byte {}", whole.len());
    assert!(said.message.contains(&begin), "{}", said.message);
    assert_eq!(said.found.as_deref(), Some("4 more bytes"));
    assert_eq!(scene.animations, whole_scene.animations);
}

fn written(scene: &Scene) -> (Vec<u8>, mocap::Export) {
    let written = Exporter::new().write(scene, Format::Vmd).unwrap();
    (written.clone().into_bytes().unwrap(), written)
}

fn positions(scene: &Scene, frame: f64) -> Vec<(String, Vec3)> {
    let pose = Pose::at_tick(scene, 0, frame).unwrap();
    let joints = scene.nodes.iter().zip(&pose.node_to_world);
    let bones = joints.filter(|(node, _)| node.face.is_none());
    bones
        .map(|(node, matrix)| (node.name.clone(), matrix.w_axis.truncate()))
        .collect()
}

/// Effects of the model itself, such as inherited rotations and IK, are not written into the motion.
#[test]
fn a_motion_on_its_model_comes_back() {
    let mut scene = Importer::new().import(MOTION).unwrap();
    let (bytes, said) = written(&scene);
    // The motion of the camera is not read.
    let camera = DataLoss::new(DataKind::Cameras, 1);
    assert_eq!((said.warnings.len(), &said.losses[..]), (1, &[camera][..]));
    let again = Importer::new().skeleton(MODEL).read(&bytes, "again.vmd").unwrap();
    assert!(again.warnings.is_empty(), "{:?}", again.warnings);
    assert_eq!(again.animations[0].duration, 59.0);
    for frame in [0.0, 7.0, 20.0, 33.0, 51.0, 59.0] {
        for ((name, ours), (_, theirs)) in positions(&again, frame).iter().zip(&positions(&scene, frame)) {
            assert!(ours.distance(*theirs) < 1e-3, "{name} at {frame}: {ours} {theirs}");
        }
    }
    let faces = |scene: &Scene| {
        scene
            .nodes
            .iter()
            .filter_map(|node| node.face.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(faces(&again), faces(&scene));
    // After a conversion to metres, the file is equal except for rounding.
    Conversion::new().apply(&mut scene).unwrap();
    let (metres, said) = written(&scene);
    assert!(
        said.warnings.len() == 1 && metres.len().abs_diff(bytes.len()) < 111 * 40,
        "{:?}",
        said.warnings
    );
    let metres = Importer::new().skeleton(MODEL).read(&metres, "metres.vmd").unwrap();
    for ((name, ours), (_, theirs)) in positions(&metres, 33.0).iter().zip(&positions(&again, 33.0)) {
        assert!(ours.distance(*theirs) < 1e-3, "{name}: {ours} {theirs}");
    }
}

/// A VMD stores 15 bytes of a name. If two bones share these bytes, one bone is written and the other is reported.
#[test]
fn bones_that_a_cut_name_cannot_tell_apart_are_told() {
    let mut scene = Importer::new().import(MOTION).unwrap();
    let [long, hair] = ["長い名前の骨の先", "髪"].map(|name| node(&scene, name));
    let longer = "長い名前の骨の先生";
    scene.nodes[hair].name = longer.to_owned();
    let (_, said) = written(&scene);
    let left_out = if long < hair {
        longer
    } else {
        scene.nodes[long].name.as_str()
    };
    let note = said.notes.iter().find(|note| note.contains("first 15 bytes"));
    assert!(
        note.is_some_and(|note| note.contains(&format!("\"{left_out}\""))),
        "{:?}",
        said.notes
    );
}

/// The largest angle between the limbs of two scenes, in degrees.
fn limbs_apart(ours: &Scene, theirs: &Scene, frames: &[f64]) -> f32 {
    use HumanoidBone as B;
    const LIMBS: [(B, B); 8] = [
        (B::LeftUpperArm, B::LeftLowerArm),
        (B::LeftLowerArm, B::LeftHand),
        (B::RightUpperArm, B::RightLowerArm),
        (B::RightLowerArm, B::RightHand),
        (B::LeftUpperLeg, B::LeftLowerLeg),
        (B::LeftLowerLeg, B::LeftFoot),
        (B::RightUpperLeg, B::RightLowerLeg),
        (B::RightLowerLeg, B::RightFoot),
    ];
    let directions = |scene: &Scene, frame: f64| {
        let pose = Pose::at_tick(scene, 0, frame * scene.animations[0].ticks_per_second).unwrap();
        let at = |bone: B| {
            let index = scene
                .nodes
                .iter()
                .position(|node| node.humanoid_bone == Some(bone))
                .unwrap();
            pose.node_to_world[index].w_axis.truncate()
        };
        LIMBS.map(|(from, to)| at(to) - at(from))
    };
    let apart = frames.iter().flat_map(|frame| {
        let pairs = directions(ours, *frame).into_iter().zip(directions(theirs, *frame));
        pairs.map(|(a, b)| a.angle_between(b).to_degrees())
    });
    apart.fold(0.0, f32::max)
}

/// On a model of our proportions, the limbs have the directions of the source's limbs, and the feet have the heights of
/// the source's feet.
#[test]
fn any_humanoid_is_written_for_the_usual_bones() {
    let mut walk = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    Conversion::new().apply(&mut walk).unwrap();
    let (bytes, said) = written(&walk);
    let lost = said
        .warnings
        .iter()
        .filter(|warning| warning.code == Code::NotCarriedOver);
    assert_eq!(said.warnings.len(), 1 + lost.count(), "{:?}", said.warnings);
    assert!(
        said.warnings[0]
            .help
            .as_deref()
            .unwrap()
            .contains("retarget INPUT MODEL.pmx")
    );
    // The source has 120 frames per second.
    assert!(
        said.losses.contains(&DataLoss::new(DataKind::FrameRates, 1)),
        "{:?}",
        said.losses
    );
    let mut again = Importer::new().read(&bytes, "walk.vmd").unwrap();
    Conversion::new().apply(&mut again).unwrap();
    let humanoid = vrm_humanoid(&walk, None).unwrap();
    let apart = limbs_apart(&again, &humanoid, &[0.0, 0.5, 1.0, 2.0, 3.0]);
    assert!(apart < 0.05, "{apart}");
    let lowest = |scene: &Scene| {
        let pose = Pose::at_tick(scene, 0, scene.animations[0].ticks_per_second).unwrap();
        let feet = scene.nodes.iter().zip(&pose.node_to_world);
        let is_foot =
            |bone: Option<HumanoidBone>| matches!(bone, Some(HumanoidBone::LeftFoot | HumanoidBone::RightFoot));
        let heights = feet
            .filter(|(node, _)| is_foot(node.humanoid_bone))
            .map(|(_, matrix)| matrix.w_axis.y);
        heights.fold(f32::MAX, f32::min)
    };
    assert!(
        (lowest(&again) - lowest(&humanoid)).abs() < 0.03,
        "{} {}",
        lowest(&again),
        lowest(&humanoid)
    );
    // A VMD alone does not contain the positions of joints.
    let error = mocap::verify::report::Verification::of(&walk, &bytes).unwrap_err();
    assert_eq!(error.code(), Code::Unrepresentable);
    // An arm is not a humanoid.
    let arm = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    assert!(Exporter::new().write(&arm, Format::Vmd).is_err());
}

/// A motion that is retargeted to a model is written for this model. The centre moves and the hips do not, as models
/// require.
#[test]
fn a_motion_is_retargeted_onto_a_model_and_written_for_it() {
    let mut walk = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    Conversion::new().frame_rate(30.0).apply(&mut walk).unwrap();
    let model = Importer::new().import(MODEL).unwrap();
    let mut retargeting = Retargeter::onto(model, RetargetOptions::new()).unwrap();
    retargeting.add(SourceMotion::converted(walk)).unwrap();
    let scene = retargeting.scene();
    let (bytes, said) = written(&scene);
    assert!(said.warnings.is_empty(), "{:?}", said.warnings);
    let again = Importer::new().skeleton(MODEL).read(&bytes, "walk.vmd").unwrap();
    let apart = limbs_apart(&again, &scene, &[0.0, 1.0, 2.0, 3.0]);
    // The twist bone of the arm only rotates about its own axis, which is 1.1 degrees off the arm in this model.
    assert!(apart < 0.5, "{apart}");
    let moves = |name: &str| {
        let index = node(&again, name);
        let channel = again.animations[0]
            .channels
            .iter()
            .find(|channel| channel.node.unwrap().index() == index)
            .unwrap();
        channel.position_keys.len() > 1
    };
    assert!(moves("センター") && !moves("下半身"));
}

/// A motion of these bones. Each rotates by half a turn about X in a second.
fn motion_of(bones: &[&str]) -> Vec<u8> {
    let mut bytes = [b"Vocaloid Motion Data 0002".as_slice(), &[0; 5], b"walker", &[0; 14]].concat();
    bytes.extend((2 * bones.len() as u32).to_le_bytes());
    for bone in bones {
        for (frame, rotation) in [(0_u32, [0.0_f32, 0.0, 0.0, 1.0]), (30, [1.0, 0.0, 0.0, 0.0])] {
            let mut name = bone.as_bytes().to_vec();
            name.resize(15, 0);
            bytes.extend(name);
            bytes.extend(frame.to_le_bytes());
            bytes.extend([0; 12]);
            bytes.extend(rotation.iter().flat_map(|number| number.to_le_bytes()));
            bytes.extend([20; 64]);
        }
    }
    bytes.extend([0; 4]);
    bytes
}

/// The reader refuses such a motion, instead of returning a figure that stands still.
#[test]
fn a_motion_of_bones_that_the_model_lacks_is_refused() {
    for bones in [&["Hips", "Spine", "L_Arm"][..], &["J_Bip_C_Hips"]] {
        let error = Importer::new().read(&motion_of(bones), "a.vmd").unwrap_err();
        assert_eq!(error.code(), Code::InvalidMmd);
        let message = error.to_string();
        assert!(message.contains(bones[0]) && message.contains("MODEL.pmx"), "{message}");
    }
    // If the model has one of the bones, the missing bones give a warning.
    let mut one = motion_of(&["Hips", "Spine"]);
    let head = b"\x93\xaa"; // 頭 in Shift-JIS
    for key in 0..2 {
        let at = 54 + 111 * key;
        one[at..at + 15].fill(0);
        one[at..at + 2].copy_from_slice(head);
    }
    let scene = Importer::new().read(&one, "a.vmd").unwrap();
    let left_out: Vec<_> = scene
        .warnings
        .iter()
        .filter_map(|warning| warning.joint.as_deref())
        .collect();
    assert_eq!(left_out, ["Spine"]);
}
