//! What stands behind a handle: a scene with everything that C asks for made beforehand.

use std::ffi::{CStr, CString};

use mocap::Binding;
use mocap::glam::Mat4;
use mocap::scene::{self, Node};

use crate::border::{Failure, c_text};
use crate::{MOCAP_NO_NODE, Matrix};

/// An open motion file. Only pointers to it leave the library.
pub struct Scene {
    scene: scene::Scene,
    names: Vec<CString>,
    bindings: Vec<Binding>,
    pub(crate) warnings: Vec<CString>,
}

/// An animation, and which of its channels drives which node.
pub(crate) struct Animation<'a> {
    pub(crate) data: &'a scene::Animation,
    binding: &'a Binding,
}

impl Scene {
    pub(crate) fn new(scene: scene::Scene) -> Self {
        let animations = scene.animations.iter();
        Self {
            names: scene.nodes.iter().map(|node| c_text(&node.name)).collect(),
            bindings: animations.map(|animation| Binding::new(&scene, animation)).collect(),
            warnings: scene
                .warnings
                .iter()
                .map(|warning| c_text(&warning.to_string()))
                .collect(),
            scene,
        }
    }

    pub(crate) fn into_raw(self) -> *mut Self {
        Box::into_raw(Box::new(self))
    }

    pub(crate) fn nodes(&self) -> &[Node] {
        &self.scene.nodes
    }

    pub(crate) fn node_count(&self) -> u32 {
        self.scene.nodes.len() as u32
    }

    pub(crate) fn animation_count(&self) -> u32 {
        self.scene.animations.len() as u32
    }

    pub(crate) fn node(&self, index: u32) -> Result<&Node, Failure> {
        let node = self.scene.nodes.get(index as usize);
        node.ok_or_else(|| Failure::argument("there is no such node"))
    }

    pub(crate) fn node_name(&self, index: u32) -> Result<&CStr, Failure> {
        let name = self.names.get(index as usize);
        name.map(CString::as_c_str)
            .ok_or_else(|| Failure::argument("there is no such node"))
    }

    pub(crate) fn find_node(&self, name: &CStr) -> Result<u32, Failure> {
        let index = self.names.iter().position(|other| other.as_c_str() == name);
        Ok(index.map_or(MOCAP_NO_NODE, |index| index as u32))
    }

    pub(crate) fn animation(&self, index: u32) -> Result<Animation<'_>, Failure> {
        let data = self.scene.animations.get(index as usize);
        let binding = self.bindings.get(index as usize);
        let both = data.zip(binding).map(|(data, binding)| Animation { data, binding });
        both.ok_or_else(|| Failure::argument("there is no such animation"))
    }

    /// The rest pose, each node to its parent.
    pub(crate) fn rest(&self, matrices: &mut [Matrix]) {
        for (matrix, node) in matrices.iter_mut().zip(&self.scene.nodes) {
            *matrix = node.transform.to_cols_array();
        }
    }

    /// Turns matrices to the parent into matrices to the world, in place: a parent stands before its children, so its
    /// matrix is done when theirs is due.
    pub(crate) fn chain(&self, matrices: &mut [Matrix]) {
        for (index, node) in self.scene.nodes.iter().enumerate() {
            if let Some(parent) = node.parent {
                let parent_to_world = Mat4::from_cols_array(&matrices[parent.index()]);
                let node_to_parent = Mat4::from_cols_array(&matrices[index]);
                matrices[index] = (parent_to_world * node_to_parent).to_cols_array();
            }
        }
    }
}

impl Animation<'_> {
    /// The pose at `tick`, each node to its parent.
    pub(crate) fn local_matrices(&self, scene: &Scene, tick: f64, matrices: &mut [Matrix]) {
        scene.rest(matrices);
        self.binding.sample(self.data, tick, |node, trs| {
            matrices[node.index()] = trs.matrix().to_cols_array();
        });
    }
}

/// Any number of threads may hold the same handle.
const _: () = {
    const fn assert_send_sync<T: Send + Sync>() {}
    assert_send_sync::<Scene>();
};
