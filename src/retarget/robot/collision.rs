//! Detects collisions between links of a robot, by capsules within their shapes.

use std::ops::Range;

use glam::DVec3;
use mocap_scene::scene::robot::{Placement, Robot, RobotShape, ShapeKind};
use serde::{Deserialize, Serialize};

use super::capsule::{Hull, add_bones, capsules_of, distance, nearest};
use super::kinematics::{Kinematics, RobotPose};
use super::motion::RobotMotion;

/// The guessed shapes of the links whose collision meshes could not be read; `None` if all were read.
pub(super) fn guessed_shapes(robot: &Robot) -> Option<String> {
    let is_unread = |shape: &RobotShape| shape.collides && matches!(shape.kind, ShapeKind::Mesh { bounds: None, .. });
    let unread = robot.links.iter().filter(|link| link.shapes.iter().any(is_unread));
    match (unread.clone().next(), unread.count()) {
        (Some(link), 1) => Some(format!("the shape of {}, whose mesh file could not be read", link.name)),
        (_, 0) => None,
        (_, count) => Some(format!(
            "the shapes of {count} links, whose mesh files could not be read"
        )),
    }
}

/// The smallest penetration depth of two links that counts, in metres.
const DEEP: f64 = 0.01;

/// Two links that penetrate each other.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LinkCollision {
    /// One of the two links: the base, or a link that a joint moves. Links without a moving joint count as parts of
    /// their parent.
    pub link: String,
    /// The other link.
    pub other: String,
    /// The fraction of frames in which the two links penetrate each other by more than 1 cm.
    pub fraction: f64,
    /// The largest penetration depth, in metres.
    pub deepest: f64,
}

/// The self-collisions of a robot in a motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SelfCollision {
    /// The fraction of frames in which two links penetrate each other by more than 1 cm.
    pub fraction: f64,
    /// The links, the deepest first.
    pub links: Vec<LinkCollision>,
}

/// Two bodies that penetrate each other.
pub(super) struct Penetration {
    /// The index of the pair of bodies.
    pub(super) pair: usize,
    /// The nearest points of the axes of both bodies, in the world.
    pub(super) points: [(usize, DVec3); 2],
    /// The direction from the second body to the first.
    pub(super) along: DVec3,
    pub(super) depth: f64,
}

/// The capsules of a robot.
#[derive(Clone, Debug)]
pub struct Collisions {
    /// The capsules of each body of the kinematics.
    hulls: Vec<Hull>,
    /// The name of each body's link.
    pub names: Vec<String>,
    /// The pairs of bodies that can collide.
    pub pairs: Vec<[usize; 2]>,
}

impl Collisions {
    /// Ignores pairs that touch with all joints at 0, and neighbours in the tree.
    pub fn new(robot: &Robot, kinematics: &Kinematics) -> Self {
        let count = kinematics.bodies.len();
        let mut names = vec![String::new(); count];
        let mut parts: Vec<Vec<(Placement, usize)>> = vec![Vec::new(); count];
        for (index, link) in robot.links.iter().enumerate() {
            let (body, transform) = kinematics.body_of(index);
            if link.joint.moves() || link.parent.is_none() {
                names[body].clone_from(&link.name);
            }
            parts[body].push((transform, index));
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

    /// The depth below the floor of the deepest link in a pose, except the links `feet`, which have soles.
    pub(super) fn depth_below_floor(&self, pose: &RobotPose, feet: &[usize]) -> f64 {
        let hulls = self.hulls.iter().zip(&pose.bodies).enumerate();
        let near = hulls.filter(|(body, (hull, at))| at.point(hull.centre).z < hull.radius && !feet.contains(body));
        let depths = near.flat_map(|(_, (hull, at))| {
            let capsules = hull.capsules.iter();
            capsules.flat_map(|capsule| capsule.ends.map(|end| capsule.radius - at.point(end).z))
        });
        depths.fold(0.0, f64::max)
    }

    /// The collisions of links during a motion.
    pub fn measure(&self, kinematics: &Kinematics, motion: &RobotMotion) -> SelfCollision {
        let mut pose = kinematics.rest();
        // For each pair, the number of frames in which it is too deep, and its largest depth.
        let mut found = vec![(0_usize, 0.0_f64); self.pairs.len()];
        let mut colliding_frames = 0_usize;
        for frame in 0..motion.frames() {
            motion.set(frame, kinematics, &mut pose);
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
        let fraction = |frames: usize| frames as f64 / motion.frames().max(1) as f64;
        let pairs = self.pairs.iter().zip(found).filter(|(_, (frames, _))| *frames > 0);
        let mut links: Vec<LinkCollision> = pairs
            .map(|([one, other], (frames, deepest))| LinkCollision {
                link: self.names[*one].clone(),
                other: self.names[*other].clone(),
                fraction: fraction(frames),
                deepest,
            })
            .collect();
        links.sort_by(|a, b| b.deepest.total_cmp(&a.deepest));
        SelfCollision {
            fraction: fraction(colliding_frames),
            links,
        }
    }

    /// The number of frames in which two links penetrate each other by more than 1 cm.
    pub(super) fn colliding_frames(
        &self,
        kinematics: &Kinematics,
        motion: &RobotMotion,
        frames: Range<usize>,
    ) -> usize {
        let mut pose = kinematics.rest();
        let is_colliding = |frame: &usize| {
            motion.set(*frame, kinematics, &mut pose);
            self.touching(&pose, |_| DEEP).next().is_some()
        };
        frames.filter(is_colliding).count()
    }

    /// The pairs of bodies with a penetration deeper than `least(pair)`, where `pair` is the index of the pair. Of each
    /// pair of bodies, only the two deepest capsules count.
    pub(super) fn touching(&self, pose: &RobotPose, least: impl Fn(usize) -> f64) -> impl Iterator<Item = Penetration> {
        let placed = self.hulls.iter().zip(&pose.bodies);
        let centres: Vec<DVec3> = placed.map(|(hull, transform)| transform.point(hull.centre)).collect();
        let pairs = self.pairs.iter().enumerate();
        pairs.filter_map(move |(pair, &[one, other])| {
            let (a, b) = (&self.hulls[one], &self.hulls[other]);
            let least = least(pair);
            if centres[one].distance(centres[other]) > a.radius + b.radius - least {
                return None;
            }
            let (transform, other_transform) = (&pose.bodies[one], &pose.bodies[other]);
            let mut deepest: Option<Penetration> = None;
            for capsule in &a.capsules {
                let ends = capsule.ends.map(|end| transform.point(end));
                for second in &b.capsules {
                    let points = nearest(ends, second.ends.map(|end| other_transform.point(end)));
                    let between = points[0] - points[1];
                    let depth = capsule.radius + second.radius - between.length();
                    if depth > deepest.as_ref().map_or(least, |touch| touch.depth) {
                        deepest = Some(Penetration {
                            pair,
                            points: [(one, points[0]), (other, points[1])],
                            along: between.normalize_or(DVec3::Z),
                            depth,
                        });
                    }
                }
            }
            deepest
        })
    }

    /// The penetration depth of two bodies, in metres. A negative depth means that the bodies are apart, by its
    /// absolute value or more.
    fn depth(&self, [one, other]: [usize; 2], pose: &RobotPose) -> f64 {
        let (a, b) = (&self.hulls[one], &self.hulls[other]);
        let (transform, other_transform) = (&pose.bodies[one], &pose.bodies[other]);
        let near = a.radius + b.radius - transform.point(a.centre).distance(other_transform.point(b.centre));
        if near < 0.0 {
            return near;
        }
        let mut deepest = f64::NEG_INFINITY;
        for capsule in &a.capsules {
            let ends = capsule.ends.map(|end| other_transform.to_inner(transform.point(end)));
            for other in &b.capsules {
                deepest = deepest.max(capsule.radius + other.radius - distance(ends, other.ends));
            }
        }
        deepest
    }
}
