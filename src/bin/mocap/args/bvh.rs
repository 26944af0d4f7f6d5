//! Options of the BVH writer.

use clap::ValueEnum;
use mocap::bvh::{BvhOptions, Channels};
use mocap::scene::RotationOrder;

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Writing BVH")]
pub(crate) struct BvhArgs {
    /// Order of the rotation channels [default: each joint's own, or else ZXY]
    #[arg(long, value_name = "ORDER", value_parser = parse_order)]
    order: Option<RotationOrder>,
    /// Decimals of every number [default: as many as are needed to read the same motion back]
    #[arg(long, value_name = "N")]
    digits: Option<usize>,
    /// Which joints have position channels
    #[arg(long, value_name = "KIND", default_value = "auto")]
    channels: ChannelsArg,
}

fn parse_order(text: &str) -> Result<RotationOrder, String> {
    let named = |order: &RotationOrder| format!("{order:?}").eq_ignore_ascii_case(text);
    RotationOrder::ALL
        .into_iter()
        .find(named)
        .ok_or_else(|| "none of XYZ, XZY, YXZ, YZX, ZXY, ZYX".to_owned())
}

impl BvhArgs {
    pub(crate) fn options(&self) -> BvhOptions {
        BvhOptions {
            order: self.order,
            digits: self.digits,
            channels: self.channels.into(),
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ChannelsArg {
    /// The root, and joints with an animated position
    Auto,
    /// Only the root
    #[value(name = "3")]
    Three,
    /// Every joint
    #[value(name = "6")]
    Six,
}

impl From<ChannelsArg> for Channels {
    fn from(arg: ChannelsArg) -> Self {
        match arg {
            ChannelsArg::Auto => Self::Auto,
            ChannelsArg::Three => Self::Three,
            ChannelsArg::Six => Self::Six,
        }
    }
}
