//! Mirrors a motion, so that left and right are exchanged.

mod morphs;
mod partners;
mod reference;
mod sides;

use std::fmt;

use glam::{DMat4, DQuat, DVec3, Quat, Vec3};
use mocap_figure::animal::Standing;
use mocap_figure::names::Name;
use mocap_figure::{Figure, Humanoid, HumanoidBone};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::{Binding, FaceTrack, Pose, Trs};
use mocap_scene::scene::{Face, NodeId, Scene};
use serde::Serialize;

use self::partners::partners;
use super::body::{animal_of, figure_of};
use super::frames::Frames;
use super::quantity::{centimetres, counted};
use super::step::step;
use super::{Step, StepInput, StepKey};

step! {
    /// Mirrors a motion: the right side of the figure moves as the left side did, and the left side as the right side
    /// did. The mirror is a vertical plane, whose normal is the mean direction to the figure's left. A figure that
    /// walks forward still walks forward.
    ///
    /// The step pairs joints by their bones, and joints below the bones by their positions. It does not use the names
    /// of joints. It reflects the rotation of each joint relative to the rest pose. If the two sides of the rest pose
    /// are not mirror images, a T-pose takes the place of the rest pose. In this T-pose, each bone has its mean roll in
    /// the motion. For an animal on four legs, its standing pose takes the place of the rest pose. The offset of a
    /// joint from its parent does not change, so the bones of each side keep their lengths. A second `mirror` restores
    /// the motion.
    ///
    /// Morph targets of one mesh exchange their weights if their names differ only in the side, such as `eyeBlinkLeft`
    /// and `eyeBlinkRight`. In a VRM animation, the step exchanges the winks of both eyes, and mirrors the gaze.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Mirror, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let report = Mirror::new().apply(&mut scene, &StepInput::new())?;
    /// assert!(report.pairs >= 10 && report.largest_asymmetry < 0.05);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NotHumanoid`]; [`Code::NoMotion`] if the scene lacks the animation. `scene` is then unchanged.
    Mirror {}
}

impl Step for Mirror {
    const NAME: &'static str = "mirror";
    const HELP: &'static str = "exchange left and right";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = MirrorReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<MirrorReport> {
        mirror(scene, input.animation, input.bones())
    }
}

/// The report of [`Mirror`].
///
/// [`Mirror`](crate::Mirror) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MirrorReport {
    /// The number of pairs of joints that exchanged their motion.
    pub pairs: usize,
    /// The names of the joints that belong to one side and have no partner on the other side. The motion of such a
    /// joint is mirrored without an exchange.
    pub without_partner: Vec<String>,
    /// The largest distance between a joint and the mirror image of its partner before the step, in metres. It is 0 if
    /// both sides of the skeleton are equal.
    pub largest_asymmetry: f32,
    /// The name of the joint with `largest_asymmetry`.
    pub asymmetric_joint: String,
    /// The number of pairs of morph targets that exchanged their weights.
    pub morph_pairs: usize,
}

impl fmt::Display for MirrorReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of joints exchanged", counted(self.pairs, "pair"))?;
        if self.morph_pairs > 0 {
            write!(f, ", {} of morph targets", counted(self.morph_pairs, "pair"))?;
        }
        if !self.without_partner.is_empty() {
            let alone = counted(self.without_partner.len(), "joint");
            write!(f, ", {alone} without a partner on the other side")?;
        }
        if !self.asymmetric_joint.is_empty() {
            let off = centimetres(self.largest_asymmetry);
            write!(
                f,
                "; the sides of the skeleton differ most at {}, by {off}",
                self.asymmetric_joint
            )?;
        }
        Ok(())
    }
}

fn mirror(scene: &mut Scene, animation: usize, humanoid: Option<&Humanoid>) -> Result<MirrorReport> {
    if scene.is_face_alone() && animation < scene.animations.len() {
        return Ok(of_face(scene, animation));
    }
    let animal = animal_of(scene, humanoid);
    let figure = match &animal {
        Some((_, animal)) => Figure::with_bones(scene, animal.bones()),
        None => match figure_of(scene, humanoid) {
            // The file has a head, and no body that could be mirrored.
            Err(_) if scene.face_curves_alone(animation).is_some() => return Ok(of_face(scene, animation)),
            figure => figure?,
        },
    };
    let not_humanoid = || Diagnostic::new(Code::NotHumanoid, "the skeleton has no T-pose");
    let hips = figure.humanoid.joint(HumanoidBone::Hips).ok_or_else(not_humanoid)?;
    // The T-pose comes from the skeleton alone, because a T-pose from the motion would change when the motion is
    // mirrored.
    let still = Scene {
        nodes: scene.nodes.clone(),
        metadata: scene.metadata.clone(),
        ..Scene::default()
    };
    let rest = Pose::rest(&still);
    let left_at_rest = reference::left_at_rest(&rest, &figure.humanoid, hips);
    let standing = Figure::with_bones(&still, figure.humanoid.clone());
    let stands = animal
        .as_ref()
        .map(|(figure, animal)| Standing::new(scene, figure, animal));
    let (reference, normal) = match (left_at_rest, &stands) {
        (Some(left), _) => (&rest, left),
        (None, Some(stands)) => (&stands.pose, (stands.axes * Vec3::X).as_dvec3()),
        (None, None) => {
            let t_pose = &standing.t_pose(&still).ok_or_else(not_humanoid)?.pose;
            (t_pose, normal(&standing, t_pose).ok_or_else(not_humanoid)?)
        }
    };
    let partners = partners(scene, &figure.humanoid, reference, hips, normal);

    // If a channel moves a joint, its partner moves after the mirroring. So partners are stored even if no channel
    // drives them.
    let binding = scene
        .animations
        .get(animation)
        .map(|animation| Binding::new(scene, animation));
    let driven = binding.iter().flat_map(Binding::driven);
    let held: Vec<NodeId> = driven.map(|(node, _)| partners[node.index()]).collect();
    let mut frames = Frames::new(scene, animation, &held)?;
    let before = Pose::at_tick(scene, animation, 0.0);
    let face = scene
        .animations
        .get(animation)
        .map(|animation| scene.face_tracks(animation));

    let symmetric = match left_at_rest {
        Some(_) => reference::rotations(reference),
        None => {
            let mut symmetric = reference::symmetric(&still, &figure.humanoid, reference, &partners, normal);
            sides::lay_as_in_motion(scene, &frames, &figure.humanoid, &partners, normal, &mut symmetric);
            symmetric
        }
    };
    let mirrored = MirrorPlan::new(
        scene,
        &frames,
        symmetric,
        &partners,
        hips,
        normal,
        animal
            .as_ref()
            .map_or(&figure, |(figure, _)| figure)
            .up_direction()
            .as_dvec3(),
    );
    let old: Vec<Vec<Trs>> = (0..frames.nodes().len()).map(|column| frames.track(column)).collect();
    let mut column_of = vec![None; scene.nodes.len()];
    for (column, node) in frames.nodes().iter().enumerate() {
        column_of[node.index()] = Some(column);
    }
    let (mut rotations, mut new) = (
        vec![DQuat::IDENTITY; scene.nodes.len()],
        vec![DQuat::IDENTITY; scene.nodes.len()],
    );
    for frame in 0..frames.len() {
        mirrored.frame(scene, frame, &old, &column_of, &mut rotations, &mut new, &mut frames);
    }
    let nodes = frames.nodes().to_vec();
    let moves = |node: &NodeId| {
        let is_exchanged = partners[node.index()] != *node && is_topmost(scene, node.index(), &column_of);
        is_exchanged || column_of[node.index()].is_some_and(|column| mirrored.moves[column])
    };
    let moved: Vec<NodeId> = nodes
        .iter()
        .copied()
        .filter(|node| moves(node) || moves(&partners[node.index()]))
        .collect();
    frames.exchange(&partners);
    frames.write(scene, animation, &nodes, &moved);
    mirror_face(scene, animation, face.unwrap_or_default());

    let mut report = MirrorReport {
        morph_pairs: morphs::exchange(scene, animation),
        pairs: (0..partners.len())
            .filter(|node| partners[*node].index() > *node)
            .count(),
        ..MirrorReport::default()
    };
    let name = |node: NodeId| scene.nodes[node.index()].name.clone();
    let one_sided = figure
        .humanoid
        .bones
        .iter()
        .filter(|(bone, joint)| bone.side().is_some() && partners[joint.joint.index()] == joint.joint);
    report.without_partner = one_sided.map(|(_, joint)| name(joint.joint)).collect();
    if let (Some(before), Some(after)) = (before, Pose::at_tick(scene, animation, 0.0)) {
        let reflect = |point: Vec3| {
            let from = point.as_dvec3() - before.position(hips).as_dvec3();
            (from - 2.0 * from.dot(mirrored.plane) * mirrored.plane).as_vec3()
        };
        for joint in figure.humanoid.bones.values().map(|joint| joint.joint) {
            let here = after.position(joint) - after.position(hips);
            let off = here.distance(reflect(before.position(partners[joint.index()]))) * figure.metres();
            if off > report.largest_asymmetry {
                report.largest_asymmetry = off;
                report.asymmetric_joint = name(joint);
            }
        }
    }
    Ok(report)
}

/// Mirrors a face without a body.
fn of_face(scene: &mut Scene, animation: usize) -> MirrorReport {
    let face = scene.animations.get(animation).map(|clip| scene.face_tracks(clip));
    mirror_face(scene, animation, face.unwrap_or_default());
    MirrorReport {
        morph_pairs: morphs::exchange(scene, animation),
        ..MirrorReport::default()
    }
}

/// Exchanges the facial expressions of the left and the right side, and mirrors the gaze.
fn mirror_face(scene: &mut Scene, animation: usize, mut tracks: Vec<FaceTrack>) {
    let names: Vec<String> = tracks.iter().map(|track| track.face.name().to_owned()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    for (index, pair) in Name::pairs(&names).into_iter().enumerate() {
        let is_now = tracks[index].face.clone();
        let mirrored = match (&is_now, pair) {
            (Face::Custom(_), Some(other)) => Face::Custom(names[other].to_owned()),
            (face, _) => face.mirrored(),
        };
        let track = &mut tracks[index];
        if is_now != mirrored && scene.nodes.iter().all(|node| node.face.as_ref() != Some(&mirrored)) {
            let alone = scene
                .nodes
                .iter_mut()
                .filter(|node| node.face.as_ref() == Some(&is_now));
            alone.for_each(|node| node.face = Some(mirrored.clone()));
        }
        track.face = mirrored;
        for rotation in &mut track.keys.rotation_keys.values {
            *rotation = Quat::from_xyzw(rotation.x, -rotation.y, -rotation.z, rotation.w);
        }
    }
    scene.set_face(animation, &tracks, false);
}

/// The direction to the left of the figure in the T-pose `reference`, as the nearest axis.
fn normal(figure: &Figure, reference: &Pose) -> Option<DVec3> {
    let at = |bone: HumanoidBone| Some(reference.position(figure.humanoid.joint(bone)?).as_dvec3());
    reference::along_axis(at(HumanoidBone::LeftUpperLeg)? - at(HumanoidBone::RightUpperLeg)?)
}

/// The data that the mirroring of every frame needs.
struct MirrorPlan<'a> {
    partners: &'a [NodeId],
    /// The rotations of the reference pose in the world.
    reference: Vec<DQuat>,
    /// The direction to the left in the reference pose.
    normal: DVec3,
    /// The normal of the mirror plane in the world.
    plane: DVec3,
    /// The rotation from the mirror image across the plane of the reference pose to the mirror image across `plane`.
    turn: DQuat,
    /// For each stored node, whether its translation changes during the motion.
    moves: Vec<bool>,
    rest: Pose,
    /// The position of the topmost joint of the figure in the first frame.
    center: DVec3,
}

impl<'a> MirrorPlan<'a> {
    fn new(
        scene: &Scene,
        frames: &Frames,
        reference: Vec<DQuat>,
        partners: &'a [NodeId],
        hips: NodeId,
        normal: DVec3,
        up: DVec3,
    ) -> Self {
        let rotation = |pose: &Pose, node: usize| {
            Trs::from_matrix(pose.node_to_world[node])
                .rotation
                .as_dquat()
                .normalize()
        };
        let at_reference = reference[hips.index()].inverse();
        let mut pose = Pose::rest(scene);
        let mut left_of = |frame: usize| {
            frames.pose(frame, &mut pose);
            (rotation(&pose, hips.index()) * at_reference * normal).reject_from_normalized(up)
        };
        // Averages up to 48 frames, because the hips of a runner swing by 30 degrees. The average is near 0, and so
        // unusable, if the figure turns all the way round or lies on its side.
        let stride = frames.len().div_ceil(48);
        let looked: Vec<DVec3> = (0..frames.len()).step_by(stride).map(&mut left_of).collect();
        let mean = looked.iter().sum::<DVec3>() / looked.len() as f64;
        let candidates = [mean, looked[0], normal.reject_from_normalized(up)];
        let clear = candidates.into_iter().find(|left| left.length() > 0.3);
        let plane = clear.unwrap_or(normal).normalize();
        let turn = DQuat::from_xyzw(0.0, 0.0, 0.0, -plane.dot(normal));
        let cross = plane.cross(normal);
        let above = std::iter::successors(Some(hips), |node| scene.nodes[node.index()].parent);
        let carrier = above
            .filter(|node| frames.column(*node).is_some())
            .last()
            .unwrap_or(hips);
        frames.pose(0, &mut pose);
        let center = pose.position(carrier).as_dvec3();
        Self {
            partners,
            reference,
            normal,
            plane,
            turn: DQuat::from_xyzw(cross.x, cross.y, cross.z, turn.w).normalize(),
            moves: (0..frames.nodes().len())
                .map(|column| {
                    let track = frames.track(column);
                    track.windows(2).any(|pair| pair[0].translation != pair[1].translation)
                })
                .collect(),
            rest: Pose::rest(scene),
            center,
        }
    }

    #[allow(
        clippy::too_many_arguments,
        reason = "two of them are memory that one frame hands to the next"
    )]
    fn frame(
        &self,
        scene: &Scene,
        frame: usize,
        old: &[Vec<Trs>],
        column_of: &[Option<usize>],
        rotations: &mut [DQuat],
        new: &mut [DQuat],
        frames: &mut Frames,
    ) {
        let rest = |node: usize| Trs::from_matrix(scene.nodes[node].transform).rotation.as_dquat();
        let parent_of = |node: usize| scene.nodes[node].parent.map(NodeId::index);
        for node in 0..scene.nodes.len() {
            let own = column_of[node].map_or_else(|| rest(node), |column| old[column][frame].rotation.as_dquat());
            rotations[node] = parent_of(node)
                .map_or(own, |parent| rotations[parent] * own)
                .normalize();
        }
        for node in 0..scene.nodes.len() {
            let above = parent_of(node).map_or(DQuat::IDENTITY, |parent| new[parent]);
            let Some(column) = column_of[node] else {
                new[node] = (above * rest(node)).normalize();
                continue;
            };
            let partner = self.partners[node].index();
            let change = rotations[partner] * self.reference[partner].inverse();
            let wanted = self.turn * mirrored(change, self.normal) * self.reference[node];
            // Uses the rounded rotation of the parent, so that the rounding of 32-bit keys does not add up along a
            // chain.
            let own = (above.inverse() * wanted).normalize().as_quat();
            new[node] = (above * own.as_dquat()).normalize();
            let was = old[column][frame];
            let translation = self.translation(scene, frame, node, old, column_of);
            let rotation = if own.dot(was.rotation) < 0.0 { -own } else { own };
            frames.set(
                frame,
                NodeId::new(node),
                Trs {
                    translation,
                    rotation: nonzero(rotation, was.rotation),
                    ..was
                },
            );
        }
    }

    /// The mirrored translation relative to the parent. The position of a topmost node is reflected across the mirror
    /// plane, which goes through the position of the figure in the first frame. Feet can be topmost nodes, if a rig
    /// attaches them to its root. Any other node is displaced from its rest offset by the mirror image of its partner's
    /// displacement.
    fn translation(
        &self,
        scene: &Scene,
        frame: usize,
        node: usize,
        old: &[Vec<Trs>],
        column_of: &[Option<usize>],
    ) -> Vec3 {
        let offset = |node: usize| scene.nodes[node].transform.w_axis.truncate();
        let partner = self.partners[node].index();
        let (Some(own), Some(other)) = (column_of[node], column_of[partner]) else {
            return offset(node);
        };
        if is_topmost(scene, node, column_of) && is_topmost(scene, partner, column_of) {
            let at = old[other][frame].translation.as_dvec3();
            let from = self.above(scene, partner).transform_point3(at) - self.center;
            let image = self.center + from - 2.0 * from.dot(self.plane) * self.plane;
            return self.above(scene, node).inverse().transform_point3(image).as_vec3();
        }
        if !self.moves[own] && !self.moves[other] {
            return old[own][frame].translation;
        }
        let reference = |node: usize| {
            scene.nodes[node]
                .parent
                .map_or(DQuat::IDENTITY, |parent| self.reference[parent.index()])
        };
        let moved = reference(partner) * (old[other][frame].translation - offset(partner)).as_dvec3();
        let moved = reference(node).inverse() * (moved - 2.0 * moved.dot(self.normal) * self.normal);
        (offset(node).as_dvec3() + moved).as_vec3()
    }

    /// The transform to the world from the parent of a topmost node. The parent never moves.
    fn above(&self, scene: &Scene, node: usize) -> DMat4 {
        let parent = scene.nodes[node].parent;
        parent.map_or(DMat4::IDENTITY, |parent| {
            self.rest.node_to_world[parent.index()].as_dmat4()
        })
    }
}

/// Whether no node above this node moves.
fn is_topmost(scene: &Scene, node: usize, column_of: &[Option<usize>]) -> bool {
    let above = std::iter::successors(scene.nodes[node].parent, |parent| scene.nodes[parent.index()].parent);
    above.into_iter().all(|above| column_of[above.index()].is_none())
}

fn nonzero(rotation: Quat, otherwise: Quat) -> Quat {
    if rotation.is_finite() { rotation } else { otherwise }
}

/// The mirror image of a rotation across the plane of `normal`.
fn mirrored(rotation: DQuat, normal: DVec3) -> DQuat {
    let axis = rotation.xyz();
    let reflected = 2.0 * axis.dot(normal) * normal - axis;
    DQuat::from_xyzw(reflected.x, reflected.y, reflected.z, rotation.w)
}
