//! The functions that the npm package calls: WebAssembly without imports and without generated bindings.
//!
//! A call has a request (JSON in UTF-8) and files. [`mocap_input`] allocates memory for each, the request first.
//! [`mocap_call`] answers with JSON, and with the bytes of a written file. The module keeps scenes by number. An answer
//! has the addresses of keys and matrices, and JavaScript reads them as typed arrays without a copy. A scene never
//! changes, so the addresses are valid until the scene is freed.
//!
//! WebAssembly without exceptions ends the module at a panic. [`mocap_panic`] then returns the message.

#![allow(unsafe_code, reason = "exported names")]
// Only tests may call `unwrap`.
#![warn(clippy::unwrap_used)]

mod answer;
mod clips;
mod controllers;
mod failure;
mod given;
mod keys;
mod laboratory;
mod names;
mod options;
mod request;
mod robot_streams;
mod scenes;
mod state;
#[cfg(target_family = "wasm")]
mod ufbx_libc;
mod writing;

use std::sync::{Mutex, Once};

use mocap::glam::Vec2;

use crate::state::{State, with_state};

/// The version of the package.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The message of the last panic.
static PANIC: Mutex<String> = Mutex::new(String::new());

/// Stores the message of a panic, because WebAssembly cannot print.
fn remember_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        std::panic::set_hook(Box::new(|info| {
            if let Ok(mut message) = PANIC.lock() {
                *message = info.to_string();
            }
        }));
    });
}

/// Allocates `length` bytes for the next input: the request or a file. Null without enough memory.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_input(length: usize) -> *mut u8 {
    mocap::spell_options(names::spelling);
    with_state(|state| state.input(length)).unwrap_or(std::ptr::null_mut())
}

/// Executes the request, which is the first input, and frees the inputs. Returns 0 on success. Returns 1 on failure;
/// the answer has the reason.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_call() -> u32 {
    if cfg!(target_family = "wasm") {
        remember_panics();
    }
    with_state(State::call).map_or(1, |done| u32::from(!done))
}

/// Like `mocap_call`, for requests that the drop page never makes. `page/lean_code.js` removes this function from the
/// module of the drop page, with all code that only this function needs.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_call_other() -> u32 {
    if cfg!(target_family = "wasm") {
        remember_panics();
    }
    with_state(State::call_other).map_or(1, |done| u32::from(!done))
}

/// The address of the JSON (0) or of the bytes (1) of the last answer. Both are valid until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_output(part: u32) -> *const u8 {
    with_state(|state| state.output(part).as_ptr()).unwrap_or(std::ptr::null())
}

/// The length in bytes of the JSON (0) or of the bytes (1).
#[unsafe(no_mangle)]
pub extern "C" fn mocap_output_length(part: u32) -> usize {
    with_state(|state| state.output(part).len()).unwrap_or(0)
}

/// Poses a scene. Returns the address of the world matrices of the nodes, 16 numbers each, in column-major order. The
/// matrices are valid until the scene is posed again. Null if there is no such scene or animation.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_pose(scene: u32, animation: u32, tick: f64) -> *const f32 {
    let posed = with_state(|state| {
        state
            .scenes
            .get_mut(scene)?
            .pose(animation, tick)
            .map(<[[f32; 16]]>::as_ptr)
    });
    posed.flatten().map_or(std::ptr::null(), <*const [f32; 16]>::cast)
}

/// The matrices of the same pose relative to the parents.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_pose_to_parent(scene: u32) -> *const f32 {
    let posed = with_state(|state| Some(state.scenes.get_mut(scene)?.to_parent().as_ptr()));
    posed.flatten().map_or(std::ptr::null(), <*const [f32; 16]>::cast)
}

/// Frees a scene. Ignores an unknown number.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_free(scene: u32) {
    with_state(|state| state.scenes.free(scene));
}

/// Computes the pose of a packed clip at a tick: translation, rotation and scale of each node, ten numbers. The pose
/// goes to the address in the answer that opened the clip. Returns 0 if there is no such clip. Allocates no memory.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_clip_sample(clip: u32, tick: f64) -> u32 {
    with_state(|state| u32::from(state.clips.sample(clip, tick))).unwrap_or(0)
}

/// Frees a packed clip. Ignores an unknown number.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_clip_free(clip: u32) {
    with_state(|state| state.clips.free(clip));
}

/// Advances a figure by one frame. The pose goes to the address in the answer that made the figure. The input is a
/// velocity along x and z, in m/s, and a facing. If the facing is zero, the figure faces the direction of its velocity.
/// Returns 0 if there is no such figure. Allocates no memory.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_controller_steer(figure: u32, x: f32, z: f32, look_x: f32, look_z: f32) -> u32 {
    let (velocity, look) = (Vec2::new(x, z), Vec2::new(look_x, look_z));
    with_state(|state| u32::from(state.controllers.steer(figure, velocity, look))).unwrap_or(0)
}

/// Like [`mocap_controller_steer`], towards the trajectory at the address in the answer that made the figure.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_controller_follow(figure: u32) -> u32 {
    with_state(|state| u32::from(state.controllers.follow(figure))).unwrap_or(0)
}

/// Frees a figure. Ignores an unknown number.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_controller_free(figure: u32) {
    with_state(|state| state.controllers.free(figure));
}

/// Frees a robot stream. Ignores an unknown number.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_robot_stream_free(stream: u32) {
    with_state(|state| state.robot_streams.free(stream));
}

/// After a panic: the address of its message.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_panic() -> *const u8 {
    PANIC.lock().map_or(std::ptr::null(), |message| message.as_ptr())
}

/// The length of the message in bytes; 0 if the module ended by a lack of memory instead of a panic.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_panic_length() -> usize {
    PANIC.lock().map_or(0, |message| message.len())
}
