//! The soles of a robot's feet.

use glam::DVec3;

use crate::scene::robot::{Placement, Robot, RobotShape, ShapeKind};

/// A ball that stays above the floor, in the frame of the foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SoleBall {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

/// How far the corners of a sole may differ in height, as a fraction of the leg.
const SOLE: f64 = 0.03;

/// From the ankle to the floor where nothing shows a sole, as a fraction of the leg, and to the front and the back of
/// it.
const GUESSED: [f64; 3] = [0.1, 0.25, 0.1];

/// The sole of the foot that is `link`: from what collides, else from what is seen, else from the box that has the
/// inertia of the link. `places` are those of the links with all joints at 0; `leg` is the length of a leg. A foot
/// stands on its sole there. Also whether shapes show it.
pub(super) fn sole(robot: &Robot, link: usize, places: &[Placement], ankle: DVec3, leg: f64) -> (Vec<SoleBall>, bool) {
    let foot = &places[link];
    let is_of_foot = |mut here: usize| loop {
        match robot.links[here].parent {
            _ if here == link => return true,
            Some(parent) if !robot.links[here].joint.moves() => here = parent,
            _ => return false,
        }
    };
    let mut balls = Vec::new();
    for collides in [true, false] {
        for (index, part) in robot.links.iter().enumerate().filter(|(index, _)| is_of_foot(*index)) {
            for shape in part.shapes.iter().filter(|shape| shape.collides == collides) {
                let to_foot = |point: DVec3| foot.to_inner(places[index].point(point));
                balls.extend(corners(shape).into_iter().map(|ball| SoleBall {
                    centre: to_foot(ball.centre),
                    ..ball
                }));
            }
        }
        if !balls.is_empty() {
            return (lowest(balls, foot, leg), true);
        }
    }
    let boxed = robot.links[link]
        .inertial
        .and_then(|inertial| inertial.equivalent_box());
    if let Some((place, half_size)) = boxed {
        let shape = RobotShape {
            place,
            kind: ShapeKind::Box { half_size },
            collides: true,
        };
        let found = lowest(corners(&shape), foot, leg);
        if found.len() >= 4 {
            return (found, false);
        }
    }
    let [depth, front, back] = GUESSED.map(|share| share * leg);
    let points = [(front, 0.3), (front, -0.3), (-back, 0.2), (-back, -0.2)];
    let ball = |(along, aside): (f64, f64)| SoleBall {
        centre: foot.to_inner(ankle + DVec3::new(along, aside * front, -depth)),
        radius: 0.0,
    };
    (points.into_iter().map(ball).collect(), false)
}

/// The balls that touch the floor first where all joints are at 0.
fn lowest(balls: Vec<SoleBall>, foot: &Placement, leg: f64) -> Vec<SoleBall> {
    let height = |ball: &SoleBall| foot.point(ball.centre).z - ball.radius;
    let floor = balls.iter().map(height).fold(f64::INFINITY, f64::min);
    let mut balls = balls;
    balls.retain(|ball| height(ball) < floor + SOLE * leg);
    balls
}

/// Balls whose hull is the shape, or is a little larger.
fn corners(shape: &RobotShape) -> Vec<SoleBall> {
    let ball = |centre: DVec3, radius: f64| SoleBall {
        centre: shape.place.point(centre),
        radius,
    };
    let of_box = |low: DVec3, high: DVec3| {
        let corner = |index: usize| {
            let pick = |bit: usize, low: f64, high: f64| if index & bit == 0 { low } else { high };
            DVec3::new(pick(1, low.x, high.x), pick(2, low.y, high.y), pick(4, low.z, high.z))
        };
        (0..8).map(|index| ball(corner(index), 0.0)).collect()
    };
    match &shape.kind {
        ShapeKind::Sphere { radius } => vec![ball(DVec3::ZERO, *radius)],
        ShapeKind::Capsule { radius, half_length } => {
            let end = DVec3::Z * *half_length;
            vec![ball(end, *radius), ball(-end, *radius)]
        }
        ShapeKind::Cylinder { radius, half_length } => {
            let half_size = DVec3::new(*radius, *radius, *half_length);
            of_box(-half_size, half_size)
        }
        ShapeKind::Box { half_size } | ShapeKind::Ellipsoid { half_size } => of_box(-*half_size, *half_size),
        ShapeKind::Mesh { bounds, .. } => bounds.map(|[low, high]| of_box(low, high)).unwrap_or_default(),
    }
}
