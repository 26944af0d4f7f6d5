//! The messages of VMC, and Unity's axes.
//!
//! Unity is left-handed with +Y up. A figure in Unity faces +Z and has its left hand at -X. A scene of this crate is
//! right-handed with +Y up. A figure that faces +Z has its left hand at +X. The mirror S = diag(-1, 1, 1) converts
//! between Unity and a scene. A position p becomes S p = (-x, y, z), and a rotation R becomes S R S. The mirrored
//! rotation has the opposite angle about the mirrored axis. So the axis a becomes -S a = (x, -y, -z), and the
//! quaternion (x, y, z, w) becomes (x, -y, -z, w). Both conversions are their own inverses.

use glam::{Mat4, Quat, Vec3};
use rosc::{OscMessage, OscPacket, OscType, decoder};

use mocap_scene::scene::{Face, HumanoidBone as Bone};

pub(super) const TIME: &str = "/VMC/Ext/T";
pub(super) const STATE: &str = "/VMC/Ext/OK";
pub(super) const ROOT: &str = "/VMC/Ext/Root/Pos";
pub(super) const BONE: &str = "/VMC/Ext/Bone/Pos";
const BLEND: &str = "/VMC/Ext/Blend/Val";
/// The address of the message that applies the values of blend shapes in the messages before.
pub(super) const APPLY: &str = "/VMC/Ext/Blend/Apply";

/// A position and a rotation, in the axes of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BonePose {
    pub position: Vec3,
    pub rotation: Quat,
}

impl BonePose {
    /// The hips, moved by the root.
    pub(super) fn below(self, root: Option<Self>) -> Self {
        let Some(root) = root else { return self };
        Self {
            position: root.position + root.rotation * self.position,
            rotation: root.rotation * self.rotation,
        }
    }

    /// The transform of the bone relative to its parent. Only the hips have their received position. Other bones keep
    /// their `offset` and rotate.
    pub(super) fn to_parent(self, bone: Bone, offset: Vec3, root: Option<Self>) -> Mat4 {
        match bone {
            Bone::Hips => {
                let hips = self.below(root);
                Mat4::from_rotation_translation(hips.rotation, hips.position)
            }
            _ => Mat4::from_rotation_translation(self.rotation, offset),
        }
    }
}

/// The content of a message.
#[derive(Debug, PartialEq)]
pub(super) enum Said {
    /// The sender's clock, in seconds.
    Time(f64),
    Root(BonePose),
    Bone(Bone, BonePose),
    /// A blend shape and its value.
    Blend(Face, f32),
    /// A message that is not about the motion of a body: cameras, lights, trackers.
    Other,
    /// A VMC message with wrong arguments, or with numbers that are not finite.
    Malformed,
}

/// The largest number of bundles in a packet, side by side or nested. A packet of a sender has one or a few. Without a
/// limit, a packet of 64 KiB can nest thousands of bundles.
const MOST_BUNDLES: usize = 64;

/// The contents of the messages of a packet; `None` if the packet is not OSC.
pub(super) fn messages(packet: &[u8]) -> Option<Vec<Said>> {
    Some(flat(packet)?.iter().map(said).collect())
}

/// The messages of a packet in their order; `None` if the packet is not OSC.
pub(super) fn flat(packet: &[u8]) -> Option<Vec<OscMessage>> {
    if memchr::memmem::find_iter(packet, b"#bundle\0").count() > MOST_BUNDLES {
        return None;
    }
    let (_, packet) = decoder::decode_udp(packet).ok()?;
    let mut found = Vec::new();
    let mut open = vec![packet];
    while let Some(packet) = open.pop() {
        match packet {
            OscPacket::Message(message) => found.push(message),
            // In reverse, because the last entry of a stack is taken first.
            OscPacket::Bundle(bundle) => open.extend(bundle.content.into_iter().rev()),
        }
    }
    Some(found)
}

pub(super) fn said(message: &OscMessage) -> Said {
    let arguments = message.args.as_slice();
    let read = match message.addr.as_str() {
        TIME => number(arguments.first()).filter(|time| *time >= 0.0).map(Said::Time),
        ROOT => pose(arguments).map(Said::Root),
        // A bone that no humanoid has is ignored, and is not an error.
        BONE => match arguments.first() {
            Some(OscType::String(name)) => match bone(name) {
                Some(bone) => pose(arguments).map(|pose| Said::Bone(bone, pose)),
                None => Some(Said::Other),
            },
            _ => None,
        },
        BLEND => match (arguments.first(), number(arguments.get(1))) {
            (Some(OscType::String(name)), Some(value)) => Some(Said::Blend(face(name), value.clamp(0.0, 1.0) as f32)),
            _ => None,
        },
        _ => Some(Said::Other),
    };
    read.unwrap_or(Said::Malformed)
}

/// The expression of a blend shape. Senders write the names of VRM 0 and of VRM 1.0, in upper or lower case.
fn face(name: &str) -> Face {
    let old = Face::OF_VRM0.iter().find(|(old, _)| name.eq_ignore_ascii_case(old));
    let preset = old.map(|(_, preset)| *preset);
    let preset = preset.or_else(|| {
        Face::PRESETS
            .into_iter()
            .find(|preset| name.eq_ignore_ascii_case(preset))
    });
    match preset {
        Some(preset) => Face::Preset(preset.to_owned()),
        None => Face::Custom(name.to_owned()),
    }
}

fn number(argument: Option<&OscType>) -> Option<f64> {
    match argument? {
        OscType::Float(number) => Some(f64::from(*number)),
        OscType::Double(number) => Some(*number),
        OscType::Int(number) => Some(f64::from(*number)),
        _ => None,
    }
    .filter(|number| number.is_finite())
}

/// The largest distance of a position from the origin, in metres.
const FARTHEST: f64 = 1e6;

/// The seven numbers after a name.
fn pose(arguments: &[OscType]) -> Option<BonePose> {
    let mut numbers = [0.0_f32; 7];
    for (index, into) in numbers.iter_mut().enumerate() {
        *into = number(arguments.get(index + 1)).filter(|number| number.abs() < FARTHEST)? as f32;
    }
    let [x, y, z, qx, qy, qz, qw] = numbers;
    let rotation = Quat::from_xyzw(qx, qy, qz, qw);
    // Rotations of senders have a length of 1, except for rounding.
    const SHORTEST: f32 = 0.5;
    (rotation.length() > SHORTEST).then(|| {
        mirrored(BonePose {
            position: Vec3::new(x, y, z),
            rotation: rotation.normalize(),
        })
    })
}

/// Converts Unity's axes to the axes of a scene, and back.
pub fn mirrored(pose: BonePose) -> BonePose {
    let (Vec3 { x, y, z }, [qx, qy, qz, w]) = (pose.position, pose.rotation.to_array());
    BonePose {
        position: Vec3::new(-x, y, z),
        rotation: Quat::from_xyzw(qx, -qy, -qz, w),
    }
}

/// The names of thumb bones in Unity and in VRM 1.0, where the thumb has a metacarpal and no intermediate bone.
const THUMBS: [(&str, &str); 3] = [
    ("humbProximal", "humbMetacarpal"),
    ("humbIntermediate", "humbProximal"),
    ("humbDistal", "humbDistal"),
];

/// The bone with this name in Unity's `HumanBodyBones`, such as `LeftUpperArm`.
pub fn bone(name: &str) -> Option<Bone> {
    Bone::ALL.iter().copied().find(|bone| unity_name(*bone) == name)
}

/// The name of a bone in Unity's `HumanBodyBones`.
pub fn unity_name(bone: Bone) -> String {
    let own = bone.as_str();
    let thumb = THUMBS.iter().find(|(_, vrm)| own.ends_with(vrm));
    let name = match thumb {
        Some((unity, vrm)) => format!("{}{unity}", own.trim_end_matches(vrm)),
        None => own.to_owned(),
    };
    let mut letters = name.chars();
    let first = letters.next().map(|letter| letter.to_ascii_uppercase());
    first.into_iter().chain(letters).collect()
}
