//! Robot motions of whole clips, and streams that JavaScript holds by numbers that are never reused.

use std::collections::BTreeMap;

use mocap::figure::{Humanoid, HumanoidMap};
use mocap::glam::Mat4;
use mocap::job::{Feet, RobotTarget};
use mocap::retarget::robot::report::RobotReport;
use mocap::retarget::robot::{Robot, RobotMotion, RobotOptions, RobotRetargeter, SmoothRobotStream};
use mocap::{Pose, Scene};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::failure::Failure;
use crate::given::Given;
use crate::request::{Answer, json};

/// The size of a matrix of 16 32-bit numbers, in bytes.
const MATRIX_BYTES: usize = 64;

struct Entry {
    stream: SmoothRobotStream,
    pose: Pose,
}

#[derive(Default)]
pub(crate) struct RobotStreams {
    entries: BTreeMap<u32, Entry>,
    last: u32,
}

pub(crate) struct StreamOptions {
    robot: RobotTarget,
    own: OwnStreamOptions,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
struct OwnStreamOptions {
    fps: Option<f64>,
    bones: HumanoidMap,
    character_bones: HumanoidMap,
}

impl StreamOptions {
    pub(crate) fn of(options: Value) -> Result<Self, Failure> {
        let mut given = Given::new("robotStream", options)?;
        let made = Self {
            robot: given.take()?,
            own: given.take()?,
        };
        given.end()?;
        Ok(made)
    }

    fn of_robot(&self, source: &Scene) -> Result<RobotOptions, Failure> {
        let options = RobotOptions::new();
        let passes = self.robot.passes.unwrap_or(options.passes);
        if !matches!(passes, 1 | 2) {
            return Err(Failure::argument(format!("passes must be 1 or 2, got {passes}")));
        }
        if self.robot.time_scale != options.time_scale {
            return Err(Failure::argument(
                "a stream is as fast as its poses: leave out timeScale",
            ));
        }
        let bones = Humanoid::of(source).with_map(source, self.own.bones.clone())?;
        Ok(options
            .passes(passes)
            .lock_feet(self.robot.feet == Feet::Lock)
            .floor(self.robot.floor)
            .map(self.own.character_bones.clone())
            .source(Some(bones)))
    }
}

/// The description of a stream for JavaScript.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct StreamAt<'a> {
    stream: u32,
    joint_names: &'a [String],
    delay: f64,
}

impl RobotStreams {
    pub(crate) fn add(
        &mut self,
        source: &Scene,
        robot: &Robot,
        options: &StreamOptions,
    ) -> Result<StreamAt<'_>, Failure> {
        let rate = source.animations.first().map(|animation| animation.ticks_per_second);
        let fps = options.own.fps.or(rate);
        let fps = fps.ok_or_else(|| Failure::argument("the scene has no motion with a frame rate: set fps"))?;
        let stream = RobotRetargeter::new(source, robot, &options.of_robot(source)?)?.stream(source, fps)?;
        let next = self.last.checked_add(1);
        self.last = next.ok_or_else(|| Failure::argument("there were 2^32 streams; load the module again"))?;
        let pose = Pose::rest(source);
        let Entry { stream, .. } = self.entries.entry(self.last).or_insert(Entry { stream, pose });
        Ok(StreamAt {
            stream: self.last,
            joint_names: stream.dof_names(),
            delay: stream.delay(),
        })
    }

    fn get(&mut self, stream: u32) -> Result<&mut Entry, Failure> {
        let entry = self.entries.get_mut(&stream);
        entry.ok_or_else(|| Failure::argument("the stream was freed"))
    }

    /// Takes the matrices of all nodes relative to their parents. The answer has the finished frame, if there is one.
    pub(crate) fn push(&mut self, stream: u32, matrices: &[u8]) -> Result<Answer, Failure> {
        let Entry { stream, pose } = self.get(stream)?;
        let nodes = pose.node_to_parent.len();
        if matrices.len() != MATRIX_BYTES * nodes {
            let message = format!(
                "the pose has {} numbers, and the {nodes} nodes need {}",
                matrices.len() / 4,
                16 * nodes
            );
            return Err(Failure::argument(message));
        }
        let numbers = matrices.chunks_exact(4);
        let numbers: Vec<f32> = numbers
            .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap_or_default()))
            .collect();
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(Failure::argument("a number of the pose is not finite"));
        }
        for (node, columns) in pose.node_to_parent.iter_mut().zip(numbers.chunks_exact(16)) {
            *node = Mat4::from_cols_slice(columns);
        }
        pose.update_world();
        match stream.push(pose) {
            Some(motion) => frames(&motion),
            None => frames(&RobotMotion::default()),
        }
    }

    /// The remaining frames.
    pub(crate) fn finish(&mut self, stream: u32) -> Result<Answer, Failure> {
        frames(&self.get(stream)?.stream.finish())
    }

    pub(crate) fn report(&mut self, stream: u32) -> Result<Answer, Failure> {
        #[derive(Serialize)]
        struct Said {
            report: Option<RobotReport>,
        }
        let report = self.get(stream)?.stream.report();
        Ok((json(&Said { report })?, Vec::new()))
    }

    pub(crate) fn free(&mut self, stream: u32) {
        self.entries.remove(&stream);
    }
}

fn frames(motion: &RobotMotion) -> Result<Answer, Failure> {
    #[derive(Serialize)]
    struct Frames<'a> {
        frames: usize,
        contacts: &'a [[bool; 2]],
    }
    let said = Frames {
        frames: motion.frames(),
        contacts: &motion.contacts,
    };
    Ok((json(&said)?, numbers(motion)))
}

/// The positions of the base, its rotations, and the positions of the joints, each frame by frame.
pub(crate) fn numbers(motion: &RobotMotion) -> Vec<u8> {
    let numbers = [motion.root_pos(), motion.root_rot(), motion.dof_pos.clone()].concat();
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}
