//! Writes morph targets. Each mesh with targets gets a blend shape, with a channel and a shape for each target. Clips
//! get curves of the channels.

use mocap_scene::error::Result;
use mocap_scene::scene::{Keys, Mesh, MorphTarget};

use super::animation::{Layer, add_curve};
use super::document::{Document, Id};
use super::encode::{Array, Element};
use super::names::Names;
use super::properties::Properties;
use super::space::Space;
use super::time::key_times;
use super::{FbxReport, unrepresentable};
use crate::morph_targets;

/// The value of a channel at weight 1 of a target: channels are percentages.
const FULL: f64 = 100.0;

/// A target in the file.
pub(super) struct WrittenTarget<'a> {
    channel: Id,
    target: &'a MorphTarget,
    /// The value of the channel at weight 1.
    full: f64,
}

impl<'a> WrittenTarget<'a> {
    /// A target with a channel of the original file. `full` is the value of the channel at its last shape.
    pub(super) fn new(channel: Id, target: &'a MorphTarget, full: f64) -> Self {
        Self {
            channel,
            target,
            full: FULL * full,
        }
    }
}

/// The targets of the parts of a mesh, grouped by name. Each entry has the first vertex of a part, and the target in
/// this part.
fn targets<'a>(parts: &[&'a Mesh]) -> Vec<Vec<(usize, &'a MorphTarget)>> {
    let mut found: Vec<Vec<(usize, &MorphTarget)>> = Vec::new();
    let mut start = 0;
    for part in parts {
        for target in &part.morph_targets {
            let is_it = |known: &&mut Vec<(usize, &MorphTarget)>| {
                let (of_part, first) = known[known.len() - 1];
                of_part != start && first.name == target.name
            };
            match found.iter_mut().find(is_it) {
                Some(known) => known.push((start, target)),
                None => found.push(vec![(start, target)]),
            }
        }
        start += part.vertices.len();
    }
    found
}

/// Adds the targets of the mesh with this `geometry`.
pub(super) fn write<'a>(
    geometry: Id,
    name: &str,
    parts: &[&'a Mesh],
    space: &Space,
    document: &mut Document<'_>,
) -> Result<Vec<WrittenTarget<'a>>> {
    let targets = targets(parts);
    if targets.is_empty() {
        return Ok(Vec::new());
    }
    for part in parts {
        morph_targets::check(part).map_err(|message| unrepresentable(name, message))?;
    }
    let (deformer, element) = document.object("Deformer", [name, "Deformer", "BlendShape"]);
    document.add("Deformer", element.child(Element::of("Version", 100)));
    document.connect(deformer, geometry);
    let mut names = Names::default();
    let mut written = Vec::new();
    for parts in targets {
        let first = parts[0].1;
        let name = names.unique(&first.name, "Shape");
        let ids = parts
            .iter()
            .flat_map(|(start, target)| target.vertex_ids.iter().map(move |id| *start as i32 + *id as i32));
        let offsets = parts.iter().flat_map(|(_, target)| &target.offsets);
        let offsets = offsets.flat_map(|offset| space.point(*offset).to_array());
        let (shape, element) = document.object("Geometry", [&name, "Geometry", "Shape"]);
        let mut element = element
            .child(Element::of("Version", 100))
            .child(Element::of("Indexes", Array::ints(ids)))
            .child(Element::of("Vertices", Array::doubles(offsets)));
        if parts.iter().all(|(_, target)| !target.normal_offsets.is_empty()) {
            let normals = parts.iter().flat_map(|(_, target)| &target.normal_offsets);
            let normals = normals.flat_map(|normal| space.direction(*normal).to_array());
            element = element.child(Element::of("Normals", Array::doubles(normals)));
        }
        document.add("Geometry", element);
        let at_rest = FULL * f64::from(first.weight);
        let (channel, element) = document.object("Deformer", [&name, "SubDeformer", "BlendShapeChannel"]);
        let element = element
            .child(Element::of("Version", 100))
            .child(Element::of("DeformPercent", at_rest))
            .child(Element::of("FullWeights", Array::doubles([FULL])))
            .child(Properties::new().number("DeformPercent", at_rest).element());
        document.add("Deformer", element);
        document.connect(channel, deformer);
        document.connect(shape, channel);
        written.push(WrittenTarget::new(channel, first, 1.0));
    }
    Ok(written)
}

/// Adds curves of the targets that a clip animates or sets to another value than at rest. `layers` are the layers of
/// the clips.
pub(super) fn write_curves(
    targets: &[WrittenTarget<'_>],
    layers: &[Layer],
    document: &mut Document<'_>,
    report: &mut FbxReport,
) {
    for (index, layer) in layers.iter().enumerate() {
        for WrittenTarget { channel, target, full } in targets {
            let is_elsewhere = |keys: &&Keys<f32>| keys.values.iter().any(|weight| *weight != target.weight);
            let Some(keys) = target.weight_keys.get(index).filter(is_elsewhere) else {
                continue;
            };
            let at_rest = full * f64::from(target.weight);
            let defaults = Properties::new().number("d|DeformPercent", at_rest);
            let (node, element) = document.object("AnimationCurveNode", ["DeformPercent", "AnimCurveNode", ""]);
            document.add("AnimationCurveNode", element.child(defaults.element()));
            document.connect(node, layer.id);
            document.connect_property(node, *channel, "DeformPercent");
            let ticks: Vec<f64> = (0..keys.len()).map(|key| keys.tick(key)).collect();
            let times = Array::longs(key_times(&ticks, layer.rate));
            let percents = keys.values.iter().map(|weight| (full * f64::from(*weight)) as f32);
            let curve = add_curve(document, at_rest, times, percents);
            document.connect_property(curve, node, "d|DeformPercent");
            report.curves += 1;
            report.keys += keys.len();
        }
    }
}
