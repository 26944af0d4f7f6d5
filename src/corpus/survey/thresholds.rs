//! The table of the kinds of defects, with the thresholds from which a clip is suspect or bad.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use mocap_scene::error::{Code, Diagnostic, Result};

/// Declares [`DefectKind`]. Each line has: defect or property, variant, name, unit, suspect threshold, bad threshold,
/// whether the kind needs a humanoid, and a description.
macro_rules! kinds {
    ($($class:ident $variant:ident $name:literal $unit:literal $suspect:literal $bad:literal $body:literal $help:literal)*) => {
        /// The kinds of defects of a motion, and of properties, which do not lower the verdict.
        ///
        /// ```
        /// use mocap::survey::DefectKind;
        ///
        /// let skate = DefectKind::from_name("skate")?;
        /// assert_eq!((skate, skate.unit()), (DefectKind::Skate, "cm"));
        /// # Ok::<(), mocap::Error>(())
        /// ```
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(rename_all = "kebab-case")]
        #[non_exhaustive]
        pub enum DefectKind {
            $(#[doc = $help] $variant,)*
        }

        impl DefectKind {
            /// Every kind.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// The name in tables, options and expressions.
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The unit of the amounts.
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$variant => $unit,)* }
            }

            /// A description in one phrase.
            pub const fn help(self) -> &'static str {
                match self { $(Self::$variant => $help,)* }
            }

            /// Whether the kind is a property, which does not lower the verdict.
            pub const fn is_property(self) -> bool {
                matches!(match self { $(Self::$variant => Class::$class,)* }, Class::Property)
            }

            /// Whether only a humanoid can have the kind.
            pub const fn needs_body(self) -> bool {
                match self { $(Self::$variant => $body,)* }
            }

            const fn limits(self) -> [f64; 2] {
                match self { $(Self::$variant => [$suspect, $bad],)* }
            }
        }
    };
}

/// The classes of kinds.
enum Class {
    /// Damage, which lowers the verdict.
    Defect,
    /// Information for the user, without damage.
    Property,
}

kinds! {
    Defect NotFinite "not-finite" "values" 1.0 1.0 false "values in the file that are not finite; mocap replaces them"
    Defect CutOff "cut-off" "%" 2.0 10.0 false "the file has fewer frames than it states"
    Defect NoMotion "no-motion" "joints" 1.0 1.0 false "the file has no motion, or no joint moves in it"
    Defect WrongRate "wrong-rate" "times" 1.3 2.0 false "the factor by which bodies fall too fast or too slowly, or by which the frame rate is outside 5 to 1000 frames per second"
    Defect Frozen "frozen" "s" 0.5 2.0 false "frames in which no joint moves, between frames in which the body moves"
    Defect Gap "gap" "s" 0.5 2.0 false "some joints hold one pose while other joints move; in other frames, the held joints move too"
    Defect Doubled "doubled" "frames" 1.0 5.0 false "frames that repeat the previous frame while the body moves"
    Defect Dropped "dropped" "frames" 6.0 12.0 false "frames whose previous frame is missing"
    Defect Flip "flip" "flips" 1.0 4.0 false "a rotation of a limb or of the trunk jumps away and comes back"
    Defect Exchanged "exchanged" "frames" 1.0 10.0 true "frames in which left and right legs, or arms, are exchanged"
    Defect Noise "noise" "mm" 11.0 20.0 false "jitter of a joint, as the displacement of its farthest descendant joint"
    Defect Breathing "breathing" "%" 3.0 8.0 false "the length of a bone changes"
    Defect TPose "t-pose" "s" 0.01 1.0 true "the body stands in a T-pose within the motion"
    Defect Skate "skate" "cm" 9.0 20.0 true "a foot slides during ground contact"
    Defect Floating "floating" "cm" 7.5 18.0 true "the body hovers above the floor on which it stood before"
    Defect UnderFloor "under-floor" "cm" 5.0 12.0 true "the body has sunk: one foot is below the floor, and no foot is on the floor"
    Defect FootThroughFloor "foot-through-floor" "cm" 5.0 12.0 true "one foot is below the floor on which the other foot stands"
    Defect Tilted "tilted" "degrees" 2.0 4.0 true "the floor under the feet has a slope"
    Defect Drift "drift" "cm" 6.0 20.0 true "the body and the feet in contact drift over the ground"
    Defect HeightDrift "height-drift" "cm" 10.0 20.0 true "the floor under the feet slowly rises or sinks, as in takes of inertial suits"
    Defect BeyondRange "beyond-range" "degrees" 20.0 40.0 true "a knee bends forwards, or a knee, an elbow or the neck bends beyond the human range"
    Defect SelfCollision "self-collision" "cm" 5.0 8.0 true "a hand or a forearm is inside the trunk or the head"
    Property PoseFile "pose-file" "frames" 1.0 1.0 false "the file has a pose, not a motion: at most three frames, not counting a rest pose"
    Property FaceOnly "face-only" "curves" 1.0 1.0 false "only the face moves, by expressions or morph targets"
    Property TPoseEnd "t-pose-end" "s" 0.01 1.0 true "the clip begins or ends in a T-pose"
    Property HeldEnd "held-end" "s" 0.5 2.0 false "the clip begins or ends with frames in which no joint moves"
    Property FingerFlip "finger-flip" "flips" 1.0 4.0 true "a rotation of a finger, a toe or the face jumps away and comes back"
    Property NoSupport "no-support" "s" 0.6 1.5 true "an object that is not in the file carries the body, such as stairs or a chair"
    Property Treadmill "treadmill" "s" 0.5 4.0 true "the legs walk, and the body stays in place"
    Property ClippedEnd "clipped-end" "cm" 12.0 25.0 true "the clip begins or ends in the air"
    Property OddUnit "odd-unit" "times" 1.5 3.0 false "the file's unit differs from the unit of other files with the same skeleton and format"
    Property OddAxis "odd-axis" "degrees" 45.0 45.0 false "the up axis differs from the up axis of other files with the same skeleton and format"
}

impl DefectKind {
    /// The kind with this name.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for an unknown name. The message lists all names.
    pub fn from_name(name: &str) -> Result<Self> {
        let found = Self::ALL.iter().copied().find(|kind| kind.as_str() == name);
        found.ok_or_else(|| {
            let names = Self::ALL.iter().map(|kind| kind.as_str()).collect::<Vec<_>>();
            Diagnostic::new(Code::InvalidValue, format!("\"{name}\" is not a kind of defect"))
                .expected_found(names.join(", "), name)
                .into()
        })
    }
}

/// The amounts of each kind from which a clip is suspect, and from which a clip is bad.
///
/// ```
/// use mocap::survey::{DefectKind, Thresholds};
///
/// let mut thresholds = Thresholds::default();
/// thresholds.set("skate=2..5")?;
/// assert_eq!(thresholds.of(DefectKind::Skate), [2.0, 5.0]);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Thresholds {
    changed: BTreeMap<DefectKind, [f64; 2]>,
}

impl Thresholds {
    /// The amounts of a kind from which a clip is suspect and bad.
    pub fn of(&self, kind: DefectKind) -> [f64; 2] {
        self.changed.get(&kind).copied().unwrap_or(kind.limits())
    }

    /// Sets the thresholds of a kind. `text` is `KIND=BAD` or `KIND=SUSPECT..BAD`. An amount of `inf` disables the
    /// kind.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for anything else.
    pub fn set(&mut self, text: &str) -> Result<()> {
        let refused = || {
            Diagnostic::new(Code::InvalidValue, format!("\"{text}\" is not a threshold"))
                .expected_found("KIND=BAD or KIND=SUSPECT..BAD, such as skate=2 or skate=1..2", text)
        };
        let (name, amounts) = text.split_once('=').ok_or_else(refused)?;
        let kind = DefectKind::from_name(name.trim())?;
        let (suspect, bad) = match amounts.split_once("..") {
            Some((suspect, bad)) => (Some(suspect), bad),
            None => (None, amounts),
        };
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| *number >= 0.0);
        let bad = number(bad).ok_or_else(refused)?;
        let suspect = match suspect {
            Some(text) => number(text).filter(|suspect| *suspect <= bad).ok_or_else(refused)?,
            // A bad threshold below the default suspect threshold also lowers the suspect threshold.
            None if bad.is_infinite() => bad,
            None => self.of(kind)[0].min(bad),
        };
        self.changed.insert(kind, [suspect, bad]);
        Ok(())
    }
}
