//! The motion of one humanoid on the skeleton of another, pose by pose.

use std::ffi::{CString, c_char};
use std::ptr;
use std::slice;

use mocap::Pose;
use mocap::glam::Mat4;
use mocap::retarget::{PoseRetargetOptions, Scale};

use crate::border::{self, Failure, Status, c_text, guard};
use crate::handle::Scene;
use crate::{Matrix, opened};

/// Moves poses of one skeleton onto another. Only pointers to it leave the library.
pub struct Retargeter {
    retargeter: mocap::retarget::PoseRetargeter,
    source: Pose,
    target: Pose,
    unmapped: Vec<CString>,
}

/// Prepares the motion of the skeleton of `source` onto that of `target`, both of them humanoids of any rest pose, unit
/// and axes. `scale` is how many times as long as those of the source the steps of the target are, in metres; 0: in the
/// proportion of the legs.
///
/// Returns NULL where one of the two is not a humanoid; `mocap_error_text` says which and why. The scenes may be closed
/// then: the retargeter needs them no more. `mocap_retargeter_free` frees it.
///
/// # Safety
/// `source` and `target` are open scenes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_retargeter_new(
    source: *const Scene,
    target: *const Scene,
    scale: f64,
) -> *mut Retargeter {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller hands over open scenes.
        let (source, target) = unsafe { (opened(source)?.scene(), opened(target)?.scene()) };
        let options = PoseRetargetOptions::new().scale(if scale == 0.0 {
            Scale::Auto
        } else {
            Scale::Factor(scale)
        });
        let retargeter = mocap::retarget::PoseRetargeter::new(source, target, &options)?;
        let unmapped = retargeter.unmapped().iter();
        let unmapped = unmapped.map(|lack| c_text(&format!("{}: {}", lack.bone.as_str(), lack.reason)));
        Ok(Box::into_raw(Box::new(Retargeter {
            unmapped: unmapped.collect(),
            source: Pose::rest(source),
            target: Pose::rest(target),
            retargeter,
        })))
    })
}

/// Frees a retargeter and every text that came from it. NULL is allowed.
///
/// # Safety
/// `retargeter` comes from `mocap_retargeter_new`, was not freed before, and is used by no other thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_retargeter_free(retargeter: *mut Retargeter) {
    guard((), || {
        if !retargeter.is_null() {
            // SAFETY: the pointer comes from `Box::into_raw`, and the caller gives it up.
            drop(unsafe { Box::from_raw(retargeter) });
        }
        Ok(())
    });
}

/// Puts a pose of the source on the target. `source` has the matrix of every node of the source to its parent, as
/// `mocap_local_matrices` writes them, or as they come from a live capture; `source_count` is how many. The matrices of
/// the target's nodes go to `local`, to their parents, and to `world`, to the world; either may be NULL. `count` is how
/// many matrices there is room for, at least the target's `mocap_node_count`. Nodes that nothing moves keep their rest
/// pose.
///
/// Nothing is allocated. One thread at a time may use a retargeter.
///
/// # Safety
/// `retargeter` is a retargeter that no other thread uses. `source` points to 16 x `source_count` floats. `local` and
/// `world` are NULL or point to room for 16 x `count` floats. They do not overlap with each other or with `source`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_retarget_pose(
    retargeter: *mut Retargeter,
    source: *const f32,
    source_count: usize,
    local: *mut f32,
    world: *mut f32,
    count: usize,
) -> Status {
    border::status(|| {
        // SAFETY: the caller hands over NULL or a retargeter that it alone uses.
        let retargeter = unsafe { retargeter.as_mut() };
        let retargeter = retargeter.ok_or_else(|| Failure::argument("the retargeter is NULL"))?;
        let to = retargeter.target.node_to_parent.len();
        if count < to {
            let message = format!("there is room for {count} matrices, and the target has {to} nodes");
            return Err(Failure::argument(&message));
        }
        // SAFETY: the caller hands over `source_count` matrices.
        unsafe { take(&mut retargeter.source, source, source_count) }?;
        retargeter.retargeter.pose(&retargeter.source, &mut retargeter.target);
        let pose = &retargeter.target;
        for (place, matrices) in [
            (local, pose.node_to_parent_arrays()),
            (world, pose.node_to_world_arrays()),
        ] {
            if !place.is_null() {
                // SAFETY: there is room for `count` matrices, which is no less than there are, and the caller's memory
                // does not overlap with that of the retargeter.
                unsafe { ptr::copy_nonoverlapping(matrices.as_ptr(), place.cast::<Matrix>(), to) };
            }
        }
        Ok(())
    })
}

/// How many bones are not moved from one skeleton to the other. `mocap_unmapped_text` says which and why.
///
/// # Safety
/// `retargeter` is a retargeter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_unmapped_count(retargeter: *const Retargeter) -> usize {
    // SAFETY: the caller hands over NULL or a retargeter.
    guard(0, || Ok(unsafe { known(retargeter) }?.unmapped.len()))
}

/// A bone that is not moved, from 0, with the reason, as in "jaw: the target has no such joint"; NULL beyond the last.
/// The text lives as long as the retargeter.
///
/// # Safety
/// `retargeter` is a retargeter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_unmapped_text(retargeter: *const Retargeter, bone: usize) -> *const c_char {
    guard(ptr::null(), || {
        // SAFETY: the caller hands over NULL or a retargeter.
        let unmapped = &unsafe { known(retargeter) }?.unmapped;
        let text = unmapped.get(bone);
        let text = text.ok_or_else(|| Failure::absent("unmapped bone", bone as u64, unmapped.len() as u64))?;
        Ok(text.as_ptr())
    })
}

/// Takes the matrices of all nodes to their parents into a pose.
///
/// # Safety
/// `source` is NULL or points to 16 x `count` floats.
pub(crate) unsafe fn take(pose: &mut Pose, source: *const f32, count: usize) -> Result<(), Failure> {
    let nodes = pose.node_to_parent.len();
    if source.is_null() {
        return Err(Failure::argument("source is NULL"));
    }
    if count != nodes {
        let message = format!("source has {count} matrices, and its scene has {nodes} nodes");
        return Err(Failure::argument(&message));
    }
    // SAFETY: the caller hands over `count` matrices, and a float array has the alignment of a float.
    let matrices = unsafe { slice::from_raw_parts(source.cast::<Matrix>(), nodes) };
    if matrices.iter().flatten().any(|number| !number.is_finite()) {
        return Err(Failure::argument("a number of source is not finite"));
    }
    for (node, matrix) in pose.node_to_parent.iter_mut().zip(matrices) {
        *node = Mat4::from_cols_array(matrix);
    }
    pose.update_world();
    Ok(())
}

/// # Safety
/// `retargeter` is NULL or a retargeter.
unsafe fn known<'a>(retargeter: *const Retargeter) -> Result<&'a Retargeter, Failure> {
    // SAFETY: the caller hands over NULL or a retargeter that lives.
    unsafe { retargeter.as_ref() }.ok_or_else(|| Failure::argument("the retargeter is NULL"))
}
