//! The options of `mocap edit`.

use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Command, FromArgMatches};
use mocap::edit::{EditStep, Loop};
use mocap::job::{Reading, SourceMap, SourceSpace};

use super::batch::is_folder;
use super::{ForceArgs, InputArgs, OutputFormat, PrintJobArgs, SpreadArgs, WriteArgs};

#[derive(Debug, clap::Args)]
#[command(after_help = steps())]
pub(crate) struct EditArgs {
    /// The motion to change, and after it those that steps join, blend or layer with it; with a folder as output the
    /// motions to change, folders and wildcards
    #[arg(required = true, value_name = "IN")]
    pub(crate) inputs: Vec<PathBuf>,
    /// The file to write, in any format of mocap formats, or - for standard output. If it is a folder, or ends in /,
    /// each motion gets a file of its own in it, beside a manifest
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output, or of the outputs in a folder [default: glb]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Option<OutputFormat>,
    /// A motion that steps join, blend or layer with each motion; once for each
    #[arg(long, value_name = "FILE")]
    pub(crate) with: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) steps: Steps,
    /// Frames per second of the motions before the first step, at the same speed; for an input that states no valid
    /// rate, its rate. The step resample does it later
    #[arg(long, value_name = "RATE", value_parser = Reading::parse_rate)]
    pub(crate) fps: Option<f64>,
    /// Write when feet and hands are at rest in the changed motion: .json or .npz
    #[arg(long, value_name = "FILE")]
    pub(crate) contacts: Option<PathBuf>,
    /// Draw curves of the changed motion: .svg or .png; the keys of an in-between are marked if it is the last step
    #[arg(long, value_name = "FILE", requires = "joint")]
    pub(crate) curves: Option<PathBuf>,
    /// A joint to draw; once for each
    #[arg(long, value_name = "NAME", requires = "curves")]
    pub(crate) joint: Vec<String>,
    /// Print what each step changed as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Compare the written file with its source, as `mocap verify` does
    #[arg(long)]
    pub(crate) verify: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Skip motions that were changed in the same steps, according to the manifest, and are unchanged
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: Reading,
    #[command(flatten)]
    pub(crate) many: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
    #[command(flatten)]
    pub(crate) print: PrintJobArgs,
}

impl EditArgs {
    /// Whether the output is a folder, with an output of each motion.
    pub(crate) fn is_many(&self) -> bool {
        is_folder(&self.output)
    }
}

/// The steps in the order given: those of --step, and --loop, which is one of them.
#[derive(Debug)]
pub(crate) struct Steps(pub(crate) Vec<EditStep>);

impl clap::Args for Steps {
    fn augment_args(command: Command) -> Command {
        let step = Arg::new("step")
            .value_name("NAME[:key=value,...]")
            .value_parser(parse_step)
            .help("A step, such as smooth:cut-off=8; steps are applied in the order given");
        let cut = Arg::new("loop")
            .value_name("A..B")
            .value_parser(parse_loop)
            .help("Cut to the loop from frame A to frame B: the step loop:frames=A..B");
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
        let given = ["step", "loop"].into_iter().flat_map(|name| {
            let steps = matches.get_many::<EditStep>(name).into_iter().flatten();
            matches.indices_of(name).into_iter().flatten().zip(steps)
        });
        let mut given: Vec<_> = given.collect();
        given.sort_by_key(|(place, _)| *place);
        Ok(Self(given.into_iter().map(|(_, step)| step.clone()).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn parse_loop(text: &str) -> Result<EditStep, String> {
    let frame = |frame: &str| frame.parse::<usize>().ok();
    let frames = text
        .split_once("..")
        .and_then(|(first, last)| Some([frame(first)?, frame(last)?]));
    match frames {
        Some(frames) => Ok(Loop::new().frames(Some(frames)).into()),
        None => Err("it must be two frames, such as 10..140".to_owned()),
    }
}

fn parse_step(text: &str) -> Result<EditStep, String> {
    text.parse().map_err(|error: mocap::Error| {
        let diagnostic = error.diagnostic();
        match &diagnostic.help {
            Some(help) => format!("{}; {help}", diagnostic.message),
            None => diagnostic.message.clone(),
        }
    })
}

/// The steps, with their help in a column of its own.
fn steps() -> String {
    const WIDTH: usize = 100;
    let name = EditStep::ALL
        .iter()
        .map(|step| step.name.len())
        .max()
        .unwrap_or_default();
    let indent = name + 4;
    let mut text = "Steps (S: seconds, M: metres, N: a number):\n".to_owned();
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
