//! Results of many files, gathered in memory.

use mocap::Error;

use super::inputs::Input;
use super::progress::{Counts, Outcome, Progress};
use super::spread::SpreadArgs;
use super::{PANICKED, for_each, thread_count};
use crate::{Failure, report};

/// Works on all inputs, and reports each failure. Passes each output to `keep` at once, in the order of completion.
/// Returns the output or the notice of each input, in the order of the inputs.
pub(crate) fn gather<T: Send>(
    spread: &SpreadArgs,
    inputs: &[Input],
    work: impl Fn(&Input) -> mocap::Result<T> + Sync,
    mut keep: impl FnMut(&T) -> mocap::Result<()>,
) -> Result<(Vec<Result<T, String>>, Counts), Failure> {
    let mut progress = Progress::new(spread.progress(), inputs);
    let mut results: Vec<_> = inputs.iter().map(|_| Err(String::new())).collect();
    let work = |input: &Input| work(input).map_err(|error: Error| error.to_string());
    let panicked = |_: &Input| Err(PANICKED.to_owned());
    for_each(inputs, thread_count(spread.threads), work, panicked, |index, result| {
        progress.add(
            &inputs[index],
            if result.is_ok() { Outcome::Done } else { Outcome::Failed },
        );
        match &result {
            Ok(output) => keep(output)?,
            Err(error) => report::complain(error),
        }
        results[index] = result;
        Ok::<_, Failure>(())
    })?;
    Ok((results, progress.finish()))
}
