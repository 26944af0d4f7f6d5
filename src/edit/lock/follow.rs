//! Makes a foot of a retargeted motion follow the foot of the source motion. Both feet have the same height above the
//! floor (scaled to the body), are at rest at the same time, and make footsteps in proportion.

use glam::{Quat, Vec3};
use mocap_figure::{Figure, HumanoidBone, Side};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene};

use super::leg::{ContactTrack, Foot, LegTrack};
use super::sole::{SolePoint, angle_to_height, turn_up, world_axis};
use super::weights::FootLockWeights;
use crate::body::Leg;
use crate::contacts::DetectedContacts;

/// The smallest height of a foot in the air, as a multiple of the largest height of a foot on the ground. Between the
/// two heights, the weight of the ground contact changes smoothly.
const IN_THE_AIR: f64 = 3.0;

/// The feet of a source motion, which the feet of a retargeted motion follow.
#[doc(hidden)]
pub struct FootGuide<'a> {
    /// The contacts of the source motion.
    #[doc(hidden)]
    pub contacts: &'a DetectedContacts,
    /// The ratio of heights of a foot: the height in the retargeted motion, in units of its scene, for each metre of
    /// height in the source.
    #[doc(hidden)]
    pub units_per_metre: f32,
    /// The scale and the rotation that convert an offset over the ground from the source to the retargeted motion.
    #[doc(hidden)]
    pub scale: f32,
    #[doc(hidden)]
    pub turn: Quat,
    /// The height of the floor along the up axis, in units of the scene.
    #[doc(hidden)]
    pub floor: f32,
    /// The length of a leg, in units of the scene.
    #[doc(hidden)]
    pub leg: f32,
    /// The points of the left and the right foot that stay above the floor, parents before children.
    #[doc(hidden)]
    pub soles: [Vec<SolePoint>; 2],
    #[doc(hidden)]
    pub weights: FootLockWeights,
}

/// A foot that follows the foot of a source motion.
pub(super) struct FootFollower {
    pub(super) leg: LegTrack,
    /// The points of the source's foot, in the order of `leg.points`.
    sources: Vec<SourceTrack>,
    /// The largest height above its resting level at which a point of the source's foot is near the ground, in metres.
    low: f32,
    /// The wanted heights of the contact points in each frame.
    heights: Vec<Heights>,
    /// The vertical shifts in each frame.
    lifts: Vec<Lift>,
}

/// A contact point of the source's foot over time.
struct SourceTrack {
    /// The movement over the ground from each frame to the next, scaled to this body.
    steps: Vec<Vec3>,
    /// The height of the point above its resting level on the source, in metres.
    above_rest: Vec<f32>,
}

/// The heights above their resting levels that the contact points should have.
#[derive(Clone, Copy, Debug, Default)]
struct Heights {
    ankle: f32,
    ball: Option<f32>,
    /// The weight of the ground contact: 1 on the ground, 0 in the air.
    weight: f32,
}

/// A vertical shift of a foot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lift {
    /// The shift that brings the foot to the height of the source's foot.
    wanted: f32,
    /// The smallest upward shift at which no part of the foot is below the floor.
    least: f32,
    /// The weight of the ground contact: 1 on the ground, 0 in the air.
    pub(super) weight: f32,
}

impl Lift {
    /// The shift of a foot on the ground, in units of the scene.
    pub(super) fn asked(&self) -> f32 {
        self.wanted.max(self.least)
    }
}

impl FootFollower {
    pub(super) fn new(scene: &Scene, figure: &Figure, (side, leg): (Side, Leg), followed: &FootGuide<'_>) -> Self {
        let contacts = followed.contacts;
        let sole = followed.soles[usize::from(side == Side::Right)].clone();
        let stands = |sole: &[SolePoint], node: NodeId, _: f32| {
            let point = sole.iter().find(|point| point.node == Some(node));
            point.map_or(0.0, |point| point.height)
        };
        let leg = LegTrack::new(scene, figure, (side, leg), followed.weights, contacts, sole, stands);
        let sources = leg.points.iter().filter_map(|point| {
            let source = contacts.point(point.bone.on(side))?;
            let step = |pair: &[Vec3]| followed.turn * (pair[1] - pair[0]) * followed.scale;
            let steps = source.positions.windows(2).map(step);
            Some(SourceTrack {
                steps: steps
                    .map(|step| step.reject_from_normalized(figure.up_direction()))
                    .collect(),
                above_rest: source.above_rest.clone(),
            })
        });
        Self {
            sources: sources.collect(),
            leg,
            low: followed.weights.on_the_ground as f32 * followed.leg / followed.units_per_metre,
            heights: heights(side, followed),
            lifts: Vec::new(),
        }
    }

    fn rest_of(&self, node: NodeId) -> f32 {
        let point = self.leg.points.iter().find(|point| point.node == node);
        point.map_or(0.0, |point| point.rest)
    }

    /// The weight of the ground contact of the source's foot in a frame: 1 on the ground, 0 in the air.
    fn weight(&self, frame: usize) -> f32 {
        self.heights.get(frame).map_or(0.0, |heights| heights.weight)
    }

    /// The contact points. Each point has the movement of the source's point from this frame to the next, and the
    /// height of the source's point.
    fn steps(&self, frame: usize) -> impl Iterator<Item = (&ContactTrack, Vec3, f32)> {
        let points = self.leg.points.iter().zip(&self.sources);
        points.filter_map(move |(point, source)| Some((point, *source.steps.get(frame)?, source.above_rest[frame])))
    }

    /// Of the points at rest in this frame and in the next: the point that is slowest on the source, with the movement
    /// of the source's point.
    fn slowest_at_rest(&self, frame: usize) -> Option<(&ContactTrack, Vec3)> {
        let points = self.leg.points.iter().zip(&self.sources);
        let steps = points.map(|(point, source)| (point, source.steps.get(frame).copied().unwrap_or_default()));
        let resting = steps.filter(|(point, _)| point.rests(frame));
        resting.min_by(|(_, a), (_, b)| a.length().total_cmp(&b.length()))
    }

    /// The change of the shift between two frames. A foot at rest keeps its position. A foot near the ground moves like
    /// the source's foot. `held` accumulates the distance between the source's foot and the foot at rest.
    fn change(&self, frame: usize, up: Vec3, held: &mut Vec3, gives_way: f32) -> Vec3 {
        if let Some((point, followed)) = self.slowest_at_rest(frame) {
            // Reduces this distance slowly. Without this, the body would leave its feet behind if the source's feet
            // slide all the time.
            let back = *held * gives_way;
            *held -= followed + back;
            return -point.step(frame, up) - back;
        }
        let low = self.steps(frame).filter(|(_, _, height)| *height < self.low);
        let slowest = low.min_by(|(_, a, _), (_, b, _)| a.length().total_cmp(&b.length()));
        let lowest = || self.steps(frame).min_by(|(_, _, a), (_, _, b)| a.total_cmp(b));
        let point = slowest.or_else(lowest);
        point.map_or(Vec3::ZERO, |(point, step, _)| step - point.step(frame, up))
    }

    /// The vertical shifts.
    pub(super) fn lifts(&self) -> &[Lift] {
        &self.lifts
    }

    /// Sets the shifts of the foot, which moves with the hips.
    pub(super) fn shift(&mut self, known: &[Option<Vec3>], up: Vec3, blend: usize, carried: &[Vec3]) {
        self.leg.complete(known, up, blend, carried);
        for ((shift, lift), carried) in self.leg.shifts.iter_mut().zip(&self.lifts).zip(carried) {
            let height = lift.weight * lift.wanted + (1.0 - lift.weight) * carried.dot(up);
            *shift += carried.reject_from_normalized(up) + up * height.max(lift.least);
        }
    }
}

impl Foot for FootFollower {
    fn leg(&self) -> &LegTrack {
        &self.leg
    }

    fn leg_mut(&mut self) -> &mut LegTrack {
        &mut self.leg
    }

    fn see(&mut self, frame: usize, pose: &mut Pose, up: Vec3, floor: f32) {
        self.leg.see_joints(pose, up);
        if let Some(follow) = self.heights.get(frame).copied() {
            let ankle = self.leg.leg.ankle;
            let wanted = floor + self.rest_of(ankle) + follow.ankle - pose.position(ankle).dot(up);
            let lift = follow.weight * wanted;
            self.turn(frame, pose, up, floor - lift);
            let sole = self.leg.sole.iter();
            let depths = sole.map(|point| floor + point.height - point.position(pose).dot(up));
            self.lifts.push(Lift {
                wanted,
                least: depths.fold(f32::NEG_INFINITY, f32::max),
                weight: follow.weight,
            });
        }
        self.leg.see_points(pose);
    }

    /// Rotates the foot so that the height difference between ball and ankle equals the difference on the source. No
    /// part of the foot is then below the floor.
    fn turn(&self, frame: usize, pose: &mut Pose, up: Vec3, floor: f32) {
        let ankle = self.leg.leg.ankle;
        if let Some(follow) = self.heights.get(frame)
            && let Some(ball) = follow.ball
            && let Some(point) = self.leg.points.iter().find(|point| point.node != ankle)
            && follow.weight > 0.0
        {
            let to_ball = pose.position(point.node) - pose.position(ankle);
            let wanted = point.rest + ball - self.rest_of(ankle) - follow.ankle;
            let hinge = self.leg.sole.iter().find(|point| point.pivot == Some(ankle));
            if let Some(axis) = hinge.and_then(|point| point.axis) {
                let axis = world_axis(pose, ankle, axis);
                let [angle, steepness] = angle_to_height(axis, to_ball, up, wanted);
                let largest = self.leg.weights.largest_turn as f32;
                let angle = follow.weight * (1.0 - steepness) * angle.clamp(-largest, largest);
                pose.rotate(ankle, Quat::from_axis_angle(axis, angle));
            }
        }
        turn_up(pose, &self.leg.sole, up, floor);
    }

    /// Of the points at rest, the point that is slowest on the source.
    fn resting(&self, frame: usize) -> Option<&ContactTrack> {
        self.slowest_at_rest(frame).map(|(point, _)| point)
    }

    fn known_shifts(&self, up: Vec3, frames_per_second: f32) -> Vec<Option<Vec3>> {
        let gives_way = (1.0 / (self.leg.weights.gives_way as f32 * frames_per_second)).min(1.0);
        let is_low = |frame: usize| self.leg.rests(frame) || self.weight(frame) == 1.0;
        let change = |frame: usize, held: &mut Vec3| self.change(frame, up, held, gives_way);
        let mean = |shifts: &[Vec3]| shifts.iter().sum::<Vec3>() / shifts.len() as f32;
        self.leg.shifts_of_runs(is_low, change, mean)
    }

    fn turns(&self, frame: usize) -> bool {
        self.weight(frame) > 0.0
    }

    fn slack(&self) -> f32 {
        self.leg.weights.slack as f32 * self.leg.length
    }
}

/// The wanted heights of the contact points of one foot in each frame, in units of the scene.
fn heights(side: Side, followed: &FootGuide<'_>) -> Vec<Heights> {
    let above = |bone: HumanoidBone| followed.contacts.point(bone.on(side)).map(|point| &point.above_rest);
    let (ankle, ball) = (above(HumanoidBone::LeftFoot), above(HumanoidBone::LeftToes));
    let height = |track: Option<&Vec<f32>>, frame: usize| {
        Some((track?.get(frame)? * followed.units_per_metre).max(0.0)).filter(|height| height.is_finite())
    };
    let on_the_ground = followed.weights.on_the_ground;
    let [near, far] = [on_the_ground, IN_THE_AIR * on_the_ground].map(|height| height as f32 * followed.leg);
    let of_frame = |frame: usize| {
        let Some(ankle) = height(ankle, frame) else {
            return Heights::default();
        };
        let ball = height(ball, frame);
        let lowest = ball.map_or(ankle, |ball| ball.min(ankle));
        let t = ((far - lowest) / (far - near)).clamp(0.0, 1.0);
        Heights {
            ankle,
            ball,
            weight: t * t * (3.0 - 2.0 * t),
        }
    };
    (0..followed.contacts.frames).map(of_frame).collect()
}
