//! Reads a robot of MJCF.

mod attributes;
mod body;
mod equality;
mod frame;
mod include;
mod mass;

use glam::DVec3;
use mocap_scene::error::{Code, Result};
use mocap_scene::limits::Limits;
use mocap_scene::scene::robot::Robot;
use mocap_scene::scene::{Format, Scene};

use self::attributes::Settings;
use self::body::Bodies;
use self::frame::{BodyElement, within};
use crate::warnings::Warnings;
use crate::xml::{self, Element};
use crate::{Failure, ReadOptions, Source};

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    crate::read_robot_scene(source, options, read_robot)
}

/// The robot of a file: the first body that has a free joint, else the first one.
pub(crate) fn read_robot(source: &Source<'_>, limits: &Limits, warnings: &mut Warnings) -> Result<Robot, Failure> {
    let text = xml::text(source.bytes)?;
    let included = include::texts(source, &text, limits)?;
    let (document, included) = (
        xml::parse(&text, &["mujoco"], limits)?,
        include::parse(&included, limits)?,
    );
    let root = Element::root_with(&document, &included);
    let settings = Settings::read(&root, limits)?;
    let mut bodies = Vec::new();
    for world in root.all("worldbody") {
        let inner = within(world, world.attribute("childclass"), &settings, limits)?;
        bodies.extend(inner.into_iter().filter(|inner| inner.element.name() == "body"));
    }
    let is_free = |body: &&BodyElement<'_, '_>| {
        let body = body.element;
        let free = |joint: Element<'_, '_>| joint.attribute("type") == Some("free");
        body.child("freejoint").is_some() || body.all("joint").any(free)
    };
    let Some(base) = bodies.iter().find(is_free).or(bodies.first()) else {
        return Err(Box::new(
            root.diagnostic(Code::InvalidRobot, "the model has no <body> in a <worldbody>"),
        ));
    };
    if bodies.len() > 1 {
        warnings.push(Code::SeveralRoots, || {
            let message = format!("the world has {} bodies: one was read", bodies.len());
            base.element.diagnostic(Code::SeveralRoots, message)
        });
    }
    let mut links = Bodies::new(source, limits, &settings, &text).read(*base, warnings)?;
    equality::tie_joints(&root, &mut links, bodies.len() > 1, warnings)?;
    let name = root.attribute("model").unwrap_or_default();
    Ok(Robot {
        name: root.checked_name("model", name, limits)?,
        links,
        format: Some(Format::Mjcf),
        warnings: Vec::new(),
    })
}

/// Sizes are not negative.
fn sizes(numbers: &[f64]) -> DVec3 {
    let size = |index: usize| numbers.get(index).copied().unwrap_or_default().abs();
    DVec3::new(size(0), size(1), size(2))
}
