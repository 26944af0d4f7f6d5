//! The memory of a scene, counted as in Assimp: its structs and arrays, without the overhead of the allocator.

use crate::abi::{
    AI_FAILURE, AI_SUCCESS, aiAnimation, aiBone, aiCamera, aiLight, aiMaterial, aiMemoryInfo, aiMesh, aiNode,
    aiNodeAnim, aiQuatKey, aiReturn, aiScene, aiTexture, aiVectorKey, aiVertexWeight,
};

/// The memory of the scene of an import.
///
/// # Safety
/// `scene` is NULL or a scene, and `info` the place of the numbers.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetMemoryRequirements(scene: *const aiScene, info: *mut aiMemoryInfo) -> aiReturn {
    if scene.is_null() || info.is_null() {
        return AI_FAILURE;
    }
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { info.write(of(scene)) };
    AI_SUCCESS
}

/// # Safety
/// `scene` is NULL or a whole scene.
pub(crate) unsafe fn of(scene: *const aiScene) -> aiMemoryInfo {
    let mut info = aiMemoryInfo {
        textures: 0,
        materials: 0,
        meshes: 0,
        nodes: 0,
        animations: 0,
        cameras: 0,
        lights: 0,
        total: size_of::<aiScene>() as u32,
    };
    // SAFETY: the pointers of a whole scene match its counts.
    unsafe {
        let Some(scene) = scene.as_ref() else {
            info.total = 0;
            return info;
        };
        for mesh in things(scene.mMeshes, scene.mNumMeshes) {
            info.meshes += self::mesh(mesh);
        }
        for texture in things(scene.mTextures, scene.mNumTextures) {
            let texels = texture.mWidth * texture.mHeight.max(1) * if texture.mHeight == 0 { 1 } else { 4 };
            info.textures += size_of::<aiTexture>() as u32 + texels;
        }
        for animation in things(scene.mAnimations, scene.mNumAnimations) {
            info.animations += size_of::<aiAnimation>() as u32;
            for channel in things(animation.mChannels, animation.mNumChannels) {
                let vectors = channel.mNumPositionKeys + channel.mNumScalingKeys;
                info.animations += (size_of::<aiNodeAnim>()
                    + vectors as usize * size_of::<aiVectorKey>()
                    + channel.mNumRotationKeys as usize * size_of::<aiQuatKey>())
                    as u32;
            }
        }
        for material in things(scene.mMaterials, scene.mNumMaterials) {
            let pointers = material.mNumAllocated as usize * size_of::<*const ()>();
            info.materials += (size_of::<aiMaterial>() + pointers) as u32;
            for property in things(material.mProperties, material.mNumProperties) {
                info.materials += property.mDataLength;
            }
        }
        info.cameras = scene.mNumCameras * size_of::<aiCamera>() as u32;
        info.lights = scene.mNumLights * size_of::<aiLight>() as u32;
        let mut open = vec![scene.mRootNode.cast_const()];
        while let Some(node) = open.pop().and_then(|node| node.as_ref()) {
            let pointers = node.mNumChildren as usize * size_of::<*const ()>();
            info.nodes += (size_of::<aiNode>() + pointers + node.mNumMeshes as usize * size_of::<u32>()) as u32;
            open.extend(things(node.mChildren, node.mNumChildren).map(std::ptr::from_ref));
        }
    }
    let parts = [
        info.textures,
        info.materials,
        info.meshes,
        info.nodes,
        info.animations,
        info.cameras,
        info.lights,
    ];
    info.total += parts.iter().sum::<u32>();
    info
}

/// # Safety
/// The mesh is whole.
unsafe fn mesh(mesh: &aiMesh) -> u32 {
    let vector = 3 * size_of::<f32>();
    let mut of_vertex = 0;
    let tangents = [mesh.mVertices, mesh.mNormals, mesh.mTangents, mesh.mBitangents];
    of_vertex += tangents.iter().filter(|array| !array.is_null()).count() * vector;
    of_vertex += mesh.mColors.iter().filter(|array| !array.is_null()).count() * 4 * size_of::<f32>();
    of_vertex += mesh.mTextureCoords.iter().filter(|array| !array.is_null()).count() * vector;
    let mut bytes = size_of::<aiMesh>() + mesh.mNumVertices as usize * of_vertex;
    // SAFETY: the mesh has this number of bones.
    for bone in unsafe { things(mesh.mBones, mesh.mNumBones) } {
        bytes += size_of::<aiBone>() + bone.mNumWeights as usize * size_of::<aiVertexWeight>();
    }
    // Assimp counts three indices per face, for any face.
    bytes += mesh.mNumFaces as usize * (16 + 3 * size_of::<u32>());
    bytes as u32
}

/// # Safety
/// `first` is NULL or points to `count` pointers, each NULL or to a thing.
unsafe fn things<'a, T: 'a>(first: *const *mut T, count: u32) -> impl Iterator<Item = &'a T> {
    let count = if first.is_null() { 0 } else { count as usize };
    // SAFETY: the caller's promise in `# Safety`.
    (0..count).filter_map(move |index| unsafe { first.add(index).read().as_ref() })
}
