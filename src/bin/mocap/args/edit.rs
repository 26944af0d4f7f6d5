//! The options of `mocap edit`.

use std::path::PathBuf;

use mocap::edit::{EDIT_STEPS, EditStep};

use super::{FrameRateArgs, SourceArgs};

#[derive(Debug, clap::Args)]
#[command(after_help = steps())]
pub(crate) struct EditArgs {
    /// The motion to change, and after it those that steps join, blend or layer with it
    #[arg(required = true, value_name = "IN")]
    pub(crate) inputs: Vec<PathBuf>,
    /// The file to write: .glb, .gltf or .bvh
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// A step, such as smooth:cut-off=8; steps are applied in the order given
    #[arg(long = "step", value_name = "NAME[:key=value,...]", value_parser = parse_step)]
    pub(crate) steps: Vec<EditStep>,
    /// Write when feet and hands are at rest in the changed motion: .json or .npz
    #[arg(long, value_name = "FILE")]
    pub(crate) contacts: Option<PathBuf>,
    /// Print what each step changed as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Replace a file that may be a source; an input is never replaced
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) source: SourceArgs,
    #[command(flatten)]
    pub(crate) read: FrameRateArgs,
}

fn parse_step(text: &str) -> Result<EditStep, String> {
    text.parse().map_err(|error: mocap::Error| {
        let diagnostic = error.diagnostic();
        match &diagnostic.expected {
            Some(expected) => format!("{}; the steps are {expected}", diagnostic.message),
            None => diagnostic.message.clone(),
        }
    })
}

fn steps() -> String {
    let mut text = "Steps (S: seconds, M: metres):\n".to_owned();
    for (name, help) in EDIT_STEPS {
        text += &format!("  {name:<10}  {help}\n");
    }
    text
}
