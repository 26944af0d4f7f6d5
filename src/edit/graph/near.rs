//! Finds all pairs of windows whose values are near each other. The values come from [`Bound`](super::bound::Bound).
//! The search uses boxes around eight successive windows, then boxes around eight nearby boxes, and so on, as in an
//! R-tree (Guttman, 1984). Eight boxes are compared at once.

use mocap_scene::math::wide;

use super::bound::{NUMBERS, Numbers};

/// The number of windows or boxes that are compared at once. A comparison may stop early after this number of values.
pub const LANES: usize = 8;

/// One value of each of eight windows.
type Lanes = [f32; LANES];
/// The values of eight windows: the first value of all windows, then the second value of all windows, and so on. A
/// missing window has infinite values.
type Windows = [Lanes; NUMBERS];
/// For eight boxes, the smallest and the largest of each value. A missing box is infinitely far away.
type Boxes = [[Lanes; 2]; NUMBERS];
/// The smallest and the largest of each value in a box.
type BoundingBox = [[f32; 2]; NUMBERS];

/// Successive windows of a clip: eight, or fewer at the end of the clip.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// The index of the clip.
    pub clip: usize,
    /// The first window.
    pub start: usize,
    /// The number of windows.
    pub count: usize,
}

/// The windows of all clips, in blocks. Blocks that are near each other are next to each other in this order.
pub struct NeighbourIndex {
    blocks: Vec<Block>,
    windows: Vec<Windows>,
    /// The boxes of the blocks, then the boxes around eight of these, and so on, until at most eight boxes remain.
    levels: Vec<Vec<Boxes>>,
}

impl NeighbourIndex {
    /// Builds the index of the windows of all clips.
    pub fn new(clips: &[Vec<Numbers>]) -> Self {
        let blocks = clips.iter().enumerate().flat_map(|(clip, numbers)| {
            let starts = (0..numbers.len()).step_by(LANES);
            starts.map(move |start| Block {
                clip,
                start,
                count: (numbers.len() - start).min(LANES),
            })
        });
        let mut blocks: Vec<(Block, BoundingBox)> = blocks
            .map(|block| {
                let windows = &clips[block.clip][block.start..block.start + block.count];
                (
                    block,
                    around(windows.iter().map(|numbers| numbers.map(|number| [number; 2]))),
                )
            })
            .collect();
        arrange(&mut blocks);
        let (blocks, mut boxes): (Vec<Block>, Vec<BoundingBox>) = blocks.into_iter().unzip();
        let side_by_side = |block: &Block| {
            let mut lanes = [[f32::INFINITY; LANES]; NUMBERS];
            for (lane, numbers) in clips[block.clip][block.start..][..block.count].iter().enumerate() {
                lanes
                    .iter_mut()
                    .zip(numbers)
                    .for_each(|(lanes, number)| lanes[lane] = *number);
            }
            lanes
        };
        let windows = blocks.iter().map(side_by_side).collect();
        let mut levels = Vec::new();
        while !boxes.is_empty() {
            levels.push(boxes.chunks(LANES).map(beside).collect());
            if boxes.len() <= LANES {
                break;
            }
            boxes = boxes.chunks(LANES).map(|boxes| around(boxes.iter().copied())).collect();
        }
        Self {
            blocks,
            windows,
            levels,
        }
    }

    /// The blocks, in the order of the index.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Finds the blocks with a window near a window of the block at `place`: the distance is at most the square root of
    /// `limit`. Blocks before `place` are skipped. A result has the place of the found block and a byte for each window
    /// of the block at `place`. The bits of this byte mark the near windows of the found block.
    pub fn of(&self, place: usize, limit: f32, found: &mut Vec<(usize, [u8; LANES])>) {
        found.clear();
        let own = self.own_box(place);
        let top = self.levels.len() - 1;
        let mut open: Vec<(usize, usize)> = (0..self.levels[top].len()).map(|group| (top, group)).collect();
        while let Some((level, group)) = open.pop() {
            // The number of blocks in a box of this level.
            let blocks = LANES.pow(level as u32);
            let distances = box_distances(&own, &self.levels[level][group], limit);
            for (lane, distance) in distances.into_iter().enumerate() {
                let child = group * LANES + lane;
                if distance > limit || (child + 1) * blocks <= place {
                    continue;
                }
                if level > 0 {
                    open.push((level - 1, child));
                    continue;
                }
                let near = near_windows(&self.windows[place], &self.windows[child], limit);
                if near.iter().any(|bits| *bits > 0) {
                    found.push((child, near));
                }
            }
        }
    }

    fn own_box(&self, place: usize) -> BoundingBox {
        let boxes = &self.levels[0][place / LANES];
        std::array::from_fn(|column| boxes[column].map(|lanes| lanes[place % LANES]))
    }
}

/// The box around several boxes.
fn around(boxes: impl Iterator<Item = BoundingBox>) -> BoundingBox {
    let none = [[f32::INFINITY, f32::NEG_INFINITY]; NUMBERS];
    boxes.fold(none, |mut sum, next| {
        for ([least, most], [other_least, other_most]) in sum.iter_mut().zip(next) {
            (*least, *most) = (least.min(other_least), most.max(other_most));
        }
        sum
    })
}

/// Up to eight boxes, arranged for comparison at once.
fn beside(boxes: &[BoundingBox]) -> Boxes {
    let mut all = [[[f32::INFINITY; LANES]; 2]; NUMBERS];
    for (lane, around) in boxes.iter().enumerate() {
        for (lanes, sides) in all.iter_mut().zip(around) {
            (lanes[0][lane], lanes[1][lane]) = (sides[0], sides[1]);
        }
    }
    all
}

/// Sorts boxes so that near boxes are together. The function halves the list along the value in which the boxes differ
/// most, and repeats this with both halves. The first half fills whole boxes of the next level.
fn arrange(boxes: &mut [(Block, BoundingBox)]) {
    if boxes.len() <= LANES {
        return;
    }
    let middle = |around: &BoundingBox, column: usize| around[column][0] + around[column][1];
    let whole = around(
        boxes
            .iter()
            .map(|(_, around)| std::array::from_fn(|column| [middle(around, column); 2])),
    );
    let width = |column: &usize| whole[*column][1] - whole[*column][0];
    let widest = (0..NUMBERS).max_by(|a, b| width(a).total_cmp(&width(b))).unwrap_or(0);
    let mut full = LANES;
    while full * LANES < boxes.len() {
        full *= LANES;
    }
    let half = (boxes.len() / 2)
        .next_multiple_of(full)
        .min((boxes.len() - 1) / full * full);
    let by = |(block, around): &(Block, BoundingBox)| (middle(around, widest), block.clip, block.start);
    boxes.select_nth_unstable_by(half, |a, b| {
        let (a, b) = (by(a), by(b));
        a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2)))
    });
    let (first, second) = boxes.split_at_mut(half);
    arrange(first);
    arrange(second);
}

wide::dispatch! {
    /// The squared distances of a box from eight other boxes. If all are above `limit`, the function stops early, and
    /// the results are smaller than the distances.
    fn box_distances(own: &BoundingBox, others: &Boxes, limit: f32) -> Lanes {
        let mut sums = [0.0; LANES];
        for start in (0..NUMBERS).step_by(LANES) {
            for column in start..start + LANES {
                let [least, most] = own[column];
                let [other_least, other_most] = &others[column];
                for place in 0..LANES {
                    let (below, above) = (least - other_most[place], other_least[place] - most);
                    let apart = if below > above { below } else { above };
                    let apart = if apart > 0.0 { apart } else { 0.0 };
                    sums[place] += apart * apart;
                }
            }
            if are_all_above(&sums, limit) {
                break;
            }
        }
        sums
    }
}

wide::dispatch! {
    /// For each window of `own`, a byte whose bits mark the windows of `others` within the square root of `limit`.
    fn near_windows(own: &Windows, others: &Windows, limit: f32) -> [u8; LANES] {
        let mut near = [0; LANES];
        for (row, near) in near.iter_mut().enumerate() {
            let mut sums = [0.0; LANES];
            for start in (0..NUMBERS).step_by(LANES) {
                for column in start..start + LANES {
                    let number = own[column][row];
                    for place in 0..LANES {
                        let apart = number - others[column][place];
                        sums[place] += apart * apart;
                    }
                }
                if are_all_above(&sums, limit) {
                    break;
                }
            }
            for (place, sum) in sums.into_iter().enumerate() {
                // Two missing windows give NaN, which counts as not near.
                *near |= u8::from(sum <= limit) << place;
            }
        }
        near
    }
}

/// Whether all eight values are above a limit.
#[inline(always)]
fn are_all_above(numbers: &Lanes, limit: f32) -> bool {
    let mut are = true;
    for number in numbers {
        are &= *number > limit;
    }
    are
}
