//! A motion on the humanoid of VRM: a node for each bone, without rotation in the T-pose.

use std::collections::BTreeMap;

use glam::{Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::{Animation, Channel, Keys, Node, NodeId, Scene, UpAxis};

use super::body::Body;
use super::ground;
use super::ticks::{Ticks, ticks};
use super::track::{Track, whole};
use super::watched::{WatchedJoints, WatchedPose};
use crate::report::HumanoidJoint;
use crate::{Confidence, Figure, Humanoid, HumanoidBone as Bone, is_at_rest_alike};

/// Bones whose rotation is not part of a VRM animation: it has a gaze point instead.
const EYES: [Bone; 2] = [Bone::LeftEye, Bone::RightEye];

/// Bones that VRM requires and that end a chain. If the source lacks such a bone, it is placed at the end of its parent
/// bone, and does not rotate.
pub const ENDS: [Bone; 5] = [
    Bone::Head,
    Bone::LeftHand,
    Bone::RightHand,
    Bone::LeftFoot,
    Bone::RightFoot,
];

/// Converts the motions of `scene`, which is in metres with +Y up, to a skeleton with one node for each bone of the
/// humanoid. The skeleton has the bones and the path of the source. Its T-pose faces +Z with its feet on the ground. In
/// the T-pose no node has a rotation, so the rotations of the motion are VRM's normalized rotations. Only the hips have
/// translation. The nodes of a face come after the bones, and do not change. `known` has the bones, if they are known.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::{Conversion, figure};
///
/// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// Conversion::new().apply(&mut scene)?;
/// let humanoid = figure::vrm_humanoid(&scene, None)?;
/// let bones = |scene: &mocap::Scene| scene.nodes.iter().filter(|node| node.humanoid_bone.is_some()).count();
/// assert_eq!(bones(&humanoid), humanoid.nodes.len());
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// [`Code::NotHumanoid`] if no humanoid is found, or a bone that VRM requires is missing; [`Code::UnknownUnit`] if
/// `scene` is not in metres with +Y up.
pub fn vrm_humanoid(scene: &Scene, known: Option<Humanoid>) -> Result<Scene> {
    vrm_humanoid_shown(scene, None, known)
}

/// Like [`vrm_humanoid`], but the T-pose is inferred from `other`, a scene with further frames of the motion. If a step
/// changed the skeleton, `other` has no effect.
pub fn vrm_humanoid_shown(scene: &Scene, other: Option<&Scene>, known: Option<Humanoid>) -> Result<Scene> {
    if (scene.metadata.metres_per_unit, scene.metadata.up) != (Some(1.0), Some(UpAxis::Y)) {
        let message = "a VRM animation needs metres with +Y up, but the scene does not state this unit and axis";
        return Err(Diagnostic::new(Code::UnknownUnit, message)
            .help("convert the scene first: Conversion::new().apply(&mut scene)")
            .into());
    }
    let known = with_feet(scene, known.unwrap_or_else(|| Humanoid::of(scene)));
    let shows = other.filter(|other| is_at_rest_alike(other, scene)).unwrap_or(scene);
    let figure = Figure::with_bones(shows, known);
    // Computes the T-pose with the animation of `shows`. The figure keeps the T-pose.
    figure.t_pose(shows);
    let body = Body::of_figure(scene, figure, "source")?;
    let mut missing = body.figure.humanoid.missing();
    missing.retain(|bone| !ENDS.contains(bone) || bone.parent().is_none_or(|above| body.joint(above).is_none()));
    if !missing.is_empty() {
        let names: Vec<_> = missing.iter().map(|bone| bone.as_str()).collect();
        let message = format!(
            "the skeleton is not a humanoid, because it lacks these bones: {}",
            names.join(", ")
        );
        return Err(Diagnostic::new(Code::NotHumanoid, message)
            .help("name their joints in a map, or choose another file")
            .into());
    }
    let bones = bones(&body);
    let t_pose = t_pose(&body, &bones);
    // If the ground is below the origin, move it to the origin.
    let (usual, ankle) = (ground::of_skeleton(&body), ground::of_motion(&body, scene));
    let lift = if ankle < 0.0 { usual - ankle } else { 0.0 };
    let height = ankle + lift - lowest_ankle(&t_pose);

    let mut made = Scene {
        metadata: scene.metadata.clone(),
        ..Scene::default()
    };
    let mut node_of: BTreeMap<Bone, NodeId> = BTreeMap::new();
    for &Placed { bone, joint, parent } in &bones {
        let translation = match parent {
            Some(parent) => t_pose[&bone] - t_pose[&parent],
            None => height * Vec3::Y,
        };
        node_of.insert(bone, NodeId::new(made.nodes.len()));
        made.nodes.push(Node {
            name: joint.map_or_else(
                || name_of_lacking(bone, &body),
                |joint| body.names[joint.index()].clone(),
            ),
            parent: parent.and_then(|parent| node_of.get(&parent).copied()),
            transform: Mat4::from_translation(translation),
            humanoid_bone: Some(bone),
            ..Node::default()
        });
    }
    let mut watched = WatchedJoints::default();
    let mover = Mover {
        tracks: bones
            .iter()
            .map(|placed| whole(&body, placed.bone, &mut watched))
            .collect(),
        watched,
        bones: &bones,
        body: &body,
        lift,
    };
    made.animations = (scene.animations.iter())
        .map(|animation| mover.animation(scene, animation, &made.nodes))
        .collect();
    for (index, animation) in scene.animations.iter().enumerate() {
        made.set_face(index, &scene.face_tracks(animation), true);
    }
    made.metadata.steps.push(AppliedStep::VrmHumanoid {
        heading: heading(&body),
        lift: f64::from(lift),
    });
    Ok(made)
}

/// The name for the joint of a missing bone. It is the name of the bone, unless another joint that is not a bone has
/// this name.
fn name_of_lacking(bone: Bone, body: &Body) -> String {
    let mut name = bone.as_str().to_owned();
    while body.names.contains(&name) {
        name.push('_');
    }
    name
}

/// The bones, with a foot for each leg without a foot. A joint between a shin and the toes is a foot, whatever its
/// name.
fn with_feet(scene: &Scene, mut bones: Humanoid) -> Humanoid {
    for [shin, foot, toes] in [
        [Bone::LeftLowerLeg, Bone::LeftFoot, Bone::LeftToes],
        [Bone::RightLowerLeg, Bone::RightFoot, Bone::RightToes],
    ] {
        let (Some(shin), Some(toes)) = (bones.joint(shin), bones.joint(toes)) else {
            continue;
        };
        let between = scene.nodes[toes.index()].parent.filter(|joint| *joint != shin);
        if let Some(joint) = between.filter(|_| bones.joint(foot).is_none()) {
            let found = HumanoidJoint {
                joint,
                confidence: Confidence::Likely,
                reason: "the joint is between the shin and the toes".to_owned(),
            };
            bones.bones.insert(foot, found);
        }
    }
    bones
}

/// A bone of the output, in the order of its nodes.
struct Placed {
    bone: Bone,
    /// The joint of the source; `None` for a bone that the source lacks.
    joint: Option<NodeId>,
    parent: Option<Bone>,
}

/// The bones of the output, each with its nearest ancestor in the hierarchy of VRM. A parent comes before its children.
fn bones(body: &Body) -> Vec<Placed> {
    let is_part = |bone: &Bone| (body.joint(*bone).is_some() || ENDS.contains(bone)) && !EYES.contains(bone);
    let parent = |bone: Bone| std::iter::successors(bone.parent(), |above| above.parent()).find(is_part);
    let mut placed = Vec::new();
    let mut open = vec![Bone::Hips];
    while let Some(bone) = open.pop() {
        let joint = body.joint(bone);
        let children = Bone::ALL.iter().rev().copied();
        open.extend(children.filter(|child| is_part(child) && parent(*child) == Some(bone)));
        let parent = parent(bone);
        placed.push(Placed { bone, joint, parent });
    }
    placed
}

/// The positions of the bones in the T-pose, relative to the hips, in the axes of the T-pose.
fn t_pose(body: &Body, bones: &[Placed]) -> BTreeMap<Bone, Vec3> {
    /// Where a bone begins. A bone that the source lacks begins at another node, and rotates with its parent bone.
    #[derive(Clone, Copy)]
    struct Begin {
        node: NodeId,
        turns_with: Bone,
    }
    let (mut positions, mut begins) = (BTreeMap::new(), BTreeMap::<Bone, Begin>::new());
    for &Placed { bone, joint, parent } in bones {
        let above = parent.and_then(|parent| Some((parent, *begins.get(&parent)?)));
        let Some((parent, above)) = above else {
            positions.insert(bone, Vec3::ZERO);
            begins.extend(joint.map(|node| (bone, Begin { node, turns_with: bone })));
            continue;
        };
        let end = || body.next(above.turns_with, above.node).unwrap_or(above.node);
        let node = joint.unwrap_or_else(end);
        let offset = body.to_frame(above.turns_with, body.position(node) - body.position(above.node));
        positions.insert(bone, positions[&parent] + offset);
        let turns_with = joint.map_or(above.turns_with, |_| bone);
        begins.insert(bone, Begin { node, turns_with });
    }
    positions
}

fn lowest_ankle(t_pose: &BTreeMap<Bone, Vec3>) -> f32 {
    let ankles = [Bone::LeftFoot, Bone::RightFoot].into_iter();
    let heights = ankles.filter_map(|bone| t_pose.get(&bone).map(|position| position.y));
    heights.reduce(f32::min).unwrap_or(0.0)
}

/// The rotation about +Y that brings the figure to face +Z, in degrees.
fn heading(body: &Body) -> f64 {
    let forward = body.axes * Vec3::Z;
    // Adding zero turns -0 into 0.
    f64::from(-forward.x.atan2(forward.z).to_degrees().round()) + 0.0
}

/// The ticks at which an animation is sampled: the whole ticks, the end, and keys between ticks, which resampling
/// leaves around a cut. If a file has far more keys than frames, it is sampled only at its frames.
fn ticks_and_keys(animation: &Animation) -> Vec<f64> {
    /// The largest number of keys for each frame of a bone. The curves of animation programs have one.
    const MOST_KEYS_A_FRAME: usize = 4;
    let whole = ticks(animation);
    let mut all = whole.clone();
    for channel in &animation.channels {
        let tracks = [
            &channel.position_keys.ticks,
            &channel.rotation_keys.ticks,
            &channel.scaling_keys.ticks,
        ];
        all.extend(
            tracks
                .into_iter()
                .flatten()
                .flatten()
                .filter(|tick| tick.fract() != 0.0),
        );
        all.sort_unstable_by(f64::total_cmp);
        all.dedup();
        if all.len() > MOST_KEYS_A_FRAME * whole.len() {
            return whole;
        }
    }
    all.retain(|tick| (0.0..=animation.duration).contains(tick));
    all
}

/// Moves the motion of the source to the bones.
struct Mover<'a> {
    body: &'a Body,
    bones: &'a [Placed],
    /// The rotation of each bone relative to the coordinate frame of the T-pose; `None` for a bone that the source
    /// lacks.
    tracks: Vec<Option<Track>>,
    watched: WatchedJoints,
    lift: f32,
}

impl Mover<'_> {
    fn animation(&self, source: &Scene, animation: &Animation, nodes: &[Node]) -> Animation {
        let ticks = ticks_and_keys(animation);
        let at = Ticks::new(&ticks);
        let binding = Binding::new(source, animation);
        let mut pose = Pose::rest(source);
        let mut hips_path = Vec::with_capacity(ticks.len());
        let mut rotations: Vec<Vec<Quat>> = vec![Vec::with_capacity(ticks.len()); self.bones.len()];
        let mut frames: BTreeMap<Bone, Quat> = BTreeMap::new();
        let to_frame = self.body.axes.inverse();
        let mut seen: WatchedPose<1> = WatchedPose::new(self.watched.joints.len());
        for &tick in &ticks {
            pose.sample(&binding, animation, tick);
            seen.set(0, &pose, self.body, &self.watched);
            hips_path.push(to_frame * pose.position(self.body.hips) + self.lift * Vec3::Y);
            for (keys, (placed, track)) in rotations.iter_mut().zip(self.bones.iter().zip(&self.tracks)) {
                let above = placed.parent.and_then(|parent| frames.get(&parent).copied());
                let above = above.unwrap_or(Quat::IDENTITY);
                let frame = track
                    .as_ref()
                    .map_or(above, |track| Quat::from_array(track.frame(&seen).lane(0)));
                frames.insert(placed.bone, frame);
                let rotation = (above.inverse() * frame).normalize();
                // Use the shorter arc from the previous key.
                let turned_away = keys.last().is_some_and(|last: &Quat| last.dot(rotation) < 0.0);
                keys.push(if turned_away { -rotation } else { rotation });
            }
        }
        let channels = rotations
            .into_iter()
            .zip(nodes)
            .enumerate()
            .map(|(index, (values, node))| Channel {
                node_name: node.name.clone(),
                node: Some(NodeId::new(index)),
                position_keys: match index {
                    0 => at.keys(std::mem::take(&mut hips_path)),
                    _ => Keys::constant(node.transform.w_axis.truncate()),
                },
                rotation_keys: at.rotation_keys(values),
                scaling_keys: Keys::constant(Vec3::ONE),
            });
        Animation {
            name: animation.name.clone(),
            ticks_per_second: animation.ticks_per_second,
            duration: animation.duration,
            channels: channels.collect(),
        }
    }
}
