//! Computes the rotation of a bone relative to the coordinate frames of the T-pose. It does so for one pose, or for
//! several poses at once, one in each lane of a vector.

use glam::{Quat, Vec3};
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Side};

use super::body::Body;
use super::rotations::{Points, Rotations};
use super::t_pose::limb_end;
use super::watched::{WatchedJoints, WatchedPose};

/// How to compute the rotation of a bone relative to the coordinate frame of the T-pose. Joints are indices into
/// [`WatchedJoints`].
#[derive(Clone, Debug)]
pub struct Track {
    joint: usize,
    joint_to_frame: Quat,
    aim: Option<Aim>,
}

/// The ends of a limb's bone, and its direction in the T-pose.
#[derive(Clone, Copy, Debug)]
struct Aim {
    from: usize,
    to: usize,
    direction: Vec3,
}

/// The joints at the ends of a limb's bone, and its direction in the T-pose.
pub type Ends = (NodeId, NodeId, Vec3);

impl Track {
    pub fn new(from: &Body, bone: Bone, node: NodeId, ends: Option<Ends>, watched: &mut WatchedJoints) -> Self {
        Self {
            joint: watched.rotation(node),
            joint_to_frame: from.frame_to_joint(bone, node).inverse(),
            aim: ends.map(|(start, end, direction)| Aim {
                from: watched.index_of(start),
                to: watched.index_of(end),
                direction,
            }),
        }
    }

    /// The rotation in a pose.
    #[inline(always)]
    pub fn frame<const N: usize>(&self, seen: &WatchedPose<N>) -> Rotations<N> {
        let rotation = seen.rotations[self.joint] * Rotations::all(self.joint_to_frame.to_array());
        match self.aim {
            None => rotation,
            Some(Aim { from, to, direction }) => {
                let between = seen.positions[to] - seen.positions[from];
                Rotations::arc(rotation * Points::all(direction.to_array()), between) * rotation
            }
        }
    }
}

/// Whether a bone is twisted against its parent at its beginning. This holds for thighs and upper arms, along which the
/// skin spreads the twist.
pub fn is_twisted_at_beginning(bone: Bone) -> bool {
    matches!(bone.on(Side::Left), Bone::LeftUpperLeg | Bone::LeftUpperArm)
}

/// Whether two positions determine the direction between them. Positions have seven digits in 32 bits. If a bone is
/// short and far from the origin, too few digits remain for its direction, so only the rotation of its joint is used.
fn is_told(start: Vec3, end: Vec3) -> bool {
    /// The smallest length of a bone with a known direction, as a fraction of the distance of its farther end from the
    /// origin. Of seven digits, three remain.
    const SHORTEST: f32 = 1e-4;
    start.distance(end) > SHORTEST * start.abs().max(end.abs()).max_element()
}

/// The joint that shows the twist of a whole bone of the source. For a limb, also its ends, and its direction in the
/// T-pose.
pub fn ends(from: &Body, bone: Bone) -> Option<(NodeId, Option<Ends>)> {
    let joint = from.joint(bone)?;
    let segment = from.segment(bone);
    let end = limb_end(bone).and_then(|end| from.joint(end));
    // Several joints can share the twist of a limb. In a thigh or an upper arm, the last joint has the whole twist. In
    // a shin or a forearm, the foot or the hand twists the limb, so the first joint does not twist.
    let twisted = if is_twisted_at_beginning(bone) {
        segment.last()
    } else {
        segment.first()
    };
    // The positions show the current direction of the bone, unlike the rotation of its joint: joints in between may
    // bend it, and its end may move.
    let end = end.filter(|end| is_told(from.position(joint), from.position(*end)));
    let direction = end.and_then(|end| from.direction(bone, joint, end));
    match (twisted, end, direction) {
        (Some(twisted), Some(end), Some(direction)) => Some((*twisted, Some((joint, end, direction)))),
        _ => Some((joint, None)),
    }
}

/// The track of a whole bone: its direction, and the twist of its end.
pub fn whole(from: &Body, bone: Bone, watched: &mut WatchedJoints) -> Option<Track> {
    let (node, ends) = ends(from, bone)?;
    Some(Track::new(from, bone, node, ends, watched))
}
