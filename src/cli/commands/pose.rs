//! `mocap pose`: prints node matrices at a tick.

use std::fmt;

use mocap::arrays::csv_field;
use mocap::glam::Mat4;
use mocap::{Binding, OutOfRange, Pose, Scene, Trs};
use serde::Serialize;

use super::{Place, import_motion, print_report};
use crate::args::{ArgumentSources, PoseArgs};
use crate::{Failure, report};

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct PoseView<'a> {
    file: String,
    tick: f64,
    nodes: Vec<NodeView<'a>>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct NodeView<'a> {
    name: &'a str,
    parent: Option<&'a str>,
    translation: [f32; 3],
    /// The quaternion: x, y, z, w.
    rotation: [f32; 4],
    /// The 16 numbers of the matrix, row by row.
    matrix: [f32; 16],
}

pub(crate) fn run(args: &PoseArgs, given: &ArgumentSources) -> Result<(), Failure> {
    if !args.csv {
        given.refuse(&["spreadsheet"], "it only affects CSV; add --csv")?;
    }
    let scene = import_motion(&args.read, &args.file)?;
    check_tick(args.tick, &scene, args.repeat)?;
    let view = PoseView {
        file: args.file.display().to_string(),
        tick: args.tick,
        nodes: view_nodes(&scene, args),
    };
    if !args.csv {
        return print_report(&view, args.json, Place::Result);
    }
    let table = PoseTable {
        view,
        for_spreadsheet: args.spreadsheet,
    };
    print_report(&table, args.json, Place::Data)
}

/// Refuses a tick that is not finite, and reports the frame that is used for a tick outside the motion.
pub(super) fn check_tick(tick: f64, scene: &Scene, repeats: bool) -> Result<(), Failure> {
    if !tick.is_finite() {
        return Err(Failure::Usage(format!("--tick must be finite, got {tick}")));
    }
    let last = scene.animations.first().map_or(0.0, |animation| animation.duration);
    if !repeats && !(0.0..=last).contains(&tick) {
        let taken = tick.clamp(0.0, last);
        report::say(&format!(
            "tick {tick} is outside the motion, 0 to {last}: tick {taken} is printed"
        ));
    }
    Ok(())
}

fn view_nodes<'a>(scene: &'a Scene, args: &PoseArgs) -> Vec<NodeView<'a>> {
    let mut pose = Pose::rest(scene);
    if let Some(animation) = scene.animations.first() {
        let policy = if args.repeat {
            OutOfRange::Loop
        } else {
            OutOfRange::Clamp
        };
        pose.sample(
            &Binding::new(scene, animation).out_of_range(policy),
            animation,
            args.tick,
        );
    }
    let matrices = if args.world {
        &pose.node_to_world
    } else {
        &pose.node_to_parent
    };
    let view = |(node, matrix): (&'a mocap::scene::Node, &Mat4)| {
        let trs = Trs::from_matrix(*matrix);
        NodeView {
            name: &node.name,
            parent: node.parent.map(|parent| scene.nodes[parent.index()].name.as_str()),
            translation: trs.translation.into(),
            rotation: trs.rotation.into(),
            matrix: matrix.transpose().to_cols_array(),
        }
    };
    scene.nodes.iter().zip(matrices).map(view).collect()
}

impl fmt::Display for PoseView<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for node in &self.nodes {
            writeln!(f, "{}  (parent: {})", node.name, node.parent.unwrap_or("none"))?;
            let (rows, _) = node.matrix.as_chunks::<4>();
            for [x, y, z, w] in rows {
                writeln!(f, "  {x:>12.6} {y:>12.6} {z:>12.6} {w:>12.6}")?;
            }
        }
        Ok(())
    }
}

/// A pose as CSV.
#[derive(Serialize)]
#[serde(transparent)]
struct PoseTable<'a> {
    view: PoseView<'a>,
    #[serde(skip)]
    for_spreadsheet: bool,
}

impl fmt::Display for PoseTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let header = "name,parent,tx,ty,tz,qx,qy,qz,qw,\
                      m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23,m30,m31,m32,m33";
        writeln!(f, "{header}")?;
        for node in &self.view.nodes {
            let names = [node.name, node.parent.unwrap_or_default()].map(|name| csv_field(name, self.for_spreadsheet));
            f.write_str(&names.join(","))?;
            for number in node.translation.iter().chain(&node.rotation).chain(&node.matrix) {
                write!(f, ",{number}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
