//! The face of a VRM animation: the weights of its expressions, and its gaze.

use mocap_scene::scene::Face;

use super::chain::{Joint, Skeleton};
use super::clip::{Errors, SKIN};
use super::timeline::Timeline;
use super::{Finding, FindingKind, LargestDeviation};

/// Adds the errors of the face of a clip. A weight counts like a position in metres, and the gaze like the rotation of
/// a joint. Returns findings about missing expressions of the clip `name`.
pub(super) fn compare(
    (clip, name): (usize, &str),
    ours: &Skeleton,
    theirs: &Skeleton,
    timeline: &Timeline,
    errors: &mut Errors,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    for joint in &ours.joints {
        let Some(face) = &joint.face else { continue };
        let is_it = |other: &&Joint| other.face.as_ref().is_some_and(|other| other.is_part(face));
        let Some(other) = theirs.joints.iter().find(is_it) else {
            let what = match face {
                Face::LookAt { .. } => "the gaze".to_owned(),
                expression => format!("the expression {}", expression.name()),
            };
            let message = format!("{what} of {name} is not in the file");
            findings.push(Finding::new(FindingKind::Face, message));
            continue;
        };
        for &tick in &timeline.moments {
            let seconds = timeline.seconds(tick);
            let (ours, theirs) = (joint.own(tick / timeline.rate), other.own(seconds));
            match face {
                Face::LookAt { .. } => errors.add_rotation(2.0 * SKIN * (ours.1.angle_between(theirs.1) / 2.0).sin()),
                Face::Preset(_) | Face::Custom(_) => errors.add((ours.0.x - theirs.0.x).abs(), || LargestDeviation {
                    clip,
                    joint: joint.name.clone(),
                    frame: tick as usize,
                    seconds,
                }),
            }
        }
    }
    findings
}
