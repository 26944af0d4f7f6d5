//! Defects that lower a verdict, properties that do not, and changes of a file that keep the verdict. The tests edit
//! files as text.

use mocap::glam::Quat;
use mocap::survey::report::{ClipRow, Quality};
use mocap::survey::{Corpus, DefectKind, Thresholds};

const CLEAN: [&str; 4] = [
    "real/cmu_12_01_walk",
    "real/motionbuilder_vicon_walk",
    "skeletons/bvhtoolbox_walk01",
    "skeletons/accad_run_turn",
];

fn text_of(name: &str) -> String {
    let bytes = std::fs::read(format!("../../fixtures/{name}.bvh")).unwrap();
    String::from_utf8_lossy(&bytes).into_owned()
}

fn row_of(text: &str) -> ClipRow {
    let scene = mocap::Importer::new().read(text.as_bytes(), "x.bvh").unwrap();
    Thresholds::default().examine(&scene, "x.bvh").remove(0).row
}

/// A BVH file: its hierarchy, the time of a frame in seconds, and its rows.
struct Bvh {
    hierarchy: String,
    frame_time: f64,
    rows: Vec<String>,
}

impl Bvh {
    fn new(name: &str) -> Self {
        let text = text_of(name);
        let (hierarchy, motion) = text.split_once("MOTION").unwrap();
        let mut lines = motion.lines().map(str::trim).filter(|line| !line.is_empty());
        assert!(lines.next().unwrap().starts_with("Frames"));
        let frame_time = lines.next().unwrap().split_whitespace().last().unwrap();
        Self {
            hierarchy: hierarchy.to_owned(),
            frame_time: frame_time.parse().unwrap(),
            rows: lines.map(str::to_owned).collect(),
        }
    }

    fn stating(&self, frames: usize) -> String {
        let Self {
            hierarchy,
            frame_time,
            rows,
        } = self;
        let rows = rows.join("\n");
        format!("{hierarchy}MOTION\nFrames: {frames}\nFrame Time: {frame_time:.7}\n{rows}\n")
    }

    fn row(&self) -> ClipRow {
        row_of(&self.stating(self.rows.len()))
    }
}

fn amount(row: &ClipRow, kind: DefectKind) -> f64 {
    row.amounts.get(&kind).copied().unwrap_or(0.0)
}

#[test]
fn properties_do_not_lower_the_verdict() {
    for kind in DefectKind::ALL {
        let mut row = ClipRow::default();
        row.amounts.insert(*kind, 1e6);
        row.judge(&Thresholds::default());
        let (of_defects, of_properties) = (row.reasons.as_str(), row.properties.as_str());
        match kind.is_property() {
            true => assert_eq!(
                (row.verdict, row.quality, of_defects, of_properties),
                (Quality::Good, 1.0, "", kind.as_str())
            ),
            false => assert_eq!(
                (row.verdict, of_defects, of_properties),
                (Quality::Bad, kind.as_str(), "")
            ),
        }
    }
}

#[test]
fn a_file_that_is_cut_off_is_bad() {
    for name in CLEAN {
        let mut bvh = Bvh::new(name);
        let stated = bvh.rows.len();
        let kept = stated / 20;
        bvh.rows.truncate(kept);
        let row = row_of(&bvh.stating(stated));
        assert_eq!(row.verdict, Quality::Bad, "{name}: {row:?}");
        let missing = 100.0 * (1.0 - kept as f64 / stated as f64);
        assert!(
            (amount(&row, DefectKind::CutOff) - missing).abs() < 0.1,
            "{name}: {row:?}"
        );
        // A file with the declared number of frames is complete.
        assert_eq!(amount(&bvh.row(), DefectKind::CutOff), 0.0, "{name}");
    }
}

#[test]
fn a_file_without_motion_is_bad_and_a_pose_is_good() {
    let skeleton = row_of(&text_of("real/latin1_name_no_motion"));
    assert_eq!(
        (skeleton.verdict, skeleton.reasons.as_str()),
        (Quality::Bad, "no-motion")
    );
    for name in CLEAN {
        let mut bvh = Bvh::new(name);
        let pose = bvh.rows[bvh.rows.len() / 2].clone();
        bvh.rows = vec![pose.clone(); 200];
        let still = bvh.row();
        assert_eq!(
            (still.verdict, still.reasons.as_str()),
            (Quality::Bad, "no-motion"),
            "{name}"
        );
        for frames in 1..=3 {
            bvh.rows = vec![pose.clone(); frames];
            let row = bvh.row();
            assert_eq!(
                (row.verdict, row.properties.as_str()),
                (Quality::Good, "pose-file"),
                "{name}: {row:?}"
            );
        }
    }
}

#[test]
fn a_motion_at_a_wrong_rate_is_found() {
    for name in CLEAN {
        let mut bvh = Bvh::new(name);
        let own = bvh.frame_time;
        assert!(!bvh.row().reasons.contains("wrong-rate"), "{name}");
        for frame_time in [own / 5.0, 1.0] {
            bvh.frame_time = frame_time;
            let row = bvh.row();
            assert!(row.reasons.contains("wrong-rate"), "{name} {frame_time}: {row:?}");
        }
    }
}

/// A frame repeated for a second is one defect, and changes the verdict of no other kind.
#[test]
fn a_frozen_second_changes_no_other_verdict() {
    for name in CLEAN {
        let mut bvh = Bvh::new(name);
        let own = bvh.row();
        for part in [0.3, 0.6] {
            let at = (part * bvh.rows.len() as f64) as usize;
            let rows = bvh.rows.clone();
            let second = (1.0 / bvh.frame_time).round() as usize;
            let held = vec![bvh.rows[at].clone(); second];
            bvh.rows.splice(at..at, held);
            let mut row = bvh.row();
            assert!((amount(&row, DefectKind::Frozen) - 1.0).abs() < 0.1, "{name}: {row:?}");
            row.amounts.remove(&DefectKind::Frozen);
            row.judge(&Thresholds::default());
            assert_eq!(
                row.verdict, own.verdict,
                "{name}: {} instead of {}",
                row.reasons, own.reasons
            );
            bvh.rows = rows;
        }
    }
}

#[test]
fn a_held_end_and_half_the_rate_leave_the_verdict() {
    for name in CLEAN {
        let own = Bvh::new(name).row();
        let mut held = Bvh::new(name);
        let last = held.rows[held.rows.len() - 1].clone();
        let second = (1.0 / held.frame_time).round() as usize;
        held.rows.extend(vec![last; second]);
        let mut half = Bvh::new(name);
        half.rows = half.rows.iter().step_by(2).cloned().collect();
        half.frame_time *= 2.0;
        // At 15 frames per second, running cannot be distinguished from noise.
        let is_seen = half.frame_time < 1.0 / 25.0;
        let laws = [("held end", held, true), ("half the rate", half, is_seen)];
        for (law, bvh, _) in laws.into_iter().filter(|law| law.2) {
            let row = bvh.row();
            assert_eq!(
                row.verdict, own.verdict,
                "{name}, {law}: {} instead of {}",
                row.reasons, own.reasons
            );
        }
    }
}

/// The rotations of all joints alternate by two degrees between frames, faster than the fingerprint samples.
#[test]
fn a_copy_that_trembles_is_a_near_duplicate() {
    let walk = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let mut trembling = walk.clone();
    for channel in &mut trembling.animations[0].channels {
        for (frame, rotation) in channel.rotation_keys.values.iter_mut().enumerate() {
            let sign = if frame % 2 == 0 { 1.0 } else { -1.0 };
            *rotation *= Quat::from_rotation_x(sign * 2.0_f32.to_radians());
        }
    }
    trembling.metadata.origin = None;
    let thresholds = Thresholds::default();
    let mut clips = thresholds.examine(&walk, "walk.bvh");
    clips.extend(thresholds.examine(&trembling, "trembling.bvh"));
    let corpus = Corpus::new(clips, &thresholds);
    assert_eq!(corpus.rows().filter(|row| row.twin).count(), 1);
}

/// A walk that snaps into the rest pose of the file for 0.3 s, 0.2 s after the beginning or before the end. A file that
/// begins with the rest pose has no such defect.
#[test]
fn a_rest_pose_within_a_walk_is_a_defect_however_near_to_its_ends() {
    let walk = Bvh::new("real/motionbuilder_vicon_walk");
    let frames = walk.rows.len();
    let at_rest = |row: &String| {
        let mut values: Vec<&str> = row.split_whitespace().collect();
        values[3..].fill("0");
        values.join(" ")
    };
    for (first, last, is_defect) in [(24, 59, true), (frames - 60, frames - 25, true), (0, 35, false)] {
        let mut planted = Bvh {
            hierarchy: walk.hierarchy.clone(),
            rows: walk.rows.clone(),
            ..walk
        };
        for row in &mut planted.rows[first..=last] {
            *row = at_rest(row);
        }
        let row = planted.row();
        let seconds = (last + 1 - first) as f64 * walk.frame_time;
        let [defect, property] = [DefectKind::TPose, DefectKind::TPoseEnd].map(|kind| amount(&row, kind));
        let expected = if is_defect { [seconds, 0.0] } else { [0.0, seconds] };
        assert!(
            (defect - expected[0]).abs() < 0.02 && (property - expected[1]).abs() < 0.02,
            "{first}: {defect} {property}, not {expected:?}"
        );
    }
}

/// Shifts the whole body of a fast walk during the stance phase of its left foot: frames 832 to 875, computed with
/// NumPy. Meanwhile the hips accelerate downwards by 8.4 m/s^2, as in the flight phase of a run.
#[test]
fn a_foot_that_slides_in_a_fast_walk_is_found() {
    let mut walk = Bvh::new("real/motionbuilder_vicon_walk");
    assert!(amount(&walk.row(), DefectKind::Skate) < 5.0);
    let inches = 20.0 / 2.54;
    for (frame, row) in walk.rows.iter_mut().enumerate() {
        let moved = inches * ((frame as f64 - 832.0) / (875.0 - 832.0)).clamp(0.0, 1.0);
        let (x, others) = row.split_once(char::is_whitespace).unwrap();
        *row = format!("{} {others}", x.parse::<f64>().unwrap() + moved);
    }
    let row = walk.row();
    let centimetres = amount(&row, DefectKind::Skate);
    assert!((10.0..=22.0).contains(&centimetres), "{centimetres}");
    let found = row.defects.iter().filter(|defect| defect.kind == DefectKind::Skate);
    let spans: Vec<[usize; 2]> = found.map(|defect| defect.frames).collect();
    let is_covered = |frame: &usize| spans.iter().any(|[from, to]| (from..=to).contains(&frame));
    assert!((832..=875).filter(is_covered).count() >= 40, "{spans:?}");
}

/// In a run at 30 frames per second, legs turn by tens of degrees per frame. The test exchanges the legs in ten frames.
#[test]
fn exchanged_legs_of_a_run_are_found() {
    let run = Bvh::new("skeletons/accad_run_turn");
    assert_eq!(amount(&run.row(), DefectKind::Exchanged), 0.0);
    // The columns of a joint: three for each joint before, and three more for the root.
    let joints = run.hierarchy.lines().filter_map(|line| {
        let mut words = line.split_whitespace();
        matches!(words.next(), Some("ROOT" | "JOINT")).then(|| words.next().unwrap().to_owned())
    });
    let joints: Vec<String> = joints.collect();
    let column = |joint: &String| 3 + 3 * joints.iter().position(|other| other == joint).unwrap();
    let lefts = joints
        .iter()
        .filter(|joint| joint.starts_with("Left") && is_of_leg(joint));
    let pairs: Vec<[usize; 2]> = lefts
        .map(|left| [column(left), column(&left.replace("Left", "Right"))])
        .collect();
    assert!(pairs.len() >= 3, "{joints:?}");
    for (first, last) in [(29, 38), (26, 37)] {
        let mut planted = Bvh {
            hierarchy: run.hierarchy.clone(),
            rows: run.rows.clone(),
            ..run
        };
        for row in &mut planted.rows[first..=last] {
            let mut values: Vec<&str> = row.split_whitespace().collect();
            for [left, right] in &pairs {
                (0..3).for_each(|axis| values.swap(left + axis, right + axis));
            }
            *row = values.join(" ");
        }
        let row = planted.row();
        let found = amount(&row, DefectKind::Exchanged);
        assert!((found - (last + 1 - first) as f64).abs() <= 1.0, "{first}: {found}");
    }
}

fn is_of_leg(joint: &str) -> bool {
    ["UpLeg", "Leg", "Foot"].iter().any(|bone| joint.ends_with(bone))
}

/// The body sinks by 6.1 cm for half a second of a walk. Each foot stands about 1 cm from the common level of both
/// feet.
#[test]
fn a_body_that_sinks_by_six_centimetres_is_found() {
    let mut walk = Bvh::new("real/cmu_12_01_walk");
    walk.rows.remove(0);
    assert_eq!(amount(&walk.row(), DefectKind::UnderFloor), 0.0);
    let units = 0.061 / 0.056_444_4;
    for (frame, row) in walk.rows.iter_mut().enumerate() {
        let frame = frame as f64;
        let sunk = ((frame - 160.0) / 12.0).clamp(0.0, 1.0) * ((225.0 - frame) / 12.0).clamp(0.0, 1.0);
        let mut values: Vec<String> = row.split_whitespace().map(str::to_owned).collect();
        values[1] = format!("{:.5}", values[1].parse::<f64>().unwrap() - units * sunk);
        *row = values.join(" ");
    }
    let row = walk.row();
    let centimetres = amount(&row, DefectKind::UnderFloor).max(amount(&row, DefectKind::FootThroughFloor));
    assert!((5.0..=8.0).contains(&centimetres), "{centimetres}");
}
