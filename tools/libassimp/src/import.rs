//! From a file to a scene, and its end.
//!
//! Motion is read here. Every other format is handed to the system's Assimp; so are glTF and FBX files that have meshes,
//! whose textures and colours are not read here. Where it is absent or refuses such a file, the motion is read here all
//! the same, and the scene says that it is incomplete.

use std::ffi::{CStr, OsStr, c_char, c_void};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::ptr;

use mocap::scene::UpAxis;
use mocap::{FORMATS, Format, Importer, RootOffset, Scene, SkeletonMesh, process};

use crate::abi::{SCENE_INCOMPLETE, aiFileIO, aiScene, aiString};
use crate::border::{bytes, guard, text};
use crate::c_files;
use crate::contents::{self, Contents};
use crate::importer;
use crate::properties::Properties;
use crate::system_importer::{Handlers, Steps, SystemImporter};
use crate::{flags, log, system, to_assimp};

/// Where a file is.
#[derive(Clone, Copy)]
pub(crate) enum Input<'a> {
    /// On the disk, or in the program's own file system.
    File(&'a CStr),
    /// In a file system that C functions are.
    FileOf(*mut aiFileIO, &'a CStr),
    /// In memory, with its extension.
    Memory(&'a [u8], &'a CStr),
}

/// What is to be imported, and how.
pub(crate) struct Request<'a> {
    pub(crate) input: Input<'a>,
    pub(crate) flags: u32,
    pub(crate) properties: &'a Properties,
    pub(crate) handlers: Handlers,
    /// Whether the system's Assimp is to read it, whatever it is.
    pub(crate) always_forward: bool,
}

/// Imports a file. `system` gives the importer of the system's Assimp.
///
/// # Safety
/// What the input and the handlers point to is what their types say.
pub(crate) unsafe fn import<'s>(
    request: &Request<'_>,
    system: impl FnOnce() -> Result<&'s SystemImporter, String>,
) -> Result<*mut aiScene, String> {
    // SAFETY: the same promise.
    let forward = |system: &SystemImporter| unsafe { forward(request, system) };
    if request.always_forward {
        return forward(system()?);
    }
    // SAFETY: the same promise.
    let contents = unsafe { contents::of(request) }?;
    match contents {
        Contents::Motion => {
            // SAFETY: the same promise.
            let scene = unsafe { read(request) }?;
            finish(&scene, 0, request, system)
        }
        Contents::WithMeshes => match system::system().and_then(|_| forward(system()?)) {
            Ok(scene) => Ok(scene),
            Err(reason) => {
                // SAFETY: the same promise.
                let scene = unsafe { read(request) }.map_err(|own| format!("{own} ({reason})"))?;
                log::warn("the meshes and materials of the file are left out: only its motion is read here");
                let native = to_assimp::scene(&scene, flags::of_scene(request.flags) | SCENE_INCOMPLETE);
                Ok(native)
            }
        },
        // SAFETY: the same promise.
        Contents::Scene => match unsafe { read(request) } {
            Ok(scene) => finish(&scene, 0, request, system),
            Err(own) => match system::system().and_then(|_| forward(system()?)) {
                Ok(scene) => Ok(scene),
                Err(_) => Err(own),
            },
        },
        Contents::Other(name) => {
            let unread = |reason| format!("{name}: not a format that is read here, and {reason}");
            let system = system::system().and_then(|_| system()).map_err(unread)?;
            forward(system)
        }
    }
}

/// Runs the steps: those that are here, or all by the system's Assimp where one is not.
fn finish<'s>(
    scene: &Scene,
    scene_flags: u32,
    request: &Request<'_>,
    system: impl FnOnce() -> Result<&'s SystemImporter, String>,
) -> Result<*mut aiScene, String> {
    let progress = request.handlers.progress;
    if let Some(step) = flags::foreign_for(request.flags, request.properties, scene) {
        let system = system::system().and_then(|_| system());
        let system = system.map_err(|reason| format!("{step} is not a step of this library, and {reason}"))?;
        let native = to_assimp::scene(scene, scene_flags);
        // SAFETY: the scene was made above.
        return match unsafe { system.run(native, Steps::Flags(request.flags), request.properties, progress) } {
            Ok(()) => Ok(native),
            Err(reason) => {
                // SAFETY: as above; nobody has the scene.
                unsafe { to_assimp::free(native) };
                Err(reason)
            }
        };
    }
    // SAFETY: the caller of `import` hands over NULL or a handler.
    unsafe { progress.file_read(1, 1) };
    let mut scene = scene.clone();
    flags::run(&mut scene, request.flags)?;
    if request.flags != 0 {
        // SAFETY: as above.
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
        // SAFETY: the same promise.
        Input::FileOf(files, path) => unsafe { c_files::import(files, path, flags, properties) },
    }
}

/// # Safety
/// As [`import`].
unsafe fn read(request: &Request<'_>) -> Result<Scene, String> {
    let mesh = match request.properties.no_skeleton_meshes() {
        true => SkeletonMesh::None,
        false => SkeletonMesh::Skinned,
    };
    // A program that counts on Assimp has its own way with a root whose OFFSET is left out.
    let importer = Importer::new()
        .skeleton_mesh(mesh)
        .collapse_keys(false)
        .root_offset(RootOffset::Replace);
    let path_of = |path: &CStr| Path::new(OsStr::from_bytes(path.to_bytes())).to_owned();
    // SAFETY: the same promise.
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
    match scene.metadata.format {
        Some(Format::Gltf) => in_milliseconds(&mut scene),
        // Centimetres, which FBX files are in unless they say otherwise; they were read in metres.
        Some(Format::Fbx) => process::convert_units(&mut scene, 100.0, UpAxis::Y),
        _ => {}
    }
    Ok(scene)
}

pub(crate) fn unable_to_open(path: &CStr) -> String {
    format!("Unable to open file \"{}\".", path.to_string_lossy())
}

/// Ticks as Assimp's reader of glTF has them: a thousand a second.
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

/// Reads a file. Returns NULL where that fails; `aiGetErrorString` says why. [`aiReleaseImport`] frees the scene.
///
/// # Safety
/// `path` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFile(path: *const c_char, flags: u32) -> *const aiScene {
    // SAFETY: the same promise, and neither a file system nor properties.
    unsafe { aiImportFileExWithProperties(path, flags, ptr::null_mut(), ptr::null()) }
}

/// As [`aiImportFile`], from a file system of the caller's own.
///
/// # Safety
/// `path` is NULL or ends with a zero byte, and `files` is NULL or a file system.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileEx(
    path: *const c_char,
    flags: u32,
    files: *mut aiFileIO,
) -> *const aiScene {
    // SAFETY: the same promise, and no properties.
    unsafe { aiImportFileExWithProperties(path, flags, files, ptr::null()) }
}

/// As [`aiImportFileEx`], with properties.
///
/// # Safety
/// As [`aiImportFileEx`], and `properties` is NULL or a store.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileExWithProperties(
    path: *const c_char,
    flags: u32,
    files: *mut aiFileIO,
    properties: *const Properties,
) -> *const aiScene {
    guard(ptr::null(), || {
        // SAFETY: the caller hands over NULL or a text.
        let path = unsafe { text(path, "the path") }?;
        let input = match files.is_null() {
            true => Input::File(path),
            false => Input::FileOf(files, path),
        };
        // SAFETY: the caller hands over NULL or a store.
        unsafe { import_for_c(input, flags, properties.as_ref()) }
    })
}

/// Reads a file that is in memory, `size` bytes of it. `hint` is its extension, or NULL.
///
/// # Safety
/// `first` points to `size` bytes, and `hint` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileFromMemory(
    first: *const u8,
    size: u32,
    flags: u32,
    hint: *const c_char,
) -> *const aiScene {
    // SAFETY: the same promise, and no properties.
    unsafe { aiImportFileFromMemoryWithProperties(first, size, flags, hint, ptr::null()) }
}

/// As [`aiImportFileFromMemory`], with properties.
///
/// # Safety
/// As [`aiImportFileFromMemory`], and `properties` is NULL or a store.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileFromMemoryWithProperties(
    first: *const u8,
    size: u32,
    flags: u32,
    hint: *const c_char,
    properties: *const Properties,
) -> *const aiScene {
    guard(ptr::null(), || {
        // SAFETY: the caller hands over NULL or a store, `size` bytes, and NULL or a text.
        unsafe {
            let hint = text(hint, "the hint").unwrap_or_default();
            import_for_c(
                Input::Memory(bytes(first, size as usize), hint),
                flags,
                properties.as_ref(),
            )
        }
    })
}

/// Imports with an importer of the scene's own, which `aiReleaseImport` finds by the scene.
///
/// # Safety
/// As [`import`].
unsafe fn import_for_c(
    input: Input<'_>,
    flags: u32,
    properties: Option<&Properties>,
) -> Result<*const aiScene, String> {
    let importer = importer::new();
    // SAFETY: the importer was made above, and the caller promises the rest.
    unsafe {
        let Some(state) = importer::state(importer) else {
            return Err("an importer is not this library's".to_owned());
        };
        state.properties = properties.cloned().unwrap_or_default();
        let scene = state.read(input, flags);
        if let Some(private) = scene.as_mut().and_then(|scene| scene.mPrivate.as_mut()) {
            private.importer = importer.cast();
            return Ok(scene);
        }
        let failure = importer::failure(state).to_string_lossy().into_owned();
        importer::delete(importer);
        Err(failure)
    }
}

/// Frees a scene and everything that it points to.
///
/// # Safety
/// `scene` is NULL or comes from an import, and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiReleaseImport(scene: *const aiScene) {
    // SAFETY: the same promise; a scene without an importer belongs to itself.
    unsafe {
        let Some(it) = scene.as_ref() else { return };
        match it.mPrivate.as_ref().map_or(ptr::null_mut(), |private| private.importer) {
            importer if importer.is_null() => to_assimp::free(scene.cast_mut()),
            importer => importer::delete(importer.cast()),
        }
    }
}

/// Runs steps on a scene of an import. Returns the scene, or NULL where they fail: then it is freed.
///
/// # Safety
/// `scene` is NULL or comes from an import.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiApplyPostProcessing(scene: *const aiScene, flags: u32) -> *const aiScene {
    // SAFETY: the same promise.
    unsafe { apply(scene, (flags != 0).then_some(Steps::Flags(flags))) }
}

/// `aiApplyCustomizedPostProcessing(const aiScene *scene, BaseProcess *process, bool validate)`, as
/// [`aiApplyPostProcessing`] with a step of the program's.
///
/// # Safety
/// `scene` is NULL or comes from an import, and `process` is NULL or a step.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _Z31aiApplyCustomizedPostProcessingPK7aiScenePN6Assimp11BaseProcessEb(
    scene: *const aiScene,
    process: *mut c_void,
    validate: bool,
) -> *const aiScene {
    // SAFETY: the same promise.
    unsafe { apply(scene, (!process.is_null()).then_some(Steps::Process(process, validate))) }
}

/// Frees a scene that belongs to nobody: a copy, or one that the program made.
///
/// # Safety
/// `scene` is NULL or such a scene, and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiFreeScene(scene: *const aiScene) {
    // SAFETY: the same promise.
    unsafe { to_assimp::free(scene.cast_mut()) };
}

/// # Safety
/// `scene` is NULL or comes from an import.
unsafe fn apply(scene: *const aiScene, steps: Option<Steps>) -> *const aiScene {
    guard(ptr::null(), || {
        // SAFETY: the caller hands over NULL or a scene of an import.
        unsafe {
            let private = scene.as_ref().and_then(|it| it.mPrivate.as_ref());
            let importer = private.map_or(ptr::null_mut(), |private| private.importer);
            if importer.is_null() {
                return Err("the scene does not come from an import".to_owned());
            }
            let state = importer::state(importer.cast()).ok_or("the scene comes from another library")?;
            let Some(steps) = steps else { return Ok(scene) };
            if state.run(steps).is_null() {
                let failure = importer::failure(state).to_string_lossy().into_owned();
                importer::delete(importer.cast());
                return Err(failure);
            }
            Ok(scene)
        }
    })
}

/// 1 if files with this extension are read, with or without its dot, here or by the system's Assimp; else 0.
///
/// # Safety
/// `extension` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiIsExtensionSupported(extension: *const c_char) -> i32 {
    guard(0, || {
        // SAFETY: the caller hands over NULL or a text.
        let extension = unsafe { text(extension, "the extension") }?;
        let name = extension.to_string_lossy();
        let name = name.trim_start_matches(['*', '.']);
        if extensions().any(|known| known.eq_ignore_ascii_case(name)) {
            return Ok(1);
        }
        // SAFETY: the function of the headers.
        let asked =
            unsafe { system::function::<unsafe extern "C" fn(*const c_char) -> i32>(c"aiIsExtensionSupported") };
        // SAFETY: a text.
        Ok(asked.map_or(0, |ask| unsafe { ask(extension.as_ptr()) }))
    })
}

/// The extensions that are read, here or by the system's Assimp, as in `*.bvh;*.asf`.
///
/// # Safety
/// `list` is NULL or the place of an `aiString`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetExtensionList(list: *mut aiString) {
    if list.is_null() {
        return;
    }
    let mut theirs = aiString::new("");
    // SAFETY: the function of the headers.
    if let Ok(get) = unsafe { system::function::<unsafe extern "C" fn(*mut aiString)>(c"aiGetExtensionList") } {
        // SAFETY: the place of an `aiString`.
        unsafe { get(&raw mut theirs) };
    }
    let theirs = theirs.to_text();
    let mut patterns: Vec<String> = theirs
        .split(';')
        .filter(|it| !it.is_empty())
        .map(str::to_owned)
        .collect();
    for extension in extensions() {
        let pattern = format!("*.{extension}");
        if !patterns.contains(&pattern) {
            patterns.push(pattern);
        }
    }
    // SAFETY: the caller hands over the place of an `aiString`.
    unsafe { list.write(aiString::new(&patterns.join(";"))) };
}

fn extensions() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().flat_map(|format| format.extensions.iter().copied())
}
