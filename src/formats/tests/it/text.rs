//! Tests the cursor that reads text files.

mod number;

use mocap_formats::internals::text::{Cursor, LineIndex, Word, decode};

#[test]
fn lines_end_with_cr_lf_or_both() {
    let text = b"a\nb\r\nc\rd\n\r e";
    let cursor = Cursor::new(text);
    let at = |offset| {
        let location = cursor.locate(Word {
            bytes: &text[offset..=offset],
            offset,
        });
        (location.line, location.column)
    };
    assert_eq!([at(0), at(2), at(5), at(7)], [(1, 1), (2, 1), (3, 1), (4, 1)]);
    assert_eq!(at(11), (6, 2));
    let lines = LineIndex::new(text);
    assert_eq!([0, 2, 5, 7, 11].map(|offset| lines.line(offset)), [1, 2, 3, 4, 6]);
}

#[test]
fn columns_count_characters() {
    let text = "Pescoço X".as_bytes();
    let word = Word {
        bytes: b"X",
        offset: text.len() - 1,
    };
    assert_eq!(Cursor::new(text).locate(word).column, 9);
    let latin1 = b"Pesco\xE7o X";
    let word = Word { bytes: b"X", offset: 8 };
    assert_eq!(Cursor::new(latin1).locate(word).column, 9);
}

#[test]
fn an_excerpt_is_a_short_piece_of_a_long_line() {
    let text = format!("first\n{}X{}\nlast", "ä ".repeat(1000), " y".repeat(1000));
    let offset = text.find('X').unwrap();
    let location = Cursor::new(text.as_bytes()).locate(Word { bytes: b"X", offset });
    assert_eq!((location.line, location.column), (2, 2001));
    assert!(location.text.len() < 200);
    assert_eq!(
        location.text.chars().nth(location.column - location.text_column),
        Some('X')
    );
}

#[test]
fn utf16_is_decoded_with_and_without_a_mark() {
    let units: Vec<u16> = "HIERARCHY é".encode_utf16().collect();
    let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
    let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
    let marked = [&[0xFF, 0xFE][..], &little].concat();
    for bytes in [little, big, marked] {
        assert_eq!(decode(&bytes).unwrap().as_ref(), "HIERARCHY é".as_bytes());
    }
}

#[test]
fn names_run_to_the_brace_or_the_line_end() {
    let mut cursor = Cursor::new(b"  Hand.L 1 \t{\nnext");
    assert_eq!(cursor.next_name().bytes, b"Hand.L 1");
    assert_eq!(cursor.next_word().unwrap().bytes, b"{");
    assert_eq!(cursor.next_name().bytes, b"");
    assert_eq!(cursor.next_word().unwrap().bytes, b"next");
}
