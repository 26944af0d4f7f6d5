//! Reads the skeleton of a layer, and its animations.
//!
//! | file | scene |
//! |---|---|
//! | the first `Skeleton`; a further one gives a warning | nodes |
//! | `joints`, `jointNames` | the graph, and the names |
//! | `restTransforms`, or else `bindTransforms` | the rest pose |
//! | transforms of the skeleton's ancestor prims | a parent node of the roots, which moves if an ancestor prim moves |
//! | each `SkelAnimation` with a joint of the skeleton | an animation; the bound animation comes first |
//! | time codes | ticks, of `timeCodesPerSecond`, or of the rate that a file of this crate states |
//! | skinned meshes, with their materials | meshes |
//! | blend shapes, and their weights in animations | morph targets, on request |
//! | meshes without a joint of the skeleton | nothing, with an assumption in the scene |
//! | the selected variant of a set | part of its prim |
//! | references, payloads, sets of variants without a selection | nothing, with a warning |

mod above;
mod animation;
mod blend_shapes;
mod faces;
mod index;
mod material;
mod mesh;
mod skeleton;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::{PROVENANCE, USD_HEAD};
use mocap_scene::limits::Limits;
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::{Format, NodeId, NodeKind, Scene, UpAxis};

use self::blend_shapes::Shapes;
use self::index::Index;
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

/// The provenance in a file of this crate.
pub(super) fn provenance(bytes: &[u8]) -> Option<Provenance> {
    if !super::sniff(bytes) {
        return None;
    }
    stated(&parse::metadata(text(bytes).ok()?, &Limits::default()).ok()?)
}

/// The provenance in the metadata of a layer.
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
        let message = "the file is binary USD (.usdc), which mocap cannot read";
        let help = "convert it to text with a USD tool: usdcat FILE -o FILE.usda; or export .usda, .glb or .fbx";
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
    let layer = parse::parse(text(source.bytes)?, &options.limits, !options.without_meshes)?;
    let skeleton = skeleton::read(&layer, options, warnings)?;
    let mut scene = Scene {
        nodes: skeleton.nodes.clone(),
        ..Scene::default()
    };
    scene.metadata.format = Some(Format::Usd);
    scene.metadata.attribution = stated(&layer.metadata).unwrap_or_default().attribution;
    scene.metadata.metres_per_unit = Some(metres(&layer)?);
    scene.metadata.up = Some(up(&layer)?);
    let (animations, weights) = animation::read(&layer, &skeleton, options, warnings)?;
    scene.animations = animations;
    joints_that_are_no_tips(&mut scene);
    check_end(&layer, warnings);
    scene.lose(DataKind::Cameras, count(&layer, |prim| prim.kind == "Camera"));
    scene.lose(DataKind::Lights, count(&layer, |prim| prim.kind.ends_with("Light")));
    if options.without_meshes || !options.morph_targets {
        scene.lose(DataKind::FaceCurves, animation::moving_shapes(&layer));
    }
    if !options.without_meshes {
        let index = Index::of(&layer);
        let mut shapes = Shapes::new(&index, &weights, options);
        mesh::add(&index, &skeleton, source, options, &mut shapes, (&mut scene, warnings));
        scene.lose(DataKind::MorphTargets, shapes.unread());
    }
    if scene.animations.is_empty() {
        warnings.push(Code::NoMotion, || {
            let message = "the skeleton has no SkelAnimation and does not move: the scene has no animation";
            Diagnostic::new(Code::NoMotion, message)
        });
    }
    Ok(scene)
}

/// The number of prims for which `is_it` holds.
fn count(layer: &Layer<'_>, is_it: impl Fn(&Prim) -> bool) -> usize {
    layer.prims.iter().filter(|prim| is_it(prim)).count()
}

/// Warns about samples after the end that the layer states, because other programs do not play them.
fn check_end(layer: &Layer, warnings: &mut Warnings) {
    /// The largest rounding of the stated end, in frames.
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
                "the motion continues after the end that the file states",
            )
            .expected_found(format!("time codes up to endTimeCode, {end}"), last.to_string())
            .help(
                "mocap read all time codes; other programs stop at endTimeCode. Set endTimeCode to the last time code",
            )
        });
    }
}

/// End sites are static tips. A marked end site with motion, or with a descendant joint, becomes a joint.
fn joints_that_are_no_tips(scene: &mut Scene) {
    let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    for node in channels.filter_map(|channel| channel.node).collect::<Vec<NodeId>>() {
        make_joint(scene, node);
    }
    // Children follow their parents, so a joint affects all its ancestors.
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

/// Metres per unit of the layer. If the layer states no unit, USD's default: the centimetre.
fn metres(layer: &Layer<'_>) -> Result<f64, Failure> {
    /// Metres per unit if the layer states none: USD's default, the centimetre.
    const DEFAULT: f64 = 0.01;
    let stated = metadata_number(layer, "metersPerUnit").unwrap_or(DEFAULT);
    Ok(mocap_scene::limits::positive(
        Code::InvalidUsd,
        "metersPerUnit",
        stated,
    )?)
}

/// The up axis of the layer. If the layer states none, USD's default: +Y.
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
