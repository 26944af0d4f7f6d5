//! Columns over time, such as analog channels and ground reaction forces.

use std::collections::{HashMap, HashSet};

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::{ANALOG_MARK, ANGLES_MARK};
use mocap_scene::scene::{Recording, Scene};

use super::JointAngles;
use super::angles::POSITION;

/// Columns with units, sample by sample. [`JointAngles`] convert to this type too.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::biomechanics::TimeSeries;
///
/// let analog = TimeSeries::analog(&mocap::import("fixtures/real/py_c3d_motion.c3d")?)?;
/// assert_eq!((analog.frame_rate, analog.frames()), (200.0, 1800));
/// assert!(analog.to_csv().starts_with("time,FX1,"));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TimeSeries {
    /// The first line of an OpenSim file.
    pub(super) title: &'static str,
    /// Samples per second.
    pub frame_rate: f64,
    /// The unique names of the columns.
    pub columns: Vec<String>,
    /// The unit of each column, as the file states it. A unit may be empty.
    pub units: Vec<String>,
    /// The values, sample by sample, one per column.
    pub values: Vec<f64>,
    /// Sentences about decisions and about skipped data.
    pub notes: Vec<String>,
}

impl TimeSeries {
    /// The analog channels of the scene's source file.
    ///
    /// # Errors
    /// [`Code::NoMotion`] if the file has no analog channels.
    pub fn analog(scene: &Scene) -> Result<Self> {
        let recorded = recorded(scene, |recorded| !recorded.channels.is_empty(), "analog channels")?;
        let channels = &recorded.channels;
        let samples = channels.iter().map(|channel| channel.values.len()).min().unwrap_or(0);
        let of_sample = |sample: usize| channels.iter().map(move |channel| f64::from(channel.values[sample]));
        Ok(Self {
            title: ANALOG_MARK,
            frame_rate: recorded.analog_rate,
            columns: unique(channels.iter().map(|channel| channel.name.as_str())),
            units: channels.iter().map(|channel| channel.unit.clone()).collect(),
            values: (0..samples)
                .flat_map(of_sample)
                .map(|value| if value.is_finite() { value } else { 0.0 })
                .collect(),
            notes: Vec::new(),
        })
    }

    /// The number of samples in a column.
    pub fn frames(&self) -> usize {
        self.values.len() / self.columns.len().max(1)
    }

    /// The values of a column.
    pub fn column(&self, name: &str) -> Option<impl Iterator<Item = f64>> {
        let column = self.columns.iter().position(|own| own == name)?;
        Some(self.values.chunks(self.columns.len()).map(move |row| row[column]))
    }
}

impl From<JointAngles> for TimeSeries {
    fn from(angles: JointAngles) -> Self {
        let is_length = |name: &str| POSITION.contains(&name);
        let unit = |name: &String| if is_length(name) { "m" } else { "deg" }.to_owned();
        Self {
            title: ANGLES_MARK,
            frame_rate: angles.frame_rate,
            units: angles.columns.iter().map(unit).collect(),
            columns: angles.columns,
            values: angles.values,
            notes: Vec::new(),
        }
    }
}

/// The file's recorded data besides the motion, if `has` finds the requested kind. `what` names this kind in the
/// plural, for the error.
pub(super) fn recorded<'a>(scene: &'a Scene, has: impl Fn(&Recording) -> bool, what: &str) -> Result<&'a Recording> {
    let recorded = scene.metadata.recorded.as_deref().filter(|recorded| has(recorded));
    recorded.ok_or_else(|| {
        let help = "C3D files of laboratories have them; mocap info lists the contents of a file";
        Diagnostic::new(Code::NoMotion, format!("the file has no {what}"))
            .help(help)
            .into()
    })
}

/// Column names without table separators, made unique: the second occurrence of a name ends in `_2`.
pub fn unique<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut found = Vec::new();
    let mut taken = HashSet::from(["time".to_owned()]);
    let mut counts: HashMap<String, usize> = HashMap::new();
    for name in names {
        let plain: String = name
            .chars()
            .map(|letter| {
                if letter.is_control() || ",\";".contains(letter) {
                    '_'
                } else {
                    letter
                }
            })
            .collect();
        let count = counts.entry(plain.clone()).or_insert(1);
        let mut own = plain.clone();
        while !taken.insert(own.clone()) {
            *count += 1;
            own = format!("{plain}_{count}");
        }
        found.push(own);
    }
    found
}
