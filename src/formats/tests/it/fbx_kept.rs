//! FBX characters that are written with other clips, while everything else in the file stays. The test's own parser
//! compares the elements, and ufbx reads the motion.

use std::collections::BTreeMap;

use mocap::edit::{Reverse, Step, StepInput};
use mocap::fbx::{FbxOptions, FbxVersion};
use mocap::retarget::{RetargetOptions, Retargeter, Target};
use mocap::scene::NodeId;
use mocap::{Code, Importer, Scene};

/// An element: its name, the bytes of its values, and its children.
#[derive(Clone, Debug, PartialEq)]
struct Element {
    name: String,
    values: Vec<u8>,
    children: Vec<Element>,
}

impl Element {
    /// The elements of a list, up to its end or to an empty element.
    fn list(bytes: &[u8], at: &mut usize, end: usize, is_wide: bool) -> Vec<Self> {
        let mut found = Vec::new();
        while *at < end {
            let size = if is_wide { 8 } else { 4 };
            let number = |place: usize| {
                let mut wide = [0; 8];
                wide[..size].copy_from_slice(&bytes[*at + place * size..][..size]);
                u64::from_le_bytes(wide) as usize
            };
            let (own_end, length) = (number(0), number(2));
            let name = *at + 3 * size + 1;
            let values = name + usize::from(bytes[name - 1]);
            *at = values + length;
            if own_end == 0 {
                break;
            }
            found.push(Self {
                name: String::from_utf8(bytes[name..values].to_vec()).unwrap(),
                values: bytes[values..values + length].to_vec(),
                children: Self::list(bytes, at, own_end, is_wide),
            });
            assert_eq!(*at, own_end);
        }
        found
    }

    fn is_of_animation(&self) -> bool {
        self.name.starts_with("Animation")
    }

    fn id(&self) -> i64 {
        i64::from_le_bytes(self.values[1..9].try_into().unwrap())
    }

    /// The identifiers of the two connected objects. In the element, they follow the kind of the connection.
    fn ends(&self) -> [i64; 2] {
        [8, 17].map(|at| i64::from_le_bytes(self.values[at..at + 8].try_into().unwrap()))
    }
}

fn sections(bytes: &[u8]) -> BTreeMap<String, Vec<Element>> {
    let is_wide = u32::from_le_bytes(bytes[23..27].try_into().unwrap()) >= 7500;
    let list = Element::list(bytes, &mut 27, bytes.len(), is_wide);
    list.into_iter()
        .map(|section| (section.name, section.children))
        .collect()
}

/// Checks that the output has the objects and connections of the source, except animations unless `with_clips` is set.
fn expect_kept(source: &[u8], output: &[u8], with_clips: bool, clips: usize) {
    let [before, after] = [source, output].map(sections);
    let stays = |object: &&Element| with_clips || !object.is_of_animation();
    let own: Vec<&Element> = before["Objects"].iter().filter(stays).collect();
    let there: BTreeMap<i64, &Element> = after["Objects"].iter().map(|object| (object.id(), object)).collect();
    assert_eq!(there.len(), after["Objects"].len(), "ids are unique");
    for object in &own {
        assert_eq!(there.get(&object.id()), Some(object));
    }
    let ids: Vec<i64> = own.iter().map(|object| object.id()).chain([0]).collect();
    let is_own = |connection: &&Element| connection.ends().iter().all(|end| ids.contains(end));
    let connections: Vec<_> = before["Connections"].iter().filter(is_own).collect();
    let kept: Vec<_> = after["Connections"].iter().filter(is_own).collect();
    assert_eq!(connections, kept);
    let stacks = |objects: &[Element]| objects.iter().filter(|object| object.name == "AnimationStack").count();
    let own = if with_clips { stacks(&before["Objects"]) } else { 0 };
    assert_eq!(stacks(&after["Objects"]), own + clips);
    // The file states the right count of each kind of object.
    for kind in after["Definitions"].iter().filter(|kind| kind.name == "ObjectType") {
        let name = String::from_utf8(kind.values[5..].to_vec()).unwrap();
        let count = kind.children.iter().find(|below| below.name == "Count").unwrap();
        let count = i32::from_le_bytes(count.values[1..5].try_into().unwrap());
        if name.starts_with("Animation") {
            assert_eq!(
                count as usize,
                after["Objects"].iter().filter(|object| object.name == name).count(),
                "{name}"
            );
        }
    }
}

fn import(path: &str) -> (Scene, Vec<u8>) {
    let path = format!("../../fixtures/{path}");
    let scene = Importer::new().morph_targets(true).import(&path).unwrap();
    (scene, std::fs::read(path).unwrap())
}

/// The largest distance in metres of joints of the output's first clip from the scene.
fn farthest(scene: &Scene, output: &[u8]) -> f32 {
    let again = Importer::new().read(output, "a.fbx").unwrap();
    let clip = &scene.animations[0];
    let mut farthest = 0.0_f32;
    for tick in 0..clip.frame_count() {
        let tick = (tick as f64).min(clip.duration);
        let other = tick / clip.ticks_per_second * again.animations[0].ticks_per_second;
        let poses = [(scene, tick), (&again, other)].map(|(scene, tick)| mocap::Pose::at_tick(scene, 0, tick).unwrap());
        for node in (0..scene.nodes.len()).map(NodeId::new) {
            let apart = poses[0].position(node).distance(poses[1].position(node));
            farthest = farthest.max(apart);
        }
    }
    farthest
}

#[test]
fn a_converted_file_is_the_file_with_the_clips_of_the_scene() {
    for path in [
        "real/animation_with_skeleton.fbx",
        "real/huesitos.fbx",
        "made/six_influences.fbx",
    ] {
        let (mut scene, source) = import(path);
        Reverse::new().apply(&mut scene, &StepInput::new()).unwrap();
        let (output, report) = FbxOptions::default().write(&scene).unwrap();
        assert!(
            report.is_kept && report.warnings.is_empty(),
            "{path}: {:?}",
            report.warnings
        );
        expect_kept(&source, &output, false, scene.animations.len());
        let apart = farthest(&scene, &output);
        assert!(apart < 1e-4, "{path}: {apart}");
        // A written file is kept again.
        let again = Importer::new().read(&output, "a.fbx").unwrap();
        assert!(FbxOptions::default().write(&again).unwrap().1.is_kept, "{path}");
    }
}

#[test]
fn a_character_gets_a_clip_and_keeps_its_own() {
    let (hero, source) = import("characters/arnaud.fbx");
    let walk = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let retargeted = Retargeter::new(walk, Target::from(hero), RetargetOptions::new()).unwrap();
    let scene = retargeted.scene_in_metres().unwrap();
    let (output, report) = FbxOptions::default().write(&scene).unwrap();
    assert!(report.is_kept, "{:?}", report.warnings);
    expect_kept(&source, &output, true, 1);
    let apart = farthest(&scene, &output);
    assert!(apart < 1e-4, "{apart}");
}

#[test]
fn a_file_that_cannot_take_a_clip_is_written_anew_and_says_why() {
    let (mut scene, _) = import("real/huesitos.fbx");
    let last = scene.nodes.len() - 1;
    scene.nodes[last].name = "another".to_owned();
    let (_, report) = FbxOptions::default().write(&scene).unwrap();
    let warning = &report.warnings[0];
    assert!(!report.is_kept && warning.code == Code::NotCarriedOver);
    assert!(
        warning.message.contains("the joint \"another\" has changed"),
        "{warning:?}"
    );
    // Requested conventions need no reason.
    let (scene, _) = import("real/huesitos.fbx");
    let (_, report) = FbxOptions::default().version(FbxVersion::V7400).write(&scene).unwrap();
    assert!(!report.is_kept && report.warnings.is_empty());
}

#[test]
fn broken_files_are_not_kept_and_do_not_panic() {
    let (scene, source) = import("real/huesitos.fbx");
    let mut seed = 7_u32;
    for _ in 0..60 {
        let mut bytes = source.clone();
        for _ in 0..4 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let at = 27 + seed as usize % (bytes.len() - 27);
            bytes[at] ^= (seed >> 24) as u8 | 1;
        }
        let mut broken = scene.clone();
        broken.metadata.fbx.as_mut().unwrap().bytes = bytes.into();
        drop(FbxOptions::default().write(&broken));
    }
    let mut cut = scene.clone();
    cut.metadata.fbx.as_mut().unwrap().bytes = source[..source.len() / 2].into();
    let (_, report) = FbxOptions::default().write(&cut).unwrap();
    assert!(!report.is_kept && report.warnings.len() == 1);
}
