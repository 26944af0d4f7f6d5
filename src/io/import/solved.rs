//! Solves a skeleton from the points of a file, if the caller names a joint set or an array has the joints of SMPL.

use std::path::Path;

use mocap_formats::Source;
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::scene::{NodeKind, Scene};
use mocap_solve::JointSet;
use mocap_solve::markers::{Known, solve_markers};

use super::{Importer, is_array};

/// The value that selects the joint set by the labels of the file. `auto:NAME` selects only the labels of the subject
/// NAME.
const AUTO: &str = "auto";

impl Importer {
    /// Solves rotations from the positions of a scene without a skeleton.
    pub(super) fn solve_points(&self, scene: &mut Scene, source: &Source<'_>) -> Result<()> {
        // A standing trial is needed only if the skeleton is computed from markers.
        let implied = self.standing.as_ref().filter(|_| self.joints.is_none()).map(|_| AUTO);
        let markers = self.markers.as_deref().or(implied);
        let set = match &self.joints {
            _ if markers.is_some() => None,
            Some(joints) => Some(joint_set(joints, source)?),
            None if is_array(scene) && is_points(scene) => set_of_names(scene),
            None => None,
        };
        match (set, self.lengths, markers) {
            (Some(set), lengths, _) => set.lengths(lengths.unwrap_or_default()).solve(scene),
            (None, Some(_), _) => Err(needless_lengths()),
            (None, None, Some(names)) => self.solve_markers(scene, names, source),
            (None, None, None) => {
                scene.warnings.extend(unsolved(scene).filter(|_| is_array(scene)));
                Ok(())
            }
        }
    }

    fn solve_markers(&self, scene: &mut Scene, names: &str, source: &Source<'_>) -> Result<()> {
        check_markers(scene)?;
        let mut known = Known::default().weights(self.marker_weights);
        if let Some(subject) = names.strip_prefix(AUTO).and_then(|rest| rest.strip_prefix(':')) {
            known = known.subject(subject);
        } else if names != AUTO {
            let bytes = (source.open)(Path::new(names))?;
            let text = String::from_utf8(bytes)
                .map_err(|_| Diagnostic::new(Code::BinaryFile, format!("{names} is not UTF-8 text")))?;
            known = known.named(names, &text)?;
        }
        if let Some(standing) = &self.standing {
            let bytes = (source.open)(standing)?;
            let importer = Self {
                format: None,
                markers: None,
                standing: None,
                joints: None,
                lengths: None,
                ..self.clone()
            };
            let trial = importer.read(&bytes, standing)?;
            check_markers(&trial).map_err(|error| error.with_path(standing))?;
            known = known.standing(trial);
        }
        solve_markers(scene, &known)
    }
}

/// The error for the option `lengths` if no joint positions are solved.
fn needless_lengths() -> Error {
    let message = "{lengths} is for rotations that are solved from joint positions, but nothing is solved here";
    let help = "name the joints with {joints}, or omit {lengths}";
    Diagnostic::new(Code::InvalidValue, message).help(help).into()
}

/// A built-in joint set, or the set of a JSON file.
fn joint_set(joints: &str, source: &Source<'_>) -> Result<JointSet> {
    if let Some(set) = JointSet::named(joints) {
        return Ok(set);
    }
    let unknown = |why: String| -> Error {
        Diagnostic::new(Code::InvalidValue, format!("\"{joints}\" is not a joint set"))
            .expected_found(format!("{}, or a JSON file", JointSet::names()), why)
            .into()
    };
    let bytes = (source.open)(Path::new(joints)).map_err(|error| unknown(error.diagnostic().message.clone()))?;
    let text = String::from_utf8(bytes).map_err(|_| unknown("a file that is not UTF-8 text".to_owned()))?;
    JointSet::from_json(joints, &text)
}

/// Refuses a scene that is not a group of points.
fn check_markers(scene: &Scene) -> Result<()> {
    if is_points(scene) {
        return Ok(());
    }
    if scene.animations.is_empty() && is_group(scene) {
        return Err(no_frame(scene).into());
    }
    let message = "the file has no markers: it has a skeleton, or no motion";
    let help = "mocap convert accepts files with a skeleton; {joints} names the joints of arrays";
    Err(Diagnostic::new(Code::InvalidValue, message).help(help).into())
}

/// The error for markers without frames. If the file is cut off, its reader has reported the stated and the available
/// frames.
fn no_frame(scene: &Scene) -> Diagnostic {
    let cut = scene
        .warnings
        .iter()
        .find(|warning| warning.code == Code::MissingFrames);
    let markers = scene.nodes.len() - 1;
    let Some(cut) = cut else {
        let message = format!("the file has no frames: it names {markers} markers, but has no positions");
        return Diagnostic::new(Code::NoMotion, message).help("export the take again, with its frames");
    };
    let mut diagnostic = cut.clone();
    diagnostic.code = Code::UnexpectedEnd;
    diagnostic.message = format!(
        "the file is cut off before the end of its first frame: it has only the labels of its {markers} \
            markers"
    );
    diagnostic.help("export or download the file again")
}

/// Whether the scene is a group of points that move.
fn is_points(scene: &Scene) -> bool {
    !scene.animations.is_empty() && is_group(scene)
}

/// Whether the scene consists of one group.
fn is_group(scene: &Scene) -> bool {
    scene.nodes.first().is_some_and(|node| node.kind == NodeKind::Group)
}

/// The warning for points without a skeleton if a joint set has the same number of points.
fn unsolved(scene: &Scene) -> Option<Diagnostic> {
    let count = scene.nodes.len().checked_sub(1).filter(|_| is_points(scene))?;
    let sets = JointSet::of_count(count);
    if sets.is_empty() {
        return None;
    }
    let message = format!(
        "the file has {count} points and no skeleton; joint sets with {count} points: {}",
        sets.join(", ")
    );
    Some(Diagnostic::new(Code::NotHumanoid, message).help("name their joint set: {joints}"))
}

/// The joint set whose joints have the names of the points.
fn set_of_names(scene: &Scene) -> Option<JointSet> {
    let names: Vec<&str> = scene.nodes.iter().skip(1).map(|node| node.name.as_str()).collect();
    ["smpl22", "smpl24", "mhr70", "mhr127"]
        .into_iter()
        .filter_map(JointSet::named)
        .find(|set| set.has_points(&names))
}
