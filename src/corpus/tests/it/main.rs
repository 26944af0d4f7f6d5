//! The integration tests of surveys and search: one program, because linking is slow, with one module per subject.

mod matching;
mod placing;
mod search;
mod survey;
mod verdicts;
