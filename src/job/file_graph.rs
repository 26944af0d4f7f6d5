//! Motion graphs whose clips are read from files. A walk is a path through such a graph: pieces of clips, joined by
//! transitions.

use std::path::{Path, PathBuf};

use mocap_edit::graph::report::Walk;
use mocap_edit::graph::{GraphBuilder, MotionGraph};
use mocap_edit::report::WalkReport;
use mocap_figure::convert::{Conversion, FirstFrame};
use mocap_io::import::Importer;
use mocap_retarget::{RetargetOptions, Retargeter};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::scene::Scene;

use super::files::Files;
use super::graph::GraphJobOptions;
use super::notice::{Listener, say_warnings};
use super::walk::WalkOptions;
use super::{InputOptions, SourceSpace};

/// A motion graph whose clips were read from files. To make a walk, mocap reads the files of its clips a second time.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::job::{FileGraph, GraphJobOptions, InputOptions, SourceSpace, WalkOptions};
///
/// let (read, space) = (InputOptions::default(), SourceSpace::default());
/// let files = ["fixtures/real/cmu_12_01_walk.bvh".into()];
/// let found = FileGraph::compare(&GraphJobOptions::default(), &read, &space, &files)?;
/// let walking: WalkOptions = serde_json::from_str(r#"{"seconds": 6}"#).unwrap(); // longer than the clip
/// let (scene, report) = found.walk(&walking)?;
/// assert_eq!((scene.animations[0].frame_count(), report.frames), (721, 721)); // 6 s at 120 Hz
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct FileGraph {
    graph: MotionGraph,
    builder: GraphBuilder,
    read: InputOptions,
    space: SourceSpace,
    body: Option<Body>,
}

/// The location of a graph's files if all of them are on a disk.
const ON_DISK: Files<'static> = Files {
    given: &[],
    has_disk: true,
};

impl FileGraph {
    /// Compares the motions of files. Without [`GraphJobOptions::on`], all files must have one skeleton. With `on`, all
    /// files must have humanoids.
    ///
    /// # Errors
    /// As [`Importer::import`], with the file; [`Code::InvalidValue`] if the skeletons differ, or if the clips give no
    /// graph.
    pub fn compare(
        graphing: &GraphJobOptions,
        read: &InputOptions,
        space: &SourceSpace,
        paths: &[PathBuf],
    ) -> Result<Self> {
        let clips = Clips::compare(graphing, (read, space), paths, ON_DISK, &mut |_| {})?;
        let graph = clips.graph()?;
        Ok(Self::new(graph, clips))
    }

    /// Reads a graph file, and the clips of the graph.
    ///
    /// # Errors
    /// As [`Importer::import`], with the file; [`Code::InvalidGraph`] if the file is not a graph, or if a clip has
    /// changed since the graph was made.
    pub fn open(file: &Path, read: &InputOptions, space: &SourceSpace) -> Result<Self> {
        let graph = read_graph(file, ON_DISK)?;
        let clips = Clips::of_graph(&graph, (read, space), ON_DISK, &mut |_| {});
        let clips = clips.map_err(|error| in_graph(error, file))?;
        Ok(Self::new(graph, clips))
    }

    fn new(graph: MotionGraph, clips: Clips<'_>) -> Self {
        Self {
            graph,
            builder: clips.builder,
            read: clips.read.clone(),
            space: clips.space.clone(),
            body: clips.body,
        }
    }

    /// The graph.
    pub fn graph(&self) -> &MotionGraph {
        &self.graph
    }

    /// The builder that compared the clips. The builder can compute the distances of any two clips.
    pub fn builder(&self) -> &GraphBuilder {
        &self.builder
    }

    /// Searches the graph for a walk, and computes the motion of the walk.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if no such walk exists, [`Code::InvalidGraph`] if a file has changed since the graph was
    /// made.
    pub fn walk(&self, walking: &WalkOptions) -> Result<(Scene, WalkReport)> {
        let clips = Clips {
            builder: self.builder.clone(),
            read: &self.read,
            space: &self.space,
            body: self.body.clone(),
            files: ON_DISK,
        };
        clips.walk(&self.graph, walking)
    }
}

/// The clips of files in a [`GraphBuilder`], and the options with which the files are read.
pub(super) struct Clips<'a> {
    pub(super) builder: GraphBuilder,
    read: &'a InputOptions,
    space: &'a SourceSpace,
    body: Option<Body>,
    files: Files<'a>,
}

impl<'a> Clips<'a> {
    /// Reads the clips of the inputs, and adds them to a builder.
    pub(super) fn compare(
        graphing: &GraphJobOptions,
        (read, space): (&'a InputOptions, &'a SourceSpace),
        inputs: &[PathBuf],
        files: Files<'a>,
        hear: Listener<'_>,
    ) -> Result<Self> {
        let mut clips = Self {
            builder: GraphBuilder::new(&graphing.options())?,
            read,
            space,
            body: graphing.on.as_deref().map(|file| Body::read(files, file)).transpose()?,
            files,
        };
        for path in inputs {
            let scene = clips.import(path, hear)?;
            clips.add(path, &scene)?;
        }
        Ok(clips)
    }

    /// Reads the clips of a graph again. Refuses a file that has changed since the graph was made.
    pub(super) fn of_graph(
        graph: &MotionGraph,
        (read, space): (&'a InputOptions, &'a SourceSpace),
        files: Files<'a>,
        hear: Listener<'_>,
    ) -> Result<Self> {
        let mut clips = Self {
            builder: GraphBuilder::new(&graph.options)?,
            read,
            space,
            body: Body::of(graph, files)?,
            files,
        };
        for path in files_of(graph) {
            let scene = clips.import(&path, hear)?;
            require_same(graph, &path, &scene)?;
            clips.add(&path, &scene)?;
        }
        Ok(clips)
    }

    fn add(&mut self, path: &Path, scene: &Scene) -> Result<()> {
        let added = self.builder.add(&path.to_string_lossy(), scene);
        added.map_err(|error| error.with_path(path))
    }

    /// The graph of the clips.
    pub(super) fn graph(&self) -> Result<MotionGraph> {
        let mut graph = self.builder.build()?;
        let body = self.body.as_ref();
        graph.body = body.map(|body| (body.file.to_string_lossy().into_owned(), sha256(&body.scene).to_owned()));
        Ok(graph)
    }

    /// Searches the graph of these clips for a walk, and makes the motion of the walk.
    pub(super) fn walk(&self, graph: &MotionGraph, walking: &WalkOptions) -> Result<(Scene, WalkReport)> {
        let found = walking.search(&self.builder.network(graph)?, graph)?;
        let scenes = self.scenes_of(&found, graph)?;
        let used = |clip: usize| scenes.iter().find(|(path, _)| *path == graph.clips[clip].file);
        // A clip that no piece of the walk uses is not read.
        let clips = (0..graph.clips.len()).filter_map(|clip| {
            let (_, scene) = used(clip).or(scenes.first())?;
            Some((scene, graph.clips[clip].animation))
        });
        found.motion(&Vec::from_iter(clips))
    }

    /// The scenes of the files that a walk uses, each once.
    fn scenes_of<'b>(&self, walk: &Walk, graph: &'b MotionGraph) -> Result<Vec<(&'b str, Scene)>> {
        let mut scenes: Vec<(&str, Scene)> = Vec::new();
        for piece in &walk.pieces {
            let file = graph.clips[piece.clip].file.as_str();
            if scenes.iter().all(|(path, _)| *path != file) {
                let scene = self.import(Path::new(file), &mut |_| {})?;
                require_same(graph, Path::new(file), &scene)?;
                scenes.push((file, scene));
            }
        }
        Ok(scenes)
    }

    /// Reads a clip, and drops a rest pose before the motion. The clip keeps its unit and axes, or is retargeted to the
    /// body.
    fn import(&self, path: &Path, hear: Listener<'_>) -> Result<Scene> {
        let in_file = |error: Error| error.with_path(path);
        let importer = self.read.importer().with_own_meshes();
        let mut scene = self.files.import(&importer, path)?;
        say_warnings(&mut scene, path, hear);
        self.space.state(&mut scene);
        if let Some(body) = &self.body {
            return body.with_motions_of(scene).map_err(in_file);
        }
        let conversion = Conversion::new().keep_units(true).first_frame(FirstFrame::DropRestPose);
        conversion.apply(&mut scene).map_err(in_file)?;
        Ok(scene)
    }
}

/// The body to which all clips are retargeted.
#[derive(Clone, Debug)]
struct Body {
    file: PathBuf,
    /// In metres with +Y up, without motions.
    scene: Scene,
}

impl Body {
    fn read(files: Files<'_>, file: &Path) -> Result<Self> {
        let mut scene = files.import(&Importer::new().with_own_meshes(), file)?;
        scene.animations.clear();
        let converted = Conversion::new().apply(&mut scene);
        converted.map_err(|error| error.with_path(file))?;
        Ok(Self {
            file: file.to_owned(),
            scene,
        })
    }

    /// The body that the graph was built for. The body's file must have the SHA-256 that the graph records.
    fn of(graph: &MotionGraph, files: Files<'_>) -> Result<Option<Self>> {
        let Some((file, stated)) = &graph.body else {
            return Ok(None);
        };
        let body = Self::read(files, Path::new(file))?;
        match sha256(&body.scene) {
            own if own == stated => Ok(Some(body)),
            own => Err(changed(&body.file, stated, own)),
        }
    }

    /// Retargets all motions of a scene to the body.
    fn with_motions_of(&self, motion: Scene) -> Result<Scene> {
        let origin = motion.metadata.origin.clone();
        let moved = Retargeter::new(motion, self.scene.clone(), RetargetOptions::new())?;
        let mut scene = moved.scene();
        scene.metadata.origin = origin;
        Ok(scene)
    }
}

/// Reads a graph file.
pub(super) fn read_graph(file: &Path, files: Files<'_>) -> Result<MotionGraph> {
    let graph = MotionGraph::from_json(&files.regular_text(file)?);
    graph.map_err(|error| error.with_path(file))
}

/// Adds the graph's file to an error of the graph itself, not of a clip or a request.
pub(super) fn in_graph(error: Error, file: &Path) -> Error {
    match (error.path(), error.code()) {
        (Some(_), _) | (None, Code::InvalidValue) => error,
        (None, _) => error.with_path(file),
    }
}

/// The files of a graph, each once. The clips of a file are consecutive in the graph.
pub(super) fn files_of(graph: &MotionGraph) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = graph.clips.iter().map(|clip| PathBuf::from(&clip.file)).collect();
    files.dedup();
    files
}

/// Refuses a clip whose file differs from the file that the graph records.
fn require_same(graph: &MotionGraph, file: &Path, scene: &Scene) -> Result<()> {
    let own = sha256(scene);
    let clips = graph.clips.iter().filter(|clip| Path::new(&clip.file) == file);
    match clips.map(|clip| clip.sha256.as_str()).find(|stated| *stated != own) {
        None => Ok(()),
        Some(stated) => Err(changed(file, stated, own)),
    }
}

/// The SHA-256 of the file of a scene.
fn sha256(scene: &Scene) -> &str {
    let origin = scene.metadata.origin.as_ref();
    origin.map(|origin| origin.sha256.as_str()).unwrap_or_default()
}

fn changed(file: &Path, stated: &str, found: &str) -> Error {
    let diagnostic = Diagnostic::new(Code::InvalidGraph, "the file has changed since the graph was made")
        .expected_found(format!("SHA-256 {stated}"), found);
    Error::from(diagnostic).with_path(file)
}
