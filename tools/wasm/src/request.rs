//! What can be asked for, and the answers.

use std::sync::Arc;

use mocap::arrays::{self, ArrayOptions};
use mocap::dump::SceneView;
use mocap::edit::{ContactOptions, EditReport, EditStep, contacts};
use mocap::figure::{self, Figure, HumanoidMap, humanoid};
use mocap::gltf::{self, BufferPlace};
use mocap::job::Job;
use mocap::process::name_joints;
use mocap::render::{Clip, Drawing, PageClip, PlayerClip, SheetOptions};
use mocap::retargeting::{Report, Retargeting, SourceMotion, Target};
use mocap::scene::{Assumption, RootOffsetUsed, UpAxis};
use mocap::{Code, Conversion, Error, Format, FormatInfo, Importer, MemoryFile, Scene, SkeletonMesh, WrittenFile};
use serde::{Deserialize, Serialize};

use crate::answer::SceneAt;
use crate::clips::Clips;
use crate::failure::{Failure, Finding};
use crate::options::{ConvertOptions, ReadOptions, RetargetOptions, WriteOptions};
use crate::scenes::{Entry, Scenes};

/// One call. `files` are the names of the inputs, the motion first.
#[derive(Deserialize)]
#[serde(tag = "call", rename_all = "camelCase", deny_unknown_fields)]
enum Request {
    /// A file to a scene.
    Read {
        files: Vec<String>,
        #[serde(default)]
        options: ReadOptions,
    },
    /// A character for [`Request::Retarget`]: a glTF or VRM file keeps all that is in it.
    ReadCharacter {
        files: Vec<String>,
        #[serde(default)]
        options: ReadOptions,
    },
    /// What is wrong with a file, and what it leaves open.
    Check {
        files: Vec<String>,
        #[serde(default)]
        options: ReadOptions,
    },
    /// A changed copy of a scene.
    Convert {
        scene: u32,
        #[serde(default)]
        options: ConvertOptions,
    },
    /// A changed copy of a scene: its first animation after steps, in their order. `others` are the second motions of
    /// those steps that take one.
    Edit {
        scene: u32,
        /// Each an object with its name and its options, or text.
        steps: Vec<serde_json::Value>,
        #[serde(default)]
        others: Vec<u32>,
        #[serde(default)]
        bones: HumanoidMap,
    },
    /// A whole job on files in memory. The answer has the bytes of all files of the output, one after the other.
    Run { job: serde_json::Value, files: Vec<String> },
    /// A motion on a character, as a scene.
    Retarget {
        scene: u32,
        character: u32,
        #[serde(default)]
        options: RetargetOptions,
    },
    /// A clip as the player of `mocap view` takes it: text, and the bytes of its blocks one after another.
    View { scene: u32, name: String },
    /// A packed clip, to be sampled.
    OpenClip { files: Vec<String> },
    /// A scene as a file: by the extension of a written format, or as csv, json or png.
    Write {
        scene: u32,
        format: String,
        #[serde(default)]
        options: WriteOptions,
    },
}

/// The JSON and the bytes of an answer.
type Answer = (Vec<u8>, Vec<u8>);

pub(crate) fn answer(
    scenes: &mut Scenes,
    clips: &mut Clips,
    request: &[u8],
    files: &[Vec<u8>],
) -> Result<Answer, Failure> {
    let request = serde_json::from_slice(request).map_err(|error| Failure::argument(error.to_string()))?;
    match request {
        Request::Read { files: names, options } => {
            let (file, others) = memory_files(&names, files)?;
            let scene = options.importer().read_among(file, &others)?;
            keep(scenes, Entry::new(scene, None), &[])
        }
        Request::ReadCharacter { files: names, options } => {
            let (file, others) = memory_files(&names, files)?;
            keep(scenes, read_character(&options, file, &others)?, &[])
        }
        Request::Check { files: names, options } => {
            let (file, others) = memory_files(&names, files)?;
            check(&options, file, &others)
        }
        Request::Convert { scene, options } => convert(scenes, scene, options),
        Request::Edit {
            scene,
            steps,
            others,
            bones,
        } => edit(scenes, scene, &steps, &others, bones),
        Request::Run { job, files: names } => run(&job, &names, files),
        Request::Retarget {
            scene,
            character,
            options,
        } => retarget(scenes, scene, character, &options),
        Request::View { scene, name } => view(scenes.get(scene)?, &name),
        Request::OpenClip { files: names } => {
            let (file, _) = memory_files(&names, files)?;
            Ok((json(&clips.open(file.bytes)?)?, Vec::new()))
        }
        Request::Write { scene, format, options } => write(scenes.get(scene)?, &format, &options),
    }
}

fn run(job: &serde_json::Value, names: &[String], files: &[Vec<u8>]) -> Result<Answer, Failure> {
    let job = Job::from_json(&job.to_string())?;
    let (first, mut all) = memory_files(names, files)?;
    all.insert(0, first);
    let (written, report) = job.run_in_memory(&all)?;
    let bytes = written.files.into_iter().flat_map(WrittenFile::into_bytes);
    Ok((json(&report)?, bytes.collect()))
}

fn memory_files<'a>(
    names: &'a [String],
    files: &'a [Vec<u8>],
) -> Result<(MemoryFile<'a>, Vec<MemoryFile<'a>>), Failure> {
    if names.is_empty() || names.len() != files.len() {
        return Err(Failure::argument(format!(
            "there are {} names for {} files",
            names.len(),
            files.len()
        )));
    }
    let mut all = std::iter::zip(names, files).map(|(name, bytes)| MemoryFile { name, bytes });
    let first = all.next().ok_or_else(|| Failure::argument("there is no file"))?;
    Ok((first, all.collect()))
}

fn json(answer: &impl Serialize) -> Result<Vec<u8>, Failure> {
    serde_json::to_vec(answer).map_err(|error| Failure::argument(error.to_string()))
}

/// Keeps a scene, and describes it.
fn keep(scenes: &mut Scenes, entry: Entry, assumptions: &[Assumption]) -> Result<Answer, Failure> {
    let number = scenes.add(entry)?;
    let answer = json(&SceneAt::new(number, scenes.get(number)?, assumptions))?;
    Ok((answer, Vec::new()))
}

/// As `mocap retarget` reads its character: glTF and VRM files are passed through, others give their skeleton.
fn read_character(options: &ReadOptions, file: MemoryFile<'_>, others: &[MemoryFile<'_>]) -> Result<Entry, Failure> {
    // Where the meshes of the file are wanted, a mesh of the skeleton does no harm.
    let importer = match options.gltf_meshes {
        true => options.importer(),
        false => options.importer().skeleton_mesh(SkeletonMesh::None),
    };
    match importer.read_character(file, others) {
        Ok(character) => Ok(Entry::new(character.scene().clone(), Some(Arc::new(character)))),
        Err(error) if error.code() == Code::UnknownFormat => {
            Ok(Entry::new(options.importer().read_among(file, others)?, None))
        }
        Err(error) => Err(error.into()),
    }
}

/// As a line of `mocap check --json`.
fn check(options: &ReadOptions, file: MemoryFile<'_>, others: &[MemoryFile<'_>]) -> Result<Answer, Failure> {
    #[derive(Serialize)]
    struct Checked<'a> {
        status: &'static str,
        diagnostics: Vec<Finding<'a>>,
        assumptions: Vec<Assumption>,
    }
    let importer: Importer = options.importer().hash(false).skeleton_mesh(SkeletonMesh::None);
    let read = importer.read_among(file, others);
    let (warnings, error) = match &read {
        Ok(scene) => (scene.warnings.as_slice(), None),
        Err(error) => (error.warnings(), Some(error)),
    };
    let diagnostics: Vec<Finding<'_>> = warnings
        .iter()
        .map(Finding::warning)
        .chain(error.map(Finding::error))
        .collect();
    let checked = Checked {
        status: match (error, diagnostics.is_empty()) {
            (Some(_), _) => "error",
            (None, false) => "warning",
            (None, true) => "ok",
        },
        diagnostics,
        assumptions: read.as_ref().map(figure::assumptions).unwrap_or_default(),
    };
    Ok((json(&checked)?, Vec::new()))
}

fn convert(scenes: &mut Scenes, number: u32, options: ConvertOptions) -> Result<Answer, Failure> {
    let (names, bones) = (options.names()?, options.bones.clone());
    let conversion = options.conversion()?;
    let entry = scenes.get(number)?;
    let mut scene = entry.scene.clone();
    let assumptions = conversion.apply(&mut scene)?;
    if let Some(names) = names {
        // Indices of nodes may be others now.
        let known = entry.humanoid.iter().flat_map(|known| &known.bones);
        let known = known.map(|(bone, joint)| (*bone, Some(entry.scene.nodes[joint.joint.index()].name.clone())));
        let bones = humanoid(&scene).with_map(&scene, known.chain(bones).collect())?;
        name_joints(&mut scene, &bones, &names)?;
    }
    keep(scenes, Entry::new(scene, None).converted(), &assumptions)
}

fn edit(
    scenes: &mut Scenes,
    number: u32,
    steps: &[serde_json::Value],
    others: &[u32],
    bones: HumanoidMap,
) -> Result<Answer, Failure> {
    #[derive(Serialize)]
    struct Edited<'a> {
        #[serde(flatten)]
        scene: SceneAt<'a>,
        reports: Vec<EditReport>,
    }
    let steps = steps.iter().map(EditStep::from_value).collect::<Result<Vec<_>, _>>()?;
    let others = others.iter().map(|other| Ok(&scenes.get(*other)?.scene));
    let others = others.collect::<Result<Vec<_>, Failure>>()?;
    let entry = scenes.get(number)?;
    let known = match (&entry.humanoid, bones.is_empty()) {
        (known, true) => known.clone(),
        (known, false) => {
            let found = known.clone().unwrap_or_else(|| humanoid(&entry.scene));
            Some(found.with_map(&entry.scene, bones)?)
        }
    };
    let mut scene = entry.scene.clone();
    let reports = EditStep::apply_all(&mut scene, &steps, &others, known.as_ref())?;
    let entry = entry.edited(scene);
    let number = scenes.add(entry)?;
    let answer = json(&Edited {
        scene: SceneAt::new(number, scenes.get(number)?, &[]),
        reports,
    })?;
    Ok((answer, Vec::new()))
}

/// The scene in metres with +Y up.
fn in_metres(entry: &Entry) -> Result<(Scene, Vec<Assumption>), Error> {
    let mut scene = entry.scene.clone();
    let is_in_metres = scene.metadata.metres_per_unit == Some(1.0) && scene.metadata.up == Some(UpAxis::Y);
    if entry.is_converted && is_in_metres {
        return Ok((scene, Vec::new()));
    }
    let assumptions = Conversion::new().apply(&mut scene)?;
    Ok((scene, assumptions))
}

/// The scene in metres with +Y up, with a record of the motion that was put onto its skeleton.
fn on_skeleton(entry: &Entry) -> Result<(Scene, Vec<Assumption>), Error> {
    let (mut scene, assumptions) = in_metres(entry)?;
    if let Some(provenance) = entry.provenance.first() {
        provenance.record(&mut scene);
    }
    Ok((scene, assumptions))
}

/// What is said about a file that was written.
#[derive(Default, Serialize)]
struct Said {
    assumptions: Vec<Assumption>,
    warnings: Vec<mocap::Diagnostic>,
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<WriterReport>,
}

/// What the writer of a format says of its files.
#[derive(Serialize)]
struct WriterReport {
    nodes: usize,
    notes: Vec<String>,
    renamed: Vec<gltf::Renamed>,
    achieved: Option<gltf::Achieved>,
}

fn write(entry: &Entry, format: &str, options: &WriteOptions) -> Result<Answer, Failure> {
    let scene = &entry.scene;
    match format {
        "csv" => {
            let motion = arrays::arrays(scene, &ArrayOptions::default())?;
            let said = Said {
                assumptions: motion.header.provenance.assumptions.clone(),
                ..Said::default()
            };
            Ok((json(&said)?, motion.to_csv().into_bytes()))
        }
        "json" => Ok((json(&Said::default())?, json(&SceneView::new(scene))?)),
        "png" => {
            let origin = scene.metadata.origin.as_ref().map_or("", |origin| origin.stem());
            let name = options.name.as_deref().unwrap_or(origin);
            let drawing = Drawing::sheet(&[Clip { name, scene }], &SheetOptions::default());
            Ok((json(&Said::default())?, drawing.to_png()?))
        }
        extension => write_format(entry, extension, options),
    }
}

/// A file of a written format.
fn write_format(entry: &Entry, extension: &str, options: &WriteOptions) -> Result<Answer, Failure> {
    let name = format!("scene.{extension}");
    let Some(row) = FormatInfo::of_output(name.as_ref()) else {
        let known = FormatInfo::written_extensions();
        return Err(Failure::argument(format!(
            "the format must be csv, json, png, or an extension of {known} without the dot, got {extension:?}"
        )));
    };
    if let Some(refusal) = options.refusal(row, extension) {
        return Err(mocap::Error::from(refusal).into());
    }
    if let (Format::Gltf, Some(character)) = (row.format, &entry.character) {
        let added = std::iter::zip(&entry.scene.animations, &entry.provenance);
        let (bytes, _) = character.with_clips(added, false, &options.gltf())?;
        return Ok((json(&Said::default())?, bytes));
    }
    let (scene, assumptions) = match row.keeps_units() {
        true => (entry.scene.clone(), Vec::new()),
        false => on_skeleton(entry)?,
    };
    // The page gets one file.
    let mut exporter = options.exporter().buffer(BufferPlace::Embedded);
    if let Some(humanoid) = &entry.humanoid {
        exporter = exporter.humanoid(humanoid.clone());
    }
    let mut written = exporter.write_as(&scene, name)?;
    let said = Said {
        assumptions,
        warnings: std::mem::take(&mut written.warnings),
        report: Some(WriterReport {
            nodes: written.nodes,
            notes: std::mem::take(&mut written.notes),
            renamed: std::mem::take(&mut written.renamed),
            achieved: written.error.take(),
        }),
    };
    Ok((json(&said)?, written.into_bytes()?))
}

/// As `mocap view` puts it in a page.
fn view(entry: &Entry, name: &str) -> Result<Answer, Failure> {
    #[derive(Serialize)]
    #[serde(rename_all = "camelCase")]
    struct View<'a> {
        description: Box<serde_json::value::RawValue>,
        /// The id of each block and how many bytes it has.
        blocks: Vec<(String, usize)>,
        /// What is not shown of the skin.
        left_out: Vec<String>,
        /// What the file does not state.
        assumptions: Vec<Assumption>,
        root_offset: &'a Option<RootOffsetUsed>,
    }
    let scene = &entry.scene;
    let figure = match &entry.humanoid {
        Some(humanoid) => Figure::with_bones(scene, humanoid.clone()),
        None => Figure::new(scene),
    };
    // Only a humanoid with a motion has contacts.
    let found = contacts(scene, 0, Some(&figure.humanoid), &ContactOptions::default()).ok();
    let packed = PlayerClip::new(
        &PageClip::new(Clip { name, scene })
            .figure(Some(&figure))
            .contacts(found.as_ref())
            .limb_angles(entry.limb_angles()),
    );
    let view = View {
        blocks: packed
            .blocks
            .iter()
            .map(|(id, bytes)| (id.clone(), bytes.len()))
            .collect(),
        description: serde_json::value::RawValue::from_string(packed.description)
            .map_err(|error| Failure::argument(error.to_string()))?,
        left_out: packed.left_out,
        assumptions: scene
            .metadata
            .assumptions
            .iter()
            .cloned()
            .chain(figure.assumptions())
            .collect(),
        root_offset: &scene.metadata.root_offset,
    };
    let bytes: Vec<Vec<u8>> = packed.blocks.into_iter().map(|(_, bytes)| bytes).collect();
    Ok((json(&view)?, bytes.concat()))
}

fn retarget(scenes: &mut Scenes, motion: u32, character: u32, options: &RetargetOptions) -> Result<Answer, Failure> {
    #[derive(Serialize)]
    struct Retargeted<'a> {
        #[serde(flatten)]
        scene: SceneAt<'a>,
        reports: Vec<Report>,
    }
    let (entry, target) = (scenes.get(motion)?, scenes.get(character)?);
    let file = target.character.clone();
    let onto = match &file {
        Some(file) => Target::Character(Arc::clone(file)),
        None => Target::from(target.scene.clone()),
    };
    let (source, assumptions) = in_metres(entry)?;
    let mut retargeting = Retargeting::onto(onto, options.retargeting()?)?;
    let source = SourceMotion::converted(source);
    retargeting.add(match &options.name {
        Some(name) => source.named(name),
        None => source,
    })?;
    let limb_angles = options.limb_angles.then(|| retargeting.limb_angles(0)).flatten();
    let mut scene = target.scene.clone();
    let humanoid = retargeting.humanoid().cloned();
    let (mut provenance, mut reports) = (Vec::new(), Vec::new());
    scene.animations.clear();
    for clip in retargeting.into_clips() {
        scene.animations.push(clip.animation);
        provenance.push(clip.provenance);
        reports.push(clip.report);
    }
    let entry = Entry::new(scene, file)
        .with_humanoid(humanoid)
        .with_provenance(provenance)
        .with_limb_angles(limb_angles);
    let number = scenes.add(entry)?;
    let answer = json(&Retargeted {
        scene: SceneAt::new(number, scenes.get(number)?, &assumptions),
        reports,
    })?;
    Ok((answer, Vec::new()))
}
