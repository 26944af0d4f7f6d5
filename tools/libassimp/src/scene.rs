//! The members of `aiScene` and `aiNode` whose code is not in the headers. The C++ compiler makes their symbol names:
//! `C1` and `C2` are a constructor, `D1` and `D2` the destructor.

use std::ffi::c_char;
use std::ptr;

use crate::abi::{ScenePrivate, aiNode, aiScene, aiString};
use crate::cpp_string::StdString;
use crate::{destroy, heap};

unsafe extern "C" {
    /// A function of the C library.
    safe fn strcmp(left: &c_char, right: &c_char) -> i32;
}

/// `aiScene()`
///
/// # Safety
/// `scene` points to a scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN7aiSceneC1Ev(scene: *mut aiScene) {
    let private = ScenePrivate {
        importer: ptr::null_mut(),
        steps: 0,
        is_copy: false,
    };
    // SAFETY: the caller passes a valid pointer to a scene.
    unsafe {
        scene.write(aiScene {
            mPrivate: heap::new(private),
            ..aiScene::default()
        });
    }
}

/// `aiScene()`
///
/// # Safety
/// As [`_ZN7aiSceneC1Ev`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN7aiSceneC2Ev(scene: *mut aiScene) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { _ZN7aiSceneC1Ev(scene) };
}

/// `~aiScene()`
///
/// # Safety
/// `scene` is a scene that owns what it points to, and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN7aiSceneD1Ev(scene: *mut aiScene) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { destroy::scene(&mut *scene) };
}

/// `~aiScene()`
///
/// # Safety
/// As [`_ZN7aiSceneD1Ev`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN7aiSceneD2Ev(scene: *mut aiScene) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { destroy::scene(&mut *scene) };
}

/// `aiNode()`
///
/// # Safety
/// `node` points to a node.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6aiNodeC1Ev(node: *mut aiNode) {
    // SAFETY: the caller passes a valid pointer to a node.
    unsafe { node.write(aiNode::default()) };
}

/// `aiNode()`
///
/// # Safety
/// As [`_ZN6aiNodeC1Ev`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6aiNodeC2Ev(node: *mut aiNode) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { _ZN6aiNodeC1Ev(node) };
}

/// `aiNode(const std::string &name)`
///
/// # Safety
/// `node` points to a node, and `name` a string.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6aiNodeC1ERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE(
    node: *mut aiNode,
    name: *const StdString,
) {
    // SAFETY: the caller passes a valid pointer to a node and a string.
    unsafe {
        node.write(aiNode {
            mName: aiString::from_bytes((*name).bytes()),
            ..aiNode::default()
        });
    }
}

/// `aiNode(const std::string &name)`
///
/// # Safety
/// As [`_ZN6aiNodeC1ERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6aiNodeC2ERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE(
    node: *mut aiNode,
    name: *const StdString,
) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { _ZN6aiNodeC1ERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE(node, name) };
}

/// `~aiNode()`
///
/// # Safety
/// `node` is a node that owns what it points to, and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6aiNodeD1Ev(node: *mut aiNode) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { destroy::node(&mut *node) };
}

/// `~aiNode()`
///
/// # Safety
/// As [`_ZN6aiNodeD1Ev`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6aiNodeD2Ev(node: *mut aiNode) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { destroy::node(&mut *node) };
}

/// `void aiNode::addChildren(unsigned count, aiNode **children)`: adds children to this node, which then owns them. The
/// caller still owns the array.
///
/// # Safety
/// `node` is a node, and `children` is NULL or points to `count` nodes.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6aiNode11addChildrenEjPPS_(
    node: *mut aiNode,
    count: u32,
    children: *const *mut aiNode,
) {
    if children.is_null() || count == 0 {
        return;
    }
    // SAFETY: the caller passes a node with this number of children, and `count` more nodes.
    unsafe {
        let added = std::slice::from_raw_parts(children, count as usize);
        for child in added.iter().filter_map(|child| child.as_mut()) {
            child.mParent = node;
        }
        let node = &mut *node;
        let mut all = match node.mChildren.is_null() {
            true => Vec::new(),
            false => std::slice::from_raw_parts(node.mChildren, node.mNumChildren as usize).to_vec(),
        };
        all.extend_from_slice(added);
        heap::delete_array(node.mChildren);
        node.mChildren = heap::new_array(&all);
        node.mNumChildren = all.len() as u32;
    }
}

/// `aiNode* aiNode::FindNode(const char*)`: the node itself or the first below it, depth-first, that has this name.
///
/// # Safety
/// `node` is NULL or a node whose children are nodes; `name` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6aiNode8FindNodeEPKc(node: *mut aiNode, name: *const c_char) -> *mut aiNode {
    // SAFETY: the caller passes NULL or a string.
    match unsafe { name.as_ref() } {
        // SAFETY: the caller passes NULL or a node.
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
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { _ZN6aiNode8FindNodeEPKc(node.cast_mut(), name) }
}

/// # Safety
/// `node` is NULL or a node whose children are nodes; `name` is the first character of a string.
unsafe fn find(node: *mut aiNode, name: &c_char) -> *mut aiNode {
    // SAFETY: the caller passes NULL or a node.
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
