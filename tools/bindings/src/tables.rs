//! Writes the tables of documents that repeat what the library says of itself: between two marks of a document.

use std::fs;

use mocap::edit::ValueKind;

use crate::model::{Model, Step, StepOption};
use crate::{Generated, ROOT};

const EDITING: &str = "docs/editing.md";

pub(crate) fn files(model: &Model) -> Vec<Generated> {
    let (start, end) = ("<!-- steps -->\n", "<!-- end of steps -->");
    let text = fs::read_to_string(format!("{ROOT}/{EDITING}")).unwrap_or_default();
    let parts = text.split_once(start).and_then(|(before, rest)| {
        let (_, after) = rest.split_once(end)?;
        Some((before, after))
    });
    let (before, after) = parts.unwrap_or_else(|| panic!("{EDITING} has no {start} and {end}"));
    vec![Generated {
        path: EDITING,
        text: format!("{before}{start}{}{end}{after}", steps(model)),
    }]
}

fn steps(model: &Model) -> String {
    let rows: String = model.steps.iter().map(rows).collect();
    format!("| step | option | what it is |\n|---|---|---|\n{rows}")
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

/// The name of an option with what it takes.
fn head(option: &StepOption) -> String {
    match option.takes {
        // In text each pair is an option of its own.
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
