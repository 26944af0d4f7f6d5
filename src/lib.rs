//! Motion capture: reads BVH, FBX, glTF, VRM, ASF/AMC, C3D and robots' files into one kind of scene. It plays and
//! changes the motion, and retargets it to other characters and robots. It writes the motion for other programs, and
//! verifies the files.
//!
//! Convert a file in one line. Lengths become metres with +Y up. BVH states neither its unit nor its up axis, so mocap
//! infers both:
//!
//! ```
//! # let to = std::env::temp_dir().join("mocap_front.glb");
//! mocap::convert("fixtures/real/cmu_12_01_walk.bvh", to)?;
//! # Ok::<(), mocap::Error>(())
//! ```
//!
//! Import a file, and print its channels:
//!
//! ```
//! let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
//! let animation = &scene.animations[0];
//! println!("{} frames, {} a second", animation.frame_count(), animation.ticks_per_second);
//! for channel in &animation.channels {
//!     println!("{}: position {:?}", channel.node_name, channel.position_keys.values); // one key where it is constant
//!     for (key, rotation) in channel.rotation_keys.values.iter().enumerate() {
//!         println!("  tick {}: {rotation}", channel.rotation_keys.tick(key));
//!     }
//! }
//! # assert_eq!((animation.channels.len(), animation.channels[1].position_keys.len()), (3, 1));
//! # Ok::<(), mocap::Error>(())
//! ```
//!
//! Set the transforms of your own nodes at a tick; channels are found by name:
//!
//! ```
//! use mocap::Trs;
//! use mocap::glam::Mat4;
//!
//! let mut nodes = [("Shoulder", Mat4::IDENTITY), ("Elbow", Mat4::IDENTITY)];
//! let animation = &mocap::import("fixtures/real/lecture_Test.bvh")?.animations[0];
//! for (name, node_to_parent) in &mut nodes {
//!     if let Some(channel) = animation.channels.iter().find(|channel| channel.node_name == *name) {
//!         *node_to_parent = channel.sample(4.5, Trs::from_matrix(*node_to_parent)).matrix(); // between ticks 4 and 5
//!     }
//! }
//! # let turned = nodes[1].1.x_axis;
//! # assert!((turned.y.atan2(turned.x).to_degrees() - 55.0).abs() < 1e-3);
//! # Ok::<(), mocap::Error>(())
//! ```
//!
//! | to | use | feature |
//! |---|---|---|
//! | convert a file to another format | [`convert()`] | the two formats |
//! | read a file, or bytes in memory | [`import()`], [`Importer`]; [`FormatInfo::ALL`] lists the formats | its format |
//! | have metres with +Y up, a part of the clip, another frame rate | [`Conversion`] | |
//! | write a file, small within an error bound | [`Exporter`] | its format |
//! | set all options of one format | [`gltf`], [`bvh`], [`fbx`], [`vrma`]; [`compress`] has the packed clips | its format |
//! | play a motion in an app | [`Pose`], [`Updater`]: node matrices at a tick; [`Player`]: the tick at a time | |
//! | infer unit, up axis, and which joint is which bone | [`figure`] | |
//! | bend a limb to a goal | [`ik`] | `edit` |
//! | have the scene and the print-outs of Assimp | [`process`], [`dump`] | |
//! | change a motion: lock feet, mirror, smooth, loop, blend | [`edit`] | `edit` |
//! | join parts of many clips by motion graphs | [`graph`] | `edit` |
//! | retarget files to a character, a skeleton or a robot | [`retarget::Retargeter`] | `retarget` |
//! | retarget single poses as they arrive | [`retarget::PoseRetargeter`], [`retarget::robot`] | `retarget` |
//! | receive or send motion over a network: the VMC protocol | [`live`] | `live` |
//! | see a motion: a page with a player, pictures, curves | [`render`] | `render` |
//! | solve markers or joint positions to rotations | [`solve`] | `laboratory` |
//! | have joint angles, gait events and ground forces | [`biomechanics`] | `laboratory` |
//! | survey a dataset: defects, near-duplicates, a diverse subset | [`survey`] | `corpus` |
//! | search many motions; motion matching | [`matching`] | `corpus` |
//! | have positions and rotations as arrays or tables | [`arrays`] | `jobs` |
//! | verify that a written file has the motion of its source | [`verify`] | `jobs` |
//! | run what a command line or a JSON file describes | [`job`] | `jobs` |
//!
//! A [`Scene`] is plain data in the words of Assimp: nodes, meshes, channels of keys. A [`Diagnostic`] describes one
//! problem of a file, with its location. It is the [`Error`] that ended the import, or one of the warnings in the
//! scene. [`Code`] lists all problems. [`Limits`] are the upper bounds of what a file may claim.
//!
//! # Features
//!
//! The default is `bvh`, `gltf`, `fbx` and `retarget`. A program that converts BVH to glTF needs
//! `default-features = false, features = ["bvh", "gltf"]`. Scenes, figures, poses, packed clips and print-outs need no
//! feature.
//!
//! | feature | contents |
//! |---|---|
//! | `bvh` | BVH |
//! | `gltf` | glTF and VRM animations |
//! | `fbx` | FBX; needs a C compiler |
//! | `acclaim` | ASF and AMC |
//! | `c3d`, `trc` | markers |
//! | `usd` | USD as text and in archives |
//! | `mmd` | VMD and PMX of MikuMikuDance |
//! | `urdf`, `mjcf` | robots |
//! | `arrays` | files of NumPy, PyTorch, pickle, CSV and OpenSim |
//! | `all-formats` | the format features above, without `fbx` |
//! | `npz` | `arrays`, and NumPy's archives |
//! | `meshopt` | glTF that meshopt compresses; needs a C++ compiler |
//! | `edit` | steps that change a motion; motion graphs |
//! | `retarget` | `edit`, and motions on other characters and on robots |
//! | `robots` | `retarget`, `urdf`, `mjcf` |
//! | `live` | `retarget`, and the VMC protocol |
//! | `render` | `edit`, and pictures, films and the player page |
//! | `laboratory` | `c3d`, `trc`, markers to skeletons, biomechanics |
//! | `corpus` | `retarget`, and surveys, search, motion matching |
//! | `jobs` | `corpus`, `laboratory`, `robots`, `all-formats`, and jobs, arrays, verification |
//! | `arrow`, `parquet` | `jobs`, and tables of Arrow and Parquet |
//! | `clap`, `schema` | `jobs`, and options of a [`job`] as arguments of clap, as a JSON Schema |
//!
//! The program `mocap` is the package `mocap-cli`.
//!
//! # Vectors and matrices
//!
//! Positions, rotations and matrices are types of [`glam`]. A program that uses `mocap::glam` has the same version of
//! glam. A program with another version of glam, or with another library, uses arrays, which need no type of glam.
//! [`Pose::node_to_world_arrays`] returns the arrays of a whole pose without a copy. Methods of glam convert single
//! values:
//!
//! ```
//! let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
//! // Column by column, as other libraries and graphics interfaces take them.
//! let columns: [f32; 16] = scene.nodes[0].transform.to_cols_array();
//! let xyzw: [f32; 4] = scene.animations[0].channels[0].rotation_keys.values[0].to_array();
//! assert_eq!((columns[15], xyzw.len()), (1.0, 4));
//! # Ok::<(), mocap::Error>(())
//! ```

#[doc(inline)]
pub use mocap_compress as compress;
#[cfg(feature = "corpus")]
#[doc(inline)]
pub use mocap_corpus::{matching, survey};
#[cfg(feature = "edit")]
#[doc(inline)]
pub use mocap_edit::{self as edit, graph};
#[doc(inline)]
pub use mocap_figure::{self as figure, Conversion, convert};
#[cfg(feature = "gltf")]
#[doc(inline)]
pub use mocap_formats::vrma;
#[doc(hidden)]
pub use mocap_formats::{Carriage, Contents, WriteOption};
#[doc(inline)]
pub use mocap_formats::{Export, ExportFile, FormatInfo, bvh, dump, fbx, gltf};
#[doc(inline)]
pub use mocap_io::{Clips, Exporter, Importer, MemoryFile, convert::convert, import::import};
#[cfg(feature = "jobs")]
#[doc(inline)]
pub use mocap_job::{self as job, arrays, verify};
#[cfg(feature = "render")]
#[doc(inline)]
pub use mocap_render as render;
#[cfg(feature = "retarget")]
#[doc(inline)]
pub use mocap_retarget as retarget;
#[cfg(feature = "live")]
#[doc(inline)]
pub use mocap_retarget::live;
#[doc(hidden)]
pub use mocap_scene::error::{nearest, spell_options, spelled};
#[cfg(feature = "edit")]
#[doc(inline)]
pub use mocap_scene::ik;
#[doc(inline)]
pub use mocap_scene::{
    Binding, ChainMatrix, Code, Diagnostic, Error, Format, Limits, Location, LoopMode, OutOfRange, Player, Pose,
    Result, RootOffset, Scene, SkeletonMesh, Trs, Updater, process, report, scene,
};
#[doc(hidden)]
pub use mocap_scene::{files, visible, visible_json};
#[cfg(feature = "laboratory")]
#[doc(inline)]
pub use mocap_solve::{self as solve, biomechanics};

pub use glam;

/// The examples of the README and of the book run with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
#[doc = include_str!("../docs/library.md")]
struct Pages;
