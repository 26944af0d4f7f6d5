//! Measures how well the motion of one animal follows the motion of another animal, from the poses of the two animals.

use glam::{DQuat, DVec3, Vec3};
use mocap_figure::animal::AnimalTrack;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, NodeId, Scene};

use super::AnimalRetargeter;
use crate::measure::skin::{SkinnedMotion, examine};
use crate::quality::{FeetReport, FootMotion, LimbError, RetargetReport, verdict};

/// The smallest depth below the floor that counts, as a fraction of the leg. The same limit applies to people.
const BELOW: f64 = 0.012;

impl AnimalRetargeter {
    /// The report of `moved`, an animation of `target`, which is the scene of the rig.
    pub(super) fn report(
        &self,
        source: &Scene,
        animation: &Animation,
        (target, moved): (&Scene, &Animation),
        all: &[f64],
        track: &AnimalTrack,
    ) -> RetargetReport {
        let bindings = [Binding::new(source, animation), Binding::new(target, moved)];
        let (mut was, mut is) = (Pose::rest(source), Pose::rest(target));
        let zero = |segment: &super::Segment| LimbError {
            bone: segment.bone,
            mean_degrees: 0.0,
            max_degrees: 0.0,
            tick: 0.0,
        };
        let mut limbs: Vec<LimbError> = self.segments.iter().map(zero).collect();
        let level = DQuat::from_rotation_arc(self.up[1].as_dvec3(), DVec3::Z);
        let mut paws: Vec<[DVec3; 4]> = Vec::with_capacity(all.len());
        for &tick in all {
            was.sample(&bindings[0], animation, tick);
            is.sample(&bindings[1], moved, tick);
            for (limb, segment) in limbs.iter_mut().zip(&self.segments) {
                let along = |pose: &Pose, [from, to]: [NodeId; 2]| pose.position(to) - pose.position(from);
                let was = self.to_target * along(&was, segment.source);
                let angle = angle(was, along(&is, segment.target));
                limb.mean_degrees += angle / all.len() as f64;
                if angle > limb.max_degrees {
                    (limb.max_degrees, limb.tick) = (angle, tick);
                }
            }
            paws.push(self.paws.map(|paw| self.metres * (level * is.position(paw).as_dvec3())));
        }
        let scale = f64::from(self.scale) * self.metres;
        let mut report = RetargetReport {
            unmapped: self.unmapped.clone(),
            by_names: Some(self.found.clone()),
            feet: Some(self.feet(track, &paws, animation.ticks_per_second)),
            ..RetargetReport::of_limbs(animation.name.clone(), all.len(), scale, limbs)
        };
        let motion = SkinnedMotion {
            scene: target,
            animation: moved,
            up: self.up[1],
            metres_per_unit: self.metres,
            floor_at_rest: None,
            floor: self.floor,
            joints: self.drives.iter().map(|drive| drive.node).collect(),
            person: None,
        };
        let level = track.ground.iter().copied().fold(f64::INFINITY, f64::min);
        report.skin = examine(&motion, all, &mut |tick| {
            let frame = &track.frames[(tick as usize).min(track.frames.len() - 1)];
            let joints = frame.paws.iter().chain(&frame.knees).chain(&frame.hips);
            let lowest = joints.map(|joint| joint.z).fold(f64::INFINITY, f64::min);
            self.scale * (level - lowest).max(0.0) as f32
        });
        if let Some(rig) = self.rig.as_deref() {
            let name = |node: NodeId| rig.scene.nodes[rig.node(node).index()].name.clone();
            let followers = rig.followers();
            report.followers = followers.map(|(joint, other)| (name(joint), name(other))).collect();
        }
        report.verdict = verdict(&report);
        report
    }

    /// Compares the paws of source and target, in the frames in which a paw of the source is in stance.
    fn feet(&self, track: &AnimalTrack, paws: &[[DVec3; 4]], fps: f64) -> FeetReport {
        let (mut before, mut after, mut count) = (0.0, 0.0, 0_usize);
        let frames = paws.len().min(track.frames.len());
        for frame in 1..frames {
            let was = [&track.frames[frame - 1].paws, &track.frames[frame].paws];
            let is = [&paws[frame - 1], &paws[frame]];
            for index in (0..4).filter(|index| track.contacts[frame][*index] && track.contacts[frame - 1][*index]) {
                let speed = |paws: [&[DVec3; 4]; 2]| (paws[1][index] - paws[0][index]).truncate().length() * fps;
                before += speed(was);
                after += speed(is);
                count += 1;
            }
        }
        let scale = f64::from(self.scale) * self.metres;
        let ground = self.ground.map(|height| f64::from(height) * self.metres);
        let above = |paws: &[DVec3; 4], ground: &[f64; 4]| -> [f64; 4] {
            std::array::from_fn(|index| paws[index].z - ground[index])
        };
        let motion = |heights: Vec<[f64; 4]>, leg: f64, speeds: f64| {
            let lowest = |heights: &[f64; 4]| heights.iter().copied().fold(f64::INFINITY, f64::min);
            let below = heights.iter().filter(|heights| lowest(heights) < -BELOW * leg).count();
            FootMotion {
                skate: speeds / count.max(1) as f64,
                fraction_below_floor: below as f64 / heights.len().max(1) as f64,
                deepest: -heights.iter().map(lowest).fold(0.0, f64::min),
                leg,
            }
        };
        let of_source: Vec<[f64; 4]> = track
            .frames
            .iter()
            .map(|frame| above(&frame.paws, &track.ground))
            .collect();
        let of_target: Vec<[f64; 4]> = paws.iter().map(|paws| above(paws, &ground)).collect();
        let differences = of_source
            .iter()
            .zip(&of_target)
            .flat_map(|(was, is)| (0..4).map(move |index| (scale * was[index] - is[index]).abs()));
        FeetReport {
            contact_frames: count,
            height_difference: differences.fold(0.0, f64::max),
            source: motion(of_source, track.leg, before),
            target: motion(of_target, f64::from(self.leg) * self.metres, after),
        }
    }
}

/// The angle between two directions, in degrees.
fn angle(one: Vec3, other: Vec3) -> f64 {
    f64::from(one.cross(other).length().atan2(one.dot(other)).to_degrees())
}
