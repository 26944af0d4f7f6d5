//! A summary of a file in a few lines of JSON.

use serde::Serialize;

use mocap_figure::assumptions;
use mocap_scene::error::Diagnostic;
use mocap_scene::scene::report::MarkerSolution;
use mocap_scene::scene::report::RootOffsetUsed;
use mocap_scene::scene::{Animation, Assumption, Format, NodeKind, Recording, Scene};

/// The contents of a scene: counts, clips, assumptions, warnings. Serialised, it is the output of `mocap info --json`.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::dump::report::Summary;
///
/// let scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// let json = serde_json::to_value(Summary::of(&scene)).unwrap();
/// assert_eq!((&json["joints"], &json["format"]), (&31.into(), &"bvh".into()));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Summary<'a> {
    format: Option<Format>,
    nodes: usize,
    joints: usize,
    end_sites: usize,
    meshes: usize,
    vertices: usize,
    channels: usize,
    frames: usize,
    ticks_per_second: Option<f64>,
    duration_ticks: f64,
    duration_seconds: f64,
    clips: Vec<ClipSummary<'a>>,
    /// Events, analog channels and force plates.
    #[serde(skip_serializing_if = "Option::is_none")]
    recorded: Option<&'a Recording>,
    /// The fit of a skeleton that was solved from markers.
    #[serde(skip_serializing_if = "Option::is_none")]
    solved: Option<&'a MarkerSolution>,
    root_offset: Option<&'a RootOffsetUsed>,
    assumptions: Vec<Assumption>,
    warnings: &'a [Diagnostic],
}

/// One animation.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct ClipSummary<'a> {
    name: &'a str,
    channels: usize,
    frames: usize,
    seconds: f64,
}

impl<'a> ClipSummary<'a> {
    fn new(animation: &'a Animation) -> Self {
        Self {
            name: &animation.name,
            channels: animation.channels.len(),
            frames: animation.frame_count(),
            seconds: animation.duration / animation.ticks_per_second,
        }
    }
}

impl<'a> Summary<'a> {
    /// Summarises a scene. `channels`, `frames` and the durations belong to its first animation.
    pub fn of(scene: &'a Scene) -> Self {
        let animation = scene.animations.first();
        let count = |kind| scene.nodes.iter().filter(|node| node.kind == kind).count();
        Self {
            format: scene.metadata.format,
            nodes: scene.nodes.len(),
            joints: count(NodeKind::Joint),
            end_sites: count(NodeKind::EndSite),
            meshes: scene.meshes.len(),
            vertices: scene.meshes.iter().map(|mesh| mesh.vertices.len()).sum(),
            channels: animation.map_or(0, |animation| animation.channels.len()),
            frames: animation.map_or(0, Animation::frame_count),
            ticks_per_second: animation.map(|animation| animation.ticks_per_second),
            duration_ticks: animation.map_or(0.0, |animation| animation.duration),
            duration_seconds: animation.map_or(0.0, |animation| animation.duration / animation.ticks_per_second),
            clips: scene.animations.iter().map(ClipSummary::new).collect(),
            recorded: scene.metadata.recorded.as_deref(),
            solved: scene.metadata.solved.as_deref(),
            root_offset: scene.metadata.root_offset.as_ref(),
            assumptions: assumptions(scene),
            warnings: &scene.warnings,
        }
    }
}
