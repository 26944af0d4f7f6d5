//! Chooses a diverse subset of clips by farthest-point sampling (Gonzalez, 1985) of the descriptors.

use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use mocap_scene::math::spread::spread;

/// How many clips to choose: `100`, or `3%`.
///
/// ```
/// use mocap::survey::SelectAmount;
///
/// let amount: SelectAmount = "3%".parse().unwrap();
/// assert_eq!(amount.of(201), 7);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SelectAmount {
    /// This number of clips.
    Clips(usize),
    /// This fraction of all clips, from 0 to 1.
    Fraction(f64),
}

impl SelectAmount {
    /// The number of clips to choose from `clips`. A fraction gives at least one.
    pub fn of(self, clips: usize) -> usize {
        match self {
            Self::Clips(count) => count,
            Self::Fraction(fraction) => (fraction * clips as f64).ceil() as usize,
        }
    }
}

impl FromStr for SelectAmount {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let percent = |text: &str| text.parse().ok().filter(|percent| *percent > 0.0 && *percent <= 100.0);
        let parsed = match text.strip_suffix('%') {
            Some(number) => percent(number).map(|percent: f64| Self::Fraction(percent / 100.0)),
            None => text.parse().ok().filter(|count| *count > 0).map(Self::Clips),
        };
        parsed.ok_or_else(|| format!("\"{text}\" is not a number of clips or a percentage above 0, such as 100 or 3%"))
    }
}

/// Serializes the text that a user types.
impl Serialize for SelectAmount {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Clips(count) => serializer.collect_str(count),
            Self::Fraction(fraction) => serializer.collect_str(&format_args!("{}%", 100.0 * fraction)),
        }
    }
}

impl<'de> Deserialize<'de> for SelectAmount {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "a number of clips, or a string such as \"3%\"")]
        enum Stated {
            Count(usize),
            Text(String),
        }

        let text = match Stated::deserialize(deserializer)? {
            Stated::Count(count) => count.to_string(),
            Stated::Text(text) => text,
        };
        text.parse().map_err(serde::de::Error::custom)
    }
}

/// How clips are selected, or which clips a split keeps together.
///
/// The [module](crate::survey) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum SelectBy {
    /// Select no bad clips, and no near-duplicates
    Quality,
    /// Select clips that are far apart
    Diversity,
    /// Keep the clips of a person in one part
    Person,
    /// Keep the clips of a skeleton in one part
    Skeleton,
    /// Keep near-duplicates in one part
    NearDuplicate,
}

/// The largest number of distances to compute when trying several first clips.
const MOST_DISTANCES: usize = 20_000_000;

/// Chooses `count` of the points at `allowed`. Each next point is the point farthest from all chosen points. The first
/// point is the point nearest to the mean. If [`MOST_DISTANCES`] allows, several first points are tried: the best one
/// minimizes the largest distance of any point to the nearest chosen point. With any first point, this distance is at
/// most twice the least possible distance.
pub(super) fn farthest_points(points: &[Option<Vec<f32>>], allowed: &[usize], count: usize) -> Vec<usize> {
    let is_there = |index: &&usize| points[**index].is_some();
    let mut all: Vec<usize> = allowed.iter().filter(is_there).copied().collect();
    // The mean of the descriptors is 0.
    let from_mean = |index: &usize| -> f32 { points[*index].iter().flatten().map(|value| value * value).sum() };
    all.sort_by(|a, b| from_mean(a).total_cmp(&from_mean(b)).then(a.cmp(b)));
    let distances = all.len().saturating_mul(count).max(1);
    let tries = (MOST_DISTANCES / distances).clamp(1, all.len().max(1));
    // Candidates for the first point, from the nearest to the mean to the farthest.
    let firsts: Vec<usize> = (0..tries).map(|number| number * all.len() / tries).collect();
    let chosen = spread(&firsts, |first| from_first(points, &all, *first, count));
    let best = chosen.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(chosen, _)| chosen).unwrap_or_default()
}

/// The chosen points for a given first point, and the largest squared distance of any point to the nearest chosen
/// point.
fn from_first(points: &[Option<Vec<f32>>], all: &[usize], first: usize, count: usize) -> (Vec<usize>, f32) {
    let point = |index: usize| points[index].as_deref().unwrap_or(&[]);
    let mut left: Vec<(usize, f32)> = all.iter().map(|index| (*index, f32::INFINITY)).collect();
    let mut chosen = Vec::new();
    let mut next = all.get(first).copied();
    while let Some(new) = next.filter(|_| chosen.len() < count) {
        chosen.push(new);
        left.retain(|(index, _)| *index != new);
        for (index, nearest) in &mut left {
            *nearest = nearest.min(squared_distance(point(*index), point(new)));
        }
        let farthest = left.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        next = farthest.map(|(index, _)| *index);
    }
    let largest = left.iter().map(|(_, nearest)| *nearest).fold(0.0, f32::max);
    (chosen, largest)
}

fn squared_distance(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}
