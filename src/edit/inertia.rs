//! Removes the jump between two motions at their seam by inertialisation (Bollo, 2016): the difference between the
//! poses fades out after the seam.

use glam::Vec3;

pub(super) use mocap_scene::math::inertia::{ease, fade};
use mocap_scene::math::quaternion::{exp, log};
use mocap_scene::pose::Trs;

/// The differences between two poses at a seam, joint by joint, and the change of each difference per frame.
pub(super) struct Seam {
    rotations: Vec<(Vec3, Vec3)>,
    translations: Vec<(Vec3, Vec3)>,
}

impl Seam {
    /// The difference from `new` to `old`. `new` has the first two frames after the seam. `old` has the frame at the
    /// seam, and the frame that would follow it without the seam.
    pub(super) fn new(old: [&[Trs]; 2], new: [&[Trs]; 2]) -> Self {
        let mut seam = Self {
            rotations: Vec::new(),
            translations: Vec::new(),
        };
        for column in 0..old[0].len() {
            let [at, onward] = old.map(|row| row[column]);
            let [first, second] = new.map(|row| row[column]);
            let offset = log(first.rotation.inverse() * at.rotation);
            let speed = log(second.rotation.inverse() * onward.rotation) - offset;
            seam.rotations.push((offset, speed));
            let offset = at.translation - first.translation;
            seam.translations
                .push((offset, onward.translation - second.translation - offset));
        }
        seam
    }

    /// Whether both poses are equal, so that there is no jump.
    pub(super) fn is_closed(&self) -> bool {
        let all = self.rotations.iter().chain(&self.translations);
        all.into_iter().all(|(offset, _)| offset.length() < 1e-5)
    }

    /// The largest difference between the rotations of a joint, in degrees.
    pub(super) fn largest_rotation(&self) -> f32 {
        let angles = self.rotations.iter().map(|(offset, _)| offset.length().to_degrees());
        angles.fold(0.0, f32::max)
    }

    /// Adds the difference that remains `frame` frames after the seam to `row`, the transforms of this frame. After
    /// `steps` frames, no difference remains.
    pub(super) fn apply(&self, row: &mut [Trs], frame: usize, steps: usize) {
        for (column, trs) in row.iter_mut().enumerate() {
            let (offset, speed) = self.rotations[column];
            trs.rotation = (trs.rotation * exp(fade(offset, speed, frame, steps))).normalize();
            let (offset, speed) = self.translations[column];
            trs.translation += fade(offset, speed, frame, steps);
        }
    }
}

/// The transforms of the frame that follows three successive frames, if every joint keeps its acceleration.
pub(super) fn onward(rows: [&[Trs]; 3]) -> Vec<Trs> {
    let column = |column: usize| {
        let [first, second, last] = rows.map(|row| row[column]);
        let speed = |from: Trs, to: Trs| log(from.rotation.inverse() * to.rotation);
        let turn = 2.0 * speed(second, last) - speed(first, second);
        Trs {
            rotation: (last.rotation * exp(turn)).normalize(),
            translation: 3.0 * (last.translation - second.translation) + first.translation,
            ..last
        }
    };
    (0..rows[0].len()).map(column).collect()
}
