//! Tests of allowed changes: every option of a job that writes a motion, alone and in pairs, in every written format.
//! `verify` accepts each output. A motion on another body is compared with this body. The options and their values come
//! from the schema of jobs, so a new option is tried or needs values here. `docs/verification.md` has the table.
//!
//! A sample of the pairs is tried. `MOCAP_ALL=1` tries each pair in one format and each option alone in every format.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::Path;

use mocap::edit::EditStep;
use mocap::job::{Job, Maker, MotionJob};
use mocap::scene::Animation;
use mocap::{Code, Exporter, FormatInfo, Importer, SkeletonMesh};
use serde_json::{Value, json};

use crate::sample::{Sample, is_all};
use crate::{ROOT, cut};

/// Parts of the schema that are no option of a motion.
const NO_OPTIONS: [&str; 6] = [
    // Input files, and options that only decide the verdict.
    "source.inputs",
    "source.with",
    "write.force",
    "write.output",
    "write.to",
    "verify",
];

/// Values of options whose schema does not list them, and the source that an option needs.
const VALUES: &[(&str, &str, &str)] = &[
    ("target.character.file", r#""human.gltf""#, ""),
    ("target.character.file", r#""vrm1.gltf""#, ""),
    ("target.character.map", r#"{"head": null}"#, ""),
    ("target.character.max-angle", "90", ""),
    ("target.character.names-of-clips", r#"["gait"]"#, ""),
    ("target.character.scale", r#""none""#, ""),
    ("target.character.scale", "0.5", ""),
    ("target.robot.file", r#""h1.urdf""#, ""),
    ("target.robot.file", r#""h1.xml""#, ""),
    ("target.robot.map", r#"{"head": null}"#, ""),
    ("target.robot.names-of-clips", r#"["gait"]"#, ""),
    ("target.robot.passes", "1", ""),
    ("target.robot.scale", r#""none""#, ""),
    ("target.robot.scale", "0.5", ""),
    ("target.robot.time-scale", r#""auto""#, ""),
    ("target.robot.time-scale", "0.5", ""),
    ("target.skeleton.file", r#""human.gltf""#, ""),
    ("target.skeleton.file", r#""run.bvh""#, ""),
    ("target.skeleton.map", r#"{"head": null}"#, ""),
    ("target.skeleton.max-angle", "90", ""),
    ("target.skeleton.names-of-clips", r#"["gait"]"#, ""),
    ("target.skeleton.scale", r#""none""#, ""),
    ("target.skeleton.scale", "0.5", ""),
    ("weights.clean.smoothing", "1.0", ""),
    ("weights.foot-lock.acceleration-ratio", "0.2", ""),
    ("weights.markers.slide", "0.02", ""),
    ("weights.robot.hand", "1.0", ""),
    ("read.body", r#""body_smplh.npz""#, "amass.npz"),
    ("read.clip", "1", "two.glb"),
    ("read.clip", r#""slow""#, "two.glb"),
    ("read.from", r#""bvh""#, "walk.bvh"),
    ("read.joints", r#""smpl22""#, "points.npy"),
    ("read.lengths", "", "points.npy"),
    ("read.markers", r#""auto""#, "body.trc"),
    ("read.retime", "25", ""),
    ("read.retime", "59.94", ""),
    ("read.skeleton", r#""tiny.asf""#, "tiny.amc"),
    ("read.static", r#""body.trc""#, "body.trc"),
    ("source.frames.fps", "24", ""),
    ("source.frames.fps", "29.97", ""),
    ("source.frames.fps", "30", ""),
    ("source.frames.fps", "100", ""),
    ("source.frames.fps", "240", ""),
    ("source.frames.rest", r#""t-pose""#, ""),
    ("source.frames.rest", r#""a-pose""#, ""),
    ("source.frames.rest", r#""frame:3""#, ""),
    ("source.frames.trim", r#""3f..11f""#, ""),
    ("source.frames.trim", r#""0.02..0.07""#, ""),
    ("source.map", r#"{"head": null}"#, ""),
    ("source.space.unit", r#""inch""#, ""),
    ("source.space.unit", "0.02", ""),
    ("source.space.up", r#""y""#, ""),
    ("source.space.up", r#""-y""#, ""),
    ("source.space.up", r#""z""#, ""),
    ("source.space.up", r#""-z""#, ""),
    // Joints other than the root lose the motion of their positions, as the documentation of this option says.
    ("write.bvh.channels", "", "walk.bvh"),
    ("write.bvh.digits", "5", ""),
    ("write.names", r#""mixamo""#, ""),
    ("write.names", r#""unreal""#, ""),
    ("write.names", r#"{"head": "Kopf"}"#, ""),
    ("write.smaller.max-error", r#""0.1mm""#, ""),
    ("write.smaller.max-error", r#""1mm""#, ""),
    ("write.smaller.max-error", r#""1cm""#, ""),
    ("write.smaller.shell-distance", r#""3cm""#, ""),
    ("write.space.out-unit", r#""cm""#, ""),
    ("write.space.out-unit", r#""inch""#, ""),
    ("steps", "loop:frames=2..9", ""),
    ("steps", "smooth:part=arms,range=0.02..0.08", ""),
    ("steps", "in-between:every=5", ""),
    ("steps", "trim:range=0..0.07", ""),
    ("steps", "resample:rate=30", ""),
    ("steps", "resample:rate=200", ""),
    ("steps", "reach:limb=left-hand,to=head,range=0.02..0.08", ""),
    ("steps", "pin:to=hips,range=0.02..0.08", ""),
];

/// The default target bodies. A choice uses a default body if its option belongs to a target and names no body.
const BODIES: [(&str, &str); 3] = [
    ("character", "human.gltf"),
    ("skeleton", "run.bvh"),
    ("robot", "h1.urdf"),
];

/// Motions of any skeleton. Each pair uses one of these motions. The first motions are of humanoids.
const SOURCES: [&str; 8] = [
    "walk.bvh",
    "dance.bvh",
    "zup.bvh",
    "jump.bvh",
    "two.glb",
    "arm.fbx",
    "arm.usda",
    "take.c3d",
];

const HUMANOIDS: usize = 4;

/// The number of frames in a motion.
const FRAMES: usize = 16;

/// One value of an option.
#[derive(Clone)]
struct Choice {
    option: String,
    value: Value,
    /// The only source with this option; empty if every source has it.
    source: String,
}

impl Choice {
    /// The kind of target that the option belongs to, if it is an option of a target.
    fn body(&self) -> Option<&str> {
        self.option.strip_prefix("target.")?.split('.').next()
    }
}

/// The outcome of an output.
#[derive(Clone, Debug)]
enum Verdict {
    /// `verify` accepts it.
    Accepted,
    /// Nothing was written, or the output cannot be compared.
    Refused,
    /// `verify` rejects the output.
    FalseAlarm(String),
}

/// A definition of the schema, with references resolved and without `null`.
fn resolved<'a>(schema: &'a Value, mut value: &'a Value) -> &'a Value {
    loop {
        let list = value["anyOf"].as_array();
        let others = list.map(|list| list.iter().filter(|item| item["type"] != "null").collect::<Vec<_>>());
        if let Some(name) = value["$ref"].as_str() {
            value = &schema["$defs"][name.trim_start_matches("#/$defs/")];
        } else if let Some([only]) = others.as_deref() {
            value = only;
        } else {
            return value;
        }
    }
}

/// The options with the values that the schema lists; no values if the schema lists none.
fn options(schema: &Value) -> BTreeMap<String, Vec<Value>> {
    let mut found = BTreeMap::new();
    let mut open = vec![(String::new(), &schema["$defs"]["MotionJob"])];
    while let Some((path, value)) = open.pop() {
        let value = resolved(schema, value);
        if NO_OPTIONS.contains(&path.as_str()) {
            continue;
        }
        let kinds = value["oneOf"].as_array().into_iter().flatten().chain([value]);
        let parts = kinds.filter_map(|kind| kind["properties"].as_object()).flatten();
        let below = |name: &String| match path.is_empty() {
            true => name.clone(),
            false => format!("{path}.{name}"),
        };
        let parts: Vec<_> = parts.map(|(name, part)| (below(name), part)).collect();
        if !parts.is_empty() {
            open.extend(parts);
            continue;
        }
        let constants = value["oneOf"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(|item| item.get("const"));
        let listed = value["enum"].as_array().into_iter().flatten();
        let mut values: Vec<Value> = constants.chain(listed).cloned().collect();
        if value["type"] == "boolean" {
            values.push(true.into());
        }
        found.insert(path, values);
    }
    found
}

/// Every value of every option, in the order of their names.
fn choices() -> Vec<Choice> {
    let schema: Value = serde_json::from_str(&Job::schema()).unwrap();
    let mut all = Vec::new();
    for (option, mut listed) in options(&schema) {
        let stated = VALUES.iter().filter(|(name, ..)| *name == option);
        // One weight of each solver stands for all, because all reach the solver in the same way.
        if option.starts_with("weights.") && stated.clone().next().is_none() {
            continue;
        }
        let mut source = String::new();
        for (_, text, needed) in stated {
            source = (*needed).to_owned();
            let value = match option.as_str() {
                "steps" => Some(json!([text])),
                _ if text.is_empty() => None,
                _ => Some(serde_json::from_str(text).unwrap()),
            };
            // A format other than the source's format is not a valid option.
            if option == "read.from" {
                listed.clear();
            }
            all.extend(value.map(|value| Choice {
                option: option.clone(),
                value,
                source: source.clone(),
            }));
        }
        if option == "steps" {
            listed = EditStep::ALL
                .iter()
                .filter(|step| {
                    !VALUES
                        .iter()
                        .any(|(_, text, _)| text.split(':').next() == Some(step.name))
                })
                .map(|step| json!([step_of_list(step.name)]))
                .collect();
        }
        let count = all.len();
        all.extend(listed.into_iter().map(|value| Choice {
            option: option.clone(),
            value,
            source: source.clone(),
        }));
        let is_tried = all.len() > count || VALUES.iter().any(|(name, ..)| *name == option);
        assert!(is_tried, "{option} is a new option: write values of it to VALUES");
    }
    all
}

/// The step with the options that `tests/steps.json` has for it.
fn step_of_list(name: &str) -> String {
    let texts: Vec<String> = serde_json::from_str(include_str!("../../../../../tests/steps.json")).unwrap();
    let mut texts = texts.into_iter();
    texts.find(|text| text.split(':').next() == Some(name)).unwrap()
}

/// The folder of the sources. Each source has a few frames.
fn sources() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for (name, file) in [
        ("walk.bvh", "real/cmu_12_01_walk.bvh"),
        ("second.bvh", "real/cmu_short.bvh"),
        ("dance.bvh", "real/rokoko_dance.bvh"),
        ("zup.bvh", "real/z_up_dab.bvh"),
        ("jump.bvh", "real/mocopi_jump_six_channels.bvh"),
    ] {
        fs::write(path(name), cut::first_frames(file, FRAMES)).unwrap();
    }
    for (name, file) in [
        ("arm.fbx", "real/animation_with_skeleton.fbx"),
        ("arm.usda", "made/arm.usda"),
        ("take.c3d", "real/hand_take.c3d"),
        ("tiny.amc", "made/tiny.amc"),
        ("tiny.asf", "made/tiny.asf"),
        ("points.npy", "arrays/points_smpl22.npy"),
        ("amass.npz", "arrays/amass_smplh.npz"),
        ("body_smplh.npz", "arrays/body_smplh.npz"),
        ("h1.urdf", "robots/h1.urdf"),
        ("h1.xml", "robots/h1_nomesh.xml"),
        ("human.gltf", "skeletons/human_default.gltf"),
        ("run.bvh", "skeletons/accad_run_turn.bvh"),
        ("vrm1.gltf", "skeletons/human_vrm1.gltf"),
    ] {
        fs::copy(format!("{ROOT}/fixtures/{file}"), path(name)).unwrap();
    }
    // The markers of a body.
    let mut markers = mocap::import(format!("{ROOT}/fixtures/markers/cmu_01_01.c3d")).unwrap();
    markers.trim(0.0, FRAMES as f64 - 1.0);
    Exporter::new().export(&markers, path("body.trc")).unwrap();
    // Two clips with two frame rates, with a skin.
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::Skinned);
    let mut scene = importer.import(path("walk.bvh")).unwrap();
    mocap::Conversion::new().apply(&mut scene).unwrap();
    let slow = Animation {
        name: "slow".to_owned(),
        ticks_per_second: 30.0,
        ..scene.animations[0].clone()
    };
    scene.animations[0].name = "fast".to_owned();
    scene.animations.push(slow);
    scene.metadata = mocap::scene::Metadata::default();
    scene.metadata.metres_per_unit = Some(1.0);
    Exporter::new().export(&scene, path("two.glb")).unwrap();
    folder
}

/// An output of a source in the format of an extension.
struct Cell<'a> {
    choices: Vec<&'a Choice>,
    extension: &'static str,
    source: &'a str,
}

impl Cell<'_> {
    fn job(&self, folder: &Path, output: &Path) -> Value {
        let mut job = json!({
            "source": {"inputs": [folder.join(self.source)]},
            "write": {"output": output, "force": true},
        });
        for choice in &self.choices {
            let pointer = choice.option.split('.');
            let place = pointer.fold(&mut job, |place, key| &mut place[key]);
            let is_file = |name: &str| folder.join(name).is_file();
            match (place.as_array_mut(), &choice.value) {
                (Some(steps), Value::Array(more)) => steps.extend(more.iter().cloned()),
                (_, Value::String(name)) if is_file(name) => *place = json!(folder.join(name)),
                (_, value) => *place = value.clone(),
            }
        }
        for (body, file) in BODIES {
            if self.choices.iter().any(|choice| choice.body() == Some(body)) {
                let named = &mut job["target"][body]["file"];
                if named.is_null() {
                    *named = json!(folder.join(file));
                }
            }
        }
        let steps = job["steps"].as_array().cloned().unwrap_or_default();
        let takes_other = |step: &&Value| {
            let name = step.as_str().unwrap_or_default().split(':').next();
            EditStep::ALL
                .iter()
                .any(|known| Some(known.name) == name && known.takes_other)
        };
        let seconds = steps.iter().filter(takes_other).count();
        if seconds > 0 {
            job["source"]["with"] = json!(vec![folder.join("second.bvh"); seconds]);
        }
        if !steps.is_empty() {
            // Works as the program's `edit` does.
            let frames = &mut job["source"]["frames"]["drop-first-frame"];
            if frames.is_null() {
                *frames = "auto".into();
            }
        }
        job
    }

    fn verdict(&self, folder: &Path) -> Verdict {
        let place = tempfile::tempdir().unwrap();
        let output = place.path().join(format!("out.{}", self.extension));
        let job: MotionJob = serde_json::from_value(self.job(folder, &output)).unwrap();
        let made = Maker::new(&job, &[], &mut |_| ()).and_then(|maker| {
            let made = maker.make(&job.source.inputs, &output, &mut |_| ())?;
            made.written.save(&output, &job.policy())?;
            Ok(made)
        });
        let made = match made {
            Ok(made) => made,
            Err(_) => return Verdict::Refused,
        };
        match job.verify_output(made.scene, &output) {
            Ok(verified) if verified.is_within(job.write.smaller.tolerance()) => Verdict::Accepted,
            Ok(verified) => Verdict::FalseAlarm(format!(
                "{:.3} mm, {:.3} mm by rotations, {:?} {:?}",
                1000.0 * verified.max_error,
                1000.0 * verified.rotation_error.unwrap_or(0.0),
                verified.worst,
                verified.findings
            )),
            // A format may have nothing to compare on another body.
            Err(error) if job.target.is_some() && error.code() == Code::Unrepresentable => Verdict::Refused,
            Err(error) => Verdict::FalseAlarm(error.to_string()),
        }
    }

    fn name(&self) -> String {
        let choices: Vec<String> = self
            .choices
            .iter()
            .map(|choice| format!("{} = {}", choice.option, choice.value))
            .collect();
        format!("{} to .{}: {}", self.source, self.extension, choices.join(", "))
    }
}

/// A format that cannot be compared, because it has no skeleton.
const NOT_COMPARED: &str = "vmd";

fn extensions() -> Vec<&'static str> {
    let written = FormatInfo::ALL.iter().filter(|row| row.writes());
    let extensions = written.flat_map(|row| row.extensions.iter().copied());
    extensions.filter(|extension| *extension != NOT_COMPARED).collect()
}

/// Options that are tried alone, because solving a skeleton from markers takes seconds.
const SLOW: [&str; 2] = ["read.markers", "read.static"];

/// Two choices that a job can combine: options, or two steps, for one source.
fn is_pair(a: &Choice, b: &Choice) -> bool {
    if [a, b].iter().any(|choice| SLOW.contains(&choice.option.as_str())) {
        return false;
    }
    // With three channels, the joint below an added root and the joints of a second body lose the motion of their
    // positions. A warning says so.
    let is = |option: &str, value: Value| {
        [a, b]
            .iter()
            .any(|choice| choice.option == option && choice.value == value)
    };
    let has_second_root = || {
        is("source.frames.root", "extract".into())
            || is("steps", json!(["root-motion"]))
            || is("steps", json!(["concat:within=0.5"]))
    };
    if is("write.bvh.channels", "3".into()) && has_second_root() {
        return false;
    }
    // A job retargets motions to one body. Each option of this target is tried with the options of reading and writing.
    for (one, other) in [(a, b), (b, a)] {
        let is_beside = ["source.", "write."].iter().any(|part| other.option.starts_with(part));
        if one.body().is_some() && !is_beside {
            return false;
        }
    }
    let has_one_source = a.source.is_empty() || b.source.is_empty() || a.source == b.source;
    has_one_source && (a.option != b.option || a.option == "steps")
}

/// Every option alone in every format, and every pair in one format.
fn cells(choices: &[Choice]) -> (Vec<Cell<'_>>, Vec<Cell<'_>>) {
    let extensions = extensions();
    let source_of = |choices: &[&Choice], number: usize| {
        let needed = choices.iter().find(|choice| !choice.source.is_empty());
        let has_target = choices.iter().any(|choice| choice.body().is_some());
        let count = if has_target { HUMANOIDS } else { SOURCES.len() };
        needed.map_or(SOURCES[number % count], |choice| {
            // The name lives as long as the table of values.
            VALUES.iter().find(|(_, _, source)| *source == choice.source).unwrap().2
        })
    };
    let (mut alone, mut pairs) = (Vec::new(), Vec::new());
    for (index, choice) in choices.iter().enumerate() {
        for (number, extension) in extensions.iter().enumerate() {
            alone.push(Cell {
                choices: vec![choice],
                extension,
                source: source_of(&[choice], index + number),
            });
        }
        for (other, second) in choices
            .iter()
            .enumerate()
            .skip(index + usize::from(choice.option != "steps"))
        {
            if !is_pair(choice, second) {
                continue;
            }
            let number = 7 * index + 3 * other;
            pairs.push(Cell {
                choices: vec![choice, second],
                extension: extensions[(number / 5) % extensions.len()],
                source: source_of(&[choice, second], number),
            });
        }
    }
    (alone, pairs)
}

/// The verdicts of the cells, computed on all cores.
fn verdicts(cells: &[Cell<'_>], folder: &Path) -> Vec<Verdict> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let part = cells.len().div_ceil(threads).max(1);
    std::thread::scope(|scope| {
        let of_part = |cells: &[Cell<'_>]| cells.iter().map(|cell| cell.verdict(folder)).collect::<Vec<_>>();
        let running: Vec<_> = cells
            .chunks(part)
            .map(|cells| scope.spawn(move || of_part(cells)))
            .collect();
        running.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    })
}

const DOCUMENT: &str = "docs/verification.md";
const START: &str = "<!-- allowed changes -->\n";
const END: &str = "<!-- end of allowed changes -->\n";
const COMMAND: &str = "MOCAP_WRITE=1 MOCAP_ALL=1 cargo test -p mocap-job allowed writes it";

/// The section of the document: for each option and format, the accepted outputs and the written outputs.
fn section(cells: &[Cell<'_>], verdicts: &[Verdict]) -> String {
    let mut counts: BTreeMap<(&str, &str), (usize, usize)> = BTreeMap::new();
    let (mut written, mut alarms) = (0, 0);
    for (cell, verdict) in cells.iter().zip(verdicts) {
        let (accepted, all) = match verdict {
            Verdict::Accepted => (1, 1),
            Verdict::FalseAlarm(_) => (0, 1),
            Verdict::Refused => (0, 0),
        };
        written += all;
        alarms += all - accepted;
        let options: BTreeSet<&str> = cell.choices.iter().map(|choice| choice.option.as_str()).collect();
        for option in options {
            let count = counts.entry((option, cell.extension)).or_default();
            *count = (count.0 + accepted, count.1 + all);
        }
    }
    let extensions = extensions();
    let mut text = format!(
        "{} jobs, each with one option or with two, wrote {written} outputs; the others were refused with a reason.\n\
         False alarms: {alarms}.\n\n\
         A cell is the number of outputs that the jobs with this option wrote and that `verify` accepts. `11 of 12` would be one\n\
         false alarm. An empty cell has no output.\n\n| option |",
        cells.len()
    );
    extensions
        .iter()
        .for_each(|extension| _ = write!(text, " `.{extension}` |"));
    text += "\n|---|";
    text += &"---|".repeat(extensions.len());
    text.push('\n');
    let options: BTreeSet<&str> = counts.keys().map(|(option, _)| *option).collect();
    for option in options {
        let _ = write!(text, "| `{option}` |");
        for extension in &extensions {
            match counts.get(&(option, *extension)) {
                Some((accepted, all)) if accepted == all && *all > 0 => _ = write!(text, " {all} |"),
                Some((accepted, all)) if *all > 0 => _ = write!(text, " {accepted} of {all} |"),
                _ => text += " |",
            }
        }
        text.push('\n');
    }
    text
}

#[test]
fn no_allowed_change_is_a_false_alarm() {
    /// The stride between the tried cells, if not all cells are tried.
    const PARTS: usize = 24;
    let folder = sources();
    let choices = choices();
    let (alone, pairs) = cells(&choices);
    let tried: Vec<Cell<'_>> = Sample::new().some(alone.into_iter().chain(pairs), PARTS);
    let verdicts = verdicts(&tried, folder.path());
    let alarms = tried.iter().zip(&verdicts).filter_map(|(cell, verdict)| match verdict {
        Verdict::FalseAlarm(why) => Some(format!("{}: {why}", cell.name())),
        _ => None,
    });
    let alarms: Vec<String> = alarms.collect();
    let accepted = verdicts
        .iter()
        .filter(|verdict| matches!(verdict, Verdict::Accepted))
        .count();
    let count = tried.len();
    assert!(
        alarms.is_empty(),
        "{} of {count} are false alarms:\n{}",
        alarms.len(),
        alarms.join("\n")
    );
    assert!(3 * accepted > count, "{accepted} of {count} were written");
    let path = format!("{ROOT}/{DOCUMENT}");
    let text = fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once(START).unwrap();
    let (published, after) = rest.split_once(END).unwrap();
    if std::env::var_os("MOCAP_WRITE").is_some() && is_all() {
        let section = section(&tried, &verdicts);
        fs::write(&path, format!("{before}{START}{section}{END}{after}")).unwrap();
        return;
    }
    for choice in &choices {
        let row = format!("| `{}` |", choice.option);
        assert!(
            published.contains(&row),
            "{DOCUMENT} lacks {}: {COMMAND}",
            choice.option
        );
    }
    for extension in extensions() {
        assert!(
            published.contains(&format!("`.{extension}`")),
            "{DOCUMENT} lacks {extension}: {COMMAND}"
        );
    }
}

/// A source, the extension of an output, and options with their values.
type Case<'a> = (&'static str, &'static str, &'a [(&'static str, Value)]);

/// Correct outputs that `verify` once rejected, each of another kind.
#[test]
fn outputs_that_were_refused_once_are_accepted() {
    let cases: &[Case<'_>] = &[
        // If a motion in place is cut, it stays where the whole motion began, not where the remaining part begins.
        (
            "dance.bvh",
            "fbx",
            &[
                ("source.frames.root", json!("in-place")),
                ("steps", json!(["drop-first-frame:always=true"])),
            ],
        ),
        // The ground is horizontal in the world, even under a rotated group.
        ("arm.usda", "gltf", &[("source.frames.root", json!("in-place"))]),
        ("arm.usda", "glb", &[("source.frames.root", json!("extract"))]),
        // Joints that steps add are bound to the skin at their position.
        (
            "walk.bvh",
            "glb",
            &[
                ("source.frames.root", json!("extract")),
                ("source.frames.t-pose-first", json!(true)),
            ],
        ),
        ("arm.fbx", "gltf", &[("write.bone-axis", json!("x"))]),
        // The T-pose does not move end sites relative to their joints.
        ("dance.bvh", "usda", &[("source.frames.rest", json!("t-pose"))]),
        ("jump.bvh", "usdz", &[("source.frames.t-pose-first", json!(true))]),
        // Joints intentionally get other axes, and their errors stay within the allowed error at all times.
        (
            "amass.npz",
            "mclip",
            &[
                ("read.body", json!("body_smplh.npz")),
                ("source.frames.rest", json!("a-pose")),
            ],
        ),
        (
            "walk.bvh",
            "glb",
            &[
                ("write.bone-axis", json!("y")),
                ("write.smaller.max-error", json!("1mm")),
            ],
        ),
        // Vertices are compared with the file before its steps, in the rest pose of this file.
        (
            "arm.fbx",
            "glb",
            &[("source.frames.rest", json!("frame:3")), ("steps", json!(["fill"]))],
        ),
        // A step depends on the rest pose, on the bones and on the up axis that the caller stated.
        (
            "zup.bvh",
            "fbx",
            &[
                ("source.frames.rest", json!("frame:3")),
                ("steps", json!(["t-pose-first"])),
            ],
        ),
        (
            "jump.bvh",
            "bvh",
            &[
                ("source.map", json!({"head": null})),
                ("steps", json!(["blend:weight=0.3"])),
            ],
        ),
        (
            "jump.bvh",
            "bvh",
            &[("source.space.up", json!("-z")), ("steps", json!(["loop:frames=2..9"]))],
        ),
        (
            "zup.bvh",
            "bvh",
            &[
                ("write.space.out-unit", json!("inch")),
                ("steps", json!(["turn:by=90"])),
            ],
        ),
        // A bone that the source lacks is added, and has no partner.
        ("jump.bvh", "vrma", &[("source.map", json!({"head": null}))]),
        // Two frame rates, one after the other.
        (
            "arm.fbx",
            "usdz",
            &[
                ("source.frames.fps", json!(29.97)),
                ("steps", json!(["resample:rate=200"])),
            ],
        ),
        // A skin shows the position of the soles, but a mesh drawn for a skeleton does not.
        (
            "two.glb",
            "usdz",
            &[("read.clip", json!("slow")), ("steps", json!(["ground"]))],
        ),
        (
            "two.glb",
            "fbx",
            &[("read.clip", json!(1)), ("steps", json!(["ground"]))],
        ),
        // If a skin keeps the rest pose, its nodes have the pose of a frame of the motion.
        (
            "dance.bvh",
            "gltf",
            &[
                ("target.skeleton.feet", json!("lock")),
                ("write.mesh", json!("skinned")),
            ],
        ),
        // Motion below the largest error may be lost.
        ("jump.bvh", "mclip", &[("write.smaller.max-error", json!("1cm"))]),
        // A format with one clip has the first clip.
        ("two.glb", "trc", &[]),
        ("two.glb", "bvh", &[]),
        // Two clips with different frame rates, in a file with one rate.
        ("two.glb", "fbx", &[("source.frames.fps", json!(100))]),
        ("two.glb", "fbx", &[("write.fbx.target", json!("unreal"))]),
        // Constant scales are kept.
        ("arm.usda", "gltf", &[("write.keep-constant", json!(true))]),
    ];
    let folder = sources();
    let mut wrong = Vec::new();
    for (source, extension, options) in cases {
        let choices: Vec<Choice> = options
            .iter()
            .map(|(option, value)| Choice {
                option: (*option).to_owned(),
                value: value.clone(),
                source: String::new(),
            })
            .collect();
        let cell = Cell {
            choices: choices.iter().collect(),
            extension,
            source,
        };
        match cell.verdict(folder.path()) {
            Verdict::Accepted => {}
            verdict => wrong.push(format!("{}: {verdict:?}", cell.name())),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
