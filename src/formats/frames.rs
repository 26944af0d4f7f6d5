//! The animation of a file with one row of numbers for each frame.

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::{Animation, Channel, Scene};

use crate::warnings::Warnings;

/// Adds the animation at `rate` frames per second. If there are no frames, adds no animation, and warns that the scene
/// has only `what`.
pub(super) fn add_animation(
    scene: &mut Scene,
    (frames, rate): (usize, f64),
    channels: Vec<Channel>,
    what: &str,
    warnings: &mut Warnings,
) {
    let Some(last) = frames.checked_sub(1) else {
        let message = format!("the file has no frames: the scene has {what} and no animation");
        warnings.push(Code::NoMotion, || Diagnostic::new(Code::NoMotion, message));
        return;
    };
    scene.animations.push(Animation {
        name: "Motion".to_owned(),
        ticks_per_second: rate,
        duration: last as f64,
        channels,
    });
}
