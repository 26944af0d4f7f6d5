//! The reports of commands that have no report in the library.

use std::fmt;
use std::path::Path;

use mocap::biomechanics::report::OutputDifference;
use mocap::render::Drawing;
use mocap::report::counted;
use serde::Serialize;

/// The report of an output. Its text begins with the path of the output; its JSON has no path.
#[derive(Serialize)]
#[serde(transparent)]
pub(crate) struct OutputReport<'a, R> {
    #[serde(skip)]
    pub(crate) output: &'a Path,
    pub(crate) report: R,
}

impl<R: fmt::Display> fmt::Display for OutputReport<'_, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.output.display(), self.report)
    }
}

/// Reports of one kind: a list as JSON, one after the other as text.
#[derive(Serialize)]
#[serde(transparent)]
pub(crate) struct ReportList<R>(pub(crate) Vec<R>);

impl<R: fmt::Display> fmt::Display for ReportList<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|report| writeln!(f, "{report}"))
    }
}

/// A written picture or animation.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct PictureReport {
    pub(crate) output: String,
    /// Width in pixels.
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) bytes: usize,
    /// The size as text; for an animation, also its length.
    #[serde(skip)]
    pub(crate) summary: String,
}

impl PictureReport {
    pub(crate) fn of(drawing: &Drawing, output: &Path, bytes: usize) -> Self {
        let (width, height) = (drawing.width, drawing.height);
        Self {
            output: output.display().to_string(),
            width,
            height,
            bytes,
            summary: format!("{width} x {height} pixels"),
        }
    }
}

impl fmt::Display for PictureReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.output, self.summary)
    }
}

/// A database of `mocap index`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct IndexReport {
    pub(crate) output: String,
    pub(crate) bytes: usize,
    pub(crate) clips: usize,
    pub(crate) frames: usize,
}

impl fmt::Display for IndexReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (clips, frames) = (counted(self.clips, "clip"), counted(self.frames, "frame"));
        write!(f, "{}: {clips}, {frames}", self.output)
    }
}

/// The files of a run.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct FilesReport {
    pub(crate) files: usize,
    pub(crate) failed: usize,
}

impl fmt::Display for FilesReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} files, {} failed", self.files, self.failed)
    }
}

/// The arrays of `mocap fk`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct ArraysReport {
    pub(crate) input: String,
    pub(crate) output: String,
    pub(crate) frames: usize,
    pub(crate) joints: usize,
    pub(crate) end_sites: usize,
    pub(crate) bytes: usize,
    /// Assumptions, and data that the output lacks, one sentence each.
    pub(crate) notes: Vec<String>,
    /// The layout of another program, as a phrase.
    #[serde(skip)]
    pub(crate) layout: String,
}

impl fmt::Display for ArraysReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.notes.iter().try_for_each(|note| writeln!(f, "{note}"))?;
        write!(
            f,
            "{} -> {}: {}, {}, {}{}, {} bytes",
            self.input,
            self.output,
            counted(self.frames, "frame"),
            counted(self.joints, "joint"),
            counted(self.end_sites, "end site"),
            self.layout,
            self.bytes
        )
    }
}

/// The joint angles of `mocap angles`, in degrees and metres.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct AnglesReport<'a> {
    pub(crate) input: String,
    pub(crate) output: String,
    pub(crate) frames: usize,
    pub(crate) columns: &'a [String],
    /// Warnings about the motion.
    #[serde(skip)]
    pub(crate) note: Option<String>,
    /// The differences between the angles and the angles that a model stated in the file.
    pub(crate) beside_outputs: Vec<OutputDifference>,
}

impl fmt::Display for AnglesReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (frames, columns) = (self.frames, self.columns.len());
        let (input, output) = (&self.input, &self.output);
        write!(
            f,
            "{input} -> {output}: {frames} frames of {columns} columns, in degrees and metres"
        )?;
        self.note.iter().try_for_each(|line| write!(f, "\n{line}"))?;
        beside(&self.beside_outputs).try_for_each(|line| write!(f, "\n{line}"))
    }
}

/// The differences between the angles and the angles that a model stated in the file, one line each.
pub(crate) fn beside(differences: &[OutputDifference]) -> impl Iterator<Item = String> {
    let title = "difference from the model outputs of the file, in degrees: mean +- standard deviation".to_owned();
    let line = |difference: &OutputDifference| {
        let OutputDifference {
            output,
            column,
            mean,
            deviation,
            correlation,
            ..
        } = difference;
        format!("{column:18} {output:18} {mean:7.1} +- {deviation:4.1}, correlation {correlation:.2}")
    };
    let title = Some(title).filter(|_| !differences.is_empty());
    title.into_iter().chain(differences.iter().map(line))
}

/// A page of `mocap view`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct PageReport {
    pub(crate) output: String,
}

impl fmt::Display for PageReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.output)
    }
}

/// A recording of `mocap record`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct RecordingReport {
    pub(crate) output: String,
    pub(crate) frames: u64,
    pub(crate) seconds: f64,
    pub(crate) bones: usize,
    #[serde(flatten)]
    pub(crate) heard: HeardReport,
}

impl fmt::Display for RecordingReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (output, frames, seconds) = (&self.output, self.frames, self.seconds);
        let (bones, packets) = (self.bones, self.heard.packets);
        write!(
            f,
            "{output}: {frames} frames, {seconds:.2} s, {bones} bones, of {packets} packets"
        )
    }
}

/// The received packets of a stream.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct HeardReport {
    pub(crate) packets: u64,
    /// Packets that were dropped, because they came too fast.
    pub(crate) lost: u64,
    /// Packets or messages that violate the protocol.
    pub(crate) malformed: u64,
    /// Messages without data of the body.
    pub(crate) others: u64,
}

impl fmt::Display for HeardReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (packets, lost, malformed) = (self.packets, self.lost, self.malformed);
        write!(
            f,
            "{packets} packets, {lost} lost, {malformed} malformed, {} without data of the body",
            self.others
        )
    }
}

/// The result of `mocap play`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct PlayReport {
    /// The destination address.
    pub(crate) peer: String,
    /// The sent frames of a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) frames: Option<u64>,
    /// The sent packets of a stream.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) packets: Option<u64>,
}

impl fmt::Display for PlayReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (count, what) in [(self.frames, "frames"), (self.packets, "packets")] {
            count
                .iter()
                .try_for_each(|count| writeln!(f, "{count} {what} were sent"))?;
        }
        Ok(())
    }
}

/// The result of `mocap bridge`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct BridgeReport {
    /// The destination address.
    pub(crate) peer: String,
    pub(crate) poses: u64,
    #[serde(flatten)]
    pub(crate) heard: HeardReport,
    /// The reason why the last received bones do not form a body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) problem: Option<String>,
}

impl fmt::Display for BridgeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} poses were sent, from {} received packets",
            self.poses, self.heard.packets
        )
    }
}

/// The completions of a shell.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct CompletionsReport {
    pub(crate) shell: String,
    pub(crate) script: String,
}

impl fmt::Display for CompletionsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.script)
    }
}

/// A manual page, with its text if it is not written to a file.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct ManualPage {
    /// Its file, such as `mocap-convert.1`.
    pub(crate) file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) text: Option<String>,
}

/// Manual pages: a list as JSON, or their text if they are not in files.
#[derive(Serialize)]
#[serde(transparent)]
pub(crate) struct ManualPages(pub(crate) Vec<ManualPage>);

impl fmt::Display for ManualPages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0
            .iter()
            .filter_map(|page| page.text.as_ref())
            .try_for_each(|text| f.write_str(text))
    }
}
