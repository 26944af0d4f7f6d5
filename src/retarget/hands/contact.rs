//! One contact of a hand on the target: the goal of the palm, and the applied fraction of the shift.

use std::f32::consts::{PI, TAU};
use std::ops::Range;

use glam::Vec3;
use mocap_figure::{HumanoidBone as Bone, Side};
use mocap_scene::math::directions::rotation_of;

use super::Hands;
use super::shape::{self, LEG, Shape, larger};
use super::touch::Touch;
use crate::hand_report::{HandContact, TouchedPart};

/// Half the thickness of a hand in metres, for a body whose leg is [`LEG`] long. It is the smallest distance of the
/// middle of a palm from a surface.
pub(super) const THICKNESS: f32 = 0.014;

/// The largest shift of a palm that is not visible, in metres.
const UNSEEN: f32 = 2e-3;

/// Half the time in which the weight of a contact rises or falls, in seconds: the first value that is tried, and the
/// largest.
const EASE: [f64; 2] = [0.15, 0.6];

/// The time on both sides of a frame over which shifts are averaged, in seconds.
const SMOOTH: f64 = 0.1;

/// The factor by which [`EASE`] grows if the hand jerks. Five steps lead from the first value to the longest.
const LONGER: f64 = 1.35;

/// The factor by which the shift is reduced if the hand jerks even with the longest [`EASE`].
const LESS: f32 = 0.8;

/// The smallest fraction of a shift that is kept. A smaller shift does not bring a hand near the touched part.
const LEAST: f32 = 0.25;

/// The largest push of a hand whose fingers are inside the head, in metres, for a body whose leg is [`LEG`] long.
const PUSH: f32 = 0.15;

/// The number of steps of the push out of the head. One step is not exact, because the head is round.
const PUSHES: usize = 3;

/// Maps places on parts of the source to places on the target.
pub(super) struct Places {
    pub(super) source: Vec<Shape>,
    pub(super) target: Vec<Shape>,
    /// The ratios of lengths and of heights on the target to the source.
    pub(super) scale: f32,
    pub(super) height_scale: f32,
    /// The floor of the target.
    pub(super) floor: f32,
    /// The smallest distance of a palm from a surface.
    pub(super) least: f32,
}

/// A contact on the target.
pub(super) struct Contact {
    side: Side,
    part: TouchedPart,
    /// The first and the last frame of the contact.
    first: usize,
    last: usize,
    /// Half the number of frames over which the shift starts or ends. `most` is the largest value that `ease` may get.
    ease: usize,
    most: usize,
    /// The applied fraction of the shift.
    pub(super) strength: f32,
    /// The frame of the first shift, which may be before the motion.
    from: isize,
    /// The shift of the palm, in the axes of the figure. For two hands, the shift of the left palm.
    shifts: Vec<Vec3>,
    /// The mean distance of the palm from the surface in the source, scaled to the target.
    gap: f32,
}

/// The contacts of a motion on the target, without contacts in which the hands are already in place.
pub(super) fn contacts(touches: &[Touch], places: &Places, hands: &mut Hands<'_>) -> Vec<Contact> {
    let rate = hands.target.animation.ticks_per_second;
    let [ease, most] = EASE.map(|seconds| (seconds * rate).round().max(1.0) as usize);
    let metres = hands.target.body.metres_per_unit as f32;
    let mut contacts: Vec<Contact> = Vec::new();
    for touch in touches {
        for [first, last] in touch.contacts.iter().copied() {
            if touches.iter().any(|other| touch.is_beside(other, [first, last])) {
                continue;
            }
            let mut contact = Contact {
                side: touch.side,
                part: touch.part,
                first,
                last,
                ease,
                most,
                strength: 1.0,
                from: first as isize,
                shifts: Vec::new(),
                gap: mean(touch.gaps[first..=last].iter().copied()) * places.height_scale,
            };
            if contact.find_shifts(touch, places, hands) * metres > UNSEEN {
                contacts.push(contact);
            }
        }
    }
    contacts
}

fn mean(values: impl ExactSizeIterator<Item = f32>) -> f32 {
    let count = values.len().max(1) as f32;
    values.sum::<f32>() / count
}

impl Contact {
    /// Finds the shift of the palm in each frame. Returns the largest deviation of the hand from its position in the
    /// source, relative to the touched part.
    fn find_shifts(&mut self, touch: &Touch, places: &Places, hands: &mut Hands<'_>) -> f32 {
        let Some(arm) = hands.arm(self.side) else { return 0.0 };
        let (mut farthest, corner) = (0.0_f32, 0.5 * places.least);
        let shape = |shapes: &[Shape]| shapes.iter().position(|shape| shape.part == self.part);
        let parts = shape(&places.source).zip(shape(&places.target));
        let vertices = match self.part {
            TouchedPart::Head => shape::hand_vertices(hands.target.body, hands.target.scene, hands.arms[arm].joints[2]),
            _ => Vec::new(),
        };
        let (mut pushes, mut most_push) = (Vec::new(), 0.0_f32);
        // Hands on the floor keep their mean position, and slide like the hands of the source.
        let over_floor = |palm: Vec3| Vec3::new(palm.x, 0.0, palm.z);
        let slide = |frame: usize| {
            over_floor(touch.spots[frame].from_start) * places.scale - over_floor(hands.free[arm].palm[frame])
        };
        let middle = (self.first..=self.last).map(slide).sum::<Vec3>() / (self.last + 1 - self.first) as f32;
        let slides: Vec<Vec3> = (self.first..=self.last).map(|frame| slide(frame) - middle).collect();
        for frame in self.first..=self.last {
            let (spot, palm) = (&touch.spots[frame], hands.free[arm].palm[frame]);
            let (shift, away) = match (self.part, parts) {
                (TouchedPart::OtherHand, _) => {
                    let apart = hands.free[1].palm[frame] - palm;
                    let wanted = spot.from_start * places.height_scale;
                    let shift = 0.5
                        * (apart - wanted.normalize_or_zero() * larger([wanted.length(), 2.0 * places.least], corner));
                    (shift, apart - wanted)
                }
                (TouchedPart::Floor, _) => {
                    let gap = touch.gaps[frame] * places.height_scale;
                    let height = |gap: f32| slides[frame - self.first] + Vec3::Y * (places.floor + gap - palm.y);
                    (height(larger([gap, places.least], corner)), height(gap))
                }
                (_, Some((source, target))) => {
                    hands.sample(frame);
                    let placed = places.target[target].placed(hands.target.body, &hands.pose);
                    let goal = placed.point(&places.source[source], spot, places.height_scale, places.least);
                    let hand = hands.arms[arm].joints[2];
                    let to_figure = hands.target.body.axes.inverse();
                    let turn = to_figure * rotation_of(&hands.pose.node_to_world[hand.index()]);
                    let to_wrist = to_figure * -hands.arms[arm].wrist_to_palm(&hands.pose);
                    let (mut pushed, mut push) = (goal, 0.0);
                    for _ in 0..PUSHES {
                        let depth = |vertex: &Vec3| -placed.gap(&placed.spot(pushed + to_wrist + turn * *vertex));
                        push += vertices.iter().map(depth).fold(0.0, f32::max);
                        pushed = goal + placed.away(&placed.spot(goal)) * push;
                    }
                    pushes.push(placed.away(&placed.spot(goal)));
                    most_push = most_push.max(push);
                    let wanted = spot.from_start * places.height_scale;
                    (goal - palm, placed.spot(palm).from_start - wanted)
                }
                _ => (Vec3::ZERO, Vec3::ZERO),
            };
            self.shifts.push(shift);
            farthest = farthest.max(away.length());
        }
        // One push for all frames. A push per frame would jump when another vertex becomes the deepest.
        let most_push = most_push.min(PUSH * hands.target.body.leg / LEG);
        for (shift, away) in self.shifts.iter_mut().zip(pushes) {
            *shift += away * most_push;
        }
        // Before and after the contact, the hand keeps the shift of the nearest end.
        let radius = (SMOOTH * hands.target.animation.ticks_per_second).round() as usize;
        let ends = [self.shifts[0], self.shifts[self.shifts.len() - 1]].map(|end| vec![end; 2 * radius]);
        let long = [&*ends[0], &self.shifts, &ends[1]].concat();
        let window = |at: &[Vec3]| {
            let weights = (1..=at.len()).map(|index| 1.0 - (TAU * index as f32 / (at.len() + 1) as f32).cos());
            at.iter()
                .zip(weights)
                .map(|(shift, weight)| *shift * weight)
                .sum::<Vec3>()
                / (at.len() + 1) as f32
        };
        self.shifts = long.windows(2 * radius + 1).map(window).collect();
        self.from = self.first as isize - radius as isize;
        farthest
    }

    /// The hands that the contact moves.
    pub(super) fn sides(&self) -> impl Iterator<Item = Side> {
        let other = (self.part == TouchedPart::OtherHand).then_some(Side::Right);
        std::iter::once(self.side).chain(other)
    }

    /// The shift of the palm in a frame.
    fn shift(&self, frame: usize) -> Vec3 {
        let index = (frame as isize - self.from).clamp(0, self.shifts.len() as isize - 1);
        self.shifts[index as usize]
    }

    /// Whether the trunk may lean for the contact: the touched part must not move with the trunk.
    pub(super) fn leans(&self) -> bool {
        use TouchedPart::{Floor, LeftShin, LeftThigh, RightShin, RightThigh};
        matches!(self.part, Floor | LeftThigh | RightThigh | LeftShin | RightShin)
    }

    /// The shift of each hand in a frame.
    pub(super) fn shifts(&self, frame: usize) -> impl Iterator<Item = (Side, Vec3)> {
        let shift = self.shift(frame);
        self.sides().zip([shift, -shift])
    }

    /// The fraction of the shift in a frame: the integral of a Hann window, so speed and acceleration have no jumps.
    pub(super) fn weight(&self, frame: usize) -> f32 {
        let away = self.first.saturating_sub(frame).max(frame.saturating_sub(self.last));
        let part = 1.0 - away as f32 / self.ease as f32;
        match part > -1.0 {
            true => self.strength * 0.5 * (1.0 + part + (PI * part).sin() / PI),
            false => 0.0,
        }
    }

    /// The frames that the contact changes, and the frames next to them whose jerk depends on the changed frames.
    pub(super) fn frames(&self, count: usize) -> Range<usize> {
        /// A third difference has four values.
        const BESIDE: usize = 3;
        let around = 2 * self.ease + BESIDE;
        self.first.saturating_sub(around)..(self.last + around + 1).min(count)
    }

    /// Makes the ease longer, then reduces the shift, and then drops the contact.
    pub(super) fn relax(&mut self, is_last: bool) {
        if is_last || self.strength * LESS < LEAST {
            self.strength = 0.0;
        } else if self.ease < self.most {
            self.ease = ((self.ease as f64 * LONGER).ceil() as usize).min(self.most);
        } else {
            self.strength *= LESS;
        }
    }
}

impl Hands<'_> {
    /// The mean distances of a palm from its goal, without the contact and with it, in units of the scene.
    pub(super) fn errors(&self, contact: &Contact) -> [f32; 2] {
        let Some(arm) = self.arm(contact.side) else {
            return [0.0; 2];
        };
        let error = |frame: usize, kept: bool| {
            let shift = contact.shift(frame);
            let moved = |arm: usize| self.kept[arm].palm[frame] - self.free[arm].palm[frame];
            match (contact.part, kept) {
                (TouchedPart::OtherHand, false) => 2.0 * shift.length(),
                (TouchedPart::OtherHand, true) => (2.0 * shift + moved(1) - moved(0)).length(),
                (_, false) => shift.length(),
                (_, true) => (shift - moved(arm)).length(),
            }
        };
        [false, true].map(|kept| mean((contact.first..contact.last + 1).map(|frame| error(frame, kept))))
    }

    /// The report of a contact.
    pub(super) fn report(&mut self, contact: &Contact, places: &Places) -> HandContact {
        let arm = self.arm(contact.side).unwrap_or_default();
        let shape = places.target.iter().find(|shape| shape.part == contact.part);
        let mut gaps = [0.0_f64; 2];
        for frame in contact.first..=contact.last {
            self.sample(frame);
            let placed = shape.map(|shape| shape.placed(self.target.body, &self.pose));
            for (gap, tracks) in gaps.iter_mut().zip([&self.free, &self.kept]) {
                let palm = tracks[arm].palm[frame];
                *gap += f64::from(match (contact.part, placed) {
                    (TouchedPart::OtherHand, _) => tracks[1].palm[frame].distance(palm),
                    (TouchedPart::Floor, _) => palm.y - places.floor,
                    (_, Some(placed)) => placed.gap(&placed.spot(palm)),
                    _ => 0.0,
                });
            }
        }
        let metres = self.target.body.metres_per_unit;
        let [before, after] = gaps.map(|gap| metres * gap / (contact.last + 1 - contact.first) as f64);
        let [error_before, error_after] = self.errors(contact).map(|error| metres * f64::from(error));
        HandContact {
            hand: Bone::LeftHand.on(contact.side),
            with: contact.part,
            first: self.ticks[contact.first],
            last: self.ticks[contact.last],
            source: metres * f64::from(contact.gap),
            before,
            after,
            error_before,
            error_after,
            strength: f64::from(contact.strength),
        }
    }
}
