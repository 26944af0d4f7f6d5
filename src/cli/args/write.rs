//! How an output is written: its format, from the table of formats, and the options that the format takes.

use std::path::Path;
use std::sync::LazyLock;

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser};
use mocap::job::{DrawnMesh, JointNames, OutBoneAxis, OutSpace, Smaller, Writing, WritingBvh, WritingFbx};
use mocap::{Diagnostic, Format, FormatInfo, WriteOption};

use super::Given;
use crate::Failure;

/// A written format, by one of its extensions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OutputFormat {
    pub(crate) format: Format,
    pub(crate) extension: &'static str,
}

/// All of them, in the order of the table.
static WRITTEN: LazyLock<Vec<OutputFormat>> = LazyLock::new(|| {
    let written = FormatInfo::ALL.iter().filter(|row| row.writes());
    let extensions = written.flat_map(|row| row.extensions.iter().map(|extension| (row.format, *extension)));
    extensions
        .map(|(format, extension)| OutputFormat { format, extension })
        .collect()
});

impl OutputFormat {
    /// The format that the extension of `path` names.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        // It is glTF that keeps what a VRM input has.
        let vrm = OutputFormat {
            format: Format::Gltf,
            extension: "vrm",
        };
        let mut written = WRITTEN.iter().copied().chain([vrm]);
        written.find(|format| extension.eq_ignore_ascii_case(format.extension))
    }

    pub(crate) fn row(self) -> &'static FormatInfo {
        FormatInfo::of(self.format)
    }
}

impl ValueEnum for OutputFormat {
    fn value_variants<'a>() -> &'a [Self] {
        &WRITTEN
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.extension).help(self.row().description))
    }
}

/// The extensions of all written formats, and other names.
pub(super) fn extensions_and(others: &[&'static str]) -> PossibleValuesParser {
    let written = WRITTEN.iter().map(|format| format.extension);
    PossibleValuesParser::new(written.chain(others.iter().copied()))
}

/// The options of all writers.
#[derive(Debug, clap::Args)]
pub(crate) struct WriteArgs {
    /// How to draw the skeleton of a file without meshes [default: skinned; for .fbx none]
    #[arg(long, value_name = "KIND")]
    mesh: Option<DrawnMesh>,
    /// Turn the frames of joints at rest so that this axis points along the bone, and joints bend about another: in
    /// Blender a bone is drawn along +Y. Nothing moves [default: none; for --target blender y]
    #[arg(long, value_name = "AXIS")]
    bone_axis: Option<OutBoneAxis>,
    /// Leave out the meshes, the materials and all else that the input has beside its skeleton and its motion
    #[arg(long)]
    skeleton_only: bool,
    /// Keep constant tracks in the animation; by default they become part of the rest pose
    #[arg(long)]
    pub(crate) keep_constant: bool,
    /// Names of joints in the output: vrm, mixamo, unreal, cmu, or those of a JSON file: {"bones": {"hips": "NAME",
    /// ...}}, as `mocap skeleton --json` prints [default: those of the input]
    #[arg(long, value_name = "NAMES", value_parser = |names: &str| JointNames::parse(names).map_err(|error| error.diagnostic().message.clone()))]
    names: Option<JointNames>,
    /// Embed the buffer of a .gltf, instead of writing a .bin beside it
    #[arg(long)]
    embed: bool,
    #[command(flatten)]
    bvh: WritingBvh,
    #[command(flatten)]
    fbx: WritingFbx,
    #[command(flatten)]
    pub(crate) smaller: Smaller,
    #[command(flatten)]
    pub(crate) out: OutSpace,
}

impl WriteArgs {
    /// Puts the options into a job, and an output in the format of `extension`.
    pub(super) fn fill(&self, writing: &mut Writing, output: &Path, extension: &str) {
        let own = output.extension().unwrap_or_default();
        writing.output = output.to_owned();
        writing.to = (!own.eq_ignore_ascii_case(extension)).then(|| extension.to_owned());
        writing.mesh = self.mesh;
        writing.bone_axis = self.bone_axis;
        writing.skeleton_only = self.skeleton_only;
        writing.space = self.out.clone();
        writing.keep_constant = self.keep_constant;
        writing.embed = self.embed;
        writing.smaller = self.smaller.clone();
        writing.names = self.names.clone();
        writing.bvh = self.bvh.clone();
        writing.fbx = self.fbx.clone();
    }
}

/// Refuses the options that have no effect on an output, also where they have the value of their default.
pub(crate) fn refuse_options(
    given: &Given,
    refusal: impl Fn(WriteOption) -> Option<Diagnostic>,
) -> Result<(), Failure> {
    let given = WriteOption::ALL.into_iter().filter(|option| given.has(option.as_str()));
    match given.filter_map(refusal).next() {
        Some(refusal) => Err(Failure::Usage(refusal.message)),
        None => Ok(()),
    }
}
