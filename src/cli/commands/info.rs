//! `mocap info`: summarises a file.

use std::fmt;
use std::io::{self, IsTerminal};

use mocap::dump::report::Summary;
use mocap::render::{Clip, ScreenOptions};
use mocap::retarget::robot::{JointKind, Robot};
use mocap::scene::Format;
use mocap::{Importer, Scene, SkeletonMesh};
use serde::Serialize;
use terminal_size::{Height, Width};

use super::{Place, print_report};
use crate::args::InfoArgs;
use crate::{Failure, report, streams};

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct InfoView<'a> {
    file: String,
    #[serde(flatten)]
    summary: Summary<'a>,
    /// The movable joints of a robot, in the order of the arrays of its motions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    robot_joints: Vec<RobotJointView>,
    /// The text for users.
    #[serde(skip)]
    screen: String,
}

/// A joint of a robot: positions in radians or metres, velocities in these units per second, efforts in newton metres
/// or newtons.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RobotJointView {
    joint: String,
    link: String,
    /// Whether the joint slides along its axis, instead of rotating about it.
    slides: bool,
    /// The lower limit of the position. Each limit is absent if the robot states none.
    lower: Option<f64>,
    upper: Option<f64>,
    velocity: Option<f64>,
    effort: Option<f64>,
}

impl RobotJointView {
    fn of(robot: &Robot) -> Vec<Self> {
        let finite = |limit: f64| limit.is_finite().then_some(limit);
        let joints = robot.moving_joints().into_iter().map(|link| {
            let joint = &robot.links[link].joint;
            Self {
                joint: joint.name.clone(),
                link: robot.links[link].name.clone(),
                slides: joint.kind == JointKind::Slide,
                lower: finite(joint.limits.lower),
                upper: finite(joint.limits.upper),
                velocity: joint.limits.velocity,
                effort: joint.limits.effort,
            }
        });
        joints.collect()
    }

    /// The row of the text table.
    fn row(&self, order: usize, width: usize) -> String {
        let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3}"));
        let whole = |value: Option<f64>| value.map_or("-".to_owned(), |value| value.to_string());
        let [angle, effort] = match self.slides {
            true => ["m", "N"],
            false => ["rad", "Nm"],
        };
        let name = report::visible(&self.joint);
        format!(
            "{order:>3}  {name:<width$}  {:>7} to {:>6} {angle}  {:>5} {angle}/s  {:>5} {effort}",
            number(self.lower),
            number(self.upper),
            whole(self.velocity),
            whole(self.effort)
        )
    }
}

/// The joints of the robot in a file, with the limits that a scene lacks. Empty for other files and for standard input.
fn robot_joints(args: &InfoArgs, scene: &Scene) -> Result<Vec<RobotJointView>, Failure> {
    let is_robot = matches!(scene.metadata.format, Some(Format::Urdf | Format::Mjcf));
    if !is_robot || streams::is_standard(&args.file) {
        return Ok(Vec::new());
    }
    let robot = Importer::new().import_robot(&args.file)?;
    Ok(RobotJointView::of(&robot))
}

fn table(joints: &[RobotJointView]) -> String {
    let width = joints
        .iter()
        .map(|joint| joint.joint.chars().count())
        .max()
        .unwrap_or(0);
    let rows = joints.iter().enumerate().map(|(order, joint)| joint.row(order, width));
    let rows: Vec<String> = rows.collect();
    format!(
        "\n\njoints in the order of dof_pos: range, velocity, effort\n{}\n",
        rows.join("\n")
    )
}

impl fmt::Display for InfoView<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.screen)
    }
}

pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let mut scene = import(args)?;
    let mut screen = String::new();
    let joints = robot_joints(args, &scene)?;
    if !args.json {
        make_names_visible(&mut scene);
        screen = screen_of(&report::visible(&args.file.display().to_string()), &scene);
        if !joints.is_empty() {
            screen = screen.trim_end().to_owned() + &table(&joints);
        }
    }
    print_report(&view(args, &scene, joints, screen), args.json, Place::Screen)
}

/// The output of `--json`.
pub(crate) fn summary(args: &InfoArgs) -> Result<serde_json::Value, Failure> {
    let scene = import(args)?;
    let joints = robot_joints(args, &scene)?;
    Ok(super::value(&view(args, &scene, joints, String::new())))
}

fn view<'a>(args: &InfoArgs, scene: &'a Scene, robot_joints: Vec<RobotJointView>, screen: String) -> InfoView<'a> {
    InfoView {
        file: args.file.display().to_string(),
        summary: Summary::of(scene),
        robot_joints,
        screen,
    }
}

fn import(args: &InfoArgs) -> mocap::Result<Scene> {
    let importer = args.read.importer().skeleton_mesh(SkeletonMesh::Segmented);
    streams::import(&importer, &args.file)
}

/// The screen has colours, so control characters must be escaped before.
fn make_names_visible(scene: &mut Scene) {
    let clips = scene.animations.iter_mut();
    let in_clips = clips.flat_map(|clip| {
        let channels = clip.channels.iter_mut().map(|channel| &mut channel.node_name);
        std::iter::once(&mut clip.name).chain(channels)
    });
    let nodes = scene.nodes.iter_mut().map(|node| &mut node.name);
    let warnings = scene.warnings.iter_mut().flat_map(|warning| {
        let texts = [
            &mut warning.joint,
            &mut warning.expected,
            &mut warning.found,
            &mut warning.help,
        ];
        texts.into_iter().flatten().chain([&mut warning.message])
    });
    for text in nodes.chain(in_clips).chain(warnings) {
        *text = report::visible(text).into_owned();
    }
}

/// The text of a scene, in the width and height of the terminal. If the output is not a terminal, the text has the
/// default width and any number of lines.
fn screen_of(name: &str, scene: &Scene) -> String {
    let is_terminal = io::stdout().is_terminal();
    let size = terminal_size::terminal_size().filter(|_| is_terminal);
    let options = match size {
        Some((Width(width), Height(height))) => ScreenOptions::new()
            .width(width.into())
            .height(height.into())
            .colour(std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())),
        None => ScreenOptions::new().height(usize::MAX),
    };
    Clip { name, scene }.screen(&options)
}
