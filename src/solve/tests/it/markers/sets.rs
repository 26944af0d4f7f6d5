//! Tests of each marker set, planted on a body with known joints.

use mocap_solve::internals::{by_key, keys};

use super::landmarks::{GUIDES, labels};
use super::planted::{Place, knee, legs, planted, walk};

/// The stride between the used frames of the walk, which leaves 8 frames per second.
const EVERY: usize = 15;

/// The positions of landmarks on the body. A landmark of a side has no side letter.
const PLACES: &[(&str, Place)] = &[
    ("ASI", ("Hips", "UpLeg", [30.0, 90.0, 90.0])),
    ("PSI", ("Hips", "UpLeg", [-40.0, 90.0, -110.0])),
    ("SACR", ("Hips", "Hips", [0.0, -11.0, -63.0])),
    ("ILC", ("Hips", "UpLeg", [60.0, 110.0, 0.0])),
    ("MFWT", ("Hips", "Hips", [0.0, -11.0, 137.0])),
    ("MBWT", ("Hips", "Hips", [0.0, -11.0, -63.0])),
    ("KNE", ("UpLeg", "Leg", [60.0, 0.0, 0.0])),
    ("KNM", ("UpLeg", "Leg", [-60.0, 0.0, 0.0])),
    ("GTR", ("UpLeg", "UpLeg", [90.0, -10.0, 0.0])),
    ("THI", ("UpLeg", "UpLeg", [80.0, -180.0, 30.0])),
    ("TH2", ("UpLeg", "UpLeg", [80.0, -280.0, 40.0])),
    ("TH3", ("UpLeg", "UpLeg", [70.0, -230.0, -40.0])),
    ("ANK", ("Leg", "Foot", [43.0, 0.0, 0.0])),
    ("ANM", ("Leg", "Foot", [-43.0, 0.0, 0.0])),
    ("TIB", ("Leg", "Leg", [50.0, -150.0, 30.0])),
    ("TB2", ("Leg", "Leg", [50.0, -250.0, 30.0])),
    ("TB3", ("Leg", "Leg", [45.0, -200.0, -30.0])),
    ("FHE", ("Leg", "Leg", [60.0, -20.0, -10.0])),
    ("TTU", ("Leg", "Leg", [0.0, -50.0, 45.0])),
    ("HEE", ("Foot", "Foot", [0.0, -50.0, -60.0])),
    ("MFS", ("Foot", "Foot", [0.0, -10.0, 60.0])),
    ("MFL", ("Foot", "Foot", [35.0, -30.0, 50.0])),
    ("TOE", ("Foot", "ToeBase", [-20.0, 20.0, 0.0])),
    ("TIP", ("Foot", "ToeBase", [0.0, 10.0, 50.0])),
    ("MT1", ("Foot", "ToeBase", [-40.0, 10.0, 0.0])),
    ("MT5", ("Foot", "ToeBase", [40.0, 10.0, -20.0])),
    ("C7", ("Spine1", "Neck", [0.0, 20.0, -60.0])),
    ("T2", ("Spine1", "Neck", [0.0, -30.0, -75.0])),
    ("T10", ("Spine1", "Spine1", [0.0, 0.0, -100.0])),
    ("CLAV", ("Spine1", "Neck", [0.0, -60.0, 70.0])),
    ("STRN", ("Spine1", "Spine1", [0.0, 0.0, 120.0])),
    ("XYPH", ("Spine1", "Spine1", [0.0, -40.0, 115.0])),
    ("RBAC", ("Spine1", "Spine1", [80.0, 60.0, -90.0])),
    ("LBAC", ("Spine1", "Spine1", [80.0, 60.0, -90.0])),
    ("BBAC", ("Spine1", "Spine1", [0.0, -60.0, -95.0])),
    ("NAVE", ("Spine", "Spine", [0.0, 0.0, 110.0])),
    ("SHO", ("Shoulder", "Arm", [0.0, 60.0, 0.0])),
    ("SHF", ("Shoulder", "Arm", [0.0, 20.0, 60.0])),
    ("SHB", ("Shoulder", "Arm", [0.0, 20.0, -60.0])),
    ("UPA", ("Arm", "Arm", [150.0, 50.0, 0.0])),
    ("ELB", ("Arm", "ForeArm", [0.0, 42.0, 0.0])),
    ("ELM", ("Arm", "ForeArm", [0.0, -42.0, 0.0])),
    ("FRM", ("ForeArm", "ForeArm", [120.0, 0.0, 40.0])),
    ("WRA", ("ForeArm", "Hand", [0.0, 0.0, 35.0])),
    ("WRB", ("ForeArm", "Hand", [0.0, 0.0, -35.0])),
    ("FIN", ("Hand", "Hand", [80.0, 20.0, 0.0])),
    ("HNI", ("Hand", "Hand", [70.0, 10.0, 40.0])),
    ("FHD", ("Head", "Head", [70.0, 120.0, 80.0])),
    ("BHD", ("Head", "Head", [60.0, 120.0, -80.0])),
    ("HEAD", ("Head", "Head", [0.0, 200.0, 0.0])),
    ("HEDF", ("Head", "Head", [0.0, 120.0, 100.0])),
    ("HEDS", ("Head", "Head", [80.0, 120.0, 0.0])),
    ("EAR", ("Head", "Head", [75.0, 100.0, 0.0])),
];

/// The side and the position of a landmark.
fn place(landmark: &str) -> (&'static str, Place) {
    let of = |name: &str| PLACES.iter().find(|(own, _)| *own == name).map(|(_, place)| *place);
    let side = if landmark.starts_with('R') { "Right" } else { "Left" };
    let found = of(landmark).or_else(|| of(&landmark[1..]));
    (side, found.unwrap_or_else(|| panic!("{landmark} has no place")))
}

/// The markers of a guide with their positions.
pub(super) fn markers(guide: &str) -> Vec<(String, &'static str, Place)> {
    let (labels, known) = (labels(guide), by_key());
    let placed = |(label, key): (&String, String)| {
        let (side, place) = place(&known.get(&key)?.name);
        Some((label.clone(), side, place))
    };
    std::iter::zip(&labels, keys(&labels, &known))
        .filter_map(placed)
        .collect()
}

#[test]
fn each_set_tells_the_legs() {
    let truth = walk();
    for (set, guide, _) in GUIDES {
        let solved = planted(&truth, EVERY, &markers(guide)).solved();
        let said = solved.metadata.assumptions.iter().any(|said| said.reason.contains(set));
        assert!(said, "{set}: {:?}", solved.metadata.assumptions);
        for side in ["Left", "Right"] {
            let legs = legs(&solved, &truth, EVERY, side);
            let rms = knee(&legs);
            assert!(rms < 3.0, "{set}, {side} knee: {rms} degrees RMS");
            for (index, joint) in ["hip", "knee", "ankle"].into_iter().enumerate() {
                let off = legs
                    .iter()
                    .map(|[own, truth]| own[index].distance(truth[index]))
                    .sum::<f32>();
                let mean = off / legs.len() as f32;
                assert!(mean < 25.0, "{set}, {side} {joint}: {mean} mm");
            }
        }
    }
}
