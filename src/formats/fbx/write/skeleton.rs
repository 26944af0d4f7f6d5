//! Writes the nodes as models, and the bind pose.
//!
//! The transform of a node in FBX is `T Rpre R S`: translation, pre-rotation in the order XYZ, rotation in the node's
//! rotation order, and scale. The writer leaves offsets, pivots and the post-rotation at zero.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat4, DQuat, DVec3, Mat4, Quat, Vec3};
use mocap_scene::error::Result;
use mocap_scene::limits::{FARTHEST, is_plausible};
use mocap_scene::math::rotation::to_euler_xyz;
use mocap_scene::scene::{GROUP_OF_ROOTS, Keys, Node, NodeId, NodeKind, RotationOrder, Scene};

use super::document::{Document, Id, SCENE_ROOT};
use super::encode::{Array, Element};
use super::names::Names;
use super::properties::Properties;
use super::space::Space;
use super::{FbxOptions, FbxReport, FbxRest, FbxRoot, unrepresentable};

/// The order of nodes without a rotation order: FBX's XYZ, the only order that every program reads correctly.
const USUAL_ORDER: RotationOrder = RotationOrder::Zyx;

/// The name that readers give to FBX's implicit root.
const NAME_OF_ROOT: &str = "RootNode";

/// A node of the scene, converted to the file.
pub(super) struct Placed {
    pub(super) id: Id,
    pub(super) translation: DVec3,
    pub(super) rotation: DQuat,
    pub(super) scale: DVec3,
    /// The constant rotation before the animated rotation.
    pub(super) pre_rotation: DQuat,
    pub(super) order: RotationOrder,
    /// The transform to the world in the rest pose.
    pub(super) world: DMat4,
}

impl Placed {
    fn local(&self) -> DMat4 {
        DMat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }

    pub(super) fn angles_at_rest(&self) -> DVec3 {
        self.angles(self.rotation, DVec3::ZERO)
    }

    /// The Euler angles of a rotation relative to the parent, in degrees about x, y and z. Of all equivalent angles,
    /// returns the angles nearest to `before`.
    pub(super) fn angles(&self, rotation: DQuat, before: DVec3) -> DVec3 {
        to_euler_xyz(self.pre_rotation.conjugate() * rotation, self.order, before)
    }
}

/// The name of an FBX rotation order begins with the axis that is applied first. In the matrix product this axis is the
/// last factor.
fn rotation_order(order: RotationOrder) -> i32 {
    match order {
        RotationOrder::Zyx => 0,
        RotationOrder::Yzx => 1,
        RotationOrder::Xzy => 2,
        RotationOrder::Zxy => 3,
        RotationOrder::Yxz => 4,
        RotationOrder::Xyz => 5,
    }
}

/// Adds the nodes of `scene`. `binds` has the nodes to which a mesh is bound.
pub(super) fn write<'a>(
    scene: &Scene,
    space: &Space,
    options: &FbxOptions,
    binds: &BTreeSet<usize>,
    names: &mut Names,
    document: &mut Document<'a>,
    report: &mut FbxReport,
) -> Result<Vec<Placed>> {
    let is_root = |index: usize, node: &Node| scene.nodes[index].parent.is_none() && node.kind != NodeKind::Group;
    let has_bare_root = scene.nodes.iter().enumerate().any(|(index, node)| is_root(index, node));
    let root = match &options.root {
        FbxRoot::Null(name) if has_bare_root => {
            let name = names.unique(name, "Armature");
            add_model(document, &name, SCENE_ROOT, false, Properties::new())
        }
        _ => SCENE_ROOT,
    };
    let left_out = groups_left_out(scene, options, binds);
    let is_bone = bones(scene, binds);
    let mut placed: Vec<Placed> = Vec::with_capacity(scene.nodes.len());
    for (index, node) in scene.nodes.iter().enumerate() {
        let parent = node.parent.and_then(|parent| placed.get(parent.index()));
        let (above, parent_id) = parent.map_or((DMat4::IDENTITY, root), |parent| (parent.world, parent.id));
        let mut model_node = at_rest(node, space, options)?;
        model_node.world = above * model_node.local();
        if index < left_out {
            model_node.id = SCENE_ROOT;
            placed.push(model_node);
            continue;
        }
        let instead = match node.kind {
            NodeKind::Joint => "Joint",
            NodeKind::EndSite => "EndSite",
            NodeKind::Group => "Group",
        };
        let name = names.unique(&node.name, instead);
        let mut properties = Properties::new();
        let order = rotation_order(model_node.order);
        if order != 0 {
            properties = properties.choice("RotationOrder", order);
        }
        if model_node.pre_rotation != DQuat::IDENTITY {
            let angles = to_euler_xyz(model_node.pre_rotation, USUAL_ORDER, DVec3::ZERO);
            properties = properties.vector("PreRotation", angles);
        }
        properties = properties
            // Without this flag some programs ignore the rotation order and the pre-rotation.
            .flag("RotationActive", true)
            // Inherit the scale of the parent in the usual way, as part of its matrix.
            .choice("InheritType", 1)
            .property("DefaultAttributeIndex", ["int", "Integer", ""], [0.into()])
            .own("Lcl Translation", model_node.translation)
            .own("Lcl Rotation", model_node.angles_at_rest())
            .own("Lcl Scaling", model_node.scale);
        if name != node.name {
            properties = properties.user_text(super::super::SOURCE_NAME, node.name.clone());
            report.renamed.push((index, node.name.clone(), name.clone()));
        }
        if node.kind == NodeKind::EndSite {
            properties = properties.user_flag(super::super::END_SITE);
        }
        report.bones += usize::from(is_bone[index]);
        model_node.id = add_model(document, &name, parent_id, is_bone[index], properties);
        placed.push(model_node);
    }
    Ok(placed)
}

/// Whether each node becomes a `LimbNode`: joints, nodes to which a mesh is bound, and groups between two such nodes.
///
/// Blender's Python importer finds no armature for bones below a `Null` that is itself below a bone. If a mesh is bound
/// to such bones, the importer fails with `KeyError: None`.
fn bones(scene: &Scene, binds: &BTreeSet<usize>) -> Vec<bool> {
    let nodes = scene.nodes.iter().enumerate();
    let mut is_bone: Vec<bool> = nodes
        .map(|(index, node)| node.kind != NodeKind::Group || binds.contains(&index))
        .collect();
    let mut holds_bone = is_bone.clone();
    let links = || {
        let nodes = scene.nodes.iter().enumerate();
        let links = nodes.filter_map(|(index, node)| Some((index, node.parent?.index())));
        // Parents come before their children.
        links.filter(|(index, parent)| parent < index)
    };
    for (index, parent) in links().collect::<Vec<_>>().into_iter().rev() {
        holds_bone[parent] |= holds_bone[index];
    }
    for (index, parent) in links() {
        is_bone[index] |= is_bone[parent] && holds_bone[index];
    }
    is_bone
}

/// A node in its rest pose. The id and the world transform are not set yet.
fn at_rest(node: &Node, space: &Space, options: &FbxOptions) -> Result<Placed> {
    // Decompose in double precision: with sheared axes, rounding would decide between two rotations.
    let (scale, rotation, _) = node.transform.as_dmat4().to_scale_rotation_translation();
    let (scale, rotation, translation) = (scale.as_vec3(), rotation.as_quat(), node.transform.w_axis.truncate());
    let is_sound = |vector: Vec3| vector.to_array().into_iter().all(|value| is_plausible(value.into()));
    let rotation = space
        .rotation(rotation)
        .filter(|_| is_sound(scale) && is_sound(translation));
    let Some(rotation) = rotation else {
        let message = format!(
            "its rest transform is not a product of translation, rotation and scale, or a number is beyond {FARTHEST:e}"
        );
        return Err(unrepresentable(&node.name, message));
    };
    Ok(Placed {
        id: SCENE_ROOT,
        translation: space.point(translation),
        rotation,
        scale: space.scale(scale),
        pre_rotation: match options.rest {
            FbxRest::PreRotation => rotation,
            FbxRest::Rotation => DQuat::IDENTITY,
        },
        order: node.rotation_order.map_or(USUAL_ORDER, |order| space.order(order)),
        world: DMat4::IDENTITY,
    })
}

/// The number of leading groups that the writer drops, because the implicit root of the file replaces them. By default
/// the writer drops the root node of a scene that was read from FBX. With [`FbxRoot::None`], it drops all groups above
/// the skeleton that do nothing.
fn groups_left_out(scene: &Scene, options: &FbxOptions, binds: &BTreeSet<usize>) -> usize {
    let nodes = &scene.nodes;
    let is_still = |index: usize| {
        let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
        let mut own = channels.filter(|channel| match channel.node {
            Some(node) => node.index() == index,
            None => channel.node_name == nodes[index].name,
        });
        own.all(|channel| {
            is_all(&channel.position_keys, |value| value == Vec3::ZERO)
                && is_all(&channel.rotation_keys, |value| {
                    value == Quat::IDENTITY || value == -Quat::IDENTITY
                })
                && is_all(&channel.scaling_keys, |value| value == Vec3::ONE)
        })
    };
    let is_plain = |index: usize| {
        let node = &nodes[index];
        node.kind == NodeKind::Group && node.transform == Mat4::IDENTITY && !binds.contains(&index) && is_still(index)
    };
    let children = |index: usize| {
        let parent = Some(NodeId::new(index));
        nodes.iter().filter(move |node| node.parent == parent).count()
    };
    let is_one = nodes.iter().filter(|node| node.parent.is_none()).count() == 1;
    if nodes.is_empty() || !is_one || !is_plain(0) {
        return 0;
    }
    match options.root {
        FbxRoot::Null(_) => usize::from(nodes[0].name == NAME_OF_ROOT),
        FbxRoot::None => {
            // Nodes are depth-first, so an only child directly follows its parent.
            let only = (0..nodes.len())
                .take_while(|&index| is_plain(index) && children(index) == 1)
                .count();
            let holds_roots = |index: usize| {
                let name = &nodes[index].name;
                is_plain(index) && (name == GROUP_OF_ROOTS || name == NAME_OF_ROOT)
            };
            only + usize::from(only < nodes.len() && holds_roots(only))
        }
    }
}

fn is_all<T: Copy>(keys: &Keys<T>, test: impl Fn(T) -> bool) -> bool {
    keys.values.iter().all(|value| test(*value))
}

/// Adds a bone or a null as a model with its attribute.
fn add_model<'a>(document: &mut Document<'a>, name: &str, parent: Id, is_bone: bool, properties: Properties<'a>) -> Id {
    let (class, flags) = if is_bone {
        ("LimbNode", "Skeleton")
    } else {
        ("Null", "Null")
    };
    let (attribute, element) = document.object("NodeAttribute", [name, "NodeAttribute", class]);
    let size = Properties::new().double("Size", 1.0).element();
    document.add(
        "NodeAttribute",
        element.child(size).child(Element::of("TypeFlags", flags)),
    );
    let (id, element) = document.object("Model", [name, "Model", class]);
    document.add("Model", model(element, properties));
    document.connect(attribute, id);
    document.connect(id, parent);
    id
}

/// A model of any class.
pub(super) fn model<'a>(element: Element<'a>, properties: Properties<'a>) -> Element<'a> {
    element
        .child(Element::of("Version", 232))
        .child(properties.element())
        .child(Element::of("Shading", true))
        .child(Element::of("Culling", "CullingOff"))
}

/// Offsets for joints that move relative to their parents, from their positions in the bind pose. `moving` has the
/// largest distance that each joint moves.
///
/// Blender's importers put the tail of a bone along its +Y axis. If the head of a child is at this tail, Blender
/// connects the two bones, and the child can no longer move relative to its parent. So the writer moves the head away
/// from the tail. The offset is 1e-5 of the distance from the origin or of the link length, whichever is larger. The
/// importer built into Blender 5.0 connects heads within 1e-4 units of the armature. A joint that moves by less than
/// the offset stays connected.
pub(super) fn beside_the_tails(scene: &Scene, placed: &[Placed], moving: &BTreeMap<usize, f64>) -> Vec<DVec3> {
    /// The offset as a fraction of the larger of the distance from the origin and the link length: the rounding error
    /// of keys.
    const SHARE: f64 = 1e-5;

    /// The least offset, in units of the file. Blender connects bones nearer than 1e-4.
    const UNITS: f64 = 1.5e-4;
    let mut beside = vec![DVec3::ZERO; placed.len()];
    for (index, node) in scene.nodes.iter().enumerate() {
        let Some(parent) = node.parent else { continue };
        // A joint that does not move relative to its parent gets the offset of the parent.
        let of_tail = beside[parent.index()];
        beside[index] = of_tail;
        let Some(farthest) = moving.get(&index) else { continue };
        let [own, above] = [index, parent.index()].map(|index| placed[index].world);
        let link = own.w_axis.distance(above.w_axis);
        let scale = above.x_axis.truncate().length();
        let distance = f64::max(scale * UNITS, SHARE * f64::max(own.w_axis.truncate().length(), link));
        if scale * farthest > distance {
            let offset = distance * above.x_axis.truncate().normalize_or_zero();
            beside[index] += if of_tail.dot(offset) > 0.0 { -offset } else { offset };
        }
    }
    beside
}

/// Adds the bind pose: the world matrices of these objects.
pub(super) fn bind_pose(document: &mut Document<'_>, matrices: &[(Id, DMat4)]) {
    let (_, element) = document.object("Pose", ["BindPose", "Pose", "BindPose"]);
    let nodes = matrices.iter().map(|(id, matrix)| {
        Element::new("PoseNode")
            .child(Element::of("Node", *id))
            .child(Element::of("Matrix", Array::doubles(matrix.to_cols_array())))
    });
    let element = element
        .child(Element::of("Type", "BindPose"))
        .child(Element::of("Version", 100))
        .child(Element::of("NbPoseNodes", matrices.len() as i32))
        .children(nodes);
    document.add("Pose", element);
}
