//! All rows of a corpus, and the columns that compare clips with each other.

use std::collections::{BTreeMap, BTreeSet};

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::report::counted;
use mocap_scene::visible_json;
use serde::{Deserialize, Serialize};

use super::fingerprint::{Fingerprint, RATE};
use super::row::{ClipRow, Defect, Quality};
use super::thresholds::{DefectKind, Thresholds};
use super::twins::{self, Candidate, SHORTEST_CLIP};
use super::{descriptor, select};

/// The row of one clip, and the data that is compared with other clips. Its JSON is one line of a record, a text file
/// with a line for each clip. A survey resumes from a record, and the records of shards can be merged.
///
/// The [module](crate::survey) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ClipRecord {
    /// The row.
    #[serde(flatten)]
    pub row: ClipRow,
    pub(super) fingerprint: Fingerprint,
    /// The number of clips in the file. A record may contain fewer of them.
    #[serde(default)]
    pub(super) clips: usize,
}

impl From<ClipRow> for ClipRecord {
    fn from(row: ClipRow) -> Self {
        Self {
            row,
            fingerprint: Fingerprint::default(),
            clips: 1,
        }
    }
}

/// The fewest joints of a skeleton whose sizes in different clips are compared. Two skeletons with fewer joints may be
/// alike by chance.
const LEAST_JOINTS: u64 = 5;

/// All clips of a corpus.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::survey::{Corpus, Thresholds};
///
/// let scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let mut clips = Thresholds::default().examine(&scene, "a.bvh");
/// clips.extend(Thresholds::default().examine(&scene, "b.bvh"));
/// let corpus = Corpus::new(clips, &Thresholds::default());
/// let csv = corpus.to_csv();
/// assert!(csv.starts_with("file,clip,error,verdict,") && csv.lines().count() == 3);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Corpus {
    clips: Vec<ClipRecord>,
}

impl Corpus {
    /// Makes a corpus of clips, in the order of their files, and compares the clips with each other.
    pub fn new(mut clips: Vec<ClipRecord>, thresholds: &Thresholds) -> Self {
        clips.sort_by(|a, b| (&a.row.file, &a.row.clip).cmp(&(&b.row.file, &b.row.clip)));
        let mut corpus = Self { clips };
        corpus.compare_skeletons(thresholds);
        corpus.find_twins();
        corpus.make_map();
        for clip in &mut corpus.clips {
            if clip.row.error.is_none() {
                clip.row.judge(thresholds);
            }
            clip.row.round();
        }
        corpus
    }

    /// The rows, in the order of their files.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &ClipRow> {
        self.clips.iter().map(|clip| &clip.row)
    }

    pub(super) fn rows_mut(&mut self) -> impl Iterator<Item = &mut ClipRow> {
        self.clips.iter_mut().map(|clip| &mut clip.row)
    }

    pub(super) fn clips(&self) -> &[ClipRecord] {
        &self.clips
    }

    /// Keeps the clips for whose row `is_kept` is true.
    pub fn keep(&mut self, is_kept: impl Fn(&ClipRow) -> bool) {
        self.clips.retain(|clip| is_kept(&clip.row));
    }

    /// Finds clips whose size or up axis differs from other clips with the same skeleton.
    fn compare_skeletons(&mut self, thresholds: &Thresholds) {
        let mut groups: BTreeMap<(&str, &str), Vec<usize>> = BTreeMap::new();
        for (index, clip) in self.clips.iter().enumerate().filter(|(_, clip)| clip.row.frames > 0) {
            let key = (&*clip.row.skeleton, &*clip.row.format);
            groups.entry(key).or_default().push(index);
        }
        let groups: Vec<Vec<usize>> = groups.into_values().collect();
        for group in groups {
            // Compare sizes in units of the file. Sizes in metres would hide a wrong unit, because the reader infers a
            // unit that gives bodies a human size.
            let units = |row: &ClipRow| row.size.zip(row.metres_per_unit).map(|(size, metres)| size / metres);
            let mut sizes: Vec<f64> = group
                .iter()
                .filter_map(|index| units(&self.clips[*index].row))
                .collect();
            sizes.sort_unstable_by(f64::total_cmp);
            let usual = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
            let up = self.usual_up(&group);
            for index in group {
                let row = &mut self.clips[index].row;
                let times = units(row)
                    .filter(|size| *size > 0.0 && usual > 0.0)
                    .map_or(1.0, |size| size / usual);
                let times = times.max(1.0 / times);
                // If only two sizes differ, neither of them is known to be right.
                let times = if sizes.len() > 2 && row.joints >= LEAST_JOINTS {
                    times
                } else {
                    1.0
                };
                let degrees = if up.as_ref().is_some_and(|up| *up != row.up) {
                    90.0
                } else {
                    0.0
                };
                row.set_corpus_amount(DefectKind::OddUnit, times, times > 1.001, thresholds);
                row.set_corpus_amount(DefectKind::OddAxis, degrees, degrees > 0.0, thresholds);
            }
        }
    }

    /// Groups near-duplicates. The longest clip of each group is kept. Among equally long clips, the first is kept.
    fn find_twins(&mut self) {
        let candidates: Vec<Candidate<'_>> = self.clips.iter().map(ClipRecord::candidate).collect();
        let members = twins::members(&candidates);
        let mut numbers: BTreeMap<usize, u64> = BTreeMap::new();
        for member in members.iter().flatten() {
            let next = numbers.len() as u64 + 1;
            numbers.entry(member.representative).or_insert(next);
        }
        let files: BTreeMap<usize, String> = numbers
            .keys()
            .map(|kept| (*kept, self.clips[*kept].row.file.clone()))
            .collect();
        for (index, (clip, member)) in std::iter::zip(&mut self.clips, members).enumerate() {
            let kept = member.map_or(index, |member| member.representative);
            clip.row.twin = member.is_some();
            clip.row.twin_group = numbers.get(&kept).copied();
            clip.row.twin_of = member.and_then(|member| files.get(&member.representative).cloned());
            clip.row.twin_reason = member.map(|member| member.reason.as_str().to_owned());
        }
    }

    /// Computes the position of each clip on the map.
    fn make_map(&mut self) {
        let descriptors = descriptor::descriptors(self.clips.iter().map(|clip| &clip.fingerprint));
        for (clip, point) in self.clips.iter_mut().zip(descriptor::map(&descriptors)) {
            clip.row.map_x = point.map(|[x, _]| x);
            clip.row.map_y = point.map(|[_, y]| y);
        }
    }

    /// The descriptors of all clips, in the order of the clips. The map and the selection compare these descriptors.
    /// Over the corpus, each number of a descriptor has mean 0 and standard deviation 1. A clip without motion has
    /// `None`.
    pub fn descriptors(&self) -> Vec<Option<Vec<f32>>> {
        descriptor::descriptors(self.clips.iter().map(|clip| &clip.fingerprint))
    }

    /// Keeps `count` clips that are as different as possible, by farthest-point sampling of the
    /// [descriptors](Self::descriptors). The sampling begins with the clip nearest to the mean. With `by_quality`, the
    /// selection skips bad clips and near-duplicates. It never chooses a pose file, which has no motion.
    pub fn select(&mut self, count: usize, by_quality: bool) {
        let descriptors = self.descriptors();
        let is_good = |index: &usize| {
            let row = &self.clips[*index].row;
            row.verdict < Quality::Bad && !row.twin
        };
        let moves = |index: &usize| !self.clips[*index].row.has_property(DefectKind::PoseFile);
        let all: Vec<usize> = (0..self.clips.len()).filter(moves).collect();
        let good: Vec<usize> = all.iter().copied().filter(is_good).collect();
        let allowed = if by_quality { good } else { all };
        let chosen: BTreeSet<usize> = select::farthest_points(&descriptors, &allowed, count)
            .into_iter()
            .collect();
        let mut index = 0;
        self.clips.retain(|_| {
            index += 1;
            chosen.contains(&(index - 1))
        });
    }

    /// A note on the clips that are compared only by their bytes, because they are too short. Pose files do not count.
    #[doc(hidden)]
    pub fn too_short_note(&self) -> Option<String> {
        let is_short = |clip: &&ClipRecord| {
            (1..SHORTEST_CLIP).contains(&clip.fingerprint.samples()) && !clip.row.has_property(DefectKind::PoseFile)
        };
        let count = self.clips.iter().filter(is_short).count();
        let seconds = (SHORTEST_CLIP as f64 - 1.0) / RATE;
        (count > 0).then(|| {
            format!(
                "{} not longer than {seconds} s: such short clips count as near-duplicates only if their files are \
                 identical",
                counted(count, "clip")
            )
        })
    }

    /// The up axis that more than half of the clips have, if there are at least three clips.
    fn usual_up(&self, group: &[usize]) -> Option<String> {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for index in group {
            *counts.entry(&self.clips[*index].row.up).or_default() += 1;
        }
        let (up, count) = counts.into_iter().max_by_key(|(_, count)| *count)?;
        (group.len() > 2 && 2 * count > group.len()).then(|| up.to_owned())
    }
}

impl ClipRow {
    fn has_property(&self, kind: DefectKind) -> bool {
        self.properties.split(' ').any(|name| name == kind.as_str())
    }

    fn set_corpus_amount(&mut self, kind: DefectKind, amount: f64, is_odd: bool, thresholds: &Thresholds) {
        self.defects.retain(|defect| defect.kind != kind);
        let amount = if is_odd { amount } else { 0.0 };
        self.amounts.insert(kind, amount);
        if is_odd && amount >= thresholds.of(kind)[0] {
            self.defects.push(Defect {
                kind,
                frames: [0, self.frames.saturating_sub(1) as usize],
                joint: None,
                amount,
                confidence: 0.8,
            });
        }
    }
}

impl ClipRecord {
    fn candidate(&self) -> Candidate<'_> {
        let row = &self.row;
        Candidate {
            fingerprint: &self.fingerprint,
            sha256: &row.sha256,
            clip: &row.clip,
            skeleton: &row.skeleton,
            joints: row.joints,
            rate: row.rate.unwrap_or(0.0),
            frames: row.frames,
            seconds: row.seconds,
            size: row.size.unwrap_or(0.0),
        }
    }

    /// Whether `clips` are all clips of their file.
    #[doc(hidden)]
    pub fn are_all(clips: &[Self]) -> bool {
        clips.iter().all(|clip| clip.clips == clips.len())
    }

    /// The line of a record, without the line break.
    pub fn to_line(&self) -> String {
        let text = serde_json::to_string(self).expect("rows have string keys and finite numbers");
        visible_json(&text).into_owned()
    }

    /// Reads a record: lines that [`to_line`](Self::to_line) or [`Corpus::to_record`] wrote.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] with the number of the line.
    pub fn from_lines(text: &str) -> Result<Vec<Self>> {
        let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let read = |(number, line): (usize, &str)| {
            serde_json::from_str(line).map_err(|error| {
                let message = format!("line {} is not a row of a survey: {error}", number + 1);
                Diagnostic::new(Code::InvalidValue, message).into()
            })
        };
        lines.map(read).collect()
    }
}
