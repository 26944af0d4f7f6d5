//! The C interface of `mocap`.
//!
//! `mocap.h` is generated from this file, so the comments address readers of the header. `handle` has the type behind a
//! handle, and `border` catches panics and converts errors.

#![allow(unsafe_code, reason = "pointers of other languages go in and out")]
#![deny(clippy::missing_safety_doc, clippy::undocumented_unsafe_blocks)]
// Only tests may call `unwrap`.
#![warn(clippy::unwrap_used)]

mod border;
mod chain;
mod clip;
mod controller;
mod convert;
mod edit;
mod handle;
mod open;
mod retarget;
mod robot_stream;
mod run;
mod table;

use std::ffi::{CStr, c_char};
use std::path::Path;
use std::ptr;
use std::slice;

use crate::border::{Failure, guard};
use crate::handle::Animation;

pub use crate::border::Status;
pub use crate::chain::{ChainMatrix, mocap_chain};
pub use crate::clip::{
    Clip, mocap_clip_close, mocap_clip_duration, mocap_clip_node_count, mocap_clip_open, mocap_clip_pose,
    mocap_clip_ticks_per_second,
};
pub use crate::controller::{
    Controller, mocap_controller_follow, mocap_controller_free, mocap_controller_new, mocap_controller_open,
    mocap_controller_pose, mocap_controller_steer,
};
pub use crate::convert::{
    Conversion, MOCAP_UP_AUTO, MOCAP_UP_NEG_Y, MOCAP_UP_NEG_Z, MOCAP_UP_Y, MOCAP_UP_Z, mocap_assumption_count,
    mocap_assumption_text, mocap_convert,
};
pub use crate::edit::{mocap_edit, mocap_edit_report_count, mocap_edit_report_text};
pub use crate::handle::Scene;
pub use crate::open::{mocap_open_file, mocap_open_file_as, mocap_open_memory};
pub use crate::retarget::{
    Retargeter, mocap_retarget_pose, mocap_retargeter_free, mocap_retargeter_new, mocap_unmapped_count,
    mocap_unmapped_text,
};
pub use crate::robot_stream::{
    RobotStream, mocap_robot_stream_delay, mocap_robot_stream_free, mocap_robot_stream_joint_count,
    mocap_robot_stream_joint_name, mocap_robot_stream_new, mocap_robot_stream_pull, mocap_robot_stream_push,
    mocap_robot_stream_report,
};
pub use crate::run::{mocap_run, mocap_score, mocap_text_free, mocap_verify};
pub use crate::table::{
    Table, mocap_report, mocap_table_column_count, mocap_table_free, mocap_table_name, mocap_table_new,
    mocap_table_rate, mocap_table_row_count, mocap_table_unit, mocap_table_values,
};

/// The version of this interface. It increases when a program compiled with an older header may break. Compare it with
/// `mocap_interface_version`.
pub const MOCAP_INTERFACE_VERSION: u32 = 1;

/// The index for no node: the parent of the root, and the result of a search without a match.
pub const MOCAP_NO_NODE: u32 = 0xFFFF_FFFF;

/// The interface version of the loaded library.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_interface_version() -> u32 {
    MOCAP_INTERFACE_VERSION
}

/// The version of the library, such as "0.1.0". The text is never freed.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_version() -> *const c_char {
    const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => panic!("a version has no zero byte"),
    };
    VERSION.as_ptr()
}

/// The reason why the last call of this thread failed, in UTF-8; empty if it succeeded.
///
/// The text belongs to the thread, and has at most 4,095 bytes. It stays unchanged until the thread's next failed call.
/// Successful calls do not change it, even in the same expression. The memory is never freed, so an old pointer never
/// dangles, but it shows the text of a later failure. Copy the text to keep it. Each thread only sees its own failures.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_error_text() -> *const c_char {
    border::last_failure()
}

/// Frees a scene and every text that came from it. NULL is allowed.
///
/// # Safety
/// `scene` was returned by a function of this library, was not closed before, and is used by no other thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_close(scene: *mut Scene) {
    guard((), || {
        if !scene.is_null() {
            // SAFETY: the pointer comes from `Scene::into_raw`, and the caller gives it up.
            drop(unsafe { Box::from_raw(scene) });
        }
        Ok(())
    });
}

/// The number of warnings of the reader. `mocap_warning_text` returns each of them.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_warning_count(scene: *const Scene) -> usize {
    // SAFETY: the caller passes an open scene.
    guard(0, || Ok(unsafe { opened(scene) }?.warnings.len()))
}

/// A warning of the reader, counted from 0 in the order of the file; NULL beyond the last. The text lives as long as
/// the scene.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_warning_text(scene: *const Scene, warning: usize) -> *const c_char {
    guard(ptr::null(), || {
        // SAFETY: the caller passes an open scene.
        let scene = unsafe { opened(scene) }?;
        let text = scene.warnings.get(warning);
        let text = text.ok_or_else(|| Failure::absent("warning", warning as u64, scene.warnings.len() as u64))?;
        Ok(text.as_ptr())
    })
}

/// The number of nodes of the skeleton, including end sites. Node 0 is the root. A parent has a smaller index than its
/// children.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_node_count(scene: *const Scene) -> u32 {
    // SAFETY: the caller passes an open scene.
    guard(0, || Ok(unsafe { opened(scene) }?.node_count()))
}

/// The name of a node, in UTF-8; NULL if there is no such node. The text lives as long as the scene.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_node_name(scene: *const Scene, node: u32) -> *const c_char {
    guard(ptr::null(), || {
        // SAFETY: the caller passes an open scene.
        Ok(unsafe { opened(scene) }?.node_name(node)?.as_ptr())
    })
}

/// The parent of a node; MOCAP_NO_NODE for the root, and if there is no such node.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_node_parent(scene: *const Scene, node: u32) -> u32 {
    guard(MOCAP_NO_NODE, || {
        // SAFETY: the caller passes an open scene.
        let parent = unsafe { opened(scene) }?.node(node)?.parent;
        Ok(parent.map_or(MOCAP_NO_NODE, |parent| parent.0))
    })
}

/// The first node with this name, depth-first. MOCAP_NO_NODE if there is none; `mocap_error_text` then names the node.
///
/// # Safety
/// `scene` is an open scene, and `name` is a string that ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_find_node(scene: *const Scene, name: *const c_char) -> u32 {
    guard(MOCAP_NO_NODE, || {
        // SAFETY: the caller passes an open scene.
        let scene = unsafe { opened(scene) }?;
        // SAFETY: the caller passes a string with a zero byte at its end.
        let name = unsafe { text(name, "name") }?;
        scene.find_node(name)
    })
}

/// The number of animations of the file; 0 if the file has only a skeleton. BVH has at most one.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_animation_count(scene: *const Scene) -> u32 {
    // SAFETY: the caller passes an open scene.
    guard(0, || Ok(unsafe { opened(scene) }?.animation_count()))
}

/// The number of channels of an animation, one for each node that it moves; 0 if there is no such animation.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_channel_count(scene: *const Scene, animation: u32) -> usize {
    // SAFETY: the caller passes an open scene.
    unsafe { ask(scene, animation, 0, |animation| Ok(animation.data.channels.len())) }
}

/// The node that a channel moves. MOCAP_NO_NODE if there is no such channel or animation, or if the channel moves no
/// node; `mocap_error_text` then has the reason.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_channel_node(scene: *const Scene, animation: u32, channel: usize) -> u32 {
    // SAFETY: the caller passes an open scene.
    unsafe {
        ask(scene, animation, MOCAP_NO_NODE, |animation| {
            animation.channel_node(channel)
        })
    }
}

/// The duration of an animation in ticks, from the first frame to the last. In BVH a tick is a frame, so the duration
/// is the number of frames minus 1. 0 if there is no such animation.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_duration(scene: *const Scene, animation: u32) -> f64 {
    // SAFETY: the caller passes an open scene.
    unsafe { ask(scene, animation, 0.0, |animation| Ok(animation.data.duration)) }
}

/// Ticks per second; 0 if there is no such animation.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_ticks_per_second(scene: *const Scene, animation: u32) -> f64 {
    // SAFETY: the caller passes an open scene.
    unsafe { ask(scene, animation, 0.0, |animation| Ok(animation.data.ticks_per_second)) }
}

/// Writes the matrix of every node relative to its parent into `matrices`. Each matrix has 16 floats in column-major
/// order, as in OpenGL and Vulkan, and multiplies column vectors. `count` is the number of matrices that fit in
/// `matrices`, at least `mocap_node_count`. Lengths are in the unit of the scene; see `mocap_open_file`.
///
/// The pose between two keys is interpolated: positions and scales linearly, rotations along the shorter arc (slerp).
/// Ticks before 0 give the first pose, ticks after the end the last pose, and NaN gives tick 0. The call fails if there
/// is no such animation. For a scene without animations, call `mocap_rest_local_matrices`. The call allocates no
/// memory.
///
/// # Safety
/// `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_local_matrices(
    scene: *const Scene,
    animation: u32,
    tick: f64,
    matrices: *mut f32,
    count: usize,
) -> Status {
    // SAFETY: the caller passes an open scene and room for `count` matrices.
    unsafe {
        fill(scene, matrices, count, |scene, matrices| {
            scene.animation(animation)?.local_matrices(scene, tick, matrices);
            Ok(())
        })
    }
}

/// Like `mocap_local_matrices`, but writes the matrix of every node relative to the world: the coordinate frame of the
/// root's parent.
///
/// # Safety
/// `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_world_matrices(
    scene: *const Scene,
    animation: u32,
    tick: f64,
    matrices: *mut f32,
    count: usize,
) -> Status {
    // SAFETY: the caller passes an open scene and room for `count` matrices.
    unsafe {
        fill(scene, matrices, count, |scene, matrices| {
            scene.animation(animation)?.local_matrices(scene, tick, matrices);
            scene.chain(matrices);
            Ok(())
        })
    }
}

/// Like `mocap_local_matrices`, but writes the matrix of every node relative to its parent in the rest pose.
///
/// # Safety
/// `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_rest_local_matrices(scene: *const Scene, matrices: *mut f32, count: usize) -> Status {
    // SAFETY: the caller passes an open scene and room for `count` matrices.
    unsafe {
        fill(scene, matrices, count, |scene, matrices| {
            scene.rest(matrices);
            Ok(())
        })
    }
}

/// Like `mocap_local_matrices`, but writes the matrix of every node relative to the world in the rest pose.
///
/// # Safety
/// `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_rest_world_matrices(scene: *const Scene, matrices: *mut f32, count: usize) -> Status {
    // SAFETY: the caller passes an open scene and room for `count` matrices.
    unsafe {
        fill(scene, matrices, count, |scene, matrices| {
            scene.rest(matrices);
            scene.chain(matrices);
            Ok(())
        })
    }
}

/// A matrix in the caller's layout: column-major order.
type Matrix = [f32; 16];

/// The scene behind a handle.
///
/// # Safety
/// `scene` is NULL or an open scene.
unsafe fn opened<'a>(scene: *const Scene) -> Result<&'a Scene, Failure> {
    // SAFETY: the caller passes NULL or an open scene.
    unsafe { scene.as_ref() }.ok_or_else(|| Failure::argument("the scene is NULL"))
}

/// The text at a pointer.
///
/// # Safety
/// `text` is NULL or ends with a zero byte.
unsafe fn text<'a>(text: *const c_char, what: &str) -> Result<&'a CStr, Failure> {
    if text.is_null() {
        return Err(Failure::argument(&format!("{what} is NULL")));
    }
    // SAFETY: the text is not NULL, so it ends with a zero byte.
    Ok(unsafe { CStr::from_ptr(text) })
}

/// Converts a path: any bytes on Unix, UTF-8 on other systems.
fn path_from(text: &CStr) -> Result<&Path, Failure> {
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        Ok(Path::new(std::ffi::OsStr::from_bytes(text.to_bytes())))
    }
    #[cfg(not(unix))]
    {
        let text = text.to_str();
        text.map(Path::new)
            .map_err(|_| Failure::argument("the path is not UTF-8"))
    }
}

/// Calls a function with an animation; returns the default if there is no such animation.
///
/// # Safety
/// `scene` is NULL or an open scene.
unsafe fn ask<T>(
    scene: *const Scene,
    animation: u32,
    otherwise: T,
    question: impl FnOnce(&Animation) -> Result<T, Failure>,
) -> T {
    guard(otherwise, || {
        // SAFETY: the caller passes NULL or an open scene.
        let scene = unsafe { opened(scene) }?;
        question(&scene.animation(animation)?)
    })
}

/// Calls `write` to fill the caller's matrices, one for each node.
///
/// # Safety
/// `scene` is NULL or an open scene, and `matrices` is NULL or points to room for 16 x `count` floats.
unsafe fn fill(
    scene: *const Scene,
    matrices: *mut f32,
    count: usize,
    write: impl FnOnce(&Scene, &mut [Matrix]) -> Result<(), Failure>,
) -> Status {
    border::status(|| {
        // SAFETY: the caller passes NULL or an open scene.
        let scene = unsafe { opened(scene) }?;
        let needed = scene.nodes().len();
        if matrices.is_null() {
            return Err(Failure::argument("matrices is NULL"));
        }
        if count < needed {
            let message = format!("there is room for {count} matrices, and the scene has {needed} nodes");
            return Err(Failure::argument(&message));
        }
        // SAFETY: there is room for `count` matrices, at least `needed`. Zero bits are valid floats, and the caller's
        // memory is initialized with them. A float array has the alignment of a float.
        let matrices = unsafe {
            matrices.write_bytes(0, 16 * needed);
            slice::from_raw_parts_mut(matrices.cast::<Matrix>(), needed)
        };
        write(scene, matrices)
    })
}
