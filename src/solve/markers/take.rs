//! The landmarks of a scene of markers, in metres.

use std::collections::HashMap;

use glam::{DMat3, DQuat, DVec3};

use super::landmarks::{self, Landmark};
use crate::error::{Code, Diagnostic, Result};
use crate::scene::{Animation, NodeId, NodeKind, Scene};

/// Where landmarks are, frame by frame.
#[derive(Clone, Debug)]
pub(super) struct Take {
    pub(super) frames: usize,
    pub(super) landmarks: Vec<Landmark>,
    /// The labels of the file.
    pub(super) labels: Vec<String>,
    /// Of each landmark, in metres; none where it was not seen.
    pub(super) tracks: Vec<Track>,
    by_name: HashMap<String, usize>,
    /// Labels that no set knows.
    pub(super) unknown: Vec<String>,
    /// The set of the labels.
    pub(super) set: Option<&'static str>,
    /// Whether the landmarks were guessed from distances, or why they could not be; none where labels tell them.
    pub(super) guess: Option<std::result::Result<(), &'static str>>,
    /// Metres in a unit of the scene.
    pub(super) metres: f64,
}

/// Where a marker is, frame by frame; none where it was not seen.
type Track = Vec<Option<DVec3>>;

/// With fewer labels that are known, they tell nothing.
const KNOWN: usize = 8;

/// The landmark of each label that a file of markers names.
pub(super) type Named = HashMap<String, Landmark>;

impl Take {
    /// The landmarks of a scene's first animation, by their labels; where those tell nothing and `may_guess`, by the
    /// distances that stay the same.
    pub(super) fn of_scene(scene: &Scene, named: &Named, may_guess: bool) -> Result<Self> {
        let Some(animation) = scene.animations.first() else {
            return Err(Diagnostic::new(Code::NoMotion, "there is no motion to solve").into());
        };
        let frames = animation.frame_count();
        let nodes = scene
            .nodes
            .iter()
            .enumerate()
            .filter(|(_, node)| node.kind != NodeKind::Group);
        let (labels, tracks): (Vec<String>, Vec<Track>) = nodes
            .map(|(index, node)| (node.name.clone(), track(animation, NodeId::new(index), frames)))
            .unzip();
        let known = landmarks::by_key();
        let keys = landmarks::keys(&labels, &known);
        let by_label = std::iter::zip(&labels, &keys)
            .map(|(label, key)| named.get(&landmarks::key(label)).or_else(|| known.get(key)).cloned());
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
            landmarks: Vec::new(),
            labels: Vec::new(),
            tracks: Vec::new(),
            by_name: HashMap::new(),
            unknown: Vec::new(),
            set: landmarks::set_name(&keys),
            guess,
            metres: 1.0,
        };
        for ((label, track), landmark) in labels.into_iter().zip(tracks).zip(by_label) {
            let Some(landmark) = landmark.filter(|landmark| !take.by_name.contains_key(&landmark.name)) else {
                take.unknown.push(label);
                continue;
            };
            take.by_name.insert(landmark.name.clone(), take.landmarks.len());
            take.landmarks.push(landmark);
            take.labels.push(label);
            take.tracks.push(track);
        }
        take.metres = scene.metadata.metres_per_unit.unwrap_or_else(|| take.guessed_unit());
        for point in take.tracks.iter_mut().flatten().flatten() {
            *point *= take.metres;
        }
        Ok(take)
    }

    /// Metres in a unit in which the front of a pelvis is between 15 and 45 cm wide.
    fn guessed_unit(&self) -> f64 {
        let width = (0..self.frames).find_map(|frame| Some(self.at("LASI", frame)?.distance(self.at("RASI", frame)?)));
        let is_width = |unit: &f64| (0.15..0.45).contains(&(width.unwrap_or(0.25) * unit));
        [1.0, 0.001, 0.01, 0.0254].into_iter().find(is_width).unwrap_or(1.0)
    }

    pub(super) fn at(&self, name: &str, frame: usize) -> Option<DVec3> {
        self.tracks[*self.by_name.get(name)?][frame]
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    /// Whether a landmark has this label, by its key.
    pub(super) fn has_label(&self, key: &str) -> bool {
        self.labels.iter().any(|label| landmarks::key(label) == key)
    }

    /// The frame in which the most landmarks are seen.
    fn fullest(&self) -> usize {
        let seen = |frame: &usize| self.tracks.iter().filter(|track| track[*frame].is_some()).count();
        (0..self.frames).rev().max_by_key(seen).unwrap_or(0)
    }

    /// The landmarks of these frames alone; those that are not seen are where they were on their bones in `standing`,
    /// by the others on the same bone.
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
                        carried(&pairs.collect::<Vec<_>>(), own)
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

    /// Leaves the landmarks after so many out.
    pub(super) fn keep_first(&mut self, count: usize) {
        self.landmarks.truncate(count);
        self.labels.truncate(count);
        self.tracks.truncate(count);
        self.by_name.retain(|_, index| *index < count);
    }

    /// Rotates all positions.
    pub(super) fn rotate(&mut self, rotation: impl Fn(DVec3) -> DVec3) {
        for point in self.tracks.iter_mut().flatten().flatten() {
            *point = rotation(*point);
        }
    }
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
        // A marker that never moves has one key, at the first frame.
        if let [only] = position_keys.values.as_slice()
            && position_keys.tick(0) == 0.0
        {
            track.fill(Some(only.as_dvec3()));
        }
    }
    track
}

/// Where a point of a rigid body is, of which three points or more are known before and now.
fn carried(pairs: &[(DVec3, DVec3)], point: DVec3) -> Option<DVec3> {
    if pairs.len() < 3 {
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
    Some(to + best_rotation(&sums) * (point - from))
}

/// The rotation that brings points nearest to others (B. Horn, J. Opt. Soc. Am. A 4, 1987), by iterating the largest
/// eigenvector of his matrix. `sums`: a column for each coordinate of the others, of sums of products with the points.
fn best_rotation(sums: &DMat3) -> DQuat {
    const ITERATIONS: usize = 200;
    let s = |row: usize, column: usize| sums.col(column)[row];
    let delta = DVec3::new(s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0));
    let trace = s(0, 0) + s(1, 1) + s(2, 2);
    // A shift makes the largest eigenvalue that of the largest size.
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
