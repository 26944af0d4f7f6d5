//! The descriptor of a clip: the mean and the standard deviation over time of each number of its fingerprint, 68
//! numbers in all. For the map and the selection, each number is divided by its standard deviation over the corpus.

use mocap_scene::math::principal;

use super::fingerprint::{Fingerprint, WIDTH};

/// The length of a descriptor.
pub(super) const LENGTH: usize = 2 * WIDTH;

/// Iterations to find the axes of the map.
const ROUNDS: usize = 200;

/// The descriptors of a corpus, each number with mean 0 and deviation 1; `None` for clips without samples.
pub(super) fn descriptors<'a>(clips: impl Iterator<Item = &'a Fingerprint>) -> Vec<Option<Vec<f32>>> {
    let mut all: Vec<Option<Vec<f32>>> = clips.map(descriptor).collect();
    for index in 0..LENGTH {
        let values = || all.iter().flatten().map(|descriptor| f64::from(descriptor[index]));
        let count = values().count().max(1) as f64;
        let mean = values().sum::<f64>() / count;
        let deviation = (values().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
        // A smaller deviation is rounding.
        let scale = if deviation > 1e-4 { 1.0 / deviation } else { 0.0 };
        for descriptor in all.iter_mut().flatten() {
            descriptor[index] = ((f64::from(descriptor[index]) - mean) * scale) as f32;
        }
    }
    all
}

fn descriptor(fingerprint: &Fingerprint) -> Option<Vec<f32>> {
    let samples = fingerprint.samples();
    if samples == 0 {
        return None;
    }
    let mut descriptor = vec![0.0; LENGTH];
    for index in 0..WIDTH {
        let value = |sample: usize| f32::from(fingerprint.row(sample)[index]) / 127.0;
        let mean = (0..samples).map(value).sum::<f32>() / samples as f32;
        let square = (0..samples).map(|sample| (value(sample) - mean).powi(2)).sum::<f32>() / samples as f32;
        descriptor[index] = mean;
        descriptor[WIDTH + index] = square.sqrt();
    }
    Some(descriptor)
}

/// The first two principal components of each descriptor, by power iteration on the covariance.
pub(super) fn map(descriptors: &[Option<Vec<f32>>]) -> Vec<Option<[f64; 2]>> {
    let rows = descriptors.iter().flatten();
    let rows: Vec<Vec<f64>> = rows
        .map(|row| row.iter().map(|value| f64::from(*value)).collect())
        .collect();
    let products = principal::products(rows.iter().map(Vec::as_slice), LENGTH);
    // If the descriptors span fewer than two directions, the other coordinates are 0.
    let mut axes = principal::axes(&products, LENGTH, 2, ROUNDS);
    axes.resize(2, vec![0.0; LENGTH]);
    let index = |descriptor: &Vec<f32>| {
        let along = |axis: &Vec<f64>| descriptor.iter().zip(axis).map(|(a, b)| f64::from(*a) * b).sum();
        [along(&axes[0]), along(&axes[1])]
    };
    descriptors
        .iter()
        .map(|descriptor| descriptor.as_ref().map(index))
        .collect()
}
