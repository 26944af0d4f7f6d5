//! Steps that take a second motion, which may have any skeleton.

use mocap_edit::report::EditReport;
use mocap_edit::{EditStep, Fitted};
use mocap_figure::{Humanoid, HumanoidMap};
use mocap_scene::error::{Diagnostic, Error, Result};
use mocap_scene::pose::have_the_same_joints;
use mocap_scene::scene::Scene;

use super::{RetargetOptions, Retargeter};

/// Applies steps to all animations of a scene in their order, and records each step. A step with a second motion takes
/// the first animation of a scene of `others`. The step's option `with` is the number of this motion; the first scene
/// of `others` has the number 2. Without `with`, the step takes the motion after the motion of the previous step. A
/// second motion with another skeleton is retargeted, and the report of its step says so.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::edit::{Concat, EditStep, Smooth};
/// use mocap::retarget::apply_steps;
///
/// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let other = mocap::import("fixtures/skeletons/accad_run_turn.bvh")?;
/// let steps: Vec<EditStep> = vec![Smooth::new().cut_off(8.0).into(), Concat::new().into()];
/// let reports = apply_steps(&mut scene, &steps, &[&other], None)?;
/// assert!(reports[0].to_string().starts_with("smooth: "));
/// let text = reports[1].to_string();
/// assert!(text.starts_with("concat with accad_run_turn.bvh, retargeted from another skeleton ("));
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// The errors of the steps, and of [`EditStep::second_motions`]. [`Code::NotHumanoid`](mocap_scene::Code::NotHumanoid)
/// if a second motion has another skeleton and cannot be retargeted. `scene` then has the changes of the previous
/// steps, and of the previous animations.
pub fn apply_steps(
    scene: &mut Scene,
    steps: &[EditStep],
    others: &[&Scene],
    humanoid: Option<&Humanoid>,
) -> Result<Vec<EditReport>> {
    if steps.is_empty() {
        return EditStep::check_others(others).map(|()| Vec::new());
    }
    let found = humanoid.cloned().unwrap_or_else(|| Humanoid::of(scene));
    Ok(apply_steps_with_bones(scene, (steps, None), others, humanoid.cloned(), found)?.0)
}

/// Applies steps to a scene whose bones are already `found`, and returns the bones of the changed scene too. `only` is
/// the animation to change; `None` means all.
#[doc(hidden)]
pub fn apply_steps_with_bones(
    scene: &mut Scene,
    (steps, only): (&[EditStep], Option<usize>),
    others: &[&Scene],
    stated: Option<Humanoid>,
    found: Humanoid,
) -> Result<(Vec<EditReport>, Humanoid)> {
    EditStep::apply_fitted(scene, steps, only, (others, &second_motion), stated, found)
}

/// The motion `other` on the skeleton of `scene`, whose bones are `bones`; `None` if `other` already has the joints of
/// `scene`.
#[doc(hidden)]
pub fn second_motion(scene: &Scene, bones: &HumanoidMap, other: &Scene) -> Result<Option<Fitted>> {
    let Err(difference) = have_the_same_joints(scene, other) else {
        return Ok(None);
    };
    let options = RetargetOptions::new().target_bones(bones.clone());
    let refuse = |error: Error| {
        let Diagnostic { code, message, .. } = error.diagnostic();
        let message =
            format!("the two motions have different skeletons, and the second cannot be retargeted: {message}");
        let help =
            format!("choose motions of humanoids, or motions of one skeleton; these skeletons differ: {difference}");
        Error::from(Diagnostic::new(*code, message).help(help))
    };
    let mut first_alone = other.clone();
    first_alone.animations.truncate(1);
    let retargeting = Retargeter::new(first_alone, scene.clone(), options).map_err(refuse)?;
    let report = &retargeting.clips()[0].report;
    let quality = format!(
        "{}, mean limb error {:.1} degrees",
        report.verdict().as_str(),
        report.mean_degrees()
    );
    let mut moved = retargeting.scene();
    moved.metadata.origin.clone_from(&other.metadata.origin);
    moved.metadata.root_offset.clone_from(&other.metadata.root_offset);
    moved.metadata.steps.clone_from(&other.metadata.steps);
    Ok(Some(Fitted { scene: moved, quality }))
}
