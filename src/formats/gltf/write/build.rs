//! Converts a scene to the tree of objects that glTF writes as JSON.

use glam::Vec3;
use gltf_json::image::MimeType;
use gltf_json::material::{
    self, AlphaCutoff, EmissiveFactor, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor,
};
use gltf_json::mesh::Primitive;
use gltf_json::texture::{Info, Sampler, WrappingMode};
use gltf_json::validation::Checked;
use gltf_json::{Asset, Image, Index, Material, Mesh, Node, Root, Skin, Texture};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::quaternion::unit;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::{self, AlphaMode, Face, MorphCurves, NodeKind, Scene, Surface, Wrap};
use serde_json::json;
use serde_json::value::{RawValue, to_raw_value};

use super::super::Compression;
use super::super::humanoid::VRM_ANIMATION;
use super::animation::{self, Nodes};
use super::buffer::Buffer;
use super::names::Names;
use super::rest::{self, Rest};
use super::text::Animation;
use super::{BASE_COLOR, Content, Document, GltfOptions, GltfReport, mesh, morphs};
use crate::gltf;
use crate::provenance::Provenance;

mod skins;

/// The state of the writer.
struct Builder<'a> {
    scene: &'a Scene,
    options: &'a GltfOptions,
    content: Content,
    root: Root,
    /// The animation for each clip of the scene; `None` if no track of the clip is written.
    animations: Vec<Option<Animation>>,
    /// File nodes with morph targets, each with the mesh of the scene.
    morphed: Vec<(usize, usize)>,
    buffer: Buffer,
    names: Names,
    report: GltfReport,
    /// The last written skin with its inverse bind matrices, because many meshes share one skin.
    last_skin: Option<(Vec<[f32; 16]>, Index<Skin>)>,
}

pub(super) fn document(scene: &Scene, options: &GltfOptions, content: Content) -> Result<Document> {
    let (root, animations, morphed, buffer, names, report) = Default::default();
    let mut builder = Builder {
        scene,
        options,
        content,
        root,
        animations,
        morphed,
        buffer,
        names,
        report,
        last_skin: None,
    };
    builder.asset();
    builder.nodes()?;
    match content {
        Content::Scene => {
            let skinned = builder.rigid_meshes()?;
            builder.skins(&skinned)?;
            builder.materials();
            builder.weights();
        }
        Content::VrmAnimation => builder.humanoid(),
    }
    let Builder {
        mut root,
        animations,
        buffer,
        report,
        ..
    } = builder;
    let bin = buffer.finish(options.compression)?.into_root(&mut root);
    Ok(Document {
        root,
        animations: animations.into_iter().flatten().collect(),
        bin,
        report,
    })
}

impl Builder<'_> {
    fn asset(&mut self) {
        let format = match self.content {
            Content::Scene => const { &gltf::FORMAT.without_functions() },
            Content::VrmAnimation => const { &gltf::VRM_ANIMATION.without_functions() },
        };
        let provenance = Provenance::in_file(self.scene, format);
        let provenance = match self.options.compression {
            Compression::None => provenance,
            _ => provenance.without_reasons(),
        };
        self.root.asset = Asset {
            generator: Some(concat!("mocap ", env!("CARGO_PKG_VERSION")).to_owned()),
            extras: extras(&json!({ "mocap": provenance })),
            ..Asset::default()
        };
    }

    /// Writes the materials that a face uses, and their textures.
    fn materials(&mut self) {
        if self.root.meshes.is_empty() {
            return;
        }
        let (mut images, mut written) = (vec![None; self.scene.textures.len()], Vec::new());
        for material in &self.scene.materials {
            let surface = material.surface;
            let texture = surface.and_then(|surface| surface.texture);
            let texture = texture.filter(|texture| *texture < images.len());
            let wrap = surface.map(|surface| surface.wrap).unwrap_or_default();
            let texture = texture.map(|texture| {
                let known = written.iter().find(|(key, _)| *key == (texture, wrap));
                known.map(|(_, index)| *index).unwrap_or_else(|| {
                    let image = *images[texture].get_or_insert_with(|| self.image(texture));
                    let index = self.texture(image, wrap);
                    written.push(((texture, wrap), index));
                    index
                })
            });
            let Surface {
                metallic,
                roughness,
                emissive,
                ..
            } = surface.unwrap_or_default();
            let color = surface.map_or(BASE_COLOR, |surface| surface.base_color.to_array());
            let (alpha_mode, alpha_cutoff) = match surface.map(|surface| surface.alpha).unwrap_or_default() {
                AlphaMode::Opaque => (material::AlphaMode::Opaque, None),
                AlphaMode::Mask(cutoff) => (material::AlphaMode::Mask, Some(AlphaCutoff(cutoff))),
                AlphaMode::Blend => (material::AlphaMode::Blend, None),
            };
            self.root.materials.push(Material {
                name: Some(material.name.clone()).filter(|name| !name.is_empty()),
                double_sided: material.two_sided,
                alpha_mode: Checked::Valid(alpha_mode),
                alpha_cutoff,
                pbr_metallic_roughness: PbrMetallicRoughness {
                    base_color_factor: PbrBaseColorFactor(color),
                    base_color_texture: texture.map(|index| Info {
                        index,
                        tex_coord: 0,
                        extensions: None,
                        extras: None,
                    }),
                    metallic_factor: StrengthFactor(metallic),
                    roughness_factor: StrengthFactor(roughness),
                    ..PbrMetallicRoughness::default()
                },
                emissive_factor: EmissiveFactor(emissive.to_array()),
                ..Material::default()
            });
        }
    }

    fn image(&mut self, index: usize) -> Index<Image> {
        let texture = &self.scene.textures[index];
        let image = Image {
            buffer_view: Some(self.buffer.push_image(&texture.bytes)),
            mime_type: Some(MimeType(texture.media_type.clone())),
            name: Some(texture.name.clone()).filter(|name| !name.is_empty()),
            uri: None,
            extensions: None,
            extras: None,
        };
        self.root.push(image)
    }

    fn texture(&mut self, source: Index<Image>, wrap: [Wrap; 2]) -> Index<Texture> {
        let mode = |wrap: Wrap| {
            Checked::Valid(match wrap {
                Wrap::Repeat => WrappingMode::Repeat,
                Wrap::Mirror => WrappingMode::MirroredRepeat,
                Wrap::Clamp => WrappingMode::ClampToEdge,
            })
        };
        let [wrap_s, wrap_t] = wrap.map(mode);
        let sampler = Sampler {
            wrap_s,
            wrap_t,
            ..Sampler::default()
        };
        // A texture without a sampler repeats.
        let sampler = (wrap != [Wrap::Repeat; 2]).then(|| self.root.push(sampler));
        self.root.push(Texture {
            name: None,
            sampler,
            source,
            extensions: None,
            extras: None,
        })
    }

    /// Whether the rest pose is only in a skin, so that the nodes may differ from it. If a step set new rest axes, the
    /// nodes must have the rest pose too.
    fn has_bind_pose(&self) -> bool {
        let is_skinned = self.scene.meshes.iter().any(|mesh| !mesh.bones.is_empty());
        is_skinned && !self.scene.metadata.steps.iter().any(AppliedStep::takes_new_axes)
    }

    /// Writes the node graph with its motion, and the scene with its roots.
    fn nodes(&mut self) -> Result<()> {
        let scene = self.scene;
        let mut rest = Vec::with_capacity(scene.nodes.len());
        for node in &scene.nodes {
            rest.push(rest_of(node)?);
        }
        let nodes = match (self.content, scene.animations.len()) {
            // The rest pose of a VRM animation is always the T-pose, even for static nodes.
            (Content::VrmAnimation, _) => Nodes::TPose,
            (Content::Scene, 1) if self.has_bind_pose() => Nodes::OfOneSkinnedAnimation,
            (Content::Scene, 1) => Nodes::OfOneAnimation,
            (Content::Scene, _) => {
                rest::of_all(scene, &mut rest, self.has_bind_pose());
                Nodes::OfAllAnimations
            }
        };
        // glTF allows several animations. Clip names and their order do not change.
        for (index, take) in scene.animations.iter().enumerate() {
            let written = animation::write(
                scene,
                take,
                &mut rest,
                nodes,
                self.options,
                &mut self.buffer,
                &mut self.report,
            )?;
            self.animations.push(written.map(|written| Animation {
                name: Some(scene.metadata.clip_name(take).to_owned()),
                extras: scene.clip_extras(index),
                ..written
            }));
        }

        let (names, renamed) = self.names.of_nodes(scene);
        self.report.renamed = renamed;
        let mut children = vec![Vec::new(); scene.nodes.len()];
        let mut roots = Vec::new();
        for (index, node) in scene.nodes.iter().enumerate() {
            // A weight in a VRM animation does not belong to the body.
            let is_apart = self.content == Content::VrmAnimation && node.face.is_some();
            match node.parent.filter(|_| !is_apart) {
                Some(parent) => children[parent.index()].push(Index::new(index as u32)),
                None => roots.push(Index::new(index as u32)),
            }
        }
        for (((node, name), rest), children) in scene.nodes.iter().zip(names).zip(rest).zip(children) {
            if !rest.is_finite() {
                let message = "a number of its rest pose is not finite";
                return Err(Diagnostic::new(Code::Unrepresentable, message)
                    .in_joint(&node.name)
                    .into());
            }
            let mut written = Node {
                children: Some(children).filter(|children| !children.is_empty()),
                extras: node_extras(node, &name),
                name: Some(name),
                ..Node::default()
            };
            rest.apply(&mut written);
            self.root.nodes.push(written);
        }
        if !roots.is_empty() {
            self.root.scenes.push(gltf_json::Scene {
                nodes: roots,
                name: None,
                extensions: None,
                extras: None,
            });
            self.root.scene = Some(Index::new(0));
        }
        Ok(())
    }

    /// Writes the humanoid bones of nodes, and the face roles of nodes.
    fn humanoid(&mut self) {
        let nodes = self.scene.nodes.iter().enumerate();
        let bone = |(index, node): (usize, &scene::Node)| {
            let bone = node.humanoid_bone?;
            Some((bone.as_str().to_owned(), json!({ "node": index })))
        };
        let bones: serde_json::Map<_, _> = nodes.filter_map(bone).collect();
        let mut extension = json!({ "specVersion": "1.0" });
        if !bones.is_empty() {
            extension["humanoid"] = json!({ "humanBones": bones });
        }
        for (index, node) in self.scene.nodes.iter().enumerate() {
            match &node.face {
                Some(Face::Preset(name)) => extension["expressions"]["preset"][name] = json!({ "node": index }),
                Some(Face::Custom(name)) => extension["expressions"]["custom"][name] = json!({ "node": index }),
                Some(Face::LookAt { offset_from_head }) => {
                    extension["lookAt"] = json!({ "node": index });
                    if let Some(offset) = offset_from_head {
                        extension["lookAt"]["offsetFromHeadBone"] = json!(offset.to_array());
                    }
                }
                None => {}
            }
        }
        let others = [(VRM_ANIMATION.to_owned(), extension)].into_iter().collect();
        #[allow(
            clippy::needless_update,
            reason = "it has more fields where another crate of a program turns features of `gltf` on, as Bevy does"
        )]
        let extensions = gltf_json::extensions::Root {
            others,
            ..Default::default()
        };
        self.root.extensions = Some(extensions);
        self.root.extensions_used.push(VRM_ANIMATION.to_owned());
    }

    /// Writes the meshes without bones, on their nodes. Returns the meshes with bones.
    fn rigid_meshes(&mut self) -> Result<Vec<usize>> {
        let mut skinned = Vec::new();
        for (index, node) in self.scene.nodes.iter().enumerate() {
            let (mut primitives, mut source) = (Vec::new(), None);
            for &index_of_mesh in &node.meshes {
                let mesh = &self.scene.meshes[index_of_mesh];
                if !mesh.bones.is_empty() {
                    skinned.push(index_of_mesh);
                } else if let Some((primitive, vertices)) = mesh::write(mesh, None, 0, &mut self.buffer)? {
                    self.report.vertices += vertices;
                    if !mesh.morph_targets.is_empty() {
                        source = Some(index_of_mesh);
                    }
                    primitives.push(primitive);
                }
            }
            // The primitives of a mesh have the same targets.
            let count = |primitive: &Primitive| primitive.targets.as_ref().map_or(0, Vec::len);
            if primitives.iter().any(|own| count(own) != count(&primitives[0])) {
                primitives.iter_mut().for_each(|own| own.targets = None);
                source = None;
            }
            self.root.nodes[index].mesh = self.mesh(primitives, None, source);
            self.morphed.extend(source.map(|mesh| (index, mesh)));
        }
        Ok(skinned)
    }

    /// Adds a mesh, with the morph targets of a mesh of the scene.
    fn mesh(&mut self, primitives: Vec<Primitive>, name: Option<&str>, source: Option<usize>) -> Option<Index<Mesh>> {
        let targets = source.map_or(&[][..], |mesh| &self.scene.meshes[mesh].morph_targets);
        let names: Vec<&str> = targets.iter().map(|target| target.name.as_str()).collect();
        let has_targets = !targets.is_empty();
        (!primitives.is_empty()).then(|| {
            let name = name.map(str::to_owned);
            self.root.push(Mesh {
                primitives,
                name,
                weights: has_targets.then(|| targets.iter().map(|target| target.weight).collect()),
                extensions: None,
                extras: has_targets.then(|| extras(&json!({ "targetNames": names }))).flatten(),
            })
        })
    }

    /// Writes the curves of morph targets into the animations.
    fn weights(&mut self) {
        for &(node, mesh) in &self.morphed {
            let targets = &self.scene.meshes[mesh].morph_targets;
            let curves = MorphCurves {
                node,
                names: targets.iter().map(|target| target.name.clone()).collect(),
                at_rest: targets.iter().map(|target| target.weight).collect(),
                targets: targets.iter().map(|target| target.weight_keys.clone()).collect(),
            };
            for (index, take) in self.scene.animations.iter().enumerate() {
                let Some(track) = morphs::track(&curves, index) else {
                    continue;
                };
                let animation = self.animations[index].get_or_insert_with(|| Animation {
                    name: Some(self.scene.metadata.clip_name(take).to_owned()),
                    extras: self.scene.clip_extras(index),
                    ..Animation::empty()
                });
                let rate = take.ticks_per_second;
                morphs::write(animation, &track, rate, &mut self.buffer, &mut self.report);
            }
        }
    }
}

/// The rest transform of a node, as translation, rotation and scale.
fn rest_of(node: &scene::Node) -> Result<Rest> {
    // In double precision: for axes with shear, rounding would choose between two rotations.
    let (scale, rotation, _) = node.transform.as_dmat4().to_scale_rotation_translation();
    let (scale, translation) = (
        scale.as_vec3() + Vec3::ZERO,
        node.transform.w_axis.truncate() + Vec3::ZERO,
    );
    match unit(rotation.as_quat()) {
        Some(rotation) if scale.is_finite() && translation.is_finite() => Ok(Rest {
            translation,
            rotation,
            scale,
        }),
        _ => {
            let message = "its transform is not a product of translation, rotation and scale";
            Err(Diagnostic::new(Code::Unrepresentable, message)
                .in_joint(&node.name)
                .into())
        }
    }
}

/// The extras of a node.
fn node_extras(node: &scene::Node, name: &str) -> Option<Box<RawValue>> {
    let mut extras_of_node = serde_json::Map::new();
    if node.name != name {
        extras_of_node.insert("source_name".to_owned(), json!(node.name));
    }
    if node.kind == NodeKind::EndSite {
        extras_of_node.insert("end_site".to_owned(), json!(true));
    }
    if extras_of_node.is_empty() {
        None
    } else {
        extras(&extras_of_node.into())
    }
}

fn extras(value: &serde_json::Value) -> Option<Box<RawValue>> {
    to_raw_value(value).ok()
}
