//! Tests the errors for formats that a build omits.

use std::path::Path;

use mocap::{Code, FormatInfo};
use mocap_formats::{ReadOptions, Source};

#[test]
fn a_row_that_is_left_out_names_its_feature() {
    let source = Source::of_bytes(b"", Path::new("a"));
    for row in FormatInfo::ALL.iter().filter(|row| row.feature.is_some()) {
        let error = row.read(&source, &ReadOptions::default()).unwrap_err();
        let named = format!("without the feature `{}`", row.feature.unwrap_or_default());
        assert_eq!(error.to_string().contains(&named), !row.reads, "{error}");
        assert_eq!(error.code() == Code::MissingFeature, !row.reads, "{error}");
        assert!(row.reads || !row.writes(), "{}", row.name);
    }
}
