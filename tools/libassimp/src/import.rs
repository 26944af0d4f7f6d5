//! Reads a file into a scene.
//!
//! This library reads motion. It passes every other format to the system's Assimp, and also glTF and FBX files with
//! meshes, because it reads no textures and colours. If the system's Assimp is missing or refuses such a file, this
//! library still reads the motion, and marks the scene as incomplete.

use std::ffi::{CStr, OsStr};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use mocap::{Format, Importer, RootOffset, Scene, SkeletonMesh};

use crate::abi::{SCENE_INCOMPLETE, aiScene};
use crate::c_files;
use crate::contents::{self, Contents};
use crate::request::{Input, Request, unable_to_open};
use crate::system_importer::{Steps, SystemImporter};
use crate::{flags, gltf, log, system, to_assimp};

/// Imports a file. `system` returns the importer of the system's Assimp.
///
/// # Safety
/// The pointers of the input and of the handlers point to values of their types.
pub(crate) unsafe fn import<'s>(
    request: &Request<'_>,
    system: impl FnOnce() -> Result<&'s SystemImporter, String>,
) -> Result<*mut aiScene, String> {
    // SAFETY: the caller's promise in `# Safety`.
    let forward = |system: &SystemImporter| unsafe { forward(request, system) };
    if request.always_forward {
        return forward(system()?);
    }
    // SAFETY: the caller's promise in `# Safety`.
    let contents = unsafe { contents::of(request) }?;
    match contents {
        Contents::Motion => {
            // SAFETY: the caller's promise in `# Safety`.
            let scene = unsafe { read(request) }?;
            finish(&scene, 0, request, system)
        }
        Contents::WithMeshes => match system::system().and_then(|_| forward(system()?)) {
            Ok(scene) => Ok(scene),
            Err(reason) => {
                // SAFETY: the caller's promise in `# Safety`.
                let scene = unsafe { read_scene(request) }.map_err(|own| match own == reason {
                    true => own,
                    false => format!("{own} ({reason})"),
                })?;
                log::warn("the meshes and materials of the file are left out: mocap's libassimp reads only its motion");
                let native = to_assimp::scene(&scene, flags::of_scene(request.flags) | SCENE_INCOMPLETE);
                Ok(native)
            }
        },
        // SAFETY: the caller's promise in `# Safety`.
        Contents::Scene => match unsafe { read_scene(request) } {
            Ok(scene) => finish(&scene, 0, request, system),
            Err(own) => match system::system().and_then(|_| forward(system()?)) {
                Ok(scene) => Ok(scene),
                Err(_) => Err(own),
            },
        },
        Contents::Other(name) => {
            let unread = |reason| format!("{name}: mocap's libassimp does not read this format, and {reason}");
            let system = system::system().and_then(|_| system()).map_err(unread)?;
            forward(system)
        }
    }
}

/// Runs the steps: with this library, or all of them with the system's Assimp if this library lacks a step.
fn finish<'s>(
    scene: &Scene,
    scene_flags: u32,
    request: &Request<'_>,
    system: impl FnOnce() -> Result<&'s SystemImporter, String>,
) -> Result<*mut aiScene, String> {
    let progress = request.handlers.progress;
    if let Some(step) = flags::foreign_for(request.flags, request.properties, scene) {
        let system = system::system().and_then(|_| system());
        let system =
            system.map_err(|reason| format!("mocap's libassimp does not have the step {step}, and {reason}"))?;
        let native = to_assimp::scene(scene, scene_flags);
        // SAFETY: the scene was made above.
        return match unsafe { system.run(native, Steps::Flags(request.flags), request.properties, progress) } {
            Ok(()) => Ok(native),
            Err(reason) => {
                // SAFETY: the scene was made above, and nobody else has it.
                unsafe { to_assimp::free(native) };
                Err(reason)
            }
        };
    }
    // SAFETY: the caller of `import` passes NULL or a handler.
    unsafe { progress.file_read(1, 1) };
    let mut scene = scene.clone();
    flags::run(&mut scene, request.flags)?;
    if request.flags != 0 {
        // SAFETY: the caller of `import` passes NULL or a handler.
        unsafe { progress.post_process(1, 1) };
    }
    Ok(to_assimp::scene(&scene, scene_flags | flags::of_scene(request.flags)))
}

/// # Safety
/// As [`import`].
unsafe fn forward(request: &Request<'_>, system: &SystemImporter) -> Result<*mut aiScene, String> {
    let Request {
        input,
        flags,
        properties,
        handlers,
        ..
    } = *request;
    match input {
        Input::File(path) => system.read_file(path, flags, properties, handlers),
        Input::Memory(bytes, hint) => system.read_memory(bytes, flags, hint, properties, handlers),
        // SAFETY: the caller's promise in `# Safety`.
        Input::FileOf(files, path) => unsafe { c_files::import(files, path, flags, properties) },
    }
}

/// Reads glTF or FBX; its other files must exist.
///
/// # Safety
/// As [`import`].
unsafe fn read_scene(request: &Request<'_>) -> Result<Scene, String> {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe {
        gltf::require_buffers(request)?;
        read(request)
    }
}

/// # Safety
/// As [`import`].
unsafe fn read(request: &Request<'_>) -> Result<Scene, String> {
    let mesh = match request.properties.no_skeleton_meshes() {
        true => SkeletonMesh::None,
        false => SkeletonMesh::Skinned,
    };
    // Programs that use Assimp handle a root without its OFFSET themselves.
    let importer = Importer::new()
        .skeleton_mesh(mesh)
        .collapse_keys(false)
        .file_units(true)
        .root_offset(RootOffset::Replace);
    let path_of = |path: &CStr| Path::new(OsStr::from_bytes(path.to_bytes())).to_owned();
    // SAFETY: the caller's promise in `# Safety`.
    let scene = match (request.input, unsafe { contents::all(request) }) {
        (Input::Memory(bytes, hint), _) => {
            let name = Path::new("memory").with_extension(OsStr::from_bytes(hint.to_bytes()));
            importer.read(bytes, &name)
        }
        (Input::File(path), None) => importer.import(path_of(path)),
        (Input::File(path) | Input::FileOf(_, path), Some(bytes)) => importer.read(&bytes, path_of(path)),
        (Input::FileOf(_, path), None) => return Err(unable_to_open(path)),
    };
    let mut scene = scene.map_err(|error| error.to_string())?;
    for warning in &scene.warnings {
        log::warn(&warning.to_string());
    }
    if scene.metadata.format == Some(Format::Bvh) && scene.animations.is_empty() {
        return Err("the file has no motion: a MOTION section with at least one frame is missing".to_owned());
    }
    if matches!(scene.metadata.format, Some(Format::Gltf | Format::Vrma)) {
        in_milliseconds(&mut scene);
    }
    Ok(scene)
}

/// Ticks as in Assimp's glTF reader: a thousand a second.
fn in_milliseconds(scene: &mut Scene) {
    const TICKS_PER_SECOND: f64 = 1000.0;
    for animation in &mut scene.animations {
        let factor = TICKS_PER_SECOND / animation.ticks_per_second;
        animation.duration *= factor;
        animation.ticks_per_second = TICKS_PER_SECOND;
        for channel in &mut animation.channels {
            scale_ticks(&mut channel.position_keys, factor);
            scale_ticks(&mut channel.rotation_keys, factor);
            scale_ticks(&mut channel.scaling_keys, factor);
        }
    }
}

fn scale_ticks<T>(keys: &mut mocap::scene::Keys<T>, factor: f64) {
    let ticks = (0..keys.len()).map(|index| keys.tick(index) * factor).collect();
    keys.ticks = Some(ticks);
}
