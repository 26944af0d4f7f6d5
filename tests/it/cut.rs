//! Parts of motion files, for tests that need no long motion. A test of the first second takes a hundredth of the time
//! of a whole take.

use std::fs;
use std::ops::Range;

use crate::ROOT;
use crate::sample::Sample;

/// The text of a BVH file with some of its frames.
pub(crate) fn frames(text: &str, kept: Range<usize>) -> String {
    let mut cut = String::new();
    let mut lines = text.lines();
    for line in &mut lines {
        match line.trim_start().starts_with("Frames:") {
            true => cut.push_str(&format!("Frames: {}", kept.len())),
            false => cut.push_str(line),
        }
        cut.push('\n');
        if line.trim_start().starts_with("Frame Time:") {
            break;
        }
    }
    for row in lines.skip(kept.start).take(kept.len()) {
        cut.push_str(row);
        cut.push('\n');
    }
    cut
}

/// The number of rows in a BVH file.
pub(crate) fn count(text: &str) -> usize {
    let rows = text
        .lines()
        .skip_while(|line| !line.trim_start().starts_with("Frame Time:"));
    rows.skip(1).filter(|row| !row.trim().is_empty()).count()
}

/// The text of a fixture with its first frames.
pub(crate) fn first_frames(file: &str, frames: usize) -> String {
    let text = fs::read_to_string(format!("{ROOT}/fixtures/{file}")).unwrap();
    let frames = frames.min(count(&text));
    self::frames(&text, 0..frames)
}

/// The text of a fixture with this number of successive frames, from a place that the seed chooses. With `MOCAP_ALL`,
/// all frames.
pub(crate) fn some_frames(random: &mut Sample, file: &str, frames: usize) -> String {
    let text = fs::read_to_string(format!("{ROOT}/fixtures/{file}")).unwrap();
    let all = count(&text);
    if crate::sample::is_all() || all <= frames {
        return text;
    }
    let first = random.below(all - frames + 1);
    self::frames(&text, first..first + frames)
}

#[test]
fn a_cut_file_has_the_rows_that_were_asked_for() {
    let scene = |text: &str| mocap::Importer::new().read(text.as_bytes(), "cut.bvh").unwrap();
    let whole = fs::read_to_string(format!("{ROOT}/fixtures/real/cmu_short.bvh")).unwrap();
    let keys = |text: &str| scene(text).animations[0].channels[0].position_keys.values.clone();
    assert_eq!(count(&whole), 75);
    assert_eq!(keys(&frames(&whole, 10..14)), keys(&whole)[10..14]);
    assert_eq!(keys(&first_frames("real/cmu_short.bvh", 3)), keys(&whole)[..3]);
    assert!(scene(&frames(&whole, 10..14)).warnings.is_empty());
}
