//! The provenance of a file: its origin, all decisions and all changes. The provenance is in the file itself.

use serde::{Deserialize, Serialize};

use mocap_scene::scene::report::{AppliedStep, DataLoss, RootOffsetUsed, SecondMotion};
use mocap_scene::scene::report::{Attribution, FilledJoint, Origin};
use mocap_scene::scene::{Animation, Assumption, Format, Scene, UpAxis, format_name};

use crate::FormatInfo;
use crate::ledger::LedgerOptions;

/// The provenance in a written file: `asset.extras.mocap` in glTF, `extras.mocap` of an animation that was added to a
/// character file, and a property of the scene in FBX.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::gltf::report::Provenance;
///
/// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// mocap::Conversion::new().apply(&mut scene)?;
/// let provenance = Provenance::of(&scene);
/// assert_eq!(provenance.source.unwrap().name, "cmu_short.bvh");
/// assert_eq!((provenance.frames, provenance.steps.len()), (75, scene.metadata.steps.len()));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// The version of this crate.
    pub version: String,
    /// The file from which the scene was read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<Origin>,
    /// The format of the source file. Absent if the scene does not come from a file.
    #[serde(with = "format_name")]
    pub format: Option<Format>,
    /// The number of frames of the written scene.
    pub frames: u64,
    /// The time between two frames in seconds.
    pub frame_time: f64,
    /// The time between two frames of each animation in seconds, if the animations differ.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[doc(hidden)]
    pub clip_frame_times: Vec<f64>,
    /// How the root's OFFSET was used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub root_offset: Option<RootOffsetUsed>,
    /// All other decisions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub assumptions: Vec<Assumption>,
    /// The up axis of the file, if it is not +Y. The writer has rotated the axes of all joints to this up axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
    /// The steps that changed positions or times, in order: unit, axis, trim, frame rate.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<AppliedStep>,
    /// The joints with frames in which too few markers are seen to determine the joint. Frames are counted before the
    /// steps.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub filled: Vec<FilledJoint>,
    /// The origin and licence of the motion.
    #[serde(skip_serializing_if = "Attribution::is_empty")]
    pub attribution: Attribution,
    /// Data that the source has and the file lacks.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub losses: Vec<DataLoss>,
}

impl Provenance {
    /// The provenance of `scene`.
    pub fn of(scene: &Scene) -> Self {
        let rates = scene.animations.iter().map(|animation| animation.ticks_per_second);
        let first = rates.clone().next();
        let are_one = rates.clone().all(|rate| Some(rate) == first);
        Self {
            clip_frame_times: if are_one {
                Vec::new()
            } else {
                rates.map(f64::recip).collect()
            },
            ..Self::of_animation(scene, scene.animations.first())
        }
    }

    /// The provenance of `scene` in a file of a format, including the losses of that format.
    pub(crate) fn in_file(scene: &Scene, format: &FormatInfo) -> Self {
        Self {
            losses: format.losses(scene, LedgerOptions::default()),
            ..Self::of(scene)
        }
    }

    /// The provenance of one animation of `scene`. If the scene has several animations, the provenance states the index
    /// of this animation.
    pub fn of_clip(scene: &Scene, index: usize) -> Self {
        let mut provenance = Self::of_animation(scene, scene.animations.get(index));
        if scene.animations.len() > 1 {
            let steps = std::mem::take(&mut provenance.steps)
                .into_iter()
                .flat_map(|step| match step {
                    AppliedStep::OfClip { index: clip, steps } if clip == index => steps,
                    AppliedStep::OfClip { .. } => Vec::new(),
                    step => vec![step],
                });
            let chosen = std::iter::once(AppliedStep::SelectClip { index });
            provenance.steps = chosen.chain(steps).collect();
        }
        provenance
    }

    /// The provenance of an animation in the file from which its scene was read. The provenance states no index,
    /// because the animation itself contains the provenance.
    pub(crate) fn of_kept(scene: &Scene, index: usize, format: &FormatInfo) -> Self {
        Self {
            losses: format.losses(scene, LedgerOptions::default()),
            ..Self::of_animation(scene, scene.animations.get(index))
        }
    }

    fn of_animation(scene: &Scene, animation: Option<&Animation>) -> Self {
        let metadata = &scene.metadata;
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            source: metadata.origin.clone(),
            format: metadata.format,
            frames: animation.map_or(0, |animation| animation.frame_count() as u64),
            frame_time: animation.map_or(0.0, |animation| animation.ticks_per_second.recip()),
            clip_frame_times: Vec::new(),
            root_offset: metadata.root_offset.clone(),
            assumptions: metadata.assumptions.clone(),
            up: None,
            steps: metadata.steps.clone(),
            filled: metadata
                .solved
                .as_ref()
                .map_or_else(Vec::new, |solved| solved.filled.clone()),
            attribution: metadata.attribution.clone(),
            losses: metadata.lost.clone(),
        }
    }

    /// The decisions without their reasons, for small files.
    pub(crate) fn without_reasons(mut self) -> Self {
        if let Some(used) = &mut self.root_offset {
            used.reason.clear();
        }
        for assumption in &mut self.assumptions {
            assumption.reason.clear();
        }
        self
    }

    /// Records in a written scene that its motion was retargeted from the motion of this provenance. The steps that
    /// changed the skeleton are included.
    pub fn record(&self, scene: &mut Scene) {
        let metadata = &mut scene.metadata;
        let onto_steps = std::mem::replace(&mut metadata.steps, self.steps.clone());
        metadata.origin.clone_from(&self.source);
        metadata.root_offset.clone_from(&self.root_offset);
        metadata.attribution.clone_from(&self.attribution);
        // Edits may follow.
        let last = metadata.steps.iter_mut().rev().find_map(|step| match step {
            AppliedStep::Retarget { onto, .. } => Some(onto),
            _ => None,
        });
        if let Some(onto) = last {
            onto.steps = onto_steps;
        }
    }

    /// The skeleton to which the motion was retargeted, if it is not the skeleton of the source.
    #[doc(hidden)]
    pub fn onto(&self) -> Option<&SecondMotion> {
        self.steps.iter().rev().find_map(|step| match step {
            AppliedStep::Retarget { onto, .. } => Some(onto),
            _ => None,
        })
    }
}
