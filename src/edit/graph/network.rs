//! Combines a graph with its clips, so that walks can be searched.

use std::sync::OnceLock;

use mocap_scene::error::{Code, Diagnostic, Result};

use super::clouds::{CloudSpace, Clouds};
use super::distance::{Alignment, Window};
use super::{GraphClip, GraphTransition, MotionGraph};

/// A graph and its clips, in which walks are searched.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Debug)]
pub struct Network<'a> {
    pub(super) space: &'a CloudSpace,
    pub(super) window: &'a Window,
    pub(super) clouds: &'a [Clouds],
    pub(super) clips: Vec<GraphClip>,
    pub(super) rate: f64,
    pub(super) threshold: f64,
    /// The transitions of the largest component, in the order of the frames at which they leave a clip.
    exits: Vec<GraphTransition>,
    /// The alignment of each transition, computed when a walk first needs it.
    alignments: Vec<OnceLock<Alignment>>,
    pub(super) hastes: Hastes,
}

/// The speeds of joints, computed when a walk first needs them.
#[derive(Clone, Debug)]
pub(super) struct Hastes {
    /// The speed above which a joint counts as fast, in metres per frame.
    pub(super) fast: OnceLock<f64>,
    /// For each transition, the fraction of its joint speeds that are fast.
    pub(super) of_exits: Vec<OnceLock<f64>>,
}

impl<'a> Network<'a> {
    pub(super) fn new(
        space: &'a CloudSpace,
        window: &'a Window,
        (own, clouds): (&[GraphClip], &'a [Clouds]),
        graph: &MotionGraph,
    ) -> Result<Self> {
        let refuse = |message: String| Err(Diagnostic::new(Code::InvalidGraph, message).into());
        let stated = &graph.clips;
        if own.len() != stated.len() {
            return refuse(format!(
                "the graph has {} clips, but its files have {}",
                stated.len(),
                own.len()
            ));
        }
        for (own, stated) in own.iter().zip(stated) {
            let [now, then] = [own, stated].map(|clip| [clip.animation, clip.frames]);
            if now != then {
                return refuse(format!(
                    "in the graph, {} has animation {} of {} frames; in its file, animation {} of {}",
                    stated.file, then[0], then[1], now[0], now[1]
                ));
            }
        }
        let is_inside = |[clip, frame]: [usize; 2]| {
            let part = graph.clips.get(clip).and_then(|clip| clip.part);
            part.is_some_and(|part| (part[0]..=part[1]).contains(&frame))
        };
        let inside = |transition: &&GraphTransition| is_inside(transition.from) && is_inside(transition.to);
        let mut exits: Vec<GraphTransition> = graph.transitions.iter().filter(inside).copied().collect();
        exits.sort_by_key(|exit| (exit.from, exit.to));
        if exits.is_empty() {
            return refuse("no transition of the graph lies within the kept parts of the clips".to_owned());
        }
        Ok(Self {
            space,
            window,
            clouds,
            clips: graph.clips.clone(),
            rate: graph.options.rate,
            threshold: graph.options.threshold,
            alignments: vec![OnceLock::new(); exits.len()],
            hastes: Hastes {
                fast: OnceLock::new(),
                of_exits: vec![OnceLock::new(); exits.len()],
            },
            exits,
        })
    }

    /// All transitions.
    pub(super) fn exits(&self) -> &[GraphTransition] {
        &self.exits
    }

    /// The transitions that leave a clip at frames from `first` to `last`.
    pub(super) fn exits_within(&self, clip: usize, first: usize, last: usize) -> &[GraphTransition] {
        let start = self.exits.partition_point(|exit| exit.from < [clip, first]);
        let end = self.exits.partition_point(|exit| exit.from <= [clip, last]);
        &self.exits[start..end.max(start)]
    }

    /// The rigid motion over the ground that aligns the clip that a transition enters with the clip that it leaves.
    pub(super) fn alignment(&self, exit: &GraphTransition) -> Alignment {
        match self.index_of(exit) {
            Some(index) => *self.alignments[index].get_or_init(|| self.align(exit)),
            None => self.align(exit),
        }
    }

    /// The index of a transition.
    pub(super) fn index_of(&self, exit: &GraphTransition) -> Option<usize> {
        let key = |exit: &GraphTransition| (exit.from, exit.to);
        self.exits.binary_search_by_key(&key(exit), key).ok()
    }

    fn align(&self, exit: &GraphTransition) -> Alignment {
        let start = exit.to[1] + 1 - self.window.frames();
        let clouds = |clip: usize| &self.clouds[clip];
        self.window.align(
            self.space,
            (clouds(exit.from[0]), exit.from[1]),
            (clouds(exit.to[0]), start),
        )
    }

    /// The first clip with frames in the largest component, and the first and the last of these frames.
    pub(super) fn first_part(&self) -> Result<(usize, [usize; 2])> {
        let mut parts = self.clips.iter().enumerate();
        let found = parts.find_map(|(index, clip)| Some((index, clip.part?)));
        found.ok_or_else(|| Diagnostic::new(Code::InvalidGraph, "no clip has a part in the graph").into())
    }

    /// The error for a file in which a walk comes to a dead end. mocap writes no such file.
    pub(super) fn dead_end(&self, clip: usize, frame: usize) -> mocap_scene::error::Error {
        let file = &self.clips[clip].file;
        let message = format!("no transition of the graph leaves {file} after frame {frame}");
        Diagnostic::new(Code::InvalidGraph, message).into()
    }
}
