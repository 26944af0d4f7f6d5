//! `Assimp::Importer`, the class that C++ programs import with. It keeps one scene, and frees it with itself.
//!
//! The class has one field, a pointer to what stands behind it, and no virtual function. The names are those that the
//! compiler makes of its methods: `C1` and `C2` are the constructor, `D1` and `D2` the destructor. A loader of the
//! program's own is given the importer of the system's Assimp; its calls are passed on to there.

mod handlers;
mod properties;
mod registry;

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr;

use crate::abi::{aiMemoryInfo, aiScene};
use crate::border::{bytes, caught, text};
use crate::import::{Input, Request};
use crate::properties::Properties;
use crate::system_importer::{Handlers, Steps, SystemImporter};
use crate::virtual_call::{IoSystem, Progress, delete_object};
use crate::{destroy, flags, heap, import, memory_info};

/// The layout of the class in the program's memory.
#[repr(C)]
pub(crate) struct Importer {
    state: *mut State,
}

/// What stands behind an importer.
#[repr(C)]
pub(crate) struct State {
    /// Tells it from what stands behind an importer of the system's Assimp, which begins with another pointer.
    tag: *const u8,
    pub(crate) properties: Properties,
    pub(crate) scene: *mut aiScene,
    failure: CString,
    pub(crate) handlers: Handlers,
    /// Made at first need, and kept for the loaders and steps that the program has registered with it.
    system: Option<SystemImporter>,
    /// Whether the program has registered any: then the system's Assimp reads every file.
    has_registered: bool,
    /// A `std::exception_ptr` to no exception.
    exception: *const c_void,
}

static TAG: u8 = 0;

impl State {
    pub(crate) fn new() -> Self {
        Self {
            tag: &raw const TAG,
            properties: Properties::default(),
            scene: ptr::null_mut(),
            failure: CString::default(),
            handlers: Handlers {
                io: IoSystem(ptr::null_mut()),
                progress: Progress(ptr::null_mut()),
            },
            system: None,
            has_registered: false,
            exception: ptr::null(),
        }
    }

    /// The system's importer behind this one.
    pub(crate) fn system(&mut self) -> Result<&SystemImporter, String> {
        if self.system.is_none() {
            self.system = Some(SystemImporter::new()?);
        }
        self.system.as_ref().ok_or_else(String::new)
    }

    pub(crate) fn free_scene(&mut self) {
        let scene = std::mem::replace(&mut self.scene, ptr::null_mut());
        if !scene.is_null() {
            // SAFETY: the scene belongs to this importer, which gives it up.
            unsafe {
                destroy::scene(&mut *scene);
                heap::delete(scene);
            }
        }
        self.failure = CString::default();
    }

    /// Reads a file in place of the scene before.
    ///
    /// # Safety
    /// What the input and the handlers point to is what their types say.
    pub(crate) unsafe fn read(&mut self, input: Input<'_>, flags: u32) -> *mut aiScene {
        self.free_scene();
        let properties = self.properties.clone();
        let request = Request {
            input,
            flags,
            properties: &properties,
            handlers: self.handlers,
            always_forward: self.has_registered,
        };
        // SAFETY: the same promise.
        match caught(|| unsafe { import::import(&request, || self.system()) }) {
            Ok(scene) => self.scene = scene,
            Err(failure) => self.failure = failure,
        }
        self.scene
    }

    /// Runs steps on the scene. Where they fail there is no scene any more.
    ///
    /// # Safety
    /// A process is one of the program's.
    pub(crate) unsafe fn run(&mut self, steps: Steps) -> *mut aiScene {
        let (scene, properties, progress) = (self.scene, self.properties.clone(), self.handlers.progress);
        if scene.is_null() {
            return scene;
        }
        // SAFETY: the scene is whole, and the caller promises the rest.
        let result = caught(|| unsafe { self.system()?.run(scene, steps, &properties, progress) });
        if let Err(failure) = result {
            self.free_scene();
            self.failure = failure;
        }
        self.scene
    }
}

impl Drop for State {
    fn drop(&mut self) {
        self.free_scene();
        // SAFETY: the importer owns its handlers, as the headers say, and nobody uses them any more.
        unsafe {
            delete_object(self.handlers.io.0);
            delete_object(self.handlers.progress.0);
        }
    }
}

/// The state of an importer of this library; `None` for one of the system's Assimp.
///
/// # Safety
/// `importer` was constructed and not destructed, and no other thread uses it.
pub(crate) unsafe fn state<'a>(importer: *const Importer) -> Option<&'a mut State> {
    // SAFETY: the constructor has put the pointer there, and only the destructor takes it away; what stands behind an
    // importer of either library begins with a pointer.
    unsafe {
        let state = (*importer).state;
        (ptr::eq((*state).tag, &raw const TAG)).then(|| &mut *state)
    }
}

/// Defines methods of the class, each under its symbol: what it does for an importer of this library, and the value
/// where the method of the system's Assimp has to be called and cannot be.
macro_rules! methods {
    ($(
        $(#[$attribute:meta])*
        fn $symbol:ident($state:ident $(, $name:ident: $type:ty)*) -> $result:ty | $otherwise:expr => $body:expr
    )*) => {
        $(
            $(#[$attribute])*
            ///
            /// # Safety
            /// The first argument is an importer, the others are what the method's declaration says.
            #[unsafe(no_mangle)]
            pub(crate) unsafe extern "C" fn $symbol(
                importer: *mut crate::importer::Importer
                $(, $name: $type)*
            ) -> $result {
                // SAFETY: the caller hands over an importer.
                if let Some($state) = unsafe { crate::importer::state(importer) } {
                    return $body;
                }
                type Method = unsafe extern "C" fn(*mut crate::importer::Importer $(, $type)*) -> $result;
                const SYMBOL: &str = concat!(stringify!($symbol), "\0");
                let symbol = std::ffi::CStr::from_bytes_with_nul(SYMBOL.as_bytes()).unwrap_or_default();
                // SAFETY: the same method of the system's Assimp, whose importer this is.
                match unsafe { crate::system::function::<Method>(symbol) } {
                    // SAFETY: the same promise.
                    Ok(method) => unsafe { method(importer $(, $name)*) },
                    Err(_) => $otherwise,
                }
            }
        )*
    };
}
use methods;

/// `Importer()`
///
/// # Safety
/// `importer` is the place of an importer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8ImporterC1Ev(importer: *mut Importer) {
    let state = Box::into_raw(Box::new(State::new()));
    // SAFETY: the caller hands over the place of an importer.
    unsafe { importer.write(Importer { state }) };
}

/// `Importer()`
///
/// # Safety
/// As [`_ZN6Assimp8ImporterC1Ev`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8ImporterC2Ev(importer: *mut Importer) {
    // SAFETY: the same promise.
    unsafe { _ZN6Assimp8ImporterC1Ev(importer) };
}

methods! {
    /// `~Importer()`
    fn _ZN6Assimp8ImporterD1Ev(state) -> () | () => {
        // SAFETY: the constructor made the state, and the caller gives it up.
        drop(unsafe { Box::from_raw(state) });
    }

    /// `~Importer()`
    fn _ZN6Assimp8ImporterD2Ev(state) -> () | () => {
        // SAFETY: the constructor made the state, and the caller gives it up.
        drop(unsafe { Box::from_raw(state) });
    }

    /// `const aiScene *ReadFile(const char *path, unsigned flags)`. The scene before is freed.
    fn _ZN6Assimp8Importer8ReadFileEPKcj(state, path: *const c_char, flags: u32) -> *const aiScene | ptr::null() => {
        // SAFETY: the caller hands over NULL or a text, and the handlers are of their classes.
        unsafe {
            match text(path, "the path") {
                Ok(path) => state.read(Input::File(path), flags),
                Err(_) => state.read(Input::File(c""), flags),
            }
        }
    }

    /// `const aiScene *ReadFileFromMemory(const void *bytes, size_t size, unsigned flags, const char *hint)`. The scene
    /// before is freed.
    fn _ZN6Assimp8Importer18ReadFileFromMemoryEPKvmjPKc(
        state, first: *const c_void, size: usize, flags: u32, hint: *const c_char
    ) -> *const aiScene | ptr::null() => {
        // SAFETY: the caller hands over `size` bytes, and NULL or a text.
        unsafe {
            let hint = text(hint, "the hint").unwrap_or_default();
            state.read(Input::Memory(bytes(first.cast(), size), hint), flags)
        }
    }

    /// `const aiScene *GetScene() const`
    fn _ZNK6Assimp8Importer8GetSceneEv(state) -> *const aiScene | ptr::null() => state.scene

    /// `aiScene *GetOrphanedScene()`: the scene, which is the program's from now on.
    fn _ZN6Assimp8Importer16GetOrphanedSceneEv(state) -> *mut aiScene | ptr::null_mut() => {
        state.failure = CString::default();
        std::mem::replace(&mut state.scene, ptr::null_mut())
    }

    /// `void FreeScene()`
    fn _ZN6Assimp8Importer9FreeSceneEv(state) -> () | () => state.free_scene()

    /// `const char *GetErrorString() const`: why the last import failed, or an empty text. It is valid until the next.
    fn _ZNK6Assimp8Importer14GetErrorStringEv(state) -> *const c_char | c"".as_ptr() => state.failure.as_ptr()

    /// `const std::exception_ptr &GetException() const`: none, as failures are told by their text.
    fn _ZNK6Assimp8Importer12GetExceptionEv(state) -> *const c_void | ptr::null() => {
        (&raw const state.exception).cast()
    }

    /// `const aiScene *ApplyPostProcessing(unsigned flags)`
    fn _ZN6Assimp8Importer19ApplyPostProcessingEj(state, flags: u32) -> *const aiScene | ptr::null() => {
        match flags {
            0 => state.scene,
            // SAFETY: no process.
            _ => unsafe { state.run(Steps::Flags(flags)) },
        }
    }

    /// `const aiScene *ApplyCustomizedPostProcessing(BaseProcess *process, bool validate)`
    fn _ZN6Assimp8Importer29ApplyCustomizedPostProcessingEPNS_11BaseProcessEb(
        state, process: *mut c_void, validate: bool
    ) -> *const aiScene | ptr::null() => {
        match process.is_null() {
            true => state.scene,
            // SAFETY: the caller hands over a process.
            false => unsafe { state.run(Steps::Process(process, validate)) },
        }
    }

    /// `bool ValidateFlags(unsigned flags) const`: whether all of these flags can be honoured.
    fn _ZNK6Assimp8Importer13ValidateFlagsEj(state, flags: u32) -> bool | false => {
        flags::validate(flags) && (flags::foreign(flags).is_none() || registry::validate(state, flags))
    }

    /// `void GetMemoryRequirements(aiMemoryInfo &info) const`
    fn _ZNK6Assimp8Importer21GetMemoryRequirementsER12aiMemoryInfo(state, info: *mut aiMemoryInfo) -> () | () => {
        // SAFETY: the caller hands over the place of the numbers, and the scene is NULL or whole.
        unsafe { info.write(memory_info::of(state.scene)) }
    }
}

/// An importer on the heap of C++, for the functions of the C interface.
pub(crate) fn new() -> *mut Importer {
    heap::new(Importer {
        state: Box::into_raw(Box::new(State::new())),
    })
}

/// Destructs and frees an importer.
///
/// # Safety
/// `importer` comes from [`new`], or from the `new` of a program or of the system's Assimp, and is not used any more.
pub(crate) unsafe fn delete(importer: *mut Importer) {
    // SAFETY: the same promise.
    unsafe {
        _ZN6Assimp8ImporterD1Ev(importer);
        heap::delete(importer);
    }
}

impl Clone for Importer {
    fn clone(&self) -> Self {
        *self
    }
}

impl Copy for Importer {}

/// Why the last import of `state` failed, as a text.
pub(crate) fn failure(state: &State) -> &CStr {
    &state.failure
}
