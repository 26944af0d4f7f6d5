//! Motion as arrays, for NumPy, data frames and training code: positions and rotations of joints in every frame.
//!
//! [`Arrays::of`](crate::arrays::Arrays::of) computes the arrays. [`Arrays`] has a method for each format: `.npz`, CSV,
//! Arrow tables (feature `arrow`) and Parquet files (feature `parquet`). Functions such as [`robot_csv`] write the
//! motion of a robot, contacts, a distance matrix and time series.
//!
//! | array | shape | values |
//! |---|---|---|
//! | [`Arrays::positions`] | frames x joints x 3 | x, y, z in the unit and the axes of the output |
//! | [`Arrays::rotations`] | frames x joints x [`Rotation::width`] | see [`Rotation`] |
//! | [`Arrays::velocities`] | frames x joints x 3 | velocities of the positions, in units per second |
//! | [`Arrays::contacts`] | frames x joints | whether a foot is in contact with the ground |
//!
//! Each array is one `Vec`, in row-major order. A frame's time is its index / [`Arrays::frame_rate`] seconds. The
//! importer replaces NaN and infinity by the last finite value, and applies the root's OFFSET by
//! [`Importer::root_offset`](mocap_io::Importer::root_offset). The scene's warnings and the provenance record both
//! operations.

#[cfg(feature = "npz")]
mod body;
mod chain;
mod contacts;
mod csv;
mod frame;
mod joints;
mod lanes;
#[cfg(feature = "npz")]
mod mhr;
#[cfg(feature = "npz")]
pub(crate) mod npz;
mod options;
#[cfg(feature = "parquet")]
mod parquet;
mod pickle;
pub(crate) mod robot;
mod rotation;
mod rows;
#[cfg(feature = "npz")]
mod skeletons;
#[cfg(feature = "arrow")]
#[doc(hidden)]
pub mod table;
mod timeline;
#[cfg_attr(
    not(feature = "npz"),
    expect(dead_code, reason = "files of training code are archives of NumPy")
)]
pub(crate) mod trainers;

use serde::Serialize;

use mocap_formats::gltf::report::Provenance;
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::limits::Limits;
use mocap_scene::math::velocity;
use mocap_scene::scene::{NodeId, Scene, UpAxis};

#[cfg(feature = "npz")]
#[doc(hidden)]
pub use self::body::BodyArrays;
#[cfg(feature = "npz")]
pub use self::body::BodyLayout;
#[doc(hidden)]
pub use self::joints::Joint;
#[cfg(feature = "npz")]
#[doc(hidden)]
pub use self::npz::{contacts_npz, matrix_npy, robot_npz, robot_qpos_npz};
pub use self::options::{ArrayOptions, Contacts, Space};
#[cfg(feature = "parquet")]
#[doc(hidden)]
pub use self::parquet::time_series_parquet;
#[doc(hidden)]
pub use self::robot::{robot_csv, robot_pickle};
pub use self::rotation::{Rotation, RotationSpace};
pub use mocap_figure::convert::Moment;
#[doc(hidden)]
pub use mocap_scene::files::csv_field;

/// A motion as arrays, and their description.
///
/// [`Arrays::of`](crate::arrays::Arrays::of) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Arrays {
    /// The meaning and the origin of the values.
    pub header: Header,
    /// The number of frames; 0 if the file has no motion.
    pub frames: usize,
    /// The positions: frames x joints x 3.
    pub positions: Vec<f32>,
    /// The rotations: frames x joints x [`Rotation::width`].
    pub rotations: Vec<f32>,
    /// The velocities, if requested: frames x joints x 3.
    pub velocities: Option<Vec<f32>>,
    /// The contacts of the feet, if requested: frames x joints. The value of a joint that is not a foot is `false`.
    pub contacts: Option<Vec<bool>>,
}

impl Arrays {
    /// The joints, in the order of the second axis of the arrays.
    pub fn joints(&self) -> &[Joint] {
        &self.header.joints
    }

    /// Frames per second; 0 without motion.
    pub fn frame_rate(&self) -> f64 {
        self.header.frame_rate
    }

    /// Refuses values that are not finite. Sums of positions far from the origin can overflow.
    ///
    /// # Errors
    /// [`Code::Unrepresentable`], with the joint.
    fn check(&self) -> Result<()> {
        let columns = [
            ("position", self.positions.as_slice(), 3),
            ("rotation", &self.rotations, self.header.rotation.width()),
            ("velocity", self.velocities.as_deref().unwrap_or_default(), 3),
        ];
        for (what, values, width) in columns {
            let Some(wrong) = values.iter().position(|value| !value.is_finite()) else {
                continue;
            };
            let row = wrong / width;
            let (frame, joint) = (row / self.header.joints.len(), row % self.header.joints.len());
            let message = format!("the {what} in frame {frame} is not finite");
            return Err(Diagnostic::new(Code::Unrepresentable, message)
                .in_joint(&self.header.joints[joint].name)
                .help("positions add up to more than 32-bit numbers hold: check the unit and the scales of the file")
                .into());
        }
        Ok(())
    }

    /// The number of rows of a table with a row for each frame and joint.
    pub fn rows(&self) -> usize {
        self.frames * self.header.joints.len()
    }
}

/// The meaning of the values of [`Arrays`]. Every written file contains it, as JSON.
///
/// [`Arrays::of`](crate::arrays::Arrays::of) has an example.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Header {
    /// Frames per second; 0 without motion.
    pub frame_rate: f64,
    /// Metres per unit of length of the output. Absent if the file and the options do not state the unit, and nothing
    /// in the output needed a guess of the unit.
    pub metres_per_unit: Option<f64>,
    /// The up axis of the output. Absent if the file and the options do not state the axis, and nothing in the output
    /// needed a guess of the axis.
    pub up: Option<UpAxis>,
    /// The coordinate frame of positions.
    pub space: Space,
    /// The representation of rotations.
    pub rotation: Rotation,
    /// The coordinate frame of rotations.
    pub rotation_space: RotationSpace,
    /// The thresholds for contacts, if contacts were requested.
    pub contacts: Option<Contacts>,
    /// The joints, in the order of the second axis.
    pub joints: Vec<Joint>,
    /// The source file, and all decisions and changes.
    pub provenance: Provenance,
}

impl Header {
    /// The header as JSON on one line.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("a header has string keys only, and numbers that JSON has")
    }
}

impl Arrays {
    /// The first animation of `scene` as arrays. For long motions, several threads compute the values, which do not
    /// depend on the number of threads.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::arrays::{ArrayOptions, Arrays};
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let motion = Arrays::of(&scene, &ArrayOptions::default())?;
    /// assert_eq!((motion.frames, motion.joints().len()), (10, 4));
    /// assert_eq!(motion.joints()[1].name, "Elbow");
    /// // The elbow in frame 0: 2 from the shoulder, which is at (0.1, 0, 0) and rotated by 5 degrees.
    /// let elbow = &motion.positions[3..6];
    /// assert!((f64::from(elbow[0]) - (0.1 + 2.0 * 5f64.to_radians().cos())).abs() < 1e-6);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// - [`Code::InvalidValue`] if an option is not valid, such as a pattern that matches no joint's name, or a part
    ///   that begins after the motion's end
    /// - [`Code::LimitExceeded`] if a new frame rate gives more values than the default limits allow
    /// - [`Code::Unrepresentable`] if a value is not finite
    pub fn of(scene: &Scene, options: &ArrayOptions) -> Result<Arrays> {
        let mut provenance = Provenance::of(scene);
        let frame = frame::Frame::new(scene, options, &mut provenance)?;
        let joints = joints::Selection::new(scene, options, frame.scale)?;
        let timeline = timeline::Timeline::new(scene, options, &mut provenance.steps)?;
        let width = 6 + options.rotation.width();
        check_size(&timeline, joints.nodes.len() * width)?;
        provenance.frames = timeline.frames as u64;
        provenance.frame_time = timeline.frame_time();

        let rows = timeline.frames * joints.nodes.len();
        let mut positions = vec![0.0; rows * 3];
        let mut rotations = vec![0.0; rows * options.rotation.width()];
        let mut feet = contacts::Feet::new(scene, &frame, &joints, options, timeline.frames)?;
        if let Some(animation) = scene.animations.first().filter(|_| rows > 0) {
            let source = rows::Source {
                scene,
                animation,
                options,
                frame: &frame,
                joints: &joints,
                timeline: &timeline,
                feet: &feet.joints,
            };
            source.fill(rows::Rows {
                positions: &mut positions,
                rotations: &mut rotations,
                feet: &mut feet.positions,
            });
        }
        let frame_rate = timeline.frame_rate;
        let velocities = options
            .velocities
            .then(|| velocity::velocities(&positions, 3 * joints.nodes.len(), frame_rate));
        let mut arrays = Arrays {
            frames: timeline.frames,
            positions,
            rotations,
            velocities,
            contacts: feet.contacts(&frame, frame_rate),
            header: Header {
                frame_rate,
                metres_per_unit: frame.metres_per_unit,
                up: frame.up,
                space: options.space,
                rotation: options.rotation,
                rotation_space: options.rotation_space,
                contacts: options.contacts.clone(),
                joints: joints.joints,
                provenance,
            },
        };
        arrays.check()?;
        arrays.leave_gaps(scene, &joints.nodes, &timeline);
        Ok(arrays)
    }

    /// Sets the values of a point to NaN in frames in which the point was not visible.
    fn leave_gaps(&mut self, scene: &Scene, nodes: &[NodeId], timeline: &timeline::Timeline) {
        let gaps = scene
            .animations
            .first()
            .map(|animation| scene.points_with_gaps(animation));
        for (column, node) in nodes.iter().enumerate() {
            let Some(keys) = gaps.as_ref().and_then(|gaps| gaps[node.index()]) else {
                continue;
            };
            for frame in (0..timeline.frames).filter(|frame| !keys.is_seen(timeline.tick(*frame))) {
                let row = frame * nodes.len() + column;
                for values in [Some(&mut self.positions), self.velocities.as_mut()]
                    .into_iter()
                    .flatten()
                {
                    values[3 * row..3 * row + 3].fill(f32::NAN);
                }
            }
        }
    }
}

/// Refuses more values than the limits for files allow. The caller's frame rate determines how much memory the values
/// need.
fn check_size(timeline: &timeline::Timeline, values_per_frame: usize) -> Result<()> {
    let values = |frames: usize| (frames as u64).saturating_mul(values_per_frame as u64);
    let limit = Limits::default().expanded_values(values(timeline.frames_in_file));
    let values = values(timeline.frames);
    if values > limit {
        let diagnostic = Diagnostic::new(
            Code::LimitExceeded,
            "the arrays would have more values than the limits allow",
        )
        .expected_found(format!("at most {limit} values"), format!("{values} values"))
        .help("select a part of the motion, or fewer frames per second");
        return Err(diagnostic.into());
    }
    Ok(())
}

/// The error for an option that is not valid.
fn unknown_option(message: impl Into<String>, expected: &str, found: impl Into<String>) -> Error {
    Diagnostic::new(Code::InvalidValue, message)
        .expected_found(expected, found)
        .into()
}
