//! Joins two motions.

use std::fmt;

use mocap_scene::error::{Code, Result};
use mocap_scene::limits::not_negative;
use mocap_scene::pose::Trs;
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::alike::Alikeness;
use super::body::metres_per_unit;
use super::carrier::Carrier;
use super::fit::Fit;
use super::frames::lost_weights;
use super::inertia::{Seam, onward};
use super::pair::pair;
use super::quantity::{centimetres, degrees, metres};
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Appends a second motion, which has the same joints. At the seam, the last frame of the first motion and the
    /// first frame of the second motion become one frame. So `concat` restores a motion that was cut in two. The scene
    /// gets the warning `poses-apart` if the poses at the seam differ by more than 45 degrees or 30 cm, or the
    /// speeds by more than 1 m/s. With `within`, the step joins the two most similar frames near the end of the first
    /// motion and near the start of the second motion. To compare two frames, it uses the distance of [motion
    /// graphs](crate::graph), over a third of a second around each frame.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Concat, Step, StepInput};
    ///
    /// let mut walk = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// let again = walk.clone();
    /// let report = Concat::new().blend(0.2).apply(&mut walk, &StepInput::new().other(&again))?;
    /// assert_eq!((report.seam, report.frames), (74, 149));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if the joints differ, the blend is not finite, or `within` is not from 0 to 10 s;
    /// [`Code::NoMotion`] if one of the animations is missing.
    Concat {
        /// The number of the second motion among the inputs of a command, from 2. Default: the next one.
        with: Option<usize> = None, ValueKind::Input;
        /// Seconds after the seam during which the difference between the two poses fades out. Default: 0.3.
        blend: f64 = 0.3, ValueKind::Seconds;
        /// Whether to move and turn the second motion so that it begins at the position and heading at which the first
        /// motion ends. Default: `true`.
        align: bool = true, ValueKind::Flag;
        /// The step searches this many seconds at the end of the first motion and at the beginning of the second motion
        /// for the two most similar frames. Default: 0, which keeps both motions completely.
        within: f64 = 0.0, ValueKind::Seconds;
    }
}

impl Step for Concat {
    const NAME: &'static str = "concat";
    const HELP: &'static str = "append the next input, or the input number N";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_OTHER: bool = true;
    type Report = ConcatReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<ConcatReport> {
        concat(scene, input, input.second::<Self>()?, self)
    }

    fn with(&self) -> Option<usize> {
        self.with
    }
}

/// The report of [`Concat`].
///
/// [`Concat`](crate::Concat) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ConcatReport {
    /// The frame of the result at which the two motions join.
    pub seam: usize,
    /// The number of frames after the step.
    pub frames: usize,
    /// The largest difference between the rotations of a joint in both motions at the seam, in degrees. The step fades
    /// it out.
    pub largest_rotation: f32,
    /// The distance by which the step moved the second motion over the ground, in metres.
    pub moved: f32,
    /// The seconds that the step dropped from the end of the first motion and from the beginning of the second motion.
    pub left_out: [f64; 2],
    /// The mean distance in metres between the joints of the first motion and the joints of the second motion, at the
    /// seam. `None` if the option `within` is 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub apart: Option<f32>,
}

impl fmt::Display for ConcatReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} frames, seam at frame {}; rotations changed by {} at most after the seam; the second motion was moved by {}",
            self.frames,
            self.seam,
            degrees(self.largest_rotation),
            metres(self.moved),
        )?;
        match self.apart {
            None => Ok(()),
            Some(apart) => write!(
                f,
                "; {:.2} s of the end of the first and {:.2} s of the beginning of the second were dropped; joints are {} apart",
                self.left_out[0],
                self.left_out[1],
                centimetres(apart),
            ),
        }
    }
}

fn concat(scene: &mut Scene, input: &StepInput<'_>, other: &Scene, options: &Concat) -> Result<ConcatReport> {
    let animation = input.animation;
    not_negative(Code::InvalidValue, "blend", options.blend)?;
    let (first, mut second) = pair(scene, animation, other)?;
    let carrier = Carrier::new(scene, &first);
    carrier.share_parents(scene, &first, &mut second);
    let alike = Alikeness::new(scene, input, other, &first, options.within)?.map(|alikeness| alikeness.seam());
    let [last, start] = match alike {
        Some(alike) => [alike.at[0] * first.rate, alike.at[1] * second.rate],
        None => [(first.len() - 1) as f64, 0.0],
    };
    let last = (last.round() as usize).min(first.len() - 1);
    let mut rows: Vec<Vec<Trs>> = (0..=last).map(|frame| first.row(frame)).collect();
    // The second motion, resampled to the frame rate of the first.
    let step = second.rate / first.rate;
    let count = first.up_to(((second.len() - 1) as f64 - start) / step + 1e-6, &[&second])?;
    let mut added: Vec<Vec<Trs>> = (0..count)
        .map(|frame| second.row_at(start + frame as f64 * step))
        .collect();
    let mut report = ConcatReport {
        seam: last,
        left_out: [(first.len() - 1 - last) as f64 / first.rate, start / second.rate],
        apart: alike.map(|alike| alike.apart),
        ..ConcatReport::default()
    };
    if options.align {
        let placement = carrier.placement(&added[0], &rows[last]);
        report.moved = placement.distance() * metres_per_unit(scene, input);
        added.iter_mut().for_each(|row| carrier.apply(&placement, row));
    }
    let before = [last.saturating_sub(2), last.saturating_sub(1), last].map(|frame| &*rows[frame]);
    let next = added.get(1).unwrap_or(&added[0]);
    let mut fit = Fit::new(scene, &first, metres_per_unit(scene, input));
    fit.see_rotations(&rows[last], &added[0], last);
    fit.see_positions(&rows[last], &added[0], last);
    if last > 0 && count > 1 {
        fit.see_speeds([&rows[last - 1], &rows[last]], [&added[0], next], last);
    }
    let warning = fit.warning(
        Concat::NAME,
        "search for similar frames with within=0.5 or a larger value, or cut one of the motions with the step trim",
    );
    let seam = Seam::new([&rows[last], &onward(before)], [&added[0], next]);
    report.largest_rotation = seam.largest_rotation();
    if !seam.is_closed() {
        let steps = first.frames_in(options.blend);
        for (frame, row) in added.iter_mut().enumerate().take(steps) {
            seam.apply(row, frame, steps);
        }
    }
    rows.extend(added.into_iter().skip(1));
    report.frames = rows.len();
    let taken = (0..=last).map(|frame| (&first, frame as f64));
    let taken: Vec<_> = taken
        .chain((1..count).map(|frame| (&second, start + frame as f64 * step)))
        .collect();
    let mut joined = first.with_rows_of(rows, &taken);
    let seam = [(&first, last as f64), (&second, start)];
    joined.fade_weights(last, seam, first.frames_in(options.blend));
    joined.write_all(scene, animation);
    scene
        .warnings
        .extend(warning.into_iter().chain(lost_weights(scene, other)));
    Ok(report)
}
