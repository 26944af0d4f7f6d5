//! The memory of commands with a long motion, in addition to its keys.

use mocap::edit::{Clean, Step, StepInput};
use mocap::glam::Quat;
use mocap::scene::Keys;
use mocap::survey::Thresholds;
use mocap::{Exporter, Format, Scene};

/// The number of frames. The buffers of a writer do not grow with the motion, and are small compared with its keys.
const FRAMES: usize = 20_000;

/// A walk, alternately forwards and backwards, so that it has no jumps. `noise` is added to each rotation, in radians.
pub(crate) fn take(noise: f32) -> Scene {
    let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh").unwrap();
    mocap::Conversion::new().apply(&mut scene).unwrap();
    let animation = &mut scene.animations[0];
    let frames = animation.frame_count();
    // The frame of the walk for each frame of the take.
    let own = |frame: usize| {
        let phase = frame % (2 * frames - 2);
        phase.min(2 * frames - 2 - phase)
    };
    let mut state = 1_u32;
    for channel in &mut animation.channels {
        repeat(&mut channel.position_keys, own);
        repeat(&mut channel.rotation_keys, own);
        for rotation in &mut channel.rotation_keys.values {
            let axis = [0; 3].map(|_| {
                // The linear congruential generator of Numerical Recipes.
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                noise * (state as f32 / u32::MAX as f32 - 0.5)
            });
            *rotation *= Quat::from_scaled_axis(axis.into());
        }
    }
    animation.duration = FRAMES as f64 - 1.0;
    scene
}

fn repeat<T: Copy>(keys: &mut Keys<T>, own: impl Fn(usize) -> usize) {
    if keys.len() > 1 {
        let values = (0..FRAMES).map(|frame| keys.values[own(frame)]);
        *keys = Keys::every_tick(values.collect());
    }
}

/// The number of bytes of the keys.
pub(crate) fn bytes(scene: &Scene) -> usize {
    let channels = &scene.animations[0].channels;
    let of_channel = |keys: [usize; 3]| 12 * keys[0] + 16 * keys[1] + 12 * keys[2];
    let counts = channels.iter().map(|channel| {
        let (positions, rotations) = (&channel.position_keys, &channel.rotation_keys);
        of_channel([positions.len(), rotations.len(), channel.scaling_keys.len()])
    });
    counts.sum()
}

/// The name of an operation, its memory in addition to the scene as a multiple of the scene's keys, the noise of the
/// take, and the operation.
type Case = (&'static str, f64, f32, fn(Scene));

pub(crate) const CASES: [Case; 4] = [
    ("BVH", 1.3, 0.0, |scene| {
        Exporter::new().write(&scene, Format::Bvh).unwrap();
    }),
    ("GLB", 2.2, 0.0, |scene| {
        Exporter::new().write(&scene, Format::Gltf).unwrap();
    }),
    ("survey", 0.95, 0.0, |scene| {
        Thresholds::default().examine_read(scene, "walk.bvh");
    }),
    ("clean", 3.4, 0.05, |mut scene| {
        Clean::new().apply(&mut scene, &StepInput::new()).unwrap();
    }),
];
