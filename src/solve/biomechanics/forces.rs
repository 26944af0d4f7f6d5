//! Ground reaction forces from the channels of force plates. The C3D user guide describes the plate types, but not
//! types 5 to 7. Their channels and matrices follow Visual3D's documentation (`FP_TYPE`).

use glam::{DMat3, DVec3, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::FORCES_MARK;
use mocap_scene::scene::{AnalogChannel, ForcePlate, Recording, Scene};

use super::TimeSeries;
use super::series::recorded;

/// The vertical force in newtons below which a plate has no centre of pressure. At such a force, noise of some newtons
/// would move the centre by any distance.
const LEAST_FORCE: f64 = 10.0;

/// The names of a plate's columns, as OpenSim's C3D script `osimC3D.m` writes them. `*` is the plate number.
pub(super) const COLUMNS: [(&str, &str); 9] = [
    ("ground_force_*_vx", "N"),
    ("ground_force_*_vy", "N"),
    ("ground_force_*_vz", "N"),
    ("ground_force_*_px", "m"),
    ("ground_force_*_py", "m"),
    ("ground_force_*_pz", "m"),
    ("ground_moment_*_mx", "N m"),
    ("ground_moment_*_my", "N m"),
    ("ground_moment_*_mz", "N m"),
];

impl TimeSeries {
    /// The ground reaction forces on the body, for each force plate of the scene's file. A row has the force in
    /// newtons, the centre of pressure in metres, and the free moment about it in newton metres. The axes are the axes
    /// of the scene as it was read, with +Y up. Centre and moment are 0 while the vertical force is below 10 N.
    ///
    /// # Errors
    /// [`Code::NoMotion`] if the file has no force plates, or none of a known type.
    pub fn ground_forces(scene: &Scene) -> Result<Self> {
        let recorded = recorded(scene, |recorded| !recorded.plates.is_empty(), "force plates")?;
        let mut series = Self {
            title: FORCES_MARK,
            frame_rate: recorded.analog_rate,
            ..Self::default()
        };
        let mut plates = Vec::new();
        for (index, plate) in recorded.plates.iter().enumerate() {
            match wrenches(plate, recorded) {
                Ok(wrenches) => plates.push((index + 1, wrenches)),
                Err(why) => series.notes.push(format!("plate {} was skipped: {why}", index + 1)),
            }
        }
        if plates.is_empty() {
            return Err(
                Diagnostic::new(Code::NoMotion, "no force plate of the file has a known type")
                    .expected_found("type 1 to 7", series.notes.join("; "))
                    .into(),
            );
        }
        // A foot never pulls at the ground. So forces that point down are the forces of the body on the plates.
        let up: f64 = plates
            .iter()
            .flat_map(|(_, wrenches)| wrenches)
            .map(|wrench| wrench.force.y)
            .sum();
        let sign = if up < 0.0 { -1.0 } else { 1.0 };
        if up < 0.0 {
            let note =
                "the file has the forces of the body on the plates, which point down; mocap reversed these forces";
            series.notes.push(note.to_owned());
        }
        for (number, _) in &plates {
            for (name, unit) in COLUMNS {
                series.columns.push(name.replace('*', &number.to_string()));
                series.units.push(unit.to_owned());
            }
        }
        let frames = plates.iter().map(|(_, wrenches)| wrenches.len()).min().unwrap_or(0);
        for frame in 0..frames {
            for (_, wrenches) in &plates {
                let Wrench { force, centre, moment } = wrenches[frame];
                let (force, moment) = (force * sign, moment * sign);
                series
                    .values
                    .extend([force, centre, moment].iter().flat_map(DVec3::to_array));
            }
        }
        Ok(series)
    }
}

/// Force, centre of pressure and free moment, along the axes of the laboratory.
struct Wrench {
    force: DVec3,
    centre: DVec3,
    moment: DVec3,
}

/// Force and moment about the centre of the plate's surface, in the plate's axes.
type ForceAndMoment = (DVec3, DVec3);

/// Computes force and moment from the channel values of a plate type.
type PlateFormula = fn(&ForcePlate, &[f64]) -> ForceAndMoment;

/// Computes the wrench of each sample. The error says why a plate is skipped.
fn wrenches(plate: &ForcePlate, recorded: &Recording) -> Result<Vec<Wrench>, String> {
    let (needed, of_values): (usize, PlateFormula) = match plate.plate_type {
        1 => (6, force_and_centre),
        2 | 4 => (6, force_and_moment),
        3 | 7 => (8, eight_sensors),
        5 => (8, force_and_moment),
        6 => (12, twelve_sensors),
        other => return Err(format!("type {other}")),
    };
    if plate.channels.len() < needed {
        return Err(format!("{} channels of {needed}", plate.channels.len()));
    }
    let calibration = ForcePlate::calibration_size(plate.plate_type);
    if let Some([rows, columns]) = calibration.filter(|[rows, columns]| plate.calibration.len() != rows * columns) {
        return Err(format!("no calibration matrix of {rows} x {columns} numbers"));
    }
    let middle = plate.corners.iter().map(|corner| corner.as_dvec3()).sum::<DVec3>() / 4.0;
    let to_lab = axes(plate).ok_or("its corners are not a rectangle")?;
    let channels: Vec<&AnalogChannel> = plate
        .channels
        .iter()
        .filter_map(|channel| recorded.channels.get(*channel))
        .collect();
    let samples = channels.iter().map(|channel| channel.values.len()).min().unwrap_or(0);
    let per_frame = recorded.samples_per_frame.max(1);
    let value = |channel: usize, sample: usize| {
        let value = f64::from(channels[channel].values[sample]) * plate.scales.get(channel).copied().unwrap_or(1.0);
        if value.is_finite() { value } else { 0.0 }
    };
    let base: Vec<f64> = (0..channels.len())
        .map(|channel| match plate.zero {
            Some([first, last]) => {
                let range = (first * per_frame).min(samples)..((last + 1).saturating_mul(per_frame)).min(samples);
                let count = range.len().max(1) as f64;
                range.map(|sample| value(channel, sample)).sum::<f64>() / count
            }
            None => 0.0,
        })
        .collect();
    let mut values = vec![0.0; channels.len()];
    let wrench = |sample: usize| {
        for (channel, own) in values.iter_mut().enumerate() {
            *own = value(channel, sample) - base[channel];
        }
        let (force, moment) = match calibration {
            Some([_, columns]) => of_values(plate, &calibrated(plate, columns, &values)),
            None => of_values(plate, &values),
        };
        let world = to_lab * force;
        if force.z.abs() < LEAST_FORCE {
            return Wrench {
                force: world,
                centre: DVec3::ZERO,
                moment: DVec3::ZERO,
            };
        }
        let centre = DVec3::new(-moment.y / force.z, moment.x / force.z, 0.0);
        let free = DVec3::new(0.0, 0.0, moment.z - centre.x * force.y + centre.y * force.x);
        Wrench {
            force: world,
            centre: middle + to_lab * centre,
            moment: to_lab * free,
        }
    };
    Ok((0..samples).map(wrench).collect())
}

/// Rotates from the plate's axes to the laboratory axes: x from corner 2 to 1, y from corner 4 to 1.
fn axes(plate: &ForcePlate) -> Option<DMat3> {
    let [a, b, c, d] = plate.corners.map(Vec3::as_dvec3);
    let x = (a - b + (d - c)).try_normalize()?;
    let z = x.cross(a - d + (b - c)).try_normalize()?;
    Some(DMat3::from_cols(x, z.cross(x), z))
}

/// Type 1: forces, centre of pressure, and the moment about the vertical axis through it.
fn force_and_centre(_: &ForcePlate, values: &[f64]) -> ForceAndMoment {
    let force = DVec3::from_slice(values);
    let centre = DVec3::new(values[3], values[4], 0.0);
    (force, centre.cross(force) + DVec3::new(0.0, 0.0, values[5]))
}

/// Types 2, 4 and 5: forces, and moments about the sensor origin.
fn force_and_moment(plate: &ForcePlate, values: &[f64]) -> ForceAndMoment {
    let force = DVec3::from_slice(values);
    (force, DVec3::from_slice(&values[3..]) + force.cross(below(plate)))
}

/// Types 3 and 7: two x and y sensors on each side, and a z sensor in each of the four quadrants.
fn eight_sensors(plate: &ForcePlate, values: &[f64]) -> ForceAndMoment {
    let &[x12, x34, y14, y23, z1, z2, z3, z4, ..] = values else {
        return (DVec3::ZERO, DVec3::ZERO);
    };
    let (a, b) = (plate.origin.x, plate.origin.y);
    let force = DVec3::new(x12 + x34, y14 + y23, z1 + z2 + z3 + z4);
    let moment = DVec3::new(
        b * (z1 + z2 - z3 - z4),
        a * (-z1 + z2 + z3 - z4),
        b * (-x12 + x34) + a * (y14 - y23),
    );
    (force, moment + force.cross(DVec3::new(0.0, 0.0, below(plate).z)))
}

/// Type 6: x, y and z sensors at each corner.
fn twelve_sensors(plate: &ForcePlate, values: &[f64]) -> ForceAndMoment {
    let &[x1, y1, z1, x2, y2, z2, x3, y3, z3, x4, y4, z4, ..] = values else {
        return (DVec3::ZERO, DVec3::ZERO);
    };
    eight_sensors(plate, &[x1 + x2, x3 + x4, y1 + y4, y2 + y3, z1, z2, z3, z4])
}

/// The channel values times the calibration matrix.
fn calibrated(plate: &ForcePlate, columns: usize, values: &[f64]) -> Vec<f64> {
    let row = |row: &[f64]| row.iter().zip(values).map(|(factor, value)| factor * value).sum();
    plate.calibration.chunks(columns).map(row).collect()
}

/// The vector from the sensors to the centre of the surface. The sensors are below the surface, and the plate's z
/// points down. Some programs write a height above 0, which has the wrong sign.
fn below(plate: &ForcePlate) -> DVec3 {
    match plate.origin.z > 0.0 && !matches!(plate.plate_type, 3 | 6 | 7) {
        true => -plate.origin,
        false => DVec3::new(plate.origin.x, plate.origin.y, -plate.origin.z.abs()),
    }
}
