//! What is said of a solved take: how well the body explains its markers, and which of them to look at.

use super::model::Model;
use super::take::Take;
use super::track::Tracked;
use crate::error::{Code, Diagnostic};
use crate::math::median::wide_median;
use crate::scene::{Assumption, Confidence, Scene, Topic};

/// A marker farther from its body than this on the average, in metres, is worth a word.
const LOOSE: f64 = 0.03;

/// Swaps that are named one by one.
const NAMED: usize = 20;

/// Adds the report to the scene: a sentence, and a warning for each marker and each swap that is worth a look.
pub(super) fn say(scene: &mut Scene, take: &Take, model: &Model, tracked: &Tracked) {
    let label = |marker: usize| take.labels[marker].as_str();
    let rms = |marker: usize| {
        let squares = tracked.distances[marker]
            .iter()
            .flatten()
            .map(|distance| distance * distance);
        (squares.clone().sum::<f64>() / squares.count().max(1) as f64).sqrt()
    };
    let all = tracked.distances.iter().flatten();
    let seen = all.clone().flatten().count();
    let mut distances: Vec<f64> = all.clone().flatten().copied().collect();
    let squares: f64 = distances.iter().map(|distance| distance * distance).sum();
    let mean = (squares / seen.max(1) as f64).sqrt();
    let median = wide_median(&mut distances);
    let places = (take.frames * take.tracks.len()).max(1);
    let text = format!(
        "{:.1} mm RMS and {:.1} mm in the median from their bodies; seen in {:.2} % of frames",
        mean * 1000.0,
        median * 1000.0,
        100.0 * seen as f64 / places as f64,
    );
    scene.warnings.retain(|warning| warning.code != Code::Gap);
    scene.metadata.assumptions.push(Assumption {
        topic: Topic::Markers,
        choice: text,
        reason: match take.set {
            Some(set) => format!("the labels are those of {set}"),
            None => "the labels are known one by one, and are those of no known set".to_owned(),
        },
        confidence: Some(if take.set.is_some() {
            Confidence::Sure
        } else {
            Confidence::Likely
        }),
    });
    let mut warn = |code: Code, joint: &str, message: String| {
        scene.warnings.push(Diagnostic::new(code, message).in_joint(joint));
    };
    for (marker, _) in model.markers.iter().enumerate() {
        let gaps = tracked.distances[marker]
            .iter()
            .filter(|distance| distance.is_none())
            .count();
        if gaps > 0 {
            let message = format!(
                "the marker was not seen in {gaps} of {} frames: the others say where its body is",
                take.frames
            );
            warn(Code::Gap, label(marker), message);
        }
        if rms(marker) > LOOSE || tracked.ghosts[marker] > 0 {
            let message = format!(
                "the marker is {:.0} mm RMS from its body, and in {} frames so far that it has little weight",
                rms(marker) * 1000.0,
                tracked.ghosts[marker]
            );
            warn(Code::LooseMarker, label(marker), message);
        }
    }
    for swap in tracked.swaps.iter().take(NAMED) {
        let (a, b) = swap.markers;
        let message = format!(
            "had the label of {} in frames {} to {}: exchanged",
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
    if !take.unknown.is_empty() {
        let message = format!(
            "{} markers of no known name were left out: {}",
            take.unknown.len(),
            take.unknown.join(", ")
        );
        scene.warnings.push(
            Diagnostic::new(Code::LooseMarker, message)
                .help("name them: --markers FILE, an object from labels to landmarks"),
        );
    }
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
        ([], _) => "no frame in which all are seen".to_owned(),
        (missing, []) => format!("none of the known labels; missing: {}", missing.join(", ")),
        (missing, labels) => format!("{}; missing: {}", labels.join(", "), missing.join(", ")),
    };
    Diagnostic::new(Code::InvalidValue, "the markers do not tell where the legs are")
        .expected_found("markers on the pelvis, the knees and the ankles, by names of a known set", found)
        .help("name labels with --markers FILE, a trial of somebody who stands with --static FILE, or joints with --joints")
}
