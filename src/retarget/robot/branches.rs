//! Searches other branches of a limb's solution. The three hinges of a shoulder can point the arm in one direction with
//! several sets of angles. Each frame starts from the angles of the previous frame, even if these lead into a corner of
//! the limits. The hinges of a hip have the same problem if a leg is crossed or raised.
//!
//! A limb with a large error is solved again: backwards from the last frame, and from the worst frames. There, other
//! starting angles are tried, forwards and backwards. Each frame takes the best of these tracks. A change of joints has
//! a cost, so the path changes from one track to another where both tracks agree. The path is the shortest path by
//! dynamic programming (R. Bellman, 1957).

use glam::DVec3;
use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::kinematics::{Kinematics, RobotPose};
use super::motion::RobotMotion;
use super::solver::{Bounds, Solver};
use super::terms::{Goals, Terms};
use super::twin::StandIn;
use super::weights::Weights;

/// The mean cost of a limb over a `WINDOW` above which the limb is solved again, in rad^2. It is a direction with an
/// error of 20 degrees, which is visible.
pub const SUSPECT: f64 = 0.12;

/// The time over which the cost of a limb is averaged, in seconds. A fast motion also causes an error, but for a
/// shorter time.
const WINDOW: f64 = 0.2;

/// The number of worst frames of a limb in which other starting angles are tried. Each needs a pass over all frames.
const SEEDS: usize = 3;

/// The smallest time between two of the worst frames, in seconds. Nearer frames have the same cause.
const APART: f64 = 0.5;

/// The fraction of the cost of a limb below which other starting angles are followed. A smaller gain is not worth a
/// pass.
const BETTER: f64 = 0.6;

/// The number of solver steps for new starting angles: half as many as for a first frame, because only one limb is
/// solved.
const FIRST_STEPS: usize = 60;

/// The number of solver steps for each further frame, as in the first pass.
const STEPS: usize = 8;

/// The frame rate in Hz to which `branch_change` of [`Weights`] applies.
const RATE: f64 = 30.0;

/// An arm or a leg: its goals, and the positions of its joints.
#[derive(Clone, Debug)]
pub struct Limb {
    rotations: Vec<usize>,
    /// The body of a leg's foot, whose position goals count too.
    pub foot: Option<usize>,
    pub positions: Vec<usize>,
    solver: Solver,
    weights: Weights,
}

/// The arms and legs of a robot.
#[derive(Clone, Debug)]
pub struct Branches {
    pub limbs: Vec<Limb>,
}

/// The bones of an arm and of a leg.
const LIMBS: [[Bone; 3]; 2] = [
    [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand],
    [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot],
];

/// The frames in which limbs may change to another branch.
pub struct Free<'a> {
    pub goals: &'a [Goals],
    pub bounds: &'a Bounds,
    /// The first frame that may change.
    pub from: usize,
    /// The number of frames that are not known yet. The cost of the last known frame is multiplied by this number plus
    /// 1, because the following frames probably have the same cost.
    pub ahead: usize,
}

/// The positions of a limb in every frame, with the cost of each frame.
pub struct Track {
    pub positions: Vec<Vec<f64>>,
    pub costs: Vec<f64>,
}

impl Branches {
    pub fn new(kinematics: &Kinematics, twin: &StandIn, weights: &Weights) -> Self {
        let bones = LIMBS
            .iter()
            .flat_map(|bones| Side::ALL.map(|side| bones.map(|bone| bone.on(side))));
        let limbs = bones.map(|bones| Limb::new(kinematics, twin, bones, weights));
        Self {
            limbs: limbs.filter(|limb| !limb.positions.is_empty()).collect(),
        }
    }

    /// Chooses the best path for each limb. Returns the positions of limbs that changed to another branch.
    pub fn choose(&mut self, kinematics: &Kinematics, free: &Free<'_>, motion: &mut RobotMotion) -> Vec<usize> {
        let mut changed = Vec::new();
        for limb in &mut self.limbs {
            if limb.choose(kinematics, free, motion) {
                changed.extend(&limb.positions);
            }
        }
        changed
    }
}

impl Limb {
    fn new(kinematics: &Kinematics, twin: &StandIn, bones: [Bone; 3], weights: &Weights) -> Self {
        let found = twin.bones.iter().enumerate();
        let found = found.filter(|(_, bone)| bones.contains(&bone.bone));
        let rotations: Vec<usize> = found.clone().map(|(turn, _)| turn).collect();
        let mut used = vec![false; kinematics.bodies.len() - 1];
        for joint in found.clone().flat_map(|(_, bone)| &bone.joints) {
            used[kinematics.body_of(*joint).0 - 1] = true;
        }
        let mut feet = found.filter(|(_, bone)| bone.bone.on(Side::Left) == Bone::LeftFoot);
        Self {
            rotations,
            foot: feet.next().map(|(_, bone)| kinematics.body_of(bone.link).0),
            positions: (0..used.len()).filter(|position| used[*position]).collect(),
            solver: Solver::new(Terms::of_positions(kinematics, used, 0), weights.hold),
            weights: *weights,
        }
    }

    /// Chooses the best path. Returns whether the limb changed to another branch.
    fn choose(&mut self, kinematics: &Kinematics, free: &Free<'_>, motion: &mut RobotMotion) -> bool {
        // The last fixed frame comes first, because the limb is followed from it.
        let first = free.from.saturating_sub(1);
        let goals: Vec<Goals> = free.goals[first..].iter().map(|goals| self.own(goals)).collect();
        let as_it_is = self.track(kinematics, &goals, motion, first);
        let suspects = suspects(&as_it_is.costs, motion.fps);
        if suspects.is_empty() {
            return false;
        }
        let mut follow = Follow {
            limb: self,
            kinematics,
            goals: &goals,
            bounds: free.bounds,
            motion,
            first,
        };
        let mut tracks = Vec::new();
        if let Some(last) = as_it_is.positions.last().cloned() {
            tracks.push(follow.both_ways(goals.len() - 1, last));
        }
        for frame in suspects {
            let begun = follow.begin(frame);
            if let Some((_, begun)) = begun.filter(|(cost, _)| *cost < BETTER * as_it_is.costs[frame]) {
                tracks.push(follow.both_ways(frame, begun));
            }
        }
        if free.from > 0 {
            tracks.iter_mut().for_each(|track| track.costs[0] = f64::INFINITY);
        }
        tracks.insert(0, as_it_is);
        for track in &mut tracks {
            track
                .costs
                .last_mut()
                .into_iter()
                .for_each(|cost| *cost *= 1.0 + free.ahead as f64);
        }
        let chosen = shortest(&tracks, self.weights.branch_change * motion.fps / RATE);
        if chosen.iter().all(|track| *track == 0) {
            return false;
        }
        let count = motion.dof_names.len();
        let mut pose = kinematics.rest();
        for (frame, track) in chosen.into_iter().enumerate() {
            let here = first + frame;
            for (at, value) in self.positions.iter().zip(&tracks[track].positions[frame]) {
                motion.dof_pos[here * count + at] = *value;
            }
            if !kinematics.followers.is_empty() {
                motion.set(here, kinematics, &mut pose);
                motion.dof_pos[here * count..(here + 1) * count].copy_from_slice(&pose.positions);
            }
        }
        true
    }

    /// The track of the limb in a motion, starting at the frame `first`.
    pub fn track(&self, kinematics: &Kinematics, goals: &[Goals], motion: &RobotMotion, first: usize) -> Track {
        let mut pose = kinematics.rest();
        let costs = goals.iter().enumerate().map(|(frame, goals)| {
            motion.set(first + frame, kinematics, &mut pose);
            cost(goals, &pose, &self.weights)
        });
        let of = |frame: usize| self.positions.iter().map(|at| motion.dof_of(frame)[*at]).collect();
        Track {
            costs: costs.collect(),
            positions: (first..first + goals.len()).map(of).collect(),
        }
    }

    /// The goals of this limb only.
    pub fn own(&self, goals: &Goals) -> Goals {
        let reaches = goals.reaches.iter().filter(|reach| self.foot == Some(reach.body));
        Goals {
            rotations: self
                .rotations
                .iter()
                .map(|turn| goals.rotations[*turn].clone())
                .collect(),
            reaches: reaches.cloned().collect(),
            ..Goals::default()
        }
    }
}

/// Follows a limb. The other joints of the robot keep the angles of a motion.
pub struct Follow<'a> {
    pub limb: &'a mut Limb,
    pub kinematics: &'a Kinematics,
    pub goals: &'a [Goals],
    pub bounds: &'a Bounds,
    pub motion: &'a RobotMotion,
    /// The index in the motion of the first frame of `goals`.
    pub first: usize,
}

impl Follow<'_> {
    /// Solves the limb in a frame from starting angles, and returns its cost.
    pub fn solve(&mut self, frame: usize, positions: &mut [f64], steps: usize) -> f64 {
        let mut pose = self.kinematics.rest();
        pose.root = self.motion.root[self.first + frame];
        pose.positions.copy_from_slice(self.motion.dof_of(self.first + frame));
        for (at, value) in self.limb.positions.iter().zip(positions.iter()) {
            pose.positions[*at] = *value;
        }
        let goals = &self.goals[frame];
        self.limb
            .solver
            .solve(self.kinematics, goals, self.bounds, &mut pose, steps);
        for (at, value) in self.limb.positions.iter().zip(positions) {
            *value = pose.positions[*at];
        }
        cost(goals, &pose, &self.limb.weights)
    }

    /// The best of several starting angles in a frame: joints near 0, in the middle of their limits, and a quarter of
    /// the range to either side.
    fn begin(&mut self, frame: usize) -> Option<(f64, Vec<f64>)> {
        let ranges: Vec<[f64; 2]> = self
            .limb
            .positions
            .iter()
            .map(|at| [self.bounds.lower[*at], self.bounds.upper[*at]].map(|limit| limit.clamp(-3.2, 3.2)))
            .collect();
        let along = |fraction: f64| {
            ranges
                .iter()
                .map(move |[low, high]| low + fraction * (high - low))
                .collect()
        };
        let rest = ranges.iter().map(|[low, high]| 0.0_f64.max(*low).min(*high)).collect();
        let starts: [Vec<f64>; 4] = [rest, along(0.5), along(0.25), along(0.75)];
        let ends = starts.map(|mut positions| (self.solve(frame, &mut positions, FIRST_STEPS), positions));
        ends.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The track of a limb that has the angles `begun` in the frame `frame`. The limb is followed from this frame
    /// forwards and backwards.
    fn both_ways(&mut self, frame: usize, begun: Vec<f64>) -> Track {
        let frames = self.goals.len();
        let mut track = Track {
            positions: vec![begun.clone(); frames],
            costs: vec![0.0; frames],
        };
        let mut here = begun.clone();
        for at in (0..=frame).rev() {
            track.costs[at] = self.solve(at, &mut here, STEPS);
            track.positions[at].clone_from(&here);
        }
        here = begun;
        for at in frame + 1..frames {
            track.costs[at] = self.solve(at, &mut here, STEPS);
            track.positions[at].clone_from(&here);
        }
        track
    }
}

/// The deviation of a pose from its goals, in weighted rad^2.
fn cost(goals: &Goals, pose: &RobotPose, weights: &Weights) -> f64 {
    let rotations = goals.rotations.iter().map(|turn| {
        let rotation = pose.bodies[turn.body].rotation;
        let apart = rotation_vector(turn.target * rotation.inverse());
        let along = (rotation * turn.weight_axes).inverse() * apart;
        (turn.weights * along * along).element_sum()
    });
    let places = goals.reaches.iter().map(|reach| {
        let apart = reach.target - pose.bodies[reach.body].point(reach.point);
        (reach.weight.min(DVec3::splat(weights.branch_place)) * apart * apart).element_sum()
    });
    rotations.sum::<f64>() + places.sum::<f64>()
}

/// The worst frames of a limb whose error is large for some time.
pub fn suspects(costs: &[f64], fps: f64) -> Vec<usize> {
    let half = (0.5 * WINDOW * fps).ceil().min(costs.len() as f64) as usize;
    let mean = |frame: usize| {
        let near = &costs[frame.saturating_sub(half)..(frame + half + 1).min(costs.len())];
        near.iter().sum::<f64>() / near.len() as f64
    };
    let mut bad: Vec<(usize, f64)> = (0..costs.len()).map(|frame| (frame, mean(frame))).collect();
    bad.retain(|(_, mean)| *mean > SUSPECT);
    bad.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut found: Vec<usize> = Vec::new();
    for (frame, _) in bad {
        if found.len() < SEEDS && found.iter().all(|other| other.abs_diff(frame) as f64 > APART * fps) {
            found.push(frame);
        }
    }
    found
}

/// The chosen track in each frame.
pub fn shortest(tracks: &[Track], change: f64) -> Vec<usize> {
    let frames = tracks.first().map_or(0, |track| track.costs.len());
    let mut sums: Vec<f64> = tracks
        .iter()
        .map(|track| track.costs.first().copied().unwrap_or(0.0))
        .collect();
    // For each frame after the first, the previous track on the shortest path to each track.
    let mut from: Vec<Vec<usize>> = Vec::with_capacity(frames);
    for frame in 1..frames {
        let (mut next, mut came) = (Vec::with_capacity(tracks.len()), Vec::with_capacity(tracks.len()));
        for track in tracks {
            let step = |other: usize| {
                let pairs = tracks[other].positions[frame - 1].iter().zip(&track.positions[frame]);
                sums[other] + change * pairs.map(|(was, is)| (is - was).powi(2)).sum::<f64>()
            };
            let best = (0..tracks.len()).map(|other| (other, step(other)));
            let (other, sum) = best.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
            came.push(other);
            next.push(sum + track.costs[frame]);
        }
        from.push(came);
        sums = next;
    }
    let mut here = (0..sums.len())
        .min_by(|a, b| sums[*a].total_cmp(&sums[*b]))
        .unwrap_or(0);
    let mut chosen = vec![here; frames];
    for frame in (1..frames).rev() {
        chosen[frame] = here;
        here = from[frame - 1][here];
    }
    if let Some(first) = chosen.first_mut() {
        *first = here;
    }
    chosen
}
