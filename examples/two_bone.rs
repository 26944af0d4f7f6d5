//! An arm or a leg that reaches for a goal: inverse kinematics of two bones, on plain positions.
//!
//!     echo "0 1 0  0 0.5 0.1  0 0 0  0.2 0.3 0" | cargo run --example two_bone
//!
//! Each line of the input has the positions of three joints and of the goal. Each line of the output has where the
//! second and the third joint come, and the rotations of the two bones in the world, as x y z w.

use std::error::Error;
use std::io::{self, BufRead, Write};

use mocap::glam::Vec3;
use mocap::ik::TwoBone;

fn main() -> Result<(), Box<dyn Error>> {
    run(&mut io::stdin().lock(), &mut io::stdout().lock())
}

pub(crate) fn run(input: &mut impl BufRead, out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    for line in input.lines() {
        let numbers: Vec<f32> = line?.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        if numbers.len() != 12 {
            return Err(format!("expected 12 numbers in a line, got {}", numbers.len()).into());
        }
        let point = |index: usize| Vec3::from_slice(&numbers[3 * index..]);
        let found = TwoBone::solve([point(0), point(1), point(2)], point(3), None);
        let values = [found.middle.to_array(), found.end.to_array()];
        let rotations = [found.upper.to_array(), found.lower.to_array()];
        let values = values.iter().flatten().chain(rotations.iter().flatten());
        let values: Vec<String> = values.map(f32::to_string).collect();
        writeln!(out, "{}", values.join(" "))?;
    }
    Ok(())
}
