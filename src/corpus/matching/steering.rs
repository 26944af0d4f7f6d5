//! A stick leads a figure. Critically damped springs bring its velocity and its facing to those of the stick, as in
//! Holden's demonstration ("Spring-It-On", 2021).

use std::f32::consts::{LN_2, PI, TAU};

use glam::{Vec2, Vec3};

use super::features::{AHEAD, FEATURE_RATE, Root};
use super::trajectory::Trajectory;

/// After how many seconds half of a difference is gone, that of Holden's demonstration.
const HALF_LIFE: f32 = 0.27;
/// Of a critically damped spring of this half-life: half its damping, per second.
pub const RATE: f32 = 2.0 * LN_2 / HALF_LIFE;
/// What is asked for along an axis at most, in metres per second: so that nothing overflows.
const FASTEST: f32 = 100.0;
/// Below this length, in metres per second or of a stick, there is no direction.
const STILL: f32 = 1e-3;

/// The momentum of a figure, along x and z.
#[derive(Clone, Copy, Debug)]
pub struct Steering {
    /// Metres per second, and that per second.
    velocity: Vec2,
    acceleration: Vec2,
    /// Radians from +Z towards +X, and that per second.
    angle: f32,
    turning: f32,
}

impl Steering {
    /// Of a figure that stands and looks along `forward`.
    pub fn new(forward: Vec3) -> Self {
        Self {
            velocity: Vec2::ZERO,
            acceleration: Vec2::ZERO,
            angle: forward.x.atan2(forward.z),
            turning: 0.0,
        }
    }

    /// Metres per second over the ground, in the world.
    pub fn velocity(&self) -> Vec3 {
        Vec3::new(self.velocity.x, 0.0, self.velocity.y)
    }

    /// Where it looks.
    pub fn forward(&self) -> Vec3 {
        direction(self.angle)
    }

    /// Goes on by a frame towards a velocity along x and z; it looks along `look`, or where it goes if that is zero.
    /// Numbers that are not finite count as zero. Returns the trajectory of a figure that is at `root`.
    pub fn update(&mut self, root: &Root, velocity: Vec2, look: Vec2) -> Trajectory {
        let velocity = finite(velocity);
        let look = [finite(look), velocity].into_iter().find(|look| look.length() > STILL);
        let wanted = look.map_or(self.angle, |look| look.x.atan2(look.y));
        // The shorter way round.
        let wanted = self.angle + (wanted - self.angle + PI).rem_euclid(TAU) - PI;
        let seconds = 1.0 / FEATURE_RATE as f32;
        let after = |seconds: f32| self.after(seconds, velocity, wanted);
        let ahead = AHEAD.map(|frames| after(frames as f32 / FEATURE_RATE as f32));
        let positions = ahead.map(|(moved, _)| root.position + Vec3::new(moved.x, 0.0, moved.y));
        let directions = ahead.map(|(_, next)| direction(next.angle));
        *self = after(seconds).1;
        Trajectory::new(positions, directions)
    }

    /// The distance after some seconds, and the velocity then.
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
