//! The comparison of one clip at each time.

use std::collections::{HashMap, HashSet, VecDeque};

use glam::{DMat3, DMat4, DQuat, DVec3, DVec4};
use mocap_scene::error::Result;
use mocap_scene::scene::{NodeKind, Scene, UNNAMED_MOTION};

use super::chain::Skeleton;
use super::change::Change;
use super::pairs::{Pairs, Rigid, kept_of};
use super::timeline::Timeline;
use super::{Finding, FindingKind, LargestDeviation, Output};

/// The distance in metres from a joint to the points that show its rotation: about the distance of a person's skin.
pub(super) const SKIN: f64 = 0.03;

/// The distance [`SKIN`] in units of a skeleton. A skeleton smaller than a metre has a smaller distance, in proportion.
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

/// The clip of the file for every clip of the source, paired by name. The remaining clips are paired in their order if
/// both have equally many, or if the file's format has no clip names.
pub(super) fn pairs(source: &Scene, output: &Output<'_>) -> Vec<Option<usize>> {
    let ours = names_of(source);
    let theirs = output.clip_names();
    let mut pair_of = same_names(&ours, &theirs);
    let mut left = unpaired(&theirs, &pair_of);
    let count = pair_of.iter().filter(|pair| pair.is_none()).count();
    // If both have one clip, the clips are a pair, whatever their names.
    if count == left.len() || ours.len() == 1 || !output.row().names_clips {
        let unpaired = pair_of.iter_mut().filter(|pair| pair.is_none());
        for (pair, clip) in unpaired.zip(left.drain(..count.min(left.len()))) {
            *pair = Some(clip);
        }
    }
    pair_of
}

/// The clips to compare, and the findings about clips. A source without a clip is a skeleton at rest. A file is a
/// skeleton at rest if it has no clip, or one clip in which nothing moves.
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
            // If the file has no clip at all, the comparison also reports the missing frames.
            if !theirs.is_empty() {
                continue;
            }
        }
        // A clip without movement is a pose, and a file without a clip has a pose.
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

/// The clips of the file without a clip of the source.
fn unpaired(theirs: &[String], pair_of: &[Option<usize>]) -> Vec<usize> {
    let paired: HashSet<usize> = pair_of.iter().copied().flatten().collect();
    (0..theirs.len()).filter(|clip| !paired.contains(clip)).collect()
}

/// For every clip of the source, the clip of the file with its name.
fn same_names(ours: &[String], theirs: &[String]) -> Vec<Option<usize>> {
    // Some formats allow each name once, and number repeated names.
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

/// Whether a clip kept its name, apart from characters that some formats lack, or from an added number. An unnamed clip
/// may get any name.
fn is_kept(ours: &str, theirs: &str) -> bool {
    let (ours, theirs) = (kept_of(ours), kept_of(theirs));
    let number = theirs
        .strip_prefix(ours.as_str())
        .and_then(|rest| rest.strip_prefix('_'));
    let is_numbered = number.is_some_and(|number| number.parse::<u32>().is_ok());
    [theirs.as_str(), "", UNNAMED_MOTION].contains(&ours.as_str()) || is_numbered
}

/// Whether anything moves in a clip of the source, within the time range that the file should have.
fn moves(source: &Scene, clip: usize, change: &Change) -> Result<bool> {
    let timeline = Timeline::new(source, Some(clip), change)?;
    Ok(timeline.moves(&Skeleton::of_scene(source, Some(clip))))
}

/// The name of a source clip in a finding.
pub(super) fn name_of(source: &Scene, clip: usize) -> String {
    let name = &source.animations[clip].name;
    match (source.animations.len(), name.is_empty()) {
        (1, _) => "the motion".to_owned(),
        (_, false) => format!("clip \"{name}\""),
        (_, true) => format!("clip {clip}"),
    }
}

/// Data that all clips share.
#[derive(Clone)]
pub(super) struct ComparisonBasis<'a> {
    pub(super) pairs: &'a Pairs,
    pub(super) change: &'a Change,
    /// Metres per unit of the file.
    pub(super) metres: f64,
    /// The distance in metres from a joint to the points that show its rotation.
    pub(super) skin: f64,
    /// Whether the times of the file are 32-bit seconds.
    pub(super) has_short_times: bool,
    /// Whether the file is a packed clip. Its error bound holds for positions, and for rotations that move no joint.
    pub(super) is_packed: bool,
    /// Whether joints have the same axes in the source and in the file.
    pub(super) rotations: bool,
    /// If joints have other axes on purpose, the rotation of the axes for each joint of the source; none if unknown.
    pub(super) new_axes: Option<Vec<Option<DQuat>>>,
}

/// Data that all times of a clip share.
struct JointsOfClip<'a> {
    ours: &'a Skeleton<'a>,
    /// The joint whose path over the ground carries each joint.
    carriers: Vec<Option<usize>>,
    /// The comparable data of each pair in a VRM animation.
    rigid: Option<Rigid>,
    /// Which joints move no other joint.
    ends: Vec<bool>,
    /// For a motion in place, the moment that determines its place on the ground.
    place: Option<Moment>,
}

impl ComparisonBasis<'_> {
    /// The rotation of each joint's axes in the scene after all steps, at the first time. The rotation is the same at
    /// all times.
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

    /// Compares the source with the file at these ticks of the source.
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
        // Only between two frames do stepped keys differ from linear keys.
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

    /// The position error of a pair in metres, in the axes of the file; `None` if the file does not have the position.
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

    /// The distance in metres by which a wrong rotation of a joint moves the skin around the joint. `None` if the file
    /// does not have the rotation.
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
        // In glTF, the time of this frame is rounded. Just before the rounded time, a cut has another pose.
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

    /// The error in metres of a point on the skin, from the rotation of its joint since the first frame. The first
    /// frame replaces the rest poses, which may differ.
    fn skin_error_since(&self, first: (&DMat4, &DMat4), now: (&DMat4, &DMat4)) -> f64 {
        let since = |first: &DMat4, now: &DMat4| rotation_of(now) * rotation_of(first).inverse();
        let (ours, theirs) = (since(first.0, now.0), since(first.1, now.1));
        let points = DVec3::AXES
            .into_iter()
            .map(|axis| (theirs * self.change.turn(axis)).distance(self.change.turn(ours * axis)) * self.skin);
        points.fold(0.0, worse)
    }

    /// The error in metres of a point on the skin, from the rotation of its joint and the position error `off`.
    fn skin_error(&self, ours: &DMat4, theirs: &DMat4, off: DVec3) -> f64 {
        let axes = |matrix: &DMat4| [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec4::truncate);
        // An axis scaled to zero has no direction.
        let both = axes(ours).into_iter().zip(axes(theirs));
        let points = both.filter(|(ours, _)| *ours != DVec3::ZERO).map(|(ours, theirs)| {
            let ours = self.change.turn(ours.normalize_or_zero());
            (theirs.normalize_or_zero() - ours) * self.skin
        });
        points.map(|point| (off + point).length()).fold(0.0, worse)
    }
}

/// Both skeletons at one time of the file: the node-to-world matrix of each joint, and the positions of the source's
/// joints converted to the file.
#[derive(Clone)]
struct Moment {
    seconds: f64,
    here: Vec<DMat4>,
    there: Vec<DMat4>,
    positions: Vec<DVec3>,
}

/// Whether a matrix is a rotation with nonzero scales: not mirrored, flat or sheared.
fn is_rotation(matrix: &DMat4) -> bool {
    /// The largest cosine of the angle between perpendicular axes: the rounding of single precision.
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

    /// The largest error in metres.
    pub(super) fn farthest(&self) -> f64 {
        worse(self.max, self.rotation.unwrap_or(0.0))
    }

    pub(super) fn rms(&self) -> f64 {
        (self.sum_of_squares / self.count.max(1) as f64).sqrt()
    }
}

/// The greater of two errors. NaN is the greatest.
pub(super) fn worse(a: f64, b: f64) -> f64 {
    if is_worse(b, a) { b } else { a }
}

/// NaN is the worst error, and stays the worst.
fn is_worse(error: f64, most: f64) -> bool {
    error > most || (error.is_nan() && !most.is_nan())
}
