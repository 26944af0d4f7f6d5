//! Projects the world, with +Y up, to a drawing, and paints figures.

use glam::{Quat, Vec2, Vec3};

use super::drawing::{Color, Drawing, Point};
use super::figure::{DrawnClip, Link, Side};
use super::theme;

/// An orthographic camera: it draws equal lengths equal at any distance.
#[derive(Clone, Copy)]
pub(super) struct Camera {
    world_to_camera: Quat,
    /// The world point that the camera looks at.
    pub(super) target: Vec3,
    /// The point of the drawing that shows the target.
    pub(super) middle: Point,
    /// Pixels per unit of length.
    pub(super) scale: f32,
}

impl Camera {
    /// A camera that orbits the figure. `around` is the angle from the front of the figure, `up` the angle above the
    /// horizontal, both in degrees.
    pub(super) fn new(around: f32, up: f32) -> Self {
        Self {
            world_to_camera: Quat::from_rotation_x(up.to_radians()) * Quat::from_rotation_y(-around.to_radians()),
            target: Vec3::ZERO,
            middle: [0.0, 0.0],
            scale: 1.0,
        }
    }

    /// A three-quarter view of a figure with this heading, from slightly above: arms and legs overlap least.
    pub(super) fn three_quarters(heading: f32) -> Self {
        Self::new(35.0 + heading.to_degrees(), 14.0)
    }

    /// The camera coordinates of a point: x to the right, y up, z towards the camera, in units of length.
    pub(super) fn see(&self, point: Vec3) -> Vec3 {
        self.world_to_camera * (point - self.target)
    }

    /// The position of a world point in the drawing.
    pub(super) fn project(&self, point: Vec3) -> Point {
        let seen = self.see(point);
        [
            self.middle[0] + seen.x * self.scale,
            self.middle[1] - seen.y * self.scale,
        ]
    }
}

/// The bounds, relative to a camera's target, of a figure and its shadow in several poses, in units of length.
#[derive(Default)]
pub(super) struct Extent {
    left: f32,
    right: f32,
    pub(super) bottom: f32,
    top: f32,
}

impl Extent {
    /// Includes the skin in the last pose, or the joints if there is no skin, and their projections on the ground.
    /// Controls of a rig may be far from its skin.
    pub(super) fn include(&mut self, camera: &Camera, figure: &DrawnClip<'_>, positions: &[Vec3]) {
        let mut painted: Vec<Vec3> = figure.skins().flat_map(|(_, vertices)| vertices).collect();
        if painted.is_empty() {
            painted.extend(figure.shown(positions));
        }
        for position in painted {
            let shadow = camera.see(figure.ground_below(position));
            let seen = camera.see(position);
            self.left = self.left.min(seen.x);
            self.right = self.right.max(seen.x);
            self.bottom = self.bottom.min(seen.y.min(shadow.y));
            self.top = self.top.max(seen.y);
        }
    }

    /// The scale in pixels per unit of length at which the bounds fit a width and a height in pixels; 1 if the bounds
    /// have no size.
    pub(super) fn scale_to(&self, width: f32, height: f32) -> f32 {
        let scale = (width / (self.right - self.left)).min(height / (self.top - self.bottom));
        if scale.is_finite() { scale } else { 1.0 }
    }

    /// How far the centre of the bounds is to the right of the target, in units of length.
    pub(super) fn middle(&self) -> f32 {
        0.5 * (self.left + self.right)
    }
}

/// The largest width of a bone, as a fraction of its length, as in animation programs.
const BONE_WIDTH: f32 = 0.17;

/// The largest width of a bone, as a fraction of the figure's reach, so that thighs do not look swollen.
const WIDEST_BONE: f32 = 0.065;
/// The radius of a joint, as a fraction of the figure's reach.
const JOINT_RADIUS: f32 = 0.013;

/// Paints the bones from back to front. Each bone is a pointer to the child, with two sides of different brightness.
pub(super) fn paint_figure(drawing: &mut Drawing, camera: &Camera, figure: &DrawnClip<'_>, positions: &[Vec3]) {
    let depth = |link: &Link| camera.see(positions[link.from]).z + camera.see(positions[link.to]).z;
    let mut links: Vec<&Link> = figure.links.iter().collect();
    links.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
    let joint_radius = (JOINT_RADIUS * figure.reach * camera.scale).max(0.9);
    for link in links {
        let color = side_color(link.side);
        let (from, to) = (positions[link.from], positions[link.to]);
        let width = (BONE_WIDTH * from.distance(to)).min(WIDEST_BONE * figure.reach) * camera.scale;
        paint_bone(drawing, camera.project(from), camera.project(to), width, color);
        drawing.circle(camera.project(from), joint_radius, color.mix(theme::INK, 0.35));
    }
    for &node in &figure.lone {
        let color = side_color(Side::of(&figure.clip.scene.nodes[node].name));
        drawing.circle(camera.project(positions[node]), joint_radius.max(2.0), color);
    }
}

/// Paints a pointer from one point to another.
pub(super) fn paint_bone(drawing: &mut Drawing, from: Point, to: Point, width: f32, color: Color) {
    /// The position of a bone's widest point along the bone, as a fraction. This point is near the joint, so that the
    /// bone points to its child.
    const SHOULDER: f32 = 0.18;
    let (start, end) = (Vec2::from(from), Vec2::from(to));
    let along = end - start;
    let across = along.perp().normalize_or_zero() * 0.5 * width.max(1.2);
    let shoulder = start + along * SHOULDER;
    // The light comes from the upper left. The side that faces it is brighter.
    let light_side = if across.x + across.y < 0.0 { across } else { -across };
    for (side, color) in [
        (light_side, color.mix(theme::PAPER, 0.22)),
        (-light_side, color.mix(theme::INK, 0.12)),
    ] {
        drawing.polygon(vec![from, (shoulder + side).to_array(), to], color);
    }
}

/// Paints the shadows of the bones, in light from straight above.
pub(super) fn paint_shadow_of_bones(
    drawing: &mut Drawing,
    camera: &Camera,
    figure: &DrawnClip<'_>,
    positions: &[Vec3],
) {
    let width = (1.4 * WIDEST_BONE * figure.reach * camera.scale).max(2.0);
    for link in &figure.links {
        let ends = [link.from, link.to].map(|node| camera.project(figure.ground_below(positions[node])));
        drawing.line(ends.to_vec(), width, theme::SHADOW);
    }
}

fn side_color(side: Side) -> Color {
    match side {
        Side::Left => theme::LEFT,
        Side::Right => theme::RIGHT,
        Side::Middle => theme::MIDDLE,
    }
}
