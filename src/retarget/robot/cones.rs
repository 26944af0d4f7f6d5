//! Contact forces on a floor: forces within friction cones that come nearest to a wanted force and moment.

use glam::DVec3;

use mocap_scene::math::cholesky;

/// Coulomb's coefficient of friction between soles and floor: the default of MuJoCo.
const FRICTION: f64 = 1.0;

/// The number of edges of the pyramid within a cone.
const EDGES: usize = 4;

/// The weight of the squared forces against the squared residual force. It is so small that it only decides how
/// contacts share a force.
const SHARED: f64 = 1e-6;

/// The largest number of steps of Newton's method, which limits the time of a frame.
const STEPS: usize = 60;

/// The gradient norm at which Newton's method stops, relative to the robot's weight: the level of rounding errors.
const FLAT: f64 = 1e-10;

/// The number of components of a force and a moment.
const SIZE: usize = 6;
type Wrench = [f64; SIZE];

/// The edges of the contacts' friction cones, each with its force and its moment.
#[derive(Clone, Debug, Default)]
pub struct Cones {
    edges: Vec<(DVec3, Wrench)>,
    /// The residual of the wanted force. The search for it starts from the residual of the previous frame, which is
    /// similar.
    left: Wrench,
}

impl Cones {
    /// Sets the contacts, by their vectors from the reference point of the moments, in the length unit of the moments.
    pub fn set(&mut self, contacts: impl Iterator<Item = DVec3>) {
        self.edges.clear();
        for point in contacts {
            for edge in 0..EDGES {
                let (sin, cos) = (std::f64::consts::TAU * (edge as f64 + 0.5) / EDGES as f64).sin_cos();
                let force = DVec3::new(FRICTION * cos, FRICTION * sin, 1.0);
                self.edges.push((force, wrench(force, point.cross(force))));
            }
        }
    }

    /// The contact forces that come nearest to a wanted force and moment, and the residual force and moment.
    ///
    /// With edges a, this minimizes |wanted - sum x a|^2 + s |x|^2 over x >= 0. The dual has six unknowns: x is max(0,
    /// a r) / s. The residual r minimizes |r|^2 / 2 + sum max(0, a r)^2 / 2 s - wanted r, by Newton's method with a
    /// line search.
    pub fn reach(&mut self, force: DVec3, moment: DVec3) -> (Vec<DVec3>, DVec3, DVec3) {
        let wanted = wrench(force, moment);
        for _ in 0..STEPS {
            let (value, slope, mut curvature) = self.at(&self.left, &wanted);
            if dot(&slope, &slope) < FLAT * FLAT {
                break;
            }
            let mut step = slope.map(|slope| -slope);
            cholesky::solve(&mut curvature, &mut step, SIZE);
            let downhill = dot(&step, &slope);
            let mut length = 1.0;
            let along = |length: f64, left: &Wrench| std::array::from_fn(|index| left[index] + length * step[index]);
            while length > 1e-9 && self.value(&along(length, &self.left), &wanted) > value + 1e-4 * length * downhill {
                length *= 0.5;
            }
            self.left = along(length, &self.left);
        }
        let mut forces = vec![DVec3::ZERO; self.edges.len() / EDGES];
        for (index, (force, edge)) in self.edges.iter().enumerate() {
            forces[index / EDGES] += *force * (dot(edge, &self.left).max(0.0) / SHARED);
        }
        let [x, y, z, moment @ ..] = self.left;
        (forces, DVec3::new(x, y, z), DVec3::from_array(moment))
    }

    fn value(&self, left: &Wrench, wanted: &Wrench) -> f64 {
        let pressed = self.edges.iter().map(|(_, edge)| dot(edge, left).max(0.0).powi(2));
        0.5 * dot(left, left) + pressed.sum::<f64>() * (0.5 / SHARED) - dot(wanted, left)
    }

    /// The value, its gradient and its Hessian, row by row.
    fn at(&self, left: &Wrench, wanted: &Wrench) -> (f64, Wrench, [f64; SIZE * SIZE]) {
        let mut slope: Wrench = std::array::from_fn(|index| left[index] - wanted[index]);
        let mut curvature = [0.0; SIZE * SIZE];
        (0..SIZE).for_each(|index| curvature[index * (SIZE + 1)] = 1.0);
        for (_, edge) in &self.edges {
            let pressed = dot(edge, left);
            if pressed <= 0.0 {
                continue;
            }
            for row in 0..SIZE {
                slope[row] += pressed * edge[row] / SHARED;
                for column in 0..=row {
                    curvature[row * SIZE + column] += edge[row] * edge[column] / SHARED;
                }
            }
        }
        (self.value(left, wanted), slope, curvature)
    }
}

fn wrench(force: DVec3, moment: DVec3) -> Wrench {
    [force.x, force.y, force.z, moment.x, moment.y, moment.z]
}

fn dot(a: &Wrench, b: &Wrench) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
