//! Finds near-duplicates: clips with the same bytes or the same motion. The motion may be mirrored, retimed by up to 10
//! %, at another rate, on another skeleton, or a piece of at least two seconds. Shorter clips are compared as a whole.
//!
//! Each clip has samples of the directions of ten limbs ([`super::fingerprint`]). [`index`] finds pairs of clips that
//! may repeat each other. [`alignment`] finds the offset, the pace and the reflection with the least distance of limbs.
//! A group has a representative, and shorter clips that are each near to the representative. A clip near to another
//! member, but not to the representative, does not join. So small differences never add up from clip to clip.

mod alignment;
mod index;
mod limbs;

use std::collections::{HashMap, HashSet};

use mocap_scene::math::spread::spread;

pub(super) use self::alignment::SHORTEST_CLIP;
use self::alignment::{Alignment, Moments, Track};
use self::index::{Index, MOST_ALIGNED};
pub(crate) use self::limbs::mirrored_row;
use super::fingerprint::{Fingerprint, RATE};

/// The ways in which a clip can repeat another clip, the strongest reason first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reason {
    Bytes,
    Motion,
    Rate,
    Skeleton,
    Retimed,
    Mirrored,
    Piece,
}

impl Reason {
    pub(super) const fn as_str(self) -> &'static str {
        match self {
            Self::Bytes => "bytes",
            Self::Motion => "motion",
            Self::Rate => "rate",
            Self::Skeleton => "skeleton",
            Self::Retimed => "retimed",
            Self::Mirrored => "mirrored",
            Self::Piece => "piece",
        }
    }
}

/// The data of a clip that is compared.
pub(super) struct Candidate<'a> {
    pub(super) fingerprint: &'a Fingerprint,
    pub(super) sha256: &'a str,
    pub(super) clip: &'a str,
    pub(super) skeleton: &'a str,
    pub(super) joints: u64,
    pub(super) rate: f64,
    pub(super) frames: u64,
    pub(super) seconds: f64,
    pub(super) size: f64,
}

impl Candidate<'_> {
    /// The sort order: the longest clip first, in steps of 5 %, then the clip with more frames. The first clip of a
    /// group represents the group.
    fn rank(&self) -> impl Ord + use<> {
        let length = (self.seconds.max(f64::MIN_POSITIVE).ln() / 1.05_f64.ln()).round() as i64;
        std::cmp::Reverse((length, self.frames))
    }
}

/// A clip that repeats the representative of its group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Member {
    pub(super) representative: usize,
    pub(super) reason: Reason,
}

/// A clip that repeats an earlier clip, with their fit.
#[derive(Clone, Copy)]
struct Pair {
    first: usize,
    fit: Fit,
}

/// How a clip fits another clip: matching moments, pace and reflection.
#[derive(Clone, Copy)]
struct Fit {
    at: Moments,
    pace: f32,
    mirrored: bool,
    reason: Reason,
}

/// For each clip, the clip that it repeats; `None` for a clip that is kept.
pub(super) fn members(clips: &[Candidate<'_>]) -> Vec<Option<Member>> {
    let mut order: Vec<usize> = (0..clips.len()).collect();
    order.sort_by_key(|index| (clips[*index].rank(), *index));
    let ranked: Vec<&Candidate<'_>> = order.iter().map(|index| &clips[*index]).collect();
    let mut members = vec![None; clips.len()];
    for (index, member) in std::iter::zip(&order, ranked_members(&ranked)) {
        members[*index] = member.map(|member| Member {
            representative: order[member.representative],
            ..member
        });
    }
    members
}

/// The result of [`members`], for clips that are sorted by rank.
fn ranked_members(clips: &[&Candidate<'_>]) -> Vec<Option<Member>> {
    // Copies of a file have equal bytes. Compare only one of them.
    let mut by_bytes: HashMap<(&str, &str), usize> = HashMap::new();
    let mut copy_of = vec![None; clips.len()];
    for (index, clip) in clips.iter().enumerate().filter(|(_, clip)| !clip.sha256.is_empty()) {
        let first = *by_bytes.entry((clip.sha256, clip.clip)).or_insert(index);
        copy_of[index] = Some(first).filter(|first| *first != index);
    }
    let distinct: Vec<usize> = (0..clips.len()).filter(|index| copy_of[*index].is_none()).collect();
    let mut pairs: Vec<Vec<Pair>> = vec![Vec::new(); clips.len()];
    for (index, found) in std::iter::zip(&distinct, all_pairs(clips, &distinct)) {
        pairs[*index] = found;
    }
    let mut members: Vec<Option<(Member, Fit)>> = vec![None; clips.len()];
    let mut copies = vec![None; clips.len()];
    for index in 0..clips.len() {
        match copy_of[index] {
            Some(first) => {
                let of_first: Option<(Member, Fit)> = members[first];
                copies[index] = Some(of_first.map_or(
                    Member {
                        representative: first,
                        reason: Reason::Bytes,
                    },
                    |(member, _)| member,
                ));
            }
            None => members[index] = member(clips, &members, &pairs[index], index),
        }
    }
    let own = members.into_iter().map(|member| member.map(|(member, _)| member));
    std::iter::zip(own, copies).map(|(own, copy)| own.or(copy)).collect()
}

/// The representative of a clip's group. Candidates are representatives that the clip was compared with, and
/// representatives of its near-duplicates. The clip must be near to the representative itself.
fn member(
    clips: &[&Candidate<'_>],
    members: &[Option<(Member, Fit)>],
    pairs: &[Pair],
    index: usize,
) -> Option<(Member, Fit)> {
    let of = |representative: usize, fit: Fit| {
        let reason = fit.reason;
        (Member { representative, reason }, fit)
    };
    let direct = pairs.iter().filter(|pair| members[pair.first].is_none());
    if let Some(best) = direct.min_by_key(|pair| (pair.fit.reason, pair.first)) {
        return Some(of(best.first, best.fit));
    }
    let mut tried = HashSet::new();
    pairs.iter().take(MOST_ALIGNED).find_map(|pair| {
        let (Member { representative, .. }, before) = members[pair.first]?;
        if !tried.insert((representative, before.mirrored != pair.fit.mirrored)) {
            return None;
        }
        let guess = Fit {
            at: before.at.through(before.pace, pair.fit.at),
            pace: before.pace * pair.fit.pace,
            mirrored: before.mirrored != pair.fit.mirrored,
            reason: pair.fit.reason,
        };
        let tracks = [
            Track::new(clips[representative].fingerprint, false),
            Track::new(clips[index].fingerprint, guess.mirrored),
        ];
        let found = compare([clips[representative], clips[index]], [&tracks[0], &tracks[1]], guess)?;
        Some(of(representative, found))
    })
}

/// For each clip, the earlier clips that it repeats.
fn all_pairs(clips: &[&Candidate<'_>], distinct: &[usize]) -> Vec<Vec<Pair>> {
    let index = Index::new(clips, distinct);
    spread(distinct, |&second| {
        let found = index.candidates(clips, second);
        let track = |mirrored: bool| {
            let wanted = found.iter().any(|candidate| candidate.mirrored == mirrored);
            wanted.then(|| Track::new(clips[second].fingerprint, mirrored))
        };
        let tracks = [track(false), track(true)];
        let pairs = found.iter().filter_map(|candidate| {
            let first = candidate.clip;
            let a = Track::new(clips[first].fingerprint, false);
            let b = tracks[usize::from(candidate.mirrored)].as_ref()?;
            let guess = Fit {
                at: candidate.at,
                pace: 1.0,
                mirrored: candidate.mirrored,
                reason: Reason::Motion,
            };
            let fit = compare([clips[first], clips[second]], [&a, b], guess)?;
            Some(Pair { first, fit })
        });
        pairs.collect()
    })
}

/// How a clip repeats another clip; `None` if it does not. `guess` has a moment that both clips may share, and an
/// approximate pace.
fn compare(clips: [&Candidate<'_>; 2], tracks: [&Track; 2], guess: Fit) -> Option<Fit> {
    let [first, second] = clips;
    let [a, b] = tracks;
    let same_skeleton = first.skeleton == second.skeleton;
    // Figures without a body are compared joint by joint, and have no left and right.
    let is_body = first.fingerprint.is_body;
    let same_joints = first.joints == second.joints;
    if is_body != second.fingerprint.is_body || !is_body && (guess.mirrored || !same_joints) {
        return None;
    }
    let found = Alignment::best(a, b, guess.at, guess.pace)?;
    let longer = a.samples().max(b.samples()) as f32;
    // The pace stretches the samples of the second clip.
    let shorter_by_pace = (b.samples() as f32 * found.pace).min(a.samples() as f32);
    let whole = found.overlap + 4.0 >= longer.min(a.samples() as f32).max(b.samples() as f32 * found.pace)
        || found.overlap + 4.0 >= 0.97 * longer && shorter_by_pace + 4.0 >= 0.97 * longer;
    let same_rate = (first.rate - second.rate).abs() < 0.01 * first.rate;
    let same_size = (first.size - second.size).abs() < 0.01 * first.size;
    let reason = match () {
        () if !whole => Reason::Piece,
        () if guess.mirrored => Reason::Mirrored,
        () if (found.pace - 1.0).abs() > 0.015 => Reason::Retimed,
        () if !same_skeleton || !same_size => Reason::Skeleton,
        () if !same_rate => Reason::Rate,
        () => Reason::Motion,
    };
    Some(Fit {
        at: found.at,
        pace: found.pace,
        mirrored: guess.mirrored,
        reason,
    })
}

/// Whether two clips are copies of one take, around one moment of each clip. The moments are samples that may match.
pub(crate) fn are_of_one_take(clips: [&Fingerprint; 2], [first, second]: [f32; 2], mirrored: bool) -> bool {
    let [a, b] = [Track::new(clips[0], false), Track::new(clips[1], mirrored)];
    Alignment::best(&a, &b, Moments { first, second }, 1.0).is_some()
}

/// The lengths in samples in these modules assume 10 samples per second.
const _: () = assert!(RATE == 10.0, "lengths in samples are those of ten samples a second");
