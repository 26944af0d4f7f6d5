//! Locks a foot in place during contact, and keeps it above the floor.

use glam::Vec3;
use mocap_figure::{Figure, Side};
use mocap_scene::pose::Pose;
use mocap_scene::scene::Scene;

use super::leg::{ContactTrack, Foot, LegTrack};
use super::shift;
use super::sole::{Hinge, SolePoint, turn_up};
use super::weights::FootLockWeights;
use crate::body::{Leg, and_below};
use crate::contacts::DetectedContacts;

/// The largest distance of an offset from the median offset of its contact, in metres. An offset at a larger distance
/// is noise.
const NEAR: f32 = 0.02;

/// The part of a foot's height offset that is not corrected, in metres. The soles of shoes differ in height by as much.
const LEAST: f32 = 0.01;

/// The smallest height offset, in metres, at which a foot stands on an object instead of the ground. A step of a stair
/// is higher: 0.15 m.
const FARTHEST: f32 = 0.1;

/// A locked foot.
pub(super) struct Hold {
    pub(super) leg: LegTrack,
    /// For each contact point, the height to which the point is moved, if the height is known.
    levels: Vec<Option<f32>>,
    /// The height by which the foot is lifted to its level, in each frame.
    levelled: Vec<f32>,
    metres: f32,
    /// The rotations that raise the points of the sole.
    hinges: Vec<Hinge>,
}

impl Hold {
    pub(super) fn new(
        scene: &Scene,
        figure: &Figure,
        (side, leg): (Side, Leg),
        weights: FootLockWeights,
        contacts: &DetectedContacts,
        levels: &[f32],
    ) -> Self {
        let sole: Vec<SolePoint> = and_below(scene, leg.ankle)
            .skip(1)
            .map(|node| SolePoint::at(scene, node, 0.0))
            .collect();
        let hinges = sole.iter().filter_map(|point| Hinge::new(leg.ankle, point)).collect();
        let leg = LegTrack::new(scene, figure, (side, leg), weights, contacts, sole, |_, _, height| {
            height / figure.metres()
        });
        let level = |point: &ContactTrack| {
            let mut bones = contacts.points.iter().map(|other| other.bone);
            levels.get(bones.position(|bone| bone == point.bone.on(side))?).copied()
        };
        Self {
            levels: leg.points.iter().map(level).collect(),
            levelled: vec![0.0; contacts.frames],
            metres: figure.metres(),
            hinges,
            leg,
        }
    }

    /// Lifts or lowers the foot to its level in each contact. The offset is smoothed over `blend` frames, so it is
    /// constant in a short contact and changes slowly in a long one. If the level is unknown, the foot is not moved.
    pub(super) fn level(&mut self, up: Vec3, blend: usize) {
        if self.levels.iter().all(Option::is_none) {
            return;
        }
        let frames = self.leg.shifts.len();
        let mut known: Vec<Option<Vec3>> = vec![None; frames];
        let mut start = 0;
        while start < frames {
            if !self.leg.rests(start) {
                start += 1;
                continue;
            }
            let end = (start..frames).find(|frame| !self.leg.rests(*frame)).unwrap_or(frames);
            if let Some(off) = self.off_level(start..end, up) {
                let off = shift::smooth(&shift::filled(off.into_iter()), blend);
                for (known, off) in known[start..end].iter_mut().zip(off) {
                    *known = Some(off);
                }
            }
            start = end;
        }
        self.levelled = shift::complete(&known, blend)
            .iter()
            .map(|shift| shift.dot(up))
            .collect();
    }

    /// For each frame of a contact, the offset that lifts or lowers the foot to its level. A frame has no offset if the
    /// point is not at rest, or if the offset is far from the median. The point is the ball if the ball rests at all,
    /// otherwise the ankle. `None` if the foot is so far from its level that the foot stands on an object.
    fn off_level(&self, frames: std::ops::Range<usize>, up: Vec3) -> Option<Vec<Option<Vec3>>> {
        let off = |point: &ContactTrack, level: f32| -> Vec<Option<f32>> {
            let off = |frame: usize| point.at_rest[frame].then(|| level - point.positions[frame].dot(up));
            frames.clone().map(off).collect()
        };
        let points = self.leg.points.iter().zip(&self.levels);
        let mut found = points.filter_map(|(point, level)| Some(off(point, (*level)?)));
        let found = found.find(|off| off.iter().any(Option::is_some))?;
        let median = mocap_scene::math::median::median(&mut found.iter().flatten().copied().collect::<Vec<f32>>())?;
        let is_near = |off: &f32| (off - median).abs() * self.metres < NEAR;
        let far = median.abs() * self.metres > FARTHEST;
        let least = LEAST / self.metres;
        let level = |off: f32| up * (off - off.clamp(-least, least));
        (!far).then(|| found.into_iter().map(|off| off.filter(is_near).map(level)).collect())
    }

    /// Raises points that would be below the floor smoothly, within `radius` frames before and after.
    pub(super) fn land_softly(&mut self, up: Vec3, floor: f32, radius: usize) {
        let shifts = &self.leg.shifts;
        let floor = |frame: usize| floor - shifts[frame].dot(up);
        self.hinges
            .iter_mut()
            .for_each(|hinge| hinge.land_softly(floor, radius));
    }

    /// The depth of the whole foot below its resting level. It is the least depth of the points, but at least the depth
    /// of the ankle below the floor. If the levels are known and all points are at rest, the foot stands flat. Then the
    /// largest depth counts, because raising the ball alone would bend the foot in each frame by another angle.
    fn sunk(&self, frame: usize, up: Vec3, floor: f32) -> f32 {
        let points = &self.leg.points;
        let floor = floor - self.levelled[frame];
        let depths = points
            .iter()
            .map(|point| floor + point.rest - point.positions[frame].dot(up));
        let is_flat = self.levels.iter().all(Option::is_some) && points.iter().all(|point| point.at_rest[frame]);
        let ankle = floor - self.leg.ankle[frame].dot(up);
        match depths.reduce(if is_flat { f32::max } else { f32::min }) {
            Some(depth) => depth.max(ankle).max(0.0),
            None => 0.0,
        }
    }

    /// For each frame, the smoothed height by which the foot is lifted to its resting level, and the height that keeps
    /// its ankle above the floor.
    pub(super) fn lifts_onto(&self, up: Vec3, floor: f32, blend: usize) -> [Vec<f32>; 2] {
        let depths: Vec<f32> = (0..self.leg.shifts.len())
            .map(|frame| self.sunk(frame, up, floor))
            .collect();
        let ankles = self.leg.ankle.iter();
        let least: Vec<f32> = ankles
            .zip(&self.levelled)
            .map(|(ankle, levelled)| (floor - levelled - ankle.dot(up)).max(0.0))
            .collect();
        [depths, least].map(|depths| {
            let lifted = shift::envelope(&depths, blend);
            lifted
                .iter()
                .zip(&self.levelled)
                .map(|(lift, levelled)| lift + levelled)
                .collect()
        })
    }

    /// Sets the shifts of the foot. `lifted` is the height by which the foot is lifted, and `carried` the shift of the
    /// hips.
    pub(super) fn shift(&mut self, known: &[Option<Vec3>], lifted: &[f32], up: Vec3, blend: usize, carried: &[Vec3]) {
        self.leg.complete(known, up, blend, carried);
        for ((shift, lift), carried) in self.leg.shifts.iter_mut().zip(lifted).zip(carried) {
            *shift += carried.reject_from_normalized(up) + up * *lift;
        }
    }
}

impl Foot for Hold {
    fn leg(&self) -> &LegTrack {
        &self.leg
    }

    fn leg_mut(&mut self) -> &mut LegTrack {
        &mut self.leg
    }

    fn see(&mut self, _: usize, pose: &mut Pose, up: Vec3, _: f32) {
        self.leg.see_joints(pose, up);
        self.hinges.iter_mut().for_each(|hinge| hinge.see(pose, up));
        self.leg.see_points(pose);
    }

    fn turn(&self, frame: usize, pose: &mut Pose, up: Vec3, floor: f32) {
        self.hinges.iter().for_each(|hinge| hinge.turn(frame, pose));
        turn_up(pose, &self.leg.sole, up, floor);
    }

    /// The ball if it rests, otherwise the ankle.
    fn resting(&self, frame: usize) -> Option<&ContactTrack> {
        self.leg.points.iter().find(|point| point.rests(frame))
    }

    fn known_shifts(&self, up: Vec3, _: f32) -> Vec<Option<Vec3>> {
        let is_low = |frame: usize| self.leg.rests(frame);
        let change = |frame: usize, (): &mut ()| {
            let resting = self.resting(frame);
            resting.map_or(Vec3::ZERO, |point| -point.step(frame, up))
        };
        // Measures the shift from the middle of all shifts of the contact, which makes the largest shift as small as
        // possible.
        self.leg.shifts_of_runs(is_low, change, shift::middle)
    }

    fn turns(&self, frame: usize) -> bool {
        self.hinges.iter().any(|hinge| hinge.turns(frame))
    }

    fn slack(&self) -> f32 {
        0.0
    }
}
