//! Errors about invalid glTF, always with a JSON pointer to the place.

use mocap_scene::error::{Code, Diagnostic};

/// The file breaks a rule of glTF at `pointer`, such as `/accessors/3/count`. An empty pointer means the whole file.
pub(super) fn invalid(pointer: impl Into<String>, message: impl Into<String>) -> Diagnostic {
    let (pointer, diagnostic) = (pointer.into(), Diagnostic::new(Code::InvalidGltf, message));
    let help = "export the file again, or check it with the Khronos glTF validator";
    let diagnostic = match pointer.is_empty() {
        true => diagnostic,
        false => diagnostic.at_pointer(pointer),
    };
    diagnostic.help(help)
}

/// An index of a missing item.
pub(super) fn missing(pointer: impl Into<String>, what: &str, index: usize, count: usize) -> Diagnostic {
    invalid(pointer, format!("there is no {what} {index}"))
        .expected_found(format!("an index below {count}"), format!("{index}"))
}
