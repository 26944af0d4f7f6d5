//! The data of a robot: links, joints, inertia and shapes.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3, Mat4};
use serde::Serialize;

use super::report::DataLoss;
use super::{Format, Mesh};
use crate::error::Diagnostic;

/// A robot as its file describes it, in metres and radians, with +Z up.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::Importer;
/// use mocap::retarget::robot::{JointKind, ShapeKind};
///
/// let robot = Importer::new().import_robot("fixtures/robots/h1.urdf")?;
/// let elbow = robot.links.iter().find(|link| link.joint.name == "left_elbow_joint").unwrap();
/// assert_eq!(elbow.joint.kind, JointKind::Hinge);
/// let limits = elbow.joint.limits;
/// assert_eq!((limits.lower, limits.upper), (-1.25, 2.61));
/// assert!(elbow.inertial.is_some_and(|inertial| inertial.mass > 0.5));
/// assert!(robot.links.iter().flat_map(|link| &link.shapes).any(|shape| matches!(shape.kind, ShapeKind::Mesh { .. })));
/// // The elbow bent by a right angle, in the space of the link above.
/// let bent = elbow.joint.link_to_parent(std::f64::consts::FRAC_PI_2);
/// assert!(bent.rotation.angle_between(elbow.joint.link_to_parent(0.0).rotation) > 1.5);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Robot {
    /// The name of the robot, as the file states it.
    pub name: String,
    /// The links in depth-first order: the base first, parents before their children.
    pub links: Vec<RobotLink>,
    /// The format of the file from which the robot was read.
    #[serde(with = "crate::scene::format_name")]
    pub format: Option<Format>,
    /// The warnings of the reader.
    pub warnings: Vec<Diagnostic>,
    /// Data that the file has and the robot lacks.
    #[doc(hidden)]
    #[serde(skip)]
    pub lost: Vec<DataLoss>,
}

/// A rigid body, and the joint that connects it to its parent.
///
/// [`Robot`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RobotLink {
    /// The name; in MJCF, the name of the body.
    pub name: String,
    /// The parent, an index into [`Robot::links`]; absent for the base.
    pub parent: Option<usize>,
    /// The joint to the parent; for the base, the joint to the world.
    pub joint: RobotJoint,
    /// Mass and inertia, if the file states them.
    pub inertial: Option<Inertial>,
    /// The shapes of the link.
    pub shapes: Vec<RobotShape>,
    /// The line of the file, from 1.
    pub line: usize,
}

/// The kind of motion of a joint.
///
/// [`Robot`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum JointKind {
    /// No motion.
    #[default]
    Fixed,
    /// Rotation about an axis: URDF's revolute and continuous.
    Hinge,
    /// Translation along an axis: URDF's prismatic.
    Slide,
    /// Free motion: the base of a walking robot.
    Floating,
}

/// A joint between two links.
///
/// [`Robot`] has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotJoint {
    /// The name of the joint.
    pub name: String,
    /// The kind of motion that the joint allows.
    pub kind: JointKind,
    /// The transform from the link to its parent at joint position 0.
    pub origin: Placement,
    /// A point on the axis, in the axes of the link. For URDF, the origin.
    pub anchor: DVec3,
    /// The unit vector of the axis, in the axes of the link.
    pub axis: DVec3,
    /// The limits. If other joints follow this one, the limits are narrowed so that the followers stay within their own
    /// limits.
    pub limits: JointLimits,
    /// The inertia that the motor adds to the joint: about the axis of a hinge in kilogram square metres, along the
    /// axis of a slide joint in kilograms. For the base, the value applies in all directions. MJCF: armature.
    pub armature: f64,
    /// The joint that this joint follows; `None` if this joint is free. URDF: mimic.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mimic: Option<Mimic>,
}

/// A joint whose position is `multiplier * leader + offset`.
///
/// [`Robot`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Mimic {
    /// The link whose joint is followed, an index into [`Robot::links`]. The leader follows no other joint.
    pub leader: usize,
    /// The factor for the leader's position.
    pub multiplier: f64,
    /// The offset in radians or metres.
    pub offset: f64,
}

/// The limits of a joint, in radians or metres.
///
/// [`Robot`] has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JointLimits {
    /// The smallest position; minus infinity without a limit.
    pub lower: f64,
    /// The largest position; infinity without a limit.
    pub upper: f64,
    /// The largest velocity, in radians or metres per second.
    pub velocity: Option<f64>,
    /// The largest torque or force, in newton metres or newtons.
    pub effort: Option<f64>,
}

/// A rotation and a translation.
///
/// [`Robot`] has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Placement {
    /// The rotation.
    pub rotation: DQuat,
    /// The translation.
    pub translation: DVec3,
}

/// Mass and inertia of a link.
///
/// [`Robot`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Inertial {
    /// The mass, in kilograms.
    pub mass: f64,
    /// The centre of mass and the axes of the inertia, relative to the link.
    pub origin: Placement,
    /// The inertia about the centre of mass, in these axes: xx, yy, zz, xy, xz, yz.
    pub inertia: [f64; 6],
}

/// A shape of a link.
///
/// [`Robot`] has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotShape {
    /// The pose of the shape relative to the link.
    pub origin: Placement,
    /// The kind of shape.
    pub kind: ShapeKind,
    /// Whether the shape collides, or is only visible.
    pub collides: bool,
}

impl RobotShape {
    /// A colliding shape at the origin of its link.
    pub fn new(kind: ShapeKind) -> Self {
        Self {
            origin: Placement::default(),
            kind,
            collides: true,
        }
    }
}

/// A geometric shape about the origin. Cylinders and capsules are along Z.
///
/// [`Robot`] has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "each says itself")]
pub enum ShapeKind {
    Sphere {
        radius: f64,
    },
    Capsule {
        radius: f64,
        /// Half the length without the caps.
        half_length: f64,
    },
    Cylinder {
        radius: f64,
        half_length: f64,
    },
    Box {
        half_size: DVec3,
    },
    Ellipsoid {
        half_size: DVec3,
    },
    Mesh {
        /// The file name, as written.
        file: String,
        /// The smallest and the largest vertex coordinates, if the file exists and can be read.
        bounds: Option<[DVec3; 2]>,
        /// The factors for the vertex coordinates along x, y and z.
        scale: DVec3,
        /// The path of the file, if it exists.
        #[serde(skip)]
        path: Option<PathBuf>,
        /// The triangles of the mesh, relative to the shape, if `Importer::robot_meshes` is set.
        #[serde(skip)]
        surface: Option<Arc<Mesh>>,
    },
}

impl Placement {
    /// No rotation and no translation.
    pub const IDENTITY: Self = Self {
        rotation: DQuat::IDENTITY,
        translation: DVec3::ZERO,
    };

    /// Combines two placements: first `inner`, then this placement.
    pub fn then(&self, inner: &Self) -> Self {
        Self {
            rotation: (self.rotation * inner.rotation).normalize(),
            translation: self.point(inner.translation),
        }
    }

    /// The matrix from the inner to the outer coordinate frame, in the precision of a scene.
    pub fn to_matrix(self) -> Mat4 {
        Mat4::from_rotation_translation(self.rotation.as_quat(), self.translation.as_vec3())
    }

    /// Converts a point from the inner to the outer coordinate frame.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.translation + self.rotation * point
    }

    /// Converts a point from the outer to the inner coordinate frame.
    pub fn to_inner(&self, point: DVec3) -> DVec3 {
        self.rotation.inverse() * (point - self.translation)
    }
}

impl Default for Placement {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Default for JointLimits {
    fn default() -> Self {
        Self {
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            velocity: None,
            effort: None,
        }
    }
}

impl Default for RobotJoint {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: JointKind::Fixed,
            origin: Placement::IDENTITY,
            anchor: DVec3::ZERO,
            axis: DVec3::Z,
            limits: JointLimits::default(),
            armature: 0.0,
            mimic: None,
        }
    }
}

impl RobotJoint {
    /// Whether the joint's position is one number.
    pub fn moves(&self) -> bool {
        matches!(self.kind, JointKind::Hinge | JointKind::Slide)
    }

    /// The transform from the link to its parent at joint position `position`.
    pub fn link_to_parent(&self, position: f64) -> Placement {
        let motion = match self.kind {
            JointKind::Hinge => {
                let rotation = DQuat::from_axis_angle(self.axis, position);
                Placement {
                    rotation,
                    translation: self.anchor - rotation * self.anchor,
                }
            }
            JointKind::Slide => Placement {
                rotation: DQuat::IDENTITY,
                translation: position * self.axis,
            },
            JointKind::Fixed | JointKind::Floating => return self.origin,
        };
        self.origin.then(&motion)
    }

    /// The position within the limits that is nearest to 0.
    pub fn rest(&self) -> f64 {
        0.0_f64.max(self.limits.lower).min(self.limits.upper)
    }
}

impl Inertial {
    /// The longest side of a link, in metres. An inertia that needs a larger box is a placeholder, such as ixx="1".
    const LONGEST: f64 = 1.0;

    /// [`Self::equivalent_box`], unless it is implausibly large for a link.
    pub fn plausible_box(&self) -> Option<(Placement, DVec3)> {
        let found = self.equivalent_box();
        found.filter(|(_, half_size)| 2.0 * half_size.max_element() <= Self::LONGEST)
    }

    /// The inertia about the centre of mass as a matrix, in the axes of `origin`.
    pub fn matrix(&self) -> DMat3 {
        let [xx, yy, zz, xy, xz, yz] = self.inertia;
        DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
    }

    /// The moments of inertia about the principal axes.
    pub fn moments(&self) -> DVec3 {
        principal(self.matrix()).0
    }

    /// The box of uniform density with this mass and inertia: its placement relative to the link, and half its sides.
    pub fn equivalent_box(&self) -> Option<(Placement, DVec3)> {
        let (moments, axes) = principal(self.matrix());
        let total = moments.element_sum();
        let squares = (DVec3::splat(total) - 2.0 * moments) * (1.5 / self.mass);
        let origin = Placement {
            rotation: (self.origin.rotation * axes).normalize(),
            translation: self.origin.translation,
        };
        let half_size = squares.max(DVec3::ZERO).map(f64::sqrt);
        (self.mass > 0.0 && half_size.is_finite() && half_size != DVec3::ZERO).then_some((origin, half_size))
    }
}

impl RobotShape {
    /// Spheres whose hull covers the shape, relative to the link: centres and radii. The hull may be a little larger.
    pub fn balls(&self) -> Vec<(DVec3, f64)> {
        let of_box = |low: DVec3, high: DVec3| {
            let corner = |index: usize| {
                let pick = |bit: usize, low: f64, high: f64| if index & bit == 0 { low } else { high };
                DVec3::new(pick(1, low.x, high.x), pick(2, low.y, high.y), pick(4, low.z, high.z))
            };
            (0..8).map(|index| (corner(index), 0.0)).collect()
        };
        let balls: Vec<(DVec3, f64)> = match &self.kind {
            ShapeKind::Sphere { radius } => vec![(DVec3::ZERO, *radius)],
            ShapeKind::Capsule { radius, half_length } => {
                let end = DVec3::Z * *half_length;
                vec![(end, *radius), (-end, *radius)]
            }
            ShapeKind::Cylinder { radius, half_length } => {
                let half_size = DVec3::new(*radius, *radius, *half_length);
                of_box(-half_size, half_size)
            }
            ShapeKind::Box { half_size } | ShapeKind::Ellipsoid { half_size } => of_box(-*half_size, *half_size),
            ShapeKind::Mesh { bounds, .. } => bounds.map(|[low, high]| of_box(low, high)).unwrap_or_default(),
        };
        let placed = balls.into_iter();
        placed
            .map(|(centre, radius)| (self.origin.point(centre), radius))
            .collect()
    }
}

/// The principal moments and axes of a symmetric matrix, by Jacobi rotations.
fn principal(mut matrix: DMat3) -> (DVec3, DQuat) {
    /// The number of Jacobi sweeps. The sweeps converge quadratically: a 3 by 3 matrix needs four.
    const SWEEPS: usize = 16;
    let mut axes = DQuat::IDENTITY;
    for _ in 0..SWEEPS {
        for (a, b) in [(0, 1), (0, 2), (1, 2)] {
            let off = matrix.col(b)[a];
            let angle = 0.5 * (2.0 * off).atan2(matrix.col(a)[a] - matrix.col(b)[b]);
            let axis = [DVec3::Z, DVec3::NEG_Y, DVec3::X][a + b - 1];
            let turn = DQuat::from_axis_angle(axis, angle);
            let turned = DMat3::from_quat(turn);
            matrix = turned.transpose() * matrix * turned;
            axes *= turn;
        }
    }
    let moments = DVec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z);
    (moments, axes.normalize())
}

impl Robot {
    /// The links of joints with a position, in the order of the links.
    pub fn moving_joints(&self) -> Vec<usize> {
        let links = self.links.iter().enumerate();
        links
            .filter_map(|(index, link)| link.joint.moves().then_some(index))
            .collect()
    }

    /// The names of joints with a position, in the order of the links. Outputs have this order in `dof_pos`.
    pub fn dof_names(&self) -> Vec<String> {
        let joints = self.moving_joints().into_iter();
        joints.map(|link| self.links[link].joint.name.clone()).collect()
    }

    /// The placements of all links with every joint at 0, regardless of limits. They start at the origin of the base,
    /// with the rotation that the file states.
    pub fn zero_pose(&self) -> Vec<Placement> {
        let mut transforms: Vec<Placement> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            let origin = match link.parent {
                Some(parent) => transforms[parent].then(&link.joint.link_to_parent(0.0)),
                None => Placement {
                    translation: DVec3::ZERO,
                    ..link.joint.origin
                },
            };
            transforms.push(origin);
        }
        transforms
    }
}
