//! The structs of Assimp 5.2.5 as they lie in memory, with its names. A test holds each against Assimp's headers.

// The names are Assimp's.
#![allow(non_camel_case_types)]

use std::ffi::{c_char, c_void};
use std::ptr;

/// Row after row, for column vectors: the translation stands at the end of the first three rows.
pub(crate) type aiMatrix4x4 = [[f32; 4]; 4];
pub(crate) type aiMatrix3x3 = [[f32; 3]; 3];
pub(crate) type aiVector3D = [f32; 3];
/// w, x, y, z.
pub(crate) type aiQuaternion = [f32; 4];
pub(crate) type aiColor4D = [f32; 4];

/// Declares the structs, and for the test their sizes and the places of their fields.
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
    /// A text of at most 1023 bytes, with a zero byte at its end.
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
        mTextures: *mut c_void,
        mNumLights: u32,
        mLights: *mut c_void,
        mNumCameras: u32,
        mCameras: *mut c_void,
        mMetaData: *mut aiMetadata,
        mName: aiString,
        mNumSkeletons: u32,
        mSkeletons: *mut c_void,
        mPrivate: *mut c_void,
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
        mAnimMeshes: *mut c_void,
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
        mMeshChannels: *mut c_void,
        mNumMorphMeshChannels: u32,
        mMorphMeshChannels: *mut c_void,
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

/// `aiMetadataType`: an `aiString`.
pub(crate) const METADATA_STRING: i32 = 5;

impl aiString {
    /// A text, cut where Assimp cuts it.
    pub(crate) fn new(text: &str) -> Self {
        let bytes = &text.as_bytes()[..text.len().min(MAXLEN - 1)];
        let mut data = [0; MAXLEN];
        data[..bytes.len()].copy_from_slice(bytes);
        Self {
            length: bytes.len() as u32,
            data,
        }
    }

    /// The text up to its zero byte; what is not UTF-8 is replaced.
    pub(crate) fn to_text(self) -> String {
        let length = self.data.iter().position(|&byte| byte == 0).unwrap_or(MAXLEN);
        String::from_utf8_lossy(&self.data[..length]).into_owned()
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
mod tests {
    use std::fmt::Write as _;
    use std::io::Write as _;
    use std::process::{Command, Stdio};

    use super::*;

    /// Lets the C++ compiler compare every size and every offset with those of the headers that Debian ships.
    #[test]
    fn layouts_are_those_of_the_headers() {
        let mut source = String::from(
            "#include <cstddef>\n#include <assimp/cimport.h>\n#include <assimp/cexport.h>\n#include <assimp/scene.h>\n",
        );
        for (name, size, fields) in LAYOUT {
            writeln!(source, "static_assert(sizeof({name}) == {size}, \"{name}\");").unwrap();
            for (field, offset) in *fields {
                writeln!(
                    source,
                    "static_assert(offsetof({name}, {field}) == {offset}, \"{name}::{field}\");"
                )
                .unwrap();
            }
        }
        for (name, size) in [
            ("aiMatrix4x4", size_of::<aiMatrix4x4>()),
            ("aiMatrix3x3", size_of::<aiMatrix3x3>()),
            ("aiVector3D", size_of::<aiVector3D>()),
            ("aiQuaternion", size_of::<aiQuaternion>()),
            ("aiColor4D", size_of::<aiColor4D>()),
            ("aiAABB", size_of::<[aiVector3D; 2]>()),
            ("aiReturn", size_of::<aiReturn>()),
        ] {
            writeln!(source, "static_assert(sizeof({name}) == {size}, \"{name}\");").unwrap();
        }

        let mut compiler = Command::new("c++")
            .args(["-std=c++17", "-Wno-invalid-offsetof", "-fsyntax-only", "-x", "c++", "-"])
            .stdin(Stdio::piped())
            .spawn()
            .unwrap();
        compiler.stdin.take().unwrap().write_all(source.as_bytes()).unwrap();
        assert!(compiler.wait().unwrap().success(), "{source}");
    }

    #[test]
    fn a_long_text_is_cut_where_assimp_cuts_it() {
        let text = aiString::new(&"a".repeat(2000));
        assert_eq!((text.length, text.data[1022], text.data[1023]), (1023, b'a', 0));
        assert_eq!(text.to_text().len(), 1023);
    }
}
