//! Finds a walk along a path over the ground, by a beam search.
//!
//! The speed of the figure is free. The progress of a walk is the distance along the path to the point that is nearest
//! to the figure. The cost of a walk is the sum of the squared distances from the path, frame by frame, plus a small
//! cost for each frame and each transition. Walks are compared at equal progress. Of all walks in the same frame of a
//! clip and at the same position, only the cheapest continues. Of the remaining walks, only the [`BEAM`] cheapest
//! continue. The first half of the best walk over some metres is kept, and the search continues from its end. Branch
//! and bound, as in section 5 of the paper, also finds the best walk. For very similar clips, branch and bound examines
//! too many walks.

use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap};

use glam::{DVec2, DVec3};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::math::polyline::Polyline;

use super::GraphTransition;
use super::distance::Alignment;
use super::network::Network;
use super::walk::Walk;

/// The length of path that is searched ahead, in metres. It is the length of several footsteps, so that it contains
/// transitions.
const AHEAD: f64 = 6.0;

/// The length of path for which the best walk is kept, in metres. It is half of `AHEAD`, so that the search sees beyond
/// the kept length.
const KEPT: f64 = 3.0;

/// The length of path between two comparisons of walks, in metres. It is about a twentieth of a footstep.
const STRETCH: f64 = 0.05;

/// The number of walks that continue after a comparison. The search time grows with it.
const BEAM: usize = 400;

/// The distance within which two walks in one frame of a clip count as equal, in metres. A difference of this size is
/// not visible.
const SAME_PLACE: f64 = 0.03;

/// The angle within which two walks count as equal, in radians. It is 3 degrees, which is 0.3 m after 6 m of path.
const SAME_TURN: f64 = 0.05;

/// The number of frames per second of a clip at which a walk can begin. A footstep takes half a second.
const STARTS: f64 = 3.0;

/// The largest number of beginnings. Each beginning costs as much time as a walk of the beam.
const MOST_STARTS: usize = 2000;

/// The cost of a transition whose distance is the threshold, in m^2. A second of motion at 3 cm from the path costs as
/// much.
const COST_OF_TRANSITION: f64 = 0.03;

/// The cost of each frame, in m^2, so that no figure stands still without need. A frame at 2 cm from the path costs as
/// much.
const COST_OF_FRAME: f64 = 4e-4;

/// The largest distance of a walk from the path, in metres. A walk farther away does not follow it.
const FARTHEST: f64 = 2.0;

/// The distance along the path that is searched for the nearest point, from frame to frame, in metres.
pub(super) const LOOKED_AT: f64 = 0.5;

/// The longest path, in metres. A search along a longer path would take more than a day.
const LONGEST: f64 = 1e4;

/// The lowest speed of a walk along a path, in m/s. A slower figure counts as standing.
const SLOWEST: f64 = 0.1;

/// A partial walk: the frame of the clip, the transform of the figure, the progress along the path, and the cost.
#[derive(Clone, Copy)]
struct State {
    clip: usize,
    frame: usize,
    placement: Alignment,
    along: f64,
    cost: f64,
    frames: usize,
    /// The index of the beginning of this walk, and the index of its last transition.
    start: usize,
    taken: Option<usize>,
    /// The number of frames after which the walk reached the end of the stretch. `None` if it has not reached the end.
    ended: Option<usize>,
}

/// A transition of a walk, and the index of the transition before it.
struct PathStep {
    before: Option<usize>,
    exit: GraphTransition,
}

/// A search over a stretch of the path.
struct Search<'a> {
    network: &'a Network<'a>,
    path: &'a Polyline,
    /// The beginning and end of the stretch, as distances along the path.
    begin: f64,
    end: f64,
    /// The largest number of frames in a walk.
    most: usize,
    taken: Vec<PathStep>,
    /// The walks that can continue, grouped by progress.
    open: Vec<BinaryHeap<OpenWalk>>,
    /// The number of walks that were added to `open`, and the farthest progress of a walk.
    pushed: usize,
    reached: f64,
    best: Option<State>,
}

/// A walk that can continue. The cheapest walk comes first. Of equally cheap walks, the walk that was found first comes
/// first.
struct OpenWalk {
    state: State,
    number: usize,
}

impl Ord for OpenWalk {
    fn cmp(&self, other: &Self) -> Ordering {
        let costs = other.state.cost.total_cmp(&self.state.cost);
        costs.then(other.number.cmp(&self.number))
    }
}

impl PartialOrd for OpenWalk {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Eq for OpenWalk {}

impl PartialEq for OpenWalk {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Network<'_> {
    /// Finds a walk along a path over the ground. The path is a line through points, which are given in metres along
    /// the two axes of the ground. These axes are x and z if +Y is up, and x and y if +Z is up. The walk begins at the
    /// first point and ends at the last.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for fewer than two points, for equal successive points, for numbers that are not finite,
    /// and for a path that no walk can follow.
    pub fn along(&self, points: &[[f64; 2]]) -> Result<Walk> {
        let path = line(points.iter().map(|point| self.over_ground(*point)).collect())?;
        let mut starts = self.starts(&path);
        let mut walk: Option<Walk> = None;
        loop {
            let mut search = Search::new(self, &path, &starts[0]);
            let Some(best) = search.from(&starts) else {
                return Err(search.stopped());
            };
            let mut state = starts[best.start];
            let walk = walk.get_or_insert_with(|| Walk::begin(self, state.clip, state.frame, state.placement));
            let is_last = search.end >= path.length();
            let begun = state.along;
            for exit in search.transitions(&best) {
                state = self.stay(&search, &state, exit.from[1]);
                state = self.pass(&search, &state, &exit);
                walk.take(self, &exit);
                if !is_last && state.along - begun >= KEPT {
                    break;
                }
            }
            if is_last {
                walk.stay_until(best.frame);
                walk.length = best.ended.unwrap_or(best.frames) as f64 / self.rate;
                self.bring_onto(walk, &path);
                return Ok(walk.clone());
            }
            // Without a transition, the walk stays in its clip.
            state = if state.frames > starts[best.start].frames {
                state
            } else {
                best
            };
            walk.stay_until(state.frame);
            (state.cost, state.start, state.taken, state.ended) = (0.0, 0, None, None);
            starts = vec![state];
        }
    }

    /// Transforms a point from the axes of the ground in the world to the axes of the point clouds.
    fn over_ground(&self, [first, second]: [f64; 2]) -> DVec2 {
        let upright = self.space.up.abs().max_position();
        let mut axes = DVec3::AXES.into_iter().enumerate().filter(|(axis, _)| *axis != upright);
        let mut next = |value: f64| axes.next().map_or(DVec3::ZERO, |(_, axis)| value * axis);
        let point = next(first) + next(second);
        DVec2::from(self.space.ground.map(|axis| axis.as_dvec3().dot(point)))
    }

    /// The possible beginnings of a walk. Each walk is moved to the beginning of the path, and turned along the path.
    fn starts(&self, path: &Polyline) -> Vec<State> {
        let step = (self.rate / STARTS).ceil() as usize;
        let second = self.rate.ceil() as usize;
        let begin = path.at(0.0);
        let parts = self.clips.iter().enumerate();
        let parts = parts.filter_map(|(clip, graph_clip)| Some((clip, graph_clip.part?)));
        let frames =
            parts.flat_map(|(clip, [first, last])| (first..last).step_by(step).map(move |at| (clip, at, last)));
        let frames: Vec<_> = frames.collect();
        let every = frames.len().div_ceil(MOST_STARTS).max(1);
        let start = |(start, (clip, frame, last)): (usize, &(usize, usize, usize))| {
            let centre = |frame: usize| self.clouds[*clip].centres[frame];
            let (from, to) = (centre(*frame), centre((*last).min(frame + second)));
            let length = to.distance(from);
            let turn = match length > 0.1 {
                true => (to - from).angle_to(path.at(length) - begin),
                false => 0.0,
            };
            State {
                clip: *clip,
                frame: *frame,
                placement: Alignment {
                    turn,
                    offset: begin - DVec2::from_angle(turn).rotate(from),
                    distance: 0.0,
                },
                along: 0.0,
                cost: 0.0,
                frames: 0,
                start,
                taken: None,
                ended: None,
            }
        };
        frames.iter().step_by(every).enumerate().map(start).collect()
    }

    fn at(&self, state: &State) -> DVec2 {
        state.placement.apply(self.clouds[state.clip].centres[state.frame])
    }

    /// Advances a walk to a frame of its clip.
    fn on(&self, search: &Search<'_>, state: &mut State, frame: usize) {
        state.frame = frame;
        state.frames += 1;
        if state.ended.is_some() {
            return;
        }
        let at = self.at(state);
        state.along = search.path.nearest(at, state.along, LOOKED_AT);
        state.cost += COST_OF_FRAME + at.distance_squared(search.path.at(state.along));
        if state.along >= search.end {
            state.ended = Some(state.frames);
        }
    }

    /// Advances a walk in its clip to the frame `until`, or to the end of the stretch.
    fn stay(&self, search: &Search<'_>, state: &State, until: usize) -> State {
        let mut state = *state;
        for frame in state.frame + 1..=until {
            if state.ended.is_some() {
                break;
            }
            self.on(search, &mut state, frame);
        }
        state
    }

    /// Advances a walk by a transition.
    fn pass(&self, search: &Search<'_>, state: &State, exit: &GraphTransition) -> State {
        let mut state = State {
            clip: exit.to[0],
            placement: state.placement.after(&self.alignment(exit)),
            cost: state.cost + COST_OF_TRANSITION * f64::from(exit.distance) / self.threshold,
            ..*state
        };
        let first = exit.to[1] + 2 - self.window.frames();
        (first..=exit.to[1]).for_each(|frame| self.on(search, &mut state, frame));
        state
    }
}

impl<'a> Search<'a> {
    fn new(network: &'a Network<'a>, path: &'a Polyline, start: &State) -> Self {
        let begin = start.along;
        // If the rest of the path is too short for another stretch, the rest is added to this stretch.
        let end = match begin + AHEAD + KEPT < path.length() {
            true => begin + AHEAD,
            false => path.length(),
        };
        let stretches = ((end - begin) / STRETCH) as usize + 1;
        Self {
            network,
            path,
            begin,
            end,
            most: start.frames + ((end - begin) / SLOWEST * network.rate) as usize,
            taken: Vec::new(),
            open: (0..stretches).map(|_| BinaryHeap::new()).collect(),
            pushed: 0,
            reached: begin,
            best: None,
        }
    }

    /// The cheapest walk from any of the states to the end of the stretch.
    fn from(&mut self, starts: &[State]) -> Option<State> {
        starts.iter().for_each(|start| self.push(*start));
        for stretch in 0..self.open.len() {
            let mut seen = BTreeSet::new();
            while seen.len() < BEAM
                && let Some(OpenWalk { state, .. }) = self.open[stretch].pop()
            {
                if seen.insert(self.key(&state)) {
                    self.branch(&state);
                }
            }
            self.open[stretch] = BinaryHeap::new();
        }
        self.best
    }

    /// The key under which two walks count as equal: clip, frame, rounded place and rounded direction.
    fn key(&self, state: &State) -> [i64; 5] {
        let place = self.network.at(state) / SAME_PLACE;
        let turn = state.placement.turn.rem_euclid(std::f64::consts::TAU) / SAME_TURN;
        let [x, y, turn] = [place.x, place.y, turn].map(|value| value.round() as i64);
        [state.clip as i64, state.frame as i64, x, y, turn]
    }

    /// Continues a walk by each transition at its frame, and in the clip up to the next transition.
    fn branch(&mut self, state: &State) {
        let (network, clip, frame) = (self.network, state.clip, state.frame);
        for exit in network.exits_within(clip, frame, frame) {
            let mut next = network.pass(self, state, exit);
            self.taken.push(PathStep {
                before: state.taken,
                exit: *exit,
            });
            next.taken = Some(self.taken.len() - 1);
            self.push(next);
        }
        let last = network.clips[clip].part.map_or(frame, |part| part[1]);
        if frame < last {
            let leaving = network.exits_within(clip, frame + 1, last).first();
            let next = network.stay(self, state, leaving.map_or(last, |exit| exit.from[1]));
            self.push(next);
        }
    }

    /// Adds a walk that can continue, or records it as the best if it reached the end.
    fn push(&mut self, state: State) {
        if state.ended.is_some() {
            if self.best.is_none_or(|best| state.cost < best.cost) {
                self.best = Some(state);
            }
            return;
        }
        let is_off = self.network.at(&state).distance(self.path.at(state.along)) > FARTHEST;
        let stretch = ((state.along - self.begin) / STRETCH) as usize;
        if let Some(open) = self.open.get_mut(stretch)
            && !is_off
            && state.frames < self.most
        {
            self.pushed += 1;
            self.reached = self.reached.max(state.along);
            let number = self.pushed;
            open.push(OpenWalk { state, number });
        }
    }

    /// The error if no walk reaches the end of the path.
    fn stopped(&self) -> Error {
        let message = format!(
            "no walk of the graph follows the path beyond {:.1} of {:.1} m, because no clip continues as the path \
             does; add clips with such turns, mirror them, or raise the threshold of the graph",
            self.reached,
            self.path.length()
        );
        Diagnostic::new(Code::InvalidValue, message).into()
    }

    /// The transitions of a walk.
    fn transitions(&self, state: &State) -> Vec<GraphTransition> {
        let mut exits = Vec::new();
        let mut next = state.taken;
        while let Some(taken) = next.map(|number| &self.taken[number]) {
            exits.push(taken.exit);
            next = taken.before;
        }
        exits.reverse();
        exits
    }
}

/// Checks the points of a path, and builds the line through them.
fn line(points: Vec<DVec2>) -> Result<Polyline> {
    let refuse = |message: String| Err(Diagnostic::new(Code::InvalidValue, message).into());
    if points.len() < 2 {
        return refuse(format!("a path has at least two points, got {}", points.len()));
    }
    for (index, pair) in points.windows(2).enumerate() {
        let length = pair[0].distance(pair[1]);
        if !length.is_finite() || length <= 0.0 {
            return refuse(format!(
                "the points {} and {} of the path must differ, but are {length} m apart",
                index + 1,
                index + 2
            ));
        }
    }
    let line = Polyline::new(points);
    match line.length() {
        length if length > LONGEST => refuse(format!("a path is at most {LONGEST} m long, got {length}")),
        _ => Ok(line),
    }
}
