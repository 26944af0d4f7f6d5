//! The packed clips that JavaScript holds, each with a number that is never reused.

use std::collections::BTreeMap;

use mocap::Trs;
use mocap::compress::PackedClip;
use serde::Serialize;

use crate::failure::Failure;

/// The number of values of a node in a pose: translation, rotation and scale.
const FLOATS: usize = 3 + 4 + 3;

/// A clip with the buffer of its pose.
struct Entry {
    clip: PackedClip<'static>,
    pose: Vec<Trs>,
    floats: Vec<[f32; FLOATS]>,
}

#[derive(Default)]
pub(crate) struct Clips {
    entries: BTreeMap<u32, Entry>,
    last: u32,
}

/// The description of a clip for JavaScript.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct ClipAt<'a> {
    clip: u32,
    nodes: Vec<NodeAt<'a>>,
    ticks_per_second: f64,
    duration: f64,
    frame_count: usize,
    max_error: f64,
    bytes: usize,
    /// The address where [`Clips::sample`] writes the pose.
    pose: usize,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct NodeAt<'a> {
    name: &'a str,
    parent: Option<usize>,
    is_end_site: bool,
}

impl Clips {
    /// Opens a clip.
    pub(crate) fn open(&mut self, bytes: &[u8]) -> Result<ClipAt<'_>, Failure> {
        let clip = PackedClip::new(bytes.to_vec())?;
        let nodes = clip.node_count();
        let next = self.last.checked_add(1);
        self.last = next.ok_or_else(|| Failure::argument("there were 2^32 clips; load the module again"))?;
        let Entry { clip, floats, .. } = self.entries.entry(self.last).or_insert(Entry {
            clip,
            pose: vec![Trs::IDENTITY; nodes],
            floats: vec![[0.0; FLOATS]; nodes],
        });
        let node = |node: usize| NodeAt {
            name: clip.name(node),
            parent: clip.parent(node),
            is_end_site: clip.is_end_site(node),
        };
        Ok(ClipAt {
            clip: self.last,
            nodes: (0..nodes).map(node).collect(),
            ticks_per_second: clip.ticks_per_second(),
            duration: clip.duration(),
            frame_count: clip.frame_count(),
            max_error: clip.max_error(),
            bytes: clip.bytes().len(),
            pose: floats.as_ptr().addr(),
        })
    }

    /// Computes the pose of a clip. Returns whether the clip exists.
    pub(crate) fn sample(&mut self, number: u32, tick: f64) -> bool {
        let Some(Entry { clip, pose, floats }) = self.entries.get_mut(&number) else {
            return false;
        };
        clip.sample(tick, pose);
        for (floats, trs) in std::iter::zip(floats, pose) {
            let Trs {
                translation,
                rotation,
                scale,
            } = trs;
            floats[..3].copy_from_slice(&translation.to_array());
            floats[3..7].copy_from_slice(&rotation.to_array());
            floats[7..].copy_from_slice(&scale.to_array());
        }
        true
    }

    pub(crate) fn free(&mut self, number: u32) {
        self.entries.remove(&number);
    }
}
