//! Brings a walk onto the path that it follows. What the clips leave is bent little by little: the walk is shifted and
//! turned over the ground, smoothly over time, as Gleicher edits the path of a motion ("Motion Path Editing", 2001).
//! Steps sway beside the path as they did, and feet are held afterwards, as those of every walk.

use glam::DVec2;

use super::network::Network;
use super::walk::{Bend, Walk, smooth as blended};
use crate::math::polyline::Polyline;

/// The deviation of the Gaussian bell over which a bend is smoothed, and half of the time over which the direction of a
/// walk is taken, in seconds: a step.
const SMOOTH: f64 = 0.5;

/// How far a walk is shifted at most, in metres, and turned, in radians: a walk that is farther off does not follow the
/// path, and shall not look as if.
const MOST_MOVED: f64 = 0.4;
const MOST_TURNED: f64 = 0.5;

/// How far ahead on the path the nearest point is looked for from frame to frame, in metres.
const LOOKED_AT: f64 = 0.5;

/// A figure that moves by less than this in the time of a direction goes nowhere, in metres.
const STILL: f64 = 0.1;

impl Network<'_> {
    /// How each frame of a walk is moved so that it is on a path.
    pub(super) fn bends(&self, walk: &Walk, path: &Polyline) -> Vec<Bend> {
        let centres = self.centres(walk);
        let mut reached = 0.0;
        let along: Vec<f64> = centres
            .iter()
            .map(|centre| {
                reached = path.nearest(*centre, reached, LOOKED_AT);
                reached
            })
            .collect();
        let missing = centres
            .iter()
            .zip(&along)
            .map(|(centre, along)| path.at(*along) - *centre);
        let half = (SMOOTH * self.rate).round().max(1.0) as usize;
        let last = centres.len().saturating_sub(1);
        let turn = |frame: usize| {
            let (from, to) = (frame.saturating_sub(half), (frame + half).min(last));
            let (own, wanted) = (centres[to] - centres[from], path.at(along[to]) - path.at(along[from]));
            match own.length().min(wanted.length()) > STILL {
                true => own.angle_to(wanted),
                false => 0.0,
            }
        };
        let moved = smooth(&missing.collect::<Vec<_>>(), half);
        let turns = (0..centres.len()).map(|frame| DVec2::new(turn(frame), 0.0));
        let turns = smooth(&turns.collect::<Vec<_>>(), half);
        let bends = centres.into_iter().zip(moved.into_iter().zip(turns));
        bends
            .map(|(centre, (moved, turn))| Bend {
                centre,
                moved: moved.clamp_length_max(MOST_MOVED),
                turn: turn.x.clamp(-MOST_TURNED, MOST_TURNED),
            })
            .collect()
    }

    /// Where the figure is in each frame of a walk.
    fn centres(&self, walk: &Walk) -> Vec<DVec2> {
        let blend = walk.window - 1;
        let centre = |piece: usize, frame: usize| {
            let clip = walk.pieces[piece].clip;
            walk.placements[piece].apply(self.clouds[clip].centres[frame])
        };
        let mut centres = Vec::with_capacity(walk.frames() + 1);
        for (index, piece) in walk.pieces.iter().enumerate() {
            centres.extend((piece.first..=piece.last).map(|frame| centre(index, frame)));
            let Some(next) = walk.pieces.get(index + 1) else { break };
            for step in 1..blend {
                let (from, to) = (piece.last + step, next.first + step - blend);
                let weight = blended(step as f64 / blend as f64);
                centres.push(centre(index, from).lerp(centre(index + 1, to), weight));
            }
        }
        centres
    }
}

/// The mean of values around each, under a Gaussian bell of `deviation` frames.
fn smooth(values: &[DVec2], deviation: usize) -> Vec<DVec2> {
    let reach = 3 * deviation;
    let weight = |steps: usize| (-0.5 * (steps as f64 / deviation as f64).powi(2)).exp();
    let weights: Vec<f64> = (0..=reach).map(weight).collect();
    let at = |middle: usize| {
        let (first, last) = (middle.saturating_sub(reach), (middle + reach).min(values.len() - 1));
        let near = (first..=last).map(|frame| (weights[frame.abs_diff(middle)], values[frame]));
        let (whole, sum) = near.fold((0.0, DVec2::ZERO), |(whole, sum), (weight, value)| {
            (whole + weight, sum + weight * value)
        });
        sum / whole
    };
    (0..values.len()).map(at).collect()
}
