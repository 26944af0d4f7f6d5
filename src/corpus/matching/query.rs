//! Queries: a part of a motion, or a pose.

use mocap_figure::body::Body;
use mocap_figure::convert::{Moment, TimeRange, part_ticks};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;

use super::clip::{SAMPLE_RATE, figure_of};
use crate::survey::{Fingerprint, Motion};

/// The longest query, in seconds.
const LONGEST: f64 = 60.0;

/// A part of a motion, or a pose, in the form that a search compares with the clips of a database.
///
/// The [module](crate::matching) has an example.
#[derive(Clone, Debug, PartialEq)]
pub struct Query {
    pub(super) samples: Vec<i8>,
}

impl Query {
    /// Makes a query from a part of an animation. `animation` is an index into [`Scene::animations`].
    ///
    /// # Errors
    /// [`Code::NoMotion`] without this animation, [`Code::NotHumanoid`], and [`Code::InvalidValue`] for a part that is
    /// empty, outside the motion, or longer than a minute.
    pub fn part(scene: &Scene, animation: usize, part: TimeRange) -> Result<Self> {
        let motion = motion(scene, animation)?;
        let (first, last) = part_ticks(
            scene.animations.get(animation),
            part.first,
            part.last,
            motion.first as f64,
        )?;
        let seconds = (last.min(motion.frames as f64 - 1.0) - first) / motion.rate;
        if seconds > LONGEST {
            let diagnostic = Diagnostic::new(Code::InvalidValue, "the part to look for is too long");
            let found = format!("{seconds:.1} seconds");
            return Err(diagnostic
                .expected_found(format!("at most {LONGEST} seconds"), found)
                .into());
        }
        Ok(Self::sampled(
            &motion,
            first,
            (seconds * SAMPLE_RATE + 0.01).floor() as usize + 1,
        ))
    }

    /// Makes a query from the pose at one time of an animation. The movement of the limbs hardly counts.
    ///
    /// # Errors
    /// The errors of [`part`](Self::part).
    pub fn pose(scene: &Scene, animation: usize, at: Moment) -> Result<Self> {
        let motion = motion(scene, animation)?;
        let (frame, _) = part_ticks(scene.animations.get(animation), Some(at), None, 0.0)?;
        Ok(Self::sampled(&motion, frame, 1))
    }

    fn sampled(motion: &Motion, first: f64, samples: usize) -> Self {
        let samples = Fingerprint::sampled(motion, SAMPLE_RATE, first, samples);
        Self {
            samples: samples.values,
        }
    }

    /// The duration in seconds; 0 for a pose.
    pub fn seconds(&self) -> f64 {
        (self.count() - 1) as f64 / SAMPLE_RATE
    }

    pub(super) fn count(&self) -> usize {
        self.samples.len() / crate::survey::WIDTH
    }
}

/// The motion of a humanoid.
fn motion(scene: &Scene, animation: usize) -> Result<Motion<'_>> {
    let no_motion = || Diagnostic::new(Code::NoMotion, "the file has no motion to search for");
    let clip = scene.animations.get(animation).ok_or_else(no_motion)?;
    if clip.frame_count() == 0 || clip.ticks_per_second <= 0.0 {
        return Err(no_motion().into());
    }
    let figure = figure_of(scene);
    let motion = Motion::new(scene, clip, &figure)?;
    match motion.body {
        Some(_) => Ok(motion),
        None => {
            let message = format!(
                "a search compares the limbs of a humanoid or of an animal on four legs: {}",
                figure.humanoid.reason
            );
            Err(Diagnostic::new(Code::NotHumanoid, message)
                .help(Body::help(scene))
                .into())
        }
    }
}
