//! The source of the rest pose as text, on a command line and in a job file.

use std::fmt;
use std::str::FromStr;

use mocap_scene::options::as_text;

use super::RestPoseSource;

as_text!(RestPoseSource);

impl RestPoseSource {
    #[cfg(feature = "schema")]
    const TAKES: &str = "zero (the rest pose of the file), t-pose, a-pose, or frame:N";
}

impl FromStr for RestPoseSource {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let frame = text.strip_prefix("frame:").and_then(|frame| frame.parse().ok());
        match (text, frame) {
            ("zero", _) => Ok(Self::InFile),
            ("t-pose", _) => Ok(Self::TPose),
            ("a-pose", _) => Ok(Self::APose),
            (_, Some(frame)) => Ok(Self::Frame(frame)),
            _ => Err("expected zero, t-pose, a-pose or frame:N".to_owned()),
        }
    }
}

impl fmt::Display for RestPoseSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame(frame) => write!(f, "frame:{frame}"),
            Self::TPose => f.write_str("t-pose"),
            Self::APose => f.write_str("a-pose"),
            Self::InFile => f.write_str("zero"),
        }
    }
}
