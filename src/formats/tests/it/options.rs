//! Tests that every option of writing belongs to a format.

use mocap::{FormatInfo, WriteOption};

#[test]
fn every_option_is_taken_by_some_format_and_only_by_written_ones() {
    for option in WriteOption::ALL {
        let taking: Vec<_> = FormatInfo::ALL.iter().filter(|row| row.takes(option)).collect();
        assert!(!taking.is_empty(), "{option}");
        assert!(taking.iter().all(|row| row.writes()), "{option}");
    }
}
