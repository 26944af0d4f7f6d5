//! A contact sheet: one row per clip, with poses over time.

use glam::Vec3;
use mocap_scene::options::setters;

use super::camera::{Camera, Extent};
use super::drawing::{Anchor, Drawing, Point};
use super::figure::{Clip, DrawnClip, short};
use super::raster::shortened;
use super::surface::Body;
use super::theme;

/// The options of a sheet.
///
/// [`Drawing::sheet`](crate::Drawing::sheet) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SheetOptions {
    /// Poses per clip, including the first and the last frame. Default: 8.
    pub poses: usize,
    /// The width of the sheet in pixels. Default: 1600.
    pub width: u32,
}

impl Default for SheetOptions {
    fn default() -> Self {
        Self { poses: 8, width: 1600 }
    }
}

setters! {
    SheetOptions {
        poses: usize,
        width: u32,
    }
}

/// The margin of the sheet in pixels: the width of a letter of a heading.
const MARGIN: f32 = 16.0;
/// The width in pixels of the left column, with the name and the root's path.
const HEAD: f32 = 220.0;

/// The ratio of a row's height to a pose's width. A figure with bent arms fits.
const POSE_ASPECT: f32 = 1.35;

impl Drawing {
    /// Draws every clip as a row: its name, a summary, the path of its root seen from above, and its poses. The poses
    /// are evenly spaced in time. A rest pose in the first frame is left out. Each pose has its time and the root's
    /// path on the floor. All poses of a row have the same scale.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::render::{Drawing, Clip, SheetOptions};
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let drawing = Drawing::sheet(&[Clip { name: "Test", scene: &scene }], &SheetOptions::new().poses(2).width(800));
    /// assert!(drawing.to_svg().contains(">Test</text>"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn sheet(clips: &[Clip<'_>], options: &SheetOptions) -> Self {
        let width = options.width.max(480);
        let poses = options.poses.max(1);
        let cell = (width as f32 - HEAD - 2.0 * MARGIN) / poses as f32;
        let row = (cell * POSE_ASPECT).clamp(150.0, 420.0).round();
        let height = (2.0 * MARGIN + row * clips.len() as f32) as u32;
        let names: Vec<_> = clips.iter().map(|clip| clip.name).collect();
        let title = format!("Contact sheet: {}", names.join(", "));
        let mut drawing = Self::new(width, height, theme::PAPER, title);
        for (index, clip) in clips.iter().enumerate() {
            let top = MARGIN + row * index as f32;
            if index > 0 {
                let right = width as f32 - MARGIN;
                drawing.line(vec![[MARGIN, top], [right, top]], 1.0, theme::RULE);
            }
            let mut figure = DrawnClip::new(*clip);
            let path = root_path(&mut figure);
            let in_metres: Vec<Vec3> = path.iter().map(|point| *point * figure.metres).collect();
            paint_head(&mut drawing, clip, &in_metres, top, row);
            paint_poses(
                &mut drawing,
                &mut figure,
                &path,
                poses,
                [MARGIN + HEAD, top],
                [cell, row],
            );
        }
        drawing
    }
}

/// Draws a few small poses of a clip in a row.
pub(super) fn thumbnail(clip: &Clip<'_>, width: u32, height: u32) -> Drawing {
    /// The number of poses in a thumbnail: start, middle and end.
    const POSES: usize = 3;
    let mut drawing = Drawing::new(width, height, theme::PAPER, clip.name);
    let mut figure = DrawnClip::new(*clip);
    let path = root_path(&mut figure);
    let cell = width as f32 / POSES as f32;
    paint_poses(
        &mut drawing,
        &mut figure,
        &path,
        POSES,
        [0.0, 0.0],
        [cell, height as f32],
    );
    drawing
}

/// The root's path on the ground over the whole clip.
fn root_path(figure: &mut DrawnClip<'_>) -> Vec<Vec3> {
    /// The number of points of the root's path: enough for a smooth curve.
    const POINTS: usize = 240;
    let ticks = figure.ticks(POINTS);
    ticks
        .into_iter()
        .map(|tick| {
            let positions = figure.positions(tick);
            figure.ground_below(figure.root(&positions))
        })
        .collect()
}

fn paint_head(drawing: &mut Drawing, clip: &Clip<'_>, path: &[Vec3], top: f32, row: f32) {
    /// The font height of a name in pixels, as for a heading.
    const NAME: f32 = 15.0;

    /// The font height of facts in pixels: the smallest legible height.
    const FACTS: f32 = 11.0;
    let width = HEAD - MARGIN;
    drawing.text(
        [MARGIN, top + 26.0],
        shortened(clip.name, NAME, width),
        NAME,
        Anchor::Start,
        theme::INK,
    );
    let facts = clip.facts();
    let (time, count) = facts.split_once(", ").unwrap_or((&facts, ""));
    for (line, text) in [time, count].into_iter().enumerate() {
        let at = [MARGIN, top + 44.0 + 15.0 * line as f32];
        drawing.text(at, shortened(text, FACTS, width), FACTS, Anchor::Start, theme::FADED);
    }
    let warnings = clip.scene.warnings.len();
    if warnings > 0 {
        let text = format!("{warnings} warning{}", if warnings == 1 { "" } else { "s" });
        drawing.text([MARGIN, top + 74.0], text, FACTS, Anchor::Start, theme::RIGHT);
    }
    paint_path_from_above(drawing, path, [MARGIN, top + 86.0], [width - MARGIN, row - 112.0]);
}

/// Paints a map of the root's path, given in metres, scaled to fit. In-place motion has no map.
fn paint_path_from_above(drawing: &mut Drawing, path: &[Vec3], [left, top]: Point, [width, height]: Point) {
    /// The extent in metres below which a motion is in place: far above the rounding of such a motion.
    const STILL: f32 = 1e-3;
    let from = path.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let to = path.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let size = to - from;
    if height < 24.0 || !(size.is_finite() && size.x.max(size.z) > STILL) {
        return;
    }
    let (inner_width, inner_height) = (width - 16.0, height - 16.0);
    let scale = (inner_width / size.x.max(f32::MIN_POSITIVE)).min(inner_height / size.z.max(f32::MIN_POSITIVE));
    drawing.rectangle([left, top], [left + width, top + height], theme::GROUND);
    let middle = (from + to) * 0.5;
    let on_map = |point: &Vec3| {
        let from_middle = (*point - middle) * scale;
        [left + 0.5 * width + from_middle.x, top + 0.5 * height + from_middle.z]
    };
    let points: Vec<Point> = path.iter().map(on_map).collect();
    let ends = [points[0], points[points.len() - 1]];
    drawing.line(points, 1.5, theme::FADED);
    drawing.circle(ends[0], 3.0, theme::MIDDLE);
    drawing.circle(ends[1], 3.5, theme::INK);
    let caption = format!(
        "path of the root: {} x {} m",
        short(size.x.into()),
        short(size.z.into())
    );
    drawing.text([left, top + height + 14.0], caption, 10.0, Anchor::Start, theme::FADED);
}

fn paint_poses(
    drawing: &mut Drawing,
    figure: &mut DrawnClip<'_>,
    path: &[Vec3],
    poses: usize,
    [left, top]: Point,
    [cell, row]: Point,
) {
    /// The height in pixels of the space for times, below the poses.
    const CAPTION: f32 = 26.0;
    let poses: Vec<_> = figure
        .ticks(poses)
        .into_iter()
        .map(|tick| (tick, figure.positions(tick)))
        .collect();
    let mut camera = Camera::three_quarters(figure.heading(poses.iter().map(|(_, positions)| &positions[..])));
    let mut extent = Extent::default();
    for (tick, positions) in &poses {
        // Pose the figure, because the skin follows its pose.
        figure.positions(*tick);
        camera.target = figure.ground_below(figure.root(positions));
        extent.include(&camera, figure, positions);
    }
    camera.scale = extent.scale_to(0.88 * cell, row - CAPTION - 18.0);
    let per_second = figure
        .clip
        .animation()
        .map_or(1.0, |animation| animation.ticks_per_second);
    for (index, (tick, positions)) in poses.iter().enumerate() {
        let left = left + cell * index as f32;
        let bottom = top + row - CAPTION;
        figure.positions(*tick);
        camera.target = figure.ground_below(figure.root(positions));
        camera.middle = [
            left + 0.5 * cell - extent.middle() * camera.scale,
            bottom + extent.bottom * camera.scale,
        ];
        let body = Body::new(figure, positions);
        body.paint_shadow(drawing, &camera);
        for piece in inside(
            path,
            &camera,
            [left + 4.0, top + 4.0],
            [left + cell - 4.0, top + row - 16.0],
        ) {
            drawing.line(piece, 1.2, theme::PATH);
        }
        body.paint(drawing, &camera);
        let time = format!("{} s", short(tick / per_second));
        drawing.text(
            [left + 0.5 * cell, top + row - 8.0],
            time,
            11.0,
            Anchor::Middle,
            theme::FADED,
        );
    }
}

/// The segments of a path with points inside a rectangle.
fn inside(path: &[Vec3], camera: &Camera, [left, top]: Point, [right, bottom]: Point) -> Vec<Vec<Point>> {
    let points: Vec<Point> = path.iter().map(|&point| camera.project(point)).collect();
    let is_inside = |point: &Point| (left..=right).contains(&point[0]) && (top..=bottom).contains(&point[1]);
    points
        .split(|point| !is_inside(point))
        .filter(|piece| piece.len() > 1)
        .map(<[Point]>::to_vec)
        .collect()
}
