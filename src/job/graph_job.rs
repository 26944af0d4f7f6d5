//! Motion graphs as jobs: the graph of the inputs instead of an output of their motion, and walks as motions.

use std::path::{Path, PathBuf};

use mocap_edit::WalkReport;
use mocap_edit::graph::{DistanceMatrix, MotionGraph};
use mocap_io::import::MemoryFile;
use mocap_scene::error::Result;
use mocap_scene::files::ReplacePolicy;
use mocap_scene::scene::Scene;

use super::file_graph::{Clips, files_of, in_graph, read_graph};
use super::files::{Files, check_outputs, write_all};
use super::graph::{GraphReport, Graphing};
use super::said::{Hear, Said};
use super::walk::Walking;
use super::{Job, JobReport, OutputFile, SourceFrames, SourceMap, Sources, file_name, refuse};

/// Files that are to be written, with their bytes.
type Outputs = Vec<(PathBuf, Vec<u8>)>;

impl Job {
    /// Compares the motions of the inputs, as `graph` says: the files that the job names, with their bytes, the graph
    /// last, and what there is to report. Nothing is written. The files of `given` are not read from the disk.
    ///
    /// # Errors
    /// As [`Importer::import`](mocap_io::Importer::import), with the file.
    /// [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) where the skeletons differ, where there is no graph, and
    /// for what a graph does not heed.
    pub fn compare(&self, given: &[MemoryFile<'_>]) -> Result<(Outputs, JobReport)> {
        let graphing = self.graph.clone().unwrap_or_default();
        self.graph_of(&graphing, Files { given, has_disk: true })
    }

    pub(super) fn graph_of(&self, graphing: &Graphing, files: Files<'_>) -> Result<(Outputs, JobReport)> {
        self.check_graph(graphing)?;
        self.refuse_folders()?;
        let mut report = JobReport::default();
        let mut hear = |said: Said<'_>| report.hear(said);
        let compared = Clips::compare(graphing, (&self.read, &self.source), files, &mut hear)?;
        let output = &self.write.output;
        // The matrix of clips without a transition is made too.
        let needs_graph = !output.as_os_str().is_empty() || graphing.matrix.is_none();
        let graph = needs_graph.then(|| compared.graph()).transpose()?;
        let mut made = Outputs::new();
        if let Some(picture) = &graphing.matrix {
            made.push((picture.clone(), compared.drawn(graph.as_ref(), picture)?));
        }
        if let Some(graph) = &graph {
            report.graph = Some(GraphReport::of(graph));
            if !output.as_os_str().is_empty() {
                made.push((output.clone(), graph.to_json().into_bytes()));
            }
        }
        let of_output = |(path, bytes): &(PathBuf, Vec<u8>)| OutputFile {
            name: file_name(path),
            bytes: bytes.len(),
        };
        report.files = made.iter().map(of_output).collect();
        Ok((made, report))
    }

    /// Makes a graph, and writes what it is asked to.
    pub(super) fn run_graph(&self, graphing: &Graphing, files: Files<'_>) -> Result<JobReport> {
        let policy = self.policy();
        let outputs = graphing.matrix.iter().chain([&self.write.output]);
        check_outputs(&policy, outputs.filter(|output| !output.as_os_str().is_empty()))?;
        let (made, report) = self.graph_of(graphing, files)?;
        write_all(&policy, &made)?;
        Ok(report)
    }

    /// Refuses what a graph would not heed: steps, another body than that of the graph, options of motions.
    fn check_graph(&self, graphing: &Graphing) -> Result<()> {
        let source = Sources {
            inputs: self.source.inputs.clone(),
            space: self.source.space.clone(),
            ..Sources::default()
        };
        if self.changes_motion(&source) {
            return refuse(
                "the job: a graph changes no motion, and is written as JSON",
                "leave out steps, target, all of source but inputs and space, and all of write but output, to and force; \
                 graph.on puts the clips on one body",
            );
        }
        let is_called = |path: &Path, extensions: &[&str]| {
            let own = path.extension().map(|own| own.to_string_lossy().to_ascii_lowercase());
            own.is_some_and(|own| extensions.contains(&own.as_str()))
        };
        if let Some(matrix) = graphing.matrix.as_deref()
            && !is_called(matrix, &["png", "npy"])
        {
            let message = format!("{}: the name of a matrix must end in .png or .npy", matrix.display());
            return refuse(&message, "name the file of graph.matrix so");
        }
        let output = &self.write.output;
        let is_json = match self.write.is_stream() || output.as_os_str().is_empty() {
            true => true,
            false => is_called(output, &["json"]),
        };
        if !is_json || self.write.to.as_deref().is_some_and(|to| to != "json") {
            let message = format!("{}: the name of a graph must end in .json", output.display());
            return refuse(&message, "name the file of write.output so");
        }
        match self.source.inputs.is_empty() {
            true => refuse("the job names no input", "name files in source.inputs"),
            false => Ok(()),
        }
    }
}

impl Job {
    /// Makes the walk that the job asks for, and says what it is. A walk that would replace a clip is not made.
    pub(super) fn walk_of(
        &self,
        walking: &Walking,
        files: Files<'_>,
        output: &Path,
        hear: Hear<'_>,
    ) -> Result<(Scene, WalkReport)> {
        if let Some(graphing) = &self.graph {
            let clips = Clips::compare(graphing, (&self.read, &self.source), files, hear)?;
            return clips.walk(&clips.graph()?, walking);
        }
        let file = self.source.inputs[0].as_path();
        let graph = read_graph(file, files)?;
        if files.has_disk && !self.write.is_stream() {
            let body = graph.body.iter().map(|(file, _)| PathBuf::from(file));
            let clips: Vec<PathBuf> = files_of(&graph).into_iter().chain(body).collect();
            ReplacePolicy::new(&clips).check_inputs(output)?;
        }
        let clips = Clips::of_graph(&graph, (&self.read, &self.source.space), files, hear);
        let made = clips.and_then(|clips| clips.walk(&graph, walking));
        made.map_err(|error| in_graph(error, file))
    }

    /// Refuses what a walk would not heed.
    pub(super) fn check_walk(&self, walking: &Walking) -> Result<()> {
        let aims = [
            walking.seconds.is_some(),
            walking.path.is_some(),
            !walking.through.is_empty(),
        ];
        if aims.into_iter().filter(|is_aim| *is_aim).count() != 1 {
            return refuse(
                "the job: a walk has one of seconds, path and through",
                "name one of them",
            );
        }
        let source = &self.source;
        if source.frames != SourceFrames::default() || source.map != SourceMap::default() {
            return refuse(
                "the job: a walk is of whole clips with the bones that are found",
                "leave out source.frames and source.map",
            );
        }
        let matrix = self.graph.as_ref().and_then(|graphing| graphing.matrix.as_ref());
        if self.write.verify || matrix.is_some() || self.survey.is_some() {
            return refuse(
                "the job: a walk is one motion, of many inputs",
                "leave out write.verify, graph.matrix and survey",
            );
        }
        if self.write.is_folder() {
            let message = "the job: a walk is one motion, and write.output is a folder";
            return refuse(message, "name a file in write.output");
        }
        match (&self.graph, source.inputs.len()) {
            (_, 0) => refuse("the job names no input", "name the graph in source.inputs"),
            (None, 2..) => refuse(
                "the job: a walk is over one graph",
                "name one graph in source.inputs, or put graph into the job, and the inputs are its clips",
            ),
            _ => Ok(()),
        }
    }
}

impl Clips<'_> {
    /// The matrix of the first and the last clip, as a picture or as an array, by the name of the file.
    fn drawn(&self, graph: Option<&MotionGraph>, picture: &Path) -> Result<Vec<u8>> {
        let count = self.builder.clips().len();
        if count > 2 {
            let message = format!("a matrix is of two clips, and there are {count}");
            return refuse(&message, "name two clips, or leave the matrix out");
        }
        let second = count.saturating_sub(1);
        let matrix: DistanceMatrix = self.builder.matrix(0, second)?;
        let extension = picture.extension().unwrap_or_default();
        if extension.eq_ignore_ascii_case("npy") {
            return array_of(&matrix);
        }
        picture_of(&matrix, graph, second)
    }
}

/// A matrix as an array of NumPy.
#[cfg(feature = "npz")]
fn array_of(matrix: &DistanceMatrix) -> Result<Vec<u8>> {
    Ok(crate::arrays::matrix_npy(matrix))
}

#[cfg(not(feature = "npz"))]
fn array_of(_: &DistanceMatrix) -> Result<Vec<u8>> {
    refuse(
        "this build writes no arrays: it has not the feature npz",
        "name a picture, .png, in graph.matrix",
    )
}

/// A picture of a matrix, with the transitions between the first clip and the second as dots.
#[cfg(feature = "render")]
fn picture_of(matrix: &DistanceMatrix, graph: Option<&MotionGraph>, second: usize) -> Result<Vec<u8>> {
    let transitions = graph.map(|graph| graph.transitions.as_slice()).unwrap_or_default();
    let window = graph.map_or(0, |graph| graph.options.frames());
    let between = transitions
        .iter()
        .filter(|transition| transition.from[0] == 0 && transition.to[0] == second)
        .map(|transition| [transition.from[1], transition.to[1] + 1 - window]);
    mocap_render::distance_matrix_png(matrix, &Vec::from_iter(between))
}

#[cfg(not(feature = "render"))]
fn picture_of(_: &DistanceMatrix, _: Option<&MotionGraph>, _: usize) -> Result<Vec<u8>> {
    refuse(
        "this build draws no pictures: it has not the feature render",
        "name an array, .npy, in graph.matrix",
    )
}
