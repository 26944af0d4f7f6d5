//! Reads FBX with the C library ufbx: the skeleton, its animation, and the skinned meshes.
//!
//! Bones, nodes that deform a mesh, and their ancestors become nodes of the scene. A file without any of these keeps
//! all nodes. Pivots, pre-rotations and rotation orders become one transform per node. Lengths are converted to metres
//! and the axes to +Y up, unless an option keeps the unit and axes of the file. An animation stack becomes an
//! animation. The reader samples its curves at the file's frame rate, in the range that the stack states, unless the
//! keys [contradict](timeline) the rate or the range.
//!
//! | in the file | in the scene |
//! |---|---|
//! | positions and normals of a mesh | in the world, in the bind pose |
//! | polygons | triangles |
//! | clusters of a skin | bones with offset matrices, and weights that sum to 1 for each vertex |
//! | a vertex without a weight | follows the first bone |
//! | a material: base colour, its texture, opacity | a material; a mesh with several becomes several |
//! | a PNG or JPEG image, embedded or near the file | a texture; other images give a warning |
//! | blend shapes, and curves of their weights | morph targets, if the caller wants them |
//! | vertex colours, a second skin, meshes without a skin | skipped, with an assumption in the scene |
//! | textures of other properties of materials | skipped, with an assumption in the scene |
//!
//! Lights and cameras are skipped.

mod blend_shapes;
mod material;
mod mesh;
mod refusal;
mod timeline;

use glam::{Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{FARTHEST, FrameBudget, SMALLEST_SCALE, is_degenerate_scale, is_plausible, limit_exceeded};
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::{
    Animation, Assumption, Channel, FbxOriginal, FileSpace, Format, Keys, Node, NodeId, NodeKind, RotationOrder, Scene,
    Topic, UpAxis,
};
use ufbx::LoadOpts;

pub(super) use self::blend_shapes::full_weight;
use self::refusal::refusal;
use self::timeline::Timeline;
use crate::fbx::{END_SITE, SOURCE_NAME};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions, Source};

/// The memory that ufbx may allocate for any file, in bytes.
const MEMORY: usize = 64 << 20;

/// The additional memory that ufbx may allocate for each byte of the file, in bytes. Compressed numbers expand by a
/// factor of up to 1000, but only broken files have nothing but such numbers.
const MEMORY_PER_BYTE: usize = 64;

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let read = read_bytes(source, options, &mut warnings);
    warnings.attach_to(read)
}

fn read_bytes(source: &Source<'_>, options: &ReadOptions, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let bytes = source.bytes;
    let file = load(bytes, options)?;
    let nodes = kept_nodes(&file, options)?;
    let mut scene = Scene {
        nodes: nodes.iter().map(|node| node.node(warnings)).collect(),
        ..Scene::default()
    };
    scene.metadata.format = Some(Format::Fbx);
    scene.metadata.attribution = super::provenance(bytes).unwrap_or_default().attribution;
    let (metres_per_unit, up) = match options.file_units {
        false => (Some(1.0), Some(UpAxis::Y)),
        true => file_units(&file.settings),
    };
    scene.metadata.metres_per_unit = metres_per_unit;
    scene.metadata.up = up;
    if !options.file_units {
        let (metres_per_unit, up) = file_units(&file.settings);
        scene.metadata.file_space = FileSpace {
            metres_per_unit,
            up,
            up_is_guess: false,
        };
    }
    let mut budget = FrameBudget::stated_by(&options.limits, bytes.len() as u64);
    let mut stacks = Vec::new();
    for stack in &file.anim_stacks {
        if let Some((animation, stack)) = read_stack(stack, &file, &nodes, options, &mut budget, warnings)? {
            scene.animations.push(animation);
            stacks.push(stack);
        }
    }
    if options.without_meshes || !options.morph_targets {
        scene.lose(DataKind::FaceCurves, blend_shapes::moving_channels(&file));
    }
    if !options.without_meshes {
        for (choice, reason) in mesh::read(source, &file, (&nodes, &stacks), options, &mut scene, warnings)? {
            scene.metadata.assumptions.push(Assumption {
                topic: Topic::Meshes,
                choice: choice.to_owned(),
                reason,
                confidence: None,
            });
        }
    }
    if !scene.meshes.is_empty() && !options.file_units && !options.without_original {
        scene.metadata.fbx = Some(FbxOriginal {
            bytes: bytes.into(),
            nodes: nodes.iter().map(|node| node.source.element.typed_id).collect(),
            keeps_clips: false,
        });
    }
    scene.lose(DataKind::Cameras, file.cameras.len() + file.stereo_cameras.len());
    scene.lose(DataKind::Lights, file.lights.len());
    if scene.animations.is_empty() {
        warnings.push(Code::NoMotion, || {
            Diagnostic::new(
                Code::NoMotion,
                "no animation stack has a duration: the scene has a skeleton and no animation",
            )
        });
    }
    Ok(scene)
}

/// Limits the memory that ufbx may allocate for a file.
pub(super) fn limited(bytes: &[u8], options: &ReadOptions) -> ufbx::AllocatorOpts {
    let memory = bytes.len().saturating_mul(MEMORY_PER_BYTE).saturating_add(MEMORY);
    ufbx::AllocatorOpts {
        memory_limit: memory.min(usize::try_from(options.limits.max_bytes).unwrap_or(usize::MAX)),
        ..ufbx::AllocatorOpts::default()
    }
}

fn load(bytes: &[u8], options: &ReadOptions) -> Result<ufbx::SceneRoot, Failure> {
    let limited = || limited(bytes, options);
    let load = LoadOpts {
        temp_allocator: limited(),
        result_allocator: limited(),
        file_format: ufbx::FileFormat::Fbx,
        ignore_geometry: options.without_meshes,
        ignore_embedded: options.without_meshes,
        generate_missing_normals: true,
        skip_mesh_parts: true,
        node_depth_limit: u32::try_from(options.limits.max_depth).unwrap_or(u32::MAX),
        // Converts nodes with an unusual inheritance of scale.
        inherit_mode_handling: ufbx::InheritModeHandling::Compensate,
        ..LoadOpts::default()
    };
    let load = if options.file_units {
        load
    } else {
        LoadOpts {
            space_conversion: ufbx::SpaceConversion::ModifyGeometry,
            target_axes: ufbx::axes_right_handed_y_up(),
            target_unit_meters: 1.0,
            ..load
        }
    };
    ufbx::load_memory(bytes, load).map_err(|error| Box::new(refusal(&error, bytes)))
}

/// The unit and the up axis that a file states, if a scene can represent them.
fn file_units(settings: &ufbx::SceneSettings) -> (Option<f64>, Option<UpAxis>) {
    let metres_per_unit = Some(settings.unit_meters).filter(|metres| metres.is_finite() && *metres > 0.0);
    let up = match settings.axes.up {
        ufbx::CoordinateAxis::PositiveY => Some(UpAxis::Y),
        ufbx::CoordinateAxis::PositiveZ => Some(UpAxis::Z),
        ufbx::CoordinateAxis::NegativeY => Some(UpAxis::NegY),
        ufbx::CoordinateAxis::NegativeZ => Some(UpAxis::NegZ),
        _ => None,
    };
    (metres_per_unit, up)
}

/// A node of the file that becomes a node of the scene.
struct KeptNode<'a> {
    source: &'a ufbx::Node,
    parent: Option<NodeId>,
    /// Whether the node is a bone, or moves vertices like a bone.
    is_bone: bool,
    /// Whether a property of mocap marks the node as an end site.
    is_end_site: bool,
}

impl KeptNode<'_> {
    fn node(&self, warnings: &mut Warnings) -> Node {
        let source = self.source;
        let (translation, rotation, scale) = components(&source.local_transform);
        let mut transform = Mat4::from_scale_rotation_translation(scale, rotation, translation);
        if !are_plausible(translation, rotation, scale) {
            transform = Mat4::IDENTITY;
            warnings.tally(Code::NonFiniteValue, || {
                let message = format!(
                    "the position in the rest pose is not finite, or beyond {FARTHEST:e}, or its scale is below \
                     {SMALLEST_SCALE:e}; the node was put at its parent"
                );
                Diagnostic::new(Code::NonFiniteValue, message).in_joint(self.name())
            });
        }
        Node {
            name: self.name(),
            kind: match self.is_bone {
                _ if self.is_end_site => NodeKind::EndSite,
                true => NodeKind::Joint,
                false => NodeKind::Group,
            },
            parent: self.parent,
            transform,
            rotation_order: rotation_order(source.rotation_order),
            ..Node::default()
        }
    }

    fn name(&self) -> String {
        node_name(self.source)
    }
}

/// The name of a node in its scene.
pub(super) fn node_name(node: &ufbx::Node) -> String {
    // The original name, if mocap had to change it in the file.
    let given = node
        .element
        .props
        .find_prop(SOURCE_NAME)
        .map(|property| &*property.value_str);
    let name = given.unwrap_or(&node.element.name);
    if node.is_root && name.is_empty() {
        "RootNode".to_owned()
    } else {
        name.to_owned()
    }
}

/// The nodes to keep, depth-first.
fn kept_nodes<'a>(file: &'a ufbx::Scene, options: &ReadOptions) -> Result<Vec<KeptNode<'a>>, Failure> {
    let mut is_bone: Vec<bool> = file.nodes.iter().map(|node| node.bone.is_some()).collect();
    for cluster in &file.skin_clusters {
        if let Some(node) = &cluster.bone_node {
            is_bone[node.element.typed_id as usize] = true;
        }
    }
    let has_bones = is_bone.contains(&true);
    let mut holds_bone = vec![false; file.nodes.len()];
    for (node, _) in std::iter::zip(&file.nodes, &is_bone).filter(|(_, is_bone)| **is_bone) {
        let mut above: Option<&ufbx::Node> = Some(node);
        // Stop at an ancestor that is already marked, so that the total time is linear.
        while let Some(node) = above.filter(|node| !holds_bone[node.element.typed_id as usize]) {
            holds_bone[node.element.typed_id as usize] = true;
            above = node.parent.as_deref();
        }
    }
    let mut kept: Vec<KeptNode<'a>> = Vec::new();
    let mut open: Vec<(&'a ufbx::Node, Option<NodeId>)> = vec![(&file.root_node, None)];
    while let Some((source, parent)) = open.pop() {
        let limit = options.limits.max_nodes;
        if kept.len() >= limit {
            let diagnostic = limit_exceeded(format!("at most {limit} nodes"), format!("more than {limit}"));
            return Err(Box::new(diagnostic));
        }
        let id = NodeId::new(kept.len());
        kept.push(KeptNode {
            source,
            parent,
            is_bone: is_bone[source.element.typed_id as usize],
            is_end_site: source.element.props.find_prop(END_SITE).is_some(),
        });
        let is_kept = |child: &&ufbx::Node| !has_bones || holds_bone[child.element.typed_id as usize];
        let children: Vec<&'a ufbx::Node> = source.children.iter().map(|child| &**child).filter(is_kept).collect();
        open.extend(children.into_iter().rev().map(|child| (child, Some(id))));
    }
    Ok(kept)
}

/// An animation stack from which the reader makes a clip.
struct Stack<'a> {
    stack: &'a ufbx::AnimStack,
    timeline: Timeline,
    frames: usize,
}

impl Stack<'_> {
    /// The times of the frames, in seconds.
    fn times(&self) -> impl Iterator<Item = f64> {
        let Timeline { begin, end, rate } = self.timeline;
        // Clamp the last frame to the end of the stack, because curves may continue after it.
        (0..self.frames).map(move |frame| (begin + frame as f64 / rate).min(end))
    }
}

/// Samples a stack at its frame rate. Returns `None` if its duration is 0 and it has no curves.
fn read_stack<'a>(
    stack: &'a ufbx::AnimStack,
    file: &ufbx::Scene,
    nodes: &[KeptNode<'_>],
    options: &ReadOptions,
    budget: &mut FrameBudget,
    warnings: &mut Warnings,
) -> Result<Option<(Animation, Stack<'a>)>, Failure> {
    let rate = options.sampling_rate_or(file.settings.frames_per_second)?;
    let of_nodes = nodes.iter().map(|node| node.source.element.element_id);
    let of_faces = file.blend_channels.iter().map(|channel| channel.element.element_id);
    let moved = of_nodes.chain(of_faces).collect();
    let timeline = Timeline::new(stack, &moved, (rate, options.sampling_rate), warnings);
    let (seconds, rate) = (timeline.end - timeline.begin, timeline.rate);
    // A stack with duration 0 becomes a clip of one frame if it has curves.
    let has_curves = || stack.layers.iter().any(|layer| !layer.anim_values.is_empty());
    if !(seconds.is_finite() && (seconds > 0.0 || seconds == 0.0 && has_curves())) {
        return Ok(None);
    }
    // The first frame is at the start of the stack. The next frames follow at the distance of the frame time, up to the
    // frame nearest to the end. Each frame of a node has a rotation, a translation and a scale.
    let weights = if options.morph_targets {
        file.blend_channels.len()
    } else {
        0
    };
    let frames = budget.frames((seconds * rate).round(), 10 * nodes.len() + weights)?;
    let clip = Stack {
        stack,
        timeline,
        frames,
    };
    let moving = nodes.iter().filter(|node| !node.is_end_site);
    let channels = moving.map(|node| {
        let times = clip.times();
        let transforms = times.map(|time| ufbx::evaluate_transform(&stack.anim, node.source, time));
        read_channel(node, transforms, warnings)
    });
    let animation = Animation {
        name: stack.element.name.to_string(),
        ticks_per_second: options.retime.unwrap_or(rate),
        duration: (frames - 1) as f64,
        channels: channels.collect(),
    };
    Ok(Some((animation, clip)))
}

fn read_channel(
    node: &KeptNode<'_>,
    transforms: impl Iterator<Item = ufbx::Transform>,
    warnings: &mut Warnings,
) -> Channel {
    let (mut positions, mut rotations, mut scales) = (Vec::new(), Vec::new(), Vec::new());
    let mut before = (Vec3::ZERO, Quat::IDENTITY, Vec3::ONE);
    for transform in transforms {
        let (position, mut rotation, scale) = components(&transform);
        if !are_plausible(position, rotation, scale) {
            warnings.tally(Code::NonFiniteValue, || {
                let message = format!(
                    "the value is not finite, or beyond {FARTHEST:e}, or a scale below {SMALLEST_SCALE:e}; the last \
                     value before it was used"
                );
                Diagnostic::new(Code::NonFiniteValue, message).in_joint(node.name())
            });
            positions.push(before.0);
            rotations.push(before.1);
            scales.push(before.2);
            continue;
        }
        // Choose the nearer of the two quaternions of the rotation.
        if rotation.dot(before.1) < 0.0 {
            rotation = -rotation;
        }
        before = (position, rotation, scale);
        positions.push(position);
        rotations.push(rotation);
        scales.push(scale);
    }
    Channel {
        node_name: node.name(),
        node: None,
        position_keys: Keys::every_tick(positions),
        rotation_keys: Keys::every_tick(rotations),
        scaling_keys: Keys::every_tick(scales),
    }
}

/// Translation, unit rotation and scale in single precision. A quaternion of length 0 becomes the identity.
fn components(transform: &ufbx::Transform) -> (Vec3, Quat, Vec3) {
    let vector = |v: ufbx::Vec3| glam::DVec3::new(v.x, v.y, v.z).as_vec3();
    let ufbx::Quat { x, y, z, w } = transform.rotation;
    let rotation = glam::DQuat::from_xyzw(x, y, z, w);
    let rotation = match rotation.length_squared() > 0.0 {
        true => rotation.normalize().as_quat(),
        false => Quat::IDENTITY,
    };
    (vector(transform.translation), rotation, vector(transform.scale))
}

/// Whether a transform has values with which kinematics can compute.
fn are_plausible(translation: Vec3, rotation: Quat, scale: Vec3) -> bool {
    let holds = |test: fn(f64) -> bool, vector: Vec3| vector.to_array().into_iter().all(|value| test(value.into()));
    let is_sound = |scale| is_plausible(scale) && !is_degenerate_scale(scale);
    holds(is_plausible, translation) && rotation.is_finite() && holds(is_sound, scale)
}

/// The name of an FBX rotation order begins with the axis that is applied first. In the matrix product this axis is the
/// last factor.
pub(super) fn rotation_order(order: ufbx::RotationOrder) -> Option<RotationOrder> {
    match order {
        ufbx::RotationOrder::Xyz => Some(RotationOrder::Zyx),
        ufbx::RotationOrder::Xzy => Some(RotationOrder::Yzx),
        ufbx::RotationOrder::Yzx => Some(RotationOrder::Xzy),
        ufbx::RotationOrder::Yxz => Some(RotationOrder::Zxy),
        ufbx::RotationOrder::Zxy => Some(RotationOrder::Yxz),
        ufbx::RotationOrder::Zyx => Some(RotationOrder::Xyz),
        ufbx::RotationOrder::Spheric => None,
    }
}
