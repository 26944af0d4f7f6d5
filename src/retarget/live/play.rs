//! Converts a scene to packets.

use glam::{Quat, Vec3};
use mocap_figure::vrm_humanoid;
use mocap_scene::error::Result;
use mocap_scene::scene::{Channel, HumanoidBone as Bone, Scene};
use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType, encoder};

use super::vmc::{BONE, BonePose, ROOT, STATE, TIME, mirrored, unity_name};

/// The largest packet that every network carries in one piece, in bytes: 1500 of Ethernet, less the headers of IPv6 and
/// UDP.
const LONGEST: usize = 1452;

/// The bytes of a bundle before its messages: `#bundle`, a zero and a time tag (Open Sound Control 1.0).
const BUNDLE: usize = 16;

/// The bytes before each message of a bundle: its size (Open Sound Control 1.0).
const BEFORE_MESSAGE: usize = 4;

/// The motion of a humanoid as packets of VMC.
///
/// The [module](crate::live) has an example.
#[derive(Debug)]
pub struct VmcMotion {
    scene: Scene,
}

impl VmcMotion {
    /// The first motion of a scene in metres with +Y up.
    ///
    /// # Errors
    /// The errors of [`figure::vrm_humanoid`](mocap_figure::vrm_humanoid()), if the scene has no humanoid.
    pub fn new(scene: &Scene) -> Result<Self> {
        let scene = vrm_humanoid(scene, None)?;
        Ok(Self { scene })
    }

    /// Seconds from the first frame of the motion to its last.
    pub fn seconds(&self) -> f64 {
        let animation = self.scene.animations.first();
        animation.map_or(0.0, |animation| animation.duration / animation.ticks_per_second)
    }

    /// The frames per second of the motion.
    pub fn frames_per_second(&self) -> f64 {
        let animation = self.scene.animations.first();
        animation.map_or(60.0, |animation| animation.ticks_per_second)
    }

    /// The packets of the pose at a time. The packets state this time as their clock.
    pub fn packets(&self, seconds: f64) -> Vec<Vec<u8>> {
        self.packets_at(seconds, seconds)
    }

    /// Like [`Self::packets`], but the packets state `clock` as their time. So the clock can continue to increase while
    /// a motion repeats.
    pub fn packets_at(&self, seconds: f64, clock: f64) -> Vec<Vec<u8>> {
        let mut messages = beginning(clock);
        let animation = self.scene.animations.first();
        let tick = animation.map_or(0.0, |animation| seconds * animation.ticks_per_second);
        for (index, node) in self.scene.nodes.iter().enumerate() {
            let Some(bone) = node.humanoid_bone else { continue };
            let drives = |channel: &&Channel| channel.node.is_some_and(|node| node.index() == index);
            let channel = animation.and_then(|animation| animation.channels.iter().find(drives));
            let (_, rotation, position) = node.transform.to_scale_rotation_translation();
            let pose = BonePose {
                position: channel
                    .and_then(|channel| channel.position_keys.sample(tick))
                    .unwrap_or(position),
                rotation: channel
                    .and_then(|channel| channel.rotation_keys.sample(tick))
                    .unwrap_or(rotation),
            };
            messages.push(pose_message(bone, pose));
        }
        bundles(messages)
    }
}

/// The first messages of a frame.
pub(super) fn beginning(clock: f64) -> Vec<OscMessage> {
    let message = |address: &str, args: Vec<OscType>| OscMessage {
        addr: address.to_owned(),
        args,
    };
    // The state: loaded, calibrated, in the usual mode.
    let state = [1, 3, 0].map(OscType::Int).to_vec();
    let root = BonePose {
        position: Vec3::ZERO,
        rotation: Quat::IDENTITY,
    };
    vec![
        message(STATE, state),
        message(TIME, vec![OscType::Float(clock as f32)]),
        message(ROOT, arguments_of("root", root)),
    ]
}

/// The message of a bone.
pub(super) fn pose_message(bone: Bone, pose: BonePose) -> OscMessage {
    OscMessage {
        addr: BONE.to_owned(),
        args: arguments_of(&unity_name(bone), pose),
    }
}

/// A name, a position and a rotation, in Unity's axes.
fn arguments_of(name: &str, pose: BonePose) -> Vec<OscType> {
    let BonePose { position, rotation } = mirrored(pose);
    let numbers = position.to_array().into_iter().chain(rotation.to_array());
    let name = OscType::String(name.to_owned());
    std::iter::once(name).chain(numbers.map(OscType::Float)).collect()
}

/// The messages in their order, in as few packets as a network carries in one piece.
pub(super) fn bundles(messages: Vec<OscMessage>) -> Vec<Vec<u8>> {
    // "Immediately", as OSC 1.0 defines it.
    const NOW: OscTime = OscTime {
        seconds: 0,
        fractional: 1,
    };
    let encoded = |packet: OscPacket| encoder::encode(&packet).unwrap_or_default();
    let mut packets = Vec::new();
    let (mut content, mut length) = (Vec::new(), BUNDLE);
    let mut flush = |content: Vec<OscPacket>| {
        let bundle = OscBundle { timetag: NOW, content };
        packets.push(encoded(OscPacket::Bundle(bundle)));
    };
    for message in messages {
        let message = OscPacket::Message(message);
        let own = BEFORE_MESSAGE + encoded(message.clone()).len();
        if length + own > LONGEST {
            flush(std::mem::take(&mut content));
            length = BUNDLE;
        }
        content.push(message);
        length += own;
    }
    flush(content);
    packets
}
