//! Tracks the pose through every frame. Each fit starts from the pose of the frame before. Finds swapped markers and
//! ghost markers.

use glam::{DQuat, DVec3};

use super::calibrate::Frame;
use super::fit::{Fit, Toward};
use super::gaps::{Gaps, runs as intervals};
use super::model::{Joint, Model, Pose, World};
use super::take::Track;

/// Two markers that had each other's labels, with the first and the last frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LabelSwap {
    pub(super) markers: (usize, usize),
    pub(super) first: usize,
    pub(super) last: usize,
}

/// The result of tracking a take.
#[derive(Debug, Default)]
pub(super) struct TrackingOutcome {
    /// Rotations relative to the world, indexed by joint, then frame.
    pub(super) rotations: Vec<Vec<DQuat>>,
    pub(super) roots: Vec<DVec3>,
    /// Distances in metres of markers from the body's markers, indexed by marker, then frame; `None` if not seen.
    pub(super) distances: Vec<Vec<Option<f64>>>,
    pub(super) swaps: Vec<LabelSwap>,
    /// For each marker, the number of frames in which it is far from its body.
    pub(super) ghosts: Vec<usize>,
    /// For each joint, the first and the last frame of each interval in which markers do not determine its rotation.
    pub(super) loose: Vec<Vec<(usize, usize)>>,
}

/// Tracks the body from `start`, a frame with its pose, to both ends of the take. Poses follow the second tracks, which
/// are steady. Distances are of the first. `rate` is in frames per second.
pub(super) fn track(
    model: &Model,
    (tracks, steady): (&[Track], &[Track]),
    start: (usize, &Pose),
    rate: f64,
) -> TrackingOutcome {
    let frames = tracks.first().map_or(0, Vec::len);
    let mut tracked = TrackingOutcome {
        rotations: vec![vec![DQuat::IDENTITY; frames]; model.joints.len()],
        roots: vec![DVec3::ZERO; frames],
        distances: vec![vec![None; frames]; tracks.len()],
        swaps: Vec::new(),
        ghosts: vec![0; tracks.len()],
        loose: Vec::new(),
    };
    let mut tracker = Tracker::new(model, (tracks, steady));
    let mut gaps = Gaps::new(model, start.1, frames);
    tracker.follow(
        start,
        |_| true,
        |tracker, frame, pose| {
            let distances = tracked.note(tracker, frame, pose);
            gaps.note((model, &mut tracker.fit), pose, (frame, &distances));
        },
    );
    gaps.move_root(&mut tracked.roots, rate);
    for (frame, toward) in gaps.between(model, &tracked.rotations, rate).iter().enumerate() {
        if !toward.is_empty() {
            let pose = tracker.again(frame, toward, &tracked);
            tracked.note(&tracker, frame, &pose);
        }
    }
    tracked.loose = gaps.loose.iter().map(|loose| intervals(loose)).collect();
    let is_ghost = |distance: &&f64| **distance > model.weights.ghost;
    tracked.ghosts = (tracked.distances.iter())
        .map(|distances| distances.iter().flatten().filter(is_ghost).count())
        .collect();
    tracked.swaps = runs(tracker.swapped);
    tracked
}

/// The poses of some frames. Every `step`th frame between them is solved on the way.
pub(super) fn poses(
    model: &Model,
    tracks: &[Track],
    start: (usize, &Pose),
    (wanted, step): (&[usize], usize),
) -> Vec<Frame> {
    let mut found: Vec<Option<Frame>> = wanted.iter().map(|_| None).collect();
    let is_on_way = |frame: usize| frame.abs_diff(start.0).is_multiple_of(step) || wanted.contains(&frame);
    Tracker::new(model, (tracks, tracks)).follow(start, is_on_way, |tracker, frame, pose| {
        if let Some(index) = wanted.iter().position(|wanted| *wanted == frame) {
            found[index] = Some(Frame {
                pose: pose.clone(),
                seen: tracker.near(),
            });
        }
    });
    found.into_iter().flatten().collect()
}

impl TrackingOutcome {
    /// Notes the pose of a frame, and returns the distances of markers from it.
    fn note(&mut self, tracker: &Tracker<'_>, frame: usize, pose: &Pose) -> Vec<Option<f64>> {
        let distances = tracker.fit.distances(tracker.model, &tracker.measured);
        for (own, distance) in std::iter::zip(&mut self.distances, &distances) {
            own[frame] = *distance;
        }
        self.roots[frame] = pose.root;
        for (joint, rotation) in tracker.fit.world.rotations.iter().enumerate() {
            self.rotations[joint][frame] = *rotation;
        }
        distances
    }
}

struct Tracker<'t> {
    model: &'t Model,
    tracks: &'t [Track],
    steady: &'t [Track],
    fit: Fit,
    /// The steady positions of a frame.
    seen: Vec<Option<DVec3>>,
    measured: Vec<Option<DVec3>>,
    /// Frames with a swapped pair.
    swapped: Vec<(usize, (usize, usize))>,
}

impl<'t> Tracker<'t> {
    fn new(model: &'t Model, (tracks, steady): (&'t [Track], &'t [Track])) -> Self {
        Self {
            model,
            tracks,
            steady,
            fit: Fit::default(),
            seen: Vec::new(),
            measured: Vec::new(),
            swapped: Vec::new(),
        }
    }

    /// Solves from `start` to the last frame and then to the first, but only frames for which `is_on_way` holds. Calls
    /// `tell` for each solved frame.
    fn follow(
        &mut self,
        start: (usize, &Pose),
        is_on_way: impl Fn(usize) -> bool,
        mut tell: impl FnMut(&mut Self, usize, &Pose),
    ) {
        let frames = self.tracks.first().map_or(0, Vec::len);
        let both: [&mut dyn Iterator<Item = usize>; 2] = [&mut (start.0..frames), &mut (0..start.0).rev()];
        for frames in both {
            let mut pose = start.1.clone();
            for frame in frames.filter(|frame| is_on_way(*frame)) {
                self.frame(frame, &mut pose);
                tell(self, frame, &pose);
            }
        }
    }

    fn look(&mut self, frame: usize) {
        for (seen, tracks) in [(&mut self.seen, self.steady), (&mut self.measured, self.tracks)] {
            seen.clear();
            seen.extend(tracks.iter().map(|track| track[frame]));
        }
    }

    fn exchange(&mut self, pairs: &[(usize, usize)]) {
        for &(a, b) in pairs {
            self.seen.swap(a, b);
            self.measured.swap(a, b);
        }
    }

    fn frame(&mut self, frame: usize, pose: &mut Pose) {
        self.look(frame);
        self.model.world(pose, &mut self.fit.world);
        let before = swaps(self.model, &self.fit.world, &self.seen);
        self.exchange(&before);
        self.fit.fit(self.model, pose, &self.seen);
        let after = swaps(self.model, &self.fit.world, &self.seen);
        self.exchange(&after);
        if !after.is_empty() {
            self.fit.fit(self.model, pose, &self.seen);
        }
        // A pair that was swapped twice is not swapped.
        let once = before
            .iter()
            .filter(|pair| !after.contains(pair))
            .chain(after.iter().filter(|pair| !before.contains(pair)));
        self.swapped.extend(once.map(|pair| (frame, *pair)));
    }

    /// The markers of this frame that are near their positions on the body.
    fn near(&self) -> Vec<Option<DVec3>> {
        let distances = self.fit.distances(self.model, &self.seen);
        let is_near = |distance: Option<f64>| distance.is_some_and(|distance| distance < self.model.weights.outlier);
        std::iter::zip(&self.seen, distances)
            .map(|(seen, distance)| seen.filter(|_| is_near(distance)))
            .collect()
    }

    /// Solves the pose of a frame again, with the predictions of other frames.
    fn again(&mut self, frame: usize, toward: &Toward, tracked: &TrackingOutcome) -> Pose {
        self.look(frame);
        let swapped = self.swapped.iter().filter(|(swapped, _)| *swapped == frame);
        let swapped: Vec<(usize, usize)> = swapped.map(|(_, pair)| *pair).collect();
        self.exchange(&swapped);
        let world = |joint: usize| tracked.rotations[joint][frame];
        let local = |(joint, own): (usize, &Joint)| match own.parent {
            None => world(joint),
            Some(parent) => (world(parent).inverse() * world(joint)).normalize(),
        };
        let mut pose = Pose {
            root: tracked.roots[frame],
            local: self.model.joints.iter().enumerate().map(local).collect(),
        };
        for &(joint, rotation, _) in toward {
            pose.local[joint] = rotation;
        }
        self.fit.fit_toward(self.model, &mut pose, &self.seen, toward);
        pose
    }
}

/// Pairs of markers that are nearer to their positions on the body with exchanged labels.
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

/// Consecutive frames with the same swap are one swap.
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
