//! The range and the frame rate of a stack. If the keys contradict the stated range or rate, the reader trusts the
//! keys.

use std::collections::HashSet;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits;

use crate::warnings::Warnings;

/// The least distance of two keys, in frames of the stated rate, at which sampling loses no key.
const DENSE: f64 = 0.75;

/// The largest relative difference between distances of keys that count as equal.
const UNEVEN: f64 = 0.02;

/// The largest relative distance of a rate from a whole number to which it is rounded. FBX stores times as integers.
const ROUNDING: f64 = 1e-4;

/// The times of the frames of a stack, in seconds.
pub(super) struct Timeline {
    pub(super) begin: f64,
    pub(super) end: f64,
    /// Frames per second.
    pub(super) rate: f64,
}

impl Timeline {
    /// Takes range and rate from the stack, or from the keys of the elements `moved`. `given` is the rate that the
    /// caller wants.
    pub(super) fn new(
        stack: &ufbx::AnimStack,
        moved: &HashSet<u32>,
        (stated_rate, given): (f64, Option<f64>),
        warnings: &mut Warnings,
    ) -> Self {
        let curves = curves(stack, moved);
        let rate = given.unwrap_or_else(|| rate(&curves, stated_rate, stack, warnings));
        let stated = (stack.time_begin, stack.time_end);
        let first = curves.iter().map(|curve| curve.min_time).fold(f64::INFINITY, f64::min);
        let last = curves
            .iter()
            .map(|curve| curve.max_time)
            .fold(f64::NEG_INFINITY, f64::max);
        let half = 0.5 / rate;
        let (begin, end) = match last - first > half {
            true if stated.1.min(last) - stated.0.max(first) > half => {
                let outside = (stated.0 - first).max(0.0) + (last - stated.1).max(0.0);
                if outside > half {
                    warnings.tally(Code::FrameCount, || left_out(stack, stated, (first, last)));
                }
                stated
            }
            true => {
                warnings.tally(Code::HeaderCount, || contradicted(stack, stated, (first, last)));
                (first, last)
            }
            // One key time or no key: nothing contradicts the stated range.
            false => stated,
        };
        Self { begin, end, rate }
    }
}

/// The curves of a stack that move any of the elements `moved`.
fn curves<'a>(stack: &'a ufbx::AnimStack, moved: &HashSet<u32>) -> Vec<&'a ufbx::AnimCurve> {
    let properties = stack.layers.iter().flat_map(|layer| layer.anim_props.iter());
    let of_nodes = properties.filter(|property| moved.contains(&property.element.element_id));
    let curves = of_nodes.flat_map(|property| property.anim_value.curves.iter().flatten());
    let curves = curves.map(|curve| &**curve).filter(|curve| !curve.keyframes.is_empty());
    curves
        .filter(|curve| curve.min_time.is_finite() && curve.max_time.is_finite())
        .collect()
}

/// The stated rate, or the rate of the keys if most keys are nearer to each other than the stated frames. Such keys
/// were recorded at another rate.
fn rate(curves: &[&ufbx::AnimCurve], stated: f64, stack: &ufbx::AnimStack, warnings: &mut Warnings) -> f64 {
    let mut steps: Vec<f64> = (curves.iter())
        .flat_map(|curve| curve.keyframes.windows(2).map(|pair| pair[1].time - pair[0].time))
        .filter(|step| *step > 0.0)
        .collect();
    if steps.is_empty() {
        return stated;
    }
    steps.sort_unstable_by(f64::total_cmp);
    let step = steps[steps.len() / 2];
    let is_even = |other: &&f64| (**other / step - 1.0).abs() < UNEVEN;
    if step * stated >= DENSE
        || limits::frame_rate(Code::FrameTime, step.recip()).is_err()
        || 2 * steps.iter().filter(is_even).count() < steps.len()
    {
        return stated;
    }
    let whole = step.recip().round();
    let found = if (whole * step - 1.0).abs() < ROUNDING {
        whole
    } else {
        step.recip()
    };
    warnings.tally(Code::FrameTime, || {
        let message = format!(
            "the keys of {} are nearer to each other than its frames; mocap used the rate of the keys",
            named(stack)
        );
        Diagnostic::new(Code::FrameTime, message)
            .expected_found(
                format!("{stated} frames per second"),
                format!("{found} keys per second"),
            )
            .help("resample the motion with {fps} for another rate")
    });
    found
}

fn named(stack: &ufbx::AnimStack) -> String {
    format!("the animation stack \"{}\"", stack.element.name)
}

fn seconds((first, last): (f64, f64)) -> String {
    format!("{first:.3} s to {last:.3} s")
}

fn contradicted(stack: &ufbx::AnimStack, stated: (f64, f64), keys: (f64, f64)) -> Diagnostic {
    let said = "states a range without any keys; mocap read the range of the keys";
    beside(Code::HeaderCount, stack, said, (stated, keys))
        .help("set LocalStart and LocalStop of the stack in the exporting program")
}

fn left_out(stack: &ufbx::AnimStack, stated: (f64, f64), keys: (f64, f64)) -> Diagnostic {
    let said = "has keys outside its stated range; mocap skipped them";
    beside(Code::FrameCount, stack, said, (stated, keys))
        .help("if you want the whole motion, set LocalStart and LocalStop of the stack in the exporting program")
}

/// A diagnostic about a stack, with the stated range and the range of the keys.
fn beside(code: Code, stack: &ufbx::AnimStack, said: &str, (stated, keys): ((f64, f64), (f64, f64))) -> Diagnostic {
    let message = format!("{} {said}", named(stack));
    Diagnostic::new(code, message).expected_found(seconds(stated), format!("keys from {}", seconds(keys)))
}
