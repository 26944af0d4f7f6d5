//! Tests the table of formats.

use mocap::scene::report::DataKind;
use mocap::{Carriage, Format, FormatInfo};
use mocap_formats::internals::states_unit;

/// If a build lacks a feature, the row of the format has an error that names the feature.
#[test]
fn every_format_has_a_row() {
    for format in Format::ALL {
        let rows = FormatInfo::ALL.iter().filter(|row| row.format == format).count();
        assert_eq!(rows, 1, "{format}");
    }
}

/// The writers state which formats have no unit of length.
#[test]
fn the_formats_without_a_unit_are_known() {
    for row in FormatInfo::ALL {
        let is_lost = row.carriage(DataKind::Units) == Carriage::Lost;
        assert_eq!(states_unit(row.format), !is_lost, "{}", row.format);
    }
}
