//! Tests of solving a skeleton from markers. CMU's markers are compared with the joints of the AMC file that CMU's
//! system made of them. `tools/markers` has further checks, with separate kinematics.

mod clusters;
mod gaps;
mod landmarks;
mod lower_body;
mod noise;
mod planted;
mod plug_in_gait;
mod sets;
mod tree;

use std::sync::OnceLock;

use mocap::figure::Humanoid;
use mocap::glam::Vec3;
use mocap::scene::{Confidence, Topic};
use mocap::{Code, Conversion, Exporter, Format, Importer, Pose, Scene};

const TAKE: &str = "../../fixtures/markers/cmu_01_01.c3d";

/// The stride between the kept frames of the take, which stay a motion at a lower rate.
const EVERY: usize = 20;
const FRAMES: usize = 30;

/// The take with every twentieth frame, as a TRC file.
fn trc() -> String {
    let mut scene = mocap::import(TAKE).unwrap();
    Conversion::new()
        .frame_rate(120.0 / EVERY as f64)
        .apply(&mut scene)
        .unwrap();
    let text = Exporter::new()
        .write(&scene, Format::Trc)
        .unwrap()
        .into_bytes()
        .unwrap();
    String::from_utf8(text).unwrap()
}

/// The solution of the take after `change` has changed its text.
fn solved(change: impl Fn(String) -> String) -> mocap::Result<Scene> {
    let text = change(trc());
    Importer::new().markers("auto").read(text.as_bytes(), "take.trc")
}

/// The skeleton solved from the unchanged take. All tests share it, because solving is slow.
fn taken() -> &'static Scene {
    static TAKEN: OnceLock<Scene> = OnceLock::new();
    TAKEN.get_or_init(|| solved(|text| text).unwrap())
}

/// The skeleton solved from the take with two labels exchanged in frames 10 to 19. All tests share it.
fn taken_with_exchange() -> &'static Scene {
    static TAKEN: OnceLock<Scene> = OnceLock::new();
    TAKEN.get_or_init(|| solved(|text| exchanged(&text, ["LELB", "LKNE"], 10..20)).unwrap())
}

fn position(scene: &Scene, name: &str, frame: usize) -> Vec3 {
    let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
    let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
    pose.node_to_world[node].w_axis.truncate()
}

/// The text of a TRC file with the labels of two markers exchanged in these frames.
fn exchanged(text: &str, labels: [&str; 2], frames: std::ops::Range<usize>) -> String {
    /// Lines before the first frame.
    const BEFORE: usize = 6;
    let lines: Vec<&str> = text.lines().collect();
    let columns: Vec<&str> = lines[3].split('\t').collect();
    let [a, b] = labels.map(|label| columns.iter().position(|own| *own == label).unwrap());
    let row = |(index, line): (usize, &&str)| {
        let mut cells: Vec<&str> = line.split('\t').collect();
        if index >= BEFORE && frames.contains(&(index - BEFORE)) {
            (0..3).for_each(|axis| cells.swap(a + axis, b + axis));
        }
        cells.join("\t") + "\n"
    };
    lines.iter().enumerate().map(row).collect()
}

#[test]
fn joints_are_where_the_amc_of_the_same_take_has_them_and_exchanged_labels_are_named() {
    let scene = taken_with_exchange();
    let swap = scene
        .warnings
        .iter()
        .find(|warning| warning.code == Code::SwappedMarkers);
    assert!(
        swap.is_some_and(|swap| swap.message.contains("in frames 10 to 19")),
        "{swap:?}"
    );
    // The bones that a VRM avatar must have.
    let found = Humanoid::of(scene);
    assert!(found.found, "{found:?}");
    let amc = mocap::import("../../fixtures/real/cmu_01_01.amc").unwrap();
    // AMC positions are inches times 0.45. The X of AMC is the laboratory's y.
    let millimetres = 25.4 / 0.45;
    let pairs = [
        ("leftLowerLeg", "ltibia"),
        ("rightLowerLeg", "rtibia"),
        ("leftFoot", "lfoot"),
        ("rightFoot", "rfoot"),
        ("leftLowerArm", "lradius"),
        ("rightUpperArm", "rhumerus"),
    ];
    for (ours, theirs) in pairs {
        let mut off: Vec<f32> = (0..FRAMES)
            .step_by(3)
            .map(|frame| {
                let own = position(scene, ours, frame);
                let own = Vec3::new(-own.z, own.y, own.x);
                own.distance(position(&amc, theirs, frame * EVERY) * millimetres)
            })
            .collect();
        off.sort_unstable_by(f32::total_cmp);
        assert!(off[off.len() / 2] < 45.0, "{ours}: {off:?}");
    }
}

#[test]
fn without_labels_the_same_body_is_guessed_and_said_to_be_a_guess() {
    /// The line of a TRC file with the labels.
    const LABELS: usize = 3;
    let unlabelled = |text: String| {
        let rename = |(index, line): (usize, &str)| match index {
            LABELS => {
                let mut count = 0;
                let cells = line.split('\t').enumerate().map(|(column, cell)| match (column, cell) {
                    (0 | 1, cell) | (_, cell @ "") => cell.to_owned(),
                    _ => {
                        count += 1;
                        format!("M{count}")
                    }
                });
                cells.collect::<Vec<_>>().join("\t")
            }
            _ => line.to_owned(),
        };
        text.lines().enumerate().map(rename).collect::<Vec<_>>().join("\n")
    };
    let (labelled, guessed) = (taken(), solved(unlabelled).unwrap());
    let said = guessed
        .metadata
        .assumptions
        .iter()
        .find(|said| said.topic == Topic::Markers)
        .unwrap();
    assert!(said.reason.starts_with("a guess"), "{}", said.reason);
    assert_eq!(said.confidence, Some(Confidence::Likely));
    for bone in ["hips", "leftFoot", "rightLowerLeg", "leftHand", "rightLowerArm", "head"] {
        for frame in [0, FRAMES / 2, FRAMES - 1] {
            let off = position(&guessed, bone, frame).distance(position(labelled, bone, frame));
            // The positions are in millimetres.
            assert!(off < 30.0, "{bone} in frame {frame}: {off}");
        }
    }
}

#[test]
fn the_report_has_markers_joints_and_swaps() {
    let scene = taken_with_exchange();
    let solved = scene.metadata.solved.as_ref().unwrap();
    assert_eq!(solved.swaps.len(), 1);
    assert_eq!((solved.swaps[0].first, solved.swaps[0].last), (10, 19));
    assert_eq!(solved.markers.len(), 41);
    // At 6 Hz, a second has six of the frames.
    assert_eq!(solved.rms_of_seconds.len(), FRAMES / 6);
    let knee = solved.joints.iter().find(|joint| joint.name == "leftLowerLeg").unwrap();
    // The left thigh of CMU's own skeleton of this person: 7.1578 inches / 0.45, fixtures/real/cmu_01.asf.
    assert!((knee.length - 0.404).abs() < 0.04, "{}", knee.length);
    assert!(knee.is_told && knee.deviation.unwrap() < 0.015, "{knee:?}");
}

#[test]
fn what_is_no_body_is_refused() {
    let refused = |importer: Importer, file: &str| importer.import(file).unwrap_err().to_string();
    let auto = || Importer::new().markers("auto");
    assert!(refused(auto(), "../../fixtures/real/optotrak.c3d").contains("do not show where the legs are"));
    assert!(refused(auto(), "../../fixtures/real/lecture_Test.bvh").contains("no markers"));
    assert!(refused(Importer::new().markers("nosuch.json"), TAKE).contains("nosuch.json"));
    assert!(refused(auto().static_trial("../../fixtures/real/lecture_Test.bvh"), TAKE).contains("no markers"));
    // A standing trial alone also requests a solution from markers.
    assert!(
        refused(
            Importer::new().static_trial(TAKE),
            "../../fixtures/real/lecture_Test.bvh"
        )
        .contains("no markers")
    );
}

#[test]
fn a_file_names_labels() {
    let folder = tempfile::tempdir().unwrap();
    let read = |text: &str| {
        let path = folder.path().join("names.json");
        std::fs::write(&path, text).unwrap();
        Importer::new()
            .markers(path.to_str().unwrap())
            .import("../../fixtures/real/optotrak.c3d")
            .unwrap_err()
            .to_string()
    };
    assert!(read("[]").contains("an object from labels to landmarks"));
    assert!(read(r#"{"a": "ELBOWISH"}"#).contains("ELBOWISH is not a landmark"));
    assert!(read(r#"{"nobody has it": "LASI"}"#).contains("not in the file"));
}

/// The text of a TRC file with a second person, who walks 1.5 m beside the first and has one more marker.
fn two_people(text: &str) -> String {
    let row = |(index, line): (usize, &str)| {
        let cells: Vec<String> = line.split('\t').map(str::to_owned).collect();
        let (before, markers) = cells.split_at(cells.len().min(2));
        let change = |person: &str, beside: f32| -> Vec<String> {
            let of = |(column, cell): (usize, &String)| match (index, cell.parse::<f32>()) {
                (3, _) if !cell.is_empty() => format!("{person}:{cell}"),
                (6.., Ok(number)) if column % 3 == 0 => (number + beside).to_string(),
                _ => cell.clone(),
            };
            markers.iter().enumerate().map(of).collect()
        };
        let mut first = change("Anna", 0.0);
        if index >= 3 {
            // Anna has no first marker.
            first.drain(..3.min(first.len()));
        }
        [before.to_vec(), first, change("Bert", 1500.0)].concat().join("\t") + "\n"
    };
    text.lines().enumerate().map(row).collect()
}

#[test]
fn of_two_people_one_is_solved_and_the_other_by_name() {
    let of = |markers: &str| {
        let text = two_people(&trc());
        Importer::new().markers(markers).read(text.as_bytes(), "two.trc")
    };
    let alone = taken();
    let bert = of("auto:bert").unwrap();
    let beside = position(&bert, "hips", 0) - position(alone, "hips", 0);
    // Positions are in millimetres, and numbers keep the digits of the text.
    assert!(beside.distance(Vec3::X * 1500.0) < 1.0, "{beside}");
    let said = |scene: &Scene, words: &str| scene.warnings.iter().any(|warning| warning.message.contains(words));
    assert!(
        said(&bert, "Bert was solved; 41 markers of Anna were skipped"),
        "{:?}",
        bert.warnings
    );
    let unasked = of("auto").unwrap();
    assert!(
        said(&unasked, "several subjects: Bert was solved"),
        "{:?}",
        unasked.warnings
    );
    let refused = of("auto:Carl").unwrap_err().to_string();
    assert!(
        refused.contains("\"Carl\"") && refused.contains("labels of Anna, Bert"),
        "{refused}"
    );
}

#[test]
fn a_unit_by_which_nobody_is_so_large_is_doubted() {
    let alone = taken();
    // Numbers are in millimetres.
    let doubted = solved(|text| text.replacen("\tmm\t", "\tm\t", 1)).unwrap();
    let warning = doubted
        .warnings
        .iter()
        .find(|warning| warning.code == Code::UnknownUnit)
        .unwrap();
    assert!(warning.message.ends_with("a unit of 0.001 m was used"), "{warning}");
    assert_eq!(doubted.metadata.metres_per_unit, Some(0.001));
    assert!(position(&doubted, "leftFoot", 9).distance(position(alone, "leftFoot", 9)) < 0.01);
}

#[test]
fn a_file_that_is_cut_before_its_first_frame_is_said_to_be() {
    /// The bytes before the first frame. A frame has 672 bytes, and one frame is missing.
    const WITHOUT: usize = 6144 + 671;
    let bytes = std::fs::read(TAKE).unwrap();
    let read = |length: usize| Importer::new().markers("auto").read(&bytes[..length], "cut.c3d");
    let error = read(WITHOUT).unwrap_err();
    let said = error.diagnostic();
    assert_eq!(said.code, Code::UnexpectedEnd);
    assert!(
        said.message.contains("cut off before the end of its first frame"),
        "{said}"
    );
    assert_eq!(
        said.expected.as_deref(),
        Some("600 frames of 672 bytes from byte 6144 on")
    );
    assert_eq!(said.found.as_deref(), Some("0 in a file of 6815 bytes"));
    let none = Importer::new().markers("auto").read(b"PathFileType\t4\t(X/Y/Z)\tx.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n100\t0\t1\tmm\nFrame#\tTime\tLASI\n\n", "none.trc");
    let said = none.unwrap_err().to_string();
    assert!(said.contains("has no frames: it names 1 markers"), "{said}");
}
