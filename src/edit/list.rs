//! The macro behind the list of steps in `lib.rs`. It declares the files as modules, an enum of all steps, and an enum
//! of their reports.

use std::fmt;

use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::scene::Scene;
use serde::de::Error as _;
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value};

use super::{EditStep, StepInput, StepReport, text};

/// Declares the file of each step as a module, and re-exports the public items of this file. The first item is the
/// step, and the report of the step follows `=>`. The macro makes the enums [`EditStep`] and [`StepReport`] from this
/// list. The macro also makes the module `report`. This module has all reports, including reports of files without a
/// step.
macro_rules! steps {
    (
        report { $($shared:ident: $shared_report:ident;)* }
        $($file:ident: $step:ident $(, $public:ident)* $(=> $($report:ident),+)?;)*
    ) => {
        $(
            mod $file;
            pub use self::$file::{$step, $($public),*};
        )*

        pub mod report {
            //! The reports of steps: what a step changed.

            $(pub use super::$shared::$shared_report;)*
            $($(pub use super::$file::{$($report),+};)?)*

            /// The report of a step. Each variant has the report type of one step.
            ///
            /// [`EditStep`](crate::EditStep) has an example.
            #[derive(Clone, Debug, PartialEq, serde::Serialize)]
            #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
            #[serde(untagged)]
            #[non_exhaustive]
            pub enum StepReport {
                $(
                    #[doc = concat!("Of [`", stringify!($step), "`](crate::", stringify!($step), ").")]
                    $step(<super::$step as super::Step>::Report),
                )*
            }

            impl std::fmt::Display for StepReport {
                fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                    match self { $(Self::$step(report) => std::fmt::Display::fmt(report, f),)* }
                }
            }
        }
        use self::report::StepReport;

        /// A step with its options.
        ///
        /// As text, it is `NAME:key=value,...`, as on the command line. As JSON, it is an object with the name of the
        /// step in `step` and the options as further keys, or a string with the text.
        ///
        /// ```
        /// # std::env::set_current_dir("../..").unwrap();
        /// use mocap::edit::{EditStep, StepInput};
        /// use mocap::edit::report::StepReport;
        ///
        /// let step: EditStep = "smooth:cut-off=8".parse()?;
        /// assert_eq!(step.to_string(), "smooth:cut-off=8.0,ease=0.2,filter=butterworth,range=..");
        /// let same = serde_json::json!({"step": "smooth", "cut-off": 8});
        /// assert_eq!(serde_json::from_value::<EditStep>(same).unwrap(), step);
        ///
        /// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
        /// let report = step.apply(&mut scene, &StepInput::new())?;
        /// let StepReport::Smooth(changed) = report.changed else { unreachable!() };
        /// assert!(changed.largest_rotation > 0.0);
        /// # Ok::<(), mocap::Error>(())
        /// ```
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum EditStep {
            $(#[doc = concat!("[`", stringify!($step), "`].")] $step($step),)*
        }

        impl EditStep {
            /// Every step.
            pub const ALL: &[StepInfo] = &[$(StepInfo::of::<$step>()),*];

            /// The documentation of every step, in the order of [`ALL`](Self::ALL).
            #[doc(hidden)]
            pub const DOCS: &[StepDocs] = &[$($step::DOCS),*];

            fn info(&self) -> StepInfo {
                match self { $(Self::$step(_) => StepInfo::of::<$step>(),)* }
            }

            /// The number of the second motion among the inputs of a command, counted from 1. `None` if the options do
            /// not state it.
            pub fn with(&self) -> Option<usize> {
                match self { $(Self::$step(step) => step.with(),)* }
            }

            fn keys(&self) -> serde_json::Map<String, serde_json::Value> {
                match self { $(Self::$step(step) => step::keys_of(step),)* }
            }

            /// The step as files record it.
            fn recorded(&self) -> serde_json::Value {
                match self { $(Self::$step(step) => step::recorded($step::NAME, step),)* }
            }

            /// The step with this name and these options; `None` if no step has this name.
            fn with_keys(
                name: &str,
                keys: serde_json::Map<String, serde_json::Value>,
                stated: &str,
            ) -> Option<mocap_scene::error::Result<Self>> {
                $(if name == $step::NAME {
                    return Some(text::read(keys, stated).map(Self::$step));
                })*
                None
            }

            fn report(&self, scene: &mut mocap_scene::scene::Scene, input: &StepInput<'_>) -> mocap_scene::error::Result<StepReport> {
                match self { $(Self::$step(step) => step.apply(scene, input).map(StepReport::$step),)* }
            }
        }

        $(impl From<$step> for EditStep {
            fn from(step: $step) -> Self {
                Self::$step(step)
            }
        })*
    };
}
pub(super) use steps;

impl EditStep {
    /// The name of the step.
    pub fn name(&self) -> &'static str {
        self.info().name
    }

    /// Whether the step takes a second motion.
    pub fn needs_other(&self) -> bool {
        self.info().takes_other
    }

    /// Applies the step to a scene, and records it in [`Metadata::steps`](mocap_scene::scene::Metadata::steps).
    ///
    /// # Errors
    /// The errors of the step. [`Code::InvalidValue`] if the step needs a second motion and `input` has none. After an
    /// error, `scene` is unchanged.
    pub fn apply(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<EditReport> {
        let changed = self.report(scene, input)?;
        let other = input.other.filter(|_| self.needs_other());
        let origin = other.and_then(|other| other.metadata.origin.as_ref());
        Ok(EditReport {
            step: self.clone(),
            clip: None,
            with: origin.map(|origin| origin.name.clone()),
            retargeted: None,
            changed,
        })
    }

    /// Reads a step from a JSON value, as files record it. The value is an object with the name of the step in `step`
    /// and the options as further keys, or a string with the step as text.
    ///
    /// # Errors
    /// The errors of [`list_from_json`](Self::list_from_json).
    #[doc(hidden)]
    pub fn from_value(value: &Value) -> Result<Self> {
        match value {
            Value::String(text) => text.parse(),
            value => text::from_object(value),
        }
    }
}

impl EditStep {
    /// Reads the steps of a JSON list. An entry is an object with the name of the step in `step` and the options as
    /// further keys, or a string with the step as text.
    ///
    /// ```
    /// use mocap::edit::EditStep;
    ///
    /// let steps = EditStep::list_from_json(r#"["mirror", {"step": "smooth", "cut-off": 8}]"#)?;
    /// assert_eq!(steps[1].to_string(), "smooth:cut-off=8.0,ease=0.2,filter=butterworth,range=..");
    ///
    /// let error = EditStep::list_from_json(r#"[{"step": "smooth", "cutoff": 8}]"#).unwrap_err();
    /// assert_eq!(error.code().as_str(), "unknown-option");
    /// assert!(error.diagnostic().help.as_deref().unwrap().starts_with("did you mean cut-off?"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::UnknownOption`] for a step or an option that does not exist. [`Code::InvalidValue`] for a value that an
    /// option does not take, and for a text that is no list of steps.
    pub fn list_from_json(text: &str) -> Result<Vec<Self>> {
        let list: Vec<Value> = serde_json::from_str(text).map_err(|error| {
            let message = format!("steps must be a JSON list, such as [\"mirror\", \"smooth:cut-off=8\"]: {error}");
            Diagnostic::new(Code::InvalidValue, message)
        })?;
        list.iter().map(Self::from_value).collect()
    }
}

/// Writes the step as an object with the name of the step in `step` and the options as further keys.
impl Serialize for EditStep {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let keys = self.keys();
        let mut map = serializer.serialize_map(Some(keys.len() + 1))?;
        map.serialize_entry("step", self.name())?;
        for (key, value) in &keys {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

/// Reads the step from text, or from an object as `Serialize` writes it.
impl<'de> Deserialize<'de> for EditStep {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        Self::from_value(&value).map_err(|error| D::Error::custom(error.diagnostic()))
    }
}

/// Prints the name of the step and all its options, in the order of the option names. An option that was not given has
/// its default.
impl fmt::Display for EditStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&text::of(self.info(), &self.keys()))
    }
}

/// Parses `NAME` or `NAME:key=value,...`.
impl std::str::FromStr for EditStep {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        text::parse(text)
    }
}

/// What a step changed.
///
/// As text, it is the line that `mocap edit` prints, for example `fill: 2 gaps filled, 0 longer gaps not filled; ...`.
///
/// [`EditStep`](crate::EditStep) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct EditReport {
    /// The step with all its options. In JSON, it is a string `NAME:key=value,...`.
    #[serde(serialize_with = "step_as_text")]
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub step: EditStep,
    /// The name of the changed clip, if the file has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<String>,
    /// The file of the second motion, if the step takes one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub with: Option<String>,
    /// The quality of the retargeting, if the second motion had another skeleton.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub retargeted: Option<String>,
    /// The report of the step. In JSON, a 32-bit number is written with the digits of the equal 64-bit number.
    #[serde(serialize_with = "as_value")]
    pub changed: StepReport,
}

fn step_as_text<S: Serializer>(step: &EditStep, serializer: S) -> Result<S::Ok, S::Error> {
    let keys = match step.recorded() {
        Value::Object(keys) => keys,
        _ => Map::new(),
    };
    serializer.serialize_str(&text::of(step.info(), &keys))
}

fn as_value<S: Serializer>(report: &StepReport, serializer: S) -> Result<S::Ok, S::Error> {
    let value = serde_json::to_value(report).map_err(serde::ser::Error::custom)?;
    value.serialize(serializer)
}

impl fmt::Display for EditReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.step.name())?;
        if let Some(clip) = &self.clip {
            write!(f, " of clip \"{clip}\"")?;
        }
        if let Some(file) = &self.with {
            write!(f, " with {file}")?;
        }
        if let Some(quality) = &self.retargeted {
            write!(f, ", retargeted from another skeleton ({quality})")?;
        }
        write!(f, ": {}", self.changed)
    }
}
