//! Arrays of other programs: NumPy's `.npz` and `.npy`, pickles, and the `.pt` of PyTorch.
//!
//! | container | is read by |
//! |---|---|
//! | `.npz`, `.pt`: zip | `archive`: each entry stored or deflated, its length and check sum held against what is there |
//! | `.npy` | `npy`: `numpy.lib.format`, versions 1 to 3 |
//! | `.csv` | `csv`: the arrays of this program, and positions of points, by the names of their columns |
//! | `.parquet` | `parquet`: the arrays of this program; what its pages claim is held against the file first |
//! | `.mot`, `.sto` | `mot`: a text of named columns |
//! | `.pkl`, and `data.pkl` in `.pt` | `pickle`: builds arrays, dictionaries, lists, numbers and texts, and calls nothing |
//!
//! What the arrays mean is told by their names and shapes (`layouts`): AMASS, SMPL-X's dictionaries, GVHMR, GEM-X,
//! Motion-X, PHUMA, Kimodo, joint angles of OpenSim, the arrays of this program, and positions alone, which are points
//! without a skeleton. Rotations without lengths are put on a body that is given (`body`), or else on one of our own
//! (`proportions`): no file of a licensed model is needed, and nothing of one stands here. `docs/arrays.md` says what
//! each layout is.

#[cfg(feature = "npz")]
mod archive;
mod body;
mod csv;
#[cfg_attr(
    not(feature = "npz"),
    expect(dead_code, reason = "HumanML3D is written as an archive of NumPy")
)]
#[doc(hidden)]
pub mod humanml3d;
mod layouts;
mod mot;
mod motion;
mod ndarray;
mod npy;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "parquet")]
mod parquet_pages;
mod pickle;
mod point_rows;
mod proportions;

#[doc(hidden)]
pub use self::body::Body;
pub(crate) use self::body::BodyModel;
use self::ndarray::{Bytes, Entries, NdArray};
use self::npy::Npy;
#[cfg(feature = "npz")]
#[doc(hidden)]
pub use self::proportions::SMPL_ROOT;
use crate::warnings::Warnings;
use crate::{Failure, FormatInfo, ReadOptions, Source};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::Limits;
use mocap_scene::scene::{Format, Scene};

/// What all rows have in common.
const ROW: FormatInfo = FormatInfo {
    format: Format::Npy,
    name: "NumPy's .npy",
    description: "one array of NumPy",
    extensions: &["npy"],
    reading: "good: layouts that are known by their shapes",
    writing: "no",
    sniff: |bytes| bytes.starts_with(npy::MAGIC),
    reads_blocks: false,
    reads: true,
    read: read_npy,
    write: None,
    options: &[],
    has_one_clip: false,
    has_file_meshes: false,
    states_bones: false,
    states_origin: false,
    has_rest_rotations: true,
    keeps_shear: true,
};

pub(super) const NPY: FormatInfo = ROW;

pub(super) const NPZ: FormatInfo = FormatInfo {
    format: Format::Npz,
    name: "NumPy's .npz",
    description: "arrays of NumPy: AMASS, SMPL-X, Kimodo, our own",
    extensions: &["npz"],
    reading: "good: layouts that are known by the names of their arrays",
    sniff: |bytes| first_name(bytes).is_some_and(|name| name.ends_with(".npy")),
    reads: cfg!(feature = "npz"),
    read: read_npz,
    ..ROW
};

pub(super) const TORCH: FormatInfo = FormatInfo {
    format: Format::Torch,
    name: "PyTorch's .pt",
    description: "tensors of PyTorch: GVHMR, GEM-X",
    extensions: &["pt", "pth"],
    reading: "good: layouts that are known by the names of their arrays; nothing of a file is run",
    sniff: |bytes| first_name(bytes).is_some_and(|name| name.ends_with("/data.pkl")),
    reads: cfg!(feature = "npz"),
    read: read_torch,
    ..ROW
};

pub(super) const PICKLE: FormatInfo = FormatInfo {
    format: Format::Pickle,
    name: "a pickle",
    description: "Python's pickle of arrays",
    extensions: &["pkl", "pickle"],
    reading: "good: layouts that are known by the names of their arrays; nothing of a file is run",
    sniff: pickle::sniff,
    read: read_pickle,
    ..ROW
};

pub(super) const CSV: FormatInfo = FormatInfo {
    format: Format::Csv,
    name: "CSV",
    description: "tables of text: our own arrays, positions of points",
    extensions: &["csv"],
    reading: "good: our own back as they were, positions by the names of their columns",
    sniff: csv::sniff,
    read: read_csv,
    ..ROW
};

pub(super) const PARQUET: FormatInfo = FormatInfo {
    format: Format::Parquet,
    name: "Parquet",
    description: "tables of columns: our own arrays",
    extensions: &["parquet"],
    reading: "good: our own back as they were",
    sniff: |bytes| bytes.starts_with(b"PAR1"),
    reads: cfg!(feature = "parquet"),
    read: read_parquet,
    ..ROW
};

pub(super) const MOT: FormatInfo = FormatInfo {
    format: Format::Mot,
    name: "OpenSim's .mot",
    description: "joint angles of OpenSim's models",
    extensions: &["mot", "sto"],
    reading: "fair: joint angles of its gait models, on any body; `mocap angles` writes them",
    sniff: mot::sniff,
    read: read_mot,
    ..ROW
};

/// The name of the first file of an archive.
#[cfg(feature = "npz")]
fn first_name(bytes: &[u8]) -> Option<&str> {
    archive::first_name(bytes)
}

#[cfg(not(feature = "npz"))]
fn first_name(_: &[u8]) -> Option<&str> {
    None
}

fn check_not_empty(source: &Source<'_>) -> Result<()> {
    match source.bytes.is_empty() {
        true => Err(Diagnostic::new(Code::EmptyFile, "the file is empty").into()),
        false => Ok(()),
    }
}

/// The scene of the arrays that `list` finds in the file of a row.
fn read_by(
    source: &Source<'_>,
    options: &ReadOptions,
    format: Format,
    list: impl FnOnce(&[u8], &Limits, &mut dyn FnMut(&Entries<'_>) -> Result<Scene, Failure>) -> Result<Scene, Failure>,
) -> Result<Scene> {
    let mut warnings = Warnings::default();
    check_not_empty(source)?;
    let read = list(source.bytes, &options.limits, &mut |entries| {
        layouts::scene(entries, format, options, &mut warnings)
    });
    warnings.attach_to(read)
}

fn read_npy(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    read_by(source, options, Format::Npy, |bytes, _, see| {
        let mut entries = Entries::default();
        add(&mut entries, "", Bytes::File(bytes), "of the file")?;
        see(&entries)
    })
}

fn read_mot(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    check_not_empty(source)?;
    let columns = mot::Columns::read(source.bytes, &options.limits, &mut warnings);
    let motion = columns.and_then(|columns| layouts::opensim::motion(&columns, options, &mut warnings));
    let scene = motion.map(|motion| motion.into_scene(Format::Mot, &mut warnings));
    warnings.attach_to(scene)
}

fn read_csv(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    check_not_empty(source)?;
    let read = csv::entries(source.bytes, &mut warnings)
        .and_then(|entries| layouts::scene(&entries, Format::Csv, options, &mut warnings));
    warnings.attach_to(read)
}

#[cfg(feature = "parquet")]
fn read_parquet(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let read = parquet::scene(source.bytes, options, &mut warnings);
    warnings.attach_to(read)
}

#[cfg(not(feature = "parquet"))]
fn read_parquet(_: &Source<'_>, _: &ReadOptions) -> Result<Scene> {
    Err(
        Diagnostic::new(Code::UnreadableFormat, "this build does not read Parquet")
            .help("build it with --features parquet, or write the arrays as .npz or .csv")
            .into(),
    )
}

fn read_pickle(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    read_by(source, options, Format::Pickle, |bytes, _, see| see_pickle(bytes, see))
}

/// Shows the arrays of a pickle.
fn see_pickle<T>(bytes: &[u8], see: &mut dyn FnMut(&Entries<'_>) -> Result<T, Failure>) -> Result<T, Failure> {
    let pickle = pickle::read(bytes, &mut |_| Err(no_storage()))?;
    see(&pickle::entries(&pickle))
}

/// The model of a body in the bytes of an `.npz` or a pickle; `None` where they are something else.
///
/// # Errors
/// Those of the container, and of a model whose arrays do not belong together.
#[doc(hidden)]
pub fn body_model(bytes: &[u8], limits: &Limits) -> Result<Option<BodyModel>> {
    let mut see = |entries: &Entries<'_>| BodyModel::of(entries, limits);
    let found = match () {
        () if (PICKLE.sniff)(bytes) => see_pickle(bytes, &mut see),
        #[cfg(feature = "npz")]
        () if (NPZ.sniff)(bytes) => see_npz(bytes, limits, &mut see),
        () => Ok(None),
    };
    found.map_err(|failure| (*failure).into())
}

fn no_storage() -> Failure {
    let message = "the pickle refers to tensors that it does not hold";
    Box::new(Diagnostic::new(Code::UnexpectedToken, message).help("save it with torch.save, as a .pt"))
}

/// Adds the arrays of an `.npy` with this name: those of a pickle where it holds objects.
fn add<'a>(entries: &mut Entries<'a>, name: &str, bytes: Bytes<'a>, path_of_entry: &str) -> Result<(), Failure> {
    match npy::read(&bytes, path_of_entry)? {
        Npy::Array(array) => entries.arrays.push((name.to_owned(), array)),
        Npy::Objects(Bytes::File(bytes)) => add_objects(entries, name, bytes)?,
        // Small ones are read, from bytes that are kept as long as the file's.
        Npy::Objects(Bytes::Made(..)) => {}
    }
    Ok(())
}

/// The arrays of a pickle within an array of objects; one without a dictionary keeps the name.
fn add_objects<'a>(entries: &mut Entries<'a>, name: &str, bytes: &'a [u8]) -> Result<(), Failure> {
    let pickle = pickle::read(bytes, &mut |_| Err(no_storage()))?;
    let inner: Vec<(String, NdArray<'a>)> = pickle::entries(&pickle).arrays;
    for (own, array) in inner {
        // The object of an array of one is called 0.
        let own = own.strip_prefix("0.").unwrap_or(&own);
        let joined = match (name, own) {
            (name, "" | "0") => name.to_owned(),
            ("", own) => own.to_owned(),
            (name, own) => format!("{name}.{own}"),
        };
        entries.arrays.push((joined, array));
    }
    Ok(())
}

#[cfg(feature = "npz")]
fn read_npz(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    read_by(source, options, Format::Npz, see_npz)
}

/// Shows the arrays of an archive.
#[cfg(feature = "npz")]
fn see_npz<T>(
    bytes: &[u8],
    limits: &Limits,
    see: &mut dyn FnMut(&Entries<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let mut archive = archive::Archive::open(bytes, limits)?;
    let mut entries = Entries::default();
    for name in archive.names() {
        let Some(own) = name.strip_suffix(".npy") else {
            continue;
        };
        if let Some(bytes) = archive.entry(&name)? {
            add(&mut entries, own, bytes, own)?;
        }
    }
    see(&entries)
}

#[cfg(feature = "npz")]
fn read_torch(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    const PICKLE: &str = "data.pkl";
    read_by(source, options, Format::Torch, |bytes, limits, see| {
        let mut archive = archive::Archive::open(bytes, limits)?;
        let names = archive.names();
        let folder = names.iter().find_map(|name| name.strip_suffix(PICKLE));
        let missing = |name: String| -> Failure {
            let message = format!("the archive of PyTorch has no entry {name}");
            Box::new(Diagnostic::new(Code::MissingKeyword, message).help("export or download it again"))
        };
        let folder = folder.ok_or_else(|| missing(PICKLE.to_owned()))?;
        let pickled = archive.entry(&format!("{folder}{PICKLE}"))?;
        let pickled = pickled.ok_or_else(|| missing(PICKLE.to_owned()))?;
        let mut storage = |key: &str| {
            let name = format!("{folder}data/{key}");
            archive.entry(&name)?.ok_or_else(|| missing(name))
        };
        let pickle = pickle::read(&pickled, &mut storage)?;
        see(&pickle::entries(&pickle))
    })
}

#[cfg(not(feature = "npz"))]
fn read_npz(_: &Source<'_>, _: &ReadOptions) -> Result<Scene> {
    Err(
        Diagnostic::new(Code::UnreadableFormat, "this build does not read archives of arrays")
            .help("build it with the feature npz")
            .into(),
    )
}

#[cfg(not(feature = "npz"))]
fn read_torch(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    read_npz(source, options)
}
