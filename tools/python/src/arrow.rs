//! Arrow tables with the PyCapsule interface, which every Arrow library of Python reads without a copy:
//! <https://arrow.apache.org/docs/format/CDataInterface/PyCapsuleInterface.html>.

use arrow_array::ffi::{FFI_ArrowSchema, to_ffi};
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{Array, RecordBatch, RecordBatchIterator, StructArray};
use mocap::arrays::{Arrays, table as tables};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyCapsule;

use crate::errors::invalid;
use crate::{ReadOptions, options_from};

/// A table with the Arrow PyCapsule interface. `pyarrow.table`, `polars.DataFrame`, DuckDB and others read it without a
/// copy.
#[pyclass(frozen, module = "mocap")]
pub(crate) struct ArrowTable {
    batch: RecordBatch,
}

impl ArrowTable {
    pub(crate) fn new(batch: RecordBatch) -> Self {
        Self { batch }
    }
}

fn refused(error: tables::arrow_schema::ArrowError) -> PyErr {
    invalid(error.to_string())
}

#[pymethods]
impl ArrowTable {
    /// The number of rows.
    #[getter]
    fn num_rows(&self) -> usize {
        self.batch.num_rows()
    }

    /// The names of the columns.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.batch
            .schema()
            .fields()
            .iter()
            .map(|field| field.name().clone())
            .collect()
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema = FFI_ArrowSchema::try_from(self.batch.schema().as_ref()).map_err(refused)?;
        PyCapsule::new_with_value(py, schema, c"arrow_schema")
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_array__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyCapsule>, Bound<'py, PyCapsule>)> {
        // A producer may ignore the requested schema; the consumer then casts.
        let _ = requested_schema;
        let (array, _) = to_ffi(&StructArray::from(self.batch.clone()).to_data()).map_err(refused)?;
        let array = PyCapsule::new_with_value(py, array, c"arrow_array")?;
        Ok((self.__arrow_c_schema__(py)?, array))
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema;
        let batches = RecordBatchIterator::new([Ok(self.batch.clone())], self.batch.schema());
        let stream = FFI_ArrowArrayStream::new(Box::new(batches));
        PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
    }
}

/// A table of many files, in one of the library's shapes. A file that cannot be read is a row with an error.
#[pyfunction]
pub(crate) fn table(
    py: Python<'_>,
    files: Vec<(String, PyBackedBytes)>,
    shape: &str,
    options: &str,
    read: ReadOptions,
) -> PyResult<ArrowTable> {
    let importer = read.importer()?;
    let options = options_from(options)?;
    let inventory = match shape {
        "clips" => false,
        "inventory" => true,
        other => {
            let message = format!("shape must be clips or inventory, got {other:?}");
            return Err(invalid(message));
        }
    };
    let batch = py.detach(|| {
        let scenes = files.iter().map(|(name, data)| importer.read(data, name));
        if inventory {
            let scenes: Vec<_> = scenes.collect();
            let rows: Vec<_> = files.iter().map(|(name, _)| name.as_str()).zip(&scenes).collect();
            return tables::inventory(&rows);
        }
        let motions: Vec<Result<Arrays, String>> = scenes
            .map(|scene| scene.and_then(|scene| Arrays::of(&scene, &options)))
            .map(|motion| motion.map_err(|error| error.to_string()))
            .collect();
        let names = files.iter().map(|(name, _)| name.as_str());
        let rows: Vec<_> = names
            .zip(motions.iter().map(|motion| motion.as_ref().map_err(String::as_str)))
            .collect();
        tables::clips(&rows, &options)
    });
    Ok(ArrowTable::new(batch))
}
