//! The motion of a node's morph targets: their weights in every animation of a file.

use std::collections::BTreeMap;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::{Keys, MorphCurves};

use super::face::{morph_targets, names_of_targets};
use super::file::File;
use super::json::{self, Channel};
use super::tracks::{Bend, ChannelKeys, Keys as SamplerKeys};
use crate::Failure;

impl File<'_> {
    /// The curves of all nodes with animated morph targets, with keys in seconds. Invalid curves are skipped, with a
    /// warning for each node.
    pub(super) fn all_weights(
        &self,
        bytes: &[u8],
        warnings: &mut Vec<Diagnostic>,
    ) -> Result<Vec<MorphCurves>, Failure> {
        let mut moved: BTreeMap<usize, Vec<(usize, &Channel)>> = BTreeMap::new();
        for (index, animation) in self.animations().enumerate() {
            for channel in animation.channels.iter().filter(|channel| moves_weights(channel)) {
                let channels = moved.entry(channel.target.node.unwrap_or_default()).or_default();
                channels.push((index, channel));
            }
        }
        if moved.is_empty() {
            return Ok(Vec::new());
        }
        let root = serde_json::from_slice(json::split(bytes)?.0).unwrap_or_default();
        let targets = morph_targets(&root);
        let mut found = Vec::new();
        for (node, channels) in moved {
            // The target mesh is missing. By the specification, the channel is ignored.
            let Some(at_rest) = targets.get(&node) else { continue };
            match self.curves(&channels, at_rest.len()) {
                Ok(targets) => found.push(MorphCurves {
                    node,
                    names: names_of_targets(&root, node)
                        .map(|name| name.as_str().unwrap_or_default().to_owned())
                        .collect(),
                    at_rest: at_rest.clone(),
                    targets,
                }),
                Err(mut wrong) if wrong.code != Code::LimitExceeded => {
                    wrong.message = format!("morph target curves were dropped: {}", wrong.message);
                    warnings.push(*wrong);
                }
                Err(limit) => return Err(limit),
            }
        }
        Ok(found)
    }

    /// The weights of each of `count` morph targets of a node in every animation. An animation in which the weight
    /// stays at rest has no keys. Keys are in seconds.
    ///
    /// # Errors
    /// A key is not valid.
    pub(super) fn weights(&self, node: usize, count: usize) -> Result<Vec<Vec<Keys<f32>>>, Failure> {
        let moves = |channel: &&Channel| moves_weights(channel) && channel.target.node == Some(node);
        let channels = self.animations().enumerate();
        let channels: Vec<(usize, &Channel)> = channels
            .filter_map(|(index, animation)| Some((index, animation.channels.iter().find(moves)?)))
            .collect();
        self.curves(&channels, count)
    }

    /// The weights that the channels state. Each channel comes with the index of its animation.
    fn curves(&self, channels: &[(usize, &Channel)], count: usize) -> Result<Vec<Vec<Keys<f32>>>, Failure> {
        let animations = self.animations().len();
        self.bytes.budget.take((count * animations) as u64, "/animations")?;
        let mut targets = vec![vec![Keys::default(); animations]; count];
        for (index, channel) in channels {
            let ChannelKeys { keys, bend, output } = self.sampled(*index, channel, 1, count)?;
            for (target, animations) in targets.iter_mut().enumerate() {
                let own = keys
                    .of_column(target, bend)
                    .straight(bend, &self.bytes.budget, &output)?;
                let seconds = own.times.iter().map(|time| f64::from(*time)).collect();
                animations[*index] = Keys::at_ticks(own.values, seconds);
            }
        }
        Ok(targets)
    }
}

fn moves_weights(channel: &Channel) -> bool {
    channel.target.path == "weights" && channel.target.node.is_some()
}

impl SamplerKeys {
    /// The numbers of one column, one per key. If the keys are curve keys, also the numbers of their tangents.
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
