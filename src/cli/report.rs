//! Prints diagnostics on standard error in the style of compilers, with colours on a terminal.

use std::borrow::Cow;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use indicatif::ProgressBar;
use mocap::job::Notice;
pub(crate) use mocap::report::counted;
use mocap::{Code, Diagnostic, Error};
pub(crate) use mocap::{visible, visible_json};
use serde::Serialize;

use crate::kinds;

/// Whether a diagnostic stopped the import.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    Error,
    Warning,
}

/// Prints the warnings before an error, and the error.
pub(crate) fn error(error: &Error) {
    warnings(error.path(), error.warnings());
    fault_of(error.path(), error.diagnostic());
}

/// Prints the fault of a skipped file among many.
pub(crate) fn fault(path: &Path, diagnostic: &Diagnostic) {
    fault_of(Some(path), diagnostic);
}

fn fault_of(path: Option<&Path>, diagnostic: &Diagnostic) {
    print(&render(Severity::Error, path, &kinds::helped(path, diagnostic)));
}

/// Prints warnings about a file.
pub(crate) fn warnings(path: Option<&Path>, warnings: &[Diagnostic]) {
    let is_gap = |warning: &&Diagnostic| warning.code == Code::Gap;
    let gaps: u64 = warnings.iter().filter(is_gap).map(|warning| warning.count).sum();
    // Print one line for all gaps: a take has a warning for each marker.
    for warning in warnings.iter().filter(|warning| gaps < 2 || !is_gap(warning)) {
        print(&render(Severity::Warning, path, warning));
    }
    if gaps > 1 {
        let message = format!("markers have gaps ({gaps} warnings): `mocap info` lists them");
        print(&render(Severity::Warning, path, &Diagnostic::new(Code::Gap, message)));
    }
}

/// The receiver of the notices of a file.
pub(crate) enum Voice<'a> {
    /// Prints each notice for the user at once.
    Aloud,
    /// The manifest, for one of many files.
    Kept(&'a mut Vec<String>),
}

impl Voice<'_> {
    pub(crate) fn say(&mut self, message: &str) {
        match self {
            Self::Aloud => say(message),
            Self::Kept(lines) => lines.push(message.to_owned()),
        }
    }

    /// Passes on a notice of a job.
    pub(crate) fn hear(&mut self, said: Notice<'_>) {
        match said {
            Notice::Warnings(path, found) => self.warnings(path, found),
            Notice::Note(note) => self.say(note),
            Notice::Step(step) => self.say(&step.to_string()),
            _ => {}
        }
    }

    pub(crate) fn warnings(&mut self, path: &Path, found: &[Diagnostic]) {
        match self {
            Self::Aloud => warnings(Some(path), found),
            Self::Kept(lines) => lines.extend(found.iter().map(ToString::to_string)),
        }
    }
}

/// [`visible`], but keeps line ends and tabs.
pub fn visible_lines(text: &str) -> String {
    let parts = text.split_inclusive(['\n', '\t']).map(|part| {
        let shown = part.trim_end_matches(['\n', '\t']);
        format!("{}{}", visible(shown), &part[shown.len()..])
    });
    parts.collect()
}

/// The kept errors of [`complain`], for a process whose standard error nobody reads.
static KEPT: Mutex<Option<Vec<String>>> = Mutex::new(None);

/// The most kept errors: a run of many files may have any number.
const MOST_KEPT: usize = 1000;

/// Keeps the errors that are not about the contents of a file, for [`kept`].
pub(crate) fn keep() {
    *KEPT.lock().unwrap_or_else(PoisonError::into_inner) = Some(Vec::new());
}

/// The errors that were kept.
pub(crate) fn kept() -> Vec<String> {
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    kept.as_mut().map(std::mem::take).unwrap_or_default()
}

/// Prints an error that is not about the contents of a file.
pub(crate) fn complain(message: &str) {
    if let Some(kept) = KEPT.lock().unwrap_or_else(PoisonError::into_inner).as_mut()
        && kept.len() < MOST_KEPT
    {
        kept.push(message.to_owned());
    }
    fail(message);
}

/// As [`complain`], for one of many files whose error is also in a manifest.
pub(crate) fn fail(message: &str) {
    let message = visible_lines(message);
    print(&renderer().render(&[Group::with_title(Level::ERROR.primary_title(message))]));
}

/// Prints a warning that is not about the contents of a file.
pub(crate) fn caution(message: &str) {
    print(&renderer().render(&[Group::with_title(Level::WARNING.primary_title(message))]));
}

/// For a command that needs one animation: chooses the first animation in which joints move, reports the choice, and
/// moves this animation to the front.
pub(crate) fn clip_taken(scene: &mut mocap::Scene) {
    let (index, count) = (scene.main_clip(), scene.animations.len());
    if count > 1 {
        let name = &scene.animations[index].name;
        say(&format!(
            "clip: {index} \"{name}\" of {count}; --clip selects another clip"
        ));
        scene.put_main_clip_first();
    }
    if let Some(curves) = scene.face_curves_alone(0) {
        caution(&format!(
            "only the face moves in the clip, by {curves}: the joints do not move"
        ));
    }
}

/// Whether the user wants only warnings and errors: `--quiet`.
static QUIET: AtomicBool = AtomicBool::new(false);

pub(crate) fn set_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints a line of progress or summary, unless `--quiet`.
pub(crate) fn say(message: &str) {
    if !is_quiet() {
        print(&visible_lines(message));
    }
}

/// The outputs that replaced outputs of earlier commands.
static REPLACED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

pub(crate) fn replaced(path: &Path) {
    REPLACED
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .push(path.to_owned());
}

/// Reports the replaced outputs of earlier commands: the names of a few outputs, or only the number of many.
pub(crate) fn tell_replaced() {
    /// The most replaced outputs that are named. For more, only the number is reported.
    const FEW: usize = 3;
    let paths = std::mem::take(&mut *REPLACED.lock().unwrap_or_else(PoisonError::into_inner));
    match paths.len() {
        count @ 0..=FEW => paths[..count]
            .iter()
            .for_each(|path| say(&format!("{}: replaced an earlier output of mocap", path.display()))),
        count => say(&format!("replaced {count} earlier outputs of mocap")),
    }
}

/// How standard output escapes characters of a file that control a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrintableText {
    /// [`visible_lines`].
    Words,
    /// [`visible_json`].
    Json,
    /// No escaping, for data that another program reads.
    Data,
}

/// Standard output for text.
pub(crate) fn words() -> impl Write {
    EscapeWriter::new(io::stdout().lock(), PrintableText::Words)
}

/// Standard output for JSON.
pub(crate) fn json() -> impl Write {
    EscapeWriter::new(io::stdout().lock(), PrintableText::Json)
}

/// Standard output for data: unchanged bytes, unless it is a terminal.
pub(crate) fn data() -> impl Write {
    let out = io::stdout().lock();
    let shown = match out.is_terminal() {
        true => PrintableText::Words,
        false => PrintableText::Data,
    };
    EscapeWriter::new(out, shown)
}

/// Escapes the text that is written, one whole character at a time.
pub struct EscapeWriter<W: Write> {
    out: W,
    shown: PrintableText,
    pending: Vec<u8>,
}

impl<W: Write> EscapeWriter<W> {
    pub fn new(out: W, shown: PrintableText) -> Self {
        Self {
            out,
            shown,
            pending: Vec::new(),
        }
    }

    fn write_pending(&mut self, length: usize) -> io::Result<()> {
        let rest = self.pending.split_off(length);
        let text = std::mem::replace(&mut self.pending, rest);
        let text = String::from_utf8_lossy(&text);
        let text = match self.shown {
            PrintableText::Json => visible_json(&text),
            _ => visible_lines(&text).into(),
        };
        beside_bar(|| self.out.write_all(text.as_bytes()))
    }
}

impl<W: Write> Write for EscapeWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.shown == PrintableText::Data {
            return self.out.write(bytes);
        }
        self.pending.extend_from_slice(bytes);
        // The bytes may end within a character.
        let whole = match std::str::from_utf8(&self.pending) {
            Err(error) if error.error_len().is_none() => error.valid_up_to(),
            _ => self.pending.len(),
        };
        self.write_pending(whole)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.write_pending(self.pending.len())?;
        self.out.flush()
    }
}

impl<W: Write> Drop for EscapeWriter<W> {
    fn drop(&mut self) {
        let _ = self.flush();
    }
}

/// Work that takes less time shows no progress.
pub(crate) const PATIENCE: Duration = Duration::from_secs(1);

/// The progress bar on the terminal. It is hidden while a line is printed.
static BAR: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Replaces the current bar.
pub(crate) fn set_bar(bar: Option<ProgressBar>) {
    let former = std::mem::replace(&mut *BAR.lock().unwrap_or_else(PoisonError::into_inner), bar);
    if let Some(former) = former {
        former.finish_and_clear();
    }
}

pub(crate) fn has_bar() -> bool {
    BAR.lock().unwrap_or_else(PoisonError::into_inner).is_some()
}

fn print(text: &str) {
    // Nothing can be reported if standard error is closed.
    beside_bar(|| drop(writeln!(io::stderr().lock(), "{text}")));
}

/// Calls `write` while the bar is hidden. `write` must not call this function.
pub(crate) fn beside_bar<T>(write: impl FnOnce() -> T) -> T {
    match &*BAR.lock().unwrap_or_else(PoisonError::into_inner) {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

fn renderer() -> Renderer {
    let wants_colour = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    if wants_colour {
        Renderer::styled()
    } else {
        Renderer::plain()
    }
}

/// `walk.bvh:5:14: error[unknown-channel]: ...`, the line with a marker, then joint, expected, found and help.
pub fn render(severity: Severity, path: Option<&Path>, diagnostic: &Diagnostic) -> String {
    let (severity, level) = match severity {
        Severity::Error => ("error", Level::ERROR),
        Severity::Warning => ("warning", Level::WARNING),
    };
    let path = path.map(|path| path.display().to_string());
    let mut prefix = path.map(|path| format!("{}:", visible(&path))).unwrap_or_default();
    if let Some(location) = &diagnostic.location {
        prefix += &format!("{}:{}:", location.line, location.column);
    }
    let name = if prefix.is_empty() {
        severity.to_owned()
    } else {
        format!("{prefix} {severity}")
    };
    let message = match diagnostic.count {
        1 => visible(&diagnostic.message).into_owned(),
        count => format!("{} ({count} times)", visible(&diagnostic.message)),
    };
    let title = level
        .with_name(name)
        .primary_title(message)
        .id(diagnostic.code.as_str());
    let mut group = Group::with_title(title);
    // Replace characters one by one, so that columns stay aligned.
    let line = diagnostic.location.as_ref().map(|location| {
        let shown = |c: char| {
            if c != '\t' && matches!(visible(c.encode_utf8(&mut [0; 4])), Cow::Owned(_)) {
                char::REPLACEMENT_CHARACTER
            } else {
                c
            }
        };
        location.text.chars().map(shown).collect::<String>()
    });
    if let (Some(location), Some(line)) = (&diagnostic.location, &line) {
        let bytes_to = |column: usize| {
            let characters = column.saturating_sub(location.text_column);
            line.char_indices().nth(characters).map_or(line.len(), |(byte, _)| byte)
        };
        let span = bytes_to(location.column)..bytes_to(location.column + location.length);
        group = group.element(
            Snippet::source(line)
                .line_start(location.line)
                .annotation(AnnotationKind::Primary.span(span)),
        );
    }
    let details = [
        ("at", &diagnostic.pointer),
        ("joint", &diagnostic.joint),
        ("expected", &diagnostic.expected),
        ("found", &diagnostic.found),
        ("help", &diagnostic.help),
    ];
    for (label, text) in details {
        if let Some(text) = text {
            group = group.element(Level::NOTE.with_name(label).message(visible(text)));
        }
    }
    renderer().render(&[group])
}
