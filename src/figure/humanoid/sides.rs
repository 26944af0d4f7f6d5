//! Determines which limbs are on the left, from joint names and from the body.
//!
//! Feet point forward, knees bend forward, elbows backward, and the parts of a face lie in front of the head. With up
//! and forward known, left is up x forward.

use glam::Vec3;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene, Side};

use super::super::Confidence;
use super::super::poses::poses;
use super::Sides;
use super::body::Body;
use super::limb::Fit;
use super::topology::Tree;

/// The log-odds from which evidence decides a side: 1.3 to 1.
const SAYS_A_SIDE: f32 = 0.25;

/// In a standing rest pose, the cosine of the angle between each leg and the trunk is below this value.
const STANDS: f32 = -0.6;

/// The smallest distance of a knee or elbow from the straight line that counts, as a fraction of the limb.
const BENT: f32 = 0.015;

/// The cosine of 26 degrees. A foot with a smaller angle to the shin shows no direction.
const STRAIGHT_ON: f32 = 0.9;

/// The cosine of 75 degrees. In a pose that shows left and right, the lines of hips and shoulders have at most this
/// angle: no living trunk twists more.
const WRUNG: f32 = 0.26;

/// The evidence of one pose about the sides, each from -1 to 1: positive if the limb of the first root is the left
/// limb.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Evidence {
    pub(super) feet: Option<f32>,
    pub(super) knees: Option<f32>,
    pub(super) elbows: Option<f32>,
    pub(super) face: Option<f32>,
}

impl Evidence {
    /// The sum of the evidence; 0 without evidence.
    pub(super) fn sum(&self) -> f32 {
        let weigh = |part: Option<f32>, weight: f32| weight * part.unwrap_or(0.0);
        weigh(self.feet, 1.0) + weigh(self.knees, 1.0) + weigh(self.elbows, 0.6) + weigh(self.face, 0.6)
    }
}

/// The evidence of a pose of the body. `at` gives the position of a node in the pose.
pub(super) fn evidence(tree: &Tree, body: &Body, at: impl Fn(usize) -> Vec3) -> Evidence {
    let Some(axes) = Axes::new(body, &at) else {
        return Evidence::default();
    };
    let forward = axes.forward();
    let flat = |direction: Vec3| direction - direction.project_onto_normalized(axes.up);
    let mut feet = Vec::new();
    let mut knees = Vec::new();
    let mut elbows = Vec::new();
    for joints in body.legs.joints {
        if let [Some(upper), Some(lower), Some(foot), toes] = joints {
            let chain = tree.chain(foot);
            let tip = toes.or_else(|| chain.get(1).copied());
            if let Some(direction) = tip.map(|tip| flat(at(tip) - at(foot))) {
                let length = direction.length();
                // A foot that continues the shin shows no direction. Its only child may be an end site.
                let shin = (at(foot) - at(lower)).normalize_or_zero();
                let straight = tip.map_or(1.0, |tip| (at(tip) - at(foot)).normalize_or_zero().dot(shin));
                if length > 0.05 * body.legs.long_bones && straight < STRAIGHT_ON {
                    feet.push(direction.dot(forward) / length);
                }
            }
            knees.extend(bend(at(upper), at(lower), at(foot)).map(|direction| direction.dot(forward)));
        }
    }
    for joints in body.arms.iter().flat_map(|arms| arms.joints) {
        if let [_, Some(upper), Some(lower), Some(hand)] = joints {
            elbows.extend(bend(at(upper), at(lower), at(hand)).map(|direction| -flat(direction).dot(forward)));
        }
    }
    let mean = |parts: Vec<f32>| (!parts.is_empty()).then(|| parts.iter().sum::<f32>() / parts.len() as f32);
    Evidence {
        feet: mean(feet),
        knees: mean(knees),
        elbows: mean(elbows),
        face: body.trunk.head.and_then(|head| face(tree, head, &at, forward)),
    }
}

/// The evidence of the rest pose; no evidence if the figure does not stand in the rest pose.
pub(super) fn at_rest(tree: &Tree, body: &Body) -> Evidence {
    if stands(tree, body) {
        evidence(tree, body, |node| tree.at[node])
    } else {
        Evidence::default()
    }
}

/// Whether both legs are below the trunk in the rest pose.
pub(super) fn stands(tree: &Tree, body: &Body) -> bool {
    let at = |node: usize| tree.at[node];
    let Some(axes) = Axes::new(body, &at) else {
        return false;
    };
    body.legs.joints.iter().all(|joints| {
        let end = joints[2].or(joints[1]);
        let leg = joints[0]
            .zip(end)
            .map(|(upper, end)| (at(end) - at(upper)).normalize_or_zero());
        leg.is_some_and(|leg| leg.dot(axes.up) < STANDS)
    })
}

/// The up direction and the sideways direction of one pose.
pub(super) struct Axes {
    /// The direction from the hips to the shoulders.
    pub(super) up: Vec3,
    /// The direction from the limb of the second root to the limb of the first root.
    pub(super) across: Vec3,
}

impl Axes {
    pub(super) fn new(body: &Body, at: &impl Fn(usize) -> Vec3) -> Option<Self> {
        let middle = |nodes: [Option<usize>; 2]| Some(0.5 * (at(nodes[0]?) + at(nodes[1]?)));
        let hips = middle(body.legs.joints.map(|joints| joints[0]))?;
        let arms = body
            .arms
            .as_ref()
            .and_then(|arms| middle(arms.joints.map(|joints| joints[1])));
        let trunk = &body.trunk;
        // In a collapsed pose the arms are not at the shoulders, but the joints of the trunk are in place.
        let above = trunk
            .neck
            .or(trunk.head)
            .or(trunk.spine.last().copied())
            .map(at)
            .or(arms);
        // A lower body alone shows its up axis by its legs.
        let up = match above {
            Some(above) => above - hips,
            None => hips - middle(body.legs.joints.map(|joints| joints[2]))?,
        };
        let up = up.try_normalize()?;
        let across_of = |joints: [Option<usize>; 2]| Some(at(joints[0]?) - at(joints[1]?));
        let legs = across_of(body.legs.joints.map(|joints| joints[0]))?;
        let arms = body
            .arms
            .as_ref()
            .and_then(|arms| across_of(arms.joints.map(|joints| joints[1])));
        let across = if legs.length() > 0.02 * body.legs.long_bones {
            legs
        } else {
            arms?
        };
        let across = (across - across.project_onto_normalized(up)).try_normalize()?;
        Some(Self { up, across })
    }

    /// The facing of the figure if the limb of the first root is the left limb.
    pub(super) fn forward(&self) -> Vec3 {
        self.across.cross(self.up)
    }
}

/// The direction from the straight line between the ends of a limb to its middle joint; `None` for a straight limb.
fn bend(start: Vec3, middle: Vec3, end: Vec3) -> Option<Vec3> {
    let line = (end - start).try_normalize()?;
    let off = (middle - start) - (middle - start).project_onto_normalized(line);
    let length = start.distance(middle) + middle.distance(end);
    (off.length() > BENT * length).then(|| off.normalize_or_zero())
}

/// The evidence of the face: eyes, jaw and similar joints are in front of the head's joint.
fn face(tree: &Tree, head: usize, at: &impl Fn(usize) -> Vec3, forward: Vec3) -> Option<f32> {
    /// The smallest number of joints of a face that show its facing: both eyes and a jaw.
    const ENOUGH: usize = 3;
    let mut parts = Vec::new();
    let mut open = vec![head];
    while let Some(node) = open.pop() {
        if node != head && tree.is_joint[node] {
            parts.push(at(node));
        }
        if parts.len() > 256 {
            break;
        }
        open.extend(&tree.children[node]);
    }
    if parts.len() < ENOUGH {
        return None;
    }
    let mean = parts.iter().sum::<Vec3>() / parts.len() as f32;
    let direction = mean - at(head);
    Some((direction.dot(forward) / direction.length().max(f32::MIN_POSITIVE)).clamp(-1.0, 1.0))
}

/// The side of the first root by the names of its limb's joints: `None` if the names have no side, or both sides.
pub(super) fn by_names(tree: &Tree, joints: &[[Option<usize>; 4]; 2], roots: [usize; 2]) -> Option<Side> {
    let mut votes = 0;
    for (limb, sign) in [(0, 1), (1, -1)] {
        for node in joints[limb].iter().flatten().chain([&roots[limb]]) {
            votes += match tree.names[*node].side {
                Some(Side::Left) => sign,
                Some(Side::Right) => -sign,
                None => 0,
            };
        }
    }
    match votes {
        0 => None,
        votes if votes > 0 => Some(Side::Left),
        _ => Some(Side::Right),
    }
}

/// The side of each limb, with the confidence.
pub(super) struct Found {
    /// The sides of the limbs of both roots, first of the legs, then of the arms.
    pub(super) legs: [Side; 2],
    pub(super) arms: [Side; 2],
    pub(super) is_named: bool,
    pub(super) value: Sides,
    pub(super) confidence: Confidence,
    pub(super) reason: String,
}

impl Found {
    pub(super) fn new(scene: &Scene, tree: &Tree, body: &Body) -> Self {
        let by_name = |fit: &Fit| by_names(tree, &fit.joints, fit.pair.roots);
        let legs_by_name = by_name(&body.legs);
        let (evidence, shown_by) = look_for_sides(scene, tree, body, legs_by_name);
        let sum = evidence.sum();
        let arms_by_name = body.arms.as_ref().and_then(by_name);
        let by_body = (sum.abs() > SAYS_A_SIDE).then_some(if sum > 0.0 { Side::Left } else { Side::Right });
        let legs = legs_by_name.or(by_body).unwrap_or(Side::Left);
        // Arms without names are on the side of the leg below them.
        let above = arms_by_name.is_none().then(|| arm_above_leg(scene, tree, body));
        let arms_of_legs = |above: f32| if above >= 0.0 { legs } else { legs.opposite() };
        let arms = arms_by_name.or(above.map(arms_of_legs)).unwrap_or(legs);
        let is_arm_unclear = above.is_some_and(|above| above.abs() < ABOVE);
        let (value, confidence, reason) = match (legs_by_name, by_body) {
            (None, None) => (
                Sides::Unknown,
                Confidence::Unsure,
                "neither names nor the body distinguish left from right".to_owned(),
            ),
            (None, Some(_)) if is_arm_unclear => (
                Sides::Unknown,
                Confidence::Unsure,
                "the names do not state left or right, and the shoulders are twisted against the hips".to_owned(),
            ),
            (None, Some(_)) => (
                Sides::Unknown,
                if sum.abs() > 0.6 {
                    Confidence::Likely
                } else {
                    Confidence::Unsure
                },
                format!("the names do not state left or right, but {shown_by} shows them"),
            ),
            (Some(_), None) => (
                Sides::Unknown,
                Confidence::Unsure,
                "the body does not show which side is left".to_owned(),
            ),
            (Some(named), Some(shown)) => {
                let confidence = if sum.abs() > 0.6 {
                    Confidence::Sure
                } else {
                    Confidence::Likely
                };
                let parts = parts_of(&evidence, sum);
                if named == shown {
                    (
                        Sides::Agree,
                        confidence,
                        format!("{parts} in {shown_by} agree with the sides in the names"),
                    )
                } else {
                    let reason = format!("{parts} in {shown_by} show that joints named left are on the right");
                    (Sides::Opposite, confidence, reason)
                }
            }
        };
        Self {
            legs: [legs, legs.opposite()],
            arms: [arms, arms.opposite()],
            is_named: legs_by_name.is_some(),
            value,
            confidence,
            reason,
        }
    }
}

/// The parts of the body whose evidence has the sign of the sum.
fn parts_of(evidence: &Evidence, sum: f32) -> String {
    let parts = [
        ("feet", evidence.feet),
        ("knees", evidence.knees),
        ("elbows", evidence.elbows),
        ("face", evidence.face),
    ];
    let telling: Vec<&str> = parts
        .into_iter()
        .filter(|(_, says)| says.is_some_and(|says| says * sum > 0.0))
        .map(|(part, _)| part)
        .collect();
    telling.join(" and ")
}

/// The evidence of the rest pose, or of the motion if the rest pose has none. If the rest pose contradicts the names,
/// the motion is examined too: arbitrary rest poses may look like a standing body.
fn look_for_sides(scene: &Scene, tree: &Tree, body: &Body, named: Option<Side>) -> (Evidence, &'static str) {
    let rest = at_rest(tree, body);
    let says = rest.sum().abs() > SAYS_A_SIDE;
    let is_as_named = named.is_none_or(|named| (rest.sum() > 0.0) == (named == Side::Left));
    if says && is_as_named || scene.animations.is_empty() {
        return (rest, "the rest pose");
    }
    let poses = poses(scene);
    let all: Vec<Evidence> = poses
        .iter()
        .filter(|pose| !is_wrung(tree, body, |node| pose.position(NodeId::new(node))))
        .map(|pose| evidence(tree, body, |node| pose.position(NodeId::new(node))))
        .collect();
    let mean = |part: fn(&Evidence) -> Option<f32>| {
        let said: Vec<f32> = all.iter().filter_map(part).filter(|said| said.is_finite()).collect();
        (!said.is_empty()).then(|| said.iter().sum::<f32>() / said.len() as f32)
    };
    let evidence = Evidence {
        feet: mean(|evidence| evidence.feet),
        knees: mean(|evidence| evidence.knees),
        elbows: mean(|evidence| evidence.elbows),
        face: mean(|evidence| evidence.face),
    };
    // A pose with a twisted trunk is no evidence, even if it is the rest pose.
    let is_clear = says && !is_wrung(tree, body, |node| tree.at[node]);
    match is_clear && evidence.sum().abs() <= SAYS_A_SIDE {
        true => (rest, "the rest pose"),
        false => (evidence, "the motion"),
    }
}

/// Whether the trunk is twisted so far that the shoulders face elsewhere than the hips. The names must have sides.
fn is_wrung(tree: &Tree, body: &Body, at: impl Fn(usize) -> Vec3) -> bool {
    let line = |fit: &Fit, index: usize| {
        let [first, second] = [fit.joints[0][index]?, fit.joints[1][index]?];
        let sign = match by_names(tree, &fit.joints, fit.pair.roots)? {
            Side::Left => 1.0,
            Side::Right => -1.0,
        };
        (sign * (at(first) - at(second))).try_normalize()
    };
    let shoulders = body.arms.as_ref().and_then(|arms| line(arms, 1));
    let lines = line(&body.legs, 0).zip(shoulders);
    lines.is_some_and(|(hips, shoulders)| hips.dot(shoulders) < WRUNG)
}

/// The smallest mean cosine of the angle between the lines of hips and shoulders at which arms are clearly above their
/// legs.
const ABOVE: f32 = 0.5;

/// The degree to which the first arm is on the side of the first leg, from -1 to 1. It is measured at rest, or as the
/// mean of the motion if the rest pose does not show it.
fn arm_above_leg(scene: &Scene, tree: &Tree, body: &Body) -> f32 {
    let Some(arms) = &body.arms else { return 1.0 };
    let same_way = |at: &dyn Fn(usize) -> Vec3| {
        let across = |a: Option<usize>, b: Option<usize>| match (a, b) {
            (Some(a), Some(b)) => (at(a) - at(b)).normalize_or_zero(),
            _ => Vec3::ZERO,
        };
        across(body.legs.joints[0][0], body.legs.joints[1][0]).dot(across(arms.joints[0][1], arms.joints[1][1]))
    };
    let at_rest = same_way(&|node| tree.at[node]);
    let stands = stands(tree, body);
    if stands && at_rest.abs() > ABOVE || scene.animations.is_empty() {
        return at_rest;
    }
    let poses = poses(scene);
    let sum: f32 = poses
        .iter()
        .map(|pose: &Pose| same_way(&|node| pose.position(NodeId::new(node))))
        .sum();
    sum / poses.len().max(1) as f32
}
