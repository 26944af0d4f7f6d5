//! The weights of all morph targets over time, both of a scene's meshes and of the original file that an output keeps.

use std::mem;

use serde_json::Value;

use super::report::AppliedStep;
use super::{Animation, Keys, Scene};
use crate::error::Error;

/// The clips of a scene besides one, with their weights of morph targets and their extras.
struct OtherClips {
    index: usize,
    animations: Vec<Animation>,
    weights: Vec<Vec<Keys<f32>>>,
    extras: Vec<Value>,
}

impl Scene {
    /// The weights of each morph target in all animations, including targets of [`Scene::original`]. The last tracks
    /// are not weights but the times of [`clip_extras`](Self::clip_extras).
    #[doc(hidden)]
    pub fn weight_keys(&mut self) -> impl Iterator<Item = &mut Vec<Keys<f32>>> {
        let targets = self.meshes.iter_mut().flat_map(|mesh| &mut mesh.morph_targets);
        let passed_through = self.original.iter_mut().flat_map(|original| &mut original.morphs);
        let passed_through = passed_through.flat_map(|curves| &mut curves.targets);
        let clocks = std::iter::once(self.metadata.clip_extras.clocks_mut());
        targets
            .map(|target| &mut target.weight_keys)
            .chain(passed_through)
            .chain(clocks)
    }

    /// The rest weight of each morph target, in the order of [`weight_keys`](Self::weight_keys), and its keys in an
    /// animation, if it has keys.
    #[doc(hidden)]
    pub fn weights_in(&self, animation: usize) -> impl Iterator<Item = (f32, Option<&Keys<f32>>)> {
        let clock = (0.0, keys_in(self.metadata.clip_extras.clocks(), animation));
        self.targets_in(animation).chain([clock])
    }

    /// The name of each morph target, in the order of [`weight_keys`](Self::weight_keys), in a list for each mesh.
    #[doc(hidden)]
    pub fn weight_names(&self) -> impl Iterator<Item = Vec<&str>> {
        let of_meshes = self.meshes.iter().map(|mesh| {
            let targets = mesh.morph_targets.iter();
            targets.map(|target| target.name.as_str()).collect()
        });
        let passed_through = self.original.iter().flat_map(|original| &original.morphs);
        of_meshes.chain(passed_through.map(|curves| curves.names.iter().map(String::as_str).collect()))
    }

    /// Like [`weights_in`](Self::weights_in), for morph targets without the times of extras.
    fn targets_in(&self, animation: usize) -> impl Iterator<Item = (f32, Option<&Keys<f32>>)> {
        let targets = self.meshes.iter().flat_map(|mesh| &mesh.morph_targets);
        let targets = targets.map(move |target| (target.weight, keys_in(&target.weight_keys, animation)));
        let passed_through = self.original.iter().flat_map(|original| &original.morphs);
        let passed_through = passed_through.flat_map(|curves| std::iter::zip(&curves.at_rest, &curves.targets));
        targets.chain(passed_through.map(move |(at_rest, animations)| (*at_rest, keys_in(animations, animation))))
    }

    /// The number of morph target curves in the animations of the scene. Constant weights do not count.
    #[doc(hidden)]
    pub fn weight_curves(&self) -> usize {
        (0..self.animations.len()).map(|clip| self.weight_curves_in(clip)).sum()
    }

    /// The number of morph target curves in a clip.
    pub(super) fn weight_curves_in(&self, clip: usize) -> usize {
        // If the original file is kept, the meshes that were read from this file repeat its curves.
        let is_passed_through = self
            .original
            .as_ref()
            .is_some_and(|original| !original.morphs.is_empty());
        let of_meshes: usize = self.meshes.iter().map(|mesh| mesh.morph_targets.len()).sum();
        let again = if is_passed_through { of_meshes } else { 0 };
        let keys = self.targets_in(clip).skip(again).filter_map(|(_, keys)| keys);
        keys.filter(|keys| keys.values.iter().any(|weight| *weight != keys.values[0]))
            .count()
    }

    /// The number of morph target curves without a mesh in the scene, because the meshes of the file were not read.
    #[doc(hidden)]
    pub fn weight_curves_without_meshes(&self) -> usize {
        let mut targets = self.meshes.iter().flat_map(|mesh| &mesh.morph_targets);
        match targets.any(|target| !target.weight_keys.is_empty()) {
            true => 0,
            false => self.weight_curves(),
        }
    }

    /// Moves the main clip to the front, for an output that has one clip.
    #[doc(hidden)]
    pub fn put_main_clip_first(&mut self) {
        let index = self.main_clip();
        if index == 0 {
            return;
        }
        self.animations[..=index].rotate_right(1);
        if let Some(values) = self.metadata.clip_extras.values_mut().get_mut(..=index) {
            values.rotate_right(1);
        }
        for animations in self.weight_keys().filter(|animations| index < animations.len()) {
            animations[..=index].rotate_right(1);
        }
    }

    /// Drops all animations but one.
    #[doc(hidden)]
    pub fn keep_animation(&mut self, index: usize) {
        drop(self.set_aside(index));
    }

    /// Takes all animations but one out of the scene, until `bring_back`.
    fn set_aside(&mut self, index: usize) -> OtherClips {
        OtherClips {
            index,
            animations: leave_only(&mut self.animations, index),
            weights: self.weight_keys().map(|keys| leave_only(keys, index)).collect(),
            extras: leave_only(self.metadata.clip_extras.values_mut(), index),
        }
    }

    /// Changes one animation of several. In `change`, the scene has only this animation. The scene records the steps of
    /// `change` as steps on this animation.
    #[doc(hidden)]
    pub fn change_clip<T>(&mut self, index: usize, change: impl FnOnce(&mut Self) -> T) -> T {
        let known = self.metadata.steps.len();
        let others = self.set_aside(index);
        let changed = change(self);
        self.bring_back(others);
        let steps = self.metadata.steps.split_off(known);
        if !steps.is_empty() {
            self.metadata.steps.push(AppliedStep::OfClip { index, steps });
        }
        changed
    }

    /// An error that concerns one animation. If the scene has several, the message names this animation.
    #[doc(hidden)]
    pub fn in_clip(&self, index: usize, error: Error) -> Error {
        match self.animations.len() {
            0 | 1 => error,
            _ => error.in_clip(index, &self.animations[index].name),
        }
    }

    /// Puts animations that were set aside back in their places.
    fn bring_back(&mut self, others: OtherClips) {
        let index = others.index;
        put_back(&mut self.animations, others.animations, index);
        for (keys, others) in self.weight_keys().zip(others.weights) {
            put_back(keys, others, index);
        }
        put_back(self.metadata.clip_extras.values_mut(), others.extras, index);
    }
}

/// Leaves only the value at `index`, and returns the others.
fn leave_only<T>(values: &mut Vec<T>, index: usize) -> Vec<T> {
    let mut others = mem::take(values);
    if index < others.len() {
        values.push(others.remove(index));
    }
    others
}

/// Puts the only value back at `index` among the others. Trailing values may be missing.
fn put_back<T: Clone + Default>(values: &mut Vec<T>, mut others: Vec<T>, index: usize) {
    let own = mem::take(values).into_iter().next();
    if own.is_some() || others.len() > index {
        others.resize(others.len().max(index), T::default());
        others.insert(index, own.unwrap_or_default());
    }
    *values = others;
}

fn keys_in(animations: &[Keys<f32>], animation: usize) -> Option<&Keys<f32>> {
    animations.get(animation).filter(|keys| !keys.is_empty())
}
