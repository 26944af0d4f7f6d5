//! The options of a piece of work, declared once: a command line, a program and a job file read the same types.

mod reading;
mod source;
mod text;

pub use self::reading::Reading;
pub use self::source::{BoneMap, Source, SourceFrames, SourceMap, SourceSpace, SourceUp};
pub use self::text::{Angle, Length, Rest, StepLength, UnitChoice, UpChoice};

/// Whether a value needs no place in a job file.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
