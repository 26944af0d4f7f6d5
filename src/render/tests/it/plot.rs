//! Tests plots of curves over time.

use crate::drawing::{points, texts};
use mocap::Conversion;
use mocap::render::{Clip, Drawing, PlotOptions};
use mocap::scene::{NodeId, Scene};
use mocap_render::internals::plot::{Scale, thinned};

#[test]
fn marks_stand_at_round_numbers() {
    let scale = Scale::around(-3.2, 17.9, [100.0, 0.0], 5);
    assert_eq!(scale.marks().collect::<Vec<_>>(), [-5.0, 0.0, 5.0, 10.0, 15.0, 20.0]);
    assert_eq!([scale.pixel(-5.0), scale.pixel(20.0)], [100.0, 0.0]);
    let flat = Scale::around(4.0, 4.0, [100.0, 0.0], 4);
    assert!(flat.from < 4.0 && flat.to > 4.0);
}

#[test]
fn thinning_keeps_every_spike() {
    let mut values = vec![0.0; 100_000];
    (values[33_333], values[77_777]) = (9.0, -9.0);
    let kept = thinned(&values, 500);
    assert!(kept.len() <= 2000);
    assert!(kept.contains(&(33_333, 9.0)) && kept.contains(&(77_777, -9.0)));
}

#[test]
fn every_number_at_an_axis_has_its_unit() {
    let mut scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let texts_of = |scene: &Scene| {
        let drawing = Drawing::plot(&Clip { name: "walk", scene }, &[NodeId(1)], &PlotOptions::default());
        let texts = texts(&drawing).into_iter().map(|(text, _)| text.to_string());
        texts.collect::<Vec<_>>()
    };
    // BVH does not state its unit.
    assert!(texts_of(&scene).iter().any(|text| text.ends_with("[file units]")));
    Conversion::new().apply(&mut scene).unwrap();
    let texts = texts_of(&scene);
    assert!(texts.iter().any(|text| text.ends_with("[m]")));
    let numbers = texts
        .iter()
        .filter(|text| text.starts_with(|first: char| first.is_ascii_digit() || first == '-'));
    let numbers: Vec<&String> = numbers.collect();
    assert!(numbers.len() > 10);
    let has_unit = |text: &&&String| [" m", " s", "°"].iter().any(|unit| text.ends_with(unit));
    assert_eq!(numbers.iter().find(|text| !has_unit(text)), None);
}

/// The test reads the curves back with the numbers at the axes, and compares them with the columns of the file.
#[test]
fn a_plot_shows_the_angles_of_the_file() {
    let scene = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let elbow = NodeId::new(scene.nodes.iter().position(|node| node.name == "Elbow").unwrap());
    let clip = Clip {
        name: "Test",
        scene: &scene,
    };
    let drawing = Drawing::plot(&clip, &[elbow], &PlotOptions::default());
    // The lower panel: its labels at the left give the scale.
    let labels: Vec<(f32, f32)> = texts(&drawing)
        .into_iter()
        .filter(|(_, [x, y])| *x < 64.0 && *y > 260.0)
        .filter_map(|(text, [_, y])| Some((text.strip_suffix("°")?.parse().ok()?, y - 4.0)))
        .collect();
    let (&(low, low_y), &(high, high_y)) = (labels.first().unwrap(), labels.last().unwrap());
    let curve = drawing
        .shapes
        .iter()
        .map(points)
        .find(|points| points.len() == 10 && points[0][1] > 260.0)
        .unwrap();
    let shown = curve
        .iter()
        .map(|[_, y]| low + (y - low_y) / (high_y - low_y) * (high - low));
    let text = std::fs::read_to_string("../../fixtures/real/lecture_Test.bvh").unwrap();
    let rows = text.lines().skip_while(|line| !line.starts_with("Frame Time")).skip(1);
    // Column 6 is the Zrotation of the Elbow.
    let column = rows.filter_map(|row| row.split_whitespace().nth(6)?.parse::<f32>().ok());
    for (shown, expected) in shown.zip(column) {
        assert!((shown - expected).abs() < 0.01, "{shown} is not {expected}");
    }
}
