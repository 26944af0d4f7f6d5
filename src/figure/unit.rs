//! Defines units of length, and finds the unit in which the bones have the lengths of a person's bones.

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::{HumanoidBone as Bone, Scene};
use serde::Serialize;

use super::{Confidence, Figure};
use mocap_scene::scene::report::Guess;

/// A unit of length of motion files.
///
/// [`Survey`](crate::Survey) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Unit {
    /// Metres.
    Metre,
    /// The unit of the CMU motion capture database and of its conversions: 5.6444 cm, an inch divided by the `length
    /// 0.45` of its ASF files.
    Cmu,
    /// Decimetres, which MakeHuman writes.
    Decimetre,
    /// Inches.
    Inch,
    /// Centimetres.
    Centimetre,
    /// Millimetres.
    Millimetre,
    /// A unit that is not listed here, as a number of micrometres. In this unit, the bones have the lengths of an
    /// average person's bones.
    Measured(u32),
}

impl Unit {
    /// The known units, from the longest to the shortest.
    pub const ALL: [Self; 6] = [
        Self::Metre,
        Self::Decimetre,
        Self::Cmu,
        Self::Inch,
        Self::Centimetre,
        Self::Millimetre,
    ];

    /// Metres per unit.
    pub const fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Decimetre => 0.1,
            Self::Cmu => 0.0254 / 0.45,
            Self::Inch => 0.0254,
            Self::Centimetre => 0.01,
            Self::Millimetre => 0.001,
            Self::Measured(micrometres) => micrometres as f64 * 1e-6,
        }
    }

    /// The unit with this name; `None` if there is none.
    ///
    /// ```
    /// use mocap::figure::Unit;
    ///
    /// assert_eq!(Unit::named("cm"), Some(Unit::Centimetre));
    /// assert_eq!(Unit::named("parsec"), None);
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.as_str() == name)
    }

    /// The unit with this length in metres. It is a known unit if the lengths differ by less than a thousandth.
    pub(super) fn of_metres(metres: f64) -> Self {
        let is_near = |unit: &Self| (metres / unit.metres() - 1.0).abs() < 1e-3;
        let known = Self::ALL.into_iter().find(is_near);
        known.unwrap_or_else(|| Self::measured(metres))
    }

    /// The name of the unit, as a user types it.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Decimetre => "dm",
            Self::Cmu => "cmu",
            Self::Inch => "inch",
            Self::Centimetre => "cm",
            Self::Millimetre => "mm",
            Self::Measured(_) => "measured",
        }
    }

    /// The text that a user types for the unit: its name, or its metres.
    pub fn choice(self) -> String {
        match self {
            Self::Measured(_) => self.metres().to_string(),
            unit => unit.as_str().to_owned(),
        }
    }

    /// A unit without a name, of this number of metres, rounded to a micrometre.
    fn measured(metres: f64) -> Self {
        Self::Measured((metres * 1e6).round().clamp(1.0, f64::from(u32::MAX)) as u32)
    }
}

/// The sum of the lengths of an adult's bones from ankle to head, in metres. Soles and skull do not count. Adults are
/// 1.5 m to 2.2 m tall.
const ADULT: [f64; 2] = [1.18, 1.75];

/// The sum of the lengths of any person's bones from ankle to head, in metres: from a child of two years to the largest
/// person.
const ANYBODY: [f64; 2] = [0.72, 2.2];

/// The length of thigh plus shin of an average person, in metres: 0.49 of a height of 1.7 m. It is used for files
/// without a known unit.
const USUAL_LEG: f64 = 0.833;

/// The length of thigh plus shin, as a fraction of the length of the bones from ankle to head. The two lengths are 0.49
/// and 0.787 of the height. The ratio is used for figures without a head.
const LEG: f64 = 0.49 / 0.787;

/// The largest plausible ratio between the sizes of the figure and an average person, in both directions. Giants and
/// dolls exceed the ratio. Children do not exceed the ratio, and neither do figures whose inches were read as
/// centimetres.
const PLAUSIBLE: f64 = 4.0;

impl Figure {
    /// The warning about a humanoid whose size in this unit is implausible for a person.
    pub(super) fn implausible_size(&self, metres: f64) -> Option<Diagnostic> {
        let has = |bone: Bone| self.humanoid.joint(bone).is_some();
        let is_body = has(Bone::LeftLowerLeg) && has(Bone::RightLowerLeg) && (has(Bone::Head) || has(Bone::Neck));
        let ratio = metres / self.survey.unit.value.metres();
        let is_far = ratio > PLAUSIBLE || ratio < PLAUSIBLE.recip();
        (is_body && is_far).then(|| {
            let message = format!("in this unit, the figure is {ratio:.3} times as large as a person");
            Diagnostic::new(Code::ImplausibleSize, message)
                .expected_found(
                    format!("about {:.3} m per unit", self.survey.unit.value.metres()),
                    format!("{metres} m per unit"),
                )
                .help("if the file states a wrong unit, name the right one with {unit}")
        })
    }
}

/// The unit of a program or a database, identified by its joint names.
pub(super) fn family_unit(scene: &Scene) -> Option<(Unit, &'static str)> {
    let has = |names: &[&str]| {
        names
            .iter()
            .all(|name| scene.nodes.iter().any(|node| node.name == *name))
    };
    if has(&["HMD", "Left-Hip"]) {
        Some((Unit::Centimetre, "SlimeVR"))
    } else if has(&["spine05", "upperleg01.L"]) || has(&["UpLeg_L", "LoLeg_L", "__UpLeg_L"]) {
        Some((Unit::Decimetre, "MakeHuman"))
    } else if has(&["LHipJoint", "LowerBack"]) || has(&["lhipjoint", "lowerback"]) || has(&["LHipJoint", "lowerback"]) {
        Some((Unit::Cmu, "CMU's database"))
    } else if has(&["figureHair", "lShldr"]) || has(&["mPelvis", "mTorso"]) {
        Some((Unit::Inch, "Second Life"))
    } else {
        None
    }
}

/// The unit in which the bones have the lengths of a person's bones. `whole` is the length of the bones from ankle to
/// head; without a head, the length of a leg decides.
pub(super) fn unit_of(whole: Option<f64>, leg: f64, family: Option<(Unit, &'static str)>) -> Guess<Unit> {
    let (bones, length, part) = match whole {
        Some(length) => ("bones from ankle to head", length, 1.0),
        None => ("bones of a leg", leg, LEG),
    };
    let within = |unit: &Unit, range: [f64; 2]| {
        let [least, most] = range.map(|length| length * part);
        (least..=most).contains(&(length * unit.metres()))
    };
    let measured = |unit: Unit| {
        let metres = length * unit.metres();
        format!("the {bones} measure {length:.4} units, which is {metres:.2} m")
    };
    if let Some((unit, name)) = family.filter(|(unit, _)| within(unit, ANYBODY)) {
        return Guess {
            value: unit,
            confidence: Confidence::Sure,
            reason: format!("{}, and the joint names match {name}", measured(unit)),
        };
    }
    let known = [
        Unit::Centimetre,
        Unit::Metre,
        Unit::Millimetre,
        Unit::Inch,
        Unit::Cmu,
        Unit::Decimetre,
    ];
    if let Some(unit) = known.into_iter().find(|unit| within(unit, ADULT)) {
        // Decimetres, inches and CMU's unit are rare in files without the joint names of a known program or database.
        let is_common = !matches!(unit, Unit::Decimetre | Unit::Cmu | Unit::Inch);
        return Guess {
            value: unit,
            confidence: if is_common {
                Confidence::Sure
            } else {
                Confidence::Likely
            },
            reason: measured(unit),
        };
    }
    // For the size of a child or a giant, try only the three most common units.
    if let Some(unit) = known[..3].iter().copied().find(|unit| within(unit, ANYBODY)) {
        return Guess {
            value: unit,
            confidence: Confidence::Likely,
            reason: format!("{}, the size of a child or a giant", measured(unit)),
        };
    }
    let unit = Unit::measured(USUAL_LEG / leg);
    Guess {
        value: unit,
        confidence: Confidence::Unsure,
        reason: format!(
            "{} for an average person; no known unit gives the size of a person",
            measured(unit)
        ),
    }
}
