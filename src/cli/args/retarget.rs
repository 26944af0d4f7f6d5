//! The options of `mocap retarget`.

use std::path::{Path, PathBuf};

use mocap::job::{CharacterTarget, InputOptions, JobTarget, MotionJob};

use super::batch::is_folder;
use super::onto::OntoArgs;
use super::write::extensions_and;

#[derive(Debug, clap::Args)]
pub(crate) struct RetargetArgs {
    /// The motion files, then the TARGET, unless --character or --to-skeleton names it. The TARGET is a .glb, .gltf or
    /// .vrm file, or any file with the skeleton of a humanoid
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) paths: Vec<PathBuf>,
    /// The file to write; - is standard output. A glTF or VRM character keeps its format and all its contents; the
    /// motions are added. An .fbx output has the character with skin, colours and textures, and the motions. Other
    /// formats have the skeleton and the motions. If OUTPUT is a folder, or ends in /, each motion gets one file with
    /// the character, and the folder gets a manifest; the inputs may then be folders and wildcards
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output, or of the outputs in a folder [default: the format of a glTF or VRM character, else
    /// glb]
    #[arg(long, value_name = "FORMAT", value_parser = extensions_and(&["vrm"]))]
    pub(crate) to: Option<String>,
    /// The character. Every INPUT is then a motion
    #[arg(long, value_name = "TARGET", conflicts_with = "to_skeleton")]
    pub(crate) character: Option<PathBuf>,
    /// Retarget to the skeleton of this file, without its other contents. Every INPUT is then a motion
    #[arg(long, value_name = "TARGET", conflicts_with = "replace_animations")]
    pub(crate) to_skeleton: Option<PathBuf>,
    /// Names of the clips, in the order of the motions [default: the names in the files]
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub(crate) names_of_clips: Vec<String>,
    #[command(flatten)]
    target: CharacterTarget,
    #[command(flatten)]
    pub(crate) onto: OntoArgs,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

impl RetargetArgs {
    /// Whether the output is a folder, with one output for each motion.
    pub(crate) fn is_many(&self) -> bool {
        is_folder(&self.output)
    }
}

impl RetargetArgs {
    /// The job that retargets motions to the character of a file, with an output of the format of `extension`.
    pub(crate) fn job(&self, motions: &[PathBuf], file: &Path, extension: &str) -> MotionJob {
        let mut target = self.target.clone();
        target.file = file.to_owned();
        target.names_of_clips.clone_from(&self.names_of_clips);
        let mut job = MotionJob::default();
        job.read = self.read.clone();
        job.source = self.onto.sources(motions);
        job.target = Some(match self.to_skeleton {
            Some(_) => JobTarget::Skeleton(target.into()),
            None => JobTarget::Character(target),
        });
        job.weights = self.onto.weights.weights();
        job.write = self.onto.writing(&self.output, extension);
        job
    }
}
