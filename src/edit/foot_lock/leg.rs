//! One leg over time: where it is, and how its foot is to be shifted.

use glam::Vec3;

use super::Followed;
use super::shift;
use super::sole::{Hinge, SolePoint, turn_to_height, turn_up};
use crate::edit::body::{Body, Leg, and_below};
use crate::edit::contacts::DetectedContacts;
use crate::figure::{HumanoidBone, Side};
use crate::pose::Pose;
use crate::scene::{NodeId, Scene};

/// As shares of the leg: a foot of the motion that is followed is on the ground below the first height, and in the air
/// above the second.
const ON_THE_GROUND: f32 = 0.04;
const IN_THE_AIR: f32 = 0.12;

/// How far above its place a foot that follows another may stay before the hips come down for it, as a share of the
/// leg.
const SLACK: f32 = 0.01;

/// How much of its full length a leg may be stretched to, unless the motion itself stretches it more.
const STRETCH: f32 = 0.9995;

/// The largest angle by which a foot turns to follow another, in radians.
const MOST_TURNED: f32 = 0.6;

/// The time in which a foot that is held on a sliding source gives way, in seconds.
const GIVES_WAY: f32 = 2.0;

/// A leg in every frame.
pub(super) struct LegTrack {
    pub(super) leg: Leg,
    /// The ankle and all below it.
    pub(super) foot: Vec<NodeId>,
    /// What stays above the floor.
    sole: Vec<SolePoint>,
    /// The lengths of thigh and shin together.
    pub(super) length: f32,
    pub(super) thigh: Vec<Vec3>,
    pub(super) knee: Vec<Vec3>,
    pub(super) ankle: Vec<Vec3>,
    /// How the points of the sole of a foot that follows none are turned up.
    hinges: Vec<Hinge>,
    /// How the foot is to be shifted.
    pub(super) shifts: Vec<Vec3>,
    /// The heights of the lowest point of the foot.
    lowest: Vec<f32>,
    /// The points of contact, the ball before the ankle.
    points: Vec<ContactTrack>,
    /// How high above its rest a point of that motion is at most that is near to the ground, in metres.
    low: f32,
    /// What the foot of the motion that is followed does, frame by frame.
    followed: Vec<Followers>,
    /// How far the foot is lifted to be as high as that, how far it must be at least, and how near to the ground it is.
    lifts: Vec<Lift>,
}

/// A point of contact over time.
struct ContactTrack {
    node: NodeId,
    /// Its height over the floor at rest.
    rest: f32,
    places: Vec<Vec3>,
    at_rest: Vec<bool>,
    /// Its steps over the ground in the motion that is followed, as long as they are here; empty without one.
    steps: Vec<Vec3>,
    /// How high it is above where it rests there.
    above_rest: Vec<f32>,
}

impl ContactTrack {
    /// The step over the ground from a frame to the next.
    fn step(&self, frame: usize, up: Vec3) -> Vec3 {
        (self.places[frame + 1] - self.places[frame]).reject_from_normalized(up)
    }
}

/// How high the points of contact are to be above where they rest.
#[derive(Clone, Copy, Debug, Default)]
struct Followers {
    ankle: f32,
    ball: Option<f32>,
    /// 1 on the ground, 0 in the air.
    weight: f32,
}

/// A vertical shift.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lift {
    wanted: f32,
    least: f32,
    pub(super) weight: f32,
}

impl Lift {
    /// The shift of a foot on the ground.
    pub(super) fn asked(&self) -> f32 {
        self.wanted.max(self.least)
    }
}

impl LegTrack {
    /// `followed` has the feet of another body, which these follow.
    pub(super) fn new(
        scene: &Scene,
        body: &Body,
        side: Side,
        leg: Leg,
        contacts: &DetectedContacts,
        followed: Option<&Followed<'_>>,
    ) -> Self {
        let candidates = [
            (HumanoidBone::LeftToes, body.toes(scene, side)),
            (HumanoidBone::LeftFoot, Some(leg.ankle)),
        ];
        let sole = match followed {
            Some(followed) => followed.soles[usize::from(side == Side::Right)].clone(),
            None => and_below(scene, leg.ankle)
                .skip(1)
                .map(|node| SolePoint::at(scene, node, 0.0))
                .collect(),
        };
        let stands = |node: NodeId| {
            let point = sole.iter().find(|point| point.node == Some(node));
            point.map_or(0.0, |point| point.height)
        };
        let points: Vec<ContactTrack> = candidates
            .into_iter()
            .filter_map(|(bone, node)| Some((node?, contacts.point(bone.on(side))?)))
            .map(|(node, point)| ContactTrack {
                node,
                rest: match followed {
                    Some(_) => stands(node),
                    None => point.height / body.metres,
                },
                places: Vec::with_capacity(contacts.frames),
                at_rest: point.at_rest.clone(),
                steps: followed.map_or(Vec::new(), |followed| {
                    let step = |pair: &[Vec3]| followed.turn * (pair[1] - pair[0]) * followed.scale;
                    let steps = point.places.windows(2).map(step);
                    steps.map(|step| step.reject_from_normalized(body.up)).collect()
                }),
                above_rest: point.above_rest.clone(),
            })
            .collect();
        let followers = followed.map_or(Vec::new(), |followed| {
            let above = |bone: HumanoidBone| contacts.point(bone.on(side)).map(|point| &point.above_rest);
            let (ankle, ball) = (above(HumanoidBone::LeftFoot), above(HumanoidBone::LeftToes));
            let height = |track: Option<&Vec<f32>>, frame: usize| {
                Some((track?.get(frame)? * followed.units_per_metre).max(0.0)).filter(|height| height.is_finite())
            };
            let length = followed.leg;
            (0..contacts.frames)
                .map(|frame| {
                    let Some(ankle) = height(ankle, frame) else {
                        return Followers::default();
                    };
                    let ball = height(ball, frame);
                    let lowest = ball.map_or(ankle, |ball| ball.min(ankle));
                    let (near, far) = (ON_THE_GROUND * length, IN_THE_AIR * length);
                    let t = ((far - lowest) / (far - near)).clamp(0.0, 1.0);
                    Followers {
                        ankle,
                        ball,
                        weight: t * t * (3.0 - 2.0 * t),
                    }
                })
                .collect()
        });
        let hinge = |point: &SolePoint| Hinge::new(leg.ankle, point);
        let hinges = match followed {
            Some(_) => Vec::new(),
            None => sole.iter().filter_map(hinge).collect(),
        };
        Self {
            foot: and_below(scene, leg.ankle).collect(),
            leg,
            low: followed.map_or(0.0, |followed| ON_THE_GROUND * followed.leg / followed.units_per_metre),
            hinges,
            sole,
            length: 0.0,
            shifts: vec![Vec3::ZERO; contacts.frames],
            thigh: Vec::with_capacity(contacts.frames),
            knee: Vec::with_capacity(contacts.frames),
            ankle: Vec::with_capacity(contacts.frames),
            lowest: Vec::with_capacity(contacts.frames),
            points,
            followed: followers,
            lifts: Vec::new(),
        }
    }

    /// Takes in the next frame. The foot of `pose` may be turned.
    pub(super) fn see(&mut self, frame: usize, pose: &mut Pose, up: Vec3, floor: f32) {
        let [thigh, knee, ankle] = [self.leg.thigh, self.leg.knee, self.leg.ankle].map(|node| pose.position(node));
        self.length = thigh.distance(knee) + knee.distance(ankle);
        self.thigh.push(thigh);
        self.knee.push(knee);
        self.ankle.push(ankle);
        let heights = self.foot.iter().map(|node| pose.position(*node).dot(up));
        self.lowest.push(heights.fold(f32::INFINITY, f32::min));
        self.hinges.iter_mut().for_each(|hinge| hinge.see(pose, up));
        if let Some(follow) = self.followed.get(frame).copied() {
            let stands = self.rest_of(self.leg.ankle);
            let wanted = floor + stands + follow.ankle - ankle.dot(up);
            let lift = follow.weight * wanted;
            self.turn(frame, pose, up, floor - lift);
            let depths = self
                .sole
                .iter()
                .map(|point| floor + point.height - point.place(pose).dot(up));
            self.lifts.push(Lift {
                wanted,
                least: depths.fold(f32::NEG_INFINITY, f32::max),
                weight: follow.weight,
            });
        }
        for point in &mut self.points {
            point.places.push(pose.position(point.node));
        }
    }

    fn rest_of(&self, node: NodeId) -> f32 {
        self.points
            .iter()
            .find(|point| point.node == node)
            .map_or(0.0, |point| point.rest)
    }

    /// Turns the foot so that its ball is as high above the ankle as that of the foot that is followed, and that
    /// nothing of it is below the floor.
    pub(super) fn turn(&self, frame: usize, pose: &mut Pose, up: Vec3, floor: f32) {
        if let Some(follow) = self.followed.get(frame)
            && let Some(ball) = follow.ball
            && let Some(point) = self.points.iter().find(|point| point.node != self.leg.ankle)
            && follow.weight > 0.0
        {
            let way = pose.position(point.node) - pose.position(self.leg.ankle);
            let wanted = point.rest + ball - self.rest_of(self.leg.ankle) - follow.ankle;
            let height = way.dot(up);
            turn_to_height(
                pose,
                self.leg.ankle,
                way,
                up,
                height + follow.weight * (wanted - height),
                MOST_TURNED,
            );
        }
        self.hinges.iter().for_each(|hinge| hinge.turn(frame, pose));
        turn_up(pose, &self.sole, up, floor);
    }

    /// Lets what would be below the floor turn up before it is there, within `radius` frames.
    pub(super) fn land_softly(&mut self, up: Vec3, floor: f32, radius: usize) {
        let shifts = &self.shifts;
        let floor = |frame: usize| floor - shifts[frame].dot(up);
        self.hinges
            .iter_mut()
            .for_each(|hinge| hinge.land_softly(up, floor, radius));
    }

    /// Whether any point of the foot is at rest.
    fn rests(&self, frame: usize) -> bool {
        self.points.iter().any(|point| point.at_rest[frame])
    }

    /// The point that rests in a frame and in the next: the slowest of the motion that is followed, else the ball if it
    /// does.
    fn resting(&self, frame: usize) -> Option<&ContactTrack> {
        let rests = |point: &&ContactTrack| point.at_rest[frame] && point.at_rest.get(frame + 1) == Some(&true);
        let speed = |point: &ContactTrack| point.steps.get(frame).map_or(0.0, |step| step.length());
        let resting = self.points.iter().filter(rests);
        resting.min_by(|a, b| speed(a).total_cmp(&speed(b)))
    }

    /// The step over the ground from a frame to the next of the point that rests in both.
    fn step(&self, frame: usize, up: Vec3) -> Option<Vec3> {
        Some(self.resting(frame)?.step(frame, up))
    }

    /// How the shift changes from a frame to the next. A foot at rest is held, and one that is near to the ground moves
    /// as that which is followed. `held` is how far it has been held back from following.
    fn change(&self, frame: usize, up: Vec3, held: &mut Vec3, gives_way: f32) -> Vec3 {
        if let Some(point) = self.resting(frame) {
            let followed = point.steps.get(frame).copied().unwrap_or_default();
            // A body whose feet slide all the time would leave its feet behind.
            let back = if point.steps.is_empty() {
                Vec3::ZERO
            } else {
                *held * gives_way
            };
            *held -= followed + back;
            return -point.step(frame, up) - back;
        }
        let known = || self.points.iter().filter(|point| frame < point.steps.len());
        let speed = |point: &ContactTrack| point.steps[frame].length();
        let low = known().filter(|point| point.above_rest[frame] < self.low);
        let slowest = low.min_by(|a, b| speed(a).total_cmp(&speed(b)));
        let lowest = || known().min_by(|a, b| a.above_rest[frame].total_cmp(&b.above_rest[frame]));
        let point = slowest.or_else(lowest);
        point.map_or(Vec3::ZERO, |point| point.steps[frame] - point.step(frame, up))
    }

    /// How far the points in contact slide, all steps together.
    pub(super) fn slide(&self, up: Vec3) -> f64 {
        let steps = (0..self.shifts.len()).filter_map(|frame| self.step(frame, up));
        steps.fold(0.0, |sum, step| sum + f64::from(step.length()))
    }

    /// The number of contacts of the foot.
    pub(super) fn contacts(&self) -> usize {
        (0..self.shifts.len())
            .filter(|&frame| self.rests(frame) && (frame == 0 || !self.rests(frame - 1)))
            .count()
    }

    /// Whether a point of the foot is below the floor.
    pub(super) fn is_below(&self, frame: usize, floor: f32) -> bool {
        self.lowest[frame] < floor || self.hinges.iter().any(|hinge| hinge.turns(frame))
    }

    /// Whether the foot follows that of another body in this frame.
    pub(super) fn follows(&self, frame: usize) -> bool {
        self.followed.get(frame).is_some_and(|follow| follow.weight > 0.0)
    }

    /// How far below the floor the foot comes.
    pub(super) fn deepest(&self, floor: f32) -> f32 {
        self.lowest.iter().map(|lowest| floor - lowest).fold(0.0, f32::max)
    }

    /// How long the leg may become: its full length, but for a bend that cannot be seen, unless the motion stretches
    /// it.
    pub(super) fn reach(&self, frame: usize) -> f32 {
        let now = self.thigh[frame].distance(self.ankle[frame]);
        (STRETCH * self.length).max(now)
    }

    /// How far above its place the foot may stay.
    pub(super) fn slack(&self) -> f32 {
        if self.followed.is_empty() {
            0.0
        } else {
            SLACK * self.length
        }
    }

    /// The vertical shifts of a foot that follows another.
    pub(super) fn lifts(&self) -> &[Lift] {
        &self.lifts
    }

    /// Takes over where the points of contact are in a frame.
    pub(super) fn place(&mut self, frame: usize, pose: &Pose) {
        for point in &mut self.points {
            point.places[frame] = pose.position(point.node);
        }
    }

    /// How far the foot as a whole is below where it rests, the least of its points, or the ankle below the floor.
    fn sunk(&self, frame: usize, up: Vec3, floor: f32) -> f32 {
        let depths = self
            .points
            .iter()
            .map(|point| floor + point.rest - point.places[frame].dot(up));
        let least = depths.fold(f32::INFINITY, f32::min);
        let ankle = floor - self.ankle[frame].dot(up);
        if least.is_finite() {
            least.max(ankle).max(0.0)
        } else {
            0.0
        }
    }

    /// The shifts over the ground that take the slide back, in the frames in which the foot is on the ground.
    pub(super) fn held(&self, up: Vec3, frames_per_second: f32) -> Vec<Option<Vec3>> {
        let frames = self.shifts.len();
        let follows = |frame: usize| self.followed.get(frame).is_some_and(|follow| follow.weight == 1.0);
        let is_low = |frame: &usize| self.rests(*frame) || follows(*frame);
        let gives_way = (1.0 / (GIVES_WAY * frames_per_second)).min(1.0);
        let mut known: Vec<Option<Vec3>> = vec![None; frames];
        let mut start = 0;
        while start < frames {
            if !is_low(&start) {
                start += 1;
                continue;
            }
            let end = (start..frames).find(|frame| !is_low(frame)).unwrap_or(frames);
            let (mut shift, mut held) = (Vec3::ZERO, Vec3::ZERO);
            let mut shifts = vec![shift];
            for frame in start..end - 1 {
                shift += self.change(frame, up, &mut held, gives_way);
                shifts.push(shift);
            }
            // Where the foot is shifted least: at most, or on the whole.
            let middle = match self.followed.is_empty() {
                true => shift::middle(&shifts),
                false => shifts.iter().sum::<Vec3>() / shifts.len() as f32,
            };
            for (known, shift) in known[start..end].iter_mut().zip(shifts) {
                *known = Some(shift - middle);
            }
            start = end;
        }
        known
    }

    /// Completes the shifts between the frames in which they are known, beside `carried`, the shifts of the hips.
    fn complete(&mut self, known: &[Option<Vec3>], up: Vec3, blend: usize, carried: &[Vec3]) {
        let relative = known.iter().zip(carried);
        let relative = relative.map(|(shift, carried)| Some((*shift)? - carried.reject_from_normalized(up)));
        let relative: Vec<Option<Vec3>> = relative.collect();
        self.shifts = shift::complete(&relative, blend);
    }

    /// How far a foot that follows none is below where it rests, frame by frame, and how far its ankle is below the
    /// floor: made smooth.
    pub(super) fn lifts_onto(&self, up: Vec3, floor: f32, blend: usize) -> [Vec<f32>; 2] {
        let depths: Vec<f32> = (0..self.shifts.len())
            .map(|frame| self.sunk(frame, up, floor))
            .collect();
        let least: Vec<f32> = self
            .ankle
            .iter()
            .map(|ankle| (floor - ankle.dot(up)).max(0.0))
            .collect();
        [depths, least].map(|depths| shift::envelope(&depths, blend))
    }

    /// The shifts of a foot that follows none. `lifted` is how far it is lifted, and `carried` how the hips are
    /// shifted.
    pub(super) fn shift(&mut self, known: &[Option<Vec3>], lifted: &[f32], up: Vec3, blend: usize, carried: &[Vec3]) {
        self.complete(known, up, blend, carried);
        for ((shift, lift), carried) in self.shifts.iter_mut().zip(lifted).zip(carried) {
            *shift += carried.reject_from_normalized(up) + up * *lift;
        }
    }

    /// The shifts of a foot that follows another, and is carried along with the hips.
    pub(super) fn follow(&mut self, known: &[Option<Vec3>], up: Vec3, blend: usize, carried: &[Vec3]) {
        self.complete(known, up, blend, carried);
        for ((shift, lift), carried) in self.shifts.iter_mut().zip(&self.lifts).zip(carried) {
            let height = lift.weight * lift.wanted + (1.0 - lift.weight) * carried.dot(up);
            *shift += carried.reject_from_normalized(up) + up * height.max(lift.least);
        }
    }
}
