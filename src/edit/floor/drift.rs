//! Finds the drift of the body over the ground and in height.

use glam::DVec3;

use super::least_squares::{Knots, LeastSquares, biweight};
use super::{Feet, KNOT, KNOTS, ONE_OBSERVATION, ROUNDS};

/// The standard deviation of the speed of a foot in stance, in m/s. The speed is not 0, because the foot rolls.
const OF_STANDING: f64 = 0.01;
/// The standard deviations in m/s of the drift over the ground, and of its change of slope at a knot. They are near the
/// values of `OF_DRIFT`, per second.
const OF_DRIFT_SPEED: [f64; 2] = [0.02, 0.01];
/// The least drift in height that is removed, in metres: twice `OF_DRIFT`.
const LEAST_DRIFT: f64 = 0.03;
/// The smallest drift over the ground that is removed, in metres. People who stand move their feet by less than this.
const LEAST_DRIFT_OVER_GROUND: f64 = 0.1;
/// The largest drift in height that is removed, in metres. Two steps of a stair are higher.
const LARGEST_DRIFT: f64 = 0.25;
/// The fastest drift over the ground that is removed, in m/s. A faster drift comes from a treadmill.
const FASTEST_DRIFT: f64 = 0.08;

/// The drift of the body in each frame, in metres: along the axes of the ground, and in height by `height`. `None` if
/// the drift is too small or too large.
pub(super) fn drift(feet: &Feet, height: &[f64]) -> Option<Vec<DVec3>> {
    let slow = feet.standing();
    let knots = Knots::new(feet.frames, KNOT * feet.rate, KNOTS);
    let one = 1.0 / (OF_STANDING.powi(2) * (ONE_OBSERVATION * feet.rate).max(1.0));
    let mut velocities = [vec![0.0; feet.frames], vec![0.0; feet.frames]];
    for round in 0..ROUNDS {
        let scale = 0.25f64 * (0.04f64 / 0.25).powf(round as f64 / (ROUNDS - 1) as f64);
        let mut equations = [0, 1].map(|_| LeastSquares::new(knots.count));
        for (frame, velocity) in &slow {
            let off = (velocity.x - velocities[0][*frame]).hypot(velocity.y - velocities[1][*frame]);
            let weight = one * biweight(off.hypot(velocity.z) / scale);
            let terms = knots.terms(*frame, 0);
            equations[0].add(&terms, velocity.x, weight);
            equations[1].add(&terms, velocity.y, weight);
        }
        for (mut equations, velocity) in equations.into_iter().zip(&mut velocities) {
            knots.add_priors(
                &mut equations,
                0,
                OF_DRIFT_SPEED[1].powi(-2),
                OF_DRIFT_SPEED[0].powi(-2),
            );
            *velocity = knots.curve(&equations.solve()?.values);
        }
    }
    let fastest = |velocity: &[f64]| velocity.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let is_treadmill = velocities.iter().any(|velocity| fastest(velocity) > FASTEST_DRIFT);
    let mut at = DVec3::ZERO;
    let mut drift = Vec::with_capacity(feet.frames);
    for frame in 0..feet.frames {
        if !is_treadmill {
            at.x += velocities[0][frame] / feet.rate;
            at.y += velocities[1][frame] / feet.rate;
        }
        drift.push(DVec3::new(at.x, at.y, height[frame]));
    }
    let farthest = |part: fn(&DVec3) -> f64| {
        let (least, most) = drift
            .iter()
            .map(part)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        most - least
    };
    let over_ground = farthest(|at| at.x).hypot(farthest(|at| at.y));
    let in_height = farthest(|at| at.z);
    let keeps = [
        over_ground > LEAST_DRIFT_OVER_GROUND,
        in_height > LEAST_DRIFT && in_height < LARGEST_DRIFT,
    ];
    if keeps == [false; 2] {
        return None;
    }
    for at in &mut drift {
        if !keeps[0] {
            (at.x, at.y) = (0.0, 0.0);
        }
        if !keeps[1] {
            at.z = 0.0;
        }
    }
    Some(drift)
}
