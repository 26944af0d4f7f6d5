//! Tests of arrays whose numbers do not match their layout: angles in degrees, and normalized numbers.

use std::fmt::Write as _;
use std::fs;

use mocap::arrays::{BodyArrays, BodyLayout};
use mocap::{Code, Importer};

/// A `.npy` file of rows of 64-bit numbers.
fn npy(rows: &[Vec<f64>]) -> Vec<u8> {
    let (frames, width) = (rows.len(), rows[0].len());
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({frames}, {width}), }}\n");
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    let numbers = rows.iter().flatten().flat_map(|number| number.to_le_bytes());
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes()]
        .concat()
        .into_iter()
        .chain(numbers)
        .collect()
}

/// PHUMA's rows of a body whose hips and knees bend by 0.3 and 0.6 rad, multiplied by `unit`. The body turns by `spin`
/// per frame.
fn bending(unit: f64, spin: f64) -> Vec<Vec<f64>> {
    let row = |frame: usize| {
        let mut row = vec![0.0; 69];
        row[2] = 0.9;
        row[4] = spin * frame as f64;
        let bent = (0.3 * frame as f64).sin().abs();
        // Hips are the first and second joints below the root, knees the fourth and fifth.
        for (joint, angle) in [(1, -0.3), (2, -0.3), (4, 0.6), (5, 0.6)] {
            row[3 + 3 * joint] = unit * angle * bent;
        }
        row
    };
    (0..40).map(row).collect()
}

#[test]
fn rotations_in_degrees_are_refused() {
    let read = |rows: &[Vec<f64>]| Importer::new().read(&npy(rows), "a.npy");
    assert!(read(&bending(1.0, 0.0)).is_ok());
    // More than six turns: one joint that keeps rotating.
    assert!(read(&bending(1.0, 1.0)).is_ok());
    let error = read(&bending(1.0_f64.to_degrees(), 0.0)).unwrap_err();
    assert_eq!(error.code(), Code::NumberRange);
    let said = error.to_string();
    assert!(said.contains("not in radians") && said.contains("degrees"), "{said}");
}

const LEGS: &str = r#"<robot name="legs"><link name="base"/><link name="left"/><link name="right"/>
    <joint name="l" type="revolute"><parent link="base"/><child link="left"/><axis xyz="0 1 0"/>
        <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
    <joint name="r" type="revolute"><parent link="base"/><child link="right"/><axis xyz="0 1 0"/>
        <limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>"#;

#[test]
fn joints_of_a_robot_in_degrees_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (robot, table) = (folder.path().join("legs.urdf"), folder.path().join("legs.csv"));
    fs::write(&robot, LEGS).unwrap();
    for (unit, is_read) in [(1.0, true), (1.0_f64.to_degrees(), false)] {
        let mut rows = String::new();
        for frame in 0..20 {
            let angle = unit * 0.6 * (0.3 * f64::from(frame)).sin();
            writeln!(rows, "0,0,0.5,0,0,0,1,{angle},{}", -angle).unwrap();
        }
        fs::write(&table, rows).unwrap();
        let read = Importer::new().body(&robot).import(&table);
        assert_eq!(read.is_ok(), is_read, "{unit}: {:?}", read.err());
    }
}

/// Normalized as for training networks: less the mean of each column, divided by its deviation.
fn normalized(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    /// A smaller deviation counts as 0. No column of the dataset has such a deviation.
    const STILL: f64 = 1e-3;
    let count = rows.len() as f64;
    let columns = (0..rows[0].len()).map(|column| {
        let mean = rows.iter().map(|row| row[column]).sum::<f64>() / count;
        let square = rows.iter().map(|row| (row[column] - mean).powi(2)).sum::<f64>() / count;
        (mean, square.sqrt().max(STILL))
    });
    let columns: Vec<(f64, f64)> = columns.collect();
    let row = |row: &Vec<f64>| -> Vec<f64> {
        let pairs = row.iter().zip(&columns);
        pairs.map(|(number, (mean, by))| (number - mean) / by).collect()
    };
    rows.iter().map(row).collect()
}

#[test]
fn normalized_numbers_of_humanml3d_are_refused() {
    let scene = mocap::import("../../fixtures/arrays/points_smpl22.npy").unwrap();
    let bytes = BodyArrays::new(&scene).unwrap().write(BodyLayout::HumanMl3d).unwrap();
    let numbers: Vec<f64> = bytes[bytes.len() - 59 * 263 * 4..]
        .as_chunks::<4>()
        .0
        .iter()
        .map(|bytes| f64::from(f32::from_le_bytes(*bytes)))
        .collect();
    let rows: Vec<Vec<f64>> = numbers.chunks_exact(263).map(<[f64]>::to_vec).collect();
    let read = |rows: &[Vec<f64>]| Importer::new().read(&npy(rows), "a.npy");
    // A network's numbers have small errors.
    let noisy = rows.iter().enumerate().map(|(frame, row)| {
        let noise = |column: usize| 0.1 * (1e3 * (frame * 263 + column) as f64).sin();
        row.iter()
            .enumerate()
            .map(|(column, number)| number + noise(column))
            .collect()
    });
    assert!(read(&rows).is_ok());
    assert!(read(&noisy.collect::<Vec<_>>()).is_ok());
    let error = read(&normalized(&rows)).unwrap_err();
    assert_eq!(error.code(), Code::NumberRange);
    assert!(error.to_string().contains("normalized"), "{error}");
}
