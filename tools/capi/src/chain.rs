//! The separate matrices of a chain.

use std::ffi::c_char;

use mocap::{ChainMatrix as Link, Pose};

use crate::border::{Failure, guard};
use crate::handle::Scene;
use crate::{opened, text};

/// A matrix of the chain from the root to a joint, T = J0 L1 J1 L2 J2 ..., in the notation of animation courses. A link
/// L is the translation of a joint relative to its parent. A joint J is the rotation of the joint. J0 also has the
/// translation of the root.
#[repr(C)]
pub struct ChainMatrix {
    /// `J` or `L`.
    pub letter: c_char,
    /// The number after the letter.
    pub index: u32,
    /// The node of the joint or the end site.
    pub node: u32,
    /// The matrix in column-major order; it multiplies column vectors.
    pub matrix: [f32; 16],
    /// The product of the chain up to this matrix. The last product maps from the joint to the world.
    pub product: [f32; 16],
}

/// Writes the matrices of the chain from the root to `joint`, the name of a node, at `tick`. Writes at most `count`
/// matrices. Returns the number of matrices in the chain, or 0 if the call fails. With `matrices` NULL and `count` 0,
/// the call only returns the number.
///
/// `point` is NULL, or three numbers in the coordinate frame of the joint; `point_in_world` then gets its world
/// position. In a scene without animations, the chain has the rest pose. For ticks, see `mocap_local_matrices`.
///
/// # Safety
/// `scene` is an open scene, `joint` a string, and `matrices` points to room for `count` matrices. `point` and
/// `point_in_world` are NULL or point to three floats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_chain(
    scene: *const Scene,
    animation: u32,
    tick: f64,
    joint: *const c_char,
    point: *const f32,
    point_in_world: *mut f32,
    matrices: *mut ChainMatrix,
    count: usize,
) -> usize {
    guard(0, || {
        // SAFETY: the caller passes an open scene.
        let scene = unsafe { opened(scene) }?;
        // SAFETY: the caller passes a string.
        let joint = unsafe { text(joint, "joint") }?.to_string_lossy();
        if scene.animation_count() > 0 {
            scene.animation(animation)?;
        }
        let posed = scene.scene();
        let pose = Pose::at_tick(posed, animation as usize, tick).unwrap_or_else(|| Pose::rest(posed));
        let chain = pose.chain(posed, &joint)?;
        if !point.is_null() {
            if point_in_world.is_null() {
                return Err(Failure::argument("point_in_world is NULL"));
            }
            let end = chain.last().ok_or_else(|| Failure::argument("the chain is empty"))?;
            // SAFETY: the caller passes three floats.
            let point = unsafe { point.cast::<[f32; 3]>().read() };
            let in_world = pose.point_to_world(end.node, point.into());
            // SAFETY: the caller passes room for three floats.
            unsafe { point_in_world.cast::<[f32; 3]>().write(in_world.to_array()) };
        }
        if count > 0 && matrices.is_null() {
            return Err(Failure::argument("matrices is NULL"));
        }
        for (index, link) in chain.iter().take(count).enumerate() {
            // SAFETY: the caller passes room for `count` matrices.
            unsafe { matrices.add(index).write(in_c(link)) };
        }
        Ok(chain.len())
    })
}

fn in_c(link: &Link) -> ChainMatrix {
    let (letter, index) = link.symbol.split_at(1);
    ChainMatrix {
        letter: letter.as_bytes()[0] as c_char,
        index: index.parse().unwrap_or_default(),
        node: link.node.0,
        matrix: link.matrix.to_cols_array(),
        product: link.product.to_cols_array(),
    }
}
