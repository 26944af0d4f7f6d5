//! Steady tracks of markers, by parabolas through neighbouring frames. A marker that leaves its parabola in one frame
//! is a reflection. The other markers move onto the parabola, with less noise.
//!
//! Noise rotates segments in each frame, and these rotations bias the centres of joints that hardly move.

use glam::{DMat3, DVec3};

use super::take::Track;

/// The numbers of frames before and after a frame through which a parabola is fitted. The first that fits is used.
const SIDES: [usize; 3] = [8, 5, 3];

/// The largest variance about a parabola, as a factor of the variance of noise. Noise in 17 frames exceeds it once in
/// a hundred times.
const FITS: f64 = 1.5;

/// The least number of frames for a parabola: twice the number of its coefficients.
const LEAST: f64 = 6.0;

/// The least distance in metres of a reflection from the parabola of the other frames. A marker that is nearer shows
/// the segment better than no marker does.
const REFLECTION: f64 = 0.01;

/// The least distance of a reflection as a factor of the noise, which never reaches it.
const TIMES: f64 = 10.0;

/// Makes tracks steady. `noise` is the standard deviation of a coordinate, in metres. Without noise, nothing changes.
pub(super) fn steady(tracks: &mut [Track], noise: f64) {
    if noise == 0.0 {
        return;
    }
    for track in tracks {
        let is_reflection = |frame: &usize| {
            let off = to_parabola(track, *frame, noise, false);
            off.is_some_and(|off| off.length() > f64::max(REFLECTION, TIMES * noise))
        };
        let reflections: Vec<usize> = (0..track.len()).filter(is_reflection).collect();
        reflections.into_iter().for_each(|frame| track[frame] = None);
        let steady = |(frame, at): (usize, &Option<DVec3>)| {
            let off = to_parabola(track, frame, noise, true);
            at.map(|at| at + off.unwrap_or_default())
        };
        *track = track.iter().enumerate().map(steady).collect();
    }
}

/// The vector from a position to its parabola. `counts` is whether the position itself counts.
fn to_parabola(track: &Track, frame: usize, noise: f64, counts: bool) -> Option<DVec3> {
    let own = track[frame]?;
    let fit = |side: &usize| {
        let first = frame.saturating_sub(*side);
        let last = (frame + side).min(track.len() - 1);
        // The sums of the powers of time, and of their products with positions.
        let (mut powers, mut products, mut squares) = ([0.0; 5], [DVec3::ZERO; 3], 0.0);
        for (index, at) in (first..).zip(&track[first..=last]) {
            let Some(at) = at.filter(|_| counts || index != frame) else {
                continue;
            };
            let time = (index as f64 - frame as f64) / *side as f64;
            let off = at - own;
            let mut power = 1.0;
            for (degree, sum) in powers.iter_mut().enumerate() {
                *sum += power;
                if let Some(sum) = products.get_mut(degree) {
                    *sum += off * power;
                }
                power *= time;
            }
            squares += off.length_squared();
        }
        let [count, a, b, c, d] = powers;
        if count < LEAST {
            return None;
        }
        let normal = DMat3::from_cols(DVec3::new(count, a, b), DVec3::new(a, b, c), DVec3::new(b, c, d));
        let [x, y, z] = products;
        let found = DMat3::from_cols(x, y, z) * normal.inverse();
        let explained = found.x_axis.dot(x) + found.y_axis.dot(y) + found.z_axis.dot(z);
        let most = FITS * noise * noise * 3.0 * (count - 3.0);
        (squares - explained <= most).then_some(found.x_axis)
    };
    SIDES.iter().find_map(fit)
}
