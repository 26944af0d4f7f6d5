//! Measures how many seconds of a motion each step of `edit` changes in a second of one processor.

use std::time::{Duration, Instant};

use mocap::edit::{ContactOptions, EditStep, Mirror, Step, StepInput};

use crate::Result;
use crate::feet::import;

/// The speed that every step must reach, as a multiple of real time.
const WANTED: f64 = 1000.0;

const FILES: [&str; 2] = ["cmu_12_01_walk.bvh", "cmu_01_01.bvh"];

const STEPS: [&str; 17] = [
    "foot-lock",
    "mirror",
    "smooth",
    "smooth:filter=gaussian",
    "smooth:cut-off=2",
    "despike",
    "fill",
    "loop",
    "loop:in-place=true",
    "concat",
    "blend",
    "layer",
    "warp:speed=0.8",
    "warp:path=0/0+1/2+4/3",
    "in-between:every=20",
    "in-between:every=20,interpolation=slerp",
    "in-between:every=1",
];

/// Prints a table with a row for each step and a column for each file. Each round runs every step once, on a copy of
/// the motion that exists before the clock starts.
pub(crate) fn measure(rounds: usize) -> Result<()> {
    let scenes = FILES.map(import);
    let mut rows: Vec<(&str, Vec<f64>)> = std::iter::once("contacts")
        .chain(STEPS)
        .map(|step| (step, Vec::new()))
        .collect();
    let mut lengths = Vec::new();
    for scene in scenes {
        let scene = scene?;
        let mut other = scene.clone();
        Mirror::new().apply(&mut other, &StepInput::new())?;
        let seconds = scene.animations[0].duration / scene.animations[0].ticks_per_second;
        lengths.push(seconds);
        let mut least = vec![f64::INFINITY; rows.len()];
        for _ in 0..rounds {
            for ((step, _), least) in rows.iter().zip(&mut least) {
                let mut copy = scene.clone();
                let took = match *step {
                    "contacts" => {
                        let start = Clock::start();
                        ContactOptions::default().detect(&copy, 0, None)?;
                        start.elapsed()
                    }
                    step => {
                        let step: EditStep = step.parse()?;
                        let start = Clock::start();
                        step.apply(&mut copy, &StepInput::new().other(&other))?;
                        start.elapsed()
                    }
                };
                *least = least.min(took.as_secs_f64());
            }
        }
        for ((_, ratios), least) in rows.iter_mut().zip(least) {
            ratios.push(seconds / least);
        }
    }
    let heads = FILES
        .iter()
        .zip(&lengths)
        .map(|(file, seconds)| format!("{file}, {seconds:.1} s"));
    println!("| step | {} |", heads.collect::<Vec<_>>().join(" | "));
    println!("|---|{}", "--:|".repeat(FILES.len()));
    for (step, ratios) in &rows {
        let cells: Vec<String> = ratios.iter().map(|ratio| format!("{ratio:.0}")).collect();
        println!("| `{step}` | {} |", cells.join(" | "));
    }
    let slow: Vec<&str> = rows
        .iter()
        .filter(|(_, ratios)| ratios.iter().any(|ratio| *ratio < WANTED))
        .map(|(step, _)| *step)
        .collect();
    match slow.as_slice() {
        [] => println!("every step runs at {WANTED} times real time or more"),
        slow => println!("below {WANTED} times real time: {}", slow.join("; ")),
    }
    Ok(())
}

/// The processor time of this thread. If the system does not provide it, the result includes the time of other
/// programs.
struct Clock {
    wall: Instant,
    processor: Option<f64>,
}

impl Clock {
    fn start() -> Self {
        let processor = crate::cpu_seconds();
        Self {
            wall: Instant::now(),
            processor,
        }
    }

    fn elapsed(&self) -> Duration {
        let wall = self.wall.elapsed();
        let processor = self.processor.zip(crate::cpu_seconds()).map(|(start, end)| end - start);
        processor
            .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
            .filter(|time| !time.is_zero())
            .unwrap_or(wall)
    }
}
