//! Errors about invalid glTF, always with a JSON pointer to the place of the error.

use mocap_scene::error::{Code, Diagnostic, wrong_value};

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

/// The error for an index whose item is missing.
pub(super) fn missing(pointer: impl Into<String>, what: &str, index: usize, count: usize) -> Diagnostic {
    let expected = match count {
        0 => format!("no index, because the file has no {what}"),
        _ => format!("an index below {count}"),
    };
    invalid(pointer, format!("there is no {what} {index}")).expected_found(expected, format!("{index}"))
}

/// The message of an error about JSON.
pub(super) fn json_words(error: &serde_json::Error) -> String {
    let said = error.to_string();
    wrong_value(&said).unwrap_or(said)
}
