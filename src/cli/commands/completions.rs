//! `mocap completions` and `mocap man`: shell completions and manual pages.

use std::fs;
use std::path::Path;

use clap::builder::Resettable;
use clap::{Command, CommandFactory};
use clap_mangen::Man;

use super::{Place, print_report};
use crate::args::help::arranged;
use crate::args::{Args, CompletionsArgs, ManArgs};
use crate::kinds::nearest;
use crate::printed::{CompletionsReport, ManualPage, ManualPages};
use crate::{Failure, streams};

const PROGRAM: &str = "mocap";

/// Prints the completions of a shell.
pub(crate) fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    // The generator would panic if the reader closed the pipe.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Args::command(), PROGRAM, &mut script);
    let found = CompletionsReport {
        shell: args.shell.to_string(),
        script: String::from_utf8_lossy(&script).into_owned(),
    };
    print_report(&found, args.json, Place::Data)
}

/// Prints the manual page of a command, or writes all pages to a folder.
pub(crate) fn man(args: &ManArgs) -> Result<(), Failure> {
    // A page shows only the version, so that all builds of a version make the same page.
    let mut command = arranged(Args::command()).long_version(Resettable::Reset);
    command.build();
    if let Some(folder) = &args.output {
        fs::create_dir_all(folder).map_err(|error| Failure::Folder(folder.clone(), error))?;
        let mut pages = Vec::new();
        write_pages(&command, folder, &mut pages)?;
        return print_report(&ManualPages(pages), args.json, Place::Data);
    }
    let mut found = &command;
    for name in &args.command {
        let names = found.get_subcommands().map(Command::get_name);
        found = found.find_subcommand(name).ok_or_else(|| {
            let near = nearest(name, names).map_or_else(String::new, |near| format!("; did you mean {near}?"));
            Failure::Usage(format!("there is no command {}{near}", args.command.join(" ")))
        })?;
    }
    let (man, mut page) = (Man::new(found.clone()), Vec::new());
    man.render(&mut page)?;
    let page = ManualPage {
        file: man.get_filename(),
        text: Some(String::from_utf8_lossy(&page).into_owned()),
    };
    print_report(&ManualPages(vec![page]), args.json, Place::Data)
}

/// Writes the pages of a command and of its subcommands: `mocap.1`, `mocap-convert.1` and so on.
fn write_pages(command: &Command, folder: &Path, pages: &mut Vec<ManualPage>) -> Result<(), Failure> {
    let man = Man::new(command.clone());
    let mut page = Vec::new();
    man.render(&mut page)?;
    streams::write(&folder.join(man.get_filename()), &page)?;
    pages.push(ManualPage {
        file: man.get_filename(),
        text: None,
    });
    let mut commands = command.get_subcommands().filter(|command| command.get_name() != "help");
    commands.try_for_each(|command| write_pages(command, folder, pages))
}
