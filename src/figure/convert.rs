//! Converts a scene from the unit, axes and frames of its file to the unit, axes and frames of an output.
//!
//! Motion files rarely state their unit or their up axis, and glTF is in metres with +Y up. A [`Conversion`] has the
//! caller's choices, [`Survey`](crate::Survey) guesses the rest, and [`Conversion::apply`] returns the
//! guesses:
//!
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//! use mocap::{Conversion, gltf};
//!
//! let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
//! for assumption in Conversion::new().apply(&mut scene)? {
//!     eprintln!("{assumption}"); // unit: cmu, because the bones from ankle to head measure 20.6820 units, ...
//! }
//! let glb = gltf::GltfOptions::default().write_glb(&scene)?; // in metres, with +Y up
//! # let _ = glb;
//! # Ok::<(), mocap::Error>(())
//! ```

mod apply;
mod bone_axis;
mod moment;
mod rest;
mod rest_text;
mod space;

use mocap_scene::error::{Code, Result};
use mocap_scene::limits::{self, Limits};
use mocap_scene::scene::UpAxis;
use serde::{Deserialize, Serialize};

use crate::HumanoidMap;

pub use self::bone_axis::AlongBone;
#[doc(hidden)]
pub use self::moment::part_ticks;
pub use self::moment::{Moment, TimeRange};
#[doc(hidden)]
pub use self::space::{Needs, Space};

/// What a conversion does with the first frame. In some files, such as a conversion of the CMU database, the first
/// frame is a rest pose.
///
/// [`Conversion::first_frame`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[doc(hidden)]
#[non_exhaustive]
pub enum FirstFrame {
    /// Drop the first frame if it is a rest pose and the motion jumps after it.
    #[serde(rename = "auto")]
    #[cfg_attr(feature = "clap", value(name = "auto"))]
    DropRestPose,
    /// Drop the first frame.
    #[serde(rename = "yes")]
    #[cfg_attr(feature = "clap", value(name = "yes"))]
    Drop,
    /// Keep the first frame.
    #[default]
    #[serde(rename = "no")]
    #[cfg_attr(feature = "clap", value(name = "no"))]
    Keep,
}

/// Which pose becomes the rest pose of the output: the pose of the nodes without motion, which is also the bind pose of
/// meshes.
///
/// [`Conversion::rest`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[doc(hidden)]
#[non_exhaustive]
pub enum RestPoseSource {
    /// The rest pose of the file. In BVH, it consists of the OFFSETs, and all rotations are zero.
    #[default]
    InFile,
    /// The pose of the frame with this number in the file. The first frame has the number 0.
    Frame(u64),
    /// The T-pose of the humanoid. Its arms are horizontal, and it faces along an axis. All joint rotations are zero,
    /// so the axes of all joints are the world axes.
    TPose,
    /// The T-pose with its arms lowered by 45 degrees. All joint rotations are zero.
    APose,
}

/// What a conversion does with root motion.
///
/// [`Conversion::root`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum RootMotion {
    /// Keep root motion in the root joint.
    #[default]
    Keep,
    /// Remove root motion.
    InPlace,
    /// Move root motion to a new joint above the root.
    Extract,
}

/// Converts an imported scene to the unit, the axes and the frames of an output.
///
/// By default, it converts lengths to metres and the axes to +Y up, and changes nothing else. It applies functions of
/// [`process`](mocap_scene::process) in this order: rest pose of a frame, trim, frame rate, T-pose or A-pose, unit and
/// axes, root motion, axes of joints. Each change is recorded in
/// [`Metadata::steps`](mocap_scene::scene::Metadata::steps), so that `verify` can undo it.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::convert::{FirstFrame, Moment, RootMotion};
/// use mocap::{Conversion, scene::Topic};
///
/// let mut scene = mocap::import("fixtures/real/cmu_01_01.bvh")?;
/// let assumptions = Conversion::new()
///     .first_frame(FirstFrame::DropRestPose)
///     .trim(None, Moment::Seconds(2.0))
///     .frame_rate(30.0)
///     .root(RootMotion::InPlace)
///     .apply(&mut scene)?;
/// let topics: Vec<Topic> = assumptions.iter().map(|assumption| assumption.topic).collect();
/// assert_eq!(topics, [Topic::FirstFrame, Topic::FrameRate, Topic::Unit, Topic::Up]);
/// assert_eq!(scene.animations[0].frame_count(), 60);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conversion {
    source: Space,
    keep_units: bool,
    first: Option<Moment>,
    last: Option<Moment>,
    output: Space,
    bones: HumanoidMap,
    frame_rate: Option<f64>,
    first_frame: FirstFrame,
    rest: RestPoseSource,
    t_pose_first: bool,
    bone_axis: Option<AlongBone>,
    root: RootMotion,
    limits: Limits,
}

impl Conversion {
    /// A conversion to metres with +Y up.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets how many metres one unit of length of the file is.
    ///
    /// Default: the unit that the file states, or else the guess of [`Survey`](crate::Survey), in which the figure has
    /// the size of a person. [`apply`](Self::apply) returns the guess as an
    /// [`Assumption`](mocap_scene::scene::Assumption).
    ///
    /// Every length is multiplied by this value. The guess is right for most people, but wrong for a giant or a mouse.
    /// Set the unit if you know it.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    /// use mocap::figure::Unit;
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// assert_eq!(scene.nodes[1].transform.w_axis.x, 2.0); // the elbow, from the shoulder
    /// let assumptions = Conversion::new().metres_per_unit(Unit::Decimetre.metres()).apply(&mut scene)?;
    /// assert_eq!(scene.nodes[1].transform.w_axis.x, 0.2);
    /// assert!(assumptions.iter().all(|assumption| assumption.topic != mocap::scene::Topic::Unit));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn metres_per_unit(mut self, metres: f64) -> Self {
        self.source.metres_per_unit = Some(metres);
        self
    }

    /// The up axis of the file.
    ///
    /// Default: the axis that the file states, or else the guess of [`Survey`](crate::Survey): the axis from the feet
    /// to the head. [`apply`](Self::apply) returns the guess as an [`Assumption`](mocap_scene::scene::Assumption).
    ///
    /// With [`UpAxis::Z`] the scene is rotated by -90 degrees about X, so that +Y is up: (x, y, z) becomes (x, z, -y).
    /// Only the root is rotated; other joints keep their rotations.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    /// use mocap::glam::Vec3;
    /// use mocap::scene::UpAxis;
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let first = |scene: &mocap::Scene| scene.animations[0].channels[0].position_keys.values[9];
    /// assert_eq!(first(&scene), Vec3::new(1.0, 0.18, 0.0));
    /// Conversion::new().metres_per_unit(1.0).up(UpAxis::Z).apply(&mut scene)?;
    /// assert_eq!(first(&scene), Vec3::new(1.0, 0.0, -0.18));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn up(mut self, up: UpAxis) -> Self {
        self.source.up = Some(up);
        self
    }

    /// Sets how many metres one unit of length of the output is.
    ///
    /// Default: 1, or the file's own unit with [`keep_units`](Self::keep_units). glTF files are in metres, so keep the
    /// default for them.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    /// use mocap::figure::Unit;
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let centimetres = Conversion::new().metres_per_unit(1.0).out_metres_per_unit(Unit::Centimetre.metres());
    /// centimetres.apply(&mut scene)?;
    /// assert_eq!(scene.nodes[1].transform.w_axis.x, 200.0);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn out_metres_per_unit(mut self, metres: f64) -> Self {
        self.output.metres_per_unit = Some(metres);
        self
    }

    /// The up axis of the output.
    ///
    /// Default: +Y, or the file's own axis with [`keep_units`](Self::keep_units). In glTF files, +Y is up, so keep the
    /// default for them.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    /// use mocap::glam::Vec3;
    /// use mocap::scene::UpAxis;
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// Conversion::new().metres_per_unit(1.0).up(UpAxis::Y).out_up(UpAxis::Z).apply(&mut scene)?;
    /// assert_eq!(scene.animations[0].channels[0].position_keys.values[9], Vec3::new(1.0, 0.0, 0.18));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn out_up(mut self, up: UpAxis) -> Self {
        self.output.up = Some(up);
        self
    }

    /// Whether to keep the file's own unit and axes unless [`out_metres_per_unit`](Self::out_metres_per_unit) and
    /// [`out_up`](Self::out_up) are set.
    ///
    /// Default: `false`, the output is in metres with +Y up.
    ///
    /// Use this for an output in BVH, which states no unit and no up axis. Without other options, the values do not
    /// change. The conversion guesses a unit or an axis only if it needs it. `Exporter` does not guess, either: it
    /// writes such a scene with its values and a warning.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// let before = scene.clone();
    /// Conversion::new().keep_units(true).apply(&mut scene)?;
    /// assert_eq!((scene.nodes, scene.animations), (before.nodes, before.animations));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn keep_units(mut self, keep: bool) -> Self {
        self.keep_units = keep;
        self
    }

    /// The joint of each bone, for bones that [`Humanoid::of`](crate::Humanoid::of) finds wrongly or not at all; `None`
    /// for a bone that the skeleton lacks.
    ///
    /// Default: empty.
    ///
    /// The unit and the up axis are guessed from the bones.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    /// use mocap::figure::{HumanoidBone, HumanoidMap};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// let wrong = HumanoidMap::from([(HumanoidBone::Head, Some("Hat".to_owned()))]);
    /// let error = Conversion::new().bones(wrong).apply(&mut scene).unwrap_err();
    /// assert_eq!(error.diagnostic().message, "no joint is called \"Hat\", which the map names as head");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn bones(mut self, bones: HumanoidMap) -> Self {
        self.bones = bones;
        self
    }

    /// The first and the last time to keep; `None` for the start and the end of the motion.
    ///
    /// Default: the whole motion.
    ///
    /// Both ends are included. It is an error if the first time is after the last frame, or the last time before the
    /// first. If the last time is after the last frame, the motion is kept up to its last frame.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    /// use mocap::convert::Moment;
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// Conversion::new().trim(Moment::Frame(2), Moment::Seconds(0.5)).apply(&mut scene)?;
    /// assert_eq!(scene.animations[0].frame_count(), 4); // 2, 3, 4, 5 of ten frames a second
    ///
    /// let late = Conversion::new().trim(Moment::Frame(9), None).apply(&mut scene).unwrap_err();
    /// assert!(late.to_string().contains("at most frame 3"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[doc(hidden)]
    #[must_use]
    pub fn trim(mut self, first: impl Into<Option<Moment>>, last: impl Into<Option<Moment>>) -> Self {
        self.first = first.into();
        self.last = last.into();
        self
    }

    /// Frames per second of the output.
    ///
    /// Default: the file's own frames.
    ///
    /// Between two frames, positions are interpolated linearly and rotations by slerp, but not across a
    /// [cut](mocap_scene::Scene::cuts). The frame time in a file may be rounded. If frames of both rates coincide only
    /// without this rounding, [`apply`](Self::apply) uses the exact rate, and returns an
    /// [`Assumption`](mocap_scene::scene::Assumption).
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::{Conversion, scene::Topic};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?; // 75 frames, Frame Time: .0083333
    /// let assumptions = Conversion::new().frame_rate(30.0).apply(&mut scene)?;
    /// let rate = assumptions.iter().find(|assumption| assumption.topic == Topic::FrameRate).unwrap();
    /// assert_eq!(rate.choice, "120");
    /// assert_eq!(scene.animations[0].frame_count(), 19); // every fourth frame
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[doc(hidden)]
    #[must_use]
    pub fn frame_rate(mut self, frames_per_second: f64) -> Self {
        self.frame_rate = Some(frames_per_second);
        self
    }

    /// What to do with the first frame.
    ///
    /// Default: [`FirstFrame::Keep`].
    ///
    /// If the first frame is a rest pose, the motion begins with a jump. Frame numbers in other options are those
    /// before the first frame is dropped.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    /// use mocap::convert::FirstFrame;
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// assert_eq!(scene.animations[0].frame_count(), 75);
    /// Conversion::new().first_frame(FirstFrame::DropRestPose).apply(&mut scene)?;
    /// assert_eq!(scene.animations[0].frame_count(), 74);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[doc(hidden)]
    #[must_use]
    pub fn first_frame(mut self, first_frame: FirstFrame) -> Self {
        self.first_frame = first_frame;
        self
    }

    /// The rest pose of the output.
    ///
    /// Default: [`RestPoseSource::InFile`].
    ///
    /// The motion does not change. For targets that need a T-pose, choose a frame in which the figure stands in a
    /// T-pose.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::convert::RestPoseSource;
    /// use mocap::{Conversion, Pose, scene::NodeId};
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let ninth = Pose::at_tick(&scene, 0, 9.0).unwrap();
    /// Conversion::new().keep_units(true).rest(RestPoseSource::Frame(9)).apply(&mut scene)?;
    /// assert_eq!(Pose::rest(&scene).position(NodeId(3)), ninth.position(NodeId(3)));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[doc(hidden)]
    #[must_use]
    pub fn rest(mut self, rest: RestPoseSource) -> Self {
        self.rest = rest;
        self
    }

    /// What a conversion does with root motion.
    ///
    /// Default: [`RootMotion::Keep`].
    ///
    /// Game engines that move characters need in-place clips, or the root motion in a separate joint.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    /// use mocap::convert::RootMotion;
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// Conversion::new().root(RootMotion::Extract).apply(&mut scene)?;
    /// assert_eq!((&*scene.nodes[0].name, &*scene.nodes[1].name), ("Root", "Hips"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[doc(hidden)]
    #[must_use]
    pub fn root(mut self, root: RootMotion) -> Self {
        self.root = root;
        self
    }

    /// Limits for resampling.
    ///
    /// Default: [`Limits::default`]. If the result would have more than [`Limits::max_values`] values,
    /// [`apply`](Self::apply) fails with [`Code::LimitExceeded`] before it allocates memory.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::{Code, Conversion};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// let error = Conversion::new().frame_rate(1e6).apply(&mut scene).unwrap_err();
    /// assert_eq!(error.code(), Code::LimitExceeded);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// Checks the options that do not depend on a scene: the units, the frame rate and the times.
    ///
    /// ```
    /// use mocap::Conversion;
    ///
    /// let error = Conversion::new().frame_rate(0.0).check().unwrap_err();
    /// assert_eq!(error.diagnostic().message, "frame rate must be finite and above 0, got 0");
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`].
    pub fn check(&self) -> Result<()> {
        self.source.check()?;
        self.output.check()?;
        if let Some(rate) = self.frame_rate {
            limits::frame_rate(Code::InvalidValue, rate)?;
        }
        for moment in [self.first, self.last].into_iter().flatten() {
            moment.check()?;
        }
        Ok(())
    }
}
