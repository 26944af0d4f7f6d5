//! Logging: the loggers and streams are objects of the system's Assimp. Without it, the library accepts streams, but
//! only a logger of the program logs anything.

use std::ffi::{CString, c_char, c_void};
use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};

use crate::abi::{AI_SUCCESS, aiLogStream, aiReturn};
use crate::forward::objects::{_ZTIN6Assimp10NullLoggerE, Word};
use crate::system::{self, calls, system_functions};
use crate::virtual_call;

type Logger = *mut c_void;

/// A logger of the program, kept here if there is no system's Assimp.
static OWN: AtomicPtr<c_void> = AtomicPtr::new(ptr::null_mut());

/// Writes a message to the log of the system's Assimp, if the program uses it, or to the program's logger.
pub(crate) fn warn(message: &str) {
    let Ok(message) = CString::new(message.replace('\0', " ")) else {
        return;
    };
    let logger = match system::opened() {
        Some(_) => calls::logger()
            // SAFETY: the function takes no argument.
            .map_or(ptr::null_mut(), |get| unsafe { get() }),
        None => OWN.load(Ordering::Acquire),
    };
    if !logger.is_null() {
        // SAFETY: a logger and a string.
        unsafe { virtual_call::log(logger, 7, message.as_ptr()) };
    }
}

unsafe extern "C" fn say_nothing(_message: *const c_char, _user: *mut c_char) {}

system_functions! {
    /// A stream to the standard output or a file.
    fn aiGetPredefinedLogStream(kind: u32, file: *const c_char) -> aiLogStream | aiLogStream {
        callback: Some(say_nothing),
        user: ptr::null_mut(),
    }

    /// Attaches a stream.
    fn aiAttachLogStream(stream: *const aiLogStream) -> () | ()

    /// Detaches a stream.
    fn aiDetachLogStream(stream: *const aiLogStream) -> aiReturn | AI_SUCCESS

    /// Detaches all streams.
    fn aiDetachAllLogStreams() -> () | ()

    /// Turns verbose logging on or off.
    fn aiEnableVerboseLogging(on: i32) -> () | ()

    /// `Logger *DefaultLogger::create(const char *name, LogSeverity severity, unsigned streams, IOSystem *io)`
    fn _ZN6Assimp13DefaultLogger6createEPKcNS_6Logger11LogSeverityEjPNS_8IOSystemE(
        name: *const c_char, severity: u32, streams: u32, io: *mut c_void
    ) -> Logger | own_logger()

    /// `Logger *DefaultLogger::get()`
    fn _ZN6Assimp13DefaultLogger3getEv() -> Logger | own_logger()

    /// `void DefaultLogger::set(Logger *logger)`
    fn _ZN6Assimp13DefaultLogger3setEPNS_6LoggerE(logger: Logger) -> () | OWN.store(logger, Ordering::Release)

    /// `bool DefaultLogger::isNullLogger()`
    fn _ZN6Assimp13DefaultLogger12isNullLoggerEv() -> bool | OWN.load(Ordering::Acquire).is_null()

    /// `void DefaultLogger::kill()`
    fn _ZN6Assimp13DefaultLogger4killEv() -> () | {
        let logger = OWN.swap(ptr::null_mut(), Ordering::AcqRel);
        // SAFETY: the program has given the logger away, and nobody else uses it.
        unsafe { virtual_call::delete_object(logger) }
    }
}

fn own_logger() -> Logger {
    let own = OWN.load(Ordering::Acquire);
    match own.is_null() {
        true => (&raw const _ZN6Assimp13DefaultLogger13s_pNullLoggerE).cast_mut().cast(),
        false => own,
    }
}

/// Defines the logging functions of `Logger`: each calls the entry in the table of the logger's class.
macro_rules! messages {
    ($($(#[$attribute:meta])* fn $symbol:ident = $place:literal from $severity:literal;)*) => {
        $(
            $(#[$attribute])*
            ///
            /// # Safety
            /// `logger` is a `Logger`, and `message` is NULL or ends with a zero byte.
            #[unsafe(no_mangle)]
            pub(crate) unsafe extern "C" fn $symbol(logger: Logger, message: *const c_char) {
                // SAFETY: the caller's promise in `# Safety`; the severity follows the table.
                unsafe {
                    if logger.cast::<usize>().add(1).cast::<i32>().read() >= $severity {
                        virtual_call::log(logger, $place, message);
                    }
                }
            }
        )*
    };
}

messages! {
    /// `void Logger::debug(const char *message)`
    fn _ZN6Assimp6Logger5debugEPKc = 4 from 1;
    /// `void Logger::verboseDebug(const char *message)`
    fn _ZN6Assimp6Logger12verboseDebugEPKc = 5 from 2;
    /// `void Logger::info(const char *message)`
    fn _ZN6Assimp6Logger4infoEPKc = 6 from 0;
    /// `void Logger::warn(const char *message)`
    fn _ZN6Assimp6Logger4warnEPKc = 7 from 0;
    /// `void Logger::error(const char *message)`
    fn _ZN6Assimp6Logger5errorEPKc = 8 from 0;
}

/// Defines the functions of the class `NullLogger`, which do nothing.
macro_rules! null_logger {
    ($($symbol:ident($($type:ty),*) -> $result:ty = $value:expr;)*) => {
        $(
            #[unsafe(no_mangle)]
            pub(crate) unsafe extern "C" fn $symbol(_logger: Logger $(, _: $type)*) -> $result { $value }
        )*
    };
}

null_logger! {
    _ZN6Assimp10NullLogger7OnDebugEPKc(*const c_char) -> () = ();
    _ZN6Assimp10NullLogger14OnVerboseDebugEPKc(*const c_char) -> () = ();
    _ZN6Assimp10NullLogger6OnInfoEPKc(*const c_char) -> () = ();
    _ZN6Assimp10NullLogger6OnWarnEPKc(*const c_char) -> () = ();
    _ZN6Assimp10NullLogger7OnErrorEPKc(*const c_char) -> () = ();
    _ZN6Assimp10NullLogger12attachStreamEPNS_9LogStreamEj(*mut c_void, u32) -> bool = false;
    _ZN6Assimp10NullLogger12detachStreamEPNS_9LogStreamEj(*mut c_void, u32) -> bool = false;
    _ZN6Assimp10NullLoggerD1Ev() -> () = ();
    _ZN6Assimp10NullLoggerD2Ev() -> () = ();
}

/// `~NullLogger()` and `delete`
///
/// # Safety
/// `logger` is a `NullLogger` from `new` that is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp10NullLoggerD0Ev(logger: Logger) {
    // SAFETY: `logger` is a valid `NullLogger`, as the caller guarantees (see `# Safety`).
    unsafe { crate::heap::delete(logger) };
}

#[unsafe(no_mangle)]
static _ZTVN6Assimp10NullLoggerE: [Word; 11] = [
    Word::NULL,
    Word::data(&_ZTIN6Assimp10NullLoggerE),
    Word::code(_ZN6Assimp10NullLoggerD1Ev as *const c_void),
    Word::code(_ZN6Assimp10NullLoggerD0Ev as *const c_void),
    Word::code(_ZN6Assimp10NullLogger12attachStreamEPNS_9LogStreamEj as *const c_void),
    Word::code(_ZN6Assimp10NullLogger12detachStreamEPNS_9LogStreamEj as *const c_void),
    Word::code(_ZN6Assimp10NullLogger7OnDebugEPKc as *const c_void),
    Word::code(_ZN6Assimp10NullLogger14OnVerboseDebugEPKc as *const c_void),
    Word::code(_ZN6Assimp10NullLogger6OnInfoEPKc as *const c_void),
    Word::code(_ZN6Assimp10NullLogger6OnWarnEPKc as *const c_void),
    Word::code(_ZN6Assimp10NullLogger7OnErrorEPKc as *const c_void),
];

/// `DefaultLogger::s_pNullLogger` and `m_pLogger`: members that only the class itself uses.
#[unsafe(no_mangle)]
static _ZN6Assimp13DefaultLogger13s_pNullLoggerE: [Word; 2] =
    [Word::table(_ZTVN6Assimp10NullLoggerE.as_ptr()), Word::NULL];
#[unsafe(no_mangle)]
static _ZN6Assimp13DefaultLogger9m_pLoggerE: [Word; 1] = [Word::data(&_ZN6Assimp13DefaultLogger13s_pNullLoggerE)];
