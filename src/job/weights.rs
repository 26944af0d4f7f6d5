//! The weights of solvers in a job.

use mocap_edit::{CleanWeights, EditStep, FootLockWeights};
use mocap_retarget::robot;
use mocap_scene::error::Result;
#[cfg(feature = "clap")]
use mocap_scene::error::{Diagnostic, Error};
use mocap_solve::MarkerWeights;
use serde::{Deserialize, Serialize};

use super::is_default;
#[cfg(feature = "clap")]
use super::{Wording, parsed};

/// The weights of solvers that differ from their defaults. `docs/weights.md` lists all weights.
///
/// ```
/// use mocap::job::JobWeights;
///
/// let weights: JobWeights = serde_json::from_str(r#"{"robot": {"hand": 1.0}}"#).unwrap();
/// assert_eq!((weights.robot.hand, weights.robot.head), (1.0, 0.3));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct JobWeights {
    /// Weights of retargeting to a robot.
    #[serde(skip_serializing_if = "is_default")]
    #[cfg_attr(feature = "schema", schemars(with = "schema::RobotWeights"))]
    pub robot: robot::Weights,
    /// Weights of foot lock: of the step foot-lock, and of retargeting to a character, a skeleton or a robot.
    #[serde(skip_serializing_if = "is_default")]
    #[cfg_attr(feature = "schema", schemars(with = "schema::FootLockWeights"))]
    pub foot_lock: FootLockWeights,
    /// Weights of the step clean.
    #[serde(skip_serializing_if = "is_default")]
    #[cfg_attr(feature = "schema", schemars(with = "schema::CleanWeights"))]
    pub clean: CleanWeights,
    /// Weights of solving a skeleton from markers.
    #[serde(skip_serializing_if = "is_default")]
    #[cfg_attr(feature = "schema", schemars(with = "schema::MarkerWeights"))]
    pub markers: MarkerWeights,
}

impl JobWeights {
    /// Parses the file of an option. The file is read at once, so that a bad file is refused before the work begins.
    #[cfg(feature = "clap")]
    pub fn parse_file(path: &str) -> Result<Self, String> {
        let in_words = |error: &Error| {
            let Diagnostic { message, help, .. } = error.diagnostic();
            let help = help.as_ref().map(|help| format!("; {help}"));
            format!("{message}{}", help.unwrap_or_default())
        };
        let text = mocap_io::import::read_text(path.as_ref()).map_err(|error| in_words(&error))?;
        let wording = Wording {
            text: path,
            owner: "there is",
            help: "docs/weights.md lists the weights",
        };
        let weights: Self = parsed(&text, &wording).map_err(|error| in_words(&error))?;
        weights
            .check()
            .map_err(|error| format!("{path}: {}", in_words(&error)))?;
        Ok(weights)
    }

    /// Refuses weights outside their ranges.
    ///
    /// # Errors
    /// [`Code::InvalidValue`](mocap_scene::error::Code::InvalidValue), with the weight and its range.
    pub fn check(&self) -> Result<()> {
        self.robot.check()?;
        self.foot_lock.check()?;
        self.clean.check()?;
        self.markers.check()
    }

    /// Gives the job's weights to steps without weights. If the job's weights are the defaults, the steps stay without
    /// weights.
    pub(super) fn give_to(&self, steps: &mut [EditStep]) {
        for step in steps {
            match step {
                EditStep::FootLock(step) if !is_default(&self.foot_lock) => {
                    step.weights.get_or_insert(self.foot_lock);
                }
                EditStep::Clean(step) if !is_default(&self.clean) => {
                    step.weights.get_or_insert(self.clean);
                }
                _ => {}
            }
        }
    }
}

/// The schemas of weights, from their tables.
#[cfg(feature = "schema")]
mod schema {
    use std::borrow::Cow;

    use mocap_scene::options::WeightRow;
    use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

    fn of(rows: &[WeightRow]) -> Schema {
        let property = |row: &WeightRow| {
            let [least, largest] = row.range();
            let value = serde_json::json!({
                "type": "number",
                "description": format!("{} Unit: {}.", row.reason, row.unit),
                "default": row.default,
                "minimum": least,
                "maximum": largest,
            });
            (row.key(), value)
        };
        let properties: serde_json::Map<String, serde_json::Value> = rows.iter().map(property).collect();
        json_schema!({"type": "object", "properties": properties, "additionalProperties": false})
    }

    macro_rules! schemas {
        ($($name:ident of $rows:expr;)*) => {$(
            pub(super) struct $name;

            impl JsonSchema for $name {
                fn schema_name() -> Cow<'static, str> {
                    stringify!($name).into()
                }

                fn json_schema(_: &mut SchemaGenerator) -> Schema {
                    of($rows)
                }
            }
        )*};
    }

    schemas! {
        RobotWeights of mocap_retarget::robot::Weights::ROWS;
        FootLockWeights of mocap_edit::FootLockWeights::ROWS;
        CleanWeights of mocap_edit::CleanWeights::ROWS;
        MarkerWeights of mocap_solve::MarkerWeights::ROWS;
    }
}
