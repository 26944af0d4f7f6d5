//! Finds the resting levels of the feet. A resting level is a percentile of the height of the lowest foot, over the
//! frames of a motion. A frame's weight is the distance that the feet move around it.

use glam::Vec3;

/// The largest number of examined frames of an animation. They are evenly spaced.
const FRAMES: usize = 2000;

/// The weighted fraction of frames in which the lowest foot is below its resting level: a rolling foot is lower than a
/// flat foot.
const BELOW: f64 = 0.05;

/// The range of the heights of feet that rest on one level, in metres.
const NEAR_LEVEL: f32 = 0.05;

/// The frequency of a level, as a fraction of the frequency of the most frequent level. A less frequent level below the
/// ground comes from feet that have sunk into the ground.
const OFTEN: f64 = 0.8;

/// The largest weighted fraction of frames in which feet sink into the ground.
const RARELY: f64 = 0.35;

/// The base weight of a frame in addition to the movement of the feet, as a speed in m/s. Standing for a second counts
/// as a short step.
const STANDING: f32 = 0.3;

/// The largest speed in m/s that counts: running counts no more than fast walking.
const FAST: f32 = 1.5;

/// If the points of the feet move at most this distance from one frame to the next, on average, in metres, the next
/// frame is a held frame.
const HELD: f32 = 1e-5;

/// A movement is a jump if it exceeds the second longest movement near it by this factor, plus this number of metres.
const JUMP: (f32, f32) = (3.0, 0.01);

/// The number of neighbouring movements before and after, without held frames.
const NEAR: usize = 3;

/// The resting level of each kind of points. `kinds` has the positions of the points of each kind, frame by frame.
/// `metres` is the length of one unit of these positions, in metres. The lowest point of a kind counts.
pub fn levels<T: AsRef<[Vec3]>>(kinds: &[Vec<T>], up: Vec3, metres: f32, rate: f64) -> Vec<Option<f32>> {
    let mut rests = Rests::default();
    rests.add(kinds, up, metres, rate);
    rests.levels(metres)
}

/// For each kind of point, the height of the lowest point in each examined frame, and the weight of the frame.
#[derive(Default)]
pub(super) struct Rests(Vec<Vec<(f32, f32)>>);

impl Rests {
    pub(super) fn add<T: AsRef<[Vec3]>>(&mut self, kinds: &[Vec<T>], up: Vec3, metres: f32, rate: f64) {
        let tracks: Vec<&[Vec3]> = kinds.iter().flatten().map(AsRef::as_ref).collect();
        let frames = tracks.iter().map(|track| track.len()).min().unwrap_or(0);
        let stride = stride(frames);
        // The tips of the feet do not affect the weights, because files of other formats lack them.
        let of_joints: Vec<&[Vec3]> = kinds.iter().take(2).flatten().map(AsRef::as_ref).collect();
        let weights = weights(&of_joints, (frames, stride), metres, rate);
        self.0.resize(self.0.len().max(kinds.len()), Vec::new());
        for (kind, rests) in kinds.iter().zip(&mut self.0) {
            for (frame, weight) in (0..frames).step_by(stride).zip(&weights) {
                let heights = kind.iter().map(|track| track.as_ref()[frame].dot(up));
                let lowest = heights.reduce(f32::min).filter(|height| height.is_finite());
                rests.extend(lowest.map(|lowest| (lowest, *weight)));
            }
        }
    }

    pub(super) fn levels(self, metres: f32) -> Vec<Option<f32>> {
        self.0.into_iter().map(|rests| level(rests, metres)).collect()
    }
}

/// The weighted percentile of heights, interpolated, above the lowest level at which the feet often are.
fn level(mut rests: Vec<(f32, f32)>, metres: f32) -> Option<f32> {
    rests.retain(|(_, weight)| *weight > 0.0);
    rests.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut sums = vec![0.0];
    sums.extend(rests.iter().scan(0.0, |sum, (_, weight)| {
        *sum += f64::from(*weight);
        Some(*sum)
    }));
    let near = |at: usize| {
        let end = rests.partition_point(|(height, _)| *height < rests[at].0 + NEAR_LEVEL / metres);
        sums[end] - sums[at]
    };
    let most = (0..rests.len()).map(near).fold(0.0, f64::max);
    let sunk = (0..rests.len()).find(|at| near(*at) >= OFTEN * most)?;
    // A level with a smaller weight than `least` is below the percentile anyway.
    let [least, most] = [BELOW, RARELY].map(|fraction| fraction * sums[rests.len()]);
    if (least..=most).contains(&sums[sunk]) {
        rests.drain(..sunk);
    }
    let wanted = BELOW * rests.iter().map(|(_, weight)| f64::from(*weight)).sum::<f64>();
    let mut before: Option<(f32, f64)> = None;
    let mut sum = 0.0;
    for (height, weight) in rests {
        let at = sum + 0.5 * f64::from(weight);
        sum += f64::from(weight);
        if at >= wanted {
            let Some((lower, below)) = before else {
                return Some(height);
            };
            let part = (wanted - below) / (at - below);
            return Some(lower + (height - lower) * part as f32);
        }
        before = Some((height, at));
    }
    before.map(|(height, _)| height)
}

/// The weight of each examined frame in metres: half of the distance that the points move, on average, from the
/// previous examined frame to the next.
fn weights(tracks: &[&[Vec3]], (frames, stride): (usize, usize), metres: f32, rate: f64) -> Vec<f32> {
    let examined: Vec<usize> = (0..frames).step_by(stride).collect();
    let standing = STANDING * (stride as f64 / rate.max(f64::MIN_POSITIVE)) as f32;
    let fast = standing * FAST / STANDING;
    let way = |pair: &[usize]| {
        let ways = tracks.iter().map(|track| track[pair[1]].distance(track[pair[0]]));
        ways.sum::<f32>() * metres / tracks.len().max(1) as f32
    };
    let ways: Vec<f32> = examined.windows(2).map(way).collect();
    let moving: Vec<usize> = (0..ways.len()).filter(|step| ways[*step] > HELD).collect();
    let mut counts = vec![0.0; ways.len()];
    for (at, step) in moving.iter().enumerate() {
        let near = at.saturating_sub(NEAR)..(at + NEAR + 1).min(moving.len());
        let others = near.filter(|other| *other != at).map(|other| ways[moving[other]]);
        // An isolated frame has a jump before and after it.
        let [_, second] = others.fold([0.0f32; 2], |[a, b], way| [a.max(way), b.max(way.min(a))]);
        if ways[*step] <= JUMP.0 * second + JUMP.1 {
            counts[*step] = ways[*step].min(fast) + standing;
        }
    }
    if counts.iter().all(|count| *count == 0.0) {
        // Nothing moves: use the longest of the stances between jumps of the feet.
        let jumps: Vec<usize> = (0..ways.len()).filter(|step| ways[*step] > JUMP.1).collect();
        let starts = std::iter::once(0).chain(jumps.iter().map(|step| step + 1));
        let ends = jumps.iter().map(|step| step + 1).chain([examined.len()]);
        let longest = starts
            .zip(ends)
            .max_by_key(|(start, end)| end - start)
            .unwrap_or_default();
        let weight = |frame| {
            if (longest.0..longest.1).contains(&frame) {
                1.0
            } else {
                0.0
            }
        };
        return (0..examined.len()).map(weight).collect();
    }
    let half = |step: Option<usize>| step.and_then(|step| counts.get(step)).map_or(0.0, |count| 0.5 * count);
    (0..examined.len())
        .map(|frame| half(frame.checked_sub(1)) + half(Some(frame)))
        .collect()
}

/// The number of frames from one examined frame to the next.
pub(super) fn stride(frames: usize) -> usize {
    frames.div_ceil(FRAMES).max(1)
}
