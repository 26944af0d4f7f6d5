//! Bends the path of a figure over the ground.

pub(crate) mod spline;

use std::fmt;

use glam::{DVec2, DVec3, Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use self::spline::Spline;
use super::StepInput;
use super::body::metres_per_unit;
use super::carrier::Carrier;
use super::frames::Frames;
use super::quantity::{degrees, metres};

/// A point of a path.
///
/// [`Warp`](crate::Warp) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PathPoint {
    /// The time at which the figure should be at the point, in seconds. The nearest frame is used. If `None`, the times
    /// of the points divide the length of the figure's old path evenly.
    pub seconds: Option<f64>,
    /// The position in metres along the two axes of the ground: x and z if +Y is up, x and y if +Z is up.
    pub at: [f64; 2],
}

/// Prints the point as in the text of a step: `SECONDS:M/M`, or `M/M`.
impl fmt::Display for PathPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(seconds) = self.seconds {
            write!(f, "{seconds}:")?;
        }
        write!(f, "{}/{}", self.at[0], self.at[1])
    }
}

/// The facing of a figure on its new path.
///
/// [`Warp`](crate::Warp) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum PathFacing {
    /// The figure turns with the path. If it walked sideways, it also walks sideways along the new path.
    #[default]
    Along,
    /// The figure keeps its old facing.
    Kept,
}

/// The report of a [`Warp`](crate::Warp) by `path`.
///
/// [`Warp`](crate::Warp) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WarpPathReport {
    /// The old positions of the figure at the times of the points. A warp with these points undoes this warp.
    pub points_before: Vec<PathPoint>,
    /// The length of the path through `points_before`, in metres.
    pub length_before: f64,
    /// The length of the new path, in metres. The feet slide by the difference between `length` and `length_before`.
    pub length: f64,
    /// The largest distance by which the step moved the figure, in metres.
    pub largest_shift: f64,
    /// The largest angle by which the step turned the figure, in degrees.
    pub largest_turn: f64,
}

impl fmt::Display for WarpPathReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the path was {} long, now {}; moved by {} at most, turned by {} at most",
            metres(self.length_before),
            metres(self.length),
            metres(self.largest_shift),
            degrees(self.largest_turn),
        )
    }
}

pub(super) fn warp_path(
    scene: &mut Scene,
    input: &StepInput<'_>,
    points: &[PathPoint],
    facing: PathFacing,
) -> Result<WarpPathReport> {
    check(points)?;
    let animation = input.animation;
    let frames = Frames::new(scene, animation, &[])?;
    frames.require_nodes()?;
    let carrier = Carrier::new(scene, &frames);
    let metres = f64::from(metres_per_unit(scene, input));
    let up = carrier.up.as_dvec3();
    let axes = ground_axes(up);
    let over_ground = |point: Vec3| DVec2::from(axes.map(|axis| point.as_dvec3().dot(axis))) * metres;
    // No node above the carrier moves, so the transform from its parent to the world is constant.
    let above = scene.nodes[frames.nodes()[carrier.column].index()].parent;
    let to_world = above.map_or(Mat4::IDENTITY, |parent| Pose::rest(scene).node_to_world[parent.index()]);
    let (from_world, above_turned) = (to_world.inverse(), Trs::from_matrix(to_world).rotation);
    let position_at = |frame: usize| to_world.transform_point3(frames.at(frame, carrier.column).translation);
    let was_at: Vec<DVec2> = (0..frames.len()).map(|frame| over_ground(position_at(frame))).collect();
    let at_frames = frames_of(points, &was_at, frames.rate)?;
    let seconds: Vec<f64> = frames.ticks.iter().map(|tick| tick / frames.rate).collect();
    let times: Vec<f64> = at_frames.iter().map(|frame| seconds[*frame]).collect();
    let before: Vec<DVec2> = at_frames.iter().map(|frame| was_at[*frame]).collect();
    let through: Vec<DVec2> = points.iter().map(|point| DVec2::from(point.at)).collect();
    let (old, new) = (Spline::new(&times, &before), Spline::new(&times, &through));
    let turns = match facing {
        PathFacing::Along => {
            let (old, new) = (headings(&old, &seconds), headings(&new, &seconds));
            old.zip(new)
                .map(|(old, new)| old.iter().zip(&new).map(|(old, new)| new - old).collect())
        }
        PathFacing::Kept => None,
    };
    let turns: Vec<f64> = turns.unwrap_or_else(|| vec![0.0; frames.len()]);
    let mut report = WarpPathReport {
        points_before: times
            .iter()
            .zip(&before)
            .map(|(seconds, at)| PathPoint {
                seconds: Some(*seconds),
                at: at.to_array(),
            })
            .collect(),
        ..WarpPathReport::default()
    };
    let length = |spline: &Spline| {
        seconds
            .windows(2)
            .map(|pair| spline.at(pair[0]).distance(spline.at(pair[1])))
            .sum()
    };
    (report.length_before, report.length) = (length(&old), length(&new));
    // The sign of a rotation about the up axis: it turns the first axis of the ground either towards the second axis or
    // away from it.
    let handed = axes[0].cross(axes[1]).dot(up);
    let mut rows: Vec<Vec<Trs>> = Vec::with_capacity(frames.len());
    for (frame, turn) in turns.into_iter().enumerate() {
        let mut row = frames.row(frame);
        let from = was_at[frame];
        let to = new.at(seconds[frame]) + DVec2::from_angle(turn).rotate(from - old.at(seconds[frame]));
        let shift: DVec3 = axes[0] * (to - from).x + axes[1] * (to - from).y;
        let turn = turn.sin().atan2(turn.cos());
        let about = Quat::from_axis_angle(carrier.up, (turn * handed) as f32);
        let trs = &mut row[carrier.column];
        trs.translation = from_world.transform_point3((position_at(frame).as_dvec3() + shift / metres).as_vec3());
        trs.rotation = (above_turned.inverse() * about * above_turned * trs.rotation).normalize();
        report.largest_shift = report.largest_shift.max(from.distance(to));
        report.largest_turn = report.largest_turn.max(turn.abs().to_degrees());
        rows.push(row);
    }
    let ticks = frames.ticks.clone();
    let mut changed = frames.with_rows(rows);
    changed.ticks = ticks;
    changed.write_all(scene, animation);
    Ok(report)
}

fn check(points: &[PathPoint]) -> Result<()> {
    let refuse = |message: &str| {
        let diagnostic = Diagnostic::new(Code::InvalidValue, message);
        Err(diagnostic
            .expected_found(
                "points that all have times in seconds, which increase, or points without times",
                found(points),
            )
            .into())
    };
    let times: Vec<f64> = points.iter().filter_map(|point| point.seconds).collect();
    let is_finite = points
        .iter()
        .all(|point| point.at.iter().all(|value| value.is_finite() && value.abs() < 1e9));
    if points.is_empty() {
        refuse("a path must have at least one point")
    } else if !is_finite {
        refuse("the points of a path must be finite and within 1e9 m")
    } else if !times.is_empty() && times.len() < points.len() {
        refuse("either all points of a path have a time, or none")
    } else if !times.iter().all(|time| (0.0..1e9).contains(time)) || times.windows(2).any(|pair| pair[0] >= pair[1]) {
        refuse("the times of a path must be finite, at least 0, and in increasing order")
    } else {
        Ok(())
    }
}

/// The points for a message, as text of the option `path`.
fn found(points: &[PathPoint]) -> String {
    points.iter().map(PathPoint::to_string).collect::<Vec<_>>().join("+")
}

/// The two axes over the ground: the world axes other than up, in order.
fn ground_axes(up: DVec3) -> [DVec3; 2] {
    let upright = up.abs().max_position();
    let mut axes = DVec3::AXES
        .into_iter()
        .enumerate()
        .filter(|(axis, _)| *axis != upright)
        .map(|(_, axis)| axis);
    [axes.next().unwrap_or(DVec3::X), axes.next().unwrap_or(DVec3::Z)]
}

/// The frame at which the figure passes each point: the frame nearest to the time of the point. Without a time, it is
/// the frame nearest to the point's fraction of the path length.
fn frames_of(points: &[PathPoint], was_at: &[DVec2], rate: f64) -> Result<Vec<usize>> {
    let last = was_at.len() - 1;
    let mut gone = vec![0.0];
    for pair in was_at.windows(2) {
        gone.push(gone[gone.len() - 1] + pair[0].distance(pair[1]));
    }
    let whole = gone[last];
    let at_fraction = |fraction: f64| {
        // If the figure stays at one position, the path has no length, so the fraction refers to the duration.
        if whole <= 1e-6 {
            return (fraction * last as f64).round() as usize;
        }
        let after = gone
            .partition_point(|travelled| *travelled < fraction * whole)
            .min(last);
        let before = after.saturating_sub(1);
        if fraction * whole - gone[before] < gone[after] - fraction * whole {
            before
        } else {
            after
        }
    };
    if points.len() > was_at.len() {
        let message = format!(
            "a path of {0} points needs at least {0} frames, but the number of frames is {1}",
            points.len(),
            was_at.len()
        );
        return Err(Diagnostic::new(Code::InvalidValue, message).into());
    }
    let mut frames: Vec<usize> = Vec::with_capacity(points.len());
    for (position_at, point) in points.iter().enumerate() {
        let frame = match point.seconds {
            Some(seconds) => (seconds * rate).round() as usize,
            None => at_fraction(position_at as f64 / (points.len() - 1).max(1) as f64),
        };
        let least = frames.last().map_or(0, |last| last + 1);
        // While a figure stands, several frames have the same position. Two points must not get the same frame.
        let frame = if point.seconds.is_some() {
            frame
        } else {
            frame.max(least)
        };
        if frame < least || frame > last {
            let message = format!("point {} of the path would be at frame {frame}", position_at + 1);
            let expected = format!("a frame from {least} to {last}, one for each point");
            return Err(Diagnostic::new(Code::InvalidValue, message)
                .expected_found(expected, found(points))
                .into());
        }
        frames.push(frame);
    }
    Ok(frames)
}

/// The direction of a path at the times `seconds`, as angles in radians. During a pause, the last direction counts.
/// `None` if the path never moves.
fn headings(path: &Spline, seconds: &[f64]) -> Option<Vec<f64>> {
    let speeds: Vec<DVec2> = seconds.iter().map(|seconds| path.speed(*seconds)).collect();
    let fastest = speeds.iter().map(|speed| speed.length()).fold(0.0, f64::max);
    if fastest <= 1e-9 {
        return None;
    }
    let is_clear = |speed: &DVec2| speed.length() > 1e-6 * fastest;
    let mut heading = speeds.iter().copied().find(is_clear)?.to_angle();
    let of = |speed: &DVec2| {
        if is_clear(speed) {
            heading = speed.to_angle();
        }
        heading
    };
    Some(speeds.iter().map(of).collect())
}
