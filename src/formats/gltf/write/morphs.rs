//! Writes the animated weights of morph targets.

use gltf_json::Index;
use mocap_scene::scene::{Keys, MorphCurves, Original};

use super::super::Compression;
use super::super::face::MorphTrack;
use super::GltfReport;
use super::buffer::{Buffer, Usage};
use super::text::{Animation, Channel, Sampler, Target};

/// The morph target tracks of a file that is passed through, in an animation of its scene.
pub(super) fn tracks(original: &Original, animation: usize) -> Vec<MorphTrack> {
    let curves = original.morphs.iter();
    curves.filter_map(|curves| track(curves, animation)).collect()
}

/// The morph target track of a node in an animation; `None` if the weights stay at rest.
pub(super) fn track(curves: &MorphCurves, animation: usize) -> Option<MorphTrack> {
    let keys = |animations: &Vec<Keys<f32>>| animations.get(animation).cloned().unwrap_or_default();
    let targets: Vec<Keys<f32>> = curves.targets.iter().map(keys).collect();
    let mut ticks: Vec<f64> = targets
        .iter()
        .flat_map(|keys| (0..keys.len()).map(|key| keys.tick(key)))
        .collect();
    ticks.sort_unstable_by(f64::total_cmp);
    ticks.dedup();
    let now = |tick: &f64| {
        let targets = std::iter::zip(&targets, &curves.at_rest);
        targets
            .map(|(keys, at_rest)| keys.sample(*tick).unwrap_or(*at_rest))
            .collect()
    };
    (!ticks.is_empty()).then(|| MorphTrack {
        node: curves.node,
        weights: ticks.iter().map(now).collect(),
        ticks,
    })
}

/// Adds the morph target weights of one node to an animation.
pub(super) fn write(
    animation: &mut Animation,
    track: &MorphTrack,
    ticks_per_second: f64,
    buffer: &mut Buffer,
    report: &mut GltfReport,
) {
    let (mut times, mut weights): (Vec<[f32; 1]>, Vec<[f32; 1]>) = (Vec::new(), Vec::new());
    for (tick, now) in std::iter::zip(&track.ticks, &track.weights) {
        let time = (tick / ticks_per_second) as f32;
        if times.last().is_none_or(|last| time > last[0]) {
            times.push([time]);
            weights.extend(now.iter().map(|weight| [*weight]));
        }
    }
    report.animated_tracks += 1;
    report.dropped_keys += track.ticks.len() - times.len();
    animation.channels.push(Channel {
        sampler: animation.samplers.len(),
        target: Target {
            node: Index::new(track.node as u32),
            path: "weights",
        },
    });
    animation.samplers.push(Sampler {
        input: buffer.push_times(Compression::None, &times),
        output: buffer.push(Usage::Keys, &weights),
    });
}
