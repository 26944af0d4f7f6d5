//! Makes a figure follow a path.

use std::fmt;

use glam::{DVec2, Vec2, Vec3, Vec3Swizzles};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::polyline::Polyline;
use mocap_scene::scene::{Animation, Scene};
use serde::Serialize;

use super::controller::Controller;
use super::features::{AHEAD, FEATURE_RATE};
use super::record::Record;
use super::trajectory::Trajectory;

/// The length of the piece of the path in which the point nearest to the figure is searched, as seconds at the wanted
/// speed. The piece begins at the last nearest point.
const LOOKED_AT: f64 = 0.5;
/// The distance to the end of the path at which the figure has arrived, in metres.
const ARRIVED: f64 = 0.2;
/// The longest time for a path: a factor for the path's time at the wanted speed, and a number of seconds to add.
const LONGEST: (f64, f64) = (3.0, 5.0);
/// The longest path, in minutes at the wanted speed.
const MOST_MINUTES: f64 = 60.0;

/// How a figure followed a path.
///
/// [`Controller::follow`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FollowReport {
    /// The number of frames, at 60 frames per second.
    pub frames: usize,
    /// The number of jumps to other frames of the database.
    pub jumps: usize,
    /// The length of the path, in metres.
    pub length: f64,
    /// The mean distance of the figure from the path, in metres.
    pub mean_distance: f64,
    /// The largest distance of the figure from the path, in metres.
    pub largest_distance: f64,
    /// The mean angle between the facing of the figure and the direction of the path, in degrees.
    pub mean_angle: f64,
    /// Whether the figure reached the end of the path.
    pub has_arrived: bool,
}

impl fmt::Display for FollowReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "frames: {}, jumps: {}; path of {:.1} m: mean deviation {:.2} m and {:.0} degrees, {:.2} m at most{}",
            self.frames,
            self.jumps,
            self.length,
            self.mean_distance,
            self.mean_angle,
            self.largest_distance,
            if self.has_arrived {
                ""
            } else {
                "; the figure did not reach the end of the path"
            }
        )
    }
}

impl Controller {
    /// Makes the figure walk along a path over the ground at `speed` m/s. `path` has points along x and z, in metres.
    /// `character` has the skeleton of the controller's moves. Returns the motion, and a report of how well the figure
    /// followed.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::glam::{Vec2, Vec3};
    /// use mocap::matching::{Controller, Database, Moves, IndexedClip};
    /// use mocap::retarget::{Retargeter, RetargetOptions};
    ///
    /// # fn main() -> mocap::Result<()> {
    /// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let database = Database::new(IndexedClip::of(&walk, "walk.bvh", false));
    /// let mut hero = mocap::import("fixtures/real/rokoko_dance.bvh")?;
    /// mocap::Conversion::new().apply(&mut hero)?;
    /// let clips = Retargeter::new(walk, hero.clone(), RetargetOptions::new())?.into_clips();
    /// let mut moves = Moves::new(&hero)?;
    /// moves.add(&database.clips()[0], &clips[0].animation)?;
    /// let mut figure = Controller::new(&database, moves, Vec3::ZERO, Vec3::Z)?;
    /// let (animation, followed) = figure.follow(&hero, &[Vec2::ZERO, Vec2::new(0.0, 3.0)], 1.2)?;
    /// assert_eq!(animation.frame_count(), followed.frames);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for a path without length, and for numbers that are not finite or are too large.
    pub fn follow(&mut self, character: &Scene, path: &[Vec2], speed: f32) -> Result<(Animation, FollowReport)> {
        let path = line(path, speed)?;
        let speed = f64::from(speed);
        let mut record = Record::new(self, character);
        let mut followed = FollowReport {
            length: path.length(),
            ..FollowReport::default()
        };
        let seconds = LONGEST.0 * path.length() / speed + LONGEST.1;
        let frames = (seconds * FEATURE_RATE) as usize;
        let (mut along, jumps) = (0.0, self.jumps());
        let mut before = self.position();
        for _ in 0..frames {
            record.add(self.pose());
            let position = self.position().xz().as_dvec2();
            along = path.nearest(position, along, speed * LOOKED_AT);
            let (distance, direction) = (path.at(along).distance(position), path.direction(along));
            let angle = direction.angle_to(self.forward().xz().as_dvec2()).abs().to_degrees();
            followed.mean_distance += distance;
            followed.mean_angle += angle;
            followed.largest_distance = followed.largest_distance.max(distance);
            followed.frames += 1;
            if path.length() - along < ARRIVED {
                followed.has_arrived = true;
                break;
            }
            let ahead = AHEAD.map(|frames| along + speed * frames as f64 / FEATURE_RATE);
            let positions = ahead.map(|along| on_ground(path.at(along)));
            let directions = ahead.map(|along| on_ground(path.direction(along)));
            let step = self.position().distance(before);
            before = self.position();
            // A turn is half complete after about `AHEAD[0]` frames. So the turn begins `AHEAD[0]` frames before the
            // figure should face along the path.
            let soon = path.direction(along + speed * AHEAD[0] as f64 / FEATURE_RATE);
            self.correct(on_ground(path.at(along)), on_ground(soon), step);
            self.update(&Trajectory::new(positions, directions));
        }
        followed.mean_distance /= followed.frames.max(1) as f64;
        followed.mean_angle /= followed.frames.max(1) as f64;
        followed.jumps = self.jumps() - jumps;
        Ok((record.animation(character), followed))
    }
}

/// A point on the ground, in the world.
fn on_ground(point: DVec2) -> Vec3 {
    let point = point.as_vec2();
    Vec3::new(point.x, 0.0, point.y)
}

/// Checks the points and the speed, and makes a line of the points.
fn line(points: &[Vec2], speed: f32) -> Result<Polyline> {
    let mut points: Vec<DVec2> = points.iter().map(|point| point.as_dvec2()).collect();
    points.dedup();
    let line = (points.len() > 1).then(|| Polyline::new(points));
    let length = line.as_ref().map_or(0.0, Polyline::length);
    let minutes = length / f64::from(speed) / 60.0;
    let is_valid = length.is_finite() && speed > 0.0 && speed.is_finite() && minutes <= MOST_MINUTES;
    if let Some(line) = line.filter(|_| is_valid) {
        return Ok(line);
    }
    let message = format!("the path is {length} m long at {speed} m/s");
    let expected = format!("two points, a speed above 0 m/s, and at most {MOST_MINUTES} minutes");
    let diagnostic = Diagnostic::new(Code::InvalidValue, "the figure cannot follow the path");
    Err(diagnostic.expected_found(expected, message).into())
}
