//! Reads files.

use std::ffi::c_char;
use std::ptr;
use std::slice;

use mocap::Importer;
use mocap::job::InputOptions;

use crate::border::{Failure, guard};
use crate::handle::Scene;
use crate::{path_from, text};

/// Reads a motion file. Returns NULL if reading fails; `mocap_error_text` has the reason, with line and column.
///
/// The formats, detected from the contents, or else from the extension:
///
/// - BVH (`.bvh`) and Acclaim (`.amc` with an `.asf` in the same folder, or `.asf` alone): lengths in the file's unit.
/// - C3D (`.c3d`): markers, each a node; lengths in the file's unit, +Y up.
/// - TRC (`.trc`): markers, each a node; lengths and axes as in the file.
/// - glTF 2.0 (`.glb`, `.gltf`), VRM animations (`.vrma`) and FBX (`.fbx`): the skeleton and its animations; lengths in
///   metres, +Y up.
/// - USD (`.usda`, `.usdz`): the skeleton and its animations; lengths and axes as in the file.
/// - MikuMikuDance (`.vmd`, `.pmx`): a skeleton, or a motion on the model in the same folder or on generic proportions;
///   lengths in units of 0.08 m, +Y up.
/// - Packed clips (`.mclip`): the skeleton and its animation; lengths in metres.
/// - Arrays of bodies (NumPy's `.npz` and `.npy`, PyTorch's `.pt` and `.pth`, pickles `.pkl` and `.pickle`), in layouts
///   that are known by their names or shapes; lengths in metres. The reader never runs code of a file.
/// - Tables (`.csv`, and `.parquet` in builds with that feature): arrays that this library wrote, and positions.
/// - Joint angles of OpenSim (`.mot`, `.sto`): a body of generic proportions; lengths in metres.
/// - Robots (URDF `.urdf`, MJCF `.mjcf`): only the skeleton.
///
/// The reader refuses 3ds Max `.bip`, and suggests formats to export instead.
///
/// In BVH, the position channels of the root replace its OFFSET. They are added to the OFFSET if the OFFSET is not near
/// zero, but the root position is, in the first frame or in the median of all frames.
///
/// A scene never changes, so any number of threads may use it at the same time. Free it with `mocap_close`.
///
/// # Safety
/// `path` is a string that ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_open_file(path: *const c_char) -> *mut Scene {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller passes a string with a zero byte at its end.
        let path = unsafe { text(path, "path") }?;
        let path = path_from(path)?;
        Ok(Scene::new(Importer::new().import(path)?).into_raw())
    })
}

/// Reads a motion file with the options of a job. `reading` is the JSON of the job's `read`, described by
/// `src/job/job.schema.json`. For example, these options solve a skeleton from markers, with a static trial:
///
///     mocap_open_file_as("walk.trc", "{\"markers\": \"auto\", \"static\": \"standing.trc\"}")
///
/// `mocap_report` returns the residuals of the solution. NULL means no options. The result is as for `mocap_open_file`.
///
/// # Safety
/// `path` is a string that ends with a zero byte. `reading` is such a string or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_open_file_as(path: *const c_char, reading: *const c_char) -> *mut Scene {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller passes a string with a zero byte at its end.
        let path = path_from(unsafe { text(path, "path") }?)?;
        let reading = match reading.is_null() {
            true => InputOptions::default(),
            // SAFETY: the caller passes a string with a zero byte at its end.
            false => serde_json::from_slice(unsafe { text(reading, "reading") }?.to_bytes())
                .map_err(|error| Failure::argument(&format!("reading: {error}")))?,
        };
        Ok(Scene::new(reading.importer().import(path)?).into_raw())
    })
}

/// Like `mocap_open_file`, but reads the `size` bytes of a motion file from memory, and does not keep them. `name` is
/// the file name in errors.
///
/// # Safety
/// `bytes` points to `size` bytes, and `name` is a string that ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_open_memory(bytes: *const u8, size: usize, name: *const c_char) -> *mut Scene {
    guard(ptr::null_mut(), || {
        if bytes.is_null() {
            return Err(Failure::argument("bytes is NULL"));
        }
        // SAFETY: the caller passes `size` bytes at `bytes`, which is not NULL.
        let bytes = unsafe { slice::from_raw_parts(bytes, size) };
        // SAFETY: the caller passes a string with a zero byte at its end.
        let name = unsafe { text(name, "name") }?;
        let name = path_from(name)?;
        Ok(Scene::new(Importer::new().read(bytes, name)?).into_raw())
    })
}
