//! The rules by which a joint follows other joints. They apply to one pose, or to several poses at once with SIMD.

use glam::{Quat, Vec3};

use mocap_figure::rotations::{Points, Rotations};
use mocap_scene::pose::Trs;
use mocap_scene::scene::NodeId;

/// A driven joint of the target.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    pub(super) node: NodeId,
    pub(super) rest: Trs,
    pub(super) frame_to_joint: Quat,
    pub(super) above: ParentRule,
    pub(super) rule: Rule,
}

/// The joint that the parent of a joint follows.
#[derive(Clone, Copy, Debug)]
pub(super) enum ParentRule {
    /// No joint: the rotation from the axes of the figure to the parent.
    Still(Quat),
    /// A driven joint, as an index into `Plan::drives`. If the parent is another joint, `between` is the rotation from
    /// the driven joint to the parent.
    Drive { drive: usize, between: Option<Quat> },
}

/// The rule of a joint. Numbers are indices into `Plan::tracks`.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rule {
    /// A rotation between two rotations of the source.
    Between { from: usize, to: usize, fraction: f32 },
    /// The rotation of a bone, twisted about its axis by a fraction of its [`Twist`], an index into `Plan::twists`.
    Twisted { twist: usize, fraction: f32 },
}

/// The twist of a bone that several joints share.
#[derive(Clone, Debug)]
pub(super) struct Twist {
    pub(super) bone: usize,
    /// The adjacent bone, at the beginning or at the end, against which the bone is twisted.
    pub(super) other: usize,
    /// The direction of the bone in the T-pose.
    pub(super) axis: Vec3,
    /// The joints that share the twist: the fraction of each, and the vector from the joint to the next joint in the
    /// axes of the T-pose. The joints are not exactly on one line, so the twist of a joint moves the end of the bone.
    pub(super) joints: Vec<(f32, Vec3)>,
}

/// The twist of a bone in `N` poses.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoneTwist<const N: usize> {
    bone: Rotations<N>,
    twist: Rotations<N>,
}

impl<const N: usize> Default for BoneTwist<N> {
    fn default() -> Self {
        let (bone, twist) = (Rotations::IDENTITY, Rotations::IDENTITY);
        Self { bone, twist }
    }
}

impl Twist {
    /// The twist, and the rotation of the bone after a small correction that puts the end back on the axis.
    #[inline(always)]
    pub(super) fn at<const N: usize>(&self, frames: &[Rotations<N>]) -> BoneTwist<N> {
        let bone = frames[self.bone];
        let twist = (bone.conjugate() * frames[self.other]).twist(self.axis.to_array());
        let mut end = Points::ZERO;
        for (part, offset) in &self.joints {
            end = end + fraction(twist, *part) * Points::all(offset.to_array());
        }
        // The shortest rotation back is the inverse of the rotation from the axis, whose length is 1.
        let away = Rotations::arc(Points::all(self.axis.to_array()), end);
        BoneTwist {
            bone: bone * away.conjugate(),
            twist,
        }
    }
}

impl Drive {
    /// The rotation of the joint since the T-pose, from the rotations of the source.
    #[inline(always)]
    pub(super) fn frame<const N: usize>(&self, frames: &[Rotations<N>], twists: &[BoneTwist<N>]) -> Rotations<N> {
        match self.rule {
            Rule::Between { from, to, fraction } => between(frames[from], frames[to], fraction),
            Rule::Twisted { twist, fraction: part } => twists[twist].bone * fraction(twists[twist].twist, part),
        }
    }
}

/// A fraction of a rotation, on the shorter arc.
#[inline(always)]
fn fraction<const N: usize>(rotation: Rotations<N>, fraction: f32) -> Rotations<N> {
    between(Rotations::IDENTITY, rotation, fraction)
}

/// A rotation between two rotations, on the shorter arc.
#[inline(always)]
fn between<const N: usize>(from: Rotations<N>, to: Rotations<N>, fraction: f32) -> Rotations<N> {
    if fraction == 0.0 {
        from
    } else if fraction == 1.0 {
        to
    } else {
        from.slerp(to, fraction)
    }
}
