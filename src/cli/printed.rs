//! What `--json` prints: the types of commands whose report the library does not have.

use serde::Serialize;

/// A picture or a film that was written.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct PictureReport {
    pub(crate) output: String,
    /// In pixels.
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) bytes: usize,
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

/// The files of a run.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct FilesReport {
    pub(crate) files: usize,
    pub(crate) failed: usize,
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
    /// Assumptions, and data that the output does not have, one sentence each.
    pub(crate) notes: Vec<String>,
}

/// The joint angles of `mocap angles`, in degrees and metres.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct AnglesReport<'a> {
    pub(crate) input: String,
    pub(crate) output: String,
    pub(crate) frames: usize,
    pub(crate) columns: &'a [String],
}

/// A page of `mocap view`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct PageReport {
    pub(crate) output: String,
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

/// What was heard of a stream.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct HeardReport {
    pub(crate) packets: u64,
    /// Packets that came faster than they could be worked on.
    pub(crate) lost: u64,
    /// Packets or messages that are no messages of the protocol.
    pub(crate) malformed: u64,
    /// Messages about other things than the body.
    pub(crate) others: u64,
}

/// What `mocap play` sent.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct PlayReport {
    /// Where it was sent to.
    pub(crate) peer: String,
    /// The frames of a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) frames: Option<u64>,
    /// The packets of a stream.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) packets: Option<u64>,
}

/// What `mocap bridge` sent.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct BridgeReport {
    /// Where it was sent to.
    pub(crate) peer: String,
    pub(crate) poses: u64,
    #[serde(flatten)]
    pub(crate) heard: HeardReport,
    /// Why the last bones that came are no body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) problem: Option<String>,
}

/// The completions of a shell.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct CompletionsReport {
    pub(crate) shell: String,
    pub(crate) script: String,
}

/// A manual page, with its text where it is not written to a file.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct ManualPage {
    /// Its file, such as `mocap-convert.1`.
    pub(crate) file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) text: Option<String>,
}
