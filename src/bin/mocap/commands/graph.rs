//! `mocap graph`: the motion graph of many clips, and walks over it.

use std::path::{Path, PathBuf};

use mocap::convert::FirstFrame;
use mocap::edit::WalkReport;
use mocap::files::ReplacePolicy;
use mocap::graph::{GraphBuilder, MotionGraph, Network, Walk};
use mocap::job::{Reading, SourceSpace};
use mocap::retargeting::{Retargeting, RetargetingOptions};
use mocap::{Code, Conversion, Diagnostic, Error, Importer, Scene, SkeletonMesh};

use super::{check_json, import_motion, made, output_format, print_json, unknown_extension, write_output};
use crate::args::{AimArgs, Given, GraphArgs, GraphCommand, ThroughArg, WalkArgs};
use crate::batch::inputs;
use crate::report::Voice;
use crate::{Failure, report, streams};

pub(crate) fn run(args: &GraphArgs, given: &Given) -> Result<(), Failure> {
    match &args.command {
        Some(GraphCommand::Walk(args)) => {
            check_json(args.json, &args.output)?;
            let report = walk_over(args, given)?;
            match args.json {
                true => print_json(&report)?,
                false => report::say(&report.to_string()),
            }
            Ok(())
        }
        None => make(args).map(|_| ()),
    }
}

/// Writes a graph; what is in it, for an agent.
pub(crate) fn summary(args: &GraphArgs) -> Result<serde_json::Value, Failure> {
    let graph = make(args)?;
    let clips = graph.iter().flat_map(|graph| &graph.clips);
    let clips: Vec<_> = clips
        .map(|clip| serde_json::json!({"file": clip.file, "frames": clip.frames, "part": clip.part}))
        .collect();
    let transitions = graph.as_ref().map_or(0, |graph| graph.transitions.len());
    Ok(serde_json::json!({"clips": clips, "transitions": transitions}))
}

/// Writes a walk; what `--json` prints.
pub(crate) fn summary_of_walk(args: &WalkArgs, given: &Given) -> Result<serde_json::Value, Failure> {
    walk_over(args, given).map(|report| super::value(&report))
}

/// Writes what is asked for; the graph, if it is.
fn make(args: &GraphArgs) -> Result<Option<MotionGraph>, Failure> {
    if let Some(output) = &args.output
        && output_format(output, args.to.as_deref(), "json")? != "json"
    {
        return Err(unknown_extension(output, ".json"));
    }
    if let Some(matrix) = args.matrix.as_deref()
        && !["png", "npy"].contains(&&*super::extension(matrix))
    {
        return Err(unknown_extension(matrix, ".png or .npy"));
    }
    let mut builder = GraphBuilder::new(&args.options())?;
    let inputs = inputs::find(&args.paths, &args.inputs)?;
    let policy = ReplacePolicy::new(inputs.iter().map(|input| &input.path).chain(&args.on)).force(args.force.force);
    for output in args.output.iter().chain(&args.matrix) {
        if !streams::is_standard(output) {
            policy.check_inputs(output)?;
        }
    }
    let body = args.on.as_deref().map(Body::read).transpose()?;
    for input in &inputs {
        let path = input.path()?;
        let scene = import_clip(&args.read, &args.source, path, body.as_ref())?;
        let added = builder.add(&path.to_string_lossy(), &scene);
        added.map_err(|error| error.with_path(path))?;
    }
    let mut graph = args.output.as_ref().map(|_| builder.build()).transpose()?;
    if let (Some(graph), Some(body)) = (&mut graph, &body) {
        graph.body = Some((body.file.to_string_lossy().into_owned(), body.sha256()));
    }
    if let Some(picture) = &args.matrix {
        draw(&builder, graph.as_ref(), picture, &policy)?;
    }
    if let (Some(output), Some(graph)) = (&args.output, &graph) {
        write_output(&policy, output, graph.to_json().as_bytes())?;
        tell(graph, output);
    }
    Ok(graph)
}

/// The body on which all clips are put.
struct Body {
    file: PathBuf,
    /// In metres with +Y up, without motions.
    scene: Scene,
}

impl Body {
    fn read(file: &Path) -> Result<Self, Failure> {
        let mut scene = streams::import(&Importer::new().skeleton_mesh(SkeletonMesh::None), file)?;
        scene.animations.clear();
        let converted = Conversion::new().apply(&mut scene);
        converted.map_err(|error| error.with_path(file))?;
        Ok(Self {
            file: file.to_owned(),
            scene,
        })
    }

    /// The body of a graph, whose file is to be the one that it was.
    fn of(graph: &MotionGraph) -> Result<Option<Self>, Failure> {
        let Some((file, stated)) = &graph.body else {
            return Ok(None);
        };
        let body = Self::read(Path::new(file))?;
        match body.sha256() == *stated {
            true => Ok(Some(body)),
            false => Err(changed(&body.file, stated, &body.sha256())),
        }
    }

    fn sha256(&self) -> String {
        let origin = self.scene.metadata.origin.as_ref();
        origin.map(|origin| origin.sha256.clone()).unwrap_or_default()
    }

    /// All motions of a scene on the body.
    fn with_motions_of(&self, motion: Scene) -> mocap::Result<Scene> {
        let origin = motion.metadata.origin.clone();
        let moved = Retargeting::new(motion, self.scene.clone(), RetargetingOptions::new())?;
        let mut scene = moved.scene();
        scene.metadata.origin = origin;
        Ok(scene)
    }
}

/// Reads a clip in its own unit and axes, or on the body, without a rest pose before the motion.
fn import_clip(read: &Reading, space: &SourceSpace, path: &Path, body: Option<&Body>) -> Result<Scene, Failure> {
    let mut scene = import_motion(read, path)?;
    space.state(&mut scene);
    let in_file = |error: Error| error.with_path(path);
    if let Some(body) = body {
        return Ok(body.with_motions_of(scene).map_err(in_file)?);
    }
    let conversion = Conversion::new().keep_units(true).first_frame(FirstFrame::DropRestPose);
    conversion.apply(&mut scene).map_err(in_file)?;
    Ok(scene)
}

fn draw(
    builder: &GraphBuilder,
    graph: Option<&MotionGraph>,
    picture: &Path,
    policy: &ReplacePolicy,
) -> Result<(), Failure> {
    let clips = builder.clips();
    if clips.len() > 2 {
        let message = format!("--matrix is of two clips, and there are {}", clips.len());
        return Err(Failure::Usage(message));
    }
    let second = clips.len() - 1;
    let matrix = builder.matrix(0, second)?;
    let transitions = graph.map(|graph| graph.transitions.as_slice()).unwrap_or_default();
    let window = graph.map_or(0, |graph| (graph.options.window * graph.options.rate).round() as usize);
    let between = transitions
        .iter()
        .filter(|transition| transition.from[0] == 0 && transition.to[0] == second)
        .map(|transition| [transition.from[1], transition.to[1] + 1 - window]);
    let bytes = match super::extension(picture).as_str() {
        "npy" => matrix.to_npy(),
        _ => matrix.png(&Vec::from_iter(between))?,
    };
    write_output(policy, picture, &bytes)?;
    report::say(&format!(
        "{}: {} x {} moments",
        picture.display(),
        matrix.columns,
        matrix.rows
    ));
    Ok(())
}

/// Says how large a graph is, and what of its clips is left out.
fn tell(graph: &MotionGraph, output: &Path) {
    let seconds = |frames: usize| frames as f64 / graph.options.rate;
    let all: usize = graph.clips.iter().map(|clip| clip.frames).sum();
    let parts = graph.clips.iter().filter_map(|clip| clip.part);
    let inside: usize = parts.map(|[first, last]| last - first + 1).sum();
    for clip in graph.clips.iter().filter(|clip| clip.part.is_none()) {
        report::say(&format!(
            "{}: no part of the graph: nothing leads to it and back",
            clip.file
        ));
    }
    report::say(&format!(
        "{}: {} among {}; {:.1} of {:.1} s stay: from each moment there a walk reaches all others",
        output.display(),
        report::counted(graph.transitions.len(), "transition"),
        report::counted(graph.clips.len(), "clip"),
        seconds(inside),
        seconds(all)
    ));
}

fn walk_over(args: &WalkArgs, given: &Given) -> Result<WalkReport, Failure> {
    let to = args.to.map(|format| format.extension);
    let format = output_format(&args.output, to, "glb")?;
    let job = args.job(&format);
    let graph = read_graph(&args.graph)?;
    let files = files_of(&graph);
    let body_file = graph.body.iter().map(|(file, _)| PathBuf::from(file));
    let policy = args.policy(&Vec::from_iter(files.iter().cloned().chain(body_file)));
    if !streams::is_standard(&args.output) {
        policy.check_inputs(&args.output)?;
    }
    let voice = &mut Voice::Aloud;
    let maker = made::maker(&job, given, &mut |said| voice.hear(said))?;
    maker.check(&policy, &args.output)?;
    let in_graph = |error: Error| error.with_path(&args.graph);
    let mut builder = GraphBuilder::new(&graph.options).map_err(in_graph)?;
    let body = Body::of(&graph)?;
    let mut scenes = Vec::new();
    for file in &files {
        let scene = import_clip(&args.read, &args.source, file, body.as_ref())?;
        require_same(&graph, file, &scene)?;
        let added = builder.add(&file.to_string_lossy(), &scene);
        added.map_err(|error| error.with_path(file))?;
        scenes.push(scene);
    }
    let network = builder.network(&graph).map_err(in_graph)?;
    let found = search(&args.aim, args.seed, &network, &graph)?;
    let clips = scenes.iter();
    let clips = clips.flat_map(|scene| (0..scene.animations.len()).map(move |animation| (scene, animation)));
    let (scene, report) = found.motion(&clips.collect::<Vec<_>>())?;
    let mut hear = |said: mocap::job::Said<'_>| voice.hear(said);
    let mut source = maker.prepare(scene, &args.graph, &mut hear)?;
    source.name = super::short_name(&args.output);
    let mut made = maker
        .make_of(source, &args.graph, &args.output, &mut hear)
        .map_err(made::refused)?;
    made::tell(&made.written, &args.output, voice);
    streams::save(&mut made.written, &args.output, &policy, given)?;
    Ok(report)
}

/// The walk that is asked for.
fn search(aim: &AimArgs, seed: u64, network: &Network<'_>, graph: &MotionGraph) -> Result<Walk, Failure> {
    if let Some(through) = &aim.through {
        let clips: Result<Vec<_>, Failure> = through
            .iter()
            .map(|named| Ok((clip_named(graph, named)?, named.seconds)))
            .collect();
        return Ok(network.through(&clips?)?);
    }
    if let Some(path) = &aim.path {
        return Ok(network.along(&path.0)?);
    }
    Ok(network.random(aim.seconds.unwrap_or_default(), seed)?)
}

/// The clip of a graph that is named by its path, or by the name of its file.
fn clip_named(graph: &MotionGraph, named: &ThroughArg) -> Result<usize, Failure> {
    let is_path = |file: &str| file == named.file;
    let is_name = |file: &str| Path::new(file).file_name().is_some_and(|name| name == &*named.file);
    let is_stem = |file: &str| Path::new(file).file_stem().is_some_and(|stem| stem == &*named.file);
    let tests: [&dyn Fn(&str) -> bool; 3] = [&is_path, &is_name, &is_stem];
    for is_it in tests {
        let mut found = graph.clips.iter().enumerate().filter(|(_, clip)| is_it(&clip.file));
        match (found.next(), found.next()) {
            (Some((index, _)), None) => return Ok(index),
            (Some(_), Some(_)) => {
                let message = format!("--through: several clips of the graph are called {}", named.file);
                return Err(Failure::Usage(message));
            }
            _ => {}
        }
    }
    let names: Vec<&str> = graph.clips.iter().map(|clip| clip.file.as_str()).take(20).collect();
    Err(Failure::Usage(format!(
        "--through: the graph has no clip {}; it has {}",
        named.file,
        names.join(", ")
    )))
}

/// The largest file of a graph, in bytes: some ten million transitions.
const LARGEST_GRAPH: u64 = 1 << 30;

fn read_graph(file: &Path) -> Result<MotionGraph, Failure> {
    let text = streams::text(file, LARGEST_GRAPH)?;
    Ok(MotionGraph::from_json(&text).map_err(|error| error.with_path(file))?)
}

/// The files of a graph, each once; the clips of a file stand one after another.
fn files_of(graph: &MotionGraph) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = graph.clips.iter().map(|clip| PathBuf::from(&clip.file)).collect();
    files.dedup();
    files
}

/// Refuses a clip whose file is another than that of the graph.
fn require_same(graph: &MotionGraph, file: &Path, scene: &Scene) -> Result<(), Failure> {
    let own = scene.metadata.origin.as_ref().map(|origin| origin.sha256.as_str());
    let clips = graph.clips.iter().filter(|clip| Path::new(&clip.file) == file);
    let stated = clips.map(|clip| clip.sha256.as_str());
    match stated.clone().find(|stated| Some(*stated) != own) {
        None => Ok(()),
        Some(stated) => Err(changed(file, stated, own.unwrap_or_default())),
    }
}

fn changed(file: &Path, stated: &str, found: &str) -> Failure {
    let diagnostic = Diagnostic::new(Code::InvalidGraph, "the file has changed since the graph was made")
        .expected_found(format!("SHA-256 {stated}"), found);
    Error::from(diagnostic).with_path(file).into()
}
