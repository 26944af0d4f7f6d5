//! Bends a walk so that it follows its path closely. The search leaves an error between walk and path. Smooth shifts
//! and rotations over the ground remove most of this error (Gleicher, "Motion Path Editing", 2001). The sway
//! from footstep to footstep does not change. The feet are locked later, as in every walk.

use glam::DVec2;
use mocap_scene::math::polyline::Polyline;

use super::network::Network;
use super::path::LOOKED_AT;
use super::walk::{Bend, Walk, WalkPath, smooth as blended};

/// The standard deviation in seconds of the Gaussian that smooths shifts and turns. It is also half of the time over
/// which the direction of a walk is measured. It is the time of one footstep.
const SMOOTH: f64 = 0.5;

/// The largest shift of a walk, in metres. A walk that is farther from the path does not follow it, and should stay
/// visibly away from it.
const MOST_MOVED: f64 = 0.4;

/// The largest turn of a walk, in radians (29 degrees), for the same reason as [`MOST_MOVED`].
const MOST_TURNED: f64 = 0.5;

/// The smallest distance that shows a direction, in metres. A figure that moves less while its direction is measured
/// has no direction.
const STILL: f64 = 0.1;

impl Network<'_> {
    /// Bends a walk onto a path, and records in the walk how near it is to the path.
    pub(super) fn bring_onto(&self, walk: &mut Walk, path: &Polyline) {
        let mut centres = self.centres(walk);
        centres.truncate((walk.seconds() * self.rate).ceil() as usize + 1);
        walk.bends = self.bends(centres, path);
        let moved: Vec<DVec2> = walk.bends.iter().map(|bend| bend.centre + bend.moved).collect();
        walk.followed = Some(followed(&moved, path, self.step()));
    }

    /// Half of the time over which a direction is measured, in frames.
    fn step(&self) -> usize {
        (SMOOTH * self.rate).round().max(1.0) as usize
    }

    /// The shift and turn of each frame that bring a walk onto a path.
    fn bends(&self, centres: Vec<DVec2>, path: &Polyline) -> Vec<Bend> {
        let along = along(&centres, path);
        let missing = centres
            .iter()
            .zip(&along)
            .map(|(centre, along)| path.at(*along) - *centre);
        let half = self.step();
        let turn = |frame: usize| turn((&centres, &along), path, frame, half);
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

    /// The position of the figure over the ground in each frame of a walk.
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

/// For each position in `places`, the nearest point of the path, as its distance along the path.
fn along(places: &[DVec2], path: &Polyline) -> Vec<f64> {
    let mut reached = 0.0;
    let next = |place: &DVec2| {
        reached = path.nearest(*place, reached, LOOKED_AT);
        reached
    };
    places.iter().map(next).collect()
}

/// The angle in radians from the direction of motion at a frame to the direction of the path.
fn turn((places, along): (&[DVec2], &[f64]), path: &Polyline, frame: usize, half: usize) -> f64 {
    let (from, to) = (frame.saturating_sub(half), (frame + half).min(places.len() - 1));
    let (own, wanted) = (places[to] - places[from], path.at(along[to]) - path.at(along[from]));
    match own.length().min(wanted.length()) > STILL {
        true => own.angle_to(wanted),
        false => 0.0,
    }
}

/// Measures how near the positions `places` are to a path.
fn followed(places: &[DVec2], path: &Polyline, half: usize) -> WalkPath {
    let along = along(places, path);
    let apart = places
        .iter()
        .zip(&along)
        .map(|(place, along)| place.distance(path.at(*along)));
    let turns = (0..places.len()).map(|frame| turn((places, &along), path, frame, half).abs().to_degrees());
    let mean_and_most = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, most) = values.fold((0.0, 0.0), |(sum, most), value| (sum + value, f64::max(most, value)));
        (sum / places.len().max(1) as f64, most)
    };
    let (mean_distance, largest_distance) = mean_and_most(&mut apart.into_iter());
    let (mean_angle, largest_angle) = mean_and_most(&mut turns.into_iter());
    WalkPath {
        length: path.length(),
        mean_distance,
        largest_distance,
        mean_angle,
        largest_angle,
    }
}

/// Smooths values by a Gaussian of `deviation` frames.
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
