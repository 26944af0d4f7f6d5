//! A sheet of T-poses: a row for each skeleton, with three views and the names of its bones.

use glam::{Quat, Vec3};
use mocap_figure::report::TPoseSource;
use mocap_figure::report::{RestPose, Sides};
use mocap_figure::{Confidence, Figure, HumanoidBone, Side, TPose};
use mocap_scene::scene::{NodeId, NodeKind, Scene};

use super::camera::{Camera, paint_bone};
use super::drawing::{Anchor, Color, Drawing, Point};
use super::figure::body;
use super::raster::{shortened, text_width};
use super::theme;

/// A skeleton in its T-pose, with a name for the picture.
///
/// [`Drawing::t_pose_sheet`](crate::Drawing::t_pose_sheet) has an example.
#[derive(Clone, Copy, Debug)]
pub struct TPoseClip<'a> {
    /// A short name, such as the file's.
    pub name: &'a str,
    /// The scene.
    pub scene: &'a Scene,
    /// The figure of the scene, with the humanoid bones.
    pub figure: &'a Figure,
    /// The T-pose.
    pub t_pose: &'a TPose,
}

/// The margin of the sheet in pixels: the width of a letter of a heading.
const MARGIN: f32 = 16.0;

/// The width in pixels of the left column, with the name and the facts.
const HEAD: f32 = 250.0;

/// The height in pixels of the space for captions, below the views.
const CAPTION: f32 = 26.0;

/// The views of a T-pose: degrees around the figure, degrees up.
const VIEWS: [(&str, f32, f32); 3] = [
    ("from the front", 0.0, 0.0),
    ("from its left", 90.0, 0.0),
    ("from above", 0.0, 90.0),
];

impl Drawing {
    /// Draws the T-pose of each skeleton as a row. The row states where the T-pose comes from. It shows the figure from
    /// the front, from its left and from above, with bone names. Left is blue, right orange, the middle green. Joints
    /// that are not bones are grey.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::render::{Drawing, TPoseClip};
    /// use mocap::figure::Figure;
    ///
    /// let scene = mocap::import("fixtures/real/rokoko_dance.bvh")?;
    /// let figure = Figure::new(&scene);
    /// let t_pose = figure.t_pose(&scene).unwrap();
    /// let clip = TPoseClip { name: "dance", scene: &scene, figure: &figure, t_pose };
    /// assert!(Drawing::t_pose_sheet(&[clip], 1600).to_svg().contains(">leftLowerArm</text>"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn t_pose_sheet(clips: &[TPoseClip<'_>], width: u32) -> Self {
        let width = width.max(640);
        let cell = (width as f32 - HEAD - 2.0 * MARGIN) / VIEWS.len() as f32;
        let row = (cell + CAPTION + 24.0).round();
        let height = (2.0 * MARGIN + row * clips.len() as f32) as u32;
        let names: Vec<_> = clips.iter().map(|clip| clip.name).collect();
        let mut drawing = Self::new(width, height, theme::PAPER, format!("T-pose: {}", names.join(", ")));
        for (index, clip) in clips.iter().enumerate() {
            let top = MARGIN + row * index as f32;
            if index > 0 {
                drawing.line(vec![[MARGIN, top], [width as f32 - MARGIN, top]], 1.0, theme::RULE);
            }
            paint_head(&mut drawing, clip, top);
            let figure = TPoseFigure::new(clip);
            for (view, (caption, around, up)) in VIEWS.into_iter().enumerate() {
                let left = MARGIN + HEAD + cell * view as f32;
                let mut camera = Camera::new(around, up);
                camera.target = figure.middle;
                camera.scale = 0.9 * cell / figure.extent;
                camera.middle = [left + 0.5 * cell, top + 0.5 * (row - CAPTION)];
                figure.paint(&mut drawing, &camera);
                if view == 0 {
                    figure.paint_names(&mut drawing, &camera);
                }
                let at = [left + 0.5 * cell, top + row - 10.0];
                drawing.text(at, caption, 11.0, Anchor::Middle, theme::FADED);
            }
        }
        drawing
    }
}

fn paint_head(drawing: &mut Drawing, clip: &TPoseClip<'_>, top: f32) {
    /// The font height of a name in pixels, as for a heading.
    const NAME: f32 = 15.0;

    /// The font height of facts in pixels: the smallest legible height.
    const FACTS: f32 = 11.0;
    let width = HEAD - MARGIN;
    let name = shortened(clip.name, NAME, width);
    drawing.text([MARGIN, top + 26.0], name, NAME, Anchor::Start, theme::INK);
    for (line, (text, color)) in facts(clip).into_iter().enumerate() {
        let at = [MARGIN, top + 46.0 + 16.0 * line as f32];
        drawing.text(at, shortened(&text, FACTS, width), FACTS, Anchor::Start, color);
    }
}

/// The source of the T-pose, and the confidence in the bones.
fn facts(clip: &TPoseClip<'_>) -> Vec<(String, Color)> {
    let TPoseClip { figure, t_pose, .. } = clip;
    let source = match t_pose.source {
        TPoseSource::RestPose if figure.rest_pose.value == RestPose::TPose => "the rest pose is a T-pose",
        TPoseSource::RestPose => "made from the rest pose",
        TPoseSource::FirstFrame => "the first frame is a T-pose",
        TPoseSource::Computed => "computed from the bones",
    };
    let count = |confidence| {
        let bones = figure.humanoid.bones.values();
        bones.filter(|joint| joint.confidence == confidence).count()
    };
    let mut facts = vec![
        (source.to_owned(), theme::FADED),
        (
            format!("{:.0}° from the rest pose at most", t_pose.largest_rotation()),
            theme::FADED,
        ),
        (
            format!(
                "up {}, facing {} at rest",
                figure.up.value.as_str(),
                figure.facing.value.as_str()
            ),
            theme::FADED,
        ),
        (format!("{} bones", figure.humanoid.bones.len()), theme::FADED),
    ];
    for confidence in [Confidence::Likely, Confidence::Unsure] {
        let bones = count(confidence);
        if bones > 0 {
            facts.push((format!("{bones} of them {}", confidence.as_str()), theme::FADED));
        }
    }
    if figure.humanoid.sides == Sides::Opposite {
        facts.push(("the names of left and right are swapped".to_owned(), theme::RIGHT));
    }
    let missing = figure.humanoid.missing();
    facts.extend(
        missing
            .iter()
            .map(|bone| (format!("no {}", bone.as_str()), theme::RIGHT)),
    );
    facts
}

/// The nodes of a figure with +Y up, facing +Z.
struct TPoseFigure<'a> {
    scene: &'a Scene,
    figure: &'a Figure,
    positions: Vec<Vec3>,
    in_body: Vec<bool>,
    /// The bone of each node.
    bones: Vec<Option<HumanoidBone>>,
    middle: Vec3,
    /// The longest side of the figure's bounding box.
    extent: f32,
}

impl<'a> TPoseFigure<'a> {
    fn new(clip: &TPoseClip<'a>) -> Self {
        let TPoseClip {
            scene, figure, t_pose, ..
        } = *clip;
        // The rotation from the motion's world to +Y up, facing +Z.
        let to_stage = Quat::from_mat3(&figure.figure_to_world().transpose());
        let nodes = 0..scene.nodes.len();
        let positions: Vec<Vec3> = nodes
            .map(|node| to_stage * t_pose.pose.position(NodeId::new(node)))
            .collect();
        let in_body = body(scene, &figure.humanoid);
        let shown = || {
            positions
                .iter()
                .zip(&in_body)
                .filter(|(_, in_body)| **in_body)
                .map(|(position, _)| *position)
        };
        let low = shown().fold(Vec3::INFINITY, Vec3::min);
        let high = shown().fold(Vec3::NEG_INFINITY, Vec3::max);
        let extent = (high - low).max_element();
        let mut bones = vec![None; scene.nodes.len()];
        for (bone, joint) in &figure.humanoid.bones {
            bones[joint.joint.index()] = Some(*bone);
        }
        Self {
            scene,
            figure,
            in_body,
            bones,
            middle: 0.5 * (low + high),
            extent: if extent > 0.0 && extent.is_finite() {
                extent
            } else {
                1.0
            },
            positions,
        }
    }

    /// Paints the links from back to front, in the colour of the bone at their start, and the joints.
    fn paint(&self, drawing: &mut Drawing, camera: &Camera) {
        let parent = |node: usize| self.scene.nodes[node].parent.map(NodeId::index);
        let links = (0..self.positions.len()).filter_map(|node| Some((parent(node)?, node)));
        let mut links: Vec<_> = links
            .filter(|(from, to)| self.in_body[*from] && self.in_body[*to])
            .collect();
        let depth =
            |(from, to): &(usize, usize)| camera.see(self.positions[*from]).z + camera.see(self.positions[*to]).z;
        links.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
        for (from, to) in links {
            let color = self.color_above(from);
            let (start, end) = (self.positions[from], self.positions[to]);
            let width = (0.17 * start.distance(end)).min(0.035 * self.extent) * camera.scale;
            paint_bone(drawing, camera.project(start), camera.project(end), width, color);
        }
        for node in (0..self.positions.len()).filter(|node| self.in_body[*node]) {
            if self.scene.nodes[node].kind == NodeKind::Joint {
                let color = self.bones[node].map_or(theme::MIDDLE, |bone| self.color(bone));
                let radius = (0.006 * self.extent * camera.scale).max(0.9);
                drawing.circle(
                    camera.project(self.positions[node]),
                    radius,
                    color.mix(theme::INK, 0.35),
                );
            }
        }
    }

    /// The colour of a node's bone, or of its nearest ancestor's bone.
    fn color_above(&self, node: usize) -> Color {
        let above = std::iter::successors(Some(node), |node| self.scene.nodes[*node].parent.map(NodeId::index));
        let bone = above.into_iter().find_map(|node| self.bones[node]);
        bone.map_or(theme::MIDDLE, |bone| self.color(bone))
    }

    /// The colour of a bone. Less confidence makes the colour greyer.
    fn color(&self, bone: HumanoidBone) -> Color {
        let color = match bone.side() {
            Some(Side::Left) => theme::LEFT,
            Some(Side::Right) => theme::RIGHT,
            None => theme::CURVES[1],
        };
        let greyness = match self.figure.humanoid.bones[&bone].confidence {
            Confidence::Sure => 0.0,
            Confidence::Likely => 0.4,
            Confidence::Unsure => 0.7,
        };
        color.mix(theme::MIDDLE, greyness)
    }

    /// Paints the names of trunk and limb bones: above and below the arms, and next to the other bones. A name that
    /// would overlap another name is left out.
    fn paint_names(&self, drawing: &mut Drawing, camera: &Camera) {
        /// The font height of bone names in pixels. It is small, because the names are close together.
        const SIZE: f32 = 10.0;
        let mut painted: Vec<[Point; 2]> = Vec::new();
        for &bone in NAMED {
            let Some(node) = self.figure.humanoid.joint(bone) else {
                continue;
            };
            let (start, end) = (self.positions[node.index()], self.end_of(bone));
            let name = bone.as_str();
            let width = text_width(name, SIZE);
            let is_arm = name.ends_with("Arm") || name.ends_with("Hand");
            let [x, y] = match is_arm {
                true => camera.project(0.5 * (start + end)),
                false => camera.project(start),
            };
            let is_left_of_middle = bone.side().is_some() && x < camera.middle[0];
            let (left, bottom) = match (is_arm, is_left_of_middle) {
                (true, _) if name.ends_with("LowerArm") => (x - 0.5 * width, y + 20.0),
                (true, _) => (x - 0.5 * width, y - 12.0),
                (false, true) => (x - 14.0 - width, y + 4.0),
                (false, false) => (x + 14.0, y + 4.0),
            };
            let covers = |[[other_left, other_bottom], [other_right, _]]: &[Point; 2]| {
                (other_bottom - bottom).abs() < SIZE + 2.0 && left < *other_right && *other_left < left + width
            };
            if !painted.iter().any(covers) {
                drawing.text([left, bottom], name, SIZE, Anchor::Start, theme::INK);
                painted.push([[left, bottom], [left + width + 4.0, bottom]]);
            }
        }
    }

    /// The position of the next bone of an arm. For the last bone, its own position.
    fn end_of(&self, bone: HumanoidBone) -> Vec3 {
        let next = HumanoidBone::ALL.iter().filter(|next| next.parent() == Some(bone));
        let next = next.into_iter().find_map(|next| self.figure.humanoid.joint(*next));
        let node = next.or_else(|| self.figure.humanoid.joint(bone));
        node.map_or(self.middle, |node| self.positions[node.index()])
    }
}

/// The bones with names, the most important bones first.
const NAMED: &[HumanoidBone] = &[
    HumanoidBone::Hips,
    HumanoidBone::Head,
    HumanoidBone::LeftUpperArm,
    HumanoidBone::RightUpperArm,
    HumanoidBone::LeftLowerArm,
    HumanoidBone::RightLowerArm,
    HumanoidBone::LeftHand,
    HumanoidBone::RightHand,
    HumanoidBone::LeftUpperLeg,
    HumanoidBone::RightUpperLeg,
    HumanoidBone::LeftLowerLeg,
    HumanoidBone::RightLowerLeg,
    HumanoidBone::LeftFoot,
    HumanoidBone::RightFoot,
    HumanoidBone::LeftToes,
    HumanoidBone::RightToes,
    HumanoidBone::Spine,
    HumanoidBone::Chest,
    HumanoidBone::UpperChest,
    HumanoidBone::Neck,
];
