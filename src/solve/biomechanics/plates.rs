//! Gait events from force plates: when a foot loads a plate, and when it leaves the plate.

use mocap_scene::scene::Scene;

use super::TimeSeries;
use super::events::keeps_times;
use super::forces::COLUMNS;

/// The vertical force in newtons above which a foot is on a plate. It is above the noise of plates, and a heel strike
/// exceeds it within a hundredth of a second.
const LOADED: f64 = 20.0;

/// The shortest load in seconds that is a step. A shorter one is noise, or a second contact at the edge of a plate.
const LEAST_LOAD: f64 = 0.1;

/// The largest difference in seconds between an event of a plate and the same event in the motion. It is shorter than
/// the time between the events of both feet.
const SAME: f64 = 0.1;

/// The times in seconds at which loads on force plates begin and end.
#[derive(Debug, Default)]
pub struct PlateLoads {
    begins: Vec<f64>,
    ends: Vec<f64>,
}

impl PlateLoads {
    /// The loads of a scene's force plates. Empty if there are none, or if a processing step changed the times of the
    /// motion.
    pub fn of(scene: &Scene) -> Self {
        let mut found = Self::default();
        if !keeps_times(scene) {
            return found;
        }
        let Ok(forces) = TimeSeries::ground_forces(scene) else {
            return found;
        };
        for vertical in (1..forces.columns.len()).step_by(COLUMNS.len()) {
            let rows = forces.values.chunks_exact(forces.columns.len());
            let is_loaded: Vec<bool> = rows.map(|row| row[vertical] > LOADED).collect();
            found.add(&is_loaded, forces.frame_rate);
        }
        found
    }

    /// Adds the loads of a plate. A load that begins before the recording has no first event, and a load that ends
    /// after the recording has no last event.
    pub fn add(&mut self, is_loaded: &[bool], rate: f64) {
        let mut first = 0;
        for load in is_loaded.chunk_by(|a, b| a == b) {
            let end = first + load.len();
            if load[0] && load.len() as f64 >= LEAST_LOAD * rate {
                self.begins.extend((first > 0).then(|| first as f64 / rate));
                self.ends.extend((end < is_loaded.len()).then(|| end as f64 / rate));
            }
            first = end;
        }
    }

    /// Replaces events that were found in the motion by events of the plates at the same time. Returns their number.
    pub fn replace(&self, strikes: &mut [f64], toe_offs: &mut [f64]) -> usize {
        let mut replaced = 0;
        for (found, of_plates) in [(strikes, &self.begins), (toe_offs, &self.ends)] {
            for time in found {
                let off = |other: &&f64| (**other - *time).abs();
                let nearest = of_plates.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
                if let Some(nearest) = nearest.filter(|nearest| off(nearest) <= SAME) {
                    *time = *nearest;
                    replaced += 1;
                }
            }
        }
        replaced
    }
}
