//! Plots the position and rotation curves of a joint over time.

use glam::Quat;
use mocap_figure::Unit;
use mocap_scene::options::setters;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::NodeId;

use super::drawing::{Anchor, Color, Drawing, Point};
use super::euler;
use super::figure::{Clip, short};
use super::theme;

/// The options of a plot.
///
/// [`Drawing::plot`](crate::Drawing::plot) has an example.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PlotOptions {
    /// Width in pixels. Default: 960.
    pub width: u32,
    /// Height of one pair of axes in pixels. Default: 260.
    pub panel_height: u32,
    /// Frames to mark on the curves, such as the keys of a keyframe animation. Default: none.
    pub marked_frames: Vec<usize>,
}

impl Default for PlotOptions {
    fn default() -> Self {
        Self {
            width: 960,
            panel_height: 260,
            marked_frames: Vec::new(),
        }
    }
}

setters! {
    PlotOptions {
        width: u32,
        panel_height: u32,
        marked_frames: Vec<usize>,
    }
}

/// A line through values over time.
struct Curve {
    name: String,
    color: Color,
    #[doc(hidden)]
    pub values: Vec<f64>,
}

impl Drawing {
    /// Draws two panels for each joint. The first panel has the world position of the joint, in the unit of the scene
    /// if the unit is known. The second panel has the rotation of the joint relative to its parent, in degrees about
    /// the axes of the joint's channels, in their order. The time axis is in seconds, up to the last frame.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::render::{Drawing, Clip, PlotOptions};
    /// use mocap::scene::NodeId;
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let drawing = Drawing::plot(&Clip { name: "Test", scene: &scene }, &[NodeId(1)], &PlotOptions::default());
    /// assert!(drawing.to_svg().contains("position in the world [file units]"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn plot(clip: &Clip<'_>, joints: &[NodeId], options: &PlotOptions) -> Self {
        let is_there = |joint: &NodeId| joint.index() < clip.scene.nodes.len();
        let joints: Vec<NodeId> = joints.iter().copied().filter(is_there).collect();
        let width = options.width.clamp(320, super::raster::LARGEST_SIDE);
        let panel = options.panel_height.clamp(120, super::raster::LARGEST_SIDE) as f32;
        let height = (2.0 * panel * joints.len() as f32) as u32;
        let names: Vec<_> = joints
            .iter()
            .map(|joint| clip.scene.nodes[joint.index()].name.as_str())
            .collect();
        let title = format!("Position and rotation of {} in {}", names.join(", "), clip.name);
        let mut drawing = Self::new(width, height, theme::PAPER, title);
        let unit = clip.scene.metadata.metres_per_unit.and_then(unit);
        let in_units = unit.map_or("file units", Unit::as_str);
        let length = unit.map_or(String::new(), |unit| format!(" {}", unit.as_str()));
        for (index, (&joint, track)) in joints.iter().zip(tracks(clip, &joints)).enumerate() {
            let node = &clip.scene.nodes[joint.index()];
            let (position, rotation) = curves(clip, joint, track);
            let top = 2.0 * panel * index as f32;
            let heading = format!("{}, {}: position in the world [{in_units}]", node.name, clip.name);
            paint_panel(
                &mut drawing,
                clip,
                [&heading, &length],
                &position,
                [top, panel],
                &options.marked_frames,
            );
            let heading = format!("{}: rotation to the parent [degrees]", node.name);
            paint_panel(
                &mut drawing,
                clip,
                [&heading, "°"],
                &rotation,
                [top + panel, panel],
                &options.marked_frames,
            );
        }
        drawing
    }
}

/// The world position of one joint and its rotation relative to its parent, one value per tick.
#[derive(Clone, Default)]
struct Track {
    positions: [Vec<f64>; 3],
    rotations: Vec<Quat>,
}

/// The tracks of these joints. The figure is posed once per tick, for all joints.
fn tracks(clip: &Clip<'_>, joints: &[NodeId]) -> Vec<Track> {
    let mut tracks = vec![Track::default(); joints.len()];
    let mut pose = Pose::rest(clip.scene);
    let binding = clip.animation().map(|animation| Binding::new(clip.scene, animation));
    for tick in 0..clip.frames().max(1) {
        if let (Some(binding), Some(animation)) = (&binding, clip.animation()) {
            pose.sample(binding, animation, tick as f64);
        }
        for (track, &joint) in tracks.iter_mut().zip(joints) {
            for (values, value) in track.positions.iter_mut().zip(pose.position(joint).to_array()) {
                values.push(f64::from(value));
            }
            let (_, rotation, _) = pose.node_to_parent[joint.index()].to_scale_rotation_translation();
            track.rotations.push(rotation);
        }
    }
    tracks
}

/// The curves of a joint: position and rotation.
fn curves(clip: &Clip<'_>, joint: NodeId, track: Track) -> (Vec<Curve>, Vec<Curve>) {
    let order = euler::order_of(&clip.scene.nodes[joint.index()]);
    let angles = euler::unwrapped(&track.rotations, order);
    let position = std::iter::zip(["X", "Y", "Z"], track.positions).enumerate();
    let position = position.map(|(axis, (name, values))| Curve {
        name: name.to_owned(),
        color: theme::CURVES[axis],
        values,
    });
    let rotation = order.axes().into_iter().enumerate().map(|(index, axis)| Curve {
        name: format!("{}rotation", ["X", "Y", "Z"][axis]),
        color: theme::CURVES[axis],
        values: angles.iter().map(|angles| angles[index]).collect(),
    });
    (position.collect(), rotation.collect())
}

/// The margin in pixels for the numbers of the vertical axis.
const LEFT: f32 = 64.0;

/// The right margin in pixels, so that the last label fits.
const RIGHT: f32 = 16.0;

/// The top margin in pixels, for the title.
const TOP: f32 = 34.0;

/// The bottom margin in pixels, for the times.
const BOTTOM: f32 = 34.0;

/// The font height of labels in pixels: the smallest legible height.
const LABEL: f32 = 11.0;

/// The unit of `metres` metres, equal to six digits; `None` if no unit has this length.
fn unit(metres: f64) -> Option<Unit> {
    let is_it = |unit: &Unit| (metres / unit.metres() - 1.0).abs() < 1e-6;
    Unit::ALL.into_iter().find(is_it)
}

/// Paints a pair of axes with its grid, curves, legend and marked frames. Numbers at the vertical axis have a unit.
fn paint_panel(
    drawing: &mut Drawing,
    clip: &Clip<'_>,
    [heading, unit]: [&str; 2],
    curves: &[Curve],
    [top, height]: [f32; 2],
    marked: &[usize],
) {
    let [left, right] = [LEFT, drawing.width as f32 - RIGHT];
    let [upper, lower] = [top + TOP, top + height - BOTTOM];
    let all = curves.iter().flat_map(|curve| &curve.values);
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
        (low.min(value), high.max(value))
    });
    let values = Scale::around(low, high, [lower, upper], height as usize / 40);
    let times = Scale::exactly(0.0, clip.seconds(), [left, right], drawing.width as usize / 110);

    drawing.text([left, top + 20.0], heading, 13.0, Anchor::Start, theme::INK);
    for value in values.marks() {
        let y = values.pixel(value);
        drawing.line(
            vec![[left, y], [right, y]],
            1.0,
            if value == 0.0 { theme::PATH } else { theme::RULE },
        );
        drawing.text(
            [left - 8.0, y + 4.0],
            format!("{}{unit}", values.label(value)),
            LABEL,
            Anchor::End,
            theme::FADED,
        );
    }
    for time in times.marks() {
        let x = times.pixel(time);
        drawing.line(vec![[x, upper], [x, lower]], 1.0, theme::RULE);
        drawing.text(
            [x, lower + 16.0],
            format!("{} s", times.label(time)),
            LABEL,
            Anchor::Middle,
            theme::FADED,
        );
    }
    let per_second = clip.animation().map_or(1.0, |animation| animation.ticks_per_second);
    for curve in curves {
        let point = |(tick, value): (usize, f64)| [times.pixel(tick as f64 / per_second), values.pixel(value)];
        let points: Vec<Point> = thinned(&curve.values, drawing.width as usize)
            .into_iter()
            .map(point)
            .collect();
        match points.as_slice() {
            [only] => drawing.circle(*only, 3.0, curve.color),
            _ => drawing.line(points, 1.6, curve.color),
        }
        for &frame in marked {
            if let Some(value) = curve.values.get(frame) {
                drawing.circle(point((frame, *value)), 3.0, curve.color);
            }
        }
    }
    let mut x = right;
    for curve in curves.iter().rev() {
        drawing.text([x, top + 20.0], curve.name.as_str(), LABEL, Anchor::End, theme::INK);
        x -= super::raster::text_width(&curve.name, LABEL) + 6.0;
        drawing.line(vec![[x - 16.0, top + 16.0], [x, top + 16.0]], 2.4, curve.color);
        x -= 30.0;
    }
}

/// At most four values per pixel column, each with its index: the first, the lowest, the highest and the last, so that
/// spikes remain visible.
pub fn thinned(values: &[f64], pixels: usize) -> Vec<(usize, f64)> {
    let stretch = values.len().div_ceil(pixels.max(1)).max(1);
    if stretch <= 4 {
        return values.iter().copied().enumerate().collect();
    }
    let mut kept = Vec::new();
    for (index, chunk) in values.chunks(stretch).enumerate() {
        let by_value = |a: &usize, b: &usize| chunk[*a].total_cmp(&chunk[*b]);
        let lowest = (0..chunk.len()).min_by(by_value).unwrap_or(0);
        let highest = (0..chunk.len()).max_by(by_value).unwrap_or(0);
        let mut indices = vec![0, lowest, highest, chunk.len() - 1];
        indices.sort_unstable();
        indices.dedup();
        kept.extend(indices.into_iter().map(|at| (index * stretch + at, chunk[at])));
    }
    kept
}

/// Maps values to pixels, with ticks at round numbers.
#[doc(hidden)]
pub struct Scale {
    pub from: f64,
    pub to: f64,
    pub pixels: [f32; 2],
    pub step: f64,
}

#[doc(hidden)]
impl Scale {
    /// A scale between two round numbers that include all values.
    pub fn around(low: f64, high: f64, pixels: [f32; 2], marks: usize) -> Self {
        let (low, high) = if low.is_finite() && high.is_finite() {
            (low, high)
        } else {
            (0.0, 0.0)
        };
        // A flat line, or a line with noise only in its last digit, is drawn in the middle of a wider range.
        let least = (1e-4 * low.abs().max(high.abs())).max(1e-3);
        let pad = if high - low < least { least.max(0.5) } else { 0.0 };
        let (low, high) = (low - pad, high + pad);
        let step = round_step((high - low) / marks.max(2) as f64);
        Self {
            from: (low / step).floor() * step,
            to: (high / step).ceil() * step,
            pixels,
            step,
        }
    }

    /// A scale from `from` to `to`, whatever the positions of the ticks.
    fn exactly(from: f64, to: f64, pixels: [f32; 2], marks: usize) -> Self {
        let to = if to > from { to } else { from + 1.0 };
        let step = round_step((to - from) / marks.max(2) as f64);
        Self { from, to, pixels, step }
    }

    pub fn pixel(&self, value: f64) -> f32 {
        let fraction = (value - self.from) / (self.to - self.from);
        self.pixels[0] + (self.pixels[1] - self.pixels[0]) * fraction as f32
    }

    pub fn marks(&self) -> impl Iterator<Item = f64> {
        let first = (self.from / self.step).ceil() as i64;
        let last = (self.to / self.step + 1e-9).floor() as i64;
        let step = self.step;
        (first..=last).map(move |index| index as f64 * step)
    }

    /// A number with as many decimals as the step between ticks.
    fn label(&self, value: f64) -> String {
        if self.step >= 0.01 {
            short(value)
        } else {
            format!("{value:.*}", (-self.step.log10()).ceil().clamp(0.0, 9.0) as usize)
        }
    }
}

/// The smallest number of the series 1, 2, 5 times powers of ten that is at least `step`.
fn round_step(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let round = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|factor| factor * power >= step * (1.0 - 1e-9));
    round.unwrap_or(10.0) * power
}
