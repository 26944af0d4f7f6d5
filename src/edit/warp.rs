//! Warps a motion in time, or bends its path over the ground.

use std::fmt;

use mocap_scene::error::Result;
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use super::warp_path::{PathFacing, PathPoint, WarpPathReport, warp_path};
use super::warp_time::{WarpTimeReport, warp_time};
use super::{Step, StepDocs, StepInput, StepKey, ValueKind};

/// Makes parts of a motion faster or slower, or bends its path over the ground.
///
/// The frame rate does not change, and new frames are interpolated.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::edit::{Step, StepInput, Warp};
/// use mocap::edit::report::WarpReport;
///
/// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?; // 0.9 s
/// let WarpReport::Time(report) = Warp::Moments(vec![(0.0, 0.0), (0.9, 1.8)]).apply(&mut scene, &StepInput::new())?
/// else {
///     unreachable!()
/// };
/// assert!((report.seconds - 1.8).abs() < 1e-9);
/// assert_eq!(scene.animations[0].frame_count(), 19);
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// [`Code::NoMotion`](mocap_scene::Code::NoMotion) if the scene lacks the animation.
///
/// For times: [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) if they are not finite, are negative, or do not
/// increase. [`Code::LimitExceeded`](mocap_scene::Code::LimitExceeded) if the result would be far longer than the
/// motion.
///
/// For a path, [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) without points, or if a number is not finite.
/// Also if only some points have times, or if the times are negative, do not increase from frame to frame, or are after
/// the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "WarpKeys", into = "WarpKeys")]
#[non_exhaustive]
pub enum Warp {
    /// Pairs of an old and a new time, in seconds. From pair to pair, both times increase. From the start to the first
    /// pair, and from pair to pair, the playback speed is constant. After the last pair, the playback speed is 1. If
    /// both times of every pair are exchanged, the warp is inverted. If the first new time is 0, the motion before the
    /// first old time is cut off.
    Moments(Vec<(f64, f64)>),
    /// The factor by which the whole motion becomes faster. It must be above 0; 0.5 is half the speed.
    Speed(f64),
    /// The figure passes each point at the time of this point. Its other motion, such as sway from step to step, does
    /// not change (motion warping: Witkin and Popovic, 1995). The step computes two natural cubic splines. The old
    /// spline goes through the old positions of the figure at the times of the points, the new spline through the
    /// points. The offset of the figure from the old spline becomes its offset from the new spline. Before the first
    /// point and after the last point, both splines continue straight. Heights and poses do not change.
    Path {
        /// The points, in the order of time.
        points: Vec<PathPoint>,
        /// The facing of the figure.
        facing: PathFacing,
    },
}

/// The options of all three kinds of warp. A warp has only the options of its own kind.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
struct WarpKeys {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    moments: Vec<(f64, f64)>,
    speed: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    path: Vec<PathPoint>,
    facing: Option<PathFacing>,
}

impl From<Warp> for WarpKeys {
    fn from(warp: Warp) -> Self {
        let none = Self::default();
        match warp {
            Warp::Moments(moments) => Self { moments, ..none },
            Warp::Speed(speed) => Self {
                speed: Some(speed),
                ..none
            },
            Warp::Path { points, facing } => Self {
                path: points,
                facing: Some(facing),
                ..none
            },
        }
    }
}

impl TryFrom<WarpKeys> for Warp {
    type Error = &'static str;

    fn try_from(keys: WarpKeys) -> Result<Self, Self::Error> {
        let WarpKeys {
            moments,
            speed,
            path,
            facing,
        } = keys;
        match (moments.is_empty(), speed, path.is_empty(), facing) {
            (false, None, true, None) => Ok(Self::Moments(moments)),
            (true, Some(speed), true, None) if speed > 0.0 => Ok(Self::Speed(speed)),
            (true, Some(_), true, None) => Err("speed must be above 0"),
            (true, None, false, facing) => Ok(Self::Path {
                points: path,
                facing: facing.unwrap_or_default(),
            }),
            _ => Err("a warp has either SECONDS=SECONDS,..., or speed=FACTOR, or path=... with or without facing"),
        }
    }
}

/// With `speed`, the new speed applies up to this time, in seconds. It is longer than any motion.
const LONGEST: f64 = 1e9;

impl Warp {
    pub(crate) const DOCS: StepDocs = StepDocs {
        step: "Makes parts of a motion faster or slower, or bends its path over the ground.",
        keys: &[
            "Pairs of an old and a new time, in seconds. From pair to pair, both times increase. Time 0 stays time 0, \
             unless the first new time is 0.",
            "The factor by which the whole motion becomes faster. It must be above 0; 0.5 is half the speed.",
            "Points over the ground through which the figure passes, in metres. All points have a time, or none has one.",
            "The facing of the figure: it turns with the path, or keeps its old facing. Default: along.",
        ],
    };
}

impl crate::step::sealed::Sealed for Warp {}

impl Step for Warp {
    const NAME: &'static str = "warp";
    const HELP: &'static str = "change the timing or the speed, or bend the path over the ground";
    const KEYS: &'static [StepKey] = &[
        StepKey::new("moments", ValueKind::Moments),
        StepKey::new("speed", ValueKind::Factor),
        StepKey::new("path", ValueKind::Path),
        StepKey::new("facing", ValueKind::OneOf(&["along", "kept"])),
    ];
    type Report = WarpReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<WarpReport> {
        let at_speed = |speed: f64| [(0.0, 0.0), (LONGEST * speed, LONGEST)];
        match self {
            Self::Moments(moments) => warp_time(scene, input.animation, moments).map(WarpReport::Time),
            Self::Speed(speed) => warp_time(scene, input.animation, &at_speed(*speed)).map(WarpReport::Time),
            Self::Path { points, facing } => warp_path(scene, input, points, *facing).map(WarpReport::Path),
        }
    }
}

/// The report of [`Warp`].
///
/// [`Warp`](crate::Warp) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
#[non_exhaustive]
pub enum WarpReport {
    /// The report of a warp by `moments` or by `speed`.
    Time(WarpTimeReport),
    /// The report of a warp by `path`.
    Path(WarpPathReport),
}

impl fmt::Display for WarpReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time(report) => report.fmt(f),
            Self::Path(report) => report.fmt(f),
        }
    }
}
