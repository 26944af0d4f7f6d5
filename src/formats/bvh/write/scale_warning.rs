//! The warning about joints that scales move in the scene but not in the file.

use glam::{Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{Animation, Scene};

use super::BvhOptions;
use super::build::joints;
use super::motion::Motion;
use super::scales::{SAME_SCALE, places};

/// A warning if scales move joints, because BVH has no channel for scales. The warning states the largest distance.
pub(super) fn scale_warning(scene: &Scene, options: &BvhOptions) -> Result<Option<Diagnostic>> {
    /// The rounding of 32-bit products, as a fraction of the farthest position.
    const ROUNDING: f32 = 1e-5;
    let motion = Motion::new(scene);
    let mut transforms = motion.rest();
    let scales = motion
        .channels
        .iter()
        .flatten()
        .flat_map(|channel| &channel.scaling_keys.values);
    let rest = transforms.iter().map(|transform| &transform.scale);
    if scales.chain(rest).all(|scale| scale.abs_diff_eq(Vec3::ONE, SAME_SCALE)) {
        return Ok(None);
    }
    let joints = joints(&motion, options)?;
    let places = places(&motion);
    let mut scaled = vec![Mat4::IDENTITY; scene.nodes.len()];
    let mut written = scaled.clone();
    let (mut largest, mut farthest) = (0.0_f32, 0.0_f32);
    let mut worst = None;
    for frame in 0..motion.animation.map_or(1, Animation::frame_count) {
        motion.sample(frame, &mut transforms);
        for joint in &joints {
            let transform = transforms[joint.node];
            let position = if joint.moves {
                joint.position(&transform, places.as_deref(), frame)
            } else {
                joint.offset
            };
            let rotation = if joint.turns {
                transform.rotation
            } else {
                Quat::IDENTITY
            };
            let parent = motion.parent(joint.node);
            let to_world = |world: &[Mat4]| parent.map_or(Mat4::IDENTITY, |parent| world[parent]);
            scaled[joint.node] = to_world(&scaled) * transform.matrix();
            written[joint.node] = to_world(&written) * Mat4::from_rotation_translation(rotation, position);
            let point = scaled[joint.node].w_axis.truncate();
            let distance = point.distance(written[joint.node].w_axis.truncate());
            farthest = farthest.max(point.abs().max_element());
            if distance > largest {
                largest = distance;
                worst = Some((joint.name, frame));
            }
        }
    }
    let Some((name, frame)) = worst.filter(|_| largest > ROUNDING * farthest) else {
        return Ok(None);
    };
    let (size, unit) = match scene.metadata.metres_per_unit {
        Some(metres) => (f64::from(largest) * metres, "m"),
        None => (f64::from(largest), "units"),
    };
    let message = format!(
        "BVH has no scale channels: without scales, joints are up to {size:.6} {unit} from their positions in the \
            scene, the farthest in frame {frame}"
    );
    Ok(Some(
        Diagnostic::new(Code::Unrepresentable, message)
            .in_joint(name)
            .help("write glTF to keep the scales"),
    ))
}
