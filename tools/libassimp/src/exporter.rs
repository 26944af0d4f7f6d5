//! `Assimp::Exporter`: the class of the system's Assimp. Without that library, the class lists the formats of the C
//! functions, and writes nothing.

use std::ffi::{c_char, c_void};
use std::ptr;

use crate::abi::{AI_FAILURE, aiExportDataBlob, aiExportFormatDesc, aiReturn, aiScene};
use crate::export::{aiGetExportFormatCount, aiGetExportFormatDescription};
use crate::system::system_functions;

system_functions! {
    /// `Exporter()`
    fn _ZN6Assimp8ExporterC1Ev(this: *mut *mut c_void) -> () | {
        // SAFETY: the caller passes a valid pointer to an exporter, which is one pointer.
        unsafe { this.write(ptr::null_mut()) }
    }

    /// `Exporter()`
    fn _ZN6Assimp8ExporterC2Ev(this: *mut *mut c_void) -> () | {
        // SAFETY: the caller passes a valid pointer to an exporter, which is one pointer.
        unsafe { this.write(ptr::null_mut()) }
    }

    /// `~Exporter()`
    fn _ZN6Assimp8ExporterD1Ev(this: *mut c_void) -> () | ()

    /// `~Exporter()`
    fn _ZN6Assimp8ExporterD2Ev(this: *mut c_void) -> () | ()

    /// `size_t GetExportFormatCount() const`
    fn _ZNK6Assimp8Exporter20GetExportFormatCountEv(this: *const c_void) -> usize | aiGetExportFormatCount()

    /// `const aiExportFormatDesc *GetExportFormatDescription(size_t index) const`
    fn _ZNK6Assimp8Exporter26GetExportFormatDescriptionEm(
        this: *const c_void, index: usize
    ) -> *const aiExportFormatDesc | aiGetExportFormatDescription(index)

    /// `aiReturn Export(const aiScene *, const char *id, const char *path, unsigned flags, const ExportProperties *)`
    fn _ZN6Assimp8Exporter6ExportEPK7aiScenePKcS5_jPKNS_16ExportPropertiesE(
        this: *mut c_void, scene: *const aiScene, id: *const c_char, path: *const c_char, flags: u32,
        properties: *const c_void
    ) -> aiReturn | AI_FAILURE

    /// `const aiExportDataBlob *ExportToBlob(const aiScene *, const char *id, unsigned flags, const ExportProperties
    /// *)`
    fn _ZN6Assimp8Exporter12ExportToBlobEPK7aiScenePKcjPKNS_16ExportPropertiesE(
        this: *mut c_void, scene: *const aiScene, id: *const c_char, flags: u32, properties: *const c_void
    ) -> *const aiExportDataBlob | ptr::null()

    /// `const char *GetErrorString() const`
    fn _ZNK6Assimp8Exporter14GetErrorStringEv(this: *const c_void) -> *const c_char | {
        c"Assimp::Exporter needs the system's Assimp, which was not found; aiExportScene writes gltf2 and glb2".as_ptr()
    }

    /// `const aiExportDataBlob *GetBlob() const`
    fn _ZNK6Assimp8Exporter7GetBlobEv(this: *const c_void) -> *const aiExportDataBlob | ptr::null()

    /// `const aiExportDataBlob *GetOrphanedBlob() const`
    fn _ZNK6Assimp8Exporter15GetOrphanedBlobEv(this: *const c_void) -> *const aiExportDataBlob | ptr::null()

    /// `void FreeBlob()`
    fn _ZN6Assimp8Exporter8FreeBlobEv(this: *mut c_void) -> () | ()
}
