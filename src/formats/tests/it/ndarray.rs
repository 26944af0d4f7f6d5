//! Tests the reading of arrays of numbers.

use mocap::Code;
use mocap_formats::internals::arrays::{Bytes, Kind, NdArray, half};

#[test]
fn halves_are_those_of_the_standard() {
    let of = [
        (0x3c00, 1.0),
        (0xc000, -2.0),
        (0x7bff, 65504.0),
        (0x0001, 5.960464477539063e-8),
        (0x3555, 0.333251953125),
    ];
    for (bits, value) in of {
        assert_eq!(half(bits), value);
    }
    assert!(half(0x7e00).is_nan() && half(0xfc00) == f64::NEG_INFINITY);
}

/// A view into a larger storage, as in PyTorch, and an array in Fortran order.
#[test]
fn strides_are_followed() {
    let bytes: Vec<u8> = (0..6).collect();
    let kind = (Kind::Uint(1), false);
    let rows = NdArray::new("a", kind, vec![2, 3], false, Bytes::File(&bytes)).unwrap();
    assert_eq!(rows.numbers(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    let columns = NdArray::new("a", kind, vec![2, 3], true, Bytes::File(&bytes)).unwrap();
    assert_eq!(columns.numbers(), [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
    let short = NdArray::new("a", kind, vec![7, 1], false, Bytes::File(&bytes)).unwrap_err();
    assert_eq!(short.code, Code::UnexpectedEnd);
}
