//! The motion of one clip in metres with +Y up: positions of all nodes in the world, and rotations relative to the
//! parents. The positions and rotations are computed once, and every measure reads them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Index;

use glam::{Quat, Vec3};

use mocap_edit::report::DetectedContacts;
use mocap_figure::Figure;
use mocap_scene::error::Result;
use mocap_scene::limits::{FrameBudget, Limits};
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, HumanoidBone as Bone, Node, NodeId, NodeKind, Scene};

/// The largest step of a node at rest, in metres: the rounding error of text with four decimals.
const STILL: f32 = 2e-5;

/// The motion of one clip.
pub(crate) struct Motion<'a> {
    /// Frames per second.
    pub(crate) rate: f64,
    pub(crate) frames: usize,
    /// The first frame of the motion: 1 if frame 0 is a rest pose from which the motion jumps away, else 0.
    pub(crate) first: usize,
    /// The first frame in which defects are searched: after rest poses and a T-pose at the beginning of the clip.
    pub(super) starts: usize,
    /// Whether each frame repeats the previous frame: no joint moves.
    pub(super) held: Vec<bool>,
    /// Whether each node is a part of a finger, of the toes or of the face.
    pub(super) is_detail: Vec<bool>,
    pub(crate) names: Vec<String>,
    pub(crate) parents: Vec<Option<usize>>,
    /// Whether the file can animate each node.
    pub(crate) is_joint: Vec<bool>,
    /// The joint at the start of the bone that ends in each node; `None` for the root, and below joints that only place
    /// the figure.
    pub(crate) bones: Vec<Option<usize>>,
    /// Positions, frame by frame, with `width` columns each.
    positions: Vec<Vec3>,
    /// The number of columns.
    width: usize,
    /// The column of each node. A node that is always at the position of its parent shares the parent's column.
    columns: Vec<usize>,
    /// The rotations of each node relative to its parent. If the animation has a key at every frame, the rotations are
    /// the keys.
    rotations: Vec<Cow<'a, [Quat]>>,
    /// The rotation from the axes of the file to +Y up.
    up: Quat,
    /// The body, if the figure is a humanoid.
    pub(crate) body: Option<Body>,
}

/// The body of a humanoid.
pub(crate) struct Body {
    #[doc(hidden)]
    pub bones: BTreeMap<Bone, usize>,
    pub(crate) contacts: DetectedContacts,
    /// The length from a hip through the knee to the ankle, in metres.
    #[doc(hidden)]
    pub leg: f32,
}

/// The rotations of all nodes in a frame, relative to their parents.
pub(crate) struct Rotations<'a> {
    of_nodes: &'a [Cow<'a, [Quat]>],
    frame: usize,
}

impl Index<usize> for Rotations<'_> {
    type Output = Quat;

    fn index(&self, node: usize) -> &Quat {
        match &*self.of_nodes[node] {
            [constant] => constant,
            rotations => &rotations[self.frame],
        }
    }
}

impl<'a> Motion<'a> {
    /// The motion of an animation of `scene`.
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] if the motion has more values than the limits allow.
    pub(crate) fn new(scene: &Scene, animation: &'a Animation, figure: &Figure) -> Result<Self> {
        let mut contacts = match figure.humanoid.found && animation.duration >= 0.0 {
            true => mocap_edit::contacts_of(scene, animation, figure)?,
            false => DetectedContacts::default(),
        };
        // Frees the positions of the contacts, because the motion has the same positions.
        for point in &mut contacts.points {
            point.positions = Vec::new();
        }
        let mut motion = Self::without_contacts(scene, animation, figure)?;
        if let Some(body) = &mut motion.body {
            body.contacts = contacts;
        }
        Ok(motion)
    }

    /// The motion of an animation, without contacts of the body.
    pub(super) fn without_contacts(scene: &Scene, animation: &'a Animation, figure: &Figure) -> Result<Self> {
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
        let at_rest = |node: &Node| Cow::Owned(vec![node.transform.to_scale_rotation_translation().1]);
        let mut rotations: Vec<Cow<'a, [Quat]>> = scene.nodes.iter().map(at_rest).collect();
        let mut is_constant = vec![true; nodes];
        for (node, channel) in binding.driven() {
            let keys = &animation.channels[channel].rotation_keys;
            let is_every_frame =
                keys.ticks.is_none() && keys.len() >= frames && animation.duration + 1.0 >= frames as f64;
            is_constant[node.index()] = keys.len() < 2;
            rotations[node.index()] = match keys.len() > 1 && is_every_frame {
                true => Cow::Borrowed(&keys.values[..]),
                false => Cow::Owned(Vec::new()),
            };
        }
        let (columns, owners) = columns(scene, animation, &binding);
        let mut positions = Vec::with_capacity(frames * owners.len());
        for frame in 0..frames {
            binding.sample(animation, frame as f64, |node, trs| {
                pose.node_to_parent[node.index()] = trs.matrix();
                if let Cow::Owned(rotations) = &mut rotations[node.index()]
                    && (frame == 0 || !is_constant[node.index()])
                {
                    rotations.push(trs.rotation);
                }
            });
            pose.update_world();
            let world = owners.iter().map(|node| pose.node_to_world[*node]);
            positions.extend(world.map(|matrix| up * (matrix.w_axis.truncate() * metres)));
        }
        let places = figure.placing(scene);
        let parents = || scene.nodes.iter().map(|node| node.parent.map(NodeId::index));
        let mut motion = Self {
            rate: animation.ticks_per_second,
            frames,
            first: usize::from(figure.survey.first_frame_is_rest_pose && frames > 1),
            starts: 0,
            held: vec![false; frames],
            is_detail: vec![false; nodes],
            names: scene.nodes.iter().map(|node| node.name.clone()).collect(),
            parents: parents().collect(),
            bones: parents()
                .map(|parent| parent.filter(|parent| !places[*parent]))
                .collect(),
            is_joint: scene.nodes.iter().map(|node| node.kind == NodeKind::Joint).collect(),
            positions,
            width: owners.len(),
            columns,
            rotations,
            up,
            body: None,
        };
        if figure.humanoid.found && frames > 0 {
            let bones = figure
                .humanoid
                .bones
                .iter()
                .map(|(bone, joint)| (*bone, joint.joint.index()));
            motion.body = Body::new(&motion, bones.collect());
        }
        for frame in 1..frames {
            let pairs = motion.row(frame - 1).iter().zip(motion.row(frame));
            let step = pairs.fold(0.0, |most: f32, (a, b)| most.max((*a - *b).abs().max_element()));
            motion.held[frame] = frame > motion.first && step < STILL;
        }
        if let Some(body) = &motion.body {
            let ends = [
                Bone::LeftHand,
                Bone::RightHand,
                Bone::LeftFoot,
                Bone::RightFoot,
                Bone::Head,
            ];
            let ends = ends.map(|bone| body.bones.get(&bone).copied());
            for node in 0..nodes {
                let parent = motion.parents[node];
                let is_below = parent.is_some_and(|parent| motion.is_detail[parent] || ends.contains(&Some(parent)));
                motion.is_detail[node] = is_below;
            }
        }
        motion.starts = motion.first;
        Ok(motion)
    }

    pub(crate) fn nodes(&self) -> usize {
        self.names.len()
    }

    pub(crate) fn at(&self, frame: usize, node: usize) -> Vec3 {
        self.positions[frame * self.width + self.columns[node]]
    }

    /// The positions of a frame, by column.
    fn row(&self, frame: usize) -> &[Vec3] {
        &self.positions[frame * self.width..(frame + 1) * self.width]
    }

    /// The rotations of all nodes in a frame, relative to their parents.
    pub(crate) fn rotations(&self, frame: usize) -> Rotations<'_> {
        Rotations {
            of_nodes: &self.rotations,
            frame,
        }
    }

    /// The rotation of a node relative to the world.
    pub(crate) fn to_world(&self, frame: usize, node: usize) -> Quat {
        let above = std::iter::successors(Some(node), |node| self.parents[*node]);
        let rotations = self.rotations(frame);
        self.up * above.fold(Quat::IDENTITY, |below, node| rotations[node] * below)
    }

    /// The duration of all frames, in seconds.
    pub(crate) fn seconds(&self) -> f64 {
        match self.rate > 0.0 {
            true => self.frames as f64 / self.rate,
            false => 0.0,
        }
    }

    /// Whether no joint moves by more than the rounding and noise of sensors at rest: 1 mm or 1 degree.
    pub(super) fn is_still(&self) -> bool {
        let first = self.first.min(self.frames.saturating_sub(1));
        let is_near = |frame: usize| {
            let places = self.row(frame).iter().zip(self.row(first));
            let (here, there) = (self.rotations(frame), self.rotations(first));
            let mut turns = (0..self.nodes()).map(|node| here[node].dot(there[node]).abs());
            places.fold(0.0, |most: f32, (a, b)| most.max(a.distance(*b))) < 1e-3
                && turns.all(|cosine| cosine > 0.99996)
        };
        (first..self.frames).all(is_near)
    }

    /// The vertical acceleration of a node in m/s^2, from a parabola through the frames `half` before and after.
    pub(super) fn rise(&self, frame: usize, node: usize, half: usize) -> f32 {
        let middle = frame.clamp(half, (self.frames - 1).saturating_sub(half).max(half));
        if middle + half >= self.frames {
            return 0.0;
        }
        let at = |frame: usize| self.at(frame, node).y;
        let seconds = half as f32 / self.rate as f32;
        (at(middle + half) + at(middle - half) - 2.0 * at(middle)) / (seconds * seconds)
    }

    /// The number of frames in a time, at least 1.
    pub(crate) fn frames_in(&self, seconds: f64) -> usize {
        ((seconds * self.rate).round() as usize).max(1)
    }

    /// The position of a bone.
    pub(crate) fn bone(&self, body: &Body, frame: usize, bone: Bone) -> Option<Vec3> {
        Some(self.at(frame, *body.bones.get(&bone)?))
    }

    /// The size of the skeleton: the sum of the lengths of all bones at the first frame.
    pub(crate) fn size(&self) -> f32 {
        let length = |node: usize| self.bones[node].map(|parent| self.at(0, node).distance(self.at(0, parent)));
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

/// The column of the positions of each node, and the node of each column.
fn columns(scene: &Scene, animation: &Animation, binding: &Binding) -> (Vec<usize>, Vec<usize>) {
    let at_rest = |node: &Node| node.transform.w_axis.truncate() == Vec3::ZERO;
    let mut is_at_parent: Vec<bool> = scene.nodes.iter().map(at_rest).collect();
    for (node, channel) in binding.driven() {
        match animation.channels[channel].position_keys.values.as_slice() {
            [] => {}
            keys => is_at_parent[node.index()] = keys.iter().all(|key| *key == Vec3::ZERO),
        }
    }
    let (mut columns, mut owners): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
    for (index, node) in scene.nodes.iter().enumerate() {
        match node.parent.filter(|_| is_at_parent[index]) {
            Some(parent) => columns.push(columns[parent.index()]),
            None => {
                columns.push(owners.len());
                owners.push(index);
            }
        }
    }
    (columns, owners)
}

impl Body {
    fn new(motion: &Motion, bones: BTreeMap<Bone, usize>) -> Option<Self> {
        let at = |bone| Some(motion.at(0, *bones.get(&bone)?));
        let [hip, knee, ankle] = [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot].map(at);
        bones.get(&Bone::Hips)?;
        let leg = hip?.distance(knee?) + knee?.distance(ankle?);
        let contacts = DetectedContacts::default();
        (leg > 0.0).then_some(Self { bones, contacts, leg })
    }

    pub(crate) fn hips(&self) -> usize {
        self.bones[&Bone::Hips]
    }

    /// The least height of a point of the feet above its resting height in a frame, in metres.
    pub(crate) fn lowest_foot(&self, frame: usize) -> f32 {
        let points = self.contacts.points.iter();
        let heights = points.filter_map(|point| point.above_rest.get(frame).copied());
        heights.fold(f32::INFINITY, f32::min)
    }

    /// The facing of the body: horizontal, of length 1, or zero if the hips are not upright at all.
    pub(crate) fn forward(&self, motion: &Motion, frame: usize) -> Vec3 {
        let pair = |left, right| Some(motion.bone(self, frame, left)? - motion.bone(self, frame, right)?);
        let left = pair(Bone::LeftUpperLeg, Bone::RightUpperLeg).unwrap_or_default();
        left.cross(Vec3::Y).normalize_or_zero()
    }

    /// The direction from the hips to the neck, or to the head: of length 1.
    pub(crate) fn trunk(&self, motion: &Motion, frame: usize) -> Vec3 {
        let top = motion
            .bone(self, frame, Bone::Neck)
            .or_else(|| motion.bone(self, frame, Bone::Head));
        let hips = motion.at(frame, self.hips());
        top.map_or(Vec3::Y, |top| (top - hips).normalize_or(Vec3::Y))
    }
}
