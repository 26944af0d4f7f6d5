//! Finds the feet of a robot without a joint between foot and shin.

use glam::DVec3;
use mocap_scene::scene::robot::RobotShape;

use super::Tree;

/// The smallest length of a shin without an ankle, as a fraction of the thigh.
const SHIN: f64 = 0.5;

/// The largest height difference between points of a sole, in metres.
const LEVEL_SOLE: f64 = 0.02;

impl Tree<'_> {
    /// The foot of a shin without an ankle. It is the lowest link that is fixed to the shin, if this link is below the
    /// knee. Otherwise it is the shin itself, if the shapes of the shin show its end.
    pub(super) fn fixed_foot(&self, shin: usize) -> Option<usize> {
        let height = |link: &usize| self.transforms[*link].translation.z;
        let fixed = (shin + 1..self.transforms.len()).filter(|link| self.is_fixed_to(*link, shin));
        let lowest = fixed.min_by(|a, b| height(a).total_cmp(&height(b)));
        let knee = self.anchor(shin).z;
        match lowest.filter(|link| knee - height(link) > SHIN * (self.anchor_of_hip(shin).z - knee).abs()) {
            Some(foot) => Some(foot),
            None => self.lowest_point(shin).filter(|point| point.z < knee).map(|_| shin),
        }
    }

    /// The first joint of the limb with this link.
    fn anchor_of_hip(&self, mut link: usize) -> DVec3 {
        while let Some(above) = self.children.iter().position(|children| children[..] == [link]) {
            link = above;
        }
        self.anchor(link)
    }

    /// Whether a link is below another link without a moving joint in between.
    fn is_fixed_to(&self, mut link: usize, other: usize) -> bool {
        while link != other && !self.robot.links[link].joint.moves() {
            match self.robot.links[link].parent {
                Some(parent) => link = parent,
                None => return false,
            }
        }
        link == other
    }

    /// The middle of the lowest points of the shapes of a leg's link.
    pub(super) fn lowest_point(&self, link: usize) -> Option<DVec3> {
        let balls = self.robot.links[link].shapes.iter().flat_map(RobotShape::balls);
        let points = balls.map(|(centre, radius)| self.transforms[link].point(centre) - radius * DVec3::Z);
        let points: Vec<DVec3> = points.collect();
        let least = points.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
        let lowest: Vec<DVec3> = points
            .into_iter()
            .filter(|point| point.z < least + LEVEL_SOLE)
            .collect();
        (!lowest.is_empty()).then(|| lowest.iter().sum::<DVec3>() / lowest.len() as f64)
    }
}
