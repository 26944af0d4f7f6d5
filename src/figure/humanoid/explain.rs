//! Explains the assignment of joints to bones: the scores of each table for the chosen assignment, and the second best
//! assignment.

use mocap_scene::scene::Scene;
use serde::Serialize;

use super::body::{self, Body, Trunk};
use super::limb::{self, Fit, Kind};
use super::tables::{Ratio, Sign, Sums, Tally};
use super::topology::Tree;
use crate::names::words::Part;

/// Explains the chosen assignment of bones: the log-likelihoods of lengths, names and tree shape, by part.
///
/// [`explain`](crate::Humanoid::explain) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Explanation {
    /// The sum of the scores of all parts.
    pub log_likelihood: f32,
    /// The parts: the legs, the arms, the trunk, and the fit between legs and arms.
    pub parts: Vec<PartExplanation>,
    /// The best assignment whose limbs differ from those of the chosen assignment, as one phrase, and its score.
    pub second: Option<(String, f32)>,
}

/// The evidence for and against the assignment of a body part.
///
/// [`explain`](crate::Humanoid::explain) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PartExplanation {
    /// The part, such as `legs`.
    pub part: &'static str,
    /// The joints of the part, from the body outwards, each with its bone.
    pub joints: Vec<String>,
    /// The score of the part. For two limbs, it is the mean of both scores.
    pub log_likelihood: f32,
    /// The rows of the tables that have evidence about the part.
    pub evidence: Vec<ExplanationRow>,
    /// The joints of the second best assignment of this part, and its score.
    pub second: Option<(Vec<String>, f32)>,
}

/// The evidence that one row of a table gives.
///
/// [`explain`](crate::Humanoid::explain) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ExplanationRow {
    /// The name of the table: `lengths`, `names` or `shape`.
    pub table: &'static str,
    /// The row of the table: a ratio of lengths, a part of the body, or a sign of the shape.
    pub row: &'static str,
    /// The joint whose name was read. `None` unless the table is `names`.
    pub joint: Option<String>,
    /// The measured value: the ratio of two lengths, the fit of the name (1 at best), or the amount of the sign.
    pub found: f32,
    /// The mean of the ratio in the table. `None` unless the table is `lengths`.
    pub expected: Option<f32>,
    /// The standard deviation of the logarithm of the ratio. `None` unless the table is `lengths`.
    pub spread: Option<f32>,
    /// The score of the row.
    pub log_likelihood: f32,
}

/// The explanation of a scene's best assignment; `None` if no two chains can be legs.
pub(super) fn explain(scene: &Scene) -> Option<Explanation> {
    let tree = Tree::new(scene, Vec::new());
    let found = body::find(&tree)?;
    let explain = Explain { scene, tree: &tree };
    let mut parts = vec![explain.limbs(&found.legs, Kind::Leg)];
    parts.extend(found.arms.as_ref().map(|arms| explain.limbs(arms, Kind::Arm)));
    parts.push(explain.trunk(&found));
    let mut lines = Lines::new(scene);
    body::weigh_limbs(&found.legs, found.arms.as_ref(), &mut lines);
    parts.push(PartExplanation {
        part: "legs and arms",
        joints: Vec::new(),
        log_likelihood: lines.sum(),
        evidence: lines.all,
        second: None,
    });
    Some(Explanation {
        log_likelihood: found.score,
        parts,
        second: found.second.as_ref().map(|second| (explain.roots(&second.0), second.1)),
    })
}

struct Explain<'a> {
    scene: &'a Scene,
    tree: &'a Tree,
}

impl Explain<'_> {
    fn name(&self, node: usize) -> String {
        self.scene.nodes[node].name.clone()
    }

    /// The limbs of a body, as text.
    fn roots(&self, limbs: &[[usize; 2]]) -> String {
        let pair = |roots: &[usize; 2]| format!("{:?} and {:?}", self.name(roots[0]), self.name(roots[1]));
        match limbs {
            [legs, arms, ..] => format!("legs from {}, arms from {}", pair(legs), pair(arms)),
            [legs] => format!("legs from {}, no arms", pair(legs)),
            [] => String::new(),
        }
    }

    fn limbs(&self, fit: &Fit, kind: Kind) -> PartExplanation {
        let mut lines = Lines::new(self.scene);
        lines.weight = 0.5;
        for side in 0..2 {
            limb::weigh(self.tree, fit, side, kind, &mut lines);
        }
        let second = limb::fit_but(self.tree, &fit.pair, kind, Some(fit.joints));
        PartExplanation {
            part: if kind == Kind::Leg { "legs" } else { "arms" },
            joints: self.joints_of(fit, kind),
            log_likelihood: fit.score,
            evidence: lines.all,
            second: second.map(|second| (self.joints_of(&second, kind), second.score)),
        }
    }

    fn joints_of(&self, fit: &Fit, kind: Kind) -> Vec<String> {
        let limb = |joints: &[Option<usize>; 4]| -> Vec<String> {
            let parts = kind.parts().into_iter().zip(joints);
            parts
                .filter_map(|(part, joint)| Some(format!("{} {:?}", word(part), self.name((*joint)?))))
                .collect()
        };
        fit.joints.iter().flat_map(limb).collect()
    }

    fn trunk(&self, found: &Body) -> PartExplanation {
        let mut lines = Lines::new(self.scene);
        body::weigh_trunk(self.tree, &found.legs, &found.trunk, &mut lines);
        let second = body::trunk_but(self.tree, &found.legs, found.arms.as_ref(), Some(&found.trunk));
        PartExplanation {
            part: "trunk",
            joints: self.joints_of_trunk(&found.trunk),
            log_likelihood: found.trunk.score,
            evidence: lines.all,
            second: second.map(|second| (self.joints_of_trunk(&second), second.score)),
        }
    }

    fn joints_of_trunk(&self, trunk: &Trunk) -> Vec<String> {
        let is = |part: Part, node: usize| format!("{} {:?}", word(part), self.name(node));
        let mut joints = vec![is(Part::Hips, trunk.hips)];
        joints.extend(trunk.spine.iter().map(|node| is(Part::Spine, *node)));
        joints.extend(trunk.neck.map(|node| is(Part::Neck, node)));
        joints.extend(trunk.head.map(|node| is(Part::Head, node)));
        joints
    }
}

/// The name of the part in VRM, without a side.
fn word(part: Part) -> &'static str {
    match part {
        Part::Hips => "hips",
        Part::Spine => "spine",
        Part::Neck => "neck",
        Part::Head => "head",
        Part::Jaw => "jaw",
        Part::Eye => "eye",
        Part::Shoulder => "shoulder",
        Part::UpperArm => "upperArm",
        Part::LowerArm => "lowerArm",
        Part::Hand => "hand",
        Part::UpperLeg => "upperLeg",
        Part::LowerLeg => "lowerLeg",
        Part::Foot => "foot",
        Part::Toes => "toes",
        Part::Finger => "finger",
    }
}

/// Collects the rows with evidence for an explanation.
struct Lines<'a> {
    scene: &'a Scene,
    /// The weight of each row. It is 0.5 for each of two limbs, and 1 otherwise.
    weight: f32,
    all: Vec<ExplanationRow>,
}

impl<'a> Lines<'a> {
    fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            weight: 1.0,
            all: Vec::new(),
        }
    }

    fn sum(&self) -> f32 {
        self.all.iter().map(|line| line.log_likelihood).sum()
    }

    fn add(&mut self, line: ExplanationRow, of: impl FnOnce(&mut Sums)) {
        let mut sums = Sums::default();
        of(&mut sums);
        // Adding zero turns -0 into 0.
        let log_likelihood = self.weight * sums.sum() + 0.0;
        self.all.push(ExplanationRow { log_likelihood, ..line });
    }
}

impl Tally for Lines<'_> {
    fn ratio(&mut self, row: &'static Ratio, ratio: f32) {
        let line = ExplanationRow {
            table: "lengths",
            row: row.what,
            joint: None,
            found: ratio,
            expected: Some(row.mean),
            spread: Some(row.spread),
            log_likelihood: 0.0,
        };
        self.add(line, |sums| sums.ratio(row, ratio));
    }

    fn sign(&mut self, row: &'static Sign, times: f32) {
        let line = ExplanationRow {
            table: "shape",
            row: row.what,
            joint: None,
            found: times,
            expected: None,
            spread: None,
            log_likelihood: 0.0,
        };
        self.add(line, |sums| sums.sign(row, times));
    }

    fn name(&mut self, part: Part, node: usize, fit: f32, weight: f32) {
        let line = ExplanationRow {
            table: "names",
            row: word(part),
            joint: Some(self.scene.nodes[node].name.clone()),
            found: fit,
            expected: None,
            spread: None,
            log_likelihood: 0.0,
        };
        self.add(line, |sums| sums.name(part, node, fit, weight));
    }
}
