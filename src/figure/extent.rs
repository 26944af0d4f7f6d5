//! The size of the figure and its up axis.

use glam::Vec3;
use mocap_scene::math::median::median;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene, UpAxis};

use super::names::Name;
use super::names::words::Part;
use super::poses::poses;
use super::{Confidence, Unit};
use mocap_scene::scene::report::Guess;

/// The height of a person in metres, from the ankles to the head joint. The largest extent of a moving body stays close
/// to this height, because spread arms have the same span.
const TYPICAL_HEIGHT: f64 = 1.7;

/// A guess is sure if it differs from the typical height by at most this factor. The range is 1.36 m to 2.1 m, which
/// includes nearly all adults.
const SURE_WITHIN: f64 = 1.25;

/// A guess is likely if it differs from the typical height by at most this factor. The range includes children of six
/// years, and figures in games.
const LIKELY_WITHIN: f64 = 1.4;

/// The largest variation of the height of the lowest foot in a motion on a floor, as a fraction of the figure's size.
/// Jumps and stairs vary this height.
const FLOOR_SPREAD: f64 = 0.4;

/// Body parts whose names indicate a whole body.
const LOWER: [Part; 2] = [Part::Foot, Part::Toes];
const UPPER: [Part; 2] = [Part::Head, Part::Neck];

/// Measurements of a few poses of a scene.
pub(super) struct Extent {
    /// The median over all poses of the largest extent along an axis; 0 without poses.
    size: f64,
    /// The largest extent of the rest pose along an axis.
    size_at_rest: f64,
    /// Whether a node has the name of a foot or toes, and whether one has the name of a head or neck.
    has_feet: bool,
    has_head: bool,
    /// The average vector from the feet to the head; `None` if no names identify these nodes.
    feet_to_head: Option<Vec3>,
    /// The vector from the feet to the head in the rest pose.
    feet_to_head_at_rest: Option<Vec3>,
    /// For each axis, how much the position of the lowest foot varies along it. Along the up axis, this is little,
    /// because the lowest foot returns to the floor.
    floor_spread: Vec3,
}

impl Extent {
    /// `places` marks the nodes that only place the figure. These nodes are ignored.
    pub(super) fn new(scene: &Scene, places: &[bool]) -> Self {
        let poses = poses(scene);
        let body: Vec<NodeId> = (0..scene.nodes.len())
            .filter(|node| !places[*node])
            .map(NodeId::new)
            .collect();
        let mut sizes: Vec<_> = poses.iter().map(|pose| extent(pose, &body)).collect();
        let (feet, heads) = (nodes_called(scene, &LOWER), nodes_called(scene, &UPPER));
        let from_feet = |pose: &Pose| Some(middle(pose, &heads)? - middle(pose, &feet)?);
        let lowest = |pose: &Pose| feet.iter().map(|foot| pose.position(*foot)).reduce(Vec3::min);
        let floors = || poses.iter().filter_map(lowest);
        let spread = floors().reduce(Vec3::max).zip(floors().reduce(Vec3::min));
        Self {
            size: median(&mut sizes).map_or(0.0, f64::from),
            size_at_rest: f64::from(extent(&Pose::rest(scene), &body)),
            has_feet: !feet.is_empty(),
            has_head: !heads.is_empty(),
            feet_to_head: (poses.iter().map(from_feet).sum::<Option<Vec3>>()).map(|sum| sum / poses.len() as f32),
            feet_to_head_at_rest: from_feet(&Pose::rest(scene)),
            floor_spread: spread.map_or(Vec3::ZERO, |(highest, lowest)| highest - lowest),
        }
    }

    /// The unit in which the figure's size is nearest to a person's height.
    ///
    /// Decimetres are rare, and a decimetre is less than twice the CMU unit. So decimetres are chosen only if the rest
    /// pose confirms them. A rest pose does not crouch, and in CMU files its arms are spread.
    pub(super) fn unit(&self) -> Guess<Unit> {
        let off = |size: f64, unit: &Unit| {
            let ratio = size * unit.metres() / TYPICAL_HEIGHT;
            ratio.max(ratio.recip())
        };
        let factor = |unit: &Unit| off(self.size, unit);
        let is_likely = |unit: &Unit| *unit != Unit::Decimetre || off(self.size_at_rest, unit) <= SURE_WITHIN;
        let units = Unit::ALL.into_iter().filter(is_likely);
        let nearest = units.min_by(|a, b| factor(a).total_cmp(&factor(b)));
        let value = nearest.unwrap_or(Unit::Metre);
        if self.size == 0.0 || !self.size.is_finite() {
            let reason = "the skeleton has no size".to_owned();
            return Guess {
                value: Unit::Metre,
                confidence: Confidence::Unsure,
                reason,
            };
        }
        let confidence = match factor(&value) {
            _ if self.feet_to_head.is_none() => Confidence::Unsure,
            off if off <= SURE_WITHIN => Confidence::Sure,
            off if off <= LIKELY_WITHIN => Confidence::Likely,
            _ => Confidence::Unsure,
        };
        let body = if self.feet_to_head.is_some() {
            ""
        } else {
            ", if the skeleton is a whole body"
        };
        let metres = self.size * value.metres();
        let reason = format!(
            "the skeleton measures {:.4} units, which is {metres:.2} m{body}",
            self.size
        );
        Guess {
            value,
            confidence,
            reason,
        }
    }

    /// The axis from the feet to the head.
    ///
    /// The head is not always above the feet, as in swimming or in some rest poses. If the motion and the rest pose
    /// disagree, the motion decides if its feet return to a floor, like the feet of an upright figure.
    pub(super) fn up(&self) -> Guess<UpAxis> {
        let Some(to_head) = self
            .feet_to_head
            .filter(|to_head| to_head.is_finite() && *to_head != Vec3::ZERO)
        else {
            let found = match (self.has_head, self.has_feet) {
                (false, false) => "no joint is called head or foot",
                (true, false) => "no joint is called foot",
                (false, true) => "no joint is called head",
                (true, true) => "the head and the feet are at the same point",
            };
            return Guess {
                value: UpAxis::Y,
                confidence: Confidence::Unsure,
                reason: format!("{found}, and most files are Y up"),
            };
        };
        let moving = longer_axis(to_head);
        let resting = self
            .feet_to_head_at_rest
            .filter(|to_head| to_head.is_finite() && *to_head != Vec3::ZERO)
            .filter(|to_head| to_head.normalize_or_zero().x.abs() < 0.9)
            .map(longer_axis);
        let (height, spread) = match moving {
            UpAxis::Y | UpAxis::NegY => (to_head.y, self.floor_spread.y),
            UpAxis::Z | UpAxis::NegZ => (to_head.z, self.floor_spread.z),
        };
        let stands = height > 0.0 && f64::from(spread) <= FLOOR_SPREAD * self.size;
        let fraction = height / to_head.length();
        let (value, confidence) = match resting {
            Some(resting) if resting != moving && stands => (moving, Confidence::Likely),
            Some(resting) if resting != moving => (resting, Confidence::Likely),
            _ if fraction > 0.9 => (moving, Confidence::Sure),
            _ if fraction > 0.7 => (moving, Confidence::Likely),
            _ => (moving, Confidence::Unsure),
        };
        let mut reason = format!(
            "the vector from the feet to the head is ({:.4}, {:.4}, {:.4}) units",
            to_head.x, to_head.y, to_head.z
        );
        if let Some(rest) = self.feet_to_head_at_rest.filter(|_| resting != Some(moving)) {
            reason += &format!(", and ({:.4}, {:.4}, {:.4}) in the rest pose", rest.x, rest.y, rest.z);
        }
        Guess {
            value,
            confidence,
            reason,
        }
    }
}

/// The largest extent of these nodes in a pose along an axis.
fn extent(pose: &Pose, nodes: &[NodeId]) -> f32 {
    let positions = || nodes.iter().map(|node| pose.position(*node));
    match (positions().reduce(Vec3::min), positions().reduce(Vec3::max)) {
        (Some(min), Some(max)) => (max - min).max_element(),
        _ => 0.0,
    }
}

/// X is not an up axis. The other components may be noise.
fn longer_axis(to_head: Vec3) -> UpAxis {
    /// The noise, as a fraction of the length of the path.
    const NOISE: f32 = 0.3;
    if to_head.z.abs() > to_head.y.abs() && to_head.z.abs() > NOISE * to_head.length() {
        UpAxis::Z
    } else {
        UpAxis::Y
    }
}

fn nodes_called(scene: &Scene, parts: &[Part]) -> Vec<NodeId> {
    let is_called = |name: &str| {
        let meaning = Name::read(name).meaning;
        meaning.iter().any(|(part, _)| parts.contains(part))
    };
    let called = scene.nodes.iter().enumerate().filter(|(_, node)| is_called(&node.name));
    called.map(|(index, _)| NodeId::new(index)).collect()
}

fn middle(pose: &Pose, nodes: &[NodeId]) -> Option<Vec3> {
    let sum: Vec3 = nodes.iter().map(|node| pose.position(*node)).sum();
    (!nodes.is_empty()).then(|| sum / nodes.len() as f32)
}
