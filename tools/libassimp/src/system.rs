//! The system's own Assimp, which does the work that this library does not do. It is opened when first needed.
//!
//! It has the same name and the same symbols as this library. It is opened in a special way:
//!
//! - by its path, because the dynamic linker has already loaded this library under that name
//! - with `RTLD_LOCAL`, so that the program still calls this library
//! - with `RTLD_DEEPBIND`, so that the system's Assimp calls its own functions

pub(crate) mod calls;

use std::env;
use std::ffi::{CStr, CString, c_void};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::version;

/// The library to which calls are forwarded: `off` for no library, else its path. Unset means the system's Assimp.
const VARIABLE: &str = "MOCAP_ASSIMP_FORWARD";

/// The file name of Assimp for programs of Debian 12.
const FILE_NAME: &str = "libassimp.so.5";

/// The folders of libraries, besides the folders of `LD_LIBRARY_PATH`.
const FOLDERS: &[&str] = &[
    "/usr/local/lib",
    #[cfg(target_arch = "x86_64")]
    "/usr/lib/x86_64-linux-gnu",
    #[cfg(target_arch = "aarch64")]
    "/usr/lib/aarch64-linux-gnu",
    "/usr/lib64",
    "/usr/lib",
];

/// A mark in every copy of this library and in no other library, so that no copy forwards to another copy.
#[unsafe(no_mangle)]
pub(crate) static mocap_libassimp: u8 = 1;

/// An open library. It is never closed: objects of its classes may live as long as the process.
pub(crate) struct System {
    handle: *mut c_void,
}

// SAFETY: a handle of the dynamic linker may be used from any thread.
unsafe impl Send for System {}
// SAFETY: a handle of the dynamic linker may be used from any thread.
unsafe impl Sync for System {}

static SYSTEM: OnceLock<Result<System, String>> = OnceLock::new();

/// The system's Assimp, or the reason why it is not available.
pub(crate) fn system() -> Result<&'static System, String> {
    SYSTEM.get_or_init(open).as_ref().map_err(Clone::clone)
}

/// The system's Assimp, if a call was forwarded before.
pub(crate) fn opened() -> Option<&'static System> {
    SYSTEM.get()?.as_ref().ok()
}

impl System {
    /// The address of a symbol; NULL if there is none of this name.
    pub(crate) fn find(&self, name: &CStr) -> *mut c_void {
        // SAFETY: the handle is open, and the name ends with a zero byte.
        unsafe { libc::dlsym(self.handle, name.as_ptr()) }
    }
}

/// A function of the system's Assimp, by its symbol, as a pointer of type `F`.
///
/// # Safety
/// `F` is the type of a pointer to that function.
pub(crate) unsafe fn function<F: Copy>(name: &CStr) -> Result<F, String> {
    const { assert!(size_of::<F>() == size_of::<*mut c_void>()) };
    let address = system()?.find(name);
    if address.is_null() {
        return Err(format!("the system's Assimp has no {}", name.to_string_lossy()));
    }
    // SAFETY: the caller says what type the function has, and a function's address makes a pointer to it.
    Ok(unsafe { std::mem::transmute_copy(&address) })
}

/// Defines functions that call the functions of the system's Assimp, and their values without the system's Assimp. The
/// object of a method is its first argument.
macro_rules! system_functions {
    ($(
        $(#[$attribute:meta])*
        fn $symbol:ident($($name:ident: $type:ty),*) -> $result:ty | $otherwise:expr
    )*) => {
        $(
            $(#[$attribute])*
            ///
            /// # Safety
            /// As its declaration in the headers says.
            #[unsafe(no_mangle)]
            pub(crate) unsafe extern "C" fn $symbol($($name: $type),*) -> $result {
                const NAME: &str = concat!(stringify!($symbol), "\0");
                let symbol = std::ffi::CStr::from_bytes_with_nul(NAME.as_bytes()).unwrap_or_default();
                // SAFETY: the function of the headers.
                match unsafe { crate::system::function::<unsafe extern "C" fn($($type),*) -> $result>(symbol) } {
                    // SAFETY: the caller's promise in `# Safety`.
                    Ok(function) => unsafe { function($($name),*) },
                    Err(_) => $otherwise,
                }
            }
        )*
    };
}
pub(crate) use system_functions;

fn open() -> Result<System, String> {
    let chosen = env::var_os(VARIABLE).filter(|value| !value.is_empty());
    if chosen.as_deref().is_some_and(|value| value == "off") {
        return Err(format!("{VARIABLE} is off"));
    }
    // The sanitizer ends a process that uses RTLD_DEEPBIND.
    // SAFETY: the name ends with a zero byte.
    if !unsafe { libc::dlsym(libc::RTLD_DEFAULT, c"__asan_init".as_ptr()) }.is_null() {
        return Err("the system's Assimp cannot be opened under the address sanitizer".to_owned());
    }
    if let Some(path) = chosen {
        return open_library(Path::new(&path)).map_err(|reason| format!("{VARIABLE}: {reason}"));
    }
    let mut reasons = Vec::new();
    for path in candidates() {
        match open_library(&path) {
            Ok(system) => return Ok(system),
            Err(reason) => reasons.push(reason),
        }
    }
    let reason = match reasons.is_empty() {
        true => format!("there is no {FILE_NAME} beside this one"),
        false => reasons.join("; "),
    };
    Err(format!("the system's Assimp was not found: {reason}"))
}

/// The possible files of the system's Assimp, in the order of the dynamic linker.
fn candidates() -> impl Iterator<Item = PathBuf> {
    let listed = env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    let listed: Vec<PathBuf> = env::split_paths(&listed).collect();
    let folders = listed.into_iter().chain(FOLDERS.iter().map(PathBuf::from));
    folders
        .filter(|folder| folder.is_absolute())
        .map(|folder| folder.join(FILE_NAME))
        .filter(|path| path.exists() && !is_this(path))
}

/// Whether this library was loaded from that file.
fn is_this(path: &Path) -> bool {
    let Some(own) = own_path() else { return false };
    let same = |left: std::io::Result<PathBuf>, right: std::io::Result<PathBuf>| Some(left.ok()? == right.ok()?);
    same(path.canonicalize(), own.canonicalize()).unwrap_or(false)
}

fn own_path() -> Option<PathBuf> {
    // SAFETY: zero bytes are a valid `Dl_info`, and the address is one of this library.
    let mut info: libc::Dl_info = unsafe { std::mem::zeroed() };
    // SAFETY: the address is an address of this library, and `info` has room for the answer.
    let found = unsafe { libc::dladdr((&raw const mocap_libassimp).cast(), &raw mut info) };
    if found == 0 || info.dli_fname.is_null() {
        return None;
    }
    // SAFETY: the dynamic linker's own text, which ends with a zero byte.
    let path = unsafe { CStr::from_ptr(info.dli_fname) };
    Some(PathBuf::from(std::ffi::OsStr::from_bytes(path.to_bytes())))
}

fn open_library(path: &Path) -> Result<System, String> {
    let text = CString::new(path.as_os_str().as_bytes()).map_err(|_| "a path has no zero byte".to_owned())?;
    let flags = libc::RTLD_NOW | libc::RTLD_LOCAL | libc::RTLD_DEEPBIND;
    // SAFETY: `dlopen` runs the initializers of the library. The user or the system chose this library.
    let handle = unsafe { libc::dlopen(text.as_ptr(), flags) };
    if handle.is_null() {
        // SAFETY: an opening failed just now, so there is a string, which ends with a zero byte.
        let reason = unsafe { CStr::from_ptr(libc::dlerror()) };
        return Err(reason.to_string_lossy().into_owned());
    }
    let system = System { handle };
    check(&system, path).inspect_err(|_| {
        // SAFETY: the handle is open, and nothing of the library is used.
        unsafe { libc::dlclose(handle) };
    })?;
    Ok(system)
}

/// Whether the library is Assimp, is not this library, and has the version of these structs.
fn check(system: &System, path: &Path) -> Result<(), String> {
    let path = path.display();
    if !system.find(c"mocap_libassimp").is_null() {
        return Err(format!("{path} is mocap's library too, not Assimp's"));
    }
    let number = |name: &CStr| {
        let address = system.find(name);
        // SAFETY: Assimp's headers say that the function takes nothing and returns a number.
        (!address.is_null())
            .then(|| unsafe { std::mem::transmute::<*mut c_void, unsafe extern "C" fn() -> u32>(address)() })
    };
    let (major, minor) = (number(c"aiGetVersionMajor"), number(c"aiGetVersionMinor"));
    let (Some(major), Some(minor)) = (major, minor) else {
        return Err(format!("{path} is not Assimp: it states no version"));
    };
    if (major, minor) != (version::MAJOR, version::MINOR) {
        let (wanted_major, wanted_minor) = (version::MAJOR, version::MINOR);
        return Err(format!(
            "{path} is Assimp {major}.{minor}; only {wanted_major}.{wanted_minor} has the same structs in memory"
        ));
    }
    Ok(())
}
