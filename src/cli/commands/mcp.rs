//! `mocap mcp`: serves agents.

use crate::args::McpArgs;
use crate::{Failure, agent};

pub(crate) fn run(args: &McpArgs) -> Result<(), Failure> {
    agent::serve(args)
}
