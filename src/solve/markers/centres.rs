//! Joint centres from landmarks, for each frame. The refinement starts from these centres, and joints that do not move
//! keep them.

use glam::{DMat3, DQuat, DVec3};
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::take::Take;

/// The forward offset of the hip centre from the midpoint of the front spines: a factor of the pelvis depth, plus a
/// length in metres (Harrington et al., J. Biomech. 40, 2007, table 3).
const HIP_FORWARD: (f64, f64) = (-0.24, -0.0099);

/// The upward offset from the same source: a factor of the distance between the front spines, plus a length in metres.
const HIP_UP: (f64, f64) = (-0.30, -0.0109);

/// The sideways offset from the same source: a factor of the distance between the front spines, plus a length in
/// metres.
const HIP_SIDE: (f64, f64) = (0.33, 0.0073);

/// The pelvis depth as a factor of the distance between the front spines, for a single marker on the sacrum.
const SACRAL_DEPTH: f64 = 0.6;

/// The shank length in metres of an adult of 1.72 m, for whom the widths below hold. It is 0.246 of the height (Drillis
/// and Contini, in Winter, Biomechanics and Motor Control of Human Movement). The shank shows the size of a body better
/// than the pelvis, whose markers may sit on a belly or a belt.
const SHANK: f64 = 0.423;

/// The distance in metres from the marker beside a knee to the knee centre: half the width of an adult's knee, and the
/// marker radius of 7 mm.
pub(super) const KNEE: f64 = 0.06;

/// The distance in metres from the marker beside an ankle to the ankle centre: half of the ankle's width, and the
/// marker radius.
pub(super) const ANKLE: f64 = 0.043;

/// The distance in metres from the marker beside an elbow to the elbow centre: half of the elbow's width, and the
/// marker radius.
const ELBOW: f64 = 0.042;

/// The distance of the shoulder centre below the acromion, as a fraction of the distance between both acromia (Rab et
/// al., J. Biomech. 35, 2002).
const SHOULDER_DOWN: f64 = 0.17;

/// The sine of the bend above which a hinge shows its axis without other markers.
const TELLS: f64 = 0.4;

/// The joint centres in one frame.
#[derive(Clone, Debug)]
pub(super) struct Centres {
    pub(super) joints: Vec<(Bone, DVec3)>,
    /// The up axis of the pelvis, normal to the plane of its spines, as CGM and the ISB (Wu et al., J. Biomech. 35,
    /// 2002) define it.
    pub(super) pelvis_up: DVec3,
}

/// The axes of the pelvis, left, up and forward, if its spines are seen.
pub(super) fn pelvis_axes(at: impl Fn(&str) -> Option<DVec3>) -> Option<DQuat> {
    let Pelvis { left, up, forward, .. } = Pelvis::of(&at)?;
    Some(DQuat::from_mat3(&DMat3::from_cols(left, up, forward)).normalize())
}

/// The centre of a hip, if the spines of the pelvis are seen.
pub(super) fn hip(at: impl Fn(&str) -> Option<DVec3>, side: Side) -> Option<DVec3> {
    Some(Pelvis::of(&at)?.hip(side))
}

impl Centres {
    pub(super) fn has(&self, bone: Bone) -> bool {
        self.joints.iter().any(|(own, _)| *own == bone)
    }
}

/// The joints whose landmarks are seen; `None` without a pelvis.
pub(super) fn centres(take: &Take, frame: usize) -> Option<Centres> {
    let at = |name: &str| take.at(name, frame);
    let pelvis = Pelvis::of(&at)?;
    let mut joints = vec![(Bone::Hips, pelvis.hip(Side::Left).midpoint(pelvis.hip(Side::Right)))];
    for side in [Side::Left, Side::Right] {
        leg(&at, &pelvis, side, &mut joints);
    }
    trunk(&at, &pelvis, &mut joints);
    Some(Centres {
        joints,
        pelvis_up: pelvis.up,
    })
}

struct Pelvis {
    front: DVec3,
    left: DVec3,
    forward: DVec3,
    up: DVec3,
    width: f64,
    depth: f64,
}

impl Pelvis {
    fn of(at: &impl Fn(&str) -> Option<DVec3>) -> Option<Self> {
        let (left, right) = (at("LASI")?, at("RASI")?);
        let (back, depth) = match (at("LPSI"), at("RPSI"), at("SACR")) {
            (Some(left), Some(right), _) => (left.midpoint(right), None),
            (_, _, Some(sacrum)) => (sacrum, Some(SACRAL_DEPTH)),
            _ => return None,
        };
        let front = left.midpoint(right);
        let width = left.distance(right);
        let left = (left - right).try_normalize()?;
        let forward = (front - back).reject_from(left);
        Some(Self {
            front,
            left,
            forward: forward.try_normalize()?,
            up: forward.cross(left).try_normalize()?,
            width,
            depth: depth.map_or(front.distance(back), |part| part * width),
        })
    }

    fn hip(&self, side: Side) -> DVec3 {
        let part = |(part, more): (f64, f64), of: f64| part * of + more;
        self.front
            + self.forward * part(HIP_FORWARD, self.depth)
            + self.up * part(HIP_UP, self.width)
            + self.left * part(HIP_SIDE, self.width) * sign(side)
    }
}

/// The size of the body relative to an adult, from its shanks.
fn size(at: &impl Fn(&str) -> Option<DVec3>) -> f64 {
    let shank = |side: Side| Some(at(&sided(side, "KNE"))?.distance(at(&sided(side, "ANK"))?));
    let shanks: Vec<f64> = [Side::Left, Side::Right].into_iter().filter_map(shank).collect();
    match shanks.is_empty() {
        true => 1.0,
        false => (shanks.iter().sum::<f64>() / (shanks.len() as f64 * SHANK)).clamp(0.5, 1.4),
    }
}

/// The sign of a side: positive on the left.
pub(super) fn sign(side: Side) -> f64 {
    if side == Side::Left { 1.0 } else { -1.0 }
}

pub(super) fn sided(side: Side, name: &str) -> String {
    format!("{}{name}", if side == Side::Left { "L" } else { "R" })
}

fn leg(at: &impl Fn(&str) -> Option<DVec3>, pelvis: &Pelvis, side: Side, found: &mut Vec<(Bone, DVec3)>) {
    let own = |name: &str| at(&sided(side, name));
    let hip = pelvis.hip(side);
    found.push((Bone::LeftUpperLeg.on(side), hip));
    let (Some(knee), Some(ankle)) = (own("KNE"), own("ANK")) else {
        return;
    };
    let size = size(at);
    let thigh = (knee - hip).normalize_or_zero();
    let shank = (ankle - knee).normalize_or_zero();
    // The axis points to the left, because a shin bends back.
    let left = axis(thigh.cross(shank), pelvis.left);
    let inward = -sign(side) * left.reject_from(thigh).normalize_or_zero();
    let knee = own("KNM").map_or(knee + inward * KNEE * size, |inner| knee.midpoint(inner));
    let shank = (ankle - knee).normalize_or_zero();
    let inward = -sign(side) * left.reject_from(shank).normalize_or_zero();
    let ankle = own("ANM").map_or(ankle + inward * ANKLE * size, |inner| ankle.midpoint(inner));
    found.push((Bone::LeftLowerLeg.on(side), knee));
    found.push((Bone::LeftFoot.on(side), ankle));
    let toes = match (own("TOE").or(own("MT1")), own("MT5")) {
        (Some(inner), Some(outer)) => Some(inner.midpoint(outer)),
        (one, other) => one.or(other).or(own("TIP")),
    };
    found.extend(toes.map(|toes| (Bone::LeftToes.on(side), toes)));
}

/// The axis of a hinge from the normal of its two bones. The straighter they are, the more it comes from `other`.
fn axis(normal: DVec3, other: DVec3) -> DVec3 {
    let tells = (normal.length() / TELLS).min(1.0);
    normal.normalize_or_zero() * tells + other * (1.0 - tells)
}

fn trunk(at: &impl Fn(&str) -> Option<DVec3>, pelvis: &Pelvis, found: &mut Vec<(Bone, DVec3)>) {
    // Without a marker on the acromion, a marker before and one behind the shoulder give its position.
    let shoulder = |side: Side| {
        let own = |name: &str| at(&sided(side, name));
        own("SHO").or_else(|| Some(own("SHF")?.midpoint(own("SHB")?)))
    };
    let (Some(left), Some(right)) = (shoulder(Side::Left), shoulder(Side::Right)) else {
        return;
    };
    let spine = pelvis.front - pelvis.forward * pelvis.depth * 0.6;
    let top = left.midpoint(right);
    let chest = match (at("T10"), at("STRN")) {
        (Some(back), Some(front)) => back.lerp(front, 0.4),
        _ => spine.lerp(top, 0.4),
    };
    let neck = match (at("C7"), at("CLAV")) {
        (Some(back), Some(front)) => back.lerp(front, 0.35),
        (Some(back), None) => back.lerp(top, 0.5),
        _ => top,
    };
    found.push((Bone::Spine, spine));
    found.push((Bone::Chest, chest));
    found.push((Bone::Neck, neck));
    let around = |names: &[&str]| names.iter().filter_map(|name| at(name)).collect::<Vec<DVec3>>();
    let mut head = around(&["LFHD", "RFHD", "LBHD", "RBHD"]);
    if head.is_empty() {
        head = around(&["HEAD", "HEDF", "HEDS", "LEAR", "REAR"]);
    }
    if !head.is_empty() {
        let mean = head.iter().sum::<DVec3>() / head.len() as f64;
        found.push((Bone::Head, neck.lerp(mean, 0.5)));
    }
    let down = (chest - top).normalize_or_zero();
    let width = left.distance(right);
    for side in [Side::Left, Side::Right] {
        let acromion = if side == Side::Left { left } else { right };
        let shoulder = acromion + down * SHOULDER_DOWN * width;
        found.push((Bone::LeftShoulder.on(side), neck.lerp(acromion, 0.2)));
        found.push((Bone::LeftUpperArm.on(side), shoulder));
        arm(at, side, shoulder, left - right, found);
    }
}

fn arm(
    at: &impl Fn(&str) -> Option<DVec3>,
    side: Side,
    shoulder: DVec3,
    across: DVec3,
    found: &mut Vec<(Bone, DVec3)>,
) {
    let own = |name: &str| at(&sided(side, name));
    let wrist = match (own("WRA"), own("WRB")) {
        (Some(inner), Some(outer)) => Some(inner.midpoint(outer)),
        (one, other) => one.or(other),
    };
    let (Some(elbow), Some(wrist)) = (own("ELB"), wrist) else {
        return;
    };
    let upper = (elbow - shoulder).normalize_or_zero();
    let lower = (wrist - elbow).normalize_or_zero();
    // A forearm bends forward, about the axis to the right, which is outward on the right side.
    let right = axis(upper.cross(lower), -across.normalize_or_zero());
    let inward = sign(side) * right.reject_from(upper).normalize_or_zero();
    let elbow = own("ELM").map_or(elbow + inward * ELBOW * size(at), |inner| elbow.midpoint(inner));
    found.push((Bone::LeftLowerArm.on(side), elbow));
    found.push((Bone::LeftHand.on(side), wrist));
}
