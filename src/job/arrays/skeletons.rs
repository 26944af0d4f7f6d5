//! The motion of a body on the joints of Kimodo, SOMA and MHR.

use glam::{DMat3, DQuat, DVec3};
use mocap_formats::{MHR_ROOT_HEIGHT, mhr_frames};
use mocap_scene::scene::joint_tables::{Joint, mhr};

use super::body::BodyArrays;
use super::mhr::Posed;
use super::npz;

/// The joints of Kimodo, SOMA or MHR, matched with the joints of a body.
struct Skeleton {
    joints: Vec<Joint>,
    /// For each of `joints`, the index of the body's joint that is the same bone; `None` if the body lacks the bone.
    same: Vec<Option<usize>>,
    rest: Vec<DVec3>,
}

impl Skeleton {
    /// A joint that the body lacks is halfway between its parent and its child, if the body has the child. A twist
    /// joint is at the child. If the body lacks the child too, the joint is at its parent.
    fn new(body: &BodyArrays, joints: Vec<Joint>) -> Self {
        let of_bone = |joint: &Joint| body.joints().iter().position(|own| own.bone == joint.bone);
        let same: Vec<Option<usize>> = (joints.iter())
            .map(|joint| joint.bone.and_then(|_| of_bone(joint)))
            .collect();
        let mut rest: Vec<DVec3> = Vec::with_capacity(joints.len());
        for (index, joint) in joints.iter().enumerate() {
            let above = joint.parent.map_or(DVec3::ZERO, |parent| rest[parent]);
            let below = (0..joints.len()).find(|below| joints[*below].parent == Some(index));
            rest.push(match (same[index], below.and_then(|below| same[below])) {
                (Some(own), _) => body.rest(own),
                (None, Some(below)) if joint.name.ends_with("_twist") => body.rest(below),
                (None, Some(below)) if joint.parent.is_some() => above.midpoint(body.rest(below)),
                (None, _) => above,
            });
        }
        Self { joints, same, rest }
    }

    /// World rotations and positions of the joints.
    fn posed(&self, body: &BodyArrays, frame: usize) -> Posed {
        let own = body.rotations_to_world(frame);
        let (mut world, mut positions) = (Vec::<DQuat>::new(), Vec::<DVec3>::new());
        for (index, joint) in self.joints.iter().enumerate() {
            let above = joint.parent.map_or(DQuat::IDENTITY, |parent| world[parent]);
            world.push(self.same[index].map_or(above, |same| own[same]));
            positions.push(match (self.same[index], joint.parent) {
                (Some(0), _) => body.root_position(frame),
                (_, None) => DVec3::ZERO,
                (_, Some(parent)) => positions[parent] + above * (self.rest[index] - self.rest[parent]),
            });
        }
        (world, positions)
    }
}

fn matrix(rotation: DQuat) -> [f64; 9] {
    DMat3::from_quat(rotation).transpose().to_cols_array()
}

impl BodyArrays {
    /// Kimodo's arrays of these joints.
    pub(super) fn kimodo(&self, joints: Vec<Joint>) -> Vec<u8> {
        let skeleton = Skeleton::new(self, joints);
        let (mut positions, mut global, mut local) = (Vec::new(), Vec::new(), Vec::new());
        for frame in 0..self.frames {
            let (world, posed) = skeleton.posed(self, frame);
            positions.extend(posed.iter().flat_map(DVec3::to_array));
            for (joint, rotation) in std::iter::zip(&skeleton.joints, &world) {
                let above = joint.parent.map_or(DQuat::IDENTITY, |parent| world[parent]);
                global.extend(matrix(*rotation));
                local.extend(matrix(above.inverse() * *rotation));
            }
        }
        let (frames, count) = (self.frames, skeleton.joints.len());
        npz::of_doubles(
            &[
                ("posed_joints", &[frames, count, 3], &positions),
                ("global_rot_mats", &[frames, count, 3, 3], &global),
                ("local_rot_mats", &[frames, count, 3, 3], &local),
                ("root_positions", &[frames, 3], &self.root),
                ("fps", &[], &[self.frame_rate]),
            ],
            &[],
        )
    }

    /// The arrays of SAM 3D Body. The joint positions are relative to a fixed root. The motion of the root is in the
    /// translation of the camera, which is level.
    pub(super) fn mhr(&self) -> Vec<u8> {
        let skeleton = Skeleton::new(self, mhr());
        let axes = mhr_frames(&skeleton.joints);
        let to_camera = |position: DVec3| (position * DVec3::new(1.0, -1.0, -1.0)).to_array();
        let height = DVec3::Y * MHR_ROOT_HEIGHT;
        let (mut positions, mut global, mut camera) = (Vec::new(), Vec::new(), Vec::new());
        for frame in 0..self.frames {
            let solved;
            let (world, posed) = match &self.own_mhr {
                Some(own) => &own[frame],
                None => {
                    solved = skeleton.posed(self, frame);
                    &solved
                }
            };
            let place = posed.get(1).copied().unwrap_or_default() - height;
            positions.extend(to_camera(DVec3::ZERO));
            positions.extend(posed.iter().skip(1).flat_map(|position| to_camera(*position - place)));
            global.extend(std::iter::zip(world, &axes).flat_map(|(rotation, axes)| matrix(*rotation * *axes)));
            camera.extend(to_camera(place));
        }
        let (frames, count) = (self.frames, skeleton.joints.len());
        npz::of_doubles(
            &[
                ("pred_joint_coords", &[frames, count, 3], &positions),
                ("pred_global_rots", &[frames, count, 3, 3], &global),
                ("pred_cam_t", &[frames, 3], &camera),
                ("camera_up", &[3], &to_camera(DVec3::Y)),
                ("fps", &[], &[self.frame_rate]),
            ],
            &[],
        )
    }
}
