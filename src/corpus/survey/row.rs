//! The row of a clip. The columns are declared once, for tables, expressions and the documentation.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::thresholds::DefectKind;

/// The value of a column.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cell {
    /// No value: the file is unreadable, or a measure of the body has no humanoid.
    Nothing,
    Flag(bool),
    Number(f64),
    Text(String),
}

/// The type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CellType {
    Flag,
    Number,
    Text,
}

trait CellValue {
    const TYPE: CellType;
    fn cell(&self) -> Cell;
    fn round(&mut self) {}
}

impl CellValue for bool {
    const TYPE: CellType = CellType::Flag;
    fn cell(&self) -> Cell {
        Cell::Flag(*self)
    }
}

impl CellValue for f64 {
    const TYPE: CellType = CellType::Number;
    fn cell(&self) -> Cell {
        Cell::Number(*self)
    }
    fn round(&mut self) {
        *self = rounded(*self);
    }
}

impl CellValue for u64 {
    const TYPE: CellType = CellType::Number;
    fn cell(&self) -> Cell {
        Cell::Number(*self as f64)
    }
}

impl CellValue for String {
    const TYPE: CellType = CellType::Text;
    fn cell(&self) -> Cell {
        Cell::Text(self.clone())
    }
}

impl CellValue for Quality {
    const TYPE: CellType = CellType::Text;
    fn cell(&self) -> Cell {
        Cell::Text(self.as_str().to_owned())
    }
}

impl<T: CellValue> CellValue for Option<T> {
    const TYPE: CellType = T::TYPE;
    fn cell(&self) -> Cell {
        self.as_ref().map_or(Cell::Nothing, T::cell)
    }
    fn round(&mut self) {
        self.iter_mut().for_each(T::round);
    }
}

/// Rounds to seven significant digits. Measures are not more exact, and the text of a rounded number reads back as the
/// same number.
fn rounded(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return 0.0;
    }
    let scale = 10f64.powi(6 - value.abs().log10().floor() as i32);
    match (value * scale).round() / scale {
        rounded if rounded.is_finite() => rounded,
        _ => value,
    }
}

/// How good a clip is.
///
/// The [module](crate::survey) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Quality {
    /// No amount reaches a threshold.
    #[default]
    Good,
    /// An amount reaches the lower threshold of its kind.
    Suspect,
    /// An amount reaches the upper threshold of its kind.
    Bad,
    /// The file cannot be read.
    Unreadable,
}

impl Quality {
    /// All qualities, the best first.
    pub const ALL: [Self; 4] = [Self::Good, Self::Suspect, Self::Bad, Self::Unreadable];

    /// The name in tables.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Suspect => "suspect",
            Self::Bad => "bad",
            Self::Unreadable => "unreadable",
        }
    }
}

/// A defect or a property of a motion, with its frames.
///
/// The [module](crate::survey) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Defect {
    /// The kind.
    pub kind: DefectKind,
    /// The first and the last frame.
    pub frames: [usize; 2],
    /// The joint, if a single joint has the defect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// The amount, in the unit of the kind.
    pub amount: f64,
    /// The confidence, from 0 to 1.
    pub confidence: f64,
}

/// Declares [`ClipRow`] from its columns.
macro_rules! row {
    ($($(#[doc = $help:literal])* $name:ident: $type:ty,)*) => {
        /// The row of a clip, or of a file that cannot be read.
        ///
        /// The [module](crate::survey) has an example.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[non_exhaustive]
        pub struct ClipRow {
            $($(#[doc = $help])* #[serde(default)] pub $name: $type,)*
            /// The amount of each kind of defect and property, in the unit of the kind: the largest amount of all
            /// findings, or the sum of times. The amount is 0 if the survey searched for the kind and found nothing.
            /// Kinds that the survey did not search for are absent.
            #[serde(flatten)]
            pub amounts: BTreeMap<DefectKind, f64>,
            /// The findings.
            #[serde(default)]
            pub defects: Vec<Defect>,
        }

        /// The columns, without the columns of kinds of defects.
        const COLUMNS: &[(&str, CellType)] = &[$((stringify!($name), <$type as CellValue>::TYPE),)*];

        impl ClipRow {
            /// Rounds every number to seven significant digits.
            pub(super) fn round(&mut self) {
                $(CellValue::round(&mut self.$name);)*
                self.amounts.values_mut().for_each(CellValue::round);
                self.defects.iter_mut().for_each(|defect| {
                    CellValue::round(&mut defect.amount);
                    CellValue::round(&mut defect.confidence);
                });
            }

            fn own_cell(&self, column: &str) -> Option<Cell> {
                match column {
                    $(stringify!($name) => Some(self.$name.cell()),)*
                    _ => None,
                }
            }
        }
    };
}

row! {
    /// The file.
    file: String,
    /// The clip's name in the file, or its index if it has no name.
    clip: String,
    /// Why the file cannot be read. If it is set, all columns below are empty.
    error: Option<String>,
    /// The verdict.
    verdict: Quality,
    /// The quality from 0 to 1: 1 / (1 + the sum of amount / bad threshold).
    quality: f64,
    /// The kinds of defects that lower the verdict, the worst first.
    reasons: String,
    /// The kinds of properties of the clip. Properties do not lower the verdict.
    properties: String,
    /// The SHA-256 of the file's bytes.
    sha256: String,
    /// The format of the file.
    format: String,
    /// The number of warnings of the reader.
    warnings: u64,
    /// The licence that the file or a `mocap.toml` in its folder states.
    licence: Option<String>,
    /// The dataset or the address of the file's origin.
    source: Option<String>,
    /// The name of the person who moves.
    person: Option<String>,
    /// Whether a program made the motion.
    synthetic: Option<bool>,
    /// A hash of the skeleton. Scale and names do not change it.
    skeleton: String,
    /// The number of joints that the file can animate.
    joints: u64,
    /// Whether the figure is a humanoid. If not, measures of the body are absent.
    humanoid: Option<bool>,
    /// Metres in one unit of the file.
    metres_per_unit: Option<f64>,
    /// The axis that points up in the file.
    up: String,
    /// The sum of the lengths of all bones, in metres.
    size: Option<f64>,
    /// The kind of the rest pose.
    rest_pose: String,
    /// The first frame that is a T-pose.
    t_pose_frame: Option<u64>,
    /// Frames per second.
    rate: Option<f64>,
    /// The number of frames.
    frames: u64,
    /// The duration in seconds: frames / frames per second.
    seconds: f64,
    /// The distance that the hips, or the root, travel along the floor, in metres.
    distance: Option<f64>,
    /// The mean speed along the floor, in m/s.
    speed: Option<f64>,
    /// The largest speed along the floor over half a second, in m/s.
    top_speed: Option<f64>,
    /// The root mean square of the jerk of all joints, the third derivative of their positions, in m/s^3.
    jerk: Option<f64>,
    /// The angle that the body turns about the vertical, in degrees: the sum of left and right turns.
    turning: Option<f64>,
    /// The number of jumps.
    jumps: Option<u64>,
    /// The number of times that the body turns over.
    turns_over: Option<u64>,
    /// Seconds in which the body stands.
    standing: Option<f64>,
    /// Seconds in which the body walks.
    walking: Option<f64>,
    /// Seconds in which the body runs.
    running: Option<f64>,
    /// Seconds in which the body is in the air.
    jumping: Option<f64>,
    /// Seconds in which the body lies.
    lying: Option<f64>,
    /// Seconds of all other activities.
    other: Option<f64>,
    /// The difference in movement between left and right limbs: 0 if both move equally, 1 if one side rests.
    asymmetry: Option<f64>,
    /// Whether the clip is a near-duplicate of another clip that is kept.
    twin: bool,
    /// The number of the clip's group of near-duplicates.
    twin_group: Option<u64>,
    /// The clip of the group that is kept.
    twin_of: Option<String>,
    /// How the clip repeats the kept clip: bytes, motion, mirrored, retimed, rate, skeleton or piece.
    twin_reason: Option<String>,
    /// The first coordinate on the map of the corpus. The coordinates are the first two principal components of the
    /// descriptor.
    map_x: Option<f64>,
    /// The second coordinate on the map.
    map_y: Option<f64>,
    /// The part of a split corpus that has the clip: train, validation or test.
    split: Option<String>,
}

impl ClipRow {
    /// Every column with its type. The columns of kinds of defects come last.
    pub(super) fn columns() -> Vec<(&'static str, CellType)> {
        let kinds = DefectKind::ALL.iter().map(|kind| (kind.as_str(), CellType::Number));
        COLUMNS.iter().copied().chain(kinds).collect()
    }

    /// The names of all columns. The columns of kinds of defects come last.
    pub fn column_names() -> Vec<&'static str> {
        Self::columns().into_iter().map(|(name, _)| name).collect()
    }

    /// The value of a column; `None` for an unknown column.
    pub(super) fn cell(&self, column: &str) -> Option<Cell> {
        self.own_cell(column).or_else(|| {
            let kind = DefectKind::ALL.iter().find(|kind| kind.as_str() == column)?;
            Some(
                self.amounts
                    .get(kind)
                    .map_or(Cell::Nothing, |amount| Cell::Number(*amount)),
            )
        })
    }

    /// Makes a row for a file that cannot be read.
    pub fn unreadable(file: &str, error: &str) -> Self {
        Self {
            file: file.to_owned(),
            error: Some(error.to_owned()),
            verdict: Quality::Unreadable,
            reasons: "error".to_owned(),
            ..Self::default()
        }
    }
}
