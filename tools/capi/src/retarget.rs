//! Retargets the motion of a humanoid to another humanoid, pose by pose.

use std::ffi::{CString, c_char};
use std::ptr;
use std::slice;

use mocap::Pose;
use mocap::glam::Mat4;
use mocap::retarget::{PoseRetargetOptions, Scale};

use crate::border::{self, Failure, Status, c_text, guard};
use crate::handle::Scene;
use crate::{Matrix, opened};

/// Retargets poses from one skeleton to another. Programs only hold pointers to this type.
pub struct Retargeter {
    retargeter: mocap::retarget::PoseRetargeter,
    source: Pose,
    target: Pose,
    unmapped: Vec<CString>,
}

/// Prepares to retarget poses from the skeleton of `source` to the skeleton of `target`. Both are humanoids with any
/// rest pose, unit and axes. `scale` is the length of the target's steps relative to the source's steps, both in
/// metres; 0: the ratio of the leg lengths.
///
/// Returns NULL if one of the two is not a humanoid; `mocap_error_text` has the reason. You may close the scenes after
/// this call. Free the retargeter with `mocap_retargeter_free`.
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
        // SAFETY: the caller passes open scenes.
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

/// Retargets a pose. `source` has the matrix of every node of the source relative to its parent, from
/// `mocap_local_matrices` or from a live capture; `source_count` is their number. `local` gets the matrices of the
/// target's nodes relative to their parents, and `world` the matrices relative to the world; either may be NULL.
/// `count` is the number of matrices that fit in each buffer, at least the target's `mocap_node_count`. Nodes without
/// motion keep their rest pose.
///
/// The call allocates no memory. Only one thread at a time may use a retargeter.
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
        // SAFETY: the caller passes NULL or a retargeter that it alone uses.
        let retargeter = unsafe { retargeter.as_mut() };
        let retargeter = retargeter.ok_or_else(|| Failure::argument("the retargeter is NULL"))?;
        let to = retargeter.target.node_to_parent.len();
        if count < to {
            let message = format!("there is room for {count} matrices, and the target has {to} nodes");
            return Err(Failure::argument(&message));
        }
        // SAFETY: the caller passes `source_count` matrices.
        unsafe { take(&mut retargeter.source, source, source_count) }?;
        retargeter.retargeter.pose(&retargeter.source, &mut retargeter.target);
        let pose = &retargeter.target;
        for (place, matrices) in [
            (local, pose.node_to_parent_arrays()),
            (world, pose.node_to_world_arrays()),
        ] {
            if !place.is_null() {
                // SAFETY: there is room for `count` matrices, at least the number of nodes, and the caller's memory
                // does not overlap the retargeter.
                unsafe { ptr::copy_nonoverlapping(matrices.as_ptr(), place.cast::<Matrix>(), to) };
            }
        }
        Ok(())
    })
}

/// The number of bones that are not retargeted. `mocap_unmapped_text` returns each of them with the reason.
///
/// # Safety
/// `retargeter` is a retargeter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_unmapped_count(retargeter: *const Retargeter) -> usize {
    // SAFETY: the caller passes NULL or a retargeter.
    guard(0, || Ok(unsafe { known(retargeter) }?.unmapped.len()))
}

/// A bone that is not retargeted, counted from 0, with the reason, such as "jaw: the target has no such joint"; NULL
/// beyond the last. The text lives as long as the retargeter.
///
/// # Safety
/// `retargeter` is a retargeter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_unmapped_text(retargeter: *const Retargeter, bone: usize) -> *const c_char {
    guard(ptr::null(), || {
        // SAFETY: the caller passes NULL or a retargeter.
        let unmapped = &unsafe { known(retargeter) }?.unmapped;
        let text = unmapped.get(bone);
        let text = text.ok_or_else(|| Failure::absent("unmapped bone", bone as u64, unmapped.len() as u64))?;
        Ok(text.as_ptr())
    })
}

/// Copies the matrices of all nodes relative to their parents into a pose.
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
    // SAFETY: the caller passes `count` matrices, and a float array has the alignment of a float.
    let matrices = unsafe { slice::from_raw_parts(source.cast::<Matrix>(), nodes) };
    if matrices.iter().flatten().any(|number| !number.is_finite()) {
        return Err(Failure::argument("a number in source is not finite"));
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
    // SAFETY: the caller passes NULL or a retargeter that lives.
    unsafe { retargeter.as_ref() }.ok_or_else(|| Failure::argument("the retargeter is NULL"))
}
