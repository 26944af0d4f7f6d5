//! The report about a solved take: how well the body explains its markers, and which markers to check.

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::math::median::median;
use mocap_scene::scene::report::{FilledJoint, MarkerSolution, SolvedJoint, SolvedMarker, SwappedMarkers};
use mocap_scene::scene::{Assumption, Confidence, Scene, Topic};

use super::calibrate::Certainty;
use super::model::Model;
use super::subjects;
use super::take::Take;
use super::track::TrackingOutcome;
use crate::set::JointSet;

/// The mean distance of a marker from its body, in metres, above which the marker gets a warning.
const LOOSE: f64 = 0.03;

/// The largest number of swaps, of filled gaps and of unknown names that are listed individually.
const NAMED: usize = 20;

/// The standard deviation in metres below which a joint is not mentioned.
const KNOWN: f64 = 0.005;

/// Builds the machine-readable report.
pub(super) fn solved(
    scene: &Scene,
    take: &Take,
    (set, model, known): (&JointSet, &Model, &[Option<Certainty>]),
    tracked: &TrackingOutcome,
) -> MarkerSolution {
    let mut solved = MarkerSolution::default();
    for (marker, distances) in tracked.distances.iter().enumerate() {
        let seen = distances
            .iter()
            .enumerate()
            .filter_map(|(frame, distance)| Some((frame, (*distance)?)));
        let (worst_frame, worst) = seen
            .clone()
            .fold((0, 0.0), |most, own| if own.1 > most.1 { own } else { most });
        solved.markers.push(SolvedMarker {
            label: take.labels[marker].clone(),
            landmark: take.landmarks[marker].name.clone(),
            rms: rms(seen.clone().map(|(_, distance)| distance)),
            worst,
            worst_frame,
            seen: seen.count() as f64 / take.frames.max(1) as f64,
            far: tracked.ghosts[marker],
        });
    }
    let rate = scene
        .animations
        .first()
        .map_or(1.0, |animation| animation.ticks_per_second);
    let second = (rate.round() as usize).max(1);
    solved.rms_of_seconds = (0..take.frames)
        .step_by(second)
        .map(|first| {
            let last = (first + second).min(take.frames);
            rms(tracked
                .distances
                .iter()
                .flat_map(|track| track[first..last].iter().flatten().copied()))
        })
        .collect();
    for (joint, own) in set
        .joints
        .iter()
        .enumerate()
        .filter(|(_, joint)| joint.parent.is_some())
    {
        solved.joints.push(SolvedJoint {
            name: own.name.clone(),
            length: model.joints[joint].offset.length(),
            deviation: known[joint].map(|known| known.deviation),
            is_told: known[joint].is_some_and(|known| known.deviation < 0.5 * known.before),
        });
    }
    for swap in &tracked.swaps {
        solved.swaps.push(SwappedMarkers {
            labels: [swap.markers.0, swap.markers.1].map(|marker| take.labels[marker].clone()),
            first: swap.first,
            last: swap.last,
        });
    }
    solved.frames = take.frames;
    for (joint, intervals) in std::iter::zip(&set.joints, &tracked.loose) {
        solved.filled.extend(intervals.iter().map(|&(first, last)| FilledJoint {
            joint: joint.name.clone(),
            first,
            last,
        }));
    }
    solved
}

fn rms(distances: impl Iterator<Item = f64>) -> f64 {
    let (mut squares, mut count) = (0.0, 0);
    for distance in distances {
        squares += distance * distance;
        count += 1;
    }
    (squares / f64::from(count.max(1))).sqrt()
}

/// Adds the report to the scene: sentences, and a warning for each marker and each swap to check.
pub(super) fn say(scene: &mut Scene, take: &Take, solved: &MarkerSolution, tracked: &TrackingOutcome) {
    let label = |marker: usize| take.labels[marker].as_str();
    let all = tracked.distances.iter().flatten();
    let seen = all.clone().flatten().count();
    let mut distances: Vec<f64> = all.clone().flatten().copied().collect();
    let mean = rms(distances.iter().copied());
    let median = median(&mut distances).unwrap_or_default();
    let possible = (take.frames * take.tracks.len()).max(1);
    let text = format!(
        "residual {:.1} mm RMS, {:.1} mm median; visible in {:.2} % of frames",
        mean * 1000.0,
        median * 1000.0,
        100.0 * seen as f64 / possible as f64,
    );
    scene.warnings.retain(|warning| warning.code != Code::Gap);
    scene.metadata.assumptions.push(Assumption {
        topic: Topic::Markers,
        choice: text,
        reason: match (take.set, take.guess) {
            (_, Some(_)) => format!(
                "a guess: the labels are unknown; {} of {} markers were identified by constant distances",
                take.landmarks.len(),
                take.landmarks.len() + take.unknown.len()
            ),
            (Some(set), _) => format!("the labels match {set}"),
            _ => "the labels are known individually, but match no known set".to_owned(),
        },
        confidence: Some(match (take.set, take.guess) {
            (_, Some(_)) if !is_plausible(solved, median) => Confidence::Unsure,
            (Some(_), None) => Confidence::Sure,
            _ => Confidence::Likely,
        }),
    });
    say_joints(scene, solved);
    let mut warn = |code: Code, joint: &str, message: String| {
        scene.warnings.push(Diagnostic::new(code, message).in_joint(joint));
    };
    for (marker, own) in solved.markers.iter().enumerate() {
        let gaps = tracked.distances[marker]
            .iter()
            .filter(|distance| distance.is_none())
            .count();
        if gaps > 0 {
            let message = format!(
                "the marker was not seen in {gaps} of {} frames; other markers determine its segment there",
                take.frames
            );
            warn(Code::Gap, label(marker), message);
        }
        if own.rms > LOOSE || own.far > 0 {
            let message = format!(
                "the marker has a residual of {:.0} mm RMS; in {} frames it is so far from its place on the body that \
                 it has little weight",
                own.rms * 1000.0,
                own.far
            );
            warn(Code::LooseMarker, label(marker), message);
        }
    }
    for swap in tracked.swaps.iter().take(NAMED) {
        let (a, b) = swap.markers;
        let message = format!(
            "had the label of {} in frames {} to {}; the labels were exchanged",
            label(b),
            swap.first,
            swap.last
        );
        warn(Code::SwappedMarkers, label(a), message);
    }
    if tracked.swaps.len() > NAMED {
        let message = format!("{} more swaps of markers", tracked.swaps.len() - NAMED);
        warn(Code::SwappedMarkers, "", message);
    }
    if take.guess.is_some() {
        let pairs =
            std::iter::zip(&take.landmarks, &take.labels).map(|(landmark, label)| format!("{label} {}", landmark.name));
        let message = format!(
            "the labels are unknown, so landmarks were guessed: {}",
            pairs.collect::<Vec<_>>().join(", ")
        );
        scene
            .warnings
            .push(Diagnostic::new(Code::LooseMarker, message).help("check the motion; {markers} FILE names landmarks"));
    }
    say_file(scene, take);
}

/// Warnings about the markers, from what the file states.
fn say_file(scene: &mut Scene, take: &Take) {
    if let Some(subject) = &take.subject {
        scene.warnings.push(subjects::left_out(subject, &take.others));
    }
    if let Some((width, stated)) = take.misstated {
        let message = format!(
            "with the unit in the file the front of the pelvis would be {:.3} m wide; a unit of {} m was used",
            width * stated,
            take.metres
        );
        let place = format!("{:.3} m in that unit", width * take.metres);
        scene.warnings.push(
            Diagnostic::new(Code::UnknownUnit, message)
                .expected_found("0.05 to 1 m", place)
                .help("correct the unit in the file"),
        );
    }
    for label in &take.never_seen {
        let message = "the marker was seen in no frame, and was skipped";
        scene.warnings.push(Diagnostic::new(Code::Gap, message).in_joint(label));
    }
    if !take.unattached.is_empty() {
        let message = format!(
            "markers were skipped, because no marker shows the joint of their segment ({}): {}",
            take.unattached.len(),
            take.unattached.join(", ")
        );
        let help = "an arm needs a marker at the elbow and one at the wrist, and a trunk needs both shoulders";
        scene
            .warnings
            .push(Diagnostic::new(Code::LooseMarker, message).help(help));
    }
    if !take.unknown.is_empty() {
        let named = &take.unknown[..take.unknown.len().min(NAMED)];
        let more = if take.unknown.len() > NAMED { ", ..." } else { "" };
        let message = format!(
            "markers with unknown names were skipped ({}): {}{more}",
            take.unknown.len(),
            named.join(", ")
        );
        scene.warnings.push(
            Diagnostic::new(Code::LooseMarker, message)
                .help("name these markers: {markers} FILE, an object from labels to landmarks"),
        );
    }
}

/// Whether guessed landmarks fit a body: the median marker is near it, both arms are present, and both sides are alike.
fn is_plausible(solved: &MarkerSolution, distance: f64) -> bool {
    /// The median distance in metres of markers from the body up to which a guess is plausible: as far as skin slides.
    const NEAR: f64 = 0.010;

    /// The largest difference between left and right, as a fraction of the length, in a plausible guess: the error of
    /// solved lengths.
    const ALIKE: f64 = 0.12;
    let length = |name: &str| {
        solved
            .joints
            .iter()
            .find(|joint| joint.name == name)
            .map(|joint| joint.length)
    };
    let are_alike = |bone: &str| match (length(&format!("left{bone}")), length(&format!("right{bone}"))) {
        (Some(left), Some(right)) => (left - right).abs() < ALIKE * left.max(right),
        _ => false,
    };
    distance < NEAR && ["LowerLeg", "Foot", "LowerArm", "Hand"].into_iter().all(are_alike)
}

/// Reports the lengths of limbs, and the joints that the motion does not determine.
fn say_joints(scene: &mut Scene, solved: &MarkerSolution) {
    let length = |names: [&str; 2]| -> String {
        let of = |name: &str| solved.joints.iter().find(|joint| joint.name == name);
        let lengths = names.map(|name| of(name).map_or("-".to_owned(), |joint| format!("{:.1}", joint.length * 100.0)));
        lengths.join(" and ")
    };
    let limbs = [
        ("thighs", ["leftLowerLeg", "rightLowerLeg"]),
        ("shanks", ["leftFoot", "rightFoot"]),
        ("upper arms", ["leftLowerArm", "rightLowerArm"]),
        ("forearms", ["leftHand", "rightHand"]),
    ];
    let there = limbs
        .into_iter()
        .map(|(name, names)| (name, length(names)))
        .filter(|(_, length)| length != "- and -");
    let lengths: Vec<String> = there.map(|(name, length)| format!("{name} {length} cm")).collect();
    let vague: Vec<String> = (solved.joints.iter())
        .filter(|joint| !joint.is_told)
        .filter_map(|joint| Some((joint, joint.deviation.filter(|deviation| *deviation > KNOWN)?)))
        .map(|(joint, deviation)| format!("{} {:.0} mm", joint.name, deviation * 1000.0))
        .collect();
    let reason = match vague.is_empty() {
        true => "the motion determines every joint".to_owned(),
        false => format!(
            "the motion hardly determines some joints, so regression formulas place them; their standard deviations: \
             {}",
            vague.join(", ")
        ),
    };
    scene.metadata.assumptions.push(Assumption {
        topic: Topic::Markers,
        choice: lengths.join(", "),
        reason,
        confidence: None,
    });
}

/// Reports the frames in which markers do not determine a joint. Outputs keep this note.
pub(super) fn say_gaps(scene: &mut Scene, solved: &MarkerSolution) {
    let place = |filled: &FilledJoint| format!("{} {} to {}", filled.joint, filled.first, filled.last);
    let mut places: Vec<String> = solved.filled.iter().map(place).collect();
    if places.is_empty() {
        return;
    }
    let count = places.len();
    if count > NAMED {
        places.truncate(NAMED);
        places.push(format!("and {} more", count - NAMED));
    }
    scene.metadata.assumptions.push(Assumption {
        topic: Topic::Markers,
        choice: format!("rotations were filled in frames: {}", places.join(", ")),
        reason:
            "too few markers are seen in these frames; a curve through the frames before and after determines the joint"
                .to_owned(),
        confidence: Some(Confidence::Unsure),
    });
}

/// Reports that some joints have no markers beside them.
pub(super) fn say_functional(scene: &mut Scene) {
    scene.metadata.assumptions.push(Assumption {
        topic: Topic::Markers,
        choice: "knees and ankles are the points about which the markers of both segments rotate".to_owned(),
        reason: "no marker is beside some knees or ankles".to_owned(),
        confidence: Some(Confidence::Likely),
    });
}

/// The error for markers from which no legs can be found.
pub(super) fn missing(take: &Take, standing: Option<&Take>) -> Diagnostic {
    const WANTED: [&str; 8] = ["LASI", "RASI", "LPSI", "RPSI", "LKNE", "RKNE", "LANK", "RANK"];
    let has = |name: &str| take.has(name) || standing.is_some_and(|standing| standing.has(name));
    let sacrum = has("SACR");
    let missing: Vec<&str> = WANTED
        .into_iter()
        .filter(|name| !(has(name) || sacrum && name.ends_with("PSI")))
        .collect();
    let found = match (missing.as_slice(), take.labels.as_slice()) {
        ([], _) => "no frame in which all of these markers are seen".to_owned(),
        (missing, []) => format!("none of the known labels; missing: {}", missing.join(", ")),
        (missing, labels) => format!("{}; missing: {}", labels.join(", "), missing.join(", ")),
    };
    let found = match take.guess {
        Some(Err(why)) => format!("{found}; from constant distances: {why}"),
        _ => found,
    };
    Diagnostic::new(Code::InvalidValue, "the markers do not show where the legs are")
        .expected_found(
            "markers on the pelvis, the knees and the ankles, with names of a known set",
            found,
        )
        .help("name labels with {markers} FILE, a standing trial with {static} FILE, or joints with {joints}")
}
