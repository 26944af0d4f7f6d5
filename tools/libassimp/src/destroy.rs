//! The destructors of Assimp's structs: they free everything that a struct owns, but not the struct.
//!
//! As in C++, the destructors follow the scene's pointers, because a program may have added its own data.

use crate::abi::{
    METADATA_METADATA, aiAnimMesh, aiAnimation, aiBone, aiExportDataBlob, aiMaterial, aiMaterialProperty, aiMesh,
    aiMeshAnim, aiMeshMorphAnim, aiMetadata, aiNode, aiNodeAnim, aiScene, aiSkeleton, aiTexture,
};
use crate::heap::{delete, delete_array, delete_counted_array};

/// `~aiScene()`
///
/// # Safety
/// All that the scene points to is NULL or from the C++ heap, belongs to the scene alone, and is not used any more. The
/// same holds for the arguments of the functions below.
pub(crate) unsafe fn scene(scene: &mut aiScene) {
    // SAFETY: the caller promises it in `# Safety` for all of these.
    unsafe {
        if !scene.mRootNode.is_null() {
            node(&mut *scene.mRootNode);
            delete(scene.mRootNode);
        }
        pointers(scene.mMeshes, scene.mNumMeshes, |it| mesh(it));
        pointers(scene.mMaterials, scene.mNumMaterials, |it| material(it));
        pointers(scene.mAnimations, scene.mNumAnimations, |it| animation(it));
        pointers(scene.mTextures, scene.mNumTextures, |it: &mut aiTexture| {
            delete_array(it.pcData);
        });
        pointers(scene.mLights, scene.mNumLights, |_| {});
        pointers(scene.mCameras, scene.mNumCameras, |_| {});
        pointers(scene.mSkeletons, scene.mNumSkeletons, |it: &mut aiSkeleton| {
            delete_array(it.mBones);
        });
        metadata(scene.mMetaData);
        delete(scene.mPrivate);
    }
}

/// `~aiNode()`: the node's own arrays, and all nodes below it.
///
/// # Safety
/// As [`scene`].
pub(crate) unsafe fn node(node: &mut aiNode) {
    // A graph may be too deep for recursive calls.
    // SAFETY: the caller promises it in `# Safety`.
    let mut open = unsafe { take_children(node) };
    while let Some(child) = open.pop() {
        // SAFETY: a child is NULL or a node of its parent's alone.
        unsafe {
            if let Some(node) = child.as_mut() {
                open.extend(take_children(node));
                delete(child);
            }
        }
    }
}

/// Frees a node's arrays; the caller then owns its children.
///
/// # Safety
/// As [`scene`].
unsafe fn take_children(node: &mut aiNode) -> Vec<*mut aiNode> {
    // SAFETY: the node has this number of pointers to children, and owns its arrays.
    unsafe {
        let children = match node.mChildren.is_null() {
            true => Vec::new(),
            false => std::slice::from_raw_parts(node.mChildren, node.mNumChildren as usize).to_vec(),
        };
        delete_array(node.mChildren);
        delete_array(node.mMeshes);
        metadata(node.mMetaData);
        children
    }
}

/// # Safety
/// As [`scene`].
unsafe fn mesh(mesh: &mut aiMesh) {
    // SAFETY: the caller promises it in `# Safety`.
    unsafe {
        for array in [mesh.mVertices, mesh.mNormals, mesh.mTangents, mesh.mBitangents] {
            delete_array(array);
        }
        mesh.mColors.into_iter().for_each(|array| delete_array(array));
        mesh.mTextureCoords.into_iter().for_each(|array| delete_array(array));
        pointers(mesh.mTextureCoordsNames, mesh.mTextureCoords.len() as u32, |_| {});
        pointers(mesh.mBones, mesh.mNumBones, |it: &mut aiBone| delete_array(it.mWeights));
        pointers(mesh.mAnimMeshes, mesh.mNumAnimMeshes, |it| anim_mesh(it));
        delete_counted_array(mesh.mFaces, |face| delete_array(face.mIndices));
    }
}

/// # Safety
/// As [`scene`].
unsafe fn anim_mesh(mesh: &mut aiAnimMesh) {
    // SAFETY: the caller promises it in `# Safety`.
    unsafe {
        for array in [mesh.mVertices, mesh.mNormals, mesh.mTangents, mesh.mBitangents] {
            delete_array(array);
        }
        mesh.mColors.into_iter().for_each(|array| delete_array(array));
        mesh.mTextureCoords.into_iter().for_each(|array| delete_array(array));
    }
}

/// `~aiMaterial()`
///
/// # Safety
/// As [`scene`].
pub(crate) unsafe fn material(material: &mut aiMaterial) {
    // SAFETY: the caller promises it in `# Safety`.
    unsafe {
        pointers(material.mProperties, material.mNumProperties, |it| {
            material_property(it);
        });
    };
}

/// `~aiMaterialProperty()`
///
/// # Safety
/// As [`scene`].
pub(crate) unsafe fn material_property(property: &mut aiMaterialProperty) {
    // SAFETY: the caller promises it in `# Safety`.
    unsafe { delete_array(property.mData) };
}

/// # Safety
/// As [`scene`].
unsafe fn animation(animation: &mut aiAnimation) {
    // SAFETY: the caller promises it in `# Safety`.
    unsafe {
        pointers(animation.mChannels, animation.mNumChannels, |it: &mut aiNodeAnim| {
            delete_array(it.mPositionKeys);
            delete_array(it.mRotationKeys);
            delete_array(it.mScalingKeys);
        });
        let (meshes, morphs) = (animation.mMeshChannels, animation.mMorphMeshChannels);
        pointers(meshes, animation.mNumMeshChannels, |it: &mut aiMeshAnim| {
            delete_array(it.mKeys);
        });
        pointers(morphs, animation.mNumMorphMeshChannels, |it: &mut aiMeshMorphAnim| {
            delete_counted_array(it.mKeys, |key| {
                delete_array(key.mValues);
                delete_array(key.mWeights);
            });
        });
    }
}

/// `delete` of metadata.
///
/// # Safety
/// As [`scene`]; NULL is allowed.
unsafe fn metadata(metadata: *mut aiMetadata) {
    // SAFETY: the caller promises it in `# Safety`; each value has the type beside it.
    unsafe {
        let Some(it) = metadata.as_ref() else { return };
        if !it.mValues.is_null() {
            for entry in std::slice::from_raw_parts(it.mValues, it.mNumProperties as usize) {
                match entry.mType {
                    METADATA_METADATA => self::metadata(entry.mData.cast()),
                    _ => delete(entry.mData),
                }
            }
        }
        delete_array(it.mKeys);
        delete_array(it.mValues);
        delete(metadata);
    }
}

/// `delete` of a blob and all following blobs.
///
/// # Safety
/// As [`scene`]; NULL is allowed.
pub(crate) unsafe fn blobs(first: *mut aiExportDataBlob) {
    let mut next = first;
    // SAFETY: the caller promises it in `# Safety`.
    unsafe {
        while let Some(blob) = next.as_ref() {
            let this = std::mem::replace(&mut next, blob.next);
            delete_array(blob.data);
            delete(this);
        }
    }
}

/// `delete`s the targets of `count` pointers, then the pointers.
///
/// # Safety
/// As [`scene`].
unsafe fn pointers<T>(first: *mut *mut T, count: u32, destroy: impl Fn(&mut T)) {
    if first.is_null() {
        return;
    }
    // SAFETY: there are `count` pointers, each NULL or to a value that only the array owns.
    unsafe {
        for &pointer in std::slice::from_raw_parts(first, count as usize) {
            if let Some(it) = pointer.as_mut() {
                destroy(it);
                delete(pointer);
            }
        }
        delete_array(first);
    }
}
