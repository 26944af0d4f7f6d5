//! Notices while a job runs.

use std::path::Path;

use mocap_edit::report::EditReport;
use mocap_scene::error::{Code, Diagnostic, spelled};
use mocap_scene::scene::{Assumption, Scene, Topic};

/// A notice of a running job.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::job::{Maker, MotionJob, Notice};
///
/// let job = r#"{"source": {"inputs": ["fixtures/real/cmu_short.bvh"]}, "write": {"output": "walk.glb"}}"#;
/// let job: MotionJob = serde_json::from_str(job).unwrap();
/// let mut notes = Vec::new();
/// let mut hear = |said: Notice<'_>| {
///     if let Notice::Note(note) = said {
///         notes.push(note.to_owned());
///     }
/// };
/// let maker = Maker::new(&job, &[], &mut hear)?;
/// maker.make(&job.source.inputs, &job.write.output, &mut hear)?;
/// assert!(notes.iter().any(|note| note.starts_with("unit: cmu, because")));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Debug)]
#[non_exhaustive]
pub enum Notice<'a> {
    /// Possible problems of a file.
    Warnings(&'a Path, &'a [Diagnostic]),
    /// A sentence about a decision, a choice, or data that was dropped.
    Note(&'a str),
    /// The changes of a step.
    Step(&'a EditReport),
}

/// The receiver of notices.
pub(super) type Listener<'a> = &'a mut dyn FnMut(Notice<'_>);

/// Reports the notices about a target skeleton, which needs no motion.
pub(super) fn tell_of_skeleton(scene: &Scene, file: &Path, hear: Listener<'_>) {
    let warnings = scene.warnings.iter().filter(|warning| warning.code != Code::NoMotion);
    hear(Notice::Warnings(file, &warnings.cloned().collect::<Vec<_>>()));
    let left_out = scene.metadata.assumptions.iter();
    let left_out = left_out.filter(|assumption| assumption.topic == Topic::Meshes);
    left_out.for_each(|assumption| hear(Notice::Note(&assumption.to_string())));
}

/// Reports the warnings of a scene, and removes them, so that they are not reported twice.
pub(super) fn say_warnings(scene: &mut Scene, file: &Path, hear: Listener<'_>) {
    let warnings = std::mem::take(&mut scene.warnings);
    if !warnings.is_empty() {
        hear(Notice::Warnings(file, &warnings));
    }
}

pub(super) fn say_all(assumptions: &[Assumption], hear: Listener<'_>) {
    // Lost analog channels and events are reported elsewhere.
    let is_of_motion = |assumption: &&Assumption| !matches!(assumption.topic, Topic::Analog | Topic::Events);
    let sentences = assumptions.iter().filter(is_of_motion).map(Assumption::to_string);
    sentences.for_each(|sentence| hear(Notice::Note(&sentence)));
}

/// Reports the animation that is used if there are several: the first that moves. `only` is a format with one
/// animation.
pub(super) fn clip_taken(scene: &Scene, only: Option<&str>) -> Option<String> {
    if scene.animations.len() < 2 {
        return None;
    }
    let (index, count) = (scene.main_clip(), scene.animations.len());
    let name = &scene.animations[index].name;
    let because = only.map(|format| format!(", because {format} holds one clip"));
    let note = format!(
        "clip: {index} \"{name}\" of {count}{}; {{clip}} selects another clip",
        because.unwrap_or_default()
    );
    Some(spelled(&note).into_owned())
}
