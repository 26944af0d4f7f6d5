//! Finds the limbs on which a robot stands.

use glam::DVec3;
use mocap_scene::scene::robot::Robot;

use super::{LIMB, LOW, Tree};

/// The legs of a robot: for each leg, its moving links from the trunk outwards. A leg is a limb that ends at the level
/// of the lowest limb when all joints are at 0.
pub fn standing_limbs(robot: &Robot) -> Vec<Vec<usize>> {
    Tree::new(robot).standing_limbs()
}

/// Sorts four legs by the positions of their hips: the left and the right front leg, then the left and the right hind
/// leg. +X is forward and +Y left, by the convention of ROS.
pub fn sort_legs<T>(legs: &mut [T; 4], hip: impl Fn(&T) -> DVec3) {
    legs.sort_by(|a, b| hip(b).x.total_cmp(&hip(a).x));
    for pair in legs.chunks_mut(2) {
        pair.sort_by(|a, b| hip(b).y.total_cmp(&hip(a).y));
    }
}

/// The moving links of four legs from the trunk outwards: the left and the right front leg, then the left and the right
/// hind leg. `None` if the robot has other joints than the joints of four legs.
pub fn links_of_four_legs(robot: &Robot) -> Option<[Vec<usize>; 4]> {
    let places = robot.zero_pose();
    let mut legs: [Vec<usize>; 4] = standing_limbs(robot).try_into().ok()?;
    sort_legs(&mut legs, |leg| places[leg[0]].translation);
    let count: usize = legs.iter().map(Vec::len).sum();
    (count == robot.moving_joints().len()).then_some(legs)
}

impl Tree<'_> {
    /// The limbs that end at the level of the lowest limb, with all joints at 0. Limbs of one trunk may share joints of
    /// a spine.
    pub(super) fn standing_limbs(&self) -> Vec<Vec<usize>> {
        let path = |leaf: usize| {
            let mut path: Vec<usize> = std::iter::successors(Some(leaf), |link| self.robot.links[*link].parent)
                .filter(|link| self.robot.links[*link].joint.moves() && *link != 0)
                .collect();
            path.reverse();
            path
        };
        let leaves = (1..self.children.len()).filter(|link| self.robot.links[*link].joint.moves());
        let leaves = leaves.filter(|link| self.children[*link].is_empty());
        let mut paths: Vec<Vec<usize>> = leaves.map(path).filter(|path| path.len() >= LIMB).collect();
        let end = |path: &[usize]| self.anchor(path[path.len() - 1]).z;
        paths.sort_by(|a, b| end(a).total_cmp(&end(b)));
        let shared = |a: &[usize], b: &[usize]| a.iter().zip(b).take_while(|(a, b)| a == b).count();
        let mut limbs: Vec<Vec<usize>> = Vec::new();
        for path in paths {
            let is_apart = |limb: &Vec<usize>| path.len().min(limb.len()) >= shared(&path, limb) + LIMB;
            if limbs.iter().all(is_apart) {
                limbs.push(path);
            }
        }
        let whole = limbs.clone();
        for (index, limb) in limbs.iter_mut().enumerate() {
            let others = whole.iter().enumerate().filter(|(other, _)| *other != index);
            let common = others.map(|(_, other)| shared(&whole[index], other)).max().unwrap_or(0);
            limb.drain(..common);
        }
        let Some(lowest) = limbs.first() else { return limbs };
        let (level, leg) = (end(lowest), self.anchor(lowest[0]).z - end(lowest));
        limbs.retain(|limb| end(limb) < level + LOW * leg && self.anchor(limb[0]).z > end(limb) + LOW * leg);
        limbs
    }
}
