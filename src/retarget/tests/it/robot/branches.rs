//! Limbs that are stuck in a corner of their limits.

use mocap::retarget::robot::{RobotMotion, Weights};
use mocap_figure::robot_bones::robot_bones;
use mocap_retarget::internals::branches::{Branches, Follow, Free, SUSPECT, Track, shortest, suspects};
use mocap_retarget::internals::{Bounds, Goals, Kinematics, SolverGoals, StandIn};

/// By hand: the second track is better in the middle. A change from one track to the other costs nothing where the two
/// agree.
#[test]
fn the_way_changes_where_tracks_agree() {
    let track = |positions: [f64; 6], costs: [f64; 6]| Track {
        positions: positions.map(|position| vec![position]).to_vec(),
        costs: costs.to_vec(),
    };
    let first = track([0.0, 0.1, 2.0, 2.0, 2.0, 0.1], [0.0, 0.0, 0.5, 0.5, 0.5, 0.0]);
    let second = track([1.5, 0.1, 0.1, 0.1, 0.1, 1.5], [0.9, 0.1, 0.0, 0.0, 0.0, 0.9]);
    assert_eq!(shortest(&[first, second], 1.0), [0, 0, 1, 1, 1, 0]);
}

/// A leg of the G1 whose wanted pose its joints can reach. The leg is stuck in a corner of the limits, which its solver
/// reaches from the worst of many starting poses.
struct StuckLeg {
    kinematics: Kinematics,
    branches: Branches,
    goals: Vec<Goals>,
    bounds: Bounds,
    motion: RobotMotion,
}

const STUCK_FRAMES: usize = 30;

fn stuck_leg() -> StuckLeg {
    let urdf = std::fs::read("../../fixtures/robots/g1_29dof_rev_1_0.urdf").unwrap();
    let robot = mocap::Importer::new().read_robot(&urdf, "g1.urdf").unwrap();
    let twin = StandIn::new(&robot, &robot_bones(&robot, None).unwrap()).unwrap();
    let kinematics = Kinematics::new(&robot);
    let mut branches = Branches::new(&kinematics, &twin, &Weights::new());
    branches.limbs.retain(|limb| limb.foot.is_some());
    branches.limbs.truncate(1);
    let bodies = &kinematics.bodies[1..];
    let bounds = Bounds {
        lower: bodies.iter().map(|body| body.limits.lower).collect(),
        upper: bodies.iter().map(|body| body.limits.upper).collect(),
    };
    // The thigh is raised and turned out, and the knee is bent. Every joint is within its limits.
    let mut wanted = kinematics.rest();
    for (name, at) in [("hip_pitch", -1.9), ("hip_roll", 1.3), ("hip_yaw", 1.6), ("knee", 1.9)] {
        let dof = robot
            .dof_names()
            .iter()
            .position(|dof| *dof == format!("left_{name}_joint"));
        wanted.positions[dof.unwrap()] = at;
    }
    kinematics.update(&mut wanted);
    let mut goals = SolverGoals::new(&robot, &kinematics, &twin, &Weights::new()).goals;
    goals
        .rotations
        .iter_mut()
        .for_each(|turn| turn.target = wanted.bodies[turn.body].rotation);
    for reach in &mut goals.reaches {
        reach.target = wanted.bodies[reach.body].point(reach.point);
    }
    let mut motion = RobotMotion::default();
    motion.fps = 30.0;
    motion.root = vec![wanted.root; STUCK_FRAMES];
    motion.dof_pos = [0.0].repeat(STUCK_FRAMES * bodies.len());
    motion.dof_names = robot.dof_names();
    motion.contacts = vec![[false; 2]; STUCK_FRAMES];
    let mut stuck = StuckLeg {
        goals: vec![goals; STUCK_FRAMES],
        kinematics,
        branches,
        bounds,
        motion,
    };
    stuck.be_stuck();
    stuck
}

impl StuckLeg {
    fn be_stuck(&mut self) {
        let limb = &mut self.branches.limbs[0];
        let goals: Vec<Goals> = self.goals.iter().map(|goals| limb.own(goals)).collect();
        let positions = limb.positions.clone();
        let mut follow = Follow {
            limb,
            kinematics: &self.kinematics,
            goals: &goals,
            bounds: &self.bounds,
            motion: &self.motion,
            first: 0,
        };
        let corners = (0..1 << positions.len()).map(|corner: usize| {
            let at = |(index, position): (usize, &usize)| match corner >> index & 1 {
                0 => self.bounds.lower[*position],
                _ => self.bounds.upper[*position],
            };
            let mut begun: Vec<f64> = positions.iter().enumerate().map(at).collect();
            (follow.solve(0, &mut begun, 200), begun)
        });
        let (cost, begun) = corners.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        assert!(cost > 2.0 * SUSPECT, "no corner holds the leg: {cost}");
        let count = self.motion.dof_names.len();
        for frame in 0..STUCK_FRAMES {
            for (at, value) in positions.iter().zip(&begun) {
                self.motion.dof_pos[frame * count + at] = *value;
            }
        }
    }

    /// The cost of the leg in each frame after a search for another branch.
    fn chosen(&mut self, from: usize, ahead: usize) -> Vec<f64> {
        let free = Free {
            goals: &self.goals,
            bounds: &self.bounds,
            from,
            ahead,
        };
        let changed = self.branches.choose(&self.kinematics, &free, &mut self.motion);
        assert_eq!(changed, self.branches.limbs[0].positions);
        let limb = &self.branches.limbs[0];
        let goals: Vec<Goals> = self.goals.iter().map(|goals| limb.own(goals)).collect();
        limb.track(&self.kinematics, &goals, &self.motion, 0).costs
    }
}

#[test]
fn a_leg_leaves_a_corner_of_its_limits() {
    let costs = stuck_leg().chosen(0, 0);
    assert!(costs.iter().all(|cost| *cost < 0.5 * SUSPECT), "{costs:?}");
}

#[test]
fn frames_that_were_given_stay() {
    let mut stuck = stuck_leg();
    let before = stuck.motion.clone();
    let costs = stuck.chosen(20, 15);
    let kept = 20 * before.dof_names.len();
    assert_eq!(stuck.motion.dof_pos[..kept], before.dof_pos[..kept]);
    assert!(costs[20..].iter().all(|cost| *cost < 0.5 * SUSPECT), "{costs:?}");
}

#[test]
fn the_worst_moments_are_apart() {
    let mut costs = vec![0.0; 120];
    costs[20..30].fill(1.0);
    costs[90..100].fill(0.5);
    let found = suspects(&costs, 30.0);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(
        (20..40).contains(&found[0]) && (88..102).contains(&found[1]),
        "{found:?}"
    );
}
