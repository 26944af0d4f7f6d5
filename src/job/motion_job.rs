//! A job that writes motions.

use std::path::Path;

use mocap_edit::EditStep;
use mocap_formats::gltf::report::Provenance;
use mocap_io::Importer;
use mocap_io::import::Clips;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::ReplacePolicy;
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use super::files::policy;
use super::{InputOptions, JobTarget, JobWeights, OutputOptions, Sources, is_default};
use crate::verify::Verifier;
use crate::verify::report::Verification;

/// Reads motions, changes them, retargets them, and writes the result.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::job::MotionJob;
///
/// let folder = tempfile::tempdir().unwrap();
/// let mut job = MotionJob::default();
/// job.source.inputs = vec!["fixtures/real/cmu_short.bvh".into()];
/// job.steps = vec!["mirror".parse()?];
/// job.write.output = folder.path().join("mirrored.glb");
/// assert_eq!(job.run()?.steps.len(), 1);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MotionJob {
    /// The options for reading the inputs.
    #[serde(skip_serializing_if = "is_default")]
    pub read: InputOptions,
    /// The inputs, and the caller's statements about them.
    pub source: Sources,
    /// Steps that change the motion, in this order. They change every clip of an input. If the job names a clip, they
    /// change this clip, and the output keeps the others.
    #[serde(skip_serializing_if = "is_default")]
    #[cfg_attr(feature = "schema", schemars(with = "super::Steps"))]
    pub steps: Vec<EditStep>,
    /// The target of retargeting. Default: the motions keep their skeletons.
    #[serde(skip_serializing_if = "is_default")]
    pub target: Option<JobTarget>,
    /// The weights of solvers that differ from their defaults.
    #[serde(skip_serializing_if = "is_default")]
    pub weights: JobWeights,
    /// The output.
    pub write: OutputOptions,
    /// Whether to compare the output with its source.
    #[serde(skip_serializing_if = "is_default")]
    pub verify: bool,
}

impl MotionJob {
    /// Compares an output with the input of the job, from which `scene` was made. A retargeted motion is compared with
    /// the target, because its joints differ from the input on purpose.
    ///
    /// # Errors
    /// As [`Verifier::files`].
    pub fn verify_output(&self, scene: Option<Scene>, output: &Path) -> Result<Verification> {
        let Some(input) = self.source.inputs.first() else {
            return Err(Diagnostic::new(Code::InvalidValue, "the job names no input").into());
        };
        let verifier = Verifier::new().allowing(self.write.smaller.tolerance());
        let (input, verifier) = match &self.target {
            Some(target) => (target.file(), verifier),
            None => {
                // With steps, the provenance states the clip.
                let importer = match self.steps.is_empty() {
                    true => self.importer(),
                    false => self.importer().clips(Clips::All),
                };
                let verifier = verifier.importer(importer);
                let verifier = verifier.space(self.source.space.clone());
                (input.as_path(), verifier.second_motions(self.source.with.clone()))
            }
        };
        // A BVH file does not record its provenance.
        let verifier = match &scene {
            Some(scene) => verifier.provenance(Provenance::of(scene)),
            None => verifier,
        };
        // Free the keys of a long take before the file is read back.
        drop(scene);
        verifier.files(input, output)
    }

    /// The options for reading the inputs.
    pub(super) fn importer(&self) -> Importer {
        self.read.importer().marker_weights(self.weights.markers)
    }

    /// The policy for replacing files: the output never replaces an input or another file that the job reads.
    pub fn policy(&self) -> ReplacePolicy {
        let target = self.target.as_ref().map(JobTarget::file);
        let others = self.source.with.iter().map(AsRef::as_ref).chain(target);
        policy(&self.source.inputs, &self.read, others).force(self.write.force)
    }
}
