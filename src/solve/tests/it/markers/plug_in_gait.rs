//! Tests of Plug-in Gait's definitions, on a body with known joints whose wands are turned away from the knee's axis.

use std::sync::Arc;

use mocap::glam::Vec3;
use mocap::scene::Recording;
use mocap::{Importer, Pose, Scene};
use mocap_solve::markers::{Known, solve_markers};

use super::planted::{MILLIMETRES, Place, joint, planted, walk};

/// The stride between the used frames of the walk, which leaves 24 frames per second.
const EVERY: usize = 5;

/// The angle in degrees of the wands about the bone, from the side to the front.
const WAND: f32 = 20.0;

/// Measures in millimetres: leg length, from front spine to trochanter, widths of knee and ankle. The last one is the
/// angle in radians from the line between toe marker and ankle to the sole.
const MEASURES: [(&str, f64); 5] = [
    ("LegLength", 900.0),
    ("AsisTrocanterDistance", 70.0),
    ("KneeWidth", 100.0),
    ("AnkleWidth", 70.0),
    ("StaticPlantFlex", 0.2),
];

/// The vector from a joint to the next one in the rest pose of the left leg: outward, up and forward, in millimetres.
fn bone(scene: &Scene, above: &str, below: &str) -> Vec3 {
    let rest = Pose::rest(scene);
    (joint(scene, &rest, below).0 - joint(scene, &rest, above).0) * MILLIMETRES
}

/// The direction at right angles to a bone of the left leg in which its wand points.
fn wand(bone: Vec3) -> Vec3 {
    let side = Vec3::X.reject_from(bone).normalize();
    let front = side.cross(-bone.normalize());
    side * WAND.to_radians().cos() + front * WAND.to_radians().sin()
}

/// The walk with markers that fit the measures, before it is solved.
fn marked(truth: &Scene) -> Scene {
    // The hips of this body are not equally far from its midline, so the midpoint between them is not the midpoint of
    // the spines.
    let width = 0.5 * (bone(truth, "Hips", "LeftUpLeg").x - bone(truth, "Hips", "RightUpLeg").x);
    let (thigh, shank) = (bone(truth, "LeftUpLeg", "LeftLeg"), bone(truth, "LeftLeg", "LeftFoot"));
    // Davis et al. (1991): from the midpoint of the front spines to the hip centre, and the distance of the spines.
    let (distance, depth) = (0.115 * 900.0 - 15.3, 70.0 + 7.0);
    let (sin, cos) = 0.5_f32.sin_cos();
    let (sin_side, cos_side) = 0.314_f32.sin_cos();
    let up = distance * cos * cos_side + depth * sin_side;
    let forward = depth * cos_side - distance * cos * sin_side;
    let spines = 2.0 * (width + distance * sin);
    let front = Vec3::new(0.5 * spines - width, up, forward);
    let back = front - Vec3::new(0.5 * spines - 50.0, 0.0, 160.0);
    let (thigh_wand, shank_wand) = (wand(thigh), wand(shank));
    let places: [Place; 8] = [
        ("Hips", "UpLeg", front.to_array()),
        ("Hips", "UpLeg", back.to_array()),
        ("UpLeg", "UpLeg", (thigh * 0.5 + thigh_wand * 90.0).to_array()),
        ("UpLeg", "Leg", (thigh_wand * 57.0).to_array()),
        ("Leg", "Leg", (shank * 0.5 + shank_wand * 70.0).to_array()),
        ("Leg", "Foot", (shank_wand * 42.0).to_array()),
        ("Foot", "Foot", [0.0, -50.0, -60.0]),
        ("Foot", "ToeBase", [0.0, 20.0, 0.0]),
    ];
    let labels = ["ASI", "PSI", "THI", "KNE", "TIB", "ANK", "HEE", "TOE"];
    let of = |(letter, side): (&str, &'static str)| {
        let marker = |(label, place): (&str, Place)| (format!("{letter}{label}"), side, place);
        std::iter::zip(labels, places).map(marker).collect::<Vec<_>>()
    };
    let markers = planted(truth, EVERY, &[("L", "Left"), ("R", "Right")].map(of).concat());
    let mut scene = markers.imported(Importer::new()).unwrap();
    let sided = ["L", "R"]
        .into_iter()
        .flat_map(|side| MEASURES.map(|(name, value)| (format!("{side}{name}"), value)));
    scene.metadata.recorded = Some(Arc::new(Recording {
        measures: sided
            .chain([("InterAsisDistance".to_owned(), f64::from(spines))])
            .collect(),
        ..Recording::default()
    }));
    scene
}

/// The largest angle in degrees between the left axis of a solved thigh and its wand. Also the largest distance in
/// millimetres between a solved knee and the true knee.
fn off(solved: &Scene, truth: &Scene) -> (f32, f32) {
    let wand = wand(bone(truth, "LeftUpLeg", "LeftLeg"));
    let frames = solved.animations[0].frame_count();
    (0..frames).fold((0.0, 0.0), |(angle, distance): (f32, f32), frame| {
        let own = Pose::at_tick(solved, 0, frame as f64).unwrap();
        let other = Pose::at_tick(truth, 0, (1 + frame * EVERY) as f64).unwrap();
        let left = joint(solved, &own, "leftUpperLeg").1 * Vec3::X;
        let expected = joint(truth, &other, "LeftUpLeg").1 * wand;
        let knee = joint(solved, &own, "leftLowerLeg").0;
        let true_knee = joint(truth, &other, "LeftLeg").0 * MILLIMETRES;
        (
            angle.max(left.angle_between(expected).to_degrees()),
            distance.max(knee.distance(true_knee)),
        )
    })
}

#[test]
fn wands_define_the_axes_if_the_file_states_the_measures_of_plug_in_gait() {
    let truth = walk();
    let mut scene = marked(&truth);
    let mut without = scene.clone();
    solve_markers(&mut scene, &Known::default()).unwrap();
    let (angle, distance) = off(&scene, &truth);
    assert!(angle < 1.0 && distance < 3.0, "{angle} degrees, {distance} mm");
    let says = |scene: &Scene| {
        scene
            .metadata
            .assumptions
            .iter()
            .any(|said| said.choice.contains("centres and axes of the legs"))
    };
    assert!(says(&scene), "{:?}", scene.metadata.assumptions);
    // Without the measures, and with a wand that is turned on purpose, the motion defines the axes.
    let mut turned = without.clone();
    let mut recorded = (**turned.metadata.recorded.as_ref().unwrap()).clone();
    recorded.measures.push(("LThighRotation".to_owned(), 0.2));
    turned.metadata.recorded = Some(Arc::new(recorded));
    without.metadata.recorded = None;
    for mut scene in [without, turned] {
        solve_markers(&mut scene, &Known::default()).unwrap();
        assert!(!says(&scene), "{:?}", scene.metadata.assumptions);
        assert!(off(&scene, &truth).0 > 0.5 * WAND, "{:?}", off(&scene, &truth));
    }
}
