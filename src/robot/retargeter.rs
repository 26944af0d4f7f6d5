//! Puts the motion of a humanoid on a robot.

use glam::{DQuat, DVec2, DVec3, Quat, Vec3};

use super::bones::RobotMap;
use super::collision::Collisions;
use super::kinematics::{Kinematics, RobotPose};
use super::model::{Placement, Robot};
use super::motion::RobotMotion;
use super::report::{self, RobotReport};
use super::sole::SoleBall;
use super::solver::{Bounds, Goals, Reach, Solver, Turn};
use super::twin::{Twin, TwinBone};
use crate::edit::{ContactOptions, contacts};
use crate::error::{Code, Diagnostic, Result};
use crate::pose::{Binding, Pose};
use crate::retarget::{RetargetOptions, Retargeter, Scale};
use crate::scene::{Animation, Channel, HumanoidBone as Bone, Keys, NodeId, Scene, Side};
use crate::skeleton::Humanoid;

/// How a [`RobotRetargeter`] moves a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotOptions {
    /// How large the steps of the robot are. Default: in the proportion of the legs.
    pub scale: Scale,
    /// Which joints of the source are which bones. Default: [`humanoid`](crate::skeleton::humanoid()) finds them.
    pub source: Option<Humanoid>,
    /// Links that are other bones than those that are found.
    pub map: RobotMap,
    /// Whether joints keep within the velocities of the robot's file too. Default: `false`.
    pub velocity_limits: bool,
    /// Whether feet are held on the ground where those of the source stand. Default: `true`.
    pub lock_feet: bool,
}

impl Default for RobotOptions {
    fn default() -> Self {
        Self {
            scale: Scale::Auto,
            source: None,
            map: RobotMap::new(),
            velocity_limits: false,
            lock_feet: true,
        }
    }
}

/// Steps of the solver for the first frame, which has no frame before it, and for the others.
const FIRST_STEPS: usize = 120;
const STEPS: usize = 8;

/// Squares of weights: of directions of limbs, of turns about limbs, of what no joint of an ankle does, and of places, of
/// a metre against a radian.
const DIRECTION: f64 = 1.0;
const TWIST: f64 = 0.01;
const NOT_DRIVEN: f64 = 0.01;
const TRUNK: f64 = 1.0;
const HAND: f64 = 0.2;
const HEAD: f64 = 0.3;
const FOOT_TURN: f64 = 0.3;
/// How many times as much the turn of a foot counts that stands, less 1.
const STANDING: f64 = 12.0;
const FOOT_PLACE: f64 = 10_000.0;
const HIPS_PLACE: f64 = 9.0;

/// How far an ankle is raised to bring its foot above the floor, in metres, before the foot is turned; and how often the
/// interval is halved in which the turn is looked for.
const RAISED: f64 = 0.02;
const HALVINGS: usize = 12;

/// How far a foot that stands is held away from where the twin has it at most, in metres, and how long it takes to come
/// back, in seconds.
const FARTHEST_HELD: f64 = 0.1;
const RETURN: f64 = 0.12;

/// How long a lift above the floor takes to come and to go, in seconds.
const LIFT: f64 = 0.15;

/// A bone of the twin with the body of the robot that follows it.
#[derive(Clone, Debug)]
struct Follower {
    node: NodeId,
    /// The body to the figure's axes in the T-pose.
    body_to_frame: DQuat,
    /// Squares of the weights, of a foot in the air.
    weights: DVec3,
}

/// A point of the robot that goes where a joint of the twin is.
#[derive(Clone, Debug)]
struct Reached {
    node: NodeId,
    /// The joint, in the frame of the body.
    point: DVec3,
    /// Of an ankle: the turn of its foot, and the sole in the frame of the foot's body.
    foot: Option<(usize, Vec<SoleBall>, Side)>,
}

/// A foot from frame to frame.
#[derive(Clone, Copy, Debug, Default)]
struct Stand {
    /// How far the goal of the ankle is from where the twin has it, over the ground.
    shift: DVec2,
    /// The lowest ball of the sole in the frame before, and where it was.
    lowest: Option<(usize, DVec3)>,
    /// From 0 in the air to 1 on the ground, smoothly.
    grip: f64,
}

/// Puts the motions of one source on a robot.
#[derive(Clone, Debug)]
pub struct RobotRetargeter {
    robot: Robot,
    twin: Twin,
    options: RobotOptions,
    retargeter: Retargeter,
    kinematics: Kinematics,
    collisions: Collisions,
    solver: Solver,
    goals: Goals,
    /// For each turn of the goals, whose it is; for each reach, its node.
    turns: Vec<Follower>,
    reaches: Vec<Reached>,
}

impl RobotRetargeter {
    /// Prepares motions of the skeleton of `source` for `robot`. The animations of `source` tell where its floor is.
    ///
    /// # Errors
    /// [`Code::NotHumanoid`] where the source or the robot is no humanoid.
    pub fn new(source: &Scene, robot: &Robot, options: &RobotOptions) -> Result<Self> {
        let bones = robot.bones(Some(&options.map))?;
        let twin = Twin::new(robot, &bones)?;
        let retarget = RetargetOptions {
            scale: options.scale,
            source: options.source.clone(),
            target: Some(twin.humanoid.clone()),
        };
        let retargeter = Retargeter::new(source, &twin.scene, &retarget)?;
        let kinematics = Kinematics::new(robot);
        let mut goals = Goals::default();
        let (mut turns, mut reaches) = (Vec::new(), Vec::new());
        for bone in &twin.bones {
            let (body, place) = kinematics.body_of(bone.link);
            let body_to_frame = (bone.link_to_frame * place.rotation.inverse()).normalize();
            let weights = weights(&twin, bone, robot);
            goals.turns.push(Turn {
                body,
                weight_axes: body_to_frame.inverse(),
                weights,
                target: DQuat::IDENTITY,
            });
            turns.push(Follower {
                node: bone.node,
                body_to_frame,
                weights,
            });
            let weight = match bone.bone.on(Side::Left) {
                Bone::LeftFoot => FOOT_PLACE,
                Bone::Hips => HIPS_PLACE,
                _ => continue,
            };
            goals.reaches.push(Reach {
                body,
                point: place.point(bone.start),
                weight,
                target: DVec3::ZERO,
            });
            let side = bone.bone.side().filter(|_| weight == FOOT_PLACE);
            reaches.push(Reached {
                node: bone.node,
                point: place.point(bone.start),
                foot: side.map(|side| {
                    let balls = twin.soles[side as usize].iter().map(|ball| SoleBall {
                        centre: place.point(ball.centre),
                        ..*ball
                    });
                    (turns.len() - 1, balls.collect(), side)
                }),
            });
        }
        Ok(Self {
            solver: Solver::new(&kinematics, &goals),
            collisions: Collisions::new(robot, &kinematics),
            robot: robot.clone(),
            options: options.clone(),
            twin,
            retargeter,
            kinematics,
            goals,
            turns,
            reaches,
        })
    }

    /// An animation of `source`, by its index, on the robot, and how well it is the same.
    ///
    /// # Errors
    /// [`Code::NoMotion`] where there is no such animation.
    pub fn clip(&mut self, source: &Scene, index: usize) -> Result<(RobotMotion, RobotReport)> {
        let Some(animation) = source.animations.get(index) else {
            let message = format!(
                "there is no animation {index}: the source has {}",
                source.animations.len()
            );
            return Err(Diagnostic::new(Code::NoMotion, message).into());
        };
        let moved = self.retargeter.animation(source, animation);
        let mut held = moved;
        if self.options.lock_feet {
            self.retargeter.lock_feet(source, index, &self.twin.scene, &mut held)?;
        }
        let contacts = self.contacts_of(source, index, animation.frame_count());
        let mut motion = self.follow(&held, animation, contacts);
        self.lift(&mut motion);
        let as_twin = self.as_twin(&motion);
        let found = self.retargeter.measure(source, animation, &self.twin.scene, &as_twin);
        let heights = self.sole_heights(&motion);
        let skate = self.sole_speed(&motion);
        let collisions = self.collisions.measure(&self.kinematics, &motion);
        let report = report::report(&self.robot, &motion, found, skate, &heights, collisions);
        Ok((motion, report))
    }

    /// The robot at each frame of a motion of the twin.
    fn follow(&mut self, held: &Animation, animation: &Animation, contacts: Vec<[bool; 2]>) -> RobotMotion {
        let frames = animation.frame_count();
        let binding = Binding::new(&self.twin.scene, held);
        let mut twin = Pose::rest(&self.twin.scene);
        let mut pose = self.kinematics.rest();
        let limits = self.limits();
        let mut motion = RobotMotion {
            name: animation.name.clone(),
            fps: animation.ticks_per_second,
            root: Vec::with_capacity(frames),
            dof_pos: Vec::with_capacity(frames * pose.positions.len()),
            dof_names: self.robot.dof_names(),
            contacts,
        };
        let mut stands = [Stand::default(); 2];
        let returned = (-1.0 / (RETURN * animation.ticks_per_second)).exp();
        for frame in 0..frames {
            twin.sample(&binding, held, frame as f64);
            self.aim(&twin);
            for (side, stand) in stands.iter_mut().enumerate() {
                let is_held = self.options.lock_feet && frame > 0 && motion.contacts[frame][side];
                self.hold(side, stand, is_held && motion.contacts[frame - 1][side], returned);
            }
            let bounds = match frame {
                0 => {
                    self.begin(&mut pose);
                    limits.clone()
                }
                _ => self.reachable(&limits, &pose, animation.ticks_per_second),
            };
            let steps = if frame == 0 { FIRST_STEPS } else { STEPS };
            self.solver
                .solve(&self.kinematics, &self.goals, &bounds, &mut pose, steps);
            motion.root.push(continued(pose.root, motion.root.last()));
            motion.dof_pos.extend(&pose.positions);
        }
        motion
    }

    /// Sets the goals to a pose of the twin.
    fn aim(&mut self, twin: &Pose) {
        let to_world = self.twin.figure_to_world;
        for (turn, follower) in self.goals.turns.iter_mut().zip(&self.turns) {
            let matrix = &twin.node_to_world[follower.node.index()];
            let frame = Quat::from_mat4(matrix).as_dquat().normalize();
            turn.target = (to_world * frame * follower.body_to_frame).normalize();
        }
        for (reach, reached) in self.goals.reaches.iter_mut().zip(&self.reaches) {
            reach.target = to_world * twin.position(reached.node).as_dvec3();
            reach.point = reached.point;
            let Some((turn, sole, _)) = &reached.foot else { continue };
            let depth = |rotation: DQuat| {
                let depths = sole
                    .iter()
                    .map(|ball| ball.radius - (rotation * (ball.centre - reach.point)).z);
                depths.fold(f64::NEG_INFINITY, f64::max)
            };
            // A foot that would be far below the floor is turned towards standing flat, and the ankle is raised by the rest.
            let goal = &mut self.goals.turns[*turn];
            let tilted = goal.target;
            let upright = tilted * self.turns[*turn].body_to_frame.inverse() * DVec3::Y;
            let flat = DQuat::from_rotation_arc(upright.normalize(), DVec3::Z) * tilted;
            let most = reach.target.z + RAISED;
            if depth(tilted) > most {
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    match depth(tilted.slerp(flat, middle)) > most {
                        true => low = middle,
                        false => high = middle,
                    }
                }
                goal.target = tilted.slerp(flat, high);
            }
            reach.target.z = reach.target.z.max(depth(goal.target));
        }
    }

    /// The ankle of a side: its place among the reaches, the turn of the foot, and the sole.
    fn ankle(&self, side: usize) -> Option<(usize, usize, &[SoleBall])> {
        let feet = self.reaches.iter().enumerate();
        let mut feet = feet.filter_map(|(reach, reached)| reached.foot.as_ref().map(|foot| (reach, foot)));
        let (reach, (turn, sole, _)) = feet.find(|(_, foot)| foot.2 as usize == side)?;
        Some((reach, *turn, sole))
    }

    /// Moves the goal of an ankle so that the point on which the foot stands stays where it is: the foot may roll over it. A
    /// foot that does not stand comes back to where the twin has it. All of it by the goals: what a pose misses would add up.
    fn hold(&mut self, side: usize, stand: &mut Stand, is_held: bool, returned: f64) {
        let Some((reach, turn, sole)) = self.ankle(side) else {
            return;
        };
        let rotation = self.goals.turns[turn].target;
        let goal = &self.goals.reaches[reach];
        let way = |ball: usize| rotation * (sole[ball].centre - goal.point);
        let held = stand.lowest.filter(|_| is_held);
        let held = held.map(|(ball, place)| (place - way(ball) - goal.target).truncate());
        stand.shift = held.unwrap_or(returned * stand.shift).clamp_length_max(FARTHEST_HELD);
        let place = goal.target + stand.shift.extend(0.0);
        let height = |ball: usize| way(ball).z - sole[ball].radius;
        let lowest = (0..sole.len()).min_by(|a, b| height(*a).total_cmp(&height(*b)));
        stand.lowest = lowest.map(|ball| (ball, place + way(ball)));
        // A foot that stands is turned as it should be; one in the air gives way to the leg.
        let grip = f64::from(u8::from(is_held));
        stand.grip = grip + returned * (stand.grip - grip);
        self.goals.reaches[reach].target = place;
        self.goals.turns[turn].weights = self.turns[turn].weights * (1.0 + STANDING * stand.grip);
    }

    /// Puts the base where the hips should be.
    fn begin(&self, pose: &mut RobotPose) {
        let hips = self.twin.bones.iter().position(|bone| bone.bone == Bone::Hips);
        let Some(turn) = hips.map(|hips| &self.goals.turns[hips]) else {
            return;
        };
        let reach = self.goals.reaches.iter().find(|reach| reach.weight == HIPS_PLACE);
        let place = pose.bodies[turn.body];
        let rotation = (turn.target * place.rotation.inverse()).normalize();
        pose.root = Placement {
            rotation: (rotation * pose.root.rotation).normalize(),
            translation: DVec3::ZERO,
        };
        self.kinematics.update(pose);
        if let Some(reach) = reach {
            pose.root.translation = reach.target - pose.bodies[reach.body].point(reach.point);
        }
        self.kinematics.update(pose);
    }

    fn limits(&self) -> Bounds {
        let bodies = &self.kinematics.bodies[1..];
        Bounds {
            lower: bodies.iter().map(|body| body.limits.lower).collect(),
            upper: bodies.iter().map(|body| body.limits.upper).collect(),
        }
    }

    /// The limits, narrowed to what joints reach until the next frame.
    fn reachable(&self, limits: &Bounds, pose: &RobotPose, fps: f64) -> Bounds {
        let mut bounds = limits.clone();
        if !self.options.velocity_limits {
            return bounds;
        }
        for (index, body) in self.kinematics.bodies[1..].iter().enumerate() {
            if let Some(velocity) = body.limits.velocity {
                let (at, way) = (pose.positions[index], velocity / fps);
                bounds.lower[index] = bounds.lower[index].max(at - way);
                bounds.upper[index] = bounds.upper[index].min(at + way);
            }
        }
        bounds
    }

    /// The height of the lowest point of each sole in each frame.
    fn sole_heights(&self, motion: &RobotMotion) -> Vec<[f64; 2]> {
        let feet = [Bone::LeftFoot, Bone::RightFoot].map(|bone| self.twin.bone(bone).map(|bone| bone.link));
        let mut pose = self.kinematics.rest();
        let frames = (0..motion.frames()).map(|frame| {
            self.pose(motion, frame, &mut pose);
            [0, 1].map(|side| {
                let Some(link) = feet[side] else { return f64::INFINITY };
                let foot = self.kinematics.link(&pose, link);
                let heights = self.twin.soles[side]
                    .iter()
                    .map(|ball| foot.point(ball.centre).z - ball.radius);
                heights.fold(f64::INFINITY, f64::min)
            })
        });
        frames.collect()
    }

    /// The mean speed over the ground of the slowest point of a sole, while the foot of the source is at rest: a foot may
    /// roll. `None` where none rests.
    fn sole_speed(&self, motion: &RobotMotion) -> Option<f64> {
        let feet = [Bone::LeftFoot, Bone::RightFoot].map(|bone| self.twin.bone(bone).map(|bone| bone.link));
        let mut pose = self.kinematics.rest();
        let mut before: [Vec<DVec3>; 2] = Default::default();
        let (mut sum, mut count) = (0.0, 0_usize);
        for frame in 0..motion.frames() {
            self.pose(motion, frame, &mut pose);
            for (side, before) in before.iter_mut().enumerate() {
                let Some(link) = feet[side] else { continue };
                let foot = self.kinematics.link(&pose, link);
                let soles = &self.twin.soles[side];
                let places: Vec<DVec3> = soles.iter().map(|ball| foot.point(ball.centre)).collect();
                if frame > 0 && motion.contacts[frame][side] && motion.contacts[frame - 1][side] {
                    let steps = places.iter().zip(&*before);
                    let steps = steps.map(|(place, before)| (*place - *before).truncate().length());
                    sum += steps.fold(f64::INFINITY, f64::min) * motion.fps;
                    count += 1;
                }
                *before = places;
            }
        }
        (count > 0)
            .then(|| sum / count as f64)
            .filter(|speed| speed.is_finite())
    }

    fn pose(&self, motion: &RobotMotion, frame: usize, pose: &mut RobotPose) {
        pose.root = motion.root[frame];
        pose.positions.copy_from_slice(motion.dof_of(frame));
        self.kinematics.update(pose);
    }

    /// Raises the robot smoothly wherever a sole would be below the floor.
    fn lift(&self, motion: &mut RobotMotion) {
        let below = self
            .sole_heights(motion)
            .into_iter()
            .map(|[left, right]| (-left.min(right)).max(0.0));
        let below: Vec<f64> = below.collect();
        let half = (0.5 * LIFT * motion.fps).ceil().min(1e6) as usize;
        let window = |frame: usize| frame.saturating_sub(half)..(frame + half + 1).min(below.len());
        // The largest of a window, then the mean of those: at least what is needed, and without a jump.
        let largest: Vec<f64> = (0..below.len())
            .map(|frame| below[window(frame)].iter().copied().fold(0.0, f64::max))
            .collect();
        for (frame, root) in motion.root.iter_mut().enumerate() {
            let near = &largest[window(frame)];
            root.translation.z += near.iter().sum::<f64>() / near.len().max(1) as f64;
        }
    }

    fn contacts_of(&self, source: &Scene, index: usize, frames: usize) -> Vec<[bool; 2]> {
        let found = contacts(source, index, self.options.source.as_ref(), &ContactOptions::default());
        let Ok(found) = found else {
            return vec![[false; 2]; frames];
        };
        let rests = |side: Side, frame: usize| {
            let mut points = found.points.iter().filter(|point| point.bone.side() == Some(side));
            points.any(|point| point.at_rest.get(frame) == Some(&true))
        };
        (0..frames)
            .map(|frame| Side::ALL.map(|side| rests(side, frame)))
            .collect()
    }

    /// The motion of the robot as one of the twin whose joints are where those of the robot are.
    fn as_twin(&self, motion: &RobotMotion) -> Animation {
        let nodes = &self.twin.scene.nodes;
        let frames = motion.frames();
        let to_figure = self.twin.figure_to_world.inverse();
        let mut places: Vec<Option<(Vec<Vec3>, Vec<Quat>)>> = vec![None; nodes.len()];
        let mut pose = self.kinematics.rest();
        let mut world = vec![Placement::IDENTITY; nodes.len()];
        let mut driven = vec![false; nodes.len()];
        self.twin.bones.iter().for_each(|bone| driven[bone.node.index()] = true);
        self.twin
            .tips
            .iter()
            .for_each(|(node, _, _)| driven[node.index()] = true);
        for frame in 0..frames {
            self.pose(motion, frame, &mut pose);
            for TwinBone {
                node,
                link,
                link_to_frame,
                start,
                ..
            } in &self.twin.bones
            {
                let place = self.kinematics.link(&pose, *link);
                world[node.index()] = Placement {
                    rotation: (to_figure * place.rotation * link_to_frame.inverse()).normalize(),
                    translation: to_figure * place.point(*start),
                };
            }
            for (node, link, point) in &self.twin.tips {
                let place = self.kinematics.link(&pose, *link);
                let parent = nodes[node.index()].parent.map_or(0, NodeId::index);
                world[node.index()] = Placement {
                    rotation: world[parent].rotation,
                    translation: to_figure * place.point(*point),
                };
            }
            for (index, node) in nodes.iter().enumerate().filter(|(index, _)| driven[*index]) {
                let parent = node.parent.map_or(Placement::IDENTITY, |parent| world[parent.index()]);
                let (positions, rotations) = places[index].get_or_insert_with(Default::default);
                positions.push(parent.to_inner(world[index].translation).as_vec3());
                rotations.push(
                    (parent.rotation.inverse() * world[index].rotation)
                        .normalize()
                        .as_quat(),
                );
            }
        }
        let channels = places.into_iter().enumerate().filter_map(|(index, tracks)| {
            let (positions, rotations) = tracks?;
            Some(Channel {
                node_name: nodes[index].name.clone(),
                node: Some(NodeId::new(index)),
                position_keys: Keys::every_tick(positions),
                rotation_keys: Keys::every_tick(rotations),
                scaling_keys: Keys::constant(Vec3::ONE),
            })
        });
        Animation {
            name: motion.name.clone(),
            ticks_per_second: motion.fps,
            duration: frames.saturating_sub(1) as f64,
            channels: channels.collect(),
        }
    }
}

/// Squares of the weights of a bone's turn about left, up and forward of the figure in the T-pose.
fn weights(twin: &Twin, bone: &TwinBone, robot: &Robot) -> DVec3 {
    match bone.bone.on(Side::Left) {
        Bone::LeftUpperLeg | Bone::LeftLowerLeg => DVec3::new(DIRECTION, TWIST, DIRECTION),
        Bone::LeftUpperArm | Bone::LeftLowerArm => DVec3::new(TWIST, DIRECTION, DIRECTION),
        Bone::LeftHand => DVec3::splat(HAND),
        Bone::Head => DVec3::splat(HEAD),
        Bone::LeftFoot => {
            let places = robot.zero_pose();
            let drives = |direction: DVec3| {
                let axes = bone
                    .joints
                    .iter()
                    .map(|joint| places[*joint].rotation * robot.links[*joint].joint.axis);
                let mut along = axes.map(|axis| (twin.figure_to_world.inverse() * axis).dot(direction).abs());
                along.any(|along| along > 0.7)
            };
            let weight = |direction| if drives(direction) { FOOT_TURN } else { NOT_DRIVEN };
            // A foot is turned about the up axis by the hip.
            DVec3::new(weight(DVec3::X), 0.3 * FOOT_TURN, weight(DVec3::Z))
        }
        _ => DVec3::splat(TRUNK),
    }
}

/// The same rotation on the shorter arc from the frame before.
fn continued(root: Placement, before: Option<&Placement>) -> Placement {
    let turned_away = before.is_some_and(|before| before.rotation.dot(root.rotation) < 0.0);
    Placement {
        rotation: if turned_away { -root.rotation } else { root.rotation },
        ..root
    }
}
