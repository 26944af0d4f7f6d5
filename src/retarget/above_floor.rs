//! Keeps the skin of the target above its floor when the source kneels, crawls, lies or falls.
//!
//! If limbs keep their directions on a body of other proportions, knees, back and head may get below the floor. A
//! thicker body is deeper. The whole body is raised by the depth of its deepest part. Hands and feet do not count for
//! this depth: two-bone inverse kinematics raises them. If the source's joints and skin are below its floor, the skin
//! of the target may be equally deep. A raise reaches the depth of the deepest frame near it, and starts and ends
//! smoothly.

use std::collections::BTreeMap;
use std::f32::consts::PI;

use glam::{Quat, Vec3};
use mocap_figure::Side;
use mocap_figure::body::Body;
use mocap_figure::ground;
use mocap_figure::ticks::{Ticks, ticks};
use mocap_scene::math::directions::rotation_of;
use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, NodeId};

use super::hands::{Arm, NewRotations, channel};
use super::measure::Moving;
use super::root::Root;
use super::skin::{Vertex, vertices};

/// The depth that is not visible, as a fraction of the leg: half a centimetre.
const UNSEEN: f32 = 0.006;

/// The largest raise, as a fraction of the leg. Proportions do not explain a greater depth.
const MOST: f32 = 0.5;

/// The time before and after the deepest frame in which a raise starts and ends, in seconds.
const EASE: f64 = 0.2;

/// Cosines of the angle between a leg and straight down. Above the first cosine, the foot is raised less. Above the
/// second cosine, the foot is not raised: to raise the foot of a leg in stance, the knee would have to bend far.
const STANDING: [f32; 2] = [0.75, 0.9];

/// The largest coordinate of the directions in which the outermost vertices of a joint are searched: whole numbers from
/// -2 to 2. Neighbouring directions are at most 15 degrees apart.
const STEPS: i8 = 2;

/// The skin of a body, to keep above the floor.
pub(super) struct Surface {
    parts: Vec<Part>,
    /// The arms and legs with hands and feet.
    limbs: Vec<Arm>,
    /// The height of the floor, or of the skin at rest if the skin is lower.
    floor: f32,
}

/// The outermost vertices that move mostly with one joint.
struct Part {
    joint: NodeId,
    /// The limb that ends with the part; `None` for a part that is raised with the whole body.
    end_of: Option<usize>,
    /// The largest distance of the vertices from the joint.
    reach: f32,
    vertices: Vec<Vertex>,
}

impl Surface {
    /// The skin of a body with ankles at the height `ankle` in stance; `None` without a skin.
    pub(super) fn new(moving: &Moving<'_>, ankle: f32) -> Option<Self> {
        let (body, scene) = (moving.body, moving.scene);
        let limbs = Side::ALL.into_iter();
        let limbs = limbs.flat_map(|side| [Arm::new(body, side), Arm::leg(body, side)]);
        let limbs: Vec<Arm> = limbs.flatten().collect();
        let rest = Pose::rest(scene);
        let mut of_joints: BTreeMap<(NodeId, Option<usize>), Vec<Vertex>> = BTreeMap::new();
        for vertex in scene.own_meshes().flat_map(|mesh| vertices(mesh, &rest)) {
            let is_at_end = |limb: &Arm| {
                let [_, middle, end] = limb.joints;
                let distance = |joint: NodeId| rest.position(joint).distance(vertex.at_rest);
                (vertex.of == middle || body.depends_on(vertex.of, middle)) && distance(end) < distance(middle)
            };
            let end_of = limbs.iter().position(is_at_end);
            of_joints.entry((vertex.of, end_of)).or_default().push(vertex);
        }
        let part = |((joint, end_of), vertices): ((NodeId, Option<usize>), Vec<Vertex>)| {
            let vertices = outermost(&vertices, body.axes);
            let reach = |vertex: &Vertex| vertex.at_rest.distance(rest.position(joint));
            let reach = vertices.iter().map(reach).fold(0.0, f32::max);
            Part {
                joint,
                end_of,
                reach,
                vertices,
            }
        };
        let parts: Vec<Part> = of_joints.into_iter().map(part).collect();
        let heights = parts.iter().flat_map(|part| &part.vertices);
        let lowest = heights.map(|vertex| vertex.at_rest.dot(body.up())).reduce(f32::min)?;
        let sole = (lowest - ground::floor(body)).min(0.0);
        Some(Self {
            parts,
            limbs,
            floor: ankle - ground::ankle(body) + sole,
        })
    }

    /// The largest depth below the floor. With `of`, only the end of the limb with this index counts. Without `of`,
    /// only the parts count that are raised with the whole body.
    fn depth(&self, pose: &Pose, up: Vec3, of: Option<usize>) -> f32 {
        let mut lowest = self.floor;
        for part in self.parts.iter().filter(|part| part.end_of == of) {
            if pose.position(part.joint).dot(up) - part.reach < lowest {
                let heights = part.vertices.iter().map(|vertex| vertex.at(pose).dot(up));
                lowest = heights.fold(lowest, f32::min);
            }
        }
        self.floor - lowest
    }

    /// The largest depth below the floor.
    fn deepest(&self, pose: &Pose, up: Vec3) -> f32 {
        let limbs = (0..self.limbs.len()).map(|limb| self.depth(pose, up, Some(limb)));
        limbs.fold(self.depth(pose, up, None), f32::max)
    }
}

/// The farthest vertex in each direction.
fn outermost(vertices: &[Vertex], axes: Quat) -> Vec<Vertex> {
    let steps = || -STEPS..=STEPS;
    let mut found = Vec::new();
    for (x, y, z) in steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| (x, y, z)))) {
        // Use only the surface of the grid, because the cells inside repeat the same directions.
        if x.abs().max(y.abs()).max(z.abs()) == STEPS {
            let out = axes * Vec3::new(f32::from(x), f32::from(y), f32::from(z));
            let far = |vertex: &usize| vertices[*vertex].at_rest.dot(out);
            found.extend((0..vertices.len()).max_by(|a, b| far(a).total_cmp(&far(b))));
        }
    }
    found.sort_unstable();
    found.dedup();
    found.into_iter().map(|vertex| vertices[vertex].clone()).collect()
}

/// The allowed depth of the skin in each frame: the depth of the source's joints and skin.
pub(super) fn allowed(source: &Moving<'_>, root: &Root) -> Vec<f32> {
    let floor = root.source_ankle - ground::ankle(source.body);
    let surface = Surface::new(source, root.source_ankle);
    let binding = Binding::new(source.scene, source.animation);
    let mut pose = Pose::rest(source.scene);
    let depth = |tick: f64| {
        pose.sample(&binding, source.animation, tick);
        let of_joints = (floor - source.lowest_joint(&pose)).max(0.0);
        let of_skin = surface
            .as_ref()
            .map_or(0.0, |surface| surface.deepest(&pose, source.body.up()));
        of_joints.max(of_skin) * root.height_scale
    };
    ticks(source.animation).into_iter().map(depth).collect()
}

/// The necessary raise of the whole body in each frame; `None` if the body is nowhere too deep.
pub(super) fn raises_of_body(target: &Moving<'_>, surface: &Surface, allowed: &[f32]) -> Option<Vec<f32>> {
    raises(target, surface, allowed, &ticks(target.animation), None)
}

/// Raises the whole body.
pub(super) fn raise_body(body: &Body, animation: &mut Animation, raises: &[f32], root: &Root) {
    let ticks = ticks(animation);
    let keys = &mut channel(body, animation, body.hips).position_keys;
    let raised = ticks.iter().zip(raises);
    let raised = raised.map(|(tick, raise)| keys.sample(*tick).unwrap_or_default() + root.up(*raise));
    *keys = Ticks::new(&ticks).keys(raised.collect());
}

/// The rotations that raise hands and feet to the allowed depth; empty if no hand or foot is too deep.
pub(super) fn raise_ends(
    target: &Moving<'_>,
    surface: &Surface,
    allowed: &[f32],
    may_raise: impl Fn(&Arm) -> bool,
) -> NewRotations {
    let ticks = ticks(target.animation);
    let mut raised = Vec::new();
    for (index, limb) in surface.limbs.iter().enumerate().filter(|(_, limb)| may_raise(limb)) {
        let Some(raises) = raises(target, surface, allowed, &ticks, Some(index)) else {
            continue;
        };
        let binding = Binding::new(target.scene, target.animation);
        let mut pose = Pose::rest(target.scene);
        let mut rotations: [Vec<Quat>; 3] = Default::default();
        for (tick, raise) in ticks.iter().zip(&raises) {
            pose.sample(&binding, target.animation, *tick);
            let raise = *raise
                * if limb.is_arm {
                    1.0
                } else {
                    lies(&pose, limb, target.body.up())
                };
            if raise > 0.0 {
                let goal = limb.goal(&pose, target.body.up() * raise);
                limb.bring(&mut pose, goal);
            }
            for (rotations, joint) in rotations.iter_mut().zip(limb.joints) {
                let rotation = rotation_of(&pose.node_to_parent[joint.index()]);
                let before = rotations.last().copied().unwrap_or(rotation);
                rotations.push(in_hemisphere_of(before, rotation));
            }
        }
        let keys = rotations
            .into_iter()
            .map(|rotations| Ticks::new(&ticks).rotation_keys(rotations));
        raised.extend(limb.joints.into_iter().zip(keys));
    }
    raised
}

/// 0 for a leg in stance, 1 for a leg that is not in stance.
fn lies(pose: &Pose, leg: &Arm, up: Vec3) -> f32 {
    let [hip, _, ankle] = leg.joints.map(|joint| pose.position(joint));
    let [slanting, upright] = STANDING;
    let down = (hip - ankle).normalize_or_zero().dot(up);
    ((upright - down) / (upright - slanting)).clamp(0.0, 1.0)
}

/// The raise of a limb's end, or of the whole body, in each frame; `None` if no frame needs a visible raise.
fn raises(
    target: &Moving<'_>,
    surface: &Surface,
    allowed: &[f32],
    ticks: &[f64],
    of: Option<usize>,
) -> Option<Vec<f32>> {
    let binding = Binding::new(target.scene, target.animation);
    let mut pose = Pose::rest(target.scene);
    let depth = |(tick, allowed): (&f64, &f32)| {
        pose.sample(&binding, target.animation, *tick);
        let depth = surface.depth(&pose, target.body.up(), of) - allowed;
        depth.clamp(0.0, MOST * target.body.leg)
    };
    let depths: Vec<f32> = ticks.iter().zip(allowed).map(depth).collect();
    let is_seen = |depth: &f32| *depth > UNSEEN * target.body.leg;
    let ease = (EASE * target.animation.ticks_per_second).round() as usize;
    depths.iter().any(is_seen).then(|| covering(&depths, ease))
}

/// A smooth curve that is nowhere below these values: the maximum within `ease` frames, averaged over `ease` frames.
fn covering(values: &[f32], ease: usize) -> Vec<f32> {
    let around = |frame: usize| frame.saturating_sub(ease)..(frame + ease + 1).min(values.len());
    let largest = |frame: usize| values[around(frame)].iter().copied().fold(0.0, f32::max);
    let largest: Vec<f32> = (0..values.len()).map(largest).collect();
    let weight = |from: usize, to: usize| 1.0 + (PI * from.abs_diff(to) as f32 / (ease + 1) as f32).cos();
    let mean = |frame: usize| {
        let weighted = around(frame).map(|other| (weight(frame, other), largest[other]));
        let (sum, whole) = weighted.fold((0.0, 0.0), |(sum, whole), (weight, value)| {
            (sum + weight * value, whole + weight)
        });
        sum / whole
    };
    (0..values.len()).map(mean).collect()
}
