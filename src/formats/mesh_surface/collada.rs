//! The triangles of a COLLADA file (1.4 and 1.5).
//!
//! As in the viewers of ROS, `<unit>` converts lengths to metres, and `<up_axis>` is ignored.

use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec3};
use roxmltree::{Document, Node, ParsingOptions};

use super::{Corners, push_polygon};

/// The largest nesting depth of nodes.
const DEEPEST: usize = 64;

/// The largest number of elements. A mesh has a few dozen.
const MOST_ELEMENTS: u32 = 1 << 20;

/// The corners of all shown triangles, at most `most`.
pub(super) fn corners(bytes: &[u8], most: usize) -> Option<Corners> {
    let text = std::str::from_utf8(bytes).ok()?;
    let options = ParsingOptions {
        nodes_limit: MOST_ELEMENTS,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, options).ok()?;
    let root = document.root_element();
    let by_id = root
        .descendants()
        .filter_map(|node| Some((node.attribute("id")?, node)))
        .collect();
    let meter = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let meter = meter.and_then(|unit| unit.attribute("meter")?.parse::<f64>().ok());
    let mut reader = Reader {
        by_id,
        most,
        corners: Vec::new(),
    };
    let unit = DMat4::from_scale(DVec3::splat(meter.filter(|meter| *meter > 0.0).unwrap_or(1.0)));
    match root.descendants().find(|node| node.has_tag_name_of("visual_scene")) {
        Some(scene) => reader.node(scene, unit, 0)?,
        // Without a scene each geometry is shown once.
        None => {
            for geometry in root.descendants().filter(|node| node.has_tag_name_of("geometry")) {
                reader.geometry(geometry, unit)?;
            }
        }
    }
    Some(reader.corners)
}

/// COLLADA has a namespace, but some files have another namespace or none.
trait TagNameOf {
    fn has_tag_name_of(&self, name: &str) -> bool;
}

impl TagNameOf for Node<'_, '_> {
    fn has_tag_name_of(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|child| child.has_tag_name_of(name))
}

fn floats(node: Node<'_, '_>) -> Option<Vec<f64>> {
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    words.map(|word| word.parse().ok()).collect()
}

fn whole(node: Node<'_, '_>) -> Option<Vec<usize>> {
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    words.map(|word| word.parse().ok()).collect()
}

/// The parts of a file that are read.
struct Reader<'a, 'i> {
    by_id: HashMap<&'a str, Node<'a, 'i>>,
    most: usize,
    corners: Corners,
}

impl<'a, 'i> Reader<'a, 'i> {
    fn named(&self, node: Node<'a, 'i>, attribute: &str) -> Option<Node<'a, 'i>> {
        self.by_id.get(node.attribute(attribute)?.strip_prefix('#')?).copied()
    }

    /// Adds the geometry of a node and its descendants.
    fn node(&mut self, node: Node<'a, 'i>, above: DMat4, depth: usize) -> Option<()> {
        if depth > DEEPEST {
            return None;
        }
        let mut matrix = above;
        for part in node.children().filter(Node::is_element) {
            matrix *= match part.tag_name().name() {
                "matrix" => DMat4::from_cols_array(&floats(part)?.try_into().ok()?).transpose(),
                "translate" => DMat4::from_translation(DVec3::from_array(floats(part)?.try_into().ok()?)),
                "scale" => DMat4::from_scale(DVec3::from_array(floats(part)?.try_into().ok()?)),
                "rotate" => {
                    let [x, y, z, degrees]: [f64; 4] = floats(part)?.try_into().ok()?;
                    let axis = DVec3::new(x, y, z).try_normalize().unwrap_or(DVec3::Z);
                    DMat4::from_quat(DQuat::from_axis_angle(axis, degrees.to_radians()))
                }
                _ => continue,
            };
        }
        for part in node.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "node" => self.node(part, matrix, depth + 1)?,
                "instance_node" => self.node(self.named(part, "url")?, matrix, depth + 1)?,
                "instance_geometry" => self.geometry(self.named(part, "url")?, matrix)?,
                _ => {}
            }
        }
        Some(())
    }

    fn geometry(&mut self, geometry: Node<'a, 'i>, matrix: DMat4) -> Option<()> {
        let Some(mesh) = child(geometry, "mesh") else {
            return Some(());
        };
        for faces in mesh.children().filter(Node::is_element) {
            let kind = faces.tag_name().name();
            if !["triangles", "polylist", "polygons"].contains(&kind) {
                continue;
            }
            let places = self.places(faces, matrix)?;
            let (offset, stride) = layout(faces)?;
            let counts = child(faces, "vcount").map(whole).unwrap_or(Some(Vec::new()))?;
            for list in faces.children().filter(|node| node.has_tag_name_of("p")) {
                let indices = whole(list)?;
                let corners: Option<Vec<DVec3>> = indices
                    .iter()
                    .skip(offset)
                    .step_by(stride)
                    .map(|index| places.get(*index).copied())
                    .collect();
                self.faces(kind, &corners?, &counts)?;
            }
        }
        Some(())
    }

    fn faces(&mut self, kind: &str, mut corners: &[DVec3], counts: &[usize]) -> Option<()> {
        match kind {
            "triangles" => self.corners.extend(&corners[..corners.len() / 3 * 3]),
            "polygons" => push_polygon(corners, &mut self.corners),
            _ => {
                for count in counts {
                    let (polygon, rest) = corners.split_at_checked(*count)?;
                    push_polygon(polygon, &mut self.corners);
                    corners = rest;
                }
            }
        }
        (self.corners.len() <= self.most).then_some(())
    }

    /// The positions that the corners of faces index.
    fn places(&self, faces: Node<'a, 'i>, matrix: DMat4) -> Option<Vec<DVec3>> {
        let input = |node: Node<'a, 'i>, semantic: &str| {
            let mut inputs = node.children().filter(|node| node.has_tag_name_of("input"));
            inputs.find(|input| input.attribute("semantic") == Some(semantic))
        };
        let vertices = self.named(input(faces, "VERTEX")?, "source")?;
        let source = self.named(input(vertices, "POSITION")?, "source")?;
        let numbers = floats(child(source, "float_array")?)?;
        let accessor = child(source, "technique_common").and_then(|common| child(common, "accessor"));
        let stride = accessor
            .and_then(|accessor| accessor.attribute("stride")?.parse().ok())
            .unwrap_or(3)
            .max(3);
        let places = numbers.chunks_exact(stride);
        Some(
            places
                .map(|place| matrix.transform_point3(DVec3::from_slice(place)))
                .collect(),
        )
    }
}

/// The position of the vertex index among a corner's numbers, and the count of numbers per corner.
fn layout(faces: Node<'_, '_>) -> Option<(usize, usize)> {
    let inputs = faces.children().filter(|node| node.has_tag_name_of("input"));
    let offset = |input: &Node<'_, '_>| input.attribute("offset").unwrap_or("0").parse::<usize>().ok();
    let mut of_vertex = inputs
        .clone()
        .filter(|input| input.attribute("semantic") == Some("VERTEX"));
    let last = inputs.filter_map(|input| offset(&input)).max()?;
    Some((of_vertex.next().as_ref().and_then(offset)?, last.checked_add(1)?))
}
