//! BVH to GLB, and nothing else: the small module of the npm package.
//!
//! [`mocap_bvh_input`] makes room for the file, [`mocap_bvh_to_glb`] turns it into the file of `mocap convert`, and the
//! answer lies where [`mocap_bvh_output`] says.

#![allow(unsafe_code, reason = "exported names")]

use std::sync::{Mutex, MutexGuard, PoisonError};

use mocap::gltf::GltfOptions;
use mocap::{Conversion, Error, Importer, Limits, SkeletonMesh};

/// WebAssembly has 4 GiB of memory at most, in which the file, its scene and what is written of it stand beside each
/// other.
fn limits() -> Limits {
    Limits::new().max_bytes(512 << 20).max_values(1 << 26)
}

/// The file that is read, and then the answer: the file that was made, or JSON of what is wrong.
static BYTES: Mutex<Vec<u8>> = Mutex::new(Vec::new());

fn bytes() -> MutexGuard<'static, Vec<u8>> {
    BYTES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes room for a file. Null where there is no memory for it.
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

/// Makes the GLB of the file. 0: done; 1: it failed, and the answer says why. `has_mesh` draws the skeleton as a mesh.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_bvh_to_glb(has_mesh: u32) -> u32 {
    let file = std::mem::take(&mut *bytes());
    let made = glb_of(&file, has_mesh != 0);
    let failed = made.is_err();
    *bytes() = made.unwrap_or_else(|error| serde_json::to_vec(error.diagnostic()).unwrap_or_default());
    u32::from(failed)
}

/// The address of the answer. It stays until the next file.
#[unsafe(no_mangle)]
pub extern "C" fn mocap_bvh_output() -> *const u8 {
    bytes().as_ptr()
}

/// How many bytes it is.
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
