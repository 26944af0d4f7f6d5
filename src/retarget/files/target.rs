//! The target body of a retargeting.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use mocap_formats::gltf::Character;
use mocap_io::import::Importer;
use mocap_scene::error::{Code, Result};
use mocap_scene::scene::Scene;

use crate::robot::{Robot, robot_scene};

/// The target body of a retargeting. A clone shares its data.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::Importer;
/// use mocap::retarget::Target;
///
/// let hero = Target::import("fixtures/skeletons/human_vrm1.gltf", &Importer::new())?;
/// assert!(matches!(hero, Target::Character(_)));
/// let robot = Target::from(Importer::new().import_robot("fixtures/robots/h1.urdf")?);
/// assert!(robot.scene().nodes.len() > 19);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub enum Target {
    /// A glTF or VRM file, which is kept byte by byte, with further animations. Read it with [`Importer::gltf_meshes`]:
    /// the skin shows the soles of the feet.
    Character(Arc<Character>),
    /// A scene with the skeleton of a humanoid, of any unit, axes and rest pose.
    Skeleton(Arc<Scene>),
    /// A robot, whose joints have limits.
    Robot(Arc<Robot>),
}

impl Target {
    /// Imports the character of a glTF or VRM file, with its meshes. From any other file, imports the skeleton, as
    /// `importer` reads it.
    ///
    /// # Errors
    /// The errors of [`Importer::import_character`] and [`Importer::import`].
    pub fn import(path: impl AsRef<Path>, importer: &Importer) -> Result<Self> {
        let path = path.as_ref();
        match importer.for_characters().import_character(path) {
            Err(error) if error.code() == Code::UnknownFormat => Ok(importer.import(path)?.into()),
            read => Ok(read?.into()),
        }
    }

    /// The skeleton of the target, with a node for each link of a robot. A character is in metres with +Y up, a robot
    /// in metres with +Z up.
    pub fn scene(&self) -> Cow<'_, Scene> {
        match self {
            Self::Character(character) => Cow::Borrowed(character.scene()),
            Self::Skeleton(scene) => Cow::Borrowed(scene),
            Self::Robot(robot) => Cow::Owned(robot_scene(robot)),
        }
    }
}

impl From<Character> for Target {
    fn from(character: Character) -> Self {
        Self::Character(Arc::new(character))
    }
}

impl From<Scene> for Target {
    fn from(scene: Scene) -> Self {
        Self::Skeleton(Arc::new(scene))
    }
}

impl From<Robot> for Target {
    fn from(robot: Robot) -> Self {
        Self::Robot(Arc::new(robot))
    }
}
