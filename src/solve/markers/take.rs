//! The landmarks of a scene of markers, in metres.

use std::collections::{HashMap, HashSet};

use glam::{DAffine3, DMat3, DQuat, DVec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{FrameBudget, Limits};
use mocap_scene::math::median::median;
use mocap_scene::scene::{Animation, HumanoidBone as Bone, NodeId, NodeKind, Scene, Side};

use super::landmarks::{self, KNOWN, Labels, Landmark};
use super::subjects;
use crate::set::JointSet;

/// The positions of landmarks, frame by frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Take {
    pub(super) frames: usize,
    pub(super) landmarks: Vec<Landmark>,
    /// The labels of the file.
    pub(super) labels: Vec<String>,
    /// The positions of each landmark, in metres; `None` if it was not seen.
    pub(super) tracks: Vec<Track>,
    by_name: HashMap<String, usize>,
    /// Labels that are in no known set.
    pub(super) unknown: Vec<String>,
    /// Labels of landmarks that are seen in no frame.
    pub(super) never_seen: Vec<String>,
    /// Labels of landmarks on segments whose joints cannot be found.
    pub(super) unattached: Vec<String>,
    /// The subject of the landmarks, if the file has several subjects. `others` has the labels of the other subjects.
    pub(super) subject: Option<String>,
    pub(super) others: Vec<String>,
    /// The marker set of the labels.
    pub(super) set: Option<&'static str>,
    /// Whether the landmarks were guessed from distances, or why that failed. `None` if the labels are known.
    pub(super) guess: Option<std::result::Result<(), &'static str>>,
    /// Metres per unit of the scene.
    pub(super) metres: f64,
    /// If no pelvis has the width that the stated unit gives: the width of the front of the pelvis in units of the
    /// file, and the stated metres per unit.
    pub(super) misstated: Option<(f64, f64)>,
}

/// The positions of a marker, frame by frame; `None` if it was not seen.
pub type Track = Vec<Option<DVec3>>;

/// The width of the front of a pelvis, in metres, from the smallest child to the widest character.
const PELVIS: std::ops::Range<f64> = 0.05..1.0;

impl Take {
    /// The landmarks of a scene's first animation, by their labels. If the labels are unknown and `may_guess` is set,
    /// landmarks are guessed from constant distances.
    pub(super) fn of_scene(scene: &Scene, asked: &Labels, may_guess: bool) -> Result<Self> {
        let Some(animation) = scene.animations.first() else {
            return Err(Diagnostic::new(Code::NoMotion, "there is no motion to solve").into());
        };
        let mut budget = FrameBudget::of_scene(&Limits::default());
        let frames = budget.frames(animation.duration.round(), scene.nodes.len())?;
        let is_marker = |index: &usize| scene.nodes[*index].kind != NodeKind::Group;
        let nodes: Vec<usize> = (0..scene.nodes.len()).filter(is_marker).collect();
        let label = |index: &usize| scene.nodes[*index].name.clone();
        let all: Vec<String> = nodes.iter().map(label).collect();
        let known = landmarks::by_key();
        let subject = subjects::chosen(&all, asked, &known)?;
        let is_own = |index: &usize| subjects::is_of(&scene.nodes[*index].name, subject);
        let (nodes, others): (Vec<usize>, Vec<usize>) = nodes.into_iter().partition(is_own);
        let labels: Vec<String> = nodes.iter().map(label).collect();
        let tracks: Vec<Track> = (nodes.iter())
            .map(|index| track(animation, NodeId::new(*index), frames))
            .collect();
        let keys = landmarks::keys(&labels, &known);
        let with_keys = std::iter::zip(&labels, &keys);
        let axes: HashSet<String> = with_keys
            .clone()
            .filter(|(_, key)| landmarks::is_axis(key, &keys))
            .map(|(label, _)| label.clone())
            .collect();
        let by_label = with_keys.map(|(label, key)| {
            let by_name = || known.get(key).filter(|_| !axes.contains(label));
            asked.landmark(label).or_else(by_name).cloned()
        });
        let mut by_label: Vec<Option<Landmark>> = by_label.collect();
        let mut guess = None;
        if may_guess && by_label.iter().flatten().count() < KNOWN {
            match super::guess::landmarks(&tracks) {
                Ok(found) => {
                    by_label = found;
                    guess = Some(Ok(()));
                }
                Err(why) => guess = Some(Err(why)),
            }
        }
        let mut take = Self {
            frames,
            set: landmarks::set_name(&keys),
            guess,
            metres: 1.0,
            subject: subject.filter(|_| !others.is_empty()).map(str::to_owned),
            others: others.iter().map(label).collect(),
            ..Self::default()
        };
        take.name(labels.into_iter().zip(tracks).zip(by_label));
        take.unknown.retain(|label| !axes.contains(label));
        take.in_metres(scene.metadata.metres_per_unit);
        Ok(take)
    }

    /// Adds the markers that are landmarks. If two markers are the same landmark, adds only the first.
    fn name(&mut self, markers: impl Iterator<Item = ((String, Track), Option<Landmark>)>) {
        for ((label, track), landmark) in markers {
            let Some(landmark) = landmark.filter(|landmark| !self.by_name.contains_key(&landmark.name)) else {
                self.unknown.push(label);
                continue;
            };
            if track.iter().all(Option::is_none) {
                self.never_seen.push(label);
                continue;
            }
            self.by_name.insert(landmark.name.clone(), self.landmarks.len());
            self.landmarks.push(landmark);
            self.labels.push(label);
            self.tracks.push(track);
        }
    }

    /// Converts positions to metres. A stated unit is not used if no pelvis has the width that it would give.
    fn in_metres(&mut self, stated: Option<f64>) {
        let width = self.width_of_pelvis();
        let is_width = |unit: &f64| width.is_none_or(|width| PELVIS.contains(&(width * unit)));
        let plausible = stated.filter(is_width).or_else(|| guessed_unit(width));
        self.metres = plausible.or(stated).unwrap_or(1.0);
        self.misstated = width.zip(stated.filter(|stated| *stated != self.metres));
        for point in self.tracks.iter_mut().flatten().flatten() {
            *point *= self.metres;
        }
    }

    /// The median width of the front of the pelvis, in units of the scene.
    fn width_of_pelvis(&self) -> Option<f64> {
        let width = |frame: usize| Some(self.at("LASI", frame)?.distance(self.at("RASI", frame)?));
        let mut widths: Vec<f64> = (0..self.frames).filter_map(width).collect();
        (!widths.is_empty()).then(|| median(&mut widths).unwrap_or_default())
    }

    /// The index of a landmark.
    pub(super) fn index(&self, name: &str) -> Option<usize> {
        self.by_name.get(name).copied()
    }

    pub(super) fn at(&self, name: &str, frame: usize) -> Option<DVec3> {
        self.tracks[self.index(name)?][frame]
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    /// Whether a landmark has this label, by its key.
    pub(super) fn has_label(&self, key: &str) -> bool {
        let is_its = |label: &String| landmarks::whole_key(label) == key || landmarks::key(label) == key;
        self.labels.iter().chain(&self.never_seen).any(is_its)
    }

    /// The frame in which the most landmarks are seen.
    pub(super) fn fullest(&self) -> usize {
        let seen = |frame: &usize| self.tracks.iter().filter(|track| track[*frame].is_some()).count();
        (0..self.frames).rev().max_by_key(seen).unwrap_or(0)
    }

    /// The landmarks of these frames only. A missing landmark is placed from the other landmarks of its bone, as they
    /// are in `standing`.
    pub(super) fn filled(&self, frames: &[usize], standing: Option<&Self>) -> Self {
        let mut take = Self {
            frames: frames.len(),
            tracks: (self.tracks.iter())
                .map(|track| frames.iter().map(|frame| track[*frame]).collect())
                .collect(),
            ..self.clone()
        };
        let Some(standing) = standing else { return take };
        let still = standing.fullest();
        for (index, landmark) in standing.landmarks.iter().enumerate() {
            let Some(own) = standing.tracks[index][still] else {
                continue;
            };
            let mates: Vec<(DVec3, &str)> = standing
                .landmarks
                .iter()
                .zip(&standing.tracks)
                .filter(|(other, _)| other.bone == landmark.bone && other.name != landmark.name)
                .filter_map(|(other, track)| Some((track[still]?, other.name.as_str())))
                .collect();
            let track: Vec<Option<DVec3>> = (0..frames.len())
                .map(|frame| {
                    let seen = self.at(&landmark.name, frames[frame]);
                    seen.or_else(|| {
                        let pairs = mates
                            .iter()
                            .filter_map(|(from, name)| Some((*from, self.at(name, frames[frame])?)));
                        Some(rigid(&pairs.collect::<Vec<_>>(), 3)?.transform_point3(own))
                    })
                })
                .collect();
            match take.by_name.get(&landmark.name) {
                Some(&known) => take.tracks[known] = track,
                None => {
                    take.by_name.insert(landmark.name.clone(), take.landmarks.len());
                    take.landmarks.push(landmark.clone());
                    take.labels.push(standing.labels[index].clone());
                    take.tracks.push(track);
                }
            }
        }
        take
    }

    /// Adds a landmark to a take of one frame.
    pub(super) fn add(&mut self, name: &str, position: DVec3) {
        if let Some(landmark) = landmarks::named(name) {
            self.name(std::iter::once((
                (name.to_owned(), vec![Some(position)]),
                Some(landmark),
            )));
        }
    }

    /// Keeps the first `count` landmarks.
    pub(super) fn keep_first(&mut self, count: usize) {
        self.landmarks.truncate(count);
        self.labels.truncate(count);
        self.tracks.truncate(count);
        self.by_name.retain(|_, index| *index < count);
    }

    /// Removes the landmarks that `set` cannot attach. Otherwise markers of a forearm would move with the trunk if the
    /// elbow is not seen.
    pub(super) fn detach(&mut self, set: &JointSet) {
        let is_attached = |landmark: &Landmark| {
            let follows_parent = matches!(landmark.bone.on(Side::Left), Bone::Spine | Bone::LeftToes);
            follows_parent || set.joint(landmark.bone).is_some()
        };
        for index in (0..self.landmarks.len()).rev() {
            if !is_attached(&self.landmarks[index]) {
                self.landmarks.remove(index);
                self.tracks.remove(index);
                self.unattached.insert(0, self.labels.remove(index));
            }
        }
        let names = self.landmarks.iter().enumerate();
        self.by_name = names.map(|(index, landmark)| (landmark.name.clone(), index)).collect();
    }

    /// Rotates all positions.
    pub(super) fn rotate(&mut self, rotation: impl Fn(DVec3) -> DVec3) {
        for point in self.tracks.iter_mut().flatten().flatten() {
            *point = rotation(*point);
        }
    }
}

/// The metres per unit with which this width of the front of a pelvis is between 15 and 45 cm.
fn guessed_unit(width: Option<f64>) -> Option<f64> {
    let is_width = |unit: &f64| (0.15..0.45).contains(&(width.unwrap_or(0.25) * unit));
    [1.0, 0.001, 0.01, 0.0254].into_iter().find(is_width)
}

/// The positions of a node, frame by frame.
fn track(animation: &Animation, node: NodeId, frames: usize) -> Track {
    let mut track = vec![None; frames];
    let channel = animation.channels.iter().find(|channel| channel.node == Some(node));
    if let Some(position_keys) = channel.map(|channel| &channel.position_keys) {
        for (key, position) in position_keys.values.iter().enumerate() {
            if let Some(seen) = track.get_mut(position_keys.tick(key).max(0.0) as usize) {
                *seen = Some(position.as_dvec3());
            }
        }
        // A marker that never moves has one key, without a tick.
        if let ([only], None) = (position_keys.values.as_slice(), &position_keys.ticks) {
            track.fill(Some(only.as_dvec3()));
        }
    }
    track
}

/// The motion of a rigid body from positions of points before and now. `None` with fewer than `least` points.
pub(super) fn rigid(pairs: &[(DVec3, DVec3)], least: usize) -> Option<DAffine3> {
    if pairs.len() < least {
        return None;
    }
    let count = pairs.len() as f64;
    let from = pairs.iter().map(|pair| pair.0).sum::<DVec3>() / count;
    let to = pairs.iter().map(|pair| pair.1).sum::<DVec3>() / count;
    let mut sums = DMat3::ZERO;
    for (a, b) in pairs {
        let (a, b) = (*a - from, *b - to);
        sums += DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    }
    let rotation = best_rotation(&sums);
    Some(DAffine3::from_rotation_translation(rotation, to - rotation * from))
}

/// The rotation that brings points nearest to other points (B. Horn, J. Opt. Soc. Am. A 4, 1987), by power iteration
/// for the largest eigenvector of Horn's matrix. `sums` has the sums of the products of coordinates. A column belongs
/// to a coordinate of the points to be reached.
fn best_rotation(sums: &DMat3) -> DQuat {
    /// The number of iterations of the power method, which bounds the time. Each multiplies the error by the ratio of
    /// the two largest eigenvalues.
    const ITERATIONS: usize = 200;
    let s = |row: usize, column: usize| sums.col(column)[row];
    let delta = DVec3::new(s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0));
    let trace = s(0, 0) + s(1, 1) + s(2, 2);
    // The shift makes all eigenvalues positive, so the largest one also has the largest absolute value.
    let shift = 2.0 * (0..9).map(|cell| s(cell / 3, cell % 3).abs()).sum::<f64>();
    let apply = |q: DQuat| {
        let v = q.xyz();
        let w = trace * q.w + delta.dot(v);
        let symmetric = (0..3).map(|row| {
            (0..3)
                .map(|column| (s(row, column) + s(column, row)) * v[column])
                .sum::<f64>()
        });
        let rows: Vec<f64> = symmetric.collect();
        let vector = delta * q.w + DVec3::new(rows[0], rows[1], rows[2]) - v * trace;
        DQuat::from_xyzw(
            vector.x + shift * v.x,
            vector.y + shift * v.y,
            vector.z + shift * v.z,
            w + shift * q.w,
        )
    };
    let mut rotation = DQuat::from_xyzw(0.1, 0.2, 0.3, 0.9).normalize();
    for _ in 0..ITERATIONS {
        let next = apply(rotation);
        if next.length() < f64::MIN_POSITIVE {
            break;
        }
        rotation = next.normalize();
    }
    rotation
}
