//! Finds the soles of a robot's feet.

use glam::{DQuat, DVec2, DVec3};

use mocap_scene::math::hull::{area, convex_hull};
use mocap_scene::scene::robot::{Placement, Robot, RobotShape, ShapeKind};

/// A ball that is a part of a foot's shape, in the coordinate frame of the foot. The ball must stay above the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoleBall {
    pub centre: DVec3,
    pub radius: f64,
}

impl SoleBall {
    /// The lowest point of the ball if the foot has the placement `foot`.
    pub fn bottom(&self, foot: &Placement) -> DVec3 {
        foot.point(self.centre) - self.radius * DVec3::Z
    }
}

/// The height of the lowest point of the balls of a foot. `foot` is the placement of the foot. The height is infinite
/// without balls.
pub fn lowest_point(balls: &[SoleBall], foot: &Placement) -> f64 {
    let heights = balls.iter().map(|ball| ball.bottom(foot).z);
    heights.fold(f64::INFINITY, f64::min)
}

/// The sole of a foot.
#[derive(Clone, Debug)]
pub struct Sole {
    pub balls: Vec<SoleBall>,
    /// The rotation of the foot from its pose with all joints at 0 to the pose in which it stands flat, in the axes of
    /// the robot.
    pub to_flat: DQuat,
    /// Whether shapes in the robot's file show the sole.
    pub is_shown: bool,
}

/// The largest height difference between the corners of a sole, as a fraction of the leg.
const SOLE: f64 = 0.03;

/// The dimensions of a sole that no shape shows, as fractions of the leg. They are the distances from the ankle to the
/// floor, to the front end and to the back end.
const GUESSED: [f64; 3] = [0.1, 0.25, 0.1];

/// The longest side of a foot, as a fraction of the leg. A longer box with the inertia of the link is not a foot.
const LONGEST: f64 = 0.6;

/// The largest tilt of a foot with all joints at 0, in degrees. Knees of some robots are bent in this pose.
const MOST_TILTED: usize = 48;

/// The step of the search for the sole, in degrees: half of the angle at which a face stands on an edge.
const TILT_STEP: usize = 3;

/// The smallest size of the face on which a tilted foot stands, as a multiple of the face that touches the floor
/// without a rotation.
const LARGER: f64 = 1.5;

/// The largest distance of balls from the plane of a face, as a fraction of the leg.
const FACE: f64 = 0.01;

/// The sole of the foot `link`. It comes from the collision shapes of the link. Without these, it comes from its visual
/// shapes, or from the box that has the inertia of the link. `zero_pose` has the placements of the links with all
/// joints at 0. `leg` is the length of a leg. With all joints at 0, a foot stands on its sole, or on a larger face that
/// is tilted against the floor.
pub fn sole(robot: &Robot, link: usize, zero_pose: &[Placement], ankle: DVec3, leg: f64) -> Sole {
    let foot = &zero_pose[link];
    let is_of_foot = |mut here: usize| loop {
        match robot.links[here].parent {
            _ if here == link => return true,
            Some(parent) if !robot.links[here].joint.moves() => here = parent,
            _ => return false,
        }
    };
    for collides in [true, false] {
        let parts = robot.links.iter().enumerate().filter(|(index, _)| is_of_foot(*index));
        let balls: Vec<SoleBall> = parts
            .flat_map(|(index, part)| {
                let shapes = part.shapes.iter().filter(|shape| shape.collides == collides);
                shapes.flat_map(move |shape| balls(shape, &zero_pose[index]))
            })
            .collect();
        if !balls.is_empty() {
            return on_the_floor(balls, foot, leg, true);
        }
    }
    let boxed = robot.links[link]
        .inertial
        .and_then(|inertial| inertial.equivalent_box())
        .filter(|(_, half_size)| 2.0 * half_size.max_element() <= LONGEST * leg);
    if let Some((transform, half_size)) = boxed {
        let shape = RobotShape {
            origin: transform,
            kind: ShapeKind::Box { half_size },
            collides: true,
        };
        let found = on_the_floor(balls(&shape, foot), foot, leg, false);
        if found.balls.len() >= 4 {
            return found;
        }
    }
    let [depth, front, back] = GUESSED.map(|fraction| fraction * leg);
    let points = [(front, 0.3), (front, -0.3), (-back, 0.2), (-back, -0.2)];
    let ball = |(along, aside): (f64, f64)| SoleBall {
        centre: foot.to_inner(ankle + DVec3::new(along, aside * front, -depth)),
        radius: 0.0,
    };
    Sole {
        balls: points.into_iter().map(ball).collect(),
        to_flat: DQuat::IDENTITY,
        is_shown: false,
    }
}

/// The balls of a shape of a link with the placement `transform`, in the robot's axes.
pub fn balls(shape: &RobotShape, transform: &Placement) -> Vec<SoleBall> {
    let balls = shape.balls().into_iter();
    let ball = |(centre, radius)| SoleBall {
        centre: transform.point(centre),
        radius,
    };
    balls.map(ball).collect()
}

/// The sole of a foot from balls in the robot's axes.
pub fn on_the_floor(mut balls: Vec<SoleBall>, foot: &Placement, leg: f64, is_shown: bool) -> Sole {
    let to_flat = to_flat(&balls, leg);
    let height = |ball: &SoleBall| (to_flat * ball.centre).z - ball.radius;
    let floor = balls.iter().map(height).fold(f64::INFINITY, f64::min);
    balls.retain(|ball| height(ball) < floor + SOLE * leg);
    for ball in &mut balls {
        ball.centre = foot.to_inner(ball.centre);
    }
    Sole {
        balls,
        to_flat,
        is_shown,
    }
}

/// The rotation of a foot to the largest face on which it can stand; identity if it already stands on this face.
fn to_flat(balls: &[SoleBall], leg: f64) -> DQuat {
    let as_it_is = face(balls, DVec3::NEG_Z, leg);
    let mut best = (
        LARGER * area(&convex_hull(&mut spread(&as_it_is, DVec3::NEG_Z))),
        DVec3::NEG_Z,
    );
    for tilt in (TILT_STEP..=MOST_TILTED).step_by(TILT_STEP) {
        for around in (0..360).step_by(2 * TILT_STEP) {
            let [tilt, around] = [tilt, around].map(|degrees| (degrees as f64).to_radians());
            let (aside, down) = tilt.sin_cos();
            let along = DVec3::new(aside * around.cos(), aside * around.sin(), -down);
            let area = area(&convex_hull(&mut spread(&face(balls, along, leg), along)));
            // Of faces with the same size, choose the face with the smaller tilt.
            if area > 1.02 * best.0 {
                best = (area, along);
            }
        }
    }
    if best.1 == DVec3::NEG_Z {
        return DQuat::IDENTITY;
    }
    let normal = normal(&face(balls, best.1, leg)).map_or(best.1, |normal| {
        let normal = normal * normal.dot(best.1).signum();
        if normal.dot(best.1) > 0.95 { normal } else { best.1 }
    });
    DQuat::from_rotation_arc(normal, DVec3::NEG_Z)
}

/// The lowest points of the balls that touch a floor in the direction `down`.
fn face(balls: &[SoleBall], down: DVec3, leg: f64) -> Vec<DVec3> {
    let points = balls.iter().map(|ball| ball.centre + ball.radius * down);
    let deepest = points
        .clone()
        .map(|point| point.dot(down))
        .fold(f64::NEG_INFINITY, f64::max);
    points.filter(|point| point.dot(down) > deepest - FACE * leg).collect()
}

/// The projection of points along a direction.
fn spread(points: &[DVec3], along: DVec3) -> Vec<DVec2> {
    let (x, y) = along.any_orthonormal_pair();
    points
        .iter()
        .map(|point| DVec2::new(point.dot(x), point.dot(y)))
        .collect()
}

/// The normal of the plane of points: of the triangle with the most distant points.
fn normal(points: &[DVec3]) -> Option<DVec3> {
    let first = *points.first()?;
    let farthest = |from: &dyn Fn(&DVec3) -> f64| points.iter().copied().max_by(|a, b| from(a).total_cmp(&from(b)));
    let second = farthest(&|point| point.distance_squared(first))?;
    let third = farthest(&|point| (*point - first).cross(second - first).length_squared())?;
    (second - first).cross(third - first).try_normalize()
}
