//! The motion of one clip in metres with +Y up: positions of all nodes in the world and rotations to the parents, made
//! once and read by every measure.

use std::collections::{BTreeMap, BTreeSet};

use glam::{Quat, Vec3};

use mocap_edit::report::DetectedContacts;
use mocap_figure::Figure;
use mocap_figure::contacts::ContactRule;
use mocap_scene::error::Result;
use mocap_scene::limits::{FrameBudget, Limits};
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, HumanoidBone as Bone, NodeId, NodeKind, Scene};

/// The speed in m/s below which a foot stands: in a swing it is ten times as fast.
const SLOW: f32 = 0.2;

/// The distance in metres of two levels of the floor: noise of a foot that stands is less.
const ANOTHER_FLOOR: f32 = 0.03;

/// The shortest time for which somebody stands who does not turn while running, in seconds.
const A_STAND: f64 = 1.0;
/// Half the time of the shortest step of a run, in seconds.
const A_STEP: f64 = 0.1;

/// The motion of one clip.
pub(crate) struct Motion {
    /// Frames per second.
    pub(crate) rate: f64,
    pub(crate) frames: usize,
    /// The first frame of the motion: 1 where frame 0 is a rest pose from which the motion jumps away.
    pub(crate) first: usize,
    pub(crate) names: Vec<String>,
    pub(crate) parents: Vec<Option<usize>>,
    /// Whether the file can animate the node.
    pub(crate) is_joint: Vec<bool>,
    /// Frames x nodes.
    positions: Vec<Vec3>,
    /// Frames x nodes: node to parent.
    rotations: Vec<Quat>,
    /// From the axes of the file to +Y up.
    up: Quat,
    /// The body, where it is a humanoid.
    pub(crate) body: Option<Body>,
}

/// What of the nodes is a body.
pub(crate) struct Body {
    #[doc(hidden)]
    pub bones: BTreeMap<Bone, usize>,
    pub(crate) contacts: DetectedContacts,
    /// From a hip through the knee to the ankle, in metres.
    #[doc(hidden)]
    pub leg: f32,
}

impl Motion {
    /// The motion of an animation of `scene`.
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] where it has more values than the limits allow.
    pub(crate) fn new(scene: &Scene, animation: &Animation, figure: &Figure) -> Result<Self> {
        let nodes = scene.nodes.len();
        let stated: usize = animation
            .channels
            .iter()
            .map(|channel| channel.rotation_keys.len())
            .sum();
        let frames =
            FrameBudget::stated_by(&Limits::default(), stated as u64).frames(animation.duration.round(), nodes)?;
        let metres = figure.metres();
        let up = Quat::from_rotation_arc(figure.up_direction(), Vec3::Y);
        let binding = Binding::new(scene, animation);
        let mut pose = Pose::rest(scene);
        let mut locals: Vec<Quat> = scene
            .nodes
            .iter()
            .map(|node| node.transform.to_scale_rotation_translation().1)
            .collect();
        let mut positions = Vec::with_capacity(frames * nodes);
        let mut rotations = Vec::with_capacity(frames * nodes);
        for frame in 0..frames {
            binding.sample(animation, frame as f64, |node, trs| {
                pose.node_to_parent[node.index()] = trs.matrix();
                locals[node.index()] = trs.rotation;
            });
            pose.update_world();
            let world = pose.node_to_world.iter();
            positions.extend(world.map(|matrix| up * (matrix.w_axis.truncate() * metres)));
            rotations.extend_from_slice(&locals);
        }
        let mut motion = Self {
            rate: animation.ticks_per_second,
            frames,
            first: usize::from(figure.survey.first_frame_is_rest_pose && frames > 1),
            names: scene.nodes.iter().map(|node| node.name.clone()).collect(),
            parents: scene.nodes.iter().map(|node| node.parent.map(NodeId::index)).collect(),
            is_joint: scene.nodes.iter().map(|node| node.kind == NodeKind::Joint).collect(),
            positions,
            rotations,
            up,
            body: None,
        };
        if figure.humanoid.found && frames > 0 {
            let contacts = mocap_edit::contacts_of(scene, animation, figure)?;
            let bones = figure
                .humanoid
                .bones
                .iter()
                .map(|(bone, joint)| (*bone, joint.joint.index()));
            motion.body = Body::new(&motion, bones.collect(), contacts);
        }
        Ok(motion)
    }

    pub(crate) fn nodes(&self) -> usize {
        self.names.len()
    }

    pub(crate) fn at(&self, frame: usize, node: usize) -> Vec3 {
        self.positions[frame * self.nodes() + node]
    }

    /// All positions of a frame.
    pub(crate) fn row(&self, frame: usize) -> &[Vec3] {
        &self.positions[frame * self.nodes()..(frame + 1) * self.nodes()]
    }

    /// All rotations of a frame, node to parent.
    pub(crate) fn rotations(&self, frame: usize) -> &[Quat] {
        &self.rotations[frame * self.nodes()..(frame + 1) * self.nodes()]
    }

    /// The rotation of a node to the world.
    pub(crate) fn to_world(&self, frame: usize, node: usize) -> Quat {
        let above = std::iter::successors(Some(node), |node| self.parents[*node]);
        let rotations = self.rotations(frame);
        self.up * above.fold(Quat::IDENTITY, |below, node| rotations[node] * below)
    }

    /// The time of all frames.
    pub(crate) fn seconds(&self) -> f64 {
        match self.rate > 0.0 {
            true => self.frames as f64 / self.rate,
            false => 0.0,
        }
    }

    /// The number of frames in a time, at least 1.
    pub(crate) fn frames_in(&self, seconds: f64) -> usize {
        ((seconds * self.rate).round() as usize).max(1)
    }

    /// The position of a bone.
    pub(crate) fn bone(&self, body: &Body, frame: usize, bone: Bone) -> Option<Vec3> {
        Some(self.at(frame, *body.bones.get(&bone)?))
    }

    /// The size of the skeleton: the lengths of all its bones at the first frame.
    pub(crate) fn size(&self) -> f32 {
        let length = |node: usize| self.parents[node].map(|parent| self.at(0, node).distance(self.at(0, parent)));
        match self.frames {
            0 => 0.0,
            _ => (0..self.nodes()).filter_map(length).sum(),
        }
    }

    /// The velocity of a node, in metres per second, by central differences over `half` frames on each side.
    pub(crate) fn velocity(&self, frame: usize, node: usize, half: usize) -> Vec3 {
        let (before, after) = (frame.saturating_sub(half), (frame + half).min(self.frames - 1));
        let seconds = (after - before).max(1) as f32 / self.rate as f32;
        (self.at(after, node) - self.at(before, node)) / seconds
    }
}

impl Body {
    fn new(motion: &Motion, bones: BTreeMap<Bone, usize>, contacts: DetectedContacts) -> Option<Self> {
        let at = |bone| Some(motion.at(0, *bones.get(&bone)?));
        let [hip, knee, ankle] = [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot].map(at);
        bones.get(&Bone::Hips)?;
        let leg = hip?.distance(knee?) + knee?.distance(ankle?);
        let mut body = Self { bones, contacts, leg };
        body.stand_on_usual_floor(motion);
        (leg > 0.0).then_some(body)
    }

    /// Takes for the floor the level on which the feet stand longest. The ground of a figure is the lowest level, on
    /// which a foot may be that has sunk into the floor.
    fn stand_on_usual_floor(&mut self, motion: &Motion) {
        /// How far from a level the feet that stand on it are, in metres.
        const BIN: f32 = 0.03;
        let half = motion.frames_in(0.05);
        let lowest = |frame: usize| {
            let points = self.contacts.points.iter();
            let heights = points.filter_map(|point| Some((*point.above_rest.get(frame)?, point.node.index())));
            heights.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let all: Vec<Option<(f32, usize)>> = (0..motion.frames).map(lowest).collect();
        let stands =
            |frame: &usize| all[*frame].is_some_and(|(_, node)| motion.velocity(*frame, node, half).length() < SLOW);
        let mut standing: Vec<usize> = (motion.first..motion.frames).filter(stands).collect();
        // Feet that run are hardly ever slow; what they step on is where the lower one is lowest. Each step counts
        // then, and not how long it lasts.
        if 2 * standing.len() < motion.frames - motion.first {
            let near = motion.frames_in(A_STEP);
            let height = |frame: usize| all[frame].map_or(f32::INFINITY, |(height, _)| height);
            let is_lowest = |frame: &usize| {
                let around = frame.saturating_sub(near)..(frame + near + 1).min(motion.frames);
                around.into_iter().all(|other| height(other) >= height(*frame))
            };
            let frames = motion.frames - motion.first;
            let is_short = 3 * standing.len() < frames && standing.len() < motion.frames_in(A_STAND);
            let is_rare = is_short || 8 * standing.len() < frames;
            let lowest = (motion.first..motion.frames).filter(is_lowest);
            standing = match is_rare {
                true => lowest.collect(),
                false => standing.into_iter().chain(lowest).collect(),
            };
        }
        let heights: Vec<f32> = standing.iter().filter_map(|frame| Some(all[*frame]?.0)).collect();
        let near = |level: f32| heights.iter().filter(move |height| (*height - level).abs() <= BIN);
        let levels = heights.iter().map(|height| (height / BIN).round() as i32);
        let levels: BTreeSet<i32> = levels.collect();
        let count = |level: &i32| near(*level as f32 * BIN).count();
        let most = levels.iter().map(count).max().unwrap_or(0);
        // A body that is lifted for long has a higher level; the floor is the lowest on which it often stands.
        let Some(level) = levels.into_iter().find(|level| 5 * count(level) >= 4 * most.max(1)) else {
            return;
        };
        let level = level as f32 * BIN;
        let shift = near(level).sum::<f32>() / near(level).count().max(1) as f32;
        if shift.abs() < ANOTHER_FLOOR {
            return;
        }
        self.contacts.floor += shift;
        for point in &mut self.contacts.points {
            point.above_rest.iter_mut().for_each(|height| *height -= shift);
            let speed = |frame: usize| {
                motion
                    .velocity(frame.min(motion.frames - 1), point.node.index(), 1)
                    .length()
            };
            let samples = point.above_rest.iter().enumerate();
            let samples = samples.map(|(frame, height)| (f64::from(*height), f64::from(speed(frame))));
            point.at_rest = ContactRule::default().at_rest(samples, motion.rate);
        }
    }

    pub(crate) fn hips(&self) -> usize {
        self.bones[&Bone::Hips]
    }

    /// The heights of the points of the feet above where they rest, in metres; the least of a frame.
    pub(crate) fn lowest_foot(&self, frame: usize) -> f32 {
        let points = self.contacts.points.iter();
        let heights = points.filter_map(|point| point.above_rest.get(frame).copied());
        heights.fold(f32::INFINITY, f32::min)
    }

    /// Where the body looks: horizontal, of length 1; zero where the hips are upright in no sense.
    pub(crate) fn forward(&self, motion: &Motion, frame: usize) -> Vec3 {
        let pair = |left, right| Some(motion.bone(self, frame, left)? - motion.bone(self, frame, right)?);
        let left = pair(Bone::LeftUpperLeg, Bone::RightUpperLeg).unwrap_or_default();
        left.cross(Vec3::Y).normalize_or_zero()
    }

    /// From the hips to the neck, or the head: of length 1.
    pub(crate) fn trunk(&self, motion: &Motion, frame: usize) -> Vec3 {
        let top = motion
            .bone(self, frame, Bone::Neck)
            .or_else(|| motion.bone(self, frame, Bone::Head));
        let hips = motion.at(frame, self.hips());
        top.map_or(Vec3::Y, |top| (top - hips).normalize_or(Vec3::Y))
    }
}
