//! Motion matching's search by itself: the frames of a database that are nearest to queries, and how long that takes.
//! `tools/matching/check` compares the answers with NumPy's.
//!
//!     cargo run --release --example nearest_frames -- moves.mdb FRAMES QUERIES FOLDER
//!
//! The frames are those of the database again and again, each time with other noise, until there are FRAMES; noise and
//! queries are the same in every run. FOLDER gets what is compared, as little-endian numbers: `frames.f32`, normalized;
//! `queries.f32`; `answers.f64`, of each query the frame and its squared distance.

use std::error::Error;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::time::Instant;

use mocap::matching::{Database, FeatureTree};

type Row = [f32; Database::FEATURES];

/// Numbers from -1 to 1, by the generator SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn number(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [database, frames, queries, folder] = arguments.as_slice() else {
        return Err("nearest_frames DATABASE FRAMES QUERIES FOLDER".into());
    };
    let (frames, queries, folder): (usize, usize, &Path) = (frames.parse()?, queries.parse()?, folder.as_ref());
    let database = Database::read(BufReader::new(File::open(database)?))?;
    let own: Vec<Row> = database.features().copied().collect();
    let mut random = Random(7);
    let mut rows: Vec<Row> = Vec::with_capacity(frames);
    while rows.len() < frames {
        // A copy is another take of the motion: every feature a little larger or smaller, and moved.
        let copy: [(f32, f32); Database::FEATURES] =
            std::array::from_fn(|_| (1.0 + 0.2 * random.number(), 0.1 * random.number()));
        rows.extend(own.iter().take(frames - rows.len()).map(|row| {
            std::array::from_fn(|place| copy[place].0 * row[place] + copy[place].1 + 0.005 * random.number())
        }));
    }
    let start = Instant::now();
    let tree = FeatureTree::of_frames(&rows);
    println!("{} frames: built in {:.2} s", rows.len(), start.elapsed().as_secs_f64());

    let cold: Vec<Row> = (0..queries)
        .map(|_| {
            let row = tree.normalized(&rows[random.below(rows.len())]);
            row.map(|value| value + 0.5 * random.number())
        })
        .collect();
    let start = Instant::now();
    let answers: Vec<(usize, f32)> = cold
        .iter()
        .filter_map(|query| tree.nearest(query, f32::INFINITY, 0..0))
        .collect();
    println!("cold: {:.1} us a query", micros(start, queries));
    play(&tree, &rows, queries, &mut random);

    let bytes = |rows: &mut dyn Iterator<Item = Row>| rows.flatten().flat_map(f32::to_le_bytes).collect::<Vec<u8>>();
    fs::create_dir_all(folder)?;
    fs::write(
        folder.join("frames.f32"),
        bytes(&mut rows.iter().map(|row| tree.normalized(row))),
    )?;
    fs::write(folder.join("queries.f32"), bytes(&mut cold.iter().copied()))?;
    let answers = answers
        .iter()
        .flat_map(|(frame, distance)| [*frame as f64, f64::from(*distance)]);
    fs::write(
        folder.join("answers.f64"),
        answers.flat_map(f64::to_le_bytes).collect::<Vec<u8>>(),
    )?;
    Ok(())
}

/// As in play: every tenth frame a search from the current frame for a nearer one. A stick that moves a little every
/// sixth of a second turns and lengthens the trajectory of the current frame.
fn play(tree: &FeatureTree, rows: &[Row], queries: usize, random: &mut Random) {
    let (mut at, mut angle, mut pace, mut turning) = (0, 0.0_f32, 1.0_f32, 0.0);
    let (mut jumps, mut seconds) = (0, 0.0);
    for _ in 0..queries {
        turning = 0.8 * turning + 0.1 * random.number();
        angle = (angle + turning).clamp(-0.8, 0.8);
        pace = (pace + 0.05 * random.number()).clamp(0.8, 1.2);
        at = (at + 10).min(rows.len() - 1);
        let mut features = rows[at];
        for (place, ahead) in [(15, 1.0), (17, 2.0), (19, 3.0), (21, 1.0), (23, 2.0), (25, 3.0)] {
            let (sin, cos) = (angle * ahead / 3.0).sin_cos();
            let length = if place < 21 { pace } else { 1.0 };
            let (x, z) = (features[place], features[place + 1]);
            features[place] = length * (cos * x + sin * z);
            features[place + 1] = length * (cos * z - sin * x);
        }
        let normalized = tree.normalized(&features);
        let playing = tree.normalized(&rows[at]);
        let limit = playing.iter().zip(&normalized).map(|(a, b)| (a - b) * (a - b)).sum();
        let start = Instant::now();
        let found = tree.nearest(&normalized, limit, at.saturating_sub(20)..at + 20);
        seconds += start.elapsed().as_secs_f64();
        if let Some((frame, _)) = found {
            (at, jumps) = (frame, jumps + 1);
        }
    }
    println!(
        "in play: {:.1} us a query, {jumps} jumps in {queries}",
        1e6 * seconds / queries as f64
    );
}

fn micros(start: Instant, queries: usize) -> f64 {
    1e6 * start.elapsed().as_secs_f64() / queries as f64
}
