//! Looking for a node by its name. These are methods of a C++ class, so their names are those that the compiler makes.

use std::ffi::c_char;
use std::ptr;

use crate::abi::aiNode;

unsafe extern "C" {
    /// Of the C library.
    safe fn strcmp(left: &c_char, right: &c_char) -> i32;
}

/// `aiNode* aiNode::FindNode(const char*)`: the node itself or the first below it, depth-first, that has this name.
///
/// # Safety
/// `node` is NULL or a node whose children are nodes; `name` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6aiNode8FindNodeEPKc(node: *mut aiNode, name: *const c_char) -> *mut aiNode {
    // SAFETY: the caller hands over NULL or a text.
    match unsafe { name.as_ref() } {
        // SAFETY: the caller hands over NULL or a node.
        Some(name) => unsafe { find(node, name) },
        None => ptr::null_mut(),
    }
}

/// `const aiNode* aiNode::FindNode(const char*) const`.
///
/// # Safety
/// As [`_ZN6aiNode8FindNodeEPKc`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZNK6aiNode8FindNodeEPKc(node: *const aiNode, name: *const c_char) -> *const aiNode {
    // SAFETY: the same promise.
    unsafe { _ZN6aiNode8FindNodeEPKc(node.cast_mut(), name) }
}

/// # Safety
/// `node` is NULL or a node whose children are nodes; `name` is the first character of a text.
unsafe fn find(node: *mut aiNode, name: &c_char) -> *mut aiNode {
    // SAFETY: the caller hands over NULL or a node.
    let Some(this) = (unsafe { node.as_ref() }) else {
        return ptr::null_mut();
    };
    // SAFETY: a name has a zero byte at its end, within its array.
    let own_name = unsafe { &*this.mName.data.as_ptr().cast::<c_char>() };
    if strcmp(own_name, name) == 0 {
        return node;
    }
    for child in 0..this.mNumChildren as usize {
        // SAFETY: there are `mNumChildren` pointers to nodes at `mChildren`.
        let found = unsafe { find(*this.mChildren.add(child), name) };
        if !found.is_null() {
            return found;
        }
    }
    ptr::null_mut()
}
