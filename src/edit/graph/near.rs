//! All pairs of windows whose numbers are near each other. The search uses boxes around eight successive windows, boxes
//! around eight such boxes that are near each other, and so on, as in an R-tree (Guttman, 1984). Eight are compared at
//! once.

use mocap_scene::math::wide;

use super::bound::{NUMBERS, Numbers};

/// Windows, or boxes, that are compared at once; of numbers so many before it is looked whether they are near still.
pub const LANES: usize = 8;

/// A number of eight windows.
type Lanes = [f32; LANES];
/// Eight windows: their first numbers, their second ones, and so on. Where one is missing, its numbers are infinite.
type Windows = [Lanes; NUMBERS];
/// Eight boxes: the least and the largest of each number. A missing box is infinitely far away.
type Boxes = [[Lanes; 2]; NUMBERS];
/// The least and the largest of each number of a box.
type BoundingBox = [[f32; 2]; NUMBERS];

/// Windows that follow each other in a clip: eight, or those that are left.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// The place of the clip.
    pub clip: usize,
    /// The first window.
    pub start: usize,
    /// How many windows.
    pub count: usize,
}

/// The windows of all clips. Blocks stand in an order in which those are together that are near each other.
pub struct NeighbourIndex {
    blocks: Vec<Block>,
    windows: Vec<Windows>,
    /// The boxes of the blocks, those around eight of these, and so on, until eight are left.
    levels: Vec<Vec<Boxes>>,
}

impl NeighbourIndex {
    /// Those of clips.
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

    /// The blocks, in the order in which they stand.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// The blocks, from this one on, that may have windows within the root of `limit` of windows of this one. Each has
    /// its place, and bits: for each window of this block, the windows of the other.
    pub fn of(&self, place: usize, limit: f32, found: &mut Vec<(usize, [u8; LANES])>) {
        found.clear();
        let own = self.own_box(place);
        let top = self.levels.len() - 1;
        let mut open: Vec<(usize, usize)> = (0..self.levels[top].len()).map(|group| (top, group)).collect();
        while let Some((level, group)) = open.pop() {
            // Blocks of a box on this level.
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

/// The box around boxes.
fn around(boxes: impl Iterator<Item = BoundingBox>) -> BoundingBox {
    let none = [[f32::INFINITY, f32::NEG_INFINITY]; NUMBERS];
    boxes.fold(none, |mut sum, next| {
        for ([least, most], [other_least, other_most]) in sum.iter_mut().zip(next) {
            (*least, *most) = (least.min(other_least), most.max(other_most));
        }
        sum
    })
}

/// Up to eight boxes side by side.
fn beside(boxes: &[BoundingBox]) -> Boxes {
    let mut all = [[[f32::INFINITY; LANES]; 2]; NUMBERS];
    for (lane, around) in boxes.iter().enumerate() {
        for (lanes, sides) in all.iter_mut().zip(around) {
            (lanes[0][lane], lanes[1][lane]) = (sides[0], sides[1]);
        }
    }
    all
}

/// Brings boxes that are near each other together: halves them along the number in which they differ most, and so on.
/// A half has as many as whole boxes of boxes have.
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
    /// How far a box is from eight others, squared, or a part of that where it is more than `limit` for all.
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
    /// Of each of eight windows, which of eight others are within the root of `limit`, as bits.
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
                // Of two missing ones the difference is no number, which is not near.
                *near |= u8::from(sum <= limit) << place;
            }
        }
        near
    }
}

/// Whether eight numbers are above a limit.
#[inline(always)]
fn are_all_above(numbers: &Lanes, limit: f32) -> bool {
    let mut are = true;
    for number in numbers {
        are &= *number > limit;
    }
    are
}
