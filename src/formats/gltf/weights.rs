//! The motion of the morph targets of a node: their weights in every animation of a file.

use mocap_scene::scene::Keys;

use super::file::File;
use super::json::{Animation, Channel};
use super::tracks::{Bend, ChannelKeys, Keys as SamplerKeys};
use crate::Failure;

impl File<'_> {
    /// Of each of `count` morph targets of a node its weight in every animation, without keys where it stays at rest.
    /// Keys are at seconds.
    ///
    /// # Errors
    /// Where a key is not valid.
    pub(super) fn weights(&self, node: usize, count: usize) -> Result<Vec<Vec<Keys<f32>>>, Failure> {
        let animations: Vec<&Animation> = self.animations().collect();
        let mut targets = vec![vec![Keys::default(); animations.len()]; count];
        for (index, animation) in animations.iter().enumerate() {
            let moves = |channel: &&Channel| channel.target.path == "weights" && channel.target.node == Some(node);
            let Some(channel) = animation.channels.iter().find(moves) else {
                continue;
            };
            let ChannelKeys { keys, bend, output } = self.sampled(index, channel, 1, count)?;
            for (target, animations) in targets.iter_mut().enumerate() {
                let own = keys
                    .of_column(target, bend)
                    .straight(bend, &self.bytes.budget, &output)?;
                let seconds = own.times.iter().map(|time| f64::from(*time)).collect();
                animations[index] = Keys::at_ticks(own.values, seconds);
            }
        }
        Ok(targets)
    }
}

impl SamplerKeys {
    /// One of the numbers of each key; of a curve with its tangents.
    fn of_column(&self, column: usize, bend: Option<Bend>) -> Self {
        let parts = if bend == Some(Bend::Curve) { 3 } else { 1 };
        let parts = self.values.chunks_exact(self.columns).take(parts * self.times.len());
        Self {
            times: self.times.clone(),
            values: parts.map(|part| part[column]).collect(),
            columns: 1,
        }
    }
}
