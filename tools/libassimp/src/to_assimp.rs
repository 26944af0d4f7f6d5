//! A scene of `mocap` as an Assimp scene.

use std::ffi::c_void;
use std::ptr;

use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Animation, Bone, Channel, Keys, Material, Mesh, Primitive};
use mocap::{Format, Scene};

use crate::abi::{
    METADATA_STRING, PRIMITIVE_POINT, PRIMITIVE_TRIANGLE, PROPERTY_INTEGER, PROPERTY_STRING, aiAnimation, aiBone,
    aiFace, aiMaterial, aiMaterialProperty, aiMatrix4x4, aiMesh, aiMetadata, aiMetadataEntry, aiNode, aiNodeAnim,
    aiQuatKey, aiScene, aiString, aiVectorKey, aiVertexWeight,
};
use crate::arena::Arena;

/// A scene and the memory it lies in. A pointer to one is a pointer to the other, since the scene stands first.
#[repr(C)]
pub(crate) struct Imported {
    scene: aiScene,
    arena: Arena,
}

impl Imported {
    /// Makes an Assimp scene. `flags` becomes `aiScene::mFlags`.
    pub(crate) fn into_raw(scene: &Scene, flags: u32) -> *const aiScene {
        let mut arena = Arena::default();
        let materials = scene.materials.iter().map(|it| material(&mut arena, it)).collect();
        let meshes = scene.meshes.iter().map(|it| mesh(&mut arena, it)).collect();
        let animations = scene.animations.iter().map(|it| animation(&mut arena, it)).collect();
        let mut imported = Box::new(Self {
            scene: aiScene {
                mFlags: flags,
                mRootNode: nodes(&mut arena, scene),
                mNumMeshes: scene.meshes.len() as u32,
                mMeshes: arena.keep_pointers(meshes),
                mNumMaterials: scene.materials.len() as u32,
                mMaterials: arena.keep_pointers(materials),
                mNumAnimations: scene.animations.len() as u32,
                mAnimations: arena.keep_pointers(animations),
                mMetaData: metadata(&mut arena, scene.metadata.format),
                ..aiScene::default()
            },
            arena,
        });
        // Tells a scene of ours from one that the program made itself. Assimp leaves something here too.
        imported.scene.mPrivate = (&raw mut imported.scene).cast();
        Box::into_raw(imported).cast()
    }

    /// Frees a scene and all that it points to; a scene that is not from here stays.
    ///
    /// # Safety
    /// `scene` is NULL or a scene, and is not used any more.
    pub(crate) unsafe fn release(scene: *const aiScene) {
        // SAFETY: the caller hands over NULL or a scene.
        let is_ours = unsafe { scene.as_ref() }.is_some_and(|it| ptr::eq(it.mPrivate.cast(), scene));
        if is_ours {
            // SAFETY: `into_raw` made it, and the caller gives it up.
            drop(unsafe { Box::from_raw(scene.cast_mut().cast::<Self>()) });
        }
    }
}

/// The node graph, all nodes in one block in the order of the scene. Returns the root.
fn nodes(arena: &mut Arena, scene: &Scene) -> *mut aiNode {
    let mut children = vec![Vec::new(); scene.nodes.len()];
    for (index, node) in scene.nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            children[parent.index()].push(index);
        }
    }
    let nodes = scene.nodes.iter().map(|node| {
        let meshes: Vec<u32> = node.meshes.iter().map(|&mesh| mesh as u32).collect();
        aiNode {
            mName: aiString::new(&node.name),
            mTransformation: rows(node.transform),
            mParent: ptr::null_mut(),
            mNumChildren: 0,
            mChildren: ptr::null_mut(),
            mNumMeshes: meshes.len() as u32,
            mMeshes: arena.keep(meshes),
            mMetaData: ptr::null_mut(),
        }
    });
    let nodes = nodes.collect();
    let first: *mut aiNode = arena.keep(nodes);
    let node_at = |index: usize| first.wrapping_add(index);
    for (index, children) in children.into_iter().enumerate() {
        // SAFETY: `index` is that of a node in the block, which nothing else refers to yet.
        let node = unsafe { &mut *node_at(index) };
        let parent = scene.nodes[index].parent;
        node.mParent = parent.map_or(ptr::null_mut(), |parent| node_at(parent.index()));
        node.mNumChildren = children.len() as u32;
        node.mChildren = arena.keep(children.into_iter().map(node_at).collect());
    }
    first
}

fn mesh(arena: &mut Arena, mesh: &Mesh) -> aiMesh {
    let indices_per_face = mesh.primitive.indices_per_face();
    let indices: *mut u32 = arena.keep(mesh.indices.clone());
    let faces = (0..mesh.faces().len()).map(|face| aiFace {
        mNumIndices: indices_per_face as u32,
        mIndices: indices.wrapping_add(face * indices_per_face),
    });
    let bones = mesh.bones.iter().map(|it| bone(arena, it)).collect();
    aiMesh {
        mPrimitiveTypes: match mesh.primitive {
            Primitive::Triangles => PRIMITIVE_TRIANGLE,
            Primitive::Points => PRIMITIVE_POINT,
        },
        mNumVertices: mesh.vertices.len() as u32,
        mNumFaces: faces.len() as u32,
        mVertices: arena.keep(mesh.vertices.iter().map(Vec3::to_array).collect()),
        mNormals: arena.keep(mesh.normals.iter().map(Vec3::to_array).collect()),
        mFaces: arena.keep(faces.collect()),
        mNumBones: mesh.bones.len() as u32,
        mBones: arena.keep_pointers(bones),
        mMaterialIndex: mesh.material_index as u32,
        mName: aiString::new(&mesh.name),
        ..aiMesh::default()
    }
}

fn bone(arena: &mut Arena, bone: &Bone) -> aiBone {
    let weights = bone.weights.iter().map(|weight| aiVertexWeight {
        mVertexId: weight.vertex_id,
        mWeight: weight.weight,
    });
    aiBone {
        mName: aiString::new(&bone.name),
        mNumWeights: bone.weights.len() as u32,
        mArmature: ptr::null_mut(),
        mNode: ptr::null_mut(),
        mWeights: arena.keep(weights.collect()),
        mOffsetMatrix: rows(bone.offset_matrix),
    }
}

fn material(arena: &mut Arena, material: &Material) -> aiMaterial {
    // A text is its length in four bytes, its characters, and a zero byte.
    let mut name = (material.name.len() as u32).to_ne_bytes().to_vec();
    name.extend_from_slice(material.name.as_bytes());
    name.push(0);
    let mut properties = vec![property(arena, "?mat.name", PROPERTY_STRING, name)];
    if material.two_sided {
        let value = 1i32.to_ne_bytes().to_vec();
        properties.push(property(arena, "$mat.twosided", PROPERTY_INTEGER, value));
    }
    let count = properties.len() as u32;
    aiMaterial {
        mProperties: arena.keep_pointers(properties),
        mNumProperties: count,
        mNumAllocated: count,
    }
}

fn property(arena: &mut Arena, key: &str, kind: u32, data: Vec<u8>) -> aiMaterialProperty {
    aiMaterialProperty {
        mKey: aiString::new(key),
        mSemantic: 0,
        mIndex: 0,
        mDataLength: data.len() as u32,
        mType: kind,
        mData: arena.keep(data),
    }
}

fn animation(arena: &mut Arena, animation: &Animation) -> aiAnimation {
    let channels: Vec<_> = animation.channels.iter().map(|it| channel(arena, it)).collect();
    aiAnimation {
        mName: aiString::new(&animation.name),
        mDuration: animation.duration,
        mTicksPerSecond: animation.ticks_per_second,
        mNumChannels: channels.len() as u32,
        mChannels: arena.keep_pointers(channels),
        mNumMeshChannels: 0,
        mMeshChannels: ptr::null_mut(),
        mNumMorphMeshChannels: 0,
        mMorphMeshChannels: ptr::null_mut(),
    }
}

fn channel(arena: &mut Arena, channel: &Channel) -> aiNodeAnim {
    aiNodeAnim {
        mNodeName: aiString::new(&channel.node_name),
        mNumPositionKeys: channel.position_keys.len() as u32,
        mPositionKeys: arena.keep(vector_keys(&channel.position_keys)),
        mNumRotationKeys: channel.rotation_keys.len() as u32,
        mRotationKeys: arena.keep(rotation_keys(&channel.rotation_keys)),
        mNumScalingKeys: channel.scaling_keys.len() as u32,
        mScalingKeys: arena.keep(vector_keys(&channel.scaling_keys)),
        mPreState: 0,
        mPostState: 0,
    }
}

fn vector_keys(keys: &Keys<Vec3>) -> Vec<aiVectorKey> {
    let keys = keys.values.iter().enumerate().map(|(index, value)| aiVectorKey {
        mTime: keys.tick(index),
        mValue: value.to_array(),
    });
    keys.collect()
}

fn rotation_keys(keys: &Keys<Quat>) -> Vec<aiQuatKey> {
    let keys = keys.values.iter().enumerate().map(|(index, value)| aiQuatKey {
        mTime: keys.tick(index),
        mValue: [value.w, value.x, value.y, value.z],
    });
    keys.collect()
}

/// Says which format the scene was read from. Of BVH it says so in the words of Assimp's importer.
fn metadata(arena: &mut Arena, format: Option<Format>) -> *mut aiMetadata {
    let name = match format {
        Some(Format::Bvh) => "BVH Importer (MoCap)",
        Some(other) => other.as_str(),
        None => "",
    };
    let value: *mut aiString = arena.keep_one(aiString::new(name));
    let entry = aiMetadataEntry {
        mType: METADATA_STRING,
        mData: value.cast::<c_void>(),
    };
    let metadata = aiMetadata {
        mNumProperties: 1,
        mKeys: arena.keep_one(aiString::new("SourceAsset_Format")),
        mValues: arena.keep_one(entry),
    };
    arena.keep_one(metadata)
}

fn rows(matrix: Mat4) -> aiMatrix4x4 {
    matrix.transpose().to_cols_array_2d()
}
