//! Motion matching: a figure that goes where it is asked to.

use std::ptr;
use std::slice;

use mocap::Conversion;
use mocap::glam::{Vec2, Vec3};
use mocap::matching::{Controller as Figure, Database, IndexedClip, Moves, Trajectory};

use crate::border::{self, Failure, Status, guard};
use crate::handle::Scene;
use crate::{Matrix, opened};

/// Floats of a trajectory: x and z of three positions, and of three directions.
const TRAJECTORY: usize = 12;

/// A figure that follows what it is asked for by jumps between the frames of motions. Only pointers to it leave the
/// library.
pub struct Controller {
    figure: Figure,
    nodes: usize,
}

/// Makes a figure of the character of a scene, which stands at the origin and looks along +Z. `database` is the `size`
/// bytes of a file that `mocap index --pack` wrote, with the motions within.
///
/// The figure is in metres with +Y up, whatever the scene is in; its nodes are those of the scene. It takes memory for
/// the pose of every frame of the database, and the scene may be closed then. Returns NULL where the character is no
/// humanoid with two legs, and where the bytes are no database; `mocap_error_text` says why. `mocap_controller_free`
/// frees it.
///
/// # Safety
/// `character` is an open scene, and `database` points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_controller_open(
    character: *const Scene,
    database: *const u8,
    size: usize,
) -> *mut Controller {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller hands over an open scene.
        let character = unsafe { opened(character) }?;
        if database.is_null() {
            return Err(Failure::argument("database is NULL"));
        }
        // SAFETY: the caller hands over `size` bytes.
        let bytes = unsafe { slice::from_raw_parts(database, size) };
        let database = Database::read(bytes)?;
        if let Some(clip) = database.clips().iter().find(|clip| !clip.is_packed() && !clip.mirrored) {
            let message = format!(
                "the database has the motion of {} not within: make it with --pack",
                clip.row.file
            );
            return Err(Failure::argument(&message));
        }
        let unknown = |_: &str| Ok(mocap::Scene::default());
        make(character, &database, unknown)
    })
}

/// Makes a figure as `mocap_controller_open` does, of the motions of `count` scenes, on any skeletons; with `mirror`
/// each with left and right exchanged too. The scenes may be closed then.
///
/// # Safety
/// `character` is an open scene, and `motions` points to `count` open scenes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_controller_new(
    character: *const Scene,
    motions: *const *const Scene,
    count: usize,
    mirror: bool,
) -> *mut Controller {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller hands over an open scene.
        let character = unsafe { opened(character) }?;
        if motions.is_null() {
            return Err(Failure::argument("motions is NULL"));
        }
        // SAFETY: the caller hands over `count` pointers.
        let motions = unsafe { slice::from_raw_parts(motions, count) };
        // SAFETY: each of them is an open scene.
        let motions = motions.iter().map(|motion| Ok(unsafe { opened(*motion) }?.scene()));
        let motions = motions.collect::<Result<Vec<_>, Failure>>()?;
        let mut clips = Vec::new();
        for (index, motion) in motions.iter().enumerate() {
            let found = IndexedClip::of(motion, &index.to_string(), mirror);
            if found.is_empty() {
                return Err(Failure::argument(&format!(
                    "motion {index} is none of a humanoid with two feet"
                )));
            }
            clips.extend(found);
        }
        let open = |name: &str| Ok(motions[name.parse::<usize>().unwrap_or(0)].clone());
        make(character, &Database::new(clips), open)
    })
}

fn make(
    character: &Scene,
    database: &Database,
    open: impl FnMut(&str) -> mocap::Result<mocap::Scene>,
) -> Result<*mut Controller, Failure> {
    let mut scene = character.scene().clone();
    Conversion::new().apply(&mut scene)?;
    let moves = Moves::of(database, &scene, open)?;
    let figure = Figure::new(database, moves, Vec3::ZERO, Vec3::Z)?;
    let nodes = scene.nodes.len();
    Ok(Box::into_raw(Box::new(Controller { figure, nodes })))
}

/// Frees a figure. NULL is allowed.
///
/// # Safety
/// `controller` comes from `mocap_controller_open` or `mocap_controller_new`, was not freed before, and is used by no
/// other thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_controller_free(controller: *mut Controller) {
    guard((), || {
        if !controller.is_null() {
            // SAFETY: the pointer comes from `Box::into_raw`, and the caller gives it up.
            drop(unsafe { Box::from_raw(controller) });
        }
        Ok(())
    });
}

/// Advances by a frame, a sixtieth of a second, by the input of a stick. The input is a velocity over the ground along
/// x and z, in metres per second, and a facing (`look_x`, `look_z`). While both are 0, the figure faces its velocity.
/// Velocity and direction change smoothly. Seen from behind a figure that looks along +Z, right is along -X.
///
/// Nothing is allocated. One thread at a time may use a figure.
///
/// # Safety
/// `controller` is a figure that no other thread uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_controller_steer(
    controller: *mut Controller,
    velocity_x: f32,
    velocity_z: f32,
    look_x: f32,
    look_z: f32,
) -> Status {
    border::status(|| {
        // SAFETY: the caller hands over NULL or a figure that it alone uses.
        let controller = unsafe { alone(controller) }?;
        let (velocity, look) = (Vec2::new(velocity_x, velocity_z), Vec2::new(look_x, look_z));
        controller.figure.steer(velocity, look);
        Ok(())
    })
}

/// Advances by a frame towards a trajectory of 12 floats: x and z in metres of the figure's place in 20, 40 and 60
/// frames, then x and z of its facing. Nothing is allocated.
///
/// # Safety
/// `controller` is a figure that no other thread uses, and `trajectory` points to 12 floats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_controller_follow(controller: *mut Controller, trajectory: *const f32) -> Status {
    border::status(|| {
        // SAFETY: the caller hands over NULL or a figure that it alone uses.
        let controller = unsafe { alone(controller) }?;
        if trajectory.is_null() {
            return Err(Failure::argument("trajectory is NULL"));
        }
        // SAFETY: the caller hands over 12 floats.
        let numbers = unsafe { slice::from_raw_parts(trajectory, TRAJECTORY) };
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(Failure::argument("a number of trajectory is not finite"));
        }
        let at = |place: usize| Vec3::new(numbers[place], 0.0, numbers[place + 1]);
        let trajectory = Trajectory::new([0, 2, 4].map(at), [6, 8, 10].map(at));
        controller.figure.update(&trajectory);
        Ok(())
    })
}

/// The pose of a figure: the matrices of all nodes to their parents go to `local`, and to the world to `world`; either
/// may be NULL. `count` is how many matrices there is room for, at least `mocap_node_count` of its scene. Place and
/// facing of the figure go to the 4 floats of `root`, if that is not NULL. They are x and z in metres, then x and z of
/// a direction of length 1. Nothing is allocated.
///
/// # Safety
/// `controller` is a figure that no other thread uses. `local` and `world` are NULL or point to room for 16 x `count`
/// floats. `root` is NULL or points to room for 4.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_controller_pose(
    controller: *const Controller,
    local: *mut f32,
    world: *mut f32,
    count: usize,
    root: *mut f32,
) -> Status {
    border::status(|| {
        // SAFETY: the caller hands over NULL or a figure that lives.
        let controller = unsafe { controller.as_ref() }.ok_or_else(|| Failure::argument("the controller is NULL"))?;
        let nodes = controller.nodes;
        if count < nodes && !(local.is_null() && world.is_null()) {
            let message = format!("there is room for {count} matrices, and the figure has {nodes} nodes");
            return Err(Failure::argument(&message));
        }
        let pose = controller.figure.pose();
        for (place, matrices) in [
            (local, pose.node_to_parent_arrays()),
            (world, pose.node_to_world_arrays()),
        ] {
            if !place.is_null() {
                // SAFETY: there is room for `count` matrices, which is no less than there are, and the caller's memory
                // is not that of the figure.
                unsafe { ptr::copy_nonoverlapping(matrices.as_ptr(), place.cast::<Matrix>(), nodes) };
            }
        }
        let (at, forward) = (controller.figure.position(), controller.figure.forward());
        if !root.is_null() {
            // SAFETY: there is room for 4 floats.
            unsafe { ptr::copy_nonoverlapping([at.x, at.z, forward.x, forward.z].as_ptr(), root, 4) };
        }
        Ok(())
    })
}

/// # Safety
/// `controller` is NULL or a figure that no other thread uses.
unsafe fn alone<'a>(controller: *mut Controller) -> Result<&'a mut Controller, Failure> {
    // SAFETY: the caller hands over NULL or a figure that it alone uses.
    unsafe { controller.as_mut() }.ok_or_else(|| Failure::argument("the controller is NULL"))
}
