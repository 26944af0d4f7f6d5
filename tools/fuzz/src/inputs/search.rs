//! Databases of motions and motion graphs: files that are no motions themselves.

use std::sync::OnceLock;

use mocap::glam::{Vec2, Vec3};
use mocap::graph::{GraphBuilder, GraphOptions, MotionGraph};
use mocap::matching::{Controller, Database, FindOptions, IndexedClip, Moves, Query};
use mocap::{Code, Conversion, Diagnostic, Result, Scene};
use sha2::{Digest, Sha256};

use super::fixture;

/// Bytes of the checksum at the end of a database.
const CHECKSUM: usize = 32;
/// The number of frames for which a figure is steered.
const FRAMES: usize = 40;
/// The seconds of a walk over a graph.
const SECONDS: f64 = 5.0;

/// A short walk, and the same walk in metres.
fn walk() -> &'static [Scene; 2] {
    static WALK: OnceLock<[Scene; 2]> = OnceLock::new();
    WALK.get_or_init(|| {
        let walk = mocap::import(fixture("real/cmu_short.bvh")).expect("the fixture is read");
        let mut metres = walk.clone();
        Conversion::new().apply(&mut metres).expect("the fixture is a figure");
        [walk, metres]
    })
}

/// The walk by reference, and packed with its mirror image.
pub(super) fn databases() -> Vec<Vec<u8>> {
    let [walk, _] = walk();
    let packed = IndexedClip::packed(walk, "walk.bvh", true).expect("the fixture is packed");
    let clips = [IndexedClip::of(walk, "walk.bvh", false), packed];
    clips.map(|clips| Database::new(clips).to_bytes()).to_vec()
}

/// Corrects the checksum of a database, so that the input tests the code behind it. Searches the database, and steers a
/// figure with it.
pub(super) fn database(bytes: &[u8]) -> Result<Scene> {
    let mut sealed = bytes.to_vec();
    if let Some(end) = sealed.len().checked_sub(CHECKSUM) {
        let hash = Sha256::digest(&sealed[..end]);
        sealed[end..].copy_from_slice(&hash);
    }
    // The reader refuses a database with a wrong checksum.
    let _ = Database::read(bytes);
    let database = Database::read(&sealed[..])?;
    let [walk, metres] = walk();
    let query = Query::part(walk, 0, Default::default())?;
    for found in database.find(&query, &FindOptions::new()) {
        assert!(found.distance.is_finite() && found.first <= found.last, "{found:?}");
    }
    let moves = Moves::of(&database, metres, |_| Ok(walk.clone()))?;
    let _ = moves.to_holden();
    let mut figure = Controller::new(&database, moves, Vec3::ZERO, Vec3::Z)?;
    for _ in 0..FRAMES {
        figure.steer(Vec2::new(0.3, 1.2), Vec2::ZERO);
    }
    let clip = database.clips().first();
    clip.ok_or_else(|| Diagnostic::new(Code::NoMotion, "there is no clip"))?
        .motion()
}

/// A walk of several strides, which can continue endlessly.
fn strides() -> &'static Scene {
    static STRIDES: OnceLock<Scene> = OnceLock::new();
    STRIDES.get_or_init(|| mocap::import(fixture("real/cmu_12_01_walk.bvh")).expect("the fixture is read"))
}

fn builder() -> Result<GraphBuilder> {
    let mut builder = GraphBuilder::new(&GraphOptions::new().threshold(0.1))?;
    builder.add("walk.bvh", strides())?;
    Ok(builder)
}

/// The graph of the walk.
pub(super) fn graphs() -> Vec<Vec<u8>> {
    let graph = builder()
        .and_then(|builder| builder.build())
        .expect("the fixture has a graph");
    vec![graph.to_json().into_bytes()]
}

/// The reader refuses a graph, or the check walks over it.
pub(super) fn graph(bytes: &[u8]) -> Result<Scene> {
    let none = || Diagnostic::new(Code::InvalidGraph, "it is no text");
    let graph = MotionGraph::from_json(std::str::from_utf8(bytes).map_err(|_| none())?)?;
    assert_eq!(MotionGraph::from_json(&graph.to_json())?, graph);
    let builder = builder()?;
    let found = builder.network(&graph)?.random(SECONDS, 1)?;
    let (scene, _) = found.motion(&[(strides(), 0)])?;
    Ok(scene)
}
