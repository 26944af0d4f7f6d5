//! The step of [`foot_lock`](crate::foot_lock()). It has the options that text and JSON can express.

use std::fmt;

use mocap_scene::error::Result;
use mocap_scene::scene::Scene;

use crate::lock::{FootLockOptions, FootLockReport, FootLockWeights, foot_lock};
use crate::quantity::{centimetres, counted};
use crate::step::step;
use crate::{ContactOptions, Step, StepInput, StepKey, ValueKind};

step! {
    /// Holds feet still in contact and above the floor.
    ///
    /// The options of [`foot_lock`](crate::foot_lock()) know more.
    ///
    /// # Errors
    /// As [`foot_lock`](crate::foot_lock()).
    FootLock {
        /// Seconds in which a shift fades out after a contact, and fades in before a contact. Default: 0.2.
        blend: f64 = FootLockOptions::default().blend, ValueKind::Seconds;
        /// The largest height of a foot in contact above the level of rest, in metres. Default: 0.05.
        height: f64 = ContactOptions::default().height, ValueKind::Metres;
        /// The largest speed of a foot in contact, in metres per second. Default: 0.25.
        speed: f64 = ContactOptions::default().speed, ValueKind::MetresPerSecond;
        /// The factor of height or speed at which a foot leaves a contact. Default: 1.6.
        release: f64 = ContactOptions::default().release, ValueKind::Factor;
        /// The shortest contact, in seconds; shorter ones are dropped. Default: 0.08.
        shortest: f64 = ContactOptions::default().shortest, ValueKind::Seconds;
        /// The shortest gap between two contacts, in seconds; shorter ones are closed. Default: 0.05.
        gap: f64 = ContactOptions::default().gap, ValueKind::Seconds;
        /// The height of the floor along the up axis, in metres. Default: where the feet rest.
        floor: Option<f32> = None, ValueKind::Metres;
        /// The largest change of any other joint, in metres. If locking a foot would move a knee or the hips farther, a
        /// part of the sliding remains. Default: `None`, no foot slides.
        largest_change: Option<f64> = None, ValueKind::Metres;
        /// The weights of the lock that differ from their defaults. Default: `None`.
        weights: Option<FootLockWeights> = None, ValueKind::Numbers;
    }
}

impl Step for FootLock {
    const NAME: &'static str = "foot-lock";
    const HELP: &'static str = "hold feet still in contact and above the floor";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = FootLockReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<FootLockReport> {
        let options = FootLockOptions {
            contacts: ContactOptions {
                height: self.height,
                speed: self.speed,
                release: self.release,
                shortest: self.shortest,
                gap: self.gap,
                hands: false,
            },
            blend: self.blend,
            floor: self.floor,
            largest_change: self.largest_change,
            humanoid: input.bones().cloned(),
            weights: self.weights.unwrap_or_default(),
            ..FootLockOptions::default()
        };
        foot_lock(scene, input.animation, &options)
    }
}

impl fmt::Display for FootLockReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}; the feet slid {} in them, now {}; feet shifted by {} at most, hips lowered by {} at most",
            counted(self.contacts, "contact"),
            centimetres(self.slide_before),
            centimetres(self.slide_after),
            centimetres(self.largest_shift),
            centimetres(self.hips_lowered),
        )?;
        write!(
            f,
            "; foot speed at most {:.2} times and acceleration at most {:.2} times that without the lock",
            self.speed_ratio, self.acceleration_ratio
        )?;
        if let given_way @ 1.. = self.given_way.iter().sum::<usize>() {
            write!(f, "; the lock was relaxed in {}", counted(given_way, "frame"))?;
        }
        if !self.largest_other_joint.is_empty() {
            let by = centimetres(self.largest_other_change);
            write!(
                f,
                "; largest change of another joint: {}, by {by}",
                self.largest_other_joint
            )?;
        }
        Ok(())
    }
}
