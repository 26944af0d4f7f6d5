//! Surveys a corpus of motions: one row for each clip, its defects, near-duplicates, and a diverse subset.
//! `docs/survey-algorithm.md` describes every rule.
//!
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//! use mocap::survey::Thresholds;
//! use mocap::survey::report::{ClipRow, Quality};
//! # fn main() -> mocap::Result<()> {
//! let scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
//! let clips = Thresholds::default().examine(&scene, "cmu_12_01_walk.bvh");
//! let row: &ClipRow = &clips[0].row;
//! assert!(row.walking > row.standing && row.verdict != Quality::Unreadable);
//! # Ok(())
//! # }
//! ```

mod activity;
mod card;
mod corpus;
mod defects;
mod descriptor;
mod filter;
pub(crate) mod fingerprint;
mod formats;
mod motion;
mod moving;
pub mod report;
mod row;
mod sarif;
mod select;
mod skeleton;
mod split;
#[cfg(feature = "arrow")]
mod table;
mod thresholds;
mod twins;

use mocap_edit::MotionErrors;
use mocap_figure::Figure;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{Animation, HumanoidBone as Bone, NodeKind, Scene, Side};

use self::activity::Activity;
pub use self::corpus::Corpus;
use self::defects::Findings;
pub use self::filter::Condition;
pub(crate) use self::fingerprint::{Fingerprint, LIMBS, WIDTH};
pub(crate) use self::motion::{Body, Motion};
use self::moving::{MovingPart, moving_frames};
use self::report::{ClipRecord, ClipRow, Quality};
pub use self::select::{SelectAmount, SelectBy};
pub use self::thresholds::{DefectKind, Thresholds};
pub(crate) use self::twins::{are_of_one_take, mirrored_row};

impl Thresholds {
    /// Examines every clip of a file. A file without motion becomes one row without frames. `file` is the name of the
    /// file in the rows.
    ///
    /// The [module](crate::survey) has an example.
    pub fn examine(&self, scene: &Scene, file: &str) -> Vec<ClipRecord> {
        self.examine_read(scene.clone(), file)
    }

    /// Examines a scene as [`examine`](Self::examine) does, but does not copy it. The keys of a long motion take most
    /// of the memory.
    #[doc(hidden)]
    pub fn examine_read(&self, mut scene: Scene, file: &str) -> Vec<ClipRecord> {
        let (figure, count) = (Figure::new(&scene), scene.animations.len().max(1));
        let mut clips = Vec::new();
        examine_each(&mut scene, &figure, file, self, |row, motion| {
            let fingerprint = motion.as_ref().map(Fingerprint::new).unwrap_or_default();
            clips.push(ClipRecord {
                row,
                fingerprint,
                clips: count,
            });
        });
        clips
    }
}

/// Calls a function with the row of every clip of a file, and with the motion if the clip has a readable motion. The
/// scene is unchanged afterwards.
pub(crate) fn examine_each(
    scene: &mut Scene,
    figure: &Figure,
    file: &str,
    thresholds: &Thresholds,
    mut each: impl FnMut(ClipRow, Option<Motion<'_>>),
) {
    if scene.animations.is_empty() {
        let mut row = of_scene(scene, figure, file);
        row.clip = clip_name((0, &Animation::default()));
        let joints = row.joints.max(1) as f64;
        row.amounts.insert(DefectKind::NoMotion, joints);
        row.judge(thresholds);
        each(row, None);
    }
    for index in 0..scene.animations.len() {
        let mut row = of_scene(scene, figure, file);
        row.clip = clip_name((index, &scene.animations[index]));
        match of_clip(scene, index, figure, thresholds, &mut row) {
            Ok(motion) => {
                row.round();
                each(row, Some(motion));
            }
            Err(error) => {
                let clip = row.clip;
                let row = ClipRow::unreadable(file, &error.to_string());
                each(ClipRow { clip, ..row }, None);
            }
        }
    }
}

/// The columns that all clips of a file share.
fn of_scene(scene: &Scene, figure: &Figure, file: &str) -> ClipRow {
    let origin = scene.metadata.origin.as_ref();
    ClipRow {
        file: file.to_owned(),
        sha256: origin.map(|origin| origin.sha256.clone()).unwrap_or_default(),
        format: scene.metadata.format.map_or("", |format| format.as_str()).to_owned(),
        warnings: scene.warnings.len() as u64,
        licence: scene.metadata.attribution.licence.clone(),
        source: scene.metadata.attribution.source.clone(),
        person: scene.metadata.attribution.person.clone(),
        synthetic: scene.metadata.attribution.synthetic,
        skeleton: skeleton::id(scene, &figure.placing(scene)),
        joints: scene.nodes.iter().filter(|node| node.kind == NodeKind::Joint).count() as u64,
        humanoid: Some(figure.humanoid.found),
        metres_per_unit: Some(figure.survey.metres_per_unit),
        up: figure.survey.up.value.as_str().to_owned(),
        rest_pose: match figure.humanoid.found {
            true => figure.rest_pose.value.as_str().to_owned(),
            false => String::new(),
        },
        ..ClipRow::default()
    }
}

/// The motion of an animation. Its field `starts` is set to the first frame in which defects are searched.
fn started<'a>(scene: &Scene, animation: &'a Animation, figure: &Figure) -> Result<Motion<'a>> {
    let mut motion = Motion::new(scene, animation, figure)?;
    motion.starts = defects::searched(&motion).start;
    Ok(motion)
}

/// Finds the defects of the part of a clip in which the body moves.
fn find_in_part(part: &MovingPart, findings: &mut Findings<'_>) -> Result<()> {
    let errors = MotionErrors::find(&part.scene, 0, &part.figure)?;
    let motion = started(&part.scene, &part.scene.animations[0], &part.figure)?;
    findings.find_moving(&motion, &errors, Some(&part.frames));
    Ok(())
}

fn of_clip<'a>(
    scene: &'a mut Scene,
    index: usize,
    figure: &Figure,
    thresholds: &Thresholds,
    row: &mut ClipRow,
) -> Result<Motion<'a>> {
    let mut moving = Findings::new(thresholds);
    let whole = Motion::without_contacts(scene, &scene.animations[index], figure)?;
    let frames = moving_frames(scene, &whole);
    // Frees the memory of `whole` first: the search for errors, the moving part and the motion below each allocate
    // their own.
    drop(whole);
    let errors = match frames {
        Some(frames) => {
            let part = MovingPart::take(scene, index, frames);
            let found = find_in_part(&part, &mut moving);
            part.give_back(&mut scene.animations[index]);
            found?;
            None
        }
        None => Some(MotionErrors::find(scene, index, figure)?),
    };
    let (scene, animation) = (&*scene, &scene.animations[index]);
    let motion = started(scene, animation, figure)?;
    row.rate = Some(motion.rate);
    row.frames = motion.frames as u64;
    row.seconds = motion.seconds();
    row.size = Some(f64::from(motion.size()));
    let mut findings = Findings::new(thresholds);
    findings.find_stills(&motion, scene.face_curves_alone(index));
    if let Some(errors) = errors {
        moving.find_moving(&motion, &errors, None);
    }
    findings.append(moving);
    not_finite(scene, &motion, &mut findings);
    cut_off(scene, &motion, &mut findings);
    travel(&motion, row);
    if let Some(body) = &motion.body {
        of_body(&motion, body, row);
    }
    (row.amounts, row.defects) = (findings.amounts, findings.list);
    row.judge(thresholds);
    Ok(motion)
}

/// Finds values that are not finite, from the losses that the reader reported.
fn not_finite(scene: &Scene, motion: &Motion, findings: &mut Findings<'_>) {
    findings.look_for(&[DefectKind::NotFinite]);
    let codes = [Code::NonFiniteValue, Code::NonFiniteOffset];
    for warning in scene.warnings.iter().filter(|warning| codes.contains(&warning.code)) {
        let last = motion.frames.saturating_sub(1);
        let joint = warning.joint.as_deref();
        findings.add(
            DefectKind::NotFinite,
            [0, last],
            joint,
            warning.count.max(1) as f32,
            1.0,
        );
    }
}

/// Finds how many of the declared frames are missing, from the reader's report.
fn cut_off(scene: &Scene, motion: &Motion, findings: &mut Findings<'_>) {
    findings.look_for(&[DefectKind::CutOff]);
    let number = |text: &Option<String>| text.as_ref()?.split(' ').next()?.parse::<f32>().ok();
    let cut = |warning: &&Diagnostic| warning.code == Code::MissingFrames;
    for warning in scene.warnings.iter().filter(cut) {
        if let (Some(stated), Some(found)) = (number(&warning.expected), number(&warning.found)) {
            let last = motion.frames.saturating_sub(1);
            let missing = 100.0 * (1.0 - found / stated.max(1.0));
            findings.add(DefectKind::CutOff, [last, last], None, missing, 1.0);
        }
    }
}

/// Measures the distance and the speed of the hips, or of the root.
fn travel(motion: &Motion, row: &mut ClipRow) {
    let node = motion.body.as_ref().map_or(0, Body::hips);
    if motion.nodes() == 0 || motion.rate <= 0.0 {
        return;
    }
    // Use steps of 0.1 s, so that jitter between frames does not lengthen the path.
    let step = motion.frames_in(0.1);
    let points: Vec<_> = (motion.first..motion.frames)
        .step_by(step)
        .map(|frame| motion.at(frame, node).with_y(0.0))
        .collect();
    let path: f32 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    let half = motion.frames_in(0.25);
    let speed = |frame| motion.velocity(frame, node, half).with_y(0.0).length();
    let top = (motion.first..motion.frames)
        .step_by(step)
        .map(speed)
        .fold(0.0, f32::max);
    row.distance = finite(path);
    row.speed = finite(path / motion.seconds().max(f64::MIN_POSITIVE) as f32);
    row.top_speed = finite(top);
    row.jerk = jerk(motion);
}

/// The root mean square jerk of all joints: third differences of positions, divided by the third power of the frame
/// time.
fn jerk(motion: &Motion) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0_u64);
    let joints: Vec<usize> = (0..motion.nodes()).filter(|node| motion.is_joint[*node]).collect();
    for frame in motion.first + 3..motion.frames {
        for &node in &joints {
            let at = |before: usize| motion.at(frame - before, node).as_dvec3();
            sum += (at(0) - at(3) + 3.0 * (at(2) - at(1))).length_squared();
            count += 1;
        }
    }
    let mean = (sum / count as f64).sqrt() * motion.rate.powi(3);
    (count > 0 && mean.is_finite()).then_some(mean)
}

fn finite(value: f32) -> Option<f64> {
    value.is_finite().then_some(f64::from(value))
}

fn of_body(motion: &Motion, body: &Body, row: &mut ClipRow) {
    if motion.rate > 0.0 {
        let activity = Activity::new(motion, body);
        row.jumps = Some(activity.jumps);
        row.turns_over = Some(activity.turns_over);
        row.standing = Some(activity.standing);
        row.walking = Some(activity.walking);
        row.running = Some(activity.running);
        row.jumping = Some(activity.jumping);
        row.lying = Some(activity.lying);
        row.other = Some(activity.other);
    }
    row.t_pose_frame = (0..motion.frames)
        .find(|frame| defects::is_t_pose(motion, body, *frame))
        .map(|frame| frame as u64);
    let step = motion.frames_in(0.1);
    let looks: Vec<_> = (motion.first..motion.frames)
        .step_by(step)
        .map(|frame| body.forward(motion, frame))
        .collect();
    let turning: f32 = looks
        .windows(2)
        .map(|pair| pair[0].angle_between(pair[1]))
        .filter(|a| a.is_finite())
        .sum();
    row.turning = finite(turning.to_degrees());
    row.asymmetry = asymmetry(motion, body);
}

/// The asymmetry of a motion: the difference between the path lengths of left and right limbs, divided by their sum.
/// The paths are relative to the hips.
fn asymmetry(motion: &Motion, body: &Body) -> Option<f64> {
    let path = |bone: Bone, side: Side| -> Option<f32> {
        let node = *body.bones.get(&bone.on(side))?;
        let at = |frame: usize| motion.at(frame, node) - motion.at(frame, body.hips());
        Some(
            (motion.first + 1..motion.frames)
                .map(|frame| at(frame).distance(at(frame - 1)))
                .sum(),
        )
    };
    let limbs = [Bone::LeftHand, Bone::LeftLowerArm, Bone::LeftFoot, Bone::LeftLowerLeg];
    let side = |side: Side| limbs.iter().map(|bone| path(*bone, side)).sum::<Option<f32>>();
    let (left, right) = (side(Side::Left)?, side(Side::Right)?);
    finite((left - right).abs() / (left + right).max(f32::MIN_POSITIVE))
}

impl ClipRow {
    /// Computes verdict, quality, reasons and properties from the amounts.
    pub fn judge(&mut self, thresholds: &Thresholds) {
        let mut ratios: Vec<(f64, DefectKind)> = Vec::new();
        for (kind, amount) in &self.amounts {
            let [suspect, bad] = thresholds.of(*kind);
            if *amount >= suspect && *amount > 0.0 {
                ratios.push((amount / bad.max(f64::MIN_POSITIVE), *kind));
            }
        }
        ratios.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (properties, defects): (Vec<_>, Vec<_>) = ratios.into_iter().partition(|(_, kind)| kind.is_property());
        self.verdict = match defects.first() {
            None => Quality::Good,
            Some((worst, _)) if *worst < 1.0 => Quality::Suspect,
            Some(_) => Quality::Bad,
        };
        self.quality = 1.0 / (1.0 + defects.iter().map(|(ratio, _)| ratio).sum::<f64>());
        let names = |kinds: &[(f64, DefectKind)]| {
            let names: Vec<&str> = kinds.iter().map(|(_, kind)| kind.as_str()).collect();
            names.join(" ")
        };
        self.reasons = names(&defects);
        self.properties = names(&properties);
    }
}

/// The spans of consecutive frames for which `holds` is true, each as its first and last frame.
fn spans(frames: usize, holds: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let mut spans: Vec<[usize; 2]> = Vec::new();
    for frame in (0..frames).filter(|frame| holds(*frame)) {
        match spans.last_mut() {
            Some(last) if last[1] + 1 == frame => last[1] = frame,
            _ => spans.push([frame, frame]),
        }
    }
    spans
}

/// The name of a clip in a file, or its index if the clip has no name.
pub(crate) fn clip_name((index, clip): (usize, &Animation)) -> String {
    match clip.name.is_empty() {
        true => index.to_string(),
        false => clip.name.clone(),
    }
}
