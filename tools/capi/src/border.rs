//! The border between Rust and C: converts errors to a string and a status, and catches panics.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU8, Ordering};

/// The result of a call.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The call succeeded.
    Ok = 0,
    /// An argument is NULL, out of range, or too small.
    BadArgument = 1,
    /// The file cannot be read.
    ReadFailed = 2,
    /// A defect of the library; please report it.
    Defect = 3,
}

/// Why a call failed.
pub(crate) struct Failure {
    status: Status,
    message: String,
}

impl Failure {
    pub(crate) fn argument(message: &str) -> Self {
        Self {
            status: Status::BadArgument,
            message: message.to_owned(),
        }
    }

    /// The error of an `index` beyond the `count` existing items.
    pub(crate) fn absent(what: &str, index: u64, count: u64) -> Self {
        Self::argument(&format!(
            "there is no {what} {index}: there are {count}, counted from 0"
        ))
    }

    fn defect(panic: &(dyn Any + Send)) -> Self {
        let message = panic.downcast_ref::<&str>().copied();
        let message = message.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        Self {
            status: Status::Defect,
            message: format!("a defect of the library: {}", message.unwrap_or("of unknown kind")),
        }
    }
}

impl From<mocap::Error> for Failure {
    fn from(error: mocap::Error) -> Self {
        Self {
            status: Status::ReadFailed,
            message: error.to_string(),
        }
    }
}

/// The largest size of an error text in bytes, including the zero byte at its end.
const LONGEST_TEXT: usize = 4096;

/// The end of a shortened text.
const CUT: &str = " ...";

/// Memory for the text of a thread's last failure. The memory is never freed, so that pointers into it stay valid. When
/// the thread ends, another thread may reuse the memory. The last byte is always 0.
type TextMemory = &'static [AtomicU8; LONGEST_TEXT];

static UNUSED: Mutex<Vec<TextMemory>> = Mutex::new(Vec::new());

/// The last failure of a thread.
struct LastFailure {
    /// The reason of the failure. The text stays unchanged until the next failure, because C evaluates arguments in any
    /// order. In `printf("%s %d", mocap_error_text(), ...)`, a successful call may run after `mocap_error_text` and
    /// before the text is printed.
    text: Option<TextMemory>,
    /// Whether the last call failed with this text.
    is_last: bool,
}

impl LastFailure {
    fn write(&mut self, message: &str) {
        let memory = self.text.get_or_insert_with(|| {
            let unused = UNUSED.lock().ok().and_then(|mut unused| unused.pop());
            unused.unwrap_or_else(|| Box::leak(Box::new([const { AtomicU8::new(0) }; LONGEST_TEXT])))
        });
        let message = message.split('\0').next().unwrap_or_default();
        let (kept, end) = match message.len() < LONGEST_TEXT {
            true => (message, ""),
            false => (before(message, LONGEST_TEXT - 1 - CUT.len()), CUT),
        };
        let bytes = kept.bytes().chain(end.bytes()).chain(std::iter::once(0));
        for (place, byte) in memory.iter().zip(bytes) {
            place.store(byte, Ordering::Relaxed);
        }
    }
}

/// The longest start of a string within `bytes` bytes that ends between two characters.
fn before(text: &str, bytes: usize) -> &str {
    let end = (0..=bytes).rev().find(|&end| text.is_char_boundary(end));
    &text[..end.unwrap_or(0)]
}

impl Drop for LastFailure {
    fn drop(&mut self) {
        if let (Some(memory), Ok(mut unused)) = (self.text, UNUSED.lock()) {
            unused.push(memory);
        }
    }
}

thread_local! {
    static LAST_FAILURE: RefCell<LastFailure> = const {
        RefCell::new(LastFailure { text: None, is_last: false })
    };
}

/// The reason why the thread's last call failed; empty if it succeeded. The text stays unchanged until the thread's
/// next failure.
pub(crate) fn last_failure() -> *const c_char {
    LAST_FAILURE.with_borrow(|last| match last.text {
        Some(text) if last.is_last => text.as_ptr().cast(),
        _ => c"".as_ptr(),
    })
}

/// Runs `call`. If it fails or panics, stores the reason and returns `otherwise`.
pub(crate) fn guard<T>(otherwise: T, call: impl FnOnce() -> Result<T, Failure>) -> T {
    caught(call).unwrap_or(otherwise)
}

/// Runs `call`, and returns its status.
pub(crate) fn status(call: impl FnOnce() -> Result<(), Failure>) -> Status {
    match caught(call) {
        Ok(()) => Status::Ok,
        Err(status) => status,
    }
}

fn caught<T>(call: impl FnOnce() -> Result<T, Failure>) -> Result<T, Status> {
    // An open scene never changes, so a panic leaves no partial state.
    let result = catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|panic| Err(Failure::defect(&*panic)));
    let (result, message) = match result {
        Ok(value) => (Ok(value), None),
        Err(Failure { status, message }) => (Err(status), Some(message)),
    };
    LAST_FAILURE.with_borrow_mut(|last| {
        last.is_last = message.is_some();
        if let Some(message) = &message {
            last.write(message);
        }
    });
    result
}

/// Converts a string for C. The text ends at its first zero byte.
pub(crate) fn c_text(text: &str) -> CString {
    let before_zero = text.split('\0').next().unwrap_or_default();
    CString::new(before_zero).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use super::*;

    fn error_text() -> String {
        // SAFETY: the text is never freed, and no call comes in between.
        let text = unsafe { CStr::from_ptr(last_failure()) };
        text.to_str().unwrap().to_owned()
    }

    #[test]
    fn a_panic_becomes_a_status_and_a_text() {
        assert_eq!(status(|| panic!("slice {} is gone", 7)), Status::Defect);
        assert_eq!(error_text(), "a defect of the library: slice 7 is gone");
        assert_eq!(guard(5, || panic!("gone")), 5);
        assert_eq!(error_text(), "a defect of the library: gone");
    }

    #[test]
    fn a_success_clears_the_text() {
        assert_eq!(status(|| Err(Failure::argument("too small"))), Status::BadArgument);
        assert_eq!(error_text(), "too small");
        assert_eq!(status(|| Ok(())), Status::Ok);
        assert_eq!(error_text(), "");
    }

    #[test]
    fn a_text_outlives_calls_that_succeed() {
        assert_eq!(status(|| Err(Failure::argument("too small"))), Status::BadArgument);
        let text = last_failure();
        for _ in 0..3 {
            assert_eq!(status(|| Ok(())), Status::Ok);
        }
        // SAFETY: the text is never freed.
        assert_eq!(unsafe { CStr::from_ptr(text) }.to_str(), Ok("too small"));
    }

    #[test]
    fn a_text_cannot_dangle() {
        let fail = |message: &str| {
            assert_eq!(status(|| Err(Failure::argument(message))), Status::BadArgument);
            last_failure() as usize
        };
        let kept = fail("too small");
        assert_eq!(fail("too large"), kept);
        let of_ended = std::thread::spawn(move || fail("gone")).join().unwrap();
        // SAFETY: the text is never freed, also when its thread has ended.
        let text = unsafe { CStr::from_ptr(of_ended as *const c_char) };
        assert!(text.to_bytes().len() < LONGEST_TEXT);
        // The memory depends on the number of threads that live at the same time.
        let mut places: Vec<_> = (0..50)
            .map(|_| std::thread::spawn(move || fail("gone")).join().unwrap())
            .collect();
        places.sort_unstable();
        places.dedup();
        assert!(places.len() < 25, "{}", places.len());
    }

    #[test]
    fn a_long_text_is_cut_between_letters() {
        for length in [LONGEST_TEXT - 2, LONGEST_TEXT - 1, LONGEST_TEXT, 3 * LONGEST_TEXT] {
            let message = "\u{e9}".repeat(length / 2);
            assert_eq!(status(|| Err(Failure::argument(&message))), Status::BadArgument);
            let text = error_text();
            assert!(text.len() < LONGEST_TEXT && text.starts_with("\u{e9}\u{e9}"));
            assert_eq!(text.ends_with(CUT), message.len() >= LONGEST_TEXT, "{length}");
        }
    }

    #[test]
    fn a_text_ends_at_a_zero_byte() {
        assert_eq!(c_text("left\0right").to_str(), Ok("left"));
    }
}
