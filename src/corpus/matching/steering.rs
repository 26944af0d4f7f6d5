//! Steers a figure by a stick. Critically damped springs move the velocity and the facing of the figure to the stick's
//! values, as in Holden's demonstration ("Spring-It-On", 2021).

use std::f32::consts::{LN_2, PI, TAU};

use glam::{Vec2, Vec3};

use super::features::{AHEAD, FEATURE_RATE, Root};
use super::trajectory::Trajectory;

/// The half-life of a difference in seconds, from Holden's demonstration.
const HALF_LIFE: f32 = 0.27;
/// Half the damping of a critically damped spring with this half-life, per second.
pub const RATE: f32 = 2.0 * LN_2 / HALF_LIFE;
/// The largest wanted speed along an axis, in m/s. The limit prevents overflow.
const FASTEST: f32 = 100.0;
/// The length below which a velocity (in m/s) or a stick has no direction.
const STILL: f32 = 1e-3;

/// The velocity and facing of a figure on the ground.
#[derive(Clone, Copy, Debug)]
pub struct Steering {
    /// The velocity in m/s, and the acceleration in m/s^2.
    velocity: Vec2,
    acceleration: Vec2,
    /// The facing in radians from +Z towards +X, and its change in rad/s.
    angle: f32,
    turning: f32,
}

impl Steering {
    /// A figure that stands and faces `forward`.
    pub fn new(forward: Vec3) -> Self {
        Self {
            velocity: Vec2::ZERO,
            acceleration: Vec2::ZERO,
            angle: forward.x.atan2(forward.z),
            turning: 0.0,
        }
    }

    /// The velocity over the ground in m/s, in the world.
    pub fn velocity(&self) -> Vec3 {
        Vec3::new(self.velocity.x, 0.0, self.velocity.y)
    }

    /// The facing: a horizontal unit vector in the world.
    pub fn forward(&self) -> Vec3 {
        direction(self.angle)
    }

    /// Advances by one frame towards a wanted velocity along x and z. The wanted facing is `look`, or the direction of
    /// the velocity if `look` is zero. Numbers that are not finite count as zero. Returns the trajectory of a figure at
    /// `root`.
    pub fn update(&mut self, root: &Root, velocity: Vec2, look: Vec2) -> Trajectory {
        let velocity = finite(velocity);
        let look = [finite(look), velocity].into_iter().find(|look| look.length() > STILL);
        let wanted = look.map_or(self.angle, |look| look.x.atan2(look.y));
        // Turn the shorter way.
        let wanted = self.angle + (wanted - self.angle + PI).rem_euclid(TAU) - PI;
        let seconds = 1.0 / FEATURE_RATE as f32;
        let after = |seconds: f32| self.after(seconds, velocity, wanted);
        let ahead = AHEAD.map(|frames| after(frames as f32 / FEATURE_RATE as f32));
        let positions = ahead.map(|(moved, _)| root.position + Vec3::new(moved.x, 0.0, moved.y));
        let directions = ahead.map(|(_, next)| direction(next.angle));
        *self = after(seconds).1;
        Trajectory::new(positions, directions)
    }

    /// The distance covered after some seconds, and the state at that time.
    fn after(&self, seconds: f32, velocity: Vec2, angle: f32) -> (Vec2, Self) {
        let left = (-RATE * seconds).exp();
        let off = self.velocity - velocity;
        let falling = self.acceleration + off * RATE;
        let moved = -left * (falling / (RATE * RATE) + (off + falling * seconds) / RATE)
            + falling / (RATE * RATE)
            + off / RATE
            + velocity * seconds;
        let turned = self.angle - angle;
        let slowing = self.turning + turned * RATE;
        let next = Self {
            velocity: left * (off + falling * seconds) + velocity,
            acceleration: left * (self.acceleration - falling * RATE * seconds),
            angle: left * (turned + slowing * seconds) + angle,
            turning: left * (self.turning - slowing * RATE * seconds),
        };
        (moved, next)
    }
}

fn direction(angle: f32) -> Vec3 {
    Vec3::new(angle.sin(), 0.0, angle.cos())
}

fn finite(vector: Vec2) -> Vec2 {
    match vector.is_finite() {
        true => vector.clamp(Vec2::splat(-FASTEST), Vec2::splat(FASTEST)),
        false => Vec2::ZERO,
    }
}
