//! The contacts and the soles that the feet of the target follow.

use glam::Vec3;
use mocap_edit::report::DetectedContacts;
use mocap_edit::{FootGuide, FootLockWeights, SolePoint};
use mocap_figure::body::Body;
use mocap_figure::ground;
use mocap_figure::{HumanoidBone as Bone, Side};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{Animation, Channel, NodeId, Scene};

use super::root::Root;
use super::skin::{Skin, Vertex};

/// The largest difference between an ankle's resting height and its height in a standing body, as a fraction of the
/// leg. With a larger difference, the body does not stand.
const STANDS: f32 = 0.05;

/// The distance from the joint of the toes to their tip, as a fraction of the horizontal distance from the ankle to the
/// toes. The heel is behind the ankle by a quarter of the foot's length, and the ball is in front of the heel by two
/// thirds of this length.
const TIP: f32 = 0.5;

/// The distance from the ankle back to the heel, as a fraction of the distance from the ankle to the toes.
const HEEL: f32 = 0.4;

/// Half the width of a shoe at the ball, as a fraction of the distance from the ankle to the toes.
const WIDTH: f32 = 0.3;

/// Half the width of a foot at the heel, as a fraction of the distance from the ankle to the toes: two thirds of the
/// width at the ball.
const HEEL_WIDTH: f32 = 0.2;

/// The length of the rigid part of a foot in front of the ball, as a fraction of the distance from the ankle to the
/// toes.
const FRONT: f32 = 0.1;

/// The largest rotation of an ankle to bring a foot above the floor, in radians: 34 degrees.
const ANKLE_TURNS: f32 = 0.6;

/// The largest rotation of toes, in radians: 57 degrees. The joint allows 70 (American Academy of Orthopaedic Surgeons,
/// Joint Motion, 1965).
const TOES_TURN: f32 = 1.0;

/// The channels of a motion that a foot lock may change: the channels of the legs, of the hips, and of the ancestors of
/// the hips.
pub(super) struct FreeLegs {
    /// The number of channels before the lock.
    channels: usize,
    of_legs: Vec<(usize, Channel)>,
}

impl FreeLegs {
    pub(super) fn new(body: &Body, scene: &Scene, animation: &Animation) -> Self {
        let chain = |node: NodeId| std::iter::successors(Some(node), |node| scene.nodes[node.index()].parent);
        let thighs = Side::ALL.map(|side| body.joint(Bone::LeftUpperLeg.on(side)));
        let may_change = |node: NodeId| {
            chain(body.hips).any(|above| above == node) || chain(node).any(|above| thighs.contains(&Some(above)))
        };
        let channels = animation.channels.iter().enumerate();
        let of_legs = channels.filter(|(_, channel)| channel.node.is_none_or(may_change));
        Self {
            channels: animation.channels.len(),
            of_legs: of_legs.map(|(index, channel)| (index, channel.clone())).collect(),
        }
    }

    /// Restores the channels from before the lock.
    pub(super) fn give_back(self, animation: &mut Animation) {
        animation.channels.truncate(self.channels);
        for (index, channel) in self.of_legs {
            animation.channels[index] = channel;
        }
    }
}

/// The motion that the feet of the target follow; `None` if the source does not stand.
pub(super) fn followed<'a>(
    source: &Body,
    target: &Body,
    scene: &Scene,
    root: &Root,
    contacts: &'a DetectedContacts,
    weights: FootLockWeights,
) -> Option<FootGuide<'a>> {
    let ankles = contacts
        .points
        .iter()
        .filter(|point| point.bone.on(Side::Left) == Bone::LeftFoot);
    let rest = ankles.map(|point| f64::from(contacts.floor + point.height) / source.metres_per_unit);
    let rest = rest.reduce(f64::min)?;
    if (rest - f64::from(root.source_ankle)).abs() > f64::from(STANDS * source.leg) {
        return None;
    }
    Some(FootGuide {
        contacts,
        units_per_metre: root.height_scale / source.metres_per_unit as f32,
        scale: root.scale,
        turn: target.axes * source.axes.inverse(),
        floor: root.target_ankle - ground::ankle(target),
        leg: target.leg,
        soles: Side::ALL.map(|side| sole(target, scene, side)),
        weights,
    })
}

/// The outermost vertices of a foot's sole in the skin.
fn skin(body: &Body, scene: &Scene, side: Side) -> Vec<Vertex> {
    let Some(ankle) = body.joint(Bone::LeftFoot.on(side)) else {
        return Vec::new();
    };
    // Without a joint for the toes, the foot does not bend.
    let toes = body.joint(Bone::LeftToes.on(side)).unwrap_or(ankle);
    let floor = ground::floor(body);
    Skin { ankle, toes, floor }.sole(body, scene)
}

/// The skin of both soles, to measure how far it is below its height in a standing body.
pub(super) struct Soles {
    vertices: Vec<Vertex>,
    up: Vec3,
    /// The height of each vertex in a standing body, at most the height of the floor.
    standing: Vec<f32>,
}

impl Soles {
    /// `ankle` is the height of the ankles of a standing body.
    pub(super) fn new(body: &Body, scene: &Scene, ankle: f32) -> Self {
        let vertices: Vec<Vertex> = Side::ALL.into_iter().flat_map(|side| skin(body, scene, side)).collect();
        let floor = ankle - ground::ankle(body);
        let standing = |vertex: &Vertex| floor + (vertex.at_rest.dot(body.up()) - ground::floor(body)).min(0.0);
        Self {
            standing: vertices.iter().map(standing).collect(),
            up: body.up(),
            vertices,
        }
    }

    /// The height of the lowest vertex above its level in stance; infinite without a skin.
    pub(super) fn lowest(&self, pose: &Pose) -> f32 {
        let heights = self.vertices.iter().map(|vertex| vertex.at(pose).dot(self.up));
        let above = heights.zip(&self.standing).map(|(height, standing)| height - standing);
        above.fold(f32::INFINITY, f32::min)
    }
}

/// The points of a foot that stay above the floor: its joints at their heights in a standing body, and its sole in the
/// skin. Without a skin, the positions of heel, ball and toe tip are guessed.
fn sole(body: &Body, scene: &Scene, side: Side) -> Vec<SolePoint> {
    let Some(ankle) = body.joint(Bone::LeftFoot.on(side)) else {
        return Vec::new();
    };
    let floor = ground::floor(body);
    let height = |point: Vec3| point.dot(body.up()) - floor;
    let here = body.position(ankle);
    let (forward, left) = (body.axes * Vec3::Z, body.axes * Vec3::X);
    let toes = body.foot_joint(Bone::LeftToes.on(side));
    let points_to = toes.map(|toes| (body.position(toes) - here).reject_from_normalized(body.up()));
    let points_to = points_to.filter(|along| along.dot(forward) > 0.0).unwrap_or(forward);
    let across = points_to.normalize_or(forward).cross(body.up());
    let axis = |pivot: NodeId| Some(body.rotation(pivot).inverse() * across);
    let point = |node: NodeId| {
        let point = SolePoint::at(scene, node, height(body.position(node)));
        let axis = point.pivot.and_then(axis);
        let most = if point.pivot == Some(ankle) {
            ANKLE_TURNS
        } else {
            TOES_TURN
        };
        SolePoint { most, axis, ..point }
    };
    let mut points = vec![SolePoint {
        pivot: None,
        ..point(ankle)
    }];
    let below = (ankle.index() + 1..body.hierarchy.parents.len()).map(NodeId::new);
    points.extend(below.filter(|node| body.depends_on(*node, ankle)).map(point));
    let Some(toes) = toes.filter(|toes| (body.position(*toes) - here).dot(forward) > 0.0) else {
        return points;
    };
    let ball = body.position(toes);
    let length = (ball - here).dot(forward);
    // Without a joint for the toes, the foot does not bend.
    let bends = body.joint(Bone::LeftToes.on(side)).unwrap_or(ankle);
    let pivot = |node: NodeId| match node == ankle {
        true => (Some(ankle), ANKLE_TURNS),
        false => (Some(node), TOES_TURN),
    };
    for vertex in skin(body, scene, side) {
        let is_in_front = (vertex.at_rest - here).dot(forward) > 0.0;
        let (pivot, most) = if is_in_front { pivot(vertex.of) } else { (None, 0.0) };
        points.push(SolePoint {
            node: None,
            parts: vertex.parts,
            height: height(vertex.at_rest).min(0.0),
            pivot,
            axis: pivot.and_then(axis),
            most,
        });
    }
    if points.iter().any(|point| point.node.is_none()) {
        return points;
    }
    let rest = Pose::rest(scene);
    let mut on_the_floor = |node: NodeId, point: Vec3, (pivot, most): (Option<NodeId>, f32)| {
        let from_joint = point - body.up() * height(point) - body.position(node);
        let scale = rest.node_to_world[node.index()].x_axis.truncate().length();
        points.push(SolePoint {
            node: None,
            parts: vec![(
                node,
                1.0,
                body.rotation(node).inverse() * from_joint / scale.max(f32::MIN_POSITIVE),
            )],
            height: 0.0,
            pivot,
            axis: pivot.and_then(axis),
            most,
        });
    };
    for sign in [-1.0, 1.0] {
        let aside = left * (sign * length);
        on_the_floor(ankle, ball + forward * (FRONT * length) + aside * WIDTH, pivot(ankle));
        on_the_floor(
            ankle,
            here - forward * (HEEL * length) + aside * HEEL_WIDTH,
            (None, 0.0),
        );
        on_the_floor(
            bends,
            ball + forward * (TIP * length) + aside * HEEL_WIDTH,
            pivot(bends),
        );
    }
    points
}
