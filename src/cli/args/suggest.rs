//! Suggests a name in errors of the command line, if a near name exists. clap alone suggests `solve` for `conver`.

use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::kinds::nearest;

/// Replaces clap's suggestions.
pub(super) fn suggest(error: &mut clap::Error, command: &clap::Command) {
    match error.kind() {
        ErrorKind::InvalidSubcommand => {
            let Some(ContextValue::String(found)) = error.get(ContextKind::InvalidSubcommand).cloned() else {
                return;
            };
            error.remove(ContextKind::SuggestedSubcommand);
            let names: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
            if let Some(near) = near(&found, &names) {
                let near = ContextValue::Strings(vec![near.to_owned()]);
                error.insert(ContextKind::SuggestedSubcommand, near);
            } else if Path::new(&found).exists() {
                let tip = format!("a command comes first: mocap info {found}");
                error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
            }
        }
        ErrorKind::UnknownArgument => check(error, ContextKind::InvalidArg, ContextKind::SuggestedArg),
        ErrorKind::InvalidValue => check(error, ContextKind::InvalidValue, ContextKind::SuggestedValue),
        _ => {}
    }
}

/// Removes a suggestion that is not near the user's word.
fn check(error: &mut clap::Error, found: ContextKind, suggested: ContextKind) {
    let texts = (error.get(found), error.get(suggested));
    if let (Some(ContextValue::String(found)), Some(ContextValue::String(name))) = texts
        && near(found.trim_start_matches('-'), &[name.trim_start_matches('-')]).is_none()
    {
        error.remove(suggested);
    }
}

/// The nearest name by edit distance, or else the first name with this prefix.
fn near<'a>(found: &str, names: &[&'a str]) -> Option<&'a str> {
    /// Shorter prefixes match too many names.
    const FEWEST: usize = 3;
    let begins = |name: &&&str| found.len() >= FEWEST && name.starts_with(found);
    nearest(found, names.iter().copied()).or_else(|| names.iter().find(begins).copied())
}
