//! Defines what a step is: a name, options, and an effect on a scene.

use std::fmt;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use mocap_figure::{Humanoid, HumanoidBone, HumanoidMap};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::{AppliedStep, SecondMotion, StepRecord};

/// A change of a motion. The fields of its type are the options of the step. Each option has a default, and a name in
/// JSON and in text. Only this crate defines steps, so that every program can read the record of a step.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::edit::{Smooth, Step, StepInput};
///
/// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let report = Smooth::new().cut_off(8.0).apply(&mut scene, &StepInput::new())?;
/// println!("{report}"); // rotations changed by ... degrees at most (...), positions by ... cm at most
/// assert!(report.largest_rotation > 0.1);
/// # Ok::<(), mocap::Error>(())
/// ```
pub trait Step: sealed::Sealed + Serialize + DeserializeOwned + Clone + PartialEq + fmt::Debug {
    /// The name of the step in kebab case.
    const NAME: &'static str;
    /// The effect of the step, in a few words.
    const HELP: &'static str;
    /// The options of the step.
    const KEYS: &'static [StepKey];
    /// Whether the step takes a second motion.
    const TAKES_OTHER: bool = false;
    /// Whether the step needs the bones of the figure.
    const TAKES_BONES: bool = false;

    /// Whether the step changes the rest pose, the joint axes or the joints, which all animations share. The step then
    /// changes all animations at once.
    #[doc(hidden)]
    const IS_OF_SKELETON: bool = false;

    /// The report of the step. As text, it is a sentence with units. In JSON, values are in metres, seconds and
    /// degrees.
    type Report: fmt::Display + Serialize + Clone + PartialEq + fmt::Debug;

    /// Changes the scene without a record of the step. [`apply`](Self::apply) also records the step. If the step uses a
    /// [`Conversion`](mocap_figure::Conversion), the conversion always records itself.
    ///
    /// # Errors
    /// The errors that the type of the step documents. After an error, `scene` is unchanged.
    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<Self::Report>;

    /// The number of the second motion among the inputs of a command, counted from 1. `None` if the options do not
    /// state it.
    fn with(&self) -> Option<usize> {
        None
    }

    /// Adds the step to [`Metadata::steps`](mocap_scene::scene::Metadata::steps), so that `verify` can
    /// repeat it.
    fn record(&self, scene: &mut Scene, input: &StepInput<'_>) {
        // A second motion is retargeted to the bones of the first motion. So a step with a second motion records these
        // bones, too.
        let known = input.humanoid.filter(|_| Self::TAKES_BONES || Self::TAKES_OTHER);
        let edit = AppliedStep::Edit {
            edit: StepRecord(recorded(Self::NAME, self)),
            with: input.other.filter(|_| Self::TAKES_OTHER).map(SecondMotion::of),
            bones: known.map(|bones| names(scene, bones)).unwrap_or_default().bones,
        };
        scene.metadata.steps.push(edit);
    }

    /// Changes the scene, and records the step.
    ///
    /// # Errors
    /// The errors of [`change`](Self::change).
    fn apply(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<Self::Report> {
        let report = self.change(scene, input)?;
        self.record(scene, input);
        Ok(report)
    }
}

/// Prevents other crates from defining steps.
pub(crate) mod sealed {
    pub trait Sealed {}
}

/// The input of a step: the animation to change, the second motion, and the bones.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::edit::{Concat, Step, StepInput};
///
/// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let other = scene.clone();
/// let report = Concat::new().apply(&mut scene, &StepInput::new().other(&other))?;
/// assert_eq!(report.frames, 2 * 524 - 1); // the seam is the last frame of the one and the first of the other
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct StepInput<'a> {
    pub(super) animation: usize,
    pub(super) other: Option<&'a Scene>,
    pub(super) humanoid: Option<&'a Humanoid>,
    /// The bones that were found in the scene. They are not recorded, unlike bones that a user states.
    pub(super) found: Option<&'a Humanoid>,
}

impl<'a> StepInput<'a> {
    /// The input for the first animation of the scene, without a second motion.
    pub fn new() -> Self {
        Self::default()
    }

    /// The animation to change, as an index into the animations of the scene. Default: 0.
    #[must_use]
    pub fn animation(mut self, index: usize) -> Self {
        self.animation = index;
        self
    }

    /// The scene of the second motion, for a step that takes one. The step uses the first animation of this scene. The
    /// skeleton of this scene must have the same joints as the skeleton of the changed scene.
    #[must_use]
    pub fn other(mut self, other: impl Into<Option<&'a Scene>>) -> Self {
        self.other = other.into();
        self
    }

    /// The bones, if the caller knows them. Default: the bones that [`Humanoid::of`](mocap_figure::Humanoid::of) finds.
    #[must_use]
    pub fn humanoid(mut self, humanoid: impl Into<Option<&'a Humanoid>>) -> Self {
        self.humanoid = humanoid.into();
        self
    }

    /// The bones of the scene, if they are known.
    pub(super) fn bones(&self) -> Option<&'a Humanoid> {
        self.humanoid.or(self.found)
    }

    /// The scene of the second motion. Fails if there is none; `S` is the step that the message names.
    pub(super) fn second<S: Step>(&self) -> Result<&'a Scene> {
        let message = || format!("the step {} needs a second motion", S::NAME);
        self.other
            .ok_or_else(|| Diagnostic::new(Code::InvalidValue, message()).into())
    }
}

/// For each bone, the name of its joint; `None` for a bone without a joint.
pub(super) fn names(scene: &Scene, humanoid: &Humanoid) -> HumanoidMap {
    let name = |bone: HumanoidBone| {
        humanoid
            .joint(bone)
            .map(|joint| scene.nodes[joint.index()].name.clone())
    };
    HumanoidBone::ALL.iter().map(|&bone| (bone, name(bone))).collect()
}

/// The options of a step by their names in kebab case, except options without a value.
pub(super) fn keys_of(step: &impl Serialize) -> serde_json::Map<String, Value> {
    match serde_json::to_value(step) {
        Ok(Value::Object(mut keys)) => {
            keys.retain(|_, value| !value.is_null());
            keys
        }
        _ => serde_json::Map::new(),
    }
}

/// A step as files record it. The option `with` is left out, because the record describes the second motion itself.
pub(super) fn recorded(name: &str, step: &impl Serialize) -> Value {
    let mut keys = keys_of(step);
    keys.remove(WITH);
    keys.insert("step".to_owned(), Value::from(name));
    Value::Object(keys)
}

/// The option that names the second motion.
pub(super) const WITH: &str = "with";

/// The description of a kind of step, without values of its options.
///
/// ```
/// use mocap::edit::EditStep;
///
/// let smooth = EditStep::ALL.iter().find(|step| step.name == "smooth").unwrap();
/// assert!(smooth.to_string().starts_with("remove fast changes: filter=butterworth|gaussian, cut-off=HZ, "));
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct StepInfo {
    /// The name of the step in kebab case.
    pub name: &'static str,
    /// The effect of the step, in a few words.
    pub help: &'static str,
    /// The options of the step.
    pub keys: &'static [StepKey],
    /// Whether the step takes a second motion.
    pub takes_other: bool,
    /// Whether the step needs the bones of the figure.
    pub takes_bones: bool,
    /// Whether the step changes what all animations share.
    pub(super) is_of_skeleton: bool,
}

impl StepInfo {
    pub(super) const fn of<S: Step>() -> Self {
        Self {
            name: S::NAME,
            help: S::HELP,
            keys: S::KEYS,
            takes_other: S::TAKES_OTHER,
            takes_bones: S::TAKES_BONES,
            is_of_skeleton: S::IS_OF_SKELETON,
        }
    }
}

/// The documentation of a step, for bindings in other languages. It is separate from [`StepInfo`], so that only
/// programs that use the documentation contain it.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct StepDocs {
    /// The documentation of the step.
    pub step: &'static str,
    /// The documentation of each option, in the order of [`Step::KEYS`].
    pub keys: &'static [&'static str],
}

/// Prints the effect of the step, and its options with the values that they take.
impl fmt::Display for StepInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.help)?;
        match self.keys {
            [] => Ok(()),
            _ => write!(f, ": {}", self.keys_with_values()),
        }
    }
}

impl StepInfo {
    /// The options, each with the values that it takes.
    pub(super) fn keys_with_values(&self) -> String {
        let key = |key: &StepKey| match key.takes {
            ValueKind::Moments => key.takes.symbol().to_owned(),
            ValueKind::OneOf(words) => format!("{}={}", key.name(), words.join("|")),
            takes => format!("{}={}", key.name(), takes.symbol()),
        };
        self.keys.iter().map(key).collect::<Vec<_>>().join(", ")
    }
}

/// An option of a step.
///
/// [`StepInfo`](crate::StepInfo) has an example.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct StepKey {
    /// The name of the field in the type of the step.
    pub field: &'static str,
    /// The kind of value that the option takes.
    pub takes: ValueKind,
}

impl StepKey {
    pub(super) const fn new(field: &'static str, takes: ValueKind) -> Self {
        Self { field, takes }
    }

    /// The name of the option in JSON and in text: the field in kebab case.
    pub fn name(&self) -> String {
        self.field.replace('_', "-")
    }

    /// An example of the option with a value, as text.
    #[doc(hidden)]
    pub fn example(&self) -> String {
        match self.takes {
            ValueKind::Moments => self.takes.example().to_owned(),
            takes => format!("{}={}", self.name(), takes.example()),
        }
    }
}

/// The kind of value that an option takes. As text, it completes the sentence "KEY takes ...".
///
/// [`StepInfo`](crate::StepInfo) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ValueKind {
    /// A time, in seconds.
    Seconds,
    /// A length, in metres.
    Metres,
    /// A speed, in metres per second.
    MetresPerSecond,
    /// A frequency in Hz, or a number of frames per second.
    Hertz,
    /// An angle, in degrees.
    Degrees,
    /// A factor, such as 1.6.
    Factor,
    /// A fraction, from 0 to 1.
    Fraction,
    /// A number of frames.
    Count,
    /// Yes or no.
    Flag,
    /// One of these words.
    OneOf(&'static [&'static str]),
    /// The numbers of a first and a last frame.
    FrameRange,
    /// A time range of a motion.
    TimeRange,
    /// Frame numbers.
    Frames,
    /// A weight, or a curve of weights over time.
    Weights,
    /// Weights of a solver, each a name and a number.
    Numbers,
    /// Points over the ground, with or without times.
    Path,
    /// Pairs of an old and a new time, in seconds. In text, each pair is a separate option `S=S`.
    Moments,
    /// A point, or the name of a node.
    Target,
    /// A point or an offset: three lengths in metres.
    Point,
    /// The name of a node.
    Name,
    /// Names of joints or bones.
    Names,
    /// The number of a motion among the inputs of a command.
    Input,
}

impl ValueKind {
    /// The placeholder for a value of this kind in the help of the command line.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Seconds => "S",
            Self::Metres => "M",
            Self::MetresPerSecond => "M/S",
            Self::Hertz => "HZ",
            Self::Degrees => "DEGREES",
            Self::Factor => "TIMES",
            Self::Fraction => "FRACTION",
            Self::Count | Self::Input => "N",
            Self::Flag => "true|false",
            Self::OneOf(_) => "WORD",
            Self::FrameRange | Self::TimeRange => "A..B",
            Self::Frames => "A+B+...",
            Self::Weights => "0..1 or S:0..1+...",
            Self::Numbers => "NAME:NUMBER+...",
            Self::Path => "[S:]M/M+...",
            Self::Moments => "S=S,...",
            Self::Target => "M/M/M or NAME",
            Self::Point => "M/M/M",
            Self::Name => "NAME",
            Self::Names => "NAME+NAME+...",
        }
    }
}

impl ValueKind {
    /// An example value, as text.
    pub(super) const fn example(self) -> &'static str {
        match self {
            Self::Seconds | Self::Weights => "0.5",
            Self::Metres => "5cm",
            Self::MetresPerSecond => "0.25",
            Self::Hertz => "8",
            Self::Degrees => "3",
            Self::Factor => "1.6",
            Self::Fraction => "0.02",
            Self::Count => "20",
            Self::Input => "2",
            Self::Flag => "true",
            Self::OneOf([.., last]) => last,
            Self::OneOf([]) => "",
            Self::FrameRange => "20..140",
            Self::TimeRange => "0..1.5",
            Self::Frames => "0+30+60",
            Self::Numbers => "largest-turn:0.5",
            Self::Path => "0/0+1/2",
            Self::Moments => "0=0,1.5=3",
            Self::Target | Self::Point => "0.3/1.2/0.5",
            Self::Name => "Hips",
            Self::Names => "LeftArm+LeftForeArm",
        }
    }
}

impl fmt::Display for ValueKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let example = self.example();
        match self {
            Self::Seconds => write!(f, "a time in seconds such as {example}"),
            Self::Metres => write!(f, "a length such as {example}"),
            Self::MetresPerSecond => write!(f, "a speed in metres per second such as {example}"),
            Self::Hertz => write!(f, "a frequency in Hz such as {example}"),
            Self::Degrees => write!(f, "an angle in degrees such as {example}"),
            Self::Factor => write!(f, "a factor such as {example}"),
            Self::Fraction => write!(f, "a fraction such as {example}"),
            Self::Count => write!(f, "a whole number of frames such as {example}"),
            Self::Flag => f.write_str("true or false"),
            Self::OneOf(words) => f.write_str(&words.join(" or ")),
            Self::FrameRange => write!(f, "two frames such as {example}"),
            Self::TimeRange => write!(
                f,
                "a part A..B in seconds such as {example}, or in frames such as 20f..140f"
            ),
            Self::Frames => write!(f, "frames such as {example}"),
            Self::Weights => write!(
                f,
                "a weight from 0 to 1 such as {example}, or a curve SECONDS:WEIGHT+... such as 0:0+1.5:1"
            ),
            Self::Numbers => f.write_str("weights NAME:NUMBER+... of docs/weights.md"),
            Self::Path => write!(
                f,
                "points M/M+... such as {example}, or SECONDS:M/M+... such as 0:0/0+2.5:1/2"
            ),
            Self::Moments => write!(f, "pairs of times in seconds such as {example}"),
            Self::Target => write!(
                f,
                "a point M/M/M in metres such as {example}, or the name of a joint, a bone or a node"
            ),
            Self::Point => write!(f, "three lengths M/M/M in metres such as {example}"),
            Self::Name => f.write_str("the name of a joint, a bone or a node"),
            Self::Names => write!(f, "names of joints or bones such as {example}"),
            Self::Input => f.write_str("the number of a motion among the inputs, 2 or more"),
        }
    }
}

/// Declares a step and its options from one table: the field, its type, its default, and the kind of its values. It
/// generates the struct with a builder method for each field, the table `OPTIONS` for [`Step::KEYS`], and the
/// documentation `DOCS`.
macro_rules! step {
    (
        $(#[doc = $doc:literal])*
        $name:ident {
            $($(#[doc = $about:literal])* $field:ident: $type:ty = $default:expr, $takes:expr;)*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
        #[non_exhaustive]
        pub struct $name {
            $($(#[doc = $about])* pub $field: $type,)*
        }

        impl $crate::step::sealed::Sealed for $name {}

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $name {
            const OPTIONS: &'static [$crate::StepKey] = &[
                $($crate::StepKey::new(stringify!($field), $takes),)*
            ];
            pub(crate) const DOCS: $crate::StepDocs = $crate::StepDocs {
                step: concat!($($doc, "\n"),*),
                keys: &[$(concat!($($about, "\n"),*),)*],
            };

            /// The step with the default of every option.
            pub fn new() -> Self {
                Self::default()
            }

            $(
                $(#[doc = $about])*
                #[must_use]
                pub fn $field(mut self, $field: $type) -> Self {
                    self.$field = $field;
                    self
                }
            )*
        }
    };
}
pub(super) use step;
