//! Poses a VRM character with a VRM animation, and prints the poses as JSON.
//!
//! usage: `mocap-vrm-runtime CHARACTER ANIMATION SECONDS..`
//!
//! The answer is a list with, for each time, `{BONE: [x, y, z, w], ..}`: the rotation of each bone of the humanoid
//! since the T-pose.

use std::env;
use std::error::Error;

use serde_json::{Map, Value, json};
use vrm_runtime::{AvatarAsset, AvatarRuntime, PlaybackMode, PlaybackOptions, VrmAnimation};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = env::args().skip(1);
    let usage = "usage: mocap-vrm-runtime CHARACTER ANIMATION SECONDS..";
    let avatar = AvatarAsset::load(arguments.next().ok_or(usage)?)?;
    let animation = VrmAnimation::load(arguments.next().ok_or(usage)?)?;
    let rest = avatar.compute_world_matrices(&[]);
    let bones: Vec<_> = avatar
        .humanoid()
        .bones()
        .map(|(bone, node)| (name_of(&format!("{bone:?}")), node.0 as usize))
        .collect();
    let mut runtime = AvatarRuntime::new(avatar);
    let mode = PlaybackMode::Once;
    runtime.play(
        animation,
        PlaybackOptions {
            mode,
            ..PlaybackOptions::default()
        },
    )?;
    let mut poses = Vec::new();
    for seconds in arguments {
        runtime.seek(seconds.parse()?)?;
        let frame = runtime.update(0.0)?;
        let world = frame.world_matrices();
        let turns = bones.iter().map(|(name, node)| {
            let [now, before] = [world[*node], rest[*node]].map(|matrix| matrix.to_scale_rotation_translation().1);
            (name.clone(), json!((now * before.inverse()).normalize().to_array()))
        });
        poses.push(Value::Object(turns.collect::<Map<_, _>>()));
    }
    println!("{}", Value::Array(poses));
    Ok(())
}

/// `leftFoot` of `LeftFoot`.
fn name_of(variant: &str) -> String {
    let (first, rest) = variant.split_at(1);
    first.to_lowercase() + rest
}
