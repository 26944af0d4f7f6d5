//! `mocap index`, `mocap find` and `mocap match`: features, the file of a database, what is found across skeletons, and
//! how a figure follows a path.

use mocap::convert::Moment;
use mocap::edit::{Mirror, Step, StepInput};
use mocap::figure::{Figure, HumanoidBone as Bone};
use mocap::glam::{Vec2, Vec3};
use mocap::matching::{Controller, Database, FindOptions, Found, IndexedClip, Moves, Query};
use mocap::retargeting::{Retargeting, RetargetingOptions};
use mocap::scene::Animation;
use mocap::{Code, Conversion, Pose, Scene};
use sha2::{Digest, Sha256};

use crate::program::Folder;

const WALK: &str = "cmu_12_01_walk.bvh";

fn import(name: &str) -> Scene {
    mocap::import(format!("fixtures/real/{name}")).unwrap()
}

fn indexed(scene: &Scene) -> IndexedClip {
    IndexedClip::of(scene, "a.bvh", false).remove(0)
}

/// The walk on the skeleton of another file.
fn on_another(skeleton: &str) -> Scene {
    let moved = Retargeting::new(import(WALK), import(skeleton), RetargetingOptions::new()).unwrap();
    let mut scene = moved.target().scene().into_owned();
    scene.animations = vec![moved.clips()[0].animation.clone()];
    scene
}

fn vector(features: &[f32], at: usize) -> Vec3 {
    Vec3::from_slice(&features[at..])
}

/// Lengths that do not depend on where the root looks, from the joints themselves.
#[test]
fn features_are_those_of_the_joints() {
    let scene = import(WALK);
    let clip = indexed(&scene);
    let figure = Figure::new(&scene);
    let joint = |bone| figure.humanoid.joint(bone).unwrap();
    let scale = figure.survey.metres_per_unit as f32 * 0.87 / clip.leg;
    let rate = scene.animations[0].ticks_per_second;
    let positions = |seconds: f64| {
        let pose = Pose::at_tick(&scene, 0, seconds * rate).unwrap();
        [Bone::LeftFoot, Bone::RightFoot, Bone::Hips].map(|bone| scale * pose.position(joint(bone)))
    };
    for (frame, features) in clip.features().iter().enumerate().skip(1).step_by(37).take(6) {
        let at = |frames: f64| positions(clip.begin + (frame as f64 + frames) / 60.0);
        let [left, right, _] = at(0.0);
        let close = |found: f32, expected: f32| {
            assert!(
                (found - expected).abs() < 0.01 * expected.max(0.1),
                "{frame}: {found} {expected}"
            );
        };
        close(vector(features, 0).distance(vector(features, 3)), left.distance(right));
        close(features[1] - features[4], left.y - right.y);
        let (before, after) = (at(-1.0), at(1.0));
        for (body, place) in [6, 9, 12].into_iter().enumerate() {
            close(
                vector(features, place).length(),
                30.0 * after[body].distance(before[body]),
            );
        }
        // It walks straight on: it is before itself, and looks there.
        assert!(
            features[20] > features[18] && features[18] > features[16] && features[16] > 0.2,
            "{features:?}"
        );
        assert!(
            (21..27).step_by(2).all(|sideways| features[sideways].abs() < 0.3),
            "{features:?}"
        );
    }
    let stands = |bits: u8| {
        clip.contacts()
            .iter()
            .any(|contacts| contacts & 15 == contacts & bits && contacts & bits != 0)
    };
    assert!(stands(0b0101) && stands(0b1010));
}

#[test]
fn features_are_nearly_those_of_another_body() {
    let (own, other) = (indexed(&import(WALK)), indexed(&on_another("rokoko_dance.bvh")));
    let pairs = own.features().iter().zip(other.features());
    let (mut sums, mut count) = ([0.0; 27], 0.0);
    for (a, b) in pairs {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += (a - b).abs();
        }
        count += 1.0;
    }
    // Metres and metres a second on one body: feet, hips and trajectory of a walk of 1.2 m/s.
    for (place, sum) in sums.iter().enumerate() {
        assert!(sum / count < 0.12, "{place}: {}", sum / count);
    }
}

#[test]
fn a_mirrored_clip_is_that_of_the_mirrored_motion() {
    let mut scene = import("rokoko_dance.bvh");
    let plain = indexed(&scene);
    let own = plain.mirror();
    Mirror::new().apply(&mut scene, &StepInput::new()).unwrap();
    let other = indexed(&scene);
    assert_eq!(own.begin, other.begin);
    let difference = |a: &IndexedClip, b: &IndexedClip| {
        let pairs = a.features().iter().flatten().zip(b.features().iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    assert!(difference(&own, &other) < 0.05, "{}", difference(&own, &other));
    assert!(difference(&plain, &other) > 1.0);
    assert_eq!(own.mirror(), plain);
}

fn best(database: &Database, scene: &Scene, part: &str) -> Found {
    let query = Query::part(scene, 0, part.parse().unwrap()).unwrap();
    database.find(&query, &FindOptions::new()).remove(0)
}

#[test]
fn a_part_is_found_on_other_skeletons_mirrored_and_slower() {
    let walk = import(WALK);
    let database = Database::new(
        [WALK, "rokoko_dance.bvh", "mocopi_jump_six_channels.bvh", "run.fbx"]
            .iter()
            .flat_map(|file| IndexedClip::of(&import(file), file, false))
            .collect(),
    );
    let is_there = |found: &Found, first: f64| {
        assert!(found.file == WALK && (found.first - first).abs() < 0.16, "{found:?}");
    };
    let on_dancer = on_another("rokoko_dance.bvh");
    is_there(&best(&database, &on_dancer, "1..2.5"), 1.0);
    let mut mirrored = walk.clone();
    Mirror::new().apply(&mut mirrored, &StepInput::new()).unwrap();
    let found = best(&database, &mirrored, "1..2.5");
    is_there(&found, 1.0);
    assert!(found.mirrored);
    let mut slower = walk.clone();
    slower.animations[0].ticks_per_second /= 1.15;
    let found = best(&database, &slower, "1.15..2.875");
    is_there(&found, 1.0);
    assert!(
        (found.pace - 1.0 / 1.15).abs() < 0.06 || (found.pace - 1.15).abs() < 0.06,
        "{found:?}"
    );
    let pose = Query::pose(&on_dancer, 0, Moment::Seconds(2.0)).unwrap();
    let found = database.find(&pose, &FindOptions::new().count(3));
    assert!(found.iter().any(|found| found.file == WALK), "{found:?}");
    let none = FindOptions::new().condition("running > 2".parse::<mocap::survey::Condition>().unwrap());
    assert!(database.find(&pose, &none).is_empty());
}

#[test]
fn a_part_that_is_not_there_is_an_error() {
    let scene = import("cmu_short.bvh");
    for part in ["90..91", "9000f.."] {
        let error = Query::part(&scene, 0, part.parse().unwrap()).unwrap_err();
        assert_eq!(error.code(), Code::InvalidValue, "{part}");
    }
    assert_eq!(
        Query::pose(&scene, 1, Moment::Frame(0)).unwrap_err().code(),
        Code::NoMotion
    );
    let hand = import("leap_hand_end_site_lowercase.bvh");
    assert_eq!(
        Query::pose(&hand, 0, Moment::Frame(0)).unwrap_err().code(),
        Code::NotHumanoid
    );
}

/// Bytes with another checksum, so that what is behind it is tried.
fn resealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len() - 32;
    let hash = Sha256::digest(&bytes[..end]);
    bytes[end..].copy_from_slice(&hash);
    bytes
}

#[test]
fn a_damaged_database_is_an_error() {
    let bytes = Database::new(IndexedClip::of(&import("cmu_short.bvh"), "a.bvh", true)).to_bytes();
    let again = Database::read(&bytes[..]).unwrap();
    assert_eq!(again.to_bytes(), bytes);
    for end in (0..bytes.len()).step_by(211).chain(bytes.len() - 40..bytes.len()) {
        assert!(Database::read(&bytes[..end]).is_err(), "{end}");
    }
    for at in (0..bytes.len()).step_by(97) {
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << (at % 8);
        assert!(Database::read(&flipped[..]).is_err(), "{at}");
        // With a checksum that is right it is another database, or an error.
        if let Ok(database) = Database::read(&resealed(flipped)[..]) {
            assert!(database.features().flatten().all(|value| value.is_finite()));
        }
    }
    let with = |from: &str, to: &str| {
        let text = bytes
            .windows(from.len())
            .position(|window| window == from.as_bytes())
            .unwrap();
        let mut changed = bytes.clone();
        changed[text..text + from.len()].copy_from_slice(to.as_bytes());
        Database::read(&resealed(changed)[..]).unwrap_err().code()
    };
    // The list says how many frames there are; JSON allows a number of any length.
    assert_eq!(
        with(",\"mirrored\":false", ",\"mirrored\":9e999"),
        Code::InvalidDatabase
    );
    let mut counts = bytes.clone();
    counts[16..24].copy_from_slice(&u64::MAX.to_le_bytes());
    assert_eq!(Database::read(&counts[..]).unwrap_err().code(), Code::LimitExceeded);
    counts[16..24].copy_from_slice(&(1u64 << 27).to_le_bytes());
    assert_eq!(Database::read(&counts[..]).unwrap_err().code(), Code::UnexpectedEnd);
    let more: Vec<u8> = bytes.iter().copied().chain([0]).collect();
    assert_eq!(Database::read(&more[..]).unwrap_err().code(), Code::InvalidDatabase);
}

#[test]
fn the_commands_index_and_find() {
    let folder = Folder::of_real(&[WALK, "cmu_short.bvh", "lecture_Test.bvh"]);
    folder.ends_with(3, "index . -o moves.mdb");
    let first = folder.read("moves.mdb");
    // The same files give the same bytes, and an unchanged file is not read again.
    folder.ends_with(3, "index . -o moves.mdb --resume");
    assert_eq!(folder.read("moves.mdb"), first);
    folder.succeeds(&format!("index {WALK} -o walk.mdb"));
    folder.succeeds("index cmu_short.bvh -o short.mdb");
    folder.succeeds("index walk.mdb short.mdb -o both.mdb");
    let both = Database::read(&folder.read("both.mdb")[..]).unwrap();
    assert_eq!(both.clips().len(), 2);
    let output = folder.run(&format!("find moves.mdb --like {WALK}@1.0s..2.0s --json -n 3"));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(found[0]["distance"].as_f64().unwrap() < 0.02, "{found}");
    assert_eq!(found[0]["mirrored"], false);
    assert!(found.as_array().unwrap().len() <= 3);
    let table = folder.run(&format!("find moves.mdb --pose {WALK}@1s --where seconds>3 -n 2"));
    let table = String::from_utf8(table.stdout).unwrap();
    assert!(table.starts_with("distance  second") && table.contains(WALK), "{table}");
    // Somebody's database of another program stays.
    folder.write("theirs.mdb", b"\0\x01\0\0Standard Jet DB\0 and the tables of an office");
    folder.refuses(&format!("index {WALK} -o theirs.mdb"), 1, "--force");
    folder.succeeds(&format!("index {WALK} -o theirs.mdb --force"));
    folder.refuses("find cmu_short.bvh --pose cmu_short.bvh@0", 1, "mocapMDB");
    folder.refuses(&format!("find moves.mdb --like {WALK}@1m..2m"), 2, "A..B");
    folder.refuses("find moves.mdb", 2, "--like");
    folder.refuses("index moves.mdb -o moves.mdb", 1, "input");
    folder.refuses(&format!("index {WALK} -o moves.xyz"), 2, ".mdb");
    folder.refuses(&format!("index {WALK} -o moves.mdb --resume --where x"), 2, "--where");
}

/// The walk and its mirror image on the dancer's skeleton.
fn matched() -> (Database, Moves, Scene) {
    let walk = import(WALK);
    let database = Database::new(IndexedClip::of(&walk, WALK, true));
    let mut hero = import("rokoko_dance.bvh");
    Conversion::new().apply(&mut hero).unwrap();
    hero.animations.clear();
    let clips = Retargeting::new(walk, hero.clone(), RetargetingOptions::new())
        .unwrap()
        .into_clips();
    let mut moves = Moves::new(&hero).unwrap();
    for clip in database.clips() {
        moves.add(clip, &clips[0].animation).unwrap();
    }
    hero.animations = vec![clips[0].animation.clone()];
    (database, moves, hero)
}

/// How far any joint goes at most in a sixtieth of a second.
fn fastest(scene: &Scene, animation: &Animation) -> f32 {
    let scene = Scene {
        animations: vec![animation.clone()],
        ..scene.clone()
    };
    let step = animation.ticks_per_second / 60.0;
    let count = (animation.duration / step) as usize;
    let pose = |frame: usize| Pose::at_tick(&scene, 0, frame as f64 * step).unwrap();
    let mut fastest = 0.0_f32;
    let mut before = pose(0);
    for frame in 1..count {
        let now = pose(frame);
        let nodes = (0..scene.nodes.len()).map(mocap::scene::NodeId::new);
        fastest = nodes.fold(fastest, |fastest, node| {
            fastest.max(now.position(node).distance(before.position(node)))
        });
        before = now;
    }
    fastest
}

#[test]
fn a_figure_follows_a_path() {
    let (database, moves, hero) = matched();
    let path = [Vec2::new(1.0, -1.0), Vec2::new(1.0, 4.0)];
    let start = Vec3::new(1.0, 0.0, -1.0);
    let mut controller = Controller::new(&database, moves.clone(), start, Vec3::Z).unwrap();
    let (animation, followed) = controller.follow(&hero, &path, 1.0).unwrap();
    assert!(followed.has_arrived && followed.jumps > 0, "{followed:?}");
    assert!(followed.largest_distance < 0.2, "{followed:?}");
    // It walks no longer than the path and its speed take.
    assert!((200..600).contains(&followed.frames), "{followed:?}");
    // Where the motion goes on elsewhere, no joint is much faster than in the walk.
    let (own, source) = (fastest(&hero, &animation), fastest(&hero, &hero.animations[0]));
    assert!(own < 1.5 * source, "{own} {source}");
    let error = Controller::new(&Database::default(), moves.clone(), start, Vec3::Z).unwrap_err();
    assert_eq!(error.code(), Code::InvalidValue);
    assert!(Controller::new(&database, moves, start, Vec3::Y).is_err());
    for (path, speed) in [
        (&path[..1], 1.0),
        (&path[..], 0.0),
        (&path[..], f32::NAN),
        (&path[..], 1e-6),
    ] {
        let error = controller.follow(&hero, path, speed).unwrap_err();
        assert_eq!(error.code(), Code::InvalidValue, "{speed}");
    }
}

#[test]
fn the_command_matches() {
    let folder = Folder::of_real(&[WALK, "biovision_example1.bvh"]);
    folder.succeeds(&format!("index {WALK} -o moves.mdb --mirror"));
    folder.succeeds("match moves.mdb --path 0/0+0/2 --on biovision_example1.bvh -o out.glb");
    let scene = mocap::import(folder.path("out.glb")).unwrap();
    assert_eq!(scene.animations.len(), 1);
    let said = folder.run("match moves.mdb --path 0/0+0/1 --on biovision_example1.bvh -o out.bvh --json -q");
    let followed: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
    assert_eq!(followed["has_arrived"], true);
    folder.refuses(
        "match moves.mdb --path 0/0 --on biovision_example1.bvh -o out.glb",
        2,
        "X/Z",
    );
    folder.refuses("match moves.mdb --path 0/0+0/2 --on none.bvh -o out.glb", 1, "none.bvh");
    folder.refuses(
        "match moves.mdb --path 0/0+0/2 --on biovision_example1.bvh -o biovision_example1.bvh",
        1,
        "input",
    );
    // The clips that the database names are inputs too.
    folder.refuses(
        &format!("match moves.mdb --path 0/0+0/2 --on biovision_example1.bvh -o {WALK} --force"),
        1,
        "input",
    );
    let text = String::from_utf8(folder.read(WALK)).unwrap();
    folder.write(WALK, text.replace(".0083333", ".0083").as_bytes());
    folder.refuses(
        "match moves.mdb --path 0/0+0/2 --on biovision_example1.bvh -o out.glb",
        1,
        "changed since it was indexed",
    );
}
