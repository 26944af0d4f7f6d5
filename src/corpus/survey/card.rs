//! The card of a corpus: one offline page with counts, histograms, the worst and usual clips as moving figures, twins
//! side by side, a map, and a list to search.

use std::collections::{BTreeMap, BTreeSet};

use mocap_figure::Figure;
use mocap_scene::scene::Scene;
use serde_json::{Value, json};

use super::corpus::Corpus;
use super::motion::Motion;
use super::row::{ClipRow, Quality};
use super::thresholds::{DefectKind, Thresholds};

const PAGE: &str = include_str!("card/page.html");
const SCRIPT: &str = include_str!("card/card.js");
const STYLE: &str = include_str!("card/card.css");

/// How many of the worst clips, of usual ones and of groups of twins move on the page.
const MOVING: usize = 8;

/// Frames per second of a moving figure: fewer jerk, more make the page larger.
const RATE: f64 = 15.0;

/// Seconds of a moving figure: some steps.
const SECONDS: f64 = 6.0;

/// The longest part of a clip that is in the player, in seconds, so that pages stay small.
const PLAYED: f64 = 12.0;

/// The time in seconds by which that part begins before the worst finding: a person sees what leads to it.
const BEFORE: f64 = 2.0;

/// Joints of a moving figure at most: more make the page larger, and are fingers.
const MOST_JOINTS: usize = 120;
/// Rows of the list; the page says where there are more.
const MOST_ROWS: usize = 20_000;

impl Corpus {
    /// The page. `import` reads the files of the clips that move on it, again.
    pub fn to_page(&self, thresholds: &Thresholds, import: impl Fn(&str) -> Option<Scene>) -> String {
        let rows: Vec<&ClipRow> = self.rows().collect();
        // Of twins one is enough.
        let is_shown = |index: &usize| is_wrong(rows[*index]) && !rows[*index].twin;
        let mut worst: Vec<usize> = (0..rows.len()).filter(is_shown).collect();
        worst.sort_by(|a, b| rows[*a].quality.total_cmp(&rows[*b].quality));
        worst.truncate(MOVING);
        let usual = usual(&rows);
        let twins = twins(&rows);
        let moving: BTreeSet<usize> = worst
            .iter()
            .chain(&usual)
            .chain(twins.iter().flatten())
            .copied()
            .collect();
        let figures = moving.into_iter().filter_map(|index| {
            let scene = import(&rows[index].file)?;
            Some((index.to_string(), figure(scene, rows[index])?))
        });
        let figures: serde_json::Map<String, Value> = figures.collect();
        let kinds = DefectKind::ALL.iter().map(|kind| {
            let [suspect, bad] = thresholds.of(*kind);
            json!({"name": kind.as_str(), "unit": kind.unit(), "help": kind.help(), "suspect": suspect, "bad": bad})
        });
        let data = json!({
            "clips": rows.len(),
            "rows": rows.iter().take(MOST_ROWS).map(|row| short(row)).collect::<Vec<_>>(),
            "kinds": kinds.collect::<Vec<_>>(),
            "worst": worst, "usual": usual, "twins": twins, "figures": figures, "player": player::page(),
        });
        // Nothing in a name ends the element.
        let data = data.to_string().replace('<', "\\u003c");
        let page = PAGE.replace("/*STYLE*/", STYLE).replace("/*SCRIPT*/", SCRIPT);
        // Last, since a name may be anything.
        page.replacen("/*DATA*/", &data, 1)
    }
}

fn is_wrong(row: &ClipRow) -> bool {
    matches!(row.verdict, Quality::Suspect | Quality::Bad)
}

/// Good clips nearest to the middle of the map.
fn usual(rows: &[&ClipRow]) -> Vec<usize> {
    let from_middle = |row: &ClipRow| row.map_x.zip(row.map_y).map(|(x, y)| x * x + y * y);
    let mut usual: Vec<(usize, f64)> = (0..rows.len())
        .filter(|index| rows[*index].verdict == Quality::Good && rows[*index].frames > 1 && !rows[*index].twin)
        .filter_map(|index| Some((index, from_middle(rows[index])?)))
        .collect();
    // People first: what else there is has no limbs to see.
    let is_other = |index: usize| rows[index].humanoid != Some(true);
    usual.sort_by(|a, b| is_other(a.0).cmp(&is_other(b.0)).then(a.1.total_cmp(&b.1)));
    usual.into_iter().take(MOVING).map(|(index, _)| index).collect()
}

/// Of each group of twins the kept clip and another one.
fn twins(rows: &[&ClipRow]) -> Vec<Vec<usize>> {
    let mut groups: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (index, row) in rows.iter().enumerate() {
        if let Some(group) = row.twin_group {
            groups.entry(group).or_default().push(index);
        }
    }
    let mut groups: Vec<Vec<usize>> = groups.into_values().collect();
    for group in &mut groups {
        group.sort_by_key(|index| rows[*index].twin);
        group.truncate(2);
    }
    // Copies of files are named in the list; what is alike in motion is to be seen.
    let is_copy = |group: &Vec<usize>| {
        group
            .iter()
            .any(|index| rows[*index].twin_reason.as_deref() == Some("bytes"))
    };
    groups.retain(|group| rows[group[0]].frames > 1);
    groups.sort_by_key(is_copy);
    groups.truncate(MOVING);
    groups
}

/// What the list, the histograms and the map take of a row.
fn short(row: &ClipRow) -> Value {
    let defects = row.defects.iter().take(12);
    let defects = defects.map(|defect| {
        json!([
            defect.kind.as_str(),
            defect.frames[0],
            defect.frames[1],
            defect.joint,
            defect.amount
        ])
    });
    json!({
        "file": row.file, "clip": row.clip, "verdict": row.verdict, "quality": row.quality, "reasons": row.reasons,
        "error": row.error, "seconds": row.seconds, "rate": row.rate, "frames": row.frames, "speed": row.speed,
        "skeleton": row.skeleton, "twin": row.twin_reason, "of": row.twin_of, "x": row.map_x, "y": row.map_y,
        "does": [row.standing, row.walking, row.running, row.jumping, row.lying, row.other],
        "defects": defects.collect::<Vec<_>>(),
    })
}

/// The clip as the page draws it: small, and in the player.
fn figure(mut scene: Scene, row: &ClipRow) -> Option<Value> {
    let mut clips = scene.animations.iter().enumerate();
    let (_, clip) = clips.find(|(index, clip)| clip.name == row.clip || index.to_string() == row.clip)?;
    let clip = clip.clone();
    let figure = Figure::new(&scene);
    let motion = Motion::new(&scene, &clip, &figure).ok()?;
    let from = first_shown(&motion, row);
    let mut shown = preview(&motion, from)?;
    let last = (from + motion.frames_in(PLAYED)).min(motion.frames - 1);
    let is_long = motion.seconds() > PLAYED;
    scene.animations = vec![clip];
    if is_long {
        scene.trim(from as f64, last as f64);
    }
    shown["from"] = from.into();
    shown["played"] = player::clip(&mut scene, &figure, &row.file);
    Some(shown)
}

/// From which frame on a clip is shown: all of a short one, else from a little before its worst finding.
fn first_shown(motion: &Motion, row: &ClipRow) -> usize {
    let worst = row.reasons.split(' ').next().unwrap_or_default();
    let mut findings = row.defects.iter().filter(|defect| defect.kind.as_str() == worst);
    match findings.next() {
        Some(defect) if motion.seconds() > PLAYED => {
            let before = defect.frames[0].saturating_sub(motion.frames_in(BEFORE));
            before.clamp(motion.first, motion.frames - 1)
        }
        _ => motion.first,
    }
}

/// The joints of a clip over some seconds, in centimetres, which the page draws.
fn preview(motion: &Motion, from: usize) -> Option<Value> {
    let mut joints: Vec<usize> = match &motion.body {
        Some(body) => body.bones.values().copied().collect(),
        None => (0..motion.nodes()).filter(|node| motion.is_joint[*node]).collect(),
    };
    joints.sort_unstable();
    joints.truncate(MOST_JOINTS);
    let above = |joint: &usize| {
        let mut above = std::iter::successors(motion.parents[*joint], |node| motion.parents[*node]);
        above.find_map(|node| joints.binary_search(&node).ok())
    };
    let parents: Vec<Option<usize>> = joints.iter().map(above).collect();
    let step = (motion.rate / RATE).max(1.0);
    let frames = (0..).map(|number| from + (f64::from(number) * step) as usize);
    let frames = frames
        .take_while(|frame| *frame < motion.frames)
        .take((SECONDS * RATE) as usize);
    let centimetres = |frame: usize| -> Vec<i32> {
        let coordinates = joints.iter().flat_map(|joint| motion.at(frame, *joint).to_array());
        coordinates
            .map(|value| (100.0 * value).round().clamp(-1e6, 1e6) as i32)
            .collect()
    };
    let floor = motion.body.as_ref().map_or(0.0, |body| 100.0 * body.contacts.floor);
    let frames: Vec<Vec<i32>> = frames.map(centimetres).collect();
    let moves = !frames.is_empty() && motion.rate > 0.0;
    moves.then(|| json!({"parents": parents, "frames": frames, "rate": motion.rate / step, "floor": floor}))
}

/// The player of `mocap view`, once, and the clips that it plays.
#[cfg(feature = "render")]
mod player {
    use serde_json::{Value, json};

    use mocap_figure::Figure;
    use mocap_render::{Clip, Page, PageClip, PlayerClip};
    use mocap_scene::scene::Scene;

    /// The page of the player without clips.
    pub(super) fn page() -> Value {
        Page::without_clips().into()
    }

    /// A clip for it, without what is more than its motion.
    pub(super) fn clip(scene: &mut Scene, figure: &Figure, name: &str) -> Value {
        use base64::Engine;

        scene.meshes.clear();
        scene.original = None;
        let clip = PageClip::new(Clip { name, scene }).figure(figure);
        let packed = PlayerClip::new(&clip);
        let blocks = packed.blocks.into_iter();
        let blocks = blocks.map(|(id, bytes)| json!([id, base64::engine::general_purpose::STANDARD.encode(bytes)]));
        json!({"clip": packed.description, "blocks": blocks.collect::<Vec<_>>()})
    }
}

/// A build without pictures has no player: the page draws the joints alone.
#[cfg(not(feature = "render"))]
mod player {
    use serde_json::Value;

    use mocap_figure::Figure;
    use mocap_scene::scene::Scene;

    pub(super) fn page() -> Value {
        Value::Null
    }

    pub(super) fn clip(_: &mut Scene, _: &Figure, _: &str) -> Value {
        Value::Null
    }
}
