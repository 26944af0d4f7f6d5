//! The comparison of one clip, moment by moment.

use glam::{DMat4, DQuat, DVec3, DVec4};

use super::chain::Skeleton;
use super::change::{Change, Timeline};
use super::pairs::Pairs;
use super::{Finding, FindingKind, Output, Worst};
use crate::error::Result;
use crate::scene::{NodeKind, Scene};

/// How far from a joint the points are that show its rotation, in metres: about as far as the skin around it.
pub(super) const SKIN: f64 = 0.03;

/// Which clip of the source is which of the file. A source without a clip is a skeleton at rest, and so is a file.
pub(super) fn matched(
    source: &Scene,
    output: &Output<'_>,
    change: &Change,
    findings: &mut Vec<Finding>,
) -> Result<Vec<(Option<usize>, Option<usize>)>> {
    let (ours, theirs): (Vec<_>, Vec<_>) = (
        source.animations.iter().map(|clip| clip.name.clone()).collect(),
        output.clip_names(),
    );
    let mut pairs: Vec<(Option<usize>, Option<usize>)> = Vec::new();
    if ours.len() == theirs.len() {
        pairs = (0..ours.len()).map(|clip| (Some(clip), Some(clip))).collect();
    } else {
        let mut is_taken = vec![false; theirs.len()];
        // One clip of a file that has one is that of a source that has one, whatever their names.
        for (clip, name) in ours.iter().enumerate() {
            let found = (0..theirs.len()).find(|&other| !is_taken[other] && theirs[other] == *name);
            match found.or_else(|| (clip == 0 && !theirs.is_empty() && ours.len() == 1).then_some(0)) {
                Some(found) => {
                    is_taken[found] = true;
                    pairs.push((Some(clip), Some(found)));
                }
                None if moves(source, clip, change)? => {
                    let message = format!("{} is not in the file", name_of(source, clip));
                    findings.push(Finding::new(FindingKind::MissingClip, message));
                    // Its frames are missing, too, if the file has no other clip.
                    if theirs.is_empty() {
                        pairs.push((Some(clip), None));
                    }
                }
                // A clip in which nothing moves is a pose, and a file without a clip has one.
                None => pairs.push((Some(clip), None)),
            }
        }
        for (clip, name) in theirs.iter().enumerate().filter(|(clip, _)| !is_taken[*clip]) {
            let message = match name.is_empty() {
                true => format!("clip {clip} of the file is not in the source"),
                false => format!("clip \"{name}\" of the file is not in the source"),
            };
            findings.push(Finding::new(FindingKind::ExtraClip, message));
        }
    }
    if pairs.is_empty() {
        pairs.push((None, None));
    }
    Ok(pairs)
}

/// Whether anything moves in the part of a clip that the file is to have.
fn moves(source: &Scene, clip: usize, change: &Change) -> Result<bool> {
    let timeline = Timeline::new(source, Some(clip), change)?;
    Ok(timeline.moves(&Skeleton::of_scene(source, Some(clip))))
}

/// How a finding calls a clip of the source.
pub(super) fn name_of(source: &Scene, clip: usize) -> String {
    let name = &source.animations[clip].name;
    match (source.animations.len(), name.is_empty()) {
        (1, _) => "the motion".to_owned(),
        (_, false) => format!("clip \"{name}\""),
        (_, true) => format!("clip {clip}"),
    }
}

/// What is the same for all clips.
pub(super) struct Compared<'a> {
    pub(super) pairs: &'a Pairs,
    pub(super) change: &'a Change,
    /// Metres in a unit of the file.
    pub(super) metres: f64,
    /// Whether the times of the file are 32-bit seconds.
    pub(super) is_gltf: bool,
    /// Whether a joint has the same axes in both.
    pub(super) turns: bool,
}

impl Compared<'_> {
    /// Compares at these ticks of the source.
    pub(super) fn frames(
        &self,
        clip: Option<usize>,
        ours: &Skeleton,
        theirs: &Skeleton,
        timeline: &Timeline,
        ticks: &[f64],
    ) -> Errors {
        let root_of = roots(ours);
        let rigid = self.change.humanoid.map(|_| self.pairs.rigid(ours, theirs));
        let mut start: Option<Vec<DVec3>> = None;
        let mut first: Option<(Vec<DMat4>, Vec<DMat4>)> = None;
        let (mut here, mut there) = (Vec::new(), Vec::new());
        let mut errors = Errors {
            turn: self.turns.then_some(0.0),
            ..Errors::default()
        };
        // Steps are seen between frames alone.
        let between = theirs.stepped.as_ref().map_or(&[][..], |_| &[0.5]);
        for (index, &frame) in ticks.iter().enumerate() {
            let next = ticks.get(index + 1).copied();
            let after = between.iter().filter_map(|share| Some(frame + share * (next? - frame)));
            for tick in std::iter::once(frame).chain(after) {
                let seconds = timeline.seconds(tick);
                ours.world(tick / timeline.rate, &mut here);
                // The moment that glTF has for this frame. Just before it a cut is another pose.
                let rounded = if self.is_gltf {
                    f64::from(seconds as f32)
                } else {
                    seconds
                };
                theirs.world(rounded, &mut there);
                let places: Vec<_> = here
                    .iter()
                    .map(|matrix| self.change.place(matrix.w_axis.truncate()))
                    .collect();
                let start = start.get_or_insert_with(|| places.clone());
                if let Some(rigid) = &rigid {
                    let (here_first, there_first) = first.get_or_insert_with(|| (here.clone(), there.clone()));
                    let turns = self
                        .pairs
                        .list
                        .iter()
                        .zip(&rigid.has_turn)
                        .filter(|(_, has_turn)| **has_turn);
                    for (&(a, b), _) in turns {
                        errors.add_turn(self.turn_since((&here_first[a], &here[a]), (&there_first[b], &there[b])));
                    }
                }
                for (pair, &(a, b)) in self.pairs.list.iter().enumerate() {
                    if rigid.as_ref().is_some_and(|rigid| !rigid.has_place[pair]) {
                        continue;
                    }
                    let mut expected = places[a];
                    if self.change.in_place {
                        let offset = places[root_of[a]] - start[root_of[a]];
                        expected -= self.change.over_ground(offset);
                    }
                    let error = expected.distance(there[b].w_axis.truncate()) * self.metres;
                    errors.add(error, || Worst {
                        clip: clip.unwrap_or(0),
                        joint: ours.joints[a].name.clone(),
                        frame: tick as usize,
                        seconds,
                    });
                    if self.turns && rigid.is_none() {
                        errors.add_turn(self.turn(&here[a], &there[b]));
                    }
                }
            }
            errors.frames += 1;
        }
        errors
    }

    /// How far a point on the skin is off by the rotation of its joint since the first frame. The joints may stand
    /// otherwise at rest.
    fn turn_since(&self, ours: (&DMat4, &DMat4), theirs: (&DMat4, &DMat4)) -> f64 {
        let since = |(first, now): (&DMat4, &DMat4)| rotation_of(now) * rotation_of(first).inverse();
        let (ours, theirs) = (since(ours), since(theirs));
        let off = DVec3::AXES
            .into_iter()
            .map(|axis| self.change.turn(ours * axis).distance(theirs * self.change.turn(axis)) * SKIN);
        off.fold(0.0, f64::max)
    }

    /// How far a point on the skin is off by the rotation of its joint.
    fn turn(&self, ours: &DMat4, theirs: &DMat4) -> f64 {
        let axes = |matrix: &DMat4| [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec4::truncate);
        let off = axes(ours).into_iter().zip(axes(theirs)).map(|(ours, theirs)| {
            // What is flat has no direction.
            let ours = self.change.turn(ours.normalize_or_zero());
            ours.distance(theirs.normalize_or_zero()) * SKIN
        });
        off.fold(0.0, f64::max)
    }
}

/// The rotation of a matrix in double precision.
fn rotation_of(matrix: &DMat4) -> DQuat {
    matrix.to_scale_rotation_translation().1.normalize()
}

/// The distances of a comparison.
#[derive(Default)]
pub(super) struct Errors {
    pub(super) frames: usize,
    pub(super) max: f64,
    pub(super) turn: Option<f64>,
    pub(super) worst: Option<Worst>,
    sum_of_squares: f64,
    count: usize,
}

impl Errors {
    pub(super) fn add(&mut self, error: f64, place: impl FnOnce() -> Worst) {
        self.sum_of_squares += error * error;
        self.count += 1;
        if self.worst.is_none() || is_worse(error, self.max) {
            self.max = error;
            self.worst = Some(place());
        }
    }

    pub(super) fn add_turn(&mut self, error: f64) {
        if self.turn.is_none_or(|turn| is_worse(error, turn)) {
            self.turn = Some(error);
        }
    }

    pub(super) fn add_all(&mut self, other: &Self) {
        self.frames += other.frames;
        self.sum_of_squares += other.sum_of_squares;
        self.count += other.count;
        if self.worst.is_none() || is_worse(other.max, self.max) {
            self.max = other.max;
            self.worst.clone_from(&other.worst);
        }
        if let Some(turn) = other.turn {
            self.add_turn(turn);
        }
    }

    pub(super) fn rms(&self) -> f64 {
        (self.sum_of_squares / self.count.max(1) as f64).sqrt()
    }
}

/// A NaN is the worst of all, and stays it.
fn is_worse(error: f64, most: f64) -> bool {
    error > most || (error.is_nan() && !most.is_nan())
}

/// Of every joint the root above it: the highest node that is not a mere group.
pub(super) fn roots(skeleton: &Skeleton) -> Vec<usize> {
    let mut roots: Vec<usize> = Vec::with_capacity(skeleton.joints.len());
    for (index, joint) in skeleton.joints.iter().enumerate() {
        let is_below_root = |parent: &usize| skeleton.joints[*parent].kind != NodeKind::Group;
        roots.push(joint.parent.filter(is_below_root).map_or(index, |parent| roots[parent]));
    }
    roots
}
