//! Motion as NumPy's `.npz`.
//!
//! The format of `.npy` is NumPy's `numpy.lib.format`, version 1.0. A file has a magic string, the length of the
//! header, the header, and the values. The header is a Python literal, padded with blanks, so that the values begin at
//! a multiple of 64 bytes.

use std::io::{Cursor, Write};

use mocap_edit::graph::DistanceMatrix;
use mocap_edit::report::DetectedContacts;
use mocap_retarget::robot::RobotMotion;
use mocap_scene::files::ARRAY_MARK;
use mocap_scene::scene::RotationOrder;
use zip::write::{SimpleFileOptions, ZipWriter};
use zip::{CompressionMethod, result::ZipResult};

use crate::arrays::trainers::{Named, Values};
use crate::arrays::{Arrays, Rotation};

impl Arrays {
    /// NumPy's `.npz`: a zip archive, not compressed, with an `.npy` file for each array. All numbers are
    /// little-endian. Equal arrays give equal bytes.
    ///
    /// | name | dtype and shape | |
    /// |---|---|---|
    /// | `positions` | float32, frames x joints x 3 | |
    /// | `rotations` | float32, frames x joints x 4, 6, 3 or 3 x 3 | by [`Rotation`] |
    /// | `velocities` | float32, frames x joints x 3 | if requested |
    /// | `contacts` | bool, frames x joints | if requested |
    /// | `names` | str, joints | |
    /// | `parents` | int32, joints | -1 for a joint without a parent |
    /// | `offsets` | float32, joints x 3 | |
    /// | `rotation_orders` | str, joints | such as `ZXY`; empty for a joint without one |
    /// | `end_sites` | bool, joints | |
    /// | `frame_rate` | float64, scalar | |
    /// | `header` | str, scalar | the [`Header`](crate::arrays::Header) as JSON |
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::arrays::{ArrayOptions, Arrays};
    ///
    /// let motion = Arrays::of(&mocap::import("fixtures/real/lecture_Test.bvh")?, &ArrayOptions::default())?;
    /// assert!(motion.to_npz().starts_with(b"PK"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn to_npz(&self) -> Vec<u8> {
        Archive::made(|archive| archive.add_all(self))
    }
}

/// Contacts as an `.npz`: `at_rest` (bool, frames x points), `bones` and `names` (str, points), `heights` (float32,
/// points) in metres above the floor, `floor` (float32) and `frame_rate` (float64).
pub fn contacts_npz(contacts: &DetectedContacts) -> Vec<u8> {
    Archive::made(|archive| archive.add_contacts(contacts))
}

/// The motion of a robot as an `.npz`:
///
/// - `fps`
/// - `root_pos` (frames x 3, metres), `root_rot` (frames x 4, x y z w)
/// - `dof_pos` (frames x joints), `dof_names`
/// - `contacts` (bool, frames x 2: the left and the right foot of the source; for a robot with four legs frames x 4,
///   front feet first)
///
/// All numbers are float64.
pub fn robot_npz(motion: &RobotMotion) -> Vec<u8> {
    let frames = motion.frames();
    Archive::made(|archive| {
        archive
            .doubles("root_pos", &[frames, 3], &motion.root_pos())
            .and_then(|()| archive.doubles("root_rot", &[frames, 4], &motion.root_rot()))
            .and_then(|()| archive.doubles("dof_pos", &[frames, motion.dof_names.len()], &motion.dof_pos))
            .and_then(|()| archive.add_of_robot(motion))
    })
}

/// The motion of a robot as MuJoCo's `qpos` (frames x 7 + joints): the position of the base, its rotation as w, x, y
/// and z, and the joints. `fps`, `dof_names` and `contacts` are as in [`robot_npz`].
pub fn robot_qpos_npz(motion: &RobotMotion) -> Vec<u8> {
    let shape = [motion.frames(), 7 + motion.dof_names.len()];
    Archive::made(|archive| {
        archive
            .doubles("qpos", &shape, &motion.qpos())
            .and_then(|()| archive.add_of_robot(motion))
    })
}

/// The distances of a matrix in metres as NumPy's `.npy`: float32, windows of the first clip x windows of the second.
pub fn matrix_npy(matrix: &DistanceMatrix) -> Vec<u8> {
    npy_of_floats(&[matrix.rows, matrix.columns], &matrix.values)
}

/// An archive of arrays of different types.
pub(crate) fn of_arrays(arrays: &[Named]) -> Vec<u8> {
    Archive::made(|archive| {
        for Named { name, shape, values } in arrays {
            match values {
                Values::Int(value) => archive.array(name, "<i8", shape, &value.to_le_bytes())?,
                Values::Floats(values) => {
                    let bytes = values.iter().flat_map(|value| (*value as f32).to_le_bytes());
                    archive.array(name, "<f4", shape, &bytes.collect::<Vec<u8>>())?;
                }
                Values::Doubles(values) => archive.doubles(name, shape, values)?,
                Values::Texts(texts) => {
                    let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
                    archive.strings(name, shape, &texts)?;
                }
            }
        }
        Ok(())
    })
}

/// An archive of float64 arrays with their shapes, and of strings.
pub(super) fn of_doubles(arrays: &[(&str, &[usize], &[f64])], texts: &[(&str, &str)]) -> Vec<u8> {
    Archive::made(|archive| {
        for (name, shape, values) in arrays {
            archive.doubles(name, shape, values)?;
        }
        texts
            .iter()
            .try_for_each(|(name, text)| archive.strings(name, &[], &[text]))
    })
}

/// An `.npy` of 32-bit numbers.
pub(super) fn npy_of_floats(shape: &[usize], values: &[f32]) -> Vec<u8> {
    let bytes = values.iter().flat_map(|value| value.to_le_bytes());
    npy_header("<f4", shape).into_iter().chain(bytes).collect()
}

struct Archive(ZipWriter<Cursor<Vec<u8>>>);

impl Archive {
    /// The bytes of the archive after `add` has filled it.
    fn made(add: impl FnOnce(&mut Self) -> ZipResult<()>) -> Vec<u8> {
        let mut archive = Self(ZipWriter::new(Cursor::new(Vec::new())));
        (archive.0.set_comment(ARRAY_MARK))
            .and_then(|()| add(&mut archive))
            .and_then(|()| archive.0.finish())
            .map(Cursor::into_inner)
            .expect("an archive in memory that may be larger than 4 GiB takes what is written")
    }

    fn add_all(&mut self, arrays: &Arrays) -> ZipResult<()> {
        let joints = arrays.joints();
        let (frames, count) = (arrays.frames, joints.len());
        self.floats("positions", &[frames, count, 3], &arrays.positions)?;
        match arrays.header.rotation {
            Rotation::Matrix => self.floats("rotations", &[frames, count, 3, 3], &arrays.rotations)?,
            other => self.floats("rotations", &[frames, count, other.width()], &arrays.rotations)?,
        }
        if let Some(velocities) = &arrays.velocities {
            self.floats("velocities", &[frames, count, 3], velocities)?;
        }
        if let Some(contacts) = &arrays.contacts {
            self.bools("contacts", &[frames, count], contacts.iter().copied())?;
        }
        let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
        self.strings("names", &[count], &names)?;
        let parents = joints.iter().flat_map(|joint| {
            let parent = joint.parent.and_then(|parent| i32::try_from(parent).ok());
            parent.unwrap_or(-1).to_le_bytes()
        });
        self.array("parents", "<i4", &[count], &parents.collect::<Vec<u8>>())?;
        let offsets: Vec<f32> = joints.iter().flat_map(|joint| joint.offset.to_array()).collect();
        self.floats("offsets", &[count, 3], &offsets)?;
        let orders: Vec<String> = joints.iter().map(|joint| letters(joint.rotation_order)).collect();
        let orders: Vec<&str> = orders.iter().map(String::as_str).collect();
        self.strings("rotation_orders", &[count], &orders)?;
        self.bools("end_sites", &[count], joints.iter().map(|joint| joint.end_site))?;
        self.array("frame_rate", "<f8", &[], &arrays.frame_rate().to_le_bytes())?;
        self.strings("header", &[], &[&arrays.header.to_json()])
    }

    fn add_contacts(&mut self, contacts: &DetectedContacts) -> ZipResult<()> {
        let (frames, points) = (contacts.frames, &contacts.points);
        let at_rest = (0..frames).flat_map(|frame| points.iter().map(move |point| point.at_rest[frame]));
        self.bools("at_rest", &[frames, points.len()], at_rest)?;
        let bones: Vec<&str> = points.iter().map(|point| point.bone.as_str()).collect();
        self.strings("bones", &[points.len()], &bones)?;
        let names: Vec<&str> = points.iter().map(|point| point.name.as_str()).collect();
        self.strings("names", &[points.len()], &names)?;
        let heights: Vec<f32> = points.iter().map(|point| point.height).collect();
        self.floats("heights", &[points.len()], &heights)?;
        self.floats("floor", &[], &[contacts.floor])?;
        self.array("frame_rate", "<f8", &[], &contacts.frame_rate.to_le_bytes())
    }

    fn add_of_robot(&mut self, motion: &RobotMotion) -> ZipResult<()> {
        self.array("fps", "<f8", &[], &motion.fps.to_le_bytes())?;
        let names: Vec<&str> = motion.dof_names.iter().map(String::as_str).collect();
        self.strings("dof_names", &[names.len()], &names)?;
        let (feet, contacts) = motion.contacts_of_feet();
        self.bools("contacts", &[motion.contacts.len(), feet], contacts.into_iter())
    }

    fn doubles(&mut self, name: &str, shape: &[usize], values: &[f64]) -> ZipResult<()> {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.array(name, "<f8", shape, &bytes)
    }

    fn floats(&mut self, name: &str, shape: &[usize], values: &[f32]) -> ZipResult<()> {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.array(name, "<f4", shape, &bytes)
    }

    fn bools(&mut self, name: &str, shape: &[usize], values: impl Iterator<Item = bool>) -> ZipResult<()> {
        self.array(name, "|b1", shape, &values.map(u8::from).collect::<Vec<u8>>())
    }

    /// NumPy's strings: 4 bytes per character, padded with zeros to the length of the longest.
    fn strings(&mut self, name: &str, shape: &[usize], values: &[&str]) -> ZipResult<()> {
        let length = values
            .iter()
            .map(|value| value.chars().count())
            .max()
            .unwrap_or(0)
            .max(1);
        let mut bytes = Vec::with_capacity(4 * length * values.len());
        for value in values {
            let characters = value.chars().map(u32::from);
            let filled = characters.chain(std::iter::repeat(0)).take(length);
            bytes.extend(filled.flat_map(u32::to_le_bytes));
        }
        self.array(name, &format!("<U{length}"), shape, &bytes)
    }

    fn array(&mut self, name: &str, dtype: &str, shape: &[usize], values: &[u8]) -> ZipResult<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(values.len() > (1 << 31));
        self.0.start_file(format!("{name}.npy"), options)?;
        self.0.write_all(&npy_header(dtype, shape))?;
        self.0.write_all(values)?;
        Ok(())
    }
}

fn npy_header(dtype: &str, shape: &[usize]) -> Vec<u8> {
    // The shape is a Python tuple with a comma after every element, because a tuple of one element needs the comma.
    let shape: String = shape.iter().map(|length| format!("{length},")).collect();
    let mut header = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': ({shape}), }}");
    let before = b"\x93NUMPY\x01\x00".len() + 2;
    let padding = 64 - (before + header.len() + 1) % 64;
    header += &" ".repeat(padding % 64);
    header += "\n";
    let length = u16::try_from(header.len()).expect("a dtype and a few axes fit 64 KiB");
    [
        b"\x93NUMPY\x01\x00".as_slice(),
        &length.to_le_bytes(),
        header.as_bytes(),
    ]
    .concat()
}

fn letters(order: Option<RotationOrder>) -> String {
    order.map_or_else(String::new, |order| {
        order.axes().into_iter().map(|axis| ["X", "Y", "Z"][axis]).collect()
    })
}
