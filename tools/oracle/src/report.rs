//! The findings on one file, and their text.

use std::collections::BTreeMap;
use std::fmt::{self, Write};

use crate::difference::{Comparison, Difference};
use crate::explain::{Case, RULES};
use crate::programs::Answer;
use crate::refusals::{Program, REFUSALS};
use crate::scene::Scene;
use crate::source::{Motion, Source};
use crate::table;
use crate::text::{self, TextDifference};

/// A difference, and the row of `README.md` that explains it.
#[derive(Debug)]
pub(crate) struct Finding {
    pub explanation: Option<&'static str>,
    /// The output that differs, and the place of the difference.
    pub place: String,
    pub assimp: String,
    pub ours: String,
}

/// The differences found in one file.
#[derive(Debug, Default)]
pub(crate) struct Report {
    /// Values and lines that are equal.
    pub equal: usize,
    pub findings: Vec<Finding>,
    /// The largest error of an element of a rotation key against double precision: in Assimp's scenes, and in mocap's.
    pub rotation_errors: (f64, f64),
}

/// A unit in the last place of single precision, between 0.5 and 1.
const LAST_PLACE: f64 = f32::EPSILON as f64 / 2.0;

impl Report {
    pub(crate) fn explained(&self) -> usize {
        self.findings
            .iter()
            .filter(|finding| finding.explanation.is_some())
            .count()
    }

    pub(crate) fn unexplained(&self) -> usize {
        self.findings.len() - self.explained()
    }

    /// Whether a row of `README.md` explains anything here.
    pub(crate) fn has(&self, id: &str) -> bool {
        self.findings.iter().any(|finding| finding.explanation == Some(id))
    }

    /// A program that crashed, or printed invalid output.
    pub(crate) fn failure(&mut self, output: &str, what: String) {
        self.find(None, format!("{output}: {what}"), String::new(), String::new());
    }

    fn find(&mut self, explanation: Option<&'static str>, place: String, assimp: String, ours: String) {
        let explanation = explanation.filter(|id| table::explains(id));
        self.findings.push(Finding {
            explanation,
            place,
            assimp,
            ours,
        });
    }

    /// Compares two answers. Returns the explained and the unexplained differences of two scenes, or `None` if one
    /// program refuses the file, because there is then no text to compare.
    pub(crate) fn answers(
        &mut self,
        source: &Source,
        processed: bool,
        assimp: &Answer,
        ours: &Answer,
    ) -> Option<Vec<(Difference, Option<&'static str>)>> {
        let output = if processed { "processed" } else { "raw" };
        let (assimp, ours) = match (assimp, ours) {
            (Ok(assimp), Ok(ours)) => (assimp, ours),
            (Err(_), Err(_)) => {
                self.equal += 1;
                return None;
            }
            (Err(refusal), Ok(_)) => {
                let reason = reason_of_refusal(source, Program::Assimp, refusal);
                self.find(
                    reason,
                    output.to_owned(),
                    format!("refused: {refusal}"),
                    "a scene".to_owned(),
                );
                return None;
            }
            (Ok(_), Err(refusal)) => {
                let reason = reason_of_refusal(source, Program::Mocap, refusal);
                self.find(
                    reason,
                    output.to_owned(),
                    "a scene".to_owned(),
                    format!("refused: {refusal}"),
                );
                return None;
            }
        };
        let comparison = Comparison::of(assimp, ours);
        self.equal += comparison.equal;
        if let Some(motion) = &source.motion {
            self.kinematics(motion, output, assimp, ours);
        }
        let case = source
            .motion
            .as_ref()
            .map(|motion| Case::new(motion, processed, assimp, ours));
        let mut classed = Vec::new();
        for difference in comparison.differences {
            let rule = case
                .as_ref()
                .and_then(|case| RULES.iter().find(|rule| (rule.applies)(case, difference.place)))
                .map(|rule| rule.id);
            let place = format!("{output} {}", difference.place);
            self.find(rule, place, difference.assimp.clone(), difference.ours.clone());
            classed.push((difference, rule));
        }
        Some(classed)
    }

    /// mocap's rotations must be as near to the rotations in double precision as Assimp's, or within the last place.
    fn kinematics(&mut self, motion: &Motion, output: &str, assimp: &Scene, ours: &Scene) {
        let (Some(assimp), Some(ours)) = (motion.rotation_error(assimp), motion.rotation_error(ours)) else {
            return;
        };
        self.rotation_errors = (self.rotation_errors.0.max(assimp), self.rotation_errors.1.max(ours));
        if ours > assimp.max(LAST_PLACE) {
            let place = format!("{output} rotations, distance from double precision");
            self.find(None, place, format!("{assimp:e}"), format!("{ours:e}"));
        }
    }

    /// Compares two outputs of a pair of scenes whose differences are known.
    pub(crate) fn texts(
        &mut self,
        output: &str,
        scenes: &[(Difference, Option<&'static str>)],
        assimp: &str,
        ours: &str,
    ) {
        let (equal, differences) = text::compare(assimp, ours);
        self.equal += equal;
        for difference in differences {
            let reason = reason_of_text(scenes, &difference);
            let TextDifference { subject, assimp, ours } = difference;
            self.find(reason, format!("{output}, {subject}"), assimp, ours);
        }
    }

    /// The report on a file: one line, one more for each explanation, and each unexplained difference in full.
    pub(crate) fn print(&self, file: &str, every_difference: bool) -> String {
        let mut out = format!("{file}: {self}\n");
        if self.rotation_errors.0 > 0.0 {
            let (assimp, ours) = self.rotation_errors;
            let _ = writeln!(
                out,
                "  rotations off double precision by at most: Assimp {assimp:.1e}, mocap {ours:.1e}"
            );
        }
        let mut by_reason: BTreeMap<&str, Vec<&Finding>> = BTreeMap::new();
        for finding in &self.findings {
            by_reason
                .entry(finding.explanation.unwrap_or("UNEXPLAINED"))
                .or_default()
                .push(finding);
        }
        for (reason, findings) in by_reason {
            let first = findings[0];
            let _ = writeln!(out, "  {reason} ({} times, first at {})", findings.len(), first.place);
            for finding in findings
                .iter()
                .filter(|finding| every_difference || finding.explanation.is_none())
            {
                let _ = writeln!(out, "    {}", finding.place);
                let _ = writeln!(
                    out,
                    "      Assimp: {}",
                    finding.assimp.trim_end().replace('\n', "\n              ")
                );
                let _ = writeln!(
                    out,
                    "      mocap:  {}",
                    finding.ours.trim_end().replace('\n', "\n              ")
                );
            }
        }
        out
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} equal, {} explained, {} unexplained",
            self.equal,
            self.explained(),
            self.unexplained()
        )
    }
}

fn reason_of_refusal(source: &Source, by: Program, message: &str) -> Option<&'static str> {
    REFUSALS
        .iter()
        .find(|refusal| refusal.applies(by, message, source))
        .map(|refusal| refusal.id)
}

/// An output may differ for the reason for which its scenes differ, or, if its scenes are equal, for its own reason.
fn reason_of_text(scenes: &[(Difference, Option<&'static str>)], difference: &TextDifference) -> Option<&'static str> {
    let shown: Vec<Option<&'static str>> = scenes
        .iter()
        .filter(|(scenes, _)| difference.shows(scenes.place))
        .map(|(_, reason)| *reason)
        .collect();
    match shown.first() {
        Some(&first) if shown.iter().all(Option::is_some) => first,
        Some(_) => None,
        None => text::explain(difference),
    }
}
