//! Removes markers that are out of place for a short time: reflections, or markers with the label of another marker.
//! Their distances to rigid neighbours reveal them.

use glam::DVec3;
use mocap_scene::math::median::median;

use super::take::{Take, Track};

/// The number of frames from which distances are measured.
const FRAMES: usize = 100;

/// The number of partners of a marker: the markers whose distances to it change least, because they are on one bone.
const PARTNERS: usize = 4;

/// The smallest number of seen partners, because a single partner could itself be wrong.
const LEAST_PARTNERS: usize = 2;

/// In metres. If the distance between a marker and its partner has a larger median deviation, the partner is not used.
const KEEPS: f64 = 0.03;

/// The deviation of a distance in metres above which it is wrong: twice as far as the skin of one bone slides.
const WRONG: f64 = 0.04;

/// The smallest ratio of the deviation of a wrong distance to the usual deviation. Normal noise exceeds this ratio once
/// in a billion.
const TIMES: f64 = 6.0;

/// The mean deviation of distances in metres above which the left and the right marker of a name may be exchanged. In a
/// walk, the median deviation of distances on one limb is less.
const EXCHANGED: f64 = 0.01;

/// The ratio of the deviations with exchanged labels to the deviations without an exchange. Below this ratio, two
/// labels are exchanged.
const EXCHANGE: f64 = 0.4;

/// The ratio of the distances with exchanged labels to the distances without an exchange. Below this ratio, two labels
/// may be exchanged although distances hardly change.
const EXCHANGED_DISTANCE: f64 = 0.5;

/// A marker whose distance to another one stays constant.
struct Partner {
    marker: usize,
    distance: f64,
    /// The median deviation of the distance.
    deviation: f64,
}

/// Removes the positions that contradict more than half of the marker's partners.
pub(super) fn leave_out(take: &mut Take) {
    let partners = partners(take);
    for frame in 0..take.frames {
        let is_stray = |(marker, partners): (usize, &Vec<Partner>)| {
            let own = take.tracks[marker][frame]?;
            let wrong = partners.iter().filter_map(|partner| {
                let off = (own.distance(take.tracks[partner.marker][frame]?) - partner.distance).abs();
                Some(off > f64::max(WRONG, TIMES * partner.deviation))
            });
            let wrong: Vec<bool> = wrong.collect();
            let count = wrong.iter().filter(|wrong| **wrong).count();
            (wrong.len() >= LEAST_PARTNERS && 2 * count > wrong.len()).then_some(marker)
        };
        let strays: Vec<usize> = partners.iter().enumerate().filter_map(is_stray).collect();
        for marker in strays {
            take.tracks[marker][frame] = None;
        }
    }
}

/// Exchanges the tracks of a left and a right marker that have each other's labels in the whole take. Their distances
/// to the markers of the same limb then change, and the distances to the other limb stay. Returns the labels.
pub(super) fn exchange(take: &mut Take) -> Vec<[String; 2]> {
    let mut exchanged = Vec::new();
    while let Some((left, right)) = exchanged_pair(take) {
        take.tracks.swap(left, right);
        exchanged.push([left, right].map(|marker| take.labels[marker].clone()));
        if exchanged.len() == take.landmarks.len() {
            break;
        }
    }
    exchanged
}

/// The pair of markers whose distances improve most with exchanged labels.
fn exchanged_pair(take: &Take) -> Option<(usize, usize)> {
    let opposite = |marker: usize| {
        let name = take.landmarks[marker].name.strip_prefix('L')?;
        take.landmarks
            .iter()
            .position(|other| other.name.strip_prefix('R') == Some(name))
    };
    let pairs: Vec<(usize, usize)> = (0..take.landmarks.len())
        .filter_map(|left| Some((left, opposite(left)?)))
        .collect();
    let step = (take.frames / FRAMES).max(1);
    let ratio = |&(left, right): &(usize, usize)| {
        let bone = take.landmarks[left].bone;
        let is_mate = |other: &&(usize, usize)| {
            let own = take.landmarks[other.0].bone;
            other.0 != left && (own == bone || own.parent() == Some(bone) || bone.parent() == Some(own))
        };
        // The sums of the distances to the markers of a limb, and of the deviations from them.
        let sums = |own: fn((usize, usize)) -> (usize, usize)| {
            let mates = pairs.iter().filter(is_mate).map(|mate| own(*mate));
            mates
                .flat_map(|(of_left, of_right)| [(left, of_left), (right, of_right)])
                .filter_map(|(a, b)| constant(&take.tracks[a], &take.tracks[b], step))
                .fold((0.0, 0.0, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1, sum.2 + 1.0))
        };
        let own = sums(|mate| mate);
        let other = sums(|(left, right)| (right, left));
        let is_exchanged =
            other.1 < EXCHANGE * own.1 && (own.1 > EXCHANGED * own.2 || other.0 < EXCHANGED_DISTANCE * own.0);
        is_exchanged.then(|| other.1 / own.1)
    };
    let found = pairs.iter().filter_map(|pair| Some((ratio(pair)?, *pair)));
    found.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, pair)| pair)
}

/// The median distance of two markers, and the median deviation from it; `None` if they are never seen together.
fn constant(a: &Track, b: &Track, step: usize) -> Option<(f64, f64)> {
    let pairs = std::iter::zip(a, b).step_by(step);
    let mut distances: Vec<f64> = pairs.filter_map(|(a, b)| Some(DVec3::distance((*a)?, (*b)?))).collect();
    let distance = median(&mut distances)?;
    distances.iter_mut().for_each(|own| *own = (*own - distance).abs());
    Some((distance, median(&mut distances)?))
}

fn partners(take: &Take) -> Vec<Vec<Partner>> {
    let step = (take.frames / FRAMES).max(1);
    let count = take.tracks.len();
    let mut found: Vec<Vec<Partner>> = (0..count).map(|_| Vec::new()).collect();
    for a in 0..count {
        for b in 0..a {
            let Some((distance, deviation)) = constant(&take.tracks[a], &take.tracks[b], step) else {
                continue;
            };
            if deviation < KEEPS {
                for (own, marker) in [(a, b), (b, a)] {
                    found[own].push(Partner {
                        marker,
                        distance,
                        deviation,
                    });
                }
            }
        }
    }
    for partners in &mut found {
        partners.sort_by(|a, b| a.deviation.total_cmp(&b.deviation));
        partners.truncate(PARTNERS);
    }
    found
}
