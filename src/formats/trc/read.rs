//! Reads TRC.

use glam::Vec3;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{FARTHEST, limit_exceeded};
use mocap_scene::scene::{Format, Scene};

use super::FIRST_WORD;
use crate::points::{self, Track};
use crate::text::table::{Table, cells, words};
use crate::text::{Cursor, Word, decode, decode_name, is_binary, number};
use crate::warnings::{Warnings, cut_row};
use crate::{Failure, ReadOptions, Source};

/// The number of columns before the first marker: the frame number and the time.
const BEFORE: usize = 2;

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> mocap_scene::error::Result<Scene> {
    let mut warnings = Warnings::default();
    let read = read_text(source.bytes, options, &mut warnings);
    warnings.attach_to(read)
}

/// The statements before the motion.
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
    // The second word may follow spaces even if tabs separate the other words.
    if !Cursor::new(first.bytes)
        .next_word()
        .is_some_and(|word| word.is(FIRST_WORD))
    {
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
        most_nodes: options.limits.max_nodes,
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
    motion.tracks.iter_mut().for_each(points::leave_out_zeros);
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

/// The words of a line, separated by spaces or tabs.
fn all_words<'a>(line: Word<'a>) -> Vec<Word<'a>> {
    let mut cursor = Cursor::new(line.bytes);
    std::iter::from_fn(|| cursor.next_word()).collect()
}

/// The lines of a TRC file.
struct Lines<'a> {
    table: Table<'a>,
}

impl<'a> Lines<'a> {
    fn header(&mut self) -> Result<Header, Failure> {
        let keys = self.table.header_line("DataRate, NumFrames, NumMarkers, Units")?;
        let line = self.table.header_line("the values of the header")?;
        let (mut keys_found, mut values) = (words(keys), words(line));
        if !keys_found.iter().any(|word| word.is("NumMarkers")) {
            // Spaces separate some of the keys, and tabs others.
            (keys_found, values) = (all_words(keys), all_words(line));
        }
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

    /// Reads the marker names, and skips the following line `X1 Y1 Z1`.
    fn names(
        &mut self,
        header: &Header,
        options: &ReadOptions,
        warnings: &mut Warnings,
    ) -> Result<Vec<String>, Failure> {
        let line = self.table.header_line("Frame#, Time and the names of the markers")?;
        let mut labels = words(line).into_iter();
        if labels.next().is_none_or(|word| word.strip_prefix("Frame").is_none()) {
            return Err(self
                .table
                .refused(line, "the line with the marker names is missing", "Frame#, Time, names"));
        }
        let names = match spread_names(line) {
            Some(names) => names,
            None => labels.skip(1).map(|word| decode_name(word.bytes)).collect(),
        };
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
                let message = "the number of markers in the line of names differs from the header";
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

/// The default name of a marker, by its index.
fn unnamed(marker: usize) -> String {
    format!("Unnamed_{}", marker + 1)
}

/// The names, if each name is above the first of the three columns of its marker; a marker may have no name. `None` if
/// the names are consecutive.
fn spread_names(line: Word<'_>) -> Option<Vec<String>> {
    let cells = cells(line);
    let columns = cells.get(BEFORE..)?;
    let last = columns.iter().rposition(|cell| !cell.bytes.is_empty())?;
    let is_spread = |(column, cell): (usize, &Word<'_>)| column % 3 == 0 || cell.bytes.is_empty();
    (last >= 3 && columns.iter().enumerate().all(is_spread)).then(|| {
        let heads = columns[..=last].iter().step_by(3).enumerate();
        heads
            .map(|(marker, cell)| match cell.bytes {
                b"" => unnamed(marker),
                name => decode_name(name),
            })
            .collect()
    })
}

struct Motion {
    tracks: Vec<Track>,
    frames: usize,
    /// The first and the last time.
    times: Vec<f64>,
    limit: u64,
    most_nodes: usize,
}

impl Motion {
    /// Whether a row lacks cells. A row with tabs may omit the cells of whole markers at its end.
    fn is_short(&self, line: Word<'_>) -> bool {
        let given = cells(line).len().saturating_sub(BEFORE);
        let has_tabs = line.bytes.contains(&b'\t');
        given < self.tracks.len() * 3 && !(has_tabs && given.is_multiple_of(3))
    }

    fn row(&mut self, lines: &Table<'_>, line: Word<'_>, warnings: &mut Warnings) -> Result<(), Failure> {
        let cells = cells(line);
        let given = cells.len().saturating_sub(BEFORE);
        self.add_unnamed(lines, &cells, warnings)?;
        let values = self.tracks.len() * 3;
        if (self.frames as u64 + 1).saturating_mul(values as u64) > self.limit {
            let found = format!("more than {} frames of {} markers", self.frames, self.tracks.len());
            return Err(Box::new(limit_exceeded(
                format!("at most {} values", self.limit),
                found,
            )));
        }
        self.report_beyond(lines, cells.get(BEFORE + values..).unwrap_or_default(), warnings);
        if self.is_short(line) {
            return Err(Box::new(
                Diagnostic::new(Code::RowLength, format!("frame {} has too few numbers", self.frames))
                    .at(lines.cursor.locate(line))
                    .expected_found(
                        format!("{values} numbers of {} markers", self.tracks.len()),
                        format!("{given}"),
                    )
                    .help("the file is cut off in this frame, or was changed by hand: export it again"),
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
                        .help("the marker counts as not seen in such frames")
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

    /// Adds markers for columns after the named markers, if a row has all three numbers.
    fn add_unnamed(&mut self, lines: &Table<'_>, cells: &[Word<'_>], warnings: &mut Warnings) -> Result<(), Failure> {
        let beyond = cells.get(BEFORE + self.tracks.len() * 3..).unwrap_or_default();
        let is_whole = |cells: &[Word<'_>]| cells.iter().all(|cell| !cell.bytes.is_empty());
        let more = beyond.chunks_exact(3).rposition(is_whole).map_or(0, |last| last + 1);
        let Some(first) = beyond.first().filter(|_| more > 0) else {
            return Ok(());
        };
        let named = self.tracks.len();
        if named + more >= self.most_nodes {
            let found = format!("{} markers and their group", named + more);
            return Err(Box::new(limit_exceeded(
                format!("at most {} nodes", self.most_nodes),
                found,
            )));
        }
        self.tracks.extend((named..named + more).map(|marker| Track {
            name: unnamed(marker),
            ..Track::default()
        }));
        warnings.push(Code::HeaderCount, || {
            let message = format!("{more} markers have columns and no names");
            Diagnostic::new(Code::HeaderCount, message)
                .at(lines.cursor.locate(*first))
                .expected_found(format!("columns of {named} markers"), format!("{}", named + more))
                .help(format!(
                    "the markers got the names {} and so on; name the markers in the file",
                    unnamed(named)
                ))
        });
        Ok(())
    }

    /// Warns about numbers after the last marker.
    fn report_beyond(&self, lines: &Table<'_>, beyond: &[Word<'_>], warnings: &mut Warnings) {
        let mut filled = beyond.iter().filter(|cell| !cell.bytes.is_empty());
        if let Some(first) = filled.next() {
            let more = 1 + filled.count();
            warnings.tally(Code::TrailingText, || {
                let message = format!(
                    "{more} numbers after the last marker of frame {} are not a position",
                    self.frames
                );
                Diagnostic::new(Code::TrailingText, message)
                    .at(lines.cursor.locate(*first))
                    .help("these numbers were ignored, also in other frames")
            });
        }
    }

    /// The frame rate in frames per second, from the header, or else from the times.
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
