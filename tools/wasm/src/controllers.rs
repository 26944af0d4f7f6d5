//! The figures of motion matching that JavaScript holds, each with a number that is never reused.

use std::collections::BTreeMap;

use mocap::Scene;
use mocap::glam::{Vec2, Vec3};
use mocap::matching::{Controller, Database, IndexedClip, Moves, Trajectory};
use serde::Serialize;

use crate::failure::Failure;

/// The number of values of a trajectory: x and z of three positions and of three directions.
const TRAJECTORY: usize = 12;

/// A figure, with the memory that JavaScript reads and writes directly.
struct Entry {
    figure: Controller,
    /// The position (x and z) and the facing (x and z).
    root: Box<[f32; 4]>,
    /// The trajectory of the next frame.
    trajectory: Box<[f32; TRAJECTORY]>,
}

#[derive(Default)]
pub(crate) struct Controllers {
    entries: BTreeMap<u32, Entry>,
    last: u32,
}

/// The description of a figure for JavaScript.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct ControllerAt {
    controller: u32,
    node_count: usize,
    frames: usize,
    root: usize,
    trajectory: usize,
    to_world: usize,
    to_parent: usize,
}

impl Controllers {
    /// Makes a figure of a character in metres with +Y up, from the motions of a database or of scenes.
    pub(crate) fn add(
        &mut self,
        character: &Scene,
        database: Option<&[u8]>,
        motions: &[&Scene],
        mirror: bool,
    ) -> Result<ControllerAt, Failure> {
        let database = match database {
            Some(bytes) => packed(bytes)?,
            None => Database::new(indexed(motions, mirror)?),
        };
        let open = |name: &str| {
            let motion = name.parse().ok().and_then(|index: usize| motions.get(index));
            Ok(motion.map_or_else(Scene::default, |motion| (*motion).clone()))
        };
        let moves = Moves::of(&database, character, open)?;
        let figure = Controller::new(&database, moves, Vec3::ZERO, Vec3::Z)?;
        let next = self.last.checked_add(1);
        self.last = next.ok_or_else(|| Failure::argument("there were 2^32 figures; load the module again"))?;
        let entry = self.entries.entry(self.last).or_insert(Entry {
            root: Box::new(root(&figure)),
            trajectory: Box::new([0.0; TRAJECTORY]),
            figure,
        });
        let pose = entry.figure.pose();
        Ok(ControllerAt {
            controller: self.last,
            node_count: pose.node_to_world.len(),
            frames: database.frames(),
            root: entry.root.as_ptr().addr(),
            trajectory: entry.trajectory.as_ptr().addr(),
            to_world: pose.node_to_world.as_ptr().addr(),
            to_parent: pose.node_to_parent.as_ptr().addr(),
        })
    }

    /// Advances by one frame with a velocity. Returns whether the figure exists.
    pub(crate) fn steer(&mut self, number: u32, velocity: Vec2, look: Vec2) -> bool {
        self.go_on(number, |entry| entry.figure.steer(velocity, look))
    }

    /// Advances by one frame towards the trajectory that JavaScript has written. Returns whether the figure exists.
    pub(crate) fn follow(&mut self, number: u32) -> bool {
        self.go_on(number, |entry| {
            let number = |place: usize| Some(entry.trajectory[place]).filter(|number| number.is_finite());
            let at = |place: usize| Vec3::new(number(place).unwrap_or(0.0), 0.0, number(place + 1).unwrap_or(0.0));
            let trajectory = Trajectory::new([0, 2, 4].map(at), [6, 8, 10].map(at));
            entry.figure.update(&trajectory);
        })
    }

    fn go_on(&mut self, number: u32, step: impl FnOnce(&mut Entry)) -> bool {
        let Some(entry) = self.entries.get_mut(&number) else {
            return false;
        };
        step(entry);
        *entry.root = root(&entry.figure);
        true
    }

    pub(crate) fn free(&mut self, number: u32) {
        self.entries.remove(&number);
    }
}

fn root(figure: &Controller) -> [f32; 4] {
    let (at, forward) = (figure.position(), figure.forward());
    [at.x, at.z, forward.x, forward.z]
}

/// Reads a database that includes its motions.
fn packed(bytes: &[u8]) -> Result<Database, Failure> {
    let database = Database::read(bytes)?;
    match database.clips().iter().find(|clip| !clip.is_packed() && !clip.mirrored) {
        None => Ok(database),
        Some(clip) => Err(Failure::argument(format!(
            "the database lacks the motion of {}: make the database with `mocap index --pack`",
            clip.row.file
        ))),
    }
}

/// Indexes the clips of scenes. The index of a scene replaces its file name.
fn indexed(motions: &[&Scene], mirror: bool) -> Result<Vec<IndexedClip>, Failure> {
    let mut clips = Vec::new();
    for (index, motion) in motions.iter().enumerate() {
        let found = IndexedClip::of(motion, &index.to_string(), mirror);
        if found.is_empty() {
            let message = format!("motion {index} is not a motion of a humanoid with two feet");
            return Err(Failure::argument(message));
        }
        clips.extend(found);
    }
    Ok(clips)
}
