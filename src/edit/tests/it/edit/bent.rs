//! Tests of paths that are bent to points.

use mocap::edit::report::{WarpPathReport, WarpReport};
use mocap::edit::{PathFacing, PathPoint, Step, StepInput, Warp};
use mocap::figure::{Humanoid, HumanoidBone};

use mocap::scene::UpAxis;
use proptest::prelude::*;

use super::*;

const WALK: &str = "cmu_12_01_walk.bvh";

fn point(seconds: f64, x: f64, z: f64) -> PathPoint {
    PathPoint {
        seconds: Some(seconds),
        at: [x, z],
    }
}

fn bend(scene: &mut Scene, points: Vec<PathPoint>, facing: PathFacing) -> mocap::Result<WarpPathReport> {
    match (Warp::Path { points, facing }).apply(scene, &StepInput::new())? {
        WarpReport::Path(report) => Ok(report),
        other => panic!("{other:?}"),
    }
}

fn hips(scene: &Scene) -> usize {
    Humanoid::of(scene).joint(HumanoidBone::Hips).unwrap().index()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_path_that_is_bent_back_is_the_path(
        places in prop::collection::vec((-5.0f64..5.0, -5.0f64..5.0), 1..6),
        along in any::<bool>(),
    ) {
        let scene = import(WALK);
        let mut bent = scene.clone();
        let count = places.len();
        let points = places.iter().enumerate().map(|(place, (x, z))| point(4.3 * place as f64 / count as f64, *x, *z));
        let facing = if along { PathFacing::Along } else { PathFacing::Kept };
        let report = bend(&mut bent, points.collect(), facing).unwrap();
        prop_assert_eq!(bent.validate(), []);
        let at = exact_positions(&bent);
        for (place, (x, z)) in places.iter().enumerate() {
            let frame = (4.3 * place as f64 / count as f64 * 120.0).round() as usize;
            let hips = at[frame][hips(&scene)];
            prop_assert!((hips.x - x).hypot(hips.z - z) < 1e-5, "{place}: {hips}");
        }
        bend(&mut bent, report.points_before, facing).unwrap();
        let (old, new) = (exact_positions(&scene), exact_positions(&bent));
        let off = old.iter().flatten().zip(new.iter().flatten()).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        prop_assert!(off < 1e-5, "{off}");
    }
}

#[test]
fn a_figure_turns_with_its_path_or_looks_where_it_looked() {
    let scene = import(WALK);
    let found = Humanoid::of(&scene);
    let joint = |bone: HumanoidBone| found.joint(bone).unwrap().index();
    let (left, right) = (joint(HumanoidBone::LeftUpperLeg), joint(HumanoidBone::RightUpperLeg));
    let heading = |at: &[DVec3]| {
        let ahead = (at[left] - at[right]).cross(DVec3::Y);
        ahead.z.atan2(ahead.x).to_degrees()
    };
    let before = exact_positions(&scene);
    // The figure walks the same distance at the same speed in the direction of +X, and then turns right by a quarter
    // turn, to +Z.
    let last = before.len() - 1;
    let way = |frame: usize| {
        let step = before[frame][joint(HumanoidBone::Hips)] - before[0][joint(HumanoidBone::Hips)];
        step.x.hypot(step.z)
    };
    let points = || vec![point(0.0, 0.0, 0.0), point(last as f64 / 120.0, way(last), 0.0)];
    let was_ahead = {
        let way = before[last][joint(HumanoidBone::Hips)] - before[0][joint(HumanoidBone::Hips)];
        way.z.atan2(way.x).to_degrees()
    };
    for (facing, turned) in [(PathFacing::Along, true), (PathFacing::Kept, false)] {
        let mut bent = scene.clone();
        let report = bend(&mut bent, points(), facing).unwrap();
        assert!((report.length - report.length_before).abs() < 1e-3, "{report:?}");
        assert_bones_keep_their_lengths(&scene, &bent);
        for (old, new) in before.iter().zip(exact_positions(&bent)) {
            // Heights stay, and so do the positions of joints relative to each other.
            for (old, new) in old.iter().zip(&new) {
                assert!((old.y - new.y).abs() < 1e-5);
            }
            let expected = if turned { -was_ahead } else { 0.0 };
            let turn = (heading(&new) - heading(old) - expected + 540.0).rem_euclid(360.0) - 180.0;
            assert!(turn.abs() < 0.01, "{turn} degrees");
        }
    }
}

#[test]
fn points_without_times_share_the_way() {
    let scene = import(WALK);
    let mut bent = scene.clone();
    let at = [[0.0, 0.0], [2.0, 1.0], [2.0, 4.0]];
    let points = at.map(|at| PathPoint { seconds: None, at }).to_vec();
    let report = bend(&mut bent, points, PathFacing::Along).unwrap();
    let times: Vec<f64> = report
        .points_before
        .iter()
        .map(|point| point.seconds.unwrap())
        .collect();
    let node = hips(&scene);
    let path: Vec<DVec3> = exact_positions(&scene)
        .iter()
        .map(|at| at[node].reject_from(DVec3::Y))
        .collect();
    let gone = |frames: &[DVec3]| frames.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f64>();
    let middle = (times[1] * 120.0).round() as usize;
    assert!((gone(&path[..=middle]) / gone(&path) - 0.5).abs() < 0.01, "{times:?}");
    assert!(times[0] == 0.0 && (times[2] - 522.0 / 120.0).abs() < 0.01, "{times:?}");
}

#[test]
fn the_unit_and_the_up_axis_change_nothing() {
    let metres = import(WALK);
    let mut inches = metres.clone();
    inches.convert_units(1.0 / 0.0254, UpAxis::Y);
    inches.metadata.metres_per_unit = Some(0.0254);
    let points = vec![point(0.0, 0.0, 0.0), point(2.0, 1.0, 2.0), point(4.0, 4.0, 2.0)];
    let bend = |mut scene: Scene| {
        bend(&mut scene, points.clone(), PathFacing::Along).unwrap();
        exact_positions(&scene)
    };
    let (a, b) = (bend(metres), bend(inches));
    for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
        assert!(a.distance(*b * 0.0254) < 1e-4, "{a} {b}");
    }
}

#[test]
fn points_that_cannot_be_are_refused() {
    let walk = import(WALK);
    for (points, message) in [
        (vec![], "a path must have at least one point"),
        (
            vec![point(0.0, f64::NAN, 0.0)],
            "the points of a path must be finite and within 1e9 m",
        ),
        (
            vec![point(1.0, 0.0, 0.0), point(1.0, 1.0, 0.0)],
            "the times of a path must be finite, at least 0, and in increasing order",
        ),
        (
            vec![point(-1.0, 0.0, 0.0)],
            "the times of a path must be finite, at least 0, and in increasing order",
        ),
        (
            vec![
                point(1.0, 0.0, 0.0),
                PathPoint {
                    seconds: None,
                    at: [1.0, 1.0],
                },
            ],
            "either all points of a path have a time, or none",
        ),
    ] {
        let mut scene = walk.clone();
        let error = bend(&mut scene, points, PathFacing::Along).unwrap_err();
        assert_eq!(error.diagnostic().message, message);
        assert!(scene == walk);
    }
    let mut scene = walk.clone();
    let error = bend(&mut scene, vec![point(5.0, 0.0, 0.0)], PathFacing::Along).unwrap_err();
    assert_eq!(error.diagnostic().message, "point 1 of the path would be at frame 600");
    assert_eq!(
        error.diagnostic().expected.as_deref(),
        Some("a frame from 0 to 522, one for each point")
    );
    assert_eq!(error.diagnostic().found.as_deref(), Some("5:0/0"));
    let mut one = walk.clone();
    one.trim(0.0, 0.0);
    let points = vec![point(0.0, 0.0, 0.0), point(1.0, 0.0, 0.0)];
    let error = bend(&mut one, points, PathFacing::Along).unwrap_err();
    assert_eq!(
        error.diagnostic().message,
        "a path of 2 points needs at least 2 frames, but the number of frames is 1"
    );
    // All points are at one place: the figure walks on the spot and keeps its facing.
    let mut scene = walk.clone();
    let points = [0.0, 1.0, 2.0].map(|seconds| point(seconds, 3.0, 3.0)).to_vec();
    let report = bend(&mut scene, points, PathFacing::Along).unwrap();
    assert_eq!(scene.validate(), []);
    assert!(report.length < 1e-9 && report.largest_turn == 0.0, "{report:?}");
}
