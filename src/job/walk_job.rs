//! A job whose motion is a walk over a motion graph.

use std::path::{Path, PathBuf};

use mocap_edit::EditStep;
use mocap_edit::report::WalkReport;
use mocap_formats::Export;
use mocap_scene::error::Result;
use mocap_scene::files::ReplacePolicy;
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use super::file_graph::{Clips, files_of, in_graph, read_graph};
use super::files::{Files, check_inputs, policy};
use super::notice::Listener;
use super::run::{check_one_file, describe, save};
use super::{
    GraphJobOptions, InputOptions, JobOutput, JobReport, JobTarget, JobWeights, Maker, MotionJob, OutputOptions,
    SourceSpace, Sources, WalkOptions, is_default, refuse,
};

/// A walk over a motion graph. The job changes, retargets and writes the walk like the motion of a file.
///
/// [`WalkOptions`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WalkJob {
    /// The options for reading the clips.
    #[serde(default, skip_serializing_if = "is_default")]
    pub read: InputOptions,
    /// The graph file; with `graph`, the clips.
    #[serde(default)]
    pub source: WalkSources,
    /// The options for comparing the frames of the input clips. Without them, the input is a graph file.
    #[serde(default, skip_serializing_if = "is_default")]
    pub graph: Option<GraphJobOptions>,
    /// The goal of the walk.
    pub walk: WalkOptions,
    /// Steps that change the walk, in this order.
    #[serde(default, skip_serializing_if = "is_default")]
    #[cfg_attr(feature = "schema", schemars(with = "super::Steps"))]
    pub steps: Vec<EditStep>,
    /// The target of retargeting. Default: the walk keeps its skeleton.
    #[serde(default, skip_serializing_if = "is_default")]
    pub target: Option<JobTarget>,
    /// The weights of solvers that differ from their defaults.
    #[serde(default, skip_serializing_if = "is_default")]
    pub weights: JobWeights,
    /// The output.
    #[serde(default)]
    pub write: OutputOptions,
}

/// The inputs of a walk.
///
/// [`WalkOptions`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WalkSources {
    /// The graph file, or the clips.
    pub inputs: Vec<PathBuf>,
    /// The second motions, which steps join, blend or layer with the walk; a step counts them from 2.
    #[serde(skip_serializing_if = "is_default")]
    pub with: Vec<PathBuf>,
    /// The unit and the up axis of the clips.
    #[serde(skip_serializing_if = "is_default")]
    pub space: SourceSpace,
}

impl WalkJob {
    /// The job that changes, retargets and writes the walk as a motion.
    ///
    /// # Errors
    /// [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) for a walk without a goal or with several goals, and
    /// unless there is one input and one output.
    #[doc(hidden)]
    pub fn motion(&self) -> Result<MotionJob> {
        self.check()?;
        Ok(MotionJob {
            read: self.read.clone(),
            source: Sources {
                inputs: self.source.inputs.clone(),
                with: self.source.with.clone(),
                space: self.source.space.clone(),
                ..Sources::default()
            },
            steps: self.steps.clone(),
            target: self.target.clone(),
            weights: self.weights.clone(),
            write: self.write.clone(),
            verify: false,
        })
    }

    /// Makes the walk and its output, and reports the walk. `maker` is a maker of the job [`motion`](Self::motion).
    /// Refuses a walk whose output would replace a clip.
    ///
    /// # Errors
    /// The errors of reading, of the walk and of [`Maker::make_of`], with the file.
    #[doc(hidden)]
    pub fn make_by(&self, maker: &Maker<'_>, hear: Listener<'_>) -> Result<(JobOutput, WalkReport)> {
        let output = self.write.output.as_path();
        let (scene, report) = self.walk_of(maker.files(), hear)?;
        let input = self.input()?;
        let mut source = maker.prepare(scene, input, hear)?;
        let name = output.file_stem().unwrap_or_default();
        source.name = name.to_string_lossy().into_owned();
        Ok((maker.make_of(source, input, output, hear)?, report))
    }

    /// Searches the walk. Refuses a walk whose output would replace a clip.
    fn walk_of(&self, files: Files<'_>, hear: Listener<'_>) -> Result<(Scene, WalkReport)> {
        let (read, space) = (&self.read, &self.source.space);
        if let Some(graphing) = &self.graph {
            let clips = Clips::compare(graphing, (read, space), &self.source.inputs, files, hear)?;
            return clips.walk(&clips.graph()?, &self.walk);
        }
        let file = self.input()?;
        let graph = read_graph(file, files)?;
        if files.has_disk && !self.write.is_stream() {
            let body = graph.body.iter().map(|(file, _)| PathBuf::from(file));
            let clips: Vec<PathBuf> = files_of(&graph).into_iter().chain(body).collect();
            ReplacePolicy::new(&clips).check_inputs(&self.write.output)?;
        }
        let clips = Clips::of_graph(&graph, (read, space), files, hear);
        let made = clips.and_then(|clips| clips.walk(&graph, &self.walk));
        made.map_err(|error| in_graph(error, file))
    }

    pub(super) fn make_of(&self, files: Files<'_>) -> Result<(Export, JobReport)> {
        let mut report = JobReport::default();
        let maker = Maker::of(&self.motion()?, files, &mut |said| report.hear(said))?;
        let (mut made, walk) = self.make_by(&maker, &mut |said| report.hear(said))?;
        report.walk = Some(walk);
        describe(&mut report, &maker, &mut made, &self.write.output);
        Ok((made.written, report))
    }

    pub(super) fn run_of(&self, files: Files<'_>) -> Result<JobReport> {
        let (motion, output) = (self.motion()?, &self.write.output);
        check_one_file(&self.source.inputs, &self.write)?;
        let policy = self.policy();
        policy.check_inputs(output)?;
        let mut report = JobReport::default();
        let maker = Maker::of(&motion, files, &mut |said| report.hear(said))?;
        maker.check(&policy, output)?;
        let (made, walk) = self.make_by(&maker, &mut |said| report.hear(said))?;
        report.walk = Some(walk);
        save(&mut report, &maker, made, output, &policy)?;
        Ok(report)
    }

    /// The policy for replacing files: the output never replaces an input or another file that the job reads.
    pub fn policy(&self) -> ReplacePolicy {
        let body = self.graph.as_ref().and_then(|graphing| graphing.on.as_deref());
        let target = self.target.as_ref().map(JobTarget::file);
        let others = self.source.with.iter().map(AsRef::as_ref).chain(target).chain(body);
        policy(&self.source.inputs, &self.read, others).force(self.write.force)
    }

    fn input(&self) -> Result<&Path> {
        match self.source.inputs.first() {
            Some(input) => Ok(input),
            None => refuse("the job names no input", "name the graph in source.inputs"),
        }
    }

    fn check(&self) -> Result<()> {
        let aims = [
            self.walk.seconds.is_some(),
            self.walk.path.is_some(),
            !self.walk.through.is_empty(),
        ];
        if aims.into_iter().filter(|is_aim| *is_aim).count() != 1 {
            return refuse(
                "the job: a walk needs exactly one of seconds, path and through",
                "name one of them",
            );
        }
        if self.write.is_folder() {
            let message = "the job: a walk is one motion, but write.output is a folder";
            return refuse(message, "name a file in write.output");
        }
        if self.graph.is_none() && self.source.inputs.len() > 1 {
            return refuse(
                "the job: a walk uses one graph",
                "name one graph in source.inputs. Or add graph to the job; then source.inputs are its clips",
            );
        }
        check_inputs(&self.source.inputs)
    }
}
