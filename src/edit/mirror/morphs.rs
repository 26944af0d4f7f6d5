//! Exchanges the weights of morph targets of the left and the right side.

use std::collections::BTreeSet;

use mocap_figure::names::Name;
use mocap_scene::scene::{Keys, Scene};

/// Exchanges the weights of each pair of morph targets of one mesh. The names of the targets state the pairs. Returns
/// the number of pairs with different names.
pub(super) fn exchange(scene: &mut Scene, animation: usize) -> usize {
    let mut pairs = Vec::new();
    let mut names = BTreeSet::new();
    let mut first = 0;
    for of_mesh in scene.weight_names() {
        for (own, other) in Name::pairs(&of_mesh).into_iter().enumerate() {
            if let Some(other) = other.filter(|other| own < *other) {
                names.insert([of_mesh[own], of_mesh[other]]);
                pairs.push((first + own, first + other));
            }
        }
        first += of_mesh.len();
    }
    let count = names.len();
    let weights = scene.weights_in(animation);
    let weights: Vec<(f32, Option<Keys<f32>>)> = weights.map(|(at_rest, keys)| (at_rest, keys.cloned())).collect();
    // The keys of a target that gets the weights of `other`.
    let taken = |own: usize, other: usize| match &weights[other] {
        (_, Some(keys)) => keys.clone(),
        (at_rest, None) if *at_rest == weights[own].0 => Keys::default(),
        (at_rest, None) => Keys::constant(*at_rest),
    };
    let clips = scene.animations.len();
    let mut all: Vec<&mut Vec<Keys<f32>>> = scene.weight_keys().collect();
    for (a, b) in pairs {
        for (own, other) in [(a, b), (b, a)] {
            let keys = taken(own, other);
            let animations = &mut *all[own];
            if keys.is_empty() && animations.get(animation).is_none_or(Keys::is_empty) {
                continue;
            }
            animations.resize(clips.max(animations.len()), Keys::default());
            animations[animation] = keys;
        }
    }
    count
}
