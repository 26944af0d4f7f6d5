//! The last check of a reader's result: the scene must not have numbers that kinematics cannot compute with.
//!
//! Readers detect such numbers where they can state the line of the file. This check finds all other such numbers, for
//! every format.

use glam::Vec3;

use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::limits::{self, FARTHEST, SMALLEST_SCALE, is_degenerate_scale, is_plausible};
use mocap_scene::scene::{Animation, Keys, Scene};

/// # Errors
/// [`Code::NumberRange`] or [`Code::FrameTime`], with the joint.
pub fn check(scene: &Scene) -> Result<()> {
    for node in &scene.nodes {
        let numbers = node.transform.to_cols_array();
        if let Some(number) = numbers.into_iter().find(|number| !is_plausible((*number).into())) {
            return Err(out_of_range("the rest pose", number, &node.name));
        }
    }
    for animation in &scene.animations {
        limits::frame_rate(Code::FrameTime, animation.ticks_per_second)?;
        check_keys(animation)?;
    }
    Ok(())
}

fn check_keys(animation: &Animation) -> Result<()> {
    let is_sound = |scale| is_plausible(scale) && !is_degenerate_scale(scale);
    for channel in &animation.channels {
        let positions = first_without(&channel.position_keys, is_plausible);
        let scales = first_without(&channel.scaling_keys, is_sound);
        for (what, found) in [("position", positions), ("scale", scales)] {
            if let Some((tick, number)) = found {
                let what_and_when = format!("the {what} at tick {tick}");
                return Err(out_of_range(&what_and_when, number, &channel.node_name));
            }
        }
    }
    Ok(())
}

/// The first number that fails a test, and its tick.
fn first_without(keys: &Keys<Vec3>, holds: impl Fn(f64) -> bool) -> Option<(f64, f32)> {
    let all_hold = |value: &Vec3| value.to_array().into_iter().all(|number| holds(number.into()));
    let key = keys.values.iter().position(|value| !all_hold(value))?;
    let number = keys.values[key]
        .to_array()
        .into_iter()
        .find(|number| !holds((*number).into()))?;
    Some((keys.tick(key), number))
}

fn out_of_range(what_and_when: &str, number: f32, joint: &str) -> Error {
    let message = format!("{what_and_when} has a number that is too large or too small to compute with");
    Diagnostic::new(Code::NumberRange, message)
        .in_joint(joint)
        .expected_found(
            format!("at most {FARTHEST:e}, and of a scale 0 or at least {SMALLEST_SCALE:e}"),
            format!("{number:e}"),
        )
        .help("correct the number, or export the file again")
        .into()
}
