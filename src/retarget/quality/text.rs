//! A report as text.

use std::collections::BTreeMap;
use std::fmt;

use mocap_scene::scene::HumanoidBone as Bone;

use super::{RetargetReport, Verdict};

/// The bones of each reason.
fn by_reason<'a>(found: impl Iterator<Item = (Bone, &'a str)>) -> BTreeMap<&'a str, Vec<Bone>> {
    let mut bones: BTreeMap<&str, Vec<Bone>> = BTreeMap::new();
    found.for_each(|(bone, reason)| bones.entry(reason).or_default().push(bone));
    bones
}

impl fmt::Display for RetargetReport {
    /// A line for each finding, after the name of the clip.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (clip, verdict) = (&self.clip, self.verdict.as_str());
        if self.frames == 0 && self.verdict == Verdict::Good {
            return write!(f, "{clip}: a face without a body");
        }
        let is_by_names = self.by_names.as_ref().is_some_and(|names| !names.by_parts);
        let what = if is_by_names { "bone" } else { "limb" };
        write!(
            f,
            "{clip}: mean {what} error {:.2} degrees, {:.2} at most, in {} frames: {verdict}; path scaled by {:.3}",
            self.mean_degrees, self.max_degrees, self.frames, self.scale
        )?;
        if self.verdict != Verdict::Good {
            write!(f, "\n{clip}: {verdict} because {}", self.reasons().join("; "))?;
        }
        for limb in self.limbs.iter().filter(|limb| limb.mean_degrees > 1.0) {
            let (bone, mean, most) = (limb.bone.as_str(), limb.mean_degrees, limb.max_degrees);
            let tick = limb.tick;
            write!(
                f,
                "\n{clip}: {bone}: mean error {mean:.1} degrees, {most:.1} at tick {tick}"
            )?;
        }
        if let Some(names) = &self.by_names {
            let lacking = match names.lacking.as_slice() {
                [] => String::new(),
                lacking => format!("; the target lacks {}", lacking.join(", ")),
            };
            let (creature, joints) = (&names.creature, names.joints);
            let by = if names.by_parts { "part of the body" } else { "name" };
            write!(
                f,
                "\n{clip}: both are {creature}; {joints} joints are matched by {by}{lacking}"
            )?;
        }
        for seen in self.seen.iter().filter(|seen| seen.mean_degrees > 15.0) {
            let (mean, most, tick) = (seen.mean_degrees, seen.max_degrees, seen.tick);
            write!(
                f,
                "\n{clip}: {seen}: mean error {mean:.0} degrees, {most:.0} at tick {tick}"
            )?;
        }
        let guesses = self.guessed.iter().map(|guess| (guess.bone, guess.reason.as_str()));
        for (reason, bones) in by_reason(guesses) {
            let verb = if bones.len() == 1 { "is" } else { "are" };
            let bones = Vec::from_iter(bones.into_iter().map(Bone::as_str));
            write!(f, "\n{clip}: {} {verb} guessed: {reason}", bones.join(", "))?;
        }
        if let Some(feet) = &self.feet {
            write!(f, "\n{clip}: {feet}")?;
        }
        if let Some(lock) = &self.lock {
            let given_way = match lock.given_way.iter().sum::<usize>() {
                0 => String::new(),
                frames => format!("; the lock was relaxed in {frames} frames, so that knees do not jerk"),
            };
            let (speed, acceleration) = (lock.speed_ratio, lock.acceleration_ratio);
            write!(
                f,
                "\n{clip}: locked feet have at most {speed:.2} times the speed and {acceleration:.2} times the acceleration \
                 of free feet{given_way}"
            )?;
        }
        if let Some(hands) = &self.hands {
            write!(f, "\n{clip}: {hands}")?;
        }
        if let Some(skin) = &self.skin {
            write!(f, "\n{clip}: {skin}")?;
        }
        if !self.followers.is_empty() {
            let follows = self
                .followers
                .iter()
                .map(|(joint, other)| format!("{joint} follows {other}"));
            let follows: Vec<String> = follows.collect();
            write!(f, "\n{clip}: the skin shows that {}", follows.join(", "))?;
        }
        for clamped in &self.clamped {
            let (bone, centimetres) = (clamped.bone.as_str(), 100.0 * clamped.largest);
            let (frames, reason) = (clamped.frames, &clamped.reason);
            write!(
                f,
                "\n{clip}: {bone} is up to {centimetres:.1} cm from its goal in {frames} frames: {reason}"
            )?;
        }
        let lacks = self.unmapped.iter().map(|lack| (lack.bone, lack.reason.as_str()));
        for (reason, bones) in by_reason(lacks) {
            let (fingers, others): (Vec<_>, Vec<_>) = bones.into_iter().partition(|bone| bone.is_finger());
            let mut bones: Vec<String> = others.iter().map(|bone| bone.as_str().to_owned()).collect();
            if !fingers.is_empty() {
                bones.push(format!("{} bones of fingers", fingers.len()));
            }
            write!(f, "\n{clip}: {}: {reason}", bones.join(", "))?;
        }
        Ok(())
    }
}
