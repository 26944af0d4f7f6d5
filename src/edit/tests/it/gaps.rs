//! Tests of marker gaps through steps: an unseen marker stays unseen until the gap is filled.

use mocap::convert::RootMotion;
use mocap::edit::{Concat, ExtractRoot, Fill, Resample, Reverse, Smooth, Step, StepInput, Warp};
use mocap::{Code, Conversion, Importer, Scene};

/// Two markers in ten frames: A moves evenly, and B is visible in the frames `seen`.
fn take(seen: &[usize]) -> Scene {
    let rows: String = (0..10)
        .map(|frame| {
            let b = match seen.contains(&frame) {
                true => format!("{}\t{}\t5", frame * 10, frame * frame),
                false => "\t\t".to_owned(),
            };
            format!("{}\t{}\t{frame}\t0\t1\t{b}\n", frame + 1, frame as f64 / 10.0)
        })
        .collect();
    let text = format!(
        "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n10\t10\t2\tm\n\
         Frame#\tTime\tA\t\t\tB\t\t\n{rows}"
    );
    Importer::new().read(text.as_bytes(), "a.trc").unwrap()
}

/// The frames in which B is visible.
fn seen(scene: &Scene) -> Vec<usize> {
    assert_eq!(scene.validate(), []);
    let animation = &scene.animations[0];
    let keys = &animation.channels[1].position_keys;
    (0..animation.frame_count())
        .filter(|frame| keys.is_seen(*frame as f64))
        .collect()
}

fn after<S: Step>(step: &S, frames: &[usize]) -> Vec<usize> {
    let mut scene = take(frames);
    step.apply(&mut scene, &StepInput::new()).unwrap();
    seen(&scene)
}

#[test]
fn gaps_go_through_steps() {
    for frames in [vec![0, 1, 2, 5, 6, 9], vec![4], vec![0], vec![3, 4, 5, 6]] {
        assert_eq!(seen(&take(&frames)), frames);
        let reversed: Vec<usize> = frames.iter().rev().map(|frame| 9 - frame).collect();
        assert_eq!(after(&Reverse::new(), &frames), reversed);
        assert_eq!(after(&Smooth::new().cut_off(2.0), &frames), frames);
        // At 20 frames per second, the new frames are between two visible ones.
        let doubled: Vec<usize> = (0..19_usize)
            .filter(|frame| [frame / 2, frame.div_ceil(2)].iter().all(|old| frames.contains(old)))
            .collect();
        assert_eq!(after(&Resample::new().rate(20.0), &frames), doubled);
        let (mut scene, other) = (take(&frames), take(&frames));
        Concat::new()
            .align(false)
            .apply(&mut scene, &StepInput::new().other(&other))
            .unwrap();
        let later = frames.iter().filter(|frame| **frame > 0).map(|frame| frame + 9);
        assert_eq!(seen(&scene), frames.iter().copied().chain(later).collect::<Vec<_>>());
    }
    // At double speed, the motion has the frames 0, 2, 4, 6 and 8.
    let fast = Warp::Speed(2.0);
    assert_eq!(after(&fast, &[0, 1, 2, 5, 6, 9]), [0, 1, 3]);
}

#[test]
fn gaps_are_filled_where_that_is_asked_for_and_listed() {
    let mut scene = take(&[1, 2, 5, 6, 7]);
    let report = Fill::new().apply(&mut scene, &StepInput::new()).unwrap();
    assert_eq!(seen(&scene), [1, 2, 3, 4, 5, 6, 7]);
    let gaps = |points: &[mocap::edit::report::PointGaps]| -> Vec<(String, Vec<[usize; 2]>)> {
        points
            .iter()
            .map(|point| (point.name.clone(), point.gaps.clone()))
            .collect()
    };
    assert_eq!(gaps(&report.filled_points), [("B".to_owned(), vec![[3, 4]])]);
    assert_eq!(gaps(&report.unfilled_points), [("B".to_owned(), vec![[0, 0], [8, 9]])]);
    assert_eq!(
        report.to_string(),
        "1 gaps of 1 points filled in frames B 3..4; 2 gaps unchanged: B 0..0 8..9"
    );
    // The Hermite curve from 4 to 25 over three frames, with the speeds 4 - 1 and 36 - 25.
    let heights = [1.0, 4.0, 25.0 / 3.0, 46.0 / 3.0, 25.0, 36.0, 49.0];
    let keys = &scene.animations[0].channels[1].position_keys;
    for ((frame, position), height) in (1..8).zip(&keys.values).zip(heights) {
        let expected = [10.0 * frame as f32, height, 5.0].into();
        assert!(position.abs_diff_eq(expected, 1e-4), "{frame} {position}");
    }
    let mut long = take(&[0, 9]);
    let report = Fill::new().apply(&mut long, &StepInput::new()).unwrap();
    assert_eq!((seen(&long), report.filled_points.len()), (vec![0, 9], 0));
}

/// Points have no root. A joint above them would turn them into a skeleton and fill their gaps.
#[test]
fn the_path_of_points_is_refused() {
    for root in [RootMotion::Extract, RootMotion::InPlace] {
        let mut scene = take(&[0, 1, 5, 9]);
        let refused = Conversion::new().root(root).apply(&mut scene).unwrap_err();
        assert_eq!(refused.code(), Code::Unrepresentable);
        assert!(refused.to_string().contains("points without a skeleton"), "{refused}");
        assert_eq!(seen(&scene), [0, 1, 5, 9]);
    }
    let mut scene = take(&[0, 1, 5, 9]);
    let refused = ExtractRoot::new().apply(&mut scene, &StepInput::new()).unwrap_err();
    assert_eq!(refused.code(), Code::Unrepresentable);
}

/// A step that makes new frames cannot keep gaps, and warns.
#[test]
fn steps_that_fill_gaps_say_so() {
    let mut scene = take(&[0, 1, 5, 9]);
    let before = scene.warnings.len();
    mocap::edit::InBetween::new()
        .apply(&mut scene, &StepInput::new())
        .unwrap();
    let filled = scene.warnings[before..]
        .iter()
        .filter(|warning| warning.code == Code::Gap);
    let is_whole = seen(&scene).len() == scene.animations[0].frame_count();
    assert_eq!(filled.count(), usize::from(is_whole));
}
