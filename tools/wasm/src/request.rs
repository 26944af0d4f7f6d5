//! The requests and their answers.

use std::sync::Arc;

use mocap::edit::report::EditReport;
use mocap::edit::{ContactOptions, EditStep, StepInfo, ValueKind};
use mocap::figure::{Figure, Humanoid, HumanoidMap};
use mocap::job::Job;
use mocap::render::{Clip, PageClip, PlayerClip};
use mocap::retarget::report::ClipReport;
use mocap::retarget::robot::{Robot, RobotMotion, add_links};
use mocap::retarget::{RetargetOptions, Retargeter, SourceMotion, Target, apply_steps};
use mocap::scene::Assumption;
use mocap::scene::report::RootOffsetUsed;
use mocap::{ChainMatrix, Code, ExportFile, Importer, MemoryFile, Pose, Scene, SkeletonMesh};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::answer::SceneAt;
use crate::failure::{Failure, Finding};
use crate::laboratory::{self, Columns};
use crate::options::{ConvertOptions, PoseRetargetOptions, ReadOptions, WriteOptions};
use crate::robot_streams::{self, StreamOptions};
use crate::scenes::{Entry, Scenes};
use crate::state::State;
use crate::writing::{in_metres, write};

/// A request. `files` are the names of the inputs, the motion first.
#[derive(Deserialize)]
#[serde(tag = "call", rename_all = "camelCase", deny_unknown_fields)]
enum Request {
    /// Reads a file to a scene.
    Read {
        files: Vec<String>,
        #[serde(default)]
        options: Value,
    },
    /// Reads a character for [`Request::Retarget`]. A glTF or VRM file keeps all its contents.
    ReadCharacter {
        files: Vec<String>,
        #[serde(default)]
        options: Value,
    },
    /// A converted copy of a scene.
    Convert {
        scene: u32,
        #[serde(default)]
        options: Value,
    },
    /// An edited copy of a scene: its animations after steps in order. `others` are the second motions of the
    /// steps that take one.
    Edit {
        scene: u32,
        /// Each step is a string, or an object with name and options.
        steps: Vec<Value>,
        #[serde(default)]
        others: Vec<u32>,
        #[serde(default)]
        bones: HumanoidMap,
    },
    /// The steps of [`Request::Edit`] with their options.
    Steps {},
    /// Retargets a motion to a character, as a scene.
    Retarget {
        scene: u32,
        character: u32,
        #[serde(default)]
        options: Value,
    },
    /// A clip in the format of `mocap view`'s player: text, and the bytes of its blocks in sequence.
    View { scene: u32, name: String },
    /// The values of a robot's motion. The JSON has the joints with their limits. The bytes are 64-bit floats:
    /// positions of the base, rotations of the base (x, y, z, w), and positions of the joints, each frame by frame.
    RobotMotion { scene: u32 },
    /// Writes a scene to a file: by the extension of a written format, or as csv, json or png.
    Write {
        scene: u32,
        format: String,
        #[serde(default)]
        options: Value,
    },
}

/// A request that the drop page does not make; see [`mocap_call_other`](crate::mocap_call_other).
#[derive(Deserialize)]
#[serde(tag = "call", rename_all = "camelCase", deny_unknown_fields)]
enum OtherRequest {
    /// The problems of a file, and the properties that it does not state.
    Check {
        files: Vec<String>,
        #[serde(default)]
        options: Value,
    },
    /// Runs a job on files in memory. The answer has the bytes of all output files in sequence.
    Run { job: Value, files: Vec<String> },
    /// Joint angles, ground reaction forces or analog channels.
    Table { scene: u32, columns: Columns },
    /// Gait parameters, recorded laboratory data, or the residuals of a skeleton solved from markers.
    Report { scene: u32, report: laboratory::Report },
    /// The matrices from the root to a joint, and a point attached to it.
    Chain {
        scene: u32,
        joint: String,
        #[serde(default)]
        tick: f64,
        #[serde(default)]
        point: Option<[f32; 3]>,
    },
    /// Begins to retarget a live motion to a robot.
    RobotStream {
        scene: u32,
        robot: u32,
        #[serde(default)]
        options: Value,
    },
    /// Scores a motion of a robot against a reference: the report.
    Score {
        scene: u32,
        motion: u32,
        robot: u32,
        #[serde(default)]
        bones: HumanoidMap,
    },
    /// The next pose of a stream. The file has the matrices of all nodes relative to their parents, as 32-bit floats.
    RobotPush { stream: u32 },
    /// The remaining frames of a stream.
    RobotFinish { stream: u32 },
    /// The report of a stream.
    RobotReport { stream: u32 },
    /// Opens a packed clip for sampling.
    OpenClip { files: Vec<String> },
    /// Makes a figure of a character for motion matching. The motions come from a database, which is the file, or from
    /// scenes.
    Controller {
        character: u32,
        #[serde(default)]
        motions: Vec<u32>,
        /// Whether to also use the mirror image of each motion.
        #[serde(default)]
        mirror: bool,
    },
}

/// The JSON and the bytes of an answer.
pub(crate) type Answer = (Vec<u8>, Vec<u8>);

pub(crate) fn answer(state: &mut State, request: &[u8], files: &[Vec<u8>]) -> Result<Answer, Failure> {
    let scenes = &mut state.scenes;
    match parsed(request)? {
        Request::Read { files: names, options } => {
            let (file, others) = memory_files(&names, files)?;
            let options = ReadOptions::of("read", options)?;
            let scene = options.importer().read_among(file, &others)?;
            keep(scenes, Entry::new(scene, None), &[])
        }
        Request::ReadCharacter { files: names, options } => {
            let (file, others) = memory_files(&names, files)?;
            keep(
                scenes,
                read_character(&ReadOptions::of("readCharacter", options)?, file, &others)?,
                &[],
            )
        }
        Request::Convert { scene, options } => convert(scenes, scene, &ConvertOptions::of(options)?),
        Request::Edit {
            scene,
            steps,
            others,
            bones,
        } => edit(scenes, scene, &steps, &others, bones),
        Request::Steps {} => Ok((json(&steps())?, Vec::new())),
        Request::Retarget {
            scene,
            character,
            options,
        } => retarget(scenes, scene, character, &PoseRetargetOptions::of(options)?),
        Request::View { scene, name } => view(scenes.get(scene)?, &name),
        Request::RobotMotion { scene } => robot_motion(scenes.get(scene)?),
        Request::Write { scene, format, options } => write(scenes.get(scene)?, &format, &WriteOptions::of(options)?),
    }
}

pub(crate) fn answer_other(state: &mut State, request: &[u8], files: &[Vec<u8>]) -> Result<Answer, Failure> {
    let scenes = &mut state.scenes;
    match parsed(request)? {
        OtherRequest::Check { files: names, options } => {
            let (file, others) = memory_files(&names, files)?;
            check(&ReadOptions::of("check", options)?, file, &others)
        }
        OtherRequest::Run { job, files: names } => run(&job, &names, files),
        OtherRequest::Table { scene, columns } => laboratory::table(&scenes.get(scene)?.scene, columns),
        OtherRequest::Report { scene, report } => laboratory::report(&scenes.get(scene)?.scene, report),
        OtherRequest::Chain {
            scene,
            joint,
            tick,
            point,
        } => chain(&scenes.get(scene)?.scene, &joint, tick, point),
        OtherRequest::Score {
            scene,
            motion,
            robot,
            bones,
        } => {
            let (reference, motion) = (scenes.get(scene)?, scenes.get(motion)?);
            score(reference, motion, robot_of(scenes.get(robot)?)?, bones)
        }
        OtherRequest::RobotStream { scene, robot, options } => {
            let robot = robot_of(scenes.get(robot)?)?;
            let source = &scenes.get(scene)?.scene;
            let begun = state.robot_streams.add(source, robot, &StreamOptions::of(options)?)?;
            Ok((json(&begun)?, Vec::new()))
        }
        OtherRequest::RobotPush { stream } => {
            let pose = files.first().map_or(&[][..], Vec::as_slice);
            state.robot_streams.push(stream, pose)
        }
        OtherRequest::RobotFinish { stream } => state.robot_streams.finish(stream),
        OtherRequest::RobotReport { stream } => state.robot_streams.report(stream),
        OtherRequest::OpenClip { files: names } => {
            let (file, _) = memory_files(&names, files)?;
            Ok((json(&state.clips.open(file.bytes)?)?, Vec::new()))
        }
        OtherRequest::Controller {
            character,
            motions,
            mirror,
        } => {
            let (character, _) = in_metres(scenes.get(character)?)?;
            let motions = motions.iter().map(|motion| Ok(&scenes.get(*motion)?.scene));
            let motions = motions.collect::<Result<Vec<_>, Failure>>()?;
            let database = files.first().map(Vec::as_slice);
            let figure = state.controllers.add(&character, database, &motions, mirror)?;
            Ok((json(&figure)?, Vec::new()))
        }
    }
}

fn parsed<T: DeserializeOwned>(request: &[u8]) -> Result<T, Failure> {
    serde_json::from_slice(request).map_err(|error| Failure::argument(error.to_string()))
}

fn chain(scene: &Scene, joint: &str, tick: f64, point: Option<[f32; 3]>) -> Result<Answer, Failure> {
    #[derive(Serialize)]
    #[serde(rename_all = "camelCase")]
    struct Chain {
        chain: Vec<ChainMatrix>,
        point_in_world: Option<[f32; 3]>,
    }
    let pose = Pose::at_tick(scene, 0, tick).unwrap_or_else(|| Pose::rest(scene));
    let chain = pose.chain(scene, joint)?;
    let in_world = |point: [f32; 3]| Some(pose.point_to_world(chain.last()?.node, point.into()).to_array());
    let point_in_world = point.and_then(in_world);
    Ok((json(&Chain { chain, point_in_world })?, Vec::new()))
}

fn steps() -> Value {
    let of = |step: &StepInfo| {
        let keys = step.keys.iter().map(|key| match key.takes {
            ValueKind::OneOf(words) => {
                serde_json::json!({"name": key.name(), "takes": key.takes.symbol(), "words": words})
            }
            takes => serde_json::json!({"name": key.name(), "takes": takes.symbol()}),
        });
        let keys: Vec<Value> = keys.collect();
        serde_json::json!({"name": step.name, "help": step.help, "takesOther": step.takes_other, "keys": keys})
    };
    serde_json::json!({"steps": EditStep::ALL.iter().map(of).collect::<Vec<_>>()})
}

fn run(job: &Value, names: &[String], files: &[Vec<u8>]) -> Result<Answer, Failure> {
    let job = Job::from_json(&job.to_string())?;
    let (first, mut all) = memory_files(names, files)?;
    all.insert(0, first);
    let (written, report) = job.run_in_memory(&all)?;
    let bytes = written.files.into_iter().flat_map(ExportFile::into_bytes);
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

pub(crate) fn json(answer: &impl Serialize) -> Result<Vec<u8>, Failure> {
    serde_json::to_vec(answer).map_err(|error| Failure::argument(error.to_string()))
}

/// Keeps a scene, and describes it.
fn keep(scenes: &mut Scenes, entry: Entry, assumptions: &[Assumption]) -> Result<Answer, Failure> {
    let number = scenes.add(entry)?;
    let answer = json(&SceneAt::new(number, scenes.get(number)?, assumptions))?;
    Ok((answer, Vec::new()))
}

/// Read the meshes of links only if the caller wants meshes.
fn robot_importer(options: &ReadOptions) -> Importer {
    options.importer().robot_meshes(options.has_gltf_meshes())
}

/// Reads a character as `mocap retarget` does: glTF and VRM files are passed through, other files give their skeleton.
fn read_character(options: &ReadOptions, file: MemoryFile<'_>, others: &[MemoryFile<'_>]) -> Result<Entry, Failure> {
    // If the caller wants meshes, a generated skeleton mesh does no harm.
    let importer = match options.has_gltf_meshes() {
        true => options.importer(),
        false => options.importer().skeleton_mesh(SkeletonMesh::None),
    };
    match importer.read_character(file, others) {
        Ok(character) => Ok(Entry::new(character.scene().clone(), Some(Arc::new(character)))),
        Err(error) if error.code() == Code::UnknownFormat => {
            match robot_importer(options).read_robot_among(file, others) {
                Err(error) if error.code() == Code::UnknownFormat => {
                    Ok(Entry::new(options.importer().read_among(file, others)?, None))
                }
                robot => Ok(Entry::of_robot(robot?, options.has_gltf_meshes())),
            }
        }
        Err(error) => Err(error.into()),
    }
}

/// The answer is like a line of `mocap check --json`.
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
        assumptions: read.as_ref().map(mocap::figure::assumptions).unwrap_or_default(),
    };
    Ok((json(&checked)?, Vec::new()))
}

fn convert(scenes: &mut Scenes, number: u32, options: &ConvertOptions) -> Result<Answer, Failure> {
    let (names, bones) = (options.names()?, options.bones().clone());
    let conversion = options.conversion();
    let entry = scenes.get(number)?;
    let mut scene = entry.scene.clone();
    let assumptions = conversion.apply(&mut scene)?;
    if let Some(names) = names {
        // The indices of nodes may have changed.
        let known = entry.humanoid.iter().flat_map(|known| &known.bones);
        let known = known.map(|(bone, joint)| (*bone, Some(entry.scene.nodes[joint.joint.index()].name.clone())));
        let mut map = bones.clone();
        for (bone, joint) in known {
            map.entry(bone).or_insert(joint);
        }
        let bones = Humanoid::of(&scene).with_map(&scene, map)?;
        mocap::figure::name_joints(&mut scene, &bones, &names)?;
    }
    let known = match bones.is_empty() {
        true => None,
        false => Some(Humanoid::of(&scene).with_map(&scene, bones)?),
    };
    let entry = Entry::new(scene, None).converted().with_humanoid(known);
    keep(scenes, entry, &assumptions)
}

fn edit(
    scenes: &mut Scenes,
    number: u32,
    steps: &[Value],
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
            let found = known.clone().unwrap_or_else(|| Humanoid::of(&entry.scene));
            Some(found.with_map(&entry.scene, bones)?)
        }
    };
    let mut scene = entry.scene.clone();
    let reports = apply_steps(&mut scene, &steps, &others, known.as_ref())?;
    let entry = entry.edited(scene);
    let number = scenes.add(entry)?;
    let answer = json(&Edited {
        scene: SceneAt::new(number, scenes.get(number)?, &[]),
        reports,
    })?;
    Ok((answer, Vec::new()))
}

/// Packs the clip as `mocap view` does for a page.
fn view(entry: &Entry, name: &str) -> Result<Answer, Failure> {
    #[derive(Serialize)]
    #[serde(rename_all = "camelCase")]
    struct View<'a> {
        description: Box<serde_json::value::RawValue>,
        /// The id of each block and its length in bytes.
        blocks: Vec<(String, usize)>,
        /// The parts of the skin that are not shown.
        left_out: Vec<String>,
        /// Assumptions that the file does not state.
        assumptions: Vec<Assumption>,
        root_offset: &'a Option<RootOffsetUsed>,
    }
    let scene = &entry.scene;
    let figure = match &entry.humanoid {
        Some(humanoid) => Figure::with_bones(scene, humanoid.clone()),
        None => Figure::new(scene),
    };
    // Only a humanoid with a motion has contacts.
    let found = ContactOptions::default().detect(scene, 0, Some(&figure.humanoid)).ok();
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

fn robot_of(entry: &Entry) -> Result<&Arc<Robot>, Failure> {
    let robot = entry.robot.as_ref();
    robot.ok_or_else(|| Failure::argument("the robot must be the result of readCharacter for a URDF or MJCF file"))
}

/// The report of a motion that was retargeted to the robot, or read with the robot as its body.
fn score(reference: &Entry, motion: &Entry, robot: &Arc<Robot>, bones: HumanoidMap) -> Result<Answer, Failure> {
    let clips = motion.on_robot.as_ref().map(|retargeting| retargeting.clips());
    let motion = match clips.and_then(|clips| clips.first()?.robot_motion.clone()) {
        Some(motion) => motion,
        None => RobotMotion::of_arrays(robot, &motion.scene)?,
    };
    let options = RetargetOptions::new().source_bones(bones);
    let judge = Retargeter::onto(Target::Robot(Arc::clone(robot)), options)?;
    let report = judge.judge(reference.scene.clone(), &motion)?;
    Ok((json(&report)?, Vec::new()))
}

fn robot_motion(entry: &Entry) -> Result<Answer, Failure> {
    #[derive(Serialize)]
    struct Joint<'a> {
        name: &'a str,
        lower: f64,
        upper: f64,
        velocity: Option<f64>,
    }
    #[derive(Serialize)]
    struct Motion<'a> {
        fps: f64,
        frames: usize,
        joints: Vec<Joint<'a>>,
        contacts: &'a [[bool; 2]],
    }
    let clips = entry.on_robot.as_ref().map(|retargeting| retargeting.clips());
    let motion = clips.and_then(|clips| clips.first()?.robot_motion.as_ref());
    let (Some(robot), Some(motion)) = (&entry.robot, motion) else {
        return Err(Failure::argument(
            "the scene is not a robot's motion: retarget a motion to a robot that readCharacter has read from URDF or MJCF",
        ));
    };
    let joints = robot.moving_joints().into_iter().map(|link| {
        let joint = &robot.links[link].joint;
        Joint {
            name: &joint.name,
            lower: joint.limits.lower,
            upper: joint.limits.upper,
            velocity: joint.limits.velocity,
        }
    });
    let said = Motion {
        fps: motion.fps,
        frames: motion.frames(),
        joints: joints.collect(),
        contacts: &motion.contacts,
    };
    Ok((json(&said)?, robot_streams::numbers(motion)))
}

fn retarget(
    scenes: &mut Scenes,
    motion: u32,
    character: u32,
    options: &PoseRetargetOptions,
) -> Result<Answer, Failure> {
    #[derive(Serialize)]
    struct Retargeted<'a> {
        #[serde(flatten)]
        scene: SceneAt<'a>,
        reports: Vec<ClipReport>,
    }
    let (entry, target) = (scenes.get(motion)?, scenes.get(character)?);
    let onto = match (&target.character, &target.robot) {
        (Some(file), _) => Target::Character(Arc::clone(file)),
        (None, Some(robot)) => Target::Robot(Arc::clone(robot)),
        (None, None) => Target::from(target.scene.clone()),
    };
    let (source, assumptions) = in_metres(entry)?;
    let mut retargeting = Retargeter::onto(onto, options.retargeting()?)?;
    let source = SourceMotion::converted(source);
    retargeting.add(match options.name() {
        Some(name) => source.named(name),
        None => source,
    })?;
    let limb_angles = options
        .keeps_limb_angles()
        .then(|| retargeting.limb_angles(0))
        .flatten();
    let humanoid = retargeting.humanoid().cloned();
    let (mut provenance, mut reports) = (Vec::new(), Vec::new());
    // A writer adds the provenance later.
    let mut scene = Scene {
        metadata: target.scene.metadata.clone(),
        ..retargeting.scene()
    };
    let on_robot = target.robot.is_some().then(|| Arc::new(retargeting.clone()));
    if let Some(robot) = target.robot.as_ref().filter(|_| !target.scene.meshes.is_empty()) {
        add_links(robot, &mut scene);
    }
    // Use the character of the retargeting, because its skeleton may have a new root.
    let file = match retargeting.target() {
        Target::Character(character) => Some(Arc::clone(character)),
        _ => None,
    };
    for clip in retargeting.into_clips() {
        provenance.push(clip.provenance);
        reports.push(clip.report);
    }
    let entry = Entry::new(scene, file)
        .on_robot(target.robot.clone(), on_robot)
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
