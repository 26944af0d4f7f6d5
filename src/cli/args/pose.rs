//! The options of `mocap pose` and `mocap chain`.

use std::path::PathBuf;

use mocap::job::InputOptions;

#[derive(Debug, clap::Args)]
pub(crate) struct PoseArgs {
    /// The motion file; - is standard input
    #[arg(value_name = "INPUT")]
    pub(crate) file: PathBuf,
    /// The tick; poses between two frames are interpolated
    #[arg(long, value_name = "T", allow_negative_numbers = true, default_value_t = 0.0)]
    pub(crate) tick: f64,
    /// Print node-to-world matrices, instead of node-to-parent
    #[arg(long)]
    pub(crate) world: bool,
    /// Loop the motion: ticks outside the clip wrap around. Without this option they are clamped to the first or last
    /// frame
    #[arg(long = "loop")]
    pub(crate) repeat: bool,
    /// Print JSON
    #[arg(long, conflicts_with = "csv")]
    pub(crate) json: bool,
    /// Print comma-separated values
    #[arg(long)]
    pub(crate) csv: bool,
    /// Put ' before CSV names that begin with = + - or @, so that spreadsheets do not read them as formulas
    #[arg(long)]
    pub(crate) spreadsheet: bool,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ChainArgs {
    /// The motion file; - is standard input
    #[arg(value_name = "INPUT")]
    pub(crate) file: PathBuf,
    /// The name of the joint or end site, such as EndSite_Wrist
    pub(crate) joint: String,
    /// The tick. Poses between two frames are interpolated. Ticks outside the clip are clamped to the first or last
    /// frame
    #[arg(long, value_name = "T", allow_negative_numbers = true, default_value_t = 0.0)]
    pub(crate) tick: f64,
    /// Print the world position of this point. The point is in the joint's axes and in the unit of the file
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = point)]
    pub(crate) point: Option<[f32; 3]>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

fn point(text: &str) -> Result<[f32; 3], String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    numbers
        .ok()
        .and_then(|numbers| <[f32; 3]>::try_from(numbers).ok())
        .filter(|numbers| numbers.iter().all(|number| number.is_finite()))
        .ok_or_else(|| "a point has three finite numbers, such as 0.5,0,0".to_owned())
}
