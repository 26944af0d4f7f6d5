//! A joint above the hips that only places the figure is not a bone: surveys and graphs find the same body with or
//! without this joint.

use mocap::Scene;
use mocap::figure::Figure;
use mocap::graph::{GraphBuilder, GraphOptions};
use mocap::survey::report::ClipRow;
use mocap::survey::{DefectKind, Thresholds};

const WALKS: [&str; 3] = ["cmu_12_01_walk", "motionbuilder_vicon_walk", "mocopi_jump_six_channels"];

fn text_of(name: &str) -> String {
    std::fs::read_to_string(format!("../../fixtures/real/{name}.bvh")).unwrap()
}

fn read(text: &str) -> Scene {
    mocap::Importer::new().read(text.as_bytes(), "x.bvh").unwrap()
}

fn row_of(scene: &Scene) -> ClipRow {
    Thresholds::default().examine(scene, "x.bvh").remove(0).row
}

/// The motion of `text` below a new, still joint at `root`. The hips get the rest offset `offset`.
fn placed(text: &str, root: [f64; 3], offset: [f64; 3]) -> String {
    let (hierarchy, motion) = text.split_once("MOTION").unwrap();
    let mut lines: Vec<String> = hierarchy.lines().map(str::to_owned).collect();
    let top = lines
        .iter()
        .position(|line| line.trim_start().starts_with("ROOT"))
        .unwrap();
    lines[top] = lines[top].replace("ROOT", "JOINT");
    let below = lines[top..]
        .iter()
        .position(|line| line.trim_start().starts_with("OFFSET"));
    let words = |numbers: [f64; 3]| numbers.map(|number| number.to_string()).join(" ");
    lines[top + below.unwrap()] = format!("OFFSET {}", words(offset));
    let head = "ROOT Placement\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition";
    lines.insert(top, head.to_owned());
    // Subtract the position of the root from the hips, whose position channels come first.
    let rows = motion.lines().map(|line| {
        let numbers: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        if numbers.len() < 6 {
            return line.to_owned();
        }
        let hips = [0, 1, 2].map(|axis| numbers[axis] - root[axis]);
        let rest = line.split_whitespace().skip(3).collect::<Vec<_>>().join(" ");
        format!("{} {} {rest}", words(root), words(hips))
    });
    let rows: Vec<String> = rows.collect();
    format!("{}\n}}\nMOTION{}", lines.join("\n"), rows.join("\n"))
}

#[test]
fn a_joint_that_places_the_figure_is_no_bone_of_it() {
    for name in WALKS {
        let text = text_of(name);
        let scene = read(&text);
        let own = row_of(&scene);
        for (root, offset) in [([0.0; 3], [3.0, 90.0, -450.0]), ([400.0, 0.0, 25.0], [0.0; 3])] {
            let scene = read(&placed(&text, root, offset));
            let row = row_of(&scene);
            assert_eq!(row.joints, own.joints + 1, "{name}");
            assert_eq!(row.skeleton, own.skeleton, "{name}");
            assert_eq!(row.metres_per_unit, own.metres_per_unit, "{name}");
            let (size, expected) = (row.size.unwrap(), own.size.unwrap());
            assert!((size - expected).abs() < 1e-4 * expected, "{name}: {size} {expected}");
            let [breathing, expected] = [&row, &own].map(|row| row.amounts[&DefectKind::Breathing]);
            assert!((breathing - expected).abs() < 0.1, "{name}: {breathing} {expected}");
        }
    }
}

/// The unit of a body without a head is inferred from the extent of its joints.
#[test]
fn where_the_root_stands_does_not_change_the_unit() {
    let text = text_of("cmu_12_01_walk")
        .replace("Head", "Part")
        .replace("Neck", "Piece");
    let unit = |text: &str| Figure::new(&read(text)).survey.unit.value;
    assert_eq!(unit(&placed(&text, [400.0, 0.0, 25.0], [0.0; 3])), unit(&text));
}

#[test]
fn a_graph_takes_clips_whose_hips_stand_elsewhere_at_rest() {
    let text = text_of("cmu_12_01_walk");
    let scene = read(&text);
    let placed = [[0.0, 16.0, 0.0], [-40.0, 20.0, 300.0]].map(|offset| read(&placed(&text, [0.0; 3], offset)));
    let mut builder = GraphBuilder::new(&GraphOptions::new()).unwrap();
    for scene in &placed {
        builder.add("placed.bvh", scene).unwrap();
    }
    let mut plain = GraphBuilder::new(&GraphOptions::new()).unwrap();
    plain.add("plain.bvh", &scene).unwrap();
    let (expected, same, other) = (
        plain.matrix(0, 0).unwrap(),
        builder.matrix(0, 0).unwrap(),
        builder.matrix(0, 1).unwrap(),
    );
    for row in (0..expected.rows).step_by(7) {
        for column in (0..expected.columns).step_by(7) {
            for matrix in [&same, &other] {
                let off = (matrix.at(row, column) - expected.at(row, column)).abs();
                assert!(off < 1e-4, "{row} {column}: {off}");
            }
        }
    }
}
