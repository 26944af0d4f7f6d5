//! Converts packets to poses as they arrive.

use std::collections::BTreeMap;

use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{HumanoidBone as Bone, Scene};

use super::record::VmcRecorder;
use super::vmc::{BonePose, Said, messages};

/// The number of frames from which the skeleton and the frame rate of a sender are known.
const MEASURED: usize = 24;

/// The poses of a VMC stream: packets in, poses of [`scene`](Self::scene) out, one for each frame.
///
/// The skeleton and the frame rate are known after 24 frames. The poses of these frames are then returned together. A
/// bone that is missing in a frame keeps its pose.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::live::{VmcMotion, VmcPoses};
///
/// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// mocap::Conversion::new().apply(&mut scene)?;
/// let motion = VmcMotion::new(&scene)?;
/// let (mut poses, mut frames) = (VmcPoses::new(), 0);
/// for frame in 0..40 {
///     let seconds = f64::from(frame) / 60.0;
///     for packet in motion.packets(seconds) {
///         frames += poses.hear(&packet, seconds).len();
///     }
/// }
/// assert_eq!(frames, 39); // a frame ends as the next begins
/// assert_eq!(poses.scene().unwrap().animations[0].ticks_per_second, 60.0);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct VmcPoses {
    recorder: VmcRecorder,
    /// The number of frames that have ended in the recorder.
    ended: usize,
    begun: Option<(Scene, Pose)>,
    root: Option<BonePose>,
    /// The frame that is being received.
    bones: BTreeMap<Bone, BonePose>,
    has_clock: bool,
}

impl VmcPoses {
    /// A stream without packets yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The skeleton in its T-pose with the first frames as its motion, in metres with +Y up; `None` until it is known.
    pub fn scene(&self) -> Option<&Scene> {
        self.begun.as_ref().map(|(scene, _)| scene)
    }

    /// Receives a packet, with its time of arrival in seconds since a fixed time, and returns the poses of completed
    /// frames. Packets that are not OSC are dropped.
    pub fn hear(&mut self, packet: &[u8], seconds: f64) -> Vec<Pose> {
        if self.begun.is_none() {
            self.recorder.hear(packet, seconds);
        }
        let mut given = Vec::new();
        for said in messages(packet).unwrap_or_default() {
            let ends = match &said {
                Said::Time(_) => self.has_clock || !self.bones.is_empty(),
                Said::Bone(bone, _) => self.bones.contains_key(bone),
                _ => false,
            };
            if ends {
                given.extend(self.end_frame());
            }
            match said {
                Said::Time(_) => self.has_clock = true,
                Said::Root(bone_pose) => self.root = Some(bone_pose),
                Said::Bone(bone, bone_pose) => {
                    self.bones.insert(bone, bone_pose);
                }
                _ => {}
            }
        }
        if self.begun.is_none() && self.ended >= MEASURED {
            given = self.begin();
        }
        given
    }

    fn end_frame(&mut self) -> Option<Pose> {
        let bones = std::mem::take(&mut self.bones);
        self.has_clock = false;
        let Some((scene, pose)) = &mut self.begun else {
            self.ended += usize::from(!bones.is_empty());
            return None;
        };
        for (index, node) in scene.nodes.iter().enumerate() {
            let came = node.humanoid_bone.and_then(|bone| Some((bone, bones.get(&bone)?)));
            if let Some((bone, came)) = came {
                pose.node_to_parent[index] = came.to_parent(bone, node.transform.w_axis.truncate(), self.root);
            }
        }
        pose.update_world();
        Some(pose.clone())
    }

    /// Makes the skeleton from the received frames, and returns their poses.
    fn begin(&mut self) -> Vec<Pose> {
        self.ended = 0;
        let Ok(scene) = std::mem::take(&mut self.recorder).scene() else {
            return Vec::new();
        };
        let animation = &scene.animations[0];
        let binding = Binding::new(&scene, animation);
        let mut pose = Pose::rest(&scene);
        let mut given = Vec::new();
        // The last frame is incomplete, and returned later.
        for tick in 0..animation.duration as usize {
            pose.sample(&binding, animation, tick as f64);
            given.push(pose.clone());
        }
        self.begun = Some((scene, pose));
        given
    }
}
