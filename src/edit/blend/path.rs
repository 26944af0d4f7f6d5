//! Computes the path over the ground of a figure whose motion is mixed from two motions.

use glam::{Quat, Vec3};
use mocap_scene::pose::Trs;

use crate::carrier::{Carrier, Placement};
use crate::frames::between;

/// Mixes the movements over the ground of both motions, from frame to frame. Each movement is relative to the heading
/// of its figure. A mean of the positions would be wrong: the mean of two figures that walk in opposite directions does
/// not move.
pub(super) struct Path<'a> {
    carrier: &'a Carrier,
    last: Option<Moment>,
}

/// One frame of the two motions and of the mix.
struct Moment {
    /// The positions of the figures of both motions.
    positions: [Vec3; 2],
    /// The rotation about the up axis from the heading of the second figure to the heading of the first figure.
    other_to_first: Quat,
    /// The rotation about the up axis from the heading of the first figure to the heading of the mixed figure.
    first_to_mix: Quat,
    /// The position of the mixed figure.
    position: Vec3,
}

impl<'a> Path<'a> {
    pub(super) fn new(carrier: &'a Carrier) -> Self {
        Self { carrier, last: None }
    }

    /// Mixes a frame of the first motion with the corresponding frame of the second motion. The first call puts the
    /// mixed figure between both figures, by `weight`. Later calls continue the path of the mixed figure.
    pub(super) fn mix(&mut self, first: &[Trs], second: &[Trs], weight: f32) -> Vec<Trs> {
        let carrier = self.carrier;
        let positions = [carrier.position(first), carrier.position(second)];
        let other_to_first = carrier.turn(second, first);
        let (first_to_mix, position) = match &self.last {
            None => {
                let mut between = first.to_vec();
                carrier.apply(&carrier.placement(first, second).part(weight), &mut between);
                (carrier.turn(first, &between), carrier.position(&between))
            }
            Some(last) => {
                let closing = last.other_to_first * other_to_first.inverse();
                let [own, other] = [0, 1].map(|motion| positions[motion] - last.positions[motion]);
                let step = own.lerp(last.other_to_first * other, weight);
                (
                    Quat::IDENTITY.slerp(closing, weight) * last.first_to_mix,
                    last.position + last.first_to_mix * step,
                )
            }
        };
        let mut beside = second.to_vec();
        carrier.apply(&carrier.placement(second, first), &mut beside);
        let pairs = first.iter().zip(&beside);
        let mut row: Vec<Trs> = pairs.map(|(a, b)| between(*a, *b, weight)).collect();
        let here = carrier.position(&row);
        let over_ground = (position - here).reject_from_normalized(carrier.up);
        let to = here + over_ground - first_to_mix * here;
        carrier.apply(&Placement::new(first_to_mix, to), &mut row);
        self.last = Some(Moment {
            positions,
            other_to_first,
            first_to_mix,
            position,
        });
        row
    }
}
