//! Stores a leg over time, and defines the operations that a locked foot and a following foot share.

use glam::{Quat, Vec3};
use mocap_figure::contacts::ball;
use mocap_figure::{Figure, HumanoidBone, Side};
use mocap_scene::ik::seen_hinge;
use mocap_scene::math::directions::rotation_of;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene};

use super::shift;
use super::sole::SolePoint;
use super::weights::FootLockWeights;
use crate::body::{Leg, and_below, knee_at_rest};
use crate::contacts::DetectedContacts;

/// A foot whose motion is changed near the ground: [`Hold`](super::hold::Hold) or
/// [`FootFollower`](super::follow::FootFollower).
pub(super) trait Foot {
    fn leg(&self) -> &LegTrack;

    fn leg_mut(&mut self) -> &mut LegTrack;

    /// Adds the next frame, and may rotate the foot of `pose`.
    fn see(&mut self, frame: usize, pose: &mut Pose, up: Vec3, floor: f32);

    /// Rotates the joints of the foot until no part of it is below the floor.
    fn turn(&self, frame: usize, pose: &mut Pose, up: Vec3, floor: f32);

    /// The contact point that is at rest in this frame and in the next.
    fn resting(&self, frame: usize) -> Option<&ContactTrack>;

    /// For each frame, the shift over the ground that removes the sliding. `None` if the foot is not on the ground.
    fn known_shifts(&self, up: Vec3, frames_per_second: f32) -> Vec<Option<Vec3>>;

    /// Whether the foot must rotate in a frame, even if hips and ankle do not move.
    fn turns(&self, frame: usize) -> bool;

    /// The height by which the foot may stay above its goal.
    fn slack(&self) -> f32;

    /// Whether the foot is shifted, is below the floor or must rotate.
    fn is_changed(&self, frame: usize, floor: f32) -> bool {
        let leg = self.leg();
        leg.shifts[frame] != Vec3::ZERO || leg.lowest[frame] < floor || self.turns(frame)
    }

    /// The distance that the points of the foot slide in contact: the sum of their movements from frame to frame.
    fn slide(&self, up: Vec3) -> f64 {
        let steps = (0..self.leg().shifts.len()).filter_map(|frame| Some(self.resting(frame)?.step(frame, up)));
        steps.fold(0.0, |sum, step| sum + f64::from(step.length()))
    }
}

/// A leg in every frame.
pub(super) struct LegTrack {
    pub(super) leg: Leg,
    pub(super) weights: FootLockWeights,
    /// The ankle and all nodes below it.
    pub(super) foot: Vec<NodeId>,
    /// The points that stay above the floor.
    pub(super) sole: Vec<SolePoint>,
    /// The length of thigh plus shin.
    pub(super) length: f32,
    pub(super) thigh: Vec<Vec3>,
    pub(super) knee: Vec<Vec3>,
    pub(super) ankle: Vec<Vec3>,
    /// The rotations of the thigh in the world.
    pub(super) thigh_rotations: Vec<Quat>,
    /// The axis about which the knee bends, in the coordinate frame of the thigh. It is the sum of [`seen_hinge`] over
    /// the motion plus [`knee_at_rest`], so its length is not 1.
    pub(super) hinge: Vec3,
    /// The shift of the foot in each frame.
    pub(super) shifts: Vec<Vec3>,
    /// The height of the lowest point of the foot in each frame.
    lowest: Vec<f32>,
    /// The contact points, the ball before the ankle.
    pub(super) points: Vec<ContactTrack>,
}

/// A contact point over time.
pub(super) struct ContactTrack {
    /// The bone of the point, given for the left side.
    pub(super) bone: HumanoidBone,
    pub(super) node: NodeId,
    /// The resting level: the height of the point above the floor when it rests.
    pub(super) rest: f32,
    pub(super) positions: Vec<Vec3>,
    pub(super) at_rest: Vec<bool>,
}

impl ContactTrack {
    /// The movement of the point over the ground from this frame to the next.
    pub(super) fn step(&self, frame: usize, up: Vec3) -> Vec3 {
        (self.positions[frame + 1] - self.positions[frame]).reject_from_normalized(up)
    }

    /// Whether the point rests in this frame and in the next.
    pub(super) fn rests(&self, frame: usize) -> bool {
        self.at_rest[frame] && self.at_rest.get(frame + 1) == Some(&true)
    }
}

impl LegTrack {
    /// `rest` gives the resting level of a node of the foot above the floor. The last argument of `rest` is the height
    /// of the detected contact.
    pub(super) fn new(
        scene: &Scene,
        figure: &Figure,
        (side, leg): (Side, Leg),
        weights: FootLockWeights,
        contacts: &DetectedContacts,
        sole: Vec<SolePoint>,
        rest: impl Fn(&[SolePoint], NodeId, f32) -> f32,
    ) -> Self {
        let candidates = [
            (HumanoidBone::LeftToes, ball(scene, &figure.humanoid, side)),
            (HumanoidBone::LeftFoot, Some(leg.ankle)),
        ];
        let points = candidates
            .into_iter()
            .filter_map(|(bone, node)| Some((bone, node?, contacts.point(bone.on(side))?)))
            .map(|(bone, node, point)| ContactTrack {
                bone,
                node,
                rest: rest(&sole, node, point.height),
                positions: Vec::with_capacity(contacts.frames),
                at_rest: point.at_rest.clone(),
            })
            .collect();
        let hinge = knee_at_rest(&Pose::rest(scene), figure, leg.thigh);
        Self {
            foot: and_below(scene, leg.ankle).collect(),
            leg,
            weights,
            sole,
            length: 0.0,
            shifts: vec![Vec3::ZERO; contacts.frames],
            thigh: Vec::with_capacity(contacts.frames),
            knee: Vec::with_capacity(contacts.frames),
            ankle: Vec::with_capacity(contacts.frames),
            thigh_rotations: Vec::with_capacity(contacts.frames),
            hinge,
            lowest: Vec::with_capacity(contacts.frames),
            points,
        }
    }

    /// Adds the joints of the next frame.
    pub(super) fn see_joints(&mut self, pose: &Pose, up: Vec3) {
        let [thigh, knee, ankle] = [self.leg.thigh, self.leg.knee, self.leg.ankle].map(|node| pose.position(node));
        self.length = thigh.distance(knee) + knee.distance(ankle);
        self.thigh.push(thigh);
        self.knee.push(knee);
        self.ankle.push(ankle);
        let rotation = rotation_of(&pose.node_to_world[self.leg.thigh.index()]);
        self.hinge += seen_hinge(pose, [self.leg.thigh, self.leg.knee, self.leg.ankle]);
        self.thigh_rotations.push(rotation);
        let heights = self.foot.iter().map(|node| pose.position(*node).dot(up));
        self.lowest.push(heights.fold(f32::INFINITY, f32::min));
    }

    /// Adds the contact points of the next frame.
    pub(super) fn see_points(&mut self, pose: &Pose) {
        for point in &mut self.points {
            point.positions.push(pose.position(point.node));
        }
    }

    /// Replaces the contact points of a frame with the contact points of `pose`.
    pub(super) fn replace_points(&mut self, frame: usize, pose: &Pose) {
        for point in &mut self.points {
            point.positions[frame] = pose.position(point.node);
        }
    }

    /// Whether any point of the foot is at rest.
    pub(super) fn rests(&self, frame: usize) -> bool {
        self.points.iter().any(|point| point.at_rest[frame])
    }

    /// The number of contacts of the foot.
    pub(super) fn contacts(&self) -> usize {
        (0..self.shifts.len())
            .filter(|&frame| self.rests(frame) && (frame == 0 || !self.rests(frame - 1)))
            .count()
    }

    /// The depth of the foot's deepest point below the floor.
    pub(super) fn deepest(&self, floor: f32) -> f32 {
        self.lowest.iter().map(|lowest| floor - lowest).fold(0.0, f32::max)
    }

    /// The largest distance between hip and ankle: the full length of the leg less a bend that is too small to see. If
    /// the motion stretches the leg more, the result is the distance in the motion.
    pub(super) fn reach(&self, frame: usize) -> f32 {
        let now = self.thigh[frame].distance(self.ankle[frame]);
        (self.weights.stretch as f32 * self.length).max(now)
    }

    /// The shifts in the runs of frames for which `is_low` is true. `shift_change` gives the change of the shift from a
    /// frame to the next. For each run, `middle` gives a shift that is subtracted from all shifts of the run.
    pub(super) fn shifts_of_runs<S: Default>(
        &self,
        is_low: impl Fn(usize) -> bool,
        shift_change: impl Fn(usize, &mut S) -> Vec3,
        middle: impl Fn(&[Vec3]) -> Vec3,
    ) -> Vec<Option<Vec3>> {
        let frames = self.shifts.len();
        let mut known: Vec<Option<Vec3>> = vec![None; frames];
        let mut start = 0;
        while start < frames {
            if !is_low(start) {
                start += 1;
                continue;
            }
            let end = (start..frames).find(|frame| !is_low(*frame)).unwrap_or(frames);
            let (mut shift, mut state) = (Vec3::ZERO, S::default());
            let mut shifts = vec![shift];
            for frame in start..end - 1 {
                shift += shift_change(frame, &mut state);
                shifts.push(shift);
            }
            let middle = middle(&shifts);
            for (known, shift) in known[start..end].iter_mut().zip(shifts) {
                *known = Some(shift - middle);
            }
            start = end;
        }
        known
    }

    /// Interpolates the shifts between the frames in which they are known, relative to `carried`, the shifts of the
    /// hips.
    pub(super) fn complete(&mut self, known: &[Option<Vec3>], up: Vec3, blend: usize, carried: &[Vec3]) {
        let relative = known.iter().zip(carried);
        let relative = relative.map(|(shift, carried)| Some((*shift)? - carried.reject_from_normalized(up)));
        let relative: Vec<Option<Vec3>> = relative.collect();
        self.shifts = shift::complete(&relative, blend);
    }
}
