//! Steady tracks of markers, by parabolas through neighbouring frames. A marker that leaves its parabola in one frame
//! is a reflection. The other markers move onto the parabola, with less noise.
//!
//! Noise rotates segments in each frame, and these rotations bias the centres of joints that hardly move.

use glam::{DMat3, DVec3};
use mocap_scene::math::spread::spread;

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

/// Steady tracks. `noise` is the standard deviation of a coordinate, in metres. Without noise, nothing changes.
pub(super) fn steady(tracks: &[Track], noise: f64) -> Vec<Track> {
    match noise == 0.0 {
        true => tracks.to_vec(),
        false => spread(tracks, |track| steady_track(track.clone(), noise)),
    }
}

fn steady_track(mut track: Track, noise: f64) -> Track {
    let mut widest: Vec<Option<Sums>> = (0..track.len())
        .map(|frame| Sums::of(&track, frame, SIDES[0]))
        .collect();
    let is_reflection = |frame: &usize| {
        let off = to_parabola(&track, *frame, widest[*frame].as_ref(), (noise, false));
        off.is_some_and(|off| off.length() > f64::max(REFLECTION, TIMES * noise))
    };
    let reflections: Vec<usize> = (0..track.len()).filter(is_reflection).collect();
    reflections.iter().for_each(|frame| track[*frame] = None);
    for frame in reflections {
        let near = widest.iter_mut().enumerate().take(frame + SIDES[0] + 1);
        for (near, sums) in near.skip(frame.saturating_sub(SIDES[0])) {
            *sums = Sums::of(&track, near, SIDES[0]);
        }
    }
    let steady = |(frame, at): (usize, &Option<DVec3>)| {
        let off = to_parabola(&track, frame, widest[frame].as_ref(), (noise, true));
        at.map(|at| at + off.unwrap_or_default())
    };
    track.iter().enumerate().map(steady).collect()
}

/// The vector from a position to its parabola. `widest` has the sums over the most frames. `counts` is whether the
/// position itself counts.
fn to_parabola(track: &Track, frame: usize, widest: Option<&Sums>, (noise, counts): (f64, bool)) -> Option<DVec3> {
    let narrower = || {
        let mut sides = SIDES[1..].iter();
        sides.find_map(|side| Sums::of(track, frame, *side)?.to_parabola(noise, counts))
    };
    widest?.to_parabola(noise, counts).or_else(narrower)
}

/// Sums over the neighbours of a position.
struct Sums {
    /// The sums of the powers of time.
    powers: [f64; 5],
    /// The sums of the products of positions and powers of time. Positions are relative to the position itself.
    products: [DVec3; 3],
    squares: f64,
}

impl Sums {
    /// The sums over `side` frames before and after a frame, without the frame itself. `None` if it has no position.
    fn of(track: &Track, frame: usize, side: usize) -> Option<Self> {
        let own = track[frame]?;
        let (mut powers, mut products, mut squares) = ([0.0; 5], [DVec3::ZERO; 3], 0.0);
        let first = frame.saturating_sub(side);
        let last = (frame + side).min(track.len() - 1);
        for (index, at) in (first..).zip(&track[first..=last]) {
            let Some(at) = at.filter(|_| index != frame) else {
                continue;
            };
            let time = (index as f64 - frame as f64) / side as f64;
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
        Some(Self {
            powers,
            products,
            squares,
        })
    }

    /// The vector from the position to the parabola. `None` if no parabola fits.
    fn to_parabola(&self, noise: f64, counts: bool) -> Option<DVec3> {
        let [others, a, b, c, d] = self.powers;
        // At the time of the position, only the power of degree 0 is not 0.
        let count = others + f64::from(u8::from(counts));
        if count < LEAST {
            return None;
        }
        let normal = DMat3::from_cols(DVec3::new(count, a, b), DVec3::new(a, b, c), DVec3::new(b, c, d));
        let [x, y, z] = self.products;
        let found = DMat3::from_cols(x, y, z) * normal.inverse();
        let explained = found.x_axis.dot(x) + found.y_axis.dot(y) + found.z_axis.dot(z);
        let most = FITS * noise * noise * 3.0 * (count - 3.0);
        (self.squares - explained <= most).then_some(found.x_axis)
    }
}
