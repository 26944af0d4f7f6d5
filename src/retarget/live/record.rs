//! Converts packets to a scene.

use std::collections::BTreeMap;

use glam::{Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{
    Animation, Channel, Face, Format, HumanoidBone as Bone, Keys, Node, NodeId, NodeKind, Scene, UpAxis,
};

use super::clock::{FrameTime, seconds_of};
use super::vmc::{BonePose, Said, messages};

/// The largest number of rotations and positions of a recording: 90 minutes of 55 bones at 60 frames per second, in
/// less than a gigabyte.
const MOST_KEYS: usize = 18_000_000;

/// The counts of received messages.
///
/// The [module](crate::live) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct VmcCounts {
    /// Packets.
    pub packets: u64,
    /// Packets that are not OSC, and VMC messages with wrong arguments.
    pub malformed: u64,
    /// Values of blend shapes.
    pub blend_shapes: u64,
    /// Messages that are not about a body: cameras, lights, trackers, bones that no humanoid has.
    pub others: u64,
    /// Frames.
    pub frames: usize,
}

/// Makes a scene from VMC packets.
///
/// The [module](crate::live) has an example.
///
/// A frame ends when a bone, or the clock, arrives for the second time. The length of each bone comes from the first
/// frame with the bone. Only the hips have translation. The motion of the root is added to the hips.
#[derive(Debug, Default)]
pub struct VmcRecorder {
    counts: VmcCounts,
    frames: Vec<FrameTime>,
    root: Option<BonePose>,
    bones: BTreeMap<Bone, Track>,
    face: Vec<FaceTrack>,
    keys: usize,
}

/// The largest number of blend shapes of a recording. Characters have some dozens, and face trackers 52.
const MOST_SHAPES: usize = 1024;
/// The largest length of a blend shape's name, in bytes.
const LONGEST_NAME: usize = 256;

/// The weights of a blend shape.
#[derive(Debug)]
struct FaceTrack {
    #[doc(hidden)]
    pub face: Face,
    frames: Vec<u32>,
    weights: Vec<f32>,
}

/// The keys of a bone.
#[derive(Debug, Default)]
struct Track {
    /// The offset from its parent, in the first frame with the bone.
    offset: Vec3,
    frames: Vec<u32>,
    rotations: Vec<Quat>,
    /// The positions, only for the hips.
    positions: Vec<Vec3>,
}

impl VmcRecorder {
    /// A recorder without packets yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The counts of received messages.
    pub fn counts(&self) -> VmcCounts {
        VmcCounts {
            frames: self.frames.len(),
            ..self.counts
        }
    }

    /// Whether the recording is full: its memory is limited.
    pub fn is_full(&self) -> bool {
        self.keys >= MOST_KEYS
    }

    /// Receives a packet, with its time of arrival in seconds since a fixed time. Malformed messages are counted.
    pub fn hear(&mut self, packet: &[u8], seconds: f64) {
        self.counts.packets += 1;
        let Some(messages) = messages(packet) else {
            self.counts.malformed += 1;
            return;
        };
        for said in messages {
            match said {
                Said::Time(time) => self.time(time, seconds),
                Said::Root(bone_pose) => self.root = Some(bone_pose),
                Said::Bone(bone, bone_pose) => self.bone(bone, bone_pose, seconds),
                Said::Blend(face, weight) => self.blend(face, weight),
                Said::Other => self.counts.others += 1,
                Said::Malformed => self.counts.malformed += 1,
            }
        }
    }

    fn time(&mut self, time: f64, seconds: f64) {
        if self.is_full() {
            return;
        }
        match self.frames.last_mut() {
            Some(FrameTime { sender: own @ None, .. }) => *own = Some(time),
            _ => self.frames.push(FrameTime {
                sender: Some(time),
                arrival: seconds,
            }),
        }
        self.keys += 1;
    }

    /// Weights belong to the frame in which they arrive.
    fn blend(&mut self, face: Face, weight: f32) {
        self.counts.blend_shapes += 1;
        let Some(frame) = self.frames.len().checked_sub(1).filter(|_| !self.is_full()) else {
            return;
        };
        let own = self.face.iter().position(|track| track.face == face);
        let is_kept = self.face.len() < MOST_SHAPES && face.name().len() <= LONGEST_NAME;
        let index = match own {
            Some(index) => index,
            None if is_kept => {
                self.face.push(FaceTrack {
                    face,
                    frames: Vec::new(),
                    weights: Vec::new(),
                });
                self.face.len() - 1
            }
            None => {
                self.counts.others += 1;
                return;
            }
        };
        let track = &mut self.face[index];
        if track.frames.last() == Some(&(frame as u32)) {
            track.frames.pop();
            track.weights.pop();
        }
        track.frames.push(frame as u32);
        track.weights.push(weight);
        self.keys += 1;
    }

    /// Sets the first frame of a stream.
    pub(super) fn first_frame(&mut self, bones: &BTreeMap<Bone, BonePose>, root: Option<BonePose>) {
        self.root = root;
        bones.iter().for_each(|(bone, pose)| self.bone(*bone, *pose, 0.0));
    }

    fn bone(&mut self, bone: Bone, mut bone_pose: BonePose, seconds: f64) {
        if self.is_full() {
            return;
        }
        let track = self.bones.entry(bone).or_insert_with(|| Track {
            offset: bone_pose.position,
            ..Track::default()
        });
        let last = self.frames.len().checked_sub(1);
        let is_again = track.frames.last().map(|frame| *frame as usize) == last;
        if is_again || last.is_none() {
            self.frames.push(FrameTime {
                sender: None,
                arrival: seconds,
            });
        }
        track.frames.push((self.frames.len() - 1) as u32);
        if bone == Bone::Hips {
            bone_pose = bone_pose.below(self.root);
            track.positions.push(bone_pose.position);
        }
        track.rotations.push(bone_pose.rotation);
        self.keys += 1;
    }

    /// The recording: a node for each received bone, in metres with +Y up, without rotations in the T-pose. Warnings
    /// state the jumps of the sender's clock.
    ///
    /// # Errors
    /// [`Code::NoMotion`] if no bone was received.
    pub fn scene(self) -> Result<Scene> {
        if !self.bones.contains_key(&Bone::Hips) {
            let message = "no humanoid pose was received: /VMC/Ext/Bone/Pos of the hips is missing";
            return Err(Diagnostic::new(Code::NoMotion, message)
                .help("set the sender to send bones to this address and port, and check the firewall")
                .into());
        }
        let (times, jumps) = seconds_of(&self.frames);
        let (rate, ticks) = ticks_of(&times);
        let nodes = self.nodes();
        let channels = nodes.iter().filter_map(|node| self.channel(node, &ticks));
        let mut scene = Scene {
            animations: vec![Animation {
                name: "Motion".to_owned(),
                ticks_per_second: rate,
                duration: ticks.last().copied().unwrap_or(0.0),
                channels: channels.collect(),
            }],
            ..Scene::default()
        };
        for (index, channel) in scene.animations[0].channels.iter_mut().enumerate() {
            channel.node = Some(NodeId::new(index));
        }
        scene.nodes = nodes;
        self.add_face(&mut scene, &ticks);
        scene.warnings.extend(jumps);
        // As in a VRM animation, the rest pose counts as the T-pose, whatever its shape.
        scene.metadata.format = Some(Format::Vrma);
        scene.metadata.metres_per_unit = Some(1.0);
        scene.metadata.up = Some(UpAxis::Y);
        Ok(scene)
    }

    /// Adds the blend shapes that are not always 0, and the gaze. The gaze is the rotation of the eyes, because a VRM
    /// animation has no eye bones.
    fn add_face(&self, scene: &mut Scene, ticks: &[f64]) {
        let times = |frames: &[u32]| -> Vec<f64> { frames.iter().map(|frame| ticks[*frame as usize]).collect() };
        let still = Channel {
            position_keys: Keys::constant(Vec3::ZERO),
            rotation_keys: Keys::constant(Quat::IDENTITY),
            scaling_keys: Keys::constant(Vec3::ONE),
            ..Channel::default()
        };
        for track in self
            .face
            .iter()
            .filter(|track| track.weights.iter().any(|weight| *weight != 0.0))
        {
            let positions = track.weights.iter().map(|weight| *weight * Vec3::X).collect();
            let keys = Channel {
                position_keys: Keys::at_ticks(positions, times(&track.frames)),
                ..still.clone()
            };
            add_face_node(scene, track.face.clone(), keys);
        }
        let eyes = [Bone::LeftEye, Bone::RightEye].map(|eye| self.bones.get(&eye));
        if let (Some(eye), other) = (eyes[0].or(eyes[1]), eyes[1].or(eyes[0])) {
            let middle = other.map_or(eye.offset, |other| 0.5 * (eye.offset + other.offset));
            let keys = Channel {
                rotation_keys: Keys::at_ticks(eye.rotations.clone(), times(&eye.frames)),
                ..still
            };
            let offset_from_head = Some(middle);
            add_face_node(scene, Face::LookAt { offset_from_head }, keys);
        }
    }

    /// The bones depth-first, each with its nearest received ancestor.
    fn nodes(&self) -> Vec<Node> {
        let has = |bone: &Bone| self.bones.contains_key(bone);
        let parent = |bone: Bone| std::iter::successors(bone.parent(), |above| above.parent()).find(has);
        let mut at_rest: BTreeMap<Bone, (NodeId, Vec3)> = BTreeMap::new();
        let mut nodes: Vec<Node> = Vec::new();
        let mut open = vec![Bone::Hips];
        while let Some(bone) = open.pop() {
            let above = parent(bone).and_then(|parent| at_rest.get(&parent).copied());
            let offset = if above.is_some() {
                self.bones[&bone].offset
            } else {
                Vec3::ZERO
            };
            let bone_pose = above.map_or(Vec3::ZERO, |(_, bone_pose)| bone_pose) + offset;
            at_rest.insert(bone, (NodeId::new(nodes.len()), bone_pose));
            nodes.push(Node {
                name: bone.as_str().to_owned(),
                parent: above.map(|(node, _)| node),
                transform: Mat4::from_translation(offset),
                humanoid_bone: Some(bone),
                ..Node::default()
            });
            let children = Bone::ALL.iter().rev().copied();
            open.extend(children.filter(|child| has(child) && parent(*child) == Some(bone)));
        }
        // In the T-pose, the lowest bone, a foot, is on the ground.
        let lowest = at_rest.values().map(|(_, bone_pose)| bone_pose.y).fold(0.0, f32::min);
        nodes[0].transform = Mat4::from_translation(-lowest * Vec3::Y);
        nodes
    }

    fn channel(&self, node: &Node, ticks: &[f64]) -> Option<Channel> {
        let track = self.bones.get(&node.humanoid_bone?)?;
        let times: Vec<f64> = track.frames.iter().map(|frame| ticks[*frame as usize]).collect();
        Some(Channel {
            node_name: node.name.clone(),
            node: None,
            position_keys: match track.positions.is_empty() {
                true => Keys::constant(node.transform.w_axis.truncate()),
                false => Keys::at_ticks(track.positions.clone(), times.clone()),
            },
            rotation_keys: Keys::at_ticks(track.rotations.clone(), times),
            scaling_keys: Keys::constant(Vec3::ONE),
        })
    }
}

/// Adds a node of a face as a child of the first node, with its keys.
fn add_face_node(scene: &mut Scene, face: Face, keys: Channel) {
    let id = NodeId::new(scene.nodes.len());
    scene.nodes.push(Node {
        name: face.name().to_owned(),
        kind: NodeKind::Group,
        parent: Some(NodeId(0)),
        face: Some(face),
        ..Node::default()
    });
    scene.animations[0].channels.push(Channel {
        node_name: scene.nodes[id.index()].name.clone(),
        node: Some(id),
        ..keys
    });
}

/// The frames per second, and the tick of each frame: the next free tick, so that network jitter drops no frame.
fn ticks_of(times: &[f64]) -> (f64, Vec<f64>) {
    /// The frame rate of most senders, in Hz, for a recording with a single frame.
    const USUAL: f64 = 60.0;
    /// The largest difference of a step from the median, as a fraction of the median. A larger step has a missing
    /// frame, and is not averaged.
    const NEAR: f64 = 0.5;

    /// The largest difference of a rate from a whole number at which the whole number is used, as a fraction. The
    /// clocks of senders deviate less.
    const WHOLE: f64 = 2e-3;
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.retain(|step| *step > 1e-6);
    // The mean is used, because late packets and the rounding of a 32-bit clock shift the median.
    steps.sort_unstable_by(f64::total_cmp);
    let median = steps
        .get(steps.len().saturating_sub(1) / 2)
        .copied()
        .unwrap_or_default();
    steps.retain(|step| (step - median).abs() < NEAR * median);
    let rate = match steps.len() {
        0 => USUAL,
        count => count as f64 / steps.iter().sum::<f64>(),
    };
    let rate = match (rate - rate.round()).abs() < WHOLE * rate && rate >= 1.0 {
        true => rate.round(),
        false => rate,
    };
    let mut ticks: Vec<f64> = Vec::with_capacity(times.len());
    for time in times {
        let tick = ((time - times[0]) * rate).round();
        ticks.push(ticks.last().map_or(0.0, |last| f64::max(last + 1.0, tick)));
    }
    (rate, ticks)
}
