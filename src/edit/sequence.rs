//! Applies several steps, one after another.

use mocap_figure::{Humanoid, HumanoidMap};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::{Node, NodeId, Scene};

use super::report::EditReport;
use super::step::names;
use super::{EditStep, StepInput};

/// A second motion after retargeting to the skeleton of the first motion.
#[doc(hidden)]
pub struct Fitted {
    #[doc(hidden)]
    pub scene: Scene,
    /// The quality of the retargeting, in a few words.
    #[doc(hidden)]
    pub quality: String,
}

/// A function that retargets a second motion to the skeleton of a scene. Its arguments are the scene, the bones of the
/// scene, and the scene of the second motion. It returns `None` if the second motion already has this skeleton.
pub(crate) type Fit<'a> = &'a dyn Fn(&Scene, &HumanoidMap, &Scene) -> Result<Option<Fitted>>;

/// The names of the second motions for messages.
fn names_of(others: &[&Scene]) -> Vec<String> {
    let name = |(index, other): (usize, &&Scene)| match &other.metadata.origin {
        Some(origin) => origin.name.clone(),
        None => format!("motion {}", index + 2),
    };
    others.iter().enumerate().map(name).collect()
}

/// The node that a step has added to a scene. `before` has the names of the nodes before the step.
fn inserted(before: &[String], scene: &Scene) -> Option<NodeId> {
    let differs = |(name, node): (&String, &Node)| *name != node.name;
    let first = std::iter::zip(before, &scene.nodes)
        .position(differs)
        .unwrap_or(before.len());
    (scene.nodes.len() > before.len()).then(|| NodeId::new(first))
}

impl EditStep {
    /// Applies steps to a scene whose bones are already `found`. Also returns the bones of the changed scene. `fit`
    /// retargets the motions of `others` that have another skeleton. `only` is the animation to change; `None` means
    /// all.
    #[doc(hidden)]
    pub fn apply_fitted(
        scene: &mut Scene,
        steps: &[Self],
        only: Option<usize>,
        (others, fit): (&[&Scene], Fit<'_>),
        mut stated: Option<Humanoid>,
        mut found: Humanoid,
    ) -> Result<(Vec<EditReport>, Humanoid)> {
        let seconds = Self::second_motions(steps, &names_of(others))?;
        let mut reports = Vec::new();
        let moved = scene.moves();
        for (step, second) in std::iter::zip(steps, seconds) {
            let before: Vec<String> = scene.nodes.iter().map(|node| node.name.clone()).collect();
            let second = second.map(|index| (others[index], fit));
            let bones = (stated.as_ref(), &found);
            if scene.animations.len() < 2 || step.info().is_of_skeleton {
                reports.push(step.apply_second(scene, second, bones)?);
            } else {
                reports.extend(step.apply_to_clips(scene, only, second, bones)?);
            }
            let inserted = inserted(&before, scene);
            stated = stated.map(|stated| stated.after(inserted));
            found = found.after(inserted);
        }
        // If the user trims a motion to one frame, the frame is meant as a pose.
        let is_pose = scene.animations.iter().all(|clip| clip.frame_count() == 1);
        match moved && !is_pose && !scene.moves() {
            true => Err(
                Diagnostic::new(Code::NoMotion, "the steps stop the motion: no joint moves any more")
                    .help("leave out the step that stops the motion")
                    .into(),
            ),
            false => Ok((reports, found)),
        }
    }

    /// Applies the step to each animation of several, or to one. If the step is impossible for an animation in which
    /// nothing moves, this animation stays unchanged with a warning, because many files have an empty one.
    fn apply_to_clips(
        &self,
        scene: &mut Scene,
        only: Option<usize>,
        second: Option<(&Scene, Fit<'_>)>,
        bones: (Option<&Humanoid>, &Humanoid),
    ) -> Result<Vec<EditReport>> {
        let (mut reports, mut unchanged) = (Vec::new(), Vec::new());
        let clips = (0..scene.animations.len()).filter(|clip| only.is_none_or(|only| only == *clip));
        for clip in clips {
            let changed = scene.change_clip(clip, |scene| self.apply_second(scene, second, bones));
            let animation = &scene.animations[clip];
            match changed.map_err(|error| scene.in_clip(clip, error)) {
                Ok(report) => reports.push(EditReport {
                    clip: Some(animation.name.clone()),
                    ..report
                }),
                Err(error) if animation.moves() => return Err(error),
                Err(error) => unchanged.push(error),
            }
        }
        if reports.is_empty()
            && let Some(error) = unchanged.pop()
        {
            return Err(error);
        }
        scene.warnings.extend(unchanged.iter().map(|error| {
            let Diagnostic { code, message, .. } = error.diagnostic();
            let message = format!("{message}; nothing moves in the clip, so it stays unchanged");
            Diagnostic::new(*code, message)
        }));
        Ok(reports)
    }

    /// Applies the step to the first animation, with its second motion. The second motion is retargeted if it has
    /// another skeleton.
    fn apply_second(
        &self,
        scene: &mut Scene,
        second: Option<(&Scene, Fit<'_>)>,
        (stated, found): (Option<&Humanoid>, &Humanoid),
    ) -> Result<EditReport> {
        let fitted = match second {
            Some((other, fit)) => {
                let bones = stated.map(|bones| names(scene, bones)).unwrap_or_default();
                fit(scene, &bones, other)?
            }
            None => None,
        };
        let other = second.map(|(other, _)| other);
        let input = StepInput {
            other: fitted.as_ref().map(|fitted| &fitted.scene).or(other),
            humanoid: stated,
            found: Some(found),
            ..StepInput::new()
        };
        let mut report = self.apply(scene, &input)?;
        if let (Some(_), Some(other)) = (&fitted, other) {
            scene.lose(DataKind::FaceCurves, other.weight_curves());
        }
        report.retargeted = fitted.map(|fitted| fitted.quality);
        Ok(report)
    }

    /// Refuses second motions if there is no step that could take them.
    #[doc(hidden)]
    pub fn check_others(others: &[&Scene]) -> Result<()> {
        Self::second_motions(&[], &names_of(others)).map(drop)
    }

    /// For each step, the index of its second motion in `others`, counted from 0. `others` has the names of all inputs
    /// after the first one.
    ///
    /// ```
    /// use mocap::edit::EditStep;
    ///
    /// let steps: Vec<EditStep> = ["concat", "smooth", "blend"].map(|step| step.parse().unwrap()).to_vec();
    /// let names = ["b.bvh".to_owned(), "c.bvh".to_owned()];
    /// assert_eq!(EditStep::second_motions(&steps, &names)?, [Some(0), None, Some(1)]);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if a step takes a motion that does not exist, or if no step takes one of `others`.
    pub fn second_motions(steps: &[Self], others: &[String]) -> Result<Vec<Option<usize>>> {
        let refuse = |message: String| Err(Diagnostic::new(Code::InvalidValue, message).into());
        let count = others.len() + 1;
        // Inputs are counted from 1, and input 1 is the motion that the steps change.
        let mut next = 2;
        let mut taken = Vec::new();
        for step in steps {
            if !step.needs_other() {
                taken.push(None);
                continue;
            }
            let given = step.with().unwrap_or(next);
            if !(2..=count).contains(&given) {
                let name = step.name();
                return refuse(format!(
                    "the step {name} uses the motion number {given}, but the number of motions is {count}"
                ));
            }
            taken.push(Some(given - 2));
            next = given + 1;
        }
        match (0..others.len()).find(|given| !taken.contains(&Some(*given))) {
            Some(given) => refuse(format!(
                "{} would do nothing: no step uses this motion; leave it out",
                others[given]
            )),
            None => Ok(taken),
        }
    }
}
