//! Tests keys whose values are fitted to a track.

use mocap::compress::{RotationFormat, TranslationFormat};
use mocap::glam::{Quat, Vec3};
use mocap_compress::internals::fitted_keys::{NLERP_FROM_SLERP, NLERP_SHARE, RotationFit, TranslationFit, fit};
use mocap_compress::internals::key_frames::between;
use mocap_compress::internals::{Compensation, LeverArms, ObjectSpaceTrack, key_frames};
use mocap_scene::math::quaternion::nlerp;

const FRAMES: usize = 1001;

/// Half a turn has two possible directions. A line may be half a turn only within a bound that allows both directions:
/// their ends are at most twice the length of the chain apart.
#[test]
fn no_line_is_half_a_turn_where_its_way_matters() {
    let longest = (2.0 * NLERP_SHARE / NLERP_FROM_SLERP).cbrt();
    assert!(longest < 0.8 * std::f32::consts::PI, "{longest}");
}

fn ticks() -> Vec<f64> {
    (0..FRAMES).map(|frame| frame as f64).collect()
}

/// A line of length `h` with its ends on the parabola `x^2` has an error of `h^2 / 4` in its middle. If its ends are as
/// far below the parabola as its middle is above it, the error is `h^2 / 8` at all three points. For a bound of 25, `h`
/// is 10 and 14.1.
#[test]
fn fitted_lines_along_a_parabola_are_longer_by_the_root_of_two() {
    let (ticks, tolerance) = (ticks(), 25.0);
    let targets: Vec<Vec3> = (0..FRAMES).map(|x| Vec3::new((x * x) as f32, 1.0, -2.0)).collect();
    let exact = key_frames::reduce(FRAMES, |from, to| {
        between(&ticks, from, to)
            .all(|(frame, alpha)| targets[from].lerp(targets[to], alpha).distance(targets[frame]) <= tolerance)
    });
    assert_eq!(exact.len(), 1 + 1000 / 10);
    let (format, fitted) = (TranslationFormat::Float32, &targets);
    let (frames, keys) = fit(
        &TranslationFit {
            targets: fitted,
            format,
            tolerance,
        },
        &ticks,
    );
    // 71 lines of 14 frames are 994 frames.
    assert!((73..=75).contains(&frames.len()), "{}", frames.len());
    assert_eq!((frames[0], frames[frames.len() - 1]), (0, 1000));
    let line = |key: usize, frame: usize| {
        let (from, to) = (f64::from(frames[key]), f64::from(frames[key + 1]));
        let alpha = (frame as f64 - from) / (to - from);
        f64::from(keys[key].value.x) * (1.0 - alpha) + f64::from(keys[key + 1].value.x) * alpha
    };
    for key in 0..keys.len() - 1 {
        for frame in frames[key] as usize..=frames[key + 1] as usize {
            let error = line(key, frame) - (frame * frame) as f64;
            assert!(error.abs() <= 25.001, "{frame}: {error}");
        }
    }
}

/// The angle of a joint with an arm of one metre is a parabola, so the error in metres is the error of the angle.
#[test]
fn fitted_rotations_are_within_the_tolerance() {
    const FRAMES: usize = 201;
    let (ticks, tolerance) = (&ticks()[..FRAMES], 1e-3);
    let angle = |x: f64| 2e-5 * x * x;
    let raw = ObjectSpaceTrack {
        positions: vec![Vec3::ZERO; FRAMES],
        rotations: (0..FRAMES)
            .map(|frame| Quat::from_rotation_z(angle(frame as f64) as f32))
            .collect(),
    };
    let arms = LeverArms::new(vec![Vec3::X]);
    let joint = Compensation {
        arms: &arms,
        raw: &raw,
        lossy_positions: &raw.positions,
        lossy_parent: None,
    };
    let targets = joint.all_targets();
    for format in [RotationFormat::Float32, RotationFormat::Int16] {
        let (frames, keys) = fit(&RotationFit::new(&targets, &arms, format, tolerance), ticks);
        // Lines with ends on the parabola have up to 14.1 frames, the root of `4 * 1e-3 / 2e-5`. Fitted lines have up
        // to 20 frames.
        assert!(frames.len() <= 12, "{}", frames.len());
        for (pair, key) in std::iter::zip(frames.windows(2), keys.windows(2)) {
            for frame in pair[0]..=pair[1] {
                let alpha = (frame - pair[0]) as f32 / (pair[1] - pair[0]) as f32;
                let value = nlerp(key[0].value, key[1].value, alpha);
                let found = 2.0 * f64::from(value.z).atan2(f64::from(value.w));
                let error = found - angle(f64::from(frame));
                assert!(error.abs() <= 1.001e-3, "{format:?}, {frame}: {error}");
            }
        }
    }
}

#[test]
fn a_clip_of_one_or_two_frames_has_its_own_values() {
    for frames in [1, 2] {
        let targets: Vec<Vec3> = (0..frames).map(|x| Vec3::splat(x as f32)).collect();
        let track = TranslationFit {
            targets: &targets,
            format: TranslationFormat::Float32,
            tolerance: 1e-6,
        };
        let (key_frames, keys) = fit(&track, &ticks()[..frames]);
        assert_eq!(key_frames, key_frames::every_frame(frames));
        let values: Vec<Vec3> = keys.iter().map(|key| key.value).collect();
        assert_eq!(values, targets);
    }
}
