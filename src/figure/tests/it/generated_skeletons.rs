//! Two hundred generated bodies without names: children to giants, T-poses, A-poses and zero rest poses, twist joints,
//! any unit.

use mocap::Scene;
use mocap::figure::{Confidence, Humanoid, HumanoidBone as Bone, Side};
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind};

/// SplitMix64, so that every machine makes the same bodies.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }

    fn chance(&mut self, share: f32) -> bool {
        self.next() < share
    }
}

/// A joint of a body: its bone, and its position in the pose of the motion, in which the body stands.
struct Joint {
    at: Vec3,
    bones: Vec<Bone>,
    is_end: bool,
    children: Vec<Joint>,
}

impl Joint {
    fn new(at: Vec3, bones: &[Bone]) -> Self {
        Self {
            at,
            bones: bones.to_vec(),
            is_end: false,
            children: Vec::new(),
        }
    }

    fn end(at: Vec3) -> Self {
        Self {
            is_end: true,
            ..Self::new(at, &[])
        }
    }

    /// Joints as a chain of parents and children.
    fn chain(joints: Vec<Self>) -> Self {
        let mut joints = joints.into_iter().rev();
        let mut below = joints.next().unwrap();
        for mut joint in joints {
            joint.children.push(below);
            below = joint;
        }
        below
    }
}

fn on(bone: Bone, side: Side) -> Bone {
    if side == Side::Left { bone } else { bone.mirrored() }
}

/// A body in metres with +Y up that faces +Z.
fn body(random: &mut Random, arms_down: f32) -> Joint {
    let height = random.between(0.9, 2.4);
    let has_twists = random.chance(0.4);
    let has_ends = random.chance(0.6);
    let has_collars = random.chance(0.85);
    let has_fingers = random.chance(0.4);
    let has_toes = random.chance(0.75);
    let leg = height * random.between(0.43, 0.5);
    let thigh = leg * random.between(0.48, 0.53);
    let ankle = 0.04 * height;
    let hip_joints = ankle + leg;
    let hips_at = Vec3::Y * (hip_joints + height * random.between(0.0, 0.05));
    let trunk = height * random.between(0.26, 0.31);
    let hip_width = height * random.between(0.045, 0.06);
    let shoulder_width = height * random.between(0.095, 0.12);
    let upper_arm = height * random.between(0.165, 0.185);
    let forearm = upper_arm * random.between(0.82, 0.95);
    let foot = height * random.between(0.075, 0.1);

    let mut hips = Joint::new(hips_at, &[Bone::Hips]);
    let spines = 1 + (random.next() * 6.0) as usize;
    let mut spine: Vec<Joint> = (0..spines)
        .map(|place| {
            let share = (place + 1) as f32 / spines as f32;
            let mut bones = vec![Bone::Chest, Bone::UpperChest];
            if place == 0 {
                bones.push(Bone::Spine);
            }
            Joint::new(hips_at + Vec3::Y * trunk * share, &bones)
        })
        .collect();
    let chest_at = hips_at + Vec3::Y * trunk;
    let neck_at = chest_at + Vec3::Y * height * random.between(0.04, 0.06);
    let head_at = neck_at + Vec3::new(0.0, height * random.between(0.05, 0.07), 0.01 * height);
    let mut head = Joint::new(head_at, &[Bone::Head]);
    if random.chance(0.3) {
        for x in [-0.02, 0.02] {
            head.children
                .push(Joint::new(head_at + height * Vec3::new(x, 0.04, 0.05), &[]));
        }
    }
    if has_ends {
        head.children.push(Joint::end(head_at + Vec3::Y * 0.11 * height));
    }
    let mut neck = Joint::new(neck_at, &[Bone::Neck]);
    neck.children.push(head);
    let mut limbs = Vec::new();
    for side in [Side::Left, Side::Right] {
        let out = if side == Side::Left { Vec3::X } else { Vec3::NEG_X };
        let hip = Vec3::Y * hip_joints + out * hip_width;
        // A bent knee, as in a walk.
        let knee = hip + thigh * Vec3::new(0.0, -0.995, 0.1);
        let foot_at = knee + (leg - thigh) * Vec3::new(0.0, -0.995, -0.1);
        let toes_at = foot_at + Vec3::new(0.0, -0.6 * ankle, foot);
        let mut joints = vec![Joint::new(hip, &[on(Bone::LeftUpperLeg, side)])];
        if has_twists {
            joints.push(Joint::new(hip.lerp(knee, 0.5), &[]));
        }
        joints.push(Joint::new(knee, &[on(Bone::LeftLowerLeg, side)]));
        if has_twists {
            joints.push(Joint::new(knee.lerp(foot_at, 0.5), &[]));
        }
        joints.push(Joint::new(foot_at, &[on(Bone::LeftFoot, side)]));
        if has_toes {
            joints.push(Joint::new(toes_at, &[on(Bone::LeftToes, side)]));
        }
        if has_ends || !has_toes {
            joints.push(Joint::end(toes_at + Vec3::Z * 0.03 * height));
        }
        limbs.push(Joint::chain(joints));
    }
    let mut arms = Vec::new();
    for side in [Side::Left, Side::Right] {
        let out = if side == Side::Left { Vec3::X } else { Vec3::NEG_X };
        let along = (out - Vec3::Y * arms_down.tan()).normalize();
        let shoulder = chest_at + Vec3::Y * 0.03 * height + out * shoulder_width;
        let elbow = shoulder + along * upper_arm;
        let wrist = elbow + along * forearm;
        let mut joints = Vec::new();
        if has_collars {
            let collar = chest_at + Vec3::Y * 0.025 * height + out * shoulder_width * 0.15;
            joints.push(Joint::new(collar, &[on(Bone::LeftShoulder, side)]));
        }
        joints.push(Joint::new(shoulder, &[on(Bone::LeftUpperArm, side)]));
        if has_twists {
            joints.push(Joint::new(shoulder.lerp(elbow, 0.5), &[]));
        }
        joints.push(Joint::new(elbow, &[on(Bone::LeftLowerArm, side)]));
        if has_twists {
            joints.push(Joint::new(elbow.lerp(wrist, 0.5), &[]));
        }
        let mut hand = Joint::new(wrist, &[on(Bone::LeftHand, side)]);
        if has_fingers {
            for finger in 0..5 {
                let z = 0.025 - 0.011 * finger as f32;
                let begin = if finger == 0 { 0.025 } else { 0.05 };
                let at = |far: f32| wrist + along * far * height + Vec3::Z * z * height;
                let phalanges = [begin, begin + 0.022, begin + 0.035].map(|far| Joint::new(at(far), &[]));
                hand.children.push(Joint::chain(phalanges.into()));
            }
        } else {
            hand.children.push(Joint::end(wrist + along * 0.09 * height));
        }
        joints.push(hand);
        arms.push(Joint::chain(joints));
    }
    if random.chance(0.5) {
        arms.reverse();
        limbs.reverse();
    }
    let chest = spine.last_mut().unwrap();
    chest.children.extend(arms);
    let place = (random.next() * 2.9) as usize;
    chest.children.insert(place, neck);
    hips.children = limbs;
    let place = (random.next() * 2.9) as usize;
    hips.children.insert(place, Joint::chain(spine));
    if random.chance(0.4) {
        let mut root = Joint::new(Vec3::ZERO, &[]);
        root.children.push(hips);
        return root;
    }
    hips
}

/// A scene of a body, with the bone of each node.
#[derive(Default)]
struct GeneratedBody {
    scene: Scene,
    bones: Vec<Vec<Bone>>,
    /// The orientation of each node in the pose of the motion.
    turns: Vec<Quat>,
}

impl GeneratedBody {
    /// Adds a joint. With `laid`, the bones of unbranched chains lie along this direction at rest, and the motion sets
    /// them upright.
    fn add(&mut self, joint: &Joint, parent: Option<(usize, Vec3)>, laid: Option<Vec3>) {
        let index = self.scene.nodes.len();
        let only = match joint.children.as_slice() {
            [child] if laid.is_some() => (child.at - joint.at).try_normalize(),
            _ => None,
        };
        let turn = laid
            .zip(only)
            .map_or(Quat::IDENTITY, |(laid, way)| Quat::from_rotation_arc(laid, way));
        let offset = match parent {
            None => joint.at,
            Some((parent, at)) => self.turns[parent].inverse() * (joint.at - at),
        };
        self.scene.nodes.push(Node {
            name: format!("J{index}"),
            kind: if joint.is_end {
                NodeKind::EndSite
            } else {
                NodeKind::Joint
            },
            parent: parent.map(|(parent, _)| NodeId::new(parent)),
            transform: Mat4::from_translation(offset),
            ..Node::default()
        });
        self.bones.push(joint.bones.clone());
        self.turns.push(turn);
        for child in &joint.children {
            self.add(child, Some((index, joint.at)), laid);
        }
    }

    /// Three frames of the pose.
    fn move_it(&mut self) {
        let nodes = &self.scene.nodes;
        let channels = nodes
            .iter()
            .enumerate()
            .filter(|(_, node)| node.kind == NodeKind::Joint);
        let channels = channels.map(|(index, node)| {
            let above = node.parent.map_or(Quat::IDENTITY, |parent| self.turns[parent.index()]);
            Channel {
                node_name: node.name.clone(),
                position_keys: Keys::constant(node.transform.w_axis.truncate()),
                rotation_keys: Keys::constant(above.inverse() * self.turns[index]),
                scaling_keys: Keys::constant(Vec3::ONE),
                ..Channel::default()
            }
        });
        let animation = Animation {
            ticks_per_second: 30.0,
            duration: 2.0,
            channels: channels.collect(),
            ..Animation::default()
        };
        self.scene.animations = vec![animation];
    }
}

/// Scales and rotates a body, for another unit, another up axis and another facing.
fn placed(joint: &mut Joint, turn: Quat, unit: f32) {
    joint.at = turn * joint.at * unit;
    for child in &mut joint.children {
        placed(child, turn, unit);
    }
}

#[test]
fn generated_bodies_without_names_are_found() {
    const BODIES: usize = 200;
    const UNITS: [f32; 6] = [1.0, 10.0, 17.7, 39.37, 100.0, 1000.0];
    let mut random = Random(18);
    let (mut right, mut careless) = (0, 0);
    for body_number in 0..BODIES {
        let arms_down = if random.chance(0.4) {
            random.between(0.4, 0.9)
        } else {
            0.0
        };
        let mut joint = body(&mut random, arms_down);
        let yaw = Quat::from_rotation_y((random.next() * 4.0).floor() * std::f32::consts::FRAC_PI_2);
        let up = if random.chance(0.4) {
            Quat::from_rotation_x(std::f32::consts::FRAC_PI_2)
        } else {
            Quat::IDENTITY
        };
        let unit = UNITS[(random.next() * 5.99) as usize];
        placed(&mut joint, up * yaw, unit);
        let mut built = GeneratedBody::default();
        let laid = random.chance(0.3).then_some(Vec3::X);
        built.add(&joint, None, laid);
        if laid.is_some() {
            built.move_it();
        }
        let found = Humanoid::of(&built.scene);
        let mut wrong = Vec::new();
        for &bone in Bone::ALL.iter().filter(|bone| !bone.is_finger()) {
            let is_there = built.bones.iter().any(|bones| bones.contains(&bone));
            let is_optional = matches!(
                bone,
                Bone::Chest | Bone::UpperChest | Bone::LeftEye | Bone::RightEye | Bone::Jaw
            );
            match found.bones.get(&bone) {
                Some(joint) if built.bones[joint.joint.index()].contains(&bone) => {}
                Some(joint) => wrong.push((bone, Some(joint.confidence))),
                None if is_there && !is_optional => wrong.push((bone, None)),
                None => {}
            }
        }
        if wrong.is_empty() {
            right += 1;
            continue;
        }
        println!(
            "body {body_number}: found {}, wrong {wrong:?}, {}",
            found.found, found.reason
        );
        let is_careful =
            |(_, confidence): &(Bone, Option<Confidence>)| matches!(confidence, None | Some(Confidence::Unsure));
        careless += usize::from(found.found && !wrong.iter().all(is_careful));
    }
    println!("{right} of {BODIES} are right, {careless} wrong and not unsure");
    assert!(right * 100 >= BODIES * 95, "{right} of {BODIES} are right");
    assert_eq!(careless, 0, "the others are refused, or the wrong bones are unsure");
}
