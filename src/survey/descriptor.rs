//! The descriptor of a clip: the mean and the standard deviation of each number of its fingerprint over time, 68 in
//! all. For the map and for choosing, each is divided by its standard deviation over the corpus.

use super::fingerprint::{Fingerprint, WIDTH};

/// Numbers of a descriptor.
pub(super) const LENGTH: usize = 2 * WIDTH;

/// The descriptors of a corpus, each number with mean 0 and deviation 1; `None` for clips without samples.
pub(super) fn descriptors<'a>(clips: impl Iterator<Item = &'a Fingerprint>) -> Vec<Option<Vec<f32>>> {
    let mut all: Vec<Option<Vec<f32>>> = clips.map(descriptor).collect();
    for index in 0..LENGTH {
        let values = || all.iter().flatten().map(|descriptor| f64::from(descriptor[index]));
        let count = values().count().max(1) as f64;
        let mean = values().sum::<f64>() / count;
        let deviation = (values().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
        // What hardly differs is rounding.
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

/// The first two principal components of each descriptor, by power iteration on their covariance.
pub(super) fn map(descriptors: &[Option<Vec<f32>>]) -> Vec<Option<[f64; 2]>> {
    let mut covariance = vec![0.0_f64; LENGTH * LENGTH];
    for descriptor in descriptors.iter().flatten() {
        for (row, a) in descriptor.iter().enumerate() {
            for (column, b) in descriptor.iter().enumerate() {
                covariance[row * LENGTH + column] += f64::from(a * b);
            }
        }
    }
    let mut axes: Vec<Vec<f64>> = Vec::new();
    for number in 0..2 {
        let mut axis: Vec<f64> = (0..LENGTH)
            .map(|index| ((index * 7 + number * 3 + 1) % 11) as f64 - 5.0)
            .collect();
        for _ in 0..200 {
            let mut next: Vec<f64> = covariance.chunks(LENGTH).map(|row| dot(row, &axis)).collect();
            for other in &axes {
                let along = dot(&next, other);
                next.iter_mut()
                    .zip(other)
                    .for_each(|(value, other)| *value -= along * other);
            }
            let length = dot(&next, &next).sqrt();
            if length < 1e-12 {
                break;
            }
            axis = next.into_iter().map(|value| value / length).collect();
        }
        axes.push(axis);
    }
    let index = |descriptor: &Vec<f32>| {
        let along = |axis: &Vec<f64>| descriptor.iter().zip(axis).map(|(a, b)| f64::from(*a) * b).sum();
        [along(&axes[0]), along(&axes[1])]
    };
    descriptors
        .iter()
        .map(|descriptor| descriptor.as_ref().map(index))
        .collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
