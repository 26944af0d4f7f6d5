//! Several steps, one after another.

use super::{EditReport, EditStep, StepInput};
use crate::error::{Code, Diagnostic, Result};
use crate::figure::{self, Humanoid};
use crate::scene::{Node, NodeId, Scene};

/// What errors call the second motions.
fn names_of(others: &[&Scene]) -> Vec<String> {
    let name = |(index, other): (usize, &&Scene)| match &other.metadata.origin {
        Some(origin) => origin.name.clone(),
        None => format!("motion {}", index + 2),
    };
    others.iter().enumerate().map(name).collect()
}

/// The node that a step has added, where before there were the nodes `before`.
fn inserted(before: &[String], scene: &Scene) -> Option<NodeId> {
    let differs = |(name, node): (&String, &Node)| *name != node.name;
    let first = std::iter::zip(before, &scene.nodes)
        .position(differs)
        .unwrap_or(before.len());
    (scene.nodes.len() > before.len()).then(|| NodeId::new(first))
}

impl EditStep {
    /// Applies steps to the first animation of a scene in their order, and records each. Those that take a second
    /// motion take that of `others` which their option `with` names, where 2 is the first, or else the one after that
    /// of the step before.
    ///
    /// ```
    /// use mocap::edit::{EditStep, Mirror, Smooth};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let steps: Vec<EditStep> = vec![Smooth::new().cut_off(8.0).into(), Mirror::new().into()];
    /// let reports = EditStep::apply_all(&mut scene, &steps, &[], None)?;
    /// assert!(reports[1].to_string().starts_with("mirror: "));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of the steps, and of [`second_motions`](Self::second_motions). `scene` has then the changes of the steps
    /// before.
    pub fn apply_all(
        scene: &mut Scene,
        steps: &[Self],
        others: &[&Scene],
        humanoid: Option<&Humanoid>,
    ) -> Result<Vec<EditReport>> {
        if steps.is_empty() {
            return Self::second_motions(steps, &names_of(others)).map(|_| Vec::new());
        }
        let found = humanoid.cloned().unwrap_or_else(|| figure::humanoid(scene));
        Ok(Self::apply_found(scene, steps, others, humanoid.cloned(), found)?.0)
    }

    /// Applies steps to a scene whose bones are already `found`, and returns the bones of the changed scene too.
    pub(crate) fn apply_found(
        scene: &mut Scene,
        steps: &[Self],
        others: &[&Scene],
        mut stated: Option<Humanoid>,
        mut found: Humanoid,
    ) -> Result<(Vec<EditReport>, Humanoid)> {
        let seconds = Self::second_motions(steps, &names_of(others))?;
        let mut reports = Vec::new();
        for (step, second) in std::iter::zip(steps, seconds) {
            let before: Vec<String> = scene.nodes.iter().map(|node| node.name.clone()).collect();
            let input = StepInput {
                other: second.map(|index| others[index]),
                humanoid: stated.as_ref(),
                found: Some(&found),
                ..StepInput::new()
            };
            reports.push(step.apply(scene, &input)?);
            let inserted = inserted(&before, scene);
            stated = stated.map(|stated| stated.after(inserted));
            found = found.after(inserted);
        }
        Ok((reports, found))
    }

    /// Of each step the second motion that it takes, counted from 0 among `others`, which are the names of the motions
    /// after the first.
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
    /// [`Code::InvalidValue`] where a step takes a motion that there is not, and where no step takes one that there is.
    pub fn second_motions(steps: &[Self], others: &[String]) -> Result<Vec<Option<usize>>> {
        let refuse = |message: String| Err(Diagnostic::new(Code::InvalidValue, message).into());
        let count = others.len() + 1;
        // The inputs are counted from 1, and the first is the motion itself.
        let mut next = 2;
        let mut taken = Vec::new();
        for step in steps {
            if !step.needs_other() {
                taken.push(None);
                continue;
            }
            let place = step.with().unwrap_or(next);
            if !(2..=count).contains(&place) {
                let name = step.name();
                return refuse(format!("the step {name} takes motion {place}, and there are {count}"));
            }
            taken.push(Some(place - 2));
            next = place + 1;
        }
        match (0..others.len()).find(|place| !taken.contains(&Some(*place))) {
            Some(place) => refuse(format!(
                "{} would do nothing: no step takes it; leave it out",
                others[place]
            )),
            None => Ok(taken),
        }
    }
}
