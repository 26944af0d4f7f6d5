//! Converts a scene of `mocap` to Assimp's structs.

use std::ffi::c_void;
use std::ptr;

use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Animation, Bone, Channel, Keys, Material, Mesh, Metadata, Node, Primitive, UpAxis};
use mocap::{Format, Scene};

use crate::abi::{
    METADATA_FLOAT, METADATA_I32, METADATA_STRING, PRIMITIVE_POINT, PRIMITIVE_TRIANGLE, PROPERTY_INTEGER,
    PROPERTY_STRING, ScenePrivate, aiAnimation, aiBone, aiFace, aiMaterial, aiMaterialProperty, aiMatrix4x4, aiMesh,
    aiMetadata, aiMetadataEntry, aiNode, aiNodeAnim, aiQuatKey, aiScene, aiString, aiVector3D, aiVectorKey,
    aiVertexWeight,
};
use crate::{destroy, heap};

/// Converts a scene to Assimp's structs, on the heap of C++. `flags` becomes `aiScene::mFlags`.
pub(crate) fn scene(scene: &Scene, flags: u32) -> *mut aiScene {
    let private = ScenePrivate {
        importer: ptr::null_mut(),
        steps: 0,
        is_copy: false,
    };
    heap::new(aiScene {
        mFlags: flags,
        mRootNode: nodes(scene),
        mNumMeshes: scene.meshes.len() as u32,
        mMeshes: heap::new_pointers(scene.meshes.iter().map(mesh).collect()),
        mNumMaterials: scene.materials.len() as u32,
        mMaterials: heap::new_pointers(scene.materials.iter().map(material).collect()),
        mNumAnimations: scene.animations.len() as u32,
        mAnimations: heap::new_pointers(scene.animations.iter().map(animation).collect()),
        mMetaData: metadata(&scene.metadata),
        mPrivate: heap::new(private),
        ..aiScene::default()
    })
}

/// Destructs and frees a scene.
///
/// # Safety
/// `scene` is NULL or a scene of the C++ heap that is not used any more.
pub(crate) unsafe fn free(scene: *mut aiScene) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe {
        if let Some(it) = scene.as_mut() {
            destroy::scene(it);
            heap::delete(scene);
        }
    }
}

/// The node graph. Returns the root.
fn nodes(scene: &Scene) -> *mut aiNode {
    let mut children = vec![Vec::new(); scene.nodes.len()];
    let nodes: Vec<*mut aiNode> = scene.nodes.iter().map(node).collect();
    for (index, node) in scene.nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            let node = nodes[index];
            children[parent.index()].push(node);
            // SAFETY: the nodes were made above, and nothing else refers to them yet.
            unsafe { (*node).mParent = nodes[parent.index()] };
        }
    }
    for (&node, children) in nodes.iter().zip(&children) {
        // SAFETY: the nodes were made above, and nothing else refers to them yet.
        let node = unsafe { &mut *node };
        node.mNumChildren = children.len() as u32;
        node.mChildren = heap::new_array(children);
    }
    nodes.first().copied().unwrap_or(ptr::null_mut())
}

fn node(node: &Node) -> *mut aiNode {
    let meshes: Vec<u32> = node.meshes.iter().map(|&mesh| mesh as u32).collect();
    heap::new(aiNode {
        mName: aiString::new(&node.name),
        mTransformation: rows(node.transform),
        mNumMeshes: meshes.len() as u32,
        mMeshes: heap::new_array(&meshes),
        ..aiNode::default()
    })
}

fn mesh(mesh: &Mesh) -> aiMesh {
    let faces = mesh.faces().map(|face| aiFace {
        mNumIndices: face.len() as u32,
        mIndices: heap::new_array(face),
    });
    aiMesh {
        mPrimitiveTypes: match mesh.primitive {
            Primitive::Triangles => PRIMITIVE_TRIANGLE,
            Primitive::Points => PRIMITIVE_POINT,
        },
        mNumVertices: mesh.vertices.len() as u32,
        mNumFaces: faces.len() as u32,
        mVertices: vectors(&mesh.vertices),
        mNormals: vectors(&mesh.normals),
        mFaces: heap::new_counted_array(&faces.collect::<Vec<_>>()),
        mNumBones: mesh.bones.len() as u32,
        mBones: heap::new_pointers(mesh.bones.iter().map(bone).collect()),
        mMaterialIndex: mesh.material_index as u32,
        mName: aiString::new(&mesh.name),
        ..aiMesh::default()
    }
}

fn vectors(vectors: &[Vec3]) -> *mut aiVector3D {
    heap::new_array(&vectors.iter().map(Vec3::to_array).collect::<Vec<_>>())
}

fn bone(bone: &Bone) -> aiBone {
    let weights = bone.weights.iter().map(|weight| aiVertexWeight {
        mVertexId: weight.vertex_id,
        mWeight: weight.weight,
    });
    aiBone {
        mName: aiString::new(&bone.name),
        mNumWeights: bone.weights.len() as u32,
        mArmature: ptr::null_mut(),
        mNode: ptr::null_mut(),
        mWeights: heap::new_array(&weights.collect::<Vec<_>>()),
        mOffsetMatrix: rows(bone.offset_matrix),
    }
}

fn material(material: &Material) -> aiMaterial {
    // A string is its length in four bytes, its characters, and a zero byte.
    let mut name = (material.name.len() as u32).to_ne_bytes().to_vec();
    name.extend_from_slice(material.name.as_bytes());
    name.push(0);
    let mut properties = vec![property("?mat.name", PROPERTY_STRING, &name)];
    if material.two_sided {
        properties.push(property("$mat.twosided", PROPERTY_INTEGER, &1i32.to_ne_bytes()));
    }
    // As in C++, the array has spare capacity.
    const ROOM: usize = 5;
    let count = properties.len() as u32;
    let mut pointers: Vec<_> = properties.into_iter().map(heap::new).collect();
    pointers.resize(ROOM, ptr::null_mut());
    aiMaterial {
        mProperties: heap::new_array(&pointers),
        mNumProperties: count,
        mNumAllocated: ROOM as u32,
    }
}

fn property(key: &str, kind: u32, data: &[u8]) -> aiMaterialProperty {
    aiMaterialProperty {
        mKey: aiString::new(key),
        mSemantic: 0,
        mIndex: 0,
        mDataLength: data.len() as u32,
        mType: kind,
        mData: heap::new_array(data),
    }
}

fn animation(animation: &Animation) -> aiAnimation {
    aiAnimation {
        mName: aiString::new(&animation.name),
        mDuration: animation.duration,
        mTicksPerSecond: animation.ticks_per_second,
        mNumChannels: animation.channels.len() as u32,
        mChannels: heap::new_pointers(animation.channels.iter().map(channel).collect()),
        mNumMeshChannels: 0,
        mMeshChannels: ptr::null_mut(),
        mNumMorphMeshChannels: 0,
        mMorphMeshChannels: ptr::null_mut(),
    }
}

fn channel(channel: &Channel) -> aiNodeAnim {
    aiNodeAnim {
        mNodeName: aiString::new(&channel.node_name),
        mNumPositionKeys: channel.position_keys.len() as u32,
        mPositionKeys: heap::new_array(&vector_keys(&channel.position_keys)),
        mNumRotationKeys: channel.rotation_keys.len() as u32,
        mRotationKeys: heap::new_array(&rotation_keys(&channel.rotation_keys)),
        mNumScalingKeys: channel.scaling_keys.len() as u32,
        mScalingKeys: heap::new_array(&vector_keys(&channel.scaling_keys)),
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

/// Metadata with the format from which the scene was read, and for FBX the unit in centimetres and the up axis. For BVH
/// and FBX, the texts are those of Assimp's importers.
fn metadata(metadata: &Metadata) -> *mut aiMetadata {
    fn entry<T: Copy>(kind: i32, value: T) -> aiMetadataEntry {
        aiMetadataEntry {
            mType: kind,
            mData: heap::new(value).cast::<c_void>(),
        }
    }
    let format = match metadata.format {
        Some(Format::Bvh) => "BVH Importer (MoCap)",
        Some(Format::Fbx) => "Autodesk FBX Importer",
        Some(other) => other.as_str(),
        None => "",
    };
    let mut entries = vec![("SourceAsset_Format", entry(METADATA_STRING, aiString::new(format)))];
    if metadata.format == Some(Format::Fbx) {
        let up = metadata.up.map(|up| match up {
            UpAxis::Y => (1, 1),
            UpAxis::Z => (2, 1),
            UpAxis::NegY => (1, -1),
            UpAxis::NegZ => (2, -1),
        });
        let unit = metadata.metres_per_unit.map(|metres| (metres * 100.0) as f32);
        if let Some((axis, sign)) = up {
            entries.push(("UpAxis", entry(METADATA_I32, axis)));
            entries.push(("UpAxisSign", entry(METADATA_I32, sign)));
        }
        entries.extend(unit.map(|unit| ("UnitScaleFactor", entry(METADATA_FLOAT, unit))));
    }
    let keys: Vec<aiString> = entries.iter().map(|(key, _)| aiString::new(key)).collect();
    let values: Vec<aiMetadataEntry> = entries.into_iter().map(|(_, value)| value).collect();
    heap::new(aiMetadata {
        mNumProperties: values.len() as u32,
        mKeys: heap::new_array(&keys),
        mValues: heap::new_array(&values),
    })
}

fn rows(matrix: Mat4) -> aiMatrix4x4 {
    matrix.transpose().to_cols_array_2d()
}
