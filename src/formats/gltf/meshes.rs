//! Reads meshes with their skins, materials and colour textures.
//!
//! An error here does not prevent reading the motion: a broken item is skipped with a warning. A mesh without a skin
//! has one bone: its node, or the nearest ancestor that is in the scene.

mod materials;
mod morph_targets;
mod primitive;

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use glam::Mat4;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{Bone, Keys, Material, Mesh, Node, NodeId, Scene, Surface};
use serde::Deserialize;
use serde_json::Value;

use self::materials::{Images, Lists, item};
use self::primitive::{Primitive, read_primitive};
use super::accessors::{self, Budget, Bytes};
use super::file::{self, File};
use super::invalid::{invalid, json_words, missing};
use super::json::{self, Root};
use super::streams;
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions, Source};

/// The visible parts of a file. Each item is parsed separately, so that a broken item does not affect the other items.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Shown {
    meshes: Vec<Value>,
    skins: Vec<Value>,
    nodes: Vec<NodeJson>,
    materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
    samplers: Vec<Value>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct NodeJson {
    skin: Option<usize>,
    weights: Vec<f32>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct MeshJson {
    name: String,
    primitives: Vec<Primitive>,
    weights: Vec<f32>,
    extras: Value,
}

impl MeshJson {
    /// The names of the mesh's morph targets: from the mesh, as the specification suggests, or from a primitive, as
    /// UniVRM writes them.
    fn target_names(&self) -> Vec<String> {
        let places = [&self.extras]
            .into_iter()
            .chain(self.primitives.iter().map(|primitive| &primitive.extras));
        let lists = places.filter_map(|extras| extras["targetNames"].as_array());
        let names = lists
            .take(1)
            .flatten()
            .map(|name| name.as_str().unwrap_or_default().to_owned());
        names.collect()
    }

    /// The weight curves of each morph target of a node in every animation, with keys in seconds. Empty if the targets
    /// are not read.
    fn motion(&self, file: &File<'_>, node: usize, options: &ReadOptions) -> Result<Vec<Vec<Keys<f32>>>, Failure> {
        let counts = self.primitives.iter().map(|primitive| primitive.targets.len());
        match counts.max().filter(|count| options.morph_targets && *count > 0) {
            Some(count) => file.weights(node, count),
            None => Ok(Vec::new()),
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct SkinJson {
    joints: Vec<usize>,
    inverse_bind_matrices: Option<usize>,
}

/// The buffers of a file, opened at first use.
struct Buffers<'a> {
    root: &'a Root,
    bin: Option<&'a [u8]>,
    open: &'a dyn Fn(&Path) -> Result<Vec<u8>>,
    bytes: Bytes<'a>,
    tried: BTreeSet<usize>,
    /// The numbers of accessors that several primitives share.
    numbers: HashMap<(usize, usize), std::rc::Rc<[f32]>>,
}

impl<'a> Buffers<'a> {
    /// Opens the buffer of a view.
    fn load(&mut self, view: usize) -> Result<(), Failure> {
        let views = &self.root.buffer_views;
        let found = views
            .get(view)
            .ok_or_else(|| missing("/bufferViews", "buffer view", view, views.len()))?;
        let index = streams::buffer_of(found);
        if index < self.bytes.buffers.len() && self.tried.insert(index) {
            let opened = file::buffer(self.root, self.bin, index, self.open);
            self.bytes.buffers[index] = opened.map_err(|error| Box::new(error.diagnostic().clone()))?;
        }
        if streams::is_stream(found) && !self.bytes.views.contains_key(&view) {
            let Bytes { buffers, budget, .. } = &self.bytes;
            let decoded = streams::decode(self.root, &[view], buffers, budget)?;
            self.bytes.views.extend(decoded);
        }
        Ok(())
    }

    fn load_accessor(&mut self, accessor: usize) -> Result<(), Failure> {
        let Some(accessor) = self.root.accessors.get(accessor) else {
            return Ok(());
        };
        let sparse = accessor.sparse.iter();
        let sparse = sparse.flat_map(|sparse| [sparse.indices.buffer_view, sparse.values.buffer_view]);
        let views: Vec<usize> = accessor.buffer_view.into_iter().chain(sparse).collect();
        views.into_iter().try_for_each(|view| self.load(view))
    }

    /// The numbers of an accessor with `columns` components.
    fn numbers(&mut self, index: usize, columns: usize, pointer: &str) -> Result<std::rc::Rc<[f32]>, Failure> {
        if let Some(known) = self.numbers.get(&(index, columns)) {
            return Ok(known.clone());
        }
        self.load_accessor(index)?;
        let numbers = accessors::numbers(self.root, &self.bytes, index, columns, pointer)?;
        let numbers: std::rc::Rc<[f32]> = numbers.into();
        self.numbers.insert((index, columns), numbers.clone());
        Ok(numbers)
    }

    fn indices(&mut self, index: usize, pointer: &str) -> Result<Vec<u32>, Failure> {
        self.load_accessor(index)?;
        accessors::indices(self.root, &self.bytes, index, pointer)
    }

    /// The bytes of a view.
    fn view(&mut self, index: usize) -> Result<&[u8], Failure> {
        self.load(index)?;
        let view = &self.root.buffer_views[index];
        let pointer = format!("/bufferViews/{index}");
        if let Some(decoded) = self.bytes.views.get(&index) {
            return Ok(decoded);
        }
        self.bytes.budget.take((view.byte_length / 4) as u64, &pointer)?;
        let buffer = self.bytes.buffers.get(view.buffer).and_then(|buffer| buffer.as_deref());
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = buffer
            .zip(end)
            .and_then(|(buffer, end)| buffer.get(view.byte_offset..end));
        bytes.ok_or_else(|| invalid(pointer, "the view reaches beyond its buffer").into())
    }

    /// The bytes of a URI.
    fn file(&self, uri: &str, pointer: &str) -> Result<Cow<'a, [u8]>, Failure> {
        file::contents_of(uri, pointer, self.open).map_err(|error| Box::new(error.diagnostic().clone()))
    }
}

/// The mesh and the target in the scene that a morph target of the file became.
#[derive(Clone, Copy, Debug)]
pub(super) struct TargetPlace {
    /// The index of the node in the file, and the number of the target in this node.
    pub(super) of_node: (usize, usize),
    pub(super) mesh: usize,
    pub(super) target: usize,
}

/// Adds the meshes of `file` to the first node of `scene`. `placed` maps each node of the file to its scene node.
/// Returns the places of the morph targets.
pub(super) fn read(
    source: &Source<'_>,
    file: &File<'_>,
    placed: &HashMap<usize, NodeId>,
    options: &ReadOptions,
    scene: &mut Scene,
) -> Vec<TargetPlace> {
    let (mut warnings, mut odd) = (Warnings::default(), Warnings::default());
    let mut targets = Vec::new();
    if let Err(fault) = read_all(
        source,
        file,
        placed,
        options,
        (scene, &mut targets),
        (&mut warnings, &mut odd),
    ) {
        warnings.distinct(*fault);
    }
    scene.warnings.extend(odd.into_kept());
    for fault in warnings.into_kept() {
        let mut warning = Diagnostic::new(Code::IgnoredMesh, fault.message.clone()).times(fault.count);
        if let Some(pointer) = fault.pointer {
            warning = warning.at_pointer(pointer);
        }
        scene.warnings.push(warning);
    }
    targets
}

/// The meshes of a file with numbers that cannot be used in computations.
pub(super) fn broken_numbers(
    source: &Source<'_>,
    placed: &[(usize, NodeId)],
    nodes: &[Node],
    options: &ReadOptions,
) -> Vec<Diagnostic> {
    let open = |beside: &Path| (source.open)(&source.name.with_file_name(beside));
    let Ok(file) = File::read(source.bytes, &open, &options.limits) else {
        return Vec::new();
    };
    let (mut warnings, mut odd) = (Warnings::default(), Warnings::default());
    let mut scene = Scene {
        nodes: nodes.to_vec(),
        ..Scene::default()
    };
    let placed = placed.iter().copied().collect();
    let kept = (&mut warnings, &mut odd);
    if let Err(fault) = read_all(source, &file, &placed, options, (&mut scene, &mut Vec::new()), kept) {
        warnings.distinct(*fault);
    }
    let mut broken = warnings.into_kept();
    broken.retain(|fault| fault.code == Code::NonFiniteValue);
    broken.extend(odd.into_kept());
    broken
}

/// Reads all meshes. The first warnings are about skipped meshes, the others about meshes that are read.
fn read_all(
    source: &Source<'_>,
    file: &File<'_>,
    placed: &HashMap<usize, NodeId>,
    options: &ReadOptions,
    (scene, targets): (&mut Scene, &mut Vec<TargetPlace>),
    (warnings, odd): (&mut Warnings, &mut Warnings),
) -> Result<(), Failure> {
    let (text, bin) = json::split(source.bytes)?;
    let shown: Shown = serde_json::from_str(&String::from_utf8_lossy(text))
        .map_err(|error| invalid("/meshes", format!("the meshes cannot be read: {}", json_words(&error))))?;
    let open = |beside: &Path| (source.open)(&source.name.with_file_name(beside));
    let views: Vec<usize> = (0..file.root.buffer_views.len()).collect();
    let size = source.bytes.len() as u64;
    let streams = streams::length(&file.root, &views).min(size);
    let mut buffers = Buffers {
        root: &file.root,
        bin,
        open: &open,
        bytes: Bytes {
            buffers: std::iter::repeat_with(|| None).take(file.root.buffers.len()).collect(),
            views: HashMap::new(),
            budget: Budget::new(&options.limits, size, streams),
        },
        tried: BTreeSet::new(),
        numbers: HashMap::new(),
    };
    let mut images = Images::default();
    // The scene index of each material of the file, and the texture coordinates that its meshes need.
    let mut materials: HashMap<Option<usize>, usize> = HashMap::new();
    let mut read_materials = Vec::new();
    let lists = Lists {
        materials: &shown.materials,
        textures: &shown.textures,
        images: &shown.images,
        samplers: &shown.samplers,
    };
    let listed = file.nodes()?;
    for (position, node) in listed.iter().enumerate() {
        let Some(mesh) = file.root.nodes[node.index].mesh else {
            continue;
        };
        let json = &shown.nodes[node.index];
        let mesh_json: MeshJson = match item(&shown.meshes, "meshes", "mesh", mesh) {
            Ok(json) => json,
            Err(fault) => {
                warnings.distinct(*fault);
                continue;
            }
        };
        let binding = match json.skin {
            Some(skin) => skin_binding(&shown.skins, skin, placed, &mut buffers),
            None => rigid_binding(file, &listed, position, placed),
        };
        let binding = match binding {
            Ok(binding) => binding,
            Err(fault) => {
                warnings.distinct(*fault);
                continue;
            }
        };
        let weights = if json.weights.is_empty() {
            &mesh_json.weights
        } else {
            &json.weights
        };
        // A mesh without a name would count as the mesh of a skeleton.
        let name = match mesh_json.name.as_str() {
            "" => "Mesh".to_owned(),
            name => name.to_owned(),
        };
        let names = mesh_json.target_names();
        let motion = mesh_json.motion(file, node.index, options).unwrap_or_else(|fault| {
            warnings.distinct(*fault);
            Vec::new()
        });
        let morphs = morph_targets::Stated {
            names: &names,
            weights,
            motion: &motion,
            are_read: options.morph_targets,
        };
        for (number, primitive) in mesh_json.primitives.iter().enumerate() {
            let material = *materials.entry(primitive.material).or_insert_with(|| {
                let read = primitive
                    .material
                    .map(|index| images.material(&lists, index, &mut buffers));
                read_materials.push(match read {
                    None => None,
                    Some(Ok((read, fault))) => {
                        if let Some(fault) = fault {
                            warnings.distinct(*fault);
                        }
                        Some(read)
                    }
                    Some(Err(fault)) => {
                        warnings.distinct(*fault);
                        None
                    }
                });
                read_materials.len() - 1
            });
            let pointer = format!("/meshes/{mesh}/primitives/{number}");
            let uses = read_materials[material].as_ref();
            match read_primitive(primitive, &binding, &morphs, uses, (&mut buffers, odd), &pointer) {
                Ok(None) => {}
                Ok(Some((read, numbers))) => {
                    targets.extend(numbers.into_iter().enumerate().map(|(target, number)| TargetPlace {
                        of_node: (node.index, number),
                        mesh: scene.meshes.len(),
                        target,
                    }));
                    scene.nodes[0].meshes.push(scene.meshes.len());
                    scene.meshes.push(Mesh {
                        name: name.clone(),
                        material_index: material,
                        bones: named(read.bones, scene),
                        ..read
                    });
                }
                Err(fault) => warnings.distinct(*fault),
            }
        }
    }
    let plain = || Material {
        surface: Some(Surface::default()),
        ..Material::default()
    };
    let read = read_materials
        .into_iter()
        .map(|read| read.map_or_else(plain, |read| read.material));
    scene.materials = read.collect();
    scene.textures = images.textures;
    if scene.meshes.is_empty() {
        scene.materials.clear();
        scene.textures.clear();
    }
    Ok(())
}

fn named(mut bones: Vec<Bone>, scene: &Scene) -> Vec<Bone> {
    for bone in &mut bones {
        bone.name.clone_from(&scene.nodes[bone.node.index()].name);
    }
    bones
}

/// The nodes that move a mesh, each with the matrix from the mesh to the node in the bind pose.
struct Binding {
    joints: Vec<(NodeId, Mat4)>,
    is_rigid: bool,
}

fn skin_binding(
    skins: &[Value],
    index: usize,
    placed: &HashMap<usize, NodeId>,
    buffers: &mut Buffers<'_>,
) -> Result<Binding, Failure> {
    let pointer = format!("/skins/{index}");
    let skin: SkinJson = item(skins, "skins", "skin", index)?;
    let matrices = match skin.inverse_bind_matrices {
        None => None,
        Some(accessor) => Some(buffers.numbers(accessor, 16, &format!("{pointer}/inverseBindMatrices"))?),
    };
    let mut joints = Vec::with_capacity(skin.joints.len());
    for (slot, joint) in skin.joints.iter().enumerate() {
        let node = placed.get(joint).ok_or_else(|| {
            let pointer = format!("{pointer}/joints/{slot}");
            invalid(pointer, "the joint is not in the scene")
        })?;
        let matrix = match &matrices {
            None => Mat4::IDENTITY,
            Some(numbers) => {
                let numbers = numbers.get(16 * slot..16 * slot + 16);
                let numbers = numbers.ok_or_else(|| {
                    let pointer = format!("{pointer}/inverseBindMatrices");
                    invalid(pointer, "there are fewer matrices than joints")
                })?;
                let mut matrix = Mat4::from_cols_slice(numbers);
                // Set exactly, because a product may have rounding errors.
                for (column, last) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
                    matrix.col_mut(column).w = last;
                }
                matrix
            }
        };
        if !is_sound(matrix) {
            let pointer = format!("{pointer}/inverseBindMatrices");
            return Err(invalid(pointer, format!("matrix {slot} has no inverse")).into());
        }
        joints.push((*node, matrix));
    }
    Ok(Binding {
        joints,
        is_rigid: false,
    })
}

/// The binding of a rigid mesh: from its node to the nearest ancestor that is in the scene.
fn rigid_binding(
    file: &File<'_>,
    listed: &[file::SceneNode],
    position: usize,
    placed: &HashMap<usize, NodeId>,
) -> Result<Binding, Failure> {
    let mut matrix = Mat4::IDENTITY;
    let mut above = Some(position);
    while let Some(position) = above {
        let index = listed[position].index;
        if let Some(&node) = placed.get(&index).filter(|_| is_sound(matrix)) {
            return Ok(Binding {
                joints: vec![(node, matrix)],
                is_rigid: true,
            });
        }
        matrix = file.transform(index)?.matrix * matrix;
        above = listed[position].parent;
    }
    let pointer = format!("/nodes/{}", listed[position].index);
    Err(invalid(pointer, "no joint moves the mesh of this node").into())
}

fn is_sound(matrix: Mat4) -> bool {
    let determinant = matrix.determinant();
    matrix.is_finite() && determinant.is_finite() && determinant != 0.0
}
