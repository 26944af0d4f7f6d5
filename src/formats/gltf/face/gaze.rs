//! The rotation of a character's eyes with the gaze.

use glam::{EulerRot, Quat};
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{Animation, Channel, HumanoidBone, Keys, Scene};
use serde_json::Value;

use super::binds::number;
use super::eye;

/// Maps an angle of the gaze, in degrees, to the angle of an eye or to a weight. The map is linear up to the largest
/// input.
#[derive(Clone, Copy, Debug)]
struct Range {
    most: f32,
    scale: f32,
}

impl Range {
    fn read(value: &Value, (most, scale): (&str, &str)) -> Self {
        Self {
            most: number(&value[most]),
            scale: number(&value[scale]),
        }
    }

    fn of(self, degrees: f32) -> f32 {
        if self.most <= 0.0 {
            return 0.0;
        }
        degrees.abs().min(self.most) / self.most * self.scale
    }
}

/// The gaze settings of a VRM file.
#[derive(Clone, Debug)]
pub(super) struct Gaze {
    /// Whether the eyes rotate. Otherwise expressions show the gaze.
    pub(super) is_of_bones: bool,
    inner: Range,
    outer: Range,
    down: Range,
    up: Range,
    /// Whether the character faces -Z, as VRM 0 characters do.
    is_turned: bool,
}

impl Gaze {
    pub(super) fn read(root: &Value) -> Option<Self> {
        let extensions = &root["extensions"];
        let (vrm1, vrm0) = (&extensions["VRMC_vrm"]["lookAt"], &extensions["VRM"]["firstPerson"]);
        let is_vrm1 = vrm1.is_object();
        if !is_vrm1 && !vrm0["lookAtTypeName"].is_string() {
            return None;
        }
        let range = |new: &str, old: &str| match is_vrm1 {
            true => Range::read(&vrm1[new], ("inputMaxValue", "outputScale")),
            false => Range::read(&vrm0[old], ("xRange", "yRange")),
        };
        Some(Self {
            is_of_bones: vrm1["type"] == "bone" || vrm0["lookAtTypeName"] == "Bone",
            inner: range("rangeMapHorizontalInner", "lookAtHorizontalInner"),
            outer: range("rangeMapHorizontalOuter", "lookAtHorizontalOuter"),
            down: range("rangeMapVerticalDown", "lookAtVerticalDown"),
            up: range("rangeMapVerticalUp", "lookAtVerticalUp"),
            is_turned: !is_vrm1,
        })
    }

    /// Yaw to the left and pitch down, in degrees.
    fn angles(rotation: Quat) -> (f32, f32) {
        let (yaw, pitch, _) = rotation.to_euler(EulerRot::YXZ);
        (yaw.to_degrees(), pitch.to_degrees())
    }

    /// The weights of the look expressions: up, down, left and right.
    pub(super) fn looks(&self, rotation: Quat) -> [f32; 4] {
        let (yaw, pitch) = Self::angles(rotation);
        let mut weights = [0.0; 4];
        weights[usize::from(pitch > 0.0)] = if pitch > 0.0 {
            self.down.of(pitch)
        } else {
            self.up.of(pitch)
        };
        weights[if yaw > 0.0 { 2 } else { 3 }] = self.outer.of(yaw);
        weights
    }

    /// The rotation of an eye relative to the model, which faces +Z.
    fn of_eye(&self, is_left: bool, rotation: Quat) -> Quat {
        let (yaw, pitch) = Self::angles(rotation);
        let horizontal = if (yaw > 0.0) == is_left { self.outer } else { self.inner };
        let vertical = if pitch > 0.0 { self.down } else { self.up };
        let yaw = horizontal.of(yaw).to_radians().copysign(yaw);
        let pitch = vertical.of(pitch).to_radians().copysign(pitch);
        Quat::from_euler(EulerRot::YXZ, yaw, pitch, 0.0)
    }

    /// Adds keys to the eyes of a character. Returns false if the character has no eyes.
    pub(super) fn turn_eyes(
        &self,
        scene: &Scene,
        animation: &mut Animation,
        ticks: &[f64],
        rotations: &[Quat],
    ) -> bool {
        let rest = Pose::rest(scene);
        let mut has_eyes = false;
        for (bone, is_left) in [(HumanoidBone::LeftEye, true), (HumanoidBone::RightEye, false)] {
            let Some(id) = eye(scene, bone) else { continue };
            has_eyes = true;
            let node = &scene.nodes[id.index()];
            let own = Trs::from_matrix(node.transform);
            let parent = node.parent.map(|parent| rest.node_to_world[parent.index()]);
            let parent = parent.map_or(Quat::IDENTITY, |parent| Trs::from_matrix(parent).rotation);
            let turned = |rotation: &Quat| {
                let mut turn = self.of_eye(is_left, *rotation);
                if self.is_turned {
                    // Half a turn about the up axis.
                    turn = Quat::from_xyzw(-turn.x, turn.y, -turn.z, turn.w);
                }
                (parent.inverse() * turn * parent * own.rotation).normalize()
            };
            let keys = Keys::at_ticks(rotations.iter().map(turned).collect(), ticks.to_vec());
            let channels = &mut animation.channels;
            channels.retain(|channel| channel.node != Some(id));
            let at = channels.partition_point(|channel| channel.node < Some(id));
            channels.insert(
                at,
                Channel {
                    node_name: node.name.clone(),
                    node: Some(id),
                    position_keys: Keys::constant(own.translation),
                    rotation_keys: keys,
                    scaling_keys: Keys::constant(own.scale),
                },
            );
        }
        has_eyes
    }
}
