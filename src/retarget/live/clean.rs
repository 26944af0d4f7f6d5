//! Removes noise from packets, with a delay.

use std::collections::{BTreeMap, VecDeque};

use mocap_edit::LiveClean;
use mocap_scene::error::Result;
use mocap_scene::pose::Trs;
use mocap_scene::scene::HumanoidBone as Bone;
use rosc::OscMessage;

use super::play::{bundles, pose_message};
use super::vmc::{BonePose, Said, flat, said};

/// The number of frames from which the frame rate of a sender is measured. The cleaner returns no frame before this
/// number.
const MEASURED: usize = 24;

/// The range of frame rates of a sender, in Hz. A slower stream is not a motion, and a faster one has a wrong clock.
const RATES: [f64; 2] = [5.0, 500.0];
/// The silence of a sender after which its motion begins anew, in seconds.
const SILENCE: f64 = 1.0;
/// The largest number of messages of a frame. All bones and blend shapes of a figure are some hundreds.
const MOST: usize = 4096;

/// Removes noise from a VMC stream as it arrives, by [`LiveClean`]: packets in, packets out, each frame with a delay.
/// Messages that are not about bones stay with their frame, unchanged.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::live::{VmcCleaner, VmcMotion};
///
/// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// mocap::Conversion::new().apply(&mut scene)?;
/// let motion = VmcMotion::new(&scene)?;
/// let mut cleaner = VmcCleaner::new(0.2)?;
/// let mut frames = 0;
/// for frame in 0..60 {
///     let seconds = f64::from(frame) / 60.0;
///     for packet in motion.packets(seconds) {
///         frames += cleaner.hear(&packet, seconds).len() / motion.packets(0.0).len();
///     }
/// }
/// assert_eq!(frames, 60 - 1 - 12); // 12 frames are 0.2 seconds, and a frame ends as the next begins
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Debug)]
pub struct VmcCleaner {
    delay: f64,
    live: Option<LiveClean>,
    /// The received bones, each with its latest pose.
    bones: BTreeMap<Bone, BonePose>,
    /// The frame that is being received.
    current: Frame,
    /// The frames that were not returned yet.
    waiting: VecDeque<Frame>,
}

/// The received messages of a frame.
#[derive(Clone, Debug, Default)]
struct Frame {
    messages: Vec<OscMessage>,
    bones: Vec<Bone>,
    joints: Vec<Trs>,
    clock: Option<f64>,
    arrival: f64,
}

impl VmcCleaner {
    /// A cleaner with a delay in seconds. With half a second, each frame is cleaned with frames on both sides.
    ///
    /// # Errors
    /// [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) for a delay that is not from 0 to 10.
    pub fn new(delay: f64) -> Result<Self> {
        LiveClean::new(RATES[1], delay)?;
        Ok(Self {
            delay,
            live: None,
            bones: BTreeMap::new(),
            current: Frame::default(),
            waiting: VecDeque::new(),
        })
    }

    /// Receives a packet, with its time of arrival in seconds since a fixed time, and returns the packets that are due.
    /// Packets that are not OSC are dropped.
    pub fn hear(&mut self, packet: &[u8], seconds: f64) -> Vec<Vec<u8>> {
        let mut given = Vec::new();
        for message in flat(packet).unwrap_or_default() {
            let said = said(&message);
            let ends = match &said {
                Said::Time(_) => self.current.clock.is_some() || !self.current.bones.is_empty(),
                Said::Bone(bone, _) => self.current.bones.contains(bone),
                _ => self.current.messages.len() >= MOST,
            };
            if ends {
                given.extend(self.end_frame());
            }
            self.current.arrival = seconds;
            match said {
                Said::Time(time) => self.current.clock = Some(time),
                Said::Bone(bone, bone_pose) => {
                    // Another number of joints is a different motion.
                    if self.bones.insert(bone, bone_pose).is_none() {
                        given.extend(self.finish_waiting());
                    }
                    self.current.bones.push(bone);
                }
                _ => {}
            }
            self.current.messages.push(message);
        }
        given
    }

    /// Returns all remaining packets, at the end of a stream.
    pub fn finish(&mut self) -> Vec<Vec<u8>> {
        let mut given = self.end_frame();
        given.extend(self.finish_waiting());
        given
    }

    fn end_frame(&mut self) -> Vec<Vec<u8>> {
        let mut frame = std::mem::take(&mut self.current);
        if self.bones.is_empty() {
            return if frame.messages.is_empty() {
                Vec::new()
            } else {
                bundles(frame.messages)
            };
        }
        let mut given = Vec::new();
        if self
            .waiting
            .back()
            .is_some_and(|last| frame.arrival - last.arrival > SILENCE)
        {
            given = self.finish_waiting();
        }
        let joint = |bone_pose: &BonePose| Trs {
            translation: bone_pose.position,
            rotation: bone_pose.rotation,
            ..Trs::IDENTITY
        };
        // A bone that was not received keeps its pose.
        frame.joints = self.bones.values().map(joint).collect();
        self.waiting.push_back(frame);
        match &mut self.live {
            Some(live) => {
                let joints = live.push(&self.waiting[self.waiting.len() - 1].joints);
                given.extend(joints.and_then(|joints| self.give(joints)).into_iter().flatten());
            }
            None if self.waiting.len() >= MEASURED => given.extend(self.begin()),
            None => {}
        }
        given
    }

    /// Starts to clean when the frame rate of the sender is known.
    fn begin(&mut self) -> Vec<Vec<u8>> {
        let clocks: Option<Vec<f64>> = self.waiting.iter().map(|frame| frame.clock).collect();
        let times = clocks.unwrap_or_else(|| self.waiting.iter().map(|frame| frame.arrival).collect());
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let rate = mocap_scene::math::median::median(&mut steps)
            .unwrap_or_default()
            .recip();
        let rate = if rate.is_finite() {
            rate.clamp(RATES[0], RATES[1])
        } else {
            60.0
        };
        let Ok(mut live) = LiveClean::new(rate, self.delay) else {
            return Vec::new();
        };
        let rows: Vec<Vec<Trs>> = self.waiting.iter().map(|frame| frame.joints.clone()).collect();
        let cleaned: Vec<Vec<Trs>> = rows.iter().filter_map(|row| live.push(row)).collect();
        self.live = Some(live);
        cleaned
            .into_iter()
            .filter_map(|joints| self.give(joints))
            .flatten()
            .collect()
    }

    /// Returns the waiting frames, and resets the motion.
    fn finish_waiting(&mut self) -> Vec<Vec<u8>> {
        let mut given = match self.live {
            None if !self.waiting.is_empty() => self.begin(),
            _ => Vec::new(),
        };
        let left = self.live.take().map(|mut live| live.finish()).unwrap_or_default();
        given.extend(left.into_iter().filter_map(|joints| self.give(joints)).flatten());
        self.waiting.clear();
        given
    }

    /// The packets of the frame that has waited longest, with these joints.
    fn give(&mut self, joints: Vec<Trs>) -> Option<Vec<Vec<u8>>> {
        let frame = self.waiting.pop_front()?;
        let cleaned: BTreeMap<Bone, Trs> = self.bones.keys().copied().zip(joints).collect();
        let clean = |message: OscMessage| match said(&message) {
            Said::Bone(bone, _) => cleaned.get(&bone).map_or(message, |joint| {
                pose_message(
                    bone,
                    BonePose {
                        position: joint.translation,
                        rotation: joint.rotation,
                    },
                )
            }),
            _ => message,
        };
        Some(bundles(frame.messages.into_iter().map(clean).collect()))
    }
}
