//! The up axis of bodies on the ground. In their rest pose every bone lies along +X, so the rest pose shows no axis.

/// The name of a motion, and its posture at a moment.
type Kind = (&'static str, fn(f32) -> Posture);

use std::f32::consts::{PI, TAU};

use mocap::figure::{Axis, Confidence, Figure};
use mocap::glam::{EulerRot, Mat3, Quat, Vec3};

/// The directions of the bones of a body at a time, with Y up, Z forward and X left. The directions of the left side
/// are mirrored for the right side.
pub(crate) struct Posture {
    pub(crate) left: Vec3,
    pub(crate) trunk: Vec3,
    pub(crate) head: Vec3,
    /// Upper and lower arm of both sides, then upper and lower leg, then foot.
    pub(crate) limbs: [[Vec3; 2]; 5],
    pub(crate) travel: Vec3,
}

fn both(left: Vec3, right: Vec3) -> [Vec3; 2] {
    [left.normalize(), Vec3::new(-right.x, right.y, right.z).normalize()]
}

pub(crate) fn mirrored(left: Vec3) -> [Vec3; 2] {
    both(left, left)
}

/// A crawl on hands and knees, forward by 0.4 m/s.
fn crawl(seconds: f32) -> Posture {
    let swing = (TAU * 0.9 * seconds).sin();
    Posture {
        left: Vec3::X,
        trunk: Vec3::new(0.0, 0.1, 1.0),
        head: Vec3::new(0.0, 0.5, 1.0),
        limbs: [
            both(Vec3::new(0.1, -1.0, 0.3 * swing), Vec3::new(0.1, -1.0, -0.3 * swing)),
            mirrored(Vec3::new(0.0, -1.0, 0.15)),
            both(Vec3::new(0.1, -1.0, -0.4 * swing), Vec3::new(0.1, -1.0, 0.4 * swing)),
            mirrored(Vec3::new(0.0, -0.12, -1.0)),
            mirrored(Vec3::new(0.0, -0.25, -1.0)),
        ],
        travel: 0.4 * seconds * Vec3::Z,
    }
}

/// A body on its back that kicks with its legs.
fn lie(seconds: f32) -> Posture {
    let kick = (TAU * 0.5 * seconds).sin().max(0.0);
    Posture {
        left: Vec3::NEG_X,
        trunk: Vec3::NEG_Z,
        head: Vec3::new(0.0, 0.1, -1.0),
        limbs: [
            mirrored(Vec3::new(-0.5, 0.05, 1.0)),
            mirrored(Vec3::new(-0.2, 0.1, 1.0)),
            both(Vec3::new(-0.1, 0.4 * kick, 1.0), Vec3::new(-0.1, 0.0, 1.0)),
            mirrored(Vec3::new(-0.05, 0.0, 1.0)),
            mirrored(Vec3::new(0.0, 1.0, 0.3)),
        ],
        travel: Vec3::ZERO,
    }
}

/// A body that sits up from its back, with bent knees.
fn sit_up(seconds: f32) -> Posture {
    let angle = 0.6 * (1.0 - (TAU * 0.4 * seconds).cos());
    let trunk = Vec3::new(0.0, angle.sin() + 0.02, -angle.cos());
    Posture {
        left: Vec3::NEG_X,
        trunk,
        head: trunk + 0.1 * Vec3::Y,
        limbs: [
            mirrored(Vec3::new(-1.0, 0.3, -0.3)),
            mirrored(Vec3::new(0.8, 0.3, -0.6)),
            mirrored(Vec3::new(-0.1, 1.0, 1.0)),
            mirrored(Vec3::new(0.0, -1.0, 0.6)),
            mirrored(Vec3::new(0.0, -0.3, 1.0)),
        ],
        travel: Vec3::ZERO,
    }
}

fn walk(seconds: f32) -> Posture {
    let swing = (TAU * 0.9 * seconds).sin();
    Posture {
        left: Vec3::X,
        trunk: Vec3::new(0.0, 1.0, 0.05),
        head: Vec3::Y,
        limbs: [
            both(Vec3::new(0.15, -1.0, 0.4 * swing), Vec3::new(0.15, -1.0, -0.4 * swing)),
            mirrored(Vec3::new(0.05, -1.0, 0.4)),
            both(Vec3::new(0.05, -1.0, -0.4 * swing), Vec3::new(0.05, -1.0, 0.4 * swing)),
            mirrored(Vec3::new(0.0, -1.0, -0.3)),
            mirrored(Vec3::new(0.0, -0.35, 1.0)),
        ],
        travel: 1.1 * seconds * Vec3::Z,
    }
}

/// The rotation that lays +X along a direction.
fn along(direction: Vec3) -> Quat {
    Quat::from_rotation_arc(Vec3::X, direction.normalize())
}

/// A BVH file in metres of a body of 1.7 m whose bones lie along +X at rest. `world` rotates the world, and `lift` is
/// the height of the ground.
pub(crate) fn bvh(posture: impl Fn(f32) -> Posture, world: Quat, lift: f32) -> String {
    /// The number of frames, at 30 frames per second.
    const FRAMES: usize = 60;
    /// The height of the lowest joint above the ground, in metres: half the thickness of a limb.
    const ABOVE_GROUND: f32 = 0.04;
    let mut joints = vec![("Hips".to_owned(), None, Vec3::ZERO)];
    let mut join = |name: String, parent, offset| {
        joints.push((name, Some(parent), offset));
        joints.len() - 1
    };
    let spine = join("Spine".to_owned(), 0, 0.1 * Vec3::X);
    let neck = join("Neck".to_owned(), spine, 0.45 * Vec3::X);
    join("Head".to_owned(), neck, 0.12 * Vec3::X);
    let sides = [("Left", 1.0), ("Right", -1.0)];
    let arm = [("Arm", 0.0), ("ForeArm", 0.29), ("Hand", 0.26)];
    let leg = [("UpLeg", 0.0), ("Leg", 0.43), ("Foot", 0.42), ("ToeBase", 0.15)];
    // The bones in the order of the rows of a file, from the root down.
    for (parent, begin, bones) in [
        (spine, Vec3::new(0.4, 0.18, 0.0), &arm[..]),
        (0, Vec3::new(-0.03, 0.1, 0.0), &leg[..]),
    ] {
        for (side, sign) in sides {
            let mut last = parent;
            for (name, length) in bones {
                let offset = match *length {
                    0.0 => begin * Vec3::new(1.0, sign, 1.0),
                    length => length * Vec3::X,
                };
                last = join(format!("{side}{name}"), last, offset);
            }
        }
    }
    let mut rows = String::new();
    for frame in 0..FRAMES {
        let now = posture(frame as f32 / 30.0);
        let trunk = now.trunk.normalize();
        let left = now.left.reject_from_normalized(trunk).normalize();
        let trunk = Quat::from_mat3(&Mat3::from_cols(trunk, left, trunk.cross(left)));
        let to_world = |name: &str| {
            let limb = |index: usize| along(now.limbs[index][usize::from(name.starts_with("Right"))]);
            match name.trim_start_matches("Left").trim_start_matches("Right") {
                "Neck" | "Head" => along(now.head),
                "Arm" => limb(0),
                "ForeArm" | "Hand" => limb(1),
                "UpLeg" => limb(2),
                "Leg" => limb(3),
                "Foot" | "ToeBase" => limb(4),
                _ => trunk,
            }
        };
        let mut positions: Vec<Vec3> = Vec::new();
        for (_, parent, offset) in &joints {
            let at = parent.map_or(Vec3::ZERO, |parent: usize| {
                positions[parent] + to_world(&joints[parent].0) * *offset
            });
            positions.push(at);
        }
        let low = positions.iter().map(|at| at.y).fold(f32::INFINITY, f32::min);
        let root = world * (now.travel + (lift + ABOVE_GROUND - low) * Vec3::Y);
        rows += &format!("{} {} {}", root.x, root.y, root.z);
        for (name, parent, _) in &joints {
            let above = parent.map_or(world.inverse(), |parent| to_world(&joints[parent].0));
            let (z, x, y) = (above.inverse() * to_world(name)).to_euler(EulerRot::ZXY);
            rows += &format!(" {} {} {}", z.to_degrees(), x.to_degrees(), y.to_degrees());
        }
        rows += "\n";
    }
    let mut tree = String::new();
    write_joint(&joints, 0, &mut tree);
    format!("HIERARCHY\n{tree}MOTION\nFrames: {FRAMES}\nFrame Time: 0.0333333\n{rows}")
}

fn write_joint(joints: &[(String, Option<usize>, Vec3)], index: usize, tree: &mut String) {
    let (name, parent, offset) = &joints[index];
    let (kind, channels) = match parent {
        None => ("ROOT", "6 Xposition Yposition Zposition"),
        Some(_) => ("JOINT", "3"),
    };
    *tree += &format!(
        "{kind} {name}\n{{\nOFFSET {} {} {}\nCHANNELS {channels} Zrotation Xrotation Yrotation\n",
        offset.x, offset.y, offset.z
    );
    let children = (0..joints.len()).filter(|child| joints[*child].1 == Some(index));
    let mut is_end = true;
    for child in children {
        write_joint(joints, child, tree);
        is_end = false;
    }
    if is_end {
        *tree += "End Site\n{\nOFFSET 0.1 0 0\n}\n";
    }
    *tree += "}\n";
}

fn figure(posture: impl Fn(f32) -> Posture, world: Quat, lift: f32) -> Figure {
    let text = bvh(posture, world, lift);
    Figure::new(&mocap::Importer::new().read(text.as_bytes(), "ground.bvh").unwrap())
}

/// In a crawl along Z, the direction from the feet to the head is along Z. For a lying person, this direction equals
/// the direction of a standing person with another up axis. The parts that touch the ground lie in one plane, and most
/// files are Y up.
#[test]
fn a_body_on_the_ground_has_the_up_axis_of_the_ground() {
    let kinds: [Kind; 3] = [("crawl", crawl), ("lie", lie), ("sit-up", sit_up)];
    for (kind, posture) in kinds {
        for heading in [0.0, 0.25 * PI, 0.5 * PI, PI] {
            for lift in [0.0, 0.6] {
                let up = figure(posture, Quat::from_rotation_y(heading), lift).up;
                let what = format!("{kind}, heading {heading}, ground at {lift}: {}", up.reason);
                assert_eq!(up.value, Axis::Y, "{what}");
                assert_ne!(up.confidence, Confidence::Sure, "{what}");
            }
        }
    }
}

/// A crawl moves out of the plane of every other axis, so +Z up is also found.
#[test]
fn who_crawls_or_walks_with_z_up_is_found() {
    let z_up = Quat::from_rotation_x(0.5 * PI);
    let kinds: [Kind; 2] = [("crawl", crawl), ("walk", walk)];
    for (kind, posture) in kinds {
        let up = figure(posture, z_up, 0.0).up;
        assert_eq!(up.value, Axis::Z, "{kind}: {}", up.reason);
        assert_ne!(up.confidence, Confidence::Unsure, "{kind}: {}", up.reason);
    }
}

/// The rest pose of a walk stands along Y, and the body in motion stands along Z. With Y up, the body would lie and
/// climb by metres.
#[test]
fn nobody_climbs_while_lying() {
    let text = std::fs::read_to_string("../../fixtures/real/motionbuilder_vicon_walk.bvh").unwrap();
    let (hierarchy, motion) = text.split_once("MOTION").unwrap();
    let hips = hierarchy.replace("HIERARCHY", "").replace("ROOT", "JOINT");
    let lines = motion.lines().map(str::trim).filter(|line| !line.is_empty());
    let lines = lines.enumerate().map(|(index, line)| match index {
        0 | 1 => line.to_owned(),
        _ => format!("90 {line}"),
    });
    let motion = lines.collect::<Vec<_>>().join("\n");
    let head = "HIERARCHY\nROOT World\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation";
    let turned = format!("{head}\n{hips}\n}}\nMOTION\n{motion}\n");
    let up_of = |text: &str| Figure::new(&mocap::Importer::new().read(text.as_bytes(), "walk.bvh").unwrap()).up;
    assert_eq!(up_of(&text).value, Axis::Y);
    let up = up_of(&turned);
    assert_eq!(up.value, Axis::Z, "{}", up.reason);
}
