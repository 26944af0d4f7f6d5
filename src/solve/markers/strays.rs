//! Removes markers that are out of place for a short time: reflections, or markers with the label of another marker.
//! Their distances to rigid neighbours reveal them.

use glam::DVec3;
use mocap_scene::math::median::median;

use super::take::Take;

/// The number of frames from which distances are measured.
const FRAMES: usize = 100;

/// The number of partners of a marker: the markers whose distances to it change least, because they are on one bone.
const PARTNERS: usize = 4;

/// The smallest number of seen partners, because a single partner could itself be wrong.
const LEAST_PARTNERS: usize = 2;

/// The median deviation of a distance in metres above which a partner is not used.
const KEEPS: f64 = 0.03;

/// The deviation of a distance in metres above which it is wrong: twice as far as the skin of one bone slides.
const WRONG: f64 = 0.04;

/// The factor by which a wrong distance exceeds its usual deviation. Normal noise exceeds it once in a billion.
const TIMES: f64 = 6.0;

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

fn partners(take: &Take) -> Vec<Vec<Partner>> {
    let step = (take.frames / FRAMES).max(1);
    let count = take.tracks.len();
    let mut found: Vec<Vec<Partner>> = (0..count).map(|_| Vec::new()).collect();
    for a in 0..count {
        for b in 0..a {
            let pairs = std::iter::zip(&take.tracks[a], &take.tracks[b]).step_by(step);
            let mut distances: Vec<f64> = pairs.filter_map(|(a, b)| Some(DVec3::distance((*a)?, (*b)?))).collect();
            let distance = median(&mut distances).unwrap_or_default();
            distances.iter_mut().for_each(|own| *own = (*own - distance).abs());
            let deviation = median(&mut distances).unwrap_or_default();
            if deviation < KEEPS && !distances.is_empty() {
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
