//! Converts poses to point clouds. A point cloud has the positions of the joints of a figure, in metres.

use glam::{DVec2, Vec3};

use mocap_figure::Figure;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, NodeId, NodeKind, Scene};

/// The largest number of frames in a clip of a graph: a day at 30 frames per second. This number limits the memory.
const MOST_FRAMES: f64 = 3e6;

/// The joints of a skeleton that become points of a cloud, the weights of the points, and the axes of their
/// coordinates.
#[derive(Clone, Debug)]
pub struct CloudSpace {
    /// The up axis, and two axes along the ground with `up x first = second`.
    pub(crate) up: Vec3,
    pub(crate) ground: [Vec3; 2],
    /// Metres in one unit of the scene.
    pub(crate) metres: f32,
    nodes: Vec<NodeId>,
    /// The weight of each point. The sum of the weights is 1.
    pub(super) weights: Vec<f64>,
}

impl CloudSpace {
    /// Chooses the points of a skeleton: a top joint, and all joints and end sites below it. The top joint is the
    /// highest joint of the figure whose position moves, or otherwise the highest joint. Joints that only place the
    /// figure in the world have no point. The weight of a point is the length of its adjacent bones. So the weight is
    /// spread evenly along the body, and all fingers together weigh no more than a hand.
    pub fn new(scene: &Scene, figure: &Figure) -> Result<Self> {
        let up = figure.up_direction();
        let across = if up.x.abs() > 0.5 { Vec3::Y } else { Vec3::X };
        let places = figure.placing(scene);
        let is_point = |node: &NodeId| scene.nodes[node.index()].kind != NodeKind::Group && !places[node.index()];
        let ids = || (0..scene.nodes.len()).map(NodeId::new);
        let moving = moving(scene);
        let top = ids()
            .filter(is_point)
            .find(|node| moving[node.index()])
            .or_else(|| ids().find(is_point));
        let mut lengths = vec![0.0; scene.nodes.len()];
        let mut nodes: Vec<NodeId> = Vec::from_iter(top);
        let mut is_below: Vec<bool> = ids().map(|node| Some(node) == top).collect();
        for node in ids().skip_while(|node| Some(*node) != top).skip(1) {
            let parent = scene.nodes[node.index()].parent;
            let Some(parent) = parent.filter(|parent| is_below[parent.index()]) else {
                continue;
            };
            is_below[node.index()] = true;
            let length = f64::from(scene.nodes[node.index()].transform.w_axis.truncate().length());
            lengths[parent.index()] += 0.5 * length;
            lengths[node.index()] += 0.5 * length;
            nodes.push(node);
        }
        nodes.retain(|node| is_point(node) && lengths[node.index()] > 0.0);
        let whole: f64 = nodes.iter().map(|node| lengths[node.index()]).sum();
        if nodes.is_empty() || !whole.is_finite() {
            let message = "the skeleton has no bones with a length, so that its poses cannot be compared";
            return Err(Diagnostic::new(Code::NoMotion, message).into());
        }
        Ok(Self {
            up,
            ground: [across, up.cross(across)],
            metres: figure.metres(),
            weights: nodes.iter().map(|node| lengths[node.index()] / whole).collect(),
            nodes,
        })
    }

    /// The names of the points and their weights.
    pub(super) fn points<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = (String, f32)> + 'a {
        let names = self.nodes.iter().map(|node| scene.nodes[node.index()].name.clone());
        names.zip(self.weights.iter().map(|weight| *weight as f32))
    }
}

/// For each node, whether its position changes in an animation.
fn moving(scene: &Scene) -> Vec<bool> {
    let mut moving = vec![false; scene.nodes.len()];
    for animation in &scene.animations {
        for (node, channel) in Binding::new(scene, animation).driven() {
            let keys = &animation.channels[channel].position_keys.values;
            moving[node.index()] |= keys.windows(2).any(|pair| pair[0] != pair[1]);
        }
    }
    moving
}

/// The points of a clip in every frame, in metres.
#[derive(Clone, Debug)]
pub struct Clouds {
    pub(crate) frames: usize,
    /// The two coordinates over the ground and the height: for each point, its values in all frames.
    pub(super) values: [Vec<f32>; 3],
    /// The weighted mean of the points over the ground, in each frame.
    pub(crate) centres: Vec<DVec2>,
}

impl Clouds {
    /// The points of an animation at `rate` frames per second.
    pub fn new(space: &CloudSpace, scene: &Scene, animation: &Animation, rate: f64) -> Result<Self> {
        let step = animation.ticks_per_second / rate;
        let last = animation.duration.max(0.0) / step;
        if !last.is_finite() || last > MOST_FRAMES {
            let message = format!("a motion of {last} frames is too long for a graph: {MOST_FRAMES} at most");
            return Err(Diagnostic::new(Code::LimitExceeded, message).into());
        }
        // Also counts a last frame that a rounding error puts a little after the end.
        let frames = (last + 1e-6).floor() as usize + 1;
        let points = space.nodes.len();
        let mut values = [0; 3].map(|_| vec![0.0; frames * points]);
        let binding = Binding::new(scene, animation);
        let mut pose = Pose::rest(scene);
        for frame in 0..frames {
            pose.sample(&binding, animation, (frame as f64 * step).min(animation.duration));
            for (point, node) in space.nodes.iter().enumerate() {
                let position = pose.position(*node) * space.metres;
                let axes = [space.ground[0], space.ground[1], space.up];
                for (values, axis) in values.iter_mut().zip(axes) {
                    values[point * frames + frame] = position.dot(axis);
                }
            }
        }
        if values
            .iter()
            .flatten()
            .any(|value| !value.is_finite() || value.abs() > 1e6)
        {
            let message = "the position of a joint is not finite, or is farther than 1000 km from the origin";
            return Err(Diagnostic::new(Code::NonFiniteValue, message).into());
        }
        let mut centres = vec![DVec2::ZERO; frames];
        for (point, weight) in space.weights.iter().enumerate() {
            for (frame, centre) in centres.iter_mut().enumerate() {
                let [u, v] = [0, 1].map(|axis: usize| f64::from(values[axis][point * frames + frame]));
                *centre += *weight * DVec2::new(u, v);
            }
        }
        Ok(Self {
            frames,
            values,
            centres,
        })
    }
}
