//! Approximates the shapes of links by capsules.

use glam::DVec3;
use mocap_scene::scene::robot::{Placement, Robot, RobotShape, ShapeKind};

use super::kinematics::{Kinematics, RobotPose};

/// Half the smallest thickness of a link's shape, in metres. A thinner shape only marks where the foot touches the
/// floor.
const THIN: f64 = 0.011;

/// The radius of a link without a shape, as a fraction of its length.
pub(super) const THICKNESS: f64 = 0.125;

/// The largest number of capsules side by side in one shape.
const MOST_BESIDE: usize = 4;

/// All points within a radius of a line between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    pub ends: [DVec3; 2],
    pub radius: f64,
}

/// The capsules of a body, in its frame, and a ball around all capsules.
#[derive(Clone, Debug, Default)]
pub(super) struct Hull {
    pub(super) capsules: Vec<Capsule>,
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

impl Hull {
    pub(super) fn new(capsules: Vec<Capsule>) -> Self {
        let points = || {
            capsules
                .iter()
                .flat_map(|capsule| capsule.ends.map(|end| (end, capsule.radius)))
        };
        let count = points().count().max(1) as f64;
        let centre = points().map(|(end, _)| end).sum::<DVec3>() / count;
        let radius = points()
            .map(|(end, radius)| end.distance(centre) + radius)
            .fold(0.0, f64::max);
        Self {
            capsules,
            centre,
            radius,
        }
    }
}

/// The capsules of the links of one body, from the collision shapes, else from the visual shapes, else from the boxes
/// with the inertia of the links.
pub(super) fn capsules_of(robot: &Robot, parts: &[(Placement, usize)]) -> Vec<Capsule> {
    for collides in [true, false] {
        let mut capsules = Vec::new();
        for (transform, link) in parts {
            let shapes = robot.links[*link].shapes.iter();
            for shape in shapes.filter(|shape| shape.collides == collides) {
                add_capsules(shape, transform, &mut capsules);
            }
        }
        if !capsules.is_empty() {
            return capsules;
        }
    }
    let mut capsules = Vec::new();
    for (transform, link) in parts {
        let inertial = robot.links[*link].inertial;
        if let Some((within, half_size)) = inertial.and_then(|inertial| inertial.plausible_box()) {
            add_box(half_size, &transform.then(&within), &mut capsules);
        }
    }
    capsules
}

/// Adds capsules from the joint of a body to the joints of its children, for a body without shapes.
pub(super) fn add_bones(kinematics: &Kinematics, zero: &RobotPose, body: usize, capsules: &mut Vec<Capsule>) {
    let transform = zero.bodies[body];
    let joint = |body: usize| transform.to_inner(kinematics.axis(zero, body).1);
    for (child, _) in kinematics
        .bodies
        .iter()
        .enumerate()
        .filter(|(_, other)| other.parent == body)
    {
        let ends = [joint(body), joint(child)];
        let radius = THICKNESS * ends[0].distance(ends[1]);
        if radius >= THIN {
            capsules.push(Capsule { ends, radius });
        }
    }
}

fn add_capsules(shape: &RobotShape, transform: &Placement, capsules: &mut Vec<Capsule>) {
    let transform = transform.then(&shape.origin);
    let mut add = |half_length: f64, radius: f64| {
        if radius >= THIN {
            let end = DVec3::Z * half_length;
            capsules.push(Capsule {
                ends: [transform.point(end), transform.point(-end)],
                radius,
            });
        }
    };
    match &shape.kind {
        ShapeKind::Sphere { radius } => add(0.0, *radius),
        ShapeKind::Capsule { radius, half_length } => add(*half_length, *radius),
        ShapeKind::Cylinder { radius, half_length } if half_length >= radius => add(half_length - radius, *radius),
        // A box with the same area.
        ShapeKind::Cylinder { radius, half_length } => {
            let half_side = 0.5 * std::f64::consts::PI.sqrt() * radius;
            add_box(DVec3::new(half_side, half_side, *half_length), &transform, capsules);
        }
        ShapeKind::Box { half_size } | ShapeKind::Ellipsoid { half_size } => add_box(*half_size, &transform, capsules),
        ShapeKind::Mesh { bounds, .. } => {
            if let Some([low, high]) = bounds {
                let middle = Placement {
                    rotation: transform.rotation,
                    translation: transform.point(0.5 * (*low + *high)),
                };
                add_box(0.5 * (*high - *low), &middle, capsules);
            }
        }
    }
}

/// Adds capsules for a box, side by side: as long as the longest side of the box, and as thick as the shortest.
pub fn add_box(half_size: DVec3, transform: &Placement, capsules: &mut Vec<Capsule>) {
    let mut sides = [
        (half_size.x, DVec3::X),
        (half_size.y, DVec3::Y),
        (half_size.z, DVec3::Z),
    ];
    sides.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [(length, along), (width, across), (radius, _)] = sides;
    if radius < THIN {
        return;
    }
    let aside = width - radius;
    let gaps = (2.0 * aside / radius).ceil().min((MOST_BESIDE - 1) as f64) as usize;
    let end = along * (length - radius);
    for index in 0..=gaps {
        let middle = match gaps {
            0 => DVec3::ZERO,
            _ => across * aside * (2.0 * index as f64 / gaps as f64 - 1.0),
        };
        capsules.push(Capsule {
            ends: [transform.point(middle + end), transform.point(middle - end)],
            radius,
        });
    }
}

pub fn distance(one: [DVec3; 2], other: [DVec3; 2]) -> f64 {
    let [a, b] = nearest(one, other);
    a.distance(b)
}

/// The nearest points of two line segments (C. Ericson, Real-Time Collision Detection, 5.1.9).
pub(super) fn nearest([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> [DVec3; 2] {
    let (first, second, between) = (b - a, d - c, a - c);
    let (length, other_length) = (first.length_squared(), second.length_squared());
    let (along, other_along) = (first.dot(between), second.dot(between));
    let across = first.dot(second);
    let within = |numerator: f64, denominator: f64| match denominator > f64::EPSILON * length.max(other_length) {
        true => (numerator / denominator).clamp(0.0, 1.0),
        false => 0.0,
    };
    // First the point of the first line nearest to the second line. Then the point of the second line nearest to this
    // point, and the point of the first line nearest to that point.
    let area = length * other_length - across * across;
    let mut s = match area > 1e-12 * length * other_length {
        true => ((across * other_along - along * other_length) / area).clamp(0.0, 1.0),
        false => 0.0,
    };
    let t = within(across * s + other_along, other_length);
    s = within(across * t - along, length);
    [a + first * s, c + second * t]
}
