//! Tests the fast reader of short numbers.

mocap_scene::math::wide::dispatch! {
    fn parse_with_avx2(text: &[u8]) -> Option<Option<(f64, usize)>> {
        Some(mocap_formats::internals::bvh::parse(text))
    } else {
        let _ = text;
        None
    }
}

/// Calls the library's `parse`; `None` on a processor that cannot run it.
fn parse(text: &str) -> Option<Option<(f64, usize)>> {
    parse_with_avx2(text.as_bytes())
}

#[test]
fn what_is_read_is_what_the_standard_library_reads() {
    let mut count = 0;
    for digits in [
        "0",
        "5",
        "07",
        "90",
        "123",
        "90071992547409",
        "99999999999999",
        "00000000100001",
    ] {
        for point in 0..=digits.len() + 1 {
            for sign in ["", "-"] {
                let mut number = format!("{sign}{digits}");
                if point <= digits.len() {
                    number.insert(sign.len() + point, '.');
                }
                for after in [
                    " 9999999999999999",
                    "\t-.e888888888888888",
                    "\n................",
                    "\r\n              ",
                ] {
                    let Some(found) = parse(&format!("{number}{after}")) else {
                        return;
                    };
                    let expected: f64 = number.parse().unwrap();
                    match found {
                        Some((value, length)) => {
                            assert_eq!(value.to_bits(), expected.to_bits(), "{number:?}");
                            assert_eq!(length, number.len());
                        }
                        None => assert!(number.len() > 15, "{number:?}"),
                    }
                    count += 1;
                }
            }
        }
    }
    assert!(count > 500);
}

#[test]
fn every_decimal_of_six_digits_is_correctly_rounded() {
    for value in 0..1_000_000_u32 {
        let number = format!("{:.4} -17.25      ", f64::from(value) / 1e4);
        let Some(found) = parse(&number) else { return };
        let expected: f64 = number.split(' ').next().unwrap().parse().unwrap();
        assert_eq!(
            found.map(|(value, _)| value.to_bits()),
            Some(expected.to_bits()),
            "{number}"
        );
    }
}

#[test]
fn other_spellings_are_left_to_the_other_parser() {
    for text in [
        "",
        "-",
        ".",
        "-.",
        "+1",
        "1e5",
        "1.5e-3",
        "nan",
        "inf",
        "1.2.3",
        "1-2",
        "--1",
        "1,5",
        "1:2",
        "1/2",
        "0x10",
        "1.#QNAN",
        "1234567890123456",
        "é1",
    ] {
        let padded = format!("{text}{}", " ".repeat(20));
        let Some(found) = parse(&padded) else { return };
        assert_eq!(found, None, "{text:?}");
    }
    // The number is too near to the end of the text.
    assert!(parse("1.5 ").is_none_or(|found| found.is_none()));
}
