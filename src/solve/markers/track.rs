//! The pose of every frame, each from the one before; markers that were taken for each other, and those that are none.

use glam::{DQuat, DVec3};

use super::fit::Fit;
use super::model::{Model, Pose, World};

/// Two markers that had each other's labels, with the first frame and the last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LabelSwap {
    pub(super) markers: (usize, usize),
    pub(super) first: usize,
    pub(super) last: usize,
}

/// What came of a take.
#[derive(Debug, Default)]
pub(super) struct TrackingOutcome {
    /// Joint, then frame: to the world.
    pub(super) rotations: Vec<Vec<DQuat>>,
    pub(super) roots: Vec<DVec3>,
    /// Marker, then frame: metres from where the body has it; none where it was not seen.
    pub(super) distances: Vec<Vec<Option<f64>>>,
    pub(super) swaps: Vec<LabelSwap>,
    /// Marker: frames in which it is far from its body.
    pub(super) ghosts: Vec<usize>,
}

/// Follows the body from `start`, a frame with its pose, to both ends of the take.
pub(super) fn track(model: &Model, tracks: &[Vec<Option<DVec3>>], start: (usize, &Pose)) -> TrackingOutcome {
    let frames = tracks.first().map_or(0, Vec::len);
    let mut tracked = TrackingOutcome {
        rotations: vec![vec![DQuat::IDENTITY; frames]; model.joints.len()],
        roots: vec![DVec3::ZERO; frames],
        distances: vec![vec![None; frames]; tracks.len()],
        swaps: Vec::new(),
        ghosts: vec![0; tracks.len()],
    };
    let mut tracker = Tracker {
        model,
        tracks,
        fit: Fit::default(),
        seen: Vec::new(),
        swapped: Vec::new(),
    };
    let mut pose = start.1.clone();
    for frame in start.0..frames {
        tracker.frame(frame, &mut pose, &mut tracked);
    }
    let mut pose = start.1.clone();
    for frame in (0..start.0).rev() {
        tracker.frame(frame, &mut pose, &mut tracked);
    }
    tracked.swaps = runs(tracker.swapped);
    tracked
}

struct Tracker<'t> {
    model: &'t Model,
    tracks: &'t [Vec<Option<DVec3>>],
    fit: Fit,
    seen: Vec<Option<DVec3>>,
    /// Frames and pairs.
    swapped: Vec<(usize, (usize, usize))>,
}

impl Tracker<'_> {
    fn frame(&mut self, frame: usize, pose: &mut Pose, tracked: &mut TrackingOutcome) {
        self.seen.clear();
        self.seen.extend(self.tracks.iter().map(|track| track[frame]));
        self.model.world(pose, &mut self.fit.world);
        let before = swaps(self.model, &self.fit.world, &self.seen);
        for &(a, b) in &before {
            self.seen.swap(a, b);
        }
        self.fit.fit(self.model, pose, &self.seen);
        let after = swaps(self.model, &self.fit.world, &self.seen);
        for &(a, b) in &after {
            self.seen.swap(a, b);
        }
        if !after.is_empty() {
            self.fit.fit(self.model, pose, &self.seen);
        }
        // What was swapped twice was not swapped.
        let once = before
            .iter()
            .filter(|pair| !after.contains(pair))
            .chain(after.iter().filter(|pair| !before.contains(pair)));
        self.swapped.extend(once.map(|pair| (frame, *pair)));
        let distances = self.fit.distances(self.model, &self.seen);
        for (marker, distance) in distances.into_iter().enumerate() {
            tracked.ghosts[marker] += usize::from(distance.is_some_and(|distance| distance > self.model.weights.ghost));
            tracked.distances[marker][frame] = distance;
        }
        tracked.roots[frame] = pose.root;
        for (joint, rotation) in self.fit.world.rotations.iter().enumerate() {
            tracked.rotations[joint][frame] = *rotation;
        }
    }
}

/// Pairs of markers that are nearer to where the body has them with the labels exchanged.
fn swaps(model: &Model, world: &World, seen: &[Option<DVec3>]) -> Vec<(usize, usize)> {
    let expected: Vec<DVec3> = (0..seen.len()).map(|marker| model.marker(marker, world)).collect();
    let far = |marker: usize| seen[marker].filter(|seen| seen.distance(expected[marker]) > model.weights.swapped);
    let far: Vec<(usize, DVec3)> = (0..seen.len())
        .filter_map(|marker| Some((marker, far(marker)?)))
        .collect();
    let mut found: Vec<(usize, usize)> = Vec::new();
    for (index, &(a, at_a)) in far.iter().enumerate() {
        for &(b, at_b) in &far[index + 1..] {
            let own = at_a.distance(expected[a]).max(at_b.distance(expected[b]));
            let other = at_a.distance(expected[b]).max(at_b.distance(expected[a]));
            let is_taken = found
                .iter()
                .any(|pair| [pair.0, pair.1].iter().any(|taken| *taken == a || *taken == b));
            if other < model.weights.swap * own && !is_taken {
                found.push((a, b));
            }
        }
    }
    found
}

/// Frames with a swap one after the other are one swap.
fn runs(mut swapped: Vec<(usize, (usize, usize))>) -> Vec<LabelSwap> {
    swapped.sort_by_key(|(frame, pair)| (*pair, *frame));
    let mut runs: Vec<LabelSwap> = Vec::new();
    for (frame, markers) in swapped {
        match runs.last_mut() {
            Some(run) if run.markers == markers && run.last + 1 == frame => run.last = frame,
            _ => runs.push(LabelSwap {
                markers,
                first: frame,
                last: frame,
            }),
        }
    }
    runs.sort_by_key(|run| run.first);
    runs
}
