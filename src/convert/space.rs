//! The unit and the up axis of a scene.

use crate::error::{Code, Result};
use crate::limits::positive;
use crate::scene::{Assumption, Metadata, Topic, UpAxis};
use crate::skeleton::Survey;

/// A unit of length and an up axis, where they are known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Space {
    /// Metres in one unit of length.
    pub(crate) metres_per_unit: Option<f64>,
    /// The axis that points up.
    pub(crate) up: Option<UpAxis>,
}

impl Space {
    /// Refuses a unit that is not finite and above 0.
    pub(crate) fn check(self) -> Result<()> {
        if let Some(metres) = self.metres_per_unit {
            positive(Code::UnknownOption, "metres per unit", metres)?;
        }
        Ok(())
    }

    /// The space of a scene: the values of `self`, or else those of the file, or else the guesses of `survey`.
    pub(crate) fn or_found(self, metadata: &Metadata, survey: Option<&Survey>) -> Self {
        Self {
            metres_per_unit: self
                .metres_per_unit
                .or(metadata.metres_per_unit)
                .or(survey.map(|survey| survey.metres_per_unit)),
            up: self.up.or(survey.map(|survey| survey.up.value)),
        }
    }

    /// The guess about `topic`, unless `self` has a value.
    pub(crate) fn guess(self, topic: Topic, survey: &Survey) -> Option<Assumption> {
        let is_named = match topic {
            Topic::Unit => self.metres_per_unit.is_some(),
            Topic::Up => self.up.is_some(),
            _ => false,
        };
        (!is_named).then(|| survey.assumption(topic)).flatten()
    }
}
