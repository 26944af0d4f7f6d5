//! The goals of the robot's links: the bones of the twin, a figure with the robot's proportions. Feet keep their
//! place on the floor.

use glam::{DQuat, DVec2, DVec3, Quat};
use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::pose::Pose;
use mocap_scene::scene::robot::{Placement, Robot, RobotShape};
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Side};

use super::kinematics::{Kinematics, RobotPose};
use super::terms::{Goals, Reach, RotationGoal};
use super::twin::{StandIn, StandInBone};
use super::weights::Weights;
use mocap_figure::robot_bones::sole::SoleBall;

/// The weight of the direction of a limb and of the rotation of the trunk, in 1/rad^2. All [`Weights`] are relative to
/// it.
const DIRECTION: f64 = 1.0;

/// The weight of the base of a robot without legs, in 1/rad^2 and 1/m^2. It is a thousand times the weight of a foot in
/// stance, so that the base moves by micrometres at most.
const FIXED: f64 = 1e7;

/// The largest raise of an ankle to bring the foot above the floor, in metres. If more is needed, the foot is rotated.
/// Soles of boxes and balls differ from the source's soles by this distance.
const RAISED: f64 = 0.02;

/// The number of halvings of the interval of a foot's rotation: 180 degrees become 0.04.
const HALVINGS: usize = 12;

/// The body lies if its hips are tilted by more than 60 degrees from upright. This is the cosine of 60 degrees.
const LYING: f64 = 0.5;

/// The smallest height difference at which a foot changes to another, lower ball of its sole, in metres. The residual
/// of the solver is smaller, so the ball does not change from frame to frame.
const LOWER: f64 = 0.002;

/// The smallest cosine of the angle between an axis of the figure and a joint of the ankle that drives it: 45 degrees.
const DRIVES: f64 = 0.7;

/// A bone of the twin, with the body of the robot that follows it.
#[derive(Clone, Debug)]
struct Follower {
    node: NodeId,
    /// The rotation from the body to the figure's axes in the T-pose.
    body_to_frame: DQuat,
    /// The squared weights of the bone. For a foot, these are the weights while the foot is in the air.
    weights: DVec3,
    /// The axis along a thigh or an upper arm, in the figure's axes; `None` for other bones. The roll about this axis
    /// determines the direction in which knees and elbows bend.
    along: Option<DVec3>,
}

/// A point of the robot that follows a joint of the twin.
#[derive(Clone, Debug)]
struct ReachPoint {
    node: NodeId,
    /// The position of the joint, in the frame of the body.
    point: DVec3,
    /// For an ankle, the rotation goal of its foot, and the sole in the frame of the foot's body.
    foot: Option<(usize, Vec<SoleBall>, Side)>,
}

/// The state of a foot from frame to frame.
#[derive(Clone, Debug, Default)]
pub(super) struct FootState {
    /// The vector from the ankle of the twin to the goal of the ankle.
    shift: DVec3,
    /// The ball of the sole on which the foot stands, and its fixed horizontal position.
    ball: Option<(usize, DVec2)>,
    /// The height of the ball above its goal.
    above: f64,
    /// The grip of the foot, from 0 in the air to 1 on the ground. It changes smoothly.
    grip: f64,
    /// The position of the twin's ankle, and the height of its sole.
    twin: DVec3,
    height: f64,
    /// The positions of the sole's balls in the previous frame.
    points: Vec<DVec3>,
}

/// The goals of the solver, with the bones and joints that they follow.
#[derive(Clone, Debug)]
pub struct SolverGoals {
    pub goals: Goals,
    /// The bone of each rotation goal, and the node of each position goal.
    rotations: Vec<Follower>,
    reaches: Vec<ReachPoint>,
    figure_to_world: DQuat,
    /// The fixed placement of the base of a robot without legs.
    pub(super) stand: Option<Placement>,
    /// The heading of the source, as a rotation about the up axis.
    pub(super) heading: DQuat,
    settings: Weights,
}

impl SolverGoals {
    pub fn new(robot: &Robot, kinematics: &Kinematics, twin: &StandIn, settings: &Weights) -> Self {
        let mut goals = Goals::default();
        let (mut rotations, mut reaches) = (Vec::new(), Vec::new());
        for bone in &twin.bones {
            let (body, transform) = kinematics.body_of(bone.link);
            let body_to_frame = (bone.link_to_frame * transform.rotation.inverse()).normalize();
            let weights = weights(twin, bone, robot, settings);
            goals.rotations.push(RotationGoal {
                body,
                weight_axes: body_to_frame.inverse(),
                weights,
                target: DQuat::IDENTITY,
            });
            rotations.push(Follower {
                node: bone.node,
                body_to_frame,
                weights,
                along: match bone.bone.on(Side::Left) {
                    Bone::LeftUpperLeg => Some(DVec3::Y),
                    Bone::LeftUpperArm => Some(DVec3::X),
                    _ => None,
                },
            });
            let (weight, side) = match bone.bone.on(Side::Left) {
                Bone::LeftFoot => (settings.foot_place, bone.bone.side()),
                Bone::Hips => (settings.hips_place, None),
                _ => continue,
            };
            goals.reaches.push(Reach {
                body,
                point: transform.point(bone.start),
                weight: DVec3::splat(weight),
                target: DVec3::ZERO,
            });
            reaches.push(ReachPoint {
                node: bone.node,
                point: transform.point(bone.start),
                foot: side.map(|side| {
                    let balls = twin.soles[side as usize].iter().map(|ball| SoleBall {
                        centre: transform.point(ball.centre),
                        ..*ball
                    });
                    (rotations.len() - 1, balls.collect(), side)
                }),
            });
        }
        // The last position goals are the balls on which the feet stand.
        for side in Side::ALL {
            let feet = reaches
                .iter()
                .position(|reached: &ReachPoint| reached.foot.as_ref().is_some_and(|foot| foot.2 == side));
            let foot: &Reach = &goals.reaches[feet.unwrap_or_default()];
            goals.reaches.push(Reach {
                weight: DVec3::ZERO,
                ..foot.clone()
            });
        }
        Self {
            goals,
            rotations,
            reaches,
            figure_to_world: twin.figure_to_world,
            stand: (!twin.has_legs).then(|| stand(robot)),
            heading: DQuat::IDENTITY,
            settings: *settings,
        }
        .with_fixed_base()
    }

    /// Adds goals that keep the base of a robot without legs in its place.
    fn with_fixed_base(mut self) -> Self {
        if self.stand.is_some()
            && let Some((turn, reach)) = self.hips_places()
        {
            self.goals.rotations[turn].weights = DVec3::splat(FIXED);
            self.goals.reaches[reach].weight = DVec3::splat(FIXED);
        }
        self
    }

    /// The goals of the hips: the indices of the rotation and of the position.
    fn hips_places(&self) -> Option<(usize, usize)> {
        let reach = self.reaches.iter().position(|reached| reached.foot.is_none())?;
        let turn = self
            .rotations
            .iter()
            .position(|turn| turn.node == self.reaches[reach].node)?;
        Some((turn, reach))
    }

    /// The index of the hips' position goal.
    pub(super) fn hips_reach(&self) -> Option<usize> {
        self.hips_places().map(|(_, reach)| reach)
    }

    /// The goals of the hips.
    pub(super) fn hips(&self) -> Option<(&RotationGoal, &Reach)> {
        let (turn, reach) = self.hips_places()?;
        Some((&self.goals.rotations[turn], &self.goals.reaches[reach]))
    }

    /// The points of both soles that would touch the floor, if the goals were reached.
    pub(super) fn sole_points(&self) -> [Vec<DVec3>; 2] {
        [0, 1].map(|side| {
            let Some((ankle, turn, sole)) = self.ankle(side) else {
                return Vec::new();
            };
            let (rotation, ankle) = (self.goals.rotations[turn].target, &self.goals.reaches[ankle]);
            let point =
                |ball: &SoleBall| ankle.target + rotation * (ball.centre - ankle.point) - ball.radius * DVec3::Z;
            sole.iter().map(point).collect()
        })
    }

    /// The heights of the lowest points of both soles, if the goals were reached.
    pub(super) fn heights(&self) -> [f64; 2] {
        self.sole_points().map(|sole| lowest(&sole))
    }

    /// Sets the goals to a pose of the twin, lowered by `drop`.
    pub(super) fn aim(&mut self, twin: &Pose, drop: f64) {
        self.face(twin);
        let to_world = self.heading.inverse() * self.figure_to_world;
        for (turn, follower) in self.goals.rotations.iter_mut().zip(&self.rotations) {
            let matrix = &twin.node_to_world[follower.node.index()];
            let frame = Quat::from_mat4(matrix).as_dquat().normalize();
            turn.target = (to_world * frame * follower.body_to_frame).normalize();
        }
        for (reach, reached) in self.goals.reaches.iter_mut().zip(&self.reaches) {
            reach.target = to_world * twin.position(reached.node).as_dvec3() - drop * DVec3::Z;
            reach.point = reached.point;
            let Some((turn, sole, side)) = &reached.foot else {
                continue;
            };
            let depth = |rotation: DQuat| {
                let depths = sole
                    .iter()
                    .map(|ball| ball.radius - (rotation * (ball.centre - reach.point)).z);
                depths.fold(f64::NEG_INFINITY, f64::max)
            };
            // A foot far below the floor is rotated towards standing flat, and the ankle is raised by the remaining
            // depth.
            let goal = &mut self.goals.rotations[*turn];
            let tilted = goal.target;
            let upright = tilted * self.rotations[*turn].body_to_frame.inverse() * DVec3::Y;
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
            let clearance = self.goals.clearances[*side as usize];
            reach.target.z = reach.target.z.max(depth(goal.target) + clearance);
        }
        if let (Some(stand), Some((turn, reach))) = (&self.stand, self.hips_places()) {
            self.goals.rotations[turn].target = stand.rotation;
            let reach = &mut self.goals.reaches[reach];
            reach.target = stand.point(reach.point);
        }
    }

    /// Determines the heading of the twin's hips, for a robot whose base does not rotate with them. Lying hips keep
    /// their previous heading.
    fn face(&mut self, twin: &Pose) {
        let Some((turn, _)) = self.hips_places().filter(|_| self.stand.is_some()) else {
            return;
        };
        let hips = Quat::from_mat4(&twin.node_to_world[self.rotations[turn].node.index()]).as_dquat();
        let [from, to] = [DVec3::Z, hips * DVec3::Z].map(|up| self.figure_to_world * up);
        if to.truncate().length() > LYING {
            self.heading = DQuat::from_rotation_z(from.truncate().angle_to(to.truncate()));
        }
    }

    /// The fraction of a foot's distance from the twin's foot that remains after a frame.
    pub(super) fn returned(&self, fps: f64) -> f64 {
        (-1.0 / (self.settings.return_time * fps)).exp()
    }

    /// The ankle of a side: the index of its position goal, the index of the foot's rotation goal, and the sole.
    fn ankle(&self, side: usize) -> Option<(usize, usize, &[SoleBall])> {
        let feet = self.reaches.iter().enumerate();
        let mut feet = feet.filter_map(|(reach, reached)| reached.foot.as_ref().map(|foot| (reach, foot)));
        let (reach, (turn, sole, _)) = feet.find(|(_, foot)| foot.2 as usize == side)?;
        Some((reach, *turn, sole))
    }

    /// Holds the ball on which a foot stands at its place of the previous frame. The foot may roll over the ball. A
    /// foot that is not in stance returns to the foot of the twin.
    pub(super) fn hold(&mut self, side: usize, stand: &mut FootState, is_held: bool, returned: f64) {
        let Some((ankle, turn, sole)) = self.ankle(side) else {
            return;
        };
        let (rotation, twin) = (self.goals.rotations[turn].target, self.goals.reaches[ankle].target);
        let offset = |ball: usize| rotation * (sole[ball].centre - self.reaches[ankle].point);
        let height = |ball: usize| twin.z + offset(ball).z - sole[ball].radius;
        let height = (0..sole.len()).map(height).fold(f64::INFINITY, f64::min);
        let was = |ball: usize| stand.points[ball].z - sole[ball].radius;
        let lowest = (0..stand.points.len()).min_by(|a, b| was(*a).total_cmp(&was(*b)));
        stand.above *= returned;
        stand.shift *= returned;
        stand.ball = match (stand.ball, lowest.filter(|_| is_held)) {
            (Some((ball, anchor)), Some(lowest)) if was(ball) <= was(lowest) + LOWER => Some((ball, anchor)),
            (_, Some(lowest)) => {
                stand.above = was(lowest) - stand.height;
                Some((lowest, stand.points[lowest].truncate()))
            }
            (_, None) => None,
        };
        let mut held = Reach {
            weight: DVec3::ZERO,
            ..self.goals.reaches[self.reaches.len() + side].clone()
        };
        if let Some((ball, anchor)) = &mut stand.ball {
            let there = (twin + offset(*ball)).truncate();
            *anchor = there + (*anchor - there).clamp_length_max(self.settings.held_distance);
            held.point = sole[*ball].centre;
            held.target = anchor.extend(height + stand.above + sole[*ball].radius);
            held.weight = DVec3::splat(self.settings.foot_place);
        }
        // A foot in stance has its wanted rotation. A foot in the air follows the leg.
        let grip = f64::from(u8::from(is_held));
        stand.grip = grip + returned * (stand.grip - grip);
        (stand.twin, stand.height) = (twin, height);
        self.goals.rotations[turn].weights = self.rotations[turn].weights * (1.0 + self.settings.standing * stand.grip);
        let goal = &mut self.goals.reaches[ankle];
        goal.target += stand.shift;
        goal.weight = self.settings.foot_place - held.weight;
        self.goals.reaches[self.reaches.len() + side] = held;
    }

    /// The mean roll of thighs and upper arms relative to the source in a pose, in radians.
    pub(super) fn roll(&self, goals: &Goals, pose: &RobotPose) -> Option<f64> {
        let rotations = goals.rotations.iter().zip(&self.rotations);
        let rolls = rotations.filter_map(|(turn, follower)| {
            let rotation = pose.bodies[turn.body].rotation;
            let along = rotation * turn.weight_axes * follower.along?;
            let apart = rotation_vector(turn.target * rotation.inverse());
            Some(apart.dot(along).abs())
        });
        let (count, sum) = rolls.fold((0_usize, 0.0), |(count, sum), roll| (count + 1, sum + roll));
        (count > 0).then(|| sum / count as f64)
    }

    /// Whether the hips lie.
    pub(super) fn is_lying(&self, goals: &Goals) -> bool {
        let hips = self.hips().and_then(|(turn, _)| {
            let index = goals.rotations.iter().position(|other| other.body == turn.body)?;
            Some(goals.rotations[index].target * self.rotations[index].body_to_frame.inverse() * DVec3::Y)
        });
        hips.is_some_and(|up| up.z < LYING)
    }

    /// Raises the hips and the ankles of goals. Feet in stance keep their height.
    pub(super) fn raise(&self, goals: &mut Goals, by: f64) {
        let joints = goals.reaches.iter_mut().take(self.reaches.len());
        joints.for_each(|reach| reach.target.z += by);
    }

    /// The bodies of the feet, with their soles.
    pub(super) fn soles(&self) -> Vec<(usize, Vec<SoleBall>)> {
        let feet = Side::ALL.into_iter().filter_map(|side| {
            let (ankle, _, sole) = self.ankle(side as usize)?;
            Some((self.goals.reaches[ankle].body, sole.to_vec()))
        });
        feet.collect()
    }

    /// Reduces the weights of ankles in frames that are far from a ground contact in time, for the second pass. There,
    /// ankles may move smoothly.
    pub(super) fn loosen(&self, goals: &mut [Goals], contacts: &[[bool; 2]], fps: f64) {
        let Weights {
            foot_place,
            air_place,
            standing_height,
            nearing,
            ..
        } = self.settings;
        let fades = (-1.0 / (nearing * fps)).exp();
        for side in Side::ALL.map(|side| side as usize) {
            let Some((ankle, _, _)) = self.ankle(side) else {
                continue;
            };
            let held = self.reaches.len() + side;
            let mut near: Vec<f64> = contacts
                .iter()
                .map(|stands| f64::from(u8::from(stands[side])))
                .collect();
            for index in 1..near.len() {
                near[index] = near[index].max(fades * near[index - 1]);
            }
            for index in (1..near.len()).rev() {
                near[index - 1] = near[index - 1].max(fades * near[index]);
            }
            for (goals, near) in goals.iter_mut().zip(near) {
                let weight = air_place + (foot_place - air_place) * near * near;
                let height = weight.min(standing_height);
                for reach in [ankle, held] {
                    let reach = &mut goals.reaches[reach];
                    reach.weight = DVec3::new(weight, weight, height) * (reach.weight / foot_place);
                }
            }
        }
    }

    /// Stores the position of a foot in a solved pose.
    pub(super) fn keep(&self, side: usize, stand: &mut FootState, pose: &RobotPose) {
        let Some((ankle, turn, sole)) = self.ankle(side) else {
            return;
        };
        let foot = &pose.bodies[self.goals.rotations[turn].body];
        stand.points.clear();
        stand.points.extend(sole.iter().map(|ball| foot.point(ball.centre)));
        if stand.ball.is_some() {
            stand.shift = foot.point(self.reaches[ankle].point) - stand.twin;
        }
    }
}

/// The height of the lowest point.
pub(super) fn lowest(points: &[DVec3]) -> f64 {
    points.iter().map(|point| point.z).fold(f64::INFINITY, f64::min)
}

/// The placement of the base of a robot without legs: as in its file, with its lowest shape on the floor.
fn stand(robot: &Robot) -> Placement {
    let points = robot.zero_pose();
    let links = robot.links.iter().zip(&points);
    let bottoms = links.flat_map(|(link, transform)| {
        let balls = link.shapes.iter().flat_map(RobotShape::balls);
        balls.map(|(centre, radius)| transform.point(centre).z - radius)
    });
    let lowest = bottoms.fold(f64::INFINITY, f64::min);
    Placement {
        rotation: points[0].rotation,
        translation: DVec3::Z * if lowest.is_finite() { -lowest } else { 0.0 },
    }
}

/// The squared weights of a bone's rotation about left, up and forward of the figure in the T-pose.
fn weights(twin: &StandIn, bone: &StandInBone, robot: &Robot, settings: &Weights) -> DVec3 {
    let twist = settings.twist;
    match bone.bone.on(Side::Left) {
        Bone::LeftUpperLeg | Bone::LeftLowerLeg => DVec3::new(DIRECTION, twist, DIRECTION),
        Bone::LeftUpperArm | Bone::LeftLowerArm => DVec3::new(twist, DIRECTION, DIRECTION),
        Bone::LeftHand => DVec3::splat(settings.hand),
        Bone::Head => DVec3::splat(settings.head),
        Bone::LeftFoot => {
            let points = robot.zero_pose();
            let drives = |direction: DVec3| {
                let axes = bone
                    .joints
                    .iter()
                    .map(|joint| points[*joint].rotation * robot.links[*joint].joint.axis);
                let mut along = axes.map(|axis| (twin.figure_to_world.inverse() * axis).dot(direction).abs());
                along.any(|along| along > DRIVES)
            };
            let weight = |direction| if drives(direction) { settings.foot } else { twist };
            // The hip rotates a foot about the up axis.
            DVec3::new(
                weight(DVec3::X),
                settings.foot_heading * settings.foot,
                weight(DVec3::Z),
            )
        }
        _ => DVec3::splat(DIRECTION),
    }
}
