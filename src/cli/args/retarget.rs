//! The options of `mocap retarget`.

use std::path::{Path, PathBuf};

use mocap::job::{CharacterTarget, InputOptions, JobTarget, MotionJob};

use super::batch::is_folder;
use super::onto::OntoArgs;
use super::write::extensions_and;

#[derive(Debug, clap::Args)]
pub(crate) struct RetargetArgs {
    /// The motion files, and after them the TARGET, unless --character or --to-skeleton names it: a .glb, .gltf or .vrm
    /// file, or any file with the skeleton of a humanoid
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) paths: Vec<PathBuf>,
    /// The file to write. A glTF or VRM character keeps its format, and everything in it; the motions are added. An
    /// .fbx has any character with its skin, colours and textures, and the motions. The other formats have its skeleton
    /// and the motions. - is standard output. A folder, or a name that ends in /, gets one file with the character per
    /// motion, and a manifest; the inputs may then be folders and wildcards
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output, or of the outputs in a folder [default: that of a glTF or VRM character, or else glb]
    #[arg(long, value_name = "FORMAT", value_parser = extensions_and(&["vrm"]))]
    pub(crate) to: Option<String>,
    /// The character; every INPUT is a motion then
    #[arg(long, value_name = "TARGET", conflicts_with = "to_skeleton")]
    pub(crate) character: Option<PathBuf>,
    /// Retarget to the skeleton of this file, without its other contents; every INPUT is a motion then
    #[arg(long, value_name = "TARGET", conflicts_with = "replace_animations")]
    pub(crate) to_skeleton: Option<PathBuf>,
    /// Names of the clips, in the order of the motions [default: those of the files]
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
    /// Whether the output is a folder, with an output of each motion.
    pub(crate) fn is_many(&self) -> bool {
        is_folder(&self.output)
    }
}

impl RetargetArgs {
    /// The job of motions on the character of a file, with an output of the format of `extension`.
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
