//! Finds the cheapest walk through named clips, by Dijkstra's algorithm (1959).

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use mocap_scene::error::{Code, Diagnostic, Result};

use super::distance::Alignment;
use super::network::Network;
use super::walk::Walk;
use super::{GraphClip, GraphTransition};

/// The cost of a second of motion, as a multiple of the cost of a transition whose distance is the threshold. Because
/// of this cost, the shorter of two equally good walks wins.
const COST_OF_SECOND: f64 = 0.2;

/// The step by which the search reached a frame.
#[derive(Clone, Copy)]
enum Step {
    Start,
    /// From the frame with this index in the same clip.
    On(usize),
    /// By this transition.
    By(GraphTransition),
}

impl Network<'_> {
    /// Finds the cheapest walk that begins in the first clip of `clips` and passes through the other clips in order.
    /// Each entry is the index of a clip and an optional time in this clip, in seconds. Without a time, the walk begins
    /// at the start of the first clip's part and ends at the end of the last clip's part. Each clip between them is
    /// passed in the middle of its part. The part of a clip is the range of frames that belong to the graph. The cost
    /// of a transition is its distance.
    ///
    /// # Errors
    /// - [`Code::InvalidValue`] for fewer than two clips, a clip that the graph lacks, or a time outside the clip's
    ///   part of the graph
    /// - [`Code::InvalidGraph`] if there is no walk, which happens in no graph that mocap built
    pub fn through(&self, clips: &[(usize, Option<f64>)]) -> Result<Walk> {
        if clips.len() < 2 {
            let message = format!("a walk needs two clips or more to pass through, got {}", clips.len());
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        let mut moments = Vec::new();
        for (index, (clip, seconds)) in clips.iter().enumerate() {
            let part = self.part_of(*clip)?;
            let frame = match seconds {
                Some(seconds) => self.frame_at(*clip, part, *seconds)?,
                None if index == 0 => part[0],
                None if index + 1 == clips.len() => part[1],
                None => part[0].midpoint(part[1]),
            };
            moments.push([*clip, frame]);
        }
        let mut walk = Walk::begin(self, moments[0][0], moments[0][1], Alignment::NONE);
        for pair in moments.windows(2) {
            for exit in self.cheapest(pair[0], pair[1])? {
                walk.take(self, &exit);
            }
            walk.stay_until(pair[1][1]);
        }
        Ok(walk)
    }

    fn part_of(&self, clip: usize) -> Result<[usize; 2]> {
        let Some(GraphClip { file, part, .. }) = self.clips.get(clip) else {
            let message = format!("the graph has {} clips, and no clip {clip}", self.clips.len());
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        };
        part.ok_or_else(|| {
            let message = format!("{file} has no part in the graph: no transitions lead to it and back");
            Diagnostic::new(Code::InvalidValue, message).into()
        })
    }

    fn frame_at(&self, clip: usize, part: [usize; 2], seconds: f64) -> Result<usize> {
        let frame = (seconds * self.rate).round();
        if (part[0] as f64..=part[1] as f64).contains(&frame) {
            return Ok(frame as usize);
        }
        let [first, last] = part.map(|frame| frame as f64 / self.rate);
        let file = &self.clips[clip].file;
        let message = format!("{file} is in the graph from {first:.2} s to {last:.2} s, not at {seconds} s");
        Err(Diagnostic::new(Code::InvalidValue, message).into())
    }

    /// The transitions of the cheapest walk from the frame `from` to the frame `to`, each with its clip.
    fn cheapest(&self, from: [usize; 2], to: [usize; 2]) -> Result<Vec<GraphTransition>> {
        let mut points: BTreeMap<[usize; 2], (f64, Step)> = BTreeMap::new();
        let ends = self.exits().iter().flat_map(|exit| [exit.from, exit.to]);
        points.extend(
            ends.chain([from, to])
                .map(|point| (point, (f64::INFINITY, Step::Start))),
        );
        points.insert(from, (0.0, Step::Start));
        let mut open = BinaryHeap::from([(Reverse(Cost(0.0)), from)]);
        while let Some((Reverse(Cost(cost)), point)) = open.pop() {
            if point == to {
                return Ok(taken(&points, from, to));
            }
            if cost > points[&point].0 {
                continue;
            }
            let next = points.range([point[0], point[1] + 1]..).next().map(|(next, _)| *next);
            let on = next.filter(|next| next[0] == point[0]).map(|next| {
                let seconds = (next[1] - point[1]) as f64 / self.rate;
                (next, COST_OF_SECOND * seconds, Step::On(point[1]))
            });
            let by = self
                .exits_within(point[0], point[1], point[1])
                .iter()
                .map(|exit| (exit.to, self.cost(exit), Step::By(*exit)));
            for (next, more, step) in on.into_iter().chain(by) {
                if let Some(known) = points.get_mut(&next)
                    && cost + more < known.0
                {
                    *known = (cost + more, step);
                    open.push((Reverse(Cost(cost + more)), next));
                }
            }
        }
        Err(self.dead_end(from[0], from[1]))
    }
}

/// The transitions of the path that the search found.
fn taken(points: &BTreeMap<[usize; 2], (f64, Step)>, from: [usize; 2], to: [usize; 2]) -> Vec<GraphTransition> {
    let (mut exits, mut at) = (Vec::new(), to);
    while at != from {
        match points[&at].1 {
            Step::Start => break,
            Step::On(frame) => at[1] = frame,
            Step::By(exit) => {
                exits.push(exit);
                at = exit.from;
            }
        }
    }
    exits.reverse();
    exits
}

/// A cost, ordered for a heap.
#[derive(PartialEq)]
struct Cost(f64);

impl Eq for Cost {}

impl PartialOrd for Cost {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cost {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
