//! Motion matching: a figure that follows a stick or a trajectory.

use std::ptr;
use std::slice;

use mocap::Conversion;
use mocap::glam::{Vec2, Vec3};
use mocap::matching::{Controller as Figure, Database, IndexedClip, Moves, Trajectory};

use crate::border::{self, Failure, Status, guard};
use crate::handle::Scene;
use crate::{Matrix, opened};

/// The number of floats of a trajectory: x and z of three positions and of three directions.
const TRAJECTORY: usize = 12;

/// A figure that follows a stick or a trajectory by motion matching. Programs only hold pointers to this type.
pub struct Controller {
    figure: Figure,
    nodes: usize,
}

/// Makes a figure with the character of a scene. The figure stands at the origin and faces +Z. `database` is the `size`
/// bytes of a file that `mocap index --pack` wrote, which includes the motions.
///
/// The figure is always in metres with +Y up, and has the nodes of the scene. It takes memory for the pose of every
/// frame of the database. You may close the scene after this call. Returns NULL if the character is not a humanoid with
/// two legs, or if the bytes are not a database; `mocap_error_text` has the reason. Free the figure with
/// `mocap_controller_free`.
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
        // SAFETY: the caller passes an open scene.
        let character = unsafe { opened(character) }?;
        if database.is_null() {
            return Err(Failure::argument("database is NULL"));
        }
        // SAFETY: the caller passes `size` bytes.
        let bytes = unsafe { slice::from_raw_parts(database, size) };
        let database = Database::read(bytes)?;
        if let Some(clip) = database.clips().iter().find(|clip| !clip.is_packed() && !clip.mirrored) {
            let message = format!(
                "the database lacks the motion of {}: make the database with `mocap index --pack`",
                clip.row.file
            );
            return Err(Failure::argument(&message));
        }
        let unknown = |_: &str| Ok(mocap::Scene::default());
        make(character, &database, unknown)
    })
}

/// Like `mocap_controller_open`, with the motions of `count` scenes instead of a database. The scenes may have any
/// skeletons. With `mirror`, the figure also uses the mirror image of each motion. You may close the scenes after this
/// call.
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
        // SAFETY: the caller passes an open scene.
        let character = unsafe { opened(character) }?;
        if motions.is_null() {
            return Err(Failure::argument("motions is NULL"));
        }
        // SAFETY: the caller passes `count` pointers.
        let motions = unsafe { slice::from_raw_parts(motions, count) };
        // SAFETY: each of them is an open scene.
        let motions = motions.iter().map(|motion| Ok(unsafe { opened(*motion) }?.scene()));
        let motions = motions.collect::<Result<Vec<_>, Failure>>()?;
        let mut clips = Vec::new();
        for (index, motion) in motions.iter().enumerate() {
            let found = IndexedClip::of(motion, &index.to_string(), mirror);
            if found.is_empty() {
                return Err(Failure::argument(&format!(
                    "motion {index} is not a motion of a humanoid with two feet"
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

/// Advances by one frame, 1/60 s, controlled by a stick. The input is a velocity over the ground along x and z, in m/s,
/// and a facing (`look_x`, `look_z`). While both components of the facing are 0, the figure faces the direction of its
/// velocity. Velocity and facing change smoothly. Seen from behind a figure that faces +Z, right is -X.
///
/// The call allocates no memory. Only one thread at a time may use a figure.
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
        // SAFETY: the caller passes NULL or a figure that it alone uses.
        let controller = unsafe { alone(controller) }?;
        let (velocity, look) = (Vec2::new(velocity_x, velocity_z), Vec2::new(look_x, look_z));
        controller.figure.steer(velocity, look);
        Ok(())
    })
}

/// Advances by one frame towards a trajectory of 12 floats: x and z of the figure's positions in 20, 40 and 60 frames,
/// in metres, then x and z of its facings. The call allocates no memory.
///
/// # Safety
/// `controller` is a figure that no other thread uses, and `trajectory` points to 12 floats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_controller_follow(controller: *mut Controller, trajectory: *const f32) -> Status {
    border::status(|| {
        // SAFETY: the caller passes NULL or a figure that it alone uses.
        let controller = unsafe { alone(controller) }?;
        if trajectory.is_null() {
            return Err(Failure::argument("trajectory is NULL"));
        }
        // SAFETY: the caller passes 12 floats.
        let numbers = unsafe { slice::from_raw_parts(trajectory, TRAJECTORY) };
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(Failure::argument("a number in trajectory is not finite"));
        }
        let at = |place: usize| Vec3::new(numbers[place], 0.0, numbers[place + 1]);
        let trajectory = Trajectory::new([0, 2, 4].map(at), [6, 8, 10].map(at));
        controller.figure.update(&trajectory);
        Ok(())
    })
}

/// The pose of a figure. `local` gets the matrices of all nodes relative to their parents, and `world` the matrices
/// relative to the world; either may be NULL. `count` is the number of matrices that fit in each buffer, at least
/// `mocap_node_count` of the figure's scene. If `root` is not NULL, its 4 floats get the figure's position (x and z in
/// metres) and facing (x and z of a direction of length 1). The call allocates no memory.
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
        // SAFETY: the caller passes NULL or a valid figure.
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
                // SAFETY: there is room for `count` matrices, at least the number of nodes, and the caller's memory
                // does not overlap the figure.
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
    // SAFETY: the caller passes NULL or a figure that it alone uses.
    unsafe { controller.as_mut() }.ok_or_else(|| Failure::argument("the controller is NULL"))
}
