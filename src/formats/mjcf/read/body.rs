//! Reads bodies with their joints and geometry.

use std::collections::HashSet;

use glam::{DQuat, DVec3};
use mocap_scene::error::Code;
use mocap_scene::limits::Limits;
use mocap_scene::scene::robot::{
    Inertial, JointKind, JointLimits, Placement, RobotJoint, RobotLink, RobotShape, ShapeKind,
};

use super::attributes::{Attributes, InertiaFromGeoms, Settings};
use super::frame::{BodyElement, within};
use super::mass::{Geoms, set_total};
use super::sizes;
use crate::inertial;
use crate::mesh_bounds::mesh_shape;
use crate::text::{LineIndex, quote};
use crate::warnings::Warnings;
use crate::xml::Element;
use crate::{Failure, Source};

/// Reads the bodies of a robot into links.
pub(super) struct Bodies<'a> {
    source: &'a Source<'a>,
    limits: &'a Limits,
    settings: &'a Settings,
    lines: LineIndex,
    links: Vec<RobotLink>,
    names: HashSet<String>,
}

/// A body that is not read yet.
struct Waiting<'a, 'input> {
    body: BodyElement<'a, 'input>,
    parent: Option<usize>,
    depth: usize,
}

impl<'a> Bodies<'a> {
    pub(super) fn new(source: &'a Source<'a>, limits: &'a Limits, settings: &'a Settings, text: &str) -> Self {
        Self {
            source,
            limits,
            settings,
            lines: LineIndex::new(text.as_bytes()),
            links: Vec::new(),
            names: HashSet::new(),
        }
    }

    pub(super) fn read(
        mut self,
        base: BodyElement<'_, '_>,
        warnings: &mut Warnings,
    ) -> Result<Vec<RobotLink>, Failure> {
        let mut waiting = vec![Waiting {
            body: base,
            parent: None,
            depth: 1,
        }];
        while let Some(next) = waiting.pop() {
            let BodyElement {
                element, child_class, ..
            } = next.body;
            if next.depth > self.limits.max_depth {
                let message = format!("the bodies are nested more than {} deep", self.limits.max_depth);
                return Err(Box::new(element.diagnostic(Code::LimitExceeded, message)));
            }
            let child_class = element.attribute("childclass").or(child_class);
            let mut inner = within(element, child_class, self.settings, self.limits)?;
            let link = self.body(&next, &inner, warnings)?;
            inner.retain(|inner| inner.element.name() == "body");
            waiting.extend(inner.into_iter().rev().map(|body| Waiting {
                body,
                parent: Some(link),
                depth: next.depth + 1,
            }));
        }
        if let Some(total) = self.settings.total_mass {
            set_total(self.links.iter_mut().filter_map(|link| link.inertial.as_mut()), total);
        }
        Ok(self.links)
    }

    fn push(&mut self, body: &Element<'_, '_>, link: RobotLink) -> Result<usize, Failure> {
        if self.links.len() >= self.limits.max_nodes {
            let message = format!("the robot has more than {} links", self.limits.max_nodes);
            return Err(Box::new(body.diagnostic(Code::LimitExceeded, message)));
        }
        self.links.push(link);
        Ok(self.links.len() - 1)
    }

    /// Adds the links of a body, one for each joint. Returns the last link, which is the body itself.
    fn body(
        &mut self,
        waiting: &Waiting<'_, '_>,
        inner: &[BodyElement<'_, '_>],
        warnings: &mut Warnings,
    ) -> Result<usize, Failure> {
        let body = &waiting.body.element;
        // The line of an included element in the main file is unknown.
        let line = body.offset().map_or(0, |offset| self.lines.line(offset));
        let unnamed = || format!("body_{}", self.links.len());
        let name = body.attribute("name").map_or_else(unnamed, str::to_owned);
        let name = body.checked_name("name", &name, self.limits)?;
        if !self.names.insert(name.clone()) {
            let message = format!("two bodies are called {}", quote(name.as_bytes()));
            return Err(Box::new(
                body.at_attribute("name", Code::InvalidRobot, message)
                    .help("rename one of them"),
            ));
        }
        let mut origin = waiting.body.frame.then(&self.settings.of(*body, None)?.origin()?);
        let mut joints = Vec::new();
        let of_kind =
            |kinds: &'static [&'static str]| inner.iter().filter(|inner| kinds.contains(&inner.element.name()));
        for inner in of_kind(&["joint", "freejoint"]) {
            let attributes = self.settings.of(inner.element, inner.child_class)?;
            self.joints(&attributes, &name, waiting.parent.is_none(), inner.frame, &mut joints)?;
        }
        // The base is at its root position, not where the file places the model. The base keeps the orientation in the
        // file.
        if waiting.parent.is_none() {
            origin.translation = DVec3::ZERO;
        }
        let last = joints.pop().unwrap_or_default();
        let mut parent = waiting.parent;
        for joint in joints {
            let link = RobotLink {
                name: format!("{name}/{}", joint.name),
                parent,
                joint: RobotJoint { origin, ..joint },
                line,
                ..RobotLink::default()
            };
            parent = Some(self.push(body, link)?);
            origin = Placement::IDENTITY;
        }
        let mut shapes = Vec::new();
        let mut geoms = Geoms::default();
        for inner in of_kind(&["geom"]) {
            let attributes = self.settings.of(inner.element, inner.child_class)?;
            let Some(shape) = self.shape(&attributes, warnings)? else {
                continue;
            };
            let shape = RobotShape {
                origin: inner.frame.then(&shape.origin),
                ..shape
            };
            geoms.add(&attributes, &shape, self.settings, &name, warnings)?;
            shapes.push(shape);
        }
        let by_geoms = self.settings.inertia_from_geoms;
        let stated = body.child("inertial").filter(|_| by_geoms != InertiaFromGeoms::Always);
        let inertial = match stated {
            Some(inertial) => {
                let stated = read_inertial(&self.settings.of(inertial, None)?)?;
                inertial::possible(stated, &name, &inertial, warnings)
            }
            None if by_geoms == InertiaFromGeoms::Never => None,
            None => geoms.inertial(),
        };
        let link = RobotLink {
            name,
            parent,
            joint: RobotJoint { origin, ..last },
            inertial,
            shapes,
            line,
        };
        self.push(body, link)
    }

    fn joints(
        &self,
        attributes: &Attributes<'_, '_>,
        body: &str,
        is_base: bool,
        frame: Placement,
        joints: &mut Vec<RobotJoint>,
    ) -> Result<(), Failure> {
        let element = attributes.element;
        let kind = match element.name() {
            "freejoint" => "free",
            _ => attributes.get("type").unwrap_or("hinge"),
        };
        let unnamed = || format!("{body}_joint_{}", joints.len());
        let name = element.attribute("name").map_or_else(unnamed, str::to_owned);
        let name = element.checked_name("name", &name, self.limits)?;
        let joint = RobotJoint {
            name,
            kind: JointKind::Hinge,
            origin: Placement::IDENTITY,
            anchor: frame.point(attributes.vector("pos")?.unwrap_or_default()),
            axis: DVec3::Z,
            limits: JointLimits::default(),
            armature: self.armature(attributes)?,
            mimic: None,
        };
        match kind {
            "free" if is_base => joints.push(RobotJoint {
                kind: JointKind::Floating,
                anchor: DVec3::ZERO,
                ..joint
            }),
            "free" => {
                let message = "a body within another has a free joint";
                return Err(Box::new(
                    element.diagnostic(Code::InvalidRobot, message).in_joint(joint.name),
                ));
            }
            "ball" => joints.extend(
                [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)].map(|(letter, axis)| RobotJoint {
                    name: format!("{}_{letter}", joint.name),
                    axis,
                    ..joint.clone()
                }),
            ),
            "hinge" | "slide" => {
                let axis = attributes
                    .vector("axis")?
                    .unwrap_or(DVec3::Z)
                    .try_normalize()
                    .ok_or_else(|| {
                        let message = "the axis of a joint has no length";
                        Box::new(
                            element
                                .at_attribute("axis", Code::InvalidRobot, message)
                                .in_joint(joint.name.as_str())
                                .expected_found("a direction such as 0 1 0", "0 0 0"),
                        )
                    })?;
                let is_hinge = kind == "hinge";
                joints.push(RobotJoint {
                    kind: if is_hinge { JointKind::Hinge } else { JointKind::Slide },
                    limits: self.limits_of(attributes, is_hinge)?,
                    axis: frame.rotation * axis,
                    ..joint
                });
            }
            other => {
                return Err(Box::new(
                    element
                        .at_attribute("type", Code::UnexpectedToken, "the type of a joint is not known")
                        .in_joint(joint.name)
                        .expected_found("hinge, slide, ball or free", quote(other.as_bytes())),
                ));
            }
        }
        Ok(())
    }

    fn armature(&self, attributes: &Attributes<'_, '_>) -> Result<f64, Failure> {
        let armature = attributes.numbers("armature", 1, 1)?;
        Ok(armature.map_or(0.0, |armature| armature[0].max(0.0)))
    }

    fn limits_of(&self, attributes: &Attributes<'_, '_>, is_hinge: bool) -> Result<JointLimits, Failure> {
        let mut limits = JointLimits::default();
        let range = attributes.numbers("range", 2, 2)?;
        let is_limited = match attributes.get("limited") {
            Some("true") => true,
            Some("false") => false,
            _ => self.settings.auto_limits,
        };
        if let Some(range) = range.filter(|_| is_limited) {
            let scale = if is_hinge { self.settings.angle } else { 1.0 };
            (limits.lower, limits.upper) = (scale * range[0], scale * range[1]);
            if limits.lower > limits.upper {
                let message = "the lower limit of a joint is above the upper limit";
                return Err(Box::new(
                    attributes
                        .element
                        .at_attribute("range", Code::InvalidRobot, message)
                        .expected_found(
                            "the lower limit and the upper limit",
                            format!("{} {}", range[0], range[1]),
                        ),
                ));
            }
        }
        if let Some(force) = attributes.numbers("actuatorfrcrange", 2, 2)? {
            limits.effort = Some(force[0].abs().max(force[1].abs())).filter(|force| *force > 0.0);
        }
        Ok(limits)
    }

    fn shape(&self, attributes: &Attributes<'_, '_>, warnings: &mut Warnings) -> Result<Option<RobotShape>, Failure> {
        let numbers = attributes.numbers("size", 1, 3)?.unwrap_or_default();
        let mut size = sizes(&numbers);
        let mut origin = attributes.origin()?;
        let default = if attributes.get("mesh").is_some() {
            "mesh"
        } else {
            "sphere"
        };
        let kind = attributes.get("type").unwrap_or(default);
        if let Some(ends) = attributes.numbers("fromto", 6, 6)? {
            let (from, to) = (DVec3::from_slice(&ends), DVec3::from_slice(&ends[3..]));
            origin.translation = 0.5 * (from + to);
            // In MuJoCo, Z points from the end to the start.
            if let Some(axis) = (from - to).try_normalize() {
                origin.rotation = DQuat::from_rotation_arc(DVec3::Z, axis);
            }
            let half = 0.5 * from.distance(to);
            match kind {
                "box" | "ellipsoid" => size = DVec3::new(size.x, size.x, half),
                _ => size.y = half,
            }
        }
        let kind = match kind {
            "sphere" => ShapeKind::Sphere { radius: size.x },
            "capsule" => ShapeKind::Capsule {
                radius: size.x,
                half_length: size.y,
            },
            "cylinder" => ShapeKind::Cylinder {
                radius: size.x,
                half_length: size.y,
            },
            "box" => ShapeKind::Box { half_size: size },
            "ellipsoid" => ShapeKind::Ellipsoid { half_size: size },
            "mesh" => self.mesh(attributes, warnings),
            _ => {
                warnings.push(Code::IgnoredMesh, || {
                    let message = format!("a geom of type {} was skipped", quote(kind.as_bytes()));
                    attributes.element.at_attribute("type", Code::IgnoredMesh, message)
                });
                return Ok(None);
            }
        };
        let is_zero = |name: &str| attributes.get(name).map(str::trim) == Some("0");
        Ok(Some(RobotShape {
            origin,
            kind,
            collides: !(is_zero("contype") && is_zero("conaffinity")),
        }))
    }

    fn mesh(&self, attributes: &Attributes<'_, '_>, warnings: &mut Warnings) -> ShapeKind {
        let name = attributes.get("mesh").unwrap_or_default();
        match self.settings.meshes.get(name) {
            Some(asset) => {
                let folder = &self.settings.mesh_folder;
                mesh_shape(self.source, folder, &asset.file, asset.scale, warnings)
            }
            None => ShapeKind::Mesh {
                file: name.to_owned(),
                bounds: None,
                scale: DVec3::ONE,
                path: None,
                surface: None,
            },
        }
    }
}

fn read_inertial(attributes: &Attributes<'_, '_>) -> Result<Inertial, Failure> {
    let mut inertia = [0.0; 6];
    if let Some(full) = attributes.numbers("fullinertia", 6, 6)? {
        inertia.copy_from_slice(&full);
    } else if let Some(diagonal) = attributes.numbers("diaginertia", 3, 3)? {
        inertia[..3].copy_from_slice(&diagonal);
    }
    let mass = attributes.numbers("mass", 1, 1)?.and_then(|mass| mass.first().copied());
    Ok(Inertial {
        mass: mass.unwrap_or_default(),
        origin: attributes.origin()?,
        inertia,
    })
}
