//! The options of `mocap edit`.

use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Command, FromArgMatches};
use mocap::edit::{EditStep, Loop, ValueKind};
use mocap::job::{Length, MotionJob};

use super::{OwnArgs, ViewArgs};

#[derive(Debug, clap::Args)]
pub(crate) struct EditArgs {
    /// The motion to change, then the motions that steps join, blend or layer with it. If the output is a folder: the
    /// motions to change, folders and wildcards
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) inputs: Vec<PathBuf>,
    /// A motion that steps join, blend or layer with each input; repeatable
    #[arg(long, value_name = "FILE")]
    pub(crate) with: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) steps: Steps,
    /// Write the contacts of feet and hands in the changed motion: .json or .npz
    #[arg(id = "contacts-file", long, alias = "contacts", value_name = "FILE")]
    pub(crate) contacts: Option<PathBuf>,
    /// Draw curves of the changed motion: .svg or .png. If the last step is an in-between, its keys are marked
    #[arg(long, value_name = "FILE", requires = "joint")]
    pub(crate) curves: Option<PathBuf>,
    /// A joint to draw, by its name or its bone; repeatable
    #[arg(long, value_name = "NAME", requires = "curves")]
    pub(crate) joint: Vec<String>,
    /// Print what each step changed as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Open a page with the motion before and after in the browser
    #[arg(long)]
    pub(crate) view: bool,
    #[command(flatten)]
    pub(crate) own: OwnArgs,
}

impl EditArgs {
    /// The arguments of `mocap view` that show the motion before the steps.
    pub(crate) fn before(&self) -> ViewArgs {
        ViewArgs {
            source: self.own.source.clone(),
            map: self.own.map.clone(),
            read: self.own.read.clone(),
            ..ViewArgs::of_file(self.inputs[0].clone())
        }
    }

    /// The job, with an output of the format of `extension`. Contacts and curves are not part of the job.
    pub(crate) fn job(&self, extension: &str) -> MotionJob {
        let (motions, others) = self.inputs.split_at(match self.own.is_many() {
            true => self.inputs.len(),
            false => 1,
        });
        let with = [others, &self.with].concat();
        self.own.job(motions, with, self.steps.0.clone(), extension)
    }
}

/// The steps in the given order: each --step, and --loop-frames as a step.
#[derive(Debug)]
pub(crate) struct Steps(pub(crate) Vec<EditStep>);

impl clap::Args for Steps {
    fn augment_args(command: Command) -> Command {
        let step = Arg::new("step")
            .value_name("NAME[:key=value,...]")
            .value_parser(parse_step)
            .help("A step, such as smooth:cut-off=8; steps are applied in the order given");
        let cut = Arg::new("loop-frames")
            .alias("loop")
            .value_name("A..B")
            .value_parser(parse_loop)
            .help("Cut the motion to a loop from frame A to frame B, as the step loop:frames=A..B does");
        [step, cut].into_iter().fold(command, |command, arg| {
            let name = arg.get_id().clone();
            command.arg(arg.long(name).action(ArgAction::Append))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Steps {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = ["step", "loop-frames"].into_iter().flat_map(|name| {
            let steps = matches.get_many::<EditStep>(name).into_iter().flatten();
            matches.indices_of(name).into_iter().flatten().zip(steps)
        });
        let mut given: Vec<_> = given.collect();
        given.sort_by_key(|(position, _)| *position);
        Ok(Self(given.into_iter().map(|(_, step)| step.clone()).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn parse_loop(text: &str) -> Result<EditStep, String> {
    // A frame number may also have the suffix `f`, as in other options.
    let frame = |frame: &str| frame.strip_suffix('f').unwrap_or(frame).parse::<usize>().ok();
    let frames = text
        .split_once("..")
        .and_then(|(first, last)| Some([frame(first)?, frame(last)?]));
    match frames {
        Some(frames) => Ok(Loop::new().frames(Some(frames)).into()),
        None => Err("it must be two frames, such as 10..140".to_owned()),
    }
}

fn parse_step(text: &str) -> Result<EditStep, String> {
    if let Some(question) = question_of_lengths(text) {
        return Err(question);
    }
    text.parse().map_err(|error: mocap::Error| {
        let diagnostic = error.diagnostic();
        match &diagnostic.help {
            Some(help) => format!("{}; {help}", diagnostic.message),
            None => diagnostic.message.clone(),
        }
    })
}

/// The question to ask if a step has a length without a unit.
fn question_of_lengths(text: &str) -> Option<String> {
    let (name, options) = text.split_once(':')?;
    let step = EditStep::ALL.iter().find(|step| step.name == name)?;
    let is_length = |name: &str| {
        let mut lengths = step.keys.iter().filter(|key| key.takes == ValueKind::Metres);
        lengths.any(|key| key.field == name.trim().replace('-', "_"))
    };
    let options = options.split(',').filter_map(|option| option.split_once('='));
    let mut lengths = options.filter(|(name, _)| is_length(name));
    lengths.find_map(|(name, value)| Some(format!("{name}={value}: {}", Length::question(value)?)))
}

/// The names of the steps.
pub(super) fn names_of_steps() -> String {
    let mut text = "Steps (mocap edit --help prints their options):".to_owned();
    let mut length = WIDTH;
    for step in EditStep::ALL {
        if length + 1 + step.name.len() > WIDTH {
            text += "\n ";
            length = 1;
        }
        text += &format!(" {}", step.name);
        length += 1 + step.name.len();
    }
    text
}

/// The width of the help, in columns.
const WIDTH: usize = 100;

/// The steps, with their help in a second column.
pub(super) fn steps() -> String {
    let name = EditStep::ALL
        .iter()
        .map(|step| step.name.len())
        .max()
        .unwrap_or_default();
    let indent = name + 4;
    let mut text = "Steps (S: seconds, M: a length such as 5cm, N: a number; a point M/M/M is in metres):\n".to_owned();
    for step in EditStep::ALL {
        let mut line = format!("  {:<name$}  ", step.name);
        for word in step.to_string().split(' ') {
            if line.len() + word.len() > WIDTH {
                text += &format!("{}\n", line.trim_end());
                line = " ".repeat(indent);
            }
            line += &format!("{word} ");
        }
        text += &format!("{}\n", line.trim_end());
    }
    text
}
