//! The C interface of `mocap`.
//!
//! `mocap.h` is made from this file, so the comments here speak to a reader of the header. What the functions share,
//! the handle and the wall that no panic passes, stands in `handle` and `border`.

#![allow(unsafe_code, reason = "pointers of other languages go in and out")]
#![deny(clippy::missing_safety_doc, clippy::undocumented_unsafe_blocks)]
// Tests may unwrap; the library may not.
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
pub use crate::run::{mocap_run, mocap_text_free, mocap_verify};
pub use crate::table::{
    Table, mocap_report, mocap_table_column_count, mocap_table_free, mocap_table_name, mocap_table_new,
    mocap_table_rate, mocap_table_row_count, mocap_table_unit, mocap_table_values,
};

/// The version of this interface. It grows when a program that was compiled against an older header may break;
/// compare it with `mocap_interface_version`.
pub const MOCAP_INTERFACE_VERSION: u32 = 1;

/// The index that stands for no node: the parent of the root, and the answer where nothing is found.
pub const MOCAP_NO_NODE: u32 = 0xFFFF_FFFF;

/// The interface version of the library that the program runs with.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_interface_version() -> u32 {
    MOCAP_INTERFACE_VERSION
}

/// The version of the library, as in "0.1.0". The text is never freed.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_version() -> *const c_char {
    const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => panic!("a version has no zero byte"),
    };
    VERSION.as_ptr()
}

/// Why the last call of this thread failed, in UTF-8; empty if it did not.
///
/// The text belongs to the thread, and has at most 4,095 bytes. It stays unchanged until the thread's next call that
/// fails. A call that succeeds, also one in the same expression, does not change it. Its memory is never freed: a
/// pointer that is kept longer shows the text of a later failure, and cannot dangle. Copy the text to keep it. Each
/// thread sees its own failures alone.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_error_text() -> *const c_char {
    border::last_failure()
}

/// Frees a scene and every text that came from it. NULL is allowed.
///
/// # Safety
/// `scene` comes from `mocap_open_file` or `mocap_open_memory`, was not closed before, and is used by no other thread.
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

/// How many things the reader read around. `mocap_warning_text` says what they are.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_warning_count(scene: *const Scene) -> usize {
    // SAFETY: the caller hands over an open scene.
    guard(0, || Ok(unsafe { opened(scene) }?.warnings.len()))
}

/// What the reader read around, from 0 in the order of the file; NULL beyond the last. The text lives as long as the
/// scene.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_warning_text(scene: *const Scene, warning: usize) -> *const c_char {
    guard(ptr::null(), || {
        // SAFETY: the caller hands over an open scene.
        let scene = unsafe { opened(scene) }?;
        let text = scene.warnings.get(warning);
        let text = text.ok_or_else(|| Failure::absent("warning", warning as u64, scene.warnings.len() as u64))?;
        Ok(text.as_ptr())
    })
}

/// How many nodes the skeleton has, its end sites included. Node 0 is the root; a parent has a smaller index than its
/// children.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_node_count(scene: *const Scene) -> u32 {
    // SAFETY: the caller hands over an open scene.
    guard(0, || Ok(unsafe { opened(scene) }?.node_count()))
}

/// The name of a node, in UTF-8; NULL if there is no such node. The text lives as long as the scene.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_node_name(scene: *const Scene, node: u32) -> *const c_char {
    guard(ptr::null(), || {
        // SAFETY: the caller hands over an open scene.
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
        // SAFETY: the caller hands over an open scene.
        let parent = unsafe { opened(scene) }?.node(node)?.parent;
        Ok(parent.map_or(MOCAP_NO_NODE, |parent| parent.0))
    })
}

/// The first node of this name, depth-first; MOCAP_NO_NODE if there is none, and then `mocap_error_text` says so.
///
/// # Safety
/// `scene` is an open scene, and `name` is a text that ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_find_node(scene: *const Scene, name: *const c_char) -> u32 {
    guard(MOCAP_NO_NODE, || {
        // SAFETY: the caller hands over an open scene.
        let scene = unsafe { opened(scene) }?;
        // SAFETY: the caller hands over a text with a zero byte at its end.
        let name = unsafe { text(name, "name") }?;
        scene.find_node(name)
    })
}

/// How many animations the file has; 0 if it is a skeleton alone. BVH has at most one.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_animation_count(scene: *const Scene) -> u32 {
    // SAFETY: the caller hands over an open scene.
    guard(0, || Ok(unsafe { opened(scene) }?.animation_count()))
}

/// How many channels an animation has, one for each node that it moves; 0 if there is no such animation.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_channel_count(scene: *const Scene, animation: u32) -> usize {
    // SAFETY: the caller hands over an open scene.
    unsafe { ask(scene, animation, 0, |animation| Ok(animation.data.channels.len())) }
}

/// The node that a channel moves. MOCAP_NO_NODE if there is no such channel or animation, and if the channel moves no
/// node; then `mocap_error_text` says which.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_channel_node(scene: *const Scene, animation: u32, channel: usize) -> u32 {
    // SAFETY: the caller hands over an open scene.
    unsafe {
        ask(scene, animation, MOCAP_NO_NODE, |animation| {
            animation.channel_node(channel)
        })
    }
}

/// The length of an animation in ticks, from the first frame to the last; in BVH a tick is a frame, so this is one
/// less than there are frames. 0 if there is no such animation.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_duration(scene: *const Scene, animation: u32) -> f64 {
    // SAFETY: the caller hands over an open scene.
    unsafe { ask(scene, animation, 0.0, |animation| Ok(animation.data.duration)) }
}

/// Ticks in a second; 0 if there is no such animation.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_ticks_per_second(scene: *const Scene, animation: u32) -> f64 {
    // SAFETY: the caller hands over an open scene.
    unsafe { ask(scene, animation, 0.0, |animation| Ok(animation.data.ticks_per_second)) }
}

/// Writes the matrix of every node to its parent into `matrices`: 16 floats a node, column after column, as OpenGL and
/// Vulkan read them; they map column vectors. `count` is how many matrices there is room for, at least
/// `mocap_node_count`. `mocap_open_file` says what unit lengths are in.
///
/// Between two keys the pose is interpolated: positions and scales on a line, rotations on the shorter arc of the
/// sphere. Before tick 0 the first pose holds, after the last tick the last; a tick that is NaN stands for 0. With an
/// animation that is not there the call fails; a scene without any is asked by `mocap_rest_local_matrices`. Nothing is
/// allocated.
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
    // SAFETY: the caller hands over an open scene and room for `count` matrices.
    unsafe {
        fill(scene, matrices, count, |scene, matrices| {
            scene.animation(animation)?.local_matrices(scene, tick, matrices);
            Ok(())
        })
    }
}

/// Writes the matrix of every node to the world, that is to the space in which the root stands. Otherwise as
/// `mocap_local_matrices`.
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
    // SAFETY: the caller hands over an open scene and room for `count` matrices.
    unsafe {
        fill(scene, matrices, count, |scene, matrices| {
            scene.animation(animation)?.local_matrices(scene, tick, matrices);
            scene.chain(matrices);
            Ok(())
        })
    }
}

/// Writes the matrix of every node to its parent in the rest pose, without motion. Otherwise as
/// `mocap_local_matrices`.
///
/// # Safety
/// `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_rest_local_matrices(scene: *const Scene, matrices: *mut f32, count: usize) -> Status {
    // SAFETY: the caller hands over an open scene and room for `count` matrices.
    unsafe {
        fill(scene, matrices, count, |scene, matrices| {
            scene.rest(matrices);
            Ok(())
        })
    }
}

/// Writes the matrix of every node to the world in the rest pose, without motion. Otherwise as
/// `mocap_local_matrices`.
///
/// # Safety
/// `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_rest_world_matrices(scene: *const Scene, matrices: *mut f32, count: usize) -> Status {
    // SAFETY: the caller hands over an open scene and room for `count` matrices.
    unsafe {
        fill(scene, matrices, count, |scene, matrices| {
            scene.rest(matrices);
            scene.chain(matrices);
            Ok(())
        })
    }
}

/// A matrix as the caller stores it: column after column.
type Matrix = [f32; 16];

/// The scene behind a handle.
///
/// # Safety
/// `scene` is NULL or an open scene.
unsafe fn opened<'a>(scene: *const Scene) -> Result<&'a Scene, Failure> {
    // SAFETY: the caller hands over NULL or a scene that lives.
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

/// A path is bytes on Unix, and UTF-8 elsewhere.
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
        // SAFETY: the caller hands over NULL or an open scene.
        let scene = unsafe { opened(scene) }?;
        question(&scene.animation(animation)?)
    })
}

/// Lets `write` fill the caller's matrices, one a node.
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
        // SAFETY: the caller hands over NULL or an open scene.
        let scene = unsafe { opened(scene) }?;
        let needed = scene.nodes().len();
        if matrices.is_null() {
            return Err(Failure::argument("matrices is NULL"));
        }
        if count < needed {
            let message = format!("there is room for {count} matrices, and the scene has {needed} nodes");
            return Err(Failure::argument(&message));
        }
        // SAFETY: there is room for `count` matrices, which is no less than `needed`. Zero bits make floats, and the
        // caller's memory is written once to hold them. A float array has the alignment of a float.
        let matrices = unsafe {
            matrices.write_bytes(0, 16 * needed);
            slice::from_raw_parts_mut(matrices.cast::<Matrix>(), needed)
        };
        write(scene, matrices)
    })
}
