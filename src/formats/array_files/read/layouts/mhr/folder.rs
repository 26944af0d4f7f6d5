//! A folder with a file for each frame, or for each person in a frame.

use std::collections::BTreeMap;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::limit_exceeded;
use mocap_scene::scene::{Format, Scene};

use super::samples::frames_of;
use super::{CAMERA, Kind, ROTATIONS, Sample, persons};
use crate::array_files::read::layouts::Reader;
use crate::array_files::read::ndarray::Entries;
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

/// The largest number of frames per file of a folder. The frames between files are interpolated.
const MOST_PER_FILE: usize = 64;

/// The persons in a folder with a file for each frame, or for each person in a frame.
#[derive(Debug, Default)]
pub struct BodyFrames {
    /// Samples by frame number.
    frames: BTreeMap<u64, Vec<Sample>>,
    kind: Kind,
    rate: Option<f64>,
}

impl BodyFrames {
    /// Whether the reader needs the array with this name. An array without a name may hold dictionaries.
    pub(in crate::array_files::read) fn reads(name: &str) -> bool {
        let names = [Kind::Joints.positions(), Kind::Keypoints.positions(), CAMERA, "fps"];
        let is_known = names.iter().chain(&ROTATIONS).any(|own| name.ends_with(own));
        // The reader skips the other arrays of the estimator, because the arrays of vertices are large.
        let is_other = name.starts_with("pred_") || name.ends_with("_params") || name.ends_with("mask");
        is_known || !is_other
    }

    pub(in crate::array_files::read) fn add(&mut self, frame: u64, entries: &Entries<'_>) -> Result<(), Failure> {
        let options = ReadOptions::default();
        let reader = Reader {
            entries,
            options: &options,
        };
        let Some(kind) = Kind::of(entries).filter(|kind| self.frames.is_empty() || *kind == self.kind) else {
            let message = format!("the file has no {}", self.kind.positions());
            return Err(Box::new(
                Diagnostic::new(Code::MissingKeyword, message)
                    .expected_found(format!("{} of one frame", self.kind.positions()), entries.describe())
                    .help("take the file from the folder"),
            ));
        };
        let frames = frames_of(&reader, kind)?;
        if frames.len() != 1 {
            let message = "a file in a folder of frames does not have exactly one frame";
            return Err(Box::new(
                Diagnostic::new(Code::RowLength, message)
                    .expected_found(format!("{} of one frame", kind.positions()), entries.describe())
                    .help("read the file itself, or take it from the folder"),
            ));
        }
        self.kind = kind;
        self.rate = self.rate.or(reader.stated_rate());
        let samples = frames.into_iter().flat_map(|(_, samples)| samples);
        self.frames.entry(frame).or_default().extend(samples);
        Ok(())
    }

    pub(in crate::array_files::read) fn into_scene(
        self,
        options: &ReadOptions,
        warnings: &mut Warnings,
    ) -> Result<Scene, Failure> {
        let reader = Reader {
            entries: &Entries::default(),
            options,
        };
        let numbers: Vec<u64> = self.frames.keys().copied().collect();
        // For example, every second frame of a video is a take without gaps.
        let step = numbers.windows(2).map(|pair| pair[1] - pair[0]).min().unwrap_or(1);
        let most = MOST_PER_FILE * numbers.len();
        if let (Some(first), Some(last)) = (numbers.first(), numbers.last())
            && (last - first) / step >= most as u64
        {
            return Err(Box::new(limit_exceeded(
                format!("at most {most} frames in {} files", numbers.len()),
                format!("numbers from {first} to {last}"),
            )));
        }
        let frames = persons::places(self.frames.into_iter().collect(), step);
        super::of_frames(&reader, (self.kind, self.rate), frames, Format::Npz, warnings)
    }
}
