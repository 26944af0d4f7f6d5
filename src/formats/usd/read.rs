//! Reads the skeleton of a layer, and its animations.
//!
//! | in the file | in the scene |
//! |---|---|
//! | the first `Skeleton`; a further one gives a warning | nodes |
//! | `joints`, `jointNames` | the graph, and the names |
//! | `restTransforms`, or else `bindTransforms` | the rest pose |
//! | transforms of the prims above the skeleton | a node above its roots, which moves where they move |
//! | each `SkelAnimation` with a joint of the skeleton | an animation; the one that is bound comes first |
//! | time codes | ticks, of `timeCodesPerSecond`, or of the rate that a file of this crate states |
//! | meshes, materials, blend shapes | nothing, with an assumption in the scene |
//! | the selected variant of a set | as if it stood in its prim |
//! | references, payloads, sets of variants without a selection | nothing, with a warning |

mod above;
mod animation;
mod mesh;
mod skeleton;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::{PROVENANCE, USD_HEAD};
use mocap_scene::limits::Limits;
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::{Assumption, Format, NodeId, NodeKind, Scene, Topic, UpAxis};

use super::parse::{self, Layer, Prim};
use super::{BINARY, archive, is_archive};
use crate::provenance::Provenance;
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions, Source};

pub(crate) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let read = read_bytes(source, options, &mut warnings);
    warnings.attach_to(read)
}

/// What a file of this crate says of itself.
pub(super) fn provenance(bytes: &[u8]) -> Option<Provenance> {
    if !super::sniff(bytes) {
        return None;
    }
    stated(&parse::metadata(text(bytes).ok()?, &Limits::default()).ok()?)
}

/// What the metadata of a layer has of that.
fn stated(metadata: &parse::Metadata) -> Option<Provenance> {
    // `{ string mocap = "..." }`
    let mut texts = metadata.get("customLayerData")?.texts.iter();
    texts.find(|text| *text == PROVENANCE)?;
    serde_json::from_str(texts.next()?).ok()
}

/// The text of a file, or of the stage in an archive.
fn text(bytes: &[u8]) -> Result<&[u8], Failure> {
    let bytes = match is_archive(bytes) {
        true => archive::stage(bytes)?,
        false => bytes,
    };
    if bytes.starts_with(BINARY) {
        let message = "the file is binary USD (.usdc), which is not read";
        let help = "make text of it with a tool of USD: usdcat FILE -o FILE.usda; or export .usda, .glb or .fbx";
        return Err(Diagnostic::new(Code::UnreadableFormat, message).help(help).into());
    }
    if !bytes.starts_with(USD_HEAD) {
        let message = "the file does not begin with #usda, as text of USD does";
        return Err(Diagnostic::new(Code::InvalidUsd, message)
            .help("export or download it again")
            .into());
    }
    Ok(bytes)
}

fn read_bytes(source: &Source<'_>, options: &ReadOptions, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let layer = parse::parse(text(source.bytes)?, &options.limits, options.for_comparison)?;
    let skeleton = skeleton::read(&layer, options, warnings)?;
    let mut scene = Scene {
        nodes: skeleton.nodes.clone(),
        ..Scene::default()
    };
    scene.metadata.format = Some(Format::Usd);
    scene.metadata.attribution = stated(&layer.metadata).unwrap_or_default().attribution;
    scene.metadata.metres_per_unit = Some(metres(&layer)?);
    scene.metadata.up = Some(up(&layer)?);
    scene.animations = animation::read(&layer, &skeleton, options, warnings)?;
    joints_that_are_no_tips(&mut scene);
    check_end(&layer, warnings);
    if options.for_comparison {
        mesh::add(&layer, &skeleton, source, &mut scene);
    }
    let meshes = layer.prims.iter().filter(|prim| prim.kind == "Mesh").count();
    unread(&layer, options, &mut scene);
    if meshes > 0 && !options.for_comparison {
        scene.metadata.assumptions.push(Assumption {
            topic: Topic::Meshes,
            choice: "left out".to_owned(),
            reason: format!("the skeleton and the motion of USD are read, and the file has meshes ({meshes})"),
            confidence: None,
        });
    }
    if scene.animations.is_empty() {
        warnings.push(Code::NoMotion, || {
            let message = "no SkelAnimation drives the skeleton, and it does not move: the scene has no animation";
            Diagnostic::new(Code::NoMotion, message)
        });
    }
    Ok(scene)
}

/// Counts what the file has beside the skeleton and its motion.
fn unread(layer: &Layer, options: &ReadOptions, scene: &mut Scene) {
    let count = |is_it: &dyn Fn(&Prim) -> bool| layer.prims.iter().filter(|prim| is_it(prim)).count();
    scene.lose(DataKind::Cameras, count(&|prim| prim.kind == "Camera"));
    scene.lose(DataKind::Lights, count(&|prim| prim.kind.ends_with("Light")));
    scene.lose(DataKind::FaceCurves, animation::moving_shapes(layer));
    if options.for_comparison || options.without_meshes {
        return;
    }
    // A mesh of this program that draws the skeleton has no material.
    let custom = layer.metadata.get("customLayerData");
    let is_ours = custom.is_some_and(|custom| custom.texts.iter().any(|text| text == PROVENANCE));
    let is_mesh = |prim: &Prim| prim.kind == "Mesh" && !(is_ours && prim.texts("material:binding").is_empty());
    scene.lose(DataKind::Meshes, count(&is_mesh));
    let is_skin = |prim: &Prim| is_mesh(prim) && prim.attributes.contains_key("primvars:skel:jointIndices");
    scene.lose(DataKind::Skins, count(&is_skin));
    scene.lose(
        DataKind::UvSets,
        count(&|prim| is_mesh(prim) && prim.attributes.contains_key("primvars:st")),
    );
    scene.lose(DataKind::Materials, count(&|prim| prim.kind == "Material"));
    let is_texture = |prim: &Prim| prim.texts("info:id").iter().any(|id| id == "UsdUVTexture");
    scene.lose(DataKind::Textures, count(&is_texture));
    scene.lose(DataKind::MorphTargets, count(&|prim| prim.kind == "BlendShape"));
}

/// Warns of samples behind the end that the layer states: other programs do not play them.
fn check_end(layer: &Layer, warnings: &mut Warnings) {
    /// A part of a frame by which a rounded end may be before its time code.
    const ROUNDING: f64 = 1e-3;
    let attributes = layer
        .prims
        .iter()
        .filter(|prim| prim.kind == "SkelAnimation")
        .flat_map(|prim| prim.attributes.values());
    let times = attributes
        .flat_map(|attribute| &attribute.samples)
        .map(|(time, _)| *time);
    let last = times.fold(f64::NEG_INFINITY, f64::max);
    if let Some(end) = metadata_number(layer, "endTimeCode").filter(|end| *end < last - ROUNDING) {
        warnings.push(Code::FrameCount, || {
            Diagnostic::new(
                Code::FrameCount,
                "the motion goes on behind the end that the file states",
            )
            .expected_found(format!("time codes up to endTimeCode, {end}"), last.to_string())
            .help("all time codes were read; other programs stop at endTimeCode: correct it")
        });
    }
}

/// End sites are tips that do not move: what the file marks as one, and moves or has below it a joint, is a joint.
fn joints_that_are_no_tips(scene: &mut Scene) {
    let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    for node in channels.filter_map(|channel| channel.node).collect::<Vec<NodeId>>() {
        make_joint(scene, node);
    }
    // Children stand after their parents, so that a joint reaches all above it.
    for index in (0..scene.nodes.len()).rev() {
        let node = &scene.nodes[index];
        if let Some(parent) = node.parent.filter(|_| node.kind != NodeKind::EndSite) {
            make_joint(scene, parent);
        }
    }
}

fn make_joint(scene: &mut Scene, node: NodeId) {
    let node = &mut scene.nodes[node.index()];
    if node.kind == NodeKind::EndSite {
        node.kind = NodeKind::Joint;
    }
}

fn metadata_number(layer: &Layer<'_>, name: &str) -> Option<f64> {
    layer.metadata.get(name)?.numbers.first().copied()
}

/// Metres in a unit: the centimetre where the layer states none, as USD has it.
fn metres(layer: &Layer<'_>) -> Result<f64, Failure> {
    /// Metres in a unit where the layer states none: USD's default, the centimetre.
    const DEFAULT: f64 = 0.01;
    let stated = metadata_number(layer, "metersPerUnit").unwrap_or(DEFAULT);
    Ok(mocap_scene::limits::positive(
        Code::InvalidUsd,
        "metersPerUnit",
        stated,
    )?)
}

/// The axis that points up: +Y where the layer states none, as USD has it.
fn up(layer: &Layer<'_>) -> Result<UpAxis, Failure> {
    let stated = layer.metadata.get("upAxis").and_then(|value| value.texts.first());
    match stated.map(String::as_str) {
        None | Some("Y") => Ok(UpAxis::Y),
        Some("Z") => Ok(UpAxis::Z),
        Some(other) => {
            let message = "upAxis must be Y or Z";
            Err(Diagnostic::new(Code::InvalidUsd, message)
                .expected_found("\"Y\" or \"Z\"", format!("{other:?}"))
                .into())
        }
    }
}
