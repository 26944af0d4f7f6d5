//! The unit and the up axis of the output.

use clap::ValueEnum;
use mocap::job::UnitChoice;
use mocap::scene::UpAxis;

/// The unit and the up axis of the output.
#[derive(Debug, clap::Args)]
pub(crate) struct OutArgs {
    /// Unit of length of the output: m, dm, cm, mm, inch, cmu, or metres in one unit [default: the input's; glTF is in
    /// metres]
    #[arg(long, value_name = "UNIT", value_parser = parse_unit)]
    out_unit: Option<f64>,
    /// Up axis of the output [default: the input's; glTF has +Y up]
    #[arg(long, value_name = "AXIS")]
    out_up: Option<OutUpArg>,
}

impl OutArgs {
    pub(crate) fn metres_per_unit(&self) -> Option<f64> {
        self.out_unit
    }

    pub(crate) fn up(&self) -> Option<UpAxis> {
        self.out_up.map(|up| match up {
            OutUpArg::Y => UpAxis::Y,
            OutUpArg::Z => UpAxis::Z,
        })
    }
}

fn parse_unit(text: &str) -> Result<f64, String> {
    let known = text.parse().map(UnitChoice::metres).unwrap_or_default();
    known.ok_or_else(|| "expected m, dm, cm, mm, inch, cmu or a number above 0".to_owned())
}

/// `--out-up`.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum OutUpArg {
    Y,
    Z,
}
