//! A foot that is held where it is while it is in contact, and kept above the floor.

use glam::Vec3;

use super::leg::{ContactTrack, Foot, LegTrack};
use super::shift;
use super::sole::{Hinge, SolePoint, turn_up};
use crate::edit::body::{Leg, and_below};
use crate::edit::contacts::DetectedContacts;
use crate::figure::{Figure, Side};
use crate::pose::Pose;
use crate::scene::Scene;

/// A held foot.
pub(super) struct Hold {
    pub(super) leg: LegTrack,
    /// How the points of the sole are turned up.
    hinges: Vec<Hinge>,
}

impl Hold {
    pub(super) fn new(scene: &Scene, figure: &Figure, (side, leg): (Side, Leg), contacts: &DetectedContacts) -> Self {
        let sole: Vec<SolePoint> = and_below(scene, leg.ankle)
            .skip(1)
            .map(|node| SolePoint::at(scene, node, 0.0))
            .collect();
        let hinges = sole.iter().filter_map(|point| Hinge::new(leg.ankle, point));
        Self {
            hinges: hinges.collect(),
            leg: LegTrack::new(scene, figure, (side, leg), contacts, sole, |_, _, height| {
                height / figure.metres()
            }),
        }
    }

    /// Lets what would be below the floor turn up before it is there, within `radius` frames.
    pub(super) fn land_softly(&mut self, up: Vec3, floor: f32, radius: usize) {
        let shifts = &self.leg.shifts;
        let floor = |frame: usize| floor - shifts[frame].dot(up);
        self.hinges
            .iter_mut()
            .for_each(|hinge| hinge.land_softly(up, floor, radius));
    }

    /// How far the foot as a whole is below where it rests, the least of its points, or the ankle below the floor.
    fn sunk(&self, frame: usize, up: Vec3, floor: f32) -> f32 {
        let points = self.leg.points.iter();
        let depths = points.map(|point| floor + point.rest - point.positions[frame].dot(up));
        let least = depths.fold(f32::INFINITY, f32::min);
        let ankle = floor - self.leg.ankle[frame].dot(up);
        if least.is_finite() {
            least.max(ankle).max(0.0)
        } else {
            0.0
        }
    }

    /// How far the foot is below where it rests, frame by frame, and how far its ankle is below the floor: made smooth.
    pub(super) fn lifts_onto(&self, up: Vec3, floor: f32, blend: usize) -> [Vec<f32>; 2] {
        let depths: Vec<f32> = (0..self.leg.shifts.len())
            .map(|frame| self.sunk(frame, up, floor))
            .collect();
        let ankles = self.leg.ankle.iter();
        let least: Vec<f32> = ankles.map(|ankle| (floor - ankle.dot(up)).max(0.0)).collect();
        [depths, least].map(|depths| shift::envelope(&depths, blend))
    }

    /// Sets the shifts of the foot. `lifted` is how far it is lifted, and `carried` how the hips are shifted.
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

    /// The ball rather than the ankle, if both rest.
    fn resting(&self, frame: usize) -> Option<&ContactTrack> {
        self.leg.points.iter().find(|point| point.rests(frame))
    }

    fn known_shifts(&self, up: Vec3, _: f32) -> Vec<Option<Vec3>> {
        let is_low = |frame: usize| self.leg.rests(frame);
        let change = |frame: usize, (): &mut ()| {
            let resting = self.resting(frame);
            resting.map_or(Vec3::ZERO, |point| -point.step(frame, up))
        };
        // The largest shift of a contact is then the least.
        self.leg.shifts_of_runs(is_low, change, shift::middle)
    }

    fn turns(&self, frame: usize) -> bool {
        self.hinges.iter().any(|hinge| hinge.turns(frame))
    }

    fn slack(&self) -> f32 {
        0.0
    }
}
