//! Tests of the names of columns.

use mocap_solve::internals::unique;

#[test]
fn names_of_columns_are_there_once() {
    let names = ["Fz", "Fz", "a,b", "time", "Fz_2"];
    assert_eq!(unique(names.into_iter()), ["Fz", "Fz_2", "a_b", "time_2", "Fz_2_2"]);
}
