//! VRM animations, `.vrma`: glTF with the motion of a humanoid, and with the extension `VRMC_vrm_animation` 1.0, which
//! states the node of each bone. The rest pose is the T-pose, so a player can pose any VRM character.
//!
//! `Exporter` writes the motion of any humanoid. The format is `VRMC_vrm_animation-1.0` of the VRM Consortium's
//! vrm-specification. `import` reads a `.vrma` file like glTF, with the bones that the file states. Expressions and the
//! gaze are nodes with [`Node::face`](mocap_scene::scene::Node::face).
//!
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//! use mocap::{Conversion, Exporter};
//!
//! let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
//! Conversion::new().apply(&mut scene)?;
//! let folder = tempfile::tempdir().unwrap();
//! let written = Exporter::new().export(&scene, folder.path().join("walk.vrma"))?;
//! assert!(written.notes[0].starts_with("joints: LHipJoint")); // it is no bone
//! # Ok::<(), mocap::Error>(())
//! ```

use glam::{Quat, Vec3};
use mocap_figure::Humanoid;
use mocap_figure::vrm_humanoid::vrm_humanoid_shown;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::options::setters;
use mocap_scene::scene::report::DataLoss;
use mocap_scene::scene::{HumanoidBone, NodeId, Scene};

use super::write::{Document, GltfOptions, GltfReport};
use crate::ledger::{joints_left_out, positions_left_out};
use crate::{Export, WriteOptions};

/// Options of the writer.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::gltf::{Compression, GltfOptions};
/// use mocap::vrma::{self, VrmaOptions};
///
/// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// mocap::Conversion::new().apply(&mut scene)?;
/// let options = VrmaOptions::new().gltf(GltfOptions::new().compression(Compression::Int16));
/// let (bytes, report) = options.write(&scene)?;
/// assert!(bytes.starts_with(b"glTF") && report.animated_tracks > 20);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct VrmaOptions {
    /// The joint of each bone. Default: [`Humanoid::of`](mocap_figure::Humanoid::of) finds the joints.
    pub humanoid: Option<Humanoid>,
    /// The storage of keys. The glTF options for constant tracks and for the buffer do not apply.
    pub gltf: GltfOptions,
}

setters! {
    VrmaOptions {
        humanoid: Option<Humanoid>,
        gltf: GltfOptions,
    }
}

impl VrmaOptions {
    /// Returns the bytes of a `.vrma` file, and a report. `scene` must be in metres with +Y up.
    ///
    /// # Errors
    /// The errors of [`figure::vrm_humanoid`](mocap_figure::vrm_humanoid()) and [`GltfOptions::write_glb`], and
    /// [`Code::NoMotion`] if there is no motion.
    pub fn write(&self, scene: &Scene) -> Result<(Vec<u8>, GltfReport)> {
        let (document, report, ..) = document(scene, None, self)?;
        let bytes = document.to_glb()?;
        let report = GltfReport {
            bytes: bytes.len(),
            ..report
        };
        Ok((bytes, report))
    }
}

/// The files of this format.
pub(super) fn files(scene: &Scene, options: &WriteOptions) -> Result<Export> {
    let vrma = VrmaOptions {
        humanoid: options.humanoid.clone(),
        gltf: GltfOptions::of(options),
    };
    let (document, report, notes, losses) = document(scene, options.whole.as_deref(), &vrma)?;
    let mut written = Export {
        files: vec![document.into_glb_file(&options.name)?],
        losses: losses.into_iter().filter(|loss| loss.count > 0).collect(),
        ..report.written()
    };
    written.notes.extend(notes);
    Ok(written)
}

/// Optional bones of a VRM character, and the parts of the body that depend on them.
const OPTIONAL: [(&[HumanoidBone], &str, &str); 4] = [
    (
        &[HumanoidBone::Chest, HumanoidBone::UpperChest],
        "chest and upperChest",
        "shoulders",
    ),
    (&[HumanoidBone::Neck], "neck", "head"),
    (&[HumanoidBone::LeftShoulder], "leftShoulder", "left arm"),
    (&[HumanoidBone::RightShoulder], "rightShoulder", "right arm"),
];

/// The smallest deviation of a body part in degrees that is reported.
const WORTH_A_WORD: f32 = 1.0;

/// A sentence about characters without optional bones, if body parts would deviate. A player drops the rotations of
/// missing bones.
fn off_without_optional_bones(humanoid: &Scene) -> Option<String> {
    let off = OPTIONAL.iter().filter_map(|(bones, names, part)| {
        let (most, mean) = angles_of(humanoid, bones)?;
        (most >= WORTH_A_WORD)
            .then(|| format!("without {names} the {part} by up to {most:.1} degrees, {mean:.1} on average"))
    });
    let off: Vec<String> = off.collect();
    (!off.is_empty()).then(|| {
        format!(
            "bones: on characters that lack optional VRM bones, parts of the body deviate: {}; to avoid these \
             errors, retarget to such a character",
            off.join("; ")
        )
    })
}

/// The largest and the mean angle, in degrees, of the common rotation of consecutive bones.
fn angles_of(humanoid: &Scene, bones: &[HumanoidBone]) -> Option<(f32, f32)> {
    let clip = humanoid.animations.first()?;
    let rotations = |bone: &HumanoidBone| {
        let mut nodes = humanoid.nodes.iter();
        let node = nodes.position(|node| node.humanoid_bone == Some(*bone))?;
        let mut channels = clip.channels.iter();
        let channel = channels.find(|channel| channel.node == Some(NodeId::new(node)))?;
        Some(&channel.rotation_keys)
    };
    let tracks: Vec<_> = bones.iter().filter_map(rotations).collect();
    let frames = tracks.iter().map(|keys| keys.len()).max()?;
    let angle = |frame: usize| {
        // A constant track has one key.
        let at = tracks
            .iter()
            .filter_map(|keys| keys.values.get(frame).or_else(|| keys.values.last()));
        let all = at.fold(Quat::IDENTITY, |above, rotation| above * *rotation);
        (2.0 * Vec3::new(all.x, all.y, all.z).length().atan2(all.w.abs())).to_degrees()
    };
    let angles: Vec<f32> = (0..frames).map(angle).collect();
    let mean = angles.iter().sum::<f32>() / frames as f32;
    Some((angles.iter().copied().fold(0.0, f32::max), mean))
}

/// Returns the document, its report and its notes. Also returns the data that a player of the document loses, and the
/// joint data that the document lacks. `whole` is the complete motion, which determines the T-pose.
fn document(
    scene: &Scene,
    whole: Option<&Scene>,
    options: &VrmaOptions,
) -> Result<(Document, GltfReport, Vec<String>, [DataLoss; 2])> {
    if scene.animations.is_empty() {
        let message = "the scene has no motion, but a VRM animation consists of motion";
        return Err(Diagnostic::new(Code::NoMotion, message)
            .help("name a file with a motion")
            .into());
    }
    // A face needs no body: all parts of the extension are optional.
    let mut humanoid = match scene.is_face_alone() {
        true => scene.clone(),
        false => vrm_humanoid_shown(scene, whole, options.humanoid.clone())?,
    };
    let (left_out, lost) = joints_left_out(scene, &humanoid);
    let losses = [lost, positions_left_out(scene, &humanoid)];
    for loss in losses {
        humanoid.lose(loss.kind, loss.count as usize);
    }
    let document = Document::of_vrm_animation(&humanoid, &options.gltf)?;
    let report = GltfReport {
        left_out,
        joints: humanoid.nodes.iter().filter(|node| node.face.is_none()).count(),
        ..document.report().clone()
    };
    let notes = off_without_optional_bones(&humanoid);
    Ok((document, report, notes.into_iter().collect(), losses))
}
