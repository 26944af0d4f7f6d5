//! The unit and the up axis of a scene.

use mocap_scene::error::{Code, Result};
use mocap_scene::limits::positive;
use mocap_scene::scene::{Assumption, Metadata, Topic, UpAxis};

use crate::Survey;

/// A unit of length and an up axis, where they are known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[doc(hidden)]
pub struct Space {
    /// Metres in one unit of length.
    #[doc(hidden)]
    pub metres_per_unit: Option<f64>,
    /// The axis that points up.
    #[doc(hidden)]
    pub up: Option<UpAxis>,
}

/// What has to be known.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Needs {
    #[doc(hidden)]
    pub unit: bool,
    #[doc(hidden)]
    pub up: bool,
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

    /// Metres, +Y up.
    pub(crate) const METRES: Self = Self {
        metres_per_unit: Some(1.0),
        up: Some(UpAxis::Y),
    };

    /// The values of `self`, or else of `other`.
    pub(crate) fn or(self, other: Self) -> Self {
        Self {
            metres_per_unit: self.metres_per_unit.or(other.metres_per_unit),
            up: self.up.or(other.up),
        }
    }

    /// The values of `self`, or else those that the file states.
    #[doc(hidden)]
    pub fn or_stated(self, metadata: &Metadata) -> Self {
        self.or(Self {
            metres_per_unit: metadata.metres_per_unit,
            up: metadata.up,
        })
    }

    /// The values of `self`, or else those that the file states, or else those guesses that are needed.
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
