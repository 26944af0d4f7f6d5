//! What a caller can ask for.

use serde::{Deserialize, Serialize};

use crate::arrays::{Rotation, RotationSpace};
use crate::convert::Moment;
use crate::scene::UpAxis;

/// What to put into the arrays. The default is the file as it is: every joint and end site, positions in the world,
/// rotations to the parent as quaternions, the file's own unit, axes, frames and length.
///
/// ```
/// use mocap::arrays::{Moment, Options, Rotation, arrays};
/// use mocap::scene::UpAxis;
///
/// let options = Options {
///     rotation: Rotation::SixD,
///     frames_per_second: Some(30.0),
///     metres_per_unit: Some(1.0),
///     up: Some(UpAxis::Z),
///     first: Some(Moment::Seconds(0.5)),
///     joints: Some("Foot|Hips".to_owned()),
///     ..Options::default()
/// };
/// let motion = arrays(&mocap::import("fixtures/real/cmu_01_01.bvh")?, &options)?;
/// assert_eq!(motion.joints()[0].name, "Hips");
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// What positions are relative to. Default: the world.
    pub space: Space,
    /// What the numbers of a rotation are. Default: a quaternion.
    pub rotation: Rotation,
    /// What rotations are relative to. Default: the parent.
    pub rotation_space: RotationSpace,
    /// A regular expression for the names of the joints and end sites to keep; it may match anywhere in a name.
    /// Default: all.
    pub joints: Option<String>,
    /// Frames per second of the output. In between two frames, positions move on a line and rotations on the shorter
    /// arc; a [cut](crate::skeleton::cuts) is not smeared, the nearer side stands. Default: the file's own frames.
    pub frames_per_second: Option<f64>,
    /// The first moment to keep, not after the last frame. Default: the start.
    pub first: Option<Moment>,
    /// The last moment to keep, or a later one for all of the rest. Default: the end.
    pub last: Option<Moment>,
    /// Metres in one unit of length of the output. Default: the file's own unit.
    pub metres_per_unit: Option<f64>,
    /// Metres in one unit of length of the file. Default: what the file says, else what
    /// [`survey`](crate::skeleton::survey()) guesses.
    pub file_metres_per_unit: Option<f64>,
    /// The axis of the output that points up. Default: the file's own axes.
    pub up: Option<UpAxis>,
    /// The axis of the file that points up. Default: what [`survey`](crate::skeleton::survey()) guesses.
    pub file_up: Option<UpAxis>,
    /// Whether to give velocities. In frame i they are (p(i + 1) - p(i - 1)) / 2 x the frame rate; at the first and
    /// the last frame the difference to the one neighbour there is x the frame rate; 0 where there is one frame only.
    pub velocities: bool,
    /// Whether to say which feet stand on the ground, and what counts as that.
    pub contacts: Option<Contacts>,
}

/// What positions are relative to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Space {
    /// The space in which the root stands.
    #[default]
    World,
    /// The position of the root joint in the same frame; the axes stay those of the world.
    Root,
    /// The parent that the output lists, in its axes; the world for a joint without one.
    Local,
}

/// What counts as a foot that stands on the ground: low and slow at once.
///
/// The ground is where the lowest foot is in most frames: at the height below which it is in a twentieth of them, so
/// that a stray rest pose does not count. Heights are along the axis that points up, speeds those of central differences, in any direction. The defaults are ours, for human figures: a foot
/// in stance stays within a few centimetres and a few decimetres a second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Contacts {
    /// A regular expression for the names of the feet among the joints of the output. Default: `(?i)foot|toe|ankle`.
    pub feet: String,
    /// Metres above the ground, at most. Default: 0.05. An ankle stands higher above the ground than a toe: where the
    /// feet of a skeleton are ankles and toes, one threshold counts heel and toe apart.
    pub height: f64,
    /// Metres a second, at most. Default: 0.4.
    pub speed: f64,
}

impl Default for Contacts {
    fn default() -> Self {
        Self {
            feet: "(?i)foot|toe|ankle".to_owned(),
            height: 0.05,
            speed: 0.4,
        }
    }
}
