//! The gait of a person, or of an animal on four legs.

use mocap_figure::Figure;
use mocap_scene::error::Result;
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::animal_gait::AnimalGait;
use super::gait::Gait;

/// The gait of a person, or of an animal on four legs.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::biomechanics::BodyGait;
///
/// let scene = mocap::import("fixtures/made/dog_walk.bvh")?;
/// let BodyGait::Animal(gait) = BodyGait::of(&scene)? else {
///     panic!("a dog has four legs");
/// };
/// assert_eq!(gait.paws[0].leg, "leftFore");
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum BodyGait {
    /// The steps of a person.
    Humanoid(Box<Gait>),
    /// The named gaits of an animal.
    Animal(AnimalGait),
}

impl BodyGait {
    /// Measures the gait in the first animation of a scene, in any unit and with any up axis.
    ///
    /// # Errors
    /// The errors of [`Gait::of`]. [`Code::NoMotion`](mocap_scene::Code::NoMotion) if an animal does not move.
    pub fn of(scene: &Scene) -> Result<Self> {
        Self::of_figure(scene, &Figure::new(scene))
    }

    /// Like [`of`](Self::of), with the figure that was found in the scene, such as [`Figure::mapped`].
    ///
    /// # Errors
    /// The errors of [`of`](Self::of).
    pub fn of_figure(scene: &Scene, figure: &Figure) -> Result<Self> {
        Ok(match figure.quadruped(scene) {
            Some(animal) => Self::Animal(AnimalGait::of(scene, figure, animal)?),
            None => Self::Humanoid(Box::new(Gait::of_figure(scene, figure)?)),
        })
    }
}
