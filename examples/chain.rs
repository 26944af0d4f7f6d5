//! A chain of any number of bones that reaches for a goal: inverse kinematics on plain positions.
//!
//!     echo "0 0 0  1 0 0  2 0 0  3 0 0  1 1 0.5" | cargo run --example chain
//!
//! Each line of the input has the positions of the joints, from the first to the end, and of the goal. Each line of the
//! output has the new positions of the joints.

use std::error::Error;
use std::io::{self, BufRead, Write};

use mocap::glam::Vec3;
use mocap::ik::ChainOptions;

fn main() -> Result<(), Box<dyn Error>> {
    run(&mut io::stdin().lock(), &mut io::stdout().lock())
}

pub(crate) fn run(input: &mut impl BufRead, out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    for line in input.lines() {
        let numbers: Vec<f32> = line?.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        if numbers.len() < 9 || !numbers.len().is_multiple_of(3) {
            return Err(format!("expected three points or more in a line, got {} numbers", numbers.len()).into());
        }
        let mut points: Vec<Vec3> = numbers.chunks_exact(3).map(Vec3::from_slice).collect();
        let goal = points.pop().unwrap_or_default();
        ChainOptions::new().bend_positions(&mut points, goal);
        let values = points.iter().flat_map(mocap::glam::Vec3::to_array);
        let values: Vec<String> = values.map(|value| value.to_string()).collect();
        writeln!(out, "{}", values.join(" "))?;
    }
    Ok(())
}
