//! What is wrong with a motion: a family of kinds a file.

mod collision;
mod errors;
mod feet;
mod range;
mod skeleton;
mod still;
mod support;

use std::collections::BTreeMap;

use mocap_edit::MotionErrors;

pub(super) use self::still::is_t_pose;
use super::motion::Motion;
use super::row::Defect;
use super::thresholds::{DefectKind, Thresholds};

/// Most findings of one kind in a clip that are kept; amounts count all.
const MOST_FINDINGS: usize = 100;

/// The findings in a clip.
pub(super) struct Findings<'a> {
    thresholds: &'a Thresholds,
    pub(super) amounts: BTreeMap<DefectKind, f64>,
    pub(super) list: Vec<Defect>,
}

impl<'a> Findings<'a> {
    /// Everything that is wrong with a motion.
    pub(super) fn of(motion: &Motion, errors: &MotionErrors, thresholds: &'a Thresholds) -> Self {
        let mut findings = Self {
            thresholds,
            amounts: BTreeMap::new(),
            list: Vec::new(),
        };
        if motion.frames > 1 && motion.rate > 0.0 {
            still::find(motion, &mut findings);
            errors::find(motion, errors, &mut findings);
            skeleton::find(motion, &mut findings);
            if let Some(body) = &motion.body {
                still::find_t_pose(motion, body, &mut findings);
                feet::find(motion, body, &mut findings);
                support::find(motion, body, &mut findings);
                collision::find(motion, body, &mut findings);
                range::find(motion, body, &mut findings);
            }
        }
        findings
    }

    /// Says that a kind was looked for.
    pub(super) fn look_for(&mut self, kinds: &[DefectKind]) {
        for kind in kinds {
            self.amounts.entry(*kind).or_insert(0.0);
        }
    }

    /// Adds a finding, if its amount is worth one. Times and counts of a kind add up; of others the largest counts.
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
        let adds_up = ["s", "frames", "values"].contains(&kind.unit());
        let total = self.amounts.entry(kind).or_insert(0.0);
        match adds_up {
            true if amount >= suspect => *total += amount,
            true => {}
            false => *total = total.max(amount),
        }
        if amount >= suspect && self.list.iter().filter(|defect| defect.kind == kind).count() < MOST_FINDINGS {
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

/// How sure a finding is by how far an amount is above the least that would be one: 0.5 there, 1 from twice of it.
fn confidence(amount: f32, least: f32) -> f64 {
    f64::from((0.5 * amount / least.max(f32::MIN_POSITIVE)).clamp(0.5, 1.0))
}
