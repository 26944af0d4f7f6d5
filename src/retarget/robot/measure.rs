//! Measures a motion on a robot: the heights and speeds of its soles, and the directions of its bones.

use glam::{DQuat, DVec3, Quat, Vec3};
use mocap_figure::robot_bones::sole::lowest_point;
use mocap_scene::scene::robot::Placement;
use mocap_scene::scene::{Animation, Channel, HumanoidBone as Bone, Keys, NodeId, Scene};

use super::collision::Collisions;
use super::following::SolverGoals;
use super::kinematics::{Kinematics, RobotPose};
use super::motion::RobotMotion;
use super::terms::Goals;
use super::twin::{StandIn, StandInBone};
use crate::PoseRetargeter;
use mocap_figure::LimbAngles;

/// The time in which a lift above the floor starts and ends, in seconds.
pub(super) const LIFT: f64 = 0.15;

/// The depth of a link below the floor that counts as contact, in metres. Capsules are less exact than soles.
const TOUCHING: f64 = 0.01;

/// The speed above which a sole in stance skates, in m/s: a sixth of a slow walk.
const SKATES: f64 = 0.1;

/// The height of the lowest point of a sole in the air below which it scrapes the floor, in metres: the height of
/// seams and rugs.
const SCRAPES_BELOW: f64 = 0.005;

/// The speed of the lowest point of a sole above which the sole scrapes, in m/s. Slower soles land or push off.
const SCRAPES_ABOVE: f64 = 0.3;

/// The mean sliding speed of the slowest point of a sole in stance. The slowest point counts, because a foot may roll.
/// Soles in the air scrape the floor with their lowest point.
pub(super) struct SoleSpeed<const FEET: usize> {
    fps: f64,
    before: [Vec<DVec3>; FEET],
    sum: f64,
    count: usize,
    fastest: f64,
    skating: usize,
    swinging: usize,
    scraping: usize,
}

/// Whether a foot is in stance, or in the air, in a frame and in the previous frame.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum FootPhase {
    Stance,
    Swing,
    /// The frame is the first frame, or only one of the two frames is in stance.
    Between,
}

impl FootPhase {
    pub(super) fn new(before: Option<bool>, stands: bool) -> Self {
        match (before, stands) {
            (Some(true), true) => Self::Stance,
            (Some(false), false) => Self::Swing,
            _ => Self::Between,
        }
    }
}

impl<const FEET: usize> SoleSpeed<FEET> {
    pub(super) fn new(fps: f64) -> Self {
        Self {
            fps,
            before: std::array::from_fn(|_| Vec::new()),
            sum: 0.0,
            count: 0,
            fastest: 0.0,
            skating: 0,
            swinging: 0,
            scraping: 0,
        }
    }

    /// Adds the points of a sole in the next frame, +Z up.
    pub(super) fn add(&mut self, foot: usize, points: Vec<DVec3>, phase: FootPhase) {
        let steps = points.iter().zip(&self.before[foot]);
        let speed = |(to, from): (&DVec3, &DVec3)| to.truncate().distance(from.truncate()) * self.fps;
        match phase {
            FootPhase::Stance => {
                let speed = steps.map(speed).fold(f64::INFINITY, f64::min);
                self.sum += speed;
                self.count += 1;
                self.fastest = self.fastest.max(speed);
                self.skating += usize::from(speed > SKATES);
            }
            FootPhase::Swing => {
                let lowest = steps.min_by(|(_, a), (_, b)| a.z.total_cmp(&b.z));
                let scrapes = lowest.is_some_and(|step| step.1.z < SCRAPES_BELOW && speed(step) > SCRAPES_ABOVE);
                self.swinging += 1;
                self.scraping += usize::from(scrapes);
            }
            FootPhase::Between => {}
        }
        self.before[foot] = points;
    }

    /// The fraction of steps in the air that scrape the floor; `None` if no foot is in the air.
    pub(super) fn fraction_scraping(&self) -> Option<f64> {
        (self.swinging > 0).then(|| self.scraping as f64 / self.swinging as f64)
    }

    /// The largest speed.
    pub(super) fn fastest(&self) -> f64 {
        self.fastest
    }

    /// The fraction of samples that skate.
    pub(super) fn fraction_skating(&self) -> Option<f64> {
        self.mean().map(|_| self.skating as f64 / self.count as f64)
    }

    /// The mean speed; `None` if no foot is in stance.
    pub(super) fn mean(&self) -> Option<f64> {
        let mean = (self.count > 0).then(|| self.sum / self.count as f64);
        mean.filter(|speed| speed.is_finite())
    }
}

/// A motion on a robot.
#[derive(Clone, Copy)]
pub(super) struct Measured<'a> {
    pub(super) kinematics: &'a Kinematics,
    pub(super) twin: &'a StandIn,
    pub(super) motion: &'a RobotMotion,
    /// The heading of the source in each frame, for a robot with a fixed base.
    pub(super) headings: &'a [DQuat],
}

impl Measured<'_> {
    /// The height of the lowest point of each sole in each frame.
    pub(super) fn sole_heights(&self) -> Vec<[f64; 2]> {
        let feet = [Bone::LeftFoot, Bone::RightFoot].map(|bone| self.twin.bone(bone).map(|bone| bone.link));
        let mut pose = self.kinematics.rest();
        let frames = (0..self.motion.frames()).map(|frame| {
            self.pose(frame, &mut pose);
            [0, 1].map(|side| {
                let Some(link) = feet[side] else { return f64::INFINITY };
                lowest_point(&self.twin.soles[side], &self.kinematics.link(&pose, link))
            })
        });
        frames.collect()
    }

    /// The depth below the floor of the deepest link, except the feet, in each frame.
    pub(super) fn depths(&self, collisions: &Collisions) -> Vec<f64> {
        let feet = [Bone::LeftFoot, Bone::RightFoot].map(|bone| self.twin.bone(bone));
        let feet: Vec<usize> = feet
            .into_iter()
            .flatten()
            .map(|bone| self.kinematics.body_of(bone.link).0)
            .collect();
        let mut pose = self.kinematics.rest();
        let frames = (0..self.motion.frames()).map(|frame| {
            self.pose(frame, &mut pose);
            collisions.depth_below_floor(&pose, &feet)
        });
        frames.collect()
    }

    /// The smooth raise of the robot in each frame. With this raise, no sole is below the floor, and no link is deeper
    /// than [`TOUCHING`].
    pub(super) fn raised(&self, collisions: &Collisions) -> Vec<f64> {
        let soles = self.sole_heights().into_iter();
        let links = self.depths(collisions).into_iter();
        let heights = soles
            .zip(links)
            .map(|([left, right], depth)| left.min(right).min(TOUCHING - depth));
        raised(&heights.collect::<Vec<f64>>(), self.motion.fps)
    }

    /// The raise that only the links need.
    pub(super) fn raised_by_links(&self, collisions: &Collisions) -> Vec<f64> {
        let links = self.depths(collisions).into_iter();
        let heights = links.map(|depth| TOUCHING - depth);
        raised(&heights.collect::<Vec<f64>>(), self.motion.fps)
    }

    /// The mean roll of thighs and upper arms against their goals in degrees, and the fraction of frames in which the
    /// hips of the source lie.
    pub(super) fn roll(&self, following: &SolverGoals, goals: &[Goals]) -> (Option<f64>, f64) {
        let mut pose = self.kinematics.rest();
        let (mut sum, mut count, mut lying) = (0.0, 0_usize, 0_usize);
        for (frame, goals) in goals.iter().enumerate() {
            self.pose(frame, &mut pose);
            if let Some(roll) = following.roll(goals, &pose) {
                (sum, count) = (sum + roll, count + 1);
            }
            lying += usize::from(following.is_lying(goals));
        }
        let mean = (count > 0).then(|| (sum / count as f64).to_degrees());
        (mean, lying as f64 / goals.len().max(1) as f64)
    }

    /// The speeds of soles, while the foot of the source is in contact and while it is in the air.
    pub(super) fn soles(&self) -> SoleSpeed<2> {
        let feet = [Bone::LeftFoot, Bone::RightFoot].map(|bone| self.twin.bone(bone).map(|bone| bone.link));
        let mut pose = self.kinematics.rest();
        let mut speed = SoleSpeed::<2>::new(self.motion.fps);
        for frame in 0..self.motion.frames() {
            self.pose(frame, &mut pose);
            for (side, link) in feet.into_iter().enumerate() {
                let Some(link) = link else { continue };
                let foot = self.kinematics.link(&pose, link);
                let points = self.twin.soles[side].iter().map(|ball| ball.bottom(&foot));
                let stands = |frame: usize| self.motion.contacts[frame][side];
                let phase = FootPhase::new(frame.checked_sub(1).map(stands), stands(frame));
                speed.add(side, points.collect(), phase);
            }
        }
        speed
    }

    /// The motion of the robot as a motion of the twin, with the twin's joints at the positions of the robot's joints.
    pub(super) fn as_twin(&self) -> Animation {
        let nodes = &self.twin.scene.nodes;
        let frames = self.motion.frames();
        let to_figure = self.twin.figure_to_world.inverse();
        let mut by_node: Vec<Option<(Vec<Vec3>, Vec<Quat>)>> = vec![None; nodes.len()];
        let mut pose = self.kinematics.rest();
        let mut world = vec![Placement::IDENTITY; nodes.len()];
        let mut driven = vec![false; nodes.len()];
        self.twin.bones.iter().for_each(|bone| driven[bone.node.index()] = true);
        self.twin
            .tips
            .iter()
            .for_each(|(node, _, _)| driven[node.index()] = true);
        for frame in 0..frames {
            self.pose(frame, &mut pose);
            let to_figure = to_figure * self.headings.get(frame).copied().unwrap_or(DQuat::IDENTITY);
            for StandInBone {
                node,
                link,
                link_to_frame,
                start,
                ..
            } in &self.twin.bones
            {
                let transform = self.kinematics.link(&pose, *link);
                world[node.index()] = Placement {
                    rotation: (to_figure * transform.rotation * link_to_frame.inverse()).normalize(),
                    translation: to_figure * transform.point(*start),
                };
            }
            for (node, link, point) in &self.twin.tips {
                let transform = self.kinematics.link(&pose, *link);
                let parent = nodes[node.index()].parent.map_or(0, NodeId::index);
                world[node.index()] = Placement {
                    rotation: world[parent].rotation,
                    translation: to_figure * transform.point(*point),
                };
            }
            for (index, node) in nodes.iter().enumerate().filter(|(index, _)| driven[*index]) {
                let parent = node.parent.map_or(Placement::IDENTITY, |parent| world[parent.index()]);
                let (positions, rotations) = by_node[index].get_or_insert_with(Default::default);
                positions.push(parent.to_inner(world[index].translation).as_vec3());
                rotations.push(
                    (parent.rotation.inverse() * world[index].rotation)
                        .normalize()
                        .as_quat(),
                );
            }
        }
        let channels = by_node.into_iter().enumerate().filter_map(|(index, tracks)| {
            let (positions, rotations) = tracks?;
            Some(Channel {
                node_name: nodes[index].name.clone(),
                node: Some(NodeId::new(index)),
                position_keys: Keys::every_tick(positions),
                rotation_keys: Keys::every_tick(rotations),
                scaling_keys: Keys::constant(Vec3::ONE),
            })
        });
        Animation {
            name: self.motion.name.clone(),
            ticks_per_second: self.motion.fps,
            duration: frames.saturating_sub(1) as f64,
            channels: channels.collect(),
        }
    }

    /// The angles of the reported limbs, frame by frame. Each limb starts at a link, a node of
    /// [`robot_scene`](crate::robot::robot_scene).
    pub(super) fn limb_angles(
        &self,
        retargeter: &PoseRetargeter,
        source: &Scene,
        animation: &Animation,
    ) -> Vec<LimbAngles> {
        let twin = self.twin;
        let limbs = retargeter.limb_angles(source, animation, &twin.scene, &self.as_twin());
        let on_link = |limb: LimbAngles| {
            let bone = twin.bones.iter().find(|bone| bone.node == limb.node)?;
            let node = NodeId::new(bone.link);
            Some(LimbAngles { node, ..limb })
        };
        let limbs = limbs.into_iter().filter(|limb| twin.has_legs || !limb.bone.is_of_leg());
        limbs.filter_map(on_link).collect()
    }

    fn pose(&self, frame: usize, pose: &mut RobotPose) {
        self.motion.set(frame, self.kinematics, pose);
    }
}

/// The heights of soles while the foot of the source is in contact.
pub(super) fn standing<const FEET: usize>(heights: &[[f64; FEET]], contacts: &[[bool; FEET]]) -> Vec<f64> {
    let of_frame = |(heights, stands): (&[f64; FEET], &[bool; FEET])| std::iter::zip(*heights, *stands);
    let feet = std::iter::zip(heights, contacts).flat_map(of_frame);
    feet.filter(|(_, stands)| *stands).map(|(height, _)| height).collect()
}

/// The smooth raise of a robot with these lowest soles in each frame, so that no sole is below the floor.
pub(super) fn raised(lowest: &[f64], fps: f64) -> Vec<f64> {
    let half = (0.5 * LIFT * fps).ceil().min(1e6) as usize;
    let window = |frame: usize| frame.saturating_sub(half)..(frame + half + 1).min(lowest.len());
    // The maximum of a window, then the mean of the maxima: at least the needed raise, and without a jump.
    let largest: Vec<f64> = (0..lowest.len())
        .map(|frame| lowest[window(frame)].iter().map(|height| -height).fold(0.0, f64::max))
        .collect();
    let mean = |frame: usize| {
        let near = &largest[window(frame)];
        near.iter().sum::<f64>() / near.len().max(1) as f64
    };
    (0..lowest.len()).map(mean).collect()
}
