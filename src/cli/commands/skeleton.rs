//! `mocap skeleton`: the unit, the axes and the rest pose of a file, and the joint of each humanoid bone.

mod animal;

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use mocap::Scene;
use mocap::figure::report::Guess;
use mocap::figure::report::{Explanation, TPoseBone, TPoseSource};
use mocap::figure::report::{RestPose, Sides};
use mocap::figure::{Axis, Confidence, Creature, Figure, Humanoid, HumanoidBone, TPose};
use mocap::job::SourceUp;
use mocap::scene::{NodeId, RootOffset};
use serde::Serialize;

use self::animal::QuadrupedReport;
use super::{Place, import_drawn, mapped_figure, print_report};
use crate::args::SkeletonArgs;
use crate::{Failure, report};

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct SkeletonReport {
    file: String,
    unit: UnitReport,
    up: Guess<Axis>,
    facing: Guess<Axis>,
    root_offset: Option<Guess<&'static str>>,
    rest_pose: Guess<RestPose>,
    sides: Guess<Sides>,
    humanoid: HumanoidReport,
    /// The parts of an animal on four legs.
    #[serde(skip_serializing_if = "Option::is_none")]
    quadruped: Option<QuadrupedReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    floor: Option<Guess<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    asymmetry: Option<Guess<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    t_pose: Option<TPoseReport>,
    /// The explanation of the guessed bones. A map of the user does not change it.
    #[serde(skip_serializing_if = "Option::is_none")]
    explanation: Option<Explanation>,
    /// Whether the text also shows the explanation.
    #[serde(skip)]
    is_explained: bool,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct TPoseReport {
    source: TPoseSource,
    /// The largest of `degrees`.
    largest_rotation: f32,
    bones: BTreeMap<HumanoidBone, RotationReport>,
}

/// The rotation that brings a bone into T-pose, after its ancestors.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RotationReport {
    /// In world axes: x, y, z, w.
    rotation: [f32; 4],
    degrees: f32,
    /// The confidence in the roll of the bone.
    confidence: Confidence,
    reason: &'static str,
}

impl TPoseReport {
    /// `sides` are the sides that the joint names state. The report names the bones with these sides.
    fn new(pose: &TPose, sides: Sides) -> Self {
        let as_named = |bone: HumanoidBone| {
            if sides == Sides::Opposite {
                bone.mirrored()
            } else {
                bone
            }
        };
        let turn = |found: &TPoseBone| RotationReport {
            // Adding zero makes -0 a plain 0.
            rotation: found.rotation.to_array().map(|value| value + 0.0),
            degrees: TPose::degrees(found.rotation),
            confidence: found.confidence,
            reason: found.reason.as_str(),
        };
        Self {
            source: pose.source,
            largest_rotation: pose.largest_rotation(),
            bones: pose
                .bones
                .iter()
                .map(|(bone, found)| (as_named(*bone), turn(found)))
                .collect(),
        }
    }
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct UnitReport {
    metres: f64,
    name: String,
    confidence: Confidence,
    reason: String,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct HumanoidReport {
    found: bool,
    reason: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    creature: Option<Creature>,
    bones: BTreeMap<HumanoidBone, BoneReport>,
    missing: Vec<HumanoidBone>,
    /// Joints that follow a joint other than their parent, each with the joint that it follows.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    follow: BTreeMap<String, String>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct BoneReport {
    joint: String,
    confidence: Confidence,
    reason: String,
}

impl SkeletonReport {
    fn new(file: &Path, scene: &Scene, found: &Figure) -> Self {
        let guess = &found.survey.unit;
        let unit = match scene.metadata.metres_per_unit {
            Some(metres) => UnitReport {
                metres,
                name: mocap::figure::Unit::ALL
                    .into_iter()
                    .find(|unit| unit.metres() == metres)
                    .map_or_else(|| metres.to_string(), |unit| unit.as_str().to_owned()),
                confidence: Confidence::Sure,
                reason: "the file or its format states it".to_owned(),
            },
            None => UnitReport {
                metres: guess.value.metres(),
                name: guess.value.as_str().to_owned(),
                confidence: guess.confidence,
                reason: guess.reason.clone(),
            },
        };
        let root_offset = scene.metadata.root_offset.as_ref().map(|used| Guess {
            value: if used.policy == RootOffset::Add {
                "add"
            } else {
                "replace"
            },
            confidence: used.confidence,
            reason: used.reason.clone(),
        });
        let humanoid = &found.humanoid;
        let name = |node: NodeId| scene.nodes[node.index()].name.clone();
        let bone = |joint: &mocap::figure::report::HumanoidJoint| BoneReport {
            joint: name(joint.joint),
            confidence: joint.confidence,
            reason: joint.reason.clone(),
        };
        Self {
            file: file.display().to_string(),
            unit,
            up: found.up.clone(),
            facing: found.facing.clone(),
            root_offset,
            rest_pose: found.rest_pose.clone(),
            sides: Guess {
                value: humanoid.sides,
                confidence: humanoid.sides_confidence,
                reason: humanoid.sides_reason.clone(),
            },
            humanoid: HumanoidReport {
                found: humanoid.found,
                reason: humanoid.reason.clone(),
                creature: humanoid.creature,
                bones: humanoid
                    .bones
                    .iter()
                    .map(|(name, joint)| (*name, bone(joint)))
                    .collect(),
                missing: humanoid.missing(),
                follow: humanoid
                    .follow
                    .iter()
                    .map(|(joint, other)| (name(*joint), name(*other)))
                    .collect(),
            },
            quadruped: found.quadruped(scene).map(|found| QuadrupedReport::new(scene, found)),
            floor: found.ground(scene),
            asymmetry: found.asymmetry.clone(),
            t_pose: found.t_pose(scene).map(|pose| TPoseReport::new(pose, humanoid.sides)),
            explanation: None,
            is_explained: false,
        }
    }
}

/// The output of `--json`.
pub(crate) fn summary(args: &SkeletonArgs) -> Result<serde_json::Value, Failure> {
    find(args).map(|found| super::value(&found))
}

fn find(args: &SkeletonArgs) -> Result<SkeletonReport, Failure> {
    // Read the skin, as `retarget` does for a character: it shows the joints that follow other joints.
    let mut scene = import_drawn(&args.read, SourceUp::default(), &args.file)?;
    report::warnings(Some(&args.file), &args.source.contradictions(&scene));
    args.source.state(&mut scene);
    let mut found = SkeletonReport::new(&args.file, &scene, &mapped_figure(&scene, &args.map)?);
    if args.source.metres_per_unit().is_some() {
        found.unit.reason = "--unit states it".to_owned();
    }
    if args.source.up().is_some() {
        found.up.reason = "--up states it".to_owned();
    }
    if args.explain {
        found.is_explained = true;
        found.explanation = Humanoid::explain(&scene);
    }
    Ok(found)
}

pub(crate) fn run(args: &SkeletonArgs) -> Result<(), Failure> {
    let found = find(args)?;
    print_report(&found, args.json, Place::Result)
}

impl SkeletonReport {
    /// The scores of the tables of the guess, row by row, and the roll of each bone.
    fn write_explanation(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(explanation) = &self.explanation else {
            return writeln!(
                f,
                "\nnothing was guessed: the file states its bones, or has no two chains that can be legs"
            );
        };
        let shown = |text: &str| text.escape_debug().to_string();
        for part in &explanation.parts {
            writeln!(f, "\n{}: log-likelihood {:.2}", part.part, part.log_likelihood)?;
            for row in &part.evidence {
                let what = match &row.joint {
                    Some(joint) => format!("{} {:?}", row.row, shown(joint)),
                    None => row.row.to_owned(),
                };
                let expected = match (row.expected, row.spread) {
                    (Some(mean), Some(spread)) => format!("of {mean:.2}, spread {:.0} %", 100.0 * spread),
                    _ => String::new(),
                };
                let (found, adds) = (row.found, row.log_likelihood);
                writeln!(
                    f,
                    "  {:<8} {what:<46} {found:>6.2} {expected:<20} {adds:>+7.2}",
                    row.table
                )?;
            }
            if let Some((joints, score)) = &part.second {
                let less = part.log_likelihood - score;
                let others = joints.iter().filter(|joint| !part.joints.contains(joint));
                let others: Vec<&str> = others.map(String::as_str).collect();
                let gone = part.joints.iter().filter(|joint| !joints.contains(joint));
                let gone: Vec<&str> = gone.map(String::as_str).collect();
                let with = if others.is_empty() {
                    "nothing".to_owned()
                } else {
                    others.join(", ")
                };
                let instead = if gone.is_empty() {
                    String::new()
                } else {
                    format!(" in place of {}", gone.join(", "))
                };
                writeln!(f, "  second choice, log-likelihood lower by {less:.2}: {with}{instead}")?;
            }
        }
        match &explanation.second {
            Some((limbs, score)) => {
                let less = explanation.log_likelihood - score;
                writeln!(
                    f,
                    "\nsecond choice of limbs, log-likelihood lower by {less:.2}: {}",
                    shown(limbs)
                )?;
            }
            None => writeln!(f, "\nno second choice of limbs")?,
        }
        if !self.humanoid.found {
            writeln!(f, "\nrefused: {}", self.humanoid.reason)?;
        }
        let Some(pose) = &self.t_pose else { return Ok(()) };
        writeln!(
            f,
            "\nrotation to the T-pose in degrees, and the evidence for the roll of each bone:"
        )?;
        for (bone, turn) in &pose.bones {
            let confidence = turn.confidence.as_str();
            writeln!(
                f,
                "  {:<22} {:>6.1} {confidence:<7} {}",
                bone.as_str(),
                turn.degrees,
                turn.reason
            )?;
        }
        Ok(())
    }

    fn write_guesses(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |what: &str, value: &str, confidence: &Confidence, reason: &str| {
            writeln!(f, "{what:<24} {value:<24} {:<7} {reason}", confidence.as_str())
        };
        let unit = match self.unit.name.as_str() {
            "measured" => format!("{} m", self.unit.metres),
            name => name.to_owned(),
        };
        line("unit", &unit, &self.unit.confidence, &self.unit.reason)?;
        line("up", self.up.value.as_str(), &self.up.confidence, &self.up.reason)?;
        line(
            "facing at rest",
            self.facing.value.as_str(),
            &self.facing.confidence,
            &self.facing.reason,
        )?;
        if let Some(used) = &self.root_offset {
            line("root OFFSET", used.value, &used.confidence, &used.reason)?;
        }
        let pose = &self.rest_pose;
        line("rest pose", pose.value.as_str(), &pose.confidence, &pose.reason)?;
        line(
            "names of the sides",
            self.sides.value.as_str(),
            &self.sides.confidence,
            &self.sides.reason,
        )?;
        if let Some(floor) = &self.floor {
            let height = format!("{:.4}", floor.value);
            line("floor", &height, &floor.confidence, &floor.reason)?;
        }
        if let Some(asymmetry) = &self.asymmetry {
            let percent = format!("{:.1} %", 100.0 * asymmetry.value);
            line("left against right", &percent, &asymmetry.confidence, &asymmetry.reason)?;
        }
        if let Some(pose) = &self.t_pose {
            let source = match pose.source {
                TPoseSource::RestPose => "rest pose",
                TPoseSource::FirstFrame => "first frame",
                TPoseSource::Computed => "computed",
            };
            let reason = format!(
                "no bone rotates by more than {:.0} degrees from the rest pose",
                pose.largest_rotation
            );
            line("T-pose", source, &Confidence::Likely, &reason)?;
        }
        for (bone, joint) in &self.humanoid.bones {
            line(
                bone.as_str(),
                &joint.joint.escape_debug().to_string(),
                &joint.confidence,
                &joint.reason,
            )?;
        }
        for part in self.quadruped.iter().flat_map(|found| &found.parts) {
            let joints = part.joints.join(", ").escape_debug().to_string();
            writeln!(f, "{:<24} {joints}", part.part)?;
        }
        for (joint, other) in &self.humanoid.follow {
            let joint = joint.escape_debug();
            writeln!(f, "{joint:<24} follows {other:?}, not its parent")?;
        }
        let humanoid = &self.humanoid;
        if !humanoid.found {
            let class = humanoid.creature.map(|creature| format!(" ({})", creature.as_str()));
            writeln!(f, "no humanoid: {}{}", humanoid.reason, class.unwrap_or_default())?;
            return match &self.quadruped {
                Some(found) => writeln!(f, "a quadruped ({}): {}", found.confidence.as_str(), found.reason),
                None => Ok(()),
            };
        }
        let missing: Vec<&str> = humanoid.missing.iter().map(|bone| bone.as_str()).collect();
        match missing.as_slice() {
            [] => writeln!(f, "a humanoid: {}", humanoid.reason),
            missing => writeln!(f, "a humanoid without {}: {}", missing.join(", "), humanoid.reason),
        }
    }
}

impl fmt::Display for SkeletonReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_guesses(f)?;
        match self.is_explained {
            true => self.write_explanation(f),
            false => Ok(()),
        }
    }
}
