//! Motion matching, frame by frame.
//!
//! Six times per second, the controller searches the database for the frame nearest to a query (Clavet, 2016). The
//! query has the feet and hips of the current frame, and the wanted trajectory. If another frame is nearer to the query
//! than the current frame, the motion continues at the other frame. The difference of the two poses in position and
//! speed fades out in a third of a second, by a polynomial of degree 5 (inertialisation: Bollo, 2016). Inverse
//! kinematics of the leg holds a foot in place during its stance phase.

use glam::{Quat, Vec2, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::inertia::fade;
use mocap_scene::math::quaternion::{exp, log};
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::NodeId;

use super::database::Database;
use super::features::{AHEAD, FEATURES, Root, set_ahead, set_still, speed_of_hips};
use super::lock::FootLock;
use super::moves::{Frame, Moves};
use super::steering::Steering;
use super::trajectory::Trajectory;
use super::tree::FeatureTree;

/// Frames from one search to the next.
const SEARCH: usize = 10;
/// The controller does not jump to a frame that is at most this many frames before or after the current frame.
const NEAR: usize = 20;
/// The number of frames in which the difference of two poses fades out.
const FADE: usize = 20;

/// The fraction of the figure's distance from its path that each frame corrects. Half of the distance is corrected in a
/// third of a second.
const CORRECTED: f32 = 0.034;

/// The largest shift of a figure by a correction, as a fraction of the distance that the figure moves in the frame. The
/// shift is too small to look like foot sliding.
const MOST_MOVED: f32 = 0.06;

/// The largest turn of a figure by a correction, in radians per metre that the figure moves.
const MOST_TURNED: f32 = 0.4;

/// The length of the wanted trajectory below which the figure stops, in metres on legs of length
/// [`LEG`](super::features::LEG).
const STOPS_WITHIN: f32 = 0.1;
/// The largest speed of the hips in a frame in which the figure stands, in m/s on legs of length
/// [`LEG`](super::features::LEG).
const STANDS_BELOW: f32 = 0.1;

/// The difference between the shown pose and the pose of a frame, and the change of the difference per frame.
type Difference = (Vec3, Vec3);

/// Makes a figure follow a trajectory by jumps between the frames of a database. Only the constructor allocates memory.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::glam::Vec3;
/// use mocap::matching::{Controller, Database, Moves, Trajectory, IndexedClip};
/// use mocap::retarget::{Retargeter, RetargetOptions};
/// use mocap::{Conversion, Scene};
///
/// # fn main() -> mocap::Result<()> {
/// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let database = Database::new(IndexedClip::of(&walk, "walk.bvh", false));
/// let mut hero: Scene = mocap::import("fixtures/real/rokoko_dance.bvh")?;
/// Conversion::new().apply(&mut hero)?;
/// let clips = Retargeter::new(walk, hero.clone(), RetargetOptions::new())?.into_clips();
/// let mut moves = Moves::new(&hero)?;
/// moves.add(&database.clips()[0], &clips[0].animation)?;
/// let mut figure = Controller::new(&database, moves, Vec3::ZERO, Vec3::Z)?;
/// // Walk straight ahead at 1 m/s.
/// for _ in 0..60 {
///     let positions = [1.0, 2.0, 3.0].map(|thirds| figure.position() + Vec3::Z * thirds / 3.0);
///     figure.update(&Trajectory::new(positions, [Vec3::Z; 3]));
/// }
/// assert!(figure.position().z > 0.5 && figure.pose().node_to_world.len() == hero.nodes.len());
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Controller {
    tree: FeatureTree,
    moves: Moves,
    /// Whether the figure stands in any frame of the database.
    can_stand: bool,
    pose: Pose,
    root: Root,
    /// The current frame. `since` is the number of frames since the last jump.
    frame: usize,
    since: usize,
    until_search: usize,
    jumps: usize,
    /// The shown pose before feet are locked: the hips in the world, and the rotations of the nodes.
    hips: (Vec3, Quat),
    shown: Vec<Quat>,
    hips_differ: [Difference; 2],
    differences: Vec<Difference>,
    locks: [FootLock; 2],
    steering: Steering,
}

impl Controller {
    /// Places a figure at a position on the ground, facing `forward`. The figure begins in the frame that is most
    /// similar to standing still.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if `moves` do not belong to the frames of `database`, or if `forward` is vertical.
    pub fn new(database: &Database, moves: Moves, position: Vec3, forward: Vec3) -> Result<Self> {
        let invalid = |message: String| Diagnostic::new(Code::InvalidValue, message);
        if moves.frames.len() != database.frames() || moves.frames.is_empty() {
            let message = "the moves were not made from this database".to_owned();
            let found = format!("the poses of {}", moves.frames.len());
            return Err(invalid(message)
                .expected_found(format!("the poses of {} frames, 1 or more", database.frames()), found)
                .into());
        }
        let forward = forward.with_y(0.0).try_normalize();
        let forward = forward.ok_or_else(|| invalid("forward must not be vertical".to_owned()))?;
        let tree = FeatureTree::new(database);
        let mut still = [0.0; FEATURES];
        still[..6].copy_from_slice(&moves.features[0][..6]);
        for index in 0..AHEAD.len() {
            set_ahead(&mut still, index, Vec3::ZERO, Vec3::Z);
        }
        let found = tree.nearest(&tree.normalized(&still), f32::INFINITY, 0..0);
        let frame = found.map_or(0, |(frame, _)| frame);
        let mut controller = Self {
            pose: moves.rest.clone(),
            root: Root {
                position: position.with_y(0.0),
                forward,
            },
            frame,
            since: FADE,
            until_search: 0,
            jumps: 0,
            hips: (Vec3::ZERO, Quat::IDENTITY),
            shown: moves.rotations(frame).to_vec(),
            hips_differ: [(Vec3::ZERO, Vec3::ZERO); 2],
            differences: vec![(Vec3::ZERO, Vec3::ZERO); moves.nodes.len()],
            locks: [FootLock::default(), FootLock::default()],
            steering: Steering::new(forward),
            can_stand: speed_of_hips(&moves.features[frame]) < STANDS_BELOW,
            tree,
            moves,
        };
        controller.show();
        Ok(controller)
    }

    /// The position of the figure on the ground.
    pub fn position(&self) -> Vec3 {
        self.root.position
    }

    /// The facing of the figure: a horizontal unit vector in the world.
    pub fn forward(&self) -> Vec3 {
        self.root.forward
    }

    /// The pose of the character in the current frame.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// The current frame of the database, counted over all clips.
    pub fn frame(&self) -> usize {
        self.frame
    }

    /// The number of jumps to other frames.
    pub fn jumps(&self) -> usize {
        self.jumps
    }

    /// The node of the character's hips.
    pub(super) fn hips(&self) -> NodeId {
        self.moves.hips
    }

    /// The nodes of the character that move, except the hips.
    pub(super) fn moved(&self) -> &[NodeId] {
        &self.moves.nodes
    }

    /// Advances by one frame, 1/60 s.
    pub fn update(&mut self, trajectory: &Trajectory) {
        self.advance();
        let ends = self.moves.frames[self.frame].is_last;
        if self.until_search == 0 || ends {
            self.search(trajectory, ends);
            self.until_search = SEARCH;
        }
        self.until_search -= 1;
        self.show();
    }

    /// Advances by one frame, controlled by a stick. The input is a velocity over the ground along x and z of the
    /// world, in m/s, and a facing, `look`. While `look` is zero, the figure faces the direction of its velocity.
    /// Velocity and facing change smoothly.
    ///
    /// [`play`](Self::play) reads the sticks from a file.
    pub fn steer(&mut self, velocity: Vec2, look: Vec2) {
        let trajectory = self.steering.update(&self.root, velocity, look);
        self.update(&trajectory);
    }

    pub(super) fn steering(&self) -> &Steering {
        &self.steering
    }

    /// Moves and turns the figure towards the wanted position and facing. `step` is the distance that the figure moves
    /// in this frame. The correction is a small fraction of `step`, so that the correction is hardly visible. A figure
    /// that stands still is not corrected. Feet in contact stay locked.
    ///
    /// Holden's demonstration (2021) corrects its character in the same way, by a fraction of the character's speed.
    pub(super) fn correct(&mut self, position: Vec3, forward: Vec3, step: f32) {
        let missing = (position - self.root.position).with_y(0.0);
        self.root.position += (CORRECTED * missing).clamp_length_max(MOST_MOVED * step);
        let own = self.root.forward;
        let angle = own.cross(forward).y.atan2(own.dot(forward));
        let most = MOST_TURNED * step / self.moves.scale;
        let turn = Quat::from_rotation_y((CORRECTED * angle).clamp(-most, most));
        self.root.forward = (turn * own).with_y(0.0).normalize_or(own);
    }

    /// Advances to the next frame of the clip, and stays at the last frame.
    fn advance(&mut self) {
        self.since += 1;
        let from = self.moves.frames[self.frame].root;
        if self.moves.frames[self.frame].is_last {
            return;
        }
        self.frame += 1;
        let to = self.moves.frames[self.frame].root;
        let step = from.local(to.position - from.position);
        let turn = from.local(to.forward);
        self.root = Root {
            position: self.root.position + self.world(step),
            forward: self.world(turn).with_y(0.0).normalize_or(self.root.forward),
        };
    }

    /// Converts a vector from the axes of the root (left, up, forward) to the world.
    fn world(&self, local: Vec3) -> Vec3 {
        let left = Vec3::Y.cross(self.root.forward);
        left * local.x + Vec3::Y * local.y + self.root.forward * local.z
    }

    /// Jumps to the frame that is nearest to the query: the current pose with the wanted trajectory. If the current
    /// frame is nearer, does not jump, unless the current clip `ends`.
    fn search(&mut self, trajectory: &Trajectory, ends: bool) {
        let playing = self.moves.features[self.frame];
        let mut wanted = playing;
        for (index, (position, direction)) in trajectory.positions.iter().zip(&trajectory.directions).enumerate() {
            let position = self.root.local(position - self.root.position) / self.moves.scale;
            let direction = self.root.local(direction.with_y(0.0).normalize_or(self.root.forward));
            set_ahead(&mut wanted, index, position, direction);
        }
        // The velocities of a walking figure match other walking frames, so the figure would never stop. So search for
        // zero velocities.
        let farthest = STOPS_WITHIN * self.moves.scale;
        let stays = |position: &Vec3| (position - self.root.position).with_y(0.0).length() < farthest;
        if self.can_stand && trajectory.positions.iter().all(stays) {
            set_still(&mut wanted);
        }
        let query = self.tree.normalized(&wanted);
        let limit = match ends {
            true => f32::INFINITY,
            false => self.tree.distance(&query, &self.tree.normalized(&playing)),
        };
        let near = self.frame.saturating_sub(NEAR)..self.frame + NEAR + 1;
        if let Some((frame, _)) = self.tree.nearest(&query, limit, near) {
            self.jump(frame);
        }
    }

    /// Continues in another frame. The difference to fade out is between the pose shown without the jump and the pose
    /// of the new frame. The pose of the previous frame gives the change of the difference.
    fn jump(&mut self, frame: usize) {
        let before = frame - usize::from(!self.moves.frames[frame].is_first);
        let (position, rotation) = self.hips_now();
        // Both poses are relative to the root of the new frame.
        let root = self.moves.frames[frame].root;
        let [new, old] = [frame, before].map(|frame| self.placed(&self.moves.frames[frame], &root));
        let offset = [position - new.0, log(rotation * new.1.inverse())];
        let turned_before = nearest_to(offset[1], log(self.hips.1 * old.1.inverse()));
        let offset_before = [self.hips.0 - old.0, turned_before];
        for axis in 0..2 {
            self.hips_differ[axis] = (offset[axis], offset[axis] - offset_before[axis]);
        }
        let now = self.moves.rotations(self.frame);
        let (new, old) = (self.moves.rotations(frame), self.moves.rotations(before));
        for (column, difference) in self.differences.iter_mut().enumerate() {
            let (offset, speed) = *difference;
            let now = now[column] * exp(fade(offset, speed, self.since, FADE));
            let offset = log(new[column].inverse() * now);
            let offset_before = nearest_to(offset, log(old[column].inverse() * self.shown[column]));
            *difference = (offset, offset - offset_before);
        }
        (self.frame, self.since) = (frame, 0);
        self.jumps += 1;
    }

    /// The hips of a frame in the world, moved together with `root` of the database, so that `root` is at the root of
    /// the figure.
    fn placed(&self, frame: &Frame, root: &Root) -> (Vec3, Quat) {
        let position = self.root.position + self.world(root.local(frame.position - root.position));
        let angle = root
            .forward
            .cross(self.root.forward)
            .y
            .atan2(root.forward.dot(self.root.forward));
        (position, Quat::from_rotation_y(angle) * frame.rotation)
    }

    /// The hips of the current frame, with the part of the difference that has not faded out.
    fn hips_now(&self) -> (Vec3, Quat) {
        let frame = &self.moves.frames[self.frame];
        let (position, rotation) = self.placed(frame, &frame.root);
        let [moved, turned] = self
            .hips_differ
            .map(|(offset, speed)| fade(offset, speed, self.since, FADE));
        (position + moved, (exp(turned) * rotation).normalize())
    }

    /// Computes the shown pose: the pose of the frame, with the parts of the differences that have not faded out. Locks
    /// the feet.
    fn show(&mut self) {
        self.hips = self.hips_now();
        let rotations = self.moves.rotations(self.frame);
        for (column, (offset, speed)) in self.differences.iter().enumerate() {
            let rotation = (rotations[column] * exp(fade(*offset, *speed, self.since, FADE))).normalize();
            self.shown[column] = rotation;
            let at_rest = self.moves.at_rest[column];
            let node = self.moves.nodes[column];
            self.pose.node_to_parent[node.index()] = Trs { rotation, ..at_rest }.matrix();
        }
        let (translation, rotation) = self.hips;
        let world = Trs {
            translation,
            rotation,
            scale: self.moves.hips_scale,
        };
        self.pose.node_to_parent[self.moves.hips.index()] = self.moves.world_to_above * world.matrix();
        self.pose.update_world();
        let contacts = self.moves.frames[self.frame].contacts;
        for (side, lock) in self.locks.iter_mut().enumerate() {
            let limb = (self.moves.legs[side], self.moves.knees[side]);
            lock.hold(
                &mut self.pose,
                limb,
                self.moves.balls[side],
                contacts >> side,
                self.moves.scale,
            );
        }
    }
}

/// The rotation vector of the same rotation as `vector` that is nearer to `other`. A rotation has two rotation vectors
/// of at most 360 degrees. Near 180 degrees, the shorter vector flips its sign between frames although the joint does
/// not move.
pub fn nearest_to(other: Vec3, vector: Vec3) -> Vec3 {
    let angle = vector.length();
    let longer = vector * (1.0 - std::f32::consts::TAU / angle);
    if angle > 0.0 && longer.distance_squared(other) < vector.distance_squared(other) {
        longer
    } else {
        vector
    }
}
