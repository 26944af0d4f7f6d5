//! A small reader for Python pickles: dictionaries, lists, tuples, numbers, strings, and NumPy and PyTorch arrays.
//! joblib puts the bytes of an array into the pickle, after the object that describes the array.
//!
//! A pickle is a program for a stack machine, and may call any Python function. This reader calls none: the reader
//! knows the few names that build arrays, and refuses every other name. The operations are from Python's `pickletools`,
//! protocols 0 to 5.
//!
//! Objects are in one list and refer to each other by index. So a pickle that repeats an object a thousand times takes
//! no more memory than its bytes. One operation has at least a byte and makes at most one object; an object takes less
//! than 64 bytes.

mod build;
mod machine;
mod named;
mod objects;

use mocap_scene::error::{Code, Diagnostic};

pub(super) use self::named::entries;
use self::objects::{Id, Objects};
use super::ndarray::Bytes;
use crate::Failure;

/// The objects of a pickle. The last one is the result.
#[derive(Debug)]
pub(super) struct Pickle<'a> {
    objects: Objects<'a>,
    result: Id,
    /// The number of bytes of the pickle.
    size: usize,
}

/// Returns the bytes of the storage with this key, for a pickle in a PyTorch archive.
pub(super) type Storages<'s, 'a> = &'s mut dyn FnMut(&str) -> Result<Bytes<'a>, Failure>;

/// Reads a pickle.
///
/// # Errors
/// - [`Code::UnexpectedToken`]: the pickle calls an unknown name, or the bytes are not a pickle.
/// - [`Code::UnexpectedEnd`]: the pickle is cut off.
pub(super) fn read<'a>(bytes: &'a [u8], storages: Storages<'_, 'a>) -> Result<Pickle<'a>, Failure> {
    machine::Machine::new(bytes, storages).run()
}

fn broken(at: usize, message: &str) -> Failure {
    Box::new(
        Diagnostic::new(
            Code::UnexpectedToken,
            format!("the pickle is broken at byte {at}: {message}"),
        )
        .help("write it again, or save the arrays with numpy.savez"),
    )
}

/// The error for an unknown name.
fn refused(name: &str) -> Failure {
    Box::new(
        Diagnostic::new(
            Code::UnexpectedToken,
            format!("the pickle calls \"{name}\", but mocap runs no code from a file"),
        )
        .expected_found(
            "dictionaries, lists, numbers, strings, NumPy arrays and PyTorch tensors",
            format!("\"{name}\""),
        )
        .help("load the pickle in Python if you trust it, and save the arrays with numpy.savez"),
    )
}
