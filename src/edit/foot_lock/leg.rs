//! One leg over time: where it is, and how its foot is to be shifted.

use glam::Vec3;

use super::shift;
use crate::edit::body::{Body, Leg, and_below};
use crate::edit::contacts::DetectedContacts;
use crate::edit::frames::{Frames, tracks};
use crate::scene::{NodeId, Scene};
use crate::skeleton::{HumanoidBone, Side};

/// A leg in every frame.
pub(super) struct LegTrack {
    pub(super) leg: Leg,
    /// The ankle and all below it.
    pub(super) foot: Vec<NodeId>,
    /// The lengths of thigh and shin together.
    pub(super) length: f32,
    pub(super) thigh: Vec<Vec3>,
    pub(super) ankle: Vec<Vec3>,
    /// How the foot is to be shifted.
    pub(super) shifts: Vec<Vec3>,
    /// The heights of the lowest point of the foot.
    lowest: Vec<f32>,
    /// The heights of the points of contact at rest over the floor.
    rest: Vec<f32>,
    /// The nodes of the points of contact, the ball before the ankle.
    nodes: Vec<NodeId>,
    /// Their positions, a list for each.
    points: Vec<Vec<Vec3>>,
    /// Whether they are at rest, likewise.
    at_rest: Vec<Vec<bool>>,
}

impl LegTrack {
    pub(super) fn new(
        scene: &Scene,
        frames: &Frames,
        body: &Body,
        side: Side,
        leg: Leg,
        contacts: &DetectedContacts,
    ) -> Self {
        let candidates = [
            (HumanoidBone::LeftToes, body.toes(scene, side)),
            (HumanoidBone::LeftFoot, Some(leg.ankle)),
        ];
        let found = candidates
            .into_iter()
            .filter_map(|(bone, node)| Some((node?, contacts.point(bone.on(side))?)));
        let found: Vec<_> = found.collect();
        let nodes: Vec<NodeId> = found.iter().map(|(node, _)| *node).collect();
        let at_rest = found.iter().map(|(_, point)| point.at_rest.clone()).collect();
        let rest = found.iter().map(|(_, point)| point.height / body.metres).collect();
        let foot: Vec<NodeId> = and_below(scene, leg.ankle).collect();
        let mut all = tracks(
            frames,
            scene,
            &[&[leg.thigh, leg.knee, leg.ankle], &*nodes, &*foot].concat(),
        );
        let of_foot = all.split_off(3 + nodes.len());
        let points = all.split_off(3);
        let height = |frame: usize| {
            of_foot
                .iter()
                .map(|track| track[frame].dot(body.up))
                .fold(f32::INFINITY, f32::min)
        };
        let lowest = (0..frames.len()).map(height).collect();
        let mut limbs = all.into_iter();
        let mut next = || limbs.next().unwrap_or_default();
        let (thigh, knee, ankle) = (next(), next(), next());
        let length = match (thigh.first(), knee.first(), ankle.first()) {
            (Some(thigh), Some(knee), Some(ankle)) => thigh.distance(*knee) + knee.distance(*ankle),
            _ => 0.0,
        };
        Self {
            leg,
            foot,
            length,
            shifts: vec![Vec3::ZERO; ankle.len()],
            thigh,
            ankle,
            lowest,
            rest,
            nodes,
            points,
            at_rest,
        }
    }

    /// The same leg after its frames changed, without a shift.
    pub(super) fn measured(&self, scene: &Scene, frames: &Frames) -> Self {
        Self {
            points: tracks(frames, scene, &self.nodes),
            leg: Leg { ..self.leg },
            foot: Vec::new(),
            thigh: Vec::new(),
            ankle: Vec::new(),
            shifts: Vec::new(),
            lowest: Vec::new(),
            rest: Vec::new(),
            nodes: self.nodes.clone(),
            at_rest: self.at_rest.clone(),
            ..*self
        }
    }

    /// Whether any point of the foot is at rest.
    fn rests(&self, frame: usize) -> bool {
        self.at_rest.iter().any(|at_rest| at_rest[frame])
    }

    /// The step over the ground from a frame to the next of the point that rests in both, the ball if it does.
    fn step(&self, frame: usize, up: Vec3) -> Option<Vec3> {
        let rests = |point: &usize| self.at_rest[*point][frame] && self.at_rest[*point].get(frame + 1) == Some(&true);
        let point = (0..self.points.len()).find(rests)?;
        Some((self.points[point][frame + 1] - self.points[point][frame]).reject_from_normalized(up))
    }

    /// How far the points in contact slide, all steps together.
    pub(super) fn slide(&self, up: Vec3) -> f64 {
        let frames = self.at_rest.first().map_or(0, Vec::len);
        let steps = (0..frames).filter_map(|frame| self.step(frame, up));
        steps.map(|step| f64::from(step.length())).sum()
    }

    /// The number of contacts of the foot.
    pub(super) fn contacts(&self) -> usize {
        let frames = 0..self.at_rest.first().map_or(0, Vec::len);
        frames
            .filter(|&frame| self.rests(frame) && (frame == 0 || !self.rests(frame - 1)))
            .count()
    }

    /// Whether a point of the foot is below the floor.
    pub(super) fn is_below(&self, frame: usize, floor: f32) -> bool {
        self.lowest[frame] < floor
    }

    /// How far below the floor the foot comes.
    pub(super) fn deepest(&self, floor: f32) -> f32 {
        self.lowest.iter().map(|lowest| floor - lowest).fold(0.0, f32::max)
    }

    /// How far the foot as a whole is below where it rests, the least of its points, or the ankle below the floor.
    fn sunk(&self, frame: usize, up: Vec3, floor: f32) -> f32 {
        let depths = self
            .points
            .iter()
            .zip(&self.rest)
            .map(|(track, rest)| floor + rest - track[frame].dot(up));
        let least = depths.fold(f32::INFINITY, f32::min);
        let ankle = floor - self.ankle[frame].dot(up);
        if least.is_finite() {
            least.max(ankle).max(0.0)
        } else {
            0.0
        }
    }

    /// Finds the shifts that take the slide back, and lift a foot that is below the floor as a whole.
    pub(super) fn shift(&mut self, up: Vec3, floor: f32, blend: usize) {
        let frames = self.shifts.len();
        let mut known: Vec<Option<Vec3>> = vec![None; frames];
        let mut start = 0;
        while start < frames {
            if !self.rests(start) {
                start += 1;
                continue;
            }
            let end = (start..frames).find(|frame| !self.rests(*frame)).unwrap_or(frames);
            let mut shift = Vec3::ZERO;
            let mut shifts = vec![shift];
            for frame in start..end - 1 {
                shift -= self.step(frame, up).unwrap_or_default();
                shifts.push(shift);
            }
            // Where the foot is shifted least on the whole.
            let mean = shifts.iter().sum::<Vec3>() / shifts.len() as f32;
            for (known, shift) in known[start..end].iter_mut().zip(shifts) {
                *known = Some(shift - mean);
            }
            start = end;
        }
        self.shifts = shift::complete(&known, blend);
        let depths: Vec<f32> = (0..frames).map(|frame| self.sunk(frame, up, floor)).collect();
        for (shift, lift) in self.shifts.iter_mut().zip(shift::envelope(&depths, blend)) {
            *shift += up * lift;
        }
    }
}
