//! What the npm package calls: WebAssembly without imports, and without a generator of bindings.
//!
//! A call is a request and its files: JSON in UTF-8, and bytes. [`mocap_input`] makes room for each, the request first,
//! and [`mocap_call`] answers with JSON and, where a file was written, with its bytes. Scenes stay here under numbers.
//! Their keys and matrices are not copied: an answer names their addresses, which JavaScript reads as typed arrays. A
//! scene never changes, so they are valid until it is freed.
//!
//! The module ends at a panic, as WebAssembly does without exceptions. [`mocap_panic`] then says what it was.

#![allow(unsafe_code, reason = "exported names")]
// Tests may unwrap; the library may not.
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

/// What the last panic said.
static PANIC: Mutex<String> = Mutex::new(String::new());

/// Remembers what a panic says, for nothing can be printed.
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

/// Makes room for the next input, a request or a file of `length` bytes. Null where there is no memory for it.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_input(length: usize) -> *mut u8 {
    mocap::spell_options(names::spelling);
    with_state(|state| state.input(length)).unwrap_or(std::ptr::null_mut())
}

/// Does what the first input, a request, asks for, and frees the inputs. 0: done; 1: it failed, and the answer says
/// why.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_call() -> u32 {
    if cfg!(target_family = "wasm") {
        remember_panics();
    }
    with_state(State::call).map_or(1, |done| u32::from(!done))
}

/// Does, as `mocap_call` does, a request that no page makes. `page/lean_code.js` leaves this function out of the module
/// of the drop page, with all that it alone needs.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_call_other() -> u32 {
    if cfg!(target_family = "wasm") {
        remember_panics();
    }
    with_state(State::call_other).map_or(1, |done| u32::from(!done))
}

/// The address of the JSON (0) or of the bytes (1) of the last answer. They stay until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_output(part: u32) -> *const u8 {
    with_state(|state| state.output(part).as_ptr()).unwrap_or(std::ptr::null())
}

/// How many bytes there are.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_output_length(part: u32) -> usize {
    with_state(|state| state.output(part).len()).unwrap_or(0)
}

/// Poses a scene: the address of the matrices from the nodes to the world, 16 numbers each, column by column. They stay
/// until the scene is posed again. Null where there is no such scene or animation.
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

/// The same pose, from the nodes to their parents.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_pose_to_parent(scene: u32) -> *const f32 {
    let posed = with_state(|state| Some(state.scenes.get_mut(scene)?.to_parent().as_ptr()));
    posed.flatten().map_or(std::ptr::null(), <*const [f32; 16]>::cast)
}

/// Frees a scene. A number that is no scene is passed over.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_free(scene: u32) {
    with_state(|state| state.scenes.free(scene));
}

/// Computes the pose of a packed clip at a tick, where the answer that opened it says: translation, rotation and scale
/// of each node, ten numbers. 0 where there is no such clip. Nothing is allocated.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_clip_sample(clip: u32, tick: f64) -> u32 {
    with_state(|state| u32::from(state.clips.sample(clip, tick))).unwrap_or(0)
}

/// Frees a packed clip. A number that is no clip is passed over.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_clip_free(clip: u32) {
    with_state(|state| state.clips.free(clip));
}

/// Advances a figure by a frame. The pose goes to the address in the answer that made the figure. The input is a
/// velocity along x and z, in metres per second, and a facing. If the facing is zero, the figure faces its velocity. 0
/// where there is no such figure. Nothing is allocated.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_controller_steer(figure: u32, x: f32, z: f32, look_x: f32, look_z: f32) -> u32 {
    let (velocity, look) = (Vec2::new(x, z), Vec2::new(look_x, look_z));
    with_state(|state| u32::from(state.controllers.steer(figure, velocity, look))).unwrap_or(0)
}

/// The same towards the trajectory that was written where the answer says.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_controller_follow(figure: u32) -> u32 {
    with_state(|state| u32::from(state.controllers.follow(figure))).unwrap_or(0)
}

/// Frees a figure. A number that is no figure is passed over.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_controller_free(figure: u32) {
    with_state(|state| state.controllers.free(figure));
}

/// Frees a stream on a robot. A number that is no stream is passed over.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_robot_stream_free(stream: u32) {
    with_state(|state| state.robot_streams.free(stream));
}

/// After the module has ended: the address of what the panic said.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_panic() -> *const u8 {
    PANIC.lock().map_or(std::ptr::null(), |message| message.as_ptr())
}

/// How many bytes it is; 0 where it was no panic, but a lack of memory.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_panic_length() -> usize {
    PANIC.lock().map_or(0, |message| message.len())
}
