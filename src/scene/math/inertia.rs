//! Fades out a difference between two motions: inertialisation (Bollo, 2016).

use glam::Vec3;

/// A curve from 0 at 0 to 1 at 1, with zero speed and acceleration at both ends: the quintic with the smoothest change.
pub fn ease(part: f32) -> f32 {
    part.powi(3) * (10.0 - 15.0 * part + 6.0 * part * part)
}

/// The difference that remains at `frame`. At frame 0, the difference is `offset` and changes by `speed` per frame. A
/// quintic brings the difference to rest at 0 within `steps` frames.
pub fn fade(offset: Vec3, speed: Vec3, frame: usize, steps: usize) -> Vec3 {
    if frame >= steps {
        return Vec3::ZERO;
    }
    let (t, length) = (frame as f32 / steps as f32, steps as f32);
    let (t3, t4, t5) = (t.powi(3), t.powi(4), t.powi(5));
    offset * (1.0 - 10.0 * t3 + 15.0 * t4 - 6.0 * t5) + speed * (length * (t - 6.0 * t3 + 8.0 * t4 - 3.0 * t5))
}
