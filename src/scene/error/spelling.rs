//! Spells option names in messages, as the command line or the programming language spells them.
//!
//! A message of the library has an option's job key in braces: `name it with {skeleton}`. The program prints
//! `--skeleton`, Python prints `skeleton=`. A process has one spelling.

use std::borrow::Cow;
use std::sync::{PoisonError, RwLock};

/// The spelling of an option, by its key in a job.
type Spelling = fn(&str) -> String;

static SPELLING: RwLock<Option<Spelling>> = RwLock::new(None);

/// Sets the spelling of options in this process. Call this function before the first message. By default, options have
/// the names of Rust methods.
#[doc(hidden)]
pub fn spell_options(spelling: Spelling) {
    // A process may load the Python module, and then run the program `mocap`, which has another spelling.
    *SPELLING.write().unwrap_or_else(PoisonError::into_inner) = Some(spelling);
}

/// A message with spelled option names.
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

/// Job keys consist of lower-case letters and dashes.
fn is_key(text: &str) -> bool {
    text.starts_with(|first: char| first.is_ascii_lowercase())
        && text.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-')
}
