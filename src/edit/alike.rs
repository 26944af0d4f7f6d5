//! Finds the most similar frames of two motions, near the ends that a step joins or mixes. The measure is the distance
//! of motion graphs, which compares two windows: short runs of frames. `docs/motion-graphs-algorithm.md` has the
//! formula.

use std::ops::Range;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;

use super::StepInput;
use super::body::any_figure_of;
use super::frames::Frames;
use crate::graph::clouds::{CloudSpace, Clouds};
use crate::graph::distance::Window;

/// The highest rate at which frames are compared, in frames per second. A higher rate finds the same frames.
const MOST_PER_SECOND: f64 = 60.0;

/// A frame rate may be above `MOST_PER_SECOND` by this fraction, because frame times in files are rounded. If the rate
/// is still higher, it is divided by the smallest whole number that makes it low enough.
const ROUNDED: f64 = 1e-3;

/// The longest window of frames that is compared, in seconds: the window of a motion graph.
const WINDOW: f64 = 1.0 / 3.0;

/// The longest time that is searched, in seconds.
const LONGEST: f64 = 10.0;

/// A time in each of two motions, in seconds from the beginning of the motion. Also the distance in metres between the
/// two windows at these times.
#[derive(Clone, Copy, Debug)]
pub(super) struct MomentPair {
    pub(super) at: [f64; 2],
    pub(super) apart: f32,
}

/// Two motions as point clouds (the positions of the joints in each frame), and how many frames to search.
pub(super) struct Alikeness {
    space: CloudSpace,
    window: Window,
    clouds: [Clouds; 2],
    /// The number of point clouds per second.
    rate: f64,
    /// The number of frames that are searched at each end of a motion.
    within: usize,
}

/// Refuses a search time that is negative or longer than [`LONGEST`].
pub(super) fn check(within: f64) -> Result<()> {
    if (0.0..=LONGEST).contains(&within) {
        return Ok(());
    }
    let message = format!("within must be from 0 to {LONGEST} seconds, got {within}");
    Err(Diagnostic::new(Code::InvalidValue, message).into())
}

impl Alikeness {
    /// Compares the animation that a step changes with the first animation of `other`. `first` has the frames of the
    /// changed animation. The search covers `within` seconds. Returns `None` if `within` is 0 or a motion is shorter
    /// than a window.
    pub(super) fn new(
        scene: &Scene,
        input: &StepInput<'_>,
        other: &Scene,
        first: &Frames,
        within: f64,
    ) -> Result<Option<Self>> {
        check(within)?;
        if within == 0.0 {
            return Ok(None);
        }
        let figure = any_figure_of(scene, input);
        let space = CloudSpace::new(scene, &figure)?;
        let rate = first.rate / (first.rate / MOST_PER_SECOND - ROUNDED).ceil().max(1.0);
        let of = |scene: &Scene, animation: usize| Clouds::new(&space, scene, &scene.animations[animation], rate);
        let clouds = [of(scene, input.animation)?, of(other, 0)?];
        // A window takes at most half of the searched time, so that several windows fit into this time.
        let frames = (WINDOW.min(0.5 * within) * rate).round().max(2.0) as usize;
        let window = Window::new(frames);
        let has_room = clouds.iter().all(|clouds| window.count(clouds) > 0);
        Ok(has_room.then_some(Self {
            within: (within * rate).round() as usize,
            space,
            window,
            clouds,
            rate,
        }))
    }

    /// The best seam: the time at which the first motion should end, and the time at which the second motion should
    /// begin.
    pub(super) fn seam(&self) -> MomentPair {
        let last = self.window.count(&self.clouds[0]);
        let room = (self.within + 1).saturating_sub(self.window.frames()).max(1);
        let middle = (self.window.frames() - 1) / 2;
        let second = 0..room.min(self.window.count(&self.clouds[1]));
        self.least([(last.saturating_sub(room)..last, second)], middle)
    }

    /// The times at which both motions should begin. At most one of the two motions loses frames.
    pub(super) fn beginning(&self) -> MomentPair {
        let [a, b] = self.rooms().map(|room| 0..room);
        self.least([(a, 0..1), (0..1, b)], 0)
    }

    /// The times at which both motions should end. At most one of the two motions loses frames.
    pub(super) fn end(&self) -> MomentPair {
        let rooms = self.rooms();
        let counts = [0, 1].map(|motion| self.window.count(&self.clouds[motion]));
        let [a, b] = [0, 1].map(|motion| counts[motion] - rooms[motion]..counts[motion]);
        let [last_a, last_b] = counts.map(|count| count - 1..count);
        self.least([(last_a, b), (a, last_b)], self.window.frames() - 1)
    }

    /// The number of windows of each motion that are searched: at most half of its windows.
    fn rooms(&self) -> [usize; 2] {
        let room = |clouds: &Clouds| (self.within + 1).min(self.window.count(clouds).div_ceil(2));
        [0, 1].map(|motion| room(&self.clouds[motion]))
    }

    /// The two most similar windows, one of each motion. Each pair of `parts` has the first frames of the windows to
    /// compare: a range for each motion. If several pairs are equally similar, the first pair is chosen. The result has
    /// the time of frame `frame` of each window.
    fn least<const N: usize>(&self, parts: [(Range<usize>, Range<usize>); N], frame: usize) -> MomentPair {
        let [a, b] = &self.clouds;
        let mut nearest = (f32::INFINITY, [0, 0]);
        for (rows, columns) in parts {
            let distances = self
                .window
                .distances(&self.space, (a, rows.clone()), (b, columns.clone()));
            for (index, distance) in distances.into_iter().enumerate() {
                if distance < nearest.0 {
                    let (row, column) = (index / columns.len(), index % columns.len());
                    nearest = (distance, [rows.start + row, columns.start + column]);
                }
            }
        }
        let (apart, starts) = nearest;
        MomentPair {
            at: starts.map(|start| (start + frame) as f64 / self.rate),
            apart,
        }
    }
}
