//! Determines the meaning of a file's arrays from their names, or from their shapes if there are no names.

mod kimodo;
#[doc(hidden)]
pub(super) mod mhr;
pub(super) mod opensim;
mod own;
mod plausible;
mod points;
mod robot;
mod smpl;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{Limits, limit_exceeded};
use mocap_scene::scene::{Confidence, Format, Scene, Topic};

use super::motion::Motion;
use super::ndarray::{Entries, NdArray};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

pub(super) use self::robot::BASE as BASE_OF_ROBOT;

/// The array name for a table without a header.
pub(super) const TABLE: &str = "rows";

/// The help if arrays are not a motion.
const KNOWN: &str = "arrays are known by their names: poses and trans (AMASS), global_orient and body_pose (SMPL-X, \
                     GVHMR, GEM-X), posed_joints (Kimodo), pred_joint_coords (SAM 3D Body), the arrays of mocap fk, \
                     one array of positions (frames, joints, 3), or one of 69, 263 or 322 numbers a frame";

/// The scene of a file's arrays.
pub(super) fn scene(
    entries: &Entries<'_>,
    format: Format,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<Scene, Failure> {
    let motions = entries.of_each(robot::OFFSETS);
    if !motions.is_empty() {
        return robot::scene(&motions, options, format);
    }
    let reader = Reader { entries, options };
    let has_lengths = own::is_own(entries) || entries.get("posed_joints").is_some() || mhr::is_motion(entries);
    if has_lengths && options.body.is_some() {
        return Err(needless_body());
    }
    if own::is_own(entries) {
        return own::scene(&reader, format, warnings);
    }
    let motion = match () {
        () if entries.get("posed_joints").is_some() => kimodo::motion(&reader)?,
        () if mhr::is_motion(entries) => return mhr::scene(&reader, format, warnings),
        () if robot::is_motion(entries) => return robot::scene(&[("", entries.clone())], options, format),
        () if smpl::is_poses(entries) => smpl::of_poses(&reader)?,
        () => match smpl::dictionary(entries) {
            Some(prefix) => smpl::of_dictionary(&reader, &prefix)?,
            None => {
                let Some(array) = points::only_array(entries) else {
                    let help = mhr::needs_joints(entries).unwrap_or(KNOWN);
                    return Err(Box::new(
                        refused("no array of the file has a known layout of motions", entries).help(help),
                    ));
                };
                match smpl::of_flat(&reader, array)? {
                    Some(motion) => motion,
                    None if options.body.is_some() => return Err(needless_body()),
                    None => {
                        return match points::of_humanml3d(&reader, array, format, warnings)? {
                            Some(scene) => Ok(scene),
                            None => points::scene(&reader, array, format, warnings),
                        };
                    }
                }
            }
        },
    };
    Ok(motion.into_scene(format, warnings))
}

/// The error if the caller gives a body, but the arrays have positions.
fn needless_body() -> Failure {
    let message = "{body} is for arrays of rotations, but these arrays have joint positions";
    let help = "omit {body}; mocap retarget transfers the motion to another body";
    Box::new(Diagnostic::new(Code::InvalidValue, message).help(help))
}

fn refused(message: &str, entries: &Entries<'_>) -> Diagnostic {
    Diagnostic::new(Code::MissingKeyword, message).expected_found("a motion in a known layout", entries.describe())
}

/// The arrays of a file, and the read options.
struct Reader<'r, 'a> {
    entries: &'r Entries<'a>,
    options: &'r ReadOptions,
}

impl<'a> Reader<'_, 'a> {
    /// The frame rate that the file states, in frames per second.
    fn stated_rate(&self) -> Option<f64> {
        const NAMES: &[&str] = &[
            "mocap_framerate",
            "mocap_frame_rate",
            "frame_rate",
            "framerate",
            "fps",
            "mocap_fps",
        ];
        self.entries.first(NAMES).and_then(NdArray::scalar)
    }

    /// The frame rate that the file states, in frames per second, or else `usual`, which is recorded as an assumption.
    fn frame_rate(&self, usual: f64, motion: &mut Motion) -> Result<(), Failure> {
        let stated = self.stated_rate();
        if stated.is_none() && self.options.retime.is_none() {
            let choice = format!("{usual} frames per second");
            motion.assume(
                Topic::FrameRate,
                choice,
                "the arrays state no frame rate; this rate is usual for such arrays",
                Confidence::Likely,
            );
        }
        motion.frame_rate = self.options.frame_rate_or(stated.unwrap_or(usual))?;
        Ok(())
    }

    /// The array with this name. Its shape must be `frames`, then `widths`.
    fn numbers(&self, name: &str, frames: Option<usize>, widths: &[usize]) -> Result<(usize, Vec<f64>), Failure> {
        let Some(array) = self.entries.get(name) else {
            let message = format!("the array {name} is missing");
            return Err(Box::new(
                Diagnostic::new(Code::MissingKeyword, message)
                    .expected_found(format!("an array {name}"), self.entries.describe()),
            ));
        };
        self.numbers_of(name, array, frames, widths)
    }

    /// The numbers of an array with `widths` numbers per frame, and its number of frames. Leading axes of length 1 are
    /// dropped.
    fn numbers_of(
        &self,
        name: &str,
        array: &NdArray<'a>,
        frames: Option<usize>,
        widths: &[usize],
    ) -> Result<(usize, Vec<f64>), Failure> {
        let mut shape = array.shape.as_slice();
        while shape.len() > widths.len() + 1 && shape[0] == 1 {
            shape = &shape[1..];
        }
        let width: usize = widths.iter().product();
        let is_flat = shape.len() == 2 && shape[1] == width;
        let found = shape.first().copied().unwrap_or(0);
        if !array.is_number()
            || shape.is_empty()
            || !(is_flat || shape[1..] == *widths)
            || frames.is_some_and(|frames| frames != found)
        {
            let axes: Vec<String> = widths.iter().map(ToString::to_string).collect();
            let rows = frames.map_or("frames".to_owned(), |frames| frames.to_string());
            return Err(Box::new(
                Diagnostic::new(
                    Code::RowLength,
                    format!("the shape of the array {name} does not match its name"),
                )
                .expected_found(format!("({rows}, {})", axes.join(", ")), array.shape_text()),
            ));
        }
        self.check_values(array)?;
        Ok((found, array.numbers()))
    }

    fn check_values(&self, array: &NdArray<'_>) -> Result<(), Failure> {
        let limits: &Limits = &self.options.limits;
        let (most, count) = (limits.expanded_values(array.bytes.len() as u64), array.count() as u64);
        match count <= most {
            true => Ok(()),
            false => Err(Box::new(limit_exceeded(
                format!("at most {most} values"),
                count.to_string(),
            ))),
        }
    }
}
