//! Writes the tables of steps in documents, each between two marks.

use std::fs;

use mocap::edit::ValueKind;

use crate::model::{Model, Step, StepOption};
use crate::{Generated, ROOT};

/// The pages with tables of steps.
const PAGES: [&str; 3] = ["docs/steps-cleaning.md", "docs/steps-time.md", "docs/steps-pose.md"];

/// The mark before a table, with the names of its steps. The name `others` stands for all steps that no page names.
const START: &str = "<!-- steps: ";
const END: &str = "<!-- end of steps -->";

pub(crate) fn files(model: &Model) -> Vec<Generated> {
    let texts = PAGES.map(|path| fs::read_to_string(format!("{ROOT}/{path}")).unwrap_or_default());
    let pages: Vec<_> = PAGES
        .iter()
        .zip(&texts)
        .map(|(path, text)| (*path, parts(path, text)))
        .collect();
    let is_named = |step: &Step| pages.iter().any(|(_, [_, names, _])| has(names, step.name));
    let file = |(path, [before, names, after]): &(&'static str, [&str; 3])| {
        let steps = model.steps.iter();
        let steps = steps.filter(|step| has(names, step.name) || (*names == "others" && !is_named(step)));
        let rows: String = steps.map(rows).collect();
        let table = format!("| step | option | what it is |\n|---|---|---|\n{rows}");
        Generated {
            path,
            text: format!("{before}{START}{names} -->\n{table}{END}{after}"),
        }
    };
    pages.iter().map(file).collect()
}

/// The text before the mark of a page, the names in the mark, and the text after the table.
fn parts<'a>(path: &str, text: &'a str) -> [&'a str; 3] {
    let parts = text.split_once(START).and_then(|(before, rest)| {
        let (names, rest) = rest.split_once(" -->\n")?;
        let (_, after) = rest.split_once(END)?;
        Some([before, names, after])
    });
    parts.unwrap_or_else(|| panic!("{path} has no {START}... --> and {END}"))
}

fn has(names: &str, step: &str) -> bool {
    names.split(' ').any(|name| name == step)
}

fn rows(step: &Step) -> String {
    let mut rows = format!("| `{}` | | {} |\n", step.name, cell(&step.docs));
    if step.takes_other {
        rows += "| | `with` N | The number of the second motion among the inputs. Default: the next one. |\n";
    }
    for option in &step.options {
        rows += &format!("| | {} | {} |\n", head(option), cell(&option.docs));
    }
    rows
}

/// The name of an option and its kind of value.
fn head(option: &StepOption) -> String {
    match option.takes {
        // In a step as text, each pair is a separate option.
        ValueKind::Moments => format!("`{}`", option.takes.symbol()),
        ValueKind::Flag => format!("`{}`", option.name),
        ValueKind::OneOf(words) => {
            let words: Vec<String> = words.iter().map(|word| format!("`{word}`")).collect();
            format!("`{}`: {}", option.name, words.join(", "))
        }
        takes => format!("`{}` {}", option.name, takes.symbol()),
    }
}

fn cell(docs: &str) -> String {
    docs.replace('|', "\\|").replace("`None`", "none")
}
