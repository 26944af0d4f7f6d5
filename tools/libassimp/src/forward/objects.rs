//! The tables of virtual functions and the type infos that Assimp 5.2.5 exports, with the same sizes.
//!
//! A type info is only data, which the C++ library reads for `dynamic_cast` and for exceptions. A virtual function is a
//! stub that jumps to the same entry of the same table in the system's Assimp. The names of the tables are from
//! `tests/symbols.txt`; `readelf` gave their entries in Debian's library.

use std::ffi::{CStr, c_void};

use crate::forward::Entry;

/// A word of a table.
#[repr(transparent)]
pub(crate) struct Word(*const c_void);

// SAFETY: a word holds the address of constant data or of code, and nothing writes it.
unsafe impl Sync for Word {}

impl Word {
    pub(crate) const NULL: Self = Self(std::ptr::null());

    pub(crate) const fn data<T>(data: &'static T) -> Self {
        Self(std::ptr::from_ref(data).cast())
    }

    pub(crate) const fn code(code: *const c_void) -> Self {
        Self(code)
    }

    /// The first word of an object: the address of its class's table, after the two words that are no functions.
    pub(crate) const fn table(table: *const Word) -> Self {
        Self(table.wrapping_add(2).cast())
    }
}

// Symbols of the C++ library, which build.rs links.
unsafe extern "C" {
    #[link_name = "_ZTVN10__cxxabiv117__class_type_infoE"]
    static CLASS: Word;
    #[link_name = "_ZTVN10__cxxabiv120__si_class_type_infoE"]
    static DERIVED: Word;
    #[link_name = "_ZTVN10__cxxabiv120__function_type_infoE"]
    static FUNCTION: Word;
    #[link_name = "_ZTVN10__cxxabiv119__pointer_type_infoE"]
    static POINTER: Word;
    #[link_name = "_ZTISt13runtime_error"]
    static _ZTISt13runtime_error: Word;
}

/// The name of a type: its symbol without `_ZTS`, and a zero byte.
const fn type_name<const N: usize>(symbol: &str) -> [u8; N] {
    let symbol = symbol.as_bytes();
    let mut name = [0; N];
    let mut at = 0;
    while at + 4 < symbol.len() {
        name[at] = symbol[at + 4];
        at += 1;
    }
    name
}

macro_rules! type_names {
    ($($name:ident)*) => {
        $(
            #[unsafe(no_mangle)]
            static $name: [u8; stringify!($name).len() - 3] = type_name(stringify!($name));
        )*
    };
}

/// The words of a type info, by its kind: a class, one derived from another, a function, a pointer to a type.
macro_rules! words {
    (class $name:ident) => {
        [Word::table(&raw const CLASS), Word::data(&$name)]
    };
    (derived $name:ident $base:ident) => {
        [
            Word::table(&raw const DERIVED),
            Word::data(&$name),
            Word(&raw const $base as *const c_void),
        ]
    };
    (function $name:ident) => {
        [Word::table(&raw const FUNCTION), Word::data(&$name)]
    };
    (pointer $name:ident $to:ident) => {
        [
            Word::table(&raw const POINTER),
            Word::data(&$name),
            Word::NULL,
            Word::data(&$to),
        ]
    };
    (count class) => {
        2
    };
    (count derived) => {
        3
    };
    (count function) => {
        2
    };
    (count pointer) => {
        4
    };
}

macro_rules! type_infos {
    ($($kind:ident $info:ident $name:ident $($other:ident)?;)*) => {
        type_names! { $($name)* }
        $(
            #[unsafe(no_mangle)]
            pub(crate) static $info: [Word; words!(count $kind)] = words!($kind $name $($other)?);
        )*
    };
}

/// A table of virtual functions: no offset to the whole object, the type info, then the functions by their words.
macro_rules! tables {
    ($($table:ident $info:ident [$($word:literal)*];)*) => {
        $(
            #[unsafe(no_mangle)]
            static $table: [Word; 2 + [$($word),*].len()] = {
                const SYMBOL: &CStr = match CStr::from_bytes_with_nul(concat!(stringify!($table), "\0").as_bytes()) {
                    Ok(symbol) => symbol,
                    Err(_) => unreachable!(),
                };
                [Word::NULL, Word::data(&$info), $({
                    static ENTRY: Entry = Entry::virtual_function(SYMBOL, $word);

                    #[unsafe(naked)]
                    unsafe extern "C" fn stub() {
                        std::arch::naked_asm!("lea r11, [rip + {entry}]", "jmp [r11]", entry = sym ENTRY)
                    }

                    Word::code(stub as *const c_void)
                }),*]
            };
        )*
    };
}

type_infos! {
    derived _ZTI15DeadlyErrorBase _ZTS15DeadlyErrorBase _ZTISt13runtime_error;
    derived _ZTI17DeadlyExportError _ZTS17DeadlyExportError _ZTI15DeadlyErrorBase;
    derived _ZTI17DeadlyImportError _ZTS17DeadlyImportError _ZTI15DeadlyErrorBase;
    function _ZTIFvN10ODDLParser11LogSeverityERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEEE _ZTSFvN10ODDLParser11LogSeverityERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEEE;
    derived _ZTIN6Assimp10NullLoggerE _ZTSN6Assimp10NullLoggerE _ZTIN6Assimp6LoggerE;
    class _ZTIN6Assimp10SubdividerE _ZTSN6Assimp10SubdividerE;
    class _ZTIN6Assimp11BaseProcessE _ZTSN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp11SIBImporterE _ZTSN6Assimp11SIBImporterE _ZTIN6Assimp12BaseImporterE;
    derived _ZTIN6Assimp11SMDImporterE _ZTSN6Assimp11SMDImporterE _ZTIN6Assimp12BaseImporterE;
    class _ZTIN6Assimp12BaseImporterE _ZTSN6Assimp12BaseImporterE;
    derived _ZTIN6Assimp12ScaleProcessE _ZTSN6Assimp12ScaleProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp13DefaultLoggerE _ZTSN6Assimp13DefaultLoggerE _ZTIN6Assimp6LoggerE;
    derived _ZTIN6Assimp15DefaultIOStreamE _ZTSN6Assimp15DefaultIOStreamE _ZTIN6Assimp8IOStreamE;
    derived _ZTIN6Assimp15DefaultIOSystemE _ZTSN6Assimp15DefaultIOSystemE _ZTIN6Assimp8IOSystemE;
    derived _ZTIN6Assimp15ProgressHandlerE _ZTSN6Assimp15ProgressHandlerE _ZTIN6Assimp6Intern22AllocateFromAssimpHeapE;
    derived _ZTIN6Assimp15RemoveVCProcessE _ZTSN6Assimp15RemoveVCProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp16ArmaturePopulateE _ZTSN6Assimp16ArmaturePopulateE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp18SortByPTypeProcessE _ZTSN6Assimp18SortByPTypeProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp18TriangulateProcessE _ZTSN6Assimp18TriangulateProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp19JoinVerticesProcessE _ZTSN6Assimp19JoinVerticesProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp20EmbedTexturesProcessE _ZTSN6Assimp20EmbedTexturesProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp20PretransformVerticesE _ZTSN6Assimp20PretransformVerticesE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp22FindDegeneratesProcessE _ZTSN6Assimp22FindDegeneratesProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp22FindInvalidDataProcessE _ZTSN6Assimp22FindInvalidDataProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp23GenBoundingBoxesProcessE _ZTSN6Assimp23GenBoundingBoxesProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp23GenVertexNormalsProcessE _ZTSN6Assimp23GenVertexNormalsProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp23LimitBoneWeightsProcessE _ZTSN6Assimp23LimitBoneWeightsProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp26RemoveRedundantMatsProcessE _ZTSN6Assimp26RemoveRedundantMatsProcessE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp30SplitLargeMeshesProcess_VertexE _ZTSN6Assimp30SplitLargeMeshesProcess_VertexE _ZTIN6Assimp11BaseProcessE;
    derived _ZTIN6Assimp32SplitLargeMeshesProcess_TriangleE _ZTSN6Assimp32SplitLargeMeshesProcess_TriangleE _ZTIN6Assimp11BaseProcessE;
    class _ZTIN6Assimp6Intern22AllocateFromAssimpHeapE _ZTSN6Assimp6Intern22AllocateFromAssimpHeapE;
    derived _ZTIN6Assimp6LoggerE _ZTSN6Assimp6LoggerE _ZTIN6Assimp6Intern22AllocateFromAssimpHeapE;
    derived _ZTIN6Assimp8IOStreamE _ZTSN6Assimp8IOStreamE _ZTIN6Assimp6Intern22AllocateFromAssimpHeapE;
    derived _ZTIN6Assimp8IOSystemE _ZTSN6Assimp8IOSystemE _ZTIN6Assimp6Intern22AllocateFromAssimpHeapE;
    derived _ZTIN6Assimp9LogStreamE _ZTSN6Assimp9LogStreamE _ZTIN6Assimp6Intern22AllocateFromAssimpHeapE;
    pointer _ZTIPFvN10ODDLParser11LogSeverityERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEEE _ZTSPFvN10ODDLParser11LogSeverityERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEEE _ZTIFvN10ODDLParser11LogSeverityERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEEE;
    class _ZTISt11_Mutex_baseILN9__gnu_cxx12_Lock_policyE2EE _ZTSSt11_Mutex_baseILN9__gnu_cxx12_Lock_policyE2EE;
    derived _ZTISt15_Sp_counted_ptrIPN6Assimp15DefaultIOSystemELN9__gnu_cxx12_Lock_policyE2EE _ZTSSt15_Sp_counted_ptrIPN6Assimp15DefaultIOSystemELN9__gnu_cxx12_Lock_policyE2EE _ZTISt16_Sp_counted_baseILN9__gnu_cxx12_Lock_policyE2EE;
    derived _ZTISt15_Sp_counted_ptrIPN6Assimp8IOStreamELN9__gnu_cxx12_Lock_policyE2EE _ZTSSt15_Sp_counted_ptrIPN6Assimp8IOStreamELN9__gnu_cxx12_Lock_policyE2EE _ZTISt16_Sp_counted_baseILN9__gnu_cxx12_Lock_policyE2EE;
    derived _ZTISt15_Sp_counted_ptrIPN6Assimp8IOSystemELN9__gnu_cxx12_Lock_policyE2EE _ZTSSt15_Sp_counted_ptrIPN6Assimp8IOSystemELN9__gnu_cxx12_Lock_policyE2EE _ZTISt16_Sp_counted_baseILN9__gnu_cxx12_Lock_policyE2EE;
    derived _ZTISt15_Sp_counted_ptrIPSt6vectorIfSaIfEELN9__gnu_cxx12_Lock_policyE2EE _ZTSSt15_Sp_counted_ptrIPSt6vectorIfSaIfEELN9__gnu_cxx12_Lock_policyE2EE _ZTISt16_Sp_counted_baseILN9__gnu_cxx12_Lock_policyE2EE;
    derived _ZTISt15_Sp_counted_ptrIPSt6vectorIlSaIlEELN9__gnu_cxx12_Lock_policyE2EE _ZTSSt15_Sp_counted_ptrIPSt6vectorIlSaIlEELN9__gnu_cxx12_Lock_policyE2EE _ZTISt16_Sp_counted_baseILN9__gnu_cxx12_Lock_policyE2EE;
    derived _ZTISt16_Sp_counted_baseILN9__gnu_cxx12_Lock_policyE2EE _ZTSSt16_Sp_counted_baseILN9__gnu_cxx12_Lock_policyE2EE _ZTISt11_Mutex_baseILN9__gnu_cxx12_Lock_policyE2EE;
    derived _ZTISt19_Sp_counted_deleterIPhSt14default_deleteIA_hESaIvELN9__gnu_cxx12_Lock_policyE2EE _ZTSSt19_Sp_counted_deleterIPhSt14default_deleteIA_hESaIvELN9__gnu_cxx12_Lock_policyE2EE _ZTISt16_Sp_counted_baseILN9__gnu_cxx12_Lock_policyE2EE;
}

// Types for which Assimp exports a name without a type info.
type_names! {
    _ZTSSt14default_deleteIA_hE
    _ZTSSt19_Sp_make_shared_tag
}

tables! {
    _ZTV15DeadlyErrorBase _ZTI15DeadlyErrorBase [2 3 4];
    _ZTV17DeadlyExportError _ZTI17DeadlyExportError [2 3 4];
    _ZTV17DeadlyImportError _ZTI17DeadlyImportError [2 3 4];
    _ZTVN6Assimp10SubdividerE _ZTIN6Assimp10SubdividerE [2 3 4 5];
    _ZTVN6Assimp11BaseProcessE _ZTIN6Assimp11BaseProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp11SIBImporterE _ZTIN6Assimp11SIBImporterE [2 3 4 5 6 7];
    _ZTVN6Assimp11SMDImporterE _ZTIN6Assimp11SMDImporterE [2 3 4 5 6 7];
    _ZTVN6Assimp12BaseImporterE _ZTIN6Assimp12BaseImporterE [2 3 4 5 6 7];
    _ZTVN6Assimp12ScaleProcessE _ZTIN6Assimp12ScaleProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp13DefaultLoggerE _ZTIN6Assimp13DefaultLoggerE [2 3 4 5 6 7 8 9 10];
    _ZTVN6Assimp15DefaultIOStreamE _ZTIN6Assimp15DefaultIOStreamE [2 3 4 5 6 7 8 9];
    _ZTVN6Assimp15DefaultIOSystemE _ZTIN6Assimp15DefaultIOSystemE [2 3 4 5 6 7 8 9 10 11 12 13 14 15];
    _ZTVN6Assimp15RemoveVCProcessE _ZTIN6Assimp15RemoveVCProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp16ArmaturePopulateE _ZTIN6Assimp16ArmaturePopulateE [2 3 4 5 6 7];
    _ZTVN6Assimp18SortByPTypeProcessE _ZTIN6Assimp18SortByPTypeProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp18TriangulateProcessE _ZTIN6Assimp18TriangulateProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp19JoinVerticesProcessE _ZTIN6Assimp19JoinVerticesProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp20EmbedTexturesProcessE _ZTIN6Assimp20EmbedTexturesProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp20PretransformVerticesE _ZTIN6Assimp20PretransformVerticesE [2 3 4 5 6 7];
    _ZTVN6Assimp22FindDegeneratesProcessE _ZTIN6Assimp22FindDegeneratesProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp22FindInvalidDataProcessE _ZTIN6Assimp22FindInvalidDataProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp23GenBoundingBoxesProcessE _ZTIN6Assimp23GenBoundingBoxesProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp23GenVertexNormalsProcessE _ZTIN6Assimp23GenVertexNormalsProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp23LimitBoneWeightsProcessE _ZTIN6Assimp23LimitBoneWeightsProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp26RemoveRedundantMatsProcessE _ZTIN6Assimp26RemoveRedundantMatsProcessE [2 3 4 5 6 7];
    _ZTVN6Assimp30SplitLargeMeshesProcess_VertexE _ZTIN6Assimp30SplitLargeMeshesProcess_VertexE [2 3 4 5 6 7];
    _ZTVN6Assimp32SplitLargeMeshesProcess_TriangleE _ZTIN6Assimp32SplitLargeMeshesProcess_TriangleE [2 3 4 5 6 7];
    _ZTVN6Assimp6LoggerE _ZTIN6Assimp6LoggerE [2 3 4 5 6 7 8 9 10];
    _ZTVN6Assimp8IOStreamE _ZTIN6Assimp8IOStreamE [2 3 4 5 6 7 8 9];
    _ZTVN6Assimp8IOSystemE _ZTIN6Assimp8IOSystemE [2 3 4 5 6 7 8 9 10 11 12 13 14 15];
    _ZTVN6Assimp9LogStreamE _ZTIN6Assimp9LogStreamE [2 3 4];
}
