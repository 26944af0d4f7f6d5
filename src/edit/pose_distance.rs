//! Computes the distances between many poses.

use glam::Vec3;
use mocap_scene::math::quaternion::{log, squared_angle};
use mocap_scene::math::wide;

use super::carrier::Carrier;
use super::frames::Frames;

/// The poses of chosen frames, stored as lists of values.
///
/// The distance of two poses is the sum over all joints of the squared angle between the two rotations of a joint. Of
/// the node that carries the figure, only the tilt counts, because position and heading do not belong to a pose.
pub(super) struct Poses {
    count: usize,
    /// For each joint, four lists: the components x, y, z and w of its rotations in all frames.
    rotations: Vec<[Vec<f32>; 4]>,
    /// Further values whose squared differences are added to the distance. Each value has a list over all frames.
    values: Vec<Vec<f32>>,
}

impl Poses {
    /// The poses of the frames `chosen`. With `speed_weight`, the rotation of each joint to the next frame also counts,
    /// with this weight.
    pub(super) fn new(frames: &Frames, chosen: &[usize], carrier: &Carrier, speed_weight: Option<f32>) -> Self {
        let rotation = |frame: usize, column: usize| frames.at(frame, column).rotation;
        let mut poses = Self {
            count: chosen.len(),
            rotations: Vec::new(),
            values: Vec::new(),
        };
        let mut add = |values: Vec<Vec3>| {
            let axis = |axis: usize| values.iter().map(|value| value[axis]).collect();
            poses.values.extend([0, 1, 2].map(axis));
        };
        let last = frames.len() - 1;
        for column in 0..frames.nodes().len() {
            let of_chosen = |value: &dyn Fn(usize) -> Vec3| chosen.iter().map(|frame| value(*frame)).collect();
            if column == carrier.column {
                add(of_chosen(&|frame| rotation(frame, column).inverse() * carrier.up));
                continue;
            }
            if let Some(weight) = speed_weight.filter(|_| last > 0) {
                // The last frame has no next frame, so it gets the speed of the frame before.
                add(of_chosen(&|frame| {
                    let from = frame.min(last - 1);
                    log(rotation(from, column).inverse() * rotation(from + 1, column)) * weight.sqrt()
                }));
            }
            let component = |component: usize| {
                chosen
                    .iter()
                    .map(|frame| rotation(*frame, column).to_array()[component])
                    .collect()
            };
            poses.rotations.push([0, 1, 2, 3].map(component));
        }
        poses
    }

    /// The distances from one pose of `from` to all poses of `self`. `index` is the index of this pose among the chosen
    /// frames of `from`. `from` and `self` have the same joints.
    pub(super) fn distances(&self, from: &Self, index: usize) -> Vec<f32> {
        let mut sums = vec![0.0; self.count];
        for (track, from) in self.rotations.iter().zip(&from.rotations) {
            add_angles(
                &mut sums,
                track,
                [&from[0], &from[1], &from[2], &from[3]].map(|list| list[index]),
            );
        }
        for (track, from) in self.values.iter().zip(&from.values) {
            add_squares(&mut sums, track, from[index]);
        }
        sums
    }
}

wide::dispatch! {
    fn add_angles(sums: &mut [f32], track: &[Vec<f32>; 4], from: [f32; 4]) {
        let [x, y, z, w] = track;
        for ((((sum, x), y), z), w) in sums.iter_mut().zip(x).zip(y).zip(z).zip(w) {
            *sum += squared_angle(from, [*x, *y, *z, *w]);
        }
    }
}

wide::dispatch! {
    fn add_squares(sums: &mut [f32], track: &[f32], from: f32) {
        for (sum, value) in sums.iter_mut().zip(track) {
            *sum += (value - from) * (value - from);
        }
    }
}
