//! Converts the skeleton of a scene to entities, and entities to a scene.

use bevy::prelude::*;
use mocap::Trs;
use mocap::scene::{Node, NodeId, Scene, UpAxis};

/// Spawns the skeleton of a scene below `parent`: one entity with a [`Name`] for each node. `parent` may have a
/// [`MotionPlayer`](crate::MotionPlayer). Returns the entities in the order of the scene's nodes.
pub fn spawn(commands: &mut Commands, scene: &Scene, parent: Entity) -> Vec<Entity> {
    let mut nodes: Vec<Entity> = Vec::with_capacity(scene.nodes.len());
    for node in &scene.nodes {
        // Parents precede their children.
        let parent = node.parent.map_or(parent, |parent| nodes[parent.index()]);
        let transform = to_bevy(Trs::from_matrix(node.transform));
        let entity = commands.spawn((Name::new(node.name.clone()), transform, ChildOf(parent)));
        nodes.push(entity.id());
    }
    nodes
}

/// The entities below `root` as nodes in their current pose, parents first. The root is the first node, with the
/// identity as its transform, because the transform of the root places the figure in the world. `None` if no entity has
/// a name.
pub(crate) fn figure_of(
    root: Entity,
    parts: &Query<(Option<&Name>, Option<&Children>, &Transform)>,
) -> Option<(Scene, Vec<Entity>)> {
    let mut scene = Scene::default();
    let mut entities = Vec::new();
    let mut waiting = vec![(root, None)];
    while let Some((entity, parent)) = waiting.pop() {
        let Ok((name, children, transform)) = parts.get(entity) else {
            continue;
        };
        let id = NodeId::new(entities.len());
        let is_root = parent.is_none();
        scene.nodes.push(Node {
            // No channel refers to a node without a name.
            name: name.map_or_else(|| format!("{entity}"), |name| name.as_str().to_owned()),
            parent,
            transform: if is_root { Trs::IDENTITY } else { to_mocap(transform) }.matrix(),
            ..Node::default()
        });
        entities.push(entity);
        let below = children.into_iter().flat_map(RelationshipTarget::iter);
        let below: Vec<_> = below.map(|child| (child, Some(id))).collect();
        waiting.extend(below.into_iter().rev());
    }
    let has_name = |&&entity: &&Entity| matches!(parts.get(entity), Ok((Some(_), ..)));
    entities.iter().skip(1).find(has_name)?;
    scene.metadata.up = Some(UpAxis::Y);
    Some((scene, entities))
}

/// mocap and Bevy may use different versions of glam, so numbers are copied instead of types.
pub(crate) fn to_bevy(trs: Trs) -> Transform {
    Transform {
        translation: Vec3::from_array(trs.translation.to_array()),
        rotation: Quat::from_array(trs.rotation.to_array()),
        scale: Vec3::from_array(trs.scale.to_array()),
    }
}

pub(crate) fn to_mocap(transform: &Transform) -> Trs {
    Trs {
        translation: transform.translation.to_array().into(),
        rotation: mocap::glam::Quat::from_array(transform.rotation.to_array()),
        scale: transform.scale.to_array().into(),
    }
}
