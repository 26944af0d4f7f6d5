//! Tests that sentences of the documents are short enough to be understood on first reading, by the rules of
//! `docs/style.md`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::public::public_items;
use crate::source::{rust_files, sources};

/// The number of words in the longest allowed sentence.
const LONGEST: usize = 30;
/// The largest mean number of words in the sentences of a page.
const MEAN: usize = 18;

/// The number of words in each sentence of a page, without code, tables and headings.
fn sentences(page: &str) -> Vec<usize> {
    let (mut paragraphs, mut is_code) = (vec![String::new()], false);
    for line in page.lines() {
        let text = line.trim();
        let item = text.trim_start_matches(|sign: char| sign.is_ascii_digit());
        let item = ["- ", "* ", ". "].iter().find_map(|mark| item.strip_prefix(mark));
        let is_open = paragraphs.last().is_some_and(|last| !last.is_empty());
        if text.starts_with("```") {
            is_code = !is_code;
            paragraphs.push(String::new());
        } else if is_code || text.is_empty() || text.starts_with(['|', '#', '!', '<']) {
            paragraphs.push(String::new());
        } else if let Some(item) = item {
            paragraphs.push(item.to_owned());
        } else if is_open || !line.starts_with("    ") {
            let last = paragraphs.last_mut().unwrap();
            *last += " ";
            *last += text;
        }
    }
    paragraphs.iter().flat_map(|paragraph| words(paragraph)).collect()
}

/// The number of words in each sentence of a paragraph. A code span is one word, and the address of a link is no word.
fn words(paragraph: &str) -> Vec<usize> {
    let mut plain = String::new();
    for (number, part) in paragraph.split('`').enumerate() {
        plain += if number % 2 == 0 { part } else { "code" };
    }
    while let Some((start, end)) = plain
        .find("](")
        .and_then(|start| Some((start, start + plain[start..].find(')')?)))
    {
        plain.replace_range(start..=end, "");
    }
    let (mut counts, mut count) = (Vec::new(), 0);
    for word in plain.split_whitespace() {
        count += usize::from(word.contains(char::is_alphanumeric));
        if count > 0 && word.trim_end_matches([')', '"', '*']).ends_with(['.', '!', '?']) {
            counts.push(std::mem::take(&mut count));
        }
    }
    counts.extend((count > 0).then_some(count));
    counts
}

fn pages(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            pages(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.push(path);
        }
    }
}

/// The README of each package, tool and example.
fn readmes(found: &mut Vec<PathBuf>) {
    let below = |folder: &str| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let folders = ["src", "tools", "examples", "tools/wasm"].into_iter().flat_map(below);
    found.extend(
        folders
            .map(|folder| folder.join("README.md"))
            .filter(|path| path.exists()),
    );
}

#[test]
fn sentences_are_short() {
    let mut found = [
        "README",
        "ARCHITECTURE",
        "CHANGELOG",
        "CONTRIBUTING",
        "SECURITY",
        "fixtures/README",
    ]
    .map(|name| PathBuf::from(format!("{name}.md")))
    .to_vec();
    pages(Path::new("docs"), &mut found);
    readmes(&mut found);
    assert!(found.len() > 110, "the pages are somewhere else");
    let is_long = |path: &PathBuf| {
        let counts = sentences(&fs::read_to_string(path).unwrap());
        counts.iter().sum::<usize>() > MEAN * counts.len() || counts.iter().any(|count| *count > LONGEST)
    };
    let long = found.iter().filter(|path| is_long(path));
    let long: Vec<String> = long.map(|path| path.display().to_string()).collect();
    assert!(
        long.is_empty(),
        "a page has {MEAN} words a sentence at most in the mean, and no sentence above {LONGEST}: {}",
        long.join(", ")
    );
}

/// The comments of a file, each as a page: successive lines with the same mark.
fn comments(text: &str) -> Vec<String> {
    let (mut found, mut last) = (vec![String::new()], "");
    for line in text.lines() {
        let line = line.trim_start();
        let mark = ["//!", "///", "//"]
            .into_iter()
            .find(|mark| line.starts_with(mark))
            .unwrap_or_default();
        if mark != last {
            found.push(String::new());
            last = mark;
        }
        if !mark.is_empty() {
            let comment = found.last_mut().unwrap();
            *comment += line[mark.len()..].strip_prefix(' ').unwrap_or(&line[mark.len()..]);
            comment.push('\n');
        }
    }
    found
}

#[test]
fn sentences_of_comments_are_short() {
    let mut long = Vec::new();
    for file in rust_files(|_| true) {
        let text = fs::read_to_string(&file).unwrap();
        let is_long = |comment: &String| sentences(comment).iter().any(|count| *count > LONGEST);
        let comments = comments(&text).into_iter().filter(is_long);
        long.extend(comments.map(|comment| format!("{}: {comment}", file.display())));
    }
    assert!(
        long.is_empty(),
        "a sentence of a comment has at most {LONGEST} words:\n{}",
        long.join("\n")
    );
}

/// The names of code between backticks, such as `figure::BoneNames`. For a method such as `Pose::chain`, the name is
/// the type.
fn names_of_code(page: &str) -> impl Iterator<Item = String> {
    let spans = page.split('`').skip(1).step_by(2).filter(|span| span.contains("::"));
    spans.filter_map(|span| {
        let path = span
            .split(|sign: char| sign != ':' && sign != '_' && !sign.is_alphanumeric())
            .next()?;
        let parts = Vec::from_iter(path.split("::").skip_while(|part| *part == "mocap"));
        let is_type = |part: &&str| part.starts_with(char::is_uppercase);
        let end = parts.iter().position(is_type).map_or(parts.len(), |at| at + 1);
        Some(format!("::{}::", parts[..end].join("::")))
    })
}

#[test]
fn names_of_code_are_public() {
    let items = public_items(&sources());
    let paths = Vec::from_iter(items.values().map(|path| format!("::{path}::")));
    let mut found = vec![PathBuf::from("README.md")];
    pages(Path::new("docs"), &mut found);
    let mut unknown = BTreeSet::new();
    for page in found {
        let text = fs::read_to_string(&page).unwrap();
        // Code blocks contain other programs, and other tests run them.
        let text: String = text.split("```").step_by(2).collect();
        let names = names_of_code(&text).filter(|name| !paths.iter().any(|path| path.contains(name)));
        unknown.extend(names.map(|name| format!("{} {}", page.display(), name.trim_matches(':'))));
    }
    assert_eq!(
        unknown,
        BTreeSet::new(),
        "a name of code that no user of the library has"
    );
}

#[test]
fn words_of_sentences_are_counted() {
    let page =
        "# A heading\n\nOne `two words` three\nfour. [Five six](a/b.md) seven!\n\n| a | table |\n\n    code\n- item\n";
    assert_eq!(sentences(page), [4, 3, 1]);
}
