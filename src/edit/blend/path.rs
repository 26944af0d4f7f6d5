//! Where a figure goes whose motion is mixed of two.

use glam::{Quat, Vec3};
use mocap_scene::pose::Trs;

use crate::carrier::{Carrier, Placement};
use crate::frames::between;

/// The steps over the ground of both motions, each in the direction in which its figure looks, mixed by a weight. The
/// mean of the positions would be wrong: where the motions walk in opposite directions, it does not move.
pub(super) struct Path<'a> {
    carrier: &'a Carrier,
    last: Option<Moment>,
}

/// One frame of the two motions and of the mix.
struct Moment {
    /// Where the figures of both motions are.
    positions: [Vec3; 2],
    /// The rotation about the up axis from where the second looks to where the first looks.
    other_to_first: Quat,
    /// That from where the first looks to where the mix looks.
    first_to_mix: Quat,
    /// Where the mix is.
    position: Vec3,
}

impl<'a> Path<'a> {
    pub(super) fn new(carrier: &'a Carrier) -> Self {
        Self { carrier, last: None }
    }

    /// The mix of two rows that are one moment, where the steps up to it have led. The first one stands and looks
    /// between the two.
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
