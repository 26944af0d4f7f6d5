//! Inverse kinematics: moves the ends of limbs and chains to a goal.

use mocap::glam::{Quat, Vec3};
use mocap::ik::{ChainOptions, Goal, TwoBone};
use mocap::scene::NodeId;
use pyo3::prelude::*;

use crate::errors::invalid;
use crate::scene::{Scene, matrices, posed};

/// The result for two bones: middle, end, the rotations of the bones in the world, and the remaining distance to the
/// goal.
type Bent = ([f32; 3], [f32; 3], [f32; 4], [f32; 4], f32);

#[pyfunction]
pub(crate) fn two_bone(joints: [[f32; 3]; 3], goal: [f32; 3], pole: Option<[f32; 3]>) -> Bent {
    let found = TwoBone::solve(joints.map(Vec3::from), goal.into(), pole.map(Vec3::from));
    let (upper, lower) = (found.upper.to_array(), found.lower.to_array());
    (found.middle.into(), found.end.into(), upper, lower, found.distance)
}

/// Moves the end of a chain to a goal. Returns the positions and the remaining distance.
#[pyfunction]
pub(crate) fn chain(positions: Vec<[f32; 3]>, goal: [f32; 3], tolerance: f32) -> (Vec<[f32; 3]>, f32) {
    let mut positions: Vec<Vec3> = positions.into_iter().map(Vec3::from).collect();
    let options = ChainOptions::new().tolerance(tolerance);
    let left = options.bend_positions(&mut positions, goal.into());
    (positions.iter().map(Vec3::to_array).collect(), left)
}

/// Turns a chain of joints so that the last joint reaches a goal. Returns the matrices of the pose and the remaining
/// distance.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "Python hands them over by name")]
pub(crate) fn bend<'py>(
    py: Python<'py>,
    scene: &Scene,
    tick: f64,
    joints: Vec<usize>,
    goal: [f32; 3],
    rotation: Option<[f32; 4]>,
    pole: Option<[f32; 3]>,
    world: bool,
) -> PyResult<(Bound<'py, PyAny>, f32)> {
    let scene = scene.scene();
    check_chain(scene, &joints)?;
    let mut pose = posed(scene, tick);
    let mut wanted = Goal::at(goal.into());
    if let Some(rotation) = rotation {
        wanted = wanted.with_rotation(Quat::from_array(rotation));
    }
    let nodes: Vec<NodeId> = joints.iter().map(|&joint| NodeId::new(joint)).collect();
    let left = match nodes[..] {
        [upper, middle, end] => pose.bend_limb([upper, middle, end], &wanted, pole.map(Vec3::from)),
        _ if pole.is_some() => return Err(invalid(format!("pole needs three joints, got {}", nodes.len()))),
        _ => pose.bend_chain(&nodes, &wanted, &ChainOptions::new()),
    };
    pose.update_world();
    Ok((matrices(py, &pose, world)?, left))
}

/// Checks that each joint is an ancestor of the next.
fn check_chain(scene: &mocap::Scene, joints: &[usize]) -> PyResult<()> {
    if joints.len() < 2 {
        return Err(invalid(format!(
            "a chain has at least two joints, got {}",
            joints.len()
        )));
    }
    for pair in joints.windows(2) {
        let above = std::iter::successors(scene.nodes[pair[1]].parent, |node| scene.nodes[node.index()].parent);
        if !above.into_iter().any(|node| node.index() == pair[0]) {
            let name = |joint: usize| &scene.nodes[joint].name;
            return Err(invalid(format!(
                "each joint of a chain must be an ancestor of the next: {:?} is not an ancestor of {:?}",
                name(pair[0]),
                name(pair[1])
            )));
        }
    }
    Ok(())
}
