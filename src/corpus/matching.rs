//! Search in many motions. A database has the features of every frame of every clip, scaled to one body. A search
//! returns the frames or parts that are most similar to a query. `docs/search-algorithm.md` describes the features, the
//! file and the sources.
//!
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//! use mocap::matching::{IndexedClip, Database, FindOptions, Query};
//! # fn main() -> mocap::Result<()> {
//! let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
//! let database = Database::new(IndexedClip::of(&walk, "walk.bvh", false));
//! // One second of the same walk. The query may have another skeleton.
//! let second = Query::part(&walk, 0, "1..2".parse().unwrap())?;
//! let found = database.find(&second, &FindOptions::new());
//! assert!(found[0].distance < 0.03 && (found[0].first - 1.0).abs() < 0.1);
//! # Ok(())
//! # }
//! ```

mod clip;
pub(crate) mod controller;
mod database;
#[doc(hidden)]
pub(crate) mod features;
mod file;
mod follow;
mod gamepad;
mod holden;
pub(crate) mod like;
mod lock;
mod moves;
mod play;
mod query;
mod record;
pub mod report;
pub(crate) mod steering;
mod trajectory;
mod tree;

pub use self::clip::IndexedClip;
pub use self::controller::Controller;
pub use self::database::Database;
#[doc(hidden)]
pub use self::gamepad::Gamepad;
pub use self::like::FindOptions;
pub use self::moves::Moves;
pub use self::query::Query;
pub use self::trajectory::Trajectory;
#[doc(hidden)]
pub use self::tree::FeatureTree;
