//! Writes datasets for the library `datasets`.

use std::path::PathBuf;

use mocap::arrays::table::dataset::{DatasetClip, DatasetWriter};
use mocap::arrays::{Arrays, table};
use pyo3::prelude::*;

use crate::errors::to_python;
use crate::{ReadOptions, options_from};

/// Writes a dataset of files with their names in the dataset. Returns the names of unreadable files with the reasons.
#[pyfunction]
pub(crate) fn write_dataset(
    py: Python<'_>,
    files: Vec<(String, PathBuf)>,
    folder: PathBuf,
    license: Option<&str>,
    part_bytes: usize,
    options: &str,
    read: ReadOptions,
) -> PyResult<Vec<(String, String)>> {
    let importer = read.importer()?;
    let options = DatasetWriter::options(options_from(options)?);
    let written = py.detach(|| -> mocap::Result<_> {
        let mut dataset = DatasetWriter::create(&folder, files.iter().map(|(_, path)| path), &options, license)?;
        let (mut rows, mut bytes, mut failed) = (Vec::new(), 0, Vec::new());
        for (name, path) in &files {
            let motion = importer.import(path).and_then(|scene| {
                let motion = Arrays::of(&scene, &options)?;
                table::check_row(&motion)?;
                Ok((motion, scene.metadata.attribution))
            });
            match motion {
                Ok((motion, attribution)) => {
                    dataset.add(DatasetClip::new(name, &motion).attributed(&attribution), path)?;
                    let row = table::clips(&[(name.as_str(), Ok(&motion))], &options);
                    bytes += row.get_array_memory_size();
                    rows.push(row);
                }
                Err(error) => {
                    dataset.leave_out(name, &error.to_string());
                    failed.push((name.clone(), error.to_string()));
                }
            }
            if bytes >= part_bytes {
                dataset.write_shard(rows.drain(..))?;
                bytes = 0;
            }
        }
        if !rows.is_empty() {
            dataset.write_shard(rows)?;
        }
        dataset.finish()?;
        Ok(failed)
    });
    written.map_err(|error| to_python(py, &error))
}
