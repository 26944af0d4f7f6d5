//! The options of arrays.

use mocap_figure::HumanoidMap;
use mocap_figure::contacts::ContactRule;
use mocap_figure::convert::Moment;
use mocap_scene::options::setters;
use mocap_scene::scene::UpAxis;
use serde::{Deserialize, Serialize};

use crate::arrays::{Rotation, RotationSpace};

/// Options of the arrays. By default, the arrays have every joint and end site, positions in the world, rotations
/// relative to the parent as quaternions, and the file's own unit, axes and frames.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::arrays::{ArrayOptions, Moment, Rotation, Arrays};
/// use mocap::scene::UpAxis;
///
/// let options = ArrayOptions::new()
///     .rotation(Rotation::SixD)
///     .frames_per_second(30.0)
///     .out_metres_per_unit(1.0)
///     .out_up(UpAxis::Z)
///     .first(Moment::Seconds(0.5))
///     .joints("Foot|Hips".to_owned());
/// let motion = Arrays::of(&mocap::import("fixtures/real/cmu_01_01.bvh")?, &options)?;
/// assert_eq!(motion.joints()[0].name, "Hips");
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct ArrayOptions {
    /// The space of positions. Default: the world.
    pub space: Space,
    /// The representation of rotations. Default: a quaternion.
    pub rotation: Rotation,
    /// The coordinate frame of rotations. Default: the parent.
    pub rotation_space: RotationSpace,
    /// A regular expression for the names of the joints and end sites to keep; it may match anywhere in a name.
    /// Default: all.
    pub joints: Option<String>,
    /// Frames per second of the output. Between two frames, positions are interpolated linearly and rotations by
    /// slerp; at a [cut](mocap_scene::Scene::cuts) the nearer side is used. Default: the file's own frames.
    pub frames_per_second: Option<f64>,
    /// The first time to keep, not after the last frame. Default: the start.
    pub first: Option<Moment>,
    /// The last time to keep; a time after the end means the end. Default: the end.
    pub last: Option<Moment>,
    /// Metres per unit of length of the file. Default: the unit that the file states. If the file states none and the
    /// unit is needed: the guess of [`Survey`](mocap_figure::Survey).
    pub metres_per_unit: Option<f64>,
    /// The up axis of the file. Default: the axis that the file states. If the file states none and the axis is needed:
    /// the guess of [`Survey`](mocap_figure::Survey).
    pub up: Option<UpAxis>,
    /// Metres per unit of length of the output. Default: the file's own unit.
    pub out_metres_per_unit: Option<f64>,
    /// The up axis of the output. Default: the file's own axes.
    pub out_up: Option<UpAxis>,
    /// The joints of the humanoid's bones. The unit, the up axis and the feet are found from the bones. Default: none,
    /// so all bones are searched for.
    pub bones: HumanoidMap,
    /// Whether to compute velocities: central differences, (p(i + 1) - p(i - 1)) / 2 x the frame rate. They are
    /// one-sided at the first and the last frame, and 0 for a single frame. Default: `false`.
    pub velocities: bool,
    /// The thresholds for foot contacts. Default: `None`, no contacts.
    pub contacts: Option<Contacts>,
}

setters! {
    ArrayOptions {
        space: Space,
        rotation: Rotation,
        rotation_space: RotationSpace,
        joints: Option<String>,
        frames_per_second: Option<f64>,
        first: Option<Moment>,
        last: Option<Moment>,
        metres_per_unit: Option<f64>,
        up: Option<UpAxis>,
        out_metres_per_unit: Option<f64>,
        out_up: Option<UpAxis>,
        bones: HumanoidMap,
        velocities: bool,
        contacts: Option<Contacts>,
    }
}

/// The coordinate frame of positions.
///
/// [`ArrayOptions`](crate::arrays::ArrayOptions) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Space {
    /// The world.
    #[default]
    World,
    /// The position of the root joint in the same frame, along the axes of the world.
    Root,
    /// The joint's parent in the output, along the axes of the parent. A joint without a parent is relative to the
    /// world.
    Local,
}

/// Foot contacts, by the rule of [`ContactOptions::detect`](mocap_edit::ContactOptions::detect). A contact of a foot's
/// point starts when the point is low and slow. It ends when the height or the speed exceeds 1.6 times its threshold.
/// Contacts shorter than 0.08 seconds are dropped; gaps shorter than 0.05 seconds are closed.
///
/// Heights are measured along the up axis, from the resting level of a point. The resting level is the fifth percentile
/// of the height of the lowest point, so a rest pose in the first frame does not matter. Ankles and the balls of the
/// feet have separate levels. Joints that a pattern selects share one level. Speeds are central differences, in any
/// direction.
///
/// [`ArrayOptions`](crate::arrays::ArrayOptions) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct Contacts {
    /// A regular expression for the names of the feet among the joints of the output. Default: the ankles and the
    /// balls of the feet of a humanoid; for any other skeleton `(?i)foot|toe|ankle`.
    pub feet: Option<String>,
    /// The largest height above the resting level, in metres. Default: 0.05.
    pub height: f64,
    /// The largest speed, in metres per second. Default: 0.25.
    pub speed: f64,
}

impl Default for Contacts {
    fn default() -> Self {
        let rule = ContactRule::default();
        Self {
            feet: None,
            height: rule.height,
            speed: rule.speed,
        }
    }
}

setters! {
    Contacts {
        feet: Option<String>,
        height: f64,
        speed: f64,
    }
}
