//! Poses a model at a frame like MMD: first the motion, then inheritance and IK, bone by bone.
//!
//! A bone's rotation is `IK x own x inherited`, applied from right to left. Its position relative to its parent is the
//! rest position plus its displacement. Bones are posed by layer and then in order. Bones after the physics come last.
//! A bone inherits the whole rotation of another bone, including IK and inherited rotation.

mod ik;

use glam::{DQuat, DVec3};
use mocap_scene::math::quaternion::rotation_vector;

use self::ik::Solver;
use super::model::Model;
use crate::Failure;

/// The rotation and the translation of a bone relative to its parent. The translation is relative to its rest position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    pub(super) translation: DVec3,
    pub(super) rotation: DQuat,
}

impl Default for Local {
    fn default() -> Self {
        Self {
            translation: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
        }
    }
}

/// The pose of a model.
pub(super) struct ModelPose<'m> {
    pub(super) model: &'m Model,
    order: Vec<usize>,
    solvers: Vec<Option<Solver<'m>>>,
    /// The pose from the motion.
    pub(super) own: Vec<Local>,
    /// The rotations from IK.
    pub(super) ik: Vec<DQuat>,
    inherited: Vec<Local>,
}

impl<'m> ModelPose<'m> {
    pub(super) fn new(model: &'m Model) -> Self {
        let count = model.bones.len();
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|bone| (model.bones[*bone].is_after_physics, model.bones[*bone].layer));
        Self {
            model,
            order,
            solvers: (0..count).map(|bone| Solver::new(model, bone)).collect(),
            own: vec![Local::default(); count],
            ik: vec![DQuat::IDENTITY; count],
            inherited: vec![Local::default(); count],
        }
    }

    /// Poses all bones from [`own`](Self::own). `is_on` states which IK is enabled. `budget` is the remaining number of
    /// IK steps.
    pub(super) fn pose(&mut self, is_on: &[bool], budget: &mut u64) -> Result<(), Failure> {
        self.ik.fill(DQuat::IDENTITY);
        self.inherited.fill(Local::default());
        for place in 0..self.order.len() {
            let bone = self.order[place];
            if let Some(inherits) = self.model.bones[bone].inherits {
                let source = self.local(inherits.source);
                let inherited = &mut self.inherited[bone];
                if inherits.rotation {
                    let turn = rotation_vector(source.rotation) * inherits.ratio;
                    inherited.rotation = DQuat::from_scaled_axis(turn);
                }
                if inherits.position {
                    inherited.translation = source.translation * inherits.ratio;
                }
            }
            if let Some(solver) = self.solvers[bone].take_if(|_| is_on[bone]) {
                let solved = ik::solve(&solver, self, budget);
                self.solvers[bone] = Some(solver);
                solved?;
            }
        }
        Ok(())
    }

    pub(super) fn local(&self, bone: usize) -> Local {
        let (own, inherited) = (self.own[bone], self.inherited[bone]);
        Local {
            translation: own.translation + inherited.translation,
            rotation: (self.ik[bone] * self.without_ik(bone)).normalize(),
        }
    }

    /// The rotation of a bone without IK.
    pub(super) fn without_ik(&self, bone: usize) -> DQuat {
        self.own[bone].rotation * self.inherited[bone].rotation
    }

    /// The rest position of a bone relative to its parent.
    fn offset(&self, bone: usize) -> DVec3 {
        let bone = &self.model.bones[bone];
        bone.position
            - bone
                .parent
                .map_or(DVec3::ZERO, |parent| self.model.bones[parent].position)
    }

    /// The position and the rotation of a bone in model space.
    pub(super) fn world(&self, bone: usize) -> (DVec3, DQuat) {
        let (mut position, mut rotation) = (DVec3::ZERO, DQuat::IDENTITY);
        let mut at = Some(bone);
        while let Some(index) = at {
            let local = self.local(index);
            position = self.offset(index) + local.translation + local.rotation * position;
            rotation = local.rotation * rotation;
            at = self.model.bones[index].parent;
        }
        (position, rotation)
    }

    /// The rotation of a bone's parent.
    pub(super) fn parent_rotation(&self, bone: usize) -> DQuat {
        let parent = self.model.bones[bone].parent;
        parent.map_or(DQuat::IDENTITY, |parent| self.world(parent).1)
    }
}
