//! Checks that the values of a file are in the stated unit and axes, which other readers rely on.

use glam::DVec3;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::{Scene, UpAxis};

use super::change::Change;
use super::{Finding, FindingKind};

/// The largest relative difference of a stated unit from the expected unit.
const SAME_UNIT: f64 = 1e-6;

/// The largest relative difference of a stated unit from a unit that was inferred from lengths.
const NEAR_UNIT: f64 = 0.01;

/// A unit of length and an up axis, as far as known.
#[derive(Clone, Copy, Default)]
pub(super) struct Space {
    pub(super) metres_per_unit: Option<f64>,
    pub(super) up: Option<UpAxis>,
}

impl Space {
    /// The unit and the up axis that a file should state after these steps.
    pub(super) fn recorded(source: &Scene, steps: &[AppliedStep]) -> Self {
        let mut space = Self::of(source);
        for step in steps {
            if let AppliedStep::ConvertUnits {
                out_metres_per_unit,
                out_up,
                ..
            } = step
            {
                space = Self {
                    metres_per_unit: Some(*out_metres_per_unit),
                    up: Some(*out_up),
                };
            }
        }
        space
    }

    /// The unit and the up axis that a file should state, if its change was inferred from its values.
    pub(super) fn guessed(source: &Scene, change: &Change) -> Self {
        let space = Self::of(source);
        let is_up = |up: UpAxis, other: &UpAxis| change.turn(direction(up)).dot(direction(*other)) > 0.5;
        Self {
            metres_per_unit: space.metres_per_unit.map(|metres| metres / change.metres_per_unit),
            up: (space.up).and_then(|up| UpAxis::ALL.into_iter().find(|other| is_up(up, other))),
        }
    }

    fn of(source: &Scene) -> Self {
        Self {
            metres_per_unit: source.metadata.metres_per_unit,
            up: source.metadata.up,
        }
    }

    /// Finds statements of a file that differ from `self`. A value that `self` or `stated` lacks is not compared.
    pub(super) fn find(self, stated: Self, is_recorded: bool, findings: &mut Vec<Finding>) {
        let tolerance = if is_recorded { SAME_UNIT } else { NEAR_UNIT };
        if let (Some(expected), Some(found)) = (self.metres_per_unit, stated.metres_per_unit)
            && ((found / expected - 1.0).abs() > tolerance || (found / expected).is_nan())
        {
            let message = format!("the file states a unit of {found} m, but its lengths are in a unit of {expected} m");
            findings.push(Finding::new(FindingKind::Unit, message));
        }
        if let (Some(expected), Some(found)) = (self.up, stated.up)
            && expected != found
        {
            let (found, expected) = (found.as_str(), expected.as_str());
            let message = format!("the file states the up axis {found}, but {expected} points up in its motion");
            findings.push(Finding::new(FindingKind::UpAxis, message));
        }
    }
}

fn direction(up: UpAxis) -> DVec3 {
    match up {
        UpAxis::Y => DVec3::Y,
        UpAxis::Z => DVec3::Z,
        UpAxis::NegY => DVec3::NEG_Y,
        UpAxis::NegZ => DVec3::NEG_Z,
    }
}
