//! Retargets the motion of an animal on four legs to another animal on four legs.
//!
//! Both skeletons are compared in their standing poses. The segments of the legs get the directions of the source's
//! segments. Trunk, head, tail and paws get the rotations of the source relative to its standing pose. The neck gets
//! the directions of the source's neck, whatever the number of its joints. A joint outside these parts follows its
//! parent, or a joint of the source with the same name. Then the legs bend, so that paws in stance keep their place.

mod drives;
mod measure;

use glam::{DQuat, DVec3, Quat, Vec3};
use mocap_figure::animal::{AnimalTrack, LegGoal, RETURN, Standing, shifts};
use mocap_figure::report::{Quadruped, QuadrupedLeg};
use mocap_figure::rig::Rig;
use mocap_figure::ticks::{Ticks, ticks};
use mocap_figure::{Creature, Figure};
use mocap_scene::error::{Code, Result};
use mocap_scene::limits::positive;
use mocap_scene::math::directions::rotation_of;
use mocap_scene::math::median::median;
use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::math::up_axis::from_to;
use mocap_scene::pose::{Binding, Pose, Trs};
use mocap_scene::scene::report::{AppliedStep, SecondMotion};
use mocap_scene::scene::{Animation, Channel, HumanoidBone as Bone, Keys, NodeId, NodeKind, Scene};

use self::drives::{Drive, Drives};
use crate::plan::UnmappedBone;
use crate::quality::{ByNames, RetargetReport};
use crate::{Scale, no_animation};

/// The largest distance of a held paw from its position without the hold, as a fraction of the leg. The same value is
/// used on robots.
const FARTHEST_HELD: f64 = 0.3;

/// The largest vertical distance between the lowest vertex and the lowest paw, as a fraction of the leg, at which this
/// vertex is on the floor. A vertex at a larger distance belongs to a prop.
const SOLE: f32 = 0.5;

/// The humanoid bones under which reports list the segments of each leg. Front legs have the names of arms.
pub(crate) const SEGMENTS: [[Bone; 3]; 4] = [
    [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand],
    [Bone::RightUpperArm, Bone::RightLowerArm, Bone::RightHand],
    [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot],
    [Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot],
];

/// A segment of a leg in both skeletons: the bone under which reports list the segment, and the joints at both ends.
#[derive(Clone, Copy, Debug)]
struct Segment {
    bone: Bone,
    source: [NodeId; 2],
    target: [NodeId; 2],
}

/// Retargets the motions of one animal to another animal.
#[derive(Clone, Debug)]
pub(crate) struct AnimalRetargeter {
    figure: Figure,
    animal: Quadruped,
    /// The target with joints as children of the joints that they follow.
    rig: Option<Box<Rig>>,
    /// The legs of the target, as nodes of the rig.
    paws: [NodeId; 4],
    hips: [NodeId; 4],
    legs: [LegGoal; 4],
    segments: Vec<Segment>,
    unmapped: Vec<UnmappedBone>,
    found: ByNames,
    drives: Vec<Drive>,
    /// The drive of each node of the rig.
    drive_of: Vec<Option<usize>>,
    /// The drive that gets the path over the ground.
    root: usize,
    /// Joints without a drive whose transform in the standing pose differs from the rest pose.
    still: Vec<(NodeId, Trs)>,
    standing: Pose,
    to_target: Quat,
    up: [Vec3; 2],
    /// Units of the target per metre of the source.
    scale: f32,
    metres: f64,
    /// The length of the target's legs, in units of the target.
    leg: f32,
    /// The height at which each paw of the target rests, and the height of the floor.
    ground: [f32; 4],
    floor: f32,
    lock_feet: bool,
}

/// The target in all frames of a motion.
struct Moved {
    /// The rotations of all drives relative to the parent, in each frame.
    rotations: Vec<Vec<Quat>>,
    /// The midpoint of hips and shoulders in each frame.
    centres: Vec<Vec3>,
    /// The positions of the paws in each frame.
    paws: Vec<[Vec3; 4]>,
    /// The heights of the source's paws above their resting level, in units of the target.
    rises: Vec<[f32; 4]>,
}

impl AnimalRetargeter {
    /// Prepares to retarget the motions of `source` to `target`. `None` if `source` or `target` is not an animal on
    /// four legs whose parts are known.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if `scale` is not above 0.
    pub(crate) fn new(
        (source, from): (&Scene, &Figure),
        (target, to): (&Scene, &Figure),
        scale: Scale,
        lock_feet: bool,
    ) -> Result<Option<Self>> {
        let (Some(animal), Some(other)) = (from.quadruped(source), to.quadruped(target)) else {
            return Ok(None);
        };
        let standing = [Standing::new(source, from, animal), Standing::new(target, to, other)];
        let rig = Rig::new(target, &to.humanoid.follow).map(Box::new);
        let other = match &rig {
            Some(rig) => other.clone().map(|node| rig.node(node)),
            None => other.clone(),
        };
        let scene = rig.as_deref().map_or(target, |rig| &rig.scene);
        let mut stands = standing[1].pose.clone();
        if let Some(rig) = rig.as_deref() {
            let mut pose = Pose::rest(&rig.scene);
            if !standing[1].is_rest {
                rig.take_pose(&stands, &mut pose);
                pose.update_world();
            }
            stands = pose;
        }
        let upright = rotation_of(&from_to(from.survey.up.value, to.survey.up.value));
        let up = [from.up_direction(), to.up_direction()];
        // Without a standing rest pose, the heading of the skeleton is not known.
        let heading = match standing[0].is_rest && standing[1].is_rest {
            true => {
                let [was, is] = [upright * (standing[0].axes * Vec3::Z), standing[1].axes * Vec3::Z];
                Quat::from_axis_angle(up[1], up[1].dot(was.cross(is)).atan2(was.dot(is)))
            }
            false => Quat::IDENTITY,
        };
        let length = |pose: &Pose, animal: &Quadruped| {
            let of_leg = |leg: &QuadrupedLeg| {
                let joints: Vec<Vec3> = leg.joints().map(|node| pose.position(node)).collect();
                joints.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f32>()
            };
            0.25 * animal.legs.iter().map(of_leg).sum::<f32>()
        };
        let (leg_of_source, leg) = (length(&standing[0].pose, animal), length(&stands, &other));
        let metres = f64::from(to.metres());
        let per_metre = 1.0 / metres;
        let scale = match scale {
            Scale::Auto => f64::from(leg) / f64::from(leg_of_source * from.metres()).max(f64::EPSILON),
            Scale::None => per_metre,
            Scale::Factor(factor) => per_metre * positive(Code::InvalidValue, "scale", factor)?,
        };
        let paws = other.legs.each_ref().map(|leg| leg.paw);
        // If the animal stands in the middle of a step, one paw is in the air. So both paws of a pair get the level of
        // the lower one.
        let level = |index: usize| stands.position(paws[index]).dot(up[1]);
        let ground = std::array::from_fn(|index| level(index).min(level(index ^ 1)));
        let lowest = ground.iter().copied().fold(f32::INFINITY, f32::min);
        let skins = scene.own_meshes().filter(|mesh| !mesh.bones.is_empty());
        let vertices = skins.flat_map(|mesh| stands.skin(mesh)).map(|vertex| vertex.dot(up[1]));
        let floor = vertices.fold(f32::INFINITY, f32::min);
        let is_sole = (floor - lowest).abs() < SOLE * leg;
        let mut drives = Drives::new(
            source,
            (animal, &standing[0]),
            scene,
            (&other, &stands, standing[1].axes),
        );
        drives.add_all();
        let lacking = drives.lacking();
        let (drives, segments, unmapped, root) = drives.into_parts();
        let mut drive_of = vec![None; scene.nodes.len()];
        for (index, drive) in drives.iter().enumerate() {
            drive_of[drive.node.index()] = Some(index);
        }
        let still = scene.nodes.iter().enumerate().filter_map(|(index, node)| {
            let is_still = node.kind == NodeKind::Joint && drive_of[index].is_none();
            let stands = stands.node_to_parent[index];
            (is_still && stands != node.transform).then(|| (NodeId::new(index), Trs::from_matrix(stands)))
        });
        let legs = other.legs.each_ref().map(|leg| {
            // An ankle that follows no joint of the source is a part of the lower leg.
            let ankle = leg.ankle.filter(|ankle| drive_of[ankle.index()].is_some());
            LegGoal::new(&stands, leg, ankle, standing[1].axes * Vec3::X)
        });
        Ok(Some(Self {
            figure: from.clone(),
            animal: animal.clone(),
            paws,
            hips: other.legs.each_ref().map(|leg| leg.upper),
            legs,
            segments,
            unmapped,
            found: ByNames {
                creature: Creature::FourLegged.as_str().to_owned(),
                joints: drives.len(),
                lacking,
                by_parts: true,
            },
            still: still.collect(),
            root,
            drives,
            drive_of,
            to_target: (heading * upright).normalize(),
            up,
            scale: scale as f32,
            metres,
            leg,
            ground,
            floor: if is_sole { floor } else { lowest },
            standing: stands,
            lock_feet,
            rig,
        }))
    }

    /// The retargeting step for the record of a file.
    pub(crate) fn step(&self, target: &Scene) -> AppliedStep {
        AppliedStep::Retarget {
            onto: SecondMotion::of(target),
            scale: f64::from(self.scale) * self.metres,
            lock_feet: self.lock_feet,
        }
    }

    /// An animation of `source`, by its index, on the skeleton of `target`, with a report.
    ///
    /// # Errors
    /// [`Code::NoMotion`] if there is no such animation.
    pub(crate) fn clip(&self, source: &Scene, index: usize, target: &Scene) -> Result<(Animation, RetargetReport)> {
        let Some(animation) = source.animations.get(index) else {
            return Err(no_animation(index, source));
        };
        let scene = self.rig.as_deref().map_or(target, |rig| &rig.scene);
        let all = ticks(animation);
        let track = AnimalTrack::new(source, animation, &self.figure, &self.animal);
        let moved = self.turn(source, animation, &all, &track, scene);
        let moved = self.stand(moved, &all, animation, &track, scene);
        let report = self.report(source, animation, (scene, &moved), &all, &track);
        let moved = match self.rig.as_deref() {
            Some(rig) => rig.in_file(&moved),
            None => moved,
        };
        Ok((moved, report))
    }

    /// The rotations of all drives, before paws are held on the ground.
    fn turn(&self, source: &Scene, animation: &Animation, all: &[f64], track: &AnimalTrack, scene: &Scene) -> Moved {
        let binding = Binding::new(source, animation);
        let (mut from, mut to) = (Pose::rest(source), self.standing.clone());
        let metres = self.figure.metres();
        let mut moved = Moved {
            rotations: vec![Vec::with_capacity(all.len()); self.drives.len()],
            centres: Vec::with_capacity(all.len()),
            paws: Vec::with_capacity(all.len()),
            rises: Vec::with_capacity(all.len()),
        };
        let level = 0.25 * track.ground.iter().sum::<f64>() as f32;
        let ground = 0.25 * self.ground.iter().sum::<f32>();
        for &tick in all {
            from.sample(&binding, animation, tick);
            self.pose(&from, &mut to, scene, &mut moved.rotations);
            let middle = 0.25
                * self
                    .animal
                    .legs
                    .iter()
                    .map(|leg| from.position(leg.upper))
                    .sum::<Vec3>();
            let height = metres * middle.dot(self.up[0]) - level;
            let path = self.scale * metres * (self.to_target * middle);
            let centre = path.reject_from_normalized(self.up[1]) + (ground + self.scale * height) * self.up[1];
            let shift = centre - self.centre(&to);
            moved.centres.push(centre);
            moved.paws.push(self.paws.map(|paw| to.position(paw) + shift));
            moved.rises.push(std::array::from_fn(|index| {
                let height = metres * from.position(self.animal.legs[index].paw).dot(self.up[0]);
                self.scale * (height - track.ground[index] as f32)
            }));
        }
        moved
    }

    /// Gives the target the rotations of the source, and stores them relative to the parents.
    fn pose(&self, from: &Pose, to: &mut Pose, scene: &Scene, kept: &mut [Vec<Quat>]) {
        for index in 0..scene.nodes.len() {
            let parent = scene.nodes[index].parent;
            if let Some(at) = self.drive_of[index] {
                let drive = &self.drives[at];
                let above = parent.map_or(Quat::IDENTITY, |parent| rotation_of(&to.node_to_world[parent.index()]));
                let world = drive.rotation(from, self.to_target, above);
                let local = (above.inverse() * world).normalize();
                let rotation = kept[at].last().map_or(local, |last| in_hemisphere_of(*last, local));
                kept[at].push(rotation);
                to.node_to_parent[index] = Trs {
                    rotation,
                    ..drive.stands
                }
                .matrix();
            }
            to.node_to_world[index] = match parent {
                Some(parent) => to.node_to_world[parent.index()] * to.node_to_parent[index],
                None => to.node_to_parent[index],
            };
        }
    }

    fn centre(&self, pose: &Pose) -> Vec3 {
        0.25 * self.hips.iter().map(|hip| pose.position(*hip)).sum::<Vec3>()
    }

    /// Puts the target on the ground, and bends its legs.
    fn stand(&self, moved: Moved, all: &[f64], animation: &Animation, track: &AnimalTrack, scene: &Scene) -> Animation {
        let contacts = |frame: usize| track.contacts[frame.min(track.contacts.len() - 1)];
        let error = |frame: usize, index: usize| {
            let height = moved.paws[frame][index].dot(self.up[1]);
            f64::from(self.ground[index] + moved.rises[frame][index] - height)
        };
        let pairs = || (0..all.len()).flat_map(|frame| (0..4).map(move |index| (frame, index)));
        let mut errors: Vec<f64> = pairs()
            .filter(|(frame, index)| contacts(*frame)[*index])
            .map(|(frame, index)| error(frame, index))
            .collect();
        if errors.is_empty() {
            errors = pairs().map(|(frame, index)| error(frame, index)).collect();
        }
        let lift = median(&mut errors).unwrap_or(0.0) as f32 * self.up[1];
        let goals = self.lock_feet.then(|| self.goals(&moved, animation, &contacts));
        let Moved {
            mut rotations, centres, ..
        } = moved;
        let mut to = self.standing.clone();
        let mut path = Vec::with_capacity(all.len());
        let root = self.drives[self.root].node;
        let parent = scene.nodes[root.index()].parent;
        for frame in 0..all.len() {
            for (drive, rotations) in self.drives.iter().zip(&rotations) {
                let rotation = rotations[frame];
                to.node_to_parent[drive.node.index()] = Trs {
                    rotation,
                    ..drive.stands
                }
                .matrix();
            }
            to.update_world();
            let at = to.position(root) + centres[frame] + lift - self.centre(&to);
            let at = match parent {
                Some(parent) => to.node_to_world[parent.index()].inverse().transform_point3(at),
                None => at,
            };
            path.push(at);
            let Some(goals) = &goals else { continue };
            to.node_to_parent[root.index()].w_axis = at.extend(1.0);
            to.update_world();
            for (leg, goal) in self.legs.iter().zip(goals) {
                leg.reach(&mut to, goal[frame]);
                for node in leg.nodes() {
                    let Some(at) = self.drive_of[node.index()] else {
                        continue;
                    };
                    let local = rotation_of(&to.node_to_parent[node.index()]);
                    let before = frame.checked_sub(1).map(|before| rotations[at][before]);
                    rotations[at][frame] = before.map_or(local, |before| in_hemisphere_of(before, local));
                }
            }
        }
        let at = Ticks::new(all);
        let driven = self.drives.iter().zip(rotations).enumerate();
        let driven = driven.map(|(index, (drive, values))| Channel {
            node_name: scene.nodes[drive.node.index()].name.clone(),
            node: Some(drive.node),
            position_keys: match index == self.root {
                true => at.keys(std::mem::take(&mut path)),
                false => Keys::constant(drive.stands.translation),
            },
            rotation_keys: at.rotation_keys(values),
            scaling_keys: Keys::constant(drive.stands.scale),
        });
        let mut channels: Vec<Channel> = driven.collect();
        channels.extend(self.still.iter().map(|(node, trs)| Channel {
            node_name: scene.nodes[node.index()].name.clone(),
            node: Some(*node),
            position_keys: Keys::constant(trs.translation),
            rotation_keys: Keys::constant(trs.rotation),
            scaling_keys: Keys::constant(trs.scale),
        }));
        let mut moved = Animation {
            name: animation.name.clone(),
            ticks_per_second: animation.ticks_per_second,
            duration: animation.duration,
            channels,
        };
        moved.sort_channels();
        moved
    }

    /// The goals of the paws. In stance, a paw stays at one place. Its height above the resting level is the same as in
    /// the source.
    fn goals(&self, moved: &Moved, animation: &Animation, contacts: &dyn Fn(usize) -> [bool; 4]) -> [Vec<Vec3>; 4] {
        let level = DQuat::from_rotation_arc(self.up[1].as_dvec3(), DVec3::Z);
        let frames = moved.paws.len();
        std::array::from_fn(|index| {
            let stands: Vec<bool> = (0..frames).map(|frame| contacts(frame)[index]).collect();
            let paws: Vec<DVec3> = (0..frames)
                .map(|frame| {
                    let height = self.ground[index] + moved.rises[frame][index].max(0.0);
                    (level * moved.paws[frame][index].as_dvec3()).with_z(f64::from(height))
                })
                .collect();
            let most = FARTHEST_HELD * f64::from(self.leg);
            let shifts = shifts(&stands, &paws, None, most, RETURN * animation.ticks_per_second);
            let places = paws.iter().zip(shifts);
            places
                .map(|(paw, shift)| (level.inverse() * (*paw + shift)).as_vec3())
                .collect()
        })
    }
}
