//! Tests of the search for near windows.

use mocap_edit::internals::{LANES, NUMBERS, NeighbourIndex, Numbers};

/// No pair is missing, and each is found once.
#[test]
fn all_pairs_are_found_once() {
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let side = (5.0 / NUMBERS as f32).sqrt();
    let clips: Vec<Vec<Numbers>> = [3, 700, 41, 0, 8, 160]
        .map(|count| (0..count).map(|_| std::array::from_fn(|_| side * random())).collect())
        .to_vec();
    let limit = 0.8_f32.powi(2);
    let near = NeighbourIndex::new(&clips);
    let (mut own, mut found) = (Vec::new(), Vec::new());
    for (place, block) in near.blocks().iter().enumerate() {
        near.of(place, limit, &mut found);
        for (other, bits) in &found {
            let other = near.blocks()[*other];
            for (row, column) in (0..LANES).flat_map(|row| (0..LANES).map(move |column| (row, column))) {
                if bits[row] >> column & 1 == 1 {
                    let mut pair = [(block.clip, block.start + row), (other.clip, other.start + column)];
                    pair.sort_unstable();
                    own.push(pair);
                }
            }
        }
    }
    own.sort_unstable();
    // Two windows of the same block are found in both orders.
    own.dedup();
    let all = || (0..clips.len()).flat_map(|clip| (0..clips[clip].len()).map(move |window| (clip, window)));
    let mut truth = Vec::new();
    for first in all() {
        for second in all().filter(|second| *second >= first) {
            let pairs = clips[first.0][first.1].iter().zip(&clips[second.0][second.1]);
            if pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f32>() <= limit {
                truth.push([first, second]);
            }
        }
    }
    assert!(truth.len() > 2000 && truth.len() < 300_000, "{}", truth.len());
    assert!(own == truth, "{} of {}", own.len(), truth.len());
}
