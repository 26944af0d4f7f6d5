//! Guesses landmarks from marker positions if the labels are unknown. It uses constant distances, and positions while
//! the body stands.
//!
//! 1. Markers of one bone keep their distances. Markers beside a joint keep their distances to both bones. The tree of
//!    these links (single linkage) has each leg as a chain from its foot, and the rest of the body around the head.
//! 2. The feet show the facing direction, and with it left and right.
//! 3. In each body region, height, side and rigidity determine the landmarks: an ankle is rigid to shank and foot, an
//!    elbow to upper arm and forearm.
//!
//! Heights are measured on standing adults, as fractions of the body height: ankle 0.039, knee 0.285, hip 0.53,
//! shoulder 0.82. The source is Drillis and Contini (1966), as in Winter, Biomechanics and Motor Control of Human
//! Movement.

use glam::DVec3;
use mocap_scene::math::median::percentile;

use super::cloud::Cloud;
use super::landmarks::{Landmark, named};

/// The height below which markers are on feet, as a fraction of the body height. Ankles are at 0.04, shin markers above
/// 0.15.
const FEET: f64 = 0.10;
/// The height of a knee as a fraction of the body height (Drillis and Contini, in Winter, Biomechanics and Motor
/// Control of Human Movement).
const KNEE: f64 = 0.285;
/// The heights of knee markers as fractions of the body height, from mid-shin to mid-thigh.
const KNEES: std::ops::Range<f64> = 0.2..0.4;
/// The height below which markers are on legs, as a fraction of the body height. Hips are at 0.53.
const LEGS: f64 = 0.52;
/// The heights of pelvis markers as fractions of the body height. Front spines are at 0.58.
const PELVIS: std::ops::Range<f64> = 0.48..0.68;
/// The height above which markers are on shoulders, as a fraction of the body height. Shoulders are at 0.82.
const SHOULDERS: f64 = 0.72;
/// The height above which markers are on the head, as a fraction of the body height. The chin is at 0.87.
const HEAD: f64 = 0.86;
/// The height above which markers are on the chest, as a fraction of the body height. The navel is at 0.6.
const CHEST: f64 = 0.55;
/// The largest variation of distances between pelvis markers, as a fraction of the body height. It is about 20 mm,
/// because the skin slides.
const RIGID: f64 = 0.012;
/// The largest variation of distances between head markers, as a fraction of the body height: 7 mm.
const RIGID_HEAD: f64 = 0.004;
/// The largest variation of distances between trunk markers, as a fraction of the body height: 10 mm.
const RIGID_TRUNK: f64 = 0.006;
/// The largest distance of a central marker from the body's midline, as a fraction of the body height. A body of
/// 1.7 m has 6 cm.
const MIDDLE: f64 = 0.035;
/// The distances of shoulder markers from the body's midline, as fractions of the body height: 12 to 27 cm.
const BESIDE: std::ops::Range<f64> = 0.07..0.16;
/// The landmarks of the markers, in their order, or a message about what was not found.
pub(super) fn landmarks(tracks: &[Vec<Option<DVec3>>]) -> Result<Vec<Option<Landmark>>, &'static str> {
    let cloud = Cloud::of(tracks).ok_or("fewer than 12 markers are seen often, or more than 200 are")?;
    let mut guess = Guess {
        names: vec![None; cloud.count()],
        forward: Vec::new(),
        left: Vec::new(),
        centre: Vec::new(),
        cloud,
    };
    let upper = guess.legs()?;
    guess.pelvis(&upper)?;
    guess.head(&upper);
    guess.trunk_and_arms(&upper);
    Ok(guess.landmarks(tracks.len()))
}

struct Guess {
    cloud: Cloud,
    /// The landmark name of each marker of the cloud.
    names: Vec<Option<String>>,
    /// The facing direction of the body in each frame, and its left.
    forward: Vec<DVec3>,
    left: Vec<DVec3>,
    /// The centroid of the pelvis. Before the pelvis is found, it is the centroid of both legs.
    centre: Vec<Option<DVec3>>,
}

/// The markers of a leg, and the identified ones among them.
struct Leg {
    markers: Vec<usize>,
    foot: Vec<usize>,
    knee: usize,
    ankle: usize,
    toe: usize,
    heel: usize,
}

impl Guess {
    fn name(&mut self, marker: usize, side: &str, name: &str) {
        self.names[marker] = Some(format!("{side}{name}"));
    }

    /// Sorts markers by their coordinate along an axis, largest first.
    fn sort(&self, markers: &mut [usize], axes: &[DVec3]) {
        let key = |marker: usize| self.cloud.along(marker, axes, &self.centre, &self.cloud.upright);
        markers.sort_by(|a, b| key(*b).total_cmp(&key(*a)));
    }

    /// Finds both legs and the facing direction. Returns the markers of the upper body.
    fn legs(&mut self) -> Result<Vec<usize>, &'static str> {
        let cloud = &self.cloud;
        let all: Vec<usize> = (0..cloud.count()).collect();
        let low: Vec<usize> = all
            .iter()
            .copied()
            .filter(|marker| cloud.heights[*marker] < FEET)
            .collect();
        let lowest = |marker: &&usize, other: &&usize| cloud.heights[**marker].total_cmp(&cloud.heights[**other]);
        let (Some(&one), Some(&top)) = (low.iter().min_by(lowest), all.iter().max_by(lowest)) else {
            return Err("no markers on the feet");
        };
        let links = cloud.links(one, &low);
        let other = low
            .iter()
            .copied()
            .max_by(|a, b| links[*a].total_cmp(&links[*b]))
            .unwrap_or(one);
        let (from_one, from_other) = (cloud.links(one, &low), cloud.links(other, &low));
        let (one, other): (Vec<usize>, Vec<usize>) = low
            .iter()
            .partition(|marker| from_one[**marker] <= from_other[**marker]);
        let feet = [one, other];
        let from_top = cloud.links(top, &all);
        let mut chains = [Vec::new(), Vec::new()];
        let mut upper = Vec::new();
        let from_feet = [0, 1].map(|foot: usize| feet[foot].first().map(|first| cloud.links(*first, &all)));
        for marker in all.into_iter().filter(|marker| !low.contains(marker)) {
            let to = [0, 1].map(|foot: usize| from_feet[foot].as_ref().map_or(f64::MAX, |links| links[marker]));
            let nearer = usize::from(to[1] < to[0]);
            match cloud.heights[marker] < LEGS && to[nearer] < from_top[marker] {
                true => chains[nearer].push(marker),
                false => upper.push(marker),
            }
        }
        let [one, other] = [0, 1].map(|foot: usize| self.leg(&feet[foot], &chains[foot]));
        let legs = [one?, other?];
        self.look(&legs)?;
        for (leg, side) in legs.iter().zip(self.sides(&legs)) {
            self.name_leg(leg, side);
        }
        Ok(upper)
    }

    fn leg(&self, foot: &[usize], chain: &[usize]) -> Result<Leg, &'static str> {
        let cloud = &self.cloud;
        let beside = |marker: &&usize| (cloud.heights[**marker] - KNEE).abs();
        let knees = chain.iter().filter(|marker| KNEES.contains(&cloud.heights[**marker]));
        let knee = *knees
            .min_by(|a, b| beside(a).total_cmp(&beside(b)))
            .ok_or("no marker beside a knee")?;
        let shank: Vec<usize> = (chain.iter().copied())
            .filter(|marker| cloud.heights[*marker] <= cloud.heights[knee])
            .collect();
        let to_shank = |marker: usize| {
            let spreads = shank
                .iter()
                .filter(|other| **other != marker)
                .map(|other| cloud.spread(marker, *other));
            spreads.fold(f64::MAX, f64::min)
        };
        let low = |marker: &usize| cloud.heights[*marker] < 1.5 * FEET && *marker != knee;
        let candidates = foot.iter().copied().chain(chain.iter().copied().filter(low));
        let ankle = candidates
            .min_by(|a, b| to_shank(*a).total_cmp(&to_shank(*b)))
            .ok_or("no marker beside an ankle")?;
        let rest = || foot.iter().copied().filter(move |marker| *marker != ankle);
        let far = |a: &usize, b: &usize| cloud.distance(*a, ankle).total_cmp(&cloud.distance(*b, ankle));
        let toe = rest().max_by(far).ok_or("no markers on a foot")?;
        let behind = |marker: &usize| cloud.distance(*marker, ankle) - cloud.distance(*marker, toe);
        let heel = rest()
            .filter(|marker| *marker != toe)
            .min_by(|a, b| behind(a).total_cmp(&behind(b)));
        Ok(Leg {
            markers: foot.iter().chain(chain).copied().collect(),
            foot: foot.to_vec(),
            knee,
            ankle,
            toe,
            heel: heel.unwrap_or(ankle),
        })
    }

    /// The facing direction is the direction of both feet.
    fn look(&mut self, legs: &[Leg; 2]) -> Result<(), &'static str> {
        let cloud = &self.cloud;
        let mut last = DVec3::ZERO;
        for places in &cloud.frames {
            let points = |leg: &Leg| {
                let along = places[leg.toe]? - places[leg.heel]?;
                Some(along.reject_from(cloud.up).normalize_or_zero())
            };
            let sum: DVec3 = legs.iter().filter_map(points).sum();
            last = sum.try_normalize().unwrap_or(last);
            self.forward.push(last);
            self.left.push(cloud.up.cross(last));
        }
        let both: Vec<usize> = legs.iter().flat_map(|leg| &leg.markers).copied().collect();
        self.centre = (0..cloud.frames.len())
            .map(|frame| cloud.middle(&both, frame))
            .collect();
        let is_known = self.forward.iter().any(|forward| *forward != DVec3::ZERO);
        is_known
            .then_some(())
            .ok_or("the feet do not show the facing direction")
    }

    /// The sides of the two legs.
    fn sides(&self, legs: &[Leg; 2]) -> [&'static str; 2] {
        let mean = |leg: &Leg| {
            let places = leg.markers.iter().map(|marker| self.side(*marker));
            places.sum::<f64>() / leg.markers.len() as f64
        };
        if mean(&legs[0]) > mean(&legs[1]) {
            ["L", "R"]
        } else {
            ["R", "L"]
        }
    }

    /// The distance of a marker from the body's midline, positive on the left.
    fn side(&self, marker: usize) -> f64 {
        self.cloud.along(marker, &self.left, &self.centre, &self.cloud.upright)
    }

    fn name_leg(&mut self, leg: &Leg, side: &str) {
        for &marker in &leg.markers {
            let is_above = self.cloud.heights[marker] > self.cloud.heights[leg.knee];
            let name = match (leg.foot.contains(&marker), is_above) {
                (true, _) => "MT5",
                (_, true) => "THI",
                _ => "TIB",
            };
            self.name(marker, side, name);
        }
        self.name(leg.heel, side, "HEE");
        self.name(leg.toe, side, "TOE");
        self.name(leg.ankle, side, "ANK");
        self.name(leg.knee, side, "KNE");
    }

    /// Finds four rigid markers, or three, around the body's midline.
    fn pelvis(&mut self, upper: &[usize]) -> Result<(), &'static str> {
        /// The number of candidates to try, nearest to the midline first.
        const TRIED: usize = 20;
        let cloud = &self.cloud;
        let sides: Vec<f64> = (0..cloud.count()).map(|marker| self.side(marker)).collect();
        let mut near: Vec<usize> = (upper.iter().copied())
            .filter(|marker| PELVIS.contains(&cloud.heights[*marker]))
            .collect();
        near.sort_by(|a, b| sides[*a].abs().total_cmp(&sides[*b].abs()));
        near.truncate(TRIED);
        let cost = |markers: &[usize]| {
            let pairs = markers
                .iter()
                .flat_map(|a| markers.iter().map(move |b| cloud.spread(*a, *b)));
            let loosest = pairs.fold(0.0, f64::max);
            let mean = markers.iter().map(|marker| sides[*marker]).sum::<f64>() / markers.len() as f64;
            let is_on = |sign: f64| markers.iter().any(|marker| sign * sides[*marker] > 0.02);
            let cost = loosest + (mean.abs() - 0.02).max(0.0);
            (is_on(1.0) && is_on(-1.0) && cost < RIGID).then_some(cost)
        };
        let best = [4, 3].into_iter().find_map(|size| best_of(&near, size, &cost));
        let mut found = best.ok_or("fewer than three markers of the pelvis keep their distances to each other")?;
        self.centre = (0..cloud.frames.len())
            .map(|frame| self.cloud.middle(&found, frame))
            .collect();
        let (forward, left) = (self.forward.clone(), self.left.clone());
        self.sort(&mut found, &forward);
        let (front, back) = found.split_at_mut(2);
        self.sort(front, &left);
        self.sort(back, &left);
        let names = if back.len() == 2 {
            &["LASI", "RASI", "LPSI", "RPSI"][..]
        } else {
            &["LASI", "RASI", "SACR"]
        };
        for (marker, name) in found.into_iter().zip(names) {
            self.name(marker, "", name);
        }
        Ok(())
    }

    fn head(&mut self, upper: &[usize]) {
        let cloud = &self.cloud;
        let Some(top) = upper
            .iter()
            .copied()
            .max_by(|a, b| cloud.heights[*a].total_cmp(&cloud.heights[*b]))
        else {
            return;
        };
        let is_head = |marker: &usize| cloud.heights[*marker] > HEAD && cloud.spread(*marker, top) < RIGID_HEAD;
        let mut head: Vec<usize> = upper.iter().copied().filter(is_head).collect();
        let (forward, left) = (self.forward.clone(), self.left.clone());
        self.sort(&mut head, &forward);
        if head.len() < 4 {
            let names = ["HEAD", "HEDF", "HEDS"];
            head.into_iter()
                .zip(names)
                .for_each(|(marker, name)| self.name(marker, "", name));
            return;
        }
        let (front, rest) = head.split_at_mut(2);
        let back = rest.len() - 2;
        let back = &mut rest[back..];
        self.sort(front, &left);
        self.sort(back, &left);
        let found = [front[0], front[1], back[0], back[1]];
        for (marker, name) in found.into_iter().zip(["LFHD", "RFHD", "LBHD", "RBHD"]) {
            self.name(marker, "", name);
        }
    }

    fn trunk_and_arms(&mut self, upper: &[usize]) {
        let rest: Vec<usize> = upper
            .iter()
            .copied()
            .filter(|marker| self.names[*marker].is_none())
            .collect();
        let sides: Vec<f64> = (0..self.cloud.count()).map(|marker| self.side(marker)).collect();
        let shoulder = |sign: f64| {
            let heights = &self.cloud.heights;
            let beside = |marker: &usize| heights[*marker] > SHOULDERS && BESIDE.contains(&(sign * sides[*marker]));
            let found = rest.iter().copied().filter(beside);
            found.max_by(|a, b| heights[*a].total_cmp(&heights[*b]))
        };
        let (Some(left), Some(right)) = (shoulder(1.0), shoulder(-1.0)) else {
            return;
        };
        let shoulders = [left, right];
        self.name(left, "L", "SHO");
        self.name(right, "R", "SHO");
        let middle = self.trunk(&rest, shoulders, &sides);
        let narrow = 0.75 * sides[left].abs().min(sides[right].abs());
        let is_trunk = |guess: &Self, marker: usize| {
            let rigid = shoulders
                .iter()
                .chain(&middle)
                .filter(|other| guess.cloud.spread(marker, **other) < RIGID_TRUNK);
            rigid.count() >= 4 && sides[marker].abs() < narrow
        };
        let mut free = Vec::new();
        for marker in rest.into_iter().filter(|marker| !shoulders.contains(marker)) {
            if self.names[marker].is_some() {
                continue;
            }
            match middle.contains(&marker) || is_trunk(&*self, marker) {
                true => self.name(marker, if sides[marker] > 0.0 { "L" } else { "R" }, "BAC"),
                false => free.push(marker),
            }
        }
        let of_shoulder = shoulders.map(|shoulder| {
            let allowed: Vec<usize> = free.iter().copied().chain([shoulder]).collect();
            self.cloud.links(shoulder, &allowed)
        });
        for (side, name) in [(0, "L"), (1, "R")] {
            let is_own = |marker: &usize| of_shoulder[side][*marker] <= of_shoulder[1 - side][*marker];
            let arm: Vec<usize> = free.iter().copied().filter(is_own).collect();
            self.arm(&arm, shoulders[side], name);
        }
    }

    /// Names chest and back, and returns the central markers of the trunk.
    fn trunk(&mut self, rest: &[usize], shoulders: [usize; 2], sides: &[f64]) -> Vec<usize> {
        let cloud = &self.cloud;
        let is_middle = |marker: &usize| {
            let loose = shoulders
                .iter()
                .map(|shoulder| cloud.spread(*marker, *shoulder))
                .fold(0.0, f64::max);
            cloud.heights[*marker] > CHEST && sides[*marker].abs() < MIDDLE && loose < RIGID
        };
        let middle: Vec<usize> = rest
            .iter()
            .copied()
            .filter(is_middle)
            .filter(|marker| !shoulders.contains(marker))
            .collect();
        let front = |marker: usize| cloud.along(marker, &self.forward, &self.centre, &cloud.upright);
        let mean = middle.iter().map(|marker| front(*marker)).sum::<f64>() / middle.len().max(1) as f64;
        let (mut chest, mut back): (Vec<usize>, Vec<usize>) = middle.iter().partition(|marker| front(**marker) > mean);
        for markers in [&mut chest, &mut back] {
            markers.sort_by(|a, b| cloud.heights[*b].total_cmp(&cloud.heights[*a]));
        }
        for (markers, [high, low]) in [(chest, ["CLAV", "STRN"]), (back, ["C7", "T10"])] {
            if let [first, .., last] = *markers.as_slice() {
                self.name(last, "", low);
                self.name(first, "", high);
            } else if let [only] = *markers.as_slice() {
                self.name(only, "", high);
            }
        }
        middle
    }

    fn arm(&mut self, markers: &[usize], shoulder: usize, side: &str) {
        let cloud = &self.cloud;
        let mut far = markers.to_vec();
        far.sort_by(|a, b| cloud.distance(*b, shoulder).total_cmp(&cloud.distance(*a, shoulder)));
        far.truncate(2);
        let to_hand = |marker: usize| {
            let others = far.iter().filter(|other| **other != marker);
            let count = others.clone().count().max(1) as f64;
            others.map(|other| cloud.spread(marker, *other)).sum::<f64>() / count
        };
        let both = |marker: &usize| cloud.spread(*marker, shoulder) + to_hand(*marker);
        let candidates = markers.iter().copied().filter(|marker| !far.contains(marker));
        let Some(elbow) = candidates.min_by(|a, b| both(a).total_cmp(&both(b))) else {
            return;
        };
        let is_below = |marker: &usize| to_hand(*marker) < cloud.spread(*marker, shoulder);
        let rest = markers.iter().copied().filter(|marker| *marker != elbow);
        let (mut below, above): (Vec<usize>, Vec<usize>) = rest.partition(is_below);
        below.sort_by(|a, b| cloud.distance(*b, elbow).total_cmp(&cloud.distance(*a, elbow)));
        let finger = if below.len() >= 4 { Some(below.remove(0)) } else { None };
        let forearm = below.split_off(below.len().min(2));
        self.sort_wrist(&mut below);
        for (found, name) in [
            (forearm, "FRM"),
            (above, "UPA"),
            (vec![elbow], "ELB"),
            (finger.into_iter().collect(), "FIN"),
        ] {
            found.into_iter().for_each(|marker| self.name(marker, side, name));
        }
        for (marker, name) in below.into_iter().zip(["WRA", "WRB"]) {
            self.name(marker, side, name);
        }
    }

    /// Sorts the two markers of a wrist: the marker on the side of the thumb first. The thumb of a hanging hand is in
    /// front.
    fn sort_wrist(&self, wrist: &mut [usize]) {
        /// The fraction of frames in which the hand counts as hanging: the frames with the lowest hand.
        const HANGS: f64 = 0.3;
        let cloud = &self.cloud;
        let height = |frame: usize| cloud.middle(wrist, frame).map(|middle| middle.dot(cloud.up));
        let limit = percentile((0..cloud.frames.len()).filter_map(height), HANGS, f64::round).unwrap_or(f64::NAN);
        let frames: Vec<usize> = (0..cloud.frames.len())
            .filter(|frame| height(*frame).is_some_and(|own| own <= limit))
            .collect();
        let front = |marker: usize| cloud.along(marker, &self.forward, &self.centre, &frames);
        wrist.sort_by(|a, b| front(*b).total_cmp(&front(*a)));
    }

    /// The landmarks of all markers of the file. The second occurrence of a name gets a number.
    fn landmarks(self, count: usize) -> Vec<Option<Landmark>> {
        let mut found = vec![None; count];
        let mut taken = std::collections::HashMap::<String, usize>::new();
        for (name, marker) in self.names.into_iter().zip(self.cloud.markers) {
            let Some(mut landmark) = name.and_then(|name| named(&name)) else {
                continue;
            };
            let times = taken.entry(landmark.name.clone()).or_default();
            *times += 1;
            if *times > 1 {
                landmark.name = format!("{} {times}", landmark.name);
            }
            found[marker] = Some(landmark);
        }
        found
    }
}

/// The combination of `size` markers with the least cost.
fn best_of(markers: &[usize], size: usize, cost: &impl Fn(&[usize]) -> Option<f64>) -> Option<Vec<usize>> {
    fn choose(markers: &[usize], size: usize, chosen: &mut Vec<usize>, visit: &mut impl FnMut(&[usize])) {
        if size == 0 {
            return visit(chosen);
        }
        for (place, &marker) in markers.iter().enumerate() {
            chosen.push(marker);
            choose(&markers[place + 1..], size - 1, chosen, visit);
            chosen.pop();
        }
    }
    let mut best: Option<(f64, Vec<usize>)> = None;
    choose(markers, size, &mut Vec::new(), &mut |chosen| {
        if let Some(cost) = cost(chosen)
            && best.as_ref().is_none_or(|(least, _)| cost < *least)
        {
            best = Some((cost, chosen.to_vec()));
        }
    });
    best.map(|(_, chosen)| chosen)
}
