//! The positions of the joints of a set in every frame, without gaps.

use glam::Vec3;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{FrameBudget, Limits};
use mocap_scene::math::median::median;
use mocap_scene::scene::{Confidence, HumanoidBone as Bone, NodeId, NodeKind, Scene, Topic, UpAxis};

use super::{JointSet, refused, turned};

/// The positions of joints and points, indexed by joint or point, then frame.
#[derive(Debug)]
pub(super) struct Points {
    pub(super) frames: usize,
    /// The positions of each joint of the set.
    pub(super) tracks: Vec<Vec<Vec3>>,
    /// The positions of each point of the set.
    pub(super) all: Vec<Vec<Vec3>>,
    /// The up direction of the pelvis in each frame, if markers give more than joint centres; otherwise empty.
    pub(super) pelvis_up: Vec<Vec3>,
    pub(super) warnings: Vec<Diagnostic>,
}

impl Points {
    /// The points of a scene's nodes, matched by name. If no node has a name of the set, by order.
    pub(super) fn of_scene(scene: &Scene, set: &JointSet) -> Result<Self> {
        let Some(animation) = scene.animations.first() else {
            return Err(Diagnostic::new(Code::NoMotion, "there is no motion to solve").into());
        };
        let nodes: Vec<usize> = (0..scene.nodes.len())
            .filter(|node| scene.nodes[*node].kind != NodeKind::Group)
            .collect();
        let found = find(scene, &nodes, set)?;
        let mut budget = FrameBudget::of_scene(&Limits::default());
        let frames = budget.frames(animation.duration.round(), scene.nodes.len())?;
        let mut points = Self {
            frames,
            tracks: Vec::new(),
            all: Vec::with_capacity(found.len()),
            pelvis_up: Vec::new(),
            warnings: Vec::new(),
        };
        for (name, node) in std::iter::zip(&set.points, found) {
            let channel = animation
                .channels
                .iter()
                .find(|channel| channel.node == Some(NodeId::new(node)));
            let keys = channel.map(|channel| &channel.position_keys);
            let (mut ticks, mut values): (Vec<f64>, &[Vec3]) = (Vec::new(), &[]);
            if let Some(keys) = keys {
                ticks = (0..keys.len()).map(|key| keys.tick(key)).collect();
                values = &keys.values;
            }
            if values.is_empty() {
                let message = format!("the point {name} is in no frame");
                return Err(Diagnostic::new(Code::InvalidValue, message)
                    .in_joint(name)
                    .help("remove the point from the joints: {joints} FILE")
                    .into());
            }
            let (track, filled) = fill(&ticks, values, frames);
            // The key of a constant track holds in all frames, so it leaves no gap.
            if filled > 0 && keys.is_some_and(|keys| !keys.is_seen_throughout(frames)) {
                let message = format!(
                    "the point was not seen in {filled} of {frames} frames: positions were interpolated \
                        linearly"
                );
                points.warnings.push(Diagnostic::new(Code::Gap, message).in_joint(name));
            }
            points.all.push(track);
        }
        points.tracks = (set.joints.iter())
            .map(|joint| {
                let weight = 1.0 / joint.of.len().max(1) as f32;
                (0..frames)
                    .map(|frame| joint.of.iter().map(|point| points.all[*point][frame] * weight).sum())
                    .collect()
            })
            .collect();
        Ok(points)
    }

    /// The axis along which the spine points on average. Without a spine, the axis of the legs.
    pub(super) fn up(&self, set: &JointSet) -> (UpAxis, Confidence) {
        let hips = set
            .joint(Bone::Hips)
            .or_else(|| set.joints.iter().position(|joint| joint.parent.is_none()));
        let top = [Bone::Neck, Bone::Head, Bone::UpperChest, Bone::Chest, Bone::Spine]
            .into_iter()
            .find_map(|bone| set.joint(bone));
        let feet = [Bone::LeftFoot, Bone::RightFoot].map(|bone| set.joint(bone));
        let lines = match (hips, top, feet) {
            (Some(hips), Some(top), _) => vec![(hips, top)],
            (Some(hips), None, [Some(left), Some(right)]) => vec![(left, hips), (right, hips)],
            _ => return (UpAxis::Y, Confidence::Unsure),
        };
        let line = |(low, high): &(usize, usize)| {
            let lines = std::iter::zip(&self.tracks[*low], &self.tracks[*high]);
            lines
                .map(|(low, high)| (*high - *low).normalize_or_zero())
                .sum::<Vec3>()
        };
        let mean = lines.iter().map(line).sum::<Vec3>() / (lines.len() * self.frames.max(1)) as f32;
        let best = UpAxis::ALL.into_iter().fold(UpAxis::Y, |best, up| {
            if turned(mean, up).y > turned(mean, best).y {
                up
            } else {
                best
            }
        });
        let confidence = match turned(mean, best).y {
            0.8.. => Confidence::Sure,
            0.4.. => Confidence::Likely,
            _ => Confidence::Unsure,
        };
        (best, confidence)
    }

    /// Rotates the up axis to +Y.
    pub(super) fn turn(&mut self, (up, _): (UpAxis, Confidence)) {
        let tracks = self.tracks.iter_mut().chain(&mut self.all).flatten();
        for point in tracks.chain(&mut self.pelvis_up) {
            *point = turned(*point, up);
        }
    }

    /// The median of a number over frames. Long motions are sampled.
    pub(super) fn median(&self, number: impl Fn(usize) -> f32) -> f32 {
        /// The largest number of frames for a median, which bounds the time.
        const SAMPLES: usize = 500;
        let step = (self.frames / SAMPLES).max(1);
        let mut numbers: Vec<f32> = (0..self.frames)
            .step_by(step)
            .map(number)
            .filter(|number| number.is_finite())
            .collect();
        median(&mut numbers).unwrap_or(0.0)
    }
}

/// The node of each point of the set.
fn find(scene: &Scene, nodes: &[usize], set: &JointSet) -> Result<Vec<usize>> {
    let key = |name: &str| {
        // C3D labels may have the subject's name before a colon.
        let name = name.rsplit(':').next().unwrap_or(name);
        let letters = name.chars().filter(|letter| letter.is_alphanumeric());
        letters.flat_map(char::to_lowercase).collect::<String>()
    };
    let keys: Vec<String> = nodes.iter().map(|node| key(&scene.nodes[*node].name)).collect();
    let named = |point: &String| keys.iter().position(|own| *own == key(point)).map(|index| nodes[index]);
    let found: Vec<Option<usize>> = set.points.iter().map(named).collect();
    // An array has no names. The names of its points were assumed.
    let is_named = scene
        .metadata
        .assumptions
        .iter()
        .all(|said| said.topic != Topic::Layout);
    let is_known = found.iter().any(Option::is_some) && is_named || found.iter().all(Option::is_some);
    if !is_known && nodes.len() == set.points.len() {
        return Ok(nodes.to_vec());
    }
    let missing: Vec<&str> = std::iter::zip(&set.points, &found)
        .filter(|(_, found)| found.is_none())
        .map(|(point, _)| point.as_str())
        .collect();
    if missing.is_empty() {
        return Ok(found.into_iter().flatten().collect());
    }
    /// The largest number of names that a message lists.
    const NAMED: usize = 8;
    let there: Vec<&str> = nodes
        .iter()
        .take(NAMED)
        .map(|node| scene.nodes[*node].name.as_str())
        .collect();
    Err(refused(
        format!("the file does not have the points of {}", set.name),
        format!(
            "{} points, or their names; missing: {}",
            set.points.len(),
            missing.join(", ")
        ),
        format!("{} points: {}, ...", nodes.len(), there.join(", ")),
    )
    .help(format!("{{joints}} takes {}, or a file", JointSet::names()))
    .into())
}

/// A value for every frame: interpolated linearly between keys, constant before the first and after the last key.
fn fill(ticks: &[f64], values: &[Vec3], frames: usize) -> (Vec<Vec3>, usize) {
    let (mut track, mut key, mut filled) = (Vec::with_capacity(frames), 0, 0);
    for frame in 0..frames {
        let tick = frame as f64;
        while key + 1 < ticks.len() && ticks[key + 1] <= tick {
            key += 1;
        }
        let at = ticks[key];
        filled += usize::from((at - tick).abs() > 1e-6);
        track.push(match (ticks.get(key + 1), values.get(key + 1)) {
            (Some(next), Some(value)) if at <= tick => {
                values[key].lerp(*value, ((tick - at) / (next - at)).clamp(0.0, 1.0) as f32)
            }
            _ => values[key],
        });
    }
    (track, filled)
}
