//! Reads TRC.

use glam::Vec3;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{FARTHEST, limit_exceeded};
use mocap_scene::scene::{Format, Scene};

use super::FIRST_WORD;
use crate::points::{self, Track};
use crate::text::table::{Table, cells, words};
use crate::text::{Word, decode, decode_name, is_binary, number};
use crate::warnings::{Warnings, cut_row};
use crate::{Failure, ReadOptions, Source};

/// The columns before those of the first marker: the number of the frame, and the time.
const BEFORE: usize = 2;

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> mocap_scene::error::Result<Scene> {
    let mut warnings = Warnings::default();
    let read = read_text(source.bytes, options, &mut warnings);
    warnings.attach_to(read)
}

/// What the lines before the motion state.
struct Header {
    rate: f64,
    frames: f64,
    markers: f64,
    unit: String,
}

fn read_text(bytes: &[u8], options: &ReadOptions, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let text = decode(bytes)?;
    if is_binary(&text) {
        return Err(Box::new(Diagnostic::new(Code::BinaryFile, "the file is not text")));
    }
    let mut lines = Lines {
        table: Table::new(&text),
    };
    let first = lines.table.next_line().unwrap_or(Word { bytes: b"", offset: 0 });
    if !words(first).first().is_some_and(|word| word.is(FIRST_WORD)) {
        return Err(lines.table.refused(first, "the file is not TRC", FIRST_WORD));
    }
    let header = lines.header()?;
    let names = lines.names(&header, options, warnings)?;
    let mut motion = Motion {
        tracks: names
            .into_iter()
            .map(|name| Track {
                name,
                ..Track::default()
            })
            .collect(),
        frames: 0,
        times: Vec::new(),
        limit: options.limits.max_values,
    };
    while let Some(line) = lines.table.next_line() {
        if lines
            .table
            .is_cut_off(line, motion.is_short(line), motion.frames, header.frames)
        {
            warnings.push(Code::RowLength, || cut_row(lines.table.cursor.locate(line)));
            break;
        }
        motion.row(&lines.table, line, warnings)?;
    }
    motion.leave_out_zeros(warnings);
    lines.table.check_frames(motion.frames, header.frames, warnings);
    let rate = options.frame_rate_or(motion.rate(header.rate))?;
    let mut scene = Scene::default();
    scene.metadata.format = Some(Format::Trc);
    scene.metadata.metres_per_unit = points::metres(&header.unit);
    points::add(
        &mut scene,
        points::Kind::MARKERS,
        motion.tracks,
        (motion.frames, rate),
        warnings,
    );
    Ok(scene)
}

/// The lines of a TRC file.
struct Lines<'a> {
    table: Table<'a>,
}

impl<'a> Lines<'a> {
    fn header(&mut self) -> Result<Header, Failure> {
        let keys = self.table.header_line("DataRate, NumFrames, NumMarkers, Units")?;
        let values = words(self.table.header_line("the values of the header")?);
        let keys_found = words(keys);
        let value = |key: &str| {
            let column = keys_found.iter().position(|word| word.is(key))?;
            values.get(column).copied()
        };
        let number = |key: &str| {
            let word = value(key)?;
            number::parse(word.bytes).map(|number| number.value)
        };
        if value("NumMarkers").is_none() {
            return Err(self.table.refused(
                keys,
                "the header has no NumMarkers",
                "DataRate, NumFrames, NumMarkers, Units",
            ));
        }
        Ok(Header {
            rate: number("DataRate").unwrap_or(f64::NAN),
            frames: number("NumFrames").unwrap_or(f64::NAN),
            markers: number("NumMarkers").unwrap_or(f64::NAN),
            unit: value("Units").map_or(String::new(), |word| decode_name(word.bytes)),
        })
    }

    /// The names of the markers; the line of `X1 Y1 Z1` below them is passed.
    fn names(
        &mut self,
        header: &Header,
        options: &ReadOptions,
        warnings: &mut Warnings,
    ) -> Result<Vec<String>, Failure> {
        let line = self.table.header_line("Frame#, Time and the names of the markers")?;
        let mut labels = words(line).into_iter();
        if labels.next().is_none_or(|word| word.strip_prefix("Frame").is_none()) {
            return Err(self.table.refused(
                line,
                "the line of the names of markers is missing",
                "Frame#, Time, names",
            ));
        }
        let names: Vec<String> = labels.skip(1).map(|word| decode_name(word.bytes)).collect();
        let limit = options.limits.max_nodes;
        if names.len() >= limit {
            let found = format!("{} markers and their group", names.len());
            return Err(Box::new(limit_exceeded(format!("at most {limit} nodes"), found)));
        }
        let longest = options.limits.max_name_bytes;
        if let Some(name) = names.iter().find(|name| name.len() > longest) {
            let found = format!("a name of {} bytes", name.len());
            return Err(Box::new(limit_exceeded(
                format!("at most {longest} bytes in a name"),
                found,
            )));
        }
        if header.markers != names.len() as f64 {
            warnings.push(Code::HeaderCount, || {
                let message =
                    "the file has another number of markers than its header states; those with names were read";
                Diagnostic::new(Code::HeaderCount, message)
                    .at(self.table.cursor.locate(line))
                    .expected_found(format!("{}", header.markers), format!("{}", names.len()))
            });
        }
        let before = self.table.cursor.offset();
        let is_axes = |word: &Word<'_>| matches!(word.bytes.first(), Some(b'X' | b'x'));
        let axes = self.table.next_line();
        if !axes.is_some_and(|line| words(line).first().is_some_and(is_axes)) {
            self.table.cursor.set_offset(before);
        }
        Ok(names)
    }
}

struct Motion {
    tracks: Vec<Track>,
    frames: usize,
    /// The first time and the last.
    times: Vec<f64>,
    limit: u64,
}

impl Motion {
    /// Whether a row lacks cells. Empty cells at its end may be left out, but not within a marker, and not where blanks
    /// separate.
    fn is_short(&self, line: Word<'_>) -> bool {
        let given = cells(line).len().saturating_sub(BEFORE);
        let has_tabs = line.bytes.contains(&b'\t');
        given < self.tracks.len() * 3 && !(has_tabs && given.is_multiple_of(3))
    }

    fn row(&mut self, lines: &Table<'_>, line: Word<'_>, warnings: &mut Warnings) -> Result<(), Failure> {
        let cells = cells(line);
        let values = self.tracks.len() * 3;
        let given = cells.len().saturating_sub(BEFORE);
        if (self.frames as u64 + 1).saturating_mul(values as u64) > self.limit {
            let found = format!("more than {} frames of {} markers", self.frames, self.tracks.len());
            return Err(Box::new(limit_exceeded(
                format!("at most {} values", self.limit),
                found,
            )));
        }
        let rest = cells.get(BEFORE + values..).unwrap_or_default();
        if let Some(word) = rest.iter().find(|word| !word.bytes.is_empty()) {
            let more = rest.iter().filter(|word| !word.bytes.is_empty()).count();
            return Err(Box::new(
                Diagnostic::new(Code::RowLength, format!("frame {} has too many numbers", self.frames))
                    .at(lines.cursor.locate(*word))
                    .expected_found(
                        format!("{values} numbers of {} markers", self.tracks.len()),
                        format!("{more} more"),
                    )
                    .help("the names of markers and the columns do not fit: export the file again"),
            ));
        }
        if self.is_short(line) {
            return Err(Box::new(
                Diagnostic::new(Code::RowLength, format!("frame {} has too few numbers", self.frames))
                    .at(lines.cursor.locate(line))
                    .expected_found(
                        format!("{values} numbers of {} markers", self.tracks.len()),
                        format!("{given}"),
                    )
                    .help("the file is cut off there, or was written by another program than it says: export it again"),
            ));
        }
        if let Some(time) = cells.get(1).and_then(|word| number::parse(word.bytes)) {
            self.times.truncate(1);
            self.times.push(time.value);
        }
        let tick = self.frames as f64;
        let columns = cells.get(BEFORE..).unwrap_or_default();
        for (track, cells) in std::iter::zip(&mut self.tracks, columns.chunks_exact(3)) {
            let mut position = [0.0; 3];
            for (value, cell) in std::iter::zip(&mut position, cells) {
                *value = lines.number(*cell, "a coordinate")?;
            }
            if let Some(infinite) = position.iter().zip(cells).find(|(value, _)| value.is_infinite()) {
                warnings.tally(Code::NonFiniteValue, || {
                    let message = format!("a coordinate in frame {tick} is not finite, or beyond {FARTHEST:e}");
                    Diagnostic::new(Code::NonFiniteValue, message)
                        .at(lines.cursor.locate(*infinite.1))
                        .in_joint(&track.name)
                        .help("the marker was taken as not seen in such frames")
                });
            }
            if position.iter().all(|value| value.is_finite()) {
                track.ticks.push(tick);
                track
                    .positions
                    .push(Vec3::from_array(position.map(|value| value as f32)));
            }
        }
        self.frames += 1;
        Ok(())
    }

    /// Takes markers at the origin as not seen, where they would have jumped there.
    fn leave_out_zeros(&mut self, warnings: &mut Warnings) {
        for track in &mut self.tracks {
            let zeros = track
                .positions
                .iter()
                .filter(|position| **position == Vec3::ZERO)
                .count();
            if zeros == 0 || zeros == track.positions.len() || !jumps_to_zero(&track.positions) {
                continue;
            }
            warnings.push(Code::Gap, || {
                let message = format!("the marker is at 0, 0, 0 in {zeros} frames: taken as not seen there");
                Diagnostic::new(Code::Gap, message).in_joint(&track.name)
            });
            let mut positions = track.positions.iter();
            track.ticks.retain(|_| positions.next() != Some(&Vec3::ZERO));
            track.positions.retain(|position| *position != Vec3::ZERO);
        }
    }

    /// Frames per second: those of the header, or else of the times.
    fn rate(&self, stated: f64) -> f64 {
        if stated.is_finite() && stated > 0.0 {
            return stated;
        }
        match self.times.as_slice() {
            [first, last] if last > first => (self.frames as f64 - 1.0) / (last - first),
            _ => stated,
        }
    }
}

/// Whether all other positions are farther from the origin than a few of the longest steps between them.
fn jumps_to_zero(positions: &[Vec3]) -> bool {
    /// The number of longest steps by which all other positions must be farther from the origin: a marker does not jump
    /// as far and back.
    const STEPS: f32 = 4.0;
    let others = positions.iter().filter(|position| **position != Vec3::ZERO);
    let nearest = others.map(|position| position.length()).fold(f32::INFINITY, f32::min);
    let pairs = positions.windows(2).filter(|pair| !pair.contains(&Vec3::ZERO));
    let longest = pairs.map(|pair| pair[0].distance(pair[1])).fold(0.0, f32::max);
    nearest > STEPS * longest
}
