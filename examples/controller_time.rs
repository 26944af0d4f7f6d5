//! How long a figure of motion matching takes a frame, beside a player that shows a clip on the same character.
//!
//!     cargo run --profile dist --example controller_time -- walks.mdb HERO [FRAMES]
//!
//! A stick moves a little every frame, as somebody who plays moves it; the moves are the same in every run. Files that
//! are not packed within the database are read. Both poses have the matrices of all nodes, to the parent and to the
//! world.

use std::error::Error;
use std::fs::File;
use std::hint::black_box;
use std::io::BufReader;
use std::time::Instant;

use mocap::glam::{Vec2, Vec3};
use mocap::matching::{Controller, Database, Moves};
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::{Binding, Conversion, Pose};

/// Runs, of which the fastest counts: another program may be in the way of the others.
const RUNS: usize = 7;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (database, hero, frames) = match arguments.as_slice() {
        [database, hero] => (database, hero, 6000),
        [database, hero, frames] => (database, hero, frames.parse()?),
        _ => return Err("controller_time DATABASE HERO [FRAMES]".into()),
    };
    let database = Database::read(BufReader::new(File::open(database)?))?;
    let mut hero = mocap::import(hero)?;
    hero.animations.clear();
    Conversion::new().apply(&mut hero)?;
    let moves = Moves::of(&database, &hero, |file| mocap::import(file))?;
    let controller = Controller::new(&database, moves, Vec3::ZERO, Vec3::Z)?;

    let mut jumps = 0;
    let of_figure = fastest(frames, || {
        let mut figure = controller.clone();
        let start = Instant::now();
        for frame in 0..frames {
            let seconds = frame as f32 / 60.0;
            let angle = 0.9 * (0.7 * seconds).sin() + 0.5 * (1.9 * seconds).sin();
            let pace = 1.0 + 0.4 * (0.4 * seconds).sin();
            figure.steer(pace * Vec2::from_angle(angle).perp(), Vec2::ZERO);
        }
        jumps = black_box(figure).jumps();
        start.elapsed().as_secs_f64()
    });

    let clip = &database.clips()[0].row.file;
    let motion = mocap::import(clip)?;
    let clips = Retargeter::new(motion, hero.clone(), RetargetOptions::new())?.into_clips();
    let animation = &clips[0].animation;
    let binding = Binding::new(&hero, animation);
    let mut pose = Pose::rest(&hero);
    let of_player = fastest(frames, || {
        let start = Instant::now();
        for frame in 0..frames {
            let tick = frame as f64 / 60.0 * animation.ticks_per_second;
            pose.sample(&binding, animation, tick % animation.duration.max(1.0));
            black_box(&pose);
        }
        start.elapsed().as_secs_f64()
    });
    println!(
        "{} frames of {} nodes, database of {} frames, {jumps} jumps: figure {of_figure:.2} us a frame, player \
         {of_player:.2}, beside it {:.2}",
        frames,
        hero.nodes.len(),
        database.frames(),
        of_figure - of_player
    );
    Ok(())
}

/// Microseconds a frame of the fastest run.
fn fastest(frames: usize, mut run: impl FnMut() -> f64) -> f64 {
    let seconds = (0..RUNS).map(|_| run()).fold(f64::INFINITY, f64::min);
    1e6 * seconds / frames as f64
}
