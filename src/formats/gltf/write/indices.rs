//! The paths of indices in the JSON of a glTF file, and the list to which each refers.

use self::Done::{Broken, Hidden, Out, StandIn, White};
use super::freed::{NO_ACCESSOR, NO_VIEW};

/// The stand-in for an image without bytes: one white pixel, which does not change the colour of a material.
pub(super) const NO_IMAGE: &str = r#"{"mimeType":"image/png","uri":"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg=="}"#;

/// The repair for an invalid index.
#[derive(Clone, Copy)]
pub(super) enum Done {
    /// Removes a member of an object, or an item of an array, this many levels above the index.
    Out(usize),
    /// Removes the index. References to the item that contains it are then treated as invalid.
    Broken,
    /// Replaces the item that contains the index by this stand-in. References to the item are then treated as invalid.
    StandIn(&'static str),
    /// The texture gets [`NO_IMAGE`], and references to it are treated as invalid.
    White,
    /// The node gets an invisible mesh.
    Hidden,
}

/// The JSON paths of indices in a file, the list to which each index refers, and the repair for a missing item. `*`
/// matches any item or member, also within a name, and `**` any number of levels. A list follows the lists whose items
/// it refers to.
pub(super) const INDICES: &[(&str, &str, Done)] = &[
    ("bufferViews/*/buffer", "buffers", StandIn(NO_VIEW)),
    ("bufferViews/*/extensions/*/buffer", "buffers", StandIn(NO_VIEW)),
    ("accessors/*/bufferView", "bufferViews", StandIn(NO_ACCESSOR)),
    ("accessors/*/sparse/*/bufferView", "bufferViews", StandIn(NO_ACCESSOR)),
    ("images/*/bufferView", "bufferViews", StandIn(NO_IMAGE)),
    ("textures/*/source", "images", White),
    ("textures/*/extensions/*/source", "images", Out(1)),
    ("textures/*/sampler", "samplers", Out(0)),
    ("materials/**/*Texture/index", "textures", Out(1)),
    ("materials/*/extensions/MSFT_lod/ids/*", "materials", Out(0)),
    ("skins/*/inverseBindMatrices", "accessors", Broken),
    ("skins/*/skeleton", "nodes", Out(0)),
    ("meshes/*/primitives/*/attributes/POSITION", "accessors", Out(2)),
    ("meshes/*/primitives/*/attributes/JOINTS_*", "accessors", Out(2)),
    ("meshes/*/primitives/*/attributes/WEIGHTS_*", "accessors", Out(2)),
    ("meshes/*/primitives/*/attributes/*", "accessors", Out(0)),
    ("meshes/*/primitives/*/indices", "accessors", Out(1)),
    ("meshes/*/primitives/*/targets/*/*", "accessors", Out(3)),
    ("meshes/*/primitives/*/extensions/*/bufferView", "bufferViews", Out(3)),
    ("meshes/*/primitives/*/material", "materials", Out(0)),
    (
        "meshes/*/primitives/*/extensions/KHR_materials_variants/mappings/*/material",
        "materials",
        Out(1),
    ),
    ("nodes/*/mesh", "meshes", Hidden),
    ("nodes/*/skin", "skins", Hidden),
    ("nodes/*/camera", "cameras", Out(0)),
    ("nodes/*/children/*", "nodes", Out(0)),
    (
        "nodes/*/extensions/KHR_lights_punctual/light",
        "extensions/KHR_lights_punctual/lights",
        Out(1),
    ),
    (
        "nodes/*/extensions/EXT_mesh_gpu_instancing/attributes/*",
        "accessors",
        Out(2),
    ),
    (
        "nodes/*/extensions/VRMC_node_constraint/constraint/*/source",
        "nodes",
        Out(3),
    ),
    ("nodes/*/extensions/MSFT_lod/ids/*", "nodes", Out(0)),
    ("scenes/*/nodes/*", "nodes", Out(0)),
    ("extensions/VRMC_vrm/meta/thumbnailImage", "images", Out(0)),
    ("extensions/VRMC_vrm/humanoid/humanBones/*/node", "nodes", Out(1)),
    (
        "extensions/VRMC_vrm/firstPerson/meshAnnotations/*/node",
        "nodes",
        Out(1),
    ),
    (
        "extensions/VRMC_vrm/expressions/*/*/morphTargetBinds/*/node",
        "nodes",
        Out(1),
    ),
    (
        "extensions/VRMC_vrm/expressions/*/*/*Binds/*/material",
        "materials",
        Out(1),
    ),
    ("extensions/VRMC_springBone/springs/*/joints/*/node", "nodes", Out(3)),
    ("extensions/VRMC_springBone/springs/*/center", "nodes", Out(0)),
    ("extensions/VRMC_springBone/colliders/*/node", "nodes", Out(3)),
    (
        "extensions/VRMC_springBone/colliderGroups/*/colliders/*",
        "extensions/VRMC_springBone/colliders",
        Out(0),
    ),
    (
        "extensions/VRMC_springBone/springs/*/colliderGroups/*",
        "extensions/VRMC_springBone/colliderGroups",
        Out(0),
    ),
    ("extensions/VRM/meta/texture", "textures", Out(0)),
    ("extensions/VRM/humanoid/humanBones/*/node", "nodes", Out(1)),
    ("extensions/VRM/firstPerson/firstPersonBone", "nodes", Out(0)),
    ("extensions/VRM/firstPerson/meshAnnotations/*/mesh", "meshes", Out(1)),
    (
        "extensions/VRM/blendShapeMaster/blendShapeGroups/*/binds/*/mesh",
        "meshes",
        Out(1),
    ),
    (
        "extensions/VRM/secondaryAnimation/boneGroups/*/bones/*",
        "nodes",
        Out(0),
    ),
    ("extensions/VRM/secondaryAnimation/boneGroups/*/center", "nodes", Out(0)),
    (
        "extensions/VRM/secondaryAnimation/colliderGroups/*/node",
        "nodes",
        Out(3),
    ),
    (
        "extensions/VRM/secondaryAnimation/boneGroups/*/colliderGroups/*",
        "extensions/VRM/secondaryAnimation/colliderGroups",
        Out(0),
    ),
    (
        "extensions/VRM/materialProperties/*/textureProperties/*",
        "textures",
        Out(0),
    ),
];

/// VRM 0 writes a negative number for no reference.
pub(super) const MAY_BE_NEGATIVE: &str = "extensions/VRM/";
