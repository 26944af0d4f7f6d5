//! Runs the programs of `examples/` on the lecture's file, whose motion has a closed form.

use mocap::glam::Vec3;

#[allow(dead_code, reason = "the test calls `run`, not `main`")]
#[path = "../../examples/chain.rs"]
mod chain;
#[allow(dead_code, reason = "the test calls `run`, not `main`")]
#[path = "../../examples/end_effector_path.rs"]
mod end_effector_path;
#[allow(dead_code, reason = "the test calls `run`, not `main`")]
#[path = "../../examples/own_nodes.rs"]
mod own_nodes;
#[allow(dead_code, reason = "the test calls `run`, not `main`")]
#[path = "../../examples/two_bone.rs"]
mod two_bone;
#[allow(dead_code, reason = "the test calls `run`, not `main`")]
#[path = "../../examples/update_loop.rs"]
mod update_loop;

const LECTURE: &str = "fixtures/real/lecture_Test.bvh";

/// The lecture's arm in frame `frame`, from 0: name, x and y of each node. All nodes are in the plane z = 0.
///
/// The shoulder is at (0.1 (frame + 1), 0.02 frame). The links are 2, 1.5 and 0.5 long. Each joint is rotated by its
/// angle times frame + 1, relative to the link before.
fn arm(frame: f64) -> [(&'static str, f64, f64); 4] {
    let count = frame + 1.0;
    let (mut x, mut y, mut degrees) = (0.1 * count, 0.02 * frame, 0.0);
    let mut step = |length: f64, turn: f64| {
        degrees += turn * count;
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let here = (x, y);
        (x, y) = (x + length * cos, y + length * sin);
        here
    };
    let (shoulder, elbow, wrist) = (step(2.0, 5.0), step(1.5, 10.0), step(0.5, 8.0));
    [
        ("Shoulder", shoulder.0, shoulder.1),
        ("Elbow", elbow.0, elbow.1),
        ("Wrist", wrist.0, wrist.1),
        ("EndSite_Wrist", x, y),
    ]
}

fn output(run: impl FnOnce(&mut Vec<u8>) -> Result<(), Box<dyn std::error::Error>>) -> String {
    let mut out = Vec::new();
    run(&mut out).unwrap();
    String::from_utf8(out).unwrap()
}

#[test]
fn update_loop_draws_every_node_at_every_tick() {
    let mut expected = String::new();
    for tick in 0..10 {
        for (name, x, y) in arm(f64::from(tick)) {
            expected += &format!("{tick} {name} {x:.3} {y:.3} 0.000\n");
        }
    }
    assert_eq!(output(|out| update_loop::run(LECTURE, out)), expected);
}

#[test]
fn end_effector_path_is_a_row_a_frame() {
    let mut expected = "seconds,x,y,z\n".to_owned();
    for tick in 0..10 {
        let [.., (_, x, y)] = arm(f64::from(tick));
        expected += &format!("{:.3},{x:.3},{y:.3},0.000\n", f64::from(tick) / 10.0);
    }
    assert_eq!(output(|out| end_effector_path::run(LECTURE, None, out)), expected);
    let named = output(|out| end_effector_path::run(LECTURE, Some("EndSite_Wrist"), out));
    assert_eq!(named, expected);
    assert!(end_effector_path::run(LECTURE, Some("Elbow"), &mut Vec::new()).is_err());
}

#[test]
fn own_nodes_are_driven_through_time() {
    let mut expected = String::new();
    // Two steps of 0.2 seconds at 10 frames per second are 4 ticks. The last step ends at the last frame.
    for tick in [0.0, 4.0, 8.0, 9.0] {
        expected += &format!("tick {tick:.1}\n");
        for (name, x, y) in &arm(tick)[..3] {
            expected += &format!("  {name} {x:.3} {y:.3} 0.000\n");
        }
    }
    let found = output(|out| own_nodes::run(LECTURE, &["Shoulder", "Elbow", "Wrist"], out));
    assert_eq!(found, expected);
}

#[test]
fn a_chain_reaches_a_goal() {
    let text = output(|out| chain::run(&mut "0 0 0  1 0 0  2 0 0  3 0 0  1 1 0.5\n".as_bytes(), out));
    let numbers: Vec<f32> = text.split_whitespace().map(|number| number.parse().unwrap()).collect();
    let places: Vec<Vec3> = numbers.chunks_exact(3).map(Vec3::from_slice).collect();
    assert!(
        places[0] == Vec3::ZERO && places[3].distance(Vec3::new(1.0, 1.0, 0.5)) < 1e-4,
        "{text}"
    );
    assert!(
        places
            .windows(2)
            .all(|pair| (pair[0].distance(pair[1]) - 1.0).abs() < 1e-5),
        "{text}"
    );
    assert!(chain::run(&mut "1 2 3 4 5 6".as_bytes(), &mut Vec::new()).is_err());
}

#[test]
fn two_bones_reach_a_goal() {
    // Two bones of length 1. If the goal is the opposite corner of a unit square, the bones form a right angle.
    let text = output(|out| two_bone::run(&mut "0 0 0  1 0 0  1 1 0  -1 1 0\n".as_bytes(), out));
    let numbers: Vec<f32> = text.split_whitespace().map(|number| number.parse().unwrap()).collect();
    let near = |a: &[f32], b: [f32; 3]| std::iter::zip(a, b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(near(&numbers[..3], [0.0, 1.0, 0.0]), "{text}");
    assert!(near(&numbers[3..6], [-1.0, 1.0, 0.0]), "{text}");
    assert!(two_bone::run(&mut "1 2 3".as_bytes(), &mut Vec::new()).is_err());
}
