//! The T-pose of a humanoid: arms sideways, legs down, facing forward. There is one for each figure: the commands that
//! show it, draw it, move motions by it and write it take it from here.
//!
//! It is made in three steps. The *reference pose* is a figure that stands: the rest pose where it stands, else the
//! first frame of the motion where that is a T-pose, else one that is computed from the bones ([`standing`]). From it
//! each bone is turned to its T-pose ([`Builder::choose`]). Feet, head and shoulders are then levelled as the motion
//! shows them ([`level`]). `docs/retargeting.md` says what each bone keeps.

mod level;
mod placed;
mod stance;
mod standing;

use std::collections::BTreeMap;

use glam::{Mat3, Mat4, Quat, Vec3};
use serde::Serialize;

use super::Figure;
use super::axes::{Evidence, Shown, angle_about};
use super::axis::RestPose;
use super::hierarchy::Hierarchy;
use super::knuckles::Knuckles;
use crate::math::directions::{arc, rotation_of};
use crate::pose::Pose;
use crate::scene::{Confidence, Format, HumanoidBone as Bone, NodeId, Scene, Side};

/// The largest angle between the facing of the rest pose and the axis that is nearest to it, in radians, which counts
/// as inexact. Above it the figure is turned to face along the axis.
const FACING_IS_INEXACT: f32 = 0.09;

/// A foot that points further down than this, as a fraction of its length, does not stand on its sole at rest.
const POINTED_FOOT: f32 = 0.9;

/// The largest angle of a shortest rotation from a rest pose that stands, in radians, that leaves no doubt how the
/// bone is turned about itself: arms that hang down turn by 90 degrees.
const SMALL_TURN: f32 = 1.05;

/// The roll of a palm that looks forward or back in a rest pose that stands, in radians.
const SIDEWAYS_PALM: std::ops::RangeInclusive<f32> = 0.8..=2.2;

/// Where a thumb points in the T-pose, seen along the hand: those of SOMA's and MakeHuman's bodies are 33 and 21
/// degrees below the palm.
const THUMB: Vec3 = Vec3::new(0.0, -0.45, 0.89);

/// The pose from which a T-pose is made.
///
/// [`TPose`](crate::figure::TPose) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TPoseSource {
    /// The rest pose: the figure stands in it, with its arms sideways, down or between.
    RestPose,
    /// The first frame of the motion, which is a T-pose.
    FirstFrame,
    /// One that is computed from the bones: nothing in the file shows how they are turned about themselves.
    Computed,
}

/// Why a bone is turned as it is in a T-pose.
///
/// [`TPose`](crate::figure::TPose) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum TPoseReason {
    /// It stays as it stands in the pose from which the T-pose is made.
    Stands,
    /// It is turned by the shortest rotation until it points where it does in a T-pose.
    ShortestArc,
    /// It stands on its sole, and is turned about the up axis until it points forward.
    OnItsSole,
    /// It is pitched and rolled as where it stands in the motion.
    StandsInMotion,
    /// It is turned as on the average of the motion, against the chest.
    AverageOfMotion,
    /// It points where it does in a T-pose, turned about itself so that the palm is down, by the knuckles.
    Knuckles,
    /// It points where it does in a T-pose, turned about itself so that its knee or elbow bends as it does in the
    /// motion: a shin goes back, a forearm forward.
    Hinge,
    /// It follows the bone above it.
    FollowsTheBoneAbove,
}

impl TPoseReason {
    /// The reason as one phrase.
    ///
    /// ```
    /// use mocap::figure::TPoseReason;
    ///
    /// assert_eq!(TPoseReason::ShortestArc.as_str(), "by the shortest rotation to where it points");
    /// ```
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Stands => "as it stands",
            Self::ShortestArc => "by the shortest rotation to where it points",
            Self::OnItsSole => "as it stands on its sole, turned forward",
            Self::StandsInMotion => "as it stands in the motion",
            Self::AverageOfMotion => "as on the average of the motion",
            Self::Knuckles => "with its palm down, by the knuckles",
            Self::Hinge => "by the axis about which it bends in the motion",
            Self::FollowsTheBoneAbove => "with the bone above it",
        }
    }
}

/// A bone in the T-pose.
///
/// [`TPose`](crate::figure::TPose) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TPoseBone {
    /// The joint that is the bone.
    pub joint: NodeId,
    /// The rotation in the world, about the joint, that brings the bone there from the rest pose, after those of the
    /// bones above it.
    pub rotation: Quat,
    /// How far to trust how the bone is turned about itself. Where it points is beyond doubt.
    pub confidence: Confidence,
    /// Why it is turned so.
    pub reason: TPoseReason,
    /// From the reference pose to the T-pose, in the world.
    reference_to_t_pose: Quat,
}

/// A humanoid in the T-pose: [`Figure::t_pose`].
///
/// ```
/// use mocap::figure::{Figure, HumanoidBone};
///
/// let scene = mocap::import("fixtures/real/rokoko_dance.bvh")?; // at rest every bone lies along +X or +Y
/// let figure = Figure::new(&scene);
/// let t_pose = figure.t_pose(&scene).unwrap();
/// let at = |bone| t_pose.pose.position(t_pose.bones[&bone].joint);
/// let arm = at(HumanoidBone::LeftHand) - at(HumanoidBone::LeftUpperArm);
/// assert!(arm.normalize().x > 0.999);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TPose {
    /// The pose from which it is made.
    pub source: TPoseSource,
    /// Every node of the scene in the T-pose. Joints that are no bone go with the bone above them.
    pub pose: Pose,
    /// The bones; left and right are those of the body, whatever the names say.
    pub bones: BTreeMap<Bone, TPoseBone>,
    /// Left, up and forward of the figure, from the frames of the T-pose (+X, +Y, +Z) to the world.
    pub(crate) axes: Quat,
    /// The joints in the reference pose.
    pub(crate) positions: Vec<Vec3>,
    /// Their rotations to the world in the reference pose.
    pub(crate) rotations: Vec<Quat>,
}

impl TPose {
    /// The T-pose of `figure`, which is that of `scene`; `None` if it is not a humanoid.
    pub(super) fn new(scene: &Scene, figure: &Figure) -> Option<Self> {
        if !figure.humanoid.found {
            return None;
        }
        let humanoid = figure.humanoid.clone().with_sides_of_the_body();
        let rest_pose = figure.rest_pose.value;
        let stands = matches!(rest_pose, RestPose::TPose | RestPose::APose | RestPose::IPose);
        let axes = figure.figure_to_world();
        let hierarchy = Hierarchy::new(scene);
        let bones = humanoid.bones.iter().map(|(bone, joint)| (*bone, joint.joint));
        let bones = bones.collect();
        let knuckles = Knuckles::new(scene, &hierarchy, &bones);
        // A rest pose that stands says how bones are turned about themselves.
        let shown = (!stands).then(|| Shown::new(scene, &hierarchy, &bones));
        let sources = standing::Sources {
            humanoid: &humanoid,
            knuckles: &knuckles,
            shown: shown.as_ref(),
        };
        let (source, reference) = standing::reference(scene, &sources, figure.up.value, &axes);
        // The rest pose of a VRM animation is the T-pose, whatever it looks like.
        let is_t_pose = scene.metadata.format == Some(Format::Vrma) && rest_pose == RestPose::TPose;
        let mut builder = Builder {
            source,
            is_t_pose,
            knuckles,
            axes: Quat::from_mat3(&axes).normalize(),
            bones,
            hierarchy,
            shown,
            positions: (0..scene.nodes.len())
                .map(|node| reference.position(NodeId::new(node)))
                .collect(),
            rotations: reference.node_to_world.iter().map(rotation_of).collect(),
            turns: BTreeMap::new(),
        };
        builder.turn_bones(&axes);
        if scene.metadata.format != Some(Format::Vrma) {
            builder.level(scene);
        }
        Some(builder.finish(scene, &reference))
    }

    /// The largest angle of a bone from the rest pose, after the bones above it, in degrees.
    pub fn largest_rotation(&self) -> f32 {
        let angles = self.bones.values().map(|bone| Self::degrees(bone.rotation));
        angles.fold(0.0, f32::max)
    }

    /// The angle of a rotation, in degrees.
    pub fn degrees(rotation: Quat) -> f32 {
        // Of small angles the cosine is too coarse.
        let sine = Vec3::new(rotation.x, rotation.y, rotation.z).length();
        2.0 * sine.atan2(rotation.w.abs()).to_degrees()
    }

    /// From the reference pose of a bone to its T-pose.
    pub(crate) fn reference_to_t_pose(&self, bone: Bone) -> Quat {
        self.bones
            .get(&bone)
            .map_or(Quat::IDENTITY, |bone| bone.reference_to_t_pose)
    }

    /// From the frame of `bone` to a joint that moves with it, as a rotation: the joint's rotation in the T-pose.
    pub(crate) fn frame_to_joint(&self, bone: Bone, joint: NodeId) -> Quat {
        (self.axes.inverse() * self.reference_to_t_pose(bone) * self.rotations[joint.index()]).normalize()
    }
}

/// The rotation of a bone from the reference pose to the T-pose.
struct Turn {
    rotation: Quat,
    confidence: Confidence,
    reason: TPoseReason,
}

/// A T-pose while it is made.
struct Builder {
    source: TPoseSource,
    /// Whether the reference pose is the T-pose itself.
    is_t_pose: bool,
    knuckles: Knuckles,
    axes: Quat,
    bones: BTreeMap<Bone, NodeId>,
    hierarchy: Hierarchy,
    /// What the motion shows, where the rest pose does not stand.
    shown: Option<Shown>,
    /// The reference pose.
    positions: Vec<Vec3>,
    rotations: Vec<Quat>,
    /// From the reference pose to the T-pose.
    turns: BTreeMap<Bone, Turn>,
}

impl Builder {
    fn joint(&self, bone: Bone) -> Option<NodeId> {
        self.bones.get(&bone).copied()
    }

    fn position(&self, node: NodeId) -> Vec3 {
        self.positions[node.index()]
    }

    fn turn_bones(&mut self, axes: &Mat3) {
        if self.is_t_pose {
            let stands = || Turn {
                rotation: Quat::IDENTITY,
                confidence: Confidence::Sure,
                reason: TPoseReason::Stands,
            };
            self.turns = self.bones.keys().map(|bone| (*bone, stands())).collect();
            return;
        }
        let facing = self.turn_to_face(axes.y_axis, axes.z_axis);
        let mut turned: BTreeMap<Bone, Turn> = BTreeMap::new();
        for (&bone, &joint) in &self.bones {
            let above = std::iter::successors(bone.parent(), |bone| bone.parent())
                .find_map(|above| turned.get(&above))
                .map_or(facing, |turn| turn.rotation);
            turned.insert(bone, self.choose(bone, joint, facing, above, axes));
        }
        self.turns = turned;
    }

    /// How a bone is turned to its T-pose, and why: the one place where this is chosen. `facing` turns the whole
    /// figure forward, `above` is the rotation of the bone above, and `axes` are left, up and forward in the world.
    fn choose(&self, bone: Bone, joint: NodeId, facing: Quat, above: Quat, axes: &Mat3) -> Turn {
        let (rotation, reason) = match (direction(bone), bone.on(Side::Left)) {
            (Some(direction), part) => {
                let start = match part {
                    Bone::LeftUpperArm | Bone::LeftUpperLeg => facing,
                    _ => above,
                };
                let next = next(&self.hierarchy, &self.bones, &self.knuckles, bone, joint);
                let along = next.map(|next| start * (self.position(next) - self.position(joint)));
                match along.filter(|along| along.length() > self.shortest(joint)) {
                    Some(along) => {
                        let turn = arc(along, self.axes * direction) * start;
                        self.palm_down(bone, joint, turn, direction)
                            .or_else(|| self.rolled(bone, joint, turn, direction, above))
                            .unwrap_or((turn, TPoseReason::ShortestArc))
                    }
                    None => self
                        .as_on_average(bone, joint, above)
                        .unwrap_or((start, TPoseReason::FollowsTheBoneAbove)),
                }
            }
            (None, Bone::LeftFoot) => (
                self.foot(joint, bone, facing, axes.y_axis, axes.z_axis),
                TPoseReason::OnItsSole,
            ),
            (None, Bone::LeftToes) => (above, TPoseReason::FollowsTheBoneAbove),
            _ => (facing, TPoseReason::Stands),
        };
        let is_small = rotation.angle_between(facing) <= SMALL_TURN;
        Turn {
            rotation: rotation.normalize(),
            confidence: match self.source {
                TPoseSource::RestPose if is_small => Confidence::Sure,
                TPoseSource::RestPose | TPoseSource::FirstFrame => Confidence::Likely,
                TPoseSource::Computed if matches!(reason, TPoseReason::Hinge | TPoseReason::Knuckles) => {
                    Confidence::Likely
                }
                TPoseSource::Computed => Confidence::Unsure,
            },
            reason,
        }
    }

    /// A bone that points along `direction` after a `turn`, rolled about itself as the motion shows it. `above` is
    /// the rotation of the bone above.
    fn rolled(
        &self,
        bone: Bone,
        joint: NodeId,
        turn: Quat,
        direction: Vec3,
        above: Quat,
    ) -> Option<(Quat, TPoseReason)> {
        let rotation = |node: NodeId| turn * self.rotations[node.index()];
        let forearm = |node: NodeId| above * self.rotations[node.index()];
        let shown = self.shown.as_ref()?;
        let (roll, evidence) = shown.roll(bone, joint, self.axes, self.axes * direction, rotation, forearm)?;
        match evidence {
            Evidence::Hinge => Some((roll * turn, TPoseReason::Hinge)),
            // A first frame that is a T-pose says more than an average.
            Evidence::Average if self.source == TPoseSource::FirstFrame => None,
            Evidence::Average => Some((roll * turn, TPoseReason::AverageOfMotion)),
        }
    }

    /// A bone shorter than this points nowhere: a thousandth of the one above it.
    fn shortest(&self, joint: NodeId) -> f32 {
        let above = self.hierarchy.parents[joint.index()].map(NodeId::new);
        above.map_or(0.0, |above| 1e-3 * self.position(joint).distance(self.position(above)))
    }

    /// A hand that shows nothing of itself, turned against its forearm as on the average of the motion. `above` is the
    /// rotation of the forearm.
    fn as_on_average(&self, bone: Bone, joint: NodeId, above: Quat) -> Option<(Quat, TPoseReason)> {
        let forearm = |node: NodeId| above * self.rotations[node.index()];
        let hand = self.shown.as_ref()?.hand(bone, forearm)?;
        let turn = hand * self.rotations[joint.index()].inverse();
        (self.source == TPoseSource::Computed).then_some((turn, TPoseReason::AverageOfMotion))
    }

    /// A hand that points along `direction` after a `turn`, rolled until the palm is down: the knuckle of the index
    /// finger in front of that of the little finger, or the thumb in front of the hand. A hand of a rest pose that
    /// stands is rolled only where its palm looks forward or back: hands are not quite flat at rest, and one whose
    /// palm looks up has its whole arm turned.
    fn palm_down(&self, bone: Bone, joint: NodeId, turn: Quat, direction: Vec3) -> Option<(Quat, TPoseReason)> {
        let side = bone.side().filter(|side| bone.on(*side) == Bone::LeftHand.on(*side))?;
        let at = |finger: Bone| Some(self.position(self.knuckles.of(finger.on(side))?));
        let knuckles = at(Bone::LeftIndexProximal).zip(at(Bone::LeftLittleProximal));
        let thumb = || {
            let thumb = at(Bone::LeftThumbProximal)?;
            Some(thumb - self.position(joint))
        };
        let (across, forward) = match knuckles {
            Some((index, little)) => (index - little, Vec3::Z),
            None => (thumb()?, THUMB),
        };
        let along = self.axes * direction;
        let angle = angle_about(along, turn * across, self.axes * forward)?;
        let counts = self.source == TPoseSource::Computed || SIDEWAYS_PALM.contains(&angle.abs());
        counts.then(|| (Quat::from_axis_angle(along, angle) * turn, TPoseReason::Knuckles))
    }

    /// The rotation about the up axis that makes the figure of the reference pose face along an axis.
    fn turn_to_face(&self, up: Vec3, forward: Vec3) -> Quat {
        // One that is computed faces there, whatever its collar bones do.
        if self.source == TPoseSource::Computed {
            return Quat::IDENTITY;
        }
        let across = |left: Bone, right: Bone| {
            let across = self.position(self.joint(left)?) - self.position(self.joint(right)?);
            (across - across.project_onto_normalized(up)).try_normalize()
        };
        let hips = across(Bone::LeftUpperLeg, Bone::RightUpperLeg).unwrap_or_default();
        let shoulders = across(Bone::LeftUpperArm, Bone::RightUpperArm).unwrap_or_default();
        let Some(seen) = (hips + shoulders).cross(up).try_normalize() else {
            return Quat::IDENTITY;
        };
        let angle = seen.cross(forward).dot(up).atan2(seen.dot(forward));
        if angle.abs() < FACING_IS_INEXACT {
            return Quat::IDENTITY;
        }
        Quat::from_axis_angle(up, angle)
    }

    /// A foot stands on its sole in the reference pose. Only its heading is turned, so that it points forward.
    fn foot(&self, joint: NodeId, bone: Bone, facing: Quat, up: Vec3, forward: Vec3) -> Quat {
        let side = bone.side().unwrap_or(Side::Left);
        let toes = self.joint(Bone::LeftToes.on(side));
        let toes = toes.or_else(|| self.hierarchy.only_child(joint));
        let along = toes.and_then(|toes| (facing * (self.position(toes) - self.position(joint))).try_normalize());
        let Some(along) = along else {
            return facing;
        };
        if along.dot(up).abs() > POINTED_FOOT {
            return arc(along, forward - 0.4 * up) * facing;
        }
        let flat = along - along.project_onto_normalized(up);
        arc(flat, forward) * facing
    }

    /// Every node in the T-pose: joints that are no bone go with the bone above them.
    fn finish(self, scene: &Scene, reference: &Pose) -> TPose {
        let mut bone_of = vec![None; scene.nodes.len()];
        for (bone, joint) in &self.bones {
            bone_of[joint.index()] = Some(*bone);
        }
        let mut pose = Pose::rest(scene);
        // For each node its rotation from the reference pose, and for each bone that from the rest pose.
        let mut turned: Vec<Quat> = Vec::with_capacity(scene.nodes.len());
        let mut from_rest = vec![Quat::IDENTITY; scene.nodes.len()];
        let mut rotations = BTreeMap::new();
        for (index, bone) in bone_of.iter().enumerate() {
            let parent = self.hierarchy.parents[index];
            let above = parent.map_or(Quat::IDENTITY, |parent| turned[parent]);
            let turn = bone.and_then(|bone| self.turns.get(&bone));
            let turn = turn.map_or(above, |turn| turn.rotation);
            turned.push(turn);
            let position = parent.map_or(self.positions[index], |parent| {
                pose.node_to_world[parent].w_axis.truncate() + above * (self.positions[index] - self.positions[parent])
            });
            let rotation = turn * self.rotations[index];
            let rest_rotation = rotation_of(&pose.node_to_world[index]);
            if let Some(parent) = parent {
                from_rest[index] = from_rest[parent];
            }
            if let Some(bone) = bone {
                let all = rotation * rest_rotation.inverse();
                rotations.insert(*bone, (all * from_rest[index].inverse()).normalize());
                from_rest[index] = all;
            }
            // What the reference pose scales and shears stays.
            let linear = &reference.node_to_world[index];
            let shape = Mat4::from_quat(rotation_of(linear).inverse()) * Mat4::from_mat3(Mat3::from_mat4(*linear));
            pose.node_to_world[index] = Mat4::from_rotation_translation(rotation, position) * shape;
            let parent_to_world = parent.map_or(Mat4::IDENTITY, |parent| pose.node_to_world[parent]);
            let node_to_parent = parent_to_world.inverse() * pose.node_to_world[index];
            if node_to_parent.is_finite() {
                pose.node_to_parent[index] = node_to_parent;
            }
        }
        let bone = |(bone, turn): (Bone, Turn)| {
            let made = TPoseBone {
                joint: self.bones[&bone],
                rotation: rotations[&bone],
                confidence: turn.confidence,
                reason: turn.reason,
                reference_to_t_pose: turn.rotation,
            };
            (bone, made)
        };
        TPose {
            source: self.source,
            pose,
            bones: self.turns.into_iter().map(bone).collect(),
            axes: self.axes,
            positions: self.positions,
            rotations: self.rotations,
        }
    }
}

/// The direction in which a bone points in the T-pose, in its frame; `None` for one that is not turned there.
pub(crate) fn direction(bone: Bone) -> Option<Vec3> {
    let outwards = if bone.side() == Some(Side::Right) {
        Vec3::NEG_X
    } else {
        Vec3::X
    };
    match bone.on(Side::Left) {
        Bone::LeftUpperLeg | Bone::LeftLowerLeg => Some(Vec3::NEG_Y),
        Bone::LeftUpperArm | Bone::LeftLowerArm | Bone::LeftHand => Some(outwards),
        Bone::LeftThumbMetacarpal | Bone::LeftThumbProximal | Bone::LeftThumbDistal => {
            Some((outwards + Vec3::Z).normalize())
        }
        finger if finger.is_finger() => Some(outwards),
        _ => None,
    }
}

/// The knuckles towards which a hand points: the first that is known.
const POINTING_KNUCKLES: [Bone; 4] = [
    Bone::LeftMiddleProximal,
    Bone::LeftIndexProximal,
    Bone::LeftRingProximal,
    Bone::LeftLittleProximal,
];

/// The node towards which a bone points: the next bone, else the only child of its joint.
pub(crate) fn next(
    hierarchy: &Hierarchy,
    bones: &BTreeMap<Bone, NodeId>,
    knuckles: &Knuckles,
    bone: Bone,
    joint: NodeId,
) -> Option<NodeId> {
    let side = bone.side().unwrap_or(Side::Left);
    let of_hand: &[Bone] = match bone.on(Side::Left) {
        Bone::LeftHand => &POINTING_KNUCKLES,
        _ => &[],
    };
    let of_hand = of_hand.iter().filter_map(|knuckle| knuckles.of(knuckle.on(side)));
    let next = limb_end(bone).or_else(|| next_of_finger(bone));
    let mut named = of_hand.chain(next.and_then(|next| bones.get(&next).copied()));
    named
        .find(|next| hierarchy.is_below(*next, joint))
        .or_else(|| hierarchy.only_child(joint))
}

/// The bone that ends a bone of a limb.
pub(crate) fn limb_end(bone: Bone) -> Option<Bone> {
    let next = match bone.on(Side::Left) {
        Bone::LeftUpperLeg => Bone::LeftLowerLeg,
        Bone::LeftLowerLeg => Bone::LeftFoot,
        Bone::LeftUpperArm => Bone::LeftLowerArm,
        Bone::LeftLowerArm => Bone::LeftHand,
        _ => return None,
    };
    Some(next.on(bone.side()?))
}

/// The next bone of a finger.
fn next_of_finger(bone: Bone) -> Option<Bone> {
    let mut bones = Bone::ALL.iter().copied();
    bones.find(|next| next.is_finger() && bone.is_finger() && next.parent() == Some(bone))
}
