//! Plays a motion file, and prints where the root is, ten times a second:
//!
//!     cargo run -- walk.bvh
//!
//! An app with a window adds `DefaultPlugins` in place of the two below, and hangs what it draws on the entities.

#![warn(clippy::unwrap_used)]

use std::time::Duration;

use bevy::app::ScheduleRunnerPlugin;
use bevy::prelude::*;
use mocap_bevy::{Capture, CapturePlugin};

fn main() -> AppExit {
    let Some(file) = std::env::args_os().nth(1) else {
        eprintln!("usage: mocap-bevy FILE");
        return AppExit::from_code(2);
    };
    let scene = match mocap::import(file) {
        Ok(scene) => scene,
        Err(error) => {
            eprintln!("{error}");
            return AppExit::error();
        }
    };
    let tenth = Duration::from_millis(100);
    let mut app = App::new();
    app.add_plugins(MinimalPlugins.set(ScheduleRunnerPlugin::run_loop(tenth)))
        .add_plugins((TransformPlugin, CapturePlugin))
        .add_systems(Last, print_root);
    mocap_bevy::spawn(&mut app.world_mut().commands(), scene);
    app.world_mut().flush();
    app.run()
}

fn print_root(captures: Query<(&Capture, &GlobalTransform)>) {
    for (capture, root) in &captures {
        println!("tick {:.1}: {}", capture.player.tick, root.translation());
    }
}
