//! Values that users write as text, on a command line or in a job file: lengths, units, parts of a motion.

use std::fmt;
use std::str::FromStr;

use mocap_figure::Unit;
use mocap_scene::options::as_text;
use mocap_scene::scene::UpAxis;

as_text!(Length UnitChoice UpChoice Angle);

/// A length in metres.
///
/// ```
/// use mocap::job::Length;
///
/// assert_eq!("1mm".parse(), Ok(Length::metres(0.001)));
/// assert_eq!("0.03".parse(), Ok(Length::metres(0.03)));
/// assert!("1 mile".parse::<Length>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Length(f64);

impl Length {
    #[cfg(feature = "schema")]
    const TAKES: &str = "a length of 0 or more: metres, or a number with the unit m, cm, mm or um, such as 1mm";

    /// A length in metres.
    pub const fn metres(metres: f64) -> Self {
        Self(metres)
    }

    /// The number of metres.
    pub const fn to_metres(self) -> f64 {
        self.0
    }

    /// The question to ask if a length on a command line lacks its unit. The user of `1` probably means 1 mm, not 1 m.
    #[doc(hidden)]
    pub fn question(text: &str) -> Option<String> {
        /// A number without a unit that is below this number was meant in metres, because no motion is exact to a
        /// tenth of a millimetre.
        const SMALLEST_IN_MILLIMETRES: f64 = 0.1;
        let number: f64 = text.trim().parse().ok().filter(|&number| number != 0.0)?;
        let millimetres = match number.abs() < SMALLEST_IN_MILLIMETRES {
            true => (number * 1e9).round() / 1e6,
            false => number,
        };
        Some(format!(
            "a length needs a unit: did you mean {millimetres}mm? For metres write {number}m"
        ))
    }
}

/// On a command line a length needs its unit.
#[cfg(feature = "clap")]
impl clap::builder::ValueParserFactory for Length {
    type Parser = clap::builder::ValueParser;

    fn value_parser() -> Self::Parser {
        clap::builder::ValueParser::new(|text: &str| match (Self::question(text), text.parse::<Self>()) {
            (Some(question), Ok(_)) => Err(question),
            (_, Ok(length)) => Ok(length),
            (_, Err(_)) => Err("not a length with a unit, such as 1mm or 0.5cm".to_owned()),
        })
    }
}

impl FromStr for Length {
    type Err = String;

    /// A number in metres, or with the unit m, cm, mm or um.
    fn from_str(text: &str) -> Result<Self, String> {
        match mocap_edit::metres(text) {
            Some(number) if number.is_finite() && number >= 0.0 => Ok(Self(number)),
            _ => Err("not a length, such as 1mm, 0.5cm or 0.001, which is in metres".to_owned()),
        }
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}m", self.0)
    }
}

/// The unit of length of a file: named, given in metres, or guessed.
///
/// ```
/// use mocap::job::UnitChoice;
///
/// assert_eq!("cm".parse::<UnitChoice>().unwrap().metres(), Some(0.01));
/// assert_eq!("auto".parse::<UnitChoice>().unwrap().metres(), None);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum UnitChoice {
    /// The unit that the file states, or else a guess.
    #[default]
    Auto,
    /// A unit with a name.
    Named(Unit),
    /// Metres in one unit.
    Metres(f64),
}

impl UnitChoice {
    #[cfg(feature = "schema")]
    const TAKES: &str = "auto, m, dm, cm, mm, inch, cmu (5.6444 cm), or metres in one unit";

    /// Metres per unit, if the unit is known.
    pub fn metres(self) -> Option<f64> {
        match self {
            Self::Auto => None,
            Self::Named(unit) => Some(unit.metres()),
            Self::Metres(metres) => Some(metres),
        }
    }
}

impl FromStr for UnitChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            unit => parse_unit(unit).map_err(|expected| format!("{expected}, or auto")),
        }
    }
}

impl fmt::Display for UnitChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Named(unit) => f.write_str(unit.as_str()),
            Self::Metres(metres) => metres.fmt(f),
        }
    }
}

/// Parses a unit other than `auto`.
pub(super) fn parse_unit(text: &str) -> Result<UnitChoice, String> {
    if let Some(unit) = Unit::named(text) {
        return Ok(UnitChoice::Named(unit));
    }
    match text.parse() {
        Ok(metres) if f64::is_finite(metres) && metres > 0.0 => Ok(UnitChoice::Metres(metres)),
        _ => Err("expected a unit: m, dm, cm, mm, inch, cmu or a number above 0".to_owned()),
    }
}

/// The up axis of a file: known, or to be guessed.
///
/// ```
/// use mocap::job::UpChoice;
/// use mocap::scene::UpAxis;
///
/// assert_eq!("-z".parse::<UpChoice>().unwrap().axis(), Some(UpAxis::NegZ));
/// assert_eq!("auto".parse::<UpChoice>().unwrap().axis(), None);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum UpChoice {
    /// The axis that the file states, or else the direction from the feet to the head.
    #[default]
    Auto,
    /// This axis.
    Axis(UpAxis),
}

impl UpChoice {
    #[cfg(feature = "schema")]
    const TAKES: &str = "auto, y, z, -y or -z";

    /// The axis, if known.
    pub fn axis(self) -> Option<UpAxis> {
        match self {
            Self::Auto => None,
            Self::Axis(axis) => Some(axis),
        }
    }
}

impl FromStr for UpChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let axis = UpAxis::ALL.into_iter().find(|axis| axis.as_str() == text);
        match (text, axis) {
            ("auto", _) => Ok(Self::Auto),
            (_, Some(axis)) => Ok(Self::Axis(axis)),
            _ => Err("expected auto, y, z, -y or -z".to_owned()),
        }
    }
}

impl fmt::Display for UpChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.axis().map_or("auto", UpAxis::as_str))
    }
}

/// An angle in degrees.
///
/// ```
/// use mocap::job::Angle;
///
/// assert_eq!("12.5".parse(), Ok(Angle(12.5)));
/// assert!("-1".parse::<Angle>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angle(pub f64);

impl Angle {
    #[cfg(feature = "schema")]
    const TAKES: &str = "an angle of 0 degrees or more";
}

impl FromStr for Angle {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(angle) if f64::is_finite(angle) && angle >= 0.0 => Ok(Self(angle)),
            _ => Err("not an angle of 0 degrees or more".to_owned()),
        }
    }
}

impl fmt::Display for Angle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
