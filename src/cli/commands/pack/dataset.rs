//! `mocap pack --to hf`: a Hugging Face dataset.

use std::io;

use mocap::arrays::table::dataset::DatasetWriter;

use super::{Packed, Packer, Rows, tell};
use crate::Failure;
use crate::args::{ArgumentSources, PackArgs, TableArg};
use crate::batch::inputs::Input;
use crate::batch::progress::{Outcome, Progress};
use crate::batch::{self, InOrder, thread_count};

/// Packs all inputs into a folder without a manifest: a dataset is always made completely. Its card lists unreadable
/// files.
pub(super) fn run(args: &PackArgs, given: &ArgumentSources, inputs: &[Input]) -> Result<(), Failure> {
    given.refuse(&["resume", "shard"], "a dataset is always made from all inputs")?;
    given.refuse(
        &["force"],
        "a dataset only replaces an earlier dataset; remove other folders",
    )?;
    if let TableArg::Inventory = args.table() {
        let why = "a dataset has motions, but an inventory has none; use --table clips or long";
        return Err(Failure::Usage(format!("--table inventory: {why}")));
    }
    let options = DatasetWriter::options(args.arrays.options(&args.source, &args.map));
    let paths = inputs.iter().map(|input| &input.path);
    let mut dataset = DatasetWriter::create(&args.out_dir, paths, &options, args.license.as_deref())?;
    let packer = Packer::new(args, &given.options, options);
    let mut progress = Progress::new(args.spread.progress(), inputs);
    let most_bytes = args.part_size as usize * 1_000_000;
    let (mut rows, mut bytes, mut failures) = (Vec::<Rows>::new(), 0, Vec::new());
    let mut in_order = InOrder::new();
    let take_in = |index: usize, packed: Packed| -> io::Result<()> {
        let outcome = match &packed.record.error {
            Some(_) => Outcome::Failed,
            None => Outcome::Done,
        };
        progress.add(&inputs[index], outcome);
        in_order.push(index, (index, packed));
        while let Some((index, packed)) = in_order.pop() {
            match (packed.rows, packed.clip) {
                (Some(new), Some(clip)) => {
                    dataset.add(clip, &inputs[index].path).map_err(io::Error::other)?;
                    bytes += new.bytes();
                    rows.push(new);
                }
                _ => {
                    let error = packed.record.error.unwrap_or_default();
                    dataset.leave_out(&packed.record.input, &error);
                    failures.push(format!("  {}  {error}", packed.record.input));
                }
            }
            if bytes >= most_bytes {
                dataset
                    .write_shard(rows.iter().flat_map(Rows::tables))
                    .map_err(io::Error::other)?;
                (rows, bytes) = (Vec::new(), 0);
            }
        }
        Ok(())
    };
    let threads = thread_count(args.spread.threads);
    let (pack, panicked) = (
        |input: &Input| packer.pack(input),
        |input: &Input| packer.panicked(input),
    );
    let packed = batch::for_each(inputs, threads, pack, panicked, take_in);
    packed.map_err(|error| Failure::Folder(args.out_dir.clone(), error))?;
    if !rows.is_empty() {
        dataset.write_shard(rows.iter().flat_map(Rows::tables))?;
    }
    let counts = progress.finish();
    if counts.failed < counts.files {
        dataset.finish()?;
    }
    tell(args, counts, failures)
}
