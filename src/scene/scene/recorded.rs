//! Data that a laboratory records in addition to positions: events, analog channels and force plates.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Data that a laboratory recorded in addition to the motion. Steps and conversions do not change it. Times are in
/// seconds from the first frame of the file, lengths in metres. The axes are the axes of the scene as it was read, with
/// +Y up.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// let scene = mocap::import("fixtures/real/py_c3d_motion.c3d")?;
/// let recorded = scene.metadata.recorded.as_ref().expect("the file has analog channels");
/// let channel = &recorded.channels[0];
/// assert_eq!((channel.name.as_str(), channel.unit.as_str(), recorded.analog_rate), ("FX1", "nt", 200.0));
/// assert_eq!(channel.values.len(), 450 * recorded.samples_per_frame);
/// assert_eq!((recorded.plates[0].plate_type, recorded.events[1].label.as_str()), (2, "RHS"));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Recording {
    /// Events, sorted by time.
    pub events: Vec<Event>,
    /// Samples per second of each channel; 0 without channels.
    pub analog_rate: f64,
    /// Samples of each channel per frame of the motion; 0 without channels.
    pub samples_per_frame: usize,
    /// Analog channels.
    pub channels: Vec<AnalogChannel>,
    /// Force plates.
    pub plates: Vec<ForcePlate>,
    /// Values that a model computed from the markers, such as joint angles: x, y and z of each frame of the file, one
    /// after the other. They have the axes and the unit of the file, and NaN for missing values.
    #[serde(skip)]
    pub outputs: Vec<AnalogChannel>,
    /// Measures of the person that a laboratory's model uses, such as `LKneeWidth`. Lengths have the unit of the file,
    /// angles are in radians.
    #[serde(skip)]
    pub measures: Vec<(String, f64)>,
}

/// A time with a name, from a person or a program.
///
/// [`Recording`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Event {
    /// The time in seconds from the first frame.
    pub time: f64,
    /// The name of the event, such as `Foot Strike`.
    pub label: String,
    /// The side of the event, such as `Left`. May be empty.
    pub context: String,
    /// The person of the event. May be empty.
    pub subject: String,
}

/// A channel of analog samples, scaled as the file states.
///
/// [`Recording`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AnalogChannel {
    /// The label of the channel.
    pub name: String,
    /// The unit of the values, as the file states it. May be empty.
    pub unit: String,
    /// The samples.
    #[serde(skip)]
    pub values: Vec<f32>,
}

/// A force plate as C3D describes it: its type, its position and its channels.
///
/// [`Recording`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ForcePlate {
    /// The type in the C3D user guide:
    ///
    /// - 1: force and centre of pressure
    /// - 2: force and moment
    /// - 3: eight Kistler sensors
    /// - 4: force and moment, as in type 2, with a calibration matrix
    /// - 5: eight sensors, with a matrix that gives force and moment
    /// - 6: three forces at each of four corners, with a matrix
    /// - 7: eight Kistler sensors, as in type 3, with a matrix
    ///
    /// Other types are kept, but forces are not computed from them.
    pub plate_type: u32,
    /// The corners in metres, in the quadrants +x +y, -x +y, -x -y and +x -y of the plate's own axes.
    #[cfg_attr(feature = "schema", schemars(with = "[[f32; 3]; 4]"))]
    pub corners: [Vec3; 4],
    /// The vector in metres from the sensor origin to the centre of the surface, in the plate's axes. For types 3, 6
    /// and 7 it has half the distances of the sensors along x and y, and the height of the sensors.
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub origin: DVec3,
    /// The indices of its channels in [`Recording::channels`].
    pub channels: Vec<usize>,
    /// The factor of each channel that converts its values to newtons, metres and newton metres.
    pub scales: Vec<f64>,
    /// The calibration matrix of types 4 to 7, row by row: 6 x 6, 6 x 8, 12 x 12 or 8 x 8 numbers. For types 4 and 5
    /// the product is force and moment, for types 6 and 7 the sensor values.
    pub calibration: Vec<f64>,
    /// The first and the last frame, from 0, in which nobody is on the plate. The mean of each channel over these
    /// frames is subtracted from the channel.
    pub zero: Option<[usize; 2]>,
}

impl ForcePlate {
    /// Rows and columns of the calibration matrix, if the type has one.
    #[doc(hidden)]
    pub const fn calibration_size(plate_type: u32) -> Option<[usize; 2]> {
        match plate_type {
            4 => Some([6, 6]),
            5 => Some([6, 8]),
            6 => Some([12, 12]),
            7 => Some([8, 8]),
            _ => None,
        }
    }
}
