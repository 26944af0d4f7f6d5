//! A window with a hero that plays motion files; the space bar changes to the next one:
//!
//!     cargo run --features window --example hero -- hero.glb walk.bvh run.fbx
//!
//! Paths are relative to the current folder. With `--picture FILE`, the example saves a picture after 20 seconds and
//! ends: a software adapter needs this time for its first picture.

use std::path::PathBuf;
use std::time::Duration;

use bevy::asset::{AssetMode, UnapprovedPathMode};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::gltf::GltfAssetLabel;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy::world_serialization::WorldAssetRoot;
use mocap_bevy::{Clip, MotionFailed, MotionLooped, MotionPlayer, MotionPlugin, MotionStarted};

/// The files of the command line.
#[derive(Resource)]
struct Files {
    hero: String,
    motions: Vec<String>,
    next: usize,
    picture: Option<PathBuf>,
}

fn main() -> AppExit {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let picture = words.iter().position(|word| word == "--picture").map(|at| {
        words.remove(at);
        PathBuf::from(words.remove(at))
    });
    if words.len() < 2 {
        eprintln!("usage: hero HERO.glb MOTION... [--picture FILE.png]");
        return AppExit::from_code(2);
    }
    let hero = words.remove(0);
    let files = Files {
        hero,
        motions: words,
        next: 1,
        picture,
    };
    let assets = AssetPlugin {
        file_path: std::env::current_dir().unwrap_or_default().display().to_string(),
        mode: AssetMode::Unprocessed,
        // The user named these files.
        unapproved_path_mode: UnapprovedPathMode::Allow,
        ..default()
    };
    App::new()
        .add_plugins((DefaultPlugins.set(assets), MotionPlugin))
        .insert_resource(files)
        .add_systems(Startup, begin)
        .add_systems(Update, (change, take_picture))
        .add_observer(|started: On<MotionStarted>| println!("plays; mean error {:.1} degrees", started.mean_degrees))
        .add_observer(|_: On<MotionLooped>| println!("again"))
        .add_observer(|failed: On<MotionFailed>| eprintln!("{}", failed.reason))
        .run()
}

fn begin(mut commands: Commands, assets: Res<AssetServer>, files: Res<Files>) {
    let hero = GltfAssetLabel::Scene(0).from_asset(files.hero.clone());
    commands.spawn((
        WorldAssetRoot(assets.load(hero)),
        MotionPlayer::new(assets.load(files.motions[0].clone())),
    ));
    commands.spawn((
        Camera3d::default(),
        Tonemapping::None,
        Transform::from_xyz(2.0, 1.6, 3.2).looking_at(Vec3::new(0.0, 0.9, 0.0), Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight::default(),
        Transform::from_xyz(2.0, 4.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

fn change(
    keys: Res<ButtonInput<KeyCode>>,
    assets: Res<AssetServer>,
    mut files: ResMut<Files>,
    mut players: Query<&mut MotionPlayer>,
) {
    if !keys.just_pressed(KeyCode::Space) {
        return;
    }
    let motion = files.motions[files.next % files.motions.len()].clone();
    files.next += 1;
    for mut player in &mut players {
        player.play(assets.load(motion.clone()), Clip::First, Duration::from_millis(400));
    }
}

fn take_picture(
    mut commands: Commands,
    time: Res<Time>,
    mut files: ResMut<Files>,
    players: Query<&MotionPlayer>,
    mut since: Local<Option<f32>>,
) {
    if files.picture.is_none() || !players.iter().any(MotionPlayer::is_playing) {
        return;
    }
    let begun = *since.get_or_insert(time.elapsed_secs());
    if time.elapsed_secs() - begun > 20.0
        && let Some(picture) = files.picture.take()
    {
        let end = |_: On<ScreenshotCaptured>, mut exit: MessageWriter<AppExit>| {
            exit.write(AppExit::Success);
        };
        commands
            .spawn(Screenshot::primary_window())
            .observe(save_to_disk(picture))
            .observe(end);
    }
}
