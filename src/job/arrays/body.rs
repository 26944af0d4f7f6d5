//! Humanoid motion in the layouts of other programs: AMASS, SMPL-X, HumanML3D. `skeletons` has the layouts with other
//! joints.

use std::collections::BTreeMap;
use std::str::FromStr;

use glam::{DQuat, DVec3, Quat, Vec3};
use mocap_figure::Humanoid;
use mocap_figure::convert::Conversion;
use mocap_figure::vrm_humanoid::vrm_humanoid_shown;
use mocap_formats::SMPL_ROOT;
use mocap_formats::humanml3d;
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::math::up_axis::turn_to_y_up;
use mocap_scene::pose::Pose;
use mocap_scene::scene::joint_tables::{Joint, smpl, soma};
use mocap_scene::scene::{HumanoidBone as Bone, Scene, UpAxis};

use super::mhr::{Posed, own_mhr};
use super::npz;

/// A layout of arrays for the motion of a humanoid. [`BodyArrays`] has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BodyLayout {
    /// AMASS: the arrays `poses` (frames, 165), with the rotations of SMPL-X, and `trans`. +Z is up.
    Amass,
    /// SMPL-X's dictionary: `global_orient`, `body_pose`, hands, jaw, eyes and `transl`. +Y is up.
    Smplx,
    /// Kimodo: `posed_joints`, `global_rot_mats`, `local_rot_mats` and `root_positions`, for the 22 body joints of
    /// SMPL-X.
    Kimodo,
    /// Kimodo's arrays of the 77 joints of SOMA.
    Soma,
    /// SAM 3D Body: `pred_joint_coords`, `pred_global_rots` and `pred_cam_t`, for the 127 joints of MHR.
    Mhr,
    /// HumanML3D: 263 numbers a frame, at 20 frames a second.
    HumanMl3d,
}

impl BodyLayout {
    /// Every layout.
    pub const ALL: [Self; 6] = [
        Self::Amass,
        Self::Smplx,
        Self::Kimodo,
        Self::Soma,
        Self::Mhr,
        Self::HumanMl3d,
    ];

    /// The name that users type.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Amass => "amass",
            Self::Smplx => "smplx",
            Self::Kimodo => "kimodo",
            Self::Soma => "soma",
            Self::Mhr => "mhr",
            Self::HumanMl3d => "humanml3d",
        }
    }

    /// The extension of the files in this layout.
    pub const fn extension(self) -> &'static str {
        match self {
            Self::HumanMl3d => "npy",
            _ => "npz",
        }
    }

    /// The number of joints in a file.
    #[doc(hidden)]
    pub const fn joints(self) -> usize {
        match self {
            Self::Amass | Self::Smplx => ALL_JOINTS,
            Self::Kimodo | Self::HumanMl3d => BODY_JOINTS,
            Self::Soma => SOMA_JOINTS,
            Self::Mhr => MHR_JOINTS,
        }
    }

    /// A note for users about the assumptions of this layout: flat hands and a mean body shape. `None` for a layout
    /// without assumptions.
    #[doc(hidden)]
    pub fn note(self) -> Option<String> {
        let text = "hands: finger rotations are relative to a flat hand; the shape of the body is the mean (betas 0)";
        matches!(self, Self::Amass | Self::Smplx).then(|| text.to_owned())
    }
}

impl FromStr for BodyLayout {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|layout| layout.as_str() == name)
            .ok_or_else(|| {
                Diagnostic::new(Code::InvalidValue, format!("\"{name}\" is not a layout of arrays"))
                    .expected_found("amass, smplx, kimodo, soma, mhr or humanml3d", name)
                    .into()
            })
    }
}

/// Humanoid motion on the joints of SMPL-X. Rotations are relative to the T-pose.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::arrays::{BodyArrays, BodyLayout};
///
/// let scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// let body = BodyArrays::new(&scene)?;
/// assert_eq!((body.frames, body.poses.len()), (75, 75 * 55 * 3));
/// assert!(body.write(BodyLayout::Amass)?.starts_with(b"PK"));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyArrays {
    /// The number of frames.
    pub frames: usize,
    /// Frames per second.
    pub frame_rate: f64,
    /// Rotations of the 55 joints of SMPL-X relative to their parents, as axis-angle vectors in radians: frames x 55 x
    /// 3, +Y up. Finger rotations are relative to a flat hand. Joints that the body lacks have no rotation.
    pub poses: Vec<f64>,
    /// The position of the pelvis in metres, +Y up: frames x 3.
    pub root: Vec<f64>,
    /// The rest positions of the joints in metres, in the axes of SMPL's template: 55 x 3.
    pub rest_joints: Vec<f64>,
    joints: Vec<Joint>,
    /// All frames of a source whose joints are the joints of MHR. `None` for any other source.
    pub(super) own_mhr: Option<Vec<Posed>>,
}

/// The number of joints of SMPL-X, with hands, jaw and eyes.
const ALL_JOINTS: usize = 55;

/// The number of joints of the body without the hands: the joints of SMPL, except its two hand joints.
const BODY_JOINTS: usize = 22;

/// The number of joints of SOMA's full set.
const SOMA_JOINTS: usize = 77;

/// The number of joints of the Momentum Human Rig.
const MHR_JOINTS: usize = 127;

impl BodyArrays {
    /// Takes the first animation of a scene, with any unit and any up axis.
    ///
    /// # Errors
    /// [`Code::NotHumanoid`] if no humanoid is found; [`Code::NoMotion`] if the scene has no motion.
    pub fn new(scene: &Scene) -> Result<Self> {
        let mut scene = scene.clone();
        scene.animations.truncate(1);
        Conversion::new().apply(&mut scene)?;
        Self::of_humanoid(&scene, None, None)
    }

    /// As [`new`](Self::new), for a scene in metres with +Y up. If the scene has only a part of the motion's frames,
    /// `whole` has all frames, which show the T-pose. `known` has the bones, if the caller knows the bones.
    pub(crate) fn of_humanoid(scene: &Scene, whole: Option<&Scene>, known: Option<Humanoid>) -> Result<Self> {
        let body = vrm_humanoid_shown(scene, whole, known)?;
        let Some(animation) = body.animations.first() else {
            return Err(Diagnostic::new(Code::NoMotion, "there is no motion to write").into());
        };
        let joints = smpl(ALL_JOINTS).unwrap_or_default();
        let nodes: BTreeMap<Bone, usize> = (body.nodes.iter().enumerate())
            .filter_map(|(index, node)| Some((node.humanoid_bone?, index)))
            .collect();
        let node = |joint: &Joint| joint.bone.and_then(|bone| nodes.get(&bone).copied());
        let rest = rest_joints(&joints, &Pose::rest(&body), &node);
        let frames = animation.frame_count();
        let mut made = Self {
            frames,
            frame_rate: animation.ticks_per_second,
            poses: Vec::with_capacity(frames * ALL_JOINTS * 3),
            root: Vec::with_capacity(frames * 3),
            rest_joints: rest
                .iter()
                .flat_map(|root_position| root_position.as_dvec3().to_array())
                .collect(),
            joints,
            own_mhr: own_mhr(scene),
        };
        for frame in 0..frames {
            let Some(pose) = Pose::at_tick(&body, 0, frame as f64) else {
                break;
            };
            let mut world: Vec<DQuat> = Vec::with_capacity(ALL_JOINTS);
            for joint in &made.joints {
                let above = joint.parent.map_or(DQuat::IDENTITY, |parent| world[parent]);
                let own = node(joint).map_or(above, |node| {
                    Quat::from_mat4(&pose.node_to_world[node]).as_dquat().normalize()
                });
                world.push(own);
                made.poses
                    .extend(rotation_vector((above.inverse() * own).normalize()).to_array());
            }
            let hips = made
                .joints
                .first()
                .and_then(node)
                .map_or(Vec3::ZERO, |node| pose.node_to_world[node].w_axis.truncate());
            made.root.extend(hips.as_dvec3().to_array());
        }
        Ok(made)
    }

    /// The motion as the bytes of a file in a layout.
    ///
    /// # Errors
    /// [`Code::NoMotion`] for HumanML3D with fewer than two frames.
    pub fn write(&self, layout: BodyLayout) -> Result<Vec<u8>> {
        match layout {
            BodyLayout::Amass => Ok(self.amass()),
            BodyLayout::Smplx => Ok(self.smplx()),
            BodyLayout::Kimodo => Ok(self.kimodo(smpl(BODY_JOINTS).unwrap_or_default())),
            BodyLayout::Soma => Ok(self.kimodo(soma(SOMA_JOINTS).unwrap_or_default())),
            BodyLayout::Mhr => Ok(self.mhr()),
            BodyLayout::HumanMl3d => self.humanml3d(),
        }
    }

    fn vector(&self, frame: usize, joint: usize) -> DVec3 {
        DVec3::from_slice(&self.poses[3 * (frame * ALL_JOINTS + joint)..][..3])
    }

    pub(super) fn rest(&self, joint: usize) -> DVec3 {
        DVec3::from_slice(&self.rest_joints[3 * joint..][..3])
    }

    pub(super) fn root_position(&self, frame: usize) -> DVec3 {
        DVec3::from_slice(&self.root[3 * frame..][..3])
    }

    pub(super) fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The world rotation of every joint in a frame.
    pub(super) fn rotations_to_world(&self, frame: usize) -> Vec<DQuat> {
        let mut world: Vec<DQuat> = Vec::with_capacity(self.joints.len());
        for (index, joint) in self.joints.iter().enumerate() {
            let above = joint.parent.map_or(DQuat::IDENTITY, |parent| world[parent]);
            world.push(above * DQuat::from_scaled_axis(self.vector(frame, index)));
        }
        world
    }

    /// The axis-angle vectors of the joints `first..last` in every frame.
    fn columns(&self, first: usize, last: usize) -> Vec<f64> {
        let row = |frame: usize| &self.poses[3 * (frame * ALL_JOINTS + first)..3 * (frame * ALL_JOINTS + last)];
        (0..self.frames).flat_map(row).copied().collect()
    }

    fn amass(&self) -> Vec<u8> {
        let to_z_up = turn_to_y_up(UpAxis::Z).inverse();
        let mut poses = self.poses.clone();
        let mut trans = Vec::with_capacity(self.root.len());
        for frame in 0..self.frames {
            let root = to_z_up * DQuat::from_scaled_axis(self.vector(frame, 0));
            poses[3 * frame * ALL_JOINTS..][..3].copy_from_slice(&rotation_vector(root.normalize()).to_array());
            trans.extend((to_z_up * self.root_position(frame) - self.rest(0)).to_array());
        }
        let frames = self.frames;
        npz::of_doubles(
            &[
                ("poses", &[frames, 3 * ALL_JOINTS], &poses),
                ("trans", &[frames, 3], &trans),
                ("betas", &[16], &[0.0; 16]),
                ("mocap_frame_rate", &[], &[self.frame_rate]),
                ("rest_joints", &[ALL_JOINTS, 3], &self.rest_joints),
            ],
            &[("gender", "neutral"), ("surface_model_type", "smplx")],
        )
    }

    fn smplx(&self) -> Vec<u8> {
        let frames = self.frames;
        let transl: Vec<f64> = (0..frames)
            .flat_map(|frame| (self.root_position(frame) - self.rest(0)).to_array())
            .collect();
        let parts = [
            ("global_orient", 0, 1),
            ("body_pose", 1, 22),
            ("jaw_pose", 22, 23),
            ("leye_pose", 23, 24),
            ("reye_pose", 24, 25),
            ("left_hand_pose", 25, 40),
            ("right_hand_pose", 40, 55),
        ];
        let columns = parts.map(|(name, first, last)| (name, [frames, 3 * (last - first)], self.columns(first, last)));
        let mut arrays: Vec<(&str, &[usize], &[f64])> = columns
            .iter()
            .map(|(name, shape, values)| (*name, &shape[..], &values[..]))
            .collect();
        let (shape, rate) = ([frames, 3], [self.frame_rate]);
        arrays.extend([
            ("transl", &shape[..], &transl[..]),
            ("betas", &[10][..], &[0.0; 10][..]),
            ("fps", &[][..], &rate[..]),
            ("rest_joints", &[ALL_JOINTS, 3][..], &self.rest_joints[..]),
        ]);
        npz::of_doubles(&arrays, &[("gender", "neutral")])
    }

    /// The positions of the joints of the body in a frame.
    fn posed(&self, frame: usize) -> [DVec3; BODY_JOINTS] {
        let world = self.rotations_to_world(frame);
        let mut positions = [self.root_position(frame); BODY_JOINTS];
        for joint in 0..BODY_JOINTS {
            if let Some(parent) = self.joints[joint].parent {
                positions[joint] = positions[parent] + world[parent] * (self.rest(joint) - self.rest(parent));
            }
        }
        positions
    }

    /// The motion as an `.npy` of HumanML3D. For each time at 20 frames per second, uses the nearest frame.
    fn humanml3d(&self) -> Result<Vec<u8>> {
        let step = self.frame_rate / humanml3d::RATE;
        let count = ((self.frames.max(1) - 1) as f64 / step) as usize + 1;
        let nearest = |index: usize| ((index as f64 * step).round() as usize).min(self.frames - 1);
        let frames: Vec<[DVec3; BODY_JOINTS]> = (0..count).map(|index| self.posed(nearest(index))).collect();
        let rows = humanml3d::numbers(&frames);
        if rows.is_empty() {
            let message = "HumanML3D needs two frames at 20 frames per second, and the motion is shorter";
            return Err(Diagnostic::new(Code::NoMotion, message).into());
        }
        let values: Vec<f32> = rows.iter().flatten().copied().collect();
        Ok(npz::npy_of_floats(&[rows.len(), humanml3d::NUMBERS], &values))
    }
}

/// The rest positions of the joints. A joint that the body lacks is at its parent. The pelvis has its position in
/// SMPL's template.
fn rest_joints(joints: &[Joint], rest: &Pose, node: &dyn Fn(&Joint) -> Option<usize>) -> Vec<Vec3> {
    let mut positions: Vec<Vec3> = Vec::with_capacity(joints.len());
    let neck = joints
        .iter()
        .find(|joint| joint.bone == Some(Bone::Neck))
        .and_then(node);
    let neck = neck.map(|node| rest.node_to_world[node].w_axis.truncate());
    for joint in joints {
        let own = node(joint).map(|node| rest.node_to_world[node].w_axis.truncate());
        let above = joint.parent.map_or(Vec3::ZERO, |parent| positions[parent]);
        // If the spine has fewer joints, a missing joint is halfway from its parent to the neck.
        let is_spine = matches!(joint.bone, Some(Bone::Spine | Bone::Chest | Bone::UpperChest));
        let lacking = || {
            if is_spine {
                neck.map_or(above, |neck| above.midpoint(neck))
            } else {
                above
            }
        };
        positions.push(own.unwrap_or_else(lacking));
    }
    let shift = SMPL_ROOT - positions.first().copied().unwrap_or_default();
    positions.iter().map(|root_position| *root_position + shift).collect()
}
