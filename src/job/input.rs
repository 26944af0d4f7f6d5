//! The options for reading the files of a job.

use std::path::{Path, PathBuf};

use mocap_io::import::{Clips, Importer};
use mocap_scene::scene::{Format, RootOffset};
use mocap_solve::Lengths;
use serde::{Deserialize, Serialize};

use super::is_default;
#[cfg(feature = "clap")]
use mocap_figure::convert::Conversion;

/// The options for reading the files of a job.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::job::InputOptions;
///
/// let reading: InputOptions = serde_json::from_str(r#"{"from": "bvh", "root-offset": "add"}"#).unwrap();
/// let scene = reading.importer().import("fixtures/real/lecture_Test.bvh")?;
/// assert_eq!(scene.animations[0].frame_count(), 10);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = "Reading"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct InputOptions {
    /// Format of the input [default: found from its contents, or else from its extension]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", ignore_case = true, value_parser = format_parser()))]
    #[serde(skip_serializing_if = "is_default")]
    pub from: Option<Format>,
    /// The skeleton of an .amc motion [default: the .asf file in its folder with the same prefix, or the only .asf
    /// file]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    #[serde(skip_serializing_if = "is_default")]
    pub skeleton: Option<PathBuf>,
    /// How the root's OFFSET and its position channels combine
    #[cfg_attr(feature = "clap", arg(long, value_name = "POLICY", default_value = "auto"))]
    #[serde(skip_serializing_if = "is_default")]
    pub root_offset: RootOffset,
    /// Read all rows of the motion, including those beyond the declared number of frames
    #[cfg_attr(feature = "clap", arg(long))]
    #[serde(skip_serializing_if = "is_default")]
    pub all_rows: bool,
    /// The animation to use of a file that has several: its name, or its number from 0; name:3 is the animation whose
    /// name is 3. With all, a command for one motion uses the first
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME|N|all", default_value = "all", value_parser = parse_clip))]
    #[serde(skip_serializing_if = "is_default")]
    pub clip: Clips,
    /// The joints of a file of positions, to solve their rotations. A JSON file, or one of smpl22, smpl24, coco17,
    /// h36m, mediapipe33, openpose25, mhr70, mhr127 [default: arrays with the joints of SMPL are solved]
    #[cfg_attr(feature = "clap", arg(id = "joint-set", long, value_name = "SET|FILE"))]
    #[serde(skip_serializing_if = "is_default")]
    pub joints: Option<String>,
    /// Lengths of bones that are solved from positions: the median over all frames; or the length in each frame, so
    /// that joints match their positions
    #[cfg_attr(feature = "clap", arg(long, value_name = "KIND"))]
    #[serde(skip_serializing_if = "is_default")]
    pub lengths: Option<Lengths>,
    /// Solve a skeleton from the markers of a file. auto: a known marker set; auto:NAME: the markers of one subject;
    /// FILE: a JSON object from labels to landmarks [default: markers stay points]
    #[cfg_attr(feature = "clap", arg(long, value_name = "auto|FILE"))]
    #[serde(skip_serializing_if = "is_default")]
    pub markers: Option<String>,
    /// A static trial: markers of a standing person. It may have more markers than the motion
    #[cfg_attr(feature = "clap", arg(long = "static", value_name = "FILE"))]
    #[serde(rename = "static", skip_serializing_if = "is_default")]
    pub static_trial: Option<PathBuf>,
    /// The body for arrays of rotations, such as AMASS files. FILE is a model of SMPL, SMPL-H or SMPL-X (.npz or .pkl),
    /// or a file of any format with a figure. For arrays of a robot, FILE is the robot [default: generic proportions,
    /// 1.70 m tall]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    #[serde(skip_serializing_if = "is_default")]
    pub body: Option<PathBuf>,
    /// Treat every warning as an error
    #[cfg_attr(feature = "clap", arg(long))]
    #[serde(skip_serializing_if = "is_default")]
    pub strict: bool,
    /// Play at this number of frames per second: the motion keeps its frames, and becomes slower or faster
    #[cfg_attr(feature = "clap", arg(long, value_name = "RATE", value_parser = Self::parse_rate))]
    #[serde(skip_serializing_if = "is_default")]
    pub retime: Option<f64>,
}

impl InputOptions {
    /// Frames per second, as a command line takes them.
    #[cfg(feature = "clap")]
    pub fn parse_rate(text: &str) -> Result<f64, String> {
        let rate: f64 = text.parse().map_err(|_| "it must be a number".to_owned())?;
        let checked = Conversion::new().frame_rate(rate).check();
        checked.map_err(|error| error.diagnostic().message.clone())?;
        Ok(rate)
    }

    /// The files that are read besides the inputs.
    pub(super) fn files(&self) -> impl Iterator<Item = &Path> {
        let paths = [&self.skeleton, &self.static_trial, &self.body];
        // Names of joint sets are not files.
        let sets = [&self.joints, &self.markers].map(|set| set.as_ref().map(Path::new));
        let paths = paths.map(|path| path.as_deref());
        paths.into_iter().chain(sets).flatten().filter(|path| path.is_file())
    }

    /// An importer with these options.
    pub fn importer(&self) -> Importer {
        let mut importer = Importer::new()
            .root_offset(self.root_offset)
            .all_rows(self.all_rows)
            .strict(self.strict)
            .clips(self.clip.clone());
        if let Some(format) = self.from {
            importer = importer.format(format);
        }
        if let Some(skeleton) = &self.skeleton {
            importer = importer.skeleton(skeleton);
        }
        if let Some(joints) = &self.joints {
            importer = importer.joints(joints);
        }
        if let Some(lengths) = self.lengths {
            importer = importer.lengths(lengths);
        }
        if let Some(markers) = &self.markers {
            importer = importer.markers(markers);
        }
        if let Some(trial) = &self.static_trial {
            importer = importer.static_trial(trial);
        }
        if let Some(body) = &self.body {
            importer = importer.body(body);
        }
        match self.retime {
            Some(rate) => importer.retime(rate),
            None => importer,
        }
    }
}

#[cfg(feature = "clap")]
fn format_parser() -> impl clap::builder::TypedValueParser<Value = Format> {
    use clap::builder::{PossibleValuesParser, TypedValueParser};

    PossibleValuesParser::new(Format::ALL.map(Format::as_str)).try_map(|name| name.parse::<Format>())
}

#[cfg(feature = "clap")]
fn parse_clip(text: &str) -> Result<Clips, std::convert::Infallible> {
    text.parse()
}
