//! Smooths rotations and positions by a Kalman filter and smoother.
//!
//! The state is a value, its velocity and its acceleration, and the acceleration changes by white noise (jerk) whose
//! density may differ from frame to frame. Rotations are filtered by their error state, in the tangent space of the
//! rotation. Sources: Solà, Deray and Atchuthan, "A micro Lie theory for state estimation in robotics", 2018; Bourmaud
//! et al., "Continuous-discrete extended Kalman filter on matrix Lie groups", 2015. The smoother is that of Bryson and
//! Frazier. In the form of Bierman ("Fixed interval smoothing with discrete measurements", 1973), it inverts no matrix.
//! The noise is equal on all axes, so that one covariance of 3 x 3 serves for them. Times are in frames.

use glam::{DQuat, DVec3};

/// The values that are smoothed: how they differ, and how a difference is added.
pub(super) trait Values {
    type Value: Copy;

    /// The difference that changes `from` to `to`, in the tangent space at `from`.
    fn difference(from: Self::Value, to: Self::Value) -> DVec3;
    fn add(value: Self::Value, difference: DVec3) -> Self::Value;
}

pub(super) struct Rotations;
pub(super) struct Positions;

impl Values for Rotations {
    type Value = DQuat;

    fn difference(from: DQuat, to: DQuat) -> DVec3 {
        let turn = from.conjugate() * to;
        let (v, w) = match turn.w < 0.0 {
            true => (-turn.xyz(), -turn.w),
            false => (turn.xyz(), turn.w),
        };
        let sin = v.length();
        match sin < 1e-6 {
            true => 2.0 * v,
            false => v * (2.0 * sin.atan2(w) / sin),
        }
    }

    fn add(value: DQuat, difference: DVec3) -> DQuat {
        let half = 0.5 * difference.length();
        let sinc = if half < 1e-6 { 1.0 } else { half.sin() / half };
        let v = difference * (0.5 * sinc);
        (value * DQuat::from_xyzw(v.x, v.y, v.z, half.cos())).normalize()
    }
}

impl Values for Positions {
    type Value = DVec3;

    fn difference(from: DVec3, to: DVec3) -> DVec3 {
        to - from
    }

    fn add(value: DVec3, difference: DVec3) -> DVec3 {
        value + difference
    }
}

/// A symmetric 3 x 3 covariance of value, velocity and acceleration.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Covariance {
    vv: f64,
    vs: f64,
    va: f64,
    ss: f64,
    sa: f64,
    aa: f64,
}

impl Covariance {
    /// The covariance before the first measurement. The variances say how large each quantity may be.
    pub(super) fn unknown(value: f64, velocity: f64, acceleration: f64) -> Self {
        Self {
            vv: value,
            ss: velocity,
            aa: acceleration,
            ..Self::default()
        }
    }

    /// The covariance one frame later, after white jerk of this density.
    pub(super) fn predicted(self, jerk: f64) -> Self {
        let Self { vv, vs, va, ss, sa, aa } = self;
        Self {
            vv: vv + 2.0 * vs + va + ss + sa + 0.25 * aa + jerk / 20.0,
            vs: vs + va + ss + 1.5 * sa + 0.5 * aa + jerk / 8.0,
            va: va + sa + 0.5 * aa + jerk / 6.0,
            ss: ss + 2.0 * sa + aa + jerk / 3.0,
            sa: sa + aa + jerk / 2.0,
            aa: aa + jerk,
        }
    }

    /// The gains of value, velocity and acceleration, and the variance of the innovation.
    pub(super) fn gains(self, noise: f64) -> ([f64; 3], f64) {
        let variance = self.vv + noise;
        ([self.vv / variance, self.vs / variance, self.va / variance], variance)
    }

    /// The covariance after a measurement.
    pub(super) fn measured(self, [k0, k1, k2]: [f64; 3], noise: f64) -> Self {
        let Self { vs, va, ss, sa, aa, .. } = self;
        Self {
            // The variance is the noise times the gain, a form that cannot become negative.
            vv: noise * k0,
            vs: noise * k1,
            va: noise * k2,
            ss: ss - k1 * vs,
            sa: sa - k1 * va,
            aa: aa - k2 * va,
        }
    }
}

/// The prediction of the filter for a frame, before the measurement.
struct Step<V> {
    value: V,
    covariance: Covariance,
    innovation: DVec3,
    /// The variance of the innovation, which is the measurement minus the prediction; infinite if nothing was measured.
    variance: f64,
}

/// The state of the filter: the value, its velocity and its acceleration.
struct Filter<S: Values> {
    value: S::Value,
    velocity: DVec3,
    acceleration: DVec3,
    covariance: Covariance,
}

impl<S: Values> Filter<S> {
    fn new(first: S::Value, noise: f64, largest_step: f64) -> Self {
        let step = largest_step * largest_step + noise;
        Self {
            value: first,
            velocity: DVec3::ZERO,
            acceleration: DVec3::ZERO,
            covariance: Covariance::unknown(1e3 * noise + step, step, step),
        }
    }

    fn predict(&mut self, jerk: f64) {
        self.value = S::add(self.value, self.velocity + 0.5 * self.acceleration);
        self.velocity += self.acceleration;
        self.covariance = self.covariance.predicted(jerk);
    }

    fn measure(&mut self, measured: Option<S::Value>, noise: f64) -> Step<S::Value> {
        let mut step = Step {
            value: self.value,
            covariance: self.covariance,
            innovation: DVec3::ZERO,
            variance: f64::INFINITY,
        };
        if let Some(measured) = measured {
            let (gains, variance) = self.covariance.gains(noise);
            step.innovation = S::difference(self.value, measured);
            step.variance = variance;
            self.value = S::add(self.value, gains[0] * step.innovation);
            self.velocity += gains[1] * step.innovation;
            self.acceleration += gains[2] * step.innovation;
            self.covariance = self.covariance.measured(gains, noise);
        }
        step
    }
}

/// Smooths values whose noise has the variance `noise` per axis. `jerk` has the density of each frame. `missing` marks
/// frames without a measurement; it may be empty.
pub(super) fn smooth<S: Values>(values: &[S::Value], missing: &[bool], noise: f64, jerk: &[f64]) -> Vec<S::Value> {
    let Some(first) = values.first() else {
        return Vec::new();
    };
    let steps = values.windows(2).map(|pair| S::difference(pair[0], pair[1]).length());
    let mut filter = Filter::<S>::new(*first, noise, steps.fold(0.0, f64::max));
    let mut seen = Vec::with_capacity(values.len());
    for (frame, value) in values.iter().enumerate() {
        if frame > 0 {
            filter.predict(jerk[frame]);
        }
        let is_missing = missing.get(frame).copied().unwrap_or_default();
        seen.push(filter.measure((!is_missing).then_some(*value), noise));
    }
    backwards::<S>(&seen)
}

/// The smoothed values: the backward pass, which carries the evidence of later frames to each frame.
fn backwards<S: Values>(seen: &[Step<S::Value>]) -> Vec<S::Value> {
    let mut smoothed = Vec::with_capacity(seen.len());
    let mut adjoint = [DVec3::ZERO; 3];
    for step in seen.iter().rev() {
        let [a0, a1, a2] = adjoint;
        let mut here = [a0, a0 + a1, 0.5 * a0 + a1 + a2];
        let Covariance { vv, vs, va, .. } = step.covariance;
        if step.variance.is_finite() {
            let gained = (vv * here[0] + vs * here[1] + va * here[2]) / step.variance;
            here[0] -= gained + step.innovation / step.variance;
        }
        smoothed.push(S::add(step.value, -(vv * here[0] + vs * here[1] + va * here[2])));
        adjoint = here;
    }
    smoothed.reverse();
    smoothed
}
