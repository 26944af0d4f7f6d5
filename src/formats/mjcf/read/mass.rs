//! The mass of a body from its geoms, if `<inertial>` is missing. A geom has the mass that it states. Otherwise it has
//! a uniform density: the stated density, or 1,000 kg/m3.

use std::f64::consts::PI;

use glam::{DMat3, DQuat, DVec3};
use mocap_scene::scene::robot::{Inertial, Placement, RobotShape, ShapeKind};

use super::attributes::{Attributes, Settings};
use crate::warnings::Warnings;
use crate::{Failure, inertial};

/// The density of water in kilograms per cubic metre: MuJoCo's default.
const DENSITY: f64 = 1000.0;

/// The geoms of a body that have a mass.
#[derive(Default)]
pub(super) struct Geoms {
    solids: Vec<SolidShape>,
    /// Whether a geom is a mesh, whose volume is unknown here.
    has_mesh: bool,
}

struct SolidShape {
    mass: f64,
    origin: Placement,
    /// The moments of inertia about the centre, in the axes of the geom.
    moments: DVec3,
}

impl Geoms {
    /// Adds a geom, relative to its body.
    pub(super) fn add(
        &mut self,
        attributes: &Attributes<'_, '_>,
        shape: &RobotShape,
        settings: &Settings,
        body: &str,
        warnings: &mut Warnings,
    ) -> Result<(), Failure> {
        let number = |name: &str| -> Result<Option<f64>, Failure> {
            let numbers = attributes.numbers(name, 1, 1)?;
            Ok(numbers.and_then(|numbers| numbers.first().copied()))
        };
        let group = number("group")?.unwrap_or_default();
        let [first, last] = settings.inertia_groups;
        let (mass, density) = (number("mass")?, number("density")?.unwrap_or(DENSITY));
        let (quantity, stated) = mass.map_or(("density", density), |mass| ("mass", mass));
        let weighs = (first..=last).contains(&group) && stated != 0.0;
        if !weighs || inertial::is_negative(quantity, stated, body, &attributes.element, warnings) {
            return Ok(());
        }
        let Some((volume, moments)) = solid(&shape.kind) else {
            self.has_mesh = true;
            return Ok(());
        };
        let mass = mass.unwrap_or(density * volume);
        self.solids.push(SolidShape {
            mass,
            origin: shape.origin,
            moments: mass * moments,
        });
        Ok(())
    }

    /// The total mass and inertia of the geoms; `None` if unknown.
    pub(super) fn inertial(&self) -> Option<Inertial> {
        let mass: f64 = self.solids.iter().map(|solid| solid.mass).sum();
        if self.has_mesh || !(mass.is_finite() && mass > 0.0) {
            return None;
        }
        let centres = self.solids.iter().map(|solid| solid.mass * solid.origin.translation);
        let centre = centres.sum::<DVec3>() / mass;
        let about_centre = self.solids.iter().map(|solid| {
            let axes = DMat3::from_quat(solid.origin.rotation);
            let own = axes * DMat3::from_diagonal(solid.moments) * axes.transpose();
            let away = solid.origin.translation - centre;
            let outer = DMat3::from_cols(away * away.x, away * away.y, away * away.z);
            own + solid.mass * (DMat3::IDENTITY * away.length_squared() - outer)
        });
        let sum = about_centre.fold(DMat3::ZERO, |sum, matrix| sum + matrix);
        Some(Inertial {
            mass,
            origin: Placement {
                rotation: DQuat::IDENTITY,
                translation: centre,
            },
            inertia: [
                sum.x_axis.x,
                sum.y_axis.y,
                sum.z_axis.z,
                sum.y_axis.x,
                sum.z_axis.x,
                sum.z_axis.y,
            ],
        })
    }
}

/// The volume of a shape, and its moments of inertia about its axes for a mass of 1; `None` for a mesh.
fn solid(kind: &ShapeKind) -> Option<(f64, DVec3)> {
    let about_z = |across: f64, along: f64| DVec3::new(across, across, along);
    Some(match *kind {
        ShapeKind::Sphere { radius } => {
            let volume = 4.0 / 3.0 * PI * radius.powi(3);
            (volume, DVec3::splat(0.4 * radius * radius))
        }
        ShapeKind::Capsule { radius, half_length } => {
            let (square, length) = (radius * radius, 2.0 * half_length);
            let (tube, ball) = (PI * square * length, 4.0 / 3.0 * PI * square * radius);
            let (tube_part, ball_part) = (tube / (tube + ball), ball / (tube + ball));
            // The centre of half a ball is at 3/8 of the radius from the ball's centre.
            let of_ball = 0.4 * square + 0.25 * length * length + 0.375 * length * radius;
            let across = tube_part * (3.0 * square + length * length) / 12.0 + ball_part * of_ball;
            (
                tube + ball,
                about_z(across, tube_part * 0.5 * square + ball_part * 0.4 * square),
            )
        }
        ShapeKind::Cylinder { radius, half_length } => {
            let square = radius * radius;
            let across = (3.0 * square + 4.0 * half_length * half_length) / 12.0;
            (2.0 * PI * square * half_length, about_z(across, 0.5 * square))
        }
        ShapeKind::Box { half_size } => {
            let squares = half_size * half_size;
            (
                8.0 * half_size.element_product(),
                (DVec3::splat(squares.element_sum()) - squares) / 3.0,
            )
        }
        ShapeKind::Ellipsoid { half_size } => {
            let squares = half_size * half_size;
            let volume = 4.0 / 3.0 * PI * half_size.element_product();
            (volume, (DVec3::splat(squares.element_sum()) - squares) / 5.0)
        }
        ShapeKind::Mesh { .. } => return None,
    })
}

/// Scales the masses of the robot to the sum `total`, as the compiler's `settotalmass` requires.
pub(super) fn set_total<'a>(inertials: impl Iterator<Item = &'a mut Inertial>, total: f64) {
    let inertials: Vec<&mut Inertial> = inertials.collect();
    let sum: f64 = inertials.iter().map(|inertial| inertial.mass).sum();
    if !(sum > 0.0 && total > 0.0) {
        return;
    }
    for inertial in inertials {
        inertial.mass *= total / sum;
        inertial.inertia = inertial.inertia.map(|value| value * total / sum);
    }
}
