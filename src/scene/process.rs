//! Processing steps that change an imported scene.
//!
//! A step is a method of [`Scene`](crate::Scene) that does one thing. A pipeline is a list of calls. No step calls
//! another, and each keeps a valid scene valid. [`validate`](crate::Scene::validate) lists the rules and reports
//! violations.
//!
//! The following order gives the result of Assimp's preset "maximum quality" with "debone":
//!
//! 1. [`Scene::add_skeleton_mesh`](crate::Scene::add_skeleton_mesh) adds a mesh that shows the skeleton. Use
//!    [`SkeletonMesh::Skinned`] for exactly Assimp's meshes, or else [`SkeletonMesh::Segmented`], which needs no step
//!    6.
//! 2. [`find_degenerates`](crate::Scene::find_degenerates) replaces triangles without extent by points, in a separate
//!    mesh.
//! 3. [`remove_sizeless_meshes`](crate::Scene::remove_sizeless_meshes) removes meshes whose vertices all have one
//!    position, such as knobs of zero length.
//! 4. [`collapse_keys`](crate::Scene::collapse_keys) reduces constant tracks to one key.
//! 5. [`join_identical_vertices`](crate::Scene::join_identical_vertices) stores equal vertices once.
//! 6. [`debone`](crate::Scene::debone) splits a skinned mesh: faces that follow only one bone move to the bone's node.
//!
//! Other steps, in the recommended order:
//!
//! - [`trim`](crate::Scene::trim)
//! - [`resample`](crate::Scene::resample)
//! - [`convert_units`](crate::Scene::convert_units), after which lengths are metres and +Y is up
//! - [`put_in_place`](crate::Scene::put_in_place) or [`extract_root_motion`](crate::Scene::extract_root_motion)
//! - [`set_rest_pose_at`](crate::Scene::set_rest_pose_at)
//!
//! `compress::reduce_keys` removes keys within an error bound. `figure` guesses what a file does not state: its unit,
//! its up axis, its cuts.
//!
//! The mesh steps read the rest pose from the node transforms, so call them before
//! [`Scene::update_node_matrices`](crate::scene::Scene::update_node_matrices). Assimp also reorders faces for the
//! vertex cache of the graphics card. This crate does not, because meshes of this size gain nothing from it.

mod collapse_keys;
mod convert_units;
mod cuts;
mod debone;
mod find_degenerates;
mod join_identical_vertices;
mod rate;
mod remove_sizeless_meshes;
pub mod report;
mod resample;
mod rest_pose;
mod rest_rotations;
mod root_motion;
mod shear;
mod skeleton_mesh;
mod split;
mod trim;
mod validate;
mod visibility;

pub use self::collapse_keys::KeyTolerance;
#[doc(hidden)]
pub use self::convert_units::convert_units_to;
#[doc(hidden)]
pub use self::cuts::first_frame_is_rest_pose;
#[doc(hidden)]
pub use self::rate::{frame_rate, rate_before};
#[doc(hidden)]
pub use self::rest_pose::{put_first, set_rest_pose};
#[doc(hidden)]
pub use self::rest_rotations::{can_zero_rest_rotations, set_rest_rotations, zero_rest_rotations};
#[doc(hidden)]
pub use self::shear::{ShearOutcome, take_shear_out};
pub use self::skeleton_mesh::SkeletonMesh;
