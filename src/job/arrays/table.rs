//! Arrow tables, in four shapes.
//!
//! [`Arrays::to_table`] has one row for each frame and joint:
//!
//! | column | type | |
//! |---|---|---|
//! | `clip` | utf8 | the clip's name |
//! | `frame` | int32 | from 0 |
//! | `time` | float64 | seconds |
//! | `joint` | utf8 | |
//! | `x`, `y`, `z` | float32 | the position |
//! | by [`Rotation::columns`](crate::arrays::Rotation::columns) | float32 | the rotation |
//! | `vx`, `vy`, `vz` | float32 | the velocity; absent unless requested |
//! | `contact` | bool | absent unless requested |
//!
//! [`clips`] has one row for each clip:
//!
//! | column | type | |
//! |---|---|---|
//! | `clip` | utf8 | the clip's name |
//! | `error` | utf8 | why the file could not be read; all other columns are then null |
//! | `skeleton` | utf8 | a hash of names, parents and offsets |
//! | `frames`, `joints` | int32 | the number of frames and joints |
//! | `frame_rate` | float64 | frames per second |
//! | `names` | list of utf8 | of the joints |
//! | `parents` | list of int32 | indices into `names`; -1 for a joint without a parent |
//! | `offsets` | list of 3 x float32 | one per joint |
//! | `positions` | list of 3 x float32 | frame by frame, joint by joint |
//! | `rotations` | list of [`Rotation::width`](crate::arrays::Rotation::width) x float32 | likewise |
//! | `velocities` | list of 3 x float32 | likewise; absent unless requested |
//! | `contacts` | list of bool | likewise; absent unless requested |
//! | `header` | utf8 | the [`Header`](crate::arrays::Header) as JSON |
//!
//! [`inventory`] has one row for each file, without its motion. Its columns are `clip`, `error`, `skeleton`, `joints`,
//! `frames`, `frame_rate` and `duration` in seconds, then `metres_per_unit` and `up`, and `warnings`, a list of utf8.
//! `metres_per_unit` and `up` are guesses if the file does not state the unit and the up axis.
//!
//! `robot_reports` has one row for each motion that was retargeted to a robot, or failed. Its columns are `clip`,
//! `error`, `output`, and the fields of [`RobotReport`](mocap_retarget::robot::report::RobotReport). The fields
//! `limbs`, `clamped` and `self_collisions` are lists of structs.
//!
//! The [`ArrayOptions`] alone determine the columns, so tables with the same options can be concatenated.

#[cfg(feature = "parquet")]
#[doc(hidden)]
pub mod dataset;
mod robot_reports;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use arrow_array::builder::{BooleanBuilder, FixedSizeListBuilder, Float32Builder, ListBuilder};
use arrow_array::builder::{Int32Builder, StringBuilder};
use arrow_array::{
    Array, ArrayRef, BooleanArray, Float32Array, Float64Array, Int32Array, RecordBatch, RecordBatchOptions, StringArray,
};
use arrow_schema::{Field, Schema};
use mocap_figure::{Figure, Survey};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{Animation, Scene};
use sha2::{Digest, Sha256};

use crate::arrays::{ArrayOptions, Arrays, Joint};

pub use self::robot_reports::{RobotClip, robot_reports};
#[cfg(feature = "parquet")]
pub use mocap_io::export::parquet::{is_own_parquet, to_parquet};
/// The version of Arrow that the tables use.
pub use {arrow_array, arrow_schema};

impl Arrays {
    /// The [table](crate::arrays::table) with one row for each frame and joint.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::arrays::{ArrayOptions, Arrays};
    ///
    /// let motion = Arrays::of(&mocap::import("fixtures/real/lecture_Test.bvh")?, &ArrayOptions::default())?;
    /// let rows = motion.to_table("lecture");
    /// assert_eq!((rows.num_rows(), rows.num_columns()), (10 * 4, 4 + 3 + 4));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn to_table(&self, clip: &str) -> RecordBatch {
        self.table_of(clip, 0..self.rows())
    }

    /// [`to_table`](Self::to_table) in parts of at most 1,048,576 rows. Each part is computed on demand, because a
    /// table is several times as large as the arrays. There is always at least one part.
    #[doc(hidden)]
    pub fn tables(&self, clip: &str) -> impl Iterator<Item = RecordBatch> {
        /// The number of rows in a row group of Parquet. With this number, the parts give the same file as the whole
        /// table.
        const ROWS: usize = 1 << 20;
        let starts = (0..self.rows().max(1)).step_by(ROWS);
        starts.map(move |start| self.table_of(clip, start..(start + ROWS).min(self.rows())))
    }

    fn table_of(&self, clip: &str, rows: Range<usize>) -> RecordBatch {
        let joints = self.joints();
        let (from, to) = (rows.start, rows.end);
        let rows = || from..to;
        let frame_of = |row: usize| row / joints.len();
        let mut columns: Vec<(String, ArrayRef)> = Vec::new();
        let mut add = |name: &str, column: ArrayRef| columns.push((name.to_owned(), column));
        add("clip", Arc::new(StringArray::from_iter_values(rows().map(|_| clip))));
        add(
            "frame",
            Arc::new(rows().map(|row| Some(frame_of(row) as i32)).collect::<Int32Array>()),
        );
        let time = |row| Some(frame_of(row) as f64 / self.frame_rate());
        add("time", Arc::new(rows().map(time).collect::<Float64Array>()));
        let name = |row: usize| joints[row % joints.len()].name.as_str();
        add("joint", Arc::new(StringArray::from_iter_values(rows().map(name))));
        let mut add_floats = |names: &[&str], values: &[f32]| {
            for (joint_index, name) in names.iter().enumerate() {
                let width = names.len();
                let column = values[from * width..to * width].iter().skip(joint_index).step_by(width);
                let column = column.copied();
                add(name, Arc::new(Float32Array::from_iter_values(column)));
            }
        };
        add_floats(&["x", "y", "z"], &self.positions);
        add_floats(self.header.rotation.columns(), &self.rotations);
        if let Some(velocities) = &self.velocities {
            add_floats(&["vx", "vy", "vz"], velocities);
        }
        if let Some(contacts) = &self.contacts {
            add("contact", Arc::new(BooleanArray::from(contacts[from..to].to_vec())));
        }
        batch(columns, false)
    }

    /// [`to_table`](Self::to_table) with the header as JSON in the schema's metadata, with the key `mocap`.
    pub fn to_table_with_header(&self, clip: &str) -> RecordBatch {
        self.with_header(&self.to_table(clip))
    }

    /// A part of the table with the header as JSON in the schema's metadata.
    pub(crate) fn with_header(&self, rows: &RecordBatch) -> RecordBatch {
        let metadata = HashMap::from([("mocap".to_owned(), self.header.to_json())]);
        let schema = rows.schema().as_ref().clone().with_metadata(metadata);
        rows.clone()
            .with_schema(Arc::new(schema))
            .expect("metadata does not change the columns of a schema")
    }
}

/// Refuses a clip that is too long for one row of [`clips`]: readers hold a row in memory, and Parquet holds several
/// copies.
///
/// # Errors
/// [`Code::LimitExceeded`].
#[doc(hidden)]
pub fn check_row(motion: &Arrays) -> Result<()> {
    /// The largest number of values: half a gigabyte.
    const MOST: usize = 1 << 27;
    let numbers = motion.positions.len() + motion.rotations.len();
    if numbers <= MOST {
        return Ok(());
    }
    let diagnostic = Diagnostic::new(Code::LimitExceeded, "the clip is too long for one row of a table")
        .expected_found(format!("at most {MOST} numbers"), format!("{numbers} numbers"))
        .help("use {table} long, which has a row for each frame and joint, or crop the clip with {trim}");
    Err(diagnostic.into())
}

/// The table with one row for each clip. A clip has a name, and arrays or an error message. `options` must be the
/// options of the arrays.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::arrays::{Arrays, ArrayOptions, table};
///
/// let options = ArrayOptions::default();
/// let motion = Arrays::of(&mocap::import("fixtures/real/lecture_Test.bvh")?, &options)?;
/// let rows = table::clips(&[("lecture", Ok(&motion)), ("broken", Err("empty file"))], &options);
/// assert_eq!(rows.num_rows(), 2);
/// # Ok::<(), mocap::Error>(())
/// ```
pub fn clips(clips: &[(&str, Result<&Arrays, &str>)], options: &ArrayOptions) -> RecordBatch {
    let motions: Vec<Option<&Arrays>> = clips.iter().map(|(_, motion)| motion.ok()).collect();
    let strings = |value: &dyn Fn(&Arrays) -> String| -> ArrayRef {
        Arc::new(motions.iter().map(|motion| motion.map(value)).collect::<StringArray>())
    };
    let counts = |value: &dyn Fn(&Arrays) -> usize| -> ArrayRef {
        let count = |motion: &Option<&Arrays>| motion.and_then(|motion| i32::try_from(value(motion)).ok());
        Arc::new(motions.iter().map(count).collect::<Int32Array>())
    };
    let floats = |width: usize, value: &dyn Fn(&Arrays) -> Vec<f32>| float_lists(&motions, width, value);
    let rate = motions.iter().map(|motion| motion.map(Arrays::frame_rate));

    let mut columns: Vec<(String, ArrayRef)> = Vec::new();
    let mut add = |name: &str, column: ArrayRef| columns.push((name.to_owned(), column));
    add(
        "clip",
        Arc::new(StringArray::from_iter_values(clips.iter().map(|(clip, _)| clip))),
    );
    let errors = clips.iter().map(|(_, motion)| motion.err());
    add("error", Arc::new(errors.collect::<StringArray>()));
    add("skeleton", strings(&|motion| skeleton_hash(motion.joints())));
    add("frames", counts(&|motion| motion.frames));
    add("joints", counts(&|motion| motion.joints().len()));
    add("frame_rate", Arc::new(rate.collect::<Float64Array>()));
    add("names", names(&motions));
    add("parents", parents(&motions));
    add(
        "offsets",
        floats(3, &|motion| {
            motion
                .joints()
                .iter()
                .flat_map(|joint| joint.offset.to_array())
                .collect()
        }),
    );
    add("positions", floats(3, &|motion| motion.positions.clone()));
    add(
        "rotations",
        floats(options.rotation.width(), &|motion| motion.rotations.clone()),
    );
    if options.velocities {
        add(
            "velocities",
            floats(3, &|motion| motion.velocities.clone().unwrap_or_default()),
        );
    }
    if options.contacts.is_some() {
        add("contacts", contacts(&motions));
    }
    add("header", strings(&|motion| motion.header.to_json()));
    batch(columns, true)
}

/// The table with one row for each file, without its motion.
pub fn inventory(files: &[(&str, &Result<Scene>)]) -> RecordBatch {
    let scenes: Vec<Option<&Scene>> = files.iter().map(|(_, scene)| scene.as_ref().ok()).collect();
    let surveys: Vec<Option<Survey>> = scenes
        .iter()
        .map(|scene| scene.map(|scene| Figure::new(scene).survey))
        .collect();
    // Without motion, a scene's arrays only have its joints.
    let motionless = |scene: &Scene| Scene {
        nodes: scene.nodes.clone(),
        ..Scene::default()
    };
    let joints: Vec<Option<Vec<Joint>>> = scenes
        .iter()
        .map(|scene| Arrays::of(&motionless((*scene)?), &ArrayOptions::default()).ok())
        .map(|arrays| arrays.map(|arrays| arrays.header.joints))
        .collect();
    let animations = || scenes.iter().map(|scene| scene.map(|scene| scene.animations.first()));
    let frames = |animation: Option<&Animation>| animation.map_or(0, |animation| animation.frame_count() as i32);
    let rate = |animation: Option<&Animation>| animation.map_or(0.0, |animation| animation.ticks_per_second);
    let duration = |animation: Option<&Animation>| animation.map_or(0.0, |a| a.duration / a.ticks_per_second);
    let metres = surveys
        .iter()
        .map(|survey| survey.as_ref().map(|survey| survey.metres_per_unit));
    let up = surveys
        .iter()
        .map(|survey| survey.as_ref().map(|survey| survey.up.value.as_str()));
    let mut warnings = ListBuilder::new(StringBuilder::new());
    for scene in &scenes {
        for warning in scene.iter().flat_map(|scene| &scene.warnings) {
            warnings.values().append_value(format!("{}: {warning}", warning.code));
        }
        warnings.append(scene.is_some());
    }

    let mut columns: Vec<(String, ArrayRef)> = Vec::new();
    let mut add = |name: &str, column: ArrayRef| columns.push((name.to_owned(), column));
    add(
        "clip",
        Arc::new(StringArray::from_iter_values(files.iter().map(|(clip, _)| clip))),
    );
    let errors = files
        .iter()
        .map(|(_, scene)| scene.as_ref().err().map(ToString::to_string));
    add("error", Arc::new(errors.collect::<StringArray>()));
    let hashes = joints.iter().map(|joints| joints.as_deref().map(skeleton_hash));
    add("skeleton", Arc::new(hashes.collect::<StringArray>()));
    let counts = joints
        .iter()
        .map(|joints| joints.as_ref().map(|joints| joints.len() as i32));
    add("joints", Arc::new(counts.collect::<Int32Array>()));
    add(
        "frames",
        Arc::new(animations().map(|a| a.map(frames)).collect::<Int32Array>()),
    );
    add(
        "frame_rate",
        Arc::new(animations().map(|a| a.map(rate)).collect::<Float64Array>()),
    );
    add(
        "duration",
        Arc::new(animations().map(|a| a.map(duration)).collect::<Float64Array>()),
    );
    add("metres_per_unit", Arc::new(metres.collect::<Float64Array>()));
    add("up", Arc::new(up.collect::<StringArray>()));
    add("warnings", Arc::new(warnings.finish()));
    batch(columns, true)
}

/// The SHA-256 of a skeleton. Two skeletons have the same hash if their joints have equal names, parents and offsets,
/// in the same order.
fn skeleton_hash(joints: &[Joint]) -> String {
    let mut hash = Sha256::new();
    for joint in joints {
        // The length shows where a name ends.
        hash.update((joint.name.len() as u64).to_le_bytes());
        hash.update(joint.name.as_bytes());
        hash.update(joint.parent.map_or(-1, |parent| parent as i64).to_le_bytes());
        for length in joint.offset.to_array() {
            // Adding 0 turns minus zero into zero.
            hash.update((length + 0.0).to_le_bytes());
        }
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

fn batch(columns: Vec<(String, ArrayRef)>, nullable: bool) -> RecordBatch {
    let rows = columns.first().map_or(0, |(_, column)| column.len());
    let field =
        |(name, column): &(String, ArrayRef)| Field::new(name, column.data_type().clone(), nullable && name != "clip");
    let schema = Schema::new(columns.iter().map(field).collect::<Vec<_>>());
    let columns = columns.into_iter().map(|(_, column)| column).collect();
    let options = RecordBatchOptions::new().with_row_count(Some(rows));
    RecordBatch::try_new_with_options(Arc::new(schema), columns, &options)
        .expect("the schema is made of the columns, which are equally long")
}

fn float_lists(motions: &[Option<&Arrays>], width: usize, value: &dyn Fn(&Arrays) -> Vec<f32>) -> ArrayRef {
    let width_i32 = i32::try_from(width).expect("a rotation has at most nine numbers");
    let mut lists = ListBuilder::new(FixedSizeListBuilder::new(Float32Builder::new(), width_i32));
    for motion in motions {
        if let Some(values) = motion.map(value) {
            lists.values().values().append_slice(&values);
            for _ in 0..values.len() / width {
                lists.values().append(true);
            }
        }
        lists.append(motion.is_some());
    }
    Arc::new(lists.finish())
}

fn names(motions: &[Option<&Arrays>]) -> ArrayRef {
    let mut lists = ListBuilder::new(StringBuilder::new());
    for motion in motions {
        for joint in motion.iter().flat_map(|motion| motion.joints()) {
            lists.values().append_value(&joint.name);
        }
        lists.append(motion.is_some());
    }
    Arc::new(lists.finish())
}

fn parents(motions: &[Option<&Arrays>]) -> ArrayRef {
    let mut lists = ListBuilder::new(Int32Builder::new());
    for motion in motions {
        for joint in motion.iter().flat_map(|motion| motion.joints()) {
            lists
                .values()
                .append_value(joint.parent.map_or(-1, |parent| parent as i32));
        }
        lists.append(motion.is_some());
    }
    Arc::new(lists.finish())
}

fn contacts(motions: &[Option<&Arrays>]) -> ArrayRef {
    let mut lists = ListBuilder::new(BooleanBuilder::new());
    for motion in motions {
        let values = motion.and_then(|motion| motion.contacts.as_deref()).unwrap_or_default();
        lists.values().append_slice(values);
        lists.append(motion.is_some());
    }
    Arc::new(lists.finish())
}
