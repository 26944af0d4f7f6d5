//! Knees and ankles without a marker beside them, in trials with marker clusters on thighs and shanks. The motion of
//! both clusters determines the joint's centre and axis.

use glam::{DAffine3, DMat3, DVec3};
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::centres::{self, ANKLE, KNEE};
use super::take::{Take, rigid};

/// The number of frames from which the axes are computed, which bounds the time.
const FRAMES: usize = 300;

/// The number of markers that determine how a segment moves.
const CLUSTER: usize = 3;

/// The mean of 2 - 2 cos(angle) of a joint at or above which its motion determines its axis: the value for angles of 10
/// degrees.
const LEAST_MOTION: f64 = 0.03;

/// The factor by which a centre moves less along the axis than across it: the motion does not show where on its axis a
/// hinge is.
const STAYS_ALONG: f64 = 1e3;

/// The number of iterations of the inverse power method, which bounds the time.
const ITERATIONS: usize = 50;

/// One frame of the take as a standing trial, with the missing markers on both sides of knees and ankles. `None` if the
/// motion determines none of them.
pub(super) fn standing(take: &Take) -> Option<Take> {
    if ["LKNE", "RKNE", "LANK", "RANK"].into_iter().all(|name| take.has(name)) {
        return None;
    }
    let reference = take.fullest();
    let frames: Vec<usize> = (0..take.frames).step_by((take.frames / FRAMES).max(1)).collect();
    let moved = |bone: Bone| motions(take, bone, reference, &frames);
    let mut made = take.filled(&[reference], None);
    let at = |name: &str| take.at(name, reference);
    let axes = centres::pelvis_axes(at)?;
    for side in [Side::Left, Side::Right] {
        let [thigh, shank, foot] =
            [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot].map(|bone| moved(bone.on(side)));
        let own = |name: &str| centres::sided(side, name);
        let left = axes * DVec3::X * centres::sign(side);
        // The ankle is near the midpoint of heel and toes, and the knee near the midpoint of hip and ankle.
        let middle = at(&own("HEE"))
            .zip(at(&own("TOE")))
            .map(|(heel, toe)| heel.midpoint(toe));
        let ankle = match take.has(&own("ANK")) {
            true => at(&own("ANK")),
            false => turning(&shank, &foot, middle, left).map(|(ankle, outward)| {
                made.add(&own("ANK"), ankle + outward * ANKLE);
                made.add(&own("ANM"), ankle - outward * ANKLE);
                ankle
            }),
        };
        let between = ankle
            .zip(centres::hip(at, side))
            .map(|(ankle, hip)| ankle.midpoint(hip));
        if !take.has(&own("KNE"))
            && let Some((knee, outward)) = turning(&thigh, &shank, between, left)
        {
            made.add(&own("KNE"), knee + outward * KNEE);
            made.add(&own("KNM"), knee - outward * KNEE);
        }
    }
    (made.landmarks.len() > take.landmarks.len()).then_some(made)
}

/// The motion of a bone's markers, relative to the frame `reference`.
fn motions(take: &Take, bone: Bone, reference: usize, frames: &[usize]) -> Vec<Option<DAffine3>> {
    let own: Vec<usize> = (0..take.landmarks.len())
        .filter(|index| take.landmarks[*index].bone == bone)
        .collect();
    let moved = |frame: &usize| {
        let pair = |index: &usize| take.tracks[*index][reference].zip(take.tracks[*index][*frame]);
        rigid(&own.iter().filter_map(pair).collect::<Vec<_>>(), CLUSTER)
    };
    frames.iter().map(moved).collect()
}

/// The point that two segments share in all frames, and the axis about which they turn (the symmetric centre of
/// rotation of Ehrig et al., J. Biomech. 39, 2006, and 40, 2007). Both are in the coordinates of the reference frame.
/// The axis points as `along` does. The point is the point of the axis that is nearest to `near`.
fn turning(
    above: &[Option<DAffine3>],
    below: &[Option<DAffine3>],
    near: Option<DVec3>,
    along: DVec3,
) -> Option<(DVec3, DVec3)> {
    let near = near?;
    let (mut matrix, mut right, mut count) = (DMat3::ZERO, DVec3::ZERO, 0.0);
    for (above, below) in std::iter::zip(above, below) {
        let (Some(above), Some(below)) = (above, below) else {
            continue;
        };
        let turned = above.matrix3 - below.matrix3;
        matrix += turned.transpose() * turned;
        right += turned.transpose() * (below.translation - above.translation);
        count += 1.0;
    }
    let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
    if count == 0.0 || trace < 2.0 * LEAST_MOTION * count {
        return None;
    }
    let inverse = (matrix + DMat3::from_diagonal(DVec3::splat(trace * 1e-9))).inverse();
    let axis = (0..ITERATIONS).fold(along, |axis, _| (inverse * axis).normalize_or(along));
    let axis = axis * axis.dot(along).signum();
    let stiff = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z) * (STAYS_ALONG * trace);
    let centre = near + (matrix + stiff).inverse() * (right - matrix * near);
    (centre.is_finite() && axis.is_finite()).then_some((centre, axis))
}
