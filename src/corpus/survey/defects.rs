//! Finds the defects of a motion. Each submodule has one family of kinds.

mod collision;
mod errors;
mod feet;
mod range;
mod rate;
mod skeleton;
mod still;
mod support;

use std::collections::BTreeMap;

use mocap_edit::MotionErrors;
use mocap_scene::scene::report::DataLoss;

pub(super) use self::still::{is_t_pose, searched};
use super::motion::Motion;
use super::row::Defect;
use super::thresholds::{DefectKind, Thresholds};

/// The largest number of findings of one kind that a clip keeps. Amounts include all findings.
const MOST_FINDINGS: usize = 100;

/// The largest number of frames of a pose file, not counting a rest pose. More frames are a motion.
const POSES: usize = 3;

/// The findings in a clip.
pub(super) struct Findings<'a> {
    thresholds: &'a Thresholds,
    pub(super) amounts: BTreeMap<DefectKind, f64>,
    pub(super) list: Vec<Defect>,
}

impl<'a> Findings<'a> {
    pub(super) fn new(thresholds: &'a Thresholds) -> Self {
        Self {
            thresholds,
            amounts: BTreeMap::new(),
            list: Vec::new(),
        }
    }

    /// Finds frames in which nothing moves, and T-poses. `face_alone` has the curves of the face if only the face
    /// moves.
    pub(super) fn find_stills(&mut self, motion: &Motion, face_alone: Option<DataLoss>) {
        let frames = motion.frames - motion.first.min(motion.frames);
        let last = motion.frames.saturating_sub(1);
        self.look_for(&[DefectKind::PoseFile, DefectKind::NoMotion, DefectKind::FaceOnly]);
        if frames <= POSES {
            self.add(DefectKind::PoseFile, [0, last], None, frames as f32, 1.0);
        } else if let Some(curves) = face_alone {
            self.add(DefectKind::FaceOnly, [0, last], None, curves.count as f32, 1.0);
        } else if motion.is_still() {
            let joints = motion.is_joint.iter().filter(|is_joint| **is_joint).count();
            self.add(DefectKind::NoMotion, [0, last], None, joints as f32, 1.0);
        } else if motion.rate > 0.0 {
            still::find(motion, self);
            if let Some(body) = &motion.body {
                still::find_t_pose(motion, body, self);
            }
        }
    }

    /// Finds the defects of moving frames. Call this function before all others. `frames` has the frame of the clip for
    /// each frame of `motion`.
    pub(super) fn find_moving(&mut self, motion: &Motion, errors: &MotionErrors, frames: Option<&[usize]>) {
        let count = motion.frames - motion.first.min(motion.frames);
        if count <= POSES || motion.is_still() || motion.rate <= 0.0 {
            return;
        }
        rate::find(motion, self);
        errors::find(motion, errors, self);
        skeleton::find(motion, self);
        if let Some(body) = &motion.body {
            feet::find(motion, body, self);
            support::find(motion, body, self);
            collision::find(motion, body, self);
            range::find(motion, body, self);
        }
        for defect in &mut self.list {
            defect.frames = defect.frames.map(|frame| frames.map_or(frame, |frames| frames[frame]));
        }
    }

    /// Adds findings of other kinds.
    pub(super) fn append(&mut self, mut others: Self) {
        self.amounts.append(&mut others.amounts);
        self.list.append(&mut others.list);
    }

    /// Records that a survey searched for these kinds: absent amounts become 0.
    pub(super) fn look_for(&mut self, kinds: &[DefectKind]) {
        for kind in kinds {
            self.amounts.entry(*kind).or_insert(0.0);
        }
    }

    /// Adds a finding if its amount reaches the threshold. If the kind is a time or a count, the clip's amount is the
    /// sum of all findings. For other kinds, the clip's amount is the largest amount.
    pub(super) fn add(
        &mut self,
        kind: DefectKind,
        frames: [usize; 2],
        joint: Option<&str>,
        amount: f32,
        confidence: f64,
    ) {
        let amount = f64::from(amount);
        let [suspect, _] = self.thresholds.of(kind);
        if !amount.is_finite() || amount <= 0.0 {
            return;
        }
        let is_count = ["frames", "values", "flips"].contains(&kind.unit());
        // A single counted item is already a finding, even if a clip is suspect only from a larger count.
        let least = match is_count && suspect.is_finite() {
            true => suspect.min(1.0),
            false => suspect,
        };
        let total = self.amounts.entry(kind).or_insert(0.0);
        match is_count || kind.unit() == "s" {
            true if amount >= least => *total += amount,
            true => {}
            false => *total = total.max(amount),
        }
        if amount >= least && self.list.iter().filter(|defect| defect.kind == kind).count() < MOST_FINDINGS {
            self.list.push(Defect {
                kind,
                frames,
                joint: joint.map(str::to_owned),
                amount,
                confidence,
            });
        }
    }
}

/// 0 below `from`, 1 above `to`, and linear between `from` and `to`, so that amounts do not jump at a limit.
fn ramp(value: f32, from: f32, to: f32) -> f32 {
    ((value - from) / (to - from)).clamp(0.0, 1.0)
}

/// The confidence of a finding, linear in its amount: 0.5 at the threshold `least`, and 1 at twice the threshold or
/// more.
fn confidence(amount: f32, least: f32) -> f64 {
    f64::from((0.5 * amount / least.max(f32::MIN_POSITIVE)).clamp(0.5, 1.0))
}
