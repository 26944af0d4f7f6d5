//! The surfaces of a body that hands touch.
//!
//! Each part is a capsule with elliptic sections, in the axes that its bone has in the T-pose: +X left, +Y up, +Z
//! forward. A place on a part of one body corresponds to a place on the same part of another body. Three values state a
//! place: the distance along the capsule's axis, the direction away from the axis, and the height above the surface.
//! The direction is measured in half-axes of the elliptic section.

use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec3, Vec3Swizzles};
use mocap_figure::body::Body;
use mocap_figure::{HumanoidBone as Bone, Side};
use mocap_scene::math::directions::{arc, rotation_of};
use mocap_scene::math::median::{median, percentile};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene};

use crate::hand_report::TouchedPart;

/// The leg length in metres of the body to which the lengths in this file apply: a body of 1.7 m.
pub(super) const LEG: f32 = 0.84;

/// Half the size of a head in metres: 156 mm wide, 194 mm long, 232 mm high (NASA, Anthropometric Source Book, 1978,
/// medians of men).
const HEAD: Vec3 = Vec3::new(0.078, 0.116, 0.097);

/// The vector from the joint of the head, below the ears, to the middle of the head, in metres.
const HEAD_MIDDLE: Vec3 = Vec3::new(0.0, 0.085, 0.02);

/// Half the width and half the depth of the hips in metres, from the same source.
const HIPS: Vec3 = Vec3::new(0.165, 0.11, 0.11);

/// Half the width and half the depth of the chest in metres, from the same source.
const CHEST: Vec3 = Vec3::new(0.15, 0.12, 0.12);

/// The height of the waist above the hip joints, in metres.
const WAIST: f32 = 0.16;

/// The distance of the chest's upper end below the joints of the upper arms, in metres.
const BELOW_SHOULDERS: f32 = 0.1;

/// The radii of a thigh at the hip and the knee, in metres, from the same source.
const THIGH: [f32; 2] = [0.085, 0.058];

/// The radii of a shin at the knee and the ankle, in metres, from the same source.
const SHIN: [f32; 2] = [0.055, 0.04];

/// The smallest number of vertices of the skin that show the size of a part.
const SKIN: usize = 24;

/// The smallest and the largest ratio of a part's size in the skin to its size by proportion.
const SKIN_RANGE: [f32; 2] = [0.5, 3.0];

/// The fraction of the vertices that are ignored as outside a part, such as belts.
const OUTSIDE: f64 = 0.03;

/// The fraction of the vertices that are ignored as outside a head: single hairs. The fraction is small, because most
/// vertices of a head are in the face.
const OUTSIDE_OF_HEAD: f64 = 0.005;

/// The number of directions from top to bottom in which the outline of a head is measured: one every 18 degrees.
const ROWS: usize = 11;

/// The number of directions around the head: one every 18 degrees.
const COLUMNS: usize = 20;

/// The largest number of vertices of a hand that are kept out of the head.
const HAND_VERTICES: usize = 240;

/// The ranges at the ends of a limb in which its radii are measured, as fractions of its length.
const AT_ENDS: [[f32; 2]; 2] = [[0.15, 0.4], [0.75, 1.0]];

/// The fraction of a thigh at which the knee begins.
const KNEE: f32 = 0.75;

/// The cosine of the largest angle at which a place is in front of the thigh.
const IN_FRONT: f32 = 0.5;

/// A part of a body.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub(super) part: TouchedPart,
    joint: NodeId,
    frame_to_joint: Quat,
    /// The ends of the part's axis, relative to the joint.
    axis: [Vec3; 2],
    /// The joint at which the axis of a limb ends.
    end: Option<NodeId>,
    /// Half the size of the part in each direction, at both ends of the axis.
    extents: [Vec3; 2],
    /// The distances of a head's skin from the middle of the head, in directions from top to bottom and all around:
    /// [`ROWS`] x [`COLUMNS`]. Empty for an ellipsoid, without a skin.
    outline: Vec<f32>,
}

/// A part in a pose, in the axes of the figure.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedShape<'a> {
    shape: &'a Shape,
    rotation: Quat,
    start: Vec3,
    axis: Vec3,
}

/// A place near a part.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spot {
    /// The position along the axis, from 0 to 1.
    along: f32,
    /// The offset from this position, in the axes of the part.
    offset: Vec3,
    /// The offset from the start of the axis, in the axes of the part.
    pub(super) from_start: Vec3,
}

/// The data of each part: its joint, the joint at which a limb ends, its axis and its size at both ends, for a body
/// whose legs are [`LEG`] long.
type PartTable = (TouchedPart, Bone, Option<Bone>, [Vec3; 2]);

const PARTS: [PartTable; 7] = [
    (TouchedPart::Head, Bone::Head, None, [HEAD; 2]),
    (TouchedPart::Chest, Bone::Chest, None, [CHEST; 2]),
    (TouchedPart::Hips, Bone::Hips, None, [HIPS; 2]),
    (
        TouchedPart::LeftThigh,
        Bone::LeftUpperLeg,
        Some(Bone::LeftLowerLeg),
        [Vec3::splat(THIGH[0]), Vec3::splat(THIGH[1])],
    ),
    (
        TouchedPart::RightThigh,
        Bone::RightUpperLeg,
        Some(Bone::RightLowerLeg),
        [Vec3::splat(THIGH[0]), Vec3::splat(THIGH[1])],
    ),
    (
        TouchedPart::LeftShin,
        Bone::LeftLowerLeg,
        Some(Bone::LeftFoot),
        [Vec3::splat(SHIN[0]), Vec3::splat(SHIN[1])],
    ),
    (
        TouchedPart::RightShin,
        Bone::RightLowerLeg,
        Some(Bone::RightFoot),
        [Vec3::splat(SHIN[0]), Vec3::splat(SHIN[1])],
    ),
];

/// The parts of a body.
pub(super) fn shapes(body: &Body, scene: &Scene) -> Vec<Shape> {
    let size = body.leg / LEG;
    let skin = skin(body, scene);
    let middle = |left: Bone| {
        let [left, right] = Side::ALL.map(|side| body.joint(left.on(side)));
        Some(body.position(left?).midpoint(body.position(right?)))
    };
    let hips = middle(Bone::LeftUpperLeg).unwrap_or_else(|| body.position(body.hips));
    let shoulders = middle(Bone::LeftUpperArm);
    let mut shapes = Vec::new();
    for (part, bone, end, extents) in PARTS {
        let (bone, joint) = match bone {
            Bone::Chest => {
                let trunk = [Bone::UpperChest, Bone::Chest, Bone::Spine].into_iter();
                let Some(found) = trunk.filter_map(|bone| Some((bone, body.joint(bone)?))).next() else {
                    continue;
                };
                found
            }
            bone => match body.joint(bone) {
                Some(joint) => (bone, joint),
                None => continue,
            },
        };
        let to_frame = (body.frame_to_joint(bone, joint) * body.rotation(joint).inverse()).normalize();
        let place = |point: Vec3| to_frame * (point - body.position(joint));
        let up = Vec3::Y * size;
        let axis = match part {
            TouchedPart::Head => [HEAD_MIDDLE * size; 2],
            TouchedPart::Hips => [place(hips), place(hips) + up * WAIST],
            TouchedPart::Chest => {
                let Some(shoulders) = shoulders else { continue };
                let top = place(shoulders) - up * BELOW_SHOULDERS;
                [top.lerp(place(hips), 0.35), top]
            }
            _ => [Vec3::ZERO; 2],
        };
        let mut shape = Shape {
            part,
            joint,
            frame_to_joint: body.frame_to_joint(bone, joint),
            axis,
            end: None,
            extents: extents.map(|extent| extent * size),
            outline: Vec::new(),
        };
        if let Some(end) = end {
            let Some(end) = body.joint(end) else { continue };
            shape.end = Some(end);
            shape.axis[1] = place(body.position(end));
        }
        if let Some(points) = skin.get(&bone).filter(|points| points.len() >= SKIN) {
            shape.fit(points);
        }
        shapes.push(shape);
    }
    shapes
}

/// The vertices of the skin that move mostly with each bone, relative to the joint, in the axes that the bone has in
/// the T-pose.
fn skin(body: &Body, scene: &Scene) -> HashMap<Bone, Vec<Vec3>> {
    let rest = Pose::rest(scene);
    let bone_of: HashMap<usize, Bone> = body.bones.iter().map(|(bone, joint)| (joint.index(), *bone)).collect();
    let owner = |node: NodeId| {
        let above = std::iter::successors(Some(node.index()), |node| body.hierarchy.parents[*node]);
        let bone = above.filter_map(|node| bone_of.get(&node).copied()).next()?;
        Some(match bone {
            Bone::Jaw | Bone::LeftEye | Bone::RightEye => Bone::Head,
            bone => bone,
        })
    };
    let mut points: HashMap<Bone, Vec<Vec3>> = HashMap::new();
    for mesh in scene.meshes.iter().filter(|mesh| !mesh.name.is_empty()) {
        for bone in &mesh.bones {
            let Some((owner, joint)) = owner(bone.node).and_then(|owner| Some((owner, body.joint(owner)?))) else {
                continue;
            };
            let to_world = rest.node_to_world[bone.node.index()] * bone.offset_matrix;
            let to_frame =
                body.frame_to_joint(owner, joint) * rotation_of(&rest.node_to_world[joint.index()]).inverse();
            let of_bone = bone.weights.iter().filter(|weight| weight.weight > 0.5);
            let vertices = of_bone.filter_map(|weight| mesh.vertices.get(weight.vertex_id as usize));
            let placed = vertices.map(|vertex| to_frame * (to_world.transform_point3(*vertex) - rest.position(joint)));
            points
                .entry(owner)
                .or_default()
                .extend(placed.filter(|point| point.is_finite()));
        }
    }
    points
}

impl Spot {
    /// A place with a known position only.
    pub(super) fn at(position: Vec3) -> Self {
        Self {
            from_start: position,
            ..Self::default()
        }
    }

    /// The direction away from the axis, in the axes of the part.
    fn direction(&self) -> Vec3 {
        self.offset.normalize_or(Vec3::Z)
    }

    /// Whether the place is at the side of a thigh or behind it, not in front of it or at its knee.
    pub(super) fn is_aside(&self) -> bool {
        self.along < KNEE && self.offset.z < IN_FRONT * self.offset.length()
    }
}

impl Shape {
    /// Fits the size of the part to the vertices of its skin.
    fn fit(&mut self, points: &[Vec3]) {
        let [least, most] = SKIN_RANGE;
        let bounded = |value: f32, by_proportion: f32| value.clamp(least * by_proportion, most * by_proportion);
        if self.end.is_some() {
            let line = self.axis[1];
            for (extent, [from, to]) in self.extents.iter_mut().zip(AT_ENDS) {
                let along = |point: &Vec3| point.dot(line) / line.length_squared();
                let near = points.iter().filter(|point| (from..=to).contains(&along(point)));
                let mut radii: Vec<f32> = near.map(|point| point.reject_from(line).length()).collect();
                if radii.len() >= SKIN / 2
                    && let Some(radius) = median(&mut radii)
                {
                    *extent = Vec3::splat(bounded(radius, extent.x));
                }
            }
            return;
        }
        let is_head = self.part == TouchedPart::Head;
        // The neck does not belong to the head, and a thigh does not belong to the hips.
        let is_of_part = |point: &&Vec3| match self.part {
            TouchedPart::Head => point.y > 0.0,
            _ => point.y > self.axis[0].y,
        };
        let outline = |axis: usize| {
            let values: Vec<f32> = points.iter().filter(is_of_part).map(|point| point[axis]).collect();
            let outside = if is_head { OUTSIDE_OF_HEAD } else { OUTSIDE };
            let [low, high] = [outside, 1.0 - outside].map(|rank| percentile(values.iter().copied(), rank, f64::round));
            Some((low?, high?)).filter(|_| values.len() >= SKIN)
        };
        let Some(outlines) = [outline(0), outline(1), outline(2)]
            .into_iter()
            .collect::<Option<Vec<_>>>()
        else {
            return;
        };
        for (axis, (low, high)) in outlines.into_iter().enumerate() {
            // The joints determine the height of the trunk.
            if axis == 1 && !is_head {
                continue;
            }
            let (half, middle) = (0.5 * (high - low), 0.5 * (high + low));
            for (extent, end) in self.extents.iter_mut().zip(&mut self.axis) {
                extent[axis] = bounded(half, extent[axis]);
                end[axis] = middle;
            }
        }
        if is_head {
            let cell = |index: usize| direction(index / COLUMNS, index % COLUMNS);
            self.outline = (0..ROWS * COLUMNS).map(|index| self.radius(0.0, cell(index))).collect();
            let mut seen = vec![0.0_f32; self.outline.len()];
            for offset in points.iter().map(|point| *point - self.axis[0]) {
                let [row, column] = cell_of(offset).map(f32::round);
                let cell = &mut seen[row as usize * COLUMNS + column as usize % COLUMNS];
                *cell = cell.max(offset.length());
            }
            let seen = self.outline.iter_mut().zip(seen).filter(|(_, seen)| *seen > 0.0);
            seen.for_each(|(radius, seen)| *radius = seen);
        }
    }

    /// The distance of the surface from the axis in a direction of unit length, in the axes of the part.
    fn radius(&self, along: f32, direction: Vec3) -> f32 {
        if self.outline.is_empty() {
            return (direction / self.extents[0].lerp(self.extents[1], along))
                .length()
                .recip();
        }
        let [row, column] = cell_of(direction);
        let (above, left) = (row.floor() as usize, column.floor() as usize);
        let at = |row: usize, column: usize| self.outline[row.min(ROWS - 1) * COLUMNS + column % COLUMNS];
        let of_row = |row: usize| at(row, left) + column.fract() * (at(row, left + 1) - at(row, left));
        of_row(above) + row.fract() * (of_row(above + 1) - of_row(above))
    }

    /// The distance of a place from the surface, negative inside.
    fn gap(&self, spot: &Spot) -> f32 {
        spot.offset.length() - self.radius(spot.along, spot.direction())
    }

    /// The part in a pose.
    pub(super) fn placed(&self, body: &Body, pose: &Pose) -> PlacedShape<'_> {
        let to_figure = body.axes.inverse();
        let rotation = to_figure * rotation_of(&pose.node_to_world[self.joint.index()]) * self.frame_to_joint.inverse();
        let joint = to_figure * pose.position(self.joint);
        let start = joint + rotation * self.axis[0];
        let (rotation, end) = match self.end {
            Some(end) => {
                let end = to_figure * pose.position(end);
                (arc(rotation * self.axis[1], end - start) * rotation, end)
            }
            None => (rotation, joint + rotation * self.axis[1]),
        };
        PlacedShape {
            shape: self,
            rotation,
            start,
            axis: rotation.inverse() * (end - start),
        }
    }
}

/// The direction of a cell of an outline.
fn direction(row: usize, column: usize) -> Vec3 {
    let (sin, cos) = (PI * row as f32 / (ROWS - 1) as f32).sin_cos();
    let (z, x) = (TAU * column as f32 / COLUMNS as f32).sin_cos();
    Vec3::new(sin * x, cos, sin * z)
}

/// The position of a direction among the cells of an outline. The direction may have any length.
fn cell_of(direction: Vec3) -> [f32; 2] {
    let down = direction.xz().length().atan2(direction.y) / PI;
    let around = direction.z.atan2(direction.x).rem_euclid(TAU) / TAU;
    [down * (ROWS - 1) as f32, around * COLUMNS as f32]
}

/// Vertices of the skin of a hand, in the axes of its joint, without the scale of the joint.
pub(super) fn hand_vertices(body: &Body, scene: &Scene, hand: NodeId) -> Vec<Vec3> {
    let rest = Pose::rest(scene);
    let to_joint = rotation_of(&rest.node_to_world[hand.index()]).inverse();
    let mut vertices = Vec::new();
    for mesh in scene.meshes.iter().filter(|mesh| !mesh.name.is_empty()) {
        let is_of_hand = |node: NodeId| node == hand || body.depends_on(node, hand);
        for bone in mesh.bones.iter().filter(|bone| is_of_hand(bone.node)) {
            let to_world = rest.node_to_world[bone.node.index()] * bone.offset_matrix;
            let of_bone = bone.weights.iter().filter(|weight| weight.weight > 0.5);
            let of_bone = of_bone.filter_map(|weight| mesh.vertices.get(weight.vertex_id as usize));
            vertices
                .extend(of_bone.map(|vertex| to_joint * (to_world.transform_point3(*vertex) - rest.position(hand))));
        }
    }
    let step = vertices.len().div_ceil(HAND_VERTICES).max(1);
    vertices
        .into_iter()
        .step_by(step)
        .filter(|vertex| vertex.is_finite())
        .collect()
}

/// A smooth maximum of two lengths. If they are equal, the result is larger by half of `corner`. With a maximum that is
/// not smooth, the path of a hand would have a corner, which is a jerk.
pub(super) fn larger([one, other]: [f32; 2], corner: f32) -> f32 {
    0.5 * (one + other + (one - other).hypot(corner))
}

impl PlacedShape<'_> {
    /// The place of a point relative to the part.
    pub(super) fn spot(&self, point: Vec3) -> Spot {
        let from_start = self.rotation.inverse() * (point - self.start);
        let along = from_start.dot(self.axis) / self.axis.length_squared();
        let along = if along.is_finite() { along.clamp(0.0, 1.0) } else { 0.0 };
        Spot {
            along,
            offset: from_start - self.axis * along,
            from_start,
        }
    }

    /// The distance of a place from the surface, negative inside.
    pub(super) fn gap(&self, spot: &Spot) -> f32 {
        self.shape.gap(spot)
    }

    /// The direction away from the part at a place, in the axes of the figure.
    pub(super) fn away(&self, spot: &Spot) -> Vec3 {
        self.rotation * spot.direction()
    }

    /// The position on this part for a place on `source`. Gaps are multiplied by `scale`, and are at least `least`.
    pub(super) fn point(&self, source: &Shape, spot: &Spot, scale: f32, least: f32) -> Vec3 {
        let extent = |shape: &Shape| shape.extents[0].lerp(shape.extents[1], spot.along);
        let direction = (spot.direction() * extent(self.shape) / extent(source)).normalize();
        let gap = larger([scale * source.gap(spot), least], 0.5 * least);
        let radius = self.shape.radius(spot.along, direction);
        self.start + self.rotation * (self.axis * spot.along + direction * (radius + gap))
    }
}
