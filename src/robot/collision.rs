//! Links of a robot that touch each other, by capsules within their shapes.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::kinematics::{Kinematics, RobotPose};
use super::motion::RobotMotion;
use crate::scene::robot::{Placement, Robot, RobotShape, ShapeKind};

/// How deep two links penetrate each other where that counts, in metres.
const DEEP: f64 = 0.01;

/// A shape that is thinner than twice this is a mark where the foot touches the floor, not the link, in metres.
const THIN: f64 = 0.011;

/// The radius of a link without a shape, as a fraction of its length.
const THICKNESS: f64 = 0.125;

/// Capsules side by side in one shape.
const MOST_BESIDE: usize = 4;

/// Two links that penetrate each other.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LinkCollision {
    /// The links that carry the shapes: those with a joint, or the base.
    pub link: String,
    /// The other one.
    pub other: String,
    /// The fraction of frames in which they penetrate each other by more than 1 cm.
    pub share: f64,
    /// How deep at most, in metres.
    pub deepest: f64,
}

/// Which links of a robot collide.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct SelfCollision {
    /// The fraction of frames in which two links penetrate each other by more than 1 cm.
    pub(super) share: f64,
    /// The links, the deepest first.
    pub(super) links: Vec<LinkCollision>,
}

/// All points within a radius of a line between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Capsule {
    ends: [DVec3; 2],
    radius: f64,
}

/// The capsules of a body, in its frame, and a ball around them.
#[derive(Clone, Debug, Default)]
struct Hull {
    capsules: Vec<Capsule>,
    centre: DVec3,
    radius: f64,
}

/// The capsules of a robot.
#[derive(Clone, Debug)]
pub(super) struct Collisions {
    /// For each body of the kinematics.
    hulls: Vec<Hull>,
    /// For each body the name of its link.
    names: Vec<String>,
    /// The bodies that can touch.
    pairs: Vec<[usize; 2]>,
}

impl Collisions {
    /// Pairs that touch where all joints are at 0, and neighbours in the tree, are left out.
    pub(super) fn new(robot: &Robot, kinematics: &Kinematics) -> Self {
        let count = kinematics.bodies.len();
        let mut names = vec![String::new(); count];
        let mut parts: Vec<Vec<(Placement, usize)>> = vec![Vec::new(); count];
        for (index, link) in robot.links.iter().enumerate() {
            let (body, place) = kinematics.body_of(index);
            if link.joint.moves() || link.parent.is_none() {
                names[body].clone_from(&link.name);
            }
            parts[body].push((place, index));
        }
        let mut zero = kinematics.rest();
        zero.positions.fill(0.0);
        kinematics.update(&mut zero);
        let hulls = parts.iter().enumerate().map(|(body, parts)| {
            let mut capsules = capsules_of(robot, parts);
            if capsules.is_empty() {
                add_bones(kinematics, &zero, body, &mut capsules);
            }
            Hull::new(capsules)
        });
        let mut collisions = Self {
            hulls: hulls.collect(),
            names,
            pairs: Vec::new(),
        };
        for one in 0..count {
            for other in one + 1..count {
                let is_neighbour = kinematics.bodies[other].parent == one;
                let has_shape = |body: usize| !collisions.hulls[body].capsules.is_empty();
                if !is_neighbour && has_shape(one) && has_shape(other) && collisions.depth([one, other], &zero) < 0.0 {
                    collisions.pairs.push([one, other]);
                }
            }
        }
        collisions
    }

    /// Which links collide during a motion.
    pub(super) fn measure(&self, kinematics: &Kinematics, motion: &RobotMotion) -> SelfCollision {
        let mut pose = kinematics.rest();
        // In how many frames each pair is too deep, and how deep at most.
        let mut found = vec![(0_usize, 0.0_f64); self.pairs.len()];
        let mut colliding_frames = 0_usize;
        for frame in 0..motion.frames() {
            pose.root = motion.root[frame];
            pose.positions.copy_from_slice(motion.dof_of(frame));
            kinematics.update(&mut pose);
            let mut is_colliding = false;
            for (pair, (frames, deepest)) in self.pairs.iter().zip(&mut found) {
                let depth = self.depth(*pair, &pose);
                if depth > DEEP {
                    *frames += 1;
                    *deepest = deepest.max(depth);
                    is_colliding = true;
                }
            }
            colliding_frames += usize::from(is_colliding);
        }
        let share = |frames: usize| frames as f64 / motion.frames().max(1) as f64;
        let pairs = self.pairs.iter().zip(found).filter(|(_, (frames, _))| *frames > 0);
        let mut links: Vec<LinkCollision> = pairs
            .map(|([one, other], (frames, deepest))| LinkCollision {
                link: self.names[*one].clone(),
                other: self.names[*other].clone(),
                share: share(frames),
                deepest,
            })
            .collect();
        links.sort_by(|a, b| b.deepest.total_cmp(&a.deepest));
        SelfCollision {
            share: share(colliding_frames),
            links,
        }
    }

    /// How deep two bodies penetrate each other; below 0 how far they are apart at least.
    fn depth(&self, [one, other]: [usize; 2], pose: &RobotPose) -> f64 {
        let (a, b) = (&self.hulls[one], &self.hulls[other]);
        let (place, other_place) = (&pose.bodies[one], &pose.bodies[other]);
        let near = a.radius + b.radius - place.point(a.centre).distance(other_place.point(b.centre));
        if near < 0.0 {
            return near;
        }
        let mut deepest = f64::NEG_INFINITY;
        for capsule in &a.capsules {
            let ends = capsule.ends.map(|end| other_place.to_inner(place.point(end)));
            for other in &b.capsules {
                deepest = deepest.max(capsule.radius + other.radius - distance(ends, other.ends));
            }
        }
        deepest
    }
}

impl Hull {
    fn new(capsules: Vec<Capsule>) -> Self {
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

/// The capsules of the links of one body: of what collides, else of what is seen, else of the boxes that have their
/// inertia.
fn capsules_of(robot: &Robot, parts: &[(Placement, usize)]) -> Vec<Capsule> {
    for collides in [true, false] {
        let mut capsules = Vec::new();
        for (place, link) in parts {
            let shapes = robot.links[*link].shapes.iter();
            for shape in shapes.filter(|shape| shape.collides == collides) {
                add_capsules(shape, place, &mut capsules);
            }
        }
        if !capsules.is_empty() {
            return capsules;
        }
    }
    let mut capsules = Vec::new();
    for (place, link) in parts {
        let inertial = robot.links[*link].inertial;
        if let Some((within, half_size)) = inertial.and_then(|inertial| inertial.equivalent_box()) {
            add_box(half_size, &place.then(&within), &mut capsules);
        }
    }
    capsules
}

/// Capsules from the joint of a body to those of its children, for a body without shapes.
fn add_bones(kinematics: &Kinematics, zero: &RobotPose, body: usize, capsules: &mut Vec<Capsule>) {
    let place = zero.bodies[body];
    let joint = |body: usize| place.to_inner(kinematics.axis(zero, body).1);
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

fn add_capsules(shape: &RobotShape, place: &Placement, capsules: &mut Vec<Capsule>) {
    let place = place.then(&shape.place);
    let mut add = |half_length: f64, radius: f64| {
        if radius >= THIN {
            let end = DVec3::Z * half_length;
            capsules.push(Capsule {
                ends: [place.point(end), place.point(-end)],
                radius,
            });
        }
    };
    match &shape.kind {
        ShapeKind::Sphere { radius } => add(0.0, *radius),
        ShapeKind::Capsule { radius, half_length } => add(*half_length, *radius),
        ShapeKind::Cylinder { radius, half_length } if half_length >= radius => add(half_length - radius, *radius),
        // As a box with the same area.
        ShapeKind::Cylinder { radius, half_length } => {
            let half_side = 0.5 * std::f64::consts::PI.sqrt() * radius;
            add_box(DVec3::new(half_side, half_side, *half_length), &place, capsules);
        }
        ShapeKind::Box { half_size } | ShapeKind::Ellipsoid { half_size } => add_box(*half_size, &place, capsules),
        ShapeKind::Mesh { bounds, .. } => {
            if let Some([low, high]) = bounds {
                let middle = Placement {
                    rotation: place.rotation,
                    translation: place.point(0.5 * (*low + *high)),
                };
                add_box(0.5 * (*high - *low), &middle, capsules);
            }
        }
    }
}

/// Capsules within a box: as long as its longest side and as thick as its shortest, side by side.
fn add_box(half_size: DVec3, place: &Placement, capsules: &mut Vec<Capsule>) {
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
            ends: [place.point(middle + end), place.point(middle - end)],
            radius,
        });
    }
}

/// The distance of two line segments (C. Ericson, Real-Time Collision Detection, 5.1.9).
fn distance([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
    let (first, second, between) = (b - a, d - c, a - c);
    let (length, other_length) = (first.length_squared(), second.length_squared());
    let (along, other_along) = (first.dot(between), second.dot(between));
    let across = first.dot(second);
    let within = |numerator: f64, denominator: f64| match denominator > f64::EPSILON * length.max(other_length) {
        true => (numerator / denominator).clamp(0.0, 1.0),
        false => 0.0,
    };
    // The point of the first line that is nearest to the second, the point of the second that is nearest to that, and
    // back.
    let area = length * other_length - across * across;
    let mut s = match area > 1e-12 * length * other_length {
        true => ((across * other_along - along * other_length) / area).clamp(0.0, 1.0),
        false => 0.0,
    };
    let t = within(across * s + other_along, other_length);
    s = within(across * t - along, length);
    (between + first * s - second * t).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_as_far_apart_as_their_nearest_points() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        for round in 0..90 {
            let mut point = || DVec3::new(random(), random(), random());
            let (mut one, mut other) = ([point(), point()], [point(), point()]);
            match round % 6 {
                0 => one[1] = one[0],
                1 => other[1] = other[0],
                2 => other[1] = other[0] + 0.7 * (one[1] - one[0]),
                3 => (one[1], other[1]) = (one[0], other[0]),
                _ => {}
            }
            let found = distance(one, other);
            // Points on both, on a grid.
            const STEPS: usize = 80;
            let on = |[a, b]: [DVec3; 2], step: usize| a.lerp(b, step as f64 / STEPS as f64);
            let steps = (0..=STEPS).flat_map(|s| (0..=STEPS).map(move |t| (s, t)));
            let nearest = steps
                .map(|(s, t)| on(one, s).distance(on(other, t)))
                .fold(f64::INFINITY, f64::min);
            assert!(found <= nearest + 1e-9, "{round}: {found} {nearest}");
            assert!(nearest - found < 2.0 / STEPS as f64, "{round}: {found} {nearest}");
        }
    }

    #[test]
    fn capsules_are_within_their_box() {
        for half_size in [
            DVec3::new(0.3, 0.02, 0.1),
            DVec3::splat(0.2),
            DVec3::new(0.05, 0.4, 0.06),
        ] {
            let mut capsules = Vec::new();
            add_box(half_size, &Placement::IDENTITY, &mut capsules);
            assert!(!capsules.is_empty());
            for capsule in &capsules {
                for end in capsule.ends {
                    assert!(
                        (end.abs() + capsule.radius - half_size).max_element() < 1e-12,
                        "{capsule:?}"
                    );
                }
            }
            // They reach each of its sides.
            for axis in 0..3 {
                let reach = |capsule: &Capsule| capsule.ends.map(|end| end[axis] + capsule.radius);
                let farthest = capsules.iter().flat_map(reach).fold(0.0, f64::max);
                assert!((farthest - half_size[axis]).abs() < 1e-12, "{half_size} {axis}");
            }
        }
    }

    /// Two arms that point forward, a tail that touches them from below where all joints are at 0.
    const ROBOT: &str = r#"<mujoco><compiler angle="degree"/><worldbody><body name="base">
        <geom type="box" size="0.35 0.35 0.1"/>
        <body name="left" pos="0 0.3 0"><joint name="l" axis="0 0 1"/>
          <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.05"/></body>
        <body name="right" pos="0 -0.3 0"><joint name="r" axis="0 0 1"/>
          <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.05"/></body>
        <body name="mount" pos="0 0 -0.2"><joint name="m" axis="0 0 1"/>
          <body name="tail"><joint name="t" axis="0 1 0"/>
            <geom type="box" size="0.5 0.5 0.16"/></body></body>
        </body></worldbody></mujoco>"#;

    #[test]
    fn links_that_collide_are_found_but_neighbours_and_those_that_touch_at_rest_are_not() {
        let robot = crate::Importer::new()
            .read_robot(ROBOT.as_bytes(), "robot.xml")
            .unwrap();
        let kinematics = Kinematics::new(&robot);
        let collisions = Collisions::new(&robot, &kinematics);
        let names = |pair: &[usize; 2]| pair.map(|body| collisions.names[body].as_str());
        let pairs: Vec<_> = collisions.pairs.iter().map(names).collect();
        assert_eq!(pairs, [["left", "right"]]);
        // Ahead; across each other, 0.4 m long and 0.6 m apart; tip to tip, 0.06 m apart.
        let tips = (0.54_f64 / 0.8).acos();
        let across = std::f64::consts::FRAC_PI_2;
        let dof_pos = [
            [0.0; 4],
            [-across, across, 0.0, 0.0],
            [tips - across, across - tips, 0.0, 0.0],
            [0.0; 4],
        ];
        let mut motion = RobotMotion {
            name: String::new(),
            fps: 30.0,
            root: vec![Placement::IDENTITY; dof_pos.len()],
            dof_pos: dof_pos.concat(),
            dof_names: robot.dof_names(),
            contacts: vec![[false; 2]; dof_pos.len()],
        };
        let found = collisions.measure(&kinematics, &motion);
        assert_eq!(found.share, 0.5);
        let [pair] = &found.links[..] else { panic!("{found:?}") };
        assert_eq!(
            (pair.link.as_str(), pair.other.as_str(), pair.share),
            ("left", "right", 0.5)
        );
        assert!((pair.deepest - 0.1).abs() < 1e-9, "{pair:?}");
        motion.dof_pos.copy_within(8..12, 4);
        let pair = &collisions.measure(&kinematics, &motion).links[0];
        assert!((pair.deepest - 0.04).abs() < 1e-9, "{pair:?}");
    }
}
