//! The scale of steps as text, on a command line and in a job file.

use std::fmt;
use std::str::FromStr;

use mocap_scene::options::as_text;

use super::Scale;

as_text!(Scale);

impl Scale {
    #[cfg(feature = "schema")]
    const TAKES: &str = "auto (the ratio of the leg lengths), none (as in the source), or a factor above 0";
}

impl FromStr for Scale {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let factor = text
            .parse()
            .ok()
            .filter(|factor: &f64| factor.is_finite() && *factor > 0.0);
        match (text, factor) {
            ("auto", _) => Ok(Self::Auto),
            ("none", _) => Ok(Self::None),
            (_, Some(factor)) => Ok(Self::Factor(factor)),
            _ => Err("expected auto, none or a factor above 0".to_owned()),
        }
    }
}

impl fmt::Display for Scale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::None => f.write_str("none"),
            Self::Factor(factor) => factor.fmt(f),
        }
    }
}
