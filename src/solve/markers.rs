//! Solves a skeleton with rotations from markers on the skin.
//!
//! 1. Labels become landmarks of the body, by the marker names of known sets. If the labels are unknown, landmarks are
//!    inferred from distances between markers that stay constant.
//! 2. In some tens of frames, landmarks give the joint centres: by regressions (hips, shoulders), and by the normals of
//!    bent limbs (knees, elbows). Rotations follow from the centres, as from any joint positions.
//! 3. Calibration refines bone lengths, joint centres and marker offsets together with the poses of these frames.
//! 4. Every frame is fitted to all its markers, starting from the frame before. A missing marker has no effect. The
//!    other markers and the model hold its segment.

mod body;
mod calibrate;
mod centres;
mod cloud;
mod fit;
mod functional;
mod gaps;
mod guess;
pub(crate) mod landmarks;
mod model;
pub(crate) mod noise;
mod plug_in_gait;
mod report;
mod steady;
mod strays;
mod subjects;
pub(crate) mod take;
mod track;
pub(crate) mod tree;
mod weights;

use std::sync::Arc;

use glam::Quat;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{HumanoidBone as Bone, Scene};

use self::calibrate::{FIRST_STEPS, STEPS, calibrate};
use self::centres::{Centres, centres};
use self::landmarks::Labels;
use self::take::Take;
use self::track::LabelSwap;
pub use self::weights::MarkerWeights;
use super::points::Points;
use super::rest::Rest;
use super::set::{JointSet, SetJoint};
use super::{rules, turn, turned, write};

/// The number of frames for calibration. The time of an iteration grows with this number.
const CALIBRATED: usize = 40;

/// The rate at which frames are solved first, each from the previous one, in frames per second. Between two of these
/// frames, the limbs of a runner turn by less than 45 degrees.
const COARSE_RATE: f64 = 30.0;

/// The caller's knowledge about markers, in addition to their labels.
#[derive(Debug, Default)]
pub struct Known {
    labels: Labels,
    standing: Option<Scene>,
    weights: MarkerWeights,
}

impl Known {
    /// Adds the labels of a JSON text, an object from labels to landmarks such as `{"hip_l": "LASI"}`.
    pub fn named(mut self, name: &str, text: &str) -> Result<Self> {
        let invalid = |message: String| {
            Diagnostic::new(Code::InvalidValue, format!("the markers of {name}: {message}"))
                .help("an object from labels to landmarks: {\"my front left hip\": \"LASI\", ...}")
        };
        let stated: std::collections::BTreeMap<String, String> =
            serde_json::from_str(text).map_err(|error| invalid(error.to_string()))?;
        for (label, landmark) in stated {
            let known = landmarks::named(&landmark);
            let landmark = known.ok_or_else(|| {
                invalid(format!(
                    "{landmark} is not a landmark; docs/markers.md lists the \
                    landmarks"
                ))
            })?;
            self.labels.named.insert(landmarks::whole_key(&label), landmark);
        }
        Ok(self)
    }

    /// Refuses labels that are not in the file.
    fn check(&self, takes: &[Option<&Take>]) -> Result<()> {
        let is_there = |key: &String| takes.iter().flatten().any(|take| take.has_label(key));
        let mut missing: Vec<&str> = self
            .labels
            .named
            .keys()
            .filter(|key| !is_there(key))
            .map(String::as_str)
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        missing.sort_unstable();
        let labels = takes.first().copied().flatten().map(|take| take.labels.join(", "));
        Err(Diagnostic::new(
            Code::InvalidValue,
            "labels of {markers} are not in the file, or two labels are the same landmark",
        )
        .expected_found(missing.join(", "), labels.unwrap_or_default())
        .help("the labels of a file: mocap info FILE")
        .into())
    }

    /// The subject to solve if the file has several.
    pub fn subject(mut self, name: &str) -> Self {
        self.labels.subject = Some(name.to_owned());
        self
    }

    /// The weights of the solver.
    pub fn weights(mut self, weights: MarkerWeights) -> Self {
        self.weights = weights;
        self
    }

    /// A trial of a standing person, with markers that the motion may lack.
    pub fn standing(mut self, scene: Scene) -> Self {
        self.standing = Some(scene);
        self
    }
}

/// Replaces the markers of `scene` with a skeleton. The scene keeps its name, its rate and its unit; +Y becomes up.
pub fn solve_markers(scene: &mut Scene, known: &Known) -> Result<()> {
    known.weights.check()?;
    let may_guess = known.labels.named.is_empty() && known.standing.is_none();
    let mut take = Take::of_scene(scene, &known.labels, may_guess)?;
    let standing = match &known.standing {
        Some(standing) => Some(Take::of_scene(standing, &known.labels, false)?),
        None => None,
    };
    known.check(&[Some(&take), standing.as_ref()])?;
    let exchanged = strays::exchange(&mut take);
    let rate = scene
        .animations
        .first()
        .map_or(0.0, |animation| animation.ticks_per_second);
    let noise = noise::of(&take.tracks, rate);
    let mut steady = take.clone();
    steady.tracks = steady::steady(&take.tracks, noise);
    let functional = match standing {
        None => functional::standing(&steady),
        Some(_) => None,
    };
    let mut chosen = chosen(&steady, standing.as_ref().or(functional.as_ref()))?;
    let name = match take.set {
        Some(set) => format!("{} markers of {set}", take.landmarks.len()),
        None if take.guess.is_some() => format!("{} markers that were guessed", take.landmarks.len()),
        None => format!("{} markers", take.landmarks.len()),
    };
    let set = body::joint_set(name, &chosen.centres[0], &chosen.take);
    [&mut take, &mut steady, &mut chosen.take]
        .into_iter()
        .for_each(|take| take.detach(&set));
    let up = body::points(&set, &chosen.centres, &chosen.take).up(&set);
    let upright = |point: glam::DVec3| turned(point.as_vec3(), up.0).as_dvec3();
    [&mut take, &mut steady, &mut chosen.take]
        .into_iter()
        .for_each(|take| take.rotate(upright));
    for centres in &mut chosen.centres {
        let joints = centres.joints.iter_mut().map(|(_, centre)| centre);
        joints
            .chain([&mut centres.pelvis_up])
            .for_each(|vector| *vector = upright(*vector));
    }
    let points = body::points(&set, &chosen.centres, &chosen.take);
    let rules = rules::Rules::new(&set, &points);
    let (mut rest, world) = turn::turn(&set, &rules, &points);
    // Markers that only the standing trial has are not markers of the motion.
    let mut seen = chosen.take.clone();
    seen.keep_first(take.landmarks.len());
    let (mut model, mut frames) = body::model(&set, &rest, &world, &points, &seen, known.weights);
    let regressed = model.clone();
    let steps = if chosen.spread.is_some() { FIRST_STEPS } else { STEPS };
    let mut known_joints = calibrate(&mut model, &regressed, &mut frames, (noise, steps));
    let mut start = (chosen.frames[0], frames[0].pose.clone());
    if let Some(wanted) = &chosen.spread {
        let step = ((rate / COARSE_RATE) as usize).max(1);
        frames = track::poses(&model, &steady.tracks, (start.0, &start.1), (wanted, step));
        known_joints = calibrate(&mut model, &regressed, &mut frames, (noise, STEPS));
        start = (wanted[0], frames[0].pose.clone());
    }
    // Calibration moves the markers on the pelvis, so recompute the pelvis axes from the markers.
    let offset = |name: &str| Some(model.markers[take.landmarks.iter().position(|own| own.name == name)?].offset);
    if let Some(axes) = centres::pelvis_axes(offset) {
        model.turn_root(axes, std::iter::once(&mut start.1));
    }
    let mut tracked = track::track(&model, (&take.tracks, &steady.tracks), (start.0, &start.1), rate);
    let index = |label: &String| take.labels.iter().position(|own| own == label);
    tracked.swaps.extend(exchanged.iter().filter_map(|[left, right]| {
        Some(LabelSwap {
            markers: (index(left)?, index(right)?),
            first: 0,
            last: take.frames - 1,
        })
    }));
    if let Some(calibration) = plug_in_gait::Calibration::of(scene, &take) {
        calibration.redefine(scene, &take, &set, &mut model, &mut tracked);
    }
    let solved = report::solved(scene, &take, (&set, &model, &known_joints), &tracked);
    report::say(scene, &take, &solved, &tracked);
    report::say_gaps(scene, &solved);
    if functional.is_some() {
        report::say_functional(scene);
    }
    scene.metadata.solved = Some(Arc::new(solved));

    let metres = take.metres as f32;
    for (offset, joint) in std::iter::zip(&mut rest.offsets, &model.joints) {
        if joint.parent.is_some() {
            *offset = joint.offset.as_vec3();
        }
    }
    on_the_ground(&mut rest, &set);
    rest.offsets.iter_mut().for_each(|offset| *offset /= metres);
    let solved = moving_root(&set, &tracked.roots, metres);
    let rotations: Vec<Vec<Quat>> = tracked
        .rotations
        .iter()
        .map(|track| track.iter().map(|rotation| rotation.as_quat()).collect())
        .collect();
    scene.metadata.metres_per_unit = Some(take.metres);
    let lengths = "lengths are refined with the poses";
    write(scene, &set, &solved, &rest, rotations, up, lengths);
    Ok(())
}

/// The positions of the root, in units of the file. No other joint has moving positions.
fn moving_root(set: &JointSet, roots: &[glam::DVec3], metres: f32) -> Points {
    let track = |joint: &SetJoint| match joint.parent {
        None => roots.iter().map(|root| root.as_vec3() / metres).collect(),
        Some(_) => Vec::new(),
    };
    Points {
        frames: roots.len(),
        tracks: set.joints.iter().map(track).collect(),
        all: Vec::new(),
        pelvis_up: Vec::new(),
        warnings: Vec::new(),
    }
}

/// Sets the root height of the rest pose so that the lowest joint of the pose is on the ground.
fn on_the_ground(rest: &mut Rest, set: &JointSet) {
    let mut heights = vec![0.0_f32; set.joints.len()];
    for joint in set.depth_first() {
        if let Some(parent) = set.joints[joint].parent {
            heights[joint] = heights[parent] + rest.offsets[joint].y;
        }
    }
    let lowest = heights.iter().copied().fold(0.0, f32::min);
    rest.offsets[0].y = -lowest;
}

/// The frames for calibration.
struct FrameChoice {
    frames: Vec<usize>,
    /// The take, restricted to `frames`.
    take: Take,
    centres: Vec<Centres>,
    /// Extra frames, spread over the take, in which some markers are missing. Used if `frames` lie close together in
    /// time.
    spread: Option<Vec<usize>>,
}

/// The frame with the most markers from each of [`CALIBRATED`] equal intervals of the take. `None` if no gap between
/// chosen frames is longer than two intervals.
fn spread(chosen: &[usize], clean: &Take) -> Option<Vec<usize>> {
    let (count, frames) = (CALIBRATED.min(clean.frames), clean.frames);
    let mut ends = vec![0];
    ends.extend_from_slice(chosen);
    ends.push(frames);
    let longest = ends.windows(2).map(|pair| pair[1] - pair[0]).max()?;
    let fullest = |part: usize| {
        let seen = |frame: &usize| clean.tracks.iter().filter(|track| track[*frame].is_some()).count();
        (part * frames / count..(part + 1) * frames / count).max_by_key(seen)
    };
    (longest * count > 2 * frames).then(|| (0..count).filter_map(fullest).collect())
}

/// Chooses frames over the whole take. Every chosen frame has all joints that any frame has.
fn chosen(take: &Take, standing: Option<&Take>) -> Result<FrameChoice> {
    let all: Vec<usize> = (0..take.frames).step_by((take.frames / 1000).max(1)).collect();
    // A reflection must not affect the calibration.
    let mut clean = take.filled(&all, None);
    strays::leave_out(&mut clean);
    let indices: Vec<usize> = (0..all.len()).collect();
    let filled = clean.filled(&indices, standing);
    let found: Vec<Option<Centres>> = (0..all.len()).map(|frame| centres(&filled, frame)).collect();
    let most = found
        .iter()
        .flatten()
        .map(|centres| centres.joints.len())
        .max()
        .unwrap_or(0);
    let whole: Vec<usize> = (0..all.len())
        .filter(|frame| {
            found[*frame]
                .as_ref()
                .is_some_and(|centres| centres.joints.len() == most)
        })
        .collect();
    let has = |bone: Bone| {
        let first = whole.first().and_then(|frame| found[*frame].as_ref());
        first.is_some_and(|centres| centres.has(bone))
    };
    if !has(Bone::LeftFoot) || !has(Bone::RightFoot) {
        return Err(report::missing(take, standing).into());
    }
    let sample: Vec<usize> = (0..CALIBRATED.min(whole.len()))
        .map(|index| whole[index * whole.len() / CALIBRATED.min(whole.len())])
        .collect();
    let frames: Vec<usize> = sample.iter().map(|at| all[*at]).collect();
    Ok(FrameChoice {
        take: clean.filled(&sample, standing),
        centres: sample.iter().filter_map(|at| found[*at].clone()).collect(),
        spread: spread(&sample, &clean).map(|spread| spread.iter().map(|at| all[*at]).collect()),
        frames,
    })
}
