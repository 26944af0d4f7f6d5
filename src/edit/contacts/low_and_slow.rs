//! Which points are at rest on the ground, from their heights and speeds.

/// Thresholds of height above the level of rest and of speed, in metres and seconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Thresholds {
    /// The largest height in contact.
    pub(crate) height: f64,
    /// The largest speed in contact.
    pub(crate) speed: f64,
    /// How many times as high or fast a point in contact must be to leave it.
    pub(crate) release: f64,
}

/// The contacts of one point: whether it is at rest in each frame. It comes to rest when it is low and slow, and leaves
/// when it is `release` times too high or too fast. Heights are in metres above the level of rest.
pub(crate) fn low_and_slow(samples: impl Iterator<Item = (f64, f64)>, thresholds: Thresholds) -> Vec<bool> {
    let mut rests = false;
    let state = |(height, speed): (f64, f64)| {
        let factor = if rests { thresholds.release } else { 1.0 };
        rests = height <= factor * thresholds.height && speed <= factor * thresholds.speed;
        rests
    };
    samples.map(state).collect()
}

/// The height on which the lowest of several points rests: the fifth percentile over all frames. The minimum would be
/// that of a rest pose in the first frame, in which CMU's files have the hips at the origin and the feet far below.
/// `heights` has those of all points, frame by frame.
pub(crate) fn level(heights: &[f32], points: usize) -> f32 {
    let lowest = |frame: &[f32]| frame.iter().copied().fold(f32::INFINITY, f32::min);
    let mut lowest: Vec<f32> = heights.chunks(points.max(1)).map(lowest).collect();
    lowest.sort_by(f32::total_cmp);
    lowest.get(lowest.len().saturating_sub(1) / 20).copied().unwrap_or(0.0)
}

/// Ends every gap in `contacts` that is shorter than `gap` frames, and then drops every contact shorter than `contact`.
pub(super) fn without_short_ones(contacts: &mut [bool], gap: usize, contact: usize) {
    for (value, shortest) in [(false, gap), (true, contact)] {
        let mut start = 0;
        for end in 1..=contacts.len() {
            if end < contacts.len() && contacts[end] == contacts[start] {
                continue;
            }
            // A contact that is cut off by the end of the motion may be longer; a gap must have contacts on both sides.
            let is_inside = start > 0 && end < contacts.len();
            if contacts[start] == value && end - start < shortest && is_inside {
                contacts[start..end].fill(!value);
            }
            start = end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_takes_more_to_leave_than_to_stay_away() {
        let thresholds = Thresholds {
            height: 1.0,
            speed: 10.0,
            release: 2.0,
        };
        let heights = [1.5, 0.9, 1.5, 2.1, 1.5, 1.0];
        let found = low_and_slow(heights.into_iter().map(|height| (height, 0.0)), thresholds);
        assert_eq!(found, [false, true, true, false, false, true]);
        let speeds = [15.0, 9.0, 19.0, 21.0];
        let found = low_and_slow(speeds.into_iter().map(|speed| (0.0, speed)), thresholds);
        assert_eq!(found, [false, true, true, false]);
    }

    #[test]
    fn short_gaps_close_and_short_contacts_go() {
        let parse = |text: &str| text.chars().map(|c| c == '#').collect::<Vec<_>>();
        for (before, after) in [
            ("..###.###..", "..#######.."),
            ("..##....##..", "............"),
            (".#.#.#......", ".#####......"),
            ("##......####", "##......####"),
            ("####......#.", "####........"),
        ] {
            let mut contacts = parse(before);
            without_short_ones(&mut contacts, 3, 4);
            assert_eq!(contacts, parse(after), "{before}");
        }
    }
}
