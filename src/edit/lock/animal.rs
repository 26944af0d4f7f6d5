//! Removes the sliding of an animal's paws during ground contact.

use glam::{DVec3, Vec3};
use mocap_figure::Figure;
use mocap_figure::animal::{AnimalTrack, LegGoal, Standing, shifts};
use mocap_figure::report::Quadruped;
use mocap_scene::error::Result;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene};

use super::FootLockReport;
use crate::frames::Frames;

/// The largest shift of a paw, as a fraction of the leg. Retargeting has the same limit.
const FARTHEST: f64 = 0.3;

/// Holds each paw of a four-legged animal at its mean position during each contact. A shift fades in and out within
/// `blend` seconds.
pub(super) fn lock_paws(
    scene: &mut Scene,
    animation: usize,
    (figure, animal): (&Figure, &Quadruped),
    blend: f64,
) -> Result<FootLockReport> {
    let standing = Standing::new(scene, figure, animal);
    let left = standing.axes * Vec3::X;
    let legs = animal
        .legs
        .each_ref()
        .map(|leg| LegGoal::new(&standing.pose, leg, leg.ankle, left));
    let joints: Vec<NodeId> = legs.iter().flat_map(LegGoal::nodes).collect();
    let mut frames = Frames::new(scene, animation, &joints)?;
    let joints: Vec<NodeId> = joints
        .into_iter()
        .filter(|node| frames.column(*node).is_some())
        .collect();
    let track = AnimalTrack::new(scene, &scene.animations[animation], figure, animal);
    let metres = f64::from(figure.metres());
    let mut report = FootLockReport::default();
    let count = frames.len().min(track.frames.len());
    let mut shift = vec![[DVec3::ZERO; 4]; count];
    for index in 0..4 {
        let stands: Vec<bool> = track.contacts[..count].iter().map(|stands| stands[index]).collect();
        let paws: Vec<DVec3> = track.frames[..count].iter().map(|frame| frame.paws[index]).collect();
        let found = shifts(&stands, &paws, None, FARTHEST * track.leg, blend * frames.rate);
        report.contacts += stands.chunk_by(PartialEq::eq).filter(|run| run[0]).count();
        for (frame, found) in found.into_iter().enumerate() {
            report.largest_shift = report.largest_shift.max(found.length() as f32);
            if frame > 0 && stands[frame] && stands[frame - 1] {
                let step = paws[frame] - paws[frame - 1];
                report.slide_before += step.truncate().length();
                report.slide_after += (step + found - shift[frame - 1][index]).truncate().length();
            }
            shift[frame][index] = found;
        }
    }
    let mut pose = Pose::rest(scene);
    for (frame, shift) in shift.iter().enumerate() {
        if shift.iter().all(|shift| *shift == DVec3::ZERO) {
            continue;
        }
        frames.pose(frame, &mut pose);
        for (leg, (paw, shift)) in legs.iter().zip(animal.legs.iter().map(|leg| leg.paw).zip(shift)) {
            let by = track.to_world.inverse() * *shift / metres;
            let goal = pose.position(paw) + by.as_vec3();
            leg.reach(&mut pose, goal);
        }
        for joint in &joints {
            frames.set_rotation_of(frame, *joint, &pose);
        }
    }
    frames.write(scene, animation, &joints, &[]);
    Ok(report)
}
