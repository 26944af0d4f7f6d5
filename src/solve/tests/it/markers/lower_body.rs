//! Tests of a trial of the lower body, without shoulders to show the facing of the pelvis.

use std::fmt::Write;

use mocap::figure::{Figure, Unit};
use mocap::glam::Vec3;
use mocap::scene::Confidence;
use mocap::{Exporter, Format, Importer, Pose, Scene};

use super::{FRAMES, trc};

/// The markers of the lower body in CMU's set.
const LOWER: &[&str] = &[
    "LFWT", "RFWT", "LBWT", "RBWT", "LTHI", "RTHI", "LKNE", "RKNE", "LSHN", "RSHN", "LANK", "RANK", "LHEE", "RHEE",
    "LTOE", "RTOE", "LMT5", "RMT5",
];

/// The positions of markers in a TRC text of millimetres, frame by frame. Hidden markers have NaN.
pub(super) struct Markers {
    pub(super) labels: Vec<String>,
    pub(super) frames: Vec<Vec<Vec3>>,
    /// In frames per second.
    pub(super) rate: f64,
}

impl Markers {
    /// The positions of the lower body in the take, rotated.
    fn lower(turned: impl Fn(Vec3) -> Vec3) -> Self {
        let text = trc();
        let lines: Vec<&str> = text.lines().collect();
        let labels: Vec<&str> = lines[3].split('\t').skip(2).step_by(3).collect();
        let is_lower = |index: &usize| LOWER.contains(&labels[*index]);
        let kept: Vec<usize> = (0..labels.len()).filter(is_lower).collect();
        let frame = |line: &&str| -> Vec<Vec3> {
            let cells: Vec<f32> = line.split('\t').skip(2).filter_map(|cell| cell.parse().ok()).collect();
            kept.iter()
                .map(|index| turned(Vec3::from_slice(&cells[3 * index..])))
                .collect()
        };
        Self {
            labels: kept.iter().map(|index| labels[*index].to_owned()).collect(),
            frames: lines[lines.len() - FRAMES..].iter().map(frame).collect(),
            rate: 120.0 / super::EVERY as f64,
        }
    }

    fn at(&self, label: &str, frame: usize) -> Vec3 {
        self.frames[frame][self.labels.iter().position(|own| own == label).unwrap()]
    }

    pub(super) fn solved(&self) -> Scene {
        self.read().unwrap()
    }

    pub(super) fn read(&self) -> mocap::Result<Scene> {
        self.imported(Importer::new().markers("auto"))
    }

    /// The markers, read as `importer` does.
    pub(super) fn imported(&self, importer: Importer) -> mocap::Result<Scene> {
        let frames = self.frames.len();
        let count = self.labels.len();
        let mut text = format!(
            "PathFileType\t4\t(X/Y/Z)\tlower.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n{}\t{frames}\t{count}\tmm\nFrame#\tTime\t{}\n\n",
            self.rate,
            self.labels.join("\t\t\t")
        );
        for (index, frame) in self.frames.iter().enumerate() {
            write!(text, "{}\t{}", index + 1, index as f32 / 6.0).unwrap();
            for position @ Vec3 { x, y, z } in frame {
                match position.is_nan() {
                    true => text.push_str("\t\t\t"),
                    false => write!(text, "\t{x}\t{y}\t{z}").unwrap(),
                }
            }
            text.push('\n');
        }
        importer.read(text.as_bytes(), "lower.trc")
    }
}

/// The angles in degrees between two lines in all frames.
fn angles(line: impl Fn(usize) -> (Vec3, Vec3)) -> impl Iterator<Item = f32> {
    (0..FRAMES).map(move |frame| {
        let (a, b) = line(frame);
        a.angle_between(b).to_degrees()
    })
}

fn most(angles: impl Iterator<Item = f32>) -> f32 {
    angles.fold(0.0, f32::max)
}

#[test]
fn the_pelvis_looks_where_its_markers_are_however_the_laboratory_stands() {
    // The output has +Y up, so the take is rotated if it stands along another axis.
    type Turn = fn(Vec3) -> Vec3;
    let same: Turn = |point| point;
    let z_up: Turn = |Vec3 { x, y, z }| Vec3::new(x, -z, y);
    let aside: Turn = |Vec3 { x, y, z }| Vec3::new(0.6 * x + 0.8 * z, y, 0.6 * z - 0.8 * x);
    for (turned, in_output) in [(same, same), (z_up, same), (aside, aside)] {
        let (scene, markers) = (Markers::lower(turned).solved(), Markers::lower(in_output));
        let at = |name: &str, frame: usize| {
            let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
            let pose = Pose::at_tick(&scene, 0, frame as f64).unwrap();
            let (_, rotation, position) = pose.node_to_world[node].to_scale_rotation_translation();
            (position, rotation)
        };
        let hips = |frame: usize| at("hips", frame).1;
        let line = |frame: usize| at("leftUpperLeg", frame).0 - at("rightUpperLeg", frame).0;
        let off = most(angles(|frame| (hips(frame) * Vec3::X, line(frame))));
        assert!(off < 3.0, "left of the hips is {off} degrees off the line of the hips");
        // The angle that the markers themselves show.
        let spines =
            |frame: usize, names: [&str; 2]| names.map(|name| markers.at(name, frame)).into_iter().sum::<Vec3>();
        let across = |frame: usize| markers.at("LFWT", frame) - markers.at("RFWT", frame);
        let off = most(angles(|frame| (hips(frame) * Vec3::X, across(frame))));
        assert!(off < 3.0, "left of the hips is {off} degrees off its front spines");
        let forward = |frame: usize| spines(frame, ["LFWT", "RFWT"]) - spines(frame, ["LBWT", "RBWT"]);
        // The belt slides by a centimetre in some frames, which pitches the pelvis by some degrees.
        let off = angles(|frame| (hips(frame) * Vec3::Z, forward(frame).reject_from(across(frame)))).sum::<f32>()
            / FRAMES as f32;
        assert!(
            off < 3.0,
            "forward of the hips is {off} degrees off its spines in the mean"
        );
        // The rest pose is a body that faces +Z, with its left at +X.
        let rest = |name: &str| {
            scene
                .nodes
                .iter()
                .find(|node| node.name == name)
                .unwrap()
                .transform
                .w_axis
        };
        let (left, right) = (rest("leftUpperLeg"), rest("rightUpperLeg"));
        assert!(
            left.x > 50.0 && right.x < -50.0 && (left - right).z.abs() < 10.0,
            "{left} {right}"
        );
        assert!(rest("leftFoot").y < -300.0 && rest("rightToes").z > 50.0);
    }
}

#[test]
fn the_legs_of_a_written_lower_body_show_its_unit() {
    let bvh = Exporter::new().write(&Markers::lower(|point| point).solved(), Format::Bvh);
    let bytes = bvh.unwrap().into_bytes().unwrap();
    let unit = Figure::new(&Importer::new().read(&bytes, "lower.bvh").unwrap())
        .survey
        .unit;
    assert_eq!(
        (unit.value, unit.confidence),
        (Unit::Millimetre, Confidence::Sure),
        "{}",
        unit.reason
    );
}

#[test]
fn points_that_plug_in_gait_computes_are_no_markers() {
    let mut markers = Markers::lower(|point| point);
    let alone = markers.solved();
    // The axes of a shank. The tip of its last axis has the same name as the tip of a toe.
    for label in ["LTIO", "LTIA", "LTIL", "LTIP", "RTIO", "RTIA", "RTIL", "RTIP"] {
        markers.labels.push(label.to_owned());
        markers
            .frames
            .iter_mut()
            .for_each(|frame| frame.push(frame[10] + Vec3::Y * 200.0));
    }
    let scene = markers.solved();
    assert_eq!(scene.nodes, alone.nodes);
    assert!(scene.animations == alone.animations);
    let warns = |scene: &Scene| {
        scene
            .warnings
            .iter()
            .any(|warning| warning.to_string().contains("unknown names"))
    };
    assert!(!warns(&scene), "{:?}", scene.warnings);
    // Without the other axes, the label is the tip of a toe.
    markers.labels[LOWER.len()..]
        .iter_mut()
        .for_each(|label| label.insert(1, 'X'));
    markers.labels[LOWER.len() + 3] = "LTIP".to_owned();
    let scene = markers.solved();
    assert!(scene.animations != alone.animations && warns(&scene));
}
