//! An `Assimp::Importer` of the system's Assimp. It reads the formats and runs the steps that this library lacks.

use std::ffi::{CStr, c_void};
use std::ptr;

use crate::abi::{aiImporterDesc, aiScene};
use crate::cpp_string::StdString;
use crate::forward::objects::{_ZTIN6Assimp12BaseImporterE, Word};
use crate::properties::Properties;
use crate::system::calls;
use crate::virtual_call::{IoSystem, Progress};
use crate::{destroy, heap};

/// The object: a class of one pointer, on the C++ heap.
pub(crate) struct SystemImporter(*mut c_void);

/// The processing of a scene that this library has read.
#[derive(Clone, Copy)]
pub(crate) enum Steps {
    /// The steps of these flags.
    Flags(u32),
    /// An `Assimp::BaseProcess` of the program, and whether the scene is validated.
    Process(*mut c_void, bool),
}

/// The handlers of an import.
#[derive(Clone, Copy)]
pub(crate) struct Handlers {
    /// The program's file system, or NULL.
    pub(crate) io: IoSystem,
    /// The program's progress handler, or NULL.
    pub(crate) progress: Progress,
}

impl SystemImporter {
    pub(crate) fn new() -> Result<Self, String> {
        let construct = calls::construct_importer()?;
        let importer = heap::allocate(size_of::<*mut c_void>());
        // SAFETY: the block is as large as the class.
        unsafe { construct(importer) };
        Ok(Self(importer))
    }

    /// The object, for methods that are called by their symbol.
    pub(crate) fn object(&self) -> *mut c_void {
        self.0
    }

    /// Reads a file. The caller owns the scene.
    pub(crate) fn read_file(
        &self,
        path: &CStr,
        flags: u32,
        properties: &Properties,
        handlers: Handlers,
    ) -> Result<*mut aiScene, String> {
        let read = calls::read_file()?;
        self.set_properties(properties)?;
        // SAFETY: an importer and a string.
        self.with_handlers(handlers, || unsafe { read(self.0, path.as_ptr(), flags) })?;
        self.take_scene()
    }

    /// Reads a file in memory; `hint` is its extension. The caller owns the scene.
    pub(crate) fn read_memory(
        &self,
        bytes: &[u8],
        flags: u32,
        hint: &CStr,
        properties: &Properties,
        handlers: Handlers,
    ) -> Result<*mut aiScene, String> {
        self.set_properties(properties)?;
        self.read_and_keep(bytes, flags, hint, handlers)?;
        self.take_scene()
    }

    fn read_and_keep(&self, bytes: &[u8], flags: u32, hint: &CStr, handlers: Handlers) -> Result<(), String> {
        let read = calls::read_memory()?;
        // SAFETY: an importer, bytes and a string.
        self.with_handlers(handlers, || unsafe {
            read(self.0, bytes.as_ptr(), bytes.len(), flags, hint.as_ptr())
        })?;
        Ok(())
    }

    /// Runs steps on a scene in place. The importer receives the scene through a loader that reads nothing and passes
    /// the scene on. If a step refuses the scene, the scene is empty afterwards.
    ///
    /// # Safety
    /// `scene` is a whole scene of the C++ heap, and a process one of the program's.
    pub(crate) unsafe fn run(
        &self,
        scene: *mut aiScene,
        steps: Steps,
        properties: &Properties,
        progress: Progress,
    ) -> Result<(), String> {
        let (register, unregister) = (calls::register_loader()?, calls::unregister_loader()?);
        let apply = calls::apply_process()?;
        self.set_properties(properties)?;
        let handlers = Handlers {
            io: IoSystem(ptr::null_mut()),
            progress,
        };
        let flags = match steps {
            Steps::Flags(flags) => flags,
            Steps::Process(..) => 0,
        };
        let loader = Loader::new(scene)?;
        // SAFETY: the loader lives until it is taken back.
        unsafe { register(self.0, loader.cast()) };
        let read = self.read_and_keep(b" ", flags, Loader::EXTENSION, handlers);
        // SAFETY: the loader was registered above, and nobody uses it any more.
        unsafe {
            unregister(self.0, loader.cast());
            Loader::delete(loader);
        }
        read?;
        if let Steps::Process(process, validate) = steps {
            // SAFETY: an importer with or without a scene, and a process of the program.
            unsafe { apply(self.0, process, validate) };
        }
        let processed = self.take_scene()?;
        // SAFETY: both are scenes; each keeps its private part.
        unsafe {
            swap_contents(scene, processed);
            if let (Some(to), Some(from)) = ((*scene).mPrivate.as_mut(), (*processed).mPrivate.as_ref()) {
                to.steps |= from.steps;
            }
            destroy::scene(&mut *processed);
            heap::delete(processed);
        }
        Ok(())
    }

    /// The scene of the importer, or the reason why it has none.
    fn take_scene(&self) -> Result<*mut aiScene, String> {
        // SAFETY: an importer.
        unsafe {
            let scene = calls::scene()?(self.0);
            if scene.is_null() {
                let text = calls::importer_error_text()?(self.0);
                return Err(CStr::from_ptr(text).to_string_lossy().into_owned());
            }
            Ok(calls::orphaned_scene()?(self.0))
        }
    }

    /// Calls `read` while the importer has these handlers, then removes the handlers. They belong to the program or to
    /// another importer, but this importer would delete them.
    fn with_handlers<R>(&self, handlers: Handlers, read: impl FnOnce() -> R) -> Result<R, String> {
        let (set_io, set_progress) = (calls::set_io_handler()?, calls::set_progress_handler()?);
        let with = [(set_io, handlers.io.0), (set_progress, handlers.progress.0)];
        let with = with.into_iter().filter(|(_, handler)| !handler.is_null());
        // SAFETY: an importer, and handlers that live until the end of this call.
        with.clone().for_each(|(set, handler)| unsafe { set(self.0, handler) });
        let result = read();
        // SAFETY: an importer. NULL restores its own handler, and the other handler stays with its owner.
        with.for_each(|(set, _)| unsafe { set(self.0, ptr::null_mut()) });
        Ok(result)
    }

    fn set_properties(&self, properties: &Properties) -> Result<(), String> {
        // SAFETY: an importer, names and values.
        unsafe {
            let set = calls::set_integer()?;
            for (name, &value) in &properties.integers {
                set(self.0, name.as_ptr(), value);
            }
            let set = calls::set_float()?;
            for (name, &value) in &properties.floats {
                set(self.0, name.as_ptr(), value);
            }
            let set = calls::set_matrix()?;
            for (name, value) in &properties.matrices {
                set(self.0, name.as_ptr(), value.as_ptr().cast());
            }
            let set = calls::set_pointer()?;
            for (name, &value) in &properties.pointers {
                set(self.0, name.as_ptr(), value);
            }
            let set = calls::set_string()?;
            for (name, value) in &properties.strings {
                StdString::with(value.to_bytes(), |value| set(self.0, name.as_ptr(), value));
            }
        }
        Ok(())
    }
}

impl Drop for SystemImporter {
    fn drop(&mut self) {
        if let Ok(destruct) = calls::destruct_importer() {
            // SAFETY: the importer was constructed and is given up.
            unsafe {
                destruct(self.0);
                heap::delete(self.0);
            }
        }
    }
}

/// Exchanges the contents of two scenes; each keeps its private part.
///
/// # Safety
/// Both are scenes.
unsafe fn swap_contents(left: *mut aiScene, right: *mut aiScene) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe {
        ptr::swap(left, right);
        ptr::swap(&raw mut (*left).mPrivate, &raw mut (*right).mPrivate);
    }
}

/// A class derived from `Assimp::BaseImporter`.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct Loader {
    base: [u64; BASE / 8],
    scene: *mut aiScene,
}

/// Bytes of the class `BaseImporter`.
pub(crate) const BASE: usize = 72;

static LOADER: [Word; 8] = [
    Word::NULL,
    Word::data(&_ZTIN6Assimp12BaseImporterE),
    Word::code(Loader::destruct as *const c_void),
    Word::code(Loader::delete as *const c_void),
    Word::code(Loader::can_read as *const c_void),
    Word::code(Loader::setup_properties as *const c_void),
    Word::code(Loader::info as *const c_void),
    Word::code(Loader::read as *const c_void),
];

/// A description, which holds pointers to constant strings.
struct Description(aiImporterDesc);

// SAFETY: nothing writes the description or its strings.
unsafe impl Sync for Description {}

static DESCRIPTION: Description = Description(aiImporterDesc {
    mName: c"mocap".as_ptr(),
    mAuthor: c"".as_ptr(),
    mMaintainer: c"".as_ptr(),
    mComments: c"".as_ptr(),
    mFlags: 0,
    mMinMajor: 0,
    mMinMinor: 0,
    mMaxMajor: 0,
    mMaxMinor: 0,
    mFileExtensions: Loader::EXTENSION.as_ptr(),
});

impl Loader {
    /// An extension that no file has.
    const EXTENSION: &CStr = c"mocap-scene";

    fn new(scene: *mut aiScene) -> Result<*mut Self, String> {
        let construct = calls::construct_loader()?;
        let loader = heap::new(Self {
            base: [0; BASE / 8],
            scene,
        });
        // SAFETY: the block begins with room for the base class, which begins with the derived class's table.
        unsafe {
            construct(loader.cast());
            loader.cast::<Word>().write(Word::table(LOADER.as_ptr()));
        }
        Ok(loader)
    }

    /// # Safety
    /// `this` is a loader that is not used any more; the same for `delete`.
    unsafe extern "C" fn destruct(this: *mut Self) {
        if let Ok(destruct) = calls::destruct_loader() {
            // SAFETY: a loader begins with the base class.
            unsafe { destruct(this.cast()) };
        }
    }

    unsafe extern "C" fn delete(this: *mut Self) {
        // SAFETY: the same promise.
        unsafe {
            Self::destruct(this);
            heap::delete(this);
        }
    }

    unsafe extern "C" fn can_read(_this: *const Self, _path: *const StdString, _io: *mut c_void, _: bool) -> bool {
        // By its extension, which no file has.
        false
    }

    unsafe extern "C" fn setup_properties(_this: *mut Self, _importer: *const c_void) {}

    unsafe extern "C" fn info(_this: *const Self) -> *const aiImporterDesc {
        &raw const DESCRIPTION.0
    }

    /// # Safety
    /// `this` is a loader whose scene lives, and `scene` another scene.
    unsafe extern "C" fn read(this: *mut Self, _path: *const StdString, scene: *mut aiScene, _io: *mut c_void) {
        // SAFETY: the caller's promise in `# Safety`.
        unsafe { swap_contents((*this).scene, scene) };
    }
}
