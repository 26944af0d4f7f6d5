//! Stores both legs of a figure over a motion, and applies the changes of the legs to the frames.

use glam::Vec3;
use mocap_figure::{Figure, HumanoidBone, Side};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::ik::Goal;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{NodeId, Scene};

use super::leg::Foot;
use super::pace::Pace;
use super::weights::FootLockWeights;
use super::{FootLockReport, hips, sole};
use crate::body::{Leg, and_below, mover};
use crate::contacts::DetectedContacts;
use crate::frames::{Frames, between};

/// The distance from a goal that counts as out of reach, in metres. A millimetre is not visible.
const OUT_OF_REACH: f32 = 0.001;

/// The change of one frame. Lengths are in metres.
#[derive(Clone, Copy, Debug, Default)]
struct Change {
    /// The distance of each foot from its goal.
    missed: [f32; 2],
    /// The larger of the shifts of both feet.
    shift: f32,
    /// The largest displacement of a joint outside the feet, and this joint.
    other: f32,
    joint: Option<NodeId>,
}

impl FootLockReport {
    fn add(&mut self, scene: &Scene, changes: &[Change], paces: &[Pace]) {
        for change in changes {
            for (side, missed) in change
                .missed
                .into_iter()
                .enumerate()
                .filter(|(_, missed)| *missed > OUT_OF_REACH)
            {
                self.out_of_reach[side] += 1;
                self.farthest_out_of_reach[side] = self.farthest_out_of_reach[side].max(missed);
            }
            self.largest_shift = self.largest_shift.max(change.shift);
            if let Some(joint) = change.joint.filter(|_| change.other > self.largest_other_change) {
                self.largest_other_change = change.other;
                self.largest_other_joint.clone_from(&scene.nodes[joint.index()].name);
            }
        }
        let largest = |kind: usize| paces.iter().map(|pace| pace.ratios[kind]).fold(0.0, f32::max);
        (self.speed_ratio, self.acceleration_ratio) = (largest(0), largest(1));
        for (count, pace) in self.given_way.iter_mut().zip(paces) {
            *count = pace.frames_given_way();
        }
    }
}

/// The frames of a motion whose legs change.
pub(super) struct Legs<'a> {
    pub(super) frames: Frames<'a>,
    pub(super) legs: Vec<(Side, Leg)>,
    /// The node that carries the figure.
    mover: NodeId,
    /// The joints that rotate.
    turned: Vec<NodeId>,
    /// Whether the figure is shifted.
    moved: bool,
}

impl<'a> Legs<'a> {
    pub(super) fn new(scene: &Scene, figure: &Figure, mut frames: Frames<'a>, pivots: &[NodeId]) -> Result<Self> {
        let hips = figure.humanoid.joint(HumanoidBone::Hips);
        let legs: Option<Vec<_>> = Side::ALL
            .into_iter()
            .map(|side| Some((side, Leg::new(&figure.humanoid, side)?)))
            .collect();
        let (Some(hips), Some(legs)) = (hips, legs) else {
            let message = "the skeleton has no joint for the hips, a thigh, a shin or a foot";
            return Err(Diagnostic::new(Code::NotHumanoid, message).into());
        };
        let mover = mover(scene, hips, |node| frames.moves(node));
        let mut turned = Vec::new();
        for (_, leg) in &legs {
            turned.extend([leg.thigh, leg.knee]);
            let turns = |node: &NodeId| sole::turns(scene, *node) || pivots.contains(node);
            turned.extend(and_below(scene, leg.ankle).filter(turns));
        }
        frames.hold(scene, mover);
        turned.iter().for_each(|node| frames.hold(scene, *node));
        Ok(Self {
            frames,
            legs,
            mover,
            turned,
            moved: false,
        })
    }

    /// The length of the longer leg in the rest pose, in units of the scene.
    pub(super) fn length(&self, scene: &Scene) -> f32 {
        let rest = Pose::rest(scene);
        let length = |(_, leg): &(Side, Leg)| {
            let [thigh, knee, ankle] = [leg.thigh, leg.knee, leg.ankle].map(|node| rest.position(node));
            thigh.distance(knee) + knee.distance(ankle)
        };
        self.legs.iter().map(length).fold(0.0, f32::max)
    }

    /// The number of frames of a fade time. Fails if the lock would average too many frames for a motion of this
    /// length.
    pub(super) fn blend(&self, seconds: f64, weights: &FootLockWeights) -> Result<usize> {
        let longest = seconds.max(weights.around).max(weights.ease);
        self.frames.filter_radius(self.frames.frames_in(longest))?;
        Ok(self.frames.frames_in(seconds))
    }

    pub(super) fn check(&self, contacts: &DetectedContacts) -> Result<()> {
        if contacts.frames == self.frames.len() {
            return Ok(());
        }
        let message = "the known contacts have another number of frames";
        Err(Diagnostic::new(Code::InvalidValue, message)
            .expected_found(self.frames.len().to_string(), contacts.frames.to_string())
            .into())
    }

    /// Changes the frames for `feet`. `floor` is in units of the scene. The function `hips` gets the known shifts of
    /// the feet, computes the missing shifts, and returns the shifts of the hips.
    pub(super) fn change<F: Foot>(
        &mut self,
        scene: &Scene,
        figure: &Figure,
        floor: f32,
        feet: &mut [F],
        hips: impl FnOnce(&mut [F], Vec<Vec<Option<Vec3>>>) -> Vec<Vec3>,
    ) -> FootLockReport {
        let (up, metres) = (figure.up_direction(), figure.metres());
        let mut pose = Pose::rest(scene);
        let mut paces: Vec<Pace> = feet.iter().map(|foot| Pace::new(foot.leg(), &self.frames)).collect();
        for frame in 0..self.frames.len() {
            self.frames.pose(frame, &mut pose);
            for (foot, pace) in feet.iter_mut().zip(&mut paces) {
                pace.see(&pose);
                foot.see(frame, &mut pose, up, floor);
            }
        }
        let rate = self.frames.rate as f32;
        let known = feet.iter().map(|foot| foot.known_shifts(up, rate)).collect();
        let carried = hips(feet, known);
        let heights = || carried.iter().map(|carried| carried.dot(up));
        let slide = |feet: &[F]| feet.iter().map(|foot| foot.slide(up)).sum::<f64>() * f64::from(metres);
        let mut report = FootLockReport {
            slide_before: slide(feet),
            contacts: feet.iter().map(|foot| foot.leg().contacts()).sum(),
            deepest_before: feet.iter().map(|foot| foot.leg().deepest(floor)).fold(0.0, f32::max) * metres,
            hips_lowered: heights().map(|height| -height).fold(0.0, f32::max) * metres,
            hips_raised: heights().fold(0.0, f32::max) * metres,
            ..FootLockReport::default()
        };
        let free = self.frames.clone();
        for pace in &mut paces {
            pace.compare_with_free(metres);
        }
        let mut changes = vec![Change::default(); carried.len()];
        loop {
            self.apply(scene, (figure, floor), (feet, &mut paces), &carried, &mut changes);
            if paces.iter_mut().filter_map(Pace::give_way).count() == 0 {
                break;
            }
            for frame in (0..carried.len()).filter(|frame| paces.iter().any(|pace| pace.is_new(*frame))) {
                self.frames.set_row(frame, &free.row(frame));
            }
        }
        report.slide_after = slide(feet);
        report.add(scene, &changes, &paces);
        report
    }

    /// Moves the hips by `carried` and the feet by their shifts, in the frames that must be changed again according to
    /// `paces`.
    fn apply<F: Foot>(
        &mut self,
        scene: &Scene,
        (figure, floor): (&Figure, f32),
        (feet, paces): (&mut [F], &mut [Pace]),
        carried: &[Vec3],
        changes: &mut [Change],
    ) {
        let mut pose = Pose::rest(scene);
        let mut before = pose.clone();
        for (frame, (&carried, change)) in carried.iter().zip(changes).enumerate() {
            if !paces.iter().any(|pace| pace.is_new(frame)) {
                continue;
            }
            self.frames.pose(frame, &mut pose);
            *change = Change::default();
            if carried != Vec3::ZERO || feet.iter().any(|foot| foot.is_changed(frame, floor)) {
                before.clone_from(&pose);
                if carried != Vec3::ZERO {
                    self.carry(scene, frame, &mut pose, carried);
                }
                for (side, (foot, pace)) in feet.iter().zip(&*paces).enumerate() {
                    let weight = pace.weight(frame);
                    change.missed[side] = self.place_foot(foot, weight, frame, (&before, &mut pose), (figure, floor));
                    let shift = weight * foot.leg().shifts[frame].length() * figure.metres();
                    change.shift = change.shift.max(shift);
                }
                for index in 0..scene.nodes.len() {
                    let node = NodeId::new(index);
                    let moved = pose.position(node).distance(before.position(node)) * figure.metres();
                    if moved > change.other && !feet.iter().any(|foot| foot.leg().foot.contains(&node)) {
                        (change.other, change.joint) = (moved, Some(node));
                    }
                }
            }
            for (foot, pace) in feet.iter_mut().zip(&mut *paces) {
                foot.leg_mut().replace_points(frame, &pose);
                pace.see_changed(frame, &pose);
            }
        }
    }

    /// Moves one foot towards its goal in a frame, by the fraction `weight` of its shift. Returns the remaining
    /// distance of the foot in metres.
    fn place_foot<F: Foot>(
        &mut self,
        foot: &F,
        weight: f32,
        frame: usize,
        (before, pose): (&Pose, &mut Pose),
        (figure, floor): (&Figure, f32),
    ) -> f32 {
        let (leg, up) = (foot.leg(), figure.up_direction());
        let [thigh, knee, ankle] = [leg.leg.thigh, leg.leg.knee, leg.leg.ankle];
        let rotation = Trs::from_matrix(before.node_to_world[ankle.index()]).rotation;
        let mut position = leg.ankle[frame] + weight * leg.shifts[frame];
        let offset = position - pose.position(thigh);
        let rise = hips::rise_to_reach(offset, leg.reach(frame), up).unwrap_or(0.0);
        position += up * rise.min(foot.slack());
        let goal = Goal::at(position).with_rotation(rotation);
        let missed = pose.bend_hinged_limb([thigh, knee, ankle], &goal, leg.hinge) * figure.metres();
        let unturned: Vec<Trs> = leg.foot.iter().map(|node| to_parent(pose, *node)).collect();
        foot.turn(frame, pose, up, floor);
        if weight < 1.0 {
            for (node, unturned) in leg.foot.iter().zip(unturned) {
                pose.node_to_parent[node.index()] = between(unturned, to_parent(pose, *node), weight).matrix();
            }
            pose.update_below(ankle);
        }
        for node in [thigh, knee].iter().chain(&leg.foot) {
            self.frames.set_rotation_of(frame, *node, pose);
        }
        missed
    }

    /// Moves the whole figure in a frame.
    fn carry(&mut self, scene: &Scene, frame: usize, pose: &mut Pose, offset: Vec3) {
        let Some(trs) = self.frames.get(frame, self.mover) else {
            return;
        };
        let parent = scene.nodes[self.mover.index()].parent;
        let to_parent = parent.map_or(glam::Mat4::IDENTITY, |parent| {
            pose.node_to_world[parent.index()].inverse()
        });
        self.moved = true;
        let translation = trs.translation + to_parent.transform_vector3(offset);
        self.frames.set(frame, self.mover, Trs { translation, ..trs });
        pose.node_to_parent[self.mover.index()].w_axis = translation.extend(1.0);
        pose.update_below(self.mover);
    }

    /// These legs with only the values that [`write`](Self::write) needs. The result no longer borrows from the scene.
    pub(super) fn changes(self) -> Legs<'static> {
        Legs {
            frames: self.frames.changes(),
            legs: self.legs,
            mover: self.mover,
            turned: self.turned,
            moved: self.moved,
        }
    }

    /// Writes the changed tracks as keys.
    pub(super) fn write(&self, scene: &mut Scene, animation: usize) {
        let moved = if self.moved {
            std::slice::from_ref(&self.mover)
        } else {
            &[]
        };
        self.frames.write(scene, animation, &self.turned, moved);
    }
}

fn to_parent(pose: &Pose, node: NodeId) -> Trs {
    Trs::from_matrix(pose.node_to_parent[node.index()])
}
