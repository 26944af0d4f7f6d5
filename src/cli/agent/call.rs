//! Runs a call of a tool, and makes the answer.

use std::path::{Path, PathBuf};

use mocap::job::{GraphJob, Job, MotionJob, SurveyJob};
use serde_json::{Map, Value, json};

use super::answer::Answer;
use super::brief::{self, value};
use super::listing;
use super::paths;
use super::root::{Root, check_folder, check_output};
use super::schema::{Commands, check_names};
use super::tools::Tool;
use crate::args::{Args, Command, GraphCommand, IndexArgs, RunArgs};
use crate::batch::inputs::{self, InputArgs};
use crate::batch::spread::SpreadArgs;
use crate::{Failure, commands, streams};

pub(super) struct Call<'a> {
    pub(super) root: Root,
    pub(super) commands: &'a Commands,
    pub(super) tool: &'static Tool,
    pub(super) arguments: &'a Map<String, Value>,
}

impl Call<'_> {
    pub(super) fn answer(&mut self) -> Result<Answer, Failure> {
        self.root.check(&Value::Object(self.arguments.clone()))?;
        match self.tool.name {
            "run" => return self.run_job(),
            "list" => return self.list(),
            _ => {}
        }
        paths::check(self.tool, self.arguments)?;
        // A picture is always part of the answer, but the command line requires a file.
        let mut arguments = self.arguments.clone();
        if self.tool.name == "sheet" {
            arguments.entry("output").or_insert("sheet.png".into());
        }
        let (mut args, given) = self.commands.parse(self.tool, &arguments)?;
        let job = match &mut args.command {
            Command::Info(args) => return commands::info::summary(args).map(Answer::new),
            Command::Skeleton(args) => return commands::skeleton::summary(args).map(Answer::new),
            Command::Check(args) => return commands::check::result(args).map(brief::checked),
            Command::Verify(args) => return self.verify(commands::verify::result(args)?),
            Command::Score(args) => return commands::score::result(args).map(Answer::new),
            Command::Find(args) => {
                let found = commands::find::summary(args)?;
                return Ok(Answer::new(json!({"found": found})));
            }
            Command::Index(args) => return self.index(args),
            Command::Match(args) => {
                let beside = args.output.with_file_name("features.bin");
                let is_bones = args.output.extension().is_some_and(|it| it.eq_ignore_ascii_case("bin"));
                let outputs = [Some(&args.output), Some(&beside).filter(|_| is_bones)];
                return self.made(outputs, || commands::matching::summary(args, &given));
            }
            Command::Graph(args) => match &mut args.command {
                Some(GraphCommand::Walk(args)) => {
                    return self.made([Some(&args.output)], || commands::graph::summary_of_walk(args, &given));
                }
                None => return self.graph(args.job(), &args.inputs),
            },
            Command::Survey(_) | Command::Sheet(_) => return self.look(&args),
            Command::Convert(args) => commands::convert::job(args, &given)?,
            Command::Retarget(args) => commands::retarget::job(args, &given)?,
            Command::Robot(args) => commands::robot::job(args, &given)?,
            Command::Edit(args) => commands::edit::job(args, &given)?,
            Command::Clean(args) => commands::clean::job(args, &given)?,
            _ => {
                return Err(Failure::Usage(
                    "mocap mcp cannot run this tool, which is a defect; please report this call".to_owned(),
                ));
            }
        };
        self.job(Job::Motion(job))
    }

    fn is_dry_run(&self) -> Result<bool, Failure> {
        match self.arguments.get("dry-run") {
            None | Some(Value::Null) => Ok(false),
            Some(Value::Bool(is_dry)) => Ok(*is_dry),
            Some(_) => Err(Failure::Usage("\"dry-run\" must be true or false".to_owned())),
        }
    }

    fn list(&self) -> Result<Answer, Failure> {
        check_names(self.tool, self.arguments)?;
        match self.arguments.get("folder") {
            None | Some(Value::Null) => listing::list(Path::new(".")),
            Some(Value::String(folder)) => listing::list(Path::new(folder)),
            Some(_) => Err(Failure::Usage("\"folder\" must be a string".to_owned())),
        }
    }

    fn verify(&self, (verdict, is_alike): (Value, bool)) -> Result<Answer, Failure> {
        let mut answer = Answer::new(verdict);
        if !is_alike {
            answer.add_problem(
                "the file differs from its source: there are findings, or max_error is above max_allowed (both in \
                 metres); a larger max-error allows more",
            );
        }
        Ok(answer)
    }

    /// Runs a command that has no job, and answers with the paths of its outputs. A dry run only states the paths.
    fn made<const N: usize>(
        &mut self,
        outputs: [Option<&PathBuf>; N],
        make: impl FnOnce() -> Result<Value, Failure>,
    ) -> Result<Answer, Failure> {
        let is_dry = self.is_dry_run()?;
        let outputs: Vec<&PathBuf> = outputs.into_iter().flatten().collect();
        outputs.iter().try_for_each(|output| check_output(output))?;
        let mut report = if is_dry { json!({}) } else { make()? };
        report["outputs"] = outputs.iter().map(|output| output.display().to_string()).collect();
        report["dry_run"] = is_dry.into();
        Ok(Answer::new(report))
    }

    /// Builds a database. A dry run lists what the database would contain.
    fn index(&mut self, args: &IndexArgs) -> Result<Answer, Failure> {
        check_output(&args.output)?;
        let found = inputs::find(&args.paths, &args.inputs)?;
        let names: Vec<&str> = found.iter().map(|input| input.relative.as_str()).collect();
        let is_dry = self.is_dry_run()?;
        let output = args.output.display().to_string();
        let count = names.len();
        let mut answer = Answer::new(json!({"output": output, "dry_run": is_dry, "count": count, "inputs": names}));
        if !is_dry {
            match commands::index::run(args) {
                Ok(()) => {}
                // Some inputs are missing from the written database.
                Err(Failure::Some) => answer.is_error = true,
                Err(failure) => return Err(failure),
            }
        }
        Ok(answer)
    }

    /// Draws a picture for the answer. If the call has an output, also writes the picture.
    fn look(&mut self, args: &Args) -> Result<Answer, Failure> {
        let args = match &args.command {
            Command::Survey(args) => return self.survey(&args.job(), &args.inputs, &args.spread),
            Command::Sheet(args) => args,
            _ => {
                return Err(Failure::Usage(
                    "mocap mcp cannot draw with this tool, which is a defect; please report this call".to_owned(),
                ));
            }
        };
        let is_dry = self.is_dry_run()?;
        let output = self.arguments.get("output").and_then(Value::as_str).map(PathBuf::from);
        let output = output.filter(|_| !is_dry);
        if let Some(output) = &output {
            check_output(output)?;
        }
        let drawing = commands::sheet::drawing(args)?;
        if output.is_some() {
            commands::sheet::write(&drawing, args)?;
        }
        let mut answer = Answer::new(json!({"width": drawing.width, "height": drawing.height}));
        answer.picture = Some(drawing.to_png()?);
        if let Some(output) = &output {
            answer.report["output"] = output.display().to_string().into();
        }
        Ok(answer)
    }

    /// Makes a survey. If the call asks for a table, a page or the findings, also writes these files.
    fn survey(&mut self, job: &SurveyJob, inputs: &InputArgs, spread: &SpreadArgs) -> Result<Answer, Failure> {
        let is_dry = self.is_dry_run()?;
        let beside = job.survey.html.iter().chain(&job.survey.sarif).map(PathBuf::as_path);
        for output in beside.chain(job.write.output()) {
            check_output(output)?;
        }
        let (corpus, outputs) = commands::survey::made(job, inputs, spread)?;
        let mut answer = brief::surveyed(&corpus);
        if let Some(problem) = job.survey.problem(&corpus) {
            answer.add_problem(&problem);
        }
        if !is_dry {
            streams::write_all(&outputs, &job.policy())?;
            for report in [Some(&mut answer.report), answer.brief.as_mut()].into_iter().flatten() {
                if let Some((path, _)) = outputs.last() {
                    report["output"] = path.display().to_string().into();
                }
            }
        }
        Ok(answer)
    }

    /// Builds a graph, and draws the matrix of its distances if the call asks for the matrix.
    fn graph(&mut self, job: GraphJob, inputs: &InputArgs) -> Result<Answer, Failure> {
        let graph = job.write.output().map(Path::to_owned);
        let matrix = job.matrix.clone();
        let outputs = [graph.as_ref(), matrix.as_ref()];
        self.made(outputs, || commands::graph::summary(job, inputs))
    }

    fn run_job(&mut self) -> Result<Answer, Failure> {
        let other = self
            .arguments
            .keys()
            .find(|name| !["job", "dry-run"].contains(&name.as_str()));
        match (other, self.arguments.get("job")) {
            (Some(name), _) => Err(Failure::Usage(format!(
                "run has no argument {name:?}; its arguments are job, dry-run"
            ))),
            (None, Some(job @ Value::Object(_))) => self.job(Job::from_json(&job.to_string())?),
            (None, _) => Err(Failure::Usage(
                "run needs \"job\", an object; read mocap://job.schema.json has its schema".to_owned(),
            )),
        }
    }

    /// Runs a job. In a dry run, does everything except writing the output.
    fn job(&mut self, job: Job) -> Result<Answer, Failure> {
        let is_dry = self.is_dry_run()?;
        let job = match job {
            Job::Survey(job) => {
                let args = self.run_args()?;
                return self.survey(&job, &args.inputs, &args.spread);
            }
            Job::Graph(job) => {
                let args = self.run_args()?;
                return self.graph(job, &args.inputs);
            }
            Job::Motion(job) if job.write.is_folder() => return self.folder(&job, is_dry),
            job => job,
        };
        check_output(job.output())?;
        let found = match is_dry {
            true => {
                let (written, report) = job.make(&[])?;
                written.check(job.output(), &job.policy())?;
                report
            }
            false => job.run()?,
        };
        Ok(brief::done(&job, &found, is_dry))
    }

    /// The arguments of `mocap run` without any option.
    fn run_args(&self) -> Result<RunArgs, Failure> {
        let words = ["mocap", "run", "job.json"].map(Into::into);
        match self.commands.parse_words(words)?.0.command {
            Command::Run(args) => Ok(args),
            _ => Err(Failure::Usage(
                "mocap mcp cannot find the command run, which is a defect; please report this call".to_owned(),
            )),
        }
    }

    /// Runs a job with many motions, which writes one file for each motion.
    fn folder(&mut self, job: &MotionJob, is_dry: bool) -> Result<Answer, Failure> {
        let folder = job.write.output.as_path();
        check_folder(folder)?;
        let args = self.run_args()?;
        if is_dry {
            let found = inputs::find(&job.source.inputs, &args.inputs)?;
            let names: Vec<&str> = found.iter().map(|input| input.relative.as_str()).collect();
            let (output, count) = (folder.display().to_string(), names.len());
            let found = json!({"output": output, "dry_run": true, "count": count, "inputs": names});
            let mut answer = Answer::new(found.clone());
            answer.report["job"] = value(job);
            answer.brief = Some(found);
            return Ok(answer);
        }
        let result = commands::run::many(job, &args);
        let mut answer = brief::folder(folder);
        match result {
            Ok(()) => {}
            Err(Failure::Told | Failure::Some) => answer.is_error = true,
            Err(failure) => return Err(failure),
        }
        Ok(answer)
    }
}
