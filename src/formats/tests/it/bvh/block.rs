//! Tests that every processor reads a block of frames in the same way.

use mocap_formats::internals::bvh::Block;

/// The length of a row, and the bits of its values.
fn row(columns: usize, read: impl Fn(&mut Block) -> Option<usize>) -> Option<(usize, Vec<u64>)> {
    let mut block = Block::new(columns);
    let length = read(&mut block)?;
    Some((length, block.last_row()?.into_iter().map(f64::to_bits).collect()))
}

#[test]
fn every_processor_reads_the_same_rows() {
    let numbers = [
        "0",
        "-0",
        "-0.0",
        "17.25",
        "-163.0160",
        ".5",
        "5.",
        "+1.5",
        "1e2",
        "-3.10327e-015",
        "0.1234567890123456",
        "12345678901234567890",
        "99999999999999",
        "123456789012345",
        "4e38",
        "nan",
        "inf",
        "-",
        ".",
        "1.2.3",
        "1,5",
        "1-2",
        "é",
        "",
    ];
    let mut plain = 0;
    for first in numbers {
        for second in numbers {
            for gap in [" ", "  ", "\t", "\n", "\u{0}", "\u{a0}"] {
                for end in ["", "\n", " \r\n", " 7 8 9 10 11 12 13 14\n", "\n-1.25 1.25 -1.25 1.25"] {
                    let text = format!("{first}{gap}{second}{end}");
                    let ours = row(2, |block| block.read_plain_row(text.as_bytes()));
                    let common = row(2, |block| block.read_numbers(text.as_bytes(), |_| None));
                    assert_eq!(ours, common, "{text:?}");
                    plain += usize::from(ours.is_some());
                }
            }
        }
    }
    assert!(plain > 1000, "{plain}");
}
