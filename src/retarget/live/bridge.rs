//! Retargets packets to another body as they arrive.

use std::collections::BTreeMap;

use mocap_figure::vrm_humanoid;
use mocap_scene::error::{Error, Result};
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::robot::Robot;
use mocap_scene::scene::{Format, HumanoidBone as Bone, Scene};
use rosc::OscMessage;
use serde_json::json;

use super::clock::FrameTime;
use super::play::{beginning, bundles, pose_message};
use super::record::{VmcCounts, VmcRecorder};
use super::vmc::{APPLY, BonePose, STATE, Said, flat, said};
use crate::robot::{RobotOptions, RobotStream};
use crate::{PoseRetargetOptions, PoseRetargeter};

/// The largest number of messages that pass through in a packet. A figure has some hundreds.
const MOST: usize = 4096;

/// Retargets the poses of a VMC stream to another body as they arrive: packets in, packets out.
///
/// A pose is sent as soon as its frame has as many bones as the previous frame. If a bone is missing, the pose is sent
/// when the next frame begins. The first frame sets the lengths of the bones.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::live::{VmcBridge, VmcMotion};
///
/// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// mocap::Conversion::new().apply(&mut scene)?;
/// let motion = VmcMotion::new(&scene)?;
/// let hero = mocap::import("fixtures/skeletons/human_vrm1.gltf")?;
/// let mut bridge = VmcBridge::onto(&hero)?;
/// let mut poses = 0;
/// for frame in 0..60 {
///     let seconds = f64::from(frame) / 60.0;
///     for packet in motion.packets(seconds) {
///         poses += bridge.hear(&packet, seconds).len();
///     }
/// }
/// assert!(bridge.counts().frames == 60 && poses >= 60);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Debug)]
pub struct VmcBridge {
    onto: BridgeTarget,
    says: Sender,
    stage: Option<Stage>,
    /// The reason why there is no stage: the received bones do not form a body.
    problem: Option<Error>,
    /// The received bones, each with its latest and its first pose.
    bones: BTreeMap<Bone, BonePose>,
    offsets: BTreeMap<Bone, BonePose>,
    root: Option<BonePose>,
    frame: Frame,
    /// The number of bones of the previous frame.
    complete: usize,
    counts: VmcCounts,
}

/// The target of the poses.
#[derive(Debug)]
enum BridgeTarget {
    /// The skeleton of a character in the T-pose, without rotations.
    Humanoid(Box<Scene>),
    Robot(Box<Robot>),
}

/// The format of the output.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sender {
    Vmc,
    Json,
}

/// The frame that is being received.
#[derive(Debug, Default)]
struct Frame {
    came: Vec<Bone>,
    is_out: bool,
    clock: Option<f64>,
    arrival: f64,
    /// The time of the previous frame.
    before: Option<FrameTime>,
}

impl Frame {
    /// A frame without a clock continues the clock of the previous frame.
    fn time(&self) -> FrameTime {
        let time = FrameTime {
            sender: self.clock,
            arrival: self.arrival,
        };
        let before = self.before.and_then(|before| Some(before.sender? + time.since(before)));
        FrameTime {
            sender: time.sender.or(before),
            ..time
        }
    }
}

/// The retargeter of the poses, and its poses. It is made when the bones of the sender are known.
#[derive(Debug)]
struct Stage {
    from: Pose,
    nodes: BTreeMap<Bone, usize>,
    mover: Mover,
}

#[derive(Debug)]
enum Mover {
    /// For a character: the pose of its skeleton, and the node of each bone.
    Humanoid {
        retargeter: Box<PoseRetargeter>,
        to: Pose,
        bones: Vec<(Bone, usize)>,
    },
    /// For a robot, with the names of its joints.
    Robot {
        stream: Box<RobotStream>,
        dof_names: Vec<String>,
    },
}

impl VmcBridge {
    /// A bridge to a character, given its scene in metres with +Y up. The output is VMC. Messages that are not about
    /// bones, such as blend shapes, pass unchanged.
    ///
    /// # Errors
    /// The errors of [`figure::vrm_humanoid`](mocap_figure::vrm_humanoid()), if the scene has no humanoid.
    pub fn onto(character: &Scene) -> Result<Self> {
        let mut target = character.clone();
        target.animations.clear();
        let mut target = vrm_humanoid(&target, None)?;
        target.nodes.retain(|node| node.humanoid_bone.is_some());
        // As in a VRM animation, the rest pose is the T-pose.
        target.metadata.format = Some(Format::Vrma);
        Ok(Self::new(BridgeTarget::Humanoid(Box::new(target)), Sender::Vmc))
    }

    /// A bridge to a robot. The output is JSON, with a packet for each pose.
    pub fn onto_robot(robot: &Robot) -> Self {
        Self::new(BridgeTarget::Robot(Box::new(robot.clone())), Sender::Json)
    }

    /// Sends JSON instead of VMC, for a character too.
    #[must_use]
    pub fn json(mut self) -> Self {
        self.says = Sender::Json;
        self
    }

    fn new(onto: BridgeTarget, says: Sender) -> Self {
        Self {
            onto,
            says,
            stage: None,
            problem: None,
            bones: BTreeMap::new(),
            offsets: BTreeMap::new(),
            root: None,
            frame: Frame::default(),
            complete: usize::MAX,
            counts: VmcCounts::default(),
        }
    }

    /// The counts of received messages. A frame is a pose that was sent.
    pub fn counts(&self) -> VmcCounts {
        self.counts
    }

    /// The reason why no pose is sent: the sender's bones are not a body yet.
    pub fn problem(&self) -> Option<&Error> {
        self.problem.as_ref()
    }

    /// Receives a packet, with its time of arrival in seconds since a fixed time, and returns the packets that are due.
    /// Malformed messages are counted.
    pub fn hear(&mut self, packet: &[u8], seconds: f64) -> Vec<Vec<u8>> {
        self.counts.packets += 1;
        let Some(messages) = flat(packet) else {
            self.counts.malformed += 1;
            return Vec::new();
        };
        let (mut given, mut passed) = (Vec::new(), Vec::new());
        for message in messages.into_iter().take(MOST) {
            match said(&message) {
                Said::Time(time) => {
                    if self.frame.clock.is_some() || !self.frame.came.is_empty() {
                        self.end_frame(&mut given);
                    }
                    self.frame.clock = Some(time);
                }
                Said::Root(pose) => self.root = Some(pose),
                Said::Bone(bone, pose) => {
                    if self.frame.came.contains(&bone) {
                        self.end_frame(&mut given);
                    }
                    self.bone(bone, pose);
                }
                Said::Malformed => self.counts.malformed += 1,
                Said::Blend(..) => {
                    self.counts.blend_shapes += 1;
                    passed.push(message);
                }
                Said::Other => {
                    // The bridge sends its own state with each pose.
                    if message.addr != STATE {
                        self.counts.others += u64::from(message.addr != APPLY);
                        passed.push(message);
                    }
                }
            }
            if !self.frame.is_out {
                self.frame.arrival = seconds;
            }
        }
        if self.frame.came.len() >= self.complete && !self.frame.is_out {
            self.give(&mut given);
        }
        if self.says == Sender::Vmc && !passed.is_empty() {
            given.extend(bundles(passed));
        }
        given
    }

    fn bone(&mut self, bone: Bone, pose: BonePose) {
        self.frame.came.push(bone);
        self.bones.insert(bone, pose);
        if self.offsets.insert(bone, pose).is_none() {
            // Another number of bones is a different body.
            self.stage = None;
        }
    }

    fn end_frame(&mut self, given: &mut Vec<Vec<u8>>) {
        if !self.frame.is_out && !self.frame.came.is_empty() {
            self.give(given);
        }
        self.complete = match self.frame.came.len() {
            0 => usize::MAX,
            count => count,
        };
        self.frame = Frame {
            before: Some(self.frame.time()),
            arrival: self.frame.arrival,
            ..Frame::default()
        };
    }

    /// Sends the pose of the frame.
    fn give(&mut self, given: &mut Vec<Vec<u8>>) {
        self.frame.is_out = true;
        if self.stage.is_none() {
            match Stage::new(&self.onto, &self.offsets, self.root) {
                Ok(stage) => (self.stage, self.problem) = (Some(stage), None),
                Err(error) => self.problem = Some(error),
            }
        }
        let Some(stage) = &mut self.stage else { return };
        stage.set(&self.bones, self.root);
        let time = self.frame.time();
        let clock = time.sender.unwrap_or(time.arrival);
        let seconds = self.frame.before.map_or(0.0, |before| time.since(before));
        self.counts.frames += 1;
        match &mut stage.mover {
            Mover::Humanoid { retargeter, to, bones } => {
                retargeter.pose(&stage.from, to);
                let poses = posed(bones, to);
                given.extend(match self.says {
                    Sender::Vmc => vmc(&poses, clock),
                    Sender::Json => vec![json_of_bones(&poses, clock)],
                });
            }
            Mover::Robot { stream, dof_names } => {
                let (base, positions) = stream.pose(&stage.from, seconds);
                let mut joints = json!({});
                for (name, at) in dof_names.iter().zip(positions) {
                    joints[name.as_str()] = json!(at);
                }
                let root = json!({ "position": base.translation.to_array(), "rotation": base.rotation.to_array() });
                given.push(
                    json!({ "time": clock, "root": root, "joints": joints })
                        .to_string()
                        .into_bytes(),
                );
            }
        }
    }
}

impl Stage {
    fn new(onto: &BridgeTarget, offsets: &BTreeMap<Bone, BonePose>, root: Option<BonePose>) -> Result<Self> {
        let mut recorder = VmcRecorder::new();
        recorder.first_frame(offsets, root);
        let mut source = recorder.scene()?;
        // The floor is at height 0 of the sender, not under the feet of the first frame.
        source.animations.clear();
        let mover = match onto {
            BridgeTarget::Humanoid(target) => Mover::Humanoid {
                retargeter: Box::new(PoseRetargeter::new(&source, target, &PoseRetargetOptions::new())?),
                to: Pose::rest(target),
                bones: bones(target).collect(),
            },
            BridgeTarget::Robot(robot) => {
                let options = RobotOptions::new().velocity_limits(true);
                Mover::Robot {
                    stream: Box::new(RobotStream::new(&source, robot, &options)?),
                    dof_names: robot.dof_names(),
                }
            }
        };
        Ok(Self {
            from: Pose::rest(&source),
            nodes: bones(&source).collect(),
            mover,
        })
    }

    /// Sets the pose of the source.
    fn set(&mut self, bones: &BTreeMap<Bone, BonePose>, root: Option<BonePose>) {
        for (bone, pose) in bones {
            let Some(&node) = self.nodes.get(bone) else { continue };
            let matrix = &mut self.from.node_to_parent[node];
            *matrix = pose.to_parent(*bone, matrix.w_axis.truncate(), root);
        }
        self.from.update_world();
    }
}

/// The bones of a skeleton, with their nodes.
fn bones(scene: &Scene) -> impl Iterator<Item = (Bone, usize)> {
    let nodes = scene.nodes.iter().enumerate();
    nodes.filter_map(|(index, node)| Some((node.humanoid_bone?, index)))
}

/// The poses of the target's bones relative to their parents.
fn posed(bones: &[(Bone, usize)], to: &Pose) -> Vec<(Bone, BonePose)> {
    let pose = |node: usize| {
        let Trs {
            translation, rotation, ..
        } = Trs::from_matrix(to.node_to_parent[node]);
        BonePose {
            position: translation,
            rotation,
        }
    };
    bones.iter().map(|(bone, node)| (*bone, pose(*node))).collect()
}

fn vmc(poses: &[(Bone, BonePose)], clock: f64) -> Vec<Vec<u8>> {
    let messages: Vec<OscMessage> = beginning(clock)
        .into_iter()
        .chain(poses.iter().map(|(bone, pose)| pose_message(*bone, *pose)))
        .collect();
    bundles(messages)
}

fn json_of_bones(poses: &[(Bone, BonePose)], clock: f64) -> Vec<u8> {
    let mut bones = json!({});
    for (bone, pose) in poses {
        bones[bone.as_str()]["rotation"] = json!(pose.rotation.to_array());
        if *bone == Bone::Hips {
            bones[bone.as_str()]["position"] = json!(pose.position.to_array());
        }
    }
    json!({ "time": clock, "bones": bones }).to_string().into_bytes()
}
