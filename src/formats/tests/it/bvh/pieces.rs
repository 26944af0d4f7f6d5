//! Tests the division of a large file into pieces that end with a line.

use std::sync::Mutex;

use mocap_formats::internals::bvh::{LENGTH, Pieces, count_lines};
use mocap_formats::{Blocks, Failure};

/// A reader that returns blocks of a few bytes.
struct ShortReader<'a>(Mutex<&'a [u8]>, usize);

impl Blocks for ShortReader<'_> {
    fn read(&self, block: &mut Vec<u8>) -> Result<usize, Failure> {
        let mut rest = self.0.lock().unwrap();
        let (next, after) = rest.split_at(self.1.min(rest.len()));
        block.extend_from_slice(next);
        *rest = after;
        Ok(next.len())
    }

    fn whole(&self) -> Result<&[u8], Failure> {
        unreachable!("pieces do not need it")
    }

    fn size(&self) -> usize {
        0
    }
}

fn lengths(mut pieces: Pieces<'_>) -> Vec<(usize, usize, usize)> {
    let mut buffer = Vec::new();
    let mut found = Vec::new();
    while let Some(piece) = pieces.next(&mut buffer).unwrap() {
        found.push((piece.offset, piece.text.len(), piece.lines));
    }
    found
}

#[test]
fn pieces_cover_the_text_and_end_with_lines() {
    for line_end in ["\n", "\r", "\r\n"] {
        let line = format!("{}{line_end}", "1 ".repeat(300));
        let text = line.repeat(3 * LENGTH / line.len() + 7).into_bytes();
        let expected = text.len() / line.len() - 1;
        let memory = lengths(Pieces::new(&text, 5, None));
        assert_eq!(memory.len(), 4, "{line_end:?}");
        let (beginning, rest) = text.split_at(1000);
        let few = ShortReader(Mutex::new(rest), 3001);
        let blocks = lengths(Pieces::new(beginning, 5, Some(&few)));
        for pieces in [memory, blocks] {
            let mut end = line.len();
            for (offset, length, _) in &pieces {
                assert_eq!((*offset, length % line.len()), (end, 0), "{line_end:?}");
                end += length;
            }
            assert_eq!(end, text.len());
            assert_eq!(pieces.iter().map(|(_, _, lines)| lines).sum::<usize>(), expected);
        }
    }
}

#[test]
fn a_line_longer_than_a_piece_is_in_one() {
    let text = [b"0\n", &vec![b'1'; 5 * LENGTH / 2][..], b"\n2"].concat();
    let line = 5 * LENGTH / 2 + 1;
    assert_eq!(lengths(Pieces::new(&text, 0, None)), [(2, line, 1), (2 + line, 1, 1)]);
    let few = ShortReader(Mutex::new(&text[3..]), 1000);
    let blocks = lengths(Pieces::new(&text[..3], 0, Some(&few)));
    assert_eq!(blocks, [(2, line, 1), (2 + line, 1, 1)]);
}

#[test]
fn nothing_follows_a_line_without_an_end() {
    assert_eq!(lengths(Pieces::new(b"1 2", 1, None)), []);
    let few = ShortReader(Mutex::new(b""), 10);
    assert_eq!(lengths(Pieces::new(b"1 2\n3", 0, Some(&few))), [(4, 1, 1)]);
}

#[test]
fn empty_lines_at_the_end_are_not_counted() {
    let line_counts = [&b"1\n2\n"[..], b"1\n\n2", b"1\n\n \n", b"\n\n", b""].map(|text| count_lines(text, b'\n'));
    assert_eq!(line_counts, [2, 3, 1, 0, 0]);
}
