//! IK of a model: cyclic coordinate descent, with the loops, the largest step and the limits that the model states.
//!
//! In each loop each link, starting next to the target, rotates the target towards the goal. The n-th link rotates by
//! at most n times the stated step. In the first half of the loops, a link whose limits allow a single axis, such as a
//! knee, rotates about that axis. In these loops an angle beyond a limit is reflected, if the reflected angle is within
//! the limits. So a straight knee bends to the correct side. Limit angles are Euler angles in the order whose middle
//! axis stays within 90 degrees. These rules come from the authors of browser runtimes for MMD, who compared the rules
//! with MMD.

use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec3, EulerRot};
use mocap_scene::error::{Code, Diagnostic};

use super::ModelPose;
use crate::Failure;
use crate::mmd::model::{Ik, Model};

/// The squared distance in units between target and goal below which the IK is done.
const NEAR: f64 = 1e-8;

/// The squared length of a rotation axis below which it has no direction: rounding of unit vectors.
const NO_AXIS: f64 = 1e-14;

/// An IK, and the limits of its links.
pub(super) struct Solver<'m> {
    goal: usize,
    ik: &'m Ik,
    links: Vec<IkLimit>,
}

/// The rotation limits of a link.
#[derive(Clone, Copy)]
enum IkLimit {
    Freely,
    Not,
    Within {
        limits: [DVec3; 2],
        order: EulerRot,
        /// The single rotation axis, if there is one.
        only: Option<DVec3>,
    },
}

impl<'m> Solver<'m> {
    pub(super) fn new(model: &'m Model, bone: usize) -> Option<Self> {
        let ik = model.bones[bone].ik.as_ref()?;
        let links = ik.links.iter().map(|link| IkLimit::of(link.limits)).collect();
        Some(Self { goal: bone, ik, links })
    }
}

impl IkLimit {
    fn of(limits: Option<[DVec3; 2]>) -> Self {
        let Some([a, b]) = limits else { return Self::Freely };
        let (least, largest) = (a.min(b), a.max(b));
        let is_still = [0, 1, 2].map(|axis| least[axis] == 0.0 && largest[axis] == 0.0);
        let is_narrow = |axis: usize| -FRAC_PI_2 < least[axis] && largest[axis] < FRAC_PI_2;
        let only = match is_still {
            [true, true, true] => return Self::Not,
            [false, true, true] => Some(DVec3::X),
            [true, false, true] => Some(DVec3::Y),
            [true, true, false] => Some(DVec3::Z),
            _ => None,
        };
        Self::Within {
            limits: [least, largest],
            order: match (is_narrow(0), is_narrow(1)) {
                (true, _) => EulerRot::YXZ,
                (false, true) => EulerRot::ZYX,
                (false, false) => EulerRot::XZY,
            },
            only,
        }
    }
}

/// Rotates the links so that the target reaches the goal. Each step reduces the budget by 1.
pub(super) fn solve(solver: &Solver<'_>, posed: &mut ModelPose<'_>, budget: &mut u64) -> Result<(), Failure> {
    for link in &solver.ik.links {
        posed.ik[link.bone] = DQuat::IDENTITY;
    }
    let (goal, _) = posed.world(solver.goal);
    let is_there = |posed: &ModelPose<'_>| posed.world(solver.ik.target).0.distance_squared(goal) < NEAR;
    for round in 0..solver.ik.loops {
        if is_there(posed) {
            break;
        }
        for place in 0..solver.links.len() {
            *budget = budget.checked_sub(1).ok_or_else(too_many_steps)?;
            let is_early = round < solver.ik.loops / 2;
            turn(solver, place, goal, is_early, posed);
        }
    }
    Ok(())
}

fn too_many_steps() -> Failure {
    let message = "the IK of the model takes more steps than the limits allow";
    Diagnostic::new(Code::LimitExceeded, message)
        .help("raise Limits::max_values, or reduce the IK loops of the model")
        .into()
}

/// Rotates one link.
fn turn(solver: &Solver<'_>, place: usize, goal: DVec3, is_early: bool, posed: &mut ModelPose<'_>) {
    let bone = solver.ik.links[place].bone;
    let turning = solver.links[place];
    if matches!(turning, IkLimit::Not) {
        return;
    }
    let (at, _) = posed.world(bone);
    let (target, _) = posed.world(solver.ik.target);
    let (Some(to_target), Some(to_goal)) = ((target - at).try_normalize(), (goal - at).try_normalize()) else {
        return;
    };
    let across = to_target.cross(to_goal);
    if across.length_squared() < NO_AXIS {
        return;
    }
    let parent = posed.parent_rotation(bone);
    let axis = match turning {
        IkLimit::Within { only: Some(only), .. } if is_early => only * across.dot(parent * only).signum(),
        _ => (parent.inverse() * across).normalize(),
    };
    let most = solver.ik.step * (place + 1) as f64;
    let angle = to_target.dot(to_goal).clamp(-1.0, 1.0).acos().min(most);
    let mut ik = DQuat::from_axis_angle(axis, angle) * posed.ik[bone];
    if let IkLimit::Within { limits, order, .. } = turning {
        let own = posed.without_ik(bone);
        let limited = limited(ik * own, limits, order, is_early);
        ik = limited * own.inverse();
    }
    posed.ik[bone] = ik.normalize();
}

/// The rotation with its angles within the limits.
fn limited(rotation: DQuat, [least, largest]: [DVec3; 2], order: EulerRot, reflects: bool) -> DQuat {
    // The positions of the angles about x, y and z in glam's result.
    let axes = match order {
        EulerRot::YXZ => [1, 0, 2],
        EulerRot::ZYX => [2, 1, 0],
        _ => [0, 2, 1],
    };
    let (first, second, third) = rotation.to_euler(order);
    let angles = [first, second, third];
    let mut within = [0.0; 3];
    for (place, axis) in axes.into_iter().enumerate() {
        within[place] = within_limits(angles[place], least[axis], largest[axis], reflects);
    }
    DQuat::from_euler(order, within[0], within[1], within[2])
}

fn within_limits(angle: f64, least: f64, largest: f64, reflects: bool) -> f64 {
    if angle < least {
        let reflected = 2.0 * least - angle;
        return if reflects && reflected <= largest {
            reflected
        } else {
            least
        };
    }
    if angle > largest {
        let reflected = 2.0 * largest - angle;
        return if reflects && reflected >= least {
            reflected
        } else {
            largest
        };
    }
    angle
}
