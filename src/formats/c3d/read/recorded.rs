//! Reads events, analog samples, force plates and measures of the person: the groups `EVENT`, `ANALOG`,
//! `FORCE_PLATFORM` and `PROCESSING`.

use glam::{DVec3, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::math::up_axis::to_y_up;
use mocap_scene::scene::{AnalogChannel, Event, ForcePlate, Recording};

use super::bytes::Processor;
use super::parameters::Parameters;
use super::{Header, scene};
use crate::points;
use crate::warnings::Warnings;

/// The offset in bytes of the mark of four-letter labels in the header (The C3D File Format: User Guide, 2008).
const HEADER_MARK: usize = 298;

/// The offset in bytes of the number of events in the header.
const HEADER_COUNT: usize = 300;

/// The offset in bytes of the event times in the header.
const HEADER_TIMES: usize = 304;

/// The offset in bytes of the event labels in the header.
const HEADER_LABELS: usize = 396;

/// The value of the mark at [`HEADER_MARK`].
const HAS_LABELS: u16 = 12_345;

/// The largest number of events in the header.
const HEADER_EVENTS: usize = 18;

/// The data of the file other than points, for its complete frames; `None` if there is none.
pub(super) fn read(
    bytes: &[u8],
    processor: Processor,
    header: &Header,
    parameters: &Parameters,
    frames: usize,
    warnings: &mut Warnings,
) -> Option<Recording> {
    let mut events = events(header, parameters);
    if events.is_empty() {
        events = header_events(bytes, processor, header);
    }
    events.retain(|event| event.time.is_finite());
    events.sort_by(|a, b| a.time.total_cmp(&b.time));
    let (per_frame, channels) = channels(bytes, processor, header, parameters, frames, warnings);
    let recorded = Recording {
        events,
        analog_rate: header.frame_rate * per_frame as f64,
        samples_per_frame: per_frame,
        plates: plates(parameters, header, &channels, warnings),
        channels,
        outputs: Vec::new(),
        measures: measures(parameters),
    };
    (recorded != Recording::default()).then_some(recorded)
}

/// The measures of the person from which Vicon's Plug-in Gait computes the legs.
fn measures(parameters: &Parameters) -> Vec<(String, f64)> {
    const SIDED: [&str; 8] = [
        "LegLength",
        "AsisTrocanterDistance",
        "KneeWidth",
        "AnkleWidth",
        "ThighRotation",
        "ShankRotation",
        "TibialTorsion",
        "StaticPlantFlex",
    ];
    let sided = ["L", "R"]
        .into_iter()
        .flat_map(|side| SIDED.map(|name| format!("{side}{name}")));
    let names = sided.chain(["InterAsisDistance", "MarkerDiameter"].map(str::to_owned));
    let measure = |name: String| {
        let value = parameters.number("PROCESSING", &name.to_ascii_uppercase())?;
        value.is_finite().then_some((name, value))
    };
    names.filter_map(measure).collect()
}

/// The events of the parameters. Their times count from frame 1, which may have been cut off.
fn events(header: &Header, parameters: &Parameters) -> Vec<Event> {
    let used = parameters
        .number("EVENT", "USED")
        .map_or(0, |used| used.max(0.0) as usize);
    let times = parameters.all_numbers("EVENT", "TIMES");
    let [labels, contexts, subjects] =
        ["LABELS", "CONTEXTS", "SUBJECTS"].map(|name| parameters.all_texts("EVENT", name));
    let text = |texts: &[&str], index: usize| texts.get(index).copied().unwrap_or_default().to_owned();
    let events = times.chunks_exact(2).take(used).enumerate();
    events
        .map(|(index, time)| Event {
            time: header.since_first(60.0 * time[0] + time[1]),
            label: text(&labels, index),
            context: text(&contexts, index),
            subject: text(&subjects, index),
        })
        .collect()
}

/// The events of the header, which older programs write.
fn header_events(bytes: &[u8], processor: Processor, header: &Header) -> Vec<Event> {
    let word = |at: usize| {
        bytes
            .get(at..at + 2)
            .map_or(0, |word| processor.word([word[0], word[1]]))
    };
    let count = usize::from(word(HEADER_COUNT));
    if word(HEADER_MARK) != HAS_LABELS || count > HEADER_EVENTS {
        return Vec::new();
    }
    let event = |index: usize| {
        let time = bytes.get(HEADER_TIMES + 4 * index..)?.first_chunk::<4>()?;
        let label = bytes.get(HEADER_LABELS + 4 * index..)?.get(..4)?;
        Some(Event {
            time: header.since_first(processor.real(*time)),
            label: super::parameters::text(label),
            ..Event::default()
        })
    };
    (0..count).filter_map(event).collect()
}

/// The number of samples of each channel per frame, and the channels with the samples of all complete frames.
fn channels(
    bytes: &[u8],
    processor: Processor,
    header: &Header,
    parameters: &Parameters,
    frames: usize,
    warnings: &mut Warnings,
) -> (usize, Vec<AnalogChannel>) {
    // Some writers leave the parameter zero.
    let count = parameters
        .analog_channels()
        .filter(|count| *count > 0)
        .unwrap_or(header.samples);
    // A header may state thousands of channels, although the file ends before the samples.
    if header.samples == 0 || count == 0 || frames == 0 {
        return (0, Vec::new());
    }
    if !header.samples.is_multiple_of(count) {
        warnings.push(Code::HeaderCount, || {
            let message = "analog samples were skipped: every channel must have the same number of samples per frame";
            Diagnostic::new(Code::HeaderCount, message).expected_found(
                format!("a multiple of the {count} channels of ANALOG:USED in a frame"),
                format!("{} samples", header.samples),
            )
        });
        return (0, Vec::new());
    }
    let scaling = Scaling::of(parameters);
    let [labels, units] = ["LABELS", "UNITS"].map(|name| parameters.all_texts("ANALOG", name));
    let per_frame = header.samples / count;
    let mut channels: Vec<AnalogChannel> = (0..count)
        .map(|channel| AnalogChannel {
            name: match labels.get(channel) {
                Some(label) if !label.is_empty() => (*label).to_owned(),
                _ => format!("Analog_{}", channel + 1),
            },
            unit: units.get(channel).copied().unwrap_or_default().to_owned(),
            values: Vec::with_capacity(frames.saturating_mul(per_frame)),
        })
        .collect();
    let size = header.number_size();
    let data = bytes.get(header.data..).unwrap_or_default();
    for record in data.chunks_exact(header.record_size(header.samples)).take(frames) {
        let samples = record[4 * header.points * size..].chunks_exact(size);
        for (index, sample) in samples.enumerate() {
            let channel = index % count;
            let raw = scaling.raw(sample, processor);
            channels[channel].values.push(scaling.scaled(raw, channel));
        }
    }
    report_not_finite(&channels, warnings);
    (per_frame, channels)
}

fn report_not_finite(channels: &[AnalogChannel], warnings: &mut Warnings) {
    for channel in channels {
        let broken = channel.values.iter().filter(|value| !value.is_finite()).count();
        if broken > 0 {
            warnings.push(Code::NonFiniteValue, || {
                let message = format!(
                    "{broken} of {} samples of the analog channel \"{}\" are not finite",
                    channel.values.len(),
                    channel.name
                );
                Diagnostic::new(Code::NonFiniteValue, message).help("these samples are written as 0")
            });
        }
    }
}

/// Converts numbers of the file to values: subtracts the offset, and multiplies by the scale of the channel and the
/// common scale.
struct Scaling {
    is_unsigned: bool,
    general: f64,
    scales: Vec<f64>,
    offsets: Vec<f64>,
}

impl Scaling {
    fn of(parameters: &Parameters) -> Self {
        let is_unsigned = parameters
            .text("ANALOG", "FORMAT")
            .is_some_and(|format| format.eq_ignore_ascii_case("unsigned"));
        let mut offsets = parameters.all_numbers("ANALOG", "OFFSET");
        if is_unsigned {
            // The offsets are unsigned words, like the samples.
            offsets
                .iter_mut()
                .filter(|offset| **offset < 0.0)
                .for_each(|offset| *offset += 65_536.0);
        }
        Self {
            is_unsigned,
            general: parameters.number("ANALOG", "GEN_SCALE").unwrap_or(1.0),
            scales: parameters.all_numbers("ANALOG", "SCALE"),
            offsets,
        }
    }

    fn raw(&self, sample: &[u8], processor: Processor) -> f64 {
        match *sample {
            [a, b] if self.is_unsigned => f64::from(processor.word([a, b])),
            [a, b] => f64::from(processor.word([a, b]).cast_signed()),
            [a, b, c, d] => processor.real([a, b, c, d]),
            _ => 0.0,
        }
    }

    fn scaled(&self, raw: f64, channel: usize) -> f32 {
        let of = |values: &[f64], otherwise: f64| values.get(channel).copied().unwrap_or(otherwise);
        ((raw - of(&self.offsets, 0.0)) * of(&self.scales, 1.0) * self.general) as f32
    }
}

/// The force plates whose channels exist.
fn plates(
    parameters: &Parameters,
    header: &Header,
    channels: &[AnalogChannel],
    warnings: &mut Warnings,
) -> Vec<ForcePlate> {
    const GROUP: &str = "FORCE_PLATFORM";
    let used = parameters
        .number(GROUP, "USED")
        .map_or(0, |used| used.max(0.0) as usize);
    let metres = parameters
        .text("POINT", "UNITS")
        .and_then(points::metres)
        .unwrap_or(1.0);
    let (up, _) = scene::up_axis(parameters);
    let array = |name: &str, sizes: usize, plate: usize, least: usize| {
        let (values, stride) = parameters.array(GROUP, name, sizes)?;
        let own = values.get(plate * stride..)?.get(..stride)?;
        (stride >= least).then_some(own)
    };
    let plate = |plate: usize| {
        let plate_type = parameters.all_numbers(GROUP, "TYPE").get(plate).copied()? as u32;
        let corners = array("CORNERS", 2, plate, 12)?;
        let own: Vec<usize> = array("CHANNEL", 1, plate, 1)?
            .iter()
            // Channels count from 1. Plates with fewer channels have 0.
            .filter_map(|channel| (*channel as i64 as u16).checked_sub(1).map(usize::from))
            .collect();
        if corners.iter().any(|corner| !corner.is_finite()) || own.iter().any(|channel| *channel >= channels.len()) {
            return None;
        }
        let corner = |corner: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis| (corners[3 * corner + axis] * metres) as f32);
            to_y_up(Vec3::new(x, y, z), up)
        };
        Some(ForcePlate {
            plate_type,
            corners: [0, 1, 2, 3].map(corner),
            origin: array("ORIGIN", 1, plate, 3).map_or(DVec3::ZERO, DVec3::from_slice) * metres,
            scales: own
                .iter()
                .enumerate()
                .map(|(index, channel)| si(plate_type, index, &channels[*channel].unit, metres))
                .collect(),
            channels: own,
            calibration: array("CAL_MATRIX", 2, plate, 1)
                .and_then(|matrix| calibration(matrix, parameters.sizes(GROUP, "CAL_MATRIX"), plate_type, metres))
                .unwrap_or_default(),
            zero: zero(parameters.all_numbers(GROUP, "ZERO").as_slice()),
        })
    };
    // A plate has at least six channels of its own.
    let found: Vec<ForcePlate> = (0..used.min(channels.len() / 6)).filter_map(plate).collect();
    if found.len() < used {
        warnings.push(Code::HeaderCount, || {
            let message = format!("{} of {used} force plates were skipped", used - found.len());
            Diagnostic::new(Code::HeaderCount, message).expected_found(
                "for each force plate in FORCE_PLATFORM: a type, four finite corners, and channels that exist",
                format!("{} analog channels, {} samples a frame", channels.len(), header.samples),
            )
        });
    }
    found
}

/// The matrix by rows, with moments in newton metres. The file stores the matrix column by column. An array for plates
/// of several types has larger matrices than this plate needs.
fn calibration(matrix: &[f64], sizes: &[usize], plate_type: u32, metres: f64) -> Option<Vec<f64>> {
    let [rows, columns] = ForcePlate::calibration_size(plate_type)?;
    let &[stride, width, ..] = sizes else { return None };
    if stride < rows || width < columns {
        return None;
    }
    let is_moment = |row: usize| matches!(plate_type, 4 | 5) && row >= 3;
    let number = |index: usize| {
        let (row, column) = (index / columns, index % columns);
        matrix
            .get(stride * column + row)
            .map(|number| number * if is_moment(row) { metres } else { 1.0 })
    };
    (0..rows * columns).map(number).collect()
}

/// The first and the last frame of the baseline (the frames in which nobody is on the plate), counted from 0. C3D
/// counts from 1. A range from 0 means that the file states no baseline.
fn zero(range: &[f64]) -> Option<[usize; 2]> {
    match *range {
        [first, last, ..] if first >= 1.0 && last >= first => Some([first as usize - 1, last as usize - 1]),
        _ => None,
    }
}

/// The factor that converts a plate's channel to newtons, metres or newton metres. If no unit is stated, lengths are in
/// the unit of the points.
pub fn si(plate_type: u32, index: usize, unit: &str, metres: f64) -> f64 {
    let letters: String = unit
        .chars()
        .filter(|letter| letter.is_alphabetic())
        .flat_map(char::to_lowercase)
        .collect();
    let moment = || match letters.strip_prefix('n') {
        Some(length) => points::metres(length).unwrap_or(metres),
        None => metres,
    };
    match (plate_type, index) {
        (1, 3 | 4) => points::metres(&letters).unwrap_or(metres),
        (1, 5) | (2, 3..) => moment(),
        _ => 1.0,
    }
}
