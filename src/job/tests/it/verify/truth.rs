//! The truth matrix: each kind of corruption in each format, and changes that are no corruption, with both verdicts.
//!
//! `kinds` changes a scene before it is written, `planted` changes the bytes of a file. A kind that changes no byte of
//! a format is not in the matrix. `MOCAP_ALL=1 cargo test truth` tries all cells. With `MOCAP_WRITE=1` and `--features
//! parquet`, the test writes the table of `docs/verification-corruptions.md`.

mod kinds;
mod planted;

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use mocap::arrays::{ArrayOptions, Arrays};
use mocap::gltf::report::Provenance;
use mocap::job::Job;
use mocap::verify::Verifier;
use mocap::verify::report::Verification;
use mocap::{Conversion, Exporter, Importer, Scene, SkeletonMesh};
use serde_json::{Value, json};

use self::kinds::{KINDS, Kind};
use self::planted::{Files, Of, Plant, plants};
use crate::sample::{Sample, is_all};
use crate::{ROOT, cut};

/// The formats, and the names of files that another program wrote. Parquet needs its feature.
const FORMATS: &[&str] = &[
    "glb",
    "glb of another program",
    "gltf",
    "fbx",
    "bvh",
    "mclip",
    "vrma",
    "usda",
    "usdz",
    "trc",
    "npz",
    "csv",
    #[cfg(feature = "parquet")]
    "parquet",
];

const UP: &str = "Without a record, `mocap verify` infers the up axis. `--verify` knows the axis, and refuses.";
const UNIT: &str = "Neither source nor record states the unit. `--verify` knows the unit, and refuses.";
const END_SITE: &str = "Other programs omit end sites.";
const CHOICE: &str = "Arrays and markers may contain a selection of joints.";
const NO_ROTATIONS: &str = "Markers have only positions.";
const BONES: &str = "A VRM animation has VRM's bone names and hierarchy, and may omit bones that VRM does not require.";
const POSITIONS: &str = "The error bound of packed clips limits positions, and rotations that move no joint.";

/// Corruptions that cannot be found in the files alone, with the reason.
const MISSED: &[(&str, &str, &str)] = &[
    ("Z up for Y up", "glb of another program", UP),
    ("Z up for Y up", "bvh", UP),
    ("Z up for Y up", "mclip", UP),
    ("lying on the ground", "glb of another program", UP),
    ("lying on the ground", "bvh", UP),
    ("lying on the ground", "mclip", UP),
    ("an end site is missing", "glb of another program", END_SITE),
    ("an end site is missing", "bvh", END_SITE),
    ("an end site is missing", "mclip", END_SITE),
    ("Z up for Y up", "trc", UP),
    ("lying on the ground", "trc", UP),
    ("a forearm rolled, and its hand rolled back", "trc", NO_ROTATIONS),
    ("an end site is missing", "trc", CHOICE),
    ("an end site is missing", "npz", CHOICE),
    ("an end site is missing", "csv", CHOICE),
    ("an end site is missing", "parquet", CHOICE),
    ("a joint is missing", "npz", CHOICE),
    ("a joint is missing", "csv", CHOICE),
    ("a joint is missing", "parquet", CHOICE),
    ("a joint is missing", "vrma", BONES),
    ("a joint renamed", "vrma", BONES),
    ("another parent", "vrma", BONES),
    ("file: a joint renamed", "vrma", BONES),
    ("a forearm rolled, and its hand rolled back", "mclip", POSITIONS),
    ("units: another unit stated", "trc", UNIT),
];

/// Writes a scene to `path`, and returns the bytes of the file; none if the format cannot hold the scene.
fn written(scene: &Scene, path: &Path) -> Option<Vec<u8>> {
    let motion = || Arrays::of(scene, &ArrayOptions::new().velocities(true));
    let bytes = match path.extension()?.to_str()? {
        "npz" => Some(motion().ok()?.to_npz()),
        "csv" => Some(motion().ok()?.to_csv().into()),
        #[cfg(feature = "parquet")]
        "parquet" => motion().ok()?.to_parquet("walk").ok(),
        _ => {
            Exporter::new().overwrite(true).export(scene, path).ok()?;
            None
        }
    };
    if let Some(bytes) = bytes {
        std::fs::write(path, bytes).unwrap();
    }
    std::fs::read(path).ok()
}

/// A corruption in a format.
#[derive(Clone, Copy)]
enum Cell {
    Scene(&'static Kind, &'static str),
    File(&'static Plant, &'static str),
}

impl Cell {
    fn all() -> Vec<Self> {
        let formats = || FORMATS.iter().copied();
        let of_scene = KINDS
            .iter()
            .flat_map(|kind| formats().map(move |format| Self::Scene(kind, format)));
        let planted = plants().into_iter();
        let of_file = planted.flat_map(|plant| plant.formats.iter().map(move |format| Self::File(plant, format)));
        of_scene.chain(of_file).collect()
    }

    /// The row of the table.
    fn name(self) -> String {
        match self {
            Self::Scene(kind, _) => kind.name.to_owned(),
            Self::File(plant, _) => match plant.of {
                Of::Walk => plant.name.to_owned(),
                Of::Character => format!("character, {}", plant.name),
                Of::Onto => format!("retargeted character, {}", plant.name),
            },
        }
    }

    fn format(self) -> &'static str {
        match self {
            Self::Scene(_, format) | Self::File(_, format) => format,
        }
    }

    fn is_wrong(self) -> bool {
        match self {
            Self::Scene(kind, _) => kind.is_wrong,
            Self::File(..) => true,
        }
    }

    /// The reason why the corruption cannot be found from the files alone, if it cannot.
    fn reason(self) -> Option<&'static str> {
        let missed = MISSED
            .iter()
            .find(|(name, format, _)| *name == self.name() && *format == self.format());
        missed.map(|(_, _, reason)| *reason)
    }
}

/// The sources, and their outputs.
struct Bench {
    folder: tempfile::TempDir,
    scene: Scene,
    /// The files of each source and format.
    right: RefCell<HashMap<(Of, &'static str), Files>>,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let walk = folder.path().join("walk.bvh");
        std::fs::copy(format!("{ROOT}/fixtures/real/cmu_short.bvh"), &walk).unwrap();
        std::fs::write(
            folder.path().join("short.bvh"),
            cut::first_frames("real/cmu_short.bvh", 12),
        )
        .unwrap();
        std::fs::write(folder.path().join("character.gltf"), character().to_string()).unwrap();
        let mut scene = Importer::new()
            .skeleton_mesh(SkeletonMesh::Skinned)
            .import(&walk)
            .unwrap();
        Conversion::new().apply(&mut scene).unwrap();
        Self {
            folder,
            scene,
            right: RefCell::default(),
        }
    }

    fn source(&self, of: Of) -> PathBuf {
        match of {
            Of::Walk => self.folder.path().join("walk.bvh"),
            Of::Character => self.folder.path().join("character.gltf"),
            Of::Onto => format!("{ROOT}/fixtures/characters/human_vrm0.vrm").into(),
        }
    }

    /// The files of an uncorrupted output, which `verify` accepts.
    fn right(&self, of: Of, format: &'static str) -> Files {
        if let Some(known) = self.right.borrow().get(&(of, format)) {
            return known.clone();
        }
        let folder = tempfile::tempdir().unwrap();
        let name = format!("out.{format}");
        let output = folder.path().join(&name);
        let short = self.folder.path().join("short.bvh");
        match of {
            Of::Walk => drop(written(&self.scene, &output).unwrap()),
            Of::Character => run(&json!({"source": {"inputs": [self.source(of)]}, "write": {"output": output}})),
            Of::Onto => run(&json!({
                "source": {"inputs": [short]},
                "target": {"character": {"file": self.source(of)}},
                "write": {"output": output},
            })),
        }
        let files = Files::of(folder.path(), &name);
        let verdict = self.verdict(&files, of, false);
        assert!(is_right(&verdict), "{of:?} as {format}: {verdict:?}");
        self.right.borrow_mut().insert((of, format), files.clone());
        files
    }

    /// The verdict of `verify` about files: with the job's steps, as `--verify`, or from the files alone.
    fn verdict(&self, files: &Files, of: Of, knows_steps: bool) -> mocap::Result<Verification> {
        let folder = tempfile::tempdir().unwrap();
        files.write(folder.path());
        let verifier = match knows_steps {
            true => Verifier::new().provenance(Provenance::of(&self.scene)),
            false => Verifier::new(),
        };
        verifier.files(self.source(of), folder.path().join(&files.main))
    }

    /// The files of a cell; `None` if the format has nothing of this kind.
    fn corrupted(&self, cell: Cell) -> Option<(Files, Of)> {
        match cell {
            Cell::File(plant, format) => {
                let mut files = self.right(plant.of, format);
                let right = files.clone();
                let is_there = (plant.plant)(&mut files);
                assert!(
                    !is_there || files != right,
                    "{} changes nothing of {format}",
                    cell.name()
                );
                is_there.then_some((files, plant.of))
            }
            Cell::Scene(kind, format) => {
                let extension = format.split(' ').next().unwrap();
                let right = self.right(Of::Walk, extension);
                let mut changed = self.scene.clone();
                (kind.change)(&mut changed);
                let folder = tempfile::tempdir().unwrap();
                written(&changed, &folder.path().join(&right.main))?;
                let mut files = Files::of(folder.path(), &right.main);
                if kind.is_wrong && files == right {
                    return None;
                }
                if format.ends_with("program") {
                    let bytes = files.all.get_mut(&right.main).unwrap();
                    let name = b"\"mocap\"";
                    let place = bytes.windows(name.len()).position(|window| window == name).unwrap();
                    bytes[place..place + name.len()].copy_from_slice(b"\"other\"");
                }
                Some((files, Of::Walk))
            }
        }
    }
}

fn is_right(verdict: &mocap::Result<Verification>) -> bool {
    verdict.as_ref().is_ok_and(|verified| verified.is_within(1e-3))
}

fn run(job: &Value) {
    Job::from_json(&job.to_string()).unwrap().run().unwrap();
}

/// A character of two bones with a texture, a morph target and two clips.
fn character() -> Value {
    let text = std::fs::read_to_string(format!("{ROOT}/fixtures/made/two_bones_textured.gltf")).unwrap();
    let mut file: Value = serde_json::from_str(&text).unwrap();
    file["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
    file["meshes"][0]["weights"] = json!([0.0]);
    let mut second = file["animations"][0].clone();
    second["name"] = "bow".into();
    second["channels"][0]["target"]["node"] = 0.into();
    file["animations"].as_array_mut().unwrap().push(second);
    file
}

#[test]
fn every_corruption_is_found_in_every_format_and_nothing_else() {
    let bench = Bench::new();
    let mut wrong = Vec::new();
    let mut table: BTreeMap<(usize, String), BTreeMap<&str, String>> = BTreeMap::new();
    let cells = Cell::all();
    let names: Vec<String> = cells.iter().map(|cell| cell.name()).collect();
    for cell in Sample::new().some(cells, 16) {
        let Some((files, of)) = bench.corrupted(cell) else {
            continue;
        };
        let (name, format, reason) = (cell.name(), cell.format(), cell.reason());
        let verdict = bench.verdict(&files, of, false);
        let should_pass = !cell.is_wrong() || reason.is_some();
        // If the steps of the job show a defect, `--verify` finds it.
        let is_told = reason.is_some_and(|reason| reason.contains("--verify")) && !format.ends_with("program");
        let is_told_wrong = is_told && is_right(&bench.verdict(&files, of, true));
        if is_right(&verdict) != should_pass || is_told_wrong {
            let verdict = verdict.map(|found| {
                let Verification {
                    max_error,
                    rotation_error,
                    findings,
                    metres_per_unit,
                    ..
                } = found;
                (max_error, rotation_error, findings, metres_per_unit)
            });
            wrong.push(format!("{name}, {format}: {verdict:?}"));
        }
        if cell.is_wrong() {
            let place = names.iter().position(|other| *other == name).unwrap();
            let shown = reason.map_or(REFUSED.to_owned(), |reason| {
                format!("{ACCEPTED} ({})", footnote(reason))
            });
            table.entry((place, name)).or_default().insert(format, shown);
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
    check_page(&table);
}

/// The number of a reason on the page.
fn footnote(reason: &str) -> usize {
    let mut all: Vec<&str> = Vec::new();
    for (_, _, reason) in MISSED {
        if !all.contains(reason) {
            all.push(reason);
        }
    }
    all.iter().position(|known| *known == reason).unwrap() + 1
}

/// A row of the page: the formats that reject a corruption, and the formats that accept it.
fn row(name: &str, cells: &BTreeMap<&str, String>) -> String {
    let is_refused = |format: &&str| cells.get(format).is_some_and(|cell| cell == REFUSED);
    let refused: Vec<&str> = FORMATS.iter().copied().filter(is_refused).collect();
    let others: Vec<&str> = FORMATS.iter().copied().filter(|format| !is_refused(format)).collect();
    let refused = match (others.len(), refused.len()) {
        (0, _) => EVERY.to_owned(),
        (few, most) if few < most => format!("{EVERY}{BUT}{}", others.join(", ")),
        _ => refused.join(", "),
    };
    let accepted = FORMATS.iter().filter_map(|format| {
        let number = cells.get(format)?.strip_prefix(ACCEPTED)?;
        Some(format!("{format}{number}"))
    });
    let accepted: Vec<String> = accepted.collect();
    format!("| {name} | {refused} | {} |\n", accepted.join(", ")).replace("|  |", "| |")
}

const REFUSED: &str = "refused";
const ACCEPTED: &str = "accepted";
const EVERY: &str = "every format";
const BUT: &str = " but ";

/// The statement of a row of the page about a format.
fn stated(line: &str, format: &str) -> String {
    let cells: Vec<&str> = line.split('|').map(str::trim).collect();
    let [_, _, refused, accepted, _] = cells[..] else {
        return String::new();
    };
    let number = accepted
        .split(", ")
        .find_map(|one| one.strip_prefix(format)?.strip_prefix(" ("));
    if let Some(number) = number {
        return format!("{ACCEPTED} ({number}");
    }
    let is_listed = |list: &str| list.split(", ").any(|one| one == format);
    let is_refused = match refused.strip_prefix(EVERY) {
        Some(others) => !others.strip_prefix(BUT).is_some_and(is_listed),
        None => is_listed(refused),
    };
    if is_refused { REFUSED.to_owned() } else { String::new() }
}

/// Compares the table of the page with the results, or writes the table.
fn check_page(table: &BTreeMap<(usize, String), BTreeMap<&str, String>>) {
    let path = format!("{ROOT}/docs/verification-corruptions.md");
    let (start, end) = ("<!-- planted corruptions -->\n", "<!-- end of planted corruptions -->");
    let text = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once(start).unwrap();
    let (page, after) = rest.split_once(end).unwrap();
    if is_all() && cfg!(feature = "parquet") {
        let cells = || table.values().flat_map(BTreeMap::values);
        let (all, accepted) = (
            cells().count(),
            cells().filter(|cell| cell.starts_with(ACCEPTED)).count(),
        );
        let mut made = format!(
            "{all} corruptions: {} refused, {accepted} accepted, each for a reason below.\n\n",
            all - accepted
        );
        made += "| corruption | refused in | accepted in |\n|---|---|---|\n";
        table.iter().for_each(|((_, name), cells)| made += &row(name, cells));
        made += "\n";
        let mut reasons: Vec<&str> = MISSED.iter().map(|(_, _, reason)| *reason).collect();
        reasons.sort_by_key(|reason| footnote(reason));
        reasons.dedup();
        for reason in reasons {
            let _ = writeln!(made, "{}. {reason}", footnote(reason));
        }
        let whole = format!("{before}{start}{made}{end}{after}");
        if std::env::var_os("MOCAP_WRITE").is_some() {
            std::fs::write(&path, whole).unwrap();
            return;
        }
        assert!(
            text == whole,
            "MOCAP_ALL=1 MOCAP_WRITE=1 cargo test -p mocap-job --features parquet --test it truth writes it"
        );
        return;
    }
    for ((_, name), cells) in table {
        let line = page.lines().find(|line| line.starts_with(&format!("| {name} |")));
        for (format, found) in cells {
            let stated = stated(line.unwrap_or_default(), format);
            assert_eq!(stated, *found, "{name}, {format}: {path}");
        }
    }
}

#[test]
fn a_row_of_the_page_states_each_cell() {
    let mut cells: BTreeMap<&str, String> = FORMATS.iter().map(|format| (*format, REFUSED.to_owned())).collect();
    let holds = |cells: &BTreeMap<&str, String>, row: &str| {
        assert!(row.starts_with("| a drift | "), "{row}");
        for format in FORMATS {
            let cell = cells.get(format).map_or("", String::as_str);
            assert_eq!(stated(row.trim_end(), format), cell, "{format}: {row}");
        }
    };
    holds(&cells, &row("a drift", &cells));
    cells.insert("bvh", format!("{ACCEPTED} (3)"));
    cells.insert("glb", format!("{ACCEPTED} (12)"));
    cells.remove("gltf");
    holds(&cells, &row("a drift", &cells));
    cells.retain(|format, _| ["glb of another program", "bvh", "csv"].contains(format));
    holds(&cells, &row("a drift", &cells));
}

/// Complete files are accepted in every written format. Truncated files are rejected, even if only the last row is
/// missing.
#[test]
fn a_file_that_was_cut_off_is_refused_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("walk.bvh");
    std::fs::write(&source, crate::cut::first_frames("real/cmu_short.bvh", 12)).unwrap();
    let mut scene = mocap::import(&source).unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    for extension in FORMATS.iter().filter(|format| !format.contains(' ')) {
        let path = folder.path().join(format!("out.{extension}"));
        let bytes = written(&scene, &path).unwrap();
        for length in [
            bytes.len(),
            bytes.len() - 20,
            bytes.len() * 2 / 3,
            bytes.len() / 9,
            3,
            0,
        ] {
            std::fs::write(&path, &bytes[..length]).unwrap();
            let verdict = Verifier::new().files(&source, &path);
            let passes = verdict.as_ref().is_ok_and(|verified| verified.is_within(1e-3));
            let of = bytes.len();
            assert_eq!(passes, length == of, "{extension}, {length} bytes of {of}: {verdict:?}");
        }
    }
}
