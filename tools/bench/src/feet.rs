//! Measures how much sliding foot-lock removes, and how it changes the motion: on ten real clips, and on clean clips
//! with artificial sliding.

use std::fmt;
use std::path::Path;

use mocap::convert::FirstFrame;
use mocap::edit::report::DetectedContacts;
use mocap::edit::report::FootLockReport;
use mocap::edit::{ContactOptions, FootLockOptions, foot_lock};
use mocap::figure::HumanoidBone;
use mocap::glam::Vec3;
use mocap::scene::NodeId;
use mocap::{Binding, Conversion, Importer, Pose, Scene, SkeletonMesh};

use crate::Result;

const CLIPS: [&str; 10] = [
    "cmu_12_01_walk.bvh",
    "cmu_01_01.bvh",
    "motionbuilder_vicon_walk.bvh",
    "cmu_salsa_poser_names.bvh",
    "mocopi_jump_six_channels.bvh",
    "z_up_dab.bvh",
    "kinect_openni.bvh",
    "additive_root_walk.bvh",
    "rokoko_dance.bvh",
    "cmu_mixed_rotation_orders.bvh",
];

/// The number of clips, from the start of the list, that are cleaned and then given artificial sliding.
const SLIDING: usize = 3;

/// The largest accepted displacement of any other joint, in metres.
const LIMIT: f64 = 0.02;

pub(crate) fn measure() -> Result<()> {
    println!(
        "| clip | slide in contact, m | after, m | taken back | largest change of another joint, cm | joint | \
         acceleration before | after | where it was low | taken back within {LIMIT} m | largest change, cm |"
    );
    println!("|---|--:|--:|--:|--:|---|--:|--:|--:|--:|--:|");
    for file in CLIPS {
        let mut scene = import(file)?;
        let (source, mut limited) = (positions(&scene), scene.clone());
        let found = foot_lock(&mut scene, 0, &FootLockOptions::default())?;
        let options = FootLockOptions::new().largest_change(Some(LIMIT));
        let within = foot_lock(&mut limited, 0, &options)?;
        println!(
            "| {file} | {:.3} | {:.3} | {:.1} % | {:.1} | {} | {} | {:.1} % | {:.1} |",
            found.slide_before,
            found.slide_after,
            taken_back(&found),
            100.0 * found.largest_other_change,
            found.largest_other_joint,
            Accelerations::new(&source, &positions(&scene)),
            taken_back(&within),
            100.0 * within.largest_other_change,
        );
    }
    println!();
    println!(
        "| clip | slide, cm/s | recall | false alarms | taken back | acceleration before | after | where it was low |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|");
    for file in &CLIPS[..SLIDING] {
        let mut clean = import(file)?;
        // Locks the feet twice, because the contacts of a locked motion begin a little earlier and end a little later.
        for _ in 0..2 {
            foot_lock(&mut clean, 0, &FootLockOptions::default())?;
        }
        for speed in [0.01, 0.05, 0.1, 0.2] {
            slide(file, &clean, speed)?;
        }
    }
    Ok(())
}

fn taken_back(found: &FootLockReport) -> f64 {
    100.0 * (1.0 - found.slide_after / found.slide_before)
}

/// The whole figure slides along X at `speed` metres a second.
fn slide(file: &str, clean: &Scene, speed: f32) -> Result<()> {
    let rate = clean.animations[0].ticks_per_second as f32;
    let mut scene = clean.clone();
    let hips = scene.animations[0]
        .channels
        .iter_mut()
        .find(|channel| channel.position_keys.len() > 1);
    let keys = hips.map(|channel| &mut channel.position_keys.values);
    for (frame, position) in keys.into_iter().flatten().enumerate() {
        position.x += speed * frame as f32 / rate;
    }
    let (before, after) = (detect(clean)?, detect(&scene)?);
    let (mut hits, mut contacts, mut false_alarms, mut others) = (0, 0, 0, 0);
    for (before, after) in before.points.iter().zip(&after.points) {
        for (was, is) in before.at_rest.iter().zip(&after.at_rest) {
            match was {
                true => (contacts, hits) = (contacts + 1, hits + usize::from(*is)),
                false => (others, false_alarms) = (others + 1, false_alarms + usize::from(*is)),
            }
        }
    }
    let slid = positions(&scene);
    foot_lock(&mut scene, 0, &FootLockOptions::default())?;
    let locked = positions(&scene);
    let way = |at: &[Vec<Vec3>]| -> f32 {
        let of_point = |bone: HumanoidBone| {
            let Some(point) = before.point(bone) else { return 0.0 };
            let rests = |frame: &usize| point.at_rest[*frame] && point.at_rest[frame + 1];
            let node = point.node.index();
            let step = |frame: usize| (at[frame + 1][node] - at[frame][node]).reject_from(Vec3::Y).length();
            (0..before.frames - 1).filter(rests).map(step).sum()
        };
        [HumanoidBone::LeftToes, HumanoidBone::RightToes]
            .map(of_point)
            .iter()
            .sum()
    };
    println!(
        "| {file} | {:.0} | {:.1} % | {:.1} % | {:.1} % | {} |",
        100.0 * speed,
        100.0 * hits as f32 / contacts as f32,
        100.0 * false_alarms as f32 / others as f32,
        100.0 * (1.0 - way(&locked) / way(&slid)),
        Accelerations::new(&positions(clean), &locked)
    );
    Ok(())
}

fn detect(scene: &Scene) -> Result<DetectedContacts> {
    Ok(ContactOptions::default().detect(scene, 0, None)?)
}

/// The largest accelerations of a joint, as multiples of the 99th percentile in the unlocked motion.
struct Accelerations {
    before: f32,
    after: f32,
    /// The largest acceleration at moments when the unlocked joint stayed below 1.5 times the percentile, within three
    /// frames.
    added: f32,
}

impl Accelerations {
    fn new(before: &[Vec<Vec3>], after: &[Vec<Vec3>]) -> Self {
        let [old, new] = [before, after].map(accelerations);
        let mut sorted: Vec<f32> = old.concat();
        sorted.sort_by(f32::total_cmp);
        let usual = sorted[sorted.len() * 99 / 100];
        let largest = |values: &[Vec<f32>]| values.iter().flatten().copied().fold(0.0, f32::max) / usual;
        let mut added = 0.0f32;
        for (frame, values) in new.iter().enumerate() {
            let around = &old[frame.saturating_sub(3)..(frame + 4).min(old.len())];
            for (node, value) in values.iter().enumerate() {
                if around.iter().all(|old| old[node] <= 1.5 * usual) {
                    added = added.max(value / usual);
                }
            }
        }
        Self {
            before: largest(&old),
            after: largest(&new),
            added,
        }
    }
}

impl fmt::Display for Accelerations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} | {:.2} | {:.2}", self.before, self.after, self.added)
    }
}

/// The values of all joints, frame by frame.
fn accelerations(at: &[Vec<Vec3>]) -> Vec<Vec<f32>> {
    let of_frame = |frames: &[Vec<Vec3>]| {
        let nodes = 0..frames[0].len();
        let of_node = |node: usize| (frames[2][node] - 2.0 * frames[1][node] + frames[0][node]).length();
        nodes.map(of_node).collect()
    };
    at.windows(3).map(of_frame).collect()
}

fn positions(scene: &Scene) -> Vec<Vec<Vec3>> {
    let animation = &scene.animations[0];
    let binding = Binding::new(scene, animation);
    let mut pose = Pose::rest(scene);
    let frame = |frame: usize| {
        pose.sample(&binding, animation, frame as f64);
        (0..scene.nodes.len())
            .map(|node| pose.position(NodeId::new(node)))
            .collect()
    };
    (0..animation.frame_count()).map(frame).collect()
}

/// A file of fixtures/real in metres with +Y up, without a rest pose in its first frame.
pub(crate) fn import(file: &str) -> Result<Scene> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../fixtures/real")
        .join(file);
    let mut scene = Importer::new().skeleton_mesh(SkeletonMesh::None).import(path)?;
    Conversion::new()
        .first_frame(FirstFrame::DropRestPose)
        .apply(&mut scene)?;
    Ok(scene)
}
