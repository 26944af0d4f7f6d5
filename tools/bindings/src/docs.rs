//! Converts documentation of Rust to plain sentences.

/// The first paragraph as one line, without the brackets of rustdoc's links. A default becomes a sentence, and the text
/// ends with a full stop.
pub(crate) fn sentences(docs: &str) -> String {
    let lines = docs.lines().map(str::trim);
    let first = lines
        .skip_while(|line| line.is_empty())
        .take_while(|line| !line.is_empty());
    let text = without_links(&first.collect::<Vec<_>>().join(" "));
    let default = text.split_once(" [default");
    match default.and_then(|(text, default)| Some((text, default.strip_suffix(']')?))) {
        Some((text, default)) => format!("{} Default{}", ended(text), ended(default)),
        None => ended(&text),
    }
}

fn ended(text: &str) -> String {
    match text.is_empty() || text.ends_with(['.', '?', '!']) {
        true => text.to_owned(),
        false => format!("{text}."),
    }
}

/// Replaces links with their texts. Keeps brackets without a code span or a target.
fn without_links(text: &str) -> String {
    let (mut plain, mut rest) = (String::new(), text);
    while let Some((before, after)) = rest.split_once('[') {
        plain.push_str(before);
        rest = after;
        let Some((shown, after)) = after.split_once(']') else {
            plain.push('[');
            continue;
        };
        if let Some((_, after)) = after.strip_prefix('(').and_then(|target| target.split_once(')')) {
            plain.push_str(shown);
            // A link to a function has its own parentheses.
            rest = after.strip_prefix(')').unwrap_or(after);
        } else if shown.starts_with('`') {
            // Keep the last name of a Rust path.
            let name = shown.rsplit("::").next().unwrap_or(shown).trim_start_matches('`');
            plain.push_str(&format!("`{name}"));
            rest = after;
        } else {
            plain.push('[');
        }
    }
    plain + rest
}

/// Splits text into lines of at most `width` characters.
pub(crate) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().expect("there is a first line");
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
            lines.push(word.to_owned());
            continue;
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    lines
}
