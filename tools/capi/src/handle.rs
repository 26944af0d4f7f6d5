//! The scene at a handle, with all its strings prepared for C.

use std::ffi::{CStr, CString};

use mocap::Binding;
use mocap::edit::report::EditReport;
use mocap::glam::Mat4;
use mocap::scene::{self, Assumption, Node, NodeId};

use crate::Matrix;
use crate::border::{Failure, c_text};

/// An open motion file. Programs only hold pointers to this type.
pub struct Scene {
    scene: scene::Scene,
    names: Vec<CString>,
    bindings: Vec<Binding>,
    /// For each animation, the node that each channel moves.
    nodes_of_channels: Vec<Vec<Option<NodeId>>>,
    pub(crate) warnings: Vec<CString>,
    pub(crate) assumptions: Vec<CString>,
    /// The changes of each step that made the scene.
    pub(crate) edit_reports: Vec<CString>,
}

/// An animation, with the node of each channel.
pub(crate) struct Animation<'a> {
    pub(crate) data: &'a scene::Animation,
    binding: &'a Binding,
    nodes: &'a [Option<NodeId>],
}

impl Scene {
    pub(crate) fn new(scene: scene::Scene) -> Self {
        let animations = scene.animations.iter();
        let bindings: Vec<_> = animations.map(|animation| Binding::new(&scene, animation)).collect();
        let nodes_of_channels = std::iter::zip(&scene.animations, &bindings).map(|(animation, binding)| {
            let mut nodes = vec![None; animation.channels.len()];
            for (node, channel) in binding.driven() {
                nodes[channel] = Some(node);
            }
            nodes
        });
        Self {
            names: scene.nodes.iter().map(|node| c_text(&node.name)).collect(),
            nodes_of_channels: nodes_of_channels.collect(),
            bindings,
            warnings: scene
                .warnings
                .iter()
                .map(|warning| c_text(&warning.to_string()))
                .collect(),
            assumptions: scene.metadata.assumptions.iter().map(assumption_text).collect(),
            edit_reports: Vec::new(),
            scene,
        }
    }

    /// Returns a converted copy.
    pub(crate) fn converted(&self, conversion: &mocap::Conversion) -> Result<Self, Failure> {
        let mut scene = self.scene.clone();
        let decided = conversion.apply(&mut scene)?;
        let mut converted = Self::new(scene);
        converted.assumptions.clone_from(&self.assumptions);
        converted.assumptions.extend(decided.iter().map(assumption_text));
        Ok(converted)
    }

    /// Makes a handle of an edited scene, with the reports of the steps.
    pub(crate) fn edited(&self, changed: scene::Scene, reports: &[EditReport]) -> Self {
        let mut edited = Self::new(changed);
        edited.assumptions.clone_from(&self.assumptions);
        edited.edit_reports = reports.iter().map(|report| c_text(&report.to_string())).collect();
        edited
    }

    pub(crate) fn into_raw(self) -> *mut Self {
        Box::into_raw(Box::new(self))
    }

    pub(crate) fn scene(&self) -> &scene::Scene {
        &self.scene
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
        node.ok_or_else(|| Failure::absent("node", index.into(), self.node_count().into()))
    }

    pub(crate) fn node_name(&self, index: u32) -> Result<&CStr, Failure> {
        let name = self.names.get(index as usize);
        name.map(CString::as_c_str)
            .ok_or_else(|| Failure::absent("node", index.into(), self.node_count().into()))
    }

    pub(crate) fn find_node(&self, name: &CStr) -> Result<u32, Failure> {
        let index = self.names.iter().position(|other| other.as_c_str() == name);
        let missing = || Failure::argument(&format!("there is no node named \"{}\"", name.to_string_lossy()));
        index.map(|index| index as u32).ok_or_else(missing)
    }

    pub(crate) fn animation(&self, index: u32) -> Result<Animation<'_>, Failure> {
        let place = index as usize;
        let data = self.scene.animations.get(place);
        let data = data.ok_or_else(|| Failure::absent("animation", index.into(), self.animation_count().into()))?;
        Ok(Animation {
            data,
            binding: &self.bindings[place],
            nodes: &self.nodes_of_channels[place],
        })
    }

    /// The rest pose, as matrices relative to the parents.
    pub(crate) fn rest(&self, matrices: &mut [Matrix]) {
        for (matrix, node) in matrices.iter_mut().zip(&self.scene.nodes) {
            *matrix = node.transform.to_cols_array();
        }
    }

    /// Converts matrices relative to the parents to world matrices, in place. Parents precede their children, so the
    /// matrix of a parent is always finished first.
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

fn assumption_text(assumption: &Assumption) -> CString {
    c_text(&assumption.to_string())
}

impl Animation<'_> {
    pub(crate) fn channel_node(&self, index: usize) -> Result<u32, Failure> {
        let node = self.nodes.get(index);
        let node = node.ok_or_else(|| Failure::absent("channel", index as u64, self.nodes.len() as u64))?;
        let node = node.ok_or_else(|| Failure::argument(&format!("channel {index} moves no node")))?;
        Ok(node.0)
    }

    /// The pose at `tick`, as matrices relative to the parents.
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
