//! Finds a wrong frame rate: from frames that repeat in a pattern, and from a body that falls too slowly or too fast.
//!
//! A take of 24 frames per second in a file of 30 repeats each fourth frame. A file that states half of the true rate
//! shows slow motion: jumps fall with a quarter of gravity, and steps are too long for their frequency. The fall of the
//! centre of mass is a law of physics, so it corrects the rate. The ratio of length and frequency of steps is a habit,
//! so it only causes a warning.

use glam::{DVec3, Vec3};
use mocap_figure::contacts::points_of_feet;
use mocap_scene::math::median::median;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Side};

use crate::frames::tracks;
use crate::quantity::counted;
use crate::work::Work;

/// The longest pattern of repeated frames, in frames. Film of 24 Hz in 30 Hz has a pattern of 5 frames, 50 Hz in 60 Hz
/// one of 6.
const LONGEST_PATTERN: usize = 10;

/// The least number of times that a pattern must repeat. Fewer repetitions can be chance.
const REPEATS: usize = 8;
/// The fraction of the frames in which a pattern must hold.
const HOLDS: f64 = 0.95;

/// The acceleration of gravity in m/s^2: its standard value, rounded.
const GRAVITY: f64 = 9.81;

/// The least height of both feet above their resting level in a flight, in metres. It exceeds the noise of a run.
const IN_FLIGHT: f64 = 0.06;

/// The shortest flight in frames. A parabola has three unknowns, and three further frames show how well it fits.
const LEAST_FLIGHT: usize = 6;

/// The least rise of the parabola of a flight, in metres. With a lower rise, noise changes the rate by more than a
/// tenth.
const LEAST_BEND: f64 = 0.05;

/// The largest distance of the centre of mass from the parabola, as a fraction of the rise. The masses are from an
/// average body.
const BESIDE: f64 = 0.15;
/// The largest relative difference between the rates of two flights.
const AGREE: f64 = 0.12;

/// The factors between a stated and a true rate that are corrected. The writer doubled or halved the number of frames,
/// once or twice.
const FACTORS: [f64; 4] = [0.25, 0.5, 2.0, 4.0];

/// The largest relative deviation from such a factor. Half of the distance between two factors is 0.3.
const NEAR: f64 = 0.12;

/// The factor within which a measured rate agrees with the stated rate. Steps do not determine the rate better.
const ALIKE: f64 = 1.25;

/// The ratio of step length to step frequency, made dimensionless by the leg length and gravity. It hardly depends on
/// speed: 0.0063 m for each step per minute, with 0.84 m from hip to ankle. The source is Sekiya and Nagasaki,
/// "Reproducibility of the walking patterns of normal young adults", 1998.
const WALK_RATIO: f64 = 1.54;

/// The largest factor between a measured ratio and [`WALK_RATIO`]. The ratio varies by a fifth between people, and more
/// between styles of walking.
const WALK_RATIO_OFF: f64 = 1.55;

/// The least number of steps of a walk: two of each foot.
const STEPS: usize = 4;

/// The least step length as a fraction of the leg. Shuffling steps do not keep the ratio.
const LEAST_STEP: f64 = 0.45;
/// The least distance that the body moves in a step of a walk, as a fraction of the step length.
const GOES: f64 = 0.7;

/// The masses of segments as fractions of the body's mass, and the position of each centre as a fraction of the way
/// from one joint to the other. The entries of one side apply to both sides. Winter, "Biomechanics and motor control of
/// human movement" (2009), table 4.1.
const SEGMENTS: [(Bone, Bone, f64, f64); 7] = [
    (Bone::Hips, Bone::Neck, 0.497, 0.5),
    (Bone::Neck, Bone::Head, 0.081, 1.0),
    (Bone::LeftUpperArm, Bone::LeftLowerArm, 0.028, 0.436),
    (Bone::LeftLowerArm, Bone::LeftHand, 0.022, 0.682),
    (Bone::LeftUpperLeg, Bone::LeftLowerLeg, 0.1, 0.433),
    (Bone::LeftLowerLeg, Bone::LeftFoot, 0.0465, 0.433),
    (Bone::LeftFoot, Bone::LeftFoot, 0.0145, 0.5),
];

/// A repeating pattern of frames: for each place in the pattern, whether its frame repeats the frame before.
pub(super) struct Pattern {
    pub(super) is_held: Vec<bool>,
}

impl Pattern {
    /// The shortest pattern of held frames; `None` if they follow no pattern.
    pub(super) fn of(held: &[bool]) -> Option<Self> {
        let moving = held.iter().position(|held| !held)?..=held.iter().rposition(|held| !held)?;
        let held = &held[moving];
        (2..=LONGEST_PATTERN).find_map(|length| Self::of_length(held, length))
    }

    fn of_length(held: &[bool], length: usize) -> Option<Self> {
        let periods = held.len() / length;
        if periods < REPEATS {
            return None;
        }
        let count = |position: usize| held.iter().skip(position).step_by(length).filter(|held| **held).count();
        let is_held: Vec<bool> = (0..length).map(|position| 2 * count(position) > periods).collect();
        let agrees = held
            .iter()
            .enumerate()
            .filter(|(frame, held)| is_held[frame % length] == **held)
            .count();
        let some = is_held.contains(&true) && is_held.contains(&false);
        (some && agrees as f64 >= HOLDS * held.len() as f64).then_some(Self { is_held })
    }

    /// The fraction of the frames that do not repeat the frame before.
    pub(super) fn fraction_of_own(&self) -> f64 {
        self.is_held.iter().filter(|held| !**held).count() as f64 / self.is_held.len() as f64
    }
}

/// The evidence of a motion about its frame rate.
pub(super) enum RateEvidence {
    /// The true rate is `rate`, in frames per second. At this rate, the body falls by gravity in `flights` jumps. At
    /// the file's rate, it falls by `fall` times gravity.
    Is { rate: f64, flights: usize, fall: f64 },
    /// A message about what looks wrong. The rate is not certain.
    Perhaps(String),
}

/// The evidence of jumps and steps about the frame rate; `None` if the rate looks right or there is no evidence.
pub(super) fn told(work: &Work<'_>) -> Option<RateEvidence> {
    let body = Measured::new(work)?;
    let mut rates = body.flights();
    let stated = work.frames.rate;
    let Some(rate) = median(&mut rates).map(f64::from) else {
        return body.steps(stated).map(RateEvidence::Perhaps);
    };
    let ratio = rate / stated;
    if (1.0 / ALIKE..ALIKE).contains(&ratio) {
        return None;
    }
    let agree = rates.iter().all(|other| (f64::from(*other) / rate - 1.0).abs() < AGREE);
    let factor = FACTORS.into_iter().find(|factor| (ratio / factor - 1.0).abs() < NEAR);
    match factor.filter(|_| agree && rates.len() > 1) {
        Some(factor) => Some(RateEvidence::Is {
            rate: stated * factor,
            flights: rates.len(),
            fall: ratio.powi(-2),
        }),
        None => Some(RateEvidence::Perhaps(format!(
            "the fall of the body in {} fits {rate:.0} frames per second, not {stated:.0}",
            counted(rates.len(), "jump")
        ))),
    }
}

/// The positions of the body over time, in metres: along the two axes of the ground, and up.
struct Measured {
    centre: Vec<DVec3>,
    /// The height of the lowest point of either foot above its resting level.
    lowest: Vec<f64>,
    ankles: [Vec<DVec3>; 2],
    leg: f64,
}

impl Measured {
    fn new(work: &Work<'_>) -> Option<Self> {
        let joint = |bone: Bone| work.figure.humanoid.joint(bone);
        let segments = SEGMENTS.iter().flat_map(|&(from, to, mass, at)| {
            let is_paired = from.side().is_some();
            let sides = if is_paired { &Side::ALL[..] } else { &Side::ALL[..1] };
            sides
                .iter()
                .map(move |side| (from.on(*side), to.on(*side), mass, at))
                .collect::<Vec<_>>()
        });
        let segments: Vec<(NodeId, NodeId, f64, f64)> = segments
            .filter_map(|(from, to, mass, at)| Some((joint(from)?, joint(to)?, mass, at)))
            .collect();
        let mass: f64 = segments.iter().map(|segment| segment.2).sum();
        // Without the trunk or a leg, the computed centre of mass would be wrong.
        if mass < 0.8 {
            return None;
        }
        let [ankles, balls] = points_of_feet(work.scene, &work.figure.humanoid);
        let feet: Vec<NodeId> = ankles.iter().chain(&balls).map(|(_, node)| *node).collect();
        let [x, y, up] = crate::floor::axes(work.up);
        let local = |point: Vec3| (Vec3::new(point.dot(x), point.dot(y), point.dot(up)) * work.metres).as_dvec3();
        let mut pose = Pose::rest(work.scene);
        let centre = (0..work.frames.len()).map(|frame| {
            work.frames.pose(frame, &mut pose);
            let weighed = segments
                .iter()
                .map(|&(from, to, mass, at)| mass * local(pose.position(from)).lerp(local(pose.position(to)), at));
            weighed.sum::<DVec3>() / mass
        });
        let centre = centre.collect();
        let tracks = tracks(&work.frames, work.scene, &feet);
        let tracks: Vec<Vec<DVec3>> = tracks
            .iter()
            .map(|track| track.iter().copied().map(local).collect())
            .collect();
        Some(Self {
            centre,
            lowest: lowest(&tracks),
            ankles: [tracks.first()?.clone(), tracks.get(1)?.clone()],
            leg: f64::from(work.leg()?),
        })
    }

    /// The frame rates at which the centre of mass falls by gravity, one for each flight.
    fn flights(&self) -> Vec<f32> {
        let mut rates = Vec::new();
        let mut first = 0;
        while first < self.lowest.len() {
            let end = (first..self.lowest.len())
                .find(|frame| self.lowest[*frame] < IN_FLIGHT)
                .unwrap_or(self.lowest.len());
            if end >= first + LEAST_FLIGHT && end < self.lowest.len() && first > 0 {
                rates.extend(self.rate_of(&self.centre[first..end]));
            }
            first = end + 1;
        }
        rates
    }

    /// The frame rate at which these positions fall by gravity; `None` if they are no flight.
    fn rate_of(&self, positions: &[DVec3]) -> Option<f32> {
        let frames = positions.len() as f64;
        let heights: Vec<f64> = positions.iter().map(|position| position.z).collect();
        let [bend, beside] = parabola(&heights);
        let height = bend * (frames - 1.0).powi(2) / 8.0;
        let straight = [0, 1].map(|axis| {
            let along: Vec<f64> = positions.iter().map(|position| position[axis]).collect();
            parabola(&along)[0].abs() * (frames - 1.0).powi(2) / 8.0
        });
        let is_flight =
            -height > LEAST_BEND && beside < BESIDE * -height && straight.into_iter().all(|off| off < 0.5 * -height);
        is_flight.then(|| (GRAVITY / -bend).sqrt() as f32)
    }

    /// A message about the rate if the steps of a walk are far too long or too short for their frequency.
    fn steps(&self, rate: f64) -> Option<String> {
        let landings = self.landings(rate);
        let steps: Vec<(f64, f64)> = landings
            .windows(2)
            .filter(|pair| {
                let step = (self.centre[pair[1]] - self.centre[pair[0]]).truncate().length();
                step > GOES * self.step_at(pair[1])
            })
            .map(|pair| ((pair[1] - pair[0]) as f64 / rate, self.step_at(pair[1])))
            .collect();
        if steps.len() < STEPS {
            return None;
        }
        let middle = |values: Vec<f64>| {
            let mut values: Vec<f32> = values.into_iter().map(|value| value as f32).collect();
            median(&mut values).map(f64::from)
        };
        let time = middle(steps.iter().map(|step| step.0).collect())?;
        let length = middle(steps.iter().map(|step| step.1).collect())?;
        let ratio = length / self.leg * time / (self.leg / GRAVITY).sqrt();
        let off = ratio / WALK_RATIO;
        let words = if off > WALK_RATIO_OFF { "slow" } else { "fast" };
        (!(1.0 / WALK_RATIO_OFF..WALK_RATIO_OFF).contains(&off)).then(|| {
            format!(
                "the walk looks {:.1} times too {words}: {:.1} steps per second, each {length:.2} m long; {:.0} frames \
                 per second would give the pace of a person, not {rate:.0}",
                off.max(1.0 / off),
                1.0 / time,
                rate * off
            )
        })
    }

    /// The distance between the ankles over the ground, in metres.
    fn step_at(&self, frame: usize) -> f64 {
        let apart = self.ankles[0][frame] - self.ankles[1][frame];
        apart.truncate().length()
    }

    /// The frames in which the ankles are farthest apart, with alternating feet in front: one for each step.
    fn landings(&self, rate: f64) -> Vec<usize> {
        let frames = self.centre.len();
        let half = ((0.25 * rate) as usize).max(2);
        let along: Vec<f64> = (0..frames)
            .map(|frame| {
                let step = self.centre[(frame + half).min(frames - 1)] - self.centre[frame.saturating_sub(half)];
                let step = step.truncate().normalize_or_zero();
                (self.ankles[0][frame] - self.ankles[1][frame]).truncate().dot(step)
            })
            .collect();
        let least = LEAST_STEP * self.leg;
        let mut found: Vec<usize> = Vec::new();
        for frame in 0..frames {
            if along[frame].abs() < least {
                continue;
            }
            match found.last_mut() {
                Some(last) if along[*last].signum() == along[frame].signum() => {
                    if along[frame].abs() > along[*last].abs() {
                        *last = frame;
                    }
                }
                _ => found.push(frame),
            }
        }
        // The first step may be cut off by the beginning of the motion.
        found.into_iter().skip(1).collect()
    }
}

/// The height in each frame of the lowest point of either foot, relative to the point's resting level.
fn lowest(tracks: &[Vec<DVec3>]) -> Vec<f64> {
    let frames = tracks.first().map_or(0, Vec::len);
    let level = |track: &Vec<DVec3>| {
        let mut heights: Vec<f64> = track.iter().map(|position| position.z).collect();
        heights.sort_unstable_by(f64::total_cmp);
        heights[heights.len() / 10]
    };
    let levels: Vec<f64> = tracks.iter().map(level).collect();
    let of_frame = |frame: usize| {
        let above = tracks.iter().zip(&levels).map(|(track, level)| track[frame].z - level);
        above.fold(f64::INFINITY, f64::min)
    };
    let heights: Vec<f64> = (0..frames).map(of_frame).collect();
    let calm = |frame: usize| {
        let mut around = heights[frame.saturating_sub(2)..(frame + 3).min(frames)].to_vec();
        median(&mut around).unwrap_or_default()
    };
    (0..frames).map(calm).collect()
}

/// Fits a parabola to evenly spaced values by least squares, with orthogonal polynomials. Returns its second derivative
/// per frame, and the root mean square of the residuals.
fn parabola(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let middle = (n - 1.0) / 2.0;
    let mean_square = (n * n - 1.0) / 12.0;
    let (mut sums, mut squares) = ([0.0; 3], [0.0; 3]);
    let basis = |index: usize| {
        let t = index as f64 - middle;
        [1.0, t, t * t - mean_square]
    };
    for (index, value) in values.iter().enumerate() {
        for (degree, factor) in basis(index).into_iter().enumerate() {
            sums[degree] += factor * value;
            squares[degree] += factor * factor;
        }
    }
    let factors: [f64; 3] = std::array::from_fn(|degree| sums[degree] / f64::max(squares[degree], 1e-12));
    let beside = values.iter().enumerate().map(|(index, value)| {
        let fitted: f64 = basis(index)
            .iter()
            .zip(factors)
            .map(|(basis, factor)| basis * factor)
            .sum();
        (value - fitted).powi(2)
    });
    [2.0 * factors[2], (beside.sum::<f64>() / n).sqrt()]
}
