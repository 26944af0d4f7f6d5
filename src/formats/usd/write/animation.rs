//! Writes animations: translations, rotations and scales of the moving joints.

use glam::{Quat, Vec3};
use mocap_scene::error::{Code, Result};
use mocap_scene::limits::{self, is_plausible};
use mocap_scene::pose::{Binding, Trs};
use mocap_scene::scene::{Animation, Channel, Keys};

use super::text;
use super::{Stage, unrepresentable};
use crate::usd::{DURATION, RATE};

/// Up to this relative difference between a scale and its 16-bit value, the report has no note. Such differences come
/// from the rounding of a decomposed matrix.
const ROUNDING: f32 = 1e-5;

/// A joint that an animation drives.
struct AnimatedJoint<'a> {
    joint: usize,
    channel: &'a Channel,
    rest: Trs,
}

impl Stage<'_> {
    /// Writes an animation of the scene, as a prim with this name.
    pub(super) fn clip(&mut self, index: usize, name: &str) -> Result<()> {
        let animation = &self.scene.animations[index];
        let rate = limits::frame_rate(Code::FrameTime, animation.ticks_per_second)?;
        let driven = self.driven(animation)?;
        self.note_scales(animation, &driven);
        let metadata = text::display_name(&animation.name, name);
        let metadata: Vec<&str> = metadata.as_deref().into_iter().collect();
        self.text.open("def SkelAnimation", name, &metadata);
        self.text.line(&format!("custom double {RATE} = {rate}"));
        self.text
            .line(&format!("custom double {DURATION} = {}", animation.duration));
        let token = |out: &mut String, token: &str| out.push_str(&text::quoted(token));
        let joints = driven.iter().map(|driven| self.skeleton.joints[driven.joint].as_str());
        self.text.list("uniform token[] joints", joints, token);
        let codes = self.rate / rate;
        let codes_of = |ticks: &[f64]| -> Vec<f64> { ticks.iter().map(|tick| tick * codes).collect() };

        let ticks = ticks(driven.iter().map(|driven| &driven.channel.position_keys));
        let at = |index: usize| {
            let of = |driven: &AnimatedJoint<'_>| driven.channel.position_keys.sample(ticks[index]);
            let all = driven
                .iter()
                .map(|driven| of(driven).unwrap_or(driven.rest.translation));
            all.map(|value| value.to_array()).collect()
        };
        self.text
            .samples("float3[] translations", &codes_of(&ticks), at, text::tuple);

        let ticks = self::ticks(driven.iter().map(|driven| &driven.channel.rotation_keys));
        let at = |index: usize| {
            let of = |driven: &AnimatedJoint<'_>| driven.channel.rotation_keys.sample(ticks[index]);
            let all = driven.iter().map(|driven| of(driven).unwrap_or(driven.rest.rotation));
            // In USD, the real part of a quaternion comes first.
            all.map(Quat::normalize)
                .map(|value| [value.w, value.x, value.y, value.z])
                .collect()
        };
        self.text
            .samples("quatf[] rotations", &codes_of(&ticks), at, text::tuple);

        let ticks = self::ticks(driven.iter().map(|driven| &driven.channel.scaling_keys));
        let at = |index: usize| {
            let of = |driven: &AnimatedJoint<'_>| driven.channel.scaling_keys.sample(ticks[index]);
            let all = driven.iter().map(|driven| of(driven).unwrap_or(driven.rest.scale));
            all.map(|value| value.to_array().map(half_of_scale)).collect()
        };
        self.text.samples("half3[] scales", &codes_of(&ticks), at, text::tuple);
        self.weights(index, codes);
        self.text.close();
        Ok(())
    }

    /// The joints that an animation drives, in the order of the skeleton. If it drives no joint, returns the first
    /// joint.
    fn driven<'a>(&self, animation: &'a Animation) -> Result<Vec<AnimatedJoint<'a>>> {
        const NOTHING: &Channel = &Channel {
            node_name: String::new(),
            node: None,
            position_keys: Keys {
                values: Vec::new(),
                ticks: None,
            },
            rotation_keys: Keys {
                values: Vec::new(),
                ticks: None,
            },
            scaling_keys: Keys {
                values: Vec::new(),
                ticks: None,
            },
        };
        let binding = Binding::new(self.scene, animation);
        let found = binding
            .driven()
            .map(|(node, channel)| (node.index(), &animation.channels[channel]));
        let mut found: Vec<(usize, &Channel)> = found.collect();
        if found.is_empty() {
            found.push((0, NOTHING));
        }
        found.sort_by_key(|(joint, _)| *joint);
        for (_, channel) in &found {
            check(channel)?;
        }
        let driven = found.into_iter().map(|(joint, channel)| AnimatedJoint {
            joint,
            channel,
            rest: Trs::from_matrix(self.scene.nodes[joint].transform),
        });
        Ok(driven.collect())
    }

    /// Adds a note if a scale in the file differs from the scale in the scene.
    fn note_scales(&mut self, animation: &Animation, driven: &[AnimatedJoint<'_>]) {
        let worst = |driven: &AnimatedJoint<'_>| {
            let keys = driven.channel.scaling_keys.values.iter().copied();
            let rest = driven.channel.scaling_keys.is_empty().then_some(driven.rest.scale);
            let of = |scale: f32| (half_of_scale(scale) - scale).abs() / scale.abs().max(f32::MIN_POSITIVE);
            keys.chain(rest)
                .flat_map(|scale| scale.to_array())
                .map(of)
                .fold(0.0, f32::max)
        };
        let inexact = driven.iter().map(|driven| (worst(driven), driven.joint));
        let Some((worst, joint)) = inexact
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|(worst, _)| *worst > ROUNDING)
        else {
            return;
        };
        self.notes.push(format!(
            "{:?}: scales of UsdSkel have half precision; the largest error is {:.4} %, at joint {:?}",
            animation.name,
            100.0 * worst,
            self.scene.nodes[joint].name
        ));
    }
}

/// Refuses values that are not a transform.
fn check(channel: &Channel) -> Result<()> {
    let is_sound = |value: &Vec3| value.to_array().into_iter().all(|number| is_plausible(number.into()));
    let is_rotation = |value: &Quat| value.is_finite() && value.length_squared() > f32::EPSILON;
    let of_position = channel.position_keys.values.iter().position(|value| !is_sound(value));
    let of_scale = channel.scaling_keys.values.iter().position(|value| !is_sound(value));
    let of_rotation = channel
        .rotation_keys
        .values
        .iter()
        .position(|value| !is_rotation(value));
    let found = [
        ("position", of_position.map(|key| channel.position_keys.tick(key))),
        ("scale", of_scale.map(|key| channel.scaling_keys.tick(key))),
        ("rotation", of_rotation.map(|key| channel.rotation_keys.tick(key))),
    ];
    match found.into_iter().find_map(|(what, tick)| Some((what, tick?))) {
        Some((what, tick)) => {
            let message = format!("the {what} at tick {tick} is not finite, or too large to compute with");
            Err(unrepresentable(&channel.node_name, message))
        }
        None => Ok(()),
    }
}

/// The ticks of the keys of all tracks in `keys` that move; the tick 0 if no track moves.
pub(super) fn ticks<'a, T: 'a>(keys: impl Iterator<Item = &'a Keys<T>>) -> Vec<f64> {
    let moving = keys.filter(|keys| keys.len() > 1);
    let mut ticks: Vec<f64> = moving
        .flat_map(|keys| (0..keys.len()).map(|index| keys.tick(index)))
        .collect();
    ticks.sort_unstable_by(f64::total_cmp);
    ticks.dedup();
    if ticks.is_empty() {
        ticks.push(0.0);
    }
    ticks
}

/// The 16-bit float nearest to a scale. The result is 0 only if the scale is 0, because an axis without length has no
/// direction.
pub fn half_of_scale(scale: f32) -> f32 {
    match half(scale) {
        0.0 if scale != 0.0 => STEP.copysign(scale),
        nearest => nearest,
    }
}

/// The smallest number of a 16-bit float above 0, which is also the step between the smallest numbers.
pub const STEP: f32 = 5.960_464_5e-8;

/// The nearest 16-bit float (IEEE 754 binary16), USD's `half`.
pub fn half(value: f32) -> f32 {
    /// The smallest number that a 16-bit float holds with full precision: 2^-14.
    const NORMAL: f32 = 6.103_515_6e-5;

    /// The largest 16-bit float as a number: (2 - 2^-10) 2^15.
    const LARGEST: f32 = 65_504.0;
    if value.abs() < NORMAL {
        return (value / STEP).round_ties_even() * STEP;
    }
    let bits = value.to_bits();
    let rounded = (bits + 0x0FFF + ((bits >> 13) & 1)) & !0x1FFF;
    f32::from_bits(rounded).clamp(-LARGEST, LARGEST)
}
