//! The properties of a material, by key.
//!
//! A skeleton's material has a name and whether back faces are drawn. All other queries fail, as with Assimp.

use std::ffi::{CStr, c_char};
use std::ptr;

use crate::abi::{
    AI_FAILURE, AI_SUCCESS, MAXLEN, PROPERTY_DOUBLE, PROPERTY_FLOAT, PROPERTY_INTEGER, PROPERTY_STRING, aiColor4D,
    aiMaterial, aiMaterialProperty, aiReturn, aiString, aiUVTransform,
};
use crate::{destroy, heap};

/// `$tex.file`, under which a material has the path of a texture.
const TEXTURE_FILE: &CStr = c"$tex.file";

/// The property with this key, texture kind and texture number; for the last two, `0xFFFF_FFFF` means any.
///
/// # Safety
/// `material` is NULL or a material, `key` is NULL or ends with a zero byte, and `out` points to a pointer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetMaterialProperty(
    material: *const aiMaterial,
    key: *const c_char,
    semantic: u32,
    index: u32,
    out: *mut *const aiMaterialProperty,
) -> aiReturn {
    // SAFETY: the caller's promise in `# Safety`.
    let found = unsafe { find(material, key, semantic, index) };
    if !out.is_null() {
        // SAFETY: the caller passes a valid pointer to a pointer.
        unsafe { out.write(found.map_or(ptr::null(), ptr::from_ref)) };
    }
    found.map_or(AI_FAILURE, |_| AI_SUCCESS)
}

/// Reads floating-point numbers: at most `*max`, and then writes their number to `*max`; one number if `max` is NULL.
///
/// # Safety
/// `material` is NULL or a material, `key` is NULL or ends with a zero byte, and `out` has room for the numbers.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetMaterialFloatArray(
    material: *const aiMaterial,
    key: *const c_char,
    semantic: u32,
    index: u32,
    out: *mut f32,
    max: *mut u32,
) -> aiReturn {
    // SAFETY: the caller's promise in `# Safety`; `as` rounds to the nearest.
    unsafe { numbers(material, key, semantic, index, out, max, |number| number as f32) }
}

/// Reads integers, as [`aiGetMaterialFloatArray`] reads floating-point numbers.
///
/// # Safety
/// As [`aiGetMaterialFloatArray`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetMaterialIntegerArray(
    material: *const aiMaterial,
    key: *const c_char,
    semantic: u32,
    index: u32,
    out: *mut i32,
    max: *mut u32,
) -> aiReturn {
    // SAFETY: the caller's promise in `# Safety`; `as` drops the digits after the point.
    unsafe { numbers(material, key, semantic, index, out, max, |number| number as i32) }
}

/// A colour; a colour without alpha is opaque.
///
/// # Safety
/// `material` is NULL or a material, `key` is NULL or ends with a zero byte, and `out` has room for a colour.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetMaterialColor(
    material: *const aiMaterial,
    key: *const c_char,
    semantic: u32,
    index: u32,
    out: *mut aiColor4D,
) -> aiReturn {
    let mut count = 4;
    let mut colour = [0.0, 0.0, 0.0, 1.0];
    // SAFETY: the caller's promise in `# Safety`, and there is room for four numbers.
    let result =
        unsafe { aiGetMaterialFloatArray(material, key, semantic, index, colour.as_mut_ptr(), &raw mut count) };
    if result == AI_SUCCESS && !out.is_null() {
        // SAFETY: the caller passes a valid pointer to a colour.
        unsafe { out.write(colour) };
    }
    result
}

/// A string.
///
/// # Safety
/// `material` is NULL or a material, `key` is NULL or ends with a zero byte, and `out` points to an `aiString`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetMaterialString(
    material: *const aiMaterial,
    key: *const c_char,
    semantic: u32,
    index: u32,
    out: *mut aiString,
) -> aiReturn {
    // SAFETY: the caller's promise in `# Safety`.
    let found = unsafe { find(material, key, semantic, index) };
    let Some(property) = found.filter(|property| property.mType == PROPERTY_STRING) else {
        return AI_FAILURE;
    };
    // SAFETY: a property of a living material has its bytes.
    let bytes = unsafe { bytes_of(property) };
    // The length in four bytes, the characters, a zero byte.
    let Some(text) = bytes.get(4..).and_then(|text| CStr::from_bytes_until_nul(text).ok()) else {
        return AI_FAILURE;
    };
    let text = &text.to_bytes()[..text.count_bytes().min(MAXLEN - 1)];
    if !out.is_null() {
        let mut string = aiString::new("");
        string.length = text.len() as u32;
        string.data[..text.len()].copy_from_slice(text);
        // SAFETY: the caller passes a valid pointer to an `aiString`.
        unsafe { out.write(string) };
    }
    AI_SUCCESS
}

/// The number of textures of a kind.
///
/// # Safety
/// `material` is NULL or a material.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetMaterialTextureCount(material: *const aiMaterial, semantic: u32) -> u32 {
    // SAFETY: the caller's promise in `# Safety`.
    let properties = unsafe { properties(material) };
    let is_texture = |property: &&aiMaterialProperty| property.mSemantic == semantic && has_key(property, TEXTURE_FILE);
    properties.filter(is_texture).count() as u32
}

/// The path of a texture. The function does not write the mapping: the caller's values do not change.
///
/// # Safety
/// `material` is NULL or a material, and `path` points to an `aiString`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetMaterialTexture(
    material: *const aiMaterial,
    semantic: u32,
    index: u32,
    path: *mut aiString,
    _mapping: *mut u32,
    _uv_index: *mut u32,
    _blend: *mut f32,
    _operation: *mut u32,
    _map_mode: *mut u32,
    _flags: *mut u32,
) -> aiReturn {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { aiGetMaterialString(material, TEXTURE_FILE.as_ptr(), semantic, index, path) }
}

/// The transform of a texture's coordinates.
///
/// # Safety
/// As [`aiGetMaterialFloatArray`], with room for a transform.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetMaterialUVTransform(
    material: *const aiMaterial,
    key: *const c_char,
    semantic: u32,
    index: u32,
    out: *mut aiUVTransform,
) -> aiReturn {
    let mut count = 5;
    // SAFETY: the caller's promise in `# Safety`; a transform is five numbers.
    unsafe { aiGetMaterialFloatArray(material, key, semantic, index, out.cast(), &raw mut count) }
}

/// The name of a texture kind.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiTextureTypeToString(kind: u32) -> *const c_char {
    const NAMES: [&CStr; 22] = [
        c"n/a",
        c"Diffuse",
        c"Specular",
        c"Ambient",
        c"Emissive",
        c"Height",
        c"Normals",
        c"Shininess",
        c"Opacity",
        c"Displacement",
        c"Lightmap",
        c"Reflection",
        c"BaseColor",
        c"NormalCamera",
        c"EmissionColor",
        c"Metalness",
        c"DiffuseRoughness",
        c"AmbientOcclusion",
        c"Unknown",
        c"Sheen",
        c"Clearcoat",
        c"Transmission",
    ];
    NAMES.get(kind as usize).unwrap_or(&c"BUG").as_ptr()
}

/// `aiMaterial()`
///
/// # Safety
/// `material` points to a material.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN10aiMaterialC1Ev(material: *mut aiMaterial) {
    const ROOM: [*mut aiMaterialProperty; 5] = [ptr::null_mut(); 5];
    // SAFETY: the caller's promise in `# Safety`.
    unsafe {
        material.write(aiMaterial {
            mProperties: heap::new_array(&ROOM),
            mNumProperties: 0,
            mNumAllocated: ROOM.len() as u32,
        });
    }
}

/// `aiMaterial()`
///
/// # Safety
/// As [`_ZN10aiMaterialC1Ev`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN10aiMaterialC2Ev(material: *mut aiMaterial) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { _ZN10aiMaterialC1Ev(material) };
}

/// `~aiMaterial()`
///
/// # Safety
/// `material` is a material that is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN10aiMaterialD1Ev(material: *mut aiMaterial) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { destroy::material(&mut *material) };
}

/// `~aiMaterial()`
///
/// # Safety
/// As [`_ZN10aiMaterialD1Ev`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN10aiMaterialD2Ev(material: *mut aiMaterial) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { destroy::material(&mut *material) };
}

/// `aiString GetName() const`: empty if the material has no name.
///
/// # Safety
/// `material` is a material.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZNK10aiMaterial7GetNameEv(material: *const aiMaterial) -> aiString {
    let mut name = aiString::new("");
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { aiGetMaterialString(material, c"?mat.name".as_ptr(), 0, 0, &raw mut name) };
    name
}

/// # Safety
/// `material` is NULL or a material.
unsafe fn properties<'a>(material: *const aiMaterial) -> impl Iterator<Item = &'a aiMaterialProperty> {
    // SAFETY: the caller passes NULL or a material.
    let material = unsafe { material.as_ref() };
    let count = material.map_or(0, |material| material.mNumProperties as usize);
    (0..count).filter_map(move |index| {
        // SAFETY: there are `mNumProperties` pointers to properties at `mProperties`.
        unsafe { (*material?.mProperties.add(index)).as_ref() }
    })
}

fn has_key(property: &aiMaterialProperty, key: &CStr) -> bool {
    CStr::from_bytes_until_nul(&property.mKey.data).is_ok_and(|own| own == key)
}

/// # Safety
/// `material` is NULL or a material, and `key` is NULL or ends with a zero byte.
unsafe fn find<'a>(
    material: *const aiMaterial,
    key: *const c_char,
    semantic: u32,
    index: u32,
) -> Option<&'a aiMaterialProperty> {
    if key.is_null() {
        return None;
    }
    // SAFETY: the key is not NULL, so it ends with a zero byte.
    let key = unsafe { CStr::from_ptr(key) };
    // SAFETY: the caller passes NULL or a material.
    unsafe { properties(material) }.find(|property| {
        (semantic == u32::MAX || property.mSemantic == semantic)
            && (index == u32::MAX || property.mIndex == index)
            && has_key(property, key)
    })
}

/// # Safety
/// `property` belongs to a living material.
unsafe fn bytes_of(property: &aiMaterialProperty) -> &[u8] {
    if property.mData.is_null() {
        return &[];
    }
    // SAFETY: a property has `mDataLength` bytes at `mData`.
    unsafe { std::slice::from_raw_parts(property.mData, property.mDataLength as usize) }
}

/// # Safety
/// As [`aiGetMaterialFloatArray`].
unsafe fn numbers<T>(
    material: *const aiMaterial,
    key: *const c_char,
    semantic: u32,
    index: u32,
    out: *mut T,
    max: *mut u32,
    convert: impl Fn(f64) -> T,
) -> aiReturn {
    // SAFETY: the caller's promise in `# Safety`.
    let Some(property) = (unsafe { find(material, key, semantic, index) }) else {
        return AI_FAILURE;
    };
    // SAFETY: a property of a living material has its bytes.
    let bytes = unsafe { bytes_of(property) };
    let values: Vec<f64> = match property.mType {
        PROPERTY_FLOAT => elements(bytes, |bytes| f64::from(f32::from_ne_bytes(bytes))),
        PROPERTY_INTEGER => elements(bytes, |bytes| f64::from(i32::from_ne_bytes(bytes))),
        PROPERTY_DOUBLE => elements(bytes, f64::from_ne_bytes),
        _ => return AI_FAILURE,
    };
    // SAFETY: the caller passes NULL or the place of a count.
    let max = unsafe { max.as_mut() };
    let count = values.len().min(max.as_ref().map_or(1, |max| **max as usize));
    for (index, &value) in values[..count].iter().enumerate() {
        // SAFETY: the caller has room for this number of numbers.
        unsafe { out.add(index).write(convert(value)) };
    }
    if let Some(max) = max {
        *max = count as u32;
    }
    AI_SUCCESS
}

fn elements<const N: usize>(bytes: &[u8], value: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    bytes.as_chunks().0.iter().map(|&chunk| value(chunk)).collect()
}
