//! Turns a walk (a path through a motion graph) into a motion.

use std::fmt;

use glam::{DVec2, Quat, Vec3};
use mocap_figure::Figure;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::{Binding, Trs, have_the_same_joints};
use mocap_scene::scene::{Animation, ClipExtras, NodeId, Scene};
use serde::Serialize;

use super::body::figure_of;
use super::carrier::{Carrier, Placement};
use super::frames::{Frames, between};
use super::lock::{FootLockOptions, FootLockReport, foot_lock};
use super::quantity::centimetres;
use crate::graph::WalkPath;
use crate::graph::clouds::CloudSpace;
use crate::graph::distance::Alignment;
use crate::graph::report::Walk;
use crate::graph::walk::{Bend, smooth};

/// The report of [`Walk::motion`].
///
/// [`Walk::motion`](crate::graph::report::Walk::motion) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WalkReport {
    /// The number of frames of the motion.
    pub frames: usize,
    /// The length of the motion in seconds.
    pub seconds: f64,
    /// The time in the motion at which each transition starts, in seconds.
    pub transitions: Vec<f64>,
    /// The largest distance between the two windows of a transition, in metres.
    pub largest_distance: f32,
    /// How near the figure is to its path over the ground. `None` if the walk follows no path.
    pub path: Option<WalkPath>,
    /// The report of the foot lock. `None` if the skeleton is no humanoid.
    pub feet: Option<FootLockReport>,
}

impl fmt::Display for WalkReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.2} s in {} frames, with {} transitions of {} at most",
            self.seconds,
            self.frames,
            self.transitions.len(),
            centimetres(self.largest_distance),
        )?;
        if let Some(path) = &self.path {
            write!(f, "; {path}")?;
        }
        match &self.feet {
            None => f.write_str("; feet were not locked, because the skeleton is no humanoid"),
            Some(feet) => write!(
                f,
                "; feet slid {:.2} m in contact, now {:.2} m",
                feet.slide_before, feet.slide_after
            ),
        }
    }
}

impl Walk {
    /// Turns this walk through the graph into a motion. `clips` has the clips of the graph in their order, each as a
    /// scene and the index of an animation. The pieces of clips are aligned over the ground, and blended over the
    /// length of a window. Then [`foot_lock()`] locks the feet of a humanoid. The frame rate is the highest frame rate
    /// of the clips.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::graph::{GraphBuilder, GraphOptions};
    ///
    /// let clip = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let mut builder = GraphBuilder::new(&GraphOptions::new().threshold(0.1))?;
    /// builder.add("walk.bvh", &clip)?;
    /// let graph = builder.build()?;
    /// let found = builder.network(&graph)?.random(6.0, 1)?;
    /// let (scene, report) = found.motion(&[(&clip, 0)])?;
    /// assert_eq!((scene.animations[0].frame_count(), report.frames), (721, 721)); // 6 s at 120 Hz
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if a clip of the walk is missing in `clips`, or if the clips have different joints. The
    /// function cannot detect a wrong clip that has the right joints.
    pub fn motion(&self, clips: &[(&Scene, usize)]) -> Result<(Scene, WalkReport)> {
        let mut joined = WalkClips::new(self, clips)?;
        // The motion gets the skeleton of the first clip.
        let base = clips[0].0;
        let figure = Figure::new(base);
        let space = CloudSpace::new(base, &figure)?;
        let rate = joined.rate;
        let held = Vec::from_iter(joined.frames.iter().flatten());
        let count = held[0].up_to(self.seconds() * rate + 1e-6, &held[1..])?;
        let mut rows: Vec<Vec<Trs>> = Vec::with_capacity(count);
        for frame in 0..count {
            let seconds = frame as f64 / rate;
            let mut row = joined.row(seconds, &space)?;
            if let Some(bend) = Bend::at(&self.bends, seconds * self.rate) {
                joined.carrier.apply(&placement(&bend, &space), &mut row);
            }
            rows.push(row);
        }
        let mut report = WalkReport {
            frames: count,
            seconds: (count - 1) as f64 / rate,
            transitions: joined.starts(),
            largest_distance: self.pieces.iter().map(|piece| piece.distance).fold(0.0, f32::max),
            path: self.followed,
            feet: None,
        };
        report.transitions.retain(|seconds| *seconds < report.seconds);
        let mut scene = empty(base, rate);
        if let Some(frames) = joined.frames.iter().flatten().next() {
            frames.with_rows(rows).write_all(&mut scene, 0);
        }
        if figure_of(&scene, None).is_ok() {
            report.feet = Some(foot_lock(&mut scene, 0, &FootLockOptions::new())?);
        }
        Ok((scene, report))
    }
}

/// The scene of a clip, with an empty animation. Metadata about the file of the clip is removed, because it does not
/// apply to the walk.
fn empty(base: &Scene, rate: f64) -> Scene {
    let mut scene = base.clone();
    scene.animations = vec![Animation {
        name: "walk".to_owned(),
        ticks_per_second: rate,
        ..Animation::default()
    }];
    scene.weight_keys().for_each(Vec::clear);
    scene.metadata.clip_extras = ClipExtras::default();
    scene.metadata.origin = None;
    scene.metadata.steps.clear();
    scene.metadata.assumptions.clear();
    scene.warnings.clear();
    scene
}

/// The clips of a walk.
struct WalkClips<'a> {
    walk: &'a Walk,
    /// For each clip of the graph, its frames; `None` if the walk does not use the clip.
    frames: Vec<Option<Frames<'static>>>,
    carrier: Carrier,
    /// The highest frame rate of the used clips.
    rate: f64,
    /// The index of the piece of the previous row, and the frame of the walk at which this piece starts.
    piece: usize,
    begin: usize,
}

impl<'a> WalkClips<'a> {
    fn new(walk: &'a Walk, clips: &[(&Scene, usize)]) -> Result<Self> {
        let refuse = |message: String| Err(Diagnostic::new(Code::InvalidValue, message).into());
        let mut used: Vec<usize> = walk.pieces.iter().map(|piece| piece.clip).collect();
        used.sort_unstable();
        used.dedup();
        let mut nodes: Vec<NodeId> = Vec::new();
        for clip in &used {
            let Some((scene, animation)) = clips.get(*clip) else {
                return refuse(format!(
                    "the path through the graph uses clip {clip}, but the number of given clips is {}",
                    clips.len()
                ));
            };
            if let Err(difference) = have_the_same_joints(clips[used[0]].0, scene) {
                return refuse(format!(
                    "the clips on the path through the graph have different skeletons: {difference}"
                ));
            }
            if let Some(animation) = scene.animations.get(*animation) {
                nodes.extend(Binding::new(scene, animation).driven().map(|(node, _)| node));
            }
        }
        let mut frames: Vec<Option<Frames<'static>>> = vec![None; clips.len()];
        for clip in &used {
            let (scene, animation) = clips[*clip];
            let found = Frames::new(scene, animation, &nodes)?;
            found.require_nodes()?;
            frames[*clip] = Some(found);
        }
        let held = || frames.iter().flatten();
        let carriers = used.iter().filter_map(|clip| {
            let frames = frames[*clip].as_ref()?;
            Some(Carrier::new(clips[*clip].0, frames))
        });
        let carrier = carriers.min_by_key(|carrier| carrier.column);
        let Some(carrier) = carrier else {
            return refuse("the path through the graph has no clip".to_owned());
        };
        Ok(Self {
            walk,
            carrier,
            rate: held().map(|frames| frames.rate).fold(0.0, f64::max),
            frames,
            piece: 0,
            begin: 0,
        })
    }

    /// The time in the motion at which each transition starts, in seconds.
    fn starts(&self) -> Vec<f64> {
        let (pieces, window) = (&self.walk.pieces, self.walk.window);
        let mut at = 0;
        let ends = pieces[..pieces.len() - 1].iter().map(|piece| {
            let end = at + piece.last - piece.first;
            at = end + window - 1;
            end as f64 / self.walk.rate
        });
        ends.collect()
    }

    /// The transforms of the pose at a time of the walk. Times must not decrease from call to call.
    fn row(&mut self, seconds: f64, space: &CloudSpace) -> Result<Vec<Trs>> {
        let at = seconds * self.walk.rate;
        let blend = (self.walk.window - 1) as f64;
        loop {
            let piece = self.walk.pieces[self.piece];
            let length = piece.last - piece.first;
            let within = at - self.begin as f64;
            let is_last = self.piece + 1 == self.walk.pieces.len();
            let own = |this: &Self| this.clip_row(this.piece, piece.first as f64 + within, space);
            if within <= length as f64 || is_last {
                return own(self);
            }
            let part = (within - length as f64) / blend;
            if part < 1.0 {
                let next = self.walk.pieces[self.piece + 1];
                let from = own(self)?;
                let to = self.clip_row(self.piece + 1, next.first as f64 - blend * (1.0 - part), space)?;
                let weight = smooth(part) as f32;
                let pairs = from.iter().zip(&to);
                return Ok(pairs.map(|(from, to)| between(*from, *to, weight)).collect());
            }
            self.begin += length + self.walk.window - 1;
            self.piece += 1;
        }
    }

    /// The transforms of a frame of a piece, with the figure moved to its position in the walk. `frame` is counted at
    /// the frame rate of the graph.
    fn clip_row(&self, piece: usize, frame: f64, space: &CloudSpace) -> Result<Vec<Trs>> {
        let Some(frames) = &self.frames[self.walk.pieces[piece].clip] else {
            return Err(
                Diagnostic::new(Code::InvalidValue, "a clip on the path through the graph is not given").into(),
            );
        };
        let mut row = frames.row_at(frame / self.walk.rate * frames.rate);
        self.carrier
            .apply(&placement(&self.walk.placements[piece], space), &mut row);
        Ok(row)
    }
}

/// Converts an alignment to a rigid motion over the ground, in units of the scene.
fn placement(alignment: &Alignment, space: &CloudSpace) -> Placement {
    let turn = Quat::from_axis_angle(space.up, alignment.turn as f32);
    let DVec2 { x, y } = alignment.offset / f64::from(space.metres);
    let offset: Vec3 = space.ground[0] * x as f32 + space.ground[1] * y as f32;
    Placement::new(turn, offset)
}
