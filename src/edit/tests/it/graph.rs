//! Tests of motion graphs: distances of windows, transitions, the largest component, and walks. `tools/graph/check`
//! verifies them with NumPy and SciPy.

mod bound;
mod near;

use std::collections::BTreeSet;

use mocap::edit::{Step, StepInput, Trim, Turn};
use mocap::glam::Vec3;
use mocap::graph::report::Walk;
use mocap::graph::{GraphBuilder, GraphOptions, MotionGraph};
use mocap::scene::NodeId;
use mocap::{Pose, Scene};

fn clip(name: &str) -> Scene {
    mocap::import(format!("../../fixtures/real/{name}")).unwrap()
}

fn builder(clips: &[(&str, &Scene)], options: &GraphOptions) -> GraphBuilder {
    let mut builder = GraphBuilder::new(options).unwrap();
    for (name, scene) in clips {
        builder.add(name, scene).unwrap();
    }
    builder
}

fn walking() -> (Scene, GraphBuilder) {
    let scene = clip("cmu_12_01_walk.bvh");
    let builder = builder(&[("walk.bvh", &scene)], &GraphOptions::new());
    (scene, builder)
}

#[test]
fn where_a_figure_stands_and_looks_makes_no_distance() {
    let scene = clip("cmu_12_01_walk.bvh");
    let mut turned = scene.clone();
    Turn::new()
        .by(Some(70.0))
        .apply(&mut turned, &StepInput::new())
        .unwrap();
    let builder = builder(&[("a", &scene), ("b", &turned)], &GraphOptions::new());
    let (own, other) = (builder.matrix(0, 0).unwrap(), builder.matrix(0, 1).unwrap());
    assert_eq!((own.rows, own.columns), (122, 122)); // 131 frames at 30 Hz, of which windows have 10
    for row in 0..own.rows {
        for column in 0..own.columns {
            let [a, b] = [&own, &other].map(|matrix| matrix.at(row, column));
            // Positions are 32-bit numbers. The figure is 20 m from the origin, in units of 5.6 cm.
            assert!((a - b).abs() < 2e-5, "{row} {column}: {a} {b}");
            assert!((a - own.at(column, row)).abs() < 1e-6, "{row} {column}: not symmetric");
        }
    }
    assert!((0..own.rows).all(|row| own.at(row, row) < 1e-6));
}

/// The frames that can be reached from a frame, forwards or backwards. Every frame leads to the next.
fn reached(graph: &MotionGraph, from: [usize; 2], is_forwards: bool) -> BTreeSet<[usize; 2]> {
    let mut reached = BTreeSet::new();
    let mut open = vec![from];
    while let Some(at) = open.pop() {
        if !reached.insert(at) {
            continue;
        }
        let by = graph.transitions.iter().filter_map(|transition| match is_forwards {
            true => (transition.from == at).then_some(transition.to),
            false => (transition.to == at).then_some(transition.from),
        });
        open.extend(by);
        match is_forwards {
            true if at[1] + 1 < graph.clips[at[0]].frames => open.push([at[0], at[1] + 1]),
            false if at[1] > 0 => open.push([at[0], at[1] - 1]),
            _ => {}
        }
    }
    reached
}

#[test]
fn the_component_is_what_is_reached_from_each_of_its_frames_and_leads_there() {
    let first = clip("cmu_12_01_walk.bvh");
    let second = clip("cmu_12_01_walk.bvh");
    for threshold in [0.02, 0.1] {
        let options = GraphOptions::new().threshold(threshold).rate(15.0).whole(true);
        let whole = builder(&[("a", &first), ("b", &second)], &options).build().unwrap();
        let parts = whole.clips.iter().enumerate();
        let inside: BTreeSet<[usize; 2]> = parts
            .filter_map(|(clip, of_clip)| Some((clip, of_clip.part?)))
            .flat_map(|(clip, [first, last])| (first..=last).map(move |frame| [clip, frame]))
            .collect();
        let from = *inside.first().unwrap();
        let both = &reached(&whole, from, true) & &reached(&whole, from, false);
        assert_eq!(both, inside, "{threshold}");
        let kept = builder(&[("a", &first), ("b", &second)], &options.whole(false))
            .build()
            .unwrap();
        let mut expected = whole.transitions.clone();
        expected.retain(|transition| inside.contains(&transition.from) && inside.contains(&transition.to));
        assert_eq!(kept.transitions, expected);
        assert_eq!(kept.clips, whole.clips);
    }
}

/// The largest step of a joint from frame to frame, in metres.
fn largest_step(scene: &Scene, metres: f32) -> f32 {
    let frames = scene.animations[0].frame_count();
    let poses: Vec<Pose> = (0..frames)
        .map(|frame| Pose::at_tick(scene, 0, frame as f64).unwrap())
        .collect();
    let nodes = 0..scene.nodes.len();
    let steps = poses.windows(2).flat_map(|pair| {
        let position = |pose: &Pose, node: usize| -> Vec3 { pose.position(NodeId::new(node)) };
        nodes
            .clone()
            .map(move |node| position(&pair[0], node).distance(position(&pair[1], node)))
    });
    steps.fold(0.0, f32::max) * metres
}

fn moving(scene: &Scene) -> Vec<&str> {
    let channels = scene.animations[0].channels.iter();
    let moving = channels.filter(|channel| channel.position_keys.len() > 1);
    moving.map(|channel| channel.node_name.as_str()).collect()
}

fn made(found: &Walk, scene: &Scene) -> Scene {
    let (made, report) = found.motion(&[(scene, 0)]).unwrap();
    assert_eq!(made.animations[0].frame_count(), report.frames);
    assert!(made.validate().is_empty());
    let metres = 0.0254 / 0.45;
    let (own, most) = (largest_step(&made, metres), largest_step(scene, metres));
    assert!(
        own < 1.05 * most,
        "a joint steps by {own} m, and in the clip by {most} m"
    );
    // Rounding adds no channels: a joint moves in the walk only if it moves in the clip.
    assert_eq!(moving(&made), moving(scene));
    made
}

#[test]
fn walks_are_as_long_as_wanted_and_joints_do_not_jump() {
    let (scene, builder) = walking();
    let graph = builder.build().unwrap();
    let network = builder.network(&graph).unwrap();
    for (seconds, seed) in [(0.4, 1), (7.0, 1), (12.0, 2)] {
        let found = network.random(seconds, seed).unwrap();
        let made = made(&found, &scene);
        let length = made.animations[0].duration / made.animations[0].ticks_per_second;
        assert!((length - seconds).abs() < 0.01, "{length} s instead of {seconds} s");
    }
    assert_ne!(network.random(12.0, 2).unwrap(), network.random(12.0, 3).unwrap());
    for seconds in [0.0, -1.0, f64::NAN, 1e9] {
        assert!(network.random(seconds, 1).is_err());
    }
}

#[test]
fn a_walk_through_moments_passes_them() {
    let (scene, builder) = walking();
    let graph = builder.build().unwrap();
    let network = builder.network(&graph).unwrap();
    let found = network
        .through(&[(0, Some(3.0)), (0, Some(1.0)), (0, Some(3.5))])
        .unwrap();
    let has = |frame: usize| {
        found
            .pieces
            .iter()
            .any(|piece| (piece.first..=piece.last).contains(&frame))
    };
    assert!(has(90) && has(30) && has(105), "{found:?}");
    made(&found, &scene);
    assert!(network.through(&[(0, None)]).is_err());
    assert!(network.through(&[(0, None), (1, None)]).is_err());
    assert!(network.through(&[(0, Some(99.0)), (0, None)]).is_err());
}

#[test]
fn a_walk_follows_a_path() {
    let (scene, builder) = walking();
    let graph = builder.build().unwrap();
    let network = builder.network(&graph).unwrap();
    let found = network.along(&[[2.0, 1.0], [2.0, 13.0]]).unwrap();
    let made = made(&found, &scene);
    let metres = 0.0254 / 0.45;
    let at = |frame: usize| Pose::at_tick(&made, 0, frame as f64).unwrap().position(NodeId::new(0)) * metres;
    let frames = made.animations[0].frame_count();
    // The hips sway beside the path, which is the path of the body's mean.
    for frame in 0..frames {
        assert!((at(frame).x - 2.0).abs() < 0.25, "frame {frame} is at {}", at(frame));
    }
    assert!(
        (at(0).z - 1.0).abs() < 0.25 && (at(frames - 1).z - 13.0).abs() < 0.5,
        "{} {}",
        at(0),
        at(frames - 1)
    );
    for path in [
        vec![],
        vec![[0.0, 0.0]],
        vec![[0.0, 0.0], [0.0, 0.0]],
        vec![[0.0, 0.0], [f64::NAN, 1.0]],
    ] {
        assert!(network.along(&path).is_err(), "{path:?}");
    }
    // A straight walk cannot turn, and the error says where it ends.
    let error = network.along(&[[0.0, 0.0], [4.0, 0.0], [4.0, 5.0]]).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("of 9.0 m, because no clip continues as the path does"),
        "{error}"
    );
    let followed = found.motion(&[(&scene, 0)]).unwrap().1.path.unwrap();
    assert!(
        followed.largest_distance < 0.1 && followed.largest_angle < 10.0,
        "{followed}"
    );
}

#[test]
fn clips_of_other_skeletons_are_refused() {
    let (_, mut builder) = walking();
    let error = builder.add("dab.bvh", &clip("z_up_dab.bvh")).unwrap_err().to_string();
    assert!(error.contains("its skeleton differs from walk.bvh"), "{error}");
    let mut longer = clip("cmu_12_01_walk.bvh");
    longer.nodes[3].transform.w_axis *= 1.5;
    longer.nodes[3].transform.w_axis.w = 1.0;
    let error = builder.add("longer.bvh", &longer).unwrap_err().to_string();
    assert!(error.contains("the offset of"), "{error}");
    let mut still = clip("cmu_12_01_walk.bvh");
    still.animations.clear();
    assert_eq!(
        builder.add("still.bvh", &still).unwrap_err().code().as_str(),
        "no-motion"
    );
}

#[test]
fn a_graph_comes_back_from_its_text_and_contradictions_are_refused() {
    let (_, builder) = walking();
    let graph = builder.build().unwrap();
    let text = graph.to_json();
    assert_eq!(MotionGraph::from_json(&text).unwrap(), graph);
    for length in (0..text.len() - 2).step_by(97) {
        assert!(MotionGraph::from_json(&text[..length]).is_err(), "{length} bytes");
    }
    for (from, to) in [
        ("\"motion-graph\": 1", "\"motion-graph\": 2"),
        ("\"from\":[0,", "\"from\":[7,"),
        ("\"to\":[0,", "\"to\":[0,1"),
        ("\"distance\":", "\"distance\":-"),
        ("\"rate\":30.0", "\"rate\":1e300"),
        ("\"part\":[", "\"part\":[999,"),
        ("\"animation\"", "\"animaton\""),
    ] {
        assert!(text.contains(from));
        assert!(MotionGraph::from_json(&text.replacen(from, to, 1)).is_err(), "{to}");
    }
    let mut other = clip("cmu_12_01_walk.bvh");
    Trim::new()
        .range("1..".parse().unwrap())
        .apply(&mut other, &StepInput::new())
        .unwrap();
    let mut shorter = GraphBuilder::new(&GraphOptions::new()).unwrap();
    shorter.add("walk.bvh", &other).unwrap();
    let error = shorter.network(&graph).unwrap_err();
    assert_eq!(error.code().as_str(), "invalid-graph");
}
