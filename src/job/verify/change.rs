//! Intended changes between a source and a file.

use glam::{DMat4, DQuat, DVec3};
use mocap_edit::{EditStep, StepInput};
use mocap_figure::convert::RestPoseSource;
use mocap_figure::{Conversion, Humanoid, HumanoidMap};
use mocap_retarget::second_motion;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::Limits;
use mocap_scene::process;
use mocap_scene::scene::report::{AppliedStep, SecondMotion};
use mocap_scene::scene::{Scene, UpAxis};

use serde_json::Value;

use super::chain::Skeleton;
use super::pairs::Pairs;
use super::{Finding, FindingKind};

/// Units of length of motion files, in metres: millimetre, centimetre, decimetre, metre, inch, foot, and the unit of
/// the CMU database, an inch divided by 0.45.
const UNITS: [f64; 7] = [0.001, 0.01, 0.1, 1.0, 0.0254, 0.3048, 0.0254 / 0.45];

/// The largest error of the rest position of a joint, as a fraction of the body size: the rounding of decimals.
const SAME_REST: f64 = 1e-3;

/// The largest relative error of a ratio of lengths against the ratio of two units: the rounding of lossy files.
const SAME_UNIT: f64 = 0.01;

/// The shortest distance of two joints that is used to find a unit, as a fraction of the longest.
const SHORTEST_LINK: f64 = 1e-4;

/// Applies the steps of a file to its source.
pub(super) struct Replay<'a> {
    /// Imports the second motion of a step.
    pub(super) second: &'a dyn Fn(&SecondMotion) -> Result<Scene>,
    /// Whether the file has the unit and the axes of its source. A unit or axis that is not converted may be unknown.
    pub(super) keeps_units: bool,
}

impl Replay<'_> {
    /// The source after all steps up to the last edit, and the number of these steps. Edits are not undone, but applied
    /// to the source too. `None` without an edit.
    pub(super) fn edits(&self, source: &Scene, steps: &[AppliedStep]) -> Result<Option<(Scene, usize)>> {
        let is_resample = |step: &AppliedStep| matches!(step, AppliedStep::Resample { .. });
        let resampled = steps.iter().rposition(is_resample);
        // If several steps resample, all of them except the last are applied to the source. The file is compared with
        // the resulting motion.
        let before = resampled.and_then(|last| steps[..last].iter().rposition(is_resample));
        match steps.iter().rposition(AppliedStep::changes_motion).max(before) {
            Some(last) => Ok(Some((self.steps(source, &steps[..=last])?, last + 1))),
            None => Ok(None),
        }
    }

    /// The source after these steps.
    pub(super) fn steps(&self, source: &Scene, steps: &[AppliedStep]) -> Result<Scene> {
        let mut scene = source.clone();
        self.apply(&mut scene, steps)?;
        Ok(scene)
    }

    fn apply(&self, scene: &mut Scene, steps: &[AppliedStep]) -> Result<()> {
        for step in steps {
            match step {
                AppliedStep::ConvertUnits {
                    metres_per_unit,
                    up,
                    out_metres_per_unit,
                    out_up,
                } => {
                    let (known_metres, known_up) = (scene.metadata.metres_per_unit, scene.metadata.up);
                    process::convert_units_to(scene, (*metres_per_unit, *up), (*out_metres_per_unit, *out_up));
                    if self.keeps_units && metres_per_unit == out_metres_per_unit {
                        scene.metadata.metres_per_unit = known_metres;
                    }
                    if self.keeps_units && up == out_up {
                        scene.metadata.up = known_up;
                    }
                }
                AppliedStep::Trim { first, last } => scene.trim(*first, *last),
                AppliedStep::Resample { frames_per_second } => {
                    scene.resample(*frames_per_second, &Limits::default())?;
                }
                AppliedStep::InPlace => scene.put_in_place(),
                AppliedStep::RootMotion => drop(scene.extract_root_motion()),
                AppliedStep::ZeroRestRotations => process::zero_rest_rotations(scene)?,
                AppliedStep::Retime { .. }
                | AppliedStep::SelectClip { .. }
                | AppliedStep::VrmHumanoid { .. }
                | AppliedStep::Retarget { .. }
                | AppliedStep::NameJoints { .. } => {}
                AppliedStep::Edit { edit, bones, .. } if edit.step() == Some("rest") => {
                    set_rest(scene, &edit.0, &bones.clone().into())?;
                }
                AppliedStep::Edit { edit, with, bones } => {
                    self.edit(scene, &edit.0, with.as_ref(), &bones.clone().into())?;
                }
                AppliedStep::OfClip { index, .. } if *index >= scene.animations.len() => {}
                AppliedStep::OfClip { index, steps } => {
                    scene.change_clip(*index, |scene| self.apply(scene, steps))?;
                }
            }
        }
        Ok(())
    }

    fn edit(&self, scene: &mut Scene, edit: &Value, with: Option<&SecondMotion>, bones: &HumanoidMap) -> Result<()> {
        let mut other = match with {
            Some(with) => {
                let mut other = (self.second)(with)?;
                self.apply(&mut other, &with.steps)?;
                Some(other)
            }
            None => None,
        };
        let known = match bones.is_empty() {
            true => None,
            false => Some(Humanoid::of(scene).with_map(scene, bones.clone())?),
        };
        // A second motion with another skeleton was retargeted.
        if let Some(second) = &other
            && let Some(fitted) = second_motion(scene, bones, second)?
        {
            other = Some(fitted.scene);
        }
        let input = StepInput::new().other(other.as_ref()).humanoid(known.as_ref());
        EditStep::from_value(edit)?.apply(scene, &input)?;
        Ok(())
    }
}

/// Sets the rest pose that a conversion records.
fn set_rest(scene: &mut Scene, edit: &Value, bones: &HumanoidMap) -> Result<()> {
    let pose = edit.get("pose").and_then(Value::as_str).unwrap_or_default();
    let pose: RestPoseSource = pose
        .parse()
        .map_err(|error: String| Diagnostic::new(Code::InvalidValue, format!("the rest pose of the file: {error}")))?;
    let conversion = Conversion::new().keep_units(true).rest(pose).bones(bones.clone());
    conversion.apply(scene)?;
    Ok(())
}

/// The scene with the new names of joints, if joints were renamed: the comparison uses these names.
pub(super) fn named(scene: &Scene, steps: &[AppliedStep]) -> Option<Scene> {
    let mut named = None;
    for step in steps {
        if let AppliedStep::NameJoints { joints } = step {
            mocap_figure::apply_names(named.get_or_insert_with(|| scene.clone()), joints);
        }
    }
    named
}

/// The intended changes between a source and a file.
pub(super) struct Change {
    /// Units of the file per unit of the source.
    pub(super) metres_per_unit: f64,
    /// The up axis of the source, and of the file.
    up: (UpAxis, UpAxis),
    /// For a motion in place, the number of steps in `times` before the step that put the motion in place.
    pub(super) in_place: Option<usize>,
    /// Number of joints that were added for root motion.
    pub(super) added_roots: usize,
    /// Metres per unit of the file, if the file was converted to a unit.
    pub(super) out_metres_per_unit: Option<f64>,
    /// If only the bones of a humanoid remain: the rotation of the figure, and its offset.
    pub(super) humanoid: Option<(DQuat, DVec3)>,
    /// The steps that change times, in their order.
    pub(super) times: Vec<AppliedStep>,
    /// Whether the ratio of lengths is the ratio of two units of length, or 1.
    has_unit: bool,
}

impl Change {
    fn none() -> Self {
        Self {
            metres_per_unit: 1.0,
            up: (UpAxis::Y, UpAxis::Y),
            in_place: None,
            added_roots: 0,
            out_metres_per_unit: None,
            humanoid: None,
            times: Vec::new(),
            has_unit: true,
        }
    }

    /// Sets the unit of the file's lengths, instead of metres.
    pub(super) fn in_unit_of(mut self, metres: Option<f64>) -> Self {
        self.metres_per_unit /= metres.unwrap_or(1.0);
        self
    }

    /// The changes of recorded steps.
    pub(super) fn recorded(steps: &[AppliedStep]) -> Self {
        let mut change = Self::none();
        let mut is_turned = false;
        for step in steps {
            match *step {
                AppliedStep::ConvertUnits {
                    metres_per_unit,
                    up,
                    out_metres_per_unit,
                    out_up,
                } => {
                    change.metres_per_unit *= metres_per_unit / out_metres_per_unit;
                    change.up = (if is_turned { change.up.0 } else { up }, out_up);
                    change.out_metres_per_unit = Some(out_metres_per_unit);
                    is_turned = true;
                }
                AppliedStep::Trim { .. } | AppliedStep::Resample { .. } => change.times.push(step.clone()),
                AppliedStep::InPlace => change.in_place = Some(change.times.len()),
                AppliedStep::RootMotion => change.added_roots += 1,
                AppliedStep::VrmHumanoid { heading, lift } => {
                    change.humanoid = Some((DQuat::from_rotation_y(heading.to_radians()), DVec3::Y * lift));
                }
                AppliedStep::Retime { .. }
                | AppliedStep::SelectClip { .. }
                | AppliedStep::Retarget { .. }
                | AppliedStep::Edit { .. }
                | AppliedStep::OfClip { .. }
                | AppliedStep::NameJoints { .. }
                | AppliedStep::ZeroRestRotations => {}
            }
        }
        change
    }

    /// Infers the unit and the up axis. The unit comes from the lengths of the links at the first time with nonzero
    /// lengths. Lossy files round lengths, so a ratio near a known unit counts as this unit. The up axis is the axis
    /// that brings the joints closest. `metres` is the unit of the source. `stated` is the file's unit relative to the
    /// source, if known.
    pub(super) fn guessed(ours: &Skeleton, theirs: &Skeleton, pairs: &Pairs, metres: f64, stated: Option<f64>) -> Self {
        let seen = moments(ours, theirs);
        let mut change = Self::none();
        let of_links = ratio_of_lengths(&pairs.list, &seen);
        if let Some(ratio) = of_links.or_else(|| ratio_of_distances(&pairs.list, &seen)) {
            let is_near = |unit: &f64| (ratio / unit - 1.0).abs() < SAME_UNIT;
            let of_source = UNITS.iter().map(|unit| metres / unit);
            let of_any = UNITS.iter().flat_map(|from| UNITS.iter().map(move |to| from / to));
            let unit = stated
                .into_iter()
                .chain([1.0])
                .chain(of_source)
                .chain(of_any)
                .find(is_near);
            change.has_unit = unit.is_some();
            change.metres_per_unit = unit.unwrap_or(ratio);
        }
        let position = |world: &[DMat4], node: usize| world[node].w_axis.truncate();
        let distance = |change: &Self| -> f64 {
            let distances = seen.iter().flat_map(|(here, there)| {
                let pairs = pairs.list.iter();
                pairs.map(|(a, b)| change.apply(position(here, *a)).distance(position(there, *b)))
            });
            distances.sum()
        };
        // If several axes are equally near, the first one is kept: +Y.
        let mut nearest = (f64::INFINITY, UpAxis::Y);
        for up in UpAxis::ALL {
            change.up.0 = up;
            let found = distance(&change);
            if found < nearest.0 {
                nearest = (found, up);
            }
        }
        change.up.0 = nearest.1;
        change
    }

    /// Reports lengths that match no unit.
    pub(super) fn finding(&self) -> Option<Finding> {
        let message = || {
            format!(
                "lengths in the file are {:.6} times the lengths in its source; no two units have this ratio",
                self.metres_per_unit
            )
        };
        (!self.has_unit).then(|| Finding::new(FindingKind::Unit, message()))
    }

    /// Whether the file has another up axis.
    pub(super) fn has_another_up(&self) -> bool {
        self.up.0 != self.up.1
    }

    /// Converts a point of the source to the file.
    pub(super) fn apply(&self, point: DVec3) -> DVec3 {
        let lift = self.humanoid.map_or(DVec3::ZERO, |(_, lift)| lift);
        self.turn(point * self.metres_per_unit) + lift
    }

    /// Converts a direction of the source to the file.
    pub(super) fn turn(&self, direction: DVec3) -> DVec3 {
        let DVec3 { x, y, z } = direction;
        let (from, to) = self.up;
        let y_up = match from {
            UpAxis::Y => direction,
            UpAxis::Z => DVec3::new(x, z, -y),
            UpAxis::NegY => DVec3::new(x, -y, -z),
            UpAxis::NegZ => DVec3::new(x, -z, y),
        };
        let y_up = self.humanoid.map_or(y_up, |(heading, _)| heading * y_up);
        let DVec3 { x, y, z } = y_up;
        match to {
            UpAxis::Y => y_up,
            UpAxis::Z => DVec3::new(x, -z, y),
            UpAxis::NegY => DVec3::new(x, -y, -z),
            UpAxis::NegZ => DVec3::new(x, z, -y),
        }
    }

    /// Whether rest positions relative to the first joint differ between the file and its source. In BVH, joints rest
    /// without a rotation, so their axes then differ too.
    pub(super) fn rests_elsewhere(&self, pairs: &Pairs, ours: &Skeleton, theirs: &Skeleton) -> bool {
        let (mut here, mut there) = (Vec::new(), Vec::new());
        ours.world(0.0, &mut here);
        theirs.world(0.0, &mut there);
        let at = |&(a, b): &(usize, usize)| {
            let (a, b) = (here[a].w_axis.truncate(), there[b].w_axis.truncate());
            (self.apply(a), b)
        };
        let Some(first) = pairs.list.first().map(at) else {
            return false;
        };
        let seen: Vec<_> = pairs
            .list
            .iter()
            .map(at)
            .map(|(a, b)| (a - first.0, b - first.1))
            .collect();
        let size = seen.iter().map(|(a, _)| a.length()).fold(0.0, f64::max);
        seen.iter().any(|(a, b)| a.distance(*b) > SAME_REST * size)
    }

    /// The horizontal part of an offset in the file.
    pub(super) fn over_ground(&self, offset: DVec3) -> DVec3 {
        match self.up.1 {
            UpAxis::Y | UpAxis::NegY => DVec3::new(offset.x, 0.0, offset.z),
            UpAxis::Z | UpAxis::NegZ => DVec3::new(offset.x, offset.y, 0.0),
        }
    }
}

/// Joint positions of the source and of the file at a few times, spread evenly over the motion. The first frame is not
/// enough: all markers may be hidden in it, and be at one point.
fn moments(ours: &Skeleton, theirs: &Skeleton) -> Vec<(Vec<DMat4>, Vec<DMat4>)> {
    const PARTS: u32 = 4;
    let at = |seconds: f64| {
        let (mut here, mut there) = (Vec::new(), Vec::new());
        ours.world(seconds, &mut here);
        theirs.world(seconds, &mut there);
        (here, there)
    };
    let parts = if ours.end > 0.0 { PARTS } else { 0 };
    (0..=parts)
        .map(|part| at(ours.end * f64::from(part) / f64::from(PARTS)))
        .collect()
}

/// The ratio of the largest distances from the origin. This ratio is used for a single joint, or for joints that are
/// always at one point, because they have no other length.
fn ratio_of_distances(pairs: &[(usize, usize)], seen: &[(Vec<DMat4>, Vec<DMat4>)]) -> Option<f64> {
    let length = |world: &[DMat4], node: usize| world[node].w_axis.truncate().length();
    let distances = seen.iter().flat_map(|(here, there)| {
        let pairs = pairs.iter();
        pairs.map(|(a, b)| (length(here, *a), length(there, *b)))
    });
    let (ours, theirs) = distances.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let ratio = theirs / ours;
    (ratio.is_finite() && ratio > 0.0).then_some(ratio)
}

/// The median ratio of lengths between neighbouring pairs, at the first time with nonzero lengths. A single broken
/// length does not change the median.
fn ratio_of_lengths(pairs: &[(usize, usize)], seen: &[(Vec<DMat4>, Vec<DMat4>)]) -> Option<f64> {
    let length = |world: &[DMat4], from: usize, to: usize| world[from].w_axis.distance(world[to].w_axis);
    let lengths = |(here, there): &(Vec<DMat4>, Vec<DMat4>)| -> Vec<(f64, f64)> {
        let pairs = pairs.windows(2).map(|pair| {
            let [(a, b), (next_a, next_b)] = [pair[0], pair[1]];
            (length(here, a, next_a), length(there, b, next_b))
        });
        pairs.collect()
    };
    let lengths: Vec<_> = seen.iter().map(lengths).collect();
    let longest = lengths
        .iter()
        .flatten()
        .fold(0.0, |longest: f64, (ours, _)| longest.max(*ours));
    let median = |lengths: &Vec<(f64, f64)>| {
        // The distance of joints at one position is only rounding.
        let lengths = lengths.iter().filter(|(ours, _)| *ours > SHORTEST_LINK * longest);
        let mut ratios: Vec<f64> = lengths.map(|(ours, theirs)| theirs / ours).collect();
        ratios.sort_unstable_by(f64::total_cmp);
        let median = ratios.get(ratios.len() / 2).copied();
        median.filter(|ratio| ratio.is_finite() && *ratio > 0.0)
    };
    lengths.iter().find_map(median)
}
