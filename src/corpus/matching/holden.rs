//! The two files that the controller of Holden's motion matching demonstration (orangeduck/Motion-Matching) reads:
//! `database.bin` and `features.bin`. All numbers are little-endian.
//!
//! `database.bin` has these arrays. The counts of rows and columns come before each array:
//!
//! - positions, velocities, rotations (w, x, y, z) and angular velocities of the bones in every frame, relative to
//!   their parents
//! - the parents of the bones, -1 for the first
//! - the first and the last frame of each clip
//! - the contacts of the left and the right foot
//!
//! Bone 0 is the root, on the ground below the hips. Bone 1 is the hips. `features.bin` has the normalized features of
//! the frames, and the offsets and divisors that normalized them.
//!
//! The package `mocap-formats` does not know databases, so this module writes the files.

use glam::{Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::quaternion::{in_hemisphere_of, log};
use mocap_scene::scene::{NodeId, NodeKind};

use super::features::{AHEAD, FEATURE_RATE, FEATURES, set_ahead};
use super::moves::Moves;
use super::tree::statistics;

/// The largest relative difference between the scales of a bone along its axes that counts as rounding.
const UNIFORM: f32 = 1e-3;
/// The contact bits of the left and the right ball.
const BALLS: [u8; 2] = [4, 8];
const ANKLES: [u8; 2] = [1, 2];

/// One bone in all frames, relative to its parent.
#[derive(Clone, Default)]
struct Track {
    positions: Vec<Vec3>,
    velocities: Vec<Vec3>,
    rotations: Vec<Quat>,
    spins: Vec<Vec3>,
}

/// The bones that are written.
struct Bones {
    parents: Vec<i32>,
    tracks: Vec<Track>,
    /// The indices of the left and the right foot.
    feet: [usize; 2],
}

impl Moves {
    /// Writes `database.bin` and `features.bin` for Holden's motion matching demonstration. The controller of the
    /// demonstration runs with these files if the character has the joints of the demonstration's skeleton, in the same
    /// order.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::matching::{Database, IndexedClip, Moves};
    ///
    /// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let database = Database::new(IndexedClip::of(&walk, "walk.bvh", false));
    /// let mut hero = mocap::import("fixtures/real/rokoko_dance.bvh")?;
    /// mocap::Conversion::new().apply(&mut hero)?;
    /// let moves = Moves::of(&database, &hero, |_| Ok(walk.clone()))?;
    /// let [bones, features] = moves.to_holden()?;
    /// assert_eq!(bones[..4], (database.frames() as u32).to_le_bytes());
    /// assert_eq!(features[..8], [(database.frames() as u32).to_le_bytes(), 27_u32.to_le_bytes()].concat());
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`] without frames; [`Code::Unrepresentable`] if a bone has different scales along its axes.
    pub fn to_holden(&self) -> Result<[Vec<u8>; 2]> {
        if self.frames.is_empty() {
            return Err(Diagnostic::new(Code::NoMotion, "there are no frames to write").into());
        }
        let ranges = self.ranges();
        let bones = self.bones(&ranges)?;
        Ok([self.database_file(&bones, &ranges), features_file(&bones, &ranges)])
    }

    /// The first frame of each clip, and the frame after its last frame.
    fn ranges(&self) -> Vec<(usize, usize)> {
        let starts = (0..self.frames.len()).filter(|frame| self.frames[*frame].is_first);
        let stops = (0..self.frames.len()).filter(|frame| self.frames[*frame].is_last);
        starts.zip(stops.map(|last| last + 1)).collect()
    }

    fn bones(&self, ranges: &[(usize, usize)]) -> Result<Bones> {
        let is_bone = |column: &usize| self.node(self.nodes[*column]).kind != NodeKind::EndSite;
        let columns: Vec<usize> = (0..self.nodes.len()).filter(is_bone).collect();
        // Bones 0 and 1 are the root and the hips.
        let bone_of = |node: NodeId| match node == self.hips {
            true => Some(1),
            false => columns
                .iter()
                .position(|column| self.nodes[*column] == node)
                .map(|bone| bone + 2),
        };
        let mut scales = vec![1.0, self.uniform(self.hips, self.hips_scale)?];
        let (mut parents, mut tracks) = (vec![-1, 0], self.root_and_hips().to_vec());
        for column in &columns {
            let (node, at_rest) = (self.nodes[*column], &self.at_rest[*column]);
            let parent = self.node(node).parent.and_then(bone_of).unwrap_or(1);
            let rotations = (0..self.frames.len()).map(|frame| self.rotations(frame)[*column]);
            tracks.push(Track {
                positions: vec![at_rest.translation * scales[parent]; self.frames.len()],
                rotations: rotations.collect(),
                ..Track::default()
            });
            scales.push(scales[parent] * self.uniform(node, at_rest.scale)?);
            parents.push(parent as i32);
        }
        for track in &mut tracks {
            for range in ranges {
                track.complete(*range);
            }
        }
        let feet = self.legs.map(|leg| bone_of(leg[2]).unwrap_or(1));
        Ok(Bones { parents, tracks, feet })
    }

    /// The uniform scale of a node.
    fn uniform(&self, node: NodeId, scale: Vec3) -> Result<f32> {
        if (scale - Vec3::splat(scale.x)).abs().max_element() <= UNIFORM * scale.x.abs() {
            return Ok(scale.x);
        }
        let message = "database.bin has no scales of bones, and this bone has different scales along its axes";
        let diagnostic = Diagnostic::new(Code::Unrepresentable, message).in_joint(&self.node(node).name);
        Err(diagnostic.into())
    }

    /// The root on the ground, and the hips relative to the root.
    fn root_and_hips(&self) -> [Track; 2] {
        let mut tracks = [Track::default(), Track::default()];
        for frame in &self.frames {
            let turn = Quat::from_rotation_y(frame.root.forward.x.atan2(frame.root.forward.z));
            let off = frame.position - frame.root.position;
            tracks[0].positions.push(frame.root.position);
            tracks[0].rotations.push(turn);
            tracks[1].positions.push(turn.inverse() * off);
            tracks[1].rotations.push(turn.inverse() * frame.rotation);
        }
        tracks
    }

    fn database_file(&self, bones: &Bones, ranges: &[(usize, usize)]) -> Vec<u8> {
        let (frames, count) = (self.frames.len(), bones.tracks.len());
        let mut bytes = Vec::new();
        let vectors = |bytes: &mut Vec<u8>, of: fn(&Track) -> &Vec<Vec3>| {
            counts(bytes, &[frames, count]);
            for frame in 0..frames {
                for track in &bones.tracks {
                    floats(bytes, &of(track)[frame].to_array());
                }
            }
        };
        vectors(&mut bytes, |track| &track.positions);
        vectors(&mut bytes, |track| &track.velocities);
        counts(&mut bytes, &[frames, count]);
        for frame in 0..frames {
            for track in &bones.tracks {
                let [x, y, z, w] = track.rotations[frame].to_array();
                floats(&mut bytes, &[w, x, y, z]);
            }
        }
        vectors(&mut bytes, |track| &track.spins);
        counts(&mut bytes, &[count]);
        for parent in &bones.parents {
            bytes.extend_from_slice(&parent.to_le_bytes());
        }
        for of in [|range: &(usize, usize)| range.0, |range: &(usize, usize)| range.1] {
            counts(&mut bytes, &[ranges.len()]);
            counts(&mut bytes, &ranges.iter().map(of).collect::<Vec<_>>());
        }
        // A body without toes stands on its ankles.
        let has_balls = self
            .frames
            .iter()
            .any(|frame| frame.contacts & (BALLS[0] | BALLS[1]) != 0);
        let bits = if has_balls { BALLS } else { ANKLES };
        counts(&mut bytes, &[frames, bits.len()]);
        for frame in &self.frames {
            bytes.extend(bits.map(|bit| u8::from(frame.contacts & bit != 0)));
        }
        bytes
    }
}

impl Track {
    /// Sets the signs of the rotations, the velocities and the angular velocities in the frames of a clip. Velocities
    /// are central differences, with linear extrapolation at the ends of the clip.
    fn complete(&mut self, (start, stop): (usize, usize)) {
        let rate = FEATURE_RATE as f32;
        for frame in start + 1..stop {
            self.rotations[frame] = in_hemisphere_of(self.rotations[frame - 1], self.rotations[frame]);
        }
        let step = |frame: usize| {
            let turn = self.rotations[frame + 1] * self.rotations[frame].inverse();
            let moved = self.positions[frame + 1] - self.positions[frame];
            (rate * moved, rate * log(turn))
        };
        let steps: Vec<(Vec3, Vec3)> = (start..stop.saturating_sub(1)).map(step).collect();
        let inner: Vec<(Vec3, Vec3)> = steps
            .windows(2)
            .map(|pair| (0.5 * (pair[0].0 + pair[1].0), 0.5 * (pair[0].1 + pair[1].1)))
            .collect();
        let beyond = |near: Option<&(Vec3, Vec3)>, far: Option<&(Vec3, Vec3)>| match (near, far) {
            (Some(near), Some(far)) => (2.0 * near.0 - far.0, 2.0 * near.1 - far.1),
            (Some(near), None) => *near,
            _ => steps.first().copied().unwrap_or_default(),
        };
        let count = inner.len();
        let first = beyond(inner.first(), inner.get(1));
        let last = beyond(inner.last(), count.checked_sub(2).map(|before| &inner[before]));
        let ends = if stop - start > 1 { Some(last) } else { None };
        for (velocity, spin) in std::iter::once(first).chain(inner).chain(ends) {
            self.velocities.push(velocity);
            self.spins.push(spin);
        }
    }
}

/// The bytes of `features.bin`.
fn features_file(bones: &Bones, ranges: &[(usize, usize)]) -> Vec<u8> {
    let rows: Vec<[f32; FEATURES]> = ranges
        .iter()
        .flat_map(|range| (range.0..range.1).map(|frame| bones.features(frame, range.1 - 1)))
        .collect();
    let (mean, scale) = statistics(&rows);
    let mut bytes = Vec::new();
    counts(&mut bytes, &[rows.len(), FEATURES]);
    for row in &rows {
        let normalized: [f32; FEATURES] = std::array::from_fn(|column| (row[column] - mean[column]) / scale[column]);
        floats(&mut bytes, &normalized);
    }
    for numbers in [mean, scale] {
        counts(&mut bytes, &[FEATURES]);
        floats(&mut bytes, &numbers);
    }
    bytes
}

impl Bones {
    /// The features of a frame, computed from the written bones. `last` is the last frame of the clip.
    fn features(&self, frame: usize, last: usize) -> [f32; FEATURES] {
        let root = &self.tracks[0];
        let to_root = root.rotations[frame].inverse();
        let mut features = [0.0; FEATURES];
        for (side, foot) in self.feet.into_iter().enumerate() {
            let (position, velocity) = self.in_world(foot, frame);
            let position = to_root * (position - root.positions[frame]);
            features[3 * side..][..3].copy_from_slice(&position.to_array());
            features[6 + 3 * side..][..3].copy_from_slice(&(to_root * velocity).to_array());
        }
        let (_, velocity) = self.in_world(1, frame);
        features[12..15].copy_from_slice(&(to_root * velocity).to_array());
        for (index, ahead) in AHEAD.into_iter().enumerate() {
            let then = (frame + ahead).min(last);
            let position = to_root * (root.positions[then] - root.positions[frame]);
            let forward = to_root * (root.rotations[then] * Vec3::Z);
            set_ahead(&mut features, index, position, forward);
        }
        features
    }

    /// The position and the velocity of a bone in the world.
    fn in_world(&self, bone: usize, frame: usize) -> (Vec3, Vec3) {
        let (mut position, mut velocity) = (Vec3::ZERO, Vec3::ZERO);
        let mut above = Some(bone);
        while let Some(bone) = above {
            let track = &self.tracks[bone];
            let turned = track.rotations[frame] * position;
            velocity = track.velocities[frame] + track.rotations[frame] * velocity + track.spins[frame].cross(turned);
            position = track.positions[frame] + turned;
            above = usize::try_from(self.parents[bone]).ok();
        }
        (position, velocity)
    }
}

fn counts(bytes: &mut Vec<u8>, counts: &[usize]) {
    for count in counts {
        bytes.extend_from_slice(&(*count as u32).to_le_bytes());
    }
}

fn floats(bytes: &mut Vec<u8>, numbers: &[f32]) {
    for number in numbers {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
}
