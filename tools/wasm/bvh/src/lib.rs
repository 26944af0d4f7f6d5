//! The small module of the npm package, which only converts BVH to GLB.
//!
//! [`mocap_bvh_input`] allocates memory for the file. [`mocap_bvh_to_glb`] converts the file as `mocap convert` does.
//! [`mocap_bvh_output`] returns the address of the answer.

#![allow(unsafe_code, reason = "exported names")]

use std::sync::{Mutex, MutexGuard, PoisonError};

use mocap::gltf::GltfOptions;
use mocap::{Conversion, Error, Importer, Limits, SkeletonMesh};

/// The limits of the reader. WebAssembly has at most 4 GiB of memory, which must hold the file, its scene and the
/// output at the same time.
fn limits() -> Limits {
    Limits::new().max_bytes(512 << 20).max_values(1 << 26)
}

/// The input file, and then the answer: the output file, or an error as JSON.
static BYTES: Mutex<Vec<u8>> = Mutex::new(Vec::new());

fn bytes() -> MutexGuard<'static, Vec<u8>> {
    BYTES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Allocates memory for a file. Null without enough memory.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_bvh_input(length: usize) -> *mut u8 {
    let mut room = Vec::new();
    if room.try_reserve_exact(length).is_err() {
        return std::ptr::null_mut();
    }
    room.resize(length, 0);
    let mut bytes = bytes();
    *bytes = room;
    bytes.as_mut_ptr()
}

/// Converts the file to GLB. Returns 0 on success. Returns 1 on failure; the answer has the reason. `has_mesh` draws
/// the skeleton as a mesh.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_bvh_to_glb(has_mesh: u32) -> u32 {
    let file = std::mem::take(&mut *bytes());
    let made = glb_of(&file, has_mesh != 0);
    let failed = made.is_err();
    *bytes() = made.unwrap_or_else(|error| serde_json::to_vec(error.diagnostic()).unwrap_or_default());
    u32::from(failed)
}

/// The address of the answer, valid until the next file.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_bvh_output() -> *const u8 {
    bytes().as_ptr()
}

/// The length of the answer in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_bvh_output_length() -> usize {
    bytes().len()
}

fn glb_of(file: &[u8], has_mesh: bool) -> Result<Vec<u8>, Error> {
    let mesh = if has_mesh {
        SkeletonMesh::Skinned
    } else {
        SkeletonMesh::None
    };
    let importer = Importer::new()
        .threads(1)
        .limits(limits())
        .hash(false)
        .skeleton_mesh(mesh);
    let mut scene = importer.read_bvh(file, "motion.bvh")?;
    Conversion::new().apply(&mut scene)?;
    GltfOptions::new().write_glb(&scene)
}
