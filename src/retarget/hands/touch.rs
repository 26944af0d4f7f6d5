//! Finds the contacts of the hands in a motion.

use glam::Vec3;
use mocap_figure::Side;
use mocap_figure::contacts::ContactRule;
use mocap_scene::math::velocity::velocities;
use mocap_scene::pose::{Binding, Pose};

use super::arm::Arm;
use super::shape::{LEG, Shape, Spot};
use crate::hand_report::TouchedPart;
use crate::measure::Moving;

/// The largest speed of a hand relative to the touched part, in m/s, for a body whose leg is [`LEG`] long. It is higher
/// than for feet at rest, because skin and clothes yield.
const SPEED: f64 = 0.3;

/// The largest distance of a palm from the surface that it touches, in metres, for a body whose leg is [`LEG`] long.
/// The thickness of the source's body is only guessed, with an error of some centimetres.
fn nearest(part: TouchedPart, spot: &Spot) -> f64 {
    match part {
        // The distance from palm to palm, for clasped hands.
        TouchedPart::OtherHand => 0.1,
        TouchedPart::Head => 0.06,
        TouchedPart::Chest | TouchedPart::Hips => 0.04,
        TouchedPart::LeftThigh | TouchedPart::RightThigh if !spot.is_aside() => 0.05,
        // Hanging arms are beside the thighs and need not touch them.
        TouchedPart::LeftThigh | TouchedPart::RightThigh => 0.005,
        TouchedPart::LeftShin | TouchedPart::RightShin => 0.04,
        TouchedPart::Floor => 0.06,
    }
}

/// A part that a hand may touch, over a motion.
pub(super) struct Touch {
    /// The hand. For two hands, the left hand.
    pub(super) side: Side,
    pub(super) part: TouchedPart,
    /// The place of the hand relative to the part, frame by frame. For two hands, `from_start` is the vector from the
    /// left to the right palm. For the floor, `from_start` is the position of the palm, in the axes of the figure.
    pub(super) spots: Vec<Spot>,
    /// The distance from the surface, in units of the scene.
    pub(super) gaps: Vec<f32>,
    /// The first and the last frame of each contact.
    pub(super) contacts: Vec<[usize; 2]>,
}

impl Touch {
    fn new(side: Side, part: TouchedPart, frames: usize) -> Self {
        Self {
            side,
            part,
            spots: Vec::with_capacity(frames),
            gaps: Vec::with_capacity(frames),
            contacts: Vec::new(),
        }
    }

    /// Whether, in this contact, the hand is nearer to the part of `other` than to the part of `self`. A hand at a knee
    /// is near both thigh and shin.
    pub(super) fn is_beside(&self, other: &Self, [first, last]: [usize; 2]) -> bool {
        let is_of_body = |touch: &Self| !matches!(touch.part, TouchedPart::OtherHand | TouchedPart::Floor);
        if self.side != other.side || self.part == other.part || !(is_of_body(self) && is_of_body(other)) {
            return false;
        }
        let overlap = |[from, to]: &[usize; 2]| (*to.min(&last) + 1).saturating_sub(*from.max(&first));
        let shared: usize = other.contacts.iter().map(overlap).sum();
        let gap = |touch: &Self| touch.gaps[first..=last].iter().sum::<f32>();
        2 * shared > last + 1 - first && gap(other) < gap(self)
    }

    fn see(&mut self, spot: Spot, gap: f32) {
        self.spots.push(spot);
        self.gaps.push(gap);
    }

    /// Finds the contacts. `size` is the ratio of the leg to [`LEG`], in units of the scene.
    fn find(&mut self, size: f32, rate: f64) {
        let rule = ContactRule {
            height: 1.0,
            speed: match self.part {
                TouchedPart::OtherHand => f64::INFINITY,
                _ => SPEED,
            },
            ..ContactRule::default()
        };
        let near = |(gap, spot): (&f32, &Spot)| f64::from((gap / size).max(0.0)) / nearest(self.part, spot);
        let gaps: Vec<f64> = self.gaps.iter().zip(&self.spots).map(near).collect();
        if gaps.iter().all(|gap| *gap > 1.0) {
            return;
        }
        let flat: Vec<f32> = self
            .spots
            .iter()
            .flat_map(|spot| (spot.from_start / size).to_array())
            .collect();
        let speeds = velocities(&flat, 3, rate);
        let speeds = speeds
            .chunks_exact(3)
            .map(|speed| f64::from(Vec3::from_slice(speed).length()));
        let at_rest = rule.at_rest(gaps.into_iter().zip(speeds), rate);
        for frame in (0..at_rest.len()).filter(|frame| at_rest[*frame]) {
            match self.contacts.last_mut() {
                Some(last) if last[1] + 1 == frame => last[1] = frame,
                _ => self.contacts.push([frame, frame]),
            }
        }
    }
}

/// The parts that the hands touch in a motion. `floor` is the height of its floor in units of the scene.
pub(super) fn touches(moving: &Moving<'_>, arms: &[Arm], shapes: &[Shape], floor: f32, ticks: &[f64]) -> Vec<Touch> {
    let body = moving.body;
    let mut touches = Vec::new();
    for arm in arms {
        touches.extend(shapes.iter().map(|shape| Touch::new(arm.side, shape.part, ticks.len())));
        touches.push(Touch::new(arm.side, TouchedPart::Floor, ticks.len()));
    }
    if arms.len() == Side::ALL.len() {
        touches.push(Touch::new(Side::Left, TouchedPart::OtherHand, ticks.len()));
    }
    let binding = Binding::new(moving.scene, moving.animation);
    let mut pose = Pose::rest(moving.scene);
    let to_figure = body.axes.inverse();
    let mut placed = Vec::with_capacity(shapes.len());
    for &tick in ticks {
        pose.sample(&binding, moving.animation, tick);
        placed.clear();
        placed.extend(shapes.iter().map(|shape| shape.placed(body, &pose)));
        let mut tracks = touches.iter_mut();
        let mut palms = [Vec3::ZERO; 2];
        for (arm, palm) in arms.iter().zip(&mut palms) {
            *palm = to_figure * arm.palm(&pose);
            for (shape, touch) in placed.iter().zip(tracks.by_ref()) {
                let spot = shape.spot(*palm);
                touch.see(spot, shape.gap(&spot));
            }
            if let Some(touch) = tracks.next() {
                touch.see(Spot::at(*palm), palm.y - floor);
            }
        }
        if let Some(touch) = tracks.next() {
            let apart = palms[1] - palms[0];
            touch.see(Spot::at(apart), apart.length());
        }
    }
    for touch in &mut touches {
        touch.find(body.leg / LEG, moving.animation.ticks_per_second);
    }
    touches.retain(|touch| !touch.contacts.is_empty());
    touches
}
