//! Converts Assimp's scene of a program to a scene of `mocap`.

use mocap::Scene;
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Animation, Bone, Channel, Keys, Material, Mesh, Node, NodeId, NodeKind, Primitive, VertexWeight};

use crate::abi::{
    AI_SUCCESS, aiAnimation, aiBone, aiMaterial, aiMatrix4x4, aiMesh, aiNode, aiNodeAnim, aiQuatKey, aiScene, aiString,
    aiVectorKey,
};
use crate::border::slice;
use crate::material::{aiGetMaterialIntegerArray, aiGetMaterialString};

/// The largest depth of a graph; a deeper graph counts as circular.
const MAX_DEPTH: usize = 4096;

/// Copies a scene. Fails if `mocap` cannot represent something in it.
///
/// # Safety
/// `scene` is NULL or a scene whose counts and pointers fit together.
pub(crate) unsafe fn scene(scene: *const aiScene) -> Result<Scene, String> {
    // SAFETY: the caller passes NULL or a scene.
    let from = unsafe { scene.as_ref() }.ok_or("the scene is NULL")?;
    let mut to = Scene::default();
    // SAFETY: the scene has this number of animations, each of them whole. This also holds for the calls below.
    for animation in unsafe { targets(from.mAnimations, from.mNumAnimations, "mAnimations") }? {
        // SAFETY: the animation is whole.
        to.animations.push(unsafe { self::animation(animation) }?);
    }
    // SAFETY: the root is NULL or the head of a whole graph.
    unsafe { add_node(&mut to, from.mRootNode, None, 0) }?;
    // SAFETY: the scene has this number of materials.
    for material in unsafe { targets(from.mMaterials, from.mNumMaterials, "mMaterials") }? {
        // SAFETY: the material is whole.
        to.materials.push(unsafe { self::material(material) });
    }
    // SAFETY: the scene has this number of meshes.
    for mesh in unsafe { targets(from.mMeshes, from.mNumMeshes, "mMeshes") }? {
        // SAFETY: the mesh is whole.
        let mesh = unsafe { self::mesh(mesh, &to.nodes) }?;
        to.meshes.push(mesh);
    }
    match to.validate().first() {
        Some(violation) => Err(violation.to_string()),
        None => Ok(to),
    }
}

/// Fails if a scene has something that `mocap` cannot represent, and that is no part of a motion.
///
/// # Safety
/// `scene` is a scene whose counts and pointers fit together.
pub(crate) unsafe fn check_nothing_is_lost(scene: &aiScene) -> Result<(), String> {
    let lost = |what: &str| Err(format!("mocap's libassimp does not write {what}"));
    for (count, what) in [
        (scene.mNumTextures, "textures"),
        (scene.mNumLights, "lights"),
        (scene.mNumCameras, "cameras"),
        (scene.mNumSkeletons, "skeletons"),
    ] {
        if count > 0 {
            return lost(what);
        }
    }
    // SAFETY: the scene has these numbers of meshes, materials and animations.
    unsafe {
        for mesh in targets(scene.mMeshes, scene.mNumMeshes, "mMeshes")? {
            if mesh.mTextureCoords.iter().any(|array| !array.is_null()) {
                return lost("texture coordinates");
            }
            if mesh.mColors.iter().any(|array| !array.is_null()) {
                return lost("vertex colours");
            }
            if mesh.mNumAnimMeshes > 0 {
                return lost("blend shapes");
            }
        }
        for material in targets(scene.mMaterials, scene.mNumMaterials, "mMaterials")? {
            let properties = targets(material.mProperties, material.mNumProperties, "mProperties")?;
            let keys = properties.iter().map(|property| property.mKey.to_text());
            if keys.into_iter().any(|key| key != "?mat.name" && key != "$mat.twosided") {
                return lost("colours and textures of materials");
            }
        }
        for animation in targets(scene.mAnimations, scene.mNumAnimations, "mAnimations")? {
            if animation.mNumMeshChannels + animation.mNumMorphMeshChannels > 0 {
                return lost("animations of meshes");
            }
        }
    }
    Ok(())
}

/// The values behind an array of pointers.
///
/// # Safety
/// `count` is 0, or `first` is NULL or points to `count` pointers, each NULL or to a value.
unsafe fn targets<'a, T>(first: *mut *mut T, count: u32, what: &str) -> Result<Vec<&'a T>, String> {
    // SAFETY: the caller's promise in `# Safety`.
    let pointers = unsafe { slice::<*mut T>(first, count as usize, what) }?;
    let target = |pointer: &*mut T| {
        // SAFETY: the pointer is NULL or leads to a value.
        unsafe { pointer.as_ref() }.ok_or_else(|| format!("{what} holds a NULL"))
    };
    pointers.iter().map(target).collect()
}

/// # Safety
/// `node` is NULL or a node whose counts and pointers fit together.
unsafe fn add_node(scene: &mut Scene, node: *const aiNode, parent: Option<NodeId>, depth: usize) -> Result<(), String> {
    // SAFETY: the caller passes NULL or a node.
    let node = unsafe { node.as_ref() }.ok_or("a node is NULL")?;
    if depth == MAX_DEPTH {
        return Err(format!("the node graph is more than {MAX_DEPTH} deep"));
    }
    let id = NodeId::new(scene.nodes.len());
    let name = node.mName.to_text();
    // SAFETY: the node has this number of meshes.
    let meshes = unsafe { slice::<u32>(node.mMeshes, node.mNumMeshes as usize, "mMeshes") }?;
    scene.nodes.push(Node {
        kind: kind(scene, &name, parent, node.mNumChildren),
        name,
        parent,
        transform: matrix(node.mTransformation),
        meshes: meshes.iter().map(|&mesh| mesh as usize).collect(),
        ..Node::default()
    });
    // SAFETY: the node has this number of children.
    for child in unsafe { targets(node.mChildren, node.mNumChildren, "mChildren") }? {
        // SAFETY: the child is a node.
        unsafe { add_node(scene, child, Some(id), depth + 1) }?;
    }
    Ok(())
}

/// Assimp's nodes have no kind. Its BVH importer names an end site after its parent, and gives it neither children nor
/// a channel.
fn kind(scene: &Scene, name: &str, parent: Option<NodeId>, children: u32) -> NodeKind {
    let parent_name = parent.map(|parent| scene.nodes[parent.index()].name.as_str());
    let mut channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    let is_end_site = children == 0
        && name
            .strip_prefix("EndSite_")
            .is_some_and(|rest| Some(rest) == parent_name)
        && channels.all(|channel| channel.node_name != name);
    if is_end_site {
        NodeKind::EndSite
    } else {
        NodeKind::Joint
    }
}

/// # Safety
/// The mesh's counts and pointers fit together.
unsafe fn mesh(mesh: &aiMesh, nodes: &[Node]) -> Result<Mesh, String> {
    // SAFETY: the mesh has this number of vertices, and no or as many normals.
    let vertices = unsafe { slice(mesh.mVertices, mesh.mNumVertices as usize, "mVertices") }?;
    // SAFETY: the mesh has no or as many normals.
    let normals = unsafe { slice(mesh.mNormals, mesh.mNumVertices as usize, "mNormals") }?;
    // SAFETY: the mesh has this number of faces.
    let faces = unsafe { slice(mesh.mFaces, mesh.mNumFaces as usize, "mFaces") }?;
    let indices_per_face = faces.first().map_or(3, |face| face.mNumIndices);
    let primitive = match indices_per_face {
        3 => Primitive::Triangles,
        1 => Primitive::Points,
        other => return Err(format!("faces of {other} corners cannot be written")),
    };
    let mut indices = Vec::with_capacity(faces.len() * indices_per_face as usize);
    for face in faces {
        if face.mNumIndices != indices_per_face {
            return Err("a mesh of points and triangles cannot be written; use aiProcess_SortByPType".to_owned());
        }
        // SAFETY: the face has this number of indices.
        indices.extend_from_slice(unsafe { slice(face.mIndices, face.mNumIndices as usize, "mIndices") }?);
    }
    let mut bones = Vec::new();
    // SAFETY: the mesh has this number of bones.
    for bone in unsafe { targets(mesh.mBones, mesh.mNumBones, "mBones") }? {
        // SAFETY: the bone is whole.
        bones.push(unsafe { self::bone(bone, nodes) }?);
    }
    Ok(Mesh {
        name: mesh.mName.to_text(),
        primitive,
        vertices: vertices.iter().copied().map(Vec3::from_array).collect(),
        normals: normals
            .iter()
            .map(|&normal| Vec3::from_array(normal).normalize_or(Vec3::X))
            .collect(),
        texture_coords: Vec::new(),
        indices,
        bones,
        morph_targets: Vec::new(),
        material_index: mesh.mMaterialIndex as usize,
    })
}

/// # Safety
/// The bone's counts and pointers fit together.
unsafe fn bone(bone: &aiBone, nodes: &[Node]) -> Result<Bone, String> {
    let name = bone.mName.to_text();
    let node = nodes.iter().position(|node| node.name == name);
    let node = node.ok_or_else(|| format!("the bone \"{name}\" has no node"))?;
    // SAFETY: the bone has this number of weights.
    let weights = unsafe { slice(bone.mWeights, bone.mNumWeights as usize, "mWeights") }?;
    let weights = weights.iter().map(|weight| VertexWeight {
        vertex_id: weight.mVertexId,
        weight: weight.mWeight,
    });
    Ok(Bone {
        name,
        node: NodeId::new(node),
        offset_matrix: matrix(bone.mOffsetMatrix),
        weights: weights.collect(),
    })
}

/// # Safety
/// The material's counts and pointers fit together.
unsafe fn material(material: &aiMaterial) -> Material {
    let mut name = aiString::new("");
    let mut two_sided = 0;
    // SAFETY: the material is whole, and both answers have a place.
    let (has_name, has_sides) = unsafe {
        (
            aiGetMaterialString(material, c"?mat.name".as_ptr(), 0, 0, &raw mut name),
            aiGetMaterialIntegerArray(
                material,
                c"$mat.twosided".as_ptr(),
                0,
                0,
                &raw mut two_sided,
                std::ptr::null_mut(),
            ),
        )
    };
    Material {
        name: if has_name == AI_SUCCESS {
            name.to_text()
        } else {
            String::new()
        },
        two_sided: has_sides == AI_SUCCESS && two_sided != 0,
        surface: None,
    }
}

/// # Safety
/// The animation's counts and pointers fit together.
unsafe fn animation(animation: &aiAnimation) -> Result<Animation, String> {
    let mut channels = Vec::new();
    // SAFETY: the animation has this number of channels.
    for channel in unsafe { targets(animation.mChannels, animation.mNumChannels, "mChannels") }? {
        // SAFETY: the channel is whole.
        channels.push(unsafe { self::channel(channel) }?);
    }
    Ok(Animation {
        name: animation.mName.to_text(),
        ticks_per_second: animation.mTicksPerSecond,
        duration: animation.mDuration,
        channels,
    })
}

/// # Safety
/// The channel's counts and pointers fit together.
unsafe fn channel(channel: &aiNodeAnim) -> Result<Channel, String> {
    // SAFETY: the channel has these numbers of keys.
    let (positions, rotations, scalings) = unsafe {
        (
            slice(
                channel.mPositionKeys,
                channel.mNumPositionKeys as usize,
                "mPositionKeys",
            )?,
            slice(
                channel.mRotationKeys,
                channel.mNumRotationKeys as usize,
                "mRotationKeys",
            )?,
            slice(channel.mScalingKeys, channel.mNumScalingKeys as usize, "mScalingKeys")?,
        )
    };
    Ok(Channel {
        node_name: channel.mNodeName.to_text(),
        node: None,
        position_keys: vectors(positions),
        rotation_keys: quaternions(rotations),
        scaling_keys: vectors(scalings),
    })
}

fn vectors(keys: &[aiVectorKey]) -> Keys<Vec3> {
    let values = keys.iter().map(|key| Vec3::from_array(key.mValue)).collect();
    Keys::at_ticks(values, keys.iter().map(|key| key.mTime).collect())
}

fn quaternions(keys: &[aiQuatKey]) -> Keys<Quat> {
    let value = |key: &aiQuatKey| {
        let [w, x, y, z] = key.mValue;
        Quat::from_xyzw(x, y, z, w)
    };
    Keys::at_ticks(
        keys.iter().map(value).collect(),
        keys.iter().map(|key| key.mTime).collect(),
    )
}

fn matrix(rows: aiMatrix4x4) -> Mat4 {
    Mat4::from_cols_array_2d(&rows).transpose()
}
