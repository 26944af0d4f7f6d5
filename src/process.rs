//! Steps that change a scene after it is read.
//!
//! A step is a function on `&mut Scene` that does one thing; a pipeline is a list of calls. No step calls another,
//! none but [`reduce_keys()`] fails, and each leaves a valid scene valid: [`validate()`] lists what valid means and says what is broken.
//!
//! The recommended order gives what Assimp gives for its preset "maximum quality" with "debone":
//!
//! 1. [`skeleton_mesh()`] gives the bare skeleton something to draw. Start with [`SkeletonMesh::Skinned`] where the
//!    result shall be Assimp's mesh for mesh, with [`SkeletonMesh::Segmented`] otherwise, which needs no step 6.
//! 2. [`find_degenerates()`] turns triangles without a size into points, in a mesh of their own.
//! 3. [`remove_sizeless_meshes()`] removes meshes whose vertices all stand in one place: knobs of zero length.
//! 4. [`collapse_keys()`] leaves one key in a track that never changes.
//! 5. [`join_identical_vertices()`] stores equal vertices once.
//! 6. [`debone()`] takes the parts that follow one bone out of a skinned mesh and hangs them on the bone's node.
//!
//! What else can be done to a motion, in the order in which it is best done: [`trim()`], [`resample()`],
//! [`convert_units()`] (after which lengths are metres and +Y is up), [`in_place()`] or [`root_motion()`],
//! [`rest_pose()`], [`reduce_keys()`]. [`survey`](crate::skeleton) guesses what a file does not say: its unit, its up axis, its cuts.
//!
//! The mesh steps read the rest pose from the node transforms, so they come before any
//! [`Scene::update_node_matrices`](crate::scene::Scene::update_node_matrices). Assimp also reorders faces for the
//! vertex cache of the graphics card. That is left out: it changes no number, and such small meshes gain nothing.

mod collapse_keys;
mod convert_units;
mod debone;
mod find_degenerates;
mod join_identical_vertices;
mod reduce_keys;
mod remove_sizeless_meshes;
mod resample;
mod rest_pose;
mod root_motion;
mod skeleton_mesh;
mod split;
mod trim;
mod validate;

pub use self::collapse_keys::{KeyTolerance, collapse_keys};
pub use self::convert_units::convert_units;
pub use self::debone::debone;
pub use self::find_degenerates::find_degenerates;
pub use self::join_identical_vertices::join_identical_vertices;
pub use self::reduce_keys::reduce_keys;
pub use self::remove_sizeless_meshes::remove_sizeless_meshes;
pub use self::resample::resample;
pub use self::rest_pose::rest_pose;
pub use self::root_motion::{in_place, root_motion};
pub use self::skeleton_mesh::{SkeletonMesh, skeleton_mesh};
pub use self::trim::trim;
pub use self::validate::{Part, Rule, Violation, validate};
