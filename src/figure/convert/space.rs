//! Defines the unit of length and the up axis of a scene.

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::positive;
use mocap_scene::scene::{Assumption, Metadata, Scene, Topic, UpAxis};

use crate::Survey;

/// A unit of length and an up axis, if known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[doc(hidden)]
pub struct Space {
    /// Metres in one unit of length.
    #[doc(hidden)]
    pub metres_per_unit: Option<f64>,
    /// The up axis.
    #[doc(hidden)]
    pub up: Option<UpAxis>,
}

/// Which values a conversion needs.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Needs {
    #[doc(hidden)]
    pub unit: bool,
    #[doc(hidden)]
    pub up: bool,
}

/// The largest relative difference of equal units: files store units in single precision.
const SAME_UNIT: f64 = 1e-4;

/// The up axes, each a quarter turn about +X from the previous one.
const QUARTERS: [UpAxis; 4] = [UpAxis::Y, UpAxis::Z, UpAxis::NegY, UpAxis::NegZ];

fn quarters(up: UpAxis) -> usize {
    QUARTERS.iter().position(|axis| *axis == up).unwrap_or(0)
}

fn is_same_unit(known: f64, stated: f64) -> bool {
    (stated / known - 1.0).abs() < SAME_UNIT
}

fn otherwise(what: &str, [expected, found]: [String; 2], help: &str) -> Diagnostic {
    let message = format!("the file states another {what} than the option; mocap used the option");
    Diagnostic::new(Code::StatedOtherwise, message)
        .expected_found(expected, found)
        .help(help)
}

impl Space {
    /// Refuses a unit that is not finite and above 0.
    #[doc(hidden)]
    pub fn check(self) -> Result<()> {
        if let Some(metres) = self.metres_per_unit {
            positive(Code::InvalidValue, "metres per unit", metres)?;
        }
        Ok(())
    }

    /// Lengths in metres, and +Y up.
    pub(crate) const METRES: Self = Self {
        metres_per_unit: Some(1.0),
        up: Some(UpAxis::Y),
    };

    /// The values of `self`. A value that `self` lacks comes from `other`.
    pub(crate) fn or(self, other: Self) -> Self {
        Self {
            metres_per_unit: self.metres_per_unit.or(other.metres_per_unit),
            up: self.up.or(other.up),
        }
    }

    /// Converts `self`, the unit and the up axis of the values in a file, to the unit and the up axis of the values in
    /// the scene. The reader may have converted the values.
    fn of_scene(self, metadata: &Metadata) -> Self {
        let file = metadata.file_space;
        let unit = self.metres_per_unit.map(|stated| {
            let now = metadata.metres_per_unit.unwrap_or(1.0);
            match file.metres_per_unit.or(metadata.metres_per_unit) {
                Some(known) if is_same_unit(known, stated) => now,
                _ => file.metres_per_unit.map_or(stated, |file| now * (stated / file)),
            }
        });
        let up = self.up.map(|stated| match (file.up, metadata.up) {
            (Some(file), Some(now)) => {
                let turns = QUARTERS.len() + quarters(now) + quarters(stated) - quarters(file);
                QUARTERS[turns % QUARTERS.len()]
            }
            _ => stated,
        });
        Self {
            metres_per_unit: unit,
            up,
        }
    }

    /// A warning for each value of `self` that contradicts the file.
    #[doc(hidden)]
    pub fn contradictions(self, metadata: &Metadata) -> Vec<Diagnostic> {
        let file = metadata.file_space;
        let mut warnings = Vec::new();
        if let (Some(stated), Some(known)) = (self.metres_per_unit, file.metres_per_unit.or(metadata.metres_per_unit))
            && !is_same_unit(known, stated)
        {
            let help = "leave {unit} out if the file states the right unit; {out-unit} changes the unit of the output";
            let [expected, found] = [known, stated].map(|metres| format!("{metres} m"));
            warnings.push(otherwise("unit", [expected, found], help));
        }
        if let (Some(stated), Some(known)) = (self.up, file.up.or(metadata.up))
            && known != stated
            && !file.up_is_guess
        {
            let help = "leave {up} out if the file states the right axis; {out-up} changes the up axis of the output";
            let [expected, found] = [known, stated].map(|up| up.as_str().to_owned());
            warnings.push(otherwise("up axis", [expected, found], help));
        }
        warnings
    }

    /// Sets `self`, the unit and the up axis of a file as the caller states them, in the scene of the file. A value
    /// that contradicts the file gives a warning.
    #[doc(hidden)]
    pub fn state(self, scene: &mut Scene) {
        scene.warnings.extend(self.contradictions(&scene.metadata));
        let metadata = &mut scene.metadata;
        let (of_scene, file) = (self.of_scene(metadata), metadata.file_space);
        if let Some(stated) = self.metres_per_unit {
            metadata.metres_per_unit = of_scene.metres_per_unit;
            metadata.file_space.metres_per_unit = file.metres_per_unit.and(Some(stated));
        }
        if let Some(stated) = self.up {
            metadata.up = of_scene.up;
            metadata.file_space.up = file.up.and(Some(stated));
        }
    }

    /// The values of `self`. A value that `self` lacks is the value that the file states.
    #[doc(hidden)]
    pub fn or_stated(self, metadata: &Metadata) -> Self {
        self.of_scene(metadata).or(Self {
            metres_per_unit: metadata.metres_per_unit,
            up: metadata.up,
        })
    }

    /// The values of `self`. A value that `self` lacks is the value that the file states, or otherwise a guess if
    /// `needs` asks for it.
    #[doc(hidden)]
    pub fn or_found(self, metadata: &Metadata, survey: &Survey, needs: Needs) -> Self {
        self.or_stated(metadata).or(Self {
            metres_per_unit: needs.unit.then_some(survey.metres_per_unit),
            up: needs.up.then_some(survey.up.value),
        })
    }

    /// The guess about `topic`, unless `self` has a value.
    #[doc(hidden)]
    pub fn guess(self, topic: Topic, survey: &Survey) -> Option<Assumption> {
        let is_named = match topic {
            Topic::Unit => self.metres_per_unit.is_some(),
            Topic::Up => self.up.is_some(),
            _ => false,
        };
        (!is_named).then(|| survey.assumption(topic)).flatten()
    }
}
