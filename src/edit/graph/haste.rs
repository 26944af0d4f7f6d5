//! Compares the speed of joints during transitions with their speed in the clips.
//!
//! During a blend, the speed of a point has two parts. One part is the mix of its speeds in both clips. The other part
//! is the speed from its position in one clip to its position in the other clip. If a leg swings during the blend, the
//! sum can be faster than 99.9 percent of the speeds in the clips. Another transition with the same distance may be as
//! slow as the clips.

use glam::DVec3;
use mocap_scene::math::median::ranked;

use super::GraphTransition;
use super::clouds::Clouds;
use super::network::Network;
use super::walk::smooth;

/// The fraction of the speeds in the clips that count as fast. Fast speeds are above the 99.9th percentile.
const FAST: f64 = 0.001;

/// The largest number of speeds from which the percentile is computed.
const MOST_SPEEDS: usize = 1_000_000;

impl Network<'_> {
    /// The cost of a transition, as a sum of two terms. The first term is the distance of the transition divided by the
    /// threshold. The second term is the fraction of fast speeds divided by [`FAST`].
    pub(super) fn cost(&self, exit: &GraphTransition) -> f64 {
        let haste = match self.index_of(exit) {
            Some(index) => *self.hastes.of_exits[index].get_or_init(|| self.haste(exit)),
            None => self.haste(exit),
        };
        f64::from(exit.distance) / self.threshold + haste
    }

    fn haste(&self, exit: &GraphTransition) -> f64 {
        let fast = *self.hastes.fast.get_or_init(|| self.fast());
        let alignment = self.alignment(exit);
        let blend = self.window.frames() - 1;
        let points = self.space.weights.len();
        let at = |[clip, frame]: [usize; 2], point: usize| place(&self.clouds[clip], point, frame);
        let blended = |step: usize, point: usize| {
            let from = at([exit.from[0], exit.from[1] + step], point);
            let to = at([exit.to[0], exit.to[1] + step - blend], point);
            let over_ground = alignment.apply(to.truncate());
            from.lerp(over_ground.extend(to.z), smooth(step as f64 / blend as f64))
        };
        let beyond = |point: usize| {
            let places: Vec<DVec3> = (0..=blend).map(|step| blended(step, point)).collect();
            let is_fast = |pair: &&[DVec3]| pair[0].distance(pair[1]) > fast;
            places.windows(2).filter(is_fast).count()
        };
        let beyond: usize = (0..points).map(beyond).sum();
        beyond as f64 / (points * blend) as f64 / FAST
    }

    /// The speed above which a speed counts as fast: a thousandth of the speeds in the clips are higher.
    fn fast(&self) -> f64 {
        let points = self.space.weights.len();
        let parts = || {
            let clips = self.clips.iter().zip(self.clouds);
            clips.filter_map(|(clip, clouds)| Some((clouds, clip.part?)))
        };
        let all: usize = parts().map(|(_, [first, last])| last - first).sum();
        let step = (all * points).div_ceil(MOST_SPEEDS).max(1);
        let mut speeds = Vec::new();
        for (clouds, [first, last]) in parts() {
            for frame in (first..last).step_by(step) {
                let speed = |point| place(clouds, point, frame).distance(place(clouds, point, frame + 1));
                speeds.extend((0..points).map(speed));
            }
        }
        let place = (speeds.len() as f64 * (1.0 - FAST)) as usize;
        ranked(&mut speeds, place).unwrap_or(f64::INFINITY)
    }
}

/// The position of a point in a frame: along the two axes of the ground, and up.
fn place(clouds: &Clouds, point: usize, frame: usize) -> DVec3 {
    let [u, v, h] = [0, 1, 2].map(|axis: usize| f64::from(clouds.values[axis][point * clouds.frames + frame]));
    DVec3::new(u, v, h)
}
