//! Reads a robot from URDF.

use std::collections::HashMap;

use glam::{DQuat, DVec3, EulerRot};
use mocap_scene::error::{Code, Diagnostic, Result, nearest};
use mocap_scene::limits::Limits;
use mocap_scene::scene::report::{DataKind, DataLoss};
use mocap_scene::scene::robot::{
    Inertial, JointKind, JointLimits, Placement, Robot, RobotJoint, RobotLink, RobotShape, ShapeKind,
};
use mocap_scene::scene::{Format, Scene};

use crate::inertial;
use crate::mesh_bounds::mesh_shape;
use crate::mimic::{self, MimicNames};
use crate::text::{LineIndex, quote};
use crate::warnings::Warnings;
use crate::xml::{self, Element};
use crate::{Failure, ReadOptions, Source};

/// The elements that describe the robot itself.
const PARTS: [&str; 3] = ["link", "joint", "material"];

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    crate::robot_as_scene::read(source, options, read_robot)
}

/// The robot of a file.
pub(crate) fn read_robot(source: &Source<'_>, limits: &Limits, warnings: &mut Warnings) -> Result<Robot, Failure> {
    let text = xml::text(source.bytes)?;
    let document = xml::parse(&text, &["robot"], limits)?;
    let root = Element::root(&document);
    let reader = Reader {
        source,
        limits,
        lines: LineIndex::new(text.as_bytes()),
    };
    if let Some(macros) = root.child_of_namespace("xacro") {
        let name = macros.name();
        let found = format!("<xacro:{}>", name.strip_prefix("xacro_").unwrap_or(name));
        let help = "run `xacro FILE > robot.urdf` (xacro comes with ROS or `pip install xacro`), then pass robot.urdf";
        if is_template(&root) {
            let message = "the file is a xacro template, which must be expanded to a robot first";
            return Err(Box::new(
                macros
                    .diagnostic(Code::InvalidRobot, message)
                    .expected_found("<link> and <joint>", found)
                    .help(help),
            ));
        }
        warnings.push(Code::UnreadExtension, || {
            let message = format!("{found} belongs to xacro, not to the robot; it was ignored");
            macros
                .diagnostic(Code::UnreadExtension, message)
                .help(format!("if the robot lacks a part, {help}"))
        });
    }
    let (links, names) = reader.links(&root, warnings)?;
    let joints = reader.joints(&root, &names, warnings)?;
    let mut mimics: Vec<MimicNames<'_, '_>> = joints
        .iter()
        .filter_map(|tie| read_mimic(tie).transpose())
        .collect::<Result<_, _>>()?;
    let mut links = tree(&root, links, joints, limits)?;
    mimics.retain(|mimic| mimic.has_leader(&links, warnings));
    mimic::tie(&mut links, &mimics)?;
    let name = root.attribute("name").unwrap_or_default();
    // `<gazebo>`, `<transmission>`, `<ros2_control>`, ... belong to programs that drive or draw the robot.
    let others = root.children().filter(|child| !PARTS.contains(&child.name()));
    let materials = root.descendants().filter(|element| element.name() == "material");
    Ok(Robot {
        lost: vec![
            DataLoss::new(DataKind::Materials, materials.count() as u64),
            DataLoss::new(DataKind::Extras, others.count() as u64),
        ],
        name: root.checked_name("name", name, limits)?,
        links,
        format: Some(Format::Urdf),
        warnings: Vec::new(),
    })
}

/// Whether a file with xacro elements is a template that must first be expanded to a robot. A template has no joint, or
/// an expression such as `${length}` in place of a value.
fn is_template(root: &Element<'_, '_>) -> bool {
    let parts = || root.children().filter(|child| matches!(child.name(), "link" | "joint"));
    let is_expression = |element: Element<'_, '_>| element.attributes().any(|(_, value)| value.contains("${"));
    parts().all(|part| part.name() != "joint") || parts().any(|part| part.descendants().any(is_expression))
}

struct Reader<'a> {
    source: &'a Source<'a>,
    limits: &'a Limits,
    lines: LineIndex,
}

/// A joint with its parent and child links.
struct JointElement<'a, 'input> {
    element: Element<'a, 'input>,
    parent: usize,
    child: usize,
    joint: RobotJoint,
}

impl Reader<'_> {
    fn links<'a>(
        &self,
        root: &Element<'a, '_>,
        warnings: &mut Warnings,
    ) -> Result<(Vec<RobotLink>, HashMap<&'a str, usize>), Failure> {
        let mut links = Vec::new();
        let mut names = HashMap::new();
        for element in root.all("link") {
            let name = element.required("name")?;
            if links.len() == self.limits.max_nodes {
                let message = format!("the robot has more than {} links", self.limits.max_nodes);
                return Err(Box::new(element.diagnostic(Code::LimitExceeded, message)));
            }
            if names.insert(name, links.len()).is_some() {
                let message = format!("two links are called {}", quote(name.as_bytes()));
                return Err(Box::new(
                    element
                        .at_attribute("name", Code::InvalidRobot, message)
                        .help("rename one of them"),
                ));
            }
            let collisions = element.all("collision").map(|shape| (shape, true));
            let visuals = element.all("visual").map(|shape| (shape, false));
            let shapes = collisions.chain(visuals);
            let shapes = shapes.map(|(shape, collides)| self.shape(&shape, collides, warnings));
            let shapes = shapes.filter_map(Result::transpose).collect::<Result<_, _>>()?;
            links.push(RobotLink {
                name: element.checked_name("name", name, self.limits)?,
                inertial: match element.child("inertial") {
                    Some(inertial) => read_inertial(&inertial, name, warnings)?,
                    None => None,
                },
                shapes,
                line: self.lines.line(element.offset().unwrap_or_default()),
                ..RobotLink::default()
            });
        }
        if links.is_empty() {
            let message = "the robot has no <link>";
            return Err(Box::new(root.diagnostic(Code::InvalidRobot, message)));
        }
        Ok((links, names))
    }

    fn joints<'a, 'input>(
        &self,
        root: &Element<'a, 'input>,
        links: &HashMap<&str, usize>,
        warnings: &mut Warnings,
    ) -> Result<Vec<JointElement<'a, 'input>>, Failure> {
        let mut ties = Vec::new();
        let mut names = HashMap::new();
        for element in root.all("joint") {
            let name = element.required("name")?;
            if names.insert(name, ()).is_some() {
                let message = format!("two joints are called {}", quote(name.as_bytes()));
                return Err(Box::new(
                    element
                        .at_attribute("name", Code::InvalidRobot, message)
                        .help("rename one of them"),
                ));
            }
            let end = |tag: &'static str| -> Result<usize, Failure> {
                let end = element.child(tag).ok_or_else(|| {
                    let message = format!("the joint has no <{tag}>");
                    Box::new(element.diagnostic(Code::MissingKeyword, message).in_joint(name))
                })?;
                let link = end.required("link")?;
                links.get(link).copied().ok_or_else(|| {
                    let message = format!("no <link> is called {}", quote(link.as_bytes()));
                    let unknown = end.at_attribute("link", Code::InvalidRobot, message).in_joint(name);
                    Box::new(match nearest(link, links.keys().copied()) {
                        Some(near) => unknown.help(format!("did you mean {near}?")),
                        None => unknown,
                    })
                })
            };
            let joint = read_joint(&element, self.limits, warnings)?;
            ties.push(JointElement {
                element,
                parent: end("parent")?,
                child: end("child")?,
                joint,
            });
        }
        Ok(ties)
    }

    fn shape(
        &self,
        element: &Element<'_, '_>,
        collides: bool,
        warnings: &mut Warnings,
    ) -> Result<Option<RobotShape>, Failure> {
        let origin = origin(element)?;
        let Some(geometry) = element.child("geometry") else {
            return Ok(None);
        };
        let positive = |element: &Element<'_, '_>, name: &str| -> Result<f64, Failure> {
            element.required(name)?;
            Ok(element.number(name)?.unwrap_or_default().abs())
        };
        let Some(shape) = geometry.children().next() else {
            return Ok(None);
        };
        let kind = match shape.name() {
            "sphere" => ShapeKind::Sphere {
                radius: positive(&shape, "radius")?,
            },
            "cylinder" => ShapeKind::Cylinder {
                radius: positive(&shape, "radius")?,
                half_length: 0.5 * positive(&shape, "length")?,
            },
            "capsule" => ShapeKind::Capsule {
                radius: positive(&shape, "radius")?,
                half_length: 0.5 * positive(&shape, "length")?,
            },
            "box" => {
                shape.required("size")?;
                ShapeKind::Box {
                    half_size: 0.5 * shape.vector("size")?.unwrap_or_default().abs(),
                }
            }
            "mesh" => {
                let file = shape.required("filename")?;
                let scale = shape.vector("scale")?.unwrap_or(DVec3::ONE);
                mesh_shape(self.source, "", file, scale, warnings)
            }
            _ => return Ok(None),
        };
        Ok(Some(RobotShape { origin, kind, collides }))
    }
}

/// The `<origin>` of an element. If the element has no `<origin>`, the identity.
fn origin(element: &Element<'_, '_>) -> Result<Placement, Failure> {
    let Some(origin) = element.child("origin") else {
        return Ok(Placement::IDENTITY);
    };
    let angles = origin.vector("rpy")?.unwrap_or_default();
    Ok(Placement {
        rotation: DQuat::from_euler(EulerRot::ZYX, angles.z, angles.y, angles.x),
        translation: origin.vector("xyz")?.unwrap_or_default(),
    })
}

fn read_inertial(element: &Element<'_, '_>, link: &str, warnings: &mut Warnings) -> Result<Option<Inertial>, Failure> {
    let Some(mass) = element.child("mass") else {
        return Ok(None);
    };
    let mut inertia = [0.0; 6];
    if let Some(tensor) = element.child("inertia") {
        for (value, name) in inertia.iter_mut().zip(["ixx", "iyy", "izz", "ixy", "ixz", "iyz"]) {
            *value = tensor.number(name)?.unwrap_or_default();
        }
    }
    let stated = Inertial {
        mass: mass.number("value")?.unwrap_or_default(),
        origin: origin(element)?,
        inertia,
    };
    Ok(inertial::possible(stated, link, element, warnings))
}

fn read_joint(element: &Element<'_, '_>, limits: &Limits, warnings: &mut Warnings) -> Result<RobotJoint, Failure> {
    let name = element.required("name")?;
    let kind = match element.required("type")? {
        "revolute" | "continuous" => JointKind::Hinge,
        "prismatic" => JointKind::Slide,
        "fixed" => JointKind::Fixed,
        "floating" => JointKind::Floating,
        kind @ ("planar" | "spherical") => {
            warnings.push(Code::IgnoredChannel, || {
                let message = format!("{kind} joints are not supported: the joint does not move");
                element.diagnostic(Code::IgnoredChannel, message).in_joint(name)
            });
            JointKind::Fixed
        }
        other => {
            return Err(Box::new(
                element
                    .at_attribute("type", Code::UnexpectedToken, "the type of a joint is not known")
                    .in_joint(name)
                    .expected_found(
                        "revolute, continuous, prismatic, fixed, floating or planar",
                        quote(other.as_bytes()),
                    ),
            ));
        }
    };
    let moves = matches!(kind, JointKind::Hinge | JointKind::Slide);
    let axis = match element.child("axis").filter(|_| moves) {
        Some(axis) => {
            axis.required("xyz")?;
            let along = axis.vector("xyz")?.unwrap_or_default();
            along.try_normalize().ok_or_else(|| {
                let message = "the axis of a joint has no length";
                Box::new(
                    axis.at_attribute("xyz", Code::InvalidRobot, message)
                        .in_joint(name)
                        .expected_found(
                            "a direction such as 0 1 0",
                            quote(axis.attribute("xyz").unwrap_or_default().as_bytes()),
                        ),
                )
            })?
        }
        None => DVec3::X,
    };
    let mut joint = RobotJoint {
        name: element.checked_name("name", name, limits)?,
        kind,
        origin: origin(element)?,
        anchor: DVec3::ZERO,
        axis,
        limits: JointLimits::default(),
        armature: 0.0,
        mimic: None,
    };
    if let Some(limit) = element.child("limit").filter(|_| moves) {
        let positive = |name: &str| Ok::<_, Failure>(limit.number(name)?.filter(|value| *value > 0.0));
        joint.limits.velocity = positive("velocity")?;
        joint.limits.effort = positive("effort")?;
        if element.attribute("type") != Some("continuous") {
            joint.limits.lower = limit.number("lower")?.unwrap_or(0.0);
            joint.limits.upper = limit.number("upper")?.unwrap_or(0.0);
        }
        if joint.limits.lower > joint.limits.upper {
            let stated = (joint.limits.lower, joint.limits.upper);
            (joint.limits.upper, joint.limits.lower) = stated;
            warnings.push(Code::InvalidRobot, || {
                let message = "the lower limit of a joint is above the upper limit; mocap swapped the limits";
                limit
                    .at_attribute("lower", Code::InvalidRobot, message)
                    .in_joint(name)
                    .expected_found(
                        "a lower limit that is at most the upper limit",
                        format!("{} and {}", stated.0, stated.1),
                    )
            });
        }
    }
    Ok(joint)
}

/// The `<mimic>` of a moving joint.
fn read_mimic<'a, 'input>(tie: &JointElement<'a, 'input>) -> Result<Option<MimicNames<'a, 'input>>, Failure> {
    let Some(element) = tie.element.child("mimic").filter(|_| tie.joint.moves()) else {
        return Ok(None);
    };
    Ok(Some(MimicNames {
        element,
        attribute: "joint",
        follower: tie.joint.name.clone(),
        leader: element.required("joint")?.to_owned(),
        multiplier: element.number("multiplier")?.unwrap_or(1.0),
        offset: element.number("offset")?.unwrap_or_default(),
    }))
}

/// The links in depth-first order, each with its joint.
fn tree(
    root: &Element<'_, '_>,
    mut links: Vec<RobotLink>,
    ties: Vec<JointElement<'_, '_>>,
    limits: &Limits,
) -> Result<Vec<RobotLink>, Failure> {
    let mut carried: Vec<Option<usize>> = vec![None; links.len()];
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    for (index, tie) in ties.iter().enumerate() {
        if let Some(other) = carried[tie.child].replace(index) {
            let (link, other) = (
                quote(links[tie.child].name.as_bytes()),
                quote(ties[other].joint.name.as_bytes()),
            );
            let message = format!("the link {link} is the child of two joints");
            return Err(Box::new(
                tie.element
                    .diagnostic(Code::InvalidRobot, message)
                    .in_joint(tie.joint.name.as_str())
                    .expected_found("one joint for each link", format!("also {other}")),
            ));
        }
        children[tie.parent].push(index);
    }
    let roots: Vec<usize> = (0..links.len()).filter(|link| carried[*link].is_none()).collect();
    let base = match roots[..] {
        [base] => base,
        [] => {
            let message = "the joints form a circle: every link is the child of a joint";
            return Err(Box::new(root.diagnostic(Code::InvalidRobot, message)));
        }
        [first, second, ..] => {
            let message = format!(
                "the robot has several bases: {} and {} are not children of a joint",
                quote(links[first].name.as_bytes()),
                quote(links[second].name.as_bytes())
            );
            return Err(Box::new(
                root.diagnostic(Code::InvalidRobot, message)
                    .help("connect them with a joint, or remove the unused one"),
            ));
        }
    };
    let count = links.len();
    let mut ties: Vec<Option<JointElement<'_, '_>>> = ties.into_iter().map(Some).collect();
    let mut ordered: Vec<RobotLink> = Vec::with_capacity(count);
    // The link, the new index of its parent, its joint, and its depth.
    let mut waiting = vec![(base, None, None, 1_usize)];
    while let Some((link, parent, joint, depth)) = waiting.pop() {
        if depth > limits.max_depth {
            let message = format!("the links are nested more than {} deep", limits.max_depth);
            return Err(Box::new(Diagnostic::new(Code::LimitExceeded, message)));
        }
        let here = ordered.len();
        ordered.push(RobotLink {
            parent,
            joint: joint.unwrap_or_default(),
            ..std::mem::take(&mut links[link])
        });
        for &child in children[link].iter().rev() {
            if let Some(tie) = ties[child].take() {
                waiting.push((tie.child, Some(here), Some(tie.joint), depth + 1));
            }
        }
    }
    if ordered.len() < count {
        let message = "some joints form a circle: their links are not connected to the base";
        let left = ties.into_iter().flatten().next();
        let at = match &left {
            Some(tie) => tie
                .element
                .diagnostic(Code::InvalidRobot, message)
                .in_joint(tie.joint.name.as_str()),
            None => root.diagnostic(Code::InvalidRobot, message),
        };
        return Err(Box::new(at));
    }
    Ok(without_world(ordered))
}

/// Removes a base without mass whose only child is connected by a floating joint: the base is the world, not a part of
/// the robot.
fn without_world(mut links: Vec<RobotLink>) -> Vec<RobotLink> {
    let floats = links.get(1).is_some_and(|link| link.joint.kind == JointKind::Floating);
    let carries_one = links.iter().skip(2).all(|link| link.parent != Some(0));
    if floats && carries_one && links[0].inertial.is_none() {
        links.remove(0);
        for link in &mut links {
            link.parent = link.parent.and_then(|parent| parent.checked_sub(1));
        }
    }
    links
}
