//! The kinds of corruption, and changes that are no corruption.

use mocap::Scene;
use mocap::glam::{Mat4, Quat, Vec3};

use mocap::scene::{Animation, Channel, Node, NodeId, NodeKind, UpAxis};

/// A change of a converted scene that the file does not record.
pub(super) struct Kind {
    pub(super) name: &'static str,
    /// Whether the change affects the motion.
    pub(super) is_wrong: bool,
    pub(super) change: fn(&mut Scene),
}

const fn wrong(name: &'static str, change: fn(&mut Scene)) -> Kind {
    Kind {
        name,
        is_wrong: true,
        change,
    }
}

const fn right(name: &'static str, change: fn(&mut Scene)) -> Kind {
    Kind {
        name,
        is_wrong: false,
        change,
    }
}

/// An angle of 30 degrees, in radians.
const TURN: f32 = std::f32::consts::FRAC_PI_6;

fn channel<'a>(scene: &'a mut Scene, joint: &str) -> &'a mut Channel {
    let channels = &mut scene.animations[0].channels;
    channels.iter_mut().find(|channel| channel.node_name == joint).unwrap()
}

fn turn(scene: &mut Scene, joint: &str, frames: std::ops::Range<usize>, by: Quat) {
    for key in &mut channel(scene, joint).rotation_keys.values[frames] {
        *key *= by;
    }
}

fn root(scene: &mut Scene) -> &mut Vec<Vec3> {
    &mut channel(scene, "Hips").position_keys.values
}

fn node<'a>(scene: &'a mut Scene, name: &str) -> &'a mut Node {
    scene.nodes.iter_mut().find(|node| node.name == name).unwrap()
}

fn rename(scene: &mut Scene, from: &str, to: &str) {
    node(scene, from).name = to.to_owned();
    for channel in &mut scene.animations[0].channels {
        if channel.node_name == from {
            channel.node_name = to.to_owned();
        }
    }
}

/// Every animated key of the first clip.
fn keys(scene: &mut Scene, change: impl Fn(&mut Vec<Vec3>), turn: impl Fn(&mut Vec<Quat>)) {
    for channel in &mut scene.animations[0].channels {
        if channel.position_keys.values.len() > 1 {
            change(&mut channel.position_keys.values);
        }
        if channel.rotation_keys.values.len() > 1 {
            turn(&mut channel.rotation_keys.values);
        }
    }
}

fn lengthen(scene: &mut Scene, factor: f32) {
    for node in &mut scene.nodes {
        let offset = node.transform.w_axis.truncate() * factor;
        node.transform.w_axis = offset.extend(1.0);
    }
    for channel in &mut scene.animations[0].channels {
        channel.position_keys.values.iter_mut().for_each(|key| *key *= factor);
    }
}

fn clip(scene: &mut Scene) -> &mut Animation {
    &mut scene.animations[0]
}

#[expect(
    clippy::semicolon_if_nothing_returned,
    reason = "a line for each kind, as far as it fits"
)]
pub(super) const KINDS: &[Kind] = &[
    right("nothing", |_| ()),
    right("the same rotations with the other sign", |scene| {
        keys(
            scene,
            |_| (),
            |turns| turns.iter_mut().step_by(3).for_each(|turn| *turn = -*turn),
        );
    }),
    right("channels in another order", |scene| clip(scene).channels.reverse()),
    right("rotations within a millionth", |scene| {
        turn(scene, "Spine", 0..75, Quat::from_rotation_x(1e-6));
    }),
    right("the root within a tenth of a millimetre", |scene| {
        root(scene)[9].x += 1e-4
    }),
    wrong("one key of the root, X", |scene| root(scene)[40].x += 0.005),
    wrong("one key of the root, Y", |scene| root(scene)[0].y += 0.005),
    wrong("the last key of the root, Z", |scene| root(scene)[74].z -= 0.005),
    wrong("the root at all times", |scene| {
        root(scene).iter_mut().for_each(|key| key.x += 0.1)
    }),
    wrong("the root in millimetres", |scene| {
        root(scene).iter_mut().for_each(|key| *key *= 1000.0)
    }),
    wrong("the root stays", |scene| {
        let first = root(scene)[0];
        root(scene).fill(first);
    }),
    wrong("the root without its height", |scene| {
        root(scene).iter_mut().for_each(|key| key.y = 0.0)
    }),
    wrong("X and Z of the root exchanged", |scene| {
        root(scene)
            .iter_mut()
            .for_each(|key| *key = Vec3::new(key.z, key.y, key.x));
    }),
    wrong("a drift", |scene| {
        root(scene)
            .iter_mut()
            .enumerate()
            .for_each(|(frame, key)| key.z += 2e-4 * frame as f32);
    }),
    wrong("the path mirrored", |scene| {
        root(scene).iter_mut().for_each(|key| key.x = -key.x)
    }),
    wrong("the root rounded to centimetres", |scene| {
        root(scene)
            .iter_mut()
            .for_each(|key| *key = (*key * 100.0).round() / 100.0);
    }),
    wrong("one key of a rotation, X", |scene| {
        turn(scene, "LeftUpLeg", 40..41, Quat::from_rotation_x(TURN))
    }),
    wrong("one key of a rotation, Y", |scene| {
        turn(scene, "Spine", 3..4, Quat::from_rotation_y(TURN))
    }),
    wrong("one key of a rotation, Z", |scene| {
        turn(scene, "RightArm", 74..75, Quat::from_rotation_z(TURN))
    }),
    wrong("a forearm rolled, and its hand rolled back", |scene| {
        let hand = node(scene, "LeftHand").transform.w_axis.truncate();
        let about_itself = Quat::from_axis_angle(hand.normalize(), TURN);
        turn(scene, "LeftForeArm", 30..40, about_itself);
        for key in &mut channel(scene, "LeftHand").rotation_keys.values[30..40] {
            *key = about_itself.inverse() * *key;
        }
    }),
    wrong("the first key of a rotation", |scene| {
        turn(scene, "Hips", 0..1, Quat::from_rotation_x(TURN))
    }),
    wrong("a rotation at all times", |scene| {
        turn(scene, "LeftForeArm", 0..75, Quat::from_rotation_z(TURN))
    }),
    wrong("the heading", |scene| {
        let about_up = Quat::from_rotation_y(TURN);
        keys(
            scene,
            |path| path.iter_mut().for_each(|key| *key = about_up * *key),
            |_| (),
        );
        channel(scene, "Hips")
            .rotation_keys
            .values
            .iter_mut()
            .for_each(|key| *key = about_up * *key);
    }),
    wrong("facing backwards in place", |scene| {
        let about_up = Quat::from_rotation_y(std::f32::consts::PI);
        channel(scene, "Hips")
            .rotation_keys
            .values
            .iter_mut()
            .for_each(|key| *key = about_up * *key);
    }),
    wrong("lying on the ground", |scene| {
        let aside = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        keys(
            scene,
            |path| path.iter_mut().for_each(|key| *key = aside * *key),
            |_| (),
        );
        channel(scene, "Hips")
            .rotation_keys
            .values
            .iter_mut()
            .for_each(|key| *key = aside * *key);
    }),
    wrong("a rotation the other way round", |scene| {
        channel(scene, "RightArm")
            .rotation_keys
            .values
            .iter_mut()
            .for_each(|key| *key = key.inverse());
    }),
    wrong("all rotations the other way round", |scene| {
        keys(
            scene,
            |_| (),
            |turns| turns.iter_mut().for_each(|key| *key = key.inverse()),
        );
    }),
    wrong("the order of Euler angles mistaken", |scene| {
        use mocap::glam::EulerRot;
        for key in &mut channel(scene, "LeftUpLeg").rotation_keys.values {
            let (a, b, c) = key.to_euler(EulerRot::ZXY);
            *key = Quat::from_euler(EulerRot::XYZ, b, c, a);
        }
    }),
    wrong("degrees taken for radians", |scene| {
        for key in &mut channel(scene, "LeftUpLeg").rotation_keys.values {
            let (axis, angle) = key.to_axis_angle();
            *key = Quat::from_axis_angle(axis, angle.to_degrees());
        }
    }),
    wrong("half of each rotation", |scene| {
        keys(
            scene,
            |_| (),
            |turns| turns.iter_mut().for_each(|key| *key = Quat::IDENTITY.slerp(*key, 0.5)),
        );
    }),
    wrong("jitter", |scene| {
        keys(
            scene,
            |_| (),
            |turns| {
                let steps = turns.iter_mut().enumerate();
                steps.for_each(|(frame, key)| *key *= Quat::from_rotation_x(if frame % 2 == 0 { 0.03 } else { -0.03 }));
            },
        );
    }),
    wrong("a joint stays at rest", |scene| {
        channel(scene, "LeftUpLeg").rotation_keys.values.fill(Quat::IDENTITY);
    }),
    wrong("a joint keeps its first rotation", |scene| {
        let turns = &mut channel(scene, "LeftUpLeg").rotation_keys.values;
        let first = turns[0];
        turns.fill(first);
    }),
    wrong("a channel is missing", |scene| {
        clip(scene).channels.retain(|channel| channel.node_name != "LeftUpLeg")
    }),
    wrong("only the root moves", |scene| {
        clip(scene).channels.retain(|channel| channel.node_name == "Hips")
    }),
    wrong("only the root does not move", |scene| {
        clip(scene).channels.retain(|channel| channel.node_name != "Hips")
    }),
    wrong("channels of two joints exchanged", |scene| {
        let left = channel(scene, "LeftUpLeg").rotation_keys.clone();
        let right = std::mem::replace(&mut channel(scene, "RightUpLeg").rotation_keys, left);
        channel(scene, "LeftUpLeg").rotation_keys = right;
    }),
    wrong("a frame doubled, the next lost", |scene| {
        keys(scene, |path| path[31] = path[30], |turns| turns[31] = turns[30]);
    }),
    wrong("two frames exchanged", |scene| {
        keys(scene, |path| path.swap(20, 30), |turns| turns.swap(20, 30))
    }),
    wrong("all frames a frame late", |scene| {
        keys(scene, |path| path.rotate_right(1), |turns| turns.rotate_right(1))
    }),
    wrong("one joint a frame late", |scene| {
        channel(scene, "LeftUpLeg").rotation_keys.values.rotate_right(1)
    }),
    wrong("backwards", |scene| {
        keys(scene, |path| path.reverse(), |turns| turns.reverse())
    }),
    wrong("the last half is the first", |scene| {
        keys(
            scene,
            |path| path.copy_within(0..37, 38),
            |turns| turns.copy_within(0..37, 38),
        );
    }),
    wrong("it holds the last frames", |scene| {
        keys(scene, |path| path.truncate(65), |turns| turns.truncate(65));
    }),
    wrong("smoothed", |scene| {
        keys(
            scene,
            |_| (),
            |turns| {
                let before = turns.clone();
                (5..70).for_each(|frame| turns[frame] = before[frame - 5].slerp(before[frame + 5], 0.5));
            },
        );
    }),
    wrong("the last frame lost", |scene| {
        unsaid(scene, |scene| scene.trim(0.0, 73.0))
    }),
    wrong("the first frame lost", |scene| {
        unsaid(scene, |scene| scene.trim(1.0, 74.0))
    }),
    wrong("the first half", |scene| unsaid(scene, |scene| scene.trim(0.0, 37.0))),
    wrong("one frame", |scene| unsaid(scene, |scene| scene.trim(0.0, 0.0))),
    wrong("a tenth slower", |scene| clip(scene).ticks_per_second *= 0.9),
    wrong("twice as fast", |scene| clip(scene).ticks_per_second *= 2.0),
    wrong("30 frames a second for 120", |scene| {
        clip(scene).ticks_per_second = 30.0
    }),
    wrong("no motion", |scene| scene.animations.clear()),
    wrong("a longer thigh", |scene| {
        let knee = node(scene, "LeftLeg");
        knee.transform.w_axis = (knee.transform.w_axis.truncate() * 1.05).extend(1.0);
        channel(scene, "LeftLeg")
            .position_keys
            .values
            .iter_mut()
            .for_each(|key| *key *= 1.05);
    }),
    wrong("a tenth larger", |scene| lengthen(scene, 1.1)),
    wrong("a figure and its path, larger by two thousandths", |scene| {
        lengthen(scene, 1.002)
    }),
    wrong("twice as large", |scene| lengthen(scene, 2.0)),
    wrong("a toe elsewhere", |scene| {
        node(scene, "EndSite_LeftToeBase").transform.w_axis.x += 0.05
    }),
    wrong("a joint renamed", |scene| rename(scene, "Head", "Kopf")),
    wrong("left and right exchanged by name", |scene| {
        rename(scene, "LeftUpLeg", "swap");
        rename(scene, "RightUpLeg", "LeftUpLeg");
        rename(scene, "swap", "RightUpLeg");
    }),
    wrong("an end site is missing", remove_last),
    wrong("a joint is missing", |scene| {
        remove_last(scene);
        remove_last(scene);
    }),
    wrong("another parent", |scene| {
        let hips = scene.nodes.iter().position(|node| node.name == "Hips").unwrap();
        let last = scene
            .nodes
            .iter()
            .rposition(|node| node.kind == NodeKind::Joint)
            .unwrap();
        scene.nodes[last].parent = Some(NodeId::new(hips));
    }),
    wrong("another clip", |scene| {
        let mut other = clip(scene).clone();
        other.name = "other".to_owned();
        scene.animations.push(other);
    }),
    wrong("turned on its side at rest", |scene| {
        scene.nodes[0].transform = Mat4::from_rotation_z(TURN) * scene.nodes[0].transform;
        channel(scene, "Hips")
            .rotation_keys
            .values
            .iter_mut()
            .for_each(|key| *key = Quat::from_rotation_z(TURN) * *key);
    }),
    wrong("Z up for Y up", |scene| {
        unsaid(scene, |scene| scene.convert_units(1.0, UpAxis::Z))
    }),
];

/// Removes the last node, which has no descendants.
fn remove_last(scene: &mut Scene) {
    let last = scene.nodes.len() - 1;
    let name = scene.nodes.remove(last).name;
    clip(scene).channels.retain(|channel| channel.node_name != name);
    for mesh in &mut scene.meshes {
        mesh.bones.retain(|bone| bone.node.index() != last);
    }
}

/// A step that the file does not record.
fn unsaid(scene: &mut Scene, step: impl Fn(&mut Scene)) {
    let steps = scene.metadata.steps.clone();
    step(scene);
    scene.metadata.steps = steps;
}
