//! The scenes that JavaScript holds, each with a number that is never reused.

use std::collections::BTreeMap;
use std::sync::Arc;

use mocap::figure::Humanoid;
use mocap::glam::Mat4;
use mocap::gltf::Character;
use mocap::gltf::report::Provenance;
use mocap::retarget::Retargeter;
use mocap::retarget::report::LimbAngles;
use mocap::retarget::robot::{Robot, add_links, robot_scene};
use mocap::{Binding, Pose, Scene};

use crate::failure::Failure;

/// A scene, with data that is computed once.
pub(crate) struct Entry {
    pub(crate) scene: Scene,
    /// The file of a glTF character, to which motions are added.
    pub(crate) character: Option<Arc<Character>>,
    /// The robot whose links are the scene.
    pub(crate) robot: Option<Arc<Robot>>,
    /// The retargeter of the robot's motion.
    pub(crate) on_robot: Option<Arc<Retargeter>>,
    /// The joints of humanoid bones, if known.
    pub(crate) humanoid: Option<Humanoid>,
    /// Whether a conversion made the scene, so that its unit and axes are known.
    pub(crate) is_converted: bool,
    /// The angles between the limbs of the first animation and the source's limbs, if the caller wants them.
    limb_angles: Option<Vec<LimbAngles>>,
    /// The provenance of each retargeted animation.
    pub(crate) provenance: Vec<Provenance>,
    bindings: Vec<Option<Binding>>,
    rest: Vec<Mat4>,
    pose: Pose,
}

impl Entry {
    pub(crate) fn new(scene: Scene, character: Option<Arc<Character>>) -> Self {
        Self {
            bindings: scene.animations.iter().map(|_| None).collect(),
            rest: scene.nodes.iter().map(|node| node.transform).collect(),
            pose: Pose::rest(&scene),
            scene,
            character,
            robot: None,
            on_robot: None,
            humanoid: None,
            is_converted: false,
            limb_angles: None,
            provenance: Vec::new(),
        }
    }

    pub(crate) fn with_humanoid(mut self, humanoid: Option<Humanoid>) -> Self {
        self.humanoid = humanoid;
        self
    }

    /// Makes an entry of a robot's links. With `shapes`, the scene has the meshes of the links.
    pub(crate) fn of_robot(robot: Robot, shapes: bool) -> Self {
        let mut scene = robot_scene(&robot);
        if shapes {
            add_links(&robot, &mut scene);
        }
        Self {
            robot: Some(Arc::new(robot)),
            ..Self::new(scene, None)
        }
    }

    pub(crate) fn on_robot(mut self, robot: Option<Arc<Robot>>, motion: Option<Arc<Retargeter>>) -> Self {
        self.robot = robot;
        self.on_robot = motion;
        self
    }

    pub(crate) fn with_limb_angles(mut self, angles: Option<Vec<LimbAngles>>) -> Self {
        self.limb_angles = angles;
        self
    }

    pub(crate) fn with_provenance(mut self, provenance: Vec<Provenance>) -> Self {
        self.provenance = provenance;
        self
    }

    pub(crate) fn converted(mut self) -> Self {
        self.is_converted = true;
        self
    }

    /// Makes an entry of an edited scene. The provenance of a retargeted motion also records the steps.
    pub(crate) fn edited(&self, mut changed: Scene) -> Self {
        let mut provenance = self.provenance.clone();
        if let Some(first) = provenance.first_mut() {
            let done = changed.metadata.steps.split_off(self.scene.metadata.steps.len());
            first.steps.extend(done);
        }
        Self {
            humanoid: self.humanoid.clone(),
            is_converted: self.is_converted,
            provenance,
            ..Self::new(changed, self.character.clone())
        }
    }

    pub(crate) fn limb_angles(&self) -> Option<&[LimbAngles]> {
        self.limb_angles.as_deref()
    }

    /// The matrices relative to the parents in the rest pose.
    pub(crate) fn rest(&self) -> &[Mat4] {
        &self.rest
    }

    /// The world matrices of the nodes; `None` if there is no such animation.
    pub(crate) fn pose(&mut self, animation: u32, tick: f64) -> Option<&[[f32; 16]]> {
        let index = animation as usize;
        let animation = self.scene.animations.get(index)?;
        let binding = self.bindings.get_mut(index)?;
        let binding = binding.get_or_insert_with(|| Binding::new(&self.scene, animation));
        self.pose.sample(binding, animation, tick);
        Some(self.pose.node_to_world_arrays())
    }

    pub(crate) fn to_parent(&self) -> &[[f32; 16]] {
        self.pose.node_to_parent_arrays()
    }
}

#[derive(Default)]
pub(crate) struct Scenes {
    entries: BTreeMap<u32, Entry>,
    last: u32,
}

impl Scenes {
    pub(crate) fn add(&mut self, entry: Entry) -> Result<u32, Failure> {
        let next = self.last.checked_add(1);
        self.last = next.ok_or_else(|| Failure::argument("there were 2^32 scenes; load the module again"))?;
        self.entries.insert(self.last, entry);
        Ok(self.last)
    }

    pub(crate) fn get(&self, number: u32) -> Result<&Entry, Failure> {
        self.entries
            .get(&number)
            .ok_or_else(|| Failure::argument("the scene was freed"))
    }

    pub(crate) fn get_mut(&mut self, number: u32) -> Option<&mut Entry> {
        self.entries.get_mut(&number)
    }

    pub(crate) fn free(&mut self, number: u32) {
        self.entries.remove(&number);
    }
}
