//! Which format a name, an extension or the contents of a file mean.

use std::path::Path;

use mocap_scene::scene::Format;

use crate::FormatInfo;

impl FormatInfo {
    /// The row of a format.
    pub fn of(format: Format) -> &'static Self {
        // A test sees to it that every format has its row.
        FormatInfo::ALL
            .iter()
            .find(|row| row.format == format)
            .unwrap_or(&FormatInfo::ALL[0])
    }

    /// The written format that the extension of `path` names, in any case; also one that this build leaves out.
    pub fn of_output(path: &Path) -> Option<&'static Self> {
        let extension = path.extension()?;
        let is_its = |known: &&str| extension.eq_ignore_ascii_case(known);
        let mut written = FormatInfo::ALL.iter().filter(|row| row.write.is_some());
        written.find(|row| row.extensions.iter().any(is_its))
    }

    /// The format that the contents of a file tell, from its first bytes, 64 KiB or all of them.
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
