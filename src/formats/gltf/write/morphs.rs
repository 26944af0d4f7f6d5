//! Writes the animated weights of morph targets.

use gltf_json::Index;

use super::super::Compression;
use super::super::face::MorphTrack;
use super::GltfReport;
use super::buffer::{Buffer, Usage};
use super::text::{Animation, Channel, Sampler, Target};

/// Adds the weights of the morph targets of one node to an animation.
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
