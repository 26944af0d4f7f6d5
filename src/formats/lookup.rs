//! Looks up a format by name, extension or file contents.

use std::path::Path;

use mocap_scene::scene::Format;

use crate::FormatInfo;

impl FormatInfo {
    /// The row without its functions. A writer that used the row itself would link the reader of the format.
    pub(crate) const fn without_functions(self) -> Self {
        Self {
            sniff: Self::BASE.sniff,
            read: Self::BASE.read,
            write: None,
            provenance: Self::BASE.provenance,
            inspect: Self::BASE.inspect,
            ..self
        }
    }

    /// The row of a format.
    pub fn of(format: Format) -> &'static Self {
        // A test checks that every format has its row.
        FormatInfo::ALL
            .iter()
            .find(|row| row.format == format)
            .unwrap_or(&FormatInfo::ALL[0])
    }

    /// The format to write for the extension of `path`, in any case, including formats that this build omits.
    pub fn of_output(path: &Path) -> Option<&'static Self> {
        let extension = path.extension()?;
        let is_its = |known: &&str| extension.eq_ignore_ascii_case(known);
        let mut written = FormatInfo::ALL.iter().filter(|row| row.write.is_some());
        written.find(|row| row.extensions.iter().any(is_its))
    }

    /// The format of a file's contents, from its first 64 KiB or all of its bytes.
    ///
    /// ```
    /// use mocap::{Format, FormatInfo};
    ///
    /// let table = FormatInfo::of_contents(b"frame,joint,x,y,z\n0,hips,0,1,0\n");
    /// assert_eq!(table.map(|row| row.format), Some(Format::Csv));
    /// assert!(FormatInfo::of_contents(b"file,size\n").is_none());
    /// ```
    pub fn of_contents(bytes: &[u8]) -> Option<&'static Self> {
        FormatInfo::ALL.iter().find(|row| (row.sniff)(bytes))
    }
}
