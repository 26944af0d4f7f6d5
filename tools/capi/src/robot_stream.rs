//! Retargets a live motion to a robot.

use std::collections::VecDeque;
use std::ffi::{CString, c_char};
use std::ptr;

use mocap::retarget::robot::{RobotMotion, RobotOptions, RobotRetargeter, SmoothRobotStream};
use mocap::{Importer, Pose};

use crate::border::{self, Failure, Status, c_text, guard};
use crate::handle::Scene;
use crate::retarget::take;
use crate::{opened, path_from, text};

/// The number of values of the base in a frame: its position, and its rotation as w, x, y, z.
const BASE: usize = 7;

/// Retargets a stream of poses to a robot. Programs only hold pointers to this type.
pub struct RobotStream {
    stream: SmoothRobotStream,
    pose: Pose,
    joints: Vec<CString>,
    /// The remaining frames, once the stream has ended.
    left: Option<VecDeque<Vec<f64>>>,
}

/// Begins to retarget a live motion to a robot, at `fps` poses per second, from 1 to 1000. `source` is the skeleton of
/// the poses, a humanoid; its animation, if it has one, determines the floor. `robot` is the path of a URDF or MJCF
/// file. With `passes` 2, joints are smooth and feet do not slide, and frames have a delay of 0.6 s. With `passes` 1,
/// the delay is 0.1 s.
///
/// Returns NULL if the robot cannot be read, or if the source or the robot is not a humanoid; `mocap_error_text` has
/// the reason. You may close the scene after this call. Free the stream with `mocap_robot_stream_free`.
///
/// # Safety
/// `source` is an open scene, and `robot` is a string that ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_robot_stream_new(
    source: *const Scene,
    robot: *const c_char,
    fps: f64,
    passes: u8,
) -> *mut RobotStream {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller passes an open scene.
        let source = unsafe { opened(source) }?.scene();
        // SAFETY: the caller passes a string with a zero byte at its end.
        let robot = path_from(unsafe { text(robot, "robot") }?)?;
        if !matches!(passes, 1 | 2) {
            return Err(Failure::argument(&format!("passes must be 1 or 2, got {passes}")));
        }
        let robot = Importer::new().import_robot(robot)?;
        let options = RobotOptions::new().passes(passes);
        let stream = RobotRetargeter::new(source, &robot, &options)?.stream(source, fps)?;
        Ok(Box::into_raw(Box::new(RobotStream {
            joints: stream.dof_names().iter().map(|name| c_text(name)).collect(),
            pose: Pose::rest(source),
            left: None,
            stream,
        })))
    })
}

/// Frees a stream, with the names of its joints. NULL is allowed.
///
/// # Safety
/// `stream` comes from `mocap_robot_stream_new`, was not freed before, and is used by no other thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_robot_stream_free(stream: *mut RobotStream) {
    guard((), || {
        if !stream.is_null() {
            // SAFETY: the pointer comes from `Box::into_raw`, and the caller gives it up.
            drop(unsafe { Box::from_raw(stream) });
        }
        Ok(())
    });
}

/// The delay of a frame in seconds; 0 for NULL.
///
/// # Safety
/// `stream` is NULL or an open stream.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_robot_stream_delay(stream: *const RobotStream) -> f64 {
    // SAFETY: the caller passes NULL or an open stream.
    guard(0.0, || Ok(unsafe { living(stream) }?.stream.delay()))
}

/// The number of joints of the robot. A frame has 7 values more. 0 for NULL.
///
/// # Safety
/// `stream` is NULL or an open stream.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_robot_stream_joint_count(stream: *const RobotStream) -> usize {
    // SAFETY: the caller passes NULL or an open stream.
    guard(0, || Ok(unsafe { living(stream) }?.joints.len()))
}

/// The name of a joint, from 0, in the order of a frame; NULL beyond the last. The text lives as long as the stream.
///
/// # Safety
/// `stream` is NULL or an open stream.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_robot_stream_joint_name(stream: *const RobotStream, joint: usize) -> *const c_char {
    guard(ptr::null(), || {
        // SAFETY: the caller passes NULL or an open stream.
        let joints = &unsafe { living(stream) }?.joints;
        let name = joints.get(joint);
        let name = name.ok_or_else(|| Failure::absent("joint", joint as u64, joints.len() as u64))?;
        Ok(name.as_ptr())
    })
}

/// Takes the next pose: the matrix of every node of the source relative to its parent, as for `mocap_retarget_pose`.
/// Writes the finished frame to `frame`, and whether a frame is finished to `given`. The frame is MuJoCo's `qpos` with
/// +Z up. It has the position of the base in metres (x, y, z), its rotation (w, x, y, z), and the joint positions in
/// radians or metres. `count` is the number of values that fit in `frame`, at least 7 plus one for each joint.
///
/// Only one thread at a time may use a stream.
///
/// # Safety
/// `stream` is a stream that no other thread uses, `source` points to 16 x `source_count` floats, `frame` to room for
/// `count` numbers, and `given` to a bool.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_robot_stream_push(
    stream: *mut RobotStream,
    source: *const f32,
    source_count: usize,
    frame: *mut f64,
    count: usize,
    given: *mut bool,
) -> Status {
    border::status(|| {
        // SAFETY: the caller passes NULL or a stream that it alone uses.
        let stream = unsafe { with_room(stream, frame, count, given) }?;
        if stream.left.is_some() {
            return Err(Failure::argument("mocap_robot_stream_pull has ended the stream"));
        }
        // SAFETY: the caller passes `source_count` matrices.
        unsafe { take(&mut stream.pose, source, source_count) }?;
        let found = stream.stream.push(&stream.pose).map(|motion| motion.qpos());
        // SAFETY: `frame` has room for a frame, and `given` for a bool.
        unsafe { put(found.as_deref(), frame, given) };
        Ok(())
    })
}

/// Ends a stream, and returns one of the remaining frames with each call, as `mocap_robot_stream_push` does, until
/// `given` is false.
///
/// # Safety
/// `stream` is a stream that no other thread uses, `frame` points to room for `count` numbers, and `given` to a bool.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_robot_stream_pull(
    stream: *mut RobotStream,
    frame: *mut f64,
    count: usize,
    given: *mut bool,
) -> Status {
    border::status(|| {
        // SAFETY: the caller passes NULL or a stream that it alone uses.
        let stream = unsafe { with_room(stream, frame, count, given) }?;
        let size = stream.size();
        let RobotStream { stream, left, .. } = stream;
        let left = left.get_or_insert_with(|| frames(&stream.finish(), size));
        // SAFETY: `frame` has room for a frame, and `given` for a bool.
        unsafe { put(left.pop_front().as_deref(), frame, given) };
        Ok(())
    })
}

/// The quality of the frames of the last 30 s, as JSON with a verdict: the report of `mocap robot --json`. "null"
/// before the first frame. Free the text with `mocap_text_free`. NULL for NULL.
///
/// # Safety
/// `stream` is NULL or a stream that no other thread uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_robot_stream_report(stream: *const RobotStream) -> *mut c_char {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller passes NULL or an open stream.
        let report = unsafe { living(stream) }?.stream.report();
        let report = serde_json::to_string(&report).unwrap_or_default();
        Ok(CString::new(report).unwrap_or_default().into_raw())
    })
}

impl RobotStream {
    /// The number of values of a frame.
    fn size(&self) -> usize {
        BASE + self.joints.len()
    }
}

fn frames(motion: &RobotMotion, size: usize) -> VecDeque<Vec<f64>> {
    motion.qpos().chunks_exact(size).map(<[f64]>::to_vec).collect()
}

/// # Safety
/// `frame` points to room for the numbers, and `given` to a bool.
unsafe fn put(found: Option<&[f64]>, frame: *mut f64, given: *mut bool) {
    // SAFETY: the caller guarantees the room, outside the memory of the stream.
    unsafe {
        if let Some(numbers) = found {
            ptr::copy_nonoverlapping(numbers.as_ptr(), frame, numbers.len());
        }
        given.write(found.is_some());
    }
}

/// # Safety
/// `stream` is NULL or an open stream.
unsafe fn living<'a>(stream: *const RobotStream) -> Result<&'a RobotStream, Failure> {
    // SAFETY: the caller passes NULL or an open stream.
    unsafe { stream.as_ref() }.ok_or_else(|| Failure::argument("the stream is NULL"))
}

/// The stream at a pointer. Fails if `frame` is too small for a frame, or a pointer is NULL.
///
/// # Safety
/// `stream` is NULL or a stream that no other thread uses.
unsafe fn with_room<'a>(
    stream: *mut RobotStream,
    frame: *mut f64,
    count: usize,
    given: *mut bool,
) -> Result<&'a mut RobotStream, Failure> {
    // SAFETY: the caller passes NULL or a stream that it alone uses.
    let stream = unsafe { stream.as_mut() }.ok_or_else(|| Failure::argument("the stream is NULL"))?;
    if frame.is_null() || given.is_null() {
        return Err(Failure::argument("frame or given is NULL"));
    }
    if count < stream.size() {
        let message = format!("there is room for {count} numbers, and a frame has {}", stream.size());
        return Err(Failure::argument(&message));
    }
    Ok(stream)
}
