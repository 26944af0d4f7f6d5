//! The card of a dataset, `README.md`: metadata as YAML, then Markdown.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use arrow_schema::{DataType, Schema};
use mocap_scene::report::counted;
use mocap_scene::scene::report::Attribution;

use super::{DatasetClip, DatasetWriter};
use crate::arrays::{ArrayOptions, Rotation, RotationSpace, Space};

/// The largest number of rows of a table on the card. The columns of the dataset have the omitted values.
const MOST_ROWS: usize = 50;

/// The size categories of Hugging Face, each with a number: a dataset of the category has fewer rows than this number.
const SIZES: &[(usize, &str)] = &[
    (1_000, "n<1K"),
    (10_000, "1K<n<10K"),
    (100_000, "10K<n<100K"),
    (1_000_000, "100K<n<1M"),
    (10_000_000, "1M<n<10M"),
    (100_000_000, "10M<n<100M"),
    (usize::MAX, "100M<n<1B"),
];

pub(super) fn text(dataset: &DatasetWriter) -> String {
    let name = dataset.folder.file_name().unwrap_or_default().to_string_lossy();
    let mut text = String::from("---\n");
    // Writing to a string cannot fail.
    let _ = metadata(&mut text, dataset, &name)
        .and_then(|()| beginning(&mut text, dataset, &name))
        .and_then(|()| columns(&mut text, dataset))
        .and_then(|()| statistics(&mut text, dataset))
        .and_then(|()| sources(&mut text, dataset));
    text
}

/// The metadata at the start of the card, for programs: YAML. Its strings are written as JSON, which is valid YAML.
fn metadata(out: &mut String, dataset: &DatasetWriter, name: &str) -> std::fmt::Result {
    let size = SIZES
        .iter()
        .find(|(rows, _)| dataset.rows < *rows)
        .map_or("n>1T", |row| row.1);
    writeln!(out, "pretty_name: {}", quoted(name))?;
    writeln!(out, "license: {}", dataset.license().as_deref().unwrap_or("unknown"))?;
    writeln!(out, "task_categories:\n- other")?;
    writeln!(out, "tags:\n- motion-capture\n- human-motion\n- animation\n- mocap")?;
    writeln!(out, "size_categories:\n- {size}")?;
    writeln!(out, "configs:\n- config_name: default\n  data_files:")?;
    writeln!(out, "  - split: train\n    path: data/train-*")?;
    writeln!(out, "dataset_info:\n  features:")?;
    for field in fields(dataset) {
        writeln!(out, "  - name: {}", field.name())?;
        feature(out, field.data_type(), "    ")?;
    }
    writeln!(out, "  splits:\n  - name: train")?;
    writeln!(
        out,
        "    num_bytes: {}\n    num_examples: {}",
        dataset.bytes, dataset.rows
    )?;
    writeln!(
        out,
        "  download_size: {}\n  dataset_size: {}",
        dataset.file_bytes, dataset.bytes
    )?;
    writeln!(out, "---\n")
}

fn fields(dataset: &DatasetWriter) -> impl Iterator<Item = &arrow_schema::Field> {
    let fields = dataset.schema.as_deref().map(Schema::fields);
    fields.into_iter().flatten().map(|field| &**field)
}

/// The type of a column, in a notation that all versions of `datasets` read.
fn feature(out: &mut String, kind: &DataType, indent: &str) -> std::fmt::Result {
    match kind {
        DataType::List(item) => match item.data_type() {
            DataType::FixedSizeList(number, length) => {
                let number = number.data_type();
                writeln!(out, "{indent}sequence:\n{indent}  sequence: {}", plain(number))?;
                writeln!(out, "{indent}  length: {length}")
            }
            item => writeln!(out, "{indent}sequence: {}", plain(item)),
        },
        kind => writeln!(out, "{indent}dtype: {}", plain(kind)),
    }
}

fn plain(kind: &DataType) -> &'static str {
    match kind {
        DataType::Int32 => "int32",
        DataType::Float32 => "float32",
        DataType::Float64 => "float64",
        DataType::Boolean => "bool",
        _ => "string",
    }
}

fn beginning(out: &mut String, dataset: &DatasetWriter, name: &str) -> std::fmt::Result {
    let clips = &dataset.clips;
    let seconds: f64 = clips.iter().map(DatasetClip::seconds).sum();
    writeln!(out, "# {}\n", cell(name))?;
    writeln!(out, "{} motion clips, {}.\n", clips.len(), duration(seconds))?;
    writeln!(out, "```python\nfrom datasets import load_dataset\n")?;
    writeln!(
        out,
        "dataset = load_dataset(\"PATH OR USER/NAME\", split=\"train\").with_format(\"numpy\")"
    )?;
    writeln!(out, "row = dataset[0]")?;
    if fields(dataset).any(|field| field.name() == "positions") {
        writeln!(
            out,
            "positions = row[\"positions\"].reshape(row[\"frames\"], row[\"joints\"], 3)"
        )?;
    }
    writeln!(out, "```\n")
}

/// The meaning of each column, with its unit.
fn columns(out: &mut String, dataset: &DatasetWriter) -> std::fmt::Result {
    let options = &dataset.options;
    let unit = unit(options);
    let up = match options.out_up.unwrap_or_default().as_str() {
        axis if axis.starts_with('-') => axis.to_uppercase(),
        axis => format!("+{}", axis.to_uppercase()),
    };
    let about = match options.space {
        Space::World => "the world",
        Space::Root => "the root joint in the same frame, along the axes of the world",
        Space::Local => "the parent, along its axes",
    };
    let parent = match options.rotation_space {
        RotationSpace::Local => "the parent; for a joint without a parent, the world",
        RotationSpace::World => "the world",
    };
    writeln!(
        out,
        "## Columns\n\n| column | type | unit | meaning |\n|---|---|---|---|"
    )?;
    for field in fields(dataset) {
        let (unit, meaning) = match field.name().as_str() {
            "clip" => ("", "path of the file below the folder that was packed"),
            "skeleton" => ("", "hash of names, parents and offsets of the joints"),
            "frames" => ("", "number of frames"),
            "joints" => ("", "number of joints"),
            "frame_rate" => ("1/s", "frames per second"),
            "names" => ("", "of the joints"),
            "parents" => ("", "index of the parent of each joint; -1 without one"),
            "offsets" => (unit.as_str(), "position of each joint relative to its parent, at rest"),
            "positions" => (unit.as_str(), "frame by frame, joint by joint"),
            "velocities" => (unit.as_str(), "per second; frame by frame, joint by joint"),
            "contacts" => ("", "whether a foot is in contact; frame by frame, joint by joint"),
            "header" => (
                "",
                "JSON: joints, rotation orders, SHA-256 of the file, guesses and changes",
            ),
            "frame" => ("", "number of the frame, from 0"),
            "time" => ("s", "from the first frame"),
            "joint" => ("", "name of the joint"),
            "x" | "y" | "z" => (unit.as_str(), "position"),
            "vx" | "vy" | "vz" => (unit.as_str(), "velocity, per second"),
            "contact" => ("", "whether a foot is in contact"),
            // `rotations`, or the columns of a rotation.
            _ if options.rotation == Rotation::Euler => ("degree", "rotation"),
            _ => ("", "rotation"),
        };
        writeln!(
            out,
            "| `{}` | {} | {unit} | {meaning} |",
            field.name(),
            type_of(field.data_type())
        )?;
    }
    let rotation = match options.rotation {
        Rotation::Quaternion => "unit quaternions x, y, z, w",
        Rotation::SixD => "the first column of the rotation matrix, then the second",
        Rotation::Matrix => "rotation matrices that map column vectors, row by row",
        Rotation::Euler => "angles about x, y and z in degrees, in the rotation order of the joint (`header`)",
    };
    writeln!(out, "\nCoordinates are right-handed, with {up} up.")?;
    writeln!(out, "Lengths are in {unit}. Positions are relative to {about}.")?;
    writeln!(out, "Rotations are {rotation}, relative to {parent}.")?;
    writeln!(
        out,
        "If a file does not state its unit or up axis, mocap infers it; `header` has the reason.\n"
    )
}

fn type_of(kind: &DataType) -> String {
    match kind {
        DataType::List(item) => format!("list of {}", type_of(item.data_type())),
        DataType::FixedSizeList(item, length) => format!("{length} x {}", type_of(item.data_type())),
        kind => plain(kind).to_owned(),
    }
}

fn unit(options: &ArrayOptions) -> String {
    match options.out_metres_per_unit {
        None => "unit of the file".to_owned(),
        Some(1.0) => "m".to_owned(),
        Some(0.01) => "cm".to_owned(),
        Some(0.001) => "mm".to_owned(),
        Some(metres) => format!("{metres} m"),
    }
}

fn statistics(out: &mut String, dataset: &DatasetWriter) -> std::fmt::Result {
    let clips = &dataset.clips;
    let sorted = |value: &dyn Fn(&DatasetClip) -> f64| {
        let mut values: Vec<f64> = clips.iter().map(value).collect();
        values.sort_unstable_by(f64::total_cmp);
        let at = |part: usize| {
            values
                .get((values.len().max(1) - 1) * part / 2)
                .copied()
                .unwrap_or_default()
        };
        [at(0), at(1), at(2)]
    };
    let skeletons: BTreeMap<&str, (usize, usize, f64)> = clips.iter().fold(BTreeMap::new(), |mut all, clip| {
        let found = all.entry(clip.skeleton.as_str()).or_insert((clip.joints, 0, 0.0));
        (found.1, found.2) = (found.1 + 1, found.2 + clip.seconds());
        all
    });
    writeln!(out, "## Statistics\n")?;
    writeln!(
        out,
        "| clips | frames | duration | skeletons | rows | files |\n|---|---|---|---|---|---|"
    )?;
    let frames: usize = clips.iter().map(|clip| clip.frames).sum();
    let total = duration(clips.iter().map(DatasetClip::seconds).sum());
    let counts = [clips.len(), frames, skeletons.len(), dataset.rows, dataset.shards];
    let [clip_count, frames, skeleton_count, rows, files] = counts;
    writeln!(
        out,
        "| {clip_count} | {frames} | {total} | {skeleton_count} | {rows} | {files} |\n"
    )?;
    writeln!(out, "| of a clip | least | median | most |\n|---|---|---|---|")?;
    let seconds = sorted(&DatasetClip::seconds).map(|value| format!("{value:.2}"));
    writeln!(out, "| seconds | {} |", seconds.join(" | "))?;
    let whole = |value: &dyn Fn(&DatasetClip) -> f64| sorted(value).map(|value| format!("{value}")).join(" | ");
    writeln!(out, "| frames | {} |", whole(&|clip| clip.frames as f64))?;
    writeln!(out, "| joints | {} |", whole(&|clip| clip.joints as f64))?;
    let rates = sorted(&|clip| clip.frame_rate).map(|value| format!("{}", (value * 1e3).round() / 1e3));
    writeln!(out, "| frames per second | {} |\n", rates.join(" | "))?;
    writeln!(out, "| skeleton | joints | clips | duration |\n|---|---|---|---|")?;
    let mut listed: Vec<_> = skeletons.into_iter().collect();
    listed.sort_by(|a, b| b.1.1.cmp(&a.1.1).then(a.0.cmp(b.0)));
    for (hash, (joints, count, seconds)) in listed.iter().take(MOST_ROWS) {
        writeln!(
            out,
            "| `{}` | {joints} | {count} | {} |",
            &hash[..12],
            duration(*seconds)
        )?;
    }
    more(out, listed.len())
}

fn sources(out: &mut String, dataset: &DatasetWriter) -> std::fmt::Result {
    let mut folders: BTreeMap<&str, Vec<&DatasetClip>> = BTreeMap::new();
    for clip in &dataset.clips {
        folders.entry(clip.source()).or_default().push(clip);
    }
    let has_licences = dataset.clips.iter().any(|clip| clip.attribution.licence.is_some());
    writeln!(out, "## Sources and licences\n")?;
    match &dataset.license {
        Some(license) => writeln!(
            out,
            "The packer states that the clips are under the licence `{license}`."
        )?,
        None if has_licences => writeln!(out, "The table has the licences that the clips or their folders state.")?,
        None => writeln!(
            out,
            "The packer stated no licence. Ask the sources before you use the clips, and set `license` above."
        )?,
    }
    writeln!(out, "`header` has the SHA-256 of each file.\n")?;
    writeln!(
        out,
        "| folder | clips | duration | licences | sources | persons | licence files |\n|---|---|---|---|---|---|---|"
    )?;
    for (folder, clips) in folders.iter().take(MOST_ROWS) {
        let is_of = |below: &&String| below.is_empty() || below.split('/').next() == Some(*folder);
        let found = dataset.licenses.iter().filter(|(below, _)| is_of(below));
        let files: BTreeSet<&str> = found.flat_map(|(_, files)| files).map(String::as_str).collect();
        let links = files
            .iter()
            .map(|file| format!("[{}](<{}>)", cell(file), address(file)));
        let links = links.collect::<Vec<_>>().join(", ");
        let name = if folder.is_empty() {
            ".".to_owned()
        } else {
            cell(folder)
        };
        let seconds: f64 = clips.iter().map(|clip| clip.seconds()).sum();
        let licences = stated(clips, |attribution| &attribution.licence);
        let sources = stated(clips, |attribution| &attribution.source);
        let persons = stated(clips, |attribution| &attribution.person);
        writeln!(
            out,
            "| {name} | {} | {} | {licences} | {sources} | {persons} | {links} |",
            clips.len(),
            duration(seconds)
        )?;
    }
    more(out, folders.len())?;
    if !dataset.failed.is_empty() {
        writeln!(out, "## Files that could not be read\n\n| file | reason |\n|---|---|")?;
        for (file, error) in dataset.failed.iter().take(MOST_ROWS) {
            writeln!(out, "| {} | {} |", cell(file), cell(error))?;
        }
        more(out, dataset.failed.len())?;
    }
    let version = env!("CARGO_PKG_VERSION");
    writeln!(out, "Packed with mocap {version}.")
}

/// The different values that clips state. If some clips state a value, also the number of clips that state none.
fn stated(clips: &[&DatasetClip], of: impl Fn(&Attribution) -> &Option<String>) -> String {
    /// The most values in a cell.
    const MOST: usize = 10;
    let stated = || clips.iter().filter_map(|clip| of(&clip.attribution).as_deref());
    let values: BTreeSet<&str> = stated().collect();
    let mut cells: Vec<String> = values.iter().take(MOST).map(|value| cell(value)).collect();
    if values.len() > MOST {
        cells.push(format!("{} more", values.len() - MOST));
    }
    match clips.len() - stated().count() {
        without if without > 0 && !cells.is_empty() => cells.push(format!("not stated: {}", counted(without, "clip"))),
        _ => {}
    }
    cells.join(", ")
}

/// Ends a table with the number of omitted rows.
fn more(out: &mut String, rows: usize) -> std::fmt::Result {
    match rows.checked_sub(MOST_ROWS) {
        Some(rest) if rest > 0 => writeln!(out, "\n{rest} more.\n"),
        _ => writeln!(out),
    }
}

fn duration(seconds: f64) -> String {
    match seconds {
        ..60.0 => format!("{seconds:.1} s"),
        ..3600.0 => format!("{:.1} min", seconds / 60.0),
        _ => format!("{:.2} h", seconds / 3600.0),
    }
}

/// The path of a file as a URL between `<` and `>`.
fn address(path: &str) -> String {
    let escaped = |c: char| c.is_control() || "<>%\\".contains(c);
    path.chars()
        .map(|c| {
            if escaped(c) {
                format!("%{:02X}", u32::from(c))
            } else {
                c.to_string()
            }
        })
        .collect()
}

fn quoted(text: &str) -> String {
    serde_json::to_string(text).unwrap_or_default()
}

/// A string from a file in a Markdown table, escaped to plain text.
fn cell(text: &str) -> String {
    let mut cell = String::new();
    for c in text.chars() {
        match c {
            c if c.is_control() => cell.push(' '),
            c if r"\`*_[]<>|#&".contains(c) => {
                cell.push('\\');
                cell.push(c);
            }
            c => cell.push(c),
        }
    }
    cell
}
