//! Writes the clips of a scene into the original file. All elements except animations stay unchanged.
//!
//! A joint of the scene is a model of the file, with other axes and another unit. A constant transform, which follows
//! from both rest poses, converts between the joint and the model. The writer first writes a short part of each clip,
//! reads this file again, and compares it with the scene. If the file cannot take the clips, the writer makes a new
//! file from the scene.

mod edits;
mod excerpt;
mod pivots;
mod text;
mod tree;

use std::borrow::Cow;
use std::collections::{BTreeMap, HashSet};

use glam::{DMat3, DMat4, DVec3};
use mocap_scene::files::FBX_HEAD;
use mocap_scene::pose::{Binding, Trs};
use mocap_scene::scene::{Animation, Channel, FbxOriginal, Keys, Mesh, Node, NodeId, RotationOrder, Scene, UpAxis};
use ufbx::LoadOpts;

use self::edits::{Edits, OF_ANIMATIONS};
use self::excerpt::Excerpt;
use self::pivots::{Pivots, rotation};
use self::tree::{RawElement, RawFile};
use super::blend_shapes::{WrittenTarget, write_curves};
use super::document::{Document, Id, SCENE_ROOT};
use super::encode;
use super::names::Names;
use super::skeleton::Placed;
use super::space::Space;
use super::time::Rate;
use super::{FbxOptions, FbxReport, animation};
use crate::ReadOptions;
use crate::fbx::matrix::matrix;
use crate::fbx::read;
use crate::provenance::Provenance;

/// The largest distance of a model from its joint, in metres or relative to the distance from the origin: several
/// roundings to single precision.
const SAME: f64 = 1e-4;

/// The largest relative change of a value that counts as rounding.
const ROUNDING: f64 = 1e-5;

/// The bytes of the original file of `scene`, with the clips of the scene.
///
/// # Errors
/// The reason why the file cannot take the clips, as a phrase.
pub(super) fn write(
    scene: &Scene,
    original: &FbxOriginal,
    options: &FbxOptions,
) -> Result<(Vec<u8>, FbxReport), String> {
    let bytes: Cow<'_, [u8]> = match original.bytes.starts_with(FBX_HEAD) {
        true => (&*original.bytes).into(),
        false => text::binary(&original.bytes)?.into(),
    };
    let file = RawFile::parse(&bytes).ok_or("its elements end too early")?;
    let has_curves = scene
        .meshes
        .iter()
        .flat_map(|mesh| &mesh.morph_targets)
        .any(|target| !target.weight_keys.is_empty());
    let plain = load(&bytes, !has_curves)?;
    let models = Models::new(scene, original, &plain)?;
    if options.error_bound.is_some() && models.pivots.iter().any(|pivots| !pivots.are_none()) {
        return Err("its joints have pivots, for which mocap cannot guarantee an error bound".to_owned());
    }
    let kept = Kept {
        original,
        options,
        file,
        plain,
        models,
    };
    // Reading all clips again would need several times their memory.
    let excerpt = Excerpt::of(scene);
    excerpt.compare(&kept.with_clips(&excerpt.scene)?.0)?;
    kept.with_clips(scene)
}

/// The original file, and the models of the joints in it.
struct Kept<'a> {
    original: &'a FbxOriginal,
    options: &'a FbxOptions,
    file: RawFile<'a>,
    plain: ufbx::SceneRoot,
    models: Models,
}

impl Kept<'_> {
    /// The bytes of the file with the clips of `scene`.
    fn with_clips(&self, scene: &Scene) -> Result<(Vec<u8>, FbxReport), String> {
        let (file, plain, models, options) = (&self.file, &self.plain, &self.models, self.options);
        let objects = file.section("Objects").ok_or("it has no objects")?;
        let last = objects.children.iter().filter_map(RawElement::id).max();
        let mut document = Document::after(last.unwrap_or_default());
        let mut report = FbxReport {
            bones: models.placed.len(),
            is_kept: true,
            vertices: scene.meshes.iter().map(|mesh| mesh.vertices.len()).sum(),
            ..FbxReport::default()
        };
        let mut names = Names::default();
        if self.original.keeps_clips {
            let own = plain.anim_stacks.iter();
            own.for_each(|stack| drop(names.unique(&stack.element.name, "Take")));
        }
        let space = Space::new(1.0, UpAxis::Y, UpAxis::Y);
        let clips = animation::write(
            &models.scene(scene),
            &space,
            &models.placed,
            options,
            &mut names,
            &mut document,
            &mut report,
        )
        .map_err(|error| error.to_string())?;
        let targets = targets(&scene.meshes, plain);
        write_curves(&targets, &clips.layers, &mut document, &mut report);
        let removed: HashSet<i64> = match self.original.keeps_clips {
            true => HashSet::new(),
            false => {
                let gone = objects
                    .children
                    .iter()
                    .filter(|object| OF_ANIMATIONS.contains(&object.name));
                gone.filter_map(RawElement::id).collect()
            }
        };
        let rate = Rate::of(scene, options).map_err(|error| error.to_string())?;
        // Keep the rate of the file for the remaining clips, unless the new clips have a higher rate.
        let is_faster = plain.settings.frames_per_second >= rate.frames_per_second();
        let rate = (!(self.original.keeps_clips && is_faster)).then_some(rate);
        let provenance = Provenance::in_file(scene, &crate::fbx::FORMAT);
        let edits = Edits {
            provenance: serde_json::to_string(&provenance).unwrap_or_default(),
            active: clips.ends.first().map(|(name, _)| name.clone()),
            rate,
            removed,
            clips: &clips.ends,
        };
        let sections = edits.sections(file, document);
        let bytes = encode::kept(sections, file.version, file.footer).map_err(|error| error.to_string())?;
        report.bytes = bytes.len();
        Ok((bytes, report))
    }
}

fn load(bytes: &[u8], without_meshes: bool) -> Result<ufbx::SceneRoot, String> {
    let limited = || read::limited(bytes, &ReadOptions::default());
    let load = LoadOpts {
        temp_allocator: limited(),
        result_allocator: limited(),
        file_format: ufbx::FileFormat::Fbx,
        ignore_geometry: without_meshes,
        ignore_embedded: true,
        retain_dom: true,
        ..LoadOpts::default()
    };
    ufbx::load_memory(bytes, load).map_err(|error| error.description.to_string())
}

/// The number of an object in the file.
fn id(element: &ufbx::Element) -> Option<Id> {
    let values = &element.dom_node.as_ref()?.values;
    values.first().map(|value| value.value_int)
}

/// The models of the nodes of a scene.
struct Models {
    placed: Vec<Placed>,
    pivots: Vec<Pivots>,
    /// The transform from each model to its joint, in the coordinate frame of the joint.
    to_joint: Vec<DMat4>,
    metres_per_unit: f64,
}

impl Models {
    fn new(scene: &Scene, original: &FbxOriginal, plain: &ufbx::Scene) -> Result<Self, String> {
        let metadata = &scene.metadata;
        if scene.nodes.len() != original.nodes.len()
            || (metadata.metres_per_unit, metadata.up) != (Some(1.0), Some(UpAxis::Y))
        {
            return Err("the skeleton has changed".to_owned());
        }
        let axes = &plain.settings.axes;
        let axes = [axes.right, axes.up, axes.front].map(axis);
        let [Some(right), Some(up), Some(front)] = axes else {
            return Err("it does not state its axes".to_owned());
        };
        let rotation_of_axes = DMat3::from_cols(right, up, front).transpose();
        if rotation_of_axes.determinant() < 0.5 {
            return Err("its axes are left-handed".to_owned());
        }
        let metres_per_unit = plain.settings.unit_meters;
        let to_scene = DMat4::from_mat3(rotation_of_axes * metres_per_unit);
        let mut made = Self {
            placed: Vec::with_capacity(scene.nodes.len()),
            pivots: Vec::with_capacity(scene.nodes.len()),
            to_joint: Vec::with_capacity(scene.nodes.len()),
            metres_per_unit,
        };
        let mut worlds: Vec<DMat4> = Vec::with_capacity(scene.nodes.len());
        for (node, index) in scene.nodes.iter().zip(original.nodes.iter()) {
            let other = || format!("the joint \"{}\" has changed", node.name);
            let model = plain.nodes.get(*index as usize).ok_or_else(other)?;
            if read::node_name(model) != node.name {
                return Err(other());
            }
            let above = node.parent.map_or(DMat4::IDENTITY, |parent| worlds[parent.index()]);
            let world = above * node.transform.as_dmat4();
            let to_joint = world.inverse() * to_scene * matrix(&model.node_to_world);
            // If a joint is not at the position of its model, the rest pose of the scene has changed.
            if !to_joint.is_finite()
                || to_joint.w_axis.truncate().length() > SAME * (1.0 + world.w_axis.truncate().length())
            {
                return Err(format!("the rest pose of \"{}\" has changed", node.name));
            }
            let local = match node.parent {
                Some(parent) => made.to_joint[parent.index()].inverse() * node.transform.as_dmat4() * to_joint,
                None => to_scene.inverse() * node.transform.as_dmat4() * to_joint,
            };
            if !model.is_root && !is_near(local, matrix(&model.node_to_parent)) {
                return Err(format!("\"{}\" inherits scale in an unusual way", node.name));
            }
            let pivots = Pivots::of(model);
            let (scale, turn, translation) = local.to_scale_rotation_translation();
            let id = if model.is_root {
                Some(SCENE_ROOT)
            } else {
                id(&model.element)
            };
            made.placed.push(Placed {
                id: id.ok_or_else(other)?,
                translation: pivots.translation(translation, turn, scale),
                rotation: turn * pivots.post_rotation,
                scale,
                pre_rotation: rotation(model, "PreRotation"),
                order: match model.use_rotation_space {
                    true => {
                        read::rotation_order(model.rotation_order).ok_or("a joint has the rotation order SphericXYZ")?
                    }
                    false => RotationOrder::Zyx,
                },
                world: matrix(&model.node_to_world),
            });
            made.pivots.push(pivots);
            made.to_joint.push(to_joint);
            worlds.push(world);
        }
        Ok(made)
    }

    /// The scene, with its values converted to curves of the models.
    fn scene(&self, scene: &Scene) -> Scene {
        let nodes = scene.nodes.iter().zip(&self.placed);
        let node = |(node, placed): (&Node, &Placed)| Node {
            transform: DMat4::from_scale_rotation_translation(placed.scale, placed.rotation, placed.translation)
                .as_mat4(),
            ..node.clone()
        };
        let mut made = Scene {
            nodes: nodes.map(node).collect(),
            metadata: scene.metadata.clone(),
            ..Scene::default()
        };
        made.metadata.metres_per_unit = Some(self.metres_per_unit);
        made.animations = scene.animations.iter().map(|clip| self.clip(scene, clip)).collect();
        made
    }

    fn clip(&self, scene: &Scene, clip: &Animation) -> Animation {
        let binding = Binding::new(scene, clip);
        let channels = binding.driven().filter_map(|(node, channel)| {
            let is_model = self.placed[node.index()].id != SCENE_ROOT;
            is_model.then(|| self.channel(scene, node, &clip.channels[channel]))
        });
        Animation {
            name: clip.name.clone(),
            ticks_per_second: clip.ticks_per_second,
            duration: clip.duration,
            channels: channels.collect(),
        }
    }

    fn channel(&self, scene: &Scene, node: NodeId, channel: &Channel) -> Channel {
        let index = node.index();
        let (placed, pivots) = (&self.placed[index], &self.pivots[index]);
        let from_parent = scene.nodes[index]
            .parent
            .map_or(DMat4::IDENTITY, |parent| self.to_joint[parent.index()].inverse());
        let rest = Trs::from_matrix(scene.nodes[index].transform);
        let ticks = ticks(channel);
        let (mut translations, mut rotations, mut scales) = (Vec::new(), Vec::new(), Vec::new());
        for tick in &ticks {
            let joint = channel.sample(*tick, rest).matrix().as_dmat4();
            let local = from_parent * joint * self.to_joint[index];
            let (scale, turn, translation) = local.to_scale_rotation_translation();
            translations.push(pivots.translation(translation, turn, scale));
            rotations.push((turn * pivots.post_rotation).as_quat());
            scales.push(scale);
        }
        let keys = |values: Vec<DVec3>, rest: DVec3| {
            let is_same = |value: &DVec3| value.distance(rest) <= ROUNDING * (1.0 + rest.length());
            let values: Vec<_> = values
                .iter()
                .map(|value| {
                    if is_same(value) {
                        rest.as_vec3()
                    } else {
                        value.as_vec3()
                    }
                })
                .collect();
            match values.iter().all(|value| *value == values[0]) {
                true => Keys::constant(values[0]),
                false => Keys::at_ticks(values, ticks.clone()),
            }
        };
        Channel {
            node_name: channel.node_name.clone(),
            node: Some(node),
            position_keys: keys(translations, placed.translation),
            rotation_keys: Keys::at_ticks(rotations, ticks.clone()),
            scaling_keys: keys(scales, placed.scale),
        }
    }
}

/// The direction of an axis that the file states.
fn axis(axis: ufbx::CoordinateAxis) -> Option<DVec3> {
    use ufbx::CoordinateAxis as Axis;
    Some(match axis {
        Axis::PositiveX => DVec3::X,
        Axis::NegativeX => DVec3::NEG_X,
        Axis::PositiveY => DVec3::Y,
        Axis::NegativeY => DVec3::NEG_Y,
        Axis::PositiveZ => DVec3::Z,
        Axis::NegativeZ => DVec3::NEG_Z,
        _ => return None,
    })
}

fn is_near(a: DMat4, b: DMat4) -> bool {
    let size = a.x_axis.length() + a.y_axis.length() + a.z_axis.length();
    let axes = [(a.x_axis, b.x_axis), (a.y_axis, b.y_axis), (a.z_axis, b.z_axis)];
    axes.iter().all(|(a, b)| a.distance(*b) <= SAME * size)
        && a.w_axis.distance(b.w_axis) <= SAME * (size + a.w_axis.truncate().length())
}

/// The ticks of all keys of a channel.
fn ticks(channel: &Channel) -> Vec<f64> {
    fn of<T>(keys: &Keys<T>) -> impl Iterator<Item = f64> {
        let count = if keys.len() > 1 { keys.len() } else { 0 };
        (0..count).map(|key| keys.tick(key))
    }
    let (positions, rotations, scales) = (
        of(&channel.position_keys),
        of(&channel.rotation_keys),
        of(&channel.scaling_keys),
    );
    let mut ticks: Vec<f64> = positions.chain(rotations).chain(scales).collect();
    ticks.sort_unstable_by(f64::total_cmp);
    ticks.dedup();
    if ticks.is_empty() {
        ticks.push(0.0);
    }
    ticks
}

/// The morph targets of meshes, with the channels of the same names in the file.
fn targets<'a>(meshes: &'a [Mesh], plain: &ufbx::Scene) -> Vec<WrittenTarget<'a>> {
    let mut found: BTreeMap<Id, WrittenTarget<'a>> = BTreeMap::new();
    for target in meshes
        .iter()
        .flat_map(|mesh| &mesh.morph_targets)
        .filter(|target| !target.weight_keys.is_empty())
    {
        for channel in plain
            .blend_channels
            .iter()
            .filter(|channel| *channel.element.name == *target.name)
        {
            let full = read::full_weight(channel);
            if let Some(id) = id(&channel.element) {
                found.entry(id).or_insert_with(|| WrittenTarget::new(id, target, full));
            }
        }
    }
    found.into_values().collect()
}
