//! Collects rows of positions into an array (frames, points, 3), with NaN for missing points.

use std::borrow::Cow;
use std::collections::HashMap;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::files::{PointColumns, point_of};
use mocap_scene::limits::limit_exceeded;
use mocap_scene::math::median::median;

use super::ndarray::{Bytes, Entries, Kind, NdArray};
use crate::Failure;
use crate::warnings::Warnings;

/// The help for a table without a motion.
pub(super) const TABLES: &str = "motion tables come from mocap fk, or have positions: the columns frame, joint, x, y, \
    z, or for each point NAME_x, NAME_y, NAME_z";

/// Whether the first columns are the columns of the table that `mocap survey` writes.
pub(super) fn is_survey(names: &[String]) -> bool {
    names
        .iter()
        .map(String::as_str)
        .take(4)
        .eq(["file", "clip", "error", "verdict"])
}

/// The diagnostic for the table of a survey.
pub(super) fn table_of_survey() -> Diagnostic {
    Diagnostic::new(Code::MissingKeyword, "the table of a survey is not a motion")
        .help("of such tables, mocap survey reads only .jsonl: write the table with {output} rows.jsonl")
}

/// The largest number of missing positions for each present position. Without this limit, a table with distant frame
/// numbers would fill the memory.
const MOST_GAPS: usize = 64;

/// The number of missing positions that any table may have: 3 MB.
const ANY_GAPS: usize = 1 << 18;

pub(super) struct PointRows<'c> {
    columns: &'c PointColumns,
    /// The points in the order of their first rows.
    names: Vec<String>,
    index_of: HashMap<String, usize>,
    /// The frame, the index of the point, and the position.
    cells: Vec<(i64, usize, [f32; 3])>,
    /// The time of each frame, if it is stated.
    times: Vec<f64>,
    /// The time of the previous row, and the points that its frame already has.
    before: Option<f32>,
    seen: Vec<bool>,
    frame: i64,
}

impl<'c> PointRows<'c> {
    /// Starts the rows of a table with these columns. Unused columns are listed in a warning.
    pub(super) fn new(columns: &'c PointColumns, names: &[String], warnings: &mut Warnings) -> Self {
        let mut rows = Self {
            columns,
            names: Vec::new(),
            index_of: HashMap::new(),
            cells: Vec::new(),
            times: Vec::new(),
            before: None,
            seen: Vec::new(),
            frame: -1,
        };
        if let PointColumns::Wide { points, time } = columns {
            let mut is_used = vec![false; names.len()];
            points
                .iter()
                .flatten()
                .chain(time)
                .for_each(|column| is_used[*column] = true);
            let is_left = |(column, name): &(usize, &String)| {
                !is_used[*column] && !name.is_empty() && !name.to_lowercase().starts_with("frame")
            };
            let left = names.iter().enumerate().filter(is_left);
            let left: Vec<&str> = left.map(|(_, name)| name.as_str()).collect();
            if !left.is_empty() {
                /// The largest number of columns in a warning.
                const NAMED: usize = 8;
                let named = left.iter().take(NAMED).copied().collect::<Vec<_>>().join(", ");
                let message = format!("{} columns of the table are not positions: {named}", left.len());
                warnings.push(Code::TrailingText, || {
                    Diagnostic::new(Code::TrailingText, message).help("these columns were left out")
                });
            }
            let of_x = points.iter().filter_map(|[x, _, _]| point_of(&names[*x], 'x'));
            rows.names = of_x.map(str::to_owned).collect();
        }
        rows
    }

    /// Adds a row. `number` and `text` return the cell of a column.
    pub(super) fn add<'t>(
        &mut self,
        line: usize,
        number: impl Fn(usize) -> Result<f32, Failure>,
        text: impl Fn(usize) -> Cow<'t, str>,
    ) -> Result<(), Failure> {
        match self.columns {
            PointColumns::Wide { points, time } => {
                self.frame += 1;
                if let Some(time) = time {
                    self.times.push(number(*time)?.into());
                }
                for (column, xyz) in points.iter().enumerate() {
                    let position = position(&number, xyz)?;
                    self.cells.push((self.frame, column, position));
                }
            }
            PointColumns::Long { frame, time, name, xyz } => {
                let name = text(*name);
                let column = match self.index_of.get(name.as_ref()) {
                    Some(column) => *column,
                    None => {
                        self.names.push(name.to_string());
                        self.seen.push(false);
                        self.index_of.insert(name.into_owned(), self.names.len() - 1);
                        self.names.len() - 1
                    }
                };
                let now = time.map(&number).transpose()?;
                let is_next = match (now, self.before) {
                    (Some(now), Some(before)) => now != before,
                    (_, None) if self.frame < 0 => true,
                    _ => self.seen[column],
                };
                self.frame = match frame {
                    Some(column) => {
                        let stated = text(*column);
                        stated
                            .parse::<f64>()
                            .ok()
                            .filter(|frame| frame.fract() == 0.0 && frame.abs() < 1e15)
                            .ok_or_else(|| {
                                let message = format!("line {line}: the frame is not a whole number");
                                Diagnostic::new(Code::RowLength, message).expected_found("a whole number", stated)
                            })? as i64
                    }
                    None => self.frame + i64::from(is_next),
                };
                if is_next {
                    self.seen.fill(false);
                    self.times.extend(now.map(f64::from));
                }
                self.seen[column] = true;
                self.before = now;
                self.cells.push((self.frame, column, position(&number, xyz)?));
            }
        }
        Ok(())
    }

    /// The arrays `positions`, `names` and, if times are stated, `fps`.
    pub(super) fn into_entries(self) -> Result<Entries<'static>, Failure> {
        let frames = || self.cells.iter().map(|(frame, _, _)| *frame);
        let (Some(first), Some(last)) = (frames().min(), frames().max()) else {
            let message = "the table has no rows";
            return Err(Box::new(Diagnostic::new(Code::NoMotion, message).help(TABLES)));
        };
        let count = usize::try_from(last - first).unwrap_or(usize::MAX).saturating_add(1);
        let most = self.cells.len().saturating_mul(MOST_GAPS).saturating_add(ANY_GAPS);
        if count.saturating_mul(self.names.len()) > most {
            return Err(Box::new(limit_exceeded(
                format!("at most {most} positions"),
                format!("{} points in the frames from {first} to {last}", self.names.len()),
            )));
        }
        let mut positions = vec![f32::NAN; count * self.names.len() * 3];
        for (frame, column, position) in &self.cells {
            let at = ((frame - first) as usize * self.names.len() + column) * 3;
            positions[at..at + 3].copy_from_slice(position);
        }
        let mut entries = Entries::default();
        let shape = vec![count, self.names.len(), 3];
        entries
            .arrays
            .push(("positions".to_owned(), floats("positions", shape, &positions)?));
        entries.arrays.push(("names".to_owned(), texts(&self.names)?));
        if let Some(rate) = rate(&self.times) {
            let bytes = Bytes::made(rate.to_le_bytes().to_vec());
            let rate = NdArray::new("fps", (Kind::Float(8), false), Vec::new(), false, bytes)?;
            entries.arrays.push(("fps".to_owned(), rate));
        }
        Ok(entries)
    }
}

/// The position in a row. If one coordinate is missing, all three are NaN.
fn position(number: &impl Fn(usize) -> Result<f32, Failure>, xyz: &[usize; 3]) -> Result<[f32; 3], Failure> {
    let [x, y, z] = [number(xyz[0])?, number(xyz[1])?, number(xyz[2])?];
    Ok(if (x + y + z).is_finite() {
        [x, y, z]
    } else {
        [f32::NAN; 3]
    })
}

/// An array of 32-bit floats.
pub(super) fn floats(name: &str, shape: Vec<usize>, values: &[f32]) -> Result<NdArray<'static>, Failure> {
    let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    NdArray::new(name, (Kind::Float(4), false), shape, false, Bytes::made(bytes))
}

/// Strings in NumPy's form.
fn texts(texts: &[String]) -> Result<NdArray<'static>, Failure> {
    let longest = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
    // One long name must not make all names long.
    let longest = longest.min(256);
    let mut bytes = Vec::with_capacity(4 * longest * texts.len());
    for text in texts {
        let codes = text.chars().map(u32::from).chain(std::iter::repeat(0)).take(longest);
        bytes.extend(codes.flat_map(u32::to_le_bytes));
    }
    NdArray::new(
        "names",
        (Kind::Text(longest), false),
        vec![texts.len()],
        false,
        Bytes::made(bytes),
    )
}

/// The frame rate in frames per second from frame times: the rate of the median step, or a nearby whole number.
fn rate(times: &[f64]) -> Option<f64> {
    /// The largest relative difference to a whole rate. Times with three decimals cause this difference at 30 frames
    /// per second.
    const NEAR: f64 = 0.02;
    let mut steps: Vec<f32> = times
        .windows(2)
        .map(|pair| (pair[1] - pair[0]) as f32)
        .filter(|step| *step > 0.0)
        .collect();
    let rate = 1.0 / f64::from(median(&mut steps)?);
    let rate = match (times.first(), times.last()) {
        // Single steps are rounded, but their sum is not.
        (Some(first), Some(last)) if ((last - first) * rate + 1.0 - times.len() as f64).abs() < 1.0 => {
            (times.len() - 1) as f64 / (last - first)
        }
        _ => rate,
    };
    Some(if (rate - rate.round()).abs() < NEAR {
        rate.round()
    } else {
        rate
    })
}
