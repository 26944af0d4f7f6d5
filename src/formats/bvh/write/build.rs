//! Writes the text: the hierarchy, then one row per frame.

use std::fmt::Write;

use glam::{DVec3, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::files::FilePart;
use mocap_scene::limits::{self, FARTHEST, is_plausible};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{Animation, Format, NodeKind, RotationOrder, Scene};

use super::angles::Angles;
use super::motion::Motion;
use super::number::{push, push_single, shortest};
use super::scales::places;
use crate::bvh::{BvhOptions, Channels};
use crate::report::NodeRename;
use crate::unique_names::{UniqueNames, is_separator};

/// The rotation order for joints that have none. Most programs write this order.
const USUAL_ORDER: RotationOrder = RotationOrder::Zxy;

/// The frame rate of a file with only a rest pose, in frames per second.
const POSE_FRAME_RATE: f64 = 30.0;

/// The length in bytes of a part of the text. Parts are packed, because a long text would take more memory than its
/// scene.
const PART: usize = 1 << 20;

/// The text in parts, and the renamed nodes.
pub(super) fn text(scene: &Scene, options: &BvhOptions) -> Result<(Vec<FilePart<'static>>, Vec<NodeRename>)> {
    let motion = Motion::new(scene);
    let joints = joints(&motion, options)?;
    let (heads, renamed) = heads(scene, &joints);
    let frames = motion.animation.map_or(1, Animation::frame_count);
    let mut text = String::from("HIERARCHY\n");
    push_hierarchy(&mut text, &joints, &heads, options);
    let _ = writeln!(text, "MOTION\nFrames: {frames}");
    text.push_str("Frame Time: ");
    let frame_rate = motion
        .animation
        .map_or(POSE_FRAME_RATE, |animation| animation.ticks_per_second);
    let frame_rate = limits::frame_rate(Code::FrameTime, frame_rate)?;
    let frame_time = frame_rate.recip();
    let shortest = shortest([frame_time], |[seconds]| seconds.recip() == frame_rate);
    push(&mut text, shortest.map_or(frame_time, |[seconds]| seconds), None);
    text.push('\n');
    let mut parts = Vec::new();
    push_rows((&mut text, &mut parts), &motion, &joints, frames, options)?;
    parts.push(text.into_bytes().into());
    Ok((parts, renamed))
}

/// The form in which one node is written.
pub(super) struct Joint<'a> {
    #[doc(hidden)]
    pub name: &'a str,
    /// The index of the node.
    #[doc(hidden)]
    pub node: usize,
    is_end_site: bool,
    /// The number of nodes from the first written node to this node.
    depth: usize,
    pub(super) offset: Vec3,
    /// The product of the ancestors' scales.
    scale: Vec3,
    /// Whether the node has position channels.
    pub(super) moves: bool,
    /// Whether the node has rotation channels.
    pub(super) turns: bool,
    order: RotationOrder,
}

impl Joint<'_> {
    /// The position relative to the parent, which has no scale in BVH. `places` is the result of [`places`].
    pub(super) fn position(&self, transform: &Trs, places: Option<&[Vec<Vec3>]>, frame: usize) -> Vec3 {
        match places {
            Some(places) => places[frame][self.node],
            None => self.scale * transform.translation,
        }
    }
}

/// The nodes in order, with the form of each in the hierarchy.
pub(super) fn joints<'a>(motion: &Motion<'a>, options: &BvhOptions) -> Result<Vec<Joint<'a>>> {
    let first = motion.first;
    let places = places(motion);
    // Some programs add position channels to the OFFSET, others replace it. Scenes from other formats are written so
    // that both kinds of programs give the same result. A BVH file keeps its OFFSETs.
    let keeps_offsets = motion.scene.metadata.format == Some(Format::Bvh);
    let rest = motion.rest();
    let mut start = rest.clone();
    motion.sample(0, &mut start);
    let mut joints: Vec<Joint<'_>> = Vec::with_capacity(rest.len());
    let mut holds_nodes = vec![false; rest.len()];
    for parent in motion.scene.nodes.iter().filter_map(|node| node.parent) {
        holds_nodes[parent.index()] = true;
    }
    for index in motion.written() {
        let node = &motion.scene.nodes[index];
        let parent = motion.parent(index).map(|parent| parent - first);
        let above = parent.map(|parent| &joints[parent]);
        let scale = above.map_or(Vec3::ONE, |above| above.scale * start[above.node].scale);
        let offset = scale * rest[index].translation;
        // In BVH an End Site has no children, and its parent is a joint.
        let is_end_site = node.kind == NodeKind::EndSite && !holds_nodes[index] && parent.is_some();
        let channel = motion.channels[index];
        let is_animated = node.kind == NodeKind::Joint || channel.is_some() || rest[index].rotation != Quat::IDENTITY;
        let begins = match &places {
            Some(places) => places[0][index],
            None => scale * start[index].translation,
        };
        let point = if keeps_offsets { offset } else { begins };
        let leaves_offset = || match &places {
            Some(places) => places.iter().any(|places| is_elsewhere(places[index], point)),
            None => {
                let positions = channel.map(|channel| channel.position_keys.values.as_slice());
                let mut positions = positions.unwrap_or_default().iter();
                positions.any(|&position| scale * position != point)
            }
        };
        let moves = !is_end_site
            && match options.channels {
                Channels::Auto => parent.is_none() || leaves_offset(),
                Channels::Three => parent.is_none(),
                Channels::Six => parent.is_none() || is_animated,
            };
        let joint = Joint {
            name: &node.name,
            node: index,
            is_end_site,
            depth: above.map_or(0, |above| above.depth + 1),
            offset: match parent.is_none() && !keeps_offsets {
                true => Vec3::ZERO,
                false => {
                    let stays = match &places {
                        Some(places) => places.iter().all(|places| is_near_zero(places[index], offset)),
                        None => channel.is_some_and(|channel| {
                            let mut keys = channel.position_keys.values.iter();
                            keys.all(|key| is_near_zero(scale * *key, offset))
                        }),
                    };
                    written_offset(offset, begins, moves, parent.is_none() || stays)
                }
            },
            scale,
            moves,
            turns: !is_end_site && is_animated,
            order: options.order.or(node.rotation_order).unwrap_or(USUAL_ORDER),
        };
        if !joint.offset.abs().as_dvec3().cmple(DVec3::splat(FARTHEST)).all() {
            let message = format!("the position in the rest pose is not finite, or not below {FARTHEST:e}");
            return Err(unrepresentable(&joint, message));
        }
        joints.push(joint);
    }
    if joints.is_empty() {
        return Err(Diagnostic::new(Code::Unrepresentable, "the scene has no nodes, so it has no skeleton").into());
    }
    Ok(joints)
}

/// Whether a position differs from a point by more than the rounding of products.
fn is_elsewhere(position: Vec3, point: Vec3) -> bool {
    /// The largest rounding difference, as a fraction of the longer vector.
    const ROUNDING: f32 = 1e-6;
    position.distance(point) > ROUNDING * position.length().max(point.length())
}

/// The OFFSET of a joint. A joint without position channels gets the position of its first frame.
///
/// Some programs add certain positions to the OFFSET. They add the positions of a joint whose positions are all near
/// zero. They also add the positions of a root that starts near zero, although its OFFSET is not near zero. With a zero
/// OFFSET all programs agree.
fn written_offset(offset: Vec3, start: Vec3, moves: bool, is_root_or_stays: bool) -> Vec3 {
    if !moves {
        start
    } else if is_near_zero(start, offset) && is_root_or_stays {
        Vec3::ZERO
    } else {
        offset
    }
}

/// Whether a reader may take a position for a displacement from the OFFSET.
fn is_near_zero(position: Vec3, offset: Vec3) -> bool {
    /// The fraction of the OFFSET's length below which a reader may take a position for a displacement. This fraction
    /// is larger than the fractions in this crate's reader.
    const NEAR_ZERO: f32 = 0.06;
    position.abs().max_element() <= NEAR_ZERO * offset.length()
}

fn push_hierarchy(text: &mut String, joints: &[Joint<'_>], heads: &[String], options: &BvhOptions) {
    let mut open = 0;
    for (joint, head) in std::iter::zip(joints, heads) {
        while open > joint.depth {
            open -= 1;
            push_line(text, open, "}");
        }
        push_line(text, open, head);
        push_line(text, open, "{");
        open += 1;
        text.extend(std::iter::repeat_n('\t', open));
        text.push_str("OFFSET");
        for component in joint.offset.to_array() {
            text.push(' ');
            push_single(text, component, options.digits);
        }
        text.push('\n');
        if !joint.is_end_site {
            push_line(text, open, &channels_line(joint));
        }
    }
    while open > 0 {
        open -= 1;
        push_line(text, open, "}");
    }
}

fn push_line(text: &mut String, indentation: usize, line: &str) {
    text.extend(std::iter::repeat_n('\t', indentation));
    text.push_str(line);
    text.push('\n');
}

/// The line `JOINT name` of each node, and the renamed nodes. Blender keeps only the last of several joints with one
/// name. A joint keeps its name even if a group has the same name. An end site with the default name is written without
/// a name.
fn heads(scene: &Scene, joints: &[Joint<'_>]) -> (Vec<String>, Vec<NodeRename>) {
    let (mut unique, mut renamed) = (UniqueNames::default(), Vec::new());
    let mut head = |joint: &Joint<'_>| {
        let keyword = match (joint.is_end_site, joint.depth) {
            (true, _) if joint.name.starts_with("EndSite_") => return "End Site".to_owned(),
            (true, _) => "End Site",
            (false, 0) => "ROOT",
            (false, _) => "JOINT",
        };
        // A name ends at a brace or at the end of its line. After `End Site` a `#` begins a comment.
        let ends_name = |c: char| is_separator(c) || matches!(c, '{' | '}') || (joint.is_end_site && c == '#');
        let name = unique.of_node(scene, joint.node, |c| !ends_name(c), str::to_owned, &mut renamed);
        format!("{keyword} {name}")
    };
    let is_group = |joint: &Joint<'_>| scene.nodes[joint.node].kind == NodeKind::Group;
    let mut heads = vec![String::new(); joints.len()];
    for groups in [false, true] {
        let these = std::iter::zip(&mut heads, joints).filter(|(_, joint)| is_group(joint) == groups);
        these.for_each(|(text, joint)| *text = head(joint));
    }
    (heads, renamed)
}

fn channels_line(joint: &Joint<'_>) -> String {
    let mut names = Vec::new();
    if joint.moves {
        names.extend(["X", "Y", "Z"].map(|axis| format!("{axis}position")));
    }
    if joint.turns {
        names.extend(
            joint
                .order
                .axes()
                .map(|axis| format!("{}rotation", ["X", "Y", "Z"][axis])),
        );
    }
    let mut line = format!("CHANNELS {}", names.len());
    for name in names {
        line.push(' ');
        line.push_str(&name);
    }
    line
}

fn push_rows(
    (text, parts): (&mut String, &mut Vec<FilePart<'static>>),
    motion: &Motion<'_>,
    joints: &[Joint<'_>],
    frames: usize,
    options: &BvhOptions,
) -> Result<()> {
    let is_shortest = options.digits.is_none();
    let mut angles: Vec<Angles> = joints
        .iter()
        .map(|joint| Angles::new(joint.order, is_shortest))
        .collect();
    let mut transforms = motion.rest();
    let places = places(motion);
    for frame in 0..frames {
        motion.sample(frame, &mut transforms);
        let start = text.len();
        for (joint, angles) in std::iter::zip(joints, &mut angles) {
            let transform = transforms[joint.node];
            if joint.moves {
                let position = joint.position(&transform, places.as_deref(), frame);
                if !position
                    .to_array()
                    .into_iter()
                    .all(|number| is_plausible(number.into()))
                {
                    let message = format!("the position in frame {frame} is not finite, or beyond {FARTHEST:e}");
                    return Err(unrepresentable(joint, message));
                }
                for component in position.to_array() {
                    push_single(text, component, options.digits);
                    text.push(' ');
                }
            }
            if joint.turns {
                let Some(angles) = angles.next(transform.rotation) else {
                    return Err(unrepresentable(
                        joint,
                        format!("the rotation in frame {frame} is not valid"),
                    ));
                };
                for angle in angles {
                    push(text, angle, options.digits);
                    text.push(' ');
                }
            }
        }
        if text.len() > start {
            text.pop();
        }
        text.push('\n');
        if text.len() > PART {
            parts.push(FilePart::numbers(text.as_bytes()));
            text.clear();
        }
    }
    Ok(())
}

fn unrepresentable(joint: &Joint<'_>, message: String) -> Error {
    Diagnostic::new(Code::Unrepresentable, message)
        .in_joint(joint.name)
        .into()
}
