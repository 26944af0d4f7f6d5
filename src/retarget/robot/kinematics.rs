//! Forward kinematics of only the moving links, in double precision.

use glam::DVec3;

use mocap_scene::scene::robot::{JointKind, JointLimits, Mimic, Placement, Robot};

/// A moving link, or the base, with the links that are fixed to it.
#[derive(Clone, Debug)]
pub struct Body {
    /// The parent body; the base is its own parent.
    pub(super) parent: usize,
    /// The placement of the body relative to its parent, with the joint at 0.
    origin: Placement,
    pub(super) kind: JointKind,
    pub(super) axis: DVec3,
    anchor: DVec3,
    pub limits: JointLimits,
    /// The bodies whose joints move this body, from the base outwards, including this body but not the base.
    pub(super) chain: Vec<usize>,
}

/// The moving links of a robot: body 0 is the base, and body `d + 1` has the joint of position `d`.
#[derive(Clone, Debug)]
pub struct Kinematics {
    pub bodies: Vec<Body>,
    /// The positions of joints that follow other joints.
    pub(super) followers: Vec<Follower>,
    /// For each link, its body, and the placement of the link in the body.
    of_link: Vec<(usize, Placement)>,
}

/// The position of a joint that follows another joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Follower {
    pub(super) position: usize,
    pub(super) leader: usize,
    pub(super) multiplier: f64,
    offset: f64,
}

/// A pose of the robot.
#[derive(Clone, Debug)]
pub struct RobotPose {
    pub root: Placement,
    pub positions: Vec<f64>,
    /// The bodies in the world.
    pub bodies: Vec<Placement>,
}

impl Kinematics {
    pub fn new(robot: &Robot) -> Self {
        let mut bodies: Vec<Body> = Vec::new();
        let mut of_link: Vec<(usize, Placement)> = Vec::with_capacity(robot.links.len());
        for link in &robot.links {
            let joint = &link.joint;
            let Some((parent, transform)) = link.parent.map(|parent| of_link[parent]) else {
                of_link.push((0, Placement::IDENTITY));
                bodies.push(Body {
                    parent: 0,
                    origin: Placement::IDENTITY,
                    kind: JointKind::Floating,
                    axis: DVec3::Z,
                    anchor: DVec3::ZERO,
                    limits: JointLimits::default(),
                    chain: Vec::new(),
                });
                continue;
            };
            let origin = transform.then(&joint.origin);
            if !joint.moves() {
                of_link.push((parent, origin));
                continue;
            }
            let mut chain = bodies[parent].chain.clone();
            chain.push(bodies.len());
            of_link.push((bodies.len(), Placement::IDENTITY));
            bodies.push(Body {
                parent,
                origin,
                kind: joint.kind,
                axis: joint.axis,
                anchor: joint.anchor,
                limits: joint.limits,
                chain,
            });
        }
        let followers = robot.links.iter().zip(&of_link).filter_map(|(link, (body, _))| {
            let Mimic {
                leader,
                multiplier,
                offset,
            } = link.joint.mimic.filter(|_| link.joint.moves())?;
            let leads = robot.links.get(leader).is_some_and(|leader| leader.joint.moves());
            leads.then_some(Follower {
                position: body.checked_sub(1)?,
                leader: of_link[leader].0.checked_sub(1)?,
                multiplier,
                offset,
            })
        });
        Self {
            followers: followers.collect(),
            bodies,
            of_link,
        }
    }

    /// The body of a link, and the placement of the link in the body.
    pub(super) fn body_of(&self, link: usize) -> (usize, Placement) {
        self.of_link[link]
    }

    /// The pose with every joint as near to 0 as its limits allow.
    pub fn rest(&self) -> RobotPose {
        let rest = |body: &Body| 0.0_f64.max(body.limits.lower).min(body.limits.upper);
        let mut pose = RobotPose {
            root: Placement::IDENTITY,
            positions: self.bodies[1..].iter().map(rest).collect(),
            bodies: vec![Placement::IDENTITY; self.bodies.len()],
        };
        self.update(&mut pose);
        pose
    }

    /// Computes forward kinematics. Followers get the positions that their leaders determine.
    pub fn update(&self, pose: &mut RobotPose) {
        for follower in &self.followers {
            let at = follower.multiplier * pose.positions[follower.leader] + follower.offset;
            // Here, only rounding can exceed the limits.
            let limits = &self.bodies[follower.position + 1].limits;
            pose.positions[follower.position] = at.max(limits.lower).min(limits.upper);
        }
        pose.bodies[0] = pose.root;
        for (index, body) in self.bodies.iter().enumerate().skip(1) {
            let position = pose.positions[index - 1];
            let carried = pose.bodies[body.parent];
            let rotation = carried.rotation * body.origin.rotation;
            let here = carried.point(body.origin.translation);
            pose.bodies[index] = match body.kind {
                JointKind::Slide => Placement {
                    rotation,
                    translation: here + rotation * (position * body.axis),
                },
                _ => {
                    let turn = glam::DQuat::from_axis_angle(body.axis, position);
                    Placement {
                        rotation: (rotation * turn).normalize(),
                        translation: here + rotation * (body.anchor - turn * body.anchor),
                    }
                }
            };
        }
    }

    /// The placement of a link in the world.
    pub(super) fn link(&self, pose: &RobotPose, link: usize) -> Placement {
        let (body, transform) = self.of_link[link];
        pose.bodies[body].then(&transform)
    }

    /// The axis of a body's joint in the world, and a point on it.
    pub(super) fn axis(&self, pose: &RobotPose, body: usize) -> (DVec3, DVec3) {
        let transform = &pose.bodies[body];
        let joint = &self.bodies[body];
        (transform.rotation * joint.axis, transform.point(joint.anchor))
    }
}
