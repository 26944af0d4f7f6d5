//! Keeps the contacts of hands: with each other, the head, the trunk, the legs, the floor.
//!
//! On a body of other proportions, limbs in the same directions give other distances: palms that meet on the source
//! cross or stay apart on the target. A palm of the source is in contact if it is near a surface and moves slowly along
//! the surface. Two-bone inverse kinematics moves the palm of the target to the same place of the same part, as in
//! relationship descriptors (Al-Asqhar, Komura and Choi, 2013). If a hand would jerk, the correction is spread over a
//! longer time, then reduced, and then dropped.

mod arm;
mod contact;
mod shape;
mod touch;

use mocap_figure::body::Body;
use mocap_figure::ground;
use mocap_figure::ticks::{Ticks, ticks};
use mocap_figure::{HumanoidBone as Bone, Side};
use mocap_scene::math::directions::rotation_of;
use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, Channel, Keys, NodeId};

use glam::{Quat, Vec3};

pub(super) use self::arm::Arm;
use self::arm::WristGoal;
use self::contact::{Contact, Places};
use super::hand_report::{HandContact, HandsReport};
use super::measure::Moving;
use super::root::Root;

/// The largest number of rounds in which contacts are relaxed. It limits the computing time.
const ROUNDS: usize = 16;

/// The largest ratio of the jerk of a hand around a contact to its jerk without the contact. It limits the mean square
/// and the peak.
const JERK: f64 = 1.15;

/// The largest ratio of the jerk of hand and elbow together to their jerk without the contact. An elbow swings far when
/// a hand passes the shoulder, but viewers rarely look at an elbow.
const ELBOW: f64 = 1.5;

/// The jerk that a hand may always have, in m/s^3: a fiftieth of the jerk of a waving hand.
const STILL: f64 = 2.0;

/// The rotations of the joints that keep the hand contacts of the source, and the report. `None` if the hands touch
/// nothing, or already keep their contacts.
pub(super) fn keep(source: &Moving<'_>, target: &Moving<'_>, root: &Root) -> Option<(NewRotations, HandsReport)> {
    let both = Side::ALL.into_iter();
    let both = both.filter_map(|side| Some((Arm::new(source.body, side)?, Arm::new(target.body, side)?)));
    let (theirs, mine): (Vec<Arm>, Vec<Arm>) = both.unzip();
    let ticks = ticks(source.animation);
    let stands_on = || root.source_ankle - ground::ankle(source.body);
    let ground = source.body.figure.ground_of(source.scene);
    let floor = ground.map_or_else(stands_on, ground::Ground::height);
    let shapes = shape::shapes(source.body, source.scene);
    let touches = touch::touches(source, &theirs, &shapes, floor, &ticks);
    if touches.is_empty() {
        return None;
    }
    let places = Places {
        source: shapes,
        target: shape::shapes(target.body, target.scene),
        scale: root.scale,
        height_scale: root.height_scale,
        floor: root.target_ankle - ground::ankle(target.body),
        least: contact::THICKNESS * target.body.leg / shape::LEG,
    };
    let mut hands = Hands::new(target, mine, &ticks);
    let mut contacts = contact::contacts(&touches, &places, &mut hands);
    drop(touches);
    if contacts.is_empty() {
        return None;
    }
    hands.keep_free();
    hands.apply(&contacts);
    for round in 0..=ROUNDS {
        let mut changed = false;
        for contact in &mut contacts {
            if contact.strength > 0.0 && hands.jerk_ratio(contact) > JERK {
                contact.relax(round == ROUNDS);
                changed = true;
            }
        }
        if !changed {
            break;
        }
        hands.apply(&contacts);
    }
    let found = contacts.len();
    contacts.retain(|contact| {
        let [before, after] = hands.errors(contact);
        contact.strength > 0.0 && after < before
    });
    let given_up = found - contacts.len();
    if contacts.is_empty() {
        return None;
    }
    if given_up > 0 {
        hands.apply(&contacts);
    }
    let mut contacts: Vec<HandContact> = contacts.iter().map(|contact| hands.report(contact, &places)).collect();
    contacts.sort_by(|one, other| one.first.total_cmp(&other.first));
    let report = HandsReport {
        contacts,
        given_up,
        free_mean_degrees: 0.0,
        jerk_ratio: hands.whole_jerk_ratio(),
    };
    Some((hands.rotations(), report))
}

/// The arms of a target in every frame of a motion.
struct Hands<'a> {
    target: &'a Moving<'a>,
    arms: Vec<Arm>,
    ticks: &'a [f64],
    binding: Binding,
    pose: Pose,
    /// The tracks of each arm without the contacts, and then with the contacts.
    free: Vec<ArmTrack>,
    kept: Vec<ArmTrack>,
    /// The joint about which the trunk leans, and its rotations relative to its parent.
    trunk: Option<NodeId>,
    upright: Vec<Quat>,
    leans: Vec<Quat>,
    /// The frames that the contacts change.
    changed: Vec<bool>,
}

/// The lowest joint of the trunk that does not carry the legs.
fn trunk(body: &Body) -> Option<NodeId> {
    let legs = [Bone::LeftUpperLeg, Bone::RightUpperLeg].map(|bone| body.joint(bone));
    let carries = |joint: NodeId| legs.iter().flatten().any(|leg| body.depends_on(*leg, joint));
    body.trunk.iter().copied().find(|joint| !carries(*joint))
}

/// The motion of an arm, in the axes of the figure.
#[derive(Clone)]
struct ArmTrack {
    elbow: Vec<Vec3>,
    wrist: Vec<Vec3>,
    palm: Vec<Vec3>,
    /// The rotations of the arm's joints relative to their parents.
    rotations: Vec<[Quat; 3]>,
}

impl ArmTrack {
    fn new(frames: usize) -> Self {
        Self {
            elbow: vec![Vec3::ZERO; frames],
            wrist: vec![Vec3::ZERO; frames],
            palm: vec![Vec3::ZERO; frames],
            rotations: vec![[Quat::IDENTITY; 3]; frames],
        }
    }

    fn see(&mut self, frame: usize, arm: &Arm, pose: &Pose, to_figure: Quat) {
        self.elbow[frame] = to_figure * pose.position(arm.joints[1]);
        self.wrist[frame] = to_figure * pose.position(arm.joints[2]);
        self.palm[frame] = to_figure * arm.palm(pose);
        self.rotations[frame] = arm.joints.map(|joint| rotation_of(&pose.node_to_parent[joint.index()]));
    }
}

impl<'a> Hands<'a> {
    fn new(target: &'a Moving<'a>, arms: Vec<Arm>, ticks: &'a [f64]) -> Self {
        let mut hands = Self {
            binding: Binding::new(target.scene, target.animation),
            pose: Pose::rest(target.scene),
            free: vec![ArmTrack::new(ticks.len()); arms.len()],
            kept: Vec::new(),
            trunk: trunk(target.body),
            upright: Vec::with_capacity(ticks.len()),
            leans: Vec::new(),
            changed: vec![false; ticks.len()],
            target,
            arms,
            ticks,
        };
        for frame in 0..ticks.len() {
            hands.sample(frame);
            for (track, arm) in hands.free.iter_mut().zip(&hands.arms) {
                track.see(frame, arm, &hands.pose, hands.target.body.axes.inverse());
            }
            if let Some(trunk) = hands.trunk {
                hands
                    .upright
                    .push(rotation_of(&hands.pose.node_to_parent[trunk.index()]));
            }
        }
        hands
    }

    /// Begins with the motion without contacts.
    fn keep_free(&mut self) {
        self.leans.clone_from(&self.upright);
        self.kept.clone_from(&self.free);
    }

    /// Sets the pose to a frame without contacts.
    fn sample(&mut self, frame: usize) {
        self.pose
            .sample(&self.binding, self.target.animation, self.ticks[frame]);
    }

    fn arm(&self, side: Side) -> Option<usize> {
        self.arms.iter().position(|arm| arm.side == side)
    }

    /// Moves the arms to the goals of the contacts.
    fn apply(&mut self, contacts: &[Contact]) {
        let axes = self.target.body.axes;
        for frame in 0..self.ticks.len() {
            let mut shifts = vec![Shift::default(); self.arms.len()];
            for contact in contacts {
                let weight = contact.weight(frame);
                if weight > 0.0 {
                    for (side, shift) in contact.shifts(frame) {
                        if let Some(arm) = self.arm(side) {
                            shifts[arm].add(weight, shift, contact.leans());
                        }
                    }
                }
            }
            let is_shifted = shifts.iter().any(|shift| shift.weights > 0.0);
            if !is_shifted && !self.changed[frame] {
                continue;
            }
            self.sample(frame);
            self.changed[frame] = is_shifted;
            let goals = self.arms.iter().zip(&shifts);
            let goals =
                goals.map(|(arm, shift)| (shift.weights > 0.0).then(|| arm.goal(&self.pose, axes * shift.all())));
            let goals: Vec<Option<WristGoal>> = goals.collect();
            self.lean(&shifts, &goals);
            for (index, arm) in self.arms.iter().enumerate() {
                if let Some(goal) = goals[index] {
                    arm.bring(&mut self.pose, goal);
                }
                self.kept[index].see(frame, arm, &self.pose, axes.inverse());
            }
            if let Some(trunk) = self.trunk {
                self.leans[frame] = rotation_of(&self.pose.node_to_parent[trunk.index()]);
            }
        }
    }

    /// Leans the trunk if an arm is too short.
    fn lean(&mut self, shifts: &[Shift], goals: &[Option<WristGoal>]) {
        let Some(trunk) = self.trunk else { return };
        let pivot = self.pose.position(trunk);
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        for ((arm, shift), goal) in self.arms.iter().zip(shifts).zip(goals) {
            if let Some(goal) = goal {
                let lean = arm.lean(&self.pose, pivot, *goal) * (1.0 - shift.upright);
                sum += lean * lean.length();
                weights += lean.length();
            }
        }
        if weights > 0.0 {
            self.pose.rotate(trunk, Quat::from_scaled_axis(sum / weights));
        }
    }

    /// The largest ratio of the arms' jerk around a contact.
    fn jerk_ratio(&self, contact: &Contact) -> f64 {
        let frames = contact.frames(self.ticks.len());
        let sides = contact.sides();
        let arms = sides.filter_map(|side| self.arm(side));
        let ratio = |arm: usize| {
            let jerks = [&self.free[arm], &self.kept[arm]].map(|track| {
                let hand = self.jerk(&track.wrist[frames.clone()]);
                let elbow = self.jerk(&track.elbow[frames.clone()]);
                [hand[0], hand[1], hand[0].hypot(elbow[0])]
            });
            let [free, kept] = jerks;
            let ratios = kept.iter().zip(free).zip([1.0, 1.0, ELBOW]);
            let ratios = ratios.map(|((kept, free), more)| kept / (more * free).max(STILL));
            ratios.fold(0.0, f64::max)
        };
        arms.map(ratio).fold(0.0, f64::max)
    }

    /// The jerk of a track in m/s^3: its root mean square, and its peak.
    fn jerk(&self, track: &[Vec3]) -> [f64; 2] {
        let metres = self.target.body.metres_per_unit;
        let per_second = self.target.animation.ticks_per_second.powi(3);
        let third = |at: &[Vec3]| (at[3] - at[0] + 3.0 * (at[1] - at[2])).as_dvec3().length() * metres * per_second;
        let jerks = || track.windows(4).map(third);
        let squares = jerks().map(|jerk| jerk * jerk).sum::<f64>();
        let mean = squares / track.len().saturating_sub(3).max(1) as f64;
        [mean.sqrt(), jerks().fold(0.0, f64::max)]
    }

    fn whole_jerk_ratio(&self) -> f64 {
        let tracks = self.free.iter().zip(&self.kept);
        let ratios = tracks.map(|(free, kept)| self.jerk(&kept.wrist)[0] / self.jerk(&free.wrist)[0].max(STILL));
        ratios.fold(0.0, f64::max)
    }

    /// The rotations of the joints that the contacts change.
    fn rotations(&self) -> NewRotations {
        let at = Ticks::new(self.ticks);
        let mut changed = Vec::new();
        let mut add = |joint: NodeId, free: Vec<Quat>, mut kept: Vec<Quat>| {
            if free == kept {
                return;
            }
            drop(free);
            for frame in 1..kept.len() {
                kept[frame] = in_hemisphere_of(kept[frame - 1], kept[frame]);
            }
            changed.push((joint, at.rotation_keys(kept)));
        };
        for (arm, (free, kept)) in self.arms.iter().zip(self.free.iter().zip(&self.kept)) {
            for (index, joint) in arm.joints.into_iter().enumerate() {
                let of = |track: &ArmTrack| track.rotations.iter().map(|joints| joints[index]).collect();
                add(joint, of(free), of(kept));
            }
        }
        if let Some(trunk) = self.trunk {
            add(trunk, self.upright.clone(), self.leans.clone());
        }
        changed
    }
}

/// Joints with the keys that they get.
pub(super) type NewRotations = Vec<(NodeId, Keys<Quat>)>;

/// Gives joints their keys.
pub(super) fn set_rotations(body: &Body, animation: &mut Animation, rotations: NewRotations) {
    for (joint, keys) in rotations {
        channel(body, animation, joint).rotation_keys = keys;
    }
}

/// The channel of a joint. Adds a channel if the joint has none.
pub(super) fn channel<'a>(body: &Body, animation: &'a mut Animation, joint: NodeId) -> &'a mut Channel {
    let found = animation
        .channels
        .iter()
        .position(|channel| channel.node == Some(joint));
    let index = found.unwrap_or_else(|| {
        let rest = body.rest[joint.index()];
        animation.channels.push(Channel {
            node_name: body.names[joint.index()].clone(),
            node: Some(joint),
            position_keys: Keys::constant(rest.translation),
            rotation_keys: Keys::constant(rest.rotation),
            scaling_keys: Keys::constant(rest.scale),
        });
        animation.channels.len() - 1
    });
    &mut animation.channels[index]
}

/// The shifts of one hand from several contacts.
#[derive(Clone, Copy, Debug)]
struct Shift {
    sum: Vec3,
    weights: f32,
    /// The fraction of the free motion that remains: the product over all contacts. `upright` is the product over the
    /// contacts for which the trunk leans.
    free: f32,
    upright: f32,
}

impl Default for Shift {
    fn default() -> Self {
        Self {
            sum: Vec3::ZERO,
            weights: 0.0,
            free: 1.0,
            upright: 1.0,
        }
    }
}

impl Shift {
    fn add(&mut self, weight: f32, shift: Vec3, leans: bool) {
        self.sum += weight * shift;
        self.weights += weight;
        self.free *= 1.0 - weight;
        if leans {
            self.upright *= 1.0 - weight;
        }
    }

    /// The weighted mean, which fades as smoothly as each weight.
    fn all(&self) -> Vec3 {
        self.sum / self.weights * (1.0 - self.free)
    }
}
