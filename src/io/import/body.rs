//! Reads the body for arrays of rotations from a file.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use mocap_figure::convert::Conversion;
use mocap_figure::robot_bones::robot_scene;
use mocap_figure::vrm_humanoid;
use mocap_formats::{Body, Contents, FormatInfo, ReadOptions, Source, body_model};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{HumanoidBone, Scene};

use super::{Importer, is_array};

impl Importer {
    /// The options of the reader, with the body that the caller named.
    pub(super) fn read_options(&self, source: &Source<'_>) -> Result<ReadOptions> {
        let mut options = self.read.clone();
        if let Some(path) = &self.body {
            let bytes = (source.open)(path)?;
            let file = Source {
                bytes: &bytes,
                name: path,
                blocks: None,
                ..*source
            };
            let body = self.body_of(&file).map_err(|error| error.with_path(path))?;
            options.body = Some(Arc::new(body));
        }
        Ok(options)
    }

    /// A model of the SMPL family, a robot, or the bones of a figure in any format.
    fn body_of(&self, file: &Source<'_>) -> Result<Body> {
        if let Some(model) = body_model(file.bytes, &self.read.limits)? {
            return Ok(Body::Model(model));
        }
        let importer = Self::new().limits(self.read.limits).gltf_meshes(false);
        let row = importer.find_format(file.bytes, file.name);
        if row.is_ok_and(|row| row.contents == Contents::Robot) {
            let robot = importer.robot(file)?;
            // A robot without legs cannot take a person's rotations. It is still accepted, because arrays of its joint
            // positions need only its joints.
            let bones = bones(robot_scene(&robot)).unwrap_or_default();
            return Ok(Body::Robot(Box::new(robot), bones));
        }
        bones(importer.read(file.bytes, file.name)?).map(Body::Bones)
    }

    /// Refuses a body if the file needs none.
    pub(super) fn check_body(&self, scene: &Scene) -> Result<()> {
        if self.body.is_none() || is_array(scene) {
            return Ok(());
        }
        let extension = self.body.as_ref().and_then(|body| body.extension()).unwrap_or_default();
        let mut robots = FormatInfo::ALL.iter().filter(|row| row.contents == Contents::Robot);
        if robots.any(|row| row.extensions.iter().any(|own| extension.eq_ignore_ascii_case(own))) {
            let message = "the file has its own skeleton, so it is not a motion of the robot's joints";
            let help = "name a file of joint positions, as mocap robot writes: .npz, .pkl or .csv";
            return Err(Diagnostic::new(Code::InvalidValue, message).help(help).into());
        }
        let message = "{body} is for arrays of rotations, but this file has its own skeleton";
        let help = "omit {body}; mocap retarget transfers the motion to another body";
        Err(Diagnostic::new(Code::InvalidValue, message).help(help).into())
    }
}

/// Bone positions of a figure in its T-pose.
fn bones(mut scene: Scene) -> Result<BTreeMap<HumanoidBone, Vec3>> {
    Conversion::new().apply(&mut scene)?;
    let body = vrm_humanoid(&scene, None)?;
    let rest = Pose::rest(&body);
    let position =
        |(index, bone): (usize, Option<HumanoidBone>)| Some((bone?, rest.node_to_world[index].w_axis.truncate()));
    let bones = body.nodes.iter().map(|node| node.humanoid_bone).enumerate();
    Ok(bones.filter_map(position).collect())
}
