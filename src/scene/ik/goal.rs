//! The goal for the end of a limb.

use glam::{Quat, Vec3};

/// The wanted position and rotation of the end of a limb, in the world.
///
/// ```
/// use mocap::glam::{Quat, Vec3};
/// use mocap::ik::Goal;
///
/// let mut between = Goal::at(Vec3::Y);
/// between.position_weight = 0.5;
/// let flat = Goal::at(Vec3::Y).with_rotation(Quat::IDENTITY);
/// # let _ = (between, flat);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Goal {
    /// The position; `None` does not move the limb.
    pub position: Option<Vec3>,
    /// How far the end moves towards the goal position: a fraction of the distance, from 0 to 1.
    pub position_weight: f32,
    /// The rotation; with `None` the end rotates with the limb.
    pub rotation: Option<Quat>,
    /// How far the end rotates towards the goal rotation: a fraction of the angle, from 0 to 1.
    pub rotation_weight: f32,
}

impl Default for Goal {
    fn default() -> Self {
        Self {
            position: None,
            position_weight: 1.0,
            rotation: None,
            rotation_weight: 1.0,
        }
    }
}

impl Goal {
    /// A position goal with full weight.
    pub fn at(position: Vec3) -> Self {
        Self {
            position: Some(position),
            ..Self::default()
        }
    }

    /// Adds a rotation goal with full weight.
    #[must_use]
    pub fn with_rotation(mut self, rotation: Quat) -> Self {
        self.rotation = Some(rotation);
        self
    }

    /// The position to reach: the fraction `position_weight` of the way from `current` to the goal. `None` if the goal
    /// has no finite position.
    pub(super) fn position_from(&self, current: Vec3) -> Option<Vec3> {
        let weight = self.position_weight.clamp(0.0, 1.0);
        let position = current.lerp(self.position?, weight);
        position.is_finite().then_some(position)
    }

    /// The world rotation to apply to an end that has the rotation `current`; `None` if the goal has no finite
    /// rotation.
    pub(super) fn rotation_from(&self, current: Quat) -> Option<Quat> {
        let goal = self.rotation?;
        if !(goal.length_squared() > 0.0 && goal.is_finite() && current.is_finite()) {
            return None;
        }
        let change = (goal.normalize() * current.normalize().inverse()).normalize();
        let weight = self.rotation_weight.clamp(0.0, 1.0);
        let rotation = Quat::IDENTITY.slerp(change, weight);
        rotation.is_finite().then_some(rotation)
    }
}
