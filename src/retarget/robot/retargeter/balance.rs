//! Balance: shifts the base to where the floor can carry the robot.
//!
//! The masses and the feet of a robot are not where a person has them. With its hips over its feet like a person, a
//! robot would fall, because the centre of pressure would be outside the soles. The centre of pressure of a mass at the
//! position x and the height h is x - h/g x'' (the cart on a table of S. Kajita et al., "Biped walking pattern
//! generation by using preview control of zero-moment point", ICRA 2003). Let e be the vector from the soles to the
//! centre of pressure. A shift d of the mass removes e if d - h/g d'' = -e. The only shift that is bounded at all times
//! is -e smoothed by exp(-|t|/T) / 2T, with T = sqrt(h/g).

use glam::DVec2;
use mocap_scene::scene::{Animation, Scene};

use super::super::dynamics::GRAVITY;
use super::super::feasibility::pressures;
use super::super::motion::RobotMotion;
use super::super::robot_report::RobotReport;
use super::super::speed::Steps;
use super::super::terms::Goals;
use super::RobotRetargeter;

/// The largest number of shifts of the base.
const SHIFTS: usize = 2;

/// The fraction of feasible frames that is enough. The remaining frames are impacts of feet.
const FEASIBLE: f64 = 0.97;

/// The fraction of frames that a shift must gain. A smaller gain is not worth its cost.
const GAIN: f64 = 0.01;

/// The largest increase of the limbs' angle by a shift, in degrees: a tenth of a visible angle.
const FARTHER: f64 = 0.3;

/// The largest increase of the sliding speed of feet in stance by a shift, in m/s: below the resolution of a report.
const FASTER: f64 = 0.002;

/// The largest distance of a centre of pressure outside the soles that counts, in metres. A larger distance is not
/// reliable.
const FARTHEST: f64 = 0.3;

/// The base is shifted only if a shift is longer than this length, in metres.
const LEAST_SHIFT: f64 = 0.002;

/// A motion of the second pass before soles are raised above the floor, with its goals.
pub(super) struct Balance<'a> {
    pub(super) goals: &'a mut [Goals],
    pub(super) steps: &'a Steps,
    pub(super) motion: RobotMotion,
}

impl RobotRetargeter {
    /// A motion of the second pass, or a better balanced motion.
    pub(super) fn balanced(
        &mut self,
        source: &Scene,
        animation: &Animation,
        balance: &mut Balance<'_>,
        mut found: (RobotMotion, RobotReport),
    ) -> (RobotMotion, RobotReport) {
        let feasible = |report: &RobotReport| report.dynamics.as_ref().map(|dynamics| dynamics.fraction_feasible);
        let (degrees, slide) = (found.1.mean_degrees, found.1.skate.unwrap_or_default());
        for _ in 0..SHIFTS {
            let before = feasible(&found.1);
            if before.is_none_or(|before| before >= FEASIBLE) || !self.shift(balance) {
                break;
            }
            let motion = balance.motion.clone();
            let next = self.judged(source, animation, motion, balance.goals, balance.steps);
            let gains = feasible(&next.1) > before.map(|before| before + GAIN);
            let costs = next.1.mean_degrees > degrees + FARTHER || next.1.skate.unwrap_or_default() > slide + FASTER;
            if !gains || costs {
                break;
            }
            found = next;
        }
        found
    }

    /// Shifts the base to where the floor carries it, and solves the windows again. Returns `false` if no shift is
    /// needed.
    fn shift(&mut self, balance: &mut Balance<'_>) -> bool {
        let Balance { goals, steps, motion } = balance;
        let soles = self.following.soles();
        let found = pressures(&self.robot, &self.kinematics, &soles, motion);
        let shifts = found.and_then(|(outside, height)| shifts(&outside, height, motion.fps));
        let (Some(shifts), Some(hips)) = (shifts, self.following.hips_reach()) else {
            return false;
        };
        for ((goals, root), shift) in goals.iter_mut().zip(&mut motion.root).zip(shifts) {
            goals.reaches[hips].target += shift.extend(0.0);
            root.translation += shift.extend(0.0);
        }
        self.smooth(goals, steps, motion);
        true
    }
}

/// The shifts of the base for the vectors from the soles to the centres of pressure outside them; `None` if no shift is
/// needed.
pub fn shifts(outside: &[DVec2], height: f64, fps: f64) -> Option<Vec<DVec2>> {
    let time = (height.max(0.1) / GRAVITY).sqrt() * fps;
    let fades = (-1.0 / time).exp();
    // The sum over both sides of fades^|n| is (1 + fades) / (1 - fades).
    let whole = (1.0 + fades) / (1.0 - fades);
    let believed = outside.iter().map(|outside| outside.clamp_length_max(FARTHEST));
    let believed: Vec<DVec2> = believed.collect();
    let mut shifts = vec![DVec2::ZERO; outside.len()];
    let mut sum = DVec2::ZERO;
    for (shift, believed) in shifts.iter_mut().zip(&believed) {
        sum = fades * sum + *believed;
        *shift -= sum / whole;
    }
    sum = DVec2::ZERO;
    for (shift, believed) in shifts.iter_mut().zip(&believed).rev() {
        *shift -= fades * sum / whole;
        sum = fades * sum + *believed;
    }
    shifts
        .iter()
        .any(|shift| shift.length() > LEAST_SHIFT)
        .then_some(shifts)
}
