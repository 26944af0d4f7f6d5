//! Hints for clips that are not good: the reason, and the command to view them.

use std::path::Path;

use mocap::job::JobTarget;
use mocap::retarget::report::ClipReport;
use mocap::retarget::report::Verdict;

/// The clips of a motion that are not good, each with the reasons and the command that shows the clip. The motion is a
/// file, or one clip of a file. `output` is absent if the motion was not written.
pub(super) fn of_motion(
    reports: &[ClipReport],
    (input, clip): (&Path, Option<usize>),
    output: Option<&Path>,
    (target, body): (&JobTarget, Option<&Path>),
) -> Vec<String> {
    let doubtful = reports.iter().filter(|found| found.verdict() != Verdict::Good);
    let lines = doubtful.map(|found| {
        let (verdict, reasons) = (found.verdict().as_str(), found.reasons().join("; "));
        let clip = clip.map_or_else(String::new, |clip| format!(", clip {clip}"));
        format!("  {verdict}  {}{clip}: {reasons}", input.display())
    });
    let mut lines: Vec<String> = lines.collect();
    if !lines.is_empty() {
        let clip = clip.map_or_else(String::new, |clip| format!(" --clip {clip}"));
        lines.push(format!("        {}{clip}", look(input, output, (target, body))));
    }
    lines
}

/// The command that shows a motion next to its output. The file of a robot's motion has no meshes, so the command names
/// the robot. If the motion was read with a body file, the command names this file too.
fn look(input: &Path, output: Option<&Path>, (target, body): (&JobTarget, Option<&Path>)) -> String {
    let mut words = match (target, output) {
        (JobTarget::Robot(_), _) => vec![quoted(input), "--robot".to_owned(), quoted(target.file())],
        (_, Some(output)) => vec![quoted(input), quoted(output)],
        (_, None) => vec![quoted(input), "--character".to_owned(), quoted(target.file())],
    };
    if let Some(body) = body {
        words.extend(["--body".to_owned(), quoted(body)]);
    }
    format!("mocap view {}", words.join(" "))
}

/// The command that shows one clip of a file.
pub(super) fn clip(output: &Path, name: &str) -> String {
    format!("mocap view {} --clip={}", quoted(output), word(name.to_owned()))
}

/// A path, quoted for a shell. A path that begins with `-` gets the prefix `./`, so that no command takes it for an
/// option.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    word(match text.starts_with('-') {
        true => format!("./{text}"),
        false => text,
    })
}

/// A word, quoted for a shell.
fn word(text: String) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-./+:@%,=".contains(c);
    match !text.is_empty() && text.chars().all(is_plain) {
        true => text,
        false => format!("'{}'", text.replace('\'', "'\\''")),
    }
}
