//! Markers that are out of place for a moment, because they are reflections or have the label of another: the distances
//! to those markers tell that keep theirs.

use glam::DVec3;
use mocap_scene::math::median::median;

use super::take::Take;

/// Frames from which distances are known.
const FRAMES: usize = 100;

/// Partners of a marker, those whose distances to it change least: those of one bone.
const PARTNERS: usize = 4;

/// Partners that must be seen at least: one alone could itself be wrong.
const LEAST_PARTNERS: usize = 2;

/// Partners whose distance is off by more than this in the median, in metres, tell nothing.
const KEEPS: f64 = 0.03;

/// The distance in metres above which a distance is wrong: twice as far as skin of one bone slides.
const WRONG: f64 = 0.04;

/// How many times its usual deviation a wrong distance is off: normal noise is once in a billion.
const TIMES: f64 = 6.0;

/// A marker whose distance to another stays the same.
struct Partner {
    marker: usize,
    distance: f64,
    /// The median of how far it is off.
    deviation: f64,
}

/// Takes those positions out that more than half of the partners have elsewhere.
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
