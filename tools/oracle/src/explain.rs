//! The explained differences between two scenes. Each rule checks, with the file and both scenes, that its reason
//! applies at this place, and that both values follow from the reason.

mod meshes;

use std::cell::OnceCell;

use crate::difference::{Place, all_close, close};
use crate::scene::{Scene, Track};
use crate::source::{Channel, Joint, Motion, position, rotation};

/// A file and both programs' scenes of it.
pub(crate) struct Case<'a> {
    pub motion: &'a Motion,
    /// Whether the scenes went through the post-processing steps.
    pub processed: bool,
    pub assimp: &'a Scene,
    pub ours: &'a Scene,
    /// The motion as [`odd_row_dropped`] takes it.
    without_odd_lines: OnceCell<Option<Motion>>,
    /// Whether [`meshes::joined_across_bones`] applies, computed when first needed.
    draws_twins: OnceCell<bool>,
}

/// The reason why two scenes may differ at a place.
pub(crate) struct Rule {
    /// The row of `README.md` that gives the reason.
    pub id: &'static str,
    pub applies: fn(&Case<'_>, Place) -> bool,
}

impl Rule {
    const fn new(id: &'static str, applies: fn(&Case<'_>, Place) -> bool) -> Self {
        Self { id, applies }
    }
}

pub(crate) const RULES: &[Rule] = &[
    Rule::new("position-channels-dropped", position_channels_dropped),
    Rule::new("root-offset-added", root_offset_added),
    Rule::new("joint-offset-added", joint_offset_added),
    Rule::new("world-positions", world_positions),
    Rule::new("hole-held", hole_held),
    Rule::new("no-frames", no_frames),
    Rule::new("quaternion-sign", quaternion_sign),
    Rule::new("odd-row-dropped", odd_row_dropped),
    Rule::new("normal-not-unit", meshes::normal_not_unit),
    Rule::new("normal-rounded", meshes::normal_rounded),
    Rule::new("normal-of-small-face", meshes::normal_of_small_face),
    Rule::new("near-origin-untransformed", meshes::near_origin_untransformed),
    Rule::new("cache-locality-order", meshes::cache_locality_order),
    Rule::new("small-faces-joined", meshes::small_faces_joined),
    Rule::new("joined-across-bones", meshes::joined_across_bones),
];

/// A root position counts as near zero up to this fraction of the OFFSET's length.
const NEAR_ZERO: f64 = 0.02;

impl<'a> Case<'a> {
    pub(crate) fn new(motion: &'a Motion, processed: bool, assimp: &'a Scene, ours: &'a Scene) -> Self {
        Self {
            motion,
            processed,
            assimp,
            ours,
            without_odd_lines: OnceCell::new(),
            draws_twins: OnceCell::new(),
        }
    }

    fn joint(&self, channel: usize) -> Option<&Joint> {
        self.motion.joints.get(channel)
    }

    fn assimp_value(&self, channel: usize, track: Track, key: usize) -> &[f64] {
        &self.assimp.animations[0].channels[channel].keys(track)[key].value
    }

    fn our_value(&self, channel: usize, track: Track, key: usize) -> &[f64] {
        &self.ours.animations[0].channels[channel].keys(track)[key].value
    }

    fn key_counts(&self, channel: usize, track: Track) -> (usize, usize) {
        let count = |scene: &Scene| scene.animations[0].channels[channel].keys(track).len();
        (count(self.assimp), count(self.ours))
    }

    fn frames(&self) -> usize {
        self.motion.frames as usize
    }

    /// The joint's position in the frame by its channels; missing values repeat the last value.
    fn position(&self, joint: &Joint, frame: usize) -> Vec<f64> {
        let offset = self.motion.nodes[joint.node].offset;
        let [x, y, z] = position(&self.motion.held_row(joint, frame), offset);
        if self.adds_root_offset(joint) {
            vec![x + offset[0], y + offset[1], z + offset[2]]
        } else {
            vec![x, y, z]
        }
    }

    fn rotation(&self, joint: &Joint, frame: usize) -> Vec<f64> {
        rotation(&self.motion.held_row(joint, frame)).to_vec()
    }

    fn value(&self, joint: &Joint, track: Track, frame: usize) -> Vec<f64> {
        match track {
            Track::Position => self.position(joint, frame),
            Track::Rotation => self.rotation(joint, frame),
            Track::Scaling => vec![1.0; 3],
        }
    }

    /// Whether a track of mocap has the file's number of keys: one per frame, or one in total for a constant track.
    fn our_count_is_right(&self, joint: &Joint, track: Track, count: usize) -> bool {
        let first = self.value(joint, track, 0);
        let constant = || (1..self.frames()).all(|frame| same_value(track, &first, &self.value(joint, track, frame)));
        count == self.frames() || (count == 1 && self.processed && constant())
    }

    /// Whether the root's positions are relative to its OFFSET. They are if, on the axes with a position channel, the
    /// first position or the median is near zero compared with the OFFSET. They also are if the median is along the
    /// OFFSET.
    fn adds_root_offset(&self, joint: &Joint) -> bool {
        let offset = self.motion.nodes[joint.node].offset;
        let mut moved_offset = [0.0; 3];
        for channel in &joint.channels {
            if let Channel::Position(axis) = channel {
                moved_offset[*axis] = offset[*axis];
            }
        }
        let size = length(&moved_offset);
        let positions: Vec<[f64; 3]> = (0..self.frames())
            .map(|frame| position(&self.motion.held_row(joint, frame), [0.0; 3]))
            .collect();
        let median = |measure: &dyn Fn(&[f64; 3]) -> f64| {
            let mut values: Vec<f64> = positions.iter().map(measure).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(f64::INFINITY)
        };
        let near = |place: [f64; 3]| place.iter().all(|part| part.abs() <= NEAR_ZERO * size);
        let dot = |place: &[f64; 3]| place.iter().zip(moved_offset).map(|(a, b)| a * b).sum::<f64>();
        let along = median(&dot) / (size * size);
        let is_near = positions.first().is_some_and(|first| near(*first))
            || near([0, 1, 2].map(|axis| median(&|place| place[axis])));
        joint.node == 0 && size > 0.0 && ((is_near && along.abs() <= 0.5) || along.abs() <= 0.05)
    }
}

fn has_position(joint: &Joint) -> bool {
    joint
        .channels
        .iter()
        .any(|channel| matches!(channel, Channel::Position(_)))
}

/// Whether the numbers are equal. For rotations, the opposite quaternion is equal too, because it is the same rotation.
fn same_value(track: Track, a: &[f64], b: &[f64]) -> bool {
    all_close(a, b) || (track == Track::Rotation && all_close(a, &negated(b)))
}

fn negated(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| -value).collect()
}

fn length(vector: &[f64]) -> f64 {
    vector.iter().map(|part| part * part).sum::<f64>().sqrt()
}

fn position_channels_dropped(case: &Case<'_>, place: Place) -> bool {
    let (Place::KeyCount(channel, Track::Position) | Place::Key(channel, Track::Position, _)) = place else {
        return false;
    };
    let Some(joint) = case.joint(channel) else { return false };
    let offset = case.motion.nodes[joint.node].offset;
    let (assimp_count, our_count) = case.key_counts(channel, Track::Position);
    let dropped = joint.channels.len() != 6
        && has_position(joint)
        && assimp_count == 1
        && all_close(case.assimp_value(channel, Track::Position, 0), &offset);
    dropped
        && match place {
            Place::Key(_, track, key) => all_close(&case.position(joint, key), case.our_value(channel, track, key)),
            _ => case.our_count_is_right(joint, Track::Position, our_count),
        }
}

fn root_offset_added(case: &Case<'_>, place: Place) -> bool {
    let Place::Key(channel, track @ Track::Position, key) = place else {
        return false;
    };
    let Some(joint) = case.joint(channel) else { return false };
    let offset = case.motion.nodes[joint.node].offset;
    let sum: Vec<f64> = case
        .assimp_value(channel, track, key)
        .iter()
        .zip(offset)
        .map(|(part, offset)| part + offset)
        .collect();
    joint.channels.len() == 6 && case.adds_root_offset(joint) && all_close(&sum, case.our_value(channel, track, key))
}

/// Position channels below the root that stay near zero compared with the OFFSET; mocap adds them to the OFFSET.
fn joint_offset_added(case: &Case<'_>, place: Place) -> bool {
    let Place::Key(channel, track @ Track::Position, key) = place else {
        return false;
    };
    let Some(joint) = case.joint(channel) else { return false };
    let offset = case.motion.nodes[joint.node].offset;
    let stays_near = (0..case.frames()).all(|frame| {
        let place = position(&case.motion.held_row(joint, frame), [0.0; 3]);
        length(&place) <= 0.05 * length(&offset)
    });
    let assimp = case.assimp_value(channel, track, key).iter();
    let sum: Vec<f64> = assimp.zip(offset).map(|(part, offset)| part + offset).collect();
    joint.node != 0 && joint.channels.len() == 6 && stays_near && all_close(&sum, case.our_value(channel, track, key))
}

/// World positions: mocap's joint is as far from its parent as in the file.
fn world_positions(case: &Case<'_>, place: Place) -> bool {
    let Place::Key(channel, track @ Track::Position, key) = place else {
        return false;
    };
    let Some(joint) = case.joint(channel) else { return false };
    let parent = case.ours.nodes.get(joint.node).and_then(|node| node.parent);
    let parent = case.motion.joints.iter().find(|other| Some(other.node) == parent);
    let Some(parent) = parent.filter(|parent| parent.channels.len() == 6 && joint.channels.len() == 6) else {
        return false;
    };
    let at = |joint: &Joint| position(&case.motion.held_row(joint, key), [0.0; 3]);
    let (here, above) = (at(joint), at(parent));
    let bone = length(&[0, 1, 2].map(|axis| here[axis] - above[axis]));
    let is_far = length(&here) > 3.0 * length(&case.motion.nodes[joint.node].offset);
    is_far
        && all_close(&here, case.assimp_value(channel, track, key))
        && close(bone, length(case.our_value(channel, track, key)))
}

fn hole_held(case: &Case<'_>, place: Place) -> bool {
    let (Place::KeyCount(channel, track) | Place::Key(channel, track, _)) = place else {
        return false;
    };
    let Some(joint) = case.joint(channel) else { return false };
    match place {
        Place::Key(_, _, key) => {
            let value = case.our_value(channel, track, key);
            !case.motion.is_finite(joint, key) && same_value(track, &case.value(joint, track, key), value)
        }
        _ => {
            let (assimp_count, our_count) = case.key_counts(channel, track);
            let has_hole = (0..case.frames()).any(|frame| !case.motion.is_finite(joint, frame));
            has_hole && assimp_count == case.frames() && case.our_count_is_right(joint, track, our_count)
        }
    }
}

fn odd_row_dropped(case: &Case<'_>, place: Place) -> bool {
    let Some(motion) = case.without_odd_lines.get_or_init(|| case.motion.without_odd_lines()) else {
        return false;
    };
    let rows = Case::new(motion, case.processed, case.assimp, case.ours);
    match place {
        Place::Animation("duration") => case.ours.animations[0].duration == motion.frames - 1.0,
        Place::KeyCount(channel, track) => rows.joint(channel).is_some_and(|joint| {
            let (assimp_count, our_count) = rows.key_counts(channel, track);
            assimp_count == case.frames() && rows.our_count_is_right(joint, track, our_count)
        }),
        Place::Key(channel, track, key) => rows.joint(channel).is_some_and(|joint| {
            same_value(
                track,
                &rows.value(joint, track, key),
                rows.our_value(channel, track, key),
            )
        }),
        _ => false,
    }
}

fn no_frames(case: &Case<'_>, place: Place) -> bool {
    // Assimp converts the number to a 32-bit integer, which makes NaN and too large numbers 0.
    let frames = case.motion.frames;
    let none = frames.is_nan() || (0.0..1.0).contains(&frames) || frames >= 4_294_967_296.0;
    place == Place::Count("animations") && case.ours.animations.is_empty() && none
}

fn quaternion_sign(case: &Case<'_>, place: Place) -> bool {
    let Place::Key(channel, track @ Track::Rotation, key) = place else {
        return false;
    };
    let Some(joint) = case.joint(channel) else { return false };
    let quaternion = case.rotation(joint, key);
    all_close(
        case.assimp_value(channel, track, key),
        &negated(case.our_value(channel, track, key)),
    ) && is_on_branch_boundary(&quaternion)
}

/// Whether rounding decides from which elements of the rotation matrix Assimp computes the quaternion, and so its sign.
///
/// Assimp uses the trace, 4 w^2 - 1, if it is positive: for angles up to 120 degrees. Otherwise it uses the largest
/// element of the diagonal, which belongs to the largest of x, y and z.
fn is_on_branch_boundary(quaternion: &[f64]) -> bool {
    let trace = 4.0 * quaternion[0] * quaternion[0] - 1.0;
    let mut squares: Vec<f64> = quaternion[1..].iter().map(|part| part * part).collect();
    squares.sort_by(f64::total_cmp);
    close(trace, 0.0) || (trace < 0.0 && close(squares[1], squares[2]))
}
