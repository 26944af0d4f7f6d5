//! The verdict on a motion: a table of measures with their limits of good and fair.

use serde::{Deserialize, Serialize};

use crate::quality::Verdict;

/// The name of the fraction of infeasible frames.
pub(super) const INFEASIBLE: &str = "fraction_infeasible";

/// The name of the fraction of samples in which a motor needs more effort than it can give.
pub(super) const OVER_EFFORT: &str = "fraction_over_effort";

/// The largest fraction of samples above the efforts of motors in a good motion.
pub(super) const OVER_EFFORT_OF_GOOD: f64 = 0.01;

/// One criterion of the verdict on a motion.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Criterion {
    /// The name of the criterion. The table of `docs/robots-report.md` has its meaning and unit.
    pub name: String,
    /// The measured value.
    pub value: f64,
    /// The largest value of a good motion.
    pub good: f64,
    /// The largest value of a fair motion; absent if this criterion alone never makes a motion poor.
    pub fair: Option<f64>,
    /// The verdict by this criterion alone.
    pub verdict: Verdict,
}

impl Criterion {
    /// The criterion, and the limit that its value exceeds.
    pub(super) fn finding(&self) -> String {
        let bound = match (self.verdict, self.fair) {
            (Verdict::Poor, Some(fair)) => fair,
            _ => self.good,
        };
        format!("{} is {:.3}, above {bound}", self.name.replace('_', " "), self.value)
    }
}

/// The measures of a motion for the verdict. A measure that is `None` could not be measured, and does not count.
#[derive(Clone, Debug, Default)]
#[doc(hidden)]
pub struct Measures {
    pub mean_degrees: Option<f64>,
    pub worst_limb_degrees: Option<f64>,
    pub roll_degrees: Option<f64>,
    pub trunk_degrees: Option<f64>,
    pub jumps: f64,
    pub floating: Option<f64>,
    pub below_floor: f64,
    pub scraping: Option<f64>,
    /// The excess of the feet's sliding speed over the source's speed.
    pub more_slide: Option<f64>,
    pub lying: f64,
    pub self_collision: f64,
    pub too_fast: f64,
    pub beyond_limits: f64,
    /// The fraction of frames that need more force than the floor gives, and of samples above the efforts of motors.
    pub infeasible: Option<f64>,
    pub over_effort: Option<f64>,
    /// The number of limbs of the source that could not be compared, and of guessed parts of the robot.
    pub unmeasured_limbs: usize,
    pub guessed_parts: usize,
}

impl Measures {
    /// The measures with their limits: name, value, largest good value, largest fair value.
    fn table(&self) -> [(&'static str, Option<f64>, f64, Option<f64>); 17] {
        let count = |count: usize| Some(count as f64);
        [
            ("mean_degrees", self.mean_degrees, 5.0, Some(10.0)),
            ("worst_limb_degrees", self.worst_limb_degrees, 15.0, Some(30.0)),
            ("roll_degrees", self.roll_degrees, 30.0, Some(60.0)),
            ("trunk_degrees", self.trunk_degrees, 15.0, Some(45.0)),
            ("fraction_of_jumps", Some(self.jumps), 0.0, Some(0.02)),
            ("fraction_floating", self.floating, 0.02, Some(0.2)),
            ("fraction_below_floor", Some(self.below_floor), 0.01, Some(0.1)),
            ("fraction_scraping", self.scraping, 0.03, None),
            ("more_slide", self.more_slide, 0.005, Some(0.1)),
            ("fraction_lying", Some(self.lying), 0.5, None),
            ("fraction_in_self_collision", Some(self.self_collision), 0.02, Some(0.2)),
            ("fraction_too_fast", Some(self.too_fast), 0.001, Some(0.02)),
            ("fraction_beyond_limits", Some(self.beyond_limits), 0.0, Some(0.02)),
            // The next two measures never make a motion poor. Hands on a table also carry the robot, but inverse
            // dynamics knows only the contacts of soles.
            (INFEASIBLE, self.infeasible, 0.05, None),
            (OVER_EFFORT, self.over_effort, OVER_EFFORT_OF_GOOD, None),
            ("unmeasured_limbs", count(self.unmeasured_limbs), 0.0, None),
            ("guessed_parts", count(self.guessed_parts), 0.0, None),
        ]
    }

    /// The verdict by each measure, and the worst of all. If no limb could be compared, it is poor.
    pub fn verdict(&self) -> (Vec<Criterion>, Verdict) {
        let measured = self.table().into_iter().filter_map(|(name, value, good, fair)| {
            let value = value?;
            let verdict = match value {
                value if value <= good => Verdict::Good,
                value if fair.is_none_or(|fair| value <= fair) => Verdict::Fair,
                _ => Verdict::Poor,
            };
            Some(Criterion {
                name: name.to_owned(),
                value,
                good,
                fair,
                verdict,
            })
        });
        let criteria: Vec<Criterion> = measured.collect();
        let has = |verdict| criteria.iter().any(|criterion| criterion.verdict == verdict);
        let worst = match self.mean_degrees {
            None => Verdict::Poor,
            Some(_) if has(Verdict::Poor) => Verdict::Poor,
            Some(_) if has(Verdict::Fair) => Verdict::Fair,
            Some(_) => Verdict::Good,
        };
        (criteria, worst)
    }
}
