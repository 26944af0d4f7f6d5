//! Packed clips: decodes poses.

use std::ptr;
use std::slice;

use mocap::Trs;
use mocap::compress::PackedClip;
use mocap::glam::Mat4;

use crate::border::{self, Failure, Status, guard};

/// An open packed clip. Programs only hold pointers to this type.
pub struct Clip {
    clip: PackedClip<'static>,
    pose: Vec<Trs>,
    local: Vec<Mat4>,
    world: Vec<Mat4>,
}

/// Opens a packed clip, the `size` bytes of a file that `mocap convert walk.bvh walk.mclip` wrote. The bytes are
/// copied.
///
/// Returns NULL if the bytes are not a complete and valid packed clip; `mocap_error_text` has the reason. Free the clip
/// with `mocap_clip_close`.
///
/// # Safety
/// `bytes` points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_clip_open(bytes: *const u8, size: usize) -> *mut Clip {
    guard(ptr::null_mut(), || {
        if bytes.is_null() {
            return Err(Failure::argument("bytes is NULL"));
        }
        // SAFETY: the caller passes `size` bytes.
        let bytes = unsafe { slice::from_raw_parts(bytes, size) };
        let clip = PackedClip::new(bytes.to_vec())?;
        let nodes = clip.node_count();
        Ok(Box::into_raw(Box::new(Clip {
            clip,
            pose: vec![Trs::IDENTITY; nodes],
            local: vec![Mat4::IDENTITY; nodes],
            world: vec![Mat4::IDENTITY; nodes],
        })))
    })
}

/// Frees a packed clip. NULL is allowed.
///
/// # Safety
/// `clip` comes from `mocap_clip_open`, was not freed before, and is used by no other thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_clip_close(clip: *mut Clip) {
    guard((), || {
        if !clip.is_null() {
            // SAFETY: the pointer comes from `Box::into_raw`, and the caller gives it up.
            drop(unsafe { Box::from_raw(clip) });
        }
        Ok(())
    });
}

/// The number of nodes of a packed clip, in the order of its source file; 0 for NULL.
///
/// # Safety
/// `clip` is NULL or an open packed clip.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_clip_node_count(clip: *const Clip) -> u32 {
    // SAFETY: the caller passes NULL or an open clip.
    guard(0, || Ok(unsafe { opened(clip) }?.clip.node_count() as u32))
}

/// The last tick of a packed clip; 0 for NULL.
///
/// # Safety
/// `clip` is NULL or an open packed clip.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_clip_duration(clip: *const Clip) -> f64 {
    // SAFETY: the caller passes NULL or an open clip.
    guard(0.0, || Ok(unsafe { opened(clip) }?.clip.duration()))
}

/// Ticks per second of a packed clip; 0 for NULL.
///
/// # Safety
/// `clip` is NULL or an open packed clip.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_clip_ticks_per_second(clip: *const Clip) -> f64 {
    // SAFETY: the caller passes NULL or an open clip.
    guard(0.0, || Ok(unsafe { opened(clip) }?.clip.ticks_per_second()))
}

/// Decodes the pose at `tick`. `local` gets the matrices of all nodes relative to their parents, and `world` the
/// matrices relative to the world; either may be NULL. `count` is the number of matrices that fit in each buffer, at
/// least `mocap_clip_node_count`.
///
/// The call allocates no memory. Only one thread at a time may use a packed clip.
///
/// # Safety
/// `clip` is a packed clip that no other thread uses, and `local` and `world` are NULL or point to room for 16 x
/// `count` floats, which do not overlap.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_clip_pose(
    clip: *mut Clip,
    tick: f64,
    local: *mut f32,
    world: *mut f32,
    count: usize,
) -> Status {
    border::status(|| {
        // SAFETY: the caller passes NULL or a clip that it alone uses.
        let clip = unsafe { clip.as_mut() }.ok_or_else(|| Failure::argument("the clip is NULL"))?;
        let nodes = clip.pose.len();
        if count < nodes {
            let message = format!("there is room for {count} matrices, and the clip has {nodes} nodes");
            return Err(Failure::argument(&message));
        }
        clip.clip.sample(tick, &mut clip.pose);
        for (node, trs) in clip.pose.iter().enumerate() {
            clip.local[node] = trs.matrix();
            clip.world[node] = match clip.clip.parent(node) {
                None => clip.local[node],
                Some(parent) => clip.world[parent] * clip.local[node],
            };
        }
        for (place, matrices) in [(local, &clip.local), (world, &clip.world)] {
            if !place.is_null() {
                // SAFETY: there is room for `count` matrices, at least the number of nodes. A matrix of glam is sixteen
                // floats in column-major order.
                unsafe { ptr::copy_nonoverlapping(matrices.as_ptr().cast::<f32>(), place, 16 * nodes) };
            }
        }
        Ok(())
    })
}

/// The clip at a pointer.
///
/// # Safety
/// `clip` is NULL or an open packed clip.
unsafe fn opened<'a>(clip: *const Clip) -> Result<&'a Clip, Failure> {
    // SAFETY: the caller passes NULL or an open clip.
    unsafe { clip.as_ref() }.ok_or_else(|| Failure::argument("the clip is NULL"))
}
