//! Defines the joints of the human body as biomechanics does: the segments of the body, the rotations between them, and
//! the angles of these rotations.
//!
//! The coordinate frames follow the International Society of Biomechanics: +X forward, +Y up, +Z to the right, for a
//! standing body with hanging arms and palms forward.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, EulerRot};

use mocap_scene::scene::{HumanoidBone as Bone, Side};

/// A rigid part of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Segment {
    Pelvis,
    Trunk,
    Head,
    Thigh,
    Shank,
    Foot,
    UpperArm,
    Forearm,
    Hand,
}

impl Segment {
    const OF_TRUNK: [Self; 3] = [Self::Pelvis, Self::Trunk, Self::Head];
    const OF_SIDES: [Self; 6] = [
        Self::Thigh,
        Self::Shank,
        Self::Foot,
        Self::UpperArm,
        Self::Forearm,
        Self::Hand,
    ];

    /// The bones that can be the segment, the best first. If the segment has two sides, these are the bones of the left
    /// side.
    pub const fn bones(self) -> &'static [Bone] {
        match self {
            Self::Pelvis => &[Bone::Hips],
            Self::Trunk => &[Bone::UpperChest, Bone::Chest, Bone::Spine],
            Self::Head => &[Bone::Head],
            Self::Thigh => &[Bone::LeftUpperLeg],
            Self::Shank => &[Bone::LeftLowerLeg],
            Self::Foot => &[Bone::LeftFoot],
            Self::UpperArm => &[Bone::LeftUpperArm],
            Self::Forearm => &[Bone::LeftLowerArm],
            Self::Hand => &[Bone::LeftHand],
        }
    }

    /// The rotation from the anatomical coordinate frame of a right segment to its coordinate frame in the T-pose.
    pub fn to_t_pose(self) -> DQuat {
        let hanging = DQuat::from_rotation_x(-FRAC_PI_2);
        match self {
            Self::UpperArm => hanging,
            Self::Forearm | Self::Hand => hanging * DQuat::from_rotation_y(FRAC_PI_2),
            _ => DQuat::IDENTITY,
        }
    }
}

/// A segment of one side, or of the trunk.
pub type Part = (Segment, Option<Side>);

/// All segments of the body.
pub fn parts() -> impl Iterator<Item = Part> {
    let of_sides = |side: Side| Segment::OF_SIDES.map(move |segment| (segment, Some(side)));
    let of_trunk = Segment::OF_TRUNK.map(|segment| (segment, None));
    of_trunk
        .into_iter()
        .chain([Side::Left, Side::Right].into_iter().flat_map(of_sides))
}

/// The decomposition of a joint's rotation.
#[derive(Clone, Copy)]
pub enum Rotations {
    /// Rotations about Z, X and Y. Each angle is multiplied by the sign given here.
    Zxy([f64; 3]),
    /// Rotations about Y, X and Y. The angles are the plane of elevation, the elevation and the rotation.
    Yxy,
}

/// Two segments, and the names of the angles between them.
pub struct Joint {
    pub above: Segment,
    pub below: Segment,
    pub names: [&'static str; 3],
    pub rotations: Rotations,
}

impl Joint {
    const fn new(above: Segment, below: Segment, names: [&'static str; 3], rotations: Rotations) -> Self {
        Self {
            above,
            below,
            names,
            rotations,
        }
    }

    /// Every joint. Joints of both sides occur only once.
    pub(crate) fn all() -> impl Iterator<Item = &'static Self> + Clone {
        Self::OF_TRUNK.iter().chain(&Self::OF_SIDES)
    }

    /// Joints of the trunk.
    pub const OF_TRUNK: [Self; 2] = [
        Self::new(
            Segment::Pelvis,
            Segment::Trunk,
            ["lumbar_extension", "lumbar_bending", "lumbar_rotation"],
            Rotations::PLAIN,
        ),
        Self::new(
            Segment::Trunk,
            Segment::Head,
            ["neck_extension", "neck_bending", "neck_rotation"],
            Rotations::PLAIN,
        ),
    ];

    /// Joints of each side.
    pub const OF_SIDES: [Self; 7] = [
        Self::new(
            Segment::Pelvis,
            Segment::Thigh,
            ["hip_flexion", "hip_adduction", "hip_rotation"],
            Rotations::PLAIN,
        ),
        // A knee bends in the opposite direction to a hip or an elbow, but its flexion counts as positive.
        Self::new(
            Segment::Thigh,
            Segment::Shank,
            ["knee_angle", "knee_adduction", "knee_rotation"],
            Rotations::Zxy([-1.0, 1.0, 1.0]),
        ),
        Self::new(
            Segment::Shank,
            Segment::Foot,
            ["ankle_angle", "ankle_inversion", "ankle_rotation"],
            Rotations::PLAIN,
        ),
        Self::new(
            Segment::Trunk,
            Segment::UpperArm,
            ["arm_flex", "arm_add", "arm_rot"],
            Rotations::PLAIN,
        ),
        Self::new(
            Segment::Trunk,
            Segment::UpperArm,
            ["shoulder_plane", "shoulder_elevation", "shoulder_rotation"],
            Rotations::Yxy,
        ),
        Self::new(
            Segment::UpperArm,
            Segment::Forearm,
            ["elbow_flex", "elbow_carrying", "pro_sup"],
            Rotations::PLAIN,
        ),
        Self::new(
            Segment::Forearm,
            Segment::Hand,
            ["wrist_flex", "wrist_deviation", "wrist_rotation"],
            Rotations::PLAIN,
        ),
    ];
}

impl Rotations {
    pub const PLAIN: Self = Self::Zxy([1.0, 1.0, 1.0]);

    /// The rotation for three angles in degrees. An unknown angle is 0.
    pub(crate) fn back(self, degrees: [Option<f64>; 3]) -> DQuat {
        let [a, b, c] = degrees.map(|angle| angle.unwrap_or(0.0).to_radians());
        match self {
            Self::Zxy(signs) => DQuat::from_euler(EulerRot::ZXY, signs[0] * a, signs[1] * b, signs[2] * c),
            Self::Yxy => DQuat::from_euler(EulerRot::YXY, a, -b, c),
        }
    }

    /// The three angles of a rotation, in degrees. Several triples of angles give the same rotation. The triple nearest
    /// to `before`, the angles of the previous frame, is returned.
    pub fn of(self, rotation: DQuat, before: Option<[f64; 3]>) -> [f64; 3] {
        let radians = match self {
            Self::Zxy(signs) => {
                let (flexion, adduction, axial) = rotation.to_euler(EulerRot::ZXY);
                [signs[0] * flexion, signs[1] * adduction, signs[2] * axial]
            }
            Self::Yxy => elevation(rotation),
        };
        let mut degrees = radians.map(f64::to_degrees);
        for (angle, before) in degrees.iter_mut().zip(before.into_iter().flatten()) {
            *angle -= 360.0 * ((*angle - before) / 360.0).round();
        }
        degrees
    }
}

/// Plane of elevation, elevation and rotation of an upper arm. The elevation is a rotation about -X, which moves a
/// hanging right arm sideways, and counts as positive. In the other solution, the plane and the rotation differ by half
/// a circle.
fn elevation(rotation: DQuat) -> [f64; 3] {
    let (plane, about_x, axial) = rotation.to_euler(EulerRot::YXY);
    let half = if about_x > 0.0 { TAU / 2.0 } else { 0.0 };
    [plane + half, about_x.abs(), axial - half].map(|angle| (angle + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0)
}

/// Whether a joint has an angle of this name, without the ending of its side.
pub fn is_angle(name: &str) -> bool {
    Joint::all().any(|joint| joint.names.contains(&name))
}

/// The ending of a side's column names.
pub const fn ending(side: Option<Side>) -> &'static str {
    match side {
        Some(Side::Right) => "_r",
        Some(Side::Left) => "_l",
        None => "",
    }
}

/// The mirror image of a rotation in the plane between left and right.
pub fn mirrored(DQuat { x, y, z, w }: DQuat) -> DQuat {
    DQuat::from_xyzw(-x, -y, z, w)
}

/// The rotation of a forearm if the file has no angle for it, in degrees. The thumb of a hanging hand then points
/// forward.
const RELAXED_FOREARM: f64 = 90.0;

/// The rotations of all bones from the T-pose to a pose with given joint angles. They are in the axes of the T-pose: +X
/// left, +Y up, +Z forward. The rotation of the hips is relative to the world, and any other rotation is relative to
/// the parent bone. `angle` gives an angle in degrees for a column name of `biomechanics::JointAngles`. A joint without
/// angles has its rotation in a body that stands with hanging arms.
pub fn rotations_of(angle: &dyn Fn(&str) -> Option<f64>) -> Vec<(Bone, DQuat)> {
    let pelvis = Rotations::PLAIN.back(["pelvis_tilt", "pelvis_list", "pelvis_rotation"].map(angle));
    let mut all = vec![(Bone::Hips, to_t_pose_axes(pelvis))];
    for (segment, side) in parts().filter(|(segment, _)| *segment != Segment::Pelvis) {
        let angles_of = |joint: &Joint| joint.names.map(|name| angle(&format!("{name}{}", ending(side))));
        // A file may state the angles of a shoulder in one of two ways.
        let mut joints = Joint::all().filter(|joint| joint.below == segment);
        let has_angles = |joint: &&Joint| angles_of(joint).iter().any(Option::is_some);
        let Some(joint) = joints.clone().find(has_angles).or_else(|| joints.next()) else {
            continue;
        };
        let mut angles = angles_of(joint);
        if segment == Segment::Forearm {
            angles[2] = angles[2].or(Some(RELAXED_FOREARM));
        }
        let turned = joint.above.to_t_pose() * joint.rotations.back(angles) * segment.to_t_pose().inverse();
        let turned = if side == Some(Side::Left) {
            mirrored(turned)
        } else {
            turned
        };
        let bone = segment.bones()[0];
        all.push((side.map_or(bone, |side| bone.on(side)), to_t_pose_axes(turned)));
    }
    all
}

/// Converts a rotation from the axes of the International Society of Biomechanics to the axes of the T-pose.
fn to_t_pose_axes(DQuat { x, y, z, w }: DQuat) -> DQuat {
    DQuat::from_xyzw(-z, y, x, w)
}
