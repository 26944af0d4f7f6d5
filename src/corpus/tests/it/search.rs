//! Search and motion matching: features, the file of a database, matches across skeletons, and a figure that follows a
//! path.

use mocap::convert::Moment;
use mocap::edit::{Mirror, Step, StepInput};
use mocap::figure::{Figure, HumanoidBone as Bone};
use mocap::glam::{Mat4, Vec2, Vec3};
use mocap::matching::report::Match;
use mocap::matching::{Controller, Database, FeatureTree, FindOptions, Gamepad, IndexedClip, Moves, Query, Trajectory};
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::{Animation, NodeId};
use mocap::{Code, Conversion, Pose, Scene};
use sha2::{Digest, Sha256};

const WALK: &str = "cmu_12_01_walk.bvh";

fn import(name: &str) -> Scene {
    mocap::import(format!("../../fixtures/real/{name}")).unwrap()
}

fn indexed(scene: &Scene) -> IndexedClip {
    IndexedClip::of(scene, "a.bvh", false).remove(0)
}

/// The walk, retargeted to the skeleton of another file.
fn on_another(skeleton: &str) -> Scene {
    let moved = Retargeter::new(import(WALK), import(skeleton), RetargetOptions::new()).unwrap();
    let mut scene = moved.target().scene().into_owned();
    scene.animations = vec![moved.clips()[0].animation.clone()];
    scene
}

fn vector(features: &[f32], at: usize) -> Vec3 {
    Vec3::from_slice(&features[at..])
}

/// Compares features with lengths computed from the joints. The lengths do not depend on the facing of the root.
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
        // The figure walks straight ahead: its future positions are in front, and it faces forward.
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
    // In m and m/s: feet, hips and trajectory of a walk at 1.2 m/s.
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

fn best(database: &Database, scene: &Scene, part: &str) -> Match {
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
    let is_there = |found: &Match, first: f64| {
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

/// The bytes with a corrected checksum, so that the reader checks the contents.
fn resealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len() - 32;
    let hash = Sha256::digest(&bytes[..end]);
    bytes[end..].copy_from_slice(&hash);
    bytes
}

#[test]
fn a_damaged_database_is_an_error() {
    let bytes = Database::new(IndexedClip::packed(&import("cmu_short.bvh"), "a.bvh", true).unwrap()).to_bytes();
    let again = Database::read(&bytes[..]).unwrap();
    assert_eq!(again.to_bytes(), bytes);
    let hero = metres("rokoko_dance.bvh");
    for end in (0..bytes.len()).step_by(211).chain(bytes.len() - 40..bytes.len()) {
        assert!(Database::read(&bytes[..end]).is_err(), "{end}");
    }
    for at in (0..bytes.len()).step_by(97) {
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << (at % 8);
        assert!(Database::read(&flipped[..]).is_err(), "{at}");
        // With a correct checksum, the result is another database or an error.
        if let Ok(database) = Database::read(&resealed(flipped)[..]) {
            assert!(database.features().flatten().all(|value| value.is_finite()));
            if at % 5 == 0 {
                // A damaged packed clip is an error or another motion.
                let moves = Moves::of(&database, &hero, |_| Ok(Scene::default()));
                moves
                    .ok()
                    .map(|moves| Controller::new(&database, moves, Vec3::ZERO, Vec3::Z));
            }
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
    // The list states the number of frames. A JSON number can have any length.
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

/// Copies of a take, such as a part or a mirror image, are one match. Another walk is another match.
#[test]
fn copies_of_a_take_are_found_once() {
    let walk = import(WALK);
    let part = |first: f64, last: f64| {
        let mut scene = walk.clone();
        scene.trim(first, last);
        scene
    };
    let mut mirrored = walk.clone();
    Mirror::new().apply(&mut mirrored, &StepInput::new()).unwrap();
    let copies = [walk.clone(), part(60.0, 400.0), mirrored];
    let other = import("motionbuilder_vicon_walk.bvh");
    let clips = copies.iter().chain([&other]).enumerate().flat_map(|(number, scene)| {
        let mut scene = scene.clone();
        scene.metadata.origin = None;
        IndexedClip::of(&scene, &format!("{number}.bvh"), false)
    });
    let database = Database::new(clips.collect());
    let query = Query::part(&walk, 0, "1..2".parse().unwrap()).unwrap();
    let found = database.find(&query, &FindOptions::new());
    let files: Vec<&str> = found.iter().map(|found| found.file.as_str()).collect();
    // The whole take and its part contain the same moment of the motion.
    assert!(["0.bvh", "1.bvh"].contains(&files[0]), "{files:?}");
    assert_eq!(files[1..], ["3.bvh"]);
    let all = database.find(&query, &FindOptions::new().per_clip(None).count(5));
    assert!(all[..3].iter().all(|found| found.file != "3.bvh"), "{all:?}");
}

/// A file in metres with +Y up, without its motion.
fn metres(name: &str) -> Scene {
    let mut scene = import(name);
    Conversion::new().apply(&mut scene).unwrap();
    scene.animations.clear();
    scene
}

/// The walk and its mirror image on the dancer's skeleton.
fn matched() -> (Database, Moves, Scene) {
    matched_of(&[WALK])
}

/// The motions of `files` and their mirror images, retargeted to the dancer's skeleton.
fn matched_of(files: &[&str]) -> (Database, Moves, Scene) {
    let mut hero = metres("rokoko_dance.bvh");
    let mut moves = Moves::new(&hero).unwrap();
    let (mut indexed, mut animations) = (Vec::new(), Vec::new());
    for file in files {
        let scene = import(file);
        let of_file = IndexedClip::of(&scene, file, true);
        let retargeting = Retargeter::new(scene, hero.clone(), RetargetOptions::new()).unwrap();
        let animation = retargeting.into_clips().remove(0).animation;
        for clip in &of_file {
            moves.add(clip, &animation).unwrap();
        }
        indexed.extend(of_file);
        animations.push(animation);
    }
    hero.animations = vec![animations.remove(0)];
    (Database::new(indexed), moves, hero)
}

/// The largest distance that a joint moves in 1/60 s.
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
    // The walk takes about the time of the path at the wanted speed.
    assert!((200..600).contains(&followed.frames), "{followed:?}");
    // At a jump, no joint is much faster than in the walk.
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
fn motions_that_are_packed_within_move_as_those_of_their_files() {
    let (by_reference, _, _) = matched();
    let hero = metres("rokoko_dance.bvh");
    let moves = Moves::of(&by_reference, &hero, |_| Ok(import(WALK))).unwrap();
    let database = Database::new(IndexedClip::packed(&import(WALK), WALK, true).unwrap());
    assert!(database.clips()[0].is_packed() && !by_reference.clips()[0].is_packed());
    // Features do not depend on whether the database has the motion.
    assert!(database.features().eq(by_reference.features()));
    let database = Database::read(&database.to_bytes()[..]).unwrap();
    // On its own body, a packed motion is within 0.1 mm of the original.
    let (mut own, motion) = (import(WALK), database.clips()[0].motion().unwrap());
    Conversion::new().apply(&mut own).unwrap();
    for frame in (0..=own.animations[0].duration as usize).step_by(7) {
        let [own_pose, pose] = [&own, &motion].map(|scene| Pose::at_tick(scene, 0, frame as f64).unwrap());
        for (index, node) in own.nodes.iter().enumerate() {
            let Some(other) = motion.find_node(&node.name) else {
                continue;
            };
            let apart = own_pose.position(NodeId::new(index)).distance(pose.position(other));
            assert!(apart < 1.1e-4, "frame {frame}, {}: {apart}", node.name);
        }
    }
    let packed = Moves::of(&database, &hero, |file| panic!("{file} is within")).unwrap();
    let again = Moves::of(&by_reference, &hero, |_| Ok(import(WALK))).unwrap();
    let figure = |database: &Database, moves| Controller::new(database, moves, Vec3::ZERO, Vec3::Z).unwrap();
    let mut others = [figure(&by_reference, moves), figure(&by_reference, again)];
    let mut figure = figure(&database, packed);
    let mut alike = 0;
    for _ in 0..200 {
        for figure in others.iter_mut().chain([&mut figure]) {
            figure.steer(Vec2::new(0.0, 1.2), Vec2::ZERO);
        }
        // If two frames are almost equally near, 0.1 mm can decide between them.
        let at = |figure: &Controller| (figure.frame(), figure.jumps());
        assert_eq!(at(&others[0]), at(&others[1]));
        if at(&figure) != at(&others[0]) {
            break;
        }
        alike += 1;
        assert_eq!(others[0].pose().node_to_world, others[1].pose().node_to_world);
    }
    assert!(alike > 30, "{alike}");
    let other = Moves::of(&by_reference, &hero, |_| Ok(import("cmu_short.bvh"))).unwrap_err();
    assert_eq!(other.code(), Code::InvalidDatabase);
    assert_eq!(by_reference.clips()[0].motion().unwrap_err().code(), Code::NoMotion);
}

/// Compares the distance that the left stick asks for with the distance that the figure walks.
#[test]
fn a_figure_does_what_a_gamepad_asks_for() {
    let (database, moves, hero) = matched();
    let gamepad = Gamepad::parse("seconds;left_x;left_y;right_x;right_y\n0;0;1;0;0\n4;0;0;0;0\n6;0;0;0;0\n").unwrap();
    let mut figure = Controller::new(&database, moves.clone(), Vec3::ZERO, Vec3::Z).unwrap();
    let (animation, played) = figure.play(&hero, &gamepad, 1.2).unwrap();
    assert_eq!((played.frames, animation.frame_count()), (361, 361));
    // Four seconds at 1.2 m/s. The spring needs as long to stop as to start.
    assert!((played.wanted_distance - 4.8).abs() < 0.05, "{played:?}");
    assert!(
        figure.position().z > 3.0 && figure.position().x.abs() < 0.5,
        "{played:?}"
    );
    assert!(
        played.mean_velocity_error < 0.5 && played.mean_angle < 15.0,
        "{played:?}"
    );
    // Seen from behind, right is -X of the world.
    let right = Gamepad::parse(
        "[{\"seconds\": 0, \"left_x\": 1, \"left_y\": 0}, {\"seconds\": 4, \"left_x\": 1, \"left_y\": 0}]",
    );
    let mut figure = Controller::new(&database, moves.clone(), Vec3::ZERO, Vec3::Z).unwrap();
    figure.play(&hero, &right.unwrap(), 1.2).unwrap();
    assert!(figure.position().x < -0.5, "{}", figure.position());
    for speed in [0.0, -1.0, f32::NAN, 1e30] {
        assert_eq!(
            figure.play(&hero, &gamepad, speed).unwrap_err().code(),
            Code::InvalidValue
        );
    }
    // Values that no stick can have do no harm.
    for velocity in [Vec2::NAN, Vec2::splat(f32::INFINITY), Vec2::splat(1e38)] {
        figure.steer(velocity, velocity);
        let far = Trajectory::new([Vec3::splat(velocity.x); 3], [Vec3::splat(velocity.y); 3]);
        figure.update(&far);
    }
    assert!(figure.pose().node_to_world.iter().all(Mat4::is_finite));
}

/// In the walk, the figure never stands still. In the jump, the man stands still before and after he jumps.
#[test]
fn a_figure_that_is_let_go_stops() {
    let (database, moves, hero) = matched_of(&[WALK, "mocopi_jump_six_channels.bvh"]);
    // Release the stick at different frames of a step.
    for frames in [150, 161, 172, 183, 194] {
        let mut figure = Controller::new(&database, moves.clone(), Vec3::ZERO, Vec3::Z).unwrap();
        for _ in 0..frames {
            figure.steer(Vec2::new(0.0, 1.2), Vec2::ZERO);
        }
        let let_go = figure.position();
        assert!(let_go.z > 1.5, "{let_go}");
        let mut stands_since = 0;
        for frame in 0..300 {
            let before = figure.position();
            figure.steer(Vec2::ZERO, Vec2::ZERO);
            // The figure still moves by more than 5 cm/s.
            if before.distance(figure.position()) > 0.05 / 60.0 {
                stands_since = frame + 1;
            }
        }
        let gone = let_go.distance(figure.position());
        // The shown body stops too, not only the root: the hips stay in place for a second.
        let hips = hero.find_node("Hips").unwrap();
        let shown = figure.pose().position(hips);
        (0..60).for_each(|_| figure.steer(Vec2::ZERO, Vec2::ZERO));
        let swayed = shown.distance(figure.pose().position(hips));
        assert!(swayed < 0.05, "after {frames}: {swayed}");
        assert!(
            stands_since <= 90 && gone < 0.6,
            "after {frames}: {stands_since}, {gone}"
        );
    }
}

#[test]
fn sticks_that_are_none_are_an_error() {
    for (text, why) in [
        ("", "missing"),
        ("seconds,left_x,left_y\n", "no row"),
        ("seconds,left_x\n0,1\n", "no left_y"),
        ("seconds,left_x,left_y,a\n0,1,0,0\n", "found a"),
        ("seconds,left_x,left_y,left_y\n0,1,0,0\n", "twice"),
        ("seconds,left_x,left_y\n0,1\n", "line 2 has 2 cells"),
        ("seconds,left_x,left_y\n0,0,0\n\n1,up,0\n", "line 4, left_x"),
        (
            "seconds,left_x,left_y\n0,0,0\n1,0,1.5\n",
            "line 3, left_y; expected -1 to 1; found 1.5",
        ),
        ("seconds,left_x,left_y\n0,0,0\n1,0,NaN\n", "line 3, left_y"),
        ("seconds,left_x,left_y\n1,0,0\n1,0,0\n", "line 3, seconds"),
        ("seconds,left_x,left_y\n0,0,0\n1e30,0,0\n", "line 3, seconds"),
        ("seconds,left_x,left_y\n0,0,0\n", "after 0 seconds"),
        ("[", "its list"),
        ("[{\"seconds\": 1, \"left_x\": 0}]", "left_y"),
        (
            "[{\"seconds\": 1, \"left_x\": 0, \"left_y\": 0, \"a\": 0}]",
            "unknown field",
        ),
        ("[{\"seconds\": 1, \"left_x\": 2, \"left_y\": 0}]", "row 1, left_x"),
    ] {
        let error = Gamepad::parse(text).unwrap_err();
        assert_eq!(error.code(), Code::InvalidArrays);
        assert!(error.to_string().contains(why), "{text:?}: {error}");
    }
}

/// The search returns any frame except the last third of a second of each clip.
#[test]
fn the_nearest_frame_is_that_of_a_plain_search() {
    let files = [WALK, "cmu_short.bvh", "z_up_dab.bvh", "mocopi_jump_six_channels.bvh"];
    let clips = files.iter().flat_map(|file| IndexedClip::of(&import(file), file, true));
    let database = Database::new(clips.collect());
    let tree = FeatureTree::new(&database);
    let mut candidates = Vec::new();
    let mut frame = 0;
    for clip in database.clips() {
        let count = clip.features().len();
        let found = clip.features().iter().take(count.saturating_sub(20)).enumerate();
        candidates.extend(found.map(|(index, features)| (frame + index, tree.normalized(features))));
        frame += count;
    }
    let all: Vec<[f32; 27]> = database.features().copied().collect();
    for (number, row) in all.iter().enumerate().step_by(41) {
        // The feet of one frame, with the trajectory of another frame.
        let mut query = *row;
        query[15..].copy_from_slice(&all[(7 * number + 300) % all.len()][15..]);
        let query = tree.normalized(&query);
        let except = number.saturating_sub(20)..number + 21;
        let distance = |row: &[f32; 27]| row.iter().zip(&query).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
        let others = candidates.iter().filter(|(frame, _)| !except.contains(frame));
        let nearest = others.map(|(_, row)| distance(row)).fold(f32::INFINITY, f32::min);
        let (found, squared) = tree.nearest(&query, f32::INFINITY, except.clone()).unwrap();
        assert!(
            (squared - nearest).abs() <= 1e-5 * nearest,
            "{number}: {squared} {nearest}"
        );
        let found = candidates.iter().find(|(frame, _)| *frame == found).unwrap();
        assert!((distance(&found.1) - squared).abs() <= 1e-5 * squared);
        assert_eq!(tree.nearest(&query, 0.99 * nearest, except), None);
    }
}
