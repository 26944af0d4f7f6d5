//! The card of a corpus: one offline page with counts, histograms, a map and a searchable list. The worst clips,
//! typical clips and groups of near-duplicates are shown as moving figures.

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

/// The number of worst clips, of typical clips and of groups of near-duplicates that move on the page.
const MOVING: usize = 8;

/// Frames per second of a moving figure. Fewer frames look jerky, and more make the page larger.
const RATE: f64 = 15.0;

/// The duration of a moving figure, in seconds: a few steps.
const SECONDS: f64 = 6.0;

/// The longest part of a clip in the player, in seconds. The limit keeps pages small.
const PLAYED: f64 = 12.0;

/// How long before the worst finding this part begins, in seconds, so that the viewer sees what leads to the finding.
const BEFORE: f64 = 2.0;

/// The largest number of joints of a moving figure. More joints are mostly fingers, and make the page larger.
const MOST_JOINTS: usize = 120;
/// The largest number of rows in the list. The page states if there are more.
const MOST_ROWS: usize = 20_000;

impl Corpus {
    /// Makes the page. `import` reads the files of the moving clips again.
    pub fn to_page(&self, thresholds: &Thresholds, import: impl Fn(&str) -> Option<Scene>) -> String {
        let rows: Vec<&ClipRow> = self.rows().collect();
        // Show only one clip of a group of near-duplicates.
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
        let drawn = moving.into_iter().filter_map(|index| {
            let scene = import(&rows[index].file)?;
            Some((index.to_string(), figure(scene, rows[index])?))
        });
        let mut figures = serde_json::Map::new();
        figures.extend(drawn);
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
        // Escape `<`, so that no name can close the script element.
        let data = data.to_string().replace('<', "\\u003c");
        let page = PAGE.replace("/*STYLE*/", STYLE).replace("/*SCRIPT*/", SCRIPT);
        // Insert the data last, because a name can contain any text.
        page.replacen("/*DATA*/", &data, 1)
    }
}

fn is_wrong(row: &ClipRow) -> bool {
    matches!(row.verdict, Quality::Suspect | Quality::Bad)
}

/// Typical clips: good clips nearest to the middle of the map.
fn usual(rows: &[&ClipRow]) -> Vec<usize> {
    let from_middle = |row: &ClipRow| row.map_x.zip(row.map_y).map(|(x, y)| x * x + y * y);
    let mut usual: Vec<(usize, f64)> = (0..rows.len())
        .filter(|index| rows[*index].verdict == Quality::Good && rows[*index].frames > 1 && !rows[*index].twin)
        .filter_map(|index| Some((index, from_middle(rows[index])?)))
        .collect();
    // Show humanoids first: other figures have no limbs.
    let is_other = |index: usize| rows[index].humanoid != Some(true);
    usual.sort_by(|a, b| is_other(a.0).cmp(&is_other(b.0)).then(a.1.total_cmp(&b.1)));
    usual.into_iter().take(MOVING).map(|(index, _)| index).collect()
}

/// The kept clip and one other clip of each group of near-duplicates.
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
    // Skip copies of files: the list names them. The figures show clips with similar motion.
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

/// The values of a row for the list, the histograms and the map.
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

/// The data of a clip on the page: a small figure, and the player.
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

/// The first shown frame: the first frame of a short clip, or a frame shortly before the worst finding of a long clip.
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

/// The joints of a clip over some seconds, in centimetres, for the small figure.
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

/// The player of `mocap view`, stored once, and its clips.
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

    /// A clip for the player, reduced to its motion.
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

/// A build without pictures has no player, and the page draws only the joints.
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
