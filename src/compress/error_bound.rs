//! The error bound: the largest distance of a joint from its position in the source.
//!
//! A joint with its own bound has a *weight*. [`measure`](super::measure) and [`refinement`](super::refinement) compare
//! weighted errors with one bound. Constant tracks, the tolerances of the first pass and the decimals of constants are
//! chosen before any error is measured. For these choices, a track has the smallest bound of the joints that it moves.
//! No rotation corrects an error along the bone, so a joint's position is hardly more accurate than its parent's.

use std::collections::BTreeMap;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use super::raw_clip::RawClip;

/// The largest distance of joints from their positions in the source, at any frame, for any reader of the file.
///
/// Distances are in metres. A number converts to a bound for all joints and end sites. Joints that matter more or less
/// can have their own bounds:
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::compress::{ErrorBound, PackedClip};
/// use mocap::Conversion;
///
/// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// Conversion::new().apply(&mut scene)?;
/// let bound = ErrorBound::new(0.002).joint("LeftHand", 0.0005).joint("RightHand", 0.0005);
/// let clip = PackedClip::encode(&scene, 0, bound)?;
/// assert!(clip.max_error() <= 0.002);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct ErrorBound {
    /// The largest distance of a joint or end site from its position in the source, in metres. 0 keeps every position
    /// exactly, which only 32-bit floats can do.
    pub max_error: f64,
    /// The radius of a shell around each joint and end site, in metres. Three points of the shell, along the axes of
    /// the joint, represent the skin and keep the bound of the joint too. ACL's default is 0.03. With 0, only joints
    /// whose rotation moves no other joint have a shell, with a radius of 0.03 m. The positions of joints do not show
    /// an error of such a rotation.
    pub shell_distance: f64,
    /// The bounds of single joints and end sites, in metres, above 0, by their names in the scene. Each bound replaces
    /// [`max_error`](Self::max_error) for its joint. If several nodes have the name, the bound applies to all of them.
    pub per_joint: BTreeMap<String, f64>,
}

impl Default for ErrorBound {
    /// 1 mm for joints and end sites, without shells.
    fn default() -> Self {
        Self::new(0.001)
    }
}

impl From<f64> for ErrorBound {
    fn from(max_error: f64) -> Self {
        Self::new(max_error)
    }
}

impl ErrorBound {
    /// A bound for all joints and end sites, in metres.
    pub fn new(max_error: f64) -> Self {
        Self {
            max_error,
            shell_distance: 0.0,
            per_joint: BTreeMap::new(),
        }
    }

    /// Sets the radius of the shell around each joint and end site, in metres: see [`Self::shell_distance`].
    #[must_use]
    pub fn shell_distance(mut self, metres: f64) -> Self {
        self.shell_distance = metres;
        self
    }

    /// Sets a separate bound for the joint or end site `name`, in metres: see [`Self::per_joint`].
    #[must_use]
    pub fn joint(mut self, name: impl Into<String>, max_error: f64) -> Self {
        self.per_joint.insert(name.into(), max_error);
        self
    }

    /// The bound of the joint or end site `name`, in metres.
    pub fn of_joint(&self, name: &str) -> f64 {
        self.per_joint.get(name).copied().unwrap_or(self.max_error)
    }

    /// The largest bound of all joints of `scene`, in metres.
    pub fn largest(&self, scene: &Scene) -> f64 {
        let bounds = scene.nodes.iter().map(|node| self.of_joint(&node.name));
        bounds.reduce(f64::max).unwrap_or(self.max_error)
    }

    /// The bound with its lengths converted to a unit of `metres` metres.
    #[doc(hidden)]
    pub fn in_units_of(mut self, metres: f64) -> Self {
        self.max_error /= metres;
        self.shell_distance /= metres;
        self.per_joint.values_mut().for_each(|bound| *bound /= metres);
        self
    }

    /// The bound with every largest error multiplied by `fraction`. The shell distance does not change.
    #[doc(hidden)]
    pub fn tighter(mut self, fraction: f64) -> Self {
        self.max_error *= fraction;
        self.per_joint.values_mut().for_each(|bound| *bound *= fraction);
        self
    }

    /// The shell distance, checked to be finite and at least 0.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if the shell distance is negative or not finite.
    pub(super) fn checked_shell_distance(&self) -> Result<f32> {
        let distance = self.shell_distance as f32;
        if distance.is_finite() && distance >= 0.0 {
            return Ok(distance);
        }
        let message = "a shell distance must be finite and at least 0";
        Err(Diagnostic::new(Code::InvalidValue, message)
            .expected_found("a length in metres, such as 0.03", self.shell_distance.to_string())
            .into())
    }

    /// The bound of every node of `scene`; empty if all nodes have the same bound.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if a bound is not finite, or not above 0, or if a joint is not in the scene. The same
    /// error if there are joint bounds and [`max_error`](Self::max_error) is invalid.
    pub(super) fn of_nodes(&self, scene: &Scene) -> Result<Vec<f64>> {
        for (name, bound) in &self.per_joint {
            if !scene.nodes.iter().any(|node| node.name == *name) {
                let message = format!("an error bound names the joint \"{name}\", which does not exist");
                return Err(Diagnostic::new(Code::InvalidValue, message)
                    .expected_found("the name of a joint or end site", format!("\"{name}\""))
                    .help("`mocap info` lists the joints; a VRM animation has only humanoid bones")
                    .into());
            }
            if !(bound.is_finite() && *bound > 0.0) {
                let message = "the error bound of a joint must be finite and above 0";
                return Err(Diagnostic::new(Code::InvalidValue, message)
                    .in_joint(name)
                    .expected_found("a length in metres, such as 0.0005", bound.to_string())
                    .into());
            }
        }
        if self.per_joint.is_empty() {
            return Ok(Vec::new());
        }
        if !(self.max_error.is_finite() && self.max_error > 0.0) {
            let message = "with error bounds for single joints, the largest error of the other joints must be above 0";
            return Err(Diagnostic::new(Code::InvalidValue, message)
                .expected_found("a length in metres, such as 0.001", self.max_error.to_string())
                .into());
        }
        Ok(scene.nodes.iter().map(|node| self.of_joint(&node.name)).collect())
    }
}

/// The bounds of all joints of a clip, and of the points of its shells.
pub(super) struct Bounds {
    /// The bound of joints without their own bound, in metres.
    pub(super) max_error: f64,
    /// The factor by which each joint's error is multiplied before the comparison with `max_error`; empty if all
    /// factors are 1.
    weights: Vec<f64>,
    /// The smallest bound of each joint and its descendants; empty if all are `max_error`.
    subtrees: Vec<f64>,
    /// The smallest bound of each joint's descendants, or its own bound if it has none.
    below: Vec<f64>,
}

impl Bounds {
    /// # Errors
    /// [`Code::InvalidValue`] if the bound of a joint is not valid or its name is unknown.
    pub(super) fn new(bound: &ErrorBound, scene: &Scene, clip: &RawClip<'_>) -> Result<Self> {
        let of_nodes = bound.of_nodes(scene)?;
        let mut bounds = Self {
            max_error: bound.max_error,
            weights: Vec::new(),
            subtrees: Vec::new(),
            below: Vec::new(),
        };
        if of_nodes.is_empty() {
            return Ok(bounds);
        }
        let of_joints = (0..clip.joints.len()).map(|joint| of_nodes[clip.node_of(joint)]);
        bounds.subtrees = of_joints.collect();
        bounds.weights = bounds.subtrees.iter().map(|own| bound.max_error / own).collect();
        bounds.below = vec![f64::INFINITY; clip.joints.len()];
        // In the list, the points of the shells come after all joints, so each child comes after its parent.
        for (index, joint) in clip.joints.iter().enumerate().rev() {
            if bounds.below[index].is_infinite() {
                bounds.below[index] = bounds.subtrees[index];
            }
            bounds.subtrees[index] = bounds.subtrees[index].min(bounds.below[index]);
            if let Some(parent) = joint.parent {
                bounds.below[parent] = bounds.below[parent].min(bounds.subtrees[index]);
            }
        }
        Ok(bounds)
    }

    /// The weights of all joints; empty if all are 1.
    pub(super) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The bound of a joint, in metres.
    pub(super) fn of(&self, joint: usize) -> f64 {
        self.max_error / self.weights.get(joint).unwrap_or(&1.0)
    }

    /// The smallest bound of a joint and its descendants in metres. The joint's translation moves these joints.
    pub(super) fn of_subtree(&self, joint: usize) -> f64 {
        self.subtrees.get(joint).copied().unwrap_or(self.max_error)
    }

    /// The smallest bound of a joint's descendants in metres. The joint's rotation moves these joints. If the joint has
    /// no descendants, its own bound.
    pub(super) fn below(&self, joint: usize) -> f64 {
        self.below.get(joint).copied().unwrap_or(self.max_error)
    }
}
