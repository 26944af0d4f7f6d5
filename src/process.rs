//! Steps that change an imported scene.
//!
//! A step is a function on `&mut Scene` that does one thing; a pipeline is a list of calls. No step calls another, only
//! [`reduce_keys()`] can fail, and each keeps a valid scene valid: [`validate()`] has the rules and reports violations.
//!
//! This order gives the result of Assimp's preset "maximum quality" with "debone":
//!
//! 1. [`skeleton_mesh()`] adds a mesh that shows the skeleton. Use [`SkeletonMesh::Skinned`] for exactly Assimp's
//!    meshes; otherwise [`SkeletonMesh::Segmented`], which needs no step 6.
//! 2. [`find_degenerates()`] makes points of triangles without extent, in a separate mesh.
//! 3. [`remove_sizeless_meshes()`] removes meshes whose vertices all have one position: knobs of zero length.
//! 4. [`collapse_keys()`] reduces constant tracks to one key.
//! 5. [`join_identical_vertices()`] stores equal vertices once.
//! 6. [`debone()`] moves the parts of a skinned mesh that follow only one bone to the bone's node.
//!
//! Other steps, in the recommended order: [`trim()`], [`resample()`], [`convert_units()`] (after which lengths are
//! metres and +Y is up), [`in_place()`] or [`root_motion()`], [`rest_pose()`], [`reduce_keys()`].
//! [`survey`](crate::figure) guesses what a file does not state: its unit, its up axis, its cuts.
//!
//! The mesh steps read the rest pose from the node transforms, so they come before any
//! [`Scene::update_node_matrices`](crate::scene::Scene::update_node_matrices). Assimp also reorders faces for the
//! vertex cache of the graphics card. This crate does not, because such small meshes gain nothing from it.

mod collapse_keys;
mod convert_units;
mod debone;
mod find_degenerates;
mod join_identical_vertices;
mod name_joints;
mod reduce_keys;
mod remove_sizeless_meshes;
mod resample;
mod rest_pose;
mod rest_rotations;
mod root_motion;
mod skeleton_mesh;
mod split;
mod trim;
mod validate;

pub use self::collapse_keys::{KeyTolerance, collapse_keys};
pub use self::convert_units::convert_units;
pub(crate) use self::convert_units::convert_units_to;
pub use self::debone::debone;
pub use self::find_degenerates::find_degenerates;
pub use self::join_identical_vertices::join_identical_vertices;
pub(crate) use self::name_joints::apply_names;
pub use self::name_joints::{Naming, name_joints};
pub use self::reduce_keys::reduce_keys;
pub use self::remove_sizeless_meshes::remove_sizeless_meshes;
pub use self::resample::resample;
pub use self::rest_pose::rest_pose;
pub(crate) use self::rest_pose::{put_first, set_rest_pose};
pub(crate) use self::rest_rotations::{can_zero_rest_rotations, set_rest_rotations, zero_rest_rotations};
pub use self::root_motion::{in_place, root_motion};
pub use self::skeleton_mesh::{SkeletonMesh, skeleton_mesh};
pub use self::trim::trim;
pub use self::validate::{Part, Rule, Violation, validate};
