//! The rules for every scene of this crate.

use std::collections::HashMap;
use std::fmt;

use glam::{Mat4, Vec3};
use serde::Serialize;

use crate::scene::{Animation, Channel, Keys, Mesh, Node, Scene};

/// The largest difference from 1 of a unit vector's or quaternion's length, and of the sum of a vertex's weights.
const UNIT_TOLERANCE: f32 = 1e-4;

/// Declares [`Rule`] from one table, so that a rule, its number and its text stay together.
macro_rules! rules {
    ($($number:literal $variant:ident $text:literal)*) => {
        /// A rule for scenes. [`Scene::validate`](crate::Scene::validate) has an example.
        ///
        /// | number | rule |
        /// |---|---|
        $(#[doc = concat!("| ", $number, " | ", $text, " |")])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(rename_all = "snake_case")]
        #[non_exhaustive]
        pub enum Rule {
            $(#[doc = $text] $variant,)*
        }

        impl Rule {
            /// All rules, in the order of the table.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// The number of the rule. The number does not change between versions.
            pub const fn number(self) -> u32 {
                match self { $(Self::$variant => $number,)* }
            }

            /// The requirement.
            pub const fn text(self) -> &'static str {
                match self { $(Self::$variant => $text,)* }
            }
        }
    };
}

rules! {
    1 OneRoot "The first node has no parent, and every other node has one."
    2 DepthFirst "Nodes are in depth-first order: each follows its parent, or the subtree of a sibling."
    3 NodeTransform "A node's transform is finite, and its last row is 0 0 0 1."
    4 NodeMeshes "A node's mesh indices are valid, without repeats."
    5 MeshMaterial "A mesh's material index is valid, and the material's texture index is valid."
    6 MeshNormals "A mesh has one normal per vertex, finite and of unit length."
    7 MeshVertices "A mesh's vertices and texture coordinates are finite. It has one texture coordinate per vertex, or none."
    8 MeshIndices "A mesh's faces are complete, and their indices refer to its vertices."
    9 BoneNode "A bone states the index and the name of its node, and each node has at most one bone per mesh."
    10 BoneOffset "A bone's offset matrix is finite and can be inverted."
    11 BoneWeights "A bone's weights are from 0 to 1, and each belongs to a vertex of the mesh, at most one per vertex."
    12 WeightSum "In a mesh with bones the weights of each vertex sum to 1."
    13 AnimationTime "An animation's ticks per second are finite and above 0, and its duration is finite and at least \
        0."
    14 ChannelNode "A channel drives a node. A name has at most as many channels as nodes. If a channel states the \
        index of its node, that node has the channel's name and no other channel."
    15 KeyTicks "A track has one tick per key. Ticks are finite, strictly increasing, and within the animation's \
        duration."
    16 KeyValues "A track's values are finite."
    17 UnitRotations "A rotation key is of unit length."
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rule {}: {}", self.number(), self.text())
    }
}

/// The place in a scene that breaks a rule. All numbers in it are indices.
///
/// [`Scene::validate`](crate::Scene::validate) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Part {
    /// An index into [`Scene::nodes`].
    Node(usize),
    /// An index into [`Scene::meshes`].
    Mesh(usize),
    /// A bone of a mesh.
    Bone {
        /// An index into [`Scene::meshes`].
        mesh: usize,
        /// An index into [`Mesh::bones`].
        bone: usize,
    },
    /// An index into [`Scene::animations`].
    Animation(usize),
    /// A channel of an animation.
    Channel {
        /// An index into [`Scene::animations`].
        animation: usize,
        /// An index into [`Animation::channels`].
        channel: usize,
    },
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Node(node) => write!(f, "node {node}"),
            Self::Mesh(mesh) => write!(f, "mesh {mesh}"),
            Self::Bone { mesh, bone } => write!(f, "mesh {mesh}, bone {bone}"),
            Self::Animation(animation) => write!(f, "animation {animation}"),
            Self::Channel { animation, channel } => write!(f, "animation {animation}, channel {channel}"),
        }
    }
}

/// A rule, and a place in the scene that breaks it.
///
/// [`Scene::validate`](crate::Scene::validate) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Violation {
    /// The broken rule.
    pub rule: Rule,
    /// The place that breaks it.
    pub part: Part,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} breaks {}", self.part, self.rule)
    }
}

impl Scene {
    /// Lists the violations of the rules, in the order of the scene's data. The list is empty if the scene is valid.
    ///
    /// A place is listed once for each rule, however often it breaks the rule.
    ///
    /// ```
    /// use mocap::process::report::Rule;
    /// use mocap::scene::{Node, Scene};
    ///
    /// let lost = Node { meshes: vec![7], ..Node::default() };
    /// let violations = Scene { nodes: vec![lost], ..Scene::default() }.validate();
    /// assert_eq!(violations[0].rule, Rule::NodeMeshes);
    /// assert_eq!(
    ///     violations[0].to_string(),
    ///     "node 0 breaks rule 4: A node's mesh indices are valid, without repeats."
    /// );
    /// ```
    pub fn validate(&self) -> Vec<Violation> {
        let mut violations = Vec::new();
        let mut check = |holds: bool, rule: Rule, part: Part| {
            if !holds {
                violations.push(Violation { rule, part });
            }
        };
        check_nodes(self, &mut check);
        for (index, mesh) in self.meshes.iter().enumerate() {
            check_mesh(self, mesh, index, &mut check);
        }
        for (index, animation) in self.animations.iter().enumerate() {
            check_animation(&self.nodes, animation, index, &mut check);
        }
        violations
    }
}

fn check_nodes(scene: &Scene, check: &mut impl FnMut(bool, Rule, Part)) {
    // The nodes from the root to the previous one. In depth-first order they include the parent of the next node.
    let mut ancestors: Vec<usize> = Vec::new();
    for (index, node) in scene.nodes.iter().enumerate() {
        let part = Part::Node(index);
        check(node.parent.is_none() == (index == 0), Rule::OneRoot, part);
        if let Some(parent) = node.parent {
            while ancestors.last().is_some_and(|&last| last != parent.index()) {
                ancestors.pop();
            }
            check(!ancestors.is_empty(), Rule::DepthFirst, part);
        }
        ancestors.push(index);
        check(is_affine(node.transform), Rule::NodeTransform, part);
        let mut meshes = node.meshes.clone();
        meshes.sort_unstable();
        let in_range = meshes.iter().all(|&mesh| mesh < scene.meshes.len());
        let named_once = meshes.windows(2).all(|pair| pair[0] != pair[1]);
        check(in_range && named_once, Rule::NodeMeshes, part);
    }
}

fn check_mesh(scene: &Scene, mesh: &Mesh, index: usize, check: &mut impl FnMut(bool, Rule, Part)) {
    let part = Part::Mesh(index);
    let count = mesh.vertices.len();
    let material = scene.materials.get(mesh.material_index);
    let texture = material.and_then(|material| material.surface?.texture);
    let has_texture = texture.is_none_or(|texture| texture < scene.textures.len());
    check(material.is_some() && has_texture, Rule::MeshMaterial, part);
    let unit = mesh.normals.iter().all(|normal| is_unit(normal.length_squared()));
    check(mesh.normals.len() == count && unit, Rule::MeshNormals, part);
    let are_placed = mesh.vertices.iter().all(|vertex| vertex.is_finite());
    let coords = &mesh.texture_coords;
    let are_textured = coords.is_empty() || coords.len() == count && coords.iter().all(|position| position.is_finite());
    let are_moved = mesh.morph_targets.iter().all(|target| {
        let ids = &target.vertex_ids;
        let offsets = target.offsets.iter().chain(&target.normal_offsets);
        let has_normals = target.normal_offsets.is_empty() || target.normal_offsets.len() == ids.len();
        ids.iter().all(|vertex| (*vertex as usize) < count)
            && target.offsets.len() == ids.len()
            && has_normals
            && offsets.into_iter().all(|offset| offset.is_finite())
    });
    check(are_placed && are_textured && are_moved, Rule::MeshVertices, part);
    let whole = mesh.indices.len().is_multiple_of(mesh.primitive.indices_per_face());
    let in_range = mesh.indices.iter().all(|&vertex| (vertex as usize) < count);
    check(whole && in_range, Rule::MeshIndices, part);

    let mut sums = vec![0.0f32; count];
    let mut last_bone_of: Vec<Option<usize>> = vec![None; count];
    let mut bone_of_node = HashMap::new();
    for (bone_index, bone) in mesh.bones.iter().enumerate() {
        let part = Part::Bone {
            mesh: index,
            bone: bone_index,
        };
        let named = scene
            .nodes
            .get(bone.node.index())
            .is_some_and(|node| node.name == bone.name);
        let first = bone_of_node.insert(bone.node, bone_index).is_none();
        check(named && first, Rule::BoneNode, part);
        let matrix = bone.offset_matrix;
        check(is_affine(matrix) && matrix.determinant() != 0.0, Rule::BoneOffset, part);
        let mut weights_hold = true;
        for weight in &bone.weights {
            let vertex = weight.vertex_id as usize;
            if vertex < count {
                sums[vertex] += weight.weight;
                weights_hold &= last_bone_of[vertex].replace(bone_index) != Some(bone_index);
            }
            weights_hold &= vertex < count && (0.0..=1.0).contains(&weight.weight);
        }
        check(weights_hold, Rule::BoneWeights, part);
    }
    let full = sums.iter().all(|sum| (sum - 1.0).abs() <= UNIT_TOLERANCE);
    check(mesh.bones.is_empty() || full, Rule::WeightSum, part);
}

fn check_animation(nodes: &[Node], animation: &Animation, index: usize, check: &mut impl FnMut(bool, Rule, Part)) {
    let Animation {
        ticks_per_second: rate,
        duration,
        ..
    } = *animation;
    let time_holds = rate.is_finite() && rate > 0.0 && duration.is_finite() && duration >= 0.0;
    check(time_holds, Rule::AnimationTime, Part::Animation(index));
    let mut nodes_left: HashMap<&str, usize> = HashMap::new();
    for node in nodes {
        *nodes_left.entry(&node.name).or_default() += 1;
    }
    let mut is_driven = vec![false; nodes.len()];
    for (channel_index, channel) in animation.channels.iter().enumerate() {
        let part = Part::Channel {
            animation: index,
            channel: channel_index,
        };
        let left = nodes_left.entry(&channel.node_name).or_default();
        let node_holds = channel.node.is_none_or(|id| {
            nodes.get(id.index()).is_some_and(|node| node.name == channel.node_name)
                && !std::mem::replace(&mut is_driven[id.index()], true)
        });
        check(*left > 0 && node_holds, Rule::ChannelNode, part);
        *left = left.saturating_sub(1);
        let Channel {
            position_keys,
            rotation_keys,
            scaling_keys,
            ..
        } = channel;
        let ticks_hold = are_ticks_sound(position_keys, duration)
            && are_ticks_sound(rotation_keys, duration)
            && are_ticks_sound(scaling_keys, duration);
        check(ticks_hold, Rule::KeyTicks, part);
        let finite = |keys: &Keys<Vec3>| keys.values.iter().all(|value| value.is_finite());
        let rotations = &rotation_keys.values;
        let values_hold =
            finite(position_keys) && finite(scaling_keys) && rotations.iter().all(|value| value.is_finite());
        check(values_hold, Rule::KeyValues, part);
        let unit = rotations.iter().all(|value| is_unit(value.length_squared()));
        check(unit, Rule::UnitRotations, part);
    }
}

fn are_ticks_sound<T>(keys: &Keys<T>, duration: f64) -> bool {
    let Some(ticks) = &keys.ticks else {
        return keys.is_empty() || keys.tick(keys.len() - 1) <= duration;
    };
    ticks.len() == keys.len()
        && ticks.iter().all(|tick| (0.0..=duration).contains(tick))
        && ticks.is_sorted_by(|a, b| a < b)
}

fn is_affine(matrix: Mat4) -> bool {
    matrix.is_finite() && matrix.row(3).to_array() == [0.0, 0.0, 0.0, 1.0]
}

fn is_unit(length_squared: f32) -> bool {
    (length_squared.sqrt() - 1.0).abs() <= UNIT_TOLERANCE
}
