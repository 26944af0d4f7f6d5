//! Finds random walks of any duration.

use std::collections::BTreeMap;

use mocap_scene::error::{Code, Result};
use mocap_scene::limits::positive;

use super::distance::Alignment;
use super::network::Network;
use super::walk::Walk;

/// The longest walk, in seconds: a day.
const LONGEST: f64 = 86_400.0;

/// The shortest time that a walk stays in a clip, in seconds, if the graph allows it.
const STAY: f64 = 0.5;

/// The search considers the transitions within this time ahead, in seconds.
const AHEAD: f64 = 4.0;

impl Network<'_> {
    /// Finds a random walk that lasts `seconds`. The walk prefers frames that it has seldom visited, and transitions
    /// with a small distance. Another `seed` gives another walk.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if `seconds` is not above 0 or is more than a day; [`Code::InvalidGraph`] if the walk
    /// cannot continue, which never happens in a graph that mocap built.
    pub fn random(&self, seconds: f64, seed: u64) -> Result<Walk> {
        positive(Code::InvalidValue, "seconds", seconds)?;
        if seconds > LONGEST {
            let message = format!("seconds must be at most {LONGEST}, got {seconds}");
            return Err(mocap_scene::error::Diagnostic::new(Code::InvalidValue, message).into());
        }
        let wanted = (seconds * self.rate).ceil() as usize;
        let [stay, ahead] = [STAY, AHEAD].map(|seconds| (seconds * self.rate).round() as usize);
        let (clip, part) = self.first_part()?;
        let mut walk = Walk::begin(self, clip, part[0], Alignment::NONE);
        let mut seen = BTreeMap::<[usize; 2], f64>::new();
        let mut random = Random(seed);
        let second = |[clip, frame]: [usize; 2]| [clip, (frame as f64 / self.rate) as usize];
        loop {
            let piece = walk.pieces[walk.pieces.len() - 1];
            let (clip, frame) = (piece.clip, piece.first);
            let left = wanted.saturating_sub(walk.frames());
            let last = self.clips[clip].part.map_or(frame, |part| part[1]);
            let exits = [(stay, ahead), (stay, last), (0, last)]
                .into_iter()
                .map(|(from, to)| self.exits_within(clip, frame + from, last.min(frame + to)))
                .find(|exits| !exits.is_empty());
            let cost = |seen: &BTreeMap<_, f64>, exit: &super::GraphTransition, random: &mut Random| {
                let often = seen.get(&second(exit.to)).copied().unwrap_or(0.0);
                often + self.cost(exit) + random.next()
            };
            let best = exits
                .unwrap_or_default()
                .iter()
                .map(|exit| (cost(&seen, exit, &mut random), exit));
            let best = best.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, exit)| *exit);
            let until = best.map_or(last, |exit| exit.from[1]);
            if frame + left <= until {
                walk.stay_until(frame + left);
                walk.length = seconds;
                return Ok(walk);
            }
            let Some(exit) = best else {
                return Err(self.dead_end(clip, frame));
            };
            for passed in (frame..=exit.from[1]).step_by(self.rate.ceil() as usize) {
                *seen.entry(second([clip, passed])).or_default() += 1.0;
            }
            *seen.entry(second(exit.to)).or_default() += 1.0;
            walk.take(self, &exit);
            if walk.frames() >= wanted {
                walk.length = seconds;
                return Ok(walk);
            }
        }
    }
}

/// SplitMix64 (Steele, Lea and Flood, 2014).
struct Random(u64);

impl Random {
    /// A number from 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}
