//! What foot-lock takes back and what it costs: on ten real clips, and on clean ones in which the figure slides.

use std::path::Path;

use mocap::convert::FirstFrame;
use mocap::edit::{ContactOptions, DetectedContacts, FootLockOptions, contacts, foot_lock};
use mocap::glam::Vec3;
use mocap::scene::NodeId;
use mocap::skeleton::HumanoidBone;
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

/// Of these the first ones are made clean, and then slide.
const SLIDING: usize = 3;

pub(crate) fn measure() -> Result<()> {
    println!("| clip | slide in contact, m | after, m | taken back | largest change of another joint, cm | joint |");
    println!("|---|--:|--:|--:|--:|---|");
    for file in CLIPS {
        let mut scene = import(file)?;
        let found = foot_lock(&mut scene, 0, &FootLockOptions::default())?;
        println!(
            "| {file} | {:.3} | {:.3} | {:.1} % | {:.1} | {} |",
            found.slide_before,
            found.slide_after,
            100.0 * (1.0 - found.slide_after / found.slide_before),
            100.0 * found.largest_other_change,
            found.largest_other_joint
        );
    }
    println!();
    println!(
        "| clip | slide, cm/s | recall | false alarms | taken back | acceleration, of the 99th percentile | before |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|");
    for file in &CLIPS[..SLIDING] {
        let mut clean = import(file)?;
        // The contacts of a locked motion begin a little earlier, and end later: twice.
        for _ in 0..2 {
            foot_lock(&mut clean, 0, &FootLockOptions::default())?;
        }
        for speed in [0.01, 0.05, 0.1, 0.2] {
            slide(file, &clean, speed)?;
        }
    }
    Ok(())
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
    let usual = accelerations(&positions(clean));
    let most = accelerations(&locked);
    println!(
        "| {file} | {:.0} | {:.1} % | {:.1} % | {:.1} % | {:.2} | {:.2} |",
        100.0 * speed,
        100.0 * hits as f32 / contacts as f32,
        100.0 * false_alarms as f32 / others as f32,
        100.0 * (1.0 - way(&locked) / way(&slid)),
        most[most.len() - 1] / usual[usual.len() * 99 / 100],
        usual[usual.len() - 1] / usual[usual.len() * 99 / 100]
    );
    Ok(())
}

fn detect(scene: &Scene) -> Result<DetectedContacts> {
    Ok(contacts(scene, 0, None, &ContactOptions::default())?)
}

/// Of all joints in all frames, in order.
fn accelerations(at: &[Vec<Vec3>]) -> Vec<f32> {
    let triples = at.windows(3);
    let mut all: Vec<f32> = triples
        .flat_map(|frames| {
            let nodes = 0..frames[0].len();
            nodes
                .map(|node| (frames[2][node] - 2.0 * frames[1][node] + frames[0][node]).length())
                .collect::<Vec<_>>()
        })
        .collect();
    all.sort_by(f32::total_cmp);
    all
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
