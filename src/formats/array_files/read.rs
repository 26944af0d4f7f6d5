//! Reads the arrays of a container into a scene.

#[cfg(feature = "npz")]
mod archive;
mod body;
mod csv;
mod face;
#[doc(hidden)]
pub mod humanml3d;
mod layouts;
mod max;
mod mot;
mod motion;
mod motive;
#[doc(hidden)]
pub(crate) mod ndarray;
mod npy;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "parquet")]
mod parquet_pages;
mod pickle;
mod point_rows;
mod proportions;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::{is_face_csv, is_motive_csv};
use mocap_scene::limits::Limits;
use mocap_scene::scene::{Format, Scene};

#[doc(hidden)]
pub use self::body::Body;
pub(crate) use self::body::BodyModel;
#[doc(hidden)]
pub use self::layouts::mhr::{BodyFrames, MHR_ROOT_HEIGHT, frames as mhr_frames};
use self::ndarray::{Bytes, Entries};
use self::npy::Npy;
#[cfg(feature = "parquet")]
#[doc(hidden)]
pub use self::parquet::{ParquetRows, parquet_rows};
#[doc(hidden)]
pub use self::proportions::SMPL_ROOT;
#[cfg(feature = "npz")]
use super::is_npz;
use super::{is_face_json, is_max_json, is_pickle};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions, Source};

fn check_not_empty(source: &Source<'_>) -> Result<()> {
    match source.bytes.is_empty() {
        true => Err(Diagnostic::new(Code::EmptyFile, "the file is empty").into()),
        false => Ok(()),
    }
}

/// Reads a file into a scene. `list` finds the arrays of the file and passes them to the layouts.
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

pub(super) fn read_npy(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    read_by(source, options, Format::Npy, |bytes, _, see| {
        let bytes = Bytes::File(bytes);
        let mut entries = Entries::default();
        add(&mut entries, "", &bytes, "of the file")?;
        see(&entries)
    })
}

pub(super) fn read_mot(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    check_not_empty(source)?;
    let columns = mot::Columns::read(source.bytes, &options.limits, &mut warnings);
    let motion = columns.and_then(|columns| layouts::opensim::motion(&columns, options, &mut warnings));
    let scene = motion.map(|motion| motion.into_scene(Format::Mot, &mut warnings));
    warnings.attach_to(scene)
}

pub(super) fn read_csv(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    check_not_empty(source)?;
    let read = match source.bytes {
        bytes if is_motive_csv(bytes) => motive::scene(bytes, options, &mut warnings),
        bytes if is_face_csv(bytes) => face::scene(bytes, options, &mut warnings),
        bytes if is_face_json(bytes) => face::read_json(bytes, options, &mut warnings),
        bytes if is_max_json(bytes) => max::entries(bytes, options)
            .and_then(|entries| layouts::scene(&entries, Format::Csv, options, &mut warnings)),
        _ => csv::entries(source.bytes, &mut warnings)
            .and_then(|entries| layouts::scene(&entries, Format::Csv, options, &mut warnings)),
    };
    warnings.attach_to(read)
}

#[cfg(feature = "parquet")]
pub(super) fn read_parquet(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let read = parquet::scene(source.bytes, options, &mut warnings);
    warnings.attach_to(read)
}

pub(super) fn read_pickle(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    read_by(source, options, Format::Pickle, |bytes, _, see| see_pickle(bytes, see))
}

/// Passes the arrays of a pickle to `see`.
fn see_pickle<T>(bytes: &[u8], see: &mut dyn FnMut(&Entries<'_>) -> Result<T, Failure>) -> Result<T, Failure> {
    let pickle = pickle::read(bytes, &mut |_| Err(no_storage()))?;
    see(&pickle::entries(&pickle))
}

/// The body model in the bytes of an `.npz` or a pickle; `None` if the bytes contain no body model.
///
/// # Errors
/// The errors of the container, and an error for a model with inconsistent arrays.
#[doc(hidden)]
pub fn body_model(bytes: &[u8], limits: &Limits) -> Result<Option<BodyModel>> {
    let mut see = |entries: &Entries<'_>| BodyModel::of(entries, limits);
    let found = match () {
        () if is_pickle(bytes) => see_pickle(bytes, &mut see),
        #[cfg(feature = "npz")]
        () if is_npz(bytes) => see_npz(bytes, limits, &mut see),
        () => Ok(None),
    };
    found.map_err(|failure| (*failure).into())
}

impl BodyFrames {
    /// Adds the persons in the file of one frame. The file is an `.npz`, a pickle, or an `.npy` that contains a pickle.
    ///
    /// # Errors
    /// The errors of the container, and [`Code::RowLength`] if the arrays have several frames.
    #[doc(hidden)]
    #[cfg_attr(not(feature = "npz"), allow(unused_variables, reason = "archives alone have limits"))]
    pub fn read(&mut self, frame: u64, bytes: &[u8], limits: &Limits) -> Result<()> {
        let mut see = |entries: &Entries<'_>| self.add(frame, entries);
        let read = match () {
            () if is_pickle(bytes) => see_pickle(bytes, &mut see),
            #[cfg(feature = "npz")]
            () if is_npz(bytes) => see_npz_of(bytes, limits, &Self::reads, &mut see),
            () => {
                let bytes = Bytes::File(bytes);
                let mut entries = Entries::default();
                add(&mut entries, "", &bytes, "of the file").and_then(|()| see(&entries))
            }
        };
        read.map_err(|failure| (*failure).into())
    }

    /// The scene with the motion of all added frames.
    ///
    /// # Errors
    /// [`Code::FrameTime`] if neither a file nor the options state a frame rate.
    #[doc(hidden)]
    pub fn scene(self, options: &ReadOptions) -> Result<Scene> {
        let mut warnings = Warnings::default();
        let scene = self.into_scene(options, &mut warnings);
        warnings.attach_to(scene)
    }
}

fn no_storage() -> Failure {
    let message = "the pickle refers to tensors that it does not contain";
    Box::new(Diagnostic::new(Code::UnexpectedToken, message).help("save the tensors with torch.save, as a .pt"))
}

/// Adds the array of an `.npy` with this name. If the array holds objects, adds the arrays in the pickle of the
/// objects.
fn add<'a>(entries: &mut Entries<'a>, name: &str, bytes: &'a Bytes<'a>, path_of_entry: &str) -> Result<(), Failure> {
    match npy::read(bytes, path_of_entry)? {
        Npy::Array(array) => entries.arrays.push((name.to_owned(), array)),
        Npy::Objects(begin) => add_objects(entries, name, bytes.get(begin..).unwrap_or_default())?,
    }
    Ok(())
}

/// Adds the arrays of a pickle that an array of objects contains. If the pickle has one array instead of a dictionary,
/// this array gets the name of the array of objects.
fn add_objects<'a>(entries: &mut Entries<'a>, name: &str, bytes: &'a [u8]) -> Result<(), Failure> {
    let pickle = pickle::read(bytes, &mut |_| Err(no_storage()))?;
    let inner = pickle::entries(&pickle);
    entries.is_cut |= inner.is_cut;
    // The object in an array of one object has the name 0.
    let only = if inner.arrays.iter().all(|(own, _)| own.starts_with("0.")) {
        "0."
    } else {
        ""
    };
    for (own, array) in inner.arrays {
        let own = own.strip_prefix(only).unwrap_or(&own);
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
pub(super) fn read_npz(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    read_by(source, options, Format::Npz, see_npz)
}

/// Passes the arrays of an archive to `see`.
#[cfg(feature = "npz")]
fn see_npz<T>(
    bytes: &[u8],
    limits: &Limits,
    see: &mut dyn FnMut(&Entries<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    see_npz_of(bytes, limits, &|_| true, see)
}

/// Passes to `see` the arrays of an archive whose names `reads` accepts.
#[cfg(feature = "npz")]
fn see_npz_of<T>(
    bytes: &[u8],
    limits: &Limits,
    reads: &dyn Fn(&str) -> bool,
    see: &mut dyn FnMut(&Entries<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let mut archive = archive::Archive::open(bytes, limits)?;
    let mut files = Vec::new();
    for name in archive.names() {
        let Some(own) = name.strip_suffix(".npy").filter(|own| reads(own)) else {
            continue;
        };
        if let Some(bytes) = archive.entry(&name)? {
            files.push((own.to_owned(), bytes));
        }
    }
    let mut entries = Entries::default();
    for (own, bytes) in &files {
        add(&mut entries, own, bytes, own)?;
    }
    see(&entries)
}

#[cfg(feature = "npz")]
pub(super) fn read_torch(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
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
