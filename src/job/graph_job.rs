//! A job that builds a motion graph from its inputs.

use std::path::{Path, PathBuf};

use mocap_edit::graph::{DistanceMatrix, MotionGraph};
use mocap_formats::Export;
use mocap_io::import::MemoryFile;
use mocap_scene::error::Result;
use mocap_scene::files::ReplacePolicy;
use serde::{Deserialize, Serialize};

use super::file_graph::Clips;
use super::files::{Files, Outputs, check_inputs, check_outputs, output_files, policy, write_all, written};
use super::{
    FileOutputOptions, GraphJobOptions, GraphReport, InputOptions, JobReport, Notice, SourceSpace, is_default, refuse,
};

/// Compares motions, and writes their motion graph.
///
/// [`GraphJobOptions`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct GraphJob {
    /// The options for reading the inputs.
    #[serde(default, skip_serializing_if = "is_default")]
    pub read: InputOptions,
    /// The inputs, and the caller's statements about them.
    #[serde(default)]
    pub source: GraphSources,
    /// The options for comparing the frames.
    pub graph: GraphJobOptions,
    /// The file for the distance matrix of two clips, or of one clip with itself: a .png picture or a .npy array. In
    /// the picture, lighter means more similar, and red dots are transitions.
    #[serde(default, skip_serializing_if = "is_default")]
    pub matrix: Option<PathBuf>,
    /// The graph.
    #[serde(default, skip_serializing_if = "is_default")]
    pub write: FileOutputOptions,
}

/// The inputs of a motion graph.
///
/// [`GraphJobOptions`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct GraphSources {
    /// The motion files.
    pub inputs: Vec<PathBuf>,
    /// The unit and the up axis of the inputs.
    #[serde(skip_serializing_if = "is_default")]
    pub space: SourceSpace,
}

impl GraphJob {
    /// Compares the motions of the inputs, and writes nothing. Returns the job's output files with their bytes, the
    /// graph last, and the report. The files of `given` are not read from the disk.
    ///
    /// # Errors
    /// As [`Importer::import`](mocap_io::Importer::import), with the file.
    /// [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) if the skeletons differ, or if the clips give no graph.
    pub fn compare(&self, given: &[MemoryFile<'_>]) -> Result<(Outputs, JobReport)> {
        self.graph_of(Files { given, has_disk: true })
    }

    fn graph_of(&self, files: Files<'_>) -> Result<(Outputs, JobReport)> {
        self.check()?;
        let mut report = JobReport::default();
        let mut hear = |said: Notice<'_>| report.hear(said);
        let (known, inputs) = ((&self.read, &self.source.space), &self.source.inputs);
        let compared = Clips::compare(&self.graph, known, inputs, files, &mut hear)?;
        let output = self.write.output();
        // The matrix is also made if no transition exists.
        let needs_graph = output.is_some() || self.matrix.is_none();
        let graph = needs_graph.then(|| compared.graph()).transpose()?;
        let mut made = Outputs::new();
        if let Some(picture) = &self.matrix {
            made.push((picture.clone(), compared.drawn(graph.as_ref(), picture)?));
        }
        if let Some(graph) = &graph {
            report.graph = Some(GraphReport::of(graph));
            made.extend(output.map(|output| (output.to_owned(), graph.to_json().into_bytes())));
        }
        report.files = output_files(&made);
        Ok((made, report))
    }

    pub(super) fn make_of(&self, files: Files<'_>) -> Result<(Export, JobReport)> {
        let (made, report) = self.graph_of(files)?;
        Ok((written(made), report))
    }

    /// Makes the graph, and writes the requested files.
    pub(super) fn run_of(&self, files: Files<'_>) -> Result<JobReport> {
        let policy = self.policy();
        check_outputs(&policy, self.outputs())?;
        let (made, report) = self.graph_of(files)?;
        write_all(&policy, &made)?;
        Ok(report)
    }

    /// The files that the job writes.
    #[doc(hidden)]
    pub fn outputs(&self) -> impl Iterator<Item = &Path> {
        self.matrix.as_deref().into_iter().chain(self.write.output())
    }

    /// Which files the outputs may replace: no input, and no other file that the job reads.
    pub fn policy(&self) -> ReplacePolicy {
        policy(&self.source.inputs, &self.read, self.graph.on.as_deref()).force(self.write.force)
    }

    fn check(&self) -> Result<()> {
        let is_called = |path: &Path, extensions: &[&str]| {
            let own = path.extension().map(|own| own.to_string_lossy().to_ascii_lowercase());
            own.is_some_and(|own| extensions.contains(&own.as_str()))
        };
        if let Some(matrix) = self.matrix.as_deref()
            && !is_called(matrix, &["png", "npy"])
        {
            let message = format!("{}: the name of a matrix must end in .png or .npy", matrix.display());
            return refuse(&message, "give matrix such a file name");
        }
        let output = self.write.output().filter(|output| *output != Path::new("-"));
        let is_json = output.is_none_or(|output| is_called(output, &["json"]));
        if !is_json || self.write.to.as_deref().is_some_and(|to| to != "json") {
            let message = format!("{}: the name of a graph must end in .json", self.write.output.display());
            return refuse(&message, "give write.output such a file name");
        }
        check_inputs(&self.source.inputs)
    }
}

impl Clips<'_> {
    /// The matrix of the first and the last clip. The file name selects a picture or an array.
    fn drawn(&self, graph: Option<&MotionGraph>, picture: &Path) -> Result<Vec<u8>> {
        let count = self.builder.clips().len();
        if count > 2 {
            let message = format!("a matrix compares two clips, but there are {count}");
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

/// A matrix as a NumPy array.
#[cfg(feature = "npz")]
fn array_of(matrix: &DistanceMatrix) -> Result<Vec<u8>> {
    Ok(crate::arrays::matrix_npy(matrix))
}

#[cfg(not(feature = "npz"))]
fn array_of(_: &DistanceMatrix) -> Result<Vec<u8>> {
    refuse(
        "this build cannot write arrays: it lacks the feature npz",
        "name a picture, .png, in matrix",
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
        "this build cannot draw pictures: it lacks the feature render",
        "name an .npy file in matrix",
    )
}
