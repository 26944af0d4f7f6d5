//! Points without a skeleton, such as markers. A point has position keys in exactly the frames in which it was seen.

use glam::Vec3;

use crate::scene::{Animation, Format, Keys, NodeId, NodeKind, Scene};

/// The largest difference in ticks between a time and a frame that count as equal.
const SAME_TICK: f64 = 1e-6;

impl Scene {
    /// Whether all nodes are points, so that a frame without a position key is a gap.
    #[doc(hidden)]
    pub fn has_points(&self) -> bool {
        let is_read_as_points = matches!(
            self.metadata.format,
            Some(
                Format::C3d
                    | Format::Trc
                    | Format::Csv
                    | Format::Npy
                    | Format::Npz
                    | Format::Torch
                    | Format::Pickle
                    | Format::Parquet
            )
        );
        let mut nodes = self.nodes.iter();
        is_read_as_points
            && nodes.next().is_some_and(|first| first.kind == NodeKind::Group)
            && nodes.all(|node| node.parent == Some(NodeId(0)) && node.face.is_none())
    }

    /// The position keys of each node in a scene of points; `None` for nodes without gaps.
    #[doc(hidden)]
    pub fn points_with_gaps<'s>(&self, animation: &'s Animation) -> Vec<Option<&'s Keys<Vec3>>> {
        let mut found = vec![None; self.nodes.len()];
        if self.has_points() {
            let frames = animation.frame_count();
            for channel in &animation.channels {
                let keys = &channel.position_keys;
                if let Some(node) = channel.node.filter(|_| !keys.is_seen_throughout(frames)) {
                    found[node.index()] = Some(keys);
                }
            }
        }
        found
    }
}

impl Keys<Vec3> {
    /// The positions of a point in the frames in which it was seen. The motion has `frames` frames.
    #[doc(hidden)]
    pub fn of_point(values: Vec<Vec3>, ticks: Vec<f64>, frames: usize) -> Self {
        match (ticks.as_slice(), frames) {
            // Without its tick, the single key would mean a point that is always seen and never moves.
            ([_], 2..) => Self {
                values,
                ticks: Some(ticks),
            },
            _ => Self::at_ticks(values, ticks),
        }
    }

    /// Whether a point is seen at a tick: in that frame, or in the frames on both sides. A point that never moves has
    /// one key without a tick.
    #[doc(hidden)]
    pub fn is_seen(&self, tick: f64) -> bool {
        let whole = tick.round();
        match (tick - whole).abs() <= SAME_TICK {
            true => self.has_frame(whole),
            false => self.has_frame(tick.floor()) && self.has_frame(tick.ceil()),
        }
    }

    /// Whether a point is seen in all frames.
    #[doc(hidden)]
    pub fn is_seen_throughout(&self, frames: usize) -> bool {
        self.len() >= frames || (self.len() == 1 && self.ticks.is_none())
    }

    fn has_frame(&self, frame: f64) -> bool {
        match (&self.ticks, self.len()) {
            (None, 1) => true,
            (None, count) => frame >= 0.0 && frame < count as f64,
            (Some(ticks), _) => {
                let after = ticks.partition_point(|tick| *tick < frame - SAME_TICK);
                ticks.get(after).is_some_and(|tick| *tick <= frame + SAME_TICK)
            }
        }
    }

    /// The positions of a point at other frames. Each frame is its new tick, and the old tick to sample.
    pub(super) fn of_point_at(&self, frames: &[(f64, f64)]) -> Self {
        if self.len() == 1 && self.ticks.is_none() {
            return self.clone();
        }
        let seen = frames.iter().filter(|(_, old)| self.is_seen(*old));
        let (ticks, values) = seen.filter_map(|(new, old)| Some((*new, self.sample(*old)?))).unzip();
        Self::of_point(values, ticks, frames.len())
    }
}
