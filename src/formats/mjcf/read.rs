//! Reads a robot from MJCF.

mod attributes;
mod body;
mod equality;
mod frame;
mod include;
mod mass;

use glam::DVec3;
use mocap_scene::error::{Code, Result};
use mocap_scene::limits::Limits;
use mocap_scene::scene::report::{DataKind, DataLoss};
use mocap_scene::scene::robot::Robot;
use mocap_scene::scene::{Format, Scene};

use self::attributes::Settings;
use self::body::Bodies;
use self::frame::{BodyElement, within};
use crate::warnings::Warnings;
use crate::xml::{self, Element};
use crate::{Failure, ReadOptions, Source};

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    crate::robot_as_scene::read(source, options, read_robot)
}

/// Sections for actuators, sensors and poses of a model.
const OTHERS: [&str; 8] = [
    "actuator",
    "sensor",
    "tendon",
    "contact",
    "keyframe",
    "deformable",
    "custom",
    "extension",
];

/// The number of elements with a name in the descendants of a body.
fn count_below(body: Element<'_, '_>, name: &str) -> usize {
    let (mut count, mut open) = (0, vec![body]);
    while let Some(element) = open.pop() {
        for child in element.children() {
            count += usize::from(child.name() == name);
            if matches!(child.name(), "body" | "frame") {
                open.push(child);
            }
        }
    }
    count
}

/// The number of joints of a body and its descendants.
fn joints_of(body: Element<'_, '_>) -> usize {
    count_below(body, "joint") + count_below(body, "freejoint")
}

/// The robot of a file: the body with the most joints. On a tie, the body with a free joint, or else the first one.
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
    let size = |body: &&BodyElement<'_, '_>| {
        let body = body.element;
        let free = |joint: Element<'_, '_>| joint.attribute("type") == Some("free");
        let is_free = body.child("freejoint").is_some() || body.all("joint").any(free);
        (joints_of(body), is_free)
    };
    let Some(base) = bodies.iter().rev().max_by_key(size) else {
        return Err(Box::new(
            root.diagnostic(Code::InvalidRobot, "the model has no <body> in a <worldbody>"),
        ));
    };
    if bodies.len() > 1 {
        warnings.push(Code::SeveralRoots, || {
            let message = format!("the world has {} bodies; one was read", bodies.len());
            base.element.diagnostic(Code::SeveralRoots, message)
        });
    }
    let mut links = Bodies::new(source, limits, &settings, &text).read(*base, warnings)?;
    equality::tie_joints(&root, &mut links, bodies.len() > 1, warnings)?;
    let name = root.attribute("model").unwrap_or_default();
    let of_sections = |sections: &[&str], count: &dyn Fn(Element<'_, '_>) -> usize| {
        let sections = root.children().filter(|section| sections.contains(&section.name()));
        sections.map(count).sum::<usize>() as u64
    };
    let in_world = |name: &str| of_sections(&["worldbody"], &|world| count_below(world, name));
    let assets = |name: &str| {
        let named = |section: Element<'_, '_>| section.children().filter(|asset| asset.name() == name).count();
        of_sections(&["asset"], &named)
    };
    let bodies_of_world = in_world("body");
    Ok(Robot {
        lost: vec![
            DataLoss::new(
                DataKind::Links,
                bodies_of_world.saturating_sub(1 + count_below(base.element, "body") as u64),
            ),
            DataLoss::new(DataKind::Materials, assets("material")),
            DataLoss::new(DataKind::Textures, assets("texture")),
            DataLoss::new(DataKind::Cameras, in_world("camera")),
            DataLoss::new(DataKind::Lights, in_world("light")),
            DataLoss::new(
                DataKind::Extras,
                of_sections(&OTHERS, &|section| section.children().count()),
            ),
        ],
        name: root.checked_name("model", name, limits)?,
        links,
        format: Some(Format::Mjcf),
        warnings: Vec::new(),
    })
}

/// The three sizes of a geom, without their signs.
fn sizes(numbers: &[f64]) -> DVec3 {
    let size = |index: usize| numbers.get(index).copied().unwrap_or_default().abs();
    DVec3::new(size(0), size(1), size(2))
}
