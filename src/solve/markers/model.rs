//! A body with markers: joints with offsets, markers with offsets on their bones, and the equations that joints and
//! markers give for a pose.

use glam::{DQuat, DVec3};

use super::tree::Tree;
use super::weights::MarkerWeights;

/// What calibration may change about a joint's offset from its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Freedom {
    /// Nothing.
    Fixed,
    /// The length of the offset, not its direction.
    Length,
    /// The whole offset. The value is the standard deviation of each coordinate, in metres.
    Position(f64),
}

/// How a joint bends: the axis in the T-pose, and the direction of the child bone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hinge {
    pub(super) axis: DVec3,
    pub(super) along: DVec3,
    /// Whether the child bone does not twist. A shin does not; a forearm does.
    pub(super) is_pure: bool,
}

#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub parent: Option<usize>,
    pub(super) offset: DVec3,
    pub(super) freedom: Freedom,
    /// The expected rotation from `usual` without marker evidence, about each axis of the T-pose, in radians. A joint
    /// with `None` does not rotate.
    pub(super) bend: Option<DVec3>,
    /// The usual rotation of the joint: of the T-pose, or the mean of a take.
    pub(super) usual: DQuat,
    /// Whether the markers of a take show the usual rotation.
    pub(super) is_shown: bool,
    pub(super) hinge: Option<Hinge>,
}

#[derive(Clone, Debug)]
pub(super) struct Marker {
    pub(super) joint: usize,
    pub(super) offset: DVec3,
    /// The standard deviation of each coordinate of the offset, in metres.
    pub(super) spread: f64,
}

/// Positions and rotations of all joints.
#[derive(Clone, Debug)]
pub(super) struct Pose {
    pub(super) root: DVec3,
    /// Rotations relative to the parent.
    pub(super) local: Vec<DQuat>,
}

/// Positions and rotations of all joints, in the world.
#[derive(Clone, Debug, Default)]
pub(super) struct World {
    pub(super) positions: Vec<DVec3>,
    pub(super) rotations: Vec<DQuat>,
}

/// A residual divided by its standard deviation, the index of the first of three unknowns, and the derivatives with
/// respect to these unknowns.
pub(super) type Term = (f64, usize, DVec3);

#[derive(Clone, Debug)]
pub(super) struct Model {
    /// Parents first.
    pub(super) joints: Vec<Joint>,
    pub(super) markers: Vec<Marker>,
    /// The standard deviation of a marker coordinate about its offset, in metres.
    pub(super) slides: f64,
    /// The distance in metres at which a marker has a quarter of its weight.
    pub(super) outlier: f64,
    pub(super) weights: MarkerWeights,
    /// The first of the three unknowns of a joint's rotation. Unknowns of children precede the unknowns of their
    /// parents, so that the normal equations are solved along the tree.
    pub(super) unknown: Vec<Option<usize>>,
    pub(super) unknowns: usize,
    /// The first of the three unknowns of the root position, which come last.
    pub(super) root: usize,
    /// The blocks of three unknowns: joints, and last the position of the root.
    pub(super) tree: Tree,
    /// The joints that move each joint: the joint itself first, the root last.
    chains: Vec<Vec<usize>>,
}

/// A small rotation as a rotation vector in radians (approximate).
fn turned(rotation: DQuat) -> DVec3 {
    rotation.xyz() * (2.0 * if rotation.w < 0.0 { -1.0 } else { 1.0 })
}

impl Model {
    pub(super) fn new(joints: Vec<Joint>, markers: Vec<Marker>, weights: MarkerWeights) -> Self {
        let mut root = 0;
        let mut unknown = vec![None; joints.len()];
        for (index, joint) in joints.iter().enumerate().rev() {
            unknown[index] = joint.bend.map(|_| {
                root += 3;
                root - 3
            });
        }
        let unknowns = root + 3;
        let chains: Vec<Vec<usize>> = (0..joints.len())
            .map(|joint| std::iter::successors(Some(joint), |joint| joints[*joint].parent).collect())
            .collect();
        let mut parents = vec![None; unknowns / 3];
        for chain in &chains {
            let blocks: Vec<usize> = chain.iter().filter_map(|joint| unknown[*joint]).collect();
            for (first, above) in std::iter::zip(&blocks, blocks.iter().skip(1).chain([&root])) {
                parents[first / 3] = Some(above / 3);
            }
        }
        Self {
            joints,
            markers,
            slides: weights.slide,
            outlier: weights.outlier,
            weights,
            unknown,
            unknowns,
            root,
            tree: Tree::new(&parents),
            chains,
        }
    }

    pub(super) fn world(&self, pose: &Pose, world: &mut World) {
        world.positions.clear();
        world.rotations.clear();
        for (joint, local) in std::iter::zip(&self.joints, &pose.local) {
            let (position, rotation) = match joint.parent {
                None => (pose.root, *local),
                Some(parent) => (
                    world.positions[parent] + world.rotations[parent] * joint.offset,
                    world.rotations[parent] * *local,
                ),
            };
            world.positions.push(position);
            world.rotations.push(rotation);
        }
    }

    pub(super) fn marker(&self, marker: usize, world: &World) -> DVec3 {
        world.positions[self.markers[marker].joint] + self.arm(marker, world)
    }

    /// The vector to a marker from the joint that moves it.
    pub(super) fn arm(&self, marker: usize, world: &World) -> DVec3 {
        let Marker { joint, offset, .. } = self.markers[marker];
        world.rotations[joint] * offset
    }

    /// The joints that move a joint: itself first, the root last.
    pub(super) fn chain(&self, joint: usize) -> &[usize] {
        &self.chains[joint]
    }

    /// The derivatives of a marker's position with respect to the unknowns of the body. `offsets` has the first unknown
    /// of each joint's offset, `first` is the first unknown of the marker offsets.
    pub(super) fn grows(
        &self,
        marker: usize,
        world: &World,
        offsets: &[Option<usize>],
        first: usize,
        columns: &mut Vec<(usize, DVec3)>,
    ) {
        columns.clear();
        let own = self.markers[marker].joint;
        for &joint in self.chains[own].iter().rev() {
            let (Some(column), Some(parent)) = (offsets[joint], self.joints[joint].parent) else {
                continue;
            };
            let rotation = world.rotations[parent];
            match self.joints[joint].freedom {
                Freedom::Fixed => {}
                Freedom::Length => columns.push((column, rotation * self.joints[joint].offset.normalize_or_zero())),
                Freedom::Position(_) => {
                    columns.extend(
                        DVec3::AXES
                            .into_iter()
                            .enumerate()
                            .map(|(axis, unit)| (column + axis, rotation * unit)),
                    );
                }
            }
        }
        let rotation = world.rotations[own];
        let column = first + 3 * marker;
        columns.extend(
            DVec3::AXES
                .into_iter()
                .enumerate()
                .map(|(axis, unit)| (column + axis, rotation * unit)),
        );
    }

    /// The equations that joints give for a pose without markers: hinges bend about their axis, and a joint stays near
    /// its usual rotation.
    pub(super) fn terms(&self, pose: &Pose, world: &World, mut add: impl FnMut(Term)) {
        for (index, joint) in self.joints.iter().enumerate() {
            let (Some(unknown), Some(bend), Some(parent)) = (self.unknown[index], joint.bend, joint.parent) else {
                continue;
            };
            let local = pose.local[index];
            let to_world = world.rotations[parent];
            // A world rotation by `d` rotates the joint relative to its parent by the inverse of `to_world` times `d`.
            let mut term = |value: f64, slope: DVec3, deviation: f64| {
                add((value / deviation, unknown, to_world * slope / deviation));
            };
            let turned = turned(local * joint.usual.inverse());
            for axis in DVec3::AXES {
                term(turned.dot(axis), axis, bend.dot(axis));
            }
            let Some(hinge) = joint.hinge else { continue };
            let along = local * hinge.along;
            term(
                hinge.axis.dot(along),
                along.cross(hinge.axis),
                self.weights.beside_hinge,
            );
            if hinge.is_pure {
                let own = local * hinge.axis;
                let across = hinge.axis.cross(hinge.along);
                term(own.dot(hinge.along), own.cross(hinge.along), self.weights.beside_hinge);
                term(own.dot(across), own.cross(across), self.weights.beside_hinge);
            }
        }
    }

    /// The equations that pull a joint toward a rotation relative to its parent, with the standard deviation in
    /// radians.
    pub(super) fn toward(
        &self,
        joint: usize,
        pose: &Pose,
        world: &World,
        (rotation, deviation): (DQuat, f64),
        mut add: impl FnMut(Term),
    ) {
        let Some(unknown) = self.unknown[joint] else { return };
        let to_world = self.joints[joint]
            .parent
            .map_or(DQuat::IDENTITY, |parent| world.rotations[parent]);
        let off = turned(pose.local[joint] * rotation.inverse());
        for axis in DVec3::AXES {
            add((off.dot(axis) / deviation, unknown, to_world * axis / deviation));
        }
    }

    /// Changes the axes of the root to `axes`, which are relative to the present ones. Bodies and poses do not move.
    pub(super) fn turn_root<'p>(&mut self, axes: DQuat, poses: impl Iterator<Item = &'p mut Pose>) {
        let back = axes.inverse();
        let is_below: Vec<bool> = self.joints.iter().map(|joint| joint.parent == Some(0)).collect();
        let mut joints: Vec<&mut Joint> = self.joints.iter_mut().filter(|joint| joint.parent == Some(0)).collect();
        joints.iter_mut().for_each(|joint| joint.usual = back * joint.usual);
        let markers = self.markers.iter_mut().filter(|marker| marker.joint == 0);
        let offsets = joints.into_iter().map(|joint| &mut joint.offset);
        offsets
            .chain(markers.map(|marker| &mut marker.offset))
            .for_each(|offset| *offset = back * *offset);
        for pose in poses {
            pose.local[0] = (pose.local[0] * axes).normalize();
            let below = std::iter::zip(&mut pose.local, &is_below).filter(|(_, is_below)| **is_below);
            below.for_each(|(local, _)| *local = (back * *local).normalize());
        }
    }

    /// Changes a pose by a step of its unknowns.
    pub(super) fn step(&self, pose: &mut Pose, world: &World, step: &[DVec3]) {
        pose.root += step[self.root / 3];
        for (joint, local) in pose.local.iter_mut().enumerate() {
            let Some(unknown) = self.unknown[joint] else { continue };
            let turn = step[unknown / 3];
            let parent = self.joints[joint]
                .parent
                .map_or(DQuat::IDENTITY, |parent| world.rotations[parent]);
            *local = (DQuat::from_scaled_axis(parent.inverse() * turn) * *local).normalize();
        }
    }
}
