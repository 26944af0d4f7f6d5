//! A limb that is brought to a goal in a part of a motion.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};
use serde::Serialize;

use super::frames::Frames;
use super::inertia::ease;
use super::limb::{LimbChain, Swivel};
use super::quantity::centimetres;
use super::window::Window;
use crate::math::quaternion::{exp, in_hemisphere_of, log};
use crate::pose::{Pose, Trs};
use crate::scene::{NodeId, Scene};

/// A distance from the goal that is none, in metres: a tenth of what counts as reached.
const REACHED: f32 = 1e-4;

/// How a limb was brought to its goals. Lengths are in metres.
///
/// [`Reach`](crate::edit::Reach) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LimbReport {
    /// The frames in which the limb is to be at its goal.
    pub frames: usize,
    /// Those of them in which it is not there: the limb is too short or too long, or passes over to where it is.
    pub out_of_reach: usize,
    /// The largest distance that is left in these frames.
    pub farthest: f32,
    /// The frame in which it is left.
    pub farthest_frame: usize,
    /// The largest change of the position of what goes to the goal.
    pub moved: f32,
}

impl std::fmt::Display for LimbReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let moved = centimetres(self.moved);
        match self.out_of_reach {
            0 => write!(
                f,
                "reached in all {} frames, to {:.2} mm",
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

/// Seconds around the moment at which a goal comes within reach or leaves it, in which the limb passes over from the
/// one to the other: at once, its elbow or knee would jump.
const PASSING: f64 = 0.2;

/// The frames of a limb that is brought to its goal, and what it is brought from.
struct Solved {
    frame: usize,
    /// The fraction of the change that counts.
    weight: f32,
    goal: Vec3,
    before: Vec3,
    /// The rotations of the joints to their parents at the goal.
    rotations: [Quat; 3],
    /// How far from the goal they leave the limb, in units of the scene.
    left: f32,
}

/// Brings a limb to its goal in the frames of a window; `goal` gives it from the pose of a frame. The joints of the
/// limb are among the nodes that `frames` hold.
pub(super) fn hold(
    scene: &Scene,
    frames: &mut Frames,
    chain: &LimbChain,
    window: &Window,
    metres_per_unit: f32,
    goal: impl Fn(&Pose) -> Vec3,
) -> LimbReport {
    let mut pose = Pose::rest(scene);
    let trunks = window.frames(frames.len()).map(|(frame, _)| {
        frames.pose(frame, &mut pose);
        chain.trunk(&pose)
    });
    let trunks: Vec<Quat> = trunks.collect();
    let bell = Bell::new(CALM, frames.rate);
    let trunks: Vec<Quat> = (0..trunks.len()).map(|at| bell.mean(&trunks, at)).collect();
    let swivels = window.frames(frames.len()).zip(&trunks).map(|((frame, _), trunk)| {
        frames.pose(frame, &mut pose);
        chain.swivel(&pose, goal(&pose), *trunk)
    });
    let swivels: Vec<Swivel> = swivels.collect();
    let planes = trunks.into_iter().zip(calm(&swivels, &bell));
    let mut solved: Vec<Solved> = Vec::new();
    for ((frame, weight), swivel) in window.frames(frames.len()).zip(planes) {
        frames.pose(frame, &mut pose);
        let (goal, before) = (goal(&pose), pose.position(chain.tip));
        let left = chain.bring(&mut pose, goal, swivel);
        solved.push(Solved {
            frame,
            weight,
            goal,
            before,
            rotations: chain.joints().map(|node| rotation_to_parent(&pose, node)),
            left,
        });
    }
    pass_over(&mut solved, frames.rate, REACHED / metres_per_unit);
    let mut report = LimbReport::default();
    for of_frame in &solved {
        for (node, rotation) in chain.joints().into_iter().zip(of_frame.rotations) {
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
    /// Takes in what was done in another part.
    pub(super) fn append(&mut self, other: &Self) {
        self.frames += other.frames;
        self.out_of_reach += other.out_of_reach;
        self.moved = self.moved.max(other.moved);
        if other.farthest > self.farthest {
            (self.farthest, self.farthest_frame) = (other.farthest, other.farthest_frame);
        }
    }

    /// Takes in a frame whose tip is at `now`.
    fn add(&mut self, of_frame: &Solved, now: Vec3, metres_per_unit: f32) {
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

/// The standard deviation in seconds of the Gaussian that takes from the plane of a limb what it does from frame to
/// frame.
const CALM: f64 = 0.25;

/// A Gaussian over frames.
struct Bell {
    deviation: f32,
    /// The frames on either side that count.
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

    /// The frames around one of `count`, each with its weight.
    fn around(&self, at: usize, count: usize) -> impl Iterator<Item = (usize, f32)> + use<'_> {
        let others = at.saturating_sub(self.radius)..(at + self.radius + 1).min(count);
        others.map(move |other| {
            let far = at.abs_diff(other) as f32 / self.deviation;
            (other, (-0.5 * far * far).exp())
        })
    }

    /// The mean of the rotations around one.
    fn mean(&self, rotations: &[Quat], at: usize) -> Quat {
        let own = rotations[at];
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        for (other, part) in self.around(at, rotations.len()) {
            sum += part * log(own.inverse() * rotations[other]);
            total += part;
        }
        (own * exp(sum / total)).normalize()
    }
}

/// Frames of a standard deviation at most, so that the time is no product of two numbers of frames.
const LONGEST_BELL: f32 = 500.0;

/// The angles of the plane of a limb, from frame to frame. Where it goes far, they are the means of what is around: how
/// an arm swung does not matter to one that holds the head.
fn calm(swivels: &[Swivel], bell: &Bell) -> Vec<f32> {
    let mut angles: Vec<f32> = Vec::with_capacity(swivels.len());
    for swivel in swivels {
        let before = angles.last().copied().unwrap_or(0.0);
        let turns = ((before - swivel.angle) / TAU).round();
        angles.push(swivel.angle + turns * TAU);
    }
    let mean = |at: usize| {
        // Where nothing is known the angle goes to 0.
        let (mut sum, mut total) = (0.0, 1e-3);
        for (other, part) in bell.around(at, swivels.len()) {
            sum += part * swivels[other].known * angles[other];
            total += part * swivels[other].known;
        }
        sum / total
    };
    let of_frame = |(at, swivel): (usize, &Swivel)| {
        let (mean, detail) = (mean(at), swivel.detail * swivel.known);
        mean + detail * (angles[at] - mean)
    };
    swivels.iter().enumerate().map(of_frame).collect()
}

/// Rounds off the moments at which a goal comes within reach or leaves it: there each rotation is the mean of those
/// around it, weighted by a Gaussian.
fn pass_over(solved: &mut [Solved], rate: f64, reached: f32) {
    let radius = (PASSING * rate).round().max(1.0) as usize;
    let bell = Bell::new(0.25 * PASSING, rate);
    let is_out: Vec<bool> = solved.iter().map(|of_frame| of_frame.left > reached).collect();
    let moments: Vec<usize> = (1..solved.len()).filter(|at| is_out[*at] != is_out[at - 1]).collect();
    let mut nearest = vec![usize::MAX; solved.len()];
    for moment in moments {
        let around = moment.saturating_sub(radius)..(moment + radius).min(solved.len());
        around.for_each(|at| nearest[at] = nearest[at].min(moment.abs_diff(at)));
    }
    let joints = [0, 1, 2].map(|joint| Vec::from_iter(solved.iter().map(|of_frame| of_frame.rotations[joint])));
    for (at, of_frame) in solved.iter_mut().enumerate().filter(|(at, _)| nearest[*at] < radius) {
        // In the inner half nothing of the moment itself is left.
        let part = 2.0 * nearest[at] as f32 / radius as f32 - 1.0;
        let weight = 1.0 - ease(part.clamp(0.0, 1.0));
        for (rotation, all) in of_frame.rotations.iter_mut().zip(&joints) {
            *rotation = rotation
                .slerp(in_hemisphere_of(*rotation, bell.mean(all, at)), weight)
                .normalize();
        }
    }
}
