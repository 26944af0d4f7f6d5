//! The comparison of one clip, moment by moment.

use std::collections::{HashMap, HashSet, VecDeque};

use glam::{DMat3, DMat4, DQuat, DVec3, DVec4};
use mocap_scene::error::Result;
use mocap_scene::scene::{NodeKind, Scene, UNNAMED_MOTION};

use super::chain::Skeleton;
use super::change::Change;
use super::pairs::{Pairs, Rigid, kept_of};
use super::timeline::Timeline;
use super::{Finding, FindingKind, LargestDeviation, Output};

/// How far from a joint the points are that show its rotation, in metres: about as far as the skin of a person around
/// it.
pub(super) const SKIN: f64 = 0.03;

/// The same for a skeleton, whose unit has so many metres: less around one that is smaller than a metre.
pub(super) fn skin_of(skeleton: &Skeleton, metres: f64) -> f64 {
    let mut world = Vec::new();
    skeleton.world(0.0, &mut world);
    let places = || world.iter().map(|matrix| matrix.w_axis.truncate());
    let (low, high) = (places().reduce(DVec3::min), places().reduce(DVec3::max));
    let size = low.zip(high).map_or(0.0, |(low, high)| low.distance(high)) * metres;
    match size > 0.0 {
        true => SKIN * size.min(1.0),
        false => SKIN,
    }
}

/// The clip of the file for every clip of the source, by its name. The others are paired in their order, if as many
/// remain in both, or if the format of the file has no names of clips.
pub(super) fn pairs(source: &Scene, output: &Output<'_>) -> Vec<Option<usize>> {
    let ours = names_of(source);
    let theirs = output.clip_names();
    let mut pair_of = same_names(&ours, &theirs);
    let mut left = unpaired(&theirs, &pair_of);
    let count = pair_of.iter().filter(|pair| pair.is_none()).count();
    // One clip of a file that has one is that of a source that has one, whatever their names.
    if count == left.len() || ours.len() == 1 || !output.row().names_clips {
        let unpaired = pair_of.iter_mut().filter(|pair| pair.is_none());
        for (pair, clip) in unpaired.zip(left.drain(..count.min(left.len()))) {
            *pair = Some(clip);
        }
    }
    pair_of
}

/// Which clips are compared, with what is wrong beside that. A source without a clip is a skeleton at rest, and so is a
/// file without one, or with one in which nothing moves.
pub(super) fn matched(
    source: &Scene,
    output: &Output<'_>,
    change: &Change,
    findings: &mut Vec<Finding>,
) -> Result<Vec<(Option<usize>, Option<usize>)>> {
    let ours = names_of(source);
    let theirs = output.clip_names();
    let pair_of = self::pairs(source, output);
    let mut left = unpaired(&theirs, &pair_of);
    let is_first_of_several = output.row().has_one_clip && pair_of.first().is_some_and(Option::is_some);
    let mut pairs = Vec::new();
    for (clip, &pair) in pair_of.iter().enumerate() {
        if pair.is_none() && is_first_of_several {
            continue;
        }
        if pair.is_none() && moves(source, clip, change)? {
            let message = format!("{} is not in the file", name_of(source, clip));
            findings.push(Finding::new(FindingKind::MissingClip, message));
            // Its frames are missing, too, if the file has no other clip.
            if !theirs.is_empty() {
                continue;
            }
        }
        // A clip in which nothing moves is a pose, and a file without a clip has one.
        pairs.push((Some(clip), pair));
        let renamed =
            pair.filter(|pair| output.is_ours() && output.row().names_clips && !is_kept(&ours[clip], &theirs[*pair]));
        if let Some(pair) = renamed {
            let message = format!("{} is called \"{}\" in the file", name_of(source, clip), theirs[pair]);
            findings.push(Finding::new(FindingKind::RenamedClip, message));
        }
    }
    if let ([], [only]) = (ours.as_slice(), left.as_slice())
        && output
            .skeleton(Some(*only))?
            .span(f64::NEG_INFINITY, f64::INFINITY)
            .is_none()
    {
        pairs.push((None, left.pop()));
    }
    for clip in left.into_iter().filter(|_| !output.keeps_other_clips()) {
        let message = match theirs[clip].is_empty() {
            true => format!("clip {clip} of the file is not in the source"),
            false => format!("clip \"{}\" of the file is not in the source", theirs[clip]),
        };
        findings.push(Finding::new(FindingKind::ExtraClip, message));
    }
    if pairs.is_empty() {
        pairs.push((None, None));
    }
    Ok(pairs)
}

fn names_of(source: &Scene) -> Vec<String> {
    source.animations.iter().map(|clip| clip.name.clone()).collect()
}

/// The clips of the file that are those of no clip of the source.
fn unpaired(theirs: &[String], pair_of: &[Option<usize>]) -> Vec<usize> {
    let paired: HashSet<usize> = pair_of.iter().copied().flatten().collect();
    (0..theirs.len()).filter(|clip| !paired.contains(clip)).collect()
}

/// For every clip of the source, the clip of the file with its name.
fn same_names(ours: &[String], theirs: &[String]) -> Vec<Option<usize>> {
    // Some formats have each name once, and number the others.
    if ours.len() == theirs.len() && ours.iter().zip(theirs).all(|(ours, theirs)| is_kept(ours, theirs)) {
        return (0..ours.len()).map(Some).collect();
    }
    let mut of_name: HashMap<String, VecDeque<usize>> = HashMap::new();
    for (clip, name) in theirs.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
        of_name.entry(kept_of(name)).or_default().push_back(clip);
    }
    let pairs = ours.iter().map(|name| of_name.get_mut(&kept_of(name))?.pop_front());
    pairs.collect()
}

/// Whether a clip has the name of that of the source, as far as every format can have it, or that name with a number
/// behind it. One without a name may have any, and so one whose format has none.
fn is_kept(ours: &str, theirs: &str) -> bool {
    let (ours, theirs) = (kept_of(ours), kept_of(theirs));
    let number = theirs
        .strip_prefix(ours.as_str())
        .and_then(|rest| rest.strip_prefix('_'));
    let is_numbered = number.is_some_and(|number| number.parse::<u32>().is_ok());
    [theirs.as_str(), "", UNNAMED_MOTION].contains(&ours.as_str()) || is_numbered
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
#[derive(Clone)]
pub(super) struct ComparisonBasis<'a> {
    pub(super) pairs: &'a Pairs,
    pub(super) change: &'a Change,
    /// Metres in a unit of the file.
    pub(super) metres: f64,
    /// How far from a joint the points are that show its rotation, in metres.
    pub(super) skin: f64,
    /// Whether the times of the file are 32-bit seconds.
    pub(super) has_short_times: bool,
    /// Whether the file is a packed clip, whose bound holds for positions: of rotations it holds for those that move no
    /// joint.
    pub(super) is_packed: bool,
    /// Whether a joint has the same axes in both.
    pub(super) rotations: bool,
    /// Where it has others on purpose, the rotation of its axes, of each joint of the source; none where that is not
    /// known.
    pub(super) new_axes: Option<Vec<Option<DQuat>>>,
}

/// What is the same at all moments of a clip.
struct JointsOfClip<'a> {
    ours: &'a Skeleton<'a>,
    /// The joint whose path over the ground carries each joint.
    carriers: Vec<Option<usize>>,
    /// What a VRM animation has of each pair.
    rigid: Option<Rigid>,
    /// Which joints move no other.
    ends: Vec<bool>,
    /// Where the motion is put in place, the moment that says where.
    place: Option<Moment>,
}

impl ComparisonBasis<'_> {
    /// How the axes of each joint are rotated in the scene to which all steps were done, in the first moment. It is the
    /// same rotation at all times.
    pub(super) fn axes_of(
        &self,
        replayed: &Scene,
        (clip, ours): (Option<usize>, &Skeleton),
        timeline: &Timeline,
    ) -> Option<Vec<Option<DQuat>>> {
        let clip = clip.map(|clip| clip.min(replayed.animations.len().saturating_sub(1)));
        let theirs = Skeleton::of_scene(replayed, clip);
        let pairs = Pairs::new(ours, &theirs).ok()?;
        let first = timeline.moments.first()?;
        let (mut here, mut there) = (Vec::new(), Vec::new());
        ours.world(timeline.shown(*first) / timeline.rate, &mut here);
        theirs.world(0.0, &mut there);
        let mut axes = vec![None; here.len()];
        for (a, b) in pairs
            .list
            .into_iter()
            .filter(|(a, b)| is_rotation(&here[*a]) && is_rotation(&there[*b]))
        {
            let turned = |axis: DVec3| self.change.turn(rotation_of(&here[a]) * axis);
            let expected = DQuat::from_mat3(&DMat3::from_cols(turned(DVec3::X), turned(DVec3::Y), turned(DVec3::Z)));
            axes[a] = Some(expected.inverse() * rotation_of(&there[b]));
        }
        Some(axes)
    }

    /// Compares at these ticks of the source.
    pub(super) fn frames(
        &self,
        clip: Option<usize>,
        ours: &Skeleton,
        theirs: &Skeleton,
        timeline: &Timeline,
        ticks: &[f64],
    ) -> Errors {
        let joints = JointsOfClip {
            ours,
            carriers: ours.carriers(),
            rigid: self.change.humanoid.map(|_| self.pairs.rigid(ours, theirs)),
            ends: ours.turning_ends(),
            place: (self.change.in_place).map(|_| self.moment(timeline.place, ours, theirs, timeline)),
        };
        let mut first: Option<Moment> = None;
        let mut errors = Errors {
            rotation: Some(0.0),
            ..Errors::default()
        };
        // Steps are seen between frames alone.
        let between = theirs.stepped.as_ref().map_or(&[][..], |_| &[0.5]);
        let mut keys = timeline.between(theirs).into_iter().peekable();
        for (index, &frame) in ticks.iter().enumerate() {
            let next = ticks.get(index + 1).copied();
            let after = between
                .iter()
                .filter_map(|fraction| Some(frame + fraction * (next? - frame)));
            let until_next = std::iter::from_fn(|| keys.next_if(|key| next.is_some_and(|next| *key < next)));
            for tick in std::iter::once(frame).chain(after).chain(until_next) {
                let now = self.moment(tick, ours, theirs, timeline);
                let first = first.get_or_insert_with(|| now.clone());
                for pair in 0..self.pairs.list.len() {
                    let off = self.position_error(&joints, pair, &now);
                    if let Some(off) = off {
                        errors.add(off.length(), || LargestDeviation {
                            clip: clip.unwrap_or(0),
                            joint: ours.joints[self.pairs.list[pair].0].name.clone(),
                            frame: tick as usize,
                            seconds: now.seconds,
                        });
                    }
                    let rotation = self.rotation_error(&joints, pair, (first, &now), off.unwrap_or(DVec3::ZERO));
                    rotation.into_iter().for_each(|error| errors.add_rotation(error));
                }
            }
            errors.frames += 1;
        }
        errors
    }

    /// How far the joint of a pair is off, in metres, along the axes of the file; `None` where the file does not have
    /// its position.
    fn position_error(&self, joints: &JointsOfClip<'_>, pair: usize, now: &Moment) -> Option<DVec3> {
        let (a, b) = self.pairs.list[pair];
        if joints.rigid.as_ref().is_some_and(|rigid| !rigid.has_position[pair]) {
            return None;
        }
        let mut expected = now.positions[a];
        if let (Some(place), Some(carrier)) = (&joints.place, joints.carriers[a]) {
            expected -= self
                .change
                .over_ground(now.positions[carrier] - place.positions[carrier]);
        }
        Some((now.there[b].w_axis.truncate() - expected) * self.metres)
    }

    /// How far the skin of a joint is off by its rotation, in metres, where the file has that.
    fn rotation_error(
        &self,
        joints: &JointsOfClip<'_>,
        pair: usize,
        (first, now): (&Moment, &Moment),
        off: DVec3,
    ) -> Option<f64> {
        let (a, b) = self.pairs.list[pair];
        let ((here, there), then) = ((&now.here[a], &now.there[b]), (&first.here[a], &first.there[b]));
        let since = || self.skin_error_since(then, (here, there));
        if let Some(rigid) = &joints.rigid {
            return rigid.has_rotation[pair].then(since);
        }
        if self.is_packed && !joints.ends[a] {
            return None;
        }
        let off = if joints.ends[a] { off } else { DVec3::ZERO };
        if self.rotations {
            return Some(self.skin_error(here, there, off));
        }
        let is_joint = joints.ours.joints[a].kind != NodeKind::EndSite;
        if !is_joint || ![here, there, then.0, then.1].into_iter().all(is_rotation) {
            return None;
        }
        let axes = self.new_axes.as_ref().and_then(|axes| axes[a]);
        let turned = axes.map(|axes| self.skin_error(&(*here * DMat4::from_quat(axes)), there, off));
        Some(turned.map_or_else(since, |turned| since().min(turned)))
    }

    /// Both skeletons at a tick of the source.
    fn moment(&self, tick: f64, ours: &Skeleton, theirs: &Skeleton, timeline: &Timeline) -> Moment {
        let seconds = timeline.seconds(tick);
        let (mut here, mut there) = (Vec::new(), Vec::new());
        ours.world(timeline.shown(tick) / timeline.rate, &mut here);
        // The moment that glTF has for this frame. Just before it a cut is another pose.
        let rounded = if self.has_short_times {
            f64::from(seconds as f32)
        } else {
            seconds
        };
        theirs.world(rounded, &mut there);
        let positions = here.iter().map(|matrix| self.change.apply(matrix.w_axis.truncate()));
        Moment {
            seconds,
            positions: positions.collect(),
            here,
            there,
        }
    }

    /// How far a point on the skin is off by the rotation of its joint since the first frame. The joints may stand
    /// otherwise at rest.
    fn skin_error_since(&self, first: (&DMat4, &DMat4), now: (&DMat4, &DMat4)) -> f64 {
        let since = |first: &DMat4, now: &DMat4| rotation_of(now) * rotation_of(first).inverse();
        let (ours, theirs) = (since(first.0, now.0), since(first.1, now.1));
        let points = DVec3::AXES
            .into_iter()
            .map(|axis| (theirs * self.change.turn(axis)).distance(self.change.turn(ours * axis)) * self.skin);
        points.fold(0.0, worse)
    }

    /// How far a point on the skin is off by the rotation of its joint, and by how far the joint is `off`, in metres.
    fn skin_error(&self, ours: &DMat4, theirs: &DMat4, off: DVec3) -> f64 {
        let axes = |matrix: &DMat4| [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec4::truncate);
        // What is flat has no direction.
        let both = axes(ours).into_iter().zip(axes(theirs));
        let points = both.filter(|(ours, _)| *ours != DVec3::ZERO).map(|(ours, theirs)| {
            let ours = self.change.turn(ours.normalize_or_zero());
            (theirs.normalize_or_zero() - ours) * self.skin
        });
        points.map(|point| (off + point).length()).fold(0.0, worse)
    }
}

/// Both skeletons at one moment: node to world of each joint, and the positions that those of the source have in the
/// file, after `seconds` of it.
#[derive(Clone)]
struct Moment {
    seconds: f64,
    here: Vec<DMat4>,
    there: Vec<DMat4>,
    positions: Vec<DVec3>,
}

/// Whether the axes of a matrix are those of a rotation, each with a length: none is mirrored, flat or sheared.
fn is_rotation(matrix: &DMat4) -> bool {
    /// The cosine of the angle between two axes below which they are at right angles: rounding of single precision.
    const SQUARE: f64 = 1e-3;
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate().normalize_or_zero());
    (x.cross(y).dot(z) - 1.0).abs() < SQUARE
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
    pub(super) rotation: Option<f64>,
    pub(super) worst: Option<LargestDeviation>,
    sum_of_squares: f64,
    count: usize,
}

impl Errors {
    pub(super) fn add(&mut self, error: f64, worst: impl FnOnce() -> LargestDeviation) {
        self.sum_of_squares += error * error;
        self.count += 1;
        if self.worst.is_none() || is_worse(error, self.max) {
            self.max = error;
            self.worst = Some(worst());
        }
    }

    pub(super) fn add_rotation(&mut self, error: f64) {
        if self.rotation.is_none_or(|largest| is_worse(error, largest)) {
            self.rotation = Some(error);
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
        if let Some(rotation) = other.rotation {
            self.add_rotation(rotation);
        }
    }

    /// The farthest that anything is off, in metres.
    pub(super) fn farthest(&self) -> f64 {
        worse(self.max, self.rotation.unwrap_or(0.0))
    }

    pub(super) fn rms(&self) -> f64 {
        (self.sum_of_squares / self.count.max(1) as f64).sqrt()
    }
}

/// The greater of two errors; a NaN stays.
pub(super) fn worse(a: f64, b: f64) -> f64 {
    if is_worse(b, a) { b } else { a }
}

/// A NaN is the worst of all, and stays it.
fn is_worse(error: f64, most: f64) -> bool {
    error > most || (error.is_nan() && !most.is_nan())
}
