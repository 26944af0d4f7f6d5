//! How messages call an option: as the program, or the language, through which it was given.
//!
//! A message of the library has an option in braces, with the key that it has in a job: `name it with {skeleton}`. The
//! program says `--skeleton`, Python `skeleton=`. One process is one of them.

use std::borrow::Cow;
use std::sync::{PoisonError, RwLock};

/// What an option is called, by its key in a job.
type Spelling = fn(&str) -> String;

static SPELLING: RwLock<Option<Spelling>> = RwLock::new(None);

/// Says how this process calls options, before its first message. Without, they have the names of the methods of Rust.
#[doc(hidden)]
pub fn spell_options(spelling: Spelling) {
    // The module of Python may become the program `mocap`.
    *SPELLING.write().unwrap_or_else(PoisonError::into_inner) = Some(spelling);
}

/// A message with the names of its options.
#[doc(hidden)]
pub fn spelled(message: &str) -> Cow<'_, str> {
    let Some((before, rest)) = message.split_once('{') else {
        return Cow::Borrowed(message);
    };
    let spelling = *SPELLING.read().unwrap_or_else(PoisonError::into_inner);
    let mut text = before.to_owned();
    let mut rest = rest;
    loop {
        let (next, after) = rest
            .split_once('{')
            .map_or((rest, None), |(next, after)| (next, Some(after)));
        match next.split_once('}').filter(|(key, _)| is_key(key)) {
            Some((key, next)) => {
                text += &spelling.map_or_else(|| format!("`{}`", key.replace('-', "_")), |spell| spell(key));
                text += next;
            }
            None => {
                text.push('{');
                text += next;
            }
        }
        match after {
            Some(after) => rest = after,
            None => return Cow::Owned(text),
        }
    }
}

/// Keys of jobs have small letters and dashes.
fn is_key(text: &str) -> bool {
    text.starts_with(|first: char| first.is_ascii_lowercase())
        && text.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-')
}
