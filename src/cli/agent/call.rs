//! A call of a tool.

use std::fs;
use std::path::{Path, PathBuf};

use mocap::job::{Job, JobReport};
use mocap::survey::{ClipRow, Corpus, Quality};
use serde_json::{Map, Value, json};

use super::answer::Answer;
use super::root::{Root, check_folder, check_output};
use super::schema::Commands;
use super::tools::Tool;
use crate::args::{Args, Command, GraphCommand, IndexArgs, InputArgs, RunArgs, SpreadArgs};
use crate::batch::inputs;
use crate::batch::manifest::Manifest;
use crate::{Failure, commands, streams};

/// How many clips of a survey stand in its answer.
const MOST_CLIPS: usize = 50;

pub(super) struct Call<'a> {
    pub(super) root: Root,
    pub(super) commands: &'a Commands,
    pub(super) tool: &'static Tool,
    pub(super) arguments: &'a Map<String, Value>,
}

impl Call<'_> {
    pub(super) fn answer(&mut self) -> Result<Answer, Failure> {
        self.root.check(&Value::Object(self.arguments.clone()))?;
        if self.tool.name == "run" {
            return self.run_job();
        }
        // A picture goes into the answer, whether it is written or not; the command line asks for a file.
        let mut arguments = self.arguments.clone();
        if self.tool.name == "sheet" {
            arguments.entry("output").or_insert("sheet.png".into());
        }
        let (mut args, given) = self.commands.parse(self.tool, &arguments)?;
        let job = match &mut args.command {
            Command::Info(args) => return commands::info::summary(args).map(Answer::new),
            Command::Skeleton(args) => return commands::skeleton::summary(args).map(Answer::new),
            Command::Check(args) => return self.check(commands::check::result(args)?),
            Command::Verify(args) => return self.verify(commands::verify::result(args)?),
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
            _ => return Err(Failure::Usage("the tool has no command".to_owned())),
        };
        self.job(job)
    }

    fn is_dry_run(&self) -> Result<bool, Failure> {
        match self.arguments.get("dry-run") {
            None | Some(Value::Null) => Ok(false),
            Some(Value::Bool(is_dry)) => Ok(*is_dry),
            Some(_) => Err(Failure::Usage("\"dry-run\" must be true or false".to_owned())),
        }
    }

    fn check(&self, (files, are_whole): (Value, bool)) -> Result<Answer, Failure> {
        let mut answer = Answer::new(json!({"files": files}));
        answer.is_error = !are_whole;
        Ok(answer)
    }

    fn verify(&self, (verdict, is_alike): (Value, bool)) -> Result<Answer, Failure> {
        let mut answer = Answer::new(verdict);
        answer.is_error = !is_alike;
        Ok(answer)
    }

    /// What a command makes for which there is no job; a dry run says where it would be.
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

    /// A database; a dry run lists what would be in it.
    fn index(&mut self, args: &IndexArgs) -> Result<Answer, Failure> {
        check_output(&args.output)?;
        let found = inputs::find(&args.paths, &args.inputs)?;
        let names: Vec<&str> = found.iter().map(|input| input.relative.as_str()).collect();
        let is_dry = self.is_dry_run()?;
        let output = args.output.display().to_string();
        let mut answer = Answer::new(json!({"output": output, "inputs": names, "dry_run": is_dry}));
        if !is_dry {
            match commands::index::run(args) {
                Ok(()) => {}
                Err(Failure::Told | Failure::Some) => answer.is_error = true,
                Err(failure) => return Err(failure),
            }
        }
        Ok(answer)
    }

    /// A picture, which may be written besides.
    fn look(&mut self, args: &Args) -> Result<Answer, Failure> {
        let args = match &args.command {
            Command::Survey(args) => return self.survey(&args.job(), &args.inputs, &args.spread),
            Command::Sheet(args) => args,
            _ => return Err(Failure::Usage("the tool draws nothing".to_owned())),
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

    /// A survey, of which a table, a page and the findings may be written besides.
    fn survey(&mut self, job: &Job, inputs: &InputArgs, spread: &SpreadArgs) -> Result<Answer, Failure> {
        let is_dry = self.is_dry_run()?;
        let survey = job
            .survey
            .iter()
            .flat_map(|survey| [&survey.html, &survey.sarif])
            .flatten();
        let table = Some(&job.write.output).filter(|output| !output.as_os_str().is_empty());
        for output in survey.chain(table) {
            check_output(output)?;
        }
        let (corpus, outputs) = commands::survey::made(job, inputs, spread)?;
        let mut answer = surveyed(&corpus);
        if let Some(problem) = job.survey.as_ref().and_then(|survey| survey.problem(&corpus)) {
            answer.report["problem"] = problem.into();
            answer.is_error = true;
        }
        if !is_dry {
            streams::write_all(&outputs, &job.policy())?;
            if let Some((path, _)) = outputs.last() {
                answer.report["output"] = path.display().to_string().into();
            }
        }
        Ok(answer)
    }

    /// A graph, and the matrix of its distances.
    fn graph(&mut self, job: Job, inputs: &InputArgs) -> Result<Answer, Failure> {
        let graph = Some(job.write.output.clone()).filter(|output| !output.as_os_str().is_empty());
        let matrix = job.graph.as_ref().and_then(|graphing| graphing.matrix.clone());
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
                "run has no argument {name:?}; it has job, dry-run"
            ))),
            (None, Some(job @ Value::Object(_))) => self.job(Job::from_json(&job.to_string())?),
            (None, _) => Err(Failure::Usage(
                "run needs \"job\", an object; its schema is that of the tool".to_owned(),
            )),
        }
    }

    /// Does a job, or all of it but writing.
    fn job(&mut self, job: Job) -> Result<Answer, Failure> {
        let is_dry = self.is_dry_run()?;
        if job.survey.is_some() {
            job.check_survey()?;
            let args = self.run_args()?;
            return self.survey(&job, &args.inputs, &args.spread);
        }
        if job.graph.is_some() && job.walk.is_none() {
            let args = self.run_args()?;
            return self.graph(job, &args.inputs);
        }
        if job.write.is_folder() {
            return self.folder(&job, is_dry);
        }
        check_output(&job.write.output)?;
        let found = match is_dry {
            true => {
                let (written, report) = job.make(&[])?;
                written.check(&job.write.output, &job.policy())?;
                report
            }
            false => job.run()?,
        };
        Ok(done(&job, &found, is_dry))
    }

    /// The options of `mocap run` as they are by default.
    fn run_args(&self) -> Result<RunArgs, Failure> {
        let words = ["mocap", "run", "job.json"].map(Into::into);
        match self.commands.parse_words(words)?.0.command {
            Command::Run(args) => Ok(args),
            _ => Err(Failure::Usage("run is no command".to_owned())),
        }
    }

    /// A job with many motions, each into a file of its own.
    fn folder(&mut self, job: &Job, is_dry: bool) -> Result<Answer, Failure> {
        let folder = job.write.output.as_path();
        check_folder(folder)?;
        let args = self.run_args()?;
        if is_dry {
            let found = inputs::find(&job.source.inputs, &args.inputs)?;
            let names: Vec<&str> = found.iter().map(|input| input.relative.as_str()).collect();
            return Ok(Answer::new(
                json!({"dry_run": true, "inputs": names, "job": value(job)}),
            ));
        }
        let result = commands::run::many(job, &args);
        let mut answer = Answer::new(json!({
            "output": folder.display().to_string(),
            "motions": records(folder),
        }));
        match result {
            Ok(()) => {}
            Err(Failure::Told | Failure::Some) => answer.is_error = true,
            Err(failure) => return Err(failure),
        }
        Ok(answer)
    }
}

fn value(found: &impl serde::Serialize) -> Value {
    serde_json::to_value(found).unwrap_or_default()
}

/// What a job has done.
fn done(job: &Job, found: &JobReport, is_dry: bool) -> Answer {
    let output = job.write.output.display().to_string();
    let mut report = value(found);
    report["output"] = output.as_str().into();
    report["dry_run"] = is_dry.into();
    let clips = found.clips.iter().map(
        |clip| json!({"clip": clip.name(), "verdict": clip.verdict().as_str(), "mean_degrees": clip.mean_degrees()}),
    );
    let brief = json!({
        "output": output,
        "dry_run": is_dry,
        "files": value(&found.files),
        "notes": found.notes.iter().take(MOST_CLIPS).collect::<Vec<_>>(),
        "warnings": found.warnings.iter().take(MOST_CLIPS).map(ToString::to_string).collect::<Vec<_>>(),
        "steps": found.steps.iter().take(MOST_CLIPS).map(ToString::to_string).collect::<Vec<_>>(),
        "clips": clips.take(MOST_CLIPS).collect::<Vec<_>>(),
        "walk": found.walk.as_ref().map(value),
        "error": found.error.as_ref().map(value),
        "verification": found.verification.as_ref().map(|found| {
            json!({
                "frames": found.frames,
                "joints": found.joints,
                "max_error": found.max_error,
                "rms_error": found.rms_error,
            })
        }),
        "problem": found.problem,
    });
    let mut answer = Answer::new(report);
    answer.is_error = found.problem.is_some();
    answer.brief = Some(brief);
    answer
}

/// What the manifest of a folder says of each motion, without the reports.
fn records(folder: &Path) -> Vec<Value> {
    let text = fs::read_to_string(Manifest::path(folder, None)).unwrap_or_default();
    let records = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let brief = records.map(|record| {
        let keep = |(key, value): (&str, &Value)| (!value.is_null()).then(|| (key.to_owned(), value.clone()));
        let kept = ["input", "output", "error", "warnings", "max_error"];
        Value::Object(kept.iter().filter_map(|key| keep((*key, &record[*key]))).collect())
    });
    brief.collect()
}

/// The clips of a survey: what to choose by, the best first; the report has every column.
fn surveyed(corpus: &Corpus) -> Answer {
    let mut rows: Vec<&ClipRow> = corpus.rows().collect();
    rows.sort_by(|a, b| {
        (a.verdict, b.quality)
            .partial_cmp(&(b.verdict, a.quality))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let brief = |row: &&ClipRow| {
        json!({
            "file": row.file,
            "clip": row.clip,
            "verdict": row.verdict.as_str(),
            "quality": row.quality,
            "reasons": row.reasons,
            "error": row.error,
            "seconds": row.seconds,
            "frames": row.frames,
            "distance": row.distance,
            "walking": row.walking,
            "running": row.running,
            "standing": row.standing,
            "twin_of": row.twin_of,
        })
    };
    let verdicts: Map<String, Value> = Quality::ALL
        .iter()
        .map(|verdict| {
            let count = rows.iter().filter(|row| row.verdict == *verdict).count();
            (verdict.as_str().to_owned(), count.into())
        })
        .collect();
    let clips: Vec<Value> = rows.iter().take(MOST_CLIPS).map(brief).collect();
    let shown = json!({"count": rows.len(), "verdicts": verdicts, "clips": clips});
    let mut answer = Answer::new(json!({"count": rows.len(), "clips": value(&rows)}));
    answer.brief = Some(shown);
    answer
}
