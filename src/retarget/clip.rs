//! Retargets whole animations, a block of frames at a time.
//!
//! A block computes several frames at once. It is a structure of arrays with one lane for each frame. It stores the
//! rotations and positions of the source joints that the retargeting reads, and of the ancestors of these joints. If a
//! skeleton is stretched along one axis, its matrices are not products of rotation and translation. The frames of such
//! a skeleton are computed one by one.

use std::collections::HashMap;

use glam::{Mat3, Mat4, Quat, Vec3};
use mocap_figure::body::Body;
use mocap_figure::rotations::{Points, Rotations};
use mocap_figure::ticks::{Ticks, ticks};
use mocap_figure::watched::{Joint, WatchedJoints, WatchedPose};
use mocap_scene::math::soa::Lanes;
use mocap_scene::math::soa::single::LANES;
use mocap_scene::math::wide;
use mocap_scene::pose::{Binding, Pose, Trs};
use mocap_scene::scene::{Animation, Channel, Keys, NodeId, Scene};

use super::plan::Plan;
use super::root::Root;
use super::solve::{Solved, solve_block};

/// The largest relative difference that counts as equal: between the scales along the three axes, and between a matrix
/// and its translation, rotation and scale.
const SAME: f32 = 1e-5;

/// An animation of `source` on the target, with a key at every tick.
pub(super) fn animation(
    (body, source): (&Body, &Scene),
    target: &Body,
    plan: &Plan,
    root: &Root,
    animation: &Animation,
) -> Animation {
    let ticks = ticks(animation);
    let mut poses = Poses::new(body, source, animation, &plan.watched);
    let mut solved = Solved::new(plan, poses.joints());
    let mut hips_path = Vec::with_capacity(ticks.len());
    // Each list gets its full capacity here. `vec!` would clone an empty list without its capacity, and growing lists
    // take up to twice the memory.
    let drives = plan.drives.iter();
    let mut rotations: Vec<Vec<Quat>> = drives.map(|_| Vec::with_capacity(ticks.len())).collect();
    for block in ticks.chunks(LANES) {
        poses.see(block, &mut solved.seen);
        solve_block(&mut solved, plan, root);
        hips_path.extend((0..block.len()).map(|lane| Vec3::from_array(solved.hips.lane(lane))));
        append_block(&mut rotations, &mut solved.to_parent, block.len());
    }
    let at = Ticks::new(&ticks);
    let channels = std::iter::zip(rotations, &plan.drives).map(|(values, drive)| Channel {
        node_name: target.names[drive.node.index()].clone(),
        node: Some(drive.node),
        position_keys: match drive.node == target.hips {
            true => at.keys(std::mem::take(&mut hips_path)),
            false => Keys::constant(drive.rest.translation),
        },
        rotation_keys: at.rotation_keys(values),
        scaling_keys: Keys::constant(drive.rest.scale),
    });
    Animation {
        name: animation.name.clone(),
        ticks_per_second: animation.ticks_per_second,
        duration: animation.duration,
        channels: channels.collect(),
    }
}

wide::dispatch! {
    /// Appends the first frames of a block to the keys of each joint, each on the shorter arc from the previous key.
    fn append_block(keys: &mut [Vec<Quat>], block: &mut [Rotations<LANES>], frames: usize) {
        for (keys, block) in keys.iter_mut().zip(block) {
            append(keys, block, frames);
        }
    }
}

#[inline(always)]
fn append(keys: &mut Vec<Quat>, block: &mut Rotations<LANES>, frames: usize) {
    let last = keys.last().map_or(block.lane(0), Quat::to_array);
    let mut before = Rotations::all(last);
    for (before, block) in [
        (&mut before.x, &block.x),
        (&mut before.y, &block.y),
        (&mut before.z, &block.z),
        (&mut before.w, &block.w),
    ] {
        before.0[1..].copy_from_slice(&block.0[..LANES - 1]);
    }
    let dots = block.dot(before);
    let mut signs = Lanes::<f32, LANES>::ONE;
    let mut sign = 1.0;
    for lane in 0..LANES {
        if dots.0[lane] < 0.0 {
            sign = -sign;
        }
        signs.0[lane] = sign;
    }
    let signed = *block * signs;
    let mut values = [Quat::IDENTITY; LANES];
    for (lane, value) in values.iter_mut().enumerate() {
        *value = Quat::from_array(signed.lane(lane));
    }
    keys.extend_from_slice(&values[..frames]);
}

/// How the poses of the source are computed.
enum Poses<'a> {
    /// As rotations and positions, in blocks.
    Chains(Chains<'a>),
    /// As matrices, one pose at a time.
    Matrices {
        body: &'a Body,
        animation: &'a Animation,
        watched: &'a WatchedJoints,
        binding: Binding,
        pose: Box<Pose>,
    },
}

impl<'a> Poses<'a> {
    fn new(body: &'a Body, source: &'a Scene, animation: &'a Animation, watched: &'a WatchedJoints) -> Self {
        let binding = Binding::new(source, animation);
        match Chains::new(body, source, animation, watched, &binding) {
            Some(chains) => Self::Chains(chains),
            None => Self::Matrices {
                body,
                animation,
                watched,
                binding,
                pose: Box::new(Pose::rest(source)),
            },
        }
    }

    /// The number of watched joints.
    fn joints(&self) -> usize {
        match self {
            Self::Chains(chains) => chains.joints,
            Self::Matrices { watched, .. } => watched.joints.len(),
        }
    }

    /// Computes the poses at up to [`LANES`] ticks.
    fn see(&mut self, ticks: &[f64], seen: &mut WatchedPose<LANES>) {
        match self {
            Self::Chains(chains) => pose_block(chains, ticks, seen),
            Self::Matrices {
                body,
                animation,
                watched,
                binding,
                pose,
            } => {
                for (lane, tick) in ticks.iter().enumerate() {
                    pose.sample(binding, animation, *tick);
                    seen.set(lane, pose, body, watched);
                }
            }
        }
    }
}

/// The source joints that the retargeting reads, and their ancestors.
struct Chains<'a> {
    /// The joints, parents before children.
    links: Vec<Link<'a>>,
    /// The number of entries in [`WatchedPose`].
    joints: usize,
    /// The rotation from the world to the coordinate frame of the T-pose.
    world_to_frame: Quat,
}

struct Link<'a> {
    /// The index of the joint in [`WatchedPose`]. The joints that the retargeting reads come first.
    joint: usize,
    /// The index of the parent in the links.
    parent: Option<usize>,
    rotation: Values<'a, Quat>,
    /// The translation; `None` if nothing needs the position.
    translation: Option<Values<'a, Vec3>>,
    has_rotation: bool,
    /// The scale of the parent's axes.
    parent_scale: f32,
}

/// The values of a track.
#[derive(Clone, Copy)]
enum Values<'a, T> {
    Still(T),
    Moving(&'a Keys<T>),
}

impl<'a, T: Copy> Values<'a, T> {
    fn new(keys: Option<&'a Keys<T>>, rest: T) -> Self {
        match keys.map(|keys| (keys, keys.values.as_slice())) {
            None | Some((_, [])) => Self::Still(rest),
            Some((_, [only])) => Self::Still(*only),
            Some((keys, _)) => Self::Moving(keys),
        }
    }
}

/// The values of keys at up to [`LANES`] ticks. The last value also fills the remaining lanes.
#[inline(always)]
fn values_at<T: Copy>(keys: &Keys<T>, ticks: &[f64], sample: impl Fn(f64) -> T) -> [T; LANES] {
    // All ticks are whole, except the last tick of a clip.
    let has_tick = keys.ticks.is_none() && ticks.len() == LANES && ticks[LANES - 1].fract() == 0.0;
    let first = ticks[0] as usize;
    match keys.values.get(first..first + LANES) {
        Some(block) if has_tick => std::array::from_fn(|lane| block[lane]),
        _ => std::array::from_fn(|lane| sample(ticks[lane.min(ticks.len() - 1)])),
    }
}

impl<'a> Chains<'a> {
    /// `None` for a skeleton with a non-uniform scale.
    fn new(
        body: &'a Body,
        source: &'a Scene,
        animation: &'a Animation,
        watched: &WatchedJoints,
        binding: &Binding,
    ) -> Option<Self> {
        let channels: HashMap<NodeId, &Channel> = binding
            .driven()
            .filter_map(|(node, channel)| Some((node, animation.channels.get(channel)?)))
            .collect();
        let mut joints = watched.joints.clone();
        let mut index_of: HashMap<usize, usize> = joints.iter().map(|joint| joint.node.index()).zip(0..).collect();
        let mut next = 0;
        while let Some(&Joint { node, has_place, .. }) = joints.get(next) {
            if let Some(parent) = *body.hierarchy.parents.get(node.index())? {
                let index = *index_of.entry(parent).or_insert(joints.len());
                if index == joints.len() {
                    joints.push(Joint {
                        node: NodeId::new(parent),
                        has_rotation: true,
                        has_place,
                    });
                } else {
                    let above = &mut joints[index];
                    let is_new = !above.has_rotation || (has_place && !above.has_place);
                    above.has_rotation = true;
                    above.has_place |= has_place;
                    if is_new && index < next {
                        // Visit this joint again, because its ancestors must get the same flags.
                        next = index;
                        continue;
                    }
                }
            }
            next += 1;
        }
        let mut order: Vec<usize> = (0..joints.len()).collect();
        order.sort_by_key(|joint| joints[*joint].node);
        let mut scales = vec![1.0; joints.len()];
        let mut links = Vec::with_capacity(joints.len());
        for joint in order {
            let Joint {
                node,
                has_rotation,
                has_place,
            } = joints[joint];
            let channel = channels.get(&node).copied();
            let rest = Trs::from_matrix(source.nodes.get(node.index())?.transform);
            if channel.is_none() && !is_matrix_of(rest, source.nodes[node.index()].transform) {
                return None;
            }
            let parent = body.hierarchy.parents[node.index()].and_then(|parent| index_of.get(&parent).copied());
            let parent_scale = parent.map_or(1.0, |parent| scales[parent]);
            scales[joint] = parent_scale * even_scale(channel.map(|channel| &channel.scaling_keys), rest.scale)?;
            links.push(Link {
                joint,
                parent,
                rotation: Values::new(channel.map(|channel| &channel.rotation_keys), rest.rotation),
                translation: has_place
                    .then(|| Values::new(channel.map(|channel| &channel.position_keys), rest.translation)),
                has_rotation,
                parent_scale,
            });
        }
        Some(Self {
            links,
            joints: joints.len(),
            world_to_frame: body.axes.inverse(),
        })
    }

    #[inline(always)]
    fn pose(&self, ticks: &[f64], seen: &mut WatchedPose<LANES>) {
        let world_to_frame = Rotations::all(self.world_to_frame.to_array());
        for link in &self.links {
            let above = link.parent.map_or(world_to_frame, |parent| seen.rotations[parent]);
            if link.has_rotation {
                let local = match link.rotation {
                    Values::Still(value) => Rotations::all(value.to_array()),
                    Values::Moving(keys) => {
                        let values = values_at(keys, ticks, |tick| keys.sample(tick).unwrap_or(Quat::IDENTITY));
                        Rotations::of(|lane| values[lane].to_array())
                    }
                };
                seen.rotations[link.joint] = (above * local).normalize();
            }
            if let Some(translation) = &link.translation {
                let local = match translation {
                    Values::Still(value) => Points::all((*value * link.parent_scale).to_array()),
                    Values::Moving(keys) => {
                        let values = values_at(keys, ticks, |tick| keys.sample(tick).unwrap_or_default());
                        Points::of(|lane| values[lane].to_array()) * Lanes::all(link.parent_scale)
                    }
                };
                let from_above = above * local;
                seen.positions[link.joint] = match link.parent {
                    Some(parent) => seen.positions[parent] + from_above,
                    None => from_above,
                };
            }
        }
    }
}

wide::dispatch! {
    /// Calls [`Chains::pose`], compiled with AVX2 if the processor has it.
    fn pose_block(chains: &Chains<'_>, ticks: &[f64], seen: &mut WatchedPose<LANES>) {
        chains.pose(ticks, seen);
    }
}

/// Whether a matrix is exactly this translation, rotation and scale.
fn is_matrix_of(trs: Trs, matrix: Mat4) -> bool {
    let (axes, expected) = (Mat3::from_mat4(matrix), Mat3::from_mat4(trs.matrix()));
    axes.abs_diff_eq(expected, SAME * trs.scale.abs().max_element())
}

/// The scale of a node, if it is uniform, constant and positive.
fn even_scale(keys: Option<&Keys<Vec3>>, rest: Vec3) -> Option<f32> {
    let values = keys.map_or(&[][..], |keys| keys.values.as_slice());
    let first = values.first().copied().unwrap_or(rest);
    let is_even = |scale: &Vec3| scale.abs_diff_eq(Vec3::splat(first.x), SAME * first.x);
    (first.x > 0.0 && is_even(&first) && values.iter().all(is_even)).then_some(first.x)
}
