//! The state behind an importer, and the macro that defines its methods.

use std::ffi::{CString, c_void};
use std::ptr;

use crate::abi::aiScene;
use crate::border::caught;
use crate::properties::Properties;
use crate::request::{Input, Request};
use crate::system_importer::{Handlers, Steps, SystemImporter};
use crate::virtual_call::{IoSystem, Progress, delete_object};
use crate::{destroy, heap, import};

/// The layout of the class in the program's memory.
#[repr(C)]
pub(crate) struct Importer {
    pub(super) state: *mut State,
}

impl Clone for Importer {
    fn clone(&self) -> Self {
        *self
    }
}

impl Copy for Importer {}

/// The state behind an importer.
#[repr(C)]
pub(crate) struct State {
    /// Distinguishes this state from the state of the system's importers, which begins with another pointer.
    tag: *const u8,
    pub(crate) properties: Properties,
    pub(crate) scene: *mut aiScene,
    pub(super) failure: CString,
    pub(crate) handlers: Handlers,
    /// Created when first needed, and kept for the program's loaders and steps.
    pub(super) system: Option<SystemImporter>,
    /// Whether the program has registered a loader or step; the system's Assimp then reads every file.
    pub(super) has_registered: bool,
    /// A `std::exception_ptr` to no exception.
    pub(super) exception: *const c_void,
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

    /// The system's importer behind this importer.
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
    /// The pointers of the input and of the handlers point to values of their types.
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
        // SAFETY: the caller's promise in `# Safety`.
        match caught(|| unsafe { import::import(&request, || self.system()) }) {
            Ok(scene) => self.scene = scene,
            Err(failure) => self.failure = failure,
        }
        self.scene
    }

    /// Runs steps on the scene. If a step fails, there is no scene any more.
    ///
    /// # Safety
    /// A process is a process of the program.
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
    // SAFETY: the constructor has put the pointer there, and only the destructor takes it away; the state behind an
    // importer of either library begins with a pointer.
    unsafe {
        let state = (*importer).state;
        (ptr::eq((*state).tag, &raw const TAG)).then(|| &mut *state)
    }
}

/// Defines methods of the class under their symbols. Each method has a body for importers of this library, and a value
/// for the case that the system's Assimp is necessary but missing.
macro_rules! methods {
    ($(
        $(#[$attribute:meta])*
        fn $symbol:ident($state:ident $(, $name:ident: $type:ty)*) -> $result:ty | $otherwise:expr => $body:expr
    )*) => {
        $(
            $(#[$attribute])*
            ///
            /// # Safety
            /// The first argument is an importer; the others match the method's declaration.
            #[unsafe(no_mangle)]
            pub(crate) unsafe extern "C" fn $symbol(
                importer: *mut crate::importer::Importer
                $(, $name: $type)*
            ) -> $result {
                // SAFETY: the caller passes an importer.
                if let Some($state) = unsafe { crate::importer::state(importer) } {
                    return $body;
                }
                type Method = unsafe extern "C" fn(*mut crate::importer::Importer $(, $type)*) -> $result;
                const SYMBOL: &str = concat!(stringify!($symbol), "\0");
                let symbol = std::ffi::CStr::from_bytes_with_nul(SYMBOL.as_bytes()).unwrap_or_default();
                // SAFETY: the same method of the system's Assimp, whose importer this is.
                match unsafe { crate::system::function::<Method>(symbol) } {
                    // SAFETY: the caller's promise in `# Safety`.
                    Ok(method) => unsafe { method(importer $(, $name)*) },
                    Err(_) => $otherwise,
                }
            }
        )*
    };
}
pub(super) use methods;
