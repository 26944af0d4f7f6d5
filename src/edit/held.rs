//! Brings a limb or another chain of joints to a goal, in a range of frames.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};
use mocap_scene::math::quaternion::{exp, in_hemisphere_of, log};
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{NodeId, Scene};
use serde::Serialize;

use super::chain::Chain;
use super::frames::Frames;
use super::inertia::ease;
use super::limb::{LimbChain, NaturalBend, Swivel};
use super::quantity::centimetres;
use super::window::Window;

/// The distance from the goal that counts as reached, in metres.
const REACHED: f32 = 1e-4;

/// The accuracy with which a limb reached its goals. Lengths are in metres.
///
/// [`Reach`](crate::Reach) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LimbReport {
    /// The number of frames in which the limb should be at its goal.
    pub frames: usize,
    /// The number of these frames in which the limb is not at its goal. The reason is that the limb is too short or too
    /// long, or that the goal comes within reach or goes out of reach near this frame.
    pub out_of_reach: usize,
    /// The largest distance between the limb and its goal in these frames.
    pub farthest: f32,
    /// The frame in which this distance is largest.
    pub farthest_frame: usize,
    /// The largest distance by which the step moved the tip of the limb.
    pub moved: f32,
}

impl std::fmt::Display for LimbReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let moved = centimetres(self.moved);
        match self.out_of_reach {
            0 => write!(
                f,
                "reached in all {} frames, within {:.2} mm",
                self.frames,
                1e3 * self.farthest
            )?,
            out => {
                let farthest = centimetres(self.farthest);
                write!(
                    f,
                    "out of reach in {out} of {} frames, by {farthest} at most, in frame {}",
                    self.frames, self.farthest_frame
                )?;
            }
        }
        write!(f, "; moved by {moved} at most")
    }
}

/// When a goal comes within reach or goes out of reach, the elbow or knee would jump. So rotations are smoothed over
/// this time before and after that frame, in seconds.
const PASSING: f64 = 0.2;

/// The solution for one frame: the limb at its goal, and the position of its tip before the step.
struct HeldLimb {
    frame: usize,
    /// The fraction of the solution that is applied, from 0 to 1.
    weight: f32,
    goal: Vec3,
    before: Vec3,
    /// The rotations of the joints relative to their parents when the limb is at the goal.
    rotations: Vec<Quat>,
    /// The remaining distance from the goal, in units of the scene.
    left: f32,
}

/// Brings a chain to its goal in the frames of `window`. `goal` computes the goal from the pose of a frame. `frames`
/// must store the joints of the chain.
pub(super) fn hold(
    scene: &Scene,
    frames: &mut Frames,
    chain: &Chain,
    window: &Window,
    goal: impl Fn(&Pose) -> Vec3,
) -> LimbReport {
    let mut pose = Pose::rest(scene);
    let metres_per_unit = chain.metres_per_unit as f32;
    let planes = chain
        .limb
        .as_ref()
        .map(|limb| planes(scene, frames, limb, window, &goal));
    let mut solved: Vec<HeldLimb> = Vec::new();
    for (index, (frame, weight)) in window.frames(frames.len()).enumerate() {
        frames.pose(frame, &mut pose);
        let (goal, before) = (goal(&pose), pose.position(chain.tip));
        let left = match (&chain.limb, &planes) {
            (Some(limb), Some(planes)) => limb.bring(&mut pose, goal, planes[index]),
            _ => chain.bend(&mut pose, goal),
        };
        solved.push(HeldLimb {
            frame,
            weight,
            goal,
            before,
            rotations: chain
                .joints
                .iter()
                .map(|node| rotation_to_parent(&pose, *node))
                .collect(),
            left,
        });
    }
    pass_over(&mut solved, frames.rate, REACHED / metres_per_unit);
    let mut report = LimbReport::default();
    for of_frame in &solved {
        for (&node, &rotation) in chain.joints.iter().zip(&of_frame.rotations) {
            let Some(old) = frames.get(of_frame.frame, node) else {
                continue;
            };
            let rotation = in_hemisphere_of(old.rotation, rotation);
            let rotation = match of_frame.weight {
                1.0 => rotation,
                weight => old.rotation.slerp(rotation, weight).normalize(),
            };
            frames.set(of_frame.frame, node, Trs { rotation, ..old });
        }
        frames.pose(of_frame.frame, &mut pose);
        report.add(of_frame, pose.position(chain.tip), metres_per_unit);
    }
    report
}

impl LimbReport {
    /// Combines this report with the report of another range of frames.
    pub(super) fn append(&mut self, other: &Self) {
        self.frames += other.frames;
        self.out_of_reach += other.out_of_reach;
        self.moved = self.moved.max(other.moved);
        if other.farthest > self.farthest {
            (self.farthest, self.farthest_frame) = (other.farthest, other.farthest_frame);
        }
    }

    /// Adds one frame to the report. `now` is the position of the tip after the step.
    fn add(&mut self, of_frame: &HeldLimb, now: Vec3, metres_per_unit: f32) {
        self.moved = self.moved.max(of_frame.before.distance(now) * metres_per_unit);
        if of_frame.weight < 1.0 {
            return;
        }
        let left = of_frame.goal.distance(now) * metres_per_unit;
        self.frames += 1;
        self.out_of_reach += usize::from(left > REACHED);
        if left > self.farthest {
            (self.farthest, self.farthest_frame) = (left, of_frame.frame);
        }
    }
}

fn rotation_to_parent(pose: &Pose, node: NodeId) -> Quat {
    Trs::from_matrix(pose.node_to_parent[node.index()]).rotation.normalize()
}

/// The standard deviation in seconds of the Gaussian that smooths the plane of a limb over time.
const CALM: f64 = 0.25;

/// A Gaussian over frames.
struct Bell {
    deviation: f32,
    /// The number of frames before the middle, and of frames after it, that have a weight.
    radius: usize,
}

impl Bell {
    fn new(seconds: f64, rate: f64) -> Self {
        let deviation = ((seconds * rate) as f32).clamp(1e-3, LONGEST_BELL);
        Self {
            deviation,
            radius: (3.0 * deviation).ceil() as usize,
        }
    }

    /// The frames around the frame `at`, each with its weight. The motion has `count` frames.
    fn around(&self, at: usize, count: usize) -> impl Iterator<Item = (usize, f32)> + use<'_> {
        let others = at.saturating_sub(self.radius)..(at + self.radius + 1).min(count);
        others.map(move |other| {
            let far = at.abs_diff(other) as f32 / self.deviation;
            (other, (-0.5 * far * far).exp())
        })
    }

    /// The frames around the frame `at` within the standard deviation. The motion has `count` frames.
    fn near(&self, at: usize, count: usize) -> std::ops::Range<usize> {
        let radius = self.deviation.round() as usize;
        at.saturating_sub(radius)..(at + radius + 1).min(count)
    }

    /// The weighted mean of the values of the frames around the frame `at`. The motion has `count` frames.
    fn mean_of<T>(&self, count: usize, at: usize, value: impl Fn(usize) -> T) -> T
    where
        T: Default + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
    {
        let (mut sum, mut total) = (T::default(), 0.0);
        for (other, part) in self.around(at, count) {
            sum = sum + value(other) * part;
            total += part;
        }
        sum * (1.0 / total)
    }

    /// The weighted mean of the rotations of the frames around the frame `at`.
    fn mean(&self, rotations: &[Quat], at: usize) -> Quat {
        let own = rotations[at];
        let turn = |other: usize| log(own.inverse() * rotations[other]);
        (own * exp(self.mean_of(rotations.len(), at, turn))).normalize()
    }
}

/// The largest standard deviation in frames. With this limit, the running time is proportional to the number of frames.
const LONGEST_BELL: f32 = 500.0;

/// The plane in which a limb bends, for each frame of `window`: the most natural plane, and the angle from this plane
/// to the limb's plane.
///
/// The most natural plane depends on the trunk and on the direction of the goal. Both are smoothed over time, because
/// the elbow or knee would enlarge a jump of the trunk or of the direction.
fn planes(
    scene: &Scene,
    frames: &Frames,
    chain: &LimbChain,
    window: &Window,
    goal: impl Fn(&Pose) -> Vec3,
) -> Vec<(NaturalBend, f32)> {
    let mut pose = Pose::rest(scene);
    let numbers: Vec<usize> = window.frames(frames.len()).map(|(frame, _)| frame).collect();
    let (mut trunks, mut to_goals) = (Vec::new(), Vec::new());
    for frame in &numbers {
        frames.pose(*frame, &mut pose);
        trunks.push(chain.trunk(&pose));
        to_goals.push(chain.to_goal(&pose, goal(&pose)));
    }
    let bell = Bell::new(CALM, frames.rate);
    let natural = |at: usize| {
        chain.natural(
            bell.mean(&trunks, at),
            bell.mean_of(to_goals.len(), at, |other| to_goals[other]),
        )
    };
    let naturals: Vec<NaturalBend> = (0..numbers.len()).map(natural).collect();
    let swivels = numbers.iter().zip(&naturals).map(|(frame, natural)| {
        frames.pose(*frame, &mut pose);
        chain.swivel(&pose, goal(&pose), *natural)
    });
    let swivels: Vec<Swivel> = swivels.collect();
    naturals.into_iter().zip(calm(&swivels, &bell)).collect()
}

/// The smoothed angle of the limb's plane in each frame. The angle is averaged over time in frames in which the goal is
/// far from the limb. For example, an arm that is brought to the head does not keep its swing.
fn calm(swivels: &[Swivel], bell: &Bell) -> Vec<f32> {
    // Adds whole turns to the angle so that the angle is nearest to the last known angle. Unknown angles are skipped,
    // because they are arbitrary, and could shift the next angles by a whole turn.
    let mut reference = 0.0;
    let unwrapped = swivels.iter().map(|swivel| {
        let angle = swivel.angle + ((reference - swivel.angle) / TAU).round() * TAU;
        if swivel.known > 0.0 {
            reference = angle;
        }
        angle
    });
    let angles: Vec<f32> = unwrapped.collect();
    let mean = |at: usize| {
        // If no angle is known, the result is 0.
        let (mut sum, mut total) = (0.0, 1e-3);
        for (other, part) in bell.around(at, swivels.len()) {
            sum += part * swivels[other].known * angles[other];
            total += part * swivels[other].known;
        }
        sum / total
    };
    // Uses the smallest `detail` of the frames around each frame. Otherwise, the swing of a limb would be visible while
    // the limb is near its goal for a short time.
    let details: Vec<f32> = swivels.iter().map(|swivel| swivel.detail * swivel.known).collect();
    let least = |at: usize| {
        bell.near(at, details.len())
            .fold(1.0, |least: f32, other| least.min(details[other]))
    };
    let least: Vec<f32> = (0..details.len()).map(least).collect();
    let of_frame = |at: usize| {
        let (mean, detail) = (mean(at), bell.mean_of(least.len(), at, |other| least[other]));
        mean + detail * (angles[at] - mean)
    };
    (0..swivels.len()).map(of_frame).collect()
}

/// Smooths the rotations around each frame in which a goal comes within reach or goes out of reach. A rotation becomes
/// the mean of the rotations of the frames around it, with Gaussian weights.
fn pass_over(solved: &mut [HeldLimb], rate: f64, reached: f32) {
    let radius = (PASSING * rate).round().max(1.0) as usize;
    let bell = Bell::new(0.25 * PASSING, rate);
    let is_out: Vec<bool> = solved.iter().map(|of_frame| of_frame.left > reached).collect();
    let moments: Vec<usize> = (1..solved.len()).filter(|at| is_out[*at] != is_out[at - 1]).collect();
    let mut nearest = vec![usize::MAX; solved.len()];
    for moment in moments {
        let around = moment.saturating_sub(radius)..(moment + radius).min(solved.len());
        around.for_each(|at| nearest[at] = nearest[at].min(moment.abs_diff(at)));
    }
    let count = solved.first().map_or(0, |of_frame| of_frame.rotations.len());
    let of_joint = |joint: usize| solved.iter().map(move |of_frame| of_frame.rotations[joint]).collect();
    let joints: Vec<Vec<Quat>> = (0..count).map(of_joint).collect();
    for (at, of_frame) in solved.iter_mut().enumerate().filter(|(at, _)| nearest[*at] < radius) {
        // Within half of `radius`, the mean replaces the rotation completely.
        let part = 2.0 * nearest[at] as f32 / radius as f32 - 1.0;
        let weight = 1.0 - ease(part.clamp(0.0, 1.0));
        for (rotation, all) in of_frame.rotations.iter_mut().zip(&joints) {
            *rotation = rotation
                .slerp(in_hemisphere_of(*rotation, bell.mean(all, at)), weight)
                .normalize();
        }
    }
}
