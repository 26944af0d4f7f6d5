//! The table of formats.

use mocap::{Format, FormatInfo};

/// A build without a feature has a row with the error that names the feature.
#[test]
fn every_format_has_a_row() {
    for format in Format::ALL {
        let rows = FormatInfo::ALL.iter().filter(|row| row.format == format).count();
        assert_eq!(rows, 1, "{format}");
    }
}
