//! Items that only the tests of the program need.

pub use crate::Failure;
pub use crate::agent::about::ABOUT;
pub use crate::agent::schema::Commands;
pub use crate::agent::tools::{TOOLS, Tool};
pub use crate::args::Args;
pub use crate::args::guides::{GUIDES, Guide};
pub use crate::args::help::{GROUPS, arranged};
pub use crate::args::live::ListenAddress;
pub use crate::batch::for_each;
pub use crate::batch::inputs::{Input, InputArgs, find};
pub use crate::batch::pattern::{Fit, Pattern};
pub use crate::batch::shard::Shard;
pub use crate::batch::walk::{Entry, Search};
pub use crate::build_note::note;
#[cfg(feature = "schema")]
pub use crate::json_schema::schema;

pub mod line {
    pub use crate::agent::line::{LONGEST, Line, read};
}
pub mod packets {
    pub use crate::commands::packets::{LONGEST, MOST_WAITING, OF_PACKET, Packet, Packets, Shared};
}
pub mod report {
    pub use crate::report::{EscapeWriter, PrintableText, Severity, render, visible_lines};
}
