//! The functions of the system's Assimp that this library calls by itself, each with its symbol and its signature. Only
//! this file joins symbols and signatures, so that a look-up is safe without other checks.

use std::ffi::{CStr, c_char, c_void};

use super::function;
use crate::abi::{aiExportDataBlob, aiExportFormatDesc, aiFileIO, aiMatrix4x4, aiReturn, aiScene, aiString};
use crate::cpp_string::StdString;

/// An object of a class: the first argument of its methods.
type This = *mut c_void;

/// A property store of C.
type Store = *mut c_void;

/// Defines a look-up for each function: it returns the function's pointer, or the reason why there is none. The caller
/// must meet the conditions of the function's declaration in the headers.
macro_rules! calls {
    ($($name:ident = $symbol:ident($($argument:ty),*) $(-> $result:ty)?;)*) => {
        $(
            #[doc = concat!("`", stringify!($symbol), "`")]
            pub(crate) fn $name() -> Result<unsafe extern "C" fn($($argument),*) $(-> $result)?, String> {
                const SYMBOL: &str = concat!(stringify!($symbol), "\0");
                let symbol = CStr::from_bytes_with_nul(SYMBOL.as_bytes()).unwrap_or_default();
                // SAFETY: the table states the signature that the headers of this version declare.
                unsafe { function(symbol) }
            }
        )*
    };
}

calls! {
    error_text = aiGetErrorString() -> *const c_char;
    is_extension_supported = aiIsExtensionSupported(*const c_char) -> i32;
    extension_list = aiGetExtensionList(*mut aiString);
    import_file = aiImportFileExWithProperties(*const c_char, u32, *mut aiFileIO, Store) -> *mut aiScene;

    export_format_count = aiGetExportFormatCount() -> usize;
    export_format_description = aiGetExportFormatDescription(usize) -> *const aiExportFormatDesc;
    release_export_format_description = aiReleaseExportFormatDescription(*const aiExportFormatDesc);
    export_scene = aiExportSceneEx(*const aiScene, *const c_char, *const c_char, *mut aiFileIO, u32) -> aiReturn;
    export_scene_to_blob = aiExportSceneToBlob(*const aiScene, *const c_char, u32) -> *const aiExportDataBlob;

    create_property_store = aiCreatePropertyStore() -> Store;
    release_property_store = aiReleasePropertyStore(Store);
    set_stored_integer = aiSetImportPropertyInteger(Store, *const c_char, i32);
    set_stored_float = aiSetImportPropertyFloat(Store, *const c_char, f32);
    set_stored_string = aiSetImportPropertyString(Store, *const c_char, *const aiString);
    set_stored_matrix = aiSetImportPropertyMatrix(Store, *const c_char, *const aiMatrix4x4);

    logger = _ZN6Assimp13DefaultLogger3getEv() -> *mut c_void;

    construct_importer = _ZN6Assimp8ImporterC1Ev(This);
    destruct_importer = _ZN6Assimp8ImporterD1Ev(This);
    read_file = _ZN6Assimp8Importer8ReadFileEPKcj(This, *const c_char, u32) -> *const aiScene;
    read_memory = _ZN6Assimp8Importer18ReadFileFromMemoryEPKvmjPKc(
        This, *const u8, usize, u32, *const c_char
    ) -> *const aiScene;
    scene = _ZNK6Assimp8Importer8GetSceneEv(This) -> *const aiScene;
    orphaned_scene = _ZN6Assimp8Importer16GetOrphanedSceneEv(This) -> *mut aiScene;
    importer_error_text = _ZNK6Assimp8Importer14GetErrorStringEv(This) -> *const c_char;
    apply_process = _ZN6Assimp8Importer29ApplyCustomizedPostProcessingEPNS_11BaseProcessEb(
        This, *mut c_void, bool
    ) -> *const aiScene;
    validate_flags = _ZNK6Assimp8Importer13ValidateFlagsEj(This, u32) -> bool;

    register_loader = _ZN6Assimp8Importer14RegisterLoaderEPNS_12BaseImporterE(This, *mut c_void) -> aiReturn;
    unregister_loader = _ZN6Assimp8Importer16UnregisterLoaderEPNS_12BaseImporterE(This, *mut c_void) -> aiReturn;
    register_process = _ZN6Assimp8Importer14RegisterPPStepEPNS_11BaseProcessE(This, *mut c_void) -> aiReturn;
    construct_loader = _ZN6Assimp12BaseImporterC2Ev(This);
    destruct_loader = _ZN6Assimp12BaseImporterD2Ev(This);

    io_handler = _ZNK6Assimp8Importer12GetIOHandlerEv(This) -> *mut c_void;
    progress_handler = _ZNK6Assimp8Importer18GetProgressHandlerEv(This) -> *mut c_void;
    set_io_handler = _ZN6Assimp8Importer12SetIOHandlerEPNS_8IOSystemE(This, *mut c_void);
    set_progress_handler = _ZN6Assimp8Importer18SetProgressHandlerEPNS_15ProgressHandlerE(This, *mut c_void);
    set_integer = _ZN6Assimp8Importer18SetPropertyIntegerEPKci(This, *const c_char, i32) -> bool;
    set_float = _ZN6Assimp8Importer16SetPropertyFloatEPKcf(This, *const c_char, f32) -> bool;
    set_matrix = _ZN6Assimp8Importer17SetPropertyMatrixEPKcRK12aiMatrix4x4tIfE(This, *const c_char, *const f32) -> bool;
    set_pointer = _ZN6Assimp8Importer18SetPropertyPointerEPKcPv(This, *const c_char, *mut c_void) -> bool;
    set_string = _ZN6Assimp8Importer17SetPropertyStringEPKcRKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE(
        This, *const c_char, *const StdString
    ) -> bool;
}
