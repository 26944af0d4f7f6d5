//! Makes text from files safe to show.

use std::borrow::Cow;

/// `text` with escapes for characters that control a terminal or a page: control characters, such as the start of an
/// escape sequence, and characters that change the text direction. Names and paths from files may contain them.
///
/// ```
/// assert_eq!(mocap::visible("Hips\u{1b}[2J\u{202e}"), "Hips\\u{1b}[2J\\u{202e}");
/// ```
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let mut replaced = String::with_capacity(text.len());
    for c in text.chars() {
        if steers(c) {
            replaced.extend(c.escape_unicode());
        } else {
            replaced.push(c);
        }
    }
    Cow::Owned(replaced)
}

/// `json` with JSON escapes for the characters that [`visible`] escapes. Such characters occur only inside strings, so
/// the value does not change.
#[doc(hidden)]
pub fn visible_json(json: &str) -> Cow<'_, str> {
    // Keep line ends between values.
    let is_escaped = |c: char| c != '\n' && steers(c);
    if !json.contains(is_escaped) {
        return Cow::Borrowed(json);
    }
    let escaped = json.chars().map(|c| match is_escaped(c) {
        true => c
            .encode_utf16(&mut [0; 2])
            .iter()
            .map(|unit| format!("\\u{unit:04x}"))
            .collect(),
        false => String::from(c),
    });
    Cow::Owned(escaped.collect())
}

fn steers(c: char) -> bool {
    let changes_direction =
        matches!(c, '\u{61C}' | '\u{200E}' | '\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}');
    let ends_line = matches!(c, '\u{2028}' | '\u{2029}');
    c.is_control() || changes_direction || ends_line
}
