//! The structs of Assimp 5.2.5 with their memory layout and their names. A test compares each with Assimp's headers.

// The names are Assimp's.
#![allow(non_camel_case_types)]

use std::ffi::{c_char, c_void};
use std::ptr;

/// In row-major order, for column vectors: the first three rows end with the translation.
pub(crate) type aiMatrix4x4 = [[f32; 4]; 4];
pub(crate) type aiMatrix3x3 = [[f32; 3]; 3];
pub(crate) type aiVector2D = [f32; 2];
pub(crate) type aiVector3D = [f32; 3];
/// w, x, y, z.
pub(crate) type aiQuaternion = [f32; 4];
pub(crate) type aiColor4D = [f32; 4];

/// Declares the structs, and the sizes and field offsets for the test.
macro_rules! structs {
    ($($(#[$attribute:meta])* $name:ident { $($field:ident: $type:ty,)* })*) => {
        $(
            $(#[$attribute])*
            #[repr(C)]
            #[derive(Clone, Copy)]
            pub(crate) struct $name {
                $(pub(crate) $field: $type,)*
            }
        )*

        #[cfg(test)]
        const LAYOUT: &[(&str, usize, &[(&str, usize)])] = &[
            $((stringify!($name), size_of::<$name>(), &[
                $((stringify!($field), std::mem::offset_of!($name, $field)),)*
            ]),)*
        ];
    };
}

structs! {
    /// A string of at most 1023 bytes, with a zero byte at its end.
    aiString {
        length: u32,
        data: [u8; MAXLEN],
    }

    aiScene {
        mFlags: u32,
        mRootNode: *mut aiNode,
        mNumMeshes: u32,
        mMeshes: *mut *mut aiMesh,
        mNumMaterials: u32,
        mMaterials: *mut *mut aiMaterial,
        mNumAnimations: u32,
        mAnimations: *mut *mut aiAnimation,
        mNumTextures: u32,
        mTextures: *mut *mut aiTexture,
        mNumLights: u32,
        mLights: *mut *mut aiLight,
        mNumCameras: u32,
        mCameras: *mut *mut aiCamera,
        mMetaData: *mut aiMetadata,
        mName: aiString,
        mNumSkeletons: u32,
        mSkeletons: *mut *mut aiSkeleton,
        mPrivate: *mut ScenePrivate,
    }

    aiNode {
        mName: aiString,
        mTransformation: aiMatrix4x4,
        mParent: *mut aiNode,
        mNumChildren: u32,
        mChildren: *mut *mut aiNode,
        mNumMeshes: u32,
        mMeshes: *mut u32,
        mMetaData: *mut aiMetadata,
    }

    aiMesh {
        mPrimitiveTypes: u32,
        mNumVertices: u32,
        mNumFaces: u32,
        mVertices: *mut aiVector3D,
        mNormals: *mut aiVector3D,
        mTangents: *mut aiVector3D,
        mBitangents: *mut aiVector3D,
        mColors: [*mut aiColor4D; 8],
        mTextureCoords: [*mut aiVector3D; 8],
        mNumUVComponents: [u32; 8],
        mFaces: *mut aiFace,
        mNumBones: u32,
        mBones: *mut *mut aiBone,
        mMaterialIndex: u32,
        mName: aiString,
        mNumAnimMeshes: u32,
        mAnimMeshes: *mut *mut aiAnimMesh,
        mMethod: u32,
        mAABB: [aiVector3D; 2],
        mTextureCoordsNames: *mut *mut aiString,
    }

    aiFace {
        mNumIndices: u32,
        mIndices: *mut u32,
    }

    aiBone {
        mName: aiString,
        mNumWeights: u32,
        mArmature: *mut aiNode,
        mNode: *mut aiNode,
        mWeights: *mut aiVertexWeight,
        mOffsetMatrix: aiMatrix4x4,
    }

    aiVertexWeight {
        mVertexId: u32,
        mWeight: f32,
    }

    aiMaterial {
        mProperties: *mut *mut aiMaterialProperty,
        mNumProperties: u32,
        mNumAllocated: u32,
    }

    aiMaterialProperty {
        mKey: aiString,
        mSemantic: u32,
        mIndex: u32,
        mDataLength: u32,
        mType: u32,
        mData: *mut u8,
    }

    aiAnimation {
        mName: aiString,
        mDuration: f64,
        mTicksPerSecond: f64,
        mNumChannels: u32,
        mChannels: *mut *mut aiNodeAnim,
        mNumMeshChannels: u32,
        mMeshChannels: *mut *mut aiMeshAnim,
        mNumMorphMeshChannels: u32,
        mMorphMeshChannels: *mut *mut aiMeshMorphAnim,
    }

    aiNodeAnim {
        mNodeName: aiString,
        mNumPositionKeys: u32,
        mPositionKeys: *mut aiVectorKey,
        mNumRotationKeys: u32,
        mRotationKeys: *mut aiQuatKey,
        mNumScalingKeys: u32,
        mScalingKeys: *mut aiVectorKey,
        mPreState: u32,
        mPostState: u32,
    }

    aiVectorKey {
        mTime: f64,
        mValue: aiVector3D,
    }

    aiQuatKey {
        mTime: f64,
        mValue: aiQuaternion,
    }

    aiMetadata {
        mNumProperties: u32,
        mKeys: *mut aiString,
        mValues: *mut aiMetadataEntry,
    }

    aiMetadataEntry {
        mType: i32,
        mData: *mut c_void,
    }

    aiTexture {
        mWidth: u32,
        mHeight: u32,
        achFormatHint: [u8; 9],
        pcData: *mut u32,
        mFilename: aiString,
    }

    aiLight {
        mName: aiString,
        mType: u32,
        mPosition: aiVector3D,
        mDirection: aiVector3D,
        mUp: aiVector3D,
        mAttenuationConstant: f32,
        mAttenuationLinear: f32,
        mAttenuationQuadratic: f32,
        mColorDiffuse: [f32; 3],
        mColorSpecular: [f32; 3],
        mColorAmbient: [f32; 3],
        mAngleInnerCone: f32,
        mAngleOuterCone: f32,
        mSize: aiVector2D,
    }

    aiCamera {
        mName: aiString,
        mPosition: aiVector3D,
        mUp: aiVector3D,
        mLookAt: aiVector3D,
        mHorizontalFOV: f32,
        mClipPlaneNear: f32,
        mClipPlaneFar: f32,
        mAspect: f32,
        mOrthographicWidth: f32,
    }

    aiAnimMesh {
        mName: aiString,
        mVertices: *mut aiVector3D,
        mNormals: *mut aiVector3D,
        mTangents: *mut aiVector3D,
        mBitangents: *mut aiVector3D,
        mColors: [*mut aiColor4D; 8],
        mTextureCoords: [*mut aiVector3D; 8],
        mNumVertices: u32,
        mWeight: f32,
    }

    aiMeshAnim {
        mName: aiString,
        mNumKeys: u32,
        mKeys: *mut aiMeshKey,
    }

    aiMeshKey {
        mTime: f64,
        mValue: u32,
    }

    aiMeshMorphAnim {
        mName: aiString,
        mNumKeys: u32,
        mKeys: *mut aiMeshMorphKey,
    }

    aiMeshMorphKey {
        mTime: f64,
        mValues: *mut u32,
        mWeights: *mut f64,
        mNumValuesAndWeights: u32,
    }

    aiSkeleton {
        mName: aiString,
        mNumBones: u32,
        mBones: *mut *mut c_void,
    }

    aiUVTransform {
        mTranslation: aiVector2D,
        mScaling: aiVector2D,
        mRotation: f32,
    }

    aiMemoryInfo {
        textures: u32,
        materials: u32,
        meshes: u32,
        nodes: u32,
        animations: u32,
        cameras: u32,
        lights: u32,
        total: u32,
    }

    aiImporterDesc {
        mName: *const c_char,
        mAuthor: *const c_char,
        mMaintainer: *const c_char,
        mComments: *const c_char,
        mFlags: u32,
        mMinMajor: u32,
        mMinMinor: u32,
        mMaxMajor: u32,
        mMaxMinor: u32,
        mFileExtensions: *const c_char,
    }

    aiFileIO {
        OpenProc: Option<unsafe extern "C" fn(*mut aiFileIO, *const c_char, *const c_char) -> *mut aiFile>,
        CloseProc: Option<unsafe extern "C" fn(*mut aiFileIO, *mut aiFile)>,
        UserData: *mut c_char,
    }

    aiFile {
        ReadProc: Option<unsafe extern "C" fn(*mut aiFile, *mut c_char, usize, usize) -> usize>,
        WriteProc: *const c_void,
        TellProc: *const c_void,
        FileSizeProc: Option<unsafe extern "C" fn(*mut aiFile) -> usize>,
        SeekProc: *const c_void,
        FlushProc: *const c_void,
        UserData: *mut c_char,
    }

    aiExportDataBlob {
        size: usize,
        data: *mut c_void,
        name: aiString,
        next: *mut aiExportDataBlob,
    }

    aiExportFormatDesc {
        id: *const c_char,
        description: *const c_char,
        fileExtension: *const c_char,
    }

    aiLogStream {
        callback: Option<unsafe extern "C" fn(*const c_char, *mut c_char)>,
        user: *mut c_char,
    }
}

/// The target of `aiScene::mPrivate`. No header declares it; Assimp 5.2.5 allocates and reads these 16 bytes.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct ScenePrivate {
    /// The `Assimp::Importer` that `aiReleaseImport` destroys; NULL for a scene without an importer.
    pub(crate) importer: *mut c_void,
    /// The steps that were run on the scene.
    pub(crate) steps: u32,
    /// Whether the scene is a copy.
    pub(crate) is_copy: bool,
}

/// Bytes of an `aiString`, its zero byte included.
pub(crate) const MAXLEN: usize = 1024;

/// `aiReturn`.
pub(crate) type aiReturn = i32;
pub(crate) const AI_SUCCESS: aiReturn = 0;
pub(crate) const AI_FAILURE: aiReturn = -1;

/// `aiPrimitiveType`.
pub(crate) const PRIMITIVE_POINT: u32 = 1;
pub(crate) const PRIMITIVE_TRIANGLE: u32 = 4;

/// `aiPropertyTypeInfo`.
pub(crate) const PROPERTY_FLOAT: u32 = 1;
pub(crate) const PROPERTY_DOUBLE: u32 = 2;
pub(crate) const PROPERTY_STRING: u32 = 3;
pub(crate) const PROPERTY_INTEGER: u32 = 4;

/// `aiMetadataType`: numbers, an `aiString`, and metadata within metadata.
pub(crate) const METADATA_I32: i32 = 1;
pub(crate) const METADATA_FLOAT: i32 = 3;
pub(crate) const METADATA_STRING: i32 = 5;
pub(crate) const METADATA_METADATA: i32 = 7;

/// Flags of `aiScene::mFlags`: the scene lacks parts of the file; faces share vertices.
pub(crate) const SCENE_INCOMPLETE: u32 = 1;
pub(crate) const SCENE_NON_VERBOSE: u32 = 8;

impl aiString {
    /// A string, cut to Assimp's length limit.
    pub(crate) fn new(text: &str) -> Self {
        Self::from_bytes(text.as_bytes())
    }

    /// A string of bytes, cut to Assimp's length limit.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Self {
        let bytes = &bytes[..bytes.len().min(MAXLEN - 1)];
        let mut data = [0; MAXLEN];
        data[..bytes.len()].copy_from_slice(bytes);
        Self {
            length: bytes.len() as u32,
            data,
        }
    }

    /// The text up to its zero byte; invalid UTF-8 is replaced.
    pub(crate) fn to_text(self) -> String {
        let length = self.data.iter().position(|&byte| byte == 0).unwrap_or(MAXLEN);
        String::from_utf8_lossy(&self.data[..length]).into_owned()
    }
}

impl Default for aiNode {
    fn default() -> Self {
        Self {
            mName: aiString::new(""),
            mTransformation: [
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ],
            mParent: ptr::null_mut(),
            mNumChildren: 0,
            mChildren: ptr::null_mut(),
            mNumMeshes: 0,
            mMeshes: ptr::null_mut(),
            mMetaData: ptr::null_mut(),
        }
    }
}

impl Default for aiMesh {
    fn default() -> Self {
        Self {
            mPrimitiveTypes: 0,
            mNumVertices: 0,
            mNumFaces: 0,
            mVertices: ptr::null_mut(),
            mNormals: ptr::null_mut(),
            mTangents: ptr::null_mut(),
            mBitangents: ptr::null_mut(),
            mColors: [ptr::null_mut(); 8],
            mTextureCoords: [ptr::null_mut(); 8],
            mNumUVComponents: [0; 8],
            mFaces: ptr::null_mut(),
            mNumBones: 0,
            mBones: ptr::null_mut(),
            mMaterialIndex: 0,
            mName: aiString::new(""),
            mNumAnimMeshes: 0,
            mAnimMeshes: ptr::null_mut(),
            mMethod: 0,
            mAABB: [[0.0; 3]; 2],
            mTextureCoordsNames: ptr::null_mut(),
        }
    }
}

impl Default for aiScene {
    fn default() -> Self {
        Self {
            mFlags: 0,
            mRootNode: ptr::null_mut(),
            mNumMeshes: 0,
            mMeshes: ptr::null_mut(),
            mNumMaterials: 0,
            mMaterials: ptr::null_mut(),
            mNumAnimations: 0,
            mAnimations: ptr::null_mut(),
            mNumTextures: 0,
            mTextures: ptr::null_mut(),
            mNumLights: 0,
            mLights: ptr::null_mut(),
            mNumCameras: 0,
            mCameras: ptr::null_mut(),
            mMetaData: ptr::null_mut(),
            mName: aiString::new(""),
            mNumSkeletons: 0,
            mSkeletons: ptr::null_mut(),
            mPrivate: ptr::null_mut(),
        }
    }
}

#[cfg(test)]
mod tests;
