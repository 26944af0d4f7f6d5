//! `mocap chain`: prints each matrix from the root to a joint.

use std::fmt;

use mocap::glam::Mat4;
use mocap::scene::{NodeKind, Scene};
use mocap::{ChainMatrix, Pose};
use serde::Serialize;

use super::pose::check_tick;
use super::{Place, import_motion, print_report};
use crate::Failure;
use crate::args::ChainArgs;

/// The matrices of a chain.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct ChainView<'a> {
    file: String,
    joint: &'a str,
    tick: f64,
    chain: &'a [ChainMatrix],
    /// The point of `--point`, in the axes of the joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    point: Option<[f32; 3]>,
    /// The position of this point in the world.
    #[serde(skip_serializing_if = "Option::is_none")]
    point_in_world: Option<[f32; 3]>,
    #[serde(skip)]
    scene: &'a Scene,
}

pub(crate) fn run(args: &ChainArgs) -> Result<(), Failure> {
    let scene = import_motion(&args.read, &args.file)?;
    check_tick(args.tick, &scene, false)?;
    let pose = Pose::at_tick(&scene, 0, args.tick).unwrap_or_else(|| Pose::rest(&scene));
    let chain = pose
        .chain(&scene, &args.joint)
        .map_err(|error| error.with_path(&args.file))?;
    let attached = |point: [f32; 3]| Some(pose.point_to_world(chain.last()?.node, point.into()).into());
    let view = ChainView {
        file: args.file.display().to_string(),
        joint: &args.joint,
        tick: args.tick,
        chain: &chain,
        point: args.point,
        point_in_world: args.point.and_then(attached),
        scene: &scene,
    };
    print_report(&view, args.json, Place::Result)
}

impl fmt::Display for ChainView<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let symbols: Vec<&str> = self.chain.iter().map(|matrix| &*matrix.symbol).collect();
        writeln!(f, "T = {}, tick {}", symbols.join(" "), self.tick)?;
        writeln!(
            f,
            "positive angles turn counter-clockwise for a viewer towards whom the axis points"
        )?;
        let mut so_far = String::new();
        for part in self.chain {
            so_far += if so_far.is_empty() { "" } else { " " };
            so_far += &part.symbol;
            writeln!(f, "\n{} {}", part.symbol, meaning(part, self.scene))?;
            writeln!(f, "  {:>43}   |  {so_far:>43}", part.symbol)?;
            for (row, product) in rows(&part.matrix).into_iter().zip(rows(&part.product)) {
                writeln!(f, "  {}   |  {}", numbers(&row), numbers(&product))?;
            }
        }
        if let (Some(point), Some(world)) = (self.point, self.point_in_world) {
            let [point, world] = [point, world].map(|point| numbers(&point));
            writeln!(f, "\npoint in {}:  {point}\npoint in the world:  {world}", self.joint)?;
        }
        Ok(())
    }
}

/// The kind of a matrix, its joint, and its line in the file.
fn meaning(part: &ChainMatrix, scene: &Scene) -> String {
    let node = &scene.nodes[part.node.index()];
    let lines = node.source.unwrap_or_default();
    let at = |line: Option<usize>| line.map(|line| format!(", line {line}")).unwrap_or_default();
    let name = &part.joint;
    match (part.order, part.degrees) {
        (Some(order), Some(degrees)) => {
            let letters = order.axes().map(|axis| ["X", "Y", "Z"][axis]);
            let angles = std::iter::zip(letters, degrees).map(|(axis, angle)| format!("{axis} {}", number(angle)));
            let product = letters.map(|axis| format!("R{}", axis.to_lowercase())).join(" ");
            let angles = angles.collect::<Vec<_>>().join("  ");
            format!("{name}: {product}, {angles} degrees{}", at(lines.channels))
        }
        _ if node.kind == NodeKind::EndSite => format!("{name}: offset{}", at(lines.offset)),
        // A joint with position channels is not at its rest offset.
        _ if part.matrix.w_axis != node.transform.w_axis => {
            format!("{name}: translation to the parent{}", at(lines.channels))
        }
        _ => format!("{name}: translation to the parent{}", at(lines.offset)),
    }
}

fn rows(matrix: &Mat4) -> [[f32; 4]; 4] {
    matrix.transpose().to_cols_array_2d()
}

fn numbers(row: &[f32]) -> String {
    row.iter()
        .map(|value| format!("{:>10}", number(f64::from(*value))))
        .collect::<Vec<_>>()
        .join(" ")
}

/// Four decimals; never a minus zero.
fn number(value: f64) -> String {
    let rounded = (value * 1e4).round() / 1e4 + 0.0;
    format!("{rounded:.4}")
}
