//! The tables that score an assignment of joints to bones. They state how likely the lengths, the names and the tree of
//! the joints are for these bones.
//!
//! An assignment scores the sum of natural logarithms of likelihoods. The logarithm of a ratio of two lengths is
//! assumed to be normally distributed. The table has one mean and one spread for all bodies: for adults, and for the
//! skeletons that programs ship. A name or a sign in the tree adds the logarithm of its likelihood ratio between right
//! and wrong assignments.
//!
//! The means are near the means of the skeletons in `fixtures`, whose bones were mapped by hand. `tools/figure/fit`
//! prints both. The spreads are wider than the printed spreads, because other skeletons vary more: children, giants,
//! joints that were placed by eye.

use crate::names::words::Part;

/// A ratio of two lengths.
#[derive(Debug)]
pub(super) struct Ratio {
    pub(super) what: &'static str,
    pub(super) mean: f32,
    /// The standard deviation of the natural logarithm of the ratio.
    pub(super) spread: f32,
    /// The weight of the ratio. It is less than 1 if the ratio depends on other ratios of the table.
    pub(super) weight: f32,
    /// A smaller ratio counts as this ratio, because some joints coincide with their parents.
    pub(super) least: f32,
    /// The lowest logarithm of the likelihood, because an author may choose any length.
    pub(super) lowest: f32,
    /// Whether the ratio is about an optional bone, and so is no evidence about other bones.
    pub(super) is_optional: bool,
}

/// The lowest logarithm of a ratio without its own lowest value: exp(-4) is one in fifty.
const LOWEST: f32 = -4.0;

impl Ratio {
    const fn new(what: &'static str, mean: f32, spread: f32) -> Self {
        Self {
            what,
            mean,
            spread,
            weight: 1.0,
            least: 0.0,
            lowest: LOWEST,
            is_optional: false,
        }
    }

    const fn weight(mut self, weight: f32) -> Self {
        self.weight = weight;
        self
    }

    const fn least(mut self, least: f32) -> Self {
        self.least = least;
        self
    }

    const fn lowest(mut self, lowest: f32) -> Self {
        self.lowest = lowest;
        self
    }

    const fn optional(mut self) -> Self {
        self.is_optional = true;
        self
    }

    /// The logarithm of the likelihood of a ratio; 0 at best.
    pub(super) fn log_likelihood(&self, ratio: f32) -> f32 {
        let ratio = ratio.max(self.least);
        if !ratio.is_finite() || ratio <= 0.0 {
            return self.weight * self.lowest;
        }
        let off = (ratio / self.mean).ln() / self.spread;
        self.weight * (-0.5 * off * off).max(self.lowest)
    }
}

pub(super) const THIGH_TO_SHIN: Ratio = Ratio::new("thigh to shin", 1.0, 0.16);
/// The hip joint is the width of a hand away from the hips.
pub(super) const HIP_TO_THIGH: Ratio = Ratio::new("hips to hip joint, to thigh", 0.27, 0.6)
    .weight(0.5)
    .least(0.02)
    .lowest(-2.0);
pub(super) const FOOT_TO_SHIN: Ratio = Ratio::new("foot to shin", 0.45, 0.45).weight(0.5);
pub(super) const SOLE_TO_SHIN: Ratio = Ratio::new("ankle to toes, to shin", 0.36, 0.4)
    .weight(0.7)
    .least(0.02)
    .optional();
pub(super) const UPPER_ARM_TO_FOREARM: Ratio = Ratio::new("upper arm to forearm", 1.08, 0.16);
pub(super) const HAND_TO_FOREARM: Ratio = Ratio::new("hand to forearm", 0.6, 0.5).weight(0.5);
pub(super) const COLLAR_TO_UPPER_ARM: Ratio = Ratio::new("collar bone to upper arm", 0.55, 0.35)
    .weight(0.7)
    .least(0.02)
    .optional();
pub(super) const SHOULDER_TO_UPPER_ARM: Ratio = Ratio::new("chest to shoulder, to upper arm", 0.6, 0.6)
    .weight(0.5)
    .least(0.02);
/// Upper arm plus forearm are two thirds of thigh plus shin. The ratio counts for both arms.
pub(super) const ARM_TO_LEG: Ratio = Ratio::new("arm to leg", 0.67, 0.16).weight(1.5);
/// Both arms begin at the shoulders, so the ratio counts for both.
pub(super) const SHOULDERS_TO_LEG: Ratio = Ratio::new("hips to shoulders, to leg", 0.52, 0.35).weight(1.5);
pub(super) const HEAD_TO_LEG: Ratio = Ratio::new("hips to head, to leg", 0.82, 0.25).least(0.02);
pub(super) const TIP_TO_LEG: Ratio = Ratio::new("head to its tip, to leg", 0.24, 0.5)
    .weight(0.7)
    .lowest(-2.0);
pub(super) const NECK_TO_LEG: Ratio = Ratio::new("neck to head, to leg", 0.13, 0.6)
    .weight(0.5)
    .least(0.01)
    .optional();

/// The score that an unambiguous name of the part adds, and an unambiguous name of another part subtracts: exp(2.5) is
/// 12 to 1. A name with several meanings adds a fraction, by the weights in `names/words.rs`.
pub(super) const fn weight_of_name(part: Part) -> f32 {
    match part {
        // The mean over all joints of the spine counts.
        Part::Spine => 2.0,
        // Programs call a joint above the hips `Hips`, and the hips `Root`.
        Part::Hips => 1.5,
        _ => 2.5,
    }
}

/// A sign in the tree of joints, with the logarithm of its likelihood ratio between right and wrong assignments.
#[derive(Debug)]
pub(super) struct Sign {
    pub(super) what: &'static str,
    pub(super) log_odds: f32,
    /// Whether the sign counts as evidence of lengths.
    pub(super) is_of_lengths: bool,
}

impl Sign {
    const fn new(what: &'static str, log_odds: f32) -> Self {
        Self {
            what,
            log_odds,
            is_of_lengths: false,
        }
    }

    const fn of_lengths(mut self) -> Self {
        self.is_of_lengths = true;
        self
    }
}

/// The score is smaller than the penalty of an optional bone that does not fit.
pub(super) const OPTIONAL_BONE: Sign = Sign::new("an optional bone: a collar bone or toes", 0.6);
pub(super) const NO_FOOT: Sign = Sign::new("no joint at the ankle", -3.0);
pub(super) const NO_HAND: Sign = Sign::new("no joint at the wrist", -3.0);
/// The score is multiplied by 1 less the cosine of the angle.
pub(super) const FOOT_STANDS_OFF: Sign = Sign::new("a foot is at an angle to the shin", 1.0);
/// The score is multiplied by the fraction by which the path is longer than the straight line.
pub(super) const DETOUR: Sign = Sign::new("joints inside a bone are off its straight line", -20.0).of_lengths();
pub(super) const FINGERS_AT_HAND: Sign = Sign::new("fingers branch from the hand", 2.0);
pub(super) const FINGERS_ELSEWHERE: Sign = Sign::new("fingers branch from another joint than the hand", -2.0);
pub(super) const NO_ARMS: Sign = Sign::new("no arms", -10.0);
pub(super) const HEAD: Sign = Sign::new("a head", 4.0);
/// Eyes and jaw are children of the head.
pub(super) const FACE: Sign = Sign::new("face joints branch from the head", 1.0);
pub(super) const HEAD_BEHIND_FACE: Sign = Sign::new("face joints branch from a joint below the head", -2.0);
pub(super) const NECK_BEHIND_SHOULDERS: Sign = Sign::new("the neck begins above the shoulders", 1.2);
pub(super) const NECK_AT_SHOULDERS: Sign = Sign::new("the neck carries the arms", -1.5);
/// The score is multiplied by the number of such joints.
pub(super) const LEFT_OUT_BELOW_NECK: Sign =
    Sign::new("a joint between spine and neck is not assigned to a bone", -0.6);
pub(super) const LEFT_OUT_ABOVE_NECK: Sign = Sign::new("a joint between neck and head is not assigned to a bone", -0.1);
/// The score is multiplied by the number of joints from the branch to the shoulders.
pub(super) const HEAD_BELOW_SHOULDERS: Sign = Sign::new("the head branches off below the shoulders", -1.5);

/// Collects the score of an assignment, body part by body part.
pub(super) trait Tally {
    fn ratio(&mut self, row: &'static Ratio, ratio: f32);
    /// Adds the score of the sign times `times`: how often the sign occurs, or how strong the sign is.
    fn sign(&mut self, row: &'static Sign, times: f32);
    /// `fit` is the score of the name of `node`, from -1 to 1.
    fn name(&mut self, part: Part, node: usize, fit: f32, fraction: f32);
}

/// The sums of an assignment's scores.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// The sum over the ratios of required bones.
    pub(super) lengths: f32,
    /// The sum over signs, and over the ratios of optional bones.
    pub(super) signs: f32,
    /// The sum over names, with their weights.
    pub(super) names: f32,
}

impl Sums {
    pub(super) fn sum(&self) -> f32 {
        self.lengths + self.signs + self.names
    }
}

impl Tally for Sums {
    #[inline]
    fn ratio(&mut self, row: &'static Ratio, ratio: f32) {
        let sum = if row.is_optional {
            &mut self.signs
        } else {
            &mut self.lengths
        };
        *sum += row.log_likelihood(ratio);
    }

    #[inline]
    fn sign(&mut self, row: &'static Sign, times: f32) {
        let sum = if row.is_of_lengths {
            &mut self.lengths
        } else {
            &mut self.signs
        };
        *sum += row.log_odds * times;
    }

    #[inline]
    fn name(&mut self, part: Part, _: usize, fit: f32, fraction: f32) {
        self.names += weight_of_name(part) * fit * fraction;
    }
}
