//! Measures how many poses a second mocap and three.js retarget on one thread. Both are measured by processor time, so
//! that other work on the machine does not count.

use std::path::Path;
use std::process::Command;

use mocap::figure::Humanoid;
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
use mocap::{Importer, Scene, SkeletonMesh};

use crate::feet::import;
use crate::{Result, cpu_seconds};

/// The least ratio to the speed of three.js, and the least number of poses a second with feet.
const WANTED: f64 = 50.0;
const WANTED_WITH_FEET: f64 = 20_000.0;

const CLIPS: [&str; 2] = ["cmu_12_01_walk.bvh", "cmu_01_01.bvh"];
const CHARACTERS: [&str; 2] = ["human_cmu.gltf", "human_vrm1.gltf"];

/// Prints a table with a row for each clip on each character.
pub(crate) fn measure(rounds: usize) -> Result<()> {
    println!("| clip | character | joints | poses/s | with feet | three.js `retargetClip` | times as fast |");
    println!("|---|---|--:|--:|--:|--:|--:|");
    for clip in CLIPS {
        let source = import(clip)?;
        for character in CHARACTERS {
            let path = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("../../fixtures/skeletons")
                .join(character);
            let target = Importer::new().skeleton_mesh(SkeletonMesh::None).import(&path)?;
            let (free, with_feet) = own(&source, &target, rounds)?;
            let three = three(clip, &path, &source, &target);
            let ratio = three.map_or(f64::NAN, |three| free / three);
            println!(
                "| {clip} | {character} | {} | {free:.0} | {with_feet:.0} | {:.0} | {ratio:.0} |",
                target.nodes.len(),
                three.unwrap_or(f64::NAN),
            );
            if ratio < WANTED || with_feet < WANTED_WITH_FEET {
                println!("slower than {WANTED} times three.js, or than {WANTED_WITH_FEET} poses a second with feet");
            }
        }
    }
    Ok(())
}

/// The most poses a second of any round, without and with feet.
fn own(source: &Scene, target: &Scene, rounds: usize) -> Result<(f64, f64)> {
    let animation = &source.animations[0];
    let mut retargeter = PoseRetargeter::new(source, target, &PoseRetargetOptions::default())?;
    let (mut free, mut with_feet) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..rounds {
        let start = cpu_seconds().ok_or("the system does not tell the time of a thread")?;
        let since = || cpu_seconds().map_or(f64::INFINITY, |now| now - start);
        let mut moved = retargeter.animation(source, animation);
        free = free.min(since());
        retargeter.lock_feet(source, 0, target, &mut moved)?;
        with_feet = with_feet.min(since());
    }
    let poses = animation.frame_count() as f64;
    Ok((poses / free, poses / with_feet))
}

/// The most poses a second of three.js, whose caller names the source joint for each target joint.
fn three(clip: &str, character: &Path, source: &Scene, target: &Scene) -> Option<f64> {
    let (from, to) = (Humanoid::of(source), Humanoid::of(target));
    let name = |scene: &Scene, joint: Option<mocap::scene::NodeId>| Some(scene.nodes[joint?.index()].name.clone());
    let pairs = to
        .bones
        .keys()
        .filter_map(|bone| Some((name(target, to.joint(*bone))?, name(source, from.joint(*bone))?.into())));
    let names: serde_json::Map<String, serde_json::Value> = pairs.collect();
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new("node")
        .arg(here.join("peers/retarget.mjs"))
        .arg(here.join("../../fixtures/real").join(clip))
        .arg(character)
        .arg(serde_json::Value::Object(names).to_string())
        .output()
        .ok()?;
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).ok()?;
    value["poses_per_second"].as_f64()
}
