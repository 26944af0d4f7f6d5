//! The table of formats.

use mocap::scene::report::DataKind;
use mocap::{Carriage, Format, FormatInfo};
use mocap_formats::internals::states_unit;

/// A build without a feature has a row with the error that names the feature.
#[test]
fn every_format_has_a_row() {
    for format in Format::ALL {
        let rows = FormatInfo::ALL.iter().filter(|row| row.format == format).count();
        assert_eq!(rows, 1, "{format}");
    }
}

/// The writers know the formats without a unit of length by themselves.
#[test]
fn the_formats_without_a_unit_are_known() {
    for row in FormatInfo::ALL {
        let is_lost = row.carriage(DataKind::Units) == Carriage::Lost;
        assert_eq!(states_unit(row.format), !is_lost, "{}", row.format);
    }
}
