//! Walks along a path over the ground, by branch and bound, as in section 5 of the paper.
//!
//! The figure is to be where the path is after as long a distance as it has gone: it chooses its speed. The cost of a
//! walk is the sum of the squared distances from there, frame by frame. It only grows, so that a walk that already
//! costs more than the best one of its length is left. All walks of some seconds are searched; the first half of the
//! best is kept, and the search goes on from its end.

use glam::{DVec2, DVec3};

use super::GraphTransition;
use super::distance::Alignment;
use super::network::Network;
use super::walk::Walk;
use crate::error::{Code, Diagnostic, Result};
use crate::math::polyline::Polyline;

/// How far ahead walks are searched, and how much of the best one is kept, in seconds.
const AHEAD: f64 = 4.0;
const KEPT: f64 = 1.5;

/// Pieces that a search looks at, at most. The best walk until then counts.
const MOST_PIECES: usize = 20_000;

/// The same where a beginning is looked for.
const PIECES_OF_START: usize = 200;

/// Where a walk can begin: so many frames of each second of a clip.
const STARTS: f64 = 3.0;

/// What a transition at the threshold costs, in square metres: as a second of motion at 3 cm from the path.
const COST_OF_TRANSITION: f64 = 0.03;

/// Walks end that go farther from the path than this, in metres: there is none that follows it.
const FARTHEST: f64 = 1e4;

/// The longest path, in metres, and the slowest walk along one, in metres per second.
const LONGEST: f64 = 1e4;
const SLOWEST: f64 = 0.1;

/// A walk so far: where the figure is in its clip, how it is moved, how far it has gone, and what that costs.
#[derive(Clone, Copy)]
struct State {
    clip: usize,
    frame: usize,
    placement: Alignment,
    gone: f64,
    at: DVec2,
    cost: f64,
    frames: usize,
}

/// A search from one state.
struct Search<'a> {
    network: &'a Network<'a>,
    path: &'a Polyline,
    /// The frames of the walks that are compared.
    ahead: usize,
    /// Pieces that may still be looked at.
    pieces: usize,
    taken: Vec<GraphTransition>,
    best: Option<(f64, Vec<GraphTransition>)>,
}

impl Network<'_> {
    /// A walk along a path over the ground, through points in metres along the two axes of the ground: x and z where +Y
    /// is up, x and y where +Z is. It begins at the first, and ends where it has gone as far as the path is long.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for fewer than two points, equal ones one after another, numbers that are not finite, or
    /// where no walk gets on along the path.
    pub fn along(&self, points: &[[f64; 2]]) -> Result<Walk> {
        let path = line(points.iter().map(|point| self.over_ground(*point)).collect())?;
        let (ahead, kept) = ((AHEAD * self.rate) as usize, (KEPT * self.rate) as usize);
        let most = (path.length() / SLOWEST * self.rate) as usize + ahead;
        let mut best: Option<(f64, State)> = None;
        for start in self.starts(&path) {
            let found = Search::new(self, &path, ahead / 2, PIECES_OF_START).from(start);
            if let Some((cost, _)) = found
                && best.as_ref().is_none_or(|best| cost < best.0)
            {
                best = Some((cost, start));
            }
        }
        let refuse = |message: &str| Diagnostic::new(Code::InvalidValue, message.to_owned());
        let Some((_, mut state)) = best else {
            return Err(refuse("no walk of the graph gets on along the path").into());
        };
        let mut walk = Walk::begin(self, state.clip, state.frame, state.placement);
        while state.gone < path.length() {
            let Some((_, exits)) = Search::new(self, &path, ahead, MOST_PIECES).from(state) else {
                return Err(self.dead_end(state.clip, state.frame));
            };
            let begun = state.frames;
            for exit in exits {
                if let Some(end) = self.end(&path, &state, exit.from[1]) {
                    walk.stay_until(end);
                    walk.bends = self.bends(&walk, &path);
                    return Ok(walk);
                }
                state = self.stay(&path, &state, exit.from[1]);
                state = self.pass(&path, &state, &exit);
                walk.take(self, &exit);
                if state.frames - begun >= kept {
                    break;
                }
            }
            if state.frames > most || state.at.distance(path.at(state.gone)) > FARTHEST {
                return Err(refuse("no walk of the graph gets on along the path").into());
            }
        }
        walk.bends = self.bends(&walk, &path);
        Ok(walk)
    }

    /// A point along the axes of the ground as they are in the world, along those of the clouds.
    fn over_ground(&self, [first, second]: [f64; 2]) -> DVec2 {
        let upright = self.space.up.abs().max_position();
        let mut axes = DVec3::AXES.into_iter().enumerate().filter(|(axis, _)| *axis != upright);
        let mut next = |value: f64| axes.next().map_or(DVec3::ZERO, |(_, axis)| value * axis);
        let point = next(first) + next(second);
        DVec2::from(self.space.ground.map(|axis| axis.as_dvec3().dot(point)))
    }

    /// Where walks can begin, each moved to where the path begins and turned so that it goes along.
    fn starts(&self, path: &Polyline) -> Vec<State> {
        let step = (self.rate / STARTS).ceil() as usize;
        let second = self.rate.ceil() as usize;
        let begin = path.at(0.0);
        let along = path.at(0.5) - begin;
        let mut starts = Vec::new();
        for (clip, graph_clip) in self.clips.iter().enumerate() {
            let Some([first, last]) = graph_clip.part else { continue };
            for frame in (first..last).step_by(step) {
                let centre = |frame: usize| self.clouds[clip].centres[frame];
                let (from, to) = (centre(frame), centre(last.min(frame + second)));
                let turn = match to.distance(from) > 0.1 {
                    true => (to - from).angle_to(along),
                    false => 0.0,
                };
                let placement = Alignment {
                    turn,
                    offset: begin - DVec2::from_angle(turn).rotate(from),
                    distance: 0.0,
                };
                starts.push(State {
                    clip,
                    frame,
                    placement,
                    gone: 0.0,
                    at: begin,
                    cost: 0.0,
                    frames: 0,
                });
            }
        }
        starts
    }

    /// One frame on.
    fn on(&self, path: &Polyline, state: &mut State, frame: usize) {
        let at = state.placement.apply(self.clouds[state.clip].centres[frame]);
        state.gone += at.distance(state.at);
        state.cost += at.distance_squared(path.at(state.gone));
        (state.at, state.frame) = (at, frame);
        state.frames += 1;
    }

    /// On in the clip until a frame.
    fn stay(&self, path: &Polyline, state: &State, until: usize) -> State {
        let mut state = *state;
        (state.frame + 1..=until).for_each(|frame| self.on(path, &mut state, frame));
        state
    }

    /// The frame in which the path ends, if it does before `until`.
    fn end(&self, path: &Polyline, state: &State, until: usize) -> Option<usize> {
        let mut state = *state;
        (state.frame + 1..=until).find(|frame| {
            self.on(path, &mut state, *frame);
            state.gone >= path.length()
        })
    }

    /// By a transition to another moment.
    fn pass(&self, path: &Polyline, state: &State, exit: &GraphTransition) -> State {
        let mut state = State {
            clip: exit.to[0],
            placement: state.placement.after(&self.alignment(exit)),
            cost: state.cost + COST_OF_TRANSITION * f64::from(exit.distance) / self.threshold,
            ..*state
        };
        let first = exit.to[1] + 2 - self.window.frames();
        (first..=exit.to[1]).for_each(|frame| self.on(path, &mut state, frame));
        state.frame = exit.to[1];
        state
    }
}

impl<'a> Search<'a> {
    fn new(network: &'a Network<'a>, path: &'a Polyline, ahead: usize, pieces: usize) -> Self {
        Self {
            network,
            path,
            ahead,
            pieces,
            taken: Vec::new(),
            best: None,
        }
    }

    /// The best walk from a state: what it costs for each frame, and its transitions.
    fn from(mut self, state: State) -> Option<(f64, Vec<GraphTransition>)> {
        let begin = State {
            cost: 0.0,
            frames: 0,
            ..state
        };
        self.branch(&begin);
        self.best
    }

    fn branch(&mut self, state: &State) {
        let last = self.network.clips[state.clip].part.map_or(state.frame, |part| part[1]);
        let last = last.min(state.frame + self.ahead);
        let exits = self.network.exits_within(state.clip, state.frame, last);
        let mut ahead = Vec::with_capacity(exits.len());
        let mut here = *state;
        for exit in exits {
            here = self.network.stay(self.path, &here, exit.from[1]);
            ahead.push((self.network.pass(self.path, &here, exit), *exit));
        }
        // The most promising first, so that others soon cost more.
        let mean = |state: &State| state.cost / state.frames.max(1) as f64;
        ahead.sort_by(|a, b| mean(&a.0).total_cmp(&mean(&b.0)));
        for (next, exit) in ahead {
            let Some(left) = self.pieces.checked_sub(1) else { return };
            self.pieces = left;
            // Walks of one length are compared: what is missing costs nothing yet.
            let is_worse = |best: &(f64, Vec<GraphTransition>)| next.cost / self.ahead as f64 >= best.0;
            if self.best.as_ref().is_some_and(is_worse) {
                continue;
            }
            self.taken.push(exit);
            if next.frames >= self.ahead || next.gone >= self.path.length() {
                let cost = next.cost / next.frames.max(1) as f64;
                if self.best.as_ref().is_none_or(|best| cost < best.0) {
                    self.best = Some((cost, self.taken.clone()));
                }
            } else {
                self.branch(&next);
            }
            self.taken.pop();
        }
    }
}

/// The line through the points of a path.
fn line(points: Vec<DVec2>) -> Result<Polyline> {
    let refuse = |message: String| Err(Diagnostic::new(Code::InvalidValue, message).into());
    if points.len() < 2 {
        return refuse(format!("a path has at least two points, got {}", points.len()));
    }
    for (index, pair) in points.windows(2).enumerate() {
        let length = pair[0].distance(pair[1]);
        if !length.is_finite() || length <= 0.0 {
            return refuse(format!(
                "points {} and {} of the path are {length} m apart",
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
