//! Tests of marker clusters on thighs and shanks, as in running trials, on a body with known joints.

use mocap::Scene;

use super::lower_body::Markers;
use super::planted::{Place, knee, legs, planted, walk};

/// The stride between the used frames of the walk, which leaves 24 frames per second.
const EVERY: usize = 5;

const PLANTED: &[(&str, Place)] = &[
    ("ASI", ("Hips", "UpLeg", [30.0, 90.0, 90.0])),
    ("PSI", ("Hips", "UpLeg", [-40.0, 90.0, -110.0])),
    ("TH1", ("UpLeg", "UpLeg", [80.0, -180.0, 30.0])),
    ("TH2", ("UpLeg", "UpLeg", [80.0, -280.0, 40.0])),
    ("TH3", ("UpLeg", "UpLeg", [70.0, -230.0, -40.0])),
    ("TB1", ("Leg", "Leg", [50.0, -150.0, 30.0])),
    ("TB2", ("Leg", "Leg", [50.0, -250.0, 30.0])),
    ("TB3", ("Leg", "Leg", [45.0, -200.0, -30.0])),
    ("CAL", ("Foot", "Foot", [0.0, -50.0, -60.0])),
    ("TOE", ("Foot", "ToeBase", [-20.0, 20.0, 0.0])),
    ("MT5", ("Foot", "ToeBase", [40.0, 10.0, -20.0])),
];

/// The walk, and the markers on it.
fn clusters() -> (Scene, Markers) {
    let scene = walk();
    let both = [("L", "Left"), ("R", "Right")];
    let sided = |(letter, side): (&str, &'static str)| {
        let of = move |(label, place): &(&str, Place)| (format!("{letter}{label}"), side, *place);
        PLANTED.iter().map(of).collect::<Vec<_>>()
    };
    let markers = planted(&scene, EVERY, &both.map(sided).concat());
    (scene, markers)
}

#[test]
fn clusters_alone_tell_knees_and_ankles() {
    let (truth, markers) = clusters();
    let solved = markers.solved();
    let said = |words: &str| {
        solved
            .metadata
            .assumptions
            .iter()
            .any(|said| said.choice.contains(words))
    };
    assert!(
        said("about which the markers of both segments rotate"),
        "{:?}",
        solved.metadata.assumptions
    );
    for side in ["Left", "Right"] {
        let legs = legs(&solved, &truth, EVERY, side);
        for (frame, [places, true_places]) in legs.iter().enumerate() {
            for (place, true_place) in std::iter::zip(places, true_places) {
                // Half of the width of a knee. The motion does not show where on its axis the knee is.
                assert!(
                    place.distance(*true_place) < 30.0,
                    "{side}, frame {frame}: {places:?}, {true_places:?}"
                );
            }
        }
        let rms = knee(&legs);
        assert!(rms < 3.0, "{side} knee: {rms} degrees RMS");
    }
    // Two markers on a thigh do not show its rotation.
    let mut few = clusters().1;
    let third = few.labels.iter().position(|label| label == "LTH3").unwrap();
    few.labels.remove(third);
    for frame in &mut few.frames {
        frame.remove(third);
    }
    assert!(
        few.read()
            .unwrap_err()
            .to_string()
            .contains("do not show where the legs are")
    );
}
