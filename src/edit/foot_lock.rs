//! The step that calls [`foot_lock`](crate::foot_lock()). The step has the options that text and JSON can express.

use std::fmt;

use mocap_scene::error::Result;
use mocap_scene::scene::Scene;

use crate::lock::{FootLockOptions, FootLockReport, FootLockWeights, foot_lock};
use crate::quantity::{centimetres, counted};
use crate::step::step;
use crate::{ContactOptions, Step, StepInput, StepKey, ValueKind};

step! {
    /// Holds each foot still during ground contact, and keeps it above the floor.
    ///
    /// [`FootLockOptions`](crate::FootLockOptions) has further options.
    ///
    /// # Errors
    /// The errors of [`foot_lock`](crate::foot_lock()).
    FootLock {
        /// Seconds before a contact during which the correction of the foot fades in, and after a contact during which
        /// it fades out. Default: 0.2.
        blend: f64 = FootLockOptions::default().blend, ValueKind::Seconds;
        /// During a contact, the largest height of a foot above the height at which it rests, in metres. Default: 0.05.
        height: f64 = ContactOptions::default().height, ValueKind::Metres;
        /// During a contact, the largest speed of a foot, in metres per second. Default: 0.25.
        speed: f64 = ContactOptions::default().speed, ValueKind::MetresPerSecond;
        /// A contact ends when the height or the speed of the foot is above this factor times `height` or `speed`.
        /// Default: 1.6.
        release: f64 = ContactOptions::default().release, ValueKind::Factor;
        /// The shortest contact, in seconds. The step ignores shorter contacts. Default: 0.08.
        shortest: f64 = ContactOptions::default().shortest, ValueKind::Seconds;
        /// The shortest gap between two contacts, in seconds. If a gap is shorter, both contacts become one. Default:
        /// 0.05.
        gap: f64 = ContactOptions::default().gap, ValueKind::Seconds;
        /// The height of the floor along the up axis, in metres. Default: the height at which the feet rest.
        floor: Option<f32> = None, ValueKind::Metres;
        /// The largest distance by which the step may move a joint that is not part of a foot, in metres. If a full
        /// lock would move a knee or the hips farther, a part of the sliding remains. Default: `None`, no limit.
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
            "{}; the feet slid {} during contacts, now {}; feet shifted by {} at most, hips lowered by {} \
             and raised by {} at most",
            counted(self.contacts, "contact"),
            centimetres(self.slide_before),
            centimetres(self.slide_after),
            centimetres(self.largest_shift),
            centimetres(self.hips_lowered),
            centimetres(self.hips_raised),
        )?;
        write!(
            f,
            "; the lock multiplies the speed of a foot by {:.2} at most, and the acceleration by {:.2} at most",
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
