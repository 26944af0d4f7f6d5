//! Joins two motions.

use serde::{Deserialize, Serialize};

use super::body::metres_per_unit;
use super::frames::Frames;
use super::ground::{Carrier, have_the_same_joints};
use super::inertia::{Seam, onward};
use crate::error::{Code, Diagnostic, Result};
use crate::limits::not_negative;
use crate::pose::{Binding, Trs};
use crate::scene::{NodeId, Scene};

/// Options of [`concat()`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ConcatOptions {
    /// Seconds in which the difference of the poses fades after the seam. Default: 0.3.
    pub blend: f64,
    /// Whether the second motion begins where the first one ends, and looks where it looks. Default: `true`.
    pub align: bool,
}

impl Default for ConcatOptions {
    fn default() -> Self {
        Self {
            blend: 0.3,
            align: true,
        }
    }
}

/// What [`concat()`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ConcatReport {
    /// The frame of the seam.
    pub seam: usize,
    /// The frames now.
    pub frames: usize,
    /// The largest difference of a rotation at the seam that was faded out, in degrees.
    pub largest_rotation: f32,
    /// How far the second motion was moved over the ground, in metres.
    pub moved: f32,
}

/// Appends an animation of `other`, which has the same joints, to one of `scene`. The first frame of the second is the
/// last of the first: a motion that is cut in two there comes back.
///
/// # Errors
/// [`Code::InvalidValue`] where the joints differ, or the blend is not finite; [`Code::NoMotion`] without one of the
/// animations.
pub fn concat(
    scene: &mut Scene,
    animation: usize,
    other: &Scene,
    other_animation: usize,
    options: &ConcatOptions,
) -> Result<ConcatReport> {
    not_negative(Code::InvalidValue, "blend", options.blend)?;
    let (first, second) = pair(scene, animation, other, other_animation)?;
    let carrier = Carrier::new(scene, &first);
    let mut rows: Vec<Vec<Trs>> = (0..first.len()).map(|frame| first.row(frame).to_vec()).collect();
    // The second at the frame rate of the first.
    let step = second.rate / first.rate;
    let count = ((second.len() - 1) as f64 / step + 1e-6).floor() as usize + 1;
    let mut added: Vec<Vec<Trs>> = (0..count).map(|frame| second.row_at(frame as f64 * step)).collect();
    let last = rows.len() - 1;
    let mut report = ConcatReport {
        seam: last,
        ..ConcatReport::default()
    };
    if options.align {
        let placement = carrier.placement(&added[0], &rows[last]);
        report.moved = placement.distance() * metres_per_unit(scene);
        added.iter_mut().for_each(|row| carrier.apply(&placement, row));
    }
    let before = [last.saturating_sub(2), last.saturating_sub(1), last].map(|frame| &*rows[frame]);
    let next = added.get(1).unwrap_or(&added[0]);
    let seam = Seam::new([&rows[last], &onward(before)], [&added[0], next]);
    report.largest_rotation = seam.largest_rotation();
    if !seam.is_closed() {
        let steps = first.frames_in(options.blend);
        for (frame, row) in added.iter_mut().enumerate().take(steps) {
            seam.apply(row, frame, steps);
        }
    }
    rows.extend(added.into_iter().skip(1));
    report.frames = rows.len();
    first.with_rows(rows).write_all(scene, animation);
    Ok(report)
}

/// The frames of two animations of the same joints, both with every node that either drives.
pub(super) fn pair(scene: &Scene, animation: usize, other: &Scene, other_animation: usize) -> Result<(Frames, Frames)> {
    if let Err(difference) = have_the_same_joints(scene, other) {
        let message = format!("the two motions have different skeletons: {difference}");
        let diagnostic = Diagnostic::new(Code::InvalidValue, message);
        return Err(diagnostic
            .help("retarget one onto the skeleton of the other first")
            .into());
    }
    let driven = |scene: &Scene, animation: usize| -> Vec<NodeId> {
        let animation = scene.animations.get(animation);
        let binding = animation.map(|animation| Binding::new(scene, animation));
        binding.iter().flat_map(Binding::driven).map(|(node, _)| node).collect()
    };
    let nodes = [driven(scene, animation), driven(other, other_animation)].concat();
    let first = Frames::new(scene, animation, &nodes)?;
    first.require_nodes()?;
    Ok((first, Frames::new(other, other_animation, &nodes)?))
}
