//! Shifts the hips while feet are locked, so that the legs reach the feet.

use glam::{Mat3, Vec3};

use super::follow::{FootFollower, Lift};
use super::hold::Hold;
use super::leg::Foot;
use super::shift;

/// Returns the shifts of the hips, for feet that follow a source. The shifts of the hips are the smoothed shifts of the
/// feet on the ground, so that the legs do not bend more than on the source. Also completes the shifts of the feet.
pub(super) fn follow(feet: &mut [FootFollower], held: &[Vec<Option<Vec3>>], up: Vec3, blend: usize) -> Vec<Vec3> {
    let mut carried = carried(feet, held, up, blend);
    for (foot, held) in feet.iter_mut().zip(held) {
        foot.shift(held, up, blend, &carried);
    }
    let lowered = shift::envelope(&needed_lowering(feet, &carried, up), blend);
    for (carried, lowered) in carried.iter_mut().zip(lowered) {
        *carried -= up * lowered;
    }
    carried
}

fn carried(feet: &[FootFollower], held: &[Vec<Option<Vec3>>], up: Vec3, blend: usize) -> Vec<Vec3> {
    let frames = held.first().map_or(0, Vec::len);
    let mean = |values: &mut dyn Iterator<Item = (f32, Vec3)>| {
        let (weights, sum) = values.fold((0.0, Vec3::ZERO), |(weights, sum), (weight, value)| {
            (weights + weight, sum + value * weight)
        });
        (weights > 0.2).then(|| sum / weights)
    };
    let over_ground = |frame: usize| mean(&mut held.iter().filter_map(|held| Some((1.0, held[frame]?))));
    let height = |frame: usize| {
        let lifts = feet.iter().filter_map(|foot| foot.lifts().get(frame));
        mean(&mut lifts.map(|lift| (lift.weight, up * Lift::asked(lift))))
    };
    let over_ground = shift::filled((0..frames).map(over_ground));
    let height = shift::filled((0..frames).map(height));
    let both: Vec<Vec3> = over_ground.into_iter().zip(height).map(|(a, b)| a + b).collect();
    shift::smooth(&both, blend)
}

/// For each frame, the distance by which the hips must be lowered so that both legs reach the goals of their feet.
fn needed_lowering(feet: &[FootFollower], carried: &[Vec3], up: Vec3) -> Vec<f32> {
    let of_leg = |foot: &FootFollower, frame: usize, carried: Vec3| {
        let leg = &foot.leg;
        if carried == Vec3::ZERO && leg.shifts[frame] == Vec3::ZERO {
            return 0.0;
        }
        let goal = leg.ankle[frame] + leg.shifts[frame];
        let offset = goal - leg.thigh[frame] - carried + up * foot.slack();
        rise_to_reach(offset, leg.reach(frame), up).unwrap_or(0.0)
    };
    let of_frame = |(frame, carried): (usize, &Vec3)| {
        let legs = feet.iter().map(|foot| of_leg(foot, frame, *carried));
        legs.fold(0.0, f32::max)
    };
    carried.iter().enumerate().map(of_frame).collect()
}

/// The smallest height by which the end of `offset` must rise so that its length is at most `reach`. `None` if no
/// height is enough.
pub(super) fn rise_to_reach(offset: Vec3, reach: f32, up: Vec3) -> Option<f32> {
    let beyond = offset.length_squared() - reach * reach;
    if beyond <= 0.0 {
        return Some(0.0);
    }
    // Solves |offset + h up| = reach for the smaller h.
    let along = offset.dot(up);
    let square = along * along - beyond;
    (along < 0.0 && square >= 0.0).then(|| -along - square.sqrt())
}

/// Returns the shifts of the hips that keep the knees near their positions while feet are locked. If a knee or the hips
/// would move farther than `limit`, the feet that cause this motion are shifted less, and keep a part of their sliding.
/// Also completes the shifts of the feet.
pub(super) fn spare_knees(
    feet: &mut [Hold],
    mut held: Vec<Vec<Option<Vec3>>>,
    up: Vec3,
    floor: f32,
    blend: usize,
    limit: f32,
) -> Vec<Vec3> {
    feet.iter_mut().for_each(|foot| foot.level(up, blend));
    let lifts: Vec<[Vec<f32>; 2]> = feet.iter().map(|foot| foot.lifts_onto(up, floor, blend)).collect();
    let mut lifted: Vec<Vec<f32>> = lifts.iter().map(|[wanted, _]| wanted.clone()).collect();
    let mut kept: Vec<Vec<f32>> = lifted.iter().map(|lifted| vec![1.0; lifted.len()]).collect();
    let contacts: Vec<Vec<[usize; 2]>> = held.iter().map(|held| runs(held)).collect();
    let mut carried = balanced(feet, &held, &lifted, up, blend);
    let is_limited = limit.is_finite();
    for _ in 0..if is_limited { ROUNDS } else { 0 } {
        let [left, right, hips] = changes(feet, &carried);
        // The factor that reduces a shift which moves a knee or the hips by `change`.
        let factor = |change: f32| (BELOW * limit / change).clamp(0.5, 1.0);
        if [&left, &right, &hips]
            .into_iter()
            .flatten()
            .all(|change| *change <= limit)
        {
            break;
        }
        for (side, knee) in [left, right].into_iter().enumerate() {
            let largest: Vec<f32> = knee.iter().zip(&hips).map(|(knee, hips)| knee.max(*hips)).collect();
            for &[start, end] in &contacts[side] {
                let around = start.saturating_sub(blend)..(end + blend).min(largest.len());
                let change = largest[around].iter().copied().fold(0.0, f32::max);
                if change > limit {
                    let shifts = held[side][start..end].iter_mut().flatten();
                    shifts.for_each(|shift| *shift *= factor(change));
                }
            }
            let [wanted, least] = &lifts[side];
            for (frame, kept) in kept[side].iter_mut().enumerate() {
                if wanted[frame] != 0.0 && largest[frame] > limit {
                    *kept *= factor(largest[frame]);
                }
            }
            let given_up: Vec<f32> = kept[side].iter().map(|kept| 1.0 - kept).collect();
            let given_up = shift::envelope(&given_up, blend / 2);
            for (frame, lifted) in lifted[side].iter_mut().enumerate() {
                *lifted = least[frame] + (1.0 - given_up[frame]) * (wanted[frame] - least[frame]).max(0.0);
            }
        }
        carried = balanced(feet, &held, &lifted, up, blend);
    }
    for foot in feet {
        foot.land_softly(up, floor, quarter(blend));
    }
    carried
}

/// The largest number of rounds that reduce shifts to keep the limit. Each round halves a shift at most.
const ROUNDS: usize = 10;

/// A round aims at this fraction of the limit, so that rounding errors do not exceed the limit.
const BELOW: f32 = 0.98;

fn quarter(blend: usize) -> usize {
    (blend / 4).max(1)
}

/// The runs of frames with a known shift, each as its first frame and the frame after its last.
fn runs(known: &[Option<Vec3>]) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for (frame, _) in known.iter().enumerate().filter(|(_, known)| known.is_some()) {
        match runs.last_mut() {
            Some(last) if last[1] == frame => last[1] = frame + 1,
            _ => runs.push([frame, frame + 1]),
        }
    }
    runs
}

/// The displacements of the left knee, the right knee and the hips in each frame.
fn changes(feet: &[Hold], carried: &[Vec3]) -> [Vec<f32>; 3] {
    let knee = |side: usize| {
        let change =
            |(frame, carried): (usize, &Vec3)| feet.get(side).map_or(0.0, |foot| foot.leg.knee_change(frame, *carried));
        carried.iter().enumerate().map(change).collect()
    };
    [
        knee(0),
        knee(1),
        carried.iter().map(|carried| carried.length()).collect(),
    ]
}

/// Returns the smoothed shifts of the hips with the smallest sum of squares. The sum has the shift of the hips, and the
/// sideways displacements of the knees whose feet are on the ground. The hips move over the ground at most as far as a
/// foot does. Without this limit, feet that are raised by unlike heights would move the hips far to one side, because
/// legs are nearly parallel. Also completes the shifts of the feet.
fn balanced(feet: &mut [Hold], held: &[Vec<Option<Vec3>>], lifted: &[Vec<f32>], up: Vec3, blend: usize) -> Vec<Vec3> {
    let frames = lifted.first().map_or(0, Vec::len);
    let still = vec![Vec3::ZERO; frames];
    // The weight of a foot rises before the foot touches the ground.
    let mut importance: Vec<Vec<f32>> = Vec::new();
    for ((foot, held), lifted) in feet.iter_mut().zip(held).zip(lifted) {
        foot.shift(held, lifted, up, blend, &still);
        let counts = held
            .iter()
            .zip(lifted)
            .map(|(held, lift)| held.is_some() || *lift != 0.0);
        let counts: Vec<f32> = counts.map(|counts| f32::from(u8::from(counts))).collect();
        importance.push(shift::envelope(&counts, (blend / 2).max(1)));
    }
    let of_frame = |frame: usize| {
        let (mut matrix, mut right, mut farthest) = (Mat3::IDENTITY, Vec3::ZERO, 0.0_f32);
        for (foot, importance) in feet.iter().zip(&importance) {
            let direction = (foot.leg.ankle[frame] - foot.leg.thigh[frame]).normalize_or_zero();
            let column = direction * importance[frame] * foot.leg.bend_rate(frame).powi(2);
            matrix += Mat3::from_cols(column * direction.x, column * direction.y, column * direction.z);
            let shift = foot.leg.shifts[frame];
            right += column * direction.dot(shift);
            farthest = farthest.max(shift.reject_from_normalized(up).length());
        }
        let over_ground = (matrix.inverse() * right).reject_from_normalized(up);
        let over_ground = over_ground.clamp_length_max(farthest);
        // The best height for this movement over the ground.
        over_ground + up * (right - matrix * over_ground).dot(up) / (matrix * up).dot(up)
    };
    let hips: Vec<Vec3> = (0..frames).map(of_frame).collect();
    let hips = shift::smooth(&hips, quarter(blend));
    for ((foot, held), lifted) in feet.iter_mut().zip(held).zip(lifted) {
        foot.shift(held, lifted, up, blend, &hips);
        foot.leg.spare_knee(&hips, up, quarter(blend));
    }
    hips
}
