//! One row for each clip: the columns are declared once, for tables, expressions and the documentation.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::thresholds::DefectKind;

/// The value of a column.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cell {
    /// There is none: an unreadable file, or a measure of a body without a body.
    Nothing,
    Flag(bool),
    Number(f64),
    Text(String),
}

/// What a column holds.
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

/// To seven significant digits: what is measured is not more exact, and text of it is read back as the same number.
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
    /// Every one, the best first.
    pub const ALL: [Self; 4] = [Self::Good, Self::Suspect, Self::Bad, Self::Unreadable];

    /// Its name in tables.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Suspect => "suspect",
            Self::Bad => "bad",
            Self::Unreadable => "unreadable",
        }
    }
}

/// Something wrong with a motion, and where.
///
/// The [module](crate::survey) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Defect {
    /// What it is.
    pub kind: DefectKind,
    /// The first and the last frame.
    pub frames: [usize; 2],
    /// The joint, where it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// How much, in the unit of the kind.
    pub amount: f64,
    /// How sure that is, from 0 to 1.
    pub confidence: f64,
}

/// Declares [`ClipRow`] from its columns.
macro_rules! row {
    ($($(#[doc = $help:literal])* $name:ident: $type:ty,)*) => {
        /// One row: a clip of a file, or a file that cannot be read.
        ///
        /// The [module](crate::survey) has an example.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[non_exhaustive]
        pub struct ClipRow {
            $($(#[doc = $help])* #[serde(default)] pub $name: $type,)*
            /// The amount of each kind of defect and property, in its unit: the largest of its findings, for times
            /// their sum. 0 where it was looked for; kinds that were not looked for are absent.
            #[serde(flatten)]
            pub amounts: BTreeMap<DefectKind, f64>,
            /// Every finding.
            #[serde(default)]
            pub defects: Vec<Defect>,
        }

        /// The columns, without those of kinds of defects.
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
    /// The clip's name in the file, or its index where it has none.
    clip: String,
    /// Why the file cannot be read; all below is then empty.
    error: Option<String>,
    /// The verdict.
    verdict: Quality,
    /// From 0 to 1: 1 / (1 + the sum of amounts / bad amounts).
    quality: f64,
    /// The kinds of defects that make the verdict, the worst first.
    reasons: String,
    /// The kinds of properties that the clip has, which do not lower the verdict.
    properties: String,
    /// The SHA-256 of the file's bytes.
    sha256: String,
    /// The format of the file.
    format: String,
    /// Warnings of the reader.
    warnings: u64,
    /// The licence, as the file or a `mocap.toml` beside it states it.
    licence: Option<String>,
    /// The dataset or the address that it comes from.
    source: Option<String>,
    /// Who moves.
    person: Option<String>,
    /// Whether a program made the motion.
    synthetic: Option<bool>,
    /// A hash of the skeleton, equal for equal skeletons up to scale and names.
    skeleton: String,
    /// Joints that the file can animate.
    joints: u64,
    /// Whether it is a humanoid; measures of the body are absent where it is not.
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
    /// Frames.
    frames: u64,
    /// Frames / frames per second.
    seconds: f64,
    /// Metres that the hips, or the root, travel along the floor.
    distance: Option<f64>,
    /// Its mean per second, in metres.
    speed: Option<f64>,
    /// Its largest over half a second, in metres per second.
    top_speed: Option<f64>,
    /// The root mean square of the jerk of all joints, the third derivative of their positions, in m/s^3.
    jerk: Option<f64>,
    /// Degrees that the body turns about the vertical, left and right added.
    turning: Option<f64>,
    /// Jumps.
    jumps: Option<u64>,
    /// How often the body turns over.
    turns_over: Option<u64>,
    /// Seconds in which it stands.
    standing: Option<f64>,
    /// Seconds in which it walks.
    walking: Option<f64>,
    /// Seconds in which it runs.
    running: Option<f64>,
    /// Seconds in which it is in the air.
    jumping: Option<f64>,
    /// Seconds in which it lies.
    lying: Option<f64>,
    /// Seconds in which it does anything else.
    other: Option<f64>,
    /// By how much left and right limbs differ in how much they move: 0 for equal, 1 where one side rests.
    asymmetry: Option<f64>,
    /// Whether it repeats another clip that is kept.
    twin: bool,
    /// The number of its group of twins.
    twin_group: Option<u64>,
    /// The clip that it repeats: that which is kept of the group.
    twin_of: Option<String>,
    /// How: bytes, motion, mirrored, retimed, rate, skeleton or piece.
    twin_reason: Option<String>,
    /// Two coordinates on the map of the corpus: the first two principal components of the descriptor.
    map_x: Option<f64>,
    /// The second coordinate.
    map_y: Option<f64>,
    /// The part of the corpus that the clip is in, where it was split: train, validation or test.
    split: Option<String>,
}

impl ClipRow {
    /// Every column with its type, those of kinds of defects last.
    pub(super) fn columns() -> Vec<(&'static str, CellType)> {
        let kinds = DefectKind::ALL.iter().map(|kind| (kind.as_str(), CellType::Number));
        COLUMNS.iter().copied().chain(kinds).collect()
    }

    /// The names of all columns, those of kinds of defects last.
    pub fn column_names() -> Vec<&'static str> {
        Self::columns().into_iter().map(|(name, _)| name).collect()
    }

    /// The value of a column; `None` if there is no such column.
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

    /// A row for a file that cannot be read.
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
