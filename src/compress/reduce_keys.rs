//! Removes keys within an error bound.

use mocap_scene::error::Result;
use mocap_scene::pose::Binding;
use mocap_scene::scene::{Keys, Scene};

use super::{ErrorBound, Float32, Track, compress};

/// Removes keys of every animation. Every joint and end site stays within `max_error` metres of its previous position,
/// at every whole tick and at every tick that had a key. Returns the largest distance in metres.
///
/// The scene must be in metres: see [`convert_units`](mocap_scene::Scene::convert_units). Afterwards every joint has
/// keys at its own ticks, and the values of the keys may differ from the values before. A joint's rotation compensates
/// for the errors of its ancestors, so that errors do not add up along a chain. Errors are measured in object space, as
/// in the Animation Compression Library. Between keys, positions are interpolated linearly and rotations by slerp. Both
/// frames of a cut keep their keys, because an interpolation across the cut would exceed the bound. A track that can be
/// constant within the bound gets one key.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::compress::reduce_keys;
/// use mocap::scene::UpAxis;
///
/// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// scene.convert_units(0.0254 / 0.45, UpAxis::Y);
/// let keys = |scene: &mocap::Scene| -> usize {
///     scene.animations[0].channels.iter().map(|channel| channel.rotation_keys.len()).sum()
/// };
/// let before = keys(&scene);
/// let error = reduce_keys(&mut scene, 0.001)?;
/// assert!(error <= 0.001 && keys(&scene) < before * 3 / 4);
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// - [`Code::Unrepresentable`](mocap_scene::Code::Unrepresentable): a node with children has an animated or non-uniform
///   scale, or a value is not finite.
/// - [`Code::ErrorBound`](mocap_scene::Code::ErrorBound): 32-bit floats cannot keep the bound.
///
/// After an error the scene is unchanged.
pub fn reduce_keys(scene: &mut Scene, max_error: impl Into<ErrorBound>) -> Result<f64> {
    let bound = max_error.into();
    let mut all = Vec::with_capacity(scene.animations.len());
    for animation in &scene.animations {
        let clip = compress(scene, animation, &bound, &Float32)?;
        let driven: Vec<_> = Binding::new(scene, animation).driven().collect();
        all.push((clip, driven));
    }
    let mut largest = 0.0;
    for (animation, (clip, driven)) in std::iter::zip(&mut scene.animations, all) {
        largest = f64::max(largest, clip.error.max);
        let ticks_of = |key_frames: &[u32]| key_frames.iter().map(|frame| clip.ticks[*frame as usize]).collect();
        for (node, channel) in driven {
            let (track, channel) = (&clip.tracks[node.index()], &mut animation.channels[channel]);
            if !channel.position_keys.is_empty() {
                channel.position_keys = match &track.translation {
                    Track::Constant(value) => Keys::constant(*value),
                    Track::Animated { key_frames, keys, .. } => {
                        Keys::at_ticks(keys.iter().map(|key| key.value).collect(), ticks_of(key_frames))
                    }
                };
            }
            if !channel.rotation_keys.is_empty() {
                channel.rotation_keys = match &track.rotation {
                    Track::Constant(value) => Keys::constant(*value),
                    Track::Animated { key_frames, keys, .. } => {
                        Keys::at_ticks(keys.iter().map(|key| key.value).collect(), ticks_of(key_frames))
                    }
                };
            }
        }
    }
    Ok(largest)
}
