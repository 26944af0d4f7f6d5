//! Measures how well a motion on another skeleton follows its source, from the poses of the two skeletons.

mod hands_inside;
pub(crate) mod skin;

use std::collections::BTreeMap;

use glam::{Quat, Vec3};
use mocap_edit::contacts_of;
use mocap_figure::HumanoidBone as Bone;
use mocap_figure::body::Body;
use mocap_figure::t_pose::limb_end;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, NodeId, Scene};

use super::feet::Soles;
use super::plan::UnmappedBone;
use super::quality::{FeetReport, FootMotion, LimbError, RetargetReport, Verdict, verdict};
use super::root::Root;
use super::sight::{AspectError, Sight};

/// The smallest depth below the floor that counts, as a fraction of the leg: 1 cm on a person.
const BELOW: f32 = 0.012;

/// A skeleton with a motion.
pub(super) struct Moving<'a> {
    pub(super) body: &'a Body,
    pub(super) scene: &'a Scene,
    pub(super) animation: &'a Animation,
}

/// The measurements of a skeleton, frame by frame.
pub(super) struct Track {
    /// The directions of the skeleton's limbs, in the axes of the figure.
    limbs: Vec<(Bone, Vec<Vec3>)>,
    /// The positions of both feet's joints in metres, in the axes of the figure; +Y is up.
    feet: Vec<(Bone, Vec<Vec3>)>,
    /// The height of the lowest point of the soles above its level in stance, in metres; infinite without a skin.
    soles: Vec<f32>,
}

impl Track {
    /// Appends the feet in the following ticks.
    fn append_feet(&mut self, after: Self) {
        for ((_, path), (_, after)) in self.feet.iter_mut().zip(after.feet) {
            path.extend(after);
        }
        self.soles.extend(after.soles);
    }
}

/// The number of ticks that are compared at once. The limb directions of this many ticks need only a few hundred
/// kilobytes.
const BLOCK: usize = 1024;

/// The measured joints of a foot.
const FOOT: [Bone; 4] = [Bone::LeftFoot, Bone::LeftToes, Bone::RightFoot, Bone::RightToes];

impl Moving<'_> {
    /// The height of the lowest joint.
    pub(super) fn lowest_joint(&self, pose: &Pose) -> f32 {
        let joints = self.body.bones.values();
        let heights = joints.map(|joint| pose.position(*joint).dot(self.body.up()));
        heights.fold(f32::INFINITY, f32::min)
    }

    /// Measures poses. `soles` are the soles of the skin, if they are measured.
    pub(super) fn track(&self, ticks: &[f64], soles: Option<&Soles>) -> Track {
        let limb = |bone: Bone| {
            let ends = self
                .body
                .joint(bone)
                .zip(limb_end(bone).and_then(|end| self.body.joint(end)));
            Some((bone, ends?))
        };
        let ends: Vec<(Bone, (NodeId, NodeId))> = Bone::ALL.iter().copied().filter_map(limb).collect();
        let joints = FOOT
            .into_iter()
            .filter_map(|bone| Some((bone, self.body.foot_joint(bone)?)));
        let joints: Vec<(Bone, NodeId)> = joints.collect();
        let of_bone = |bone: &Bone| (*bone, Vec::with_capacity(ticks.len()));
        let mut track = Track {
            limbs: ends.iter().map(|(bone, _)| of_bone(bone)).collect(),
            feet: joints.iter().map(|(bone, _)| of_bone(bone)).collect(),
            soles: Vec::with_capacity(ticks.len()),
        };
        let world_to_frame: Quat = self.body.axes.inverse();
        let metres = self.body.metres_per_unit as f32;
        let binding = Binding::new(self.scene, self.animation);
        let mut pose = Pose::rest(self.scene);
        for &tick in ticks {
            pose.sample(&binding, self.animation, tick);
            for ((_, directions), (_, (from, to))) in track.limbs.iter_mut().zip(&ends) {
                let offset = pose.position(*to) - pose.position(*from);
                directions.push((world_to_frame * offset).normalize_or_zero());
            }
            for ((_, path), (_, joint)) in track.feet.iter_mut().zip(&joints) {
                path.push(metres * (world_to_frame * pose.position(*joint)));
            }
            track
                .soles
                .push(soles.map_or(f32::INFINITY, |soles| metres * soles.lowest(&pose)));
        }
        track
    }
}

/// The angles of each limb that both bodies have: one at each tick, in degrees.
pub(super) fn angles(was: &Track, is: &Track) -> Vec<(Bone, Vec<f32>)> {
    let limbs = was.limbs.iter().filter_map(|(bone, was)| {
        let (_, is) = is.limbs.iter().find(|(other, _)| other == bone)?;
        let angle = |(was, is): (&Vec3, &Vec3)| was.cross(*is).length().atan2(was.dot(*is)).to_degrees();
        Some((*bone, was.iter().zip(is).map(angle).collect()))
    });
    limbs.collect()
}

/// Compares two motions at the same ticks.
pub(super) fn measure(
    source: &Moving<'_>,
    target: &Moving<'_>,
    ticks: &[f64],
    scale: f64,
    root: &Root,
    unmapped: &[UnmappedBone],
) -> RetargetReport {
    let soles = Soles::new(target.body, target.scene, root.target_ankle);
    let see = |ticks: &[f64]| (source.track(ticks, None), target.track(ticks, Some(&soles)));
    let (mut was, mut is) = see(&[]);
    let error = |(bone, _)| LimbError {
        bone,
        mean_degrees: 0.0,
        max_degrees: 0.0,
        tick: 0.0,
    };
    let mut limbs: Vec<LimbError> = angles(&was, &is).into_iter().map(error).collect();
    for block in ticks.chunks(BLOCK) {
        let seen = see(block);
        for (limb, (_, angles)) in limbs.iter_mut().zip(angles(&seen.0, &seen.1)) {
            for (angle, &tick) in angles.into_iter().map(f64::from).zip(block) {
                limb.mean_degrees += angle;
                if angle > limb.max_degrees {
                    (limb.max_degrees, limb.tick) = (angle, tick);
                }
            }
        }
        was.append_feet(seen.0);
        is.append_feet(seen.1);
    }
    let (mut sum, mut count) = (0.0, 0);
    for limb in &mut limbs {
        sum += limb.mean_degrees;
        count += ticks.len();
        limb.mean_degrees /= ticks.len().max(1) as f64;
    }
    let mean_degrees = sum / count.max(1) as f64;
    let mut report = RetargetReport {
        clip: target.animation.name.clone(),
        frames: ticks.len(),
        scale,
        max_degrees: limbs.iter().map(|limb| limb.max_degrees).fold(0.0, f64::max),
        verdict: Verdict::Poor,
        seen: sight(source, target, ticks),
        guessed: guessed(source.body),
        limbs,
        mean_degrees,
        unmapped: unmapped.to_vec(),
        clamped: Vec::new(),
        lock: None,
        hands: None,
        feet: feet(source, target, (&was, &is), ticks, root),
        skin: skin::of(source, target, ticks, root),
        followers: BTreeMap::new(),
        by_names: None,
    };
    // If the orientation of the source is guessed, the comparison is guessed too.
    report.verdict = match source.body.is_turned_by_guess() {
        true => Verdict::Poor,
        false => verdict(&report),
    };
    report
}

/// The largest number of frames in which both bodies are examined.
const LOOKS: usize = 400;

fn sight(source: &Moving<'_>, target: &Moving<'_>, ticks: &[f64]) -> Vec<AspectError> {
    let mut sight = Sight::new(source.body, target.body);
    let bindings = [source, target].map(|moving| Binding::new(moving.scene, moving.animation));
    let (mut was, mut is) = (Pose::rest(source.scene), Pose::rest(target.scene));
    for &tick in ticks.iter().step_by(ticks.len().div_ceil(LOOKS).max(1)) {
        was.sample(&bindings[0], source.animation, tick);
        is.sample(&bindings[1], target.animation, tick);
        sight.look(&was, &is, tick);
    }
    sight.found(ticks.first().copied().unwrap_or_default())
}

fn guessed(body: &Body) -> Vec<UnmappedBone> {
    let guess = |(bone, reason)| UnmappedBone { bone, reason };
    body.guessed().into_iter().map(guess).collect()
}

/// The measures of the feet in the frames in which [`ContactOptions::detect`](mocap_edit::ContactOptions::detect) finds
/// the source's feet in contact. The slowest joint of a foot counts, because a foot may roll over heel or toes.
fn feet(
    source: &Moving<'_>,
    target: &Moving<'_>,
    (was, is): (&Track, &Track),
    ticks: &[f64],
    root: &Root,
) -> Option<FeetReport> {
    let has_feet = |body: &Body| body.joint(Bone::LeftFoot).is_some() && body.joint(Bone::RightFoot).is_some();
    if !(has_feet(source.body) && has_feet(target.body)) {
        return None;
    }
    let contacts = contacts_of(source.scene, source.animation, &source.body.figure).ok()?;
    let per_second = source.animation.ticks_per_second as f32;
    let speed = |path: &[Vec3], frame: usize| {
        let step = ticks[frame + 1] - ticks[frame];
        let offset = path[frame + 1] - path[frame];
        Vec3::new(offset.x, 0.0, offset.z).length() * per_second / step as f32
    };
    let (mut contact_frames, mut before, mut after) = (0, 0.0, 0.0);
    let frames = ticks.len().min(contacts.frames).saturating_sub(1);
    for side in [&FOOT[..2], &FOOT[2..]] {
        let joints = side.iter().filter_map(|bone| {
            let path = |track: &'_ Track| track.feet.iter().position(|(other, _)| other == bone);
            Some((&contacts.point(*bone)?.at_rest, path(was)?, path(is)?))
        });
        let joints: Vec<_> = joints.collect();
        for frame in 0..frames {
            let rests = joints
                .iter()
                .filter(|(at_rest, _, _)| at_rest[frame] && at_rest[frame + 1]);
            let speeds = rests.map(|(_, from, to)| (speed(&was.feet[*from].1, frame), speed(&is.feet[*to].1, frame)));
            if let Some((source, target)) = speeds.min_by(|a, b| a.0.total_cmp(&b.0)) {
                contact_frames += 1;
                before += f64::from(source);
                after += f64::from(target);
            }
        }
    }
    let above_standing = |moving: &Moving<'_>, ankle: f32, bone: Bone, position: Vec3| {
        position.y - moving.body.metres_per_unit as f32 * moving.body.standing_height(bone, ankle)
    };
    let mut height_difference = 0.0_f32;
    for (bone, was) in &was.feet {
        let Some((_, is)) = is.feet.iter().find(|(other, _)| other == bone) else {
            continue;
        };
        for (was, is) in was.iter().zip(is) {
            let was = above_standing(source, root.source_ankle, *bone, *was);
            let is = above_standing(target, root.target_ankle, *bone, *is);
            height_difference = height_difference.max((was - is).abs());
        }
    }
    let motion = |moving: &Moving<'_>, track: &Track, ankle: f32, speeds: f64| {
        let lowest = |frame: usize| {
            let heights = track
                .feet
                .iter()
                .map(|(bone, path)| above_standing(moving, ankle, *bone, path[frame]));
            heights.fold(track.soles[frame], f32::min)
        };
        let leg = moving.body.metres_per_unit as f32 * moving.body.leg;
        let below = (0..ticks.len()).filter(|frame| lowest(*frame) < -BELOW * leg).count();
        let deepest = (0..ticks.len()).map(lowest).fold(0.0, f32::min);
        FootMotion {
            skate: speeds / contact_frames.max(1) as f64,
            fraction_below_floor: below as f64 / ticks.len().max(1) as f64,
            deepest: f64::from(-deepest),
            leg: f64::from(leg),
        }
    };
    Some(FeetReport {
        contact_frames,
        source: motion(source, was, root.source_ankle, before),
        target: motion(target, is, root.target_ankle, after),
        height_difference: f64::from(height_difference),
    })
}
