//! Writes TRC.

use std::fmt::Write as _;

use mocap_scene::error::Result;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, NodeKind, Scene};

use super::FIRST_WORD;
use crate::numbers;
use crate::unique_names::{UniqueNames, is_separator};
use crate::written::unit_warning;
use crate::{Export, ExportFile, WriteOptions};

/// Millimetres per metre, because scenes are in metres.
const MILLIMETRES: f32 = 1000.0;

pub(crate) fn files(scene: &Scene, options: &WriteOptions) -> Result<Export> {
    numbers::check(scene)?;
    let nodes: Vec<usize> = (0..scene.nodes.len())
        .filter(|node| scene.nodes[*node].kind != NodeKind::Group)
        .collect();
    // OpenSim refuses columns with equal names.
    let (mut unique, mut renamed) = (UniqueNames::default(), Vec::new());
    let is_allowed = |c: char| !is_separator(c);
    let names: Vec<String> = (nodes.iter())
        .map(|node| unique.of_node(scene, *node, is_allowed, str::to_owned, &mut renamed))
        .collect();
    let text = text(scene, &nodes, &names, &options.name);
    Ok(Export {
        warnings: Vec::from_iter(unit_warning(scene, "TRC")),
        renamed,
        nodes: nodes.len(),
        ..Export::of(vec![ExportFile::new(&options.name, text.into_bytes())])
    })
}

/// The value of the last written decimal of a length, in millimetres.
const LAST_DIGIT: f32 = 1e-4;

fn text(scene: &Scene, nodes: &[usize], names: &[String], file: &str) -> String {
    let animation = scene.animations.first();
    let frames = animation.map_or(1, Animation::frame_count);
    let rate = animation.map_or(1.0, |animation| animation.ticks_per_second);
    let count = nodes.len();
    let mut text = format!("{FIRST_WORD}\t4\t(X/Y/Z)\t{}\n", cell(file));
    text += "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n";
    let _ = writeln!(text, "{rate}\t{rate}\t{frames}\t{count}\tmm\t{rate}\t1\t{frames}");
    text += "Frame#\tTime";
    for name in names {
        let _ = write!(text, "\t{name}\t\t");
    }
    text += "\n\t";
    for marker in 1..=count {
        let _ = write!(text, "\tX{marker}\tY{marker}\tZ{marker}");
    }
    text += "\n\n";
    let binding = animation.map(|animation| Binding::new(scene, animation));
    let gaps = animation.map_or_else(Vec::new, |animation| scene.points_with_gaps(animation));
    let mut pose = Pose::rest(scene);
    for frame in 0..frames {
        if let (Some(binding), Some(animation)) = (&binding, animation) {
            pose.sample(binding, animation, frame as f64);
        }
        let _ = write!(text, "{}\t{:.6}", frame + 1, frame as f64 / rate);
        for &node in nodes {
            let keys = gaps.get(node).copied().flatten();
            if keys.is_some_and(|keys| !keys.is_seen(frame as f64)) {
                text += "\t\t\t";
                continue;
            }
            let mut position = pose.node_to_world[node].w_axis.truncate() * MILLIMETRES;
            // Three zeros mean that a marker was not seen.
            if position.abs().max_element() < 0.5 * LAST_DIGIT {
                position.x = LAST_DIGIT;
            }
            let _ = write!(text, "\t{:.4}\t{:.4}\t{:.4}", position.x, position.y, position.z);
        }
        text.push('\n');
    }
    text
}

/// The file name without column and row separators.
fn cell(name: &str) -> String {
    name.replace(is_separator, " ")
}
