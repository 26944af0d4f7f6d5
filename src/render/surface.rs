//! Rasterizes the skin of a figure: triangles with one light and a z-buffer, in the colours of their materials.
//! Materials without a colour are grey.

use glam::{Vec2, Vec3};
use mocap_scene::scene::{Mesh, Scene};

use super::camera::{Camera, paint_figure, paint_shadow_of_bones};
use super::drawing::{Color, Drawing, Pixels, Point};
use super::figure::{DrawnClip, skin_meshes};
use super::theme;

/// The number of samples per pixel in each direction.
pub const SAMPLES: usize = 2;

/// The direction to the light in camera space: from the upper left, behind the camera.
const LIGHT: Vec3 = Vec3::new(-0.4, 0.55, 0.73);

/// The number of shades of a skin. The palette of a movie has all of them.
pub(super) const SHADES: usize = 24;

/// The shades of a skin, darkest first.
pub(super) fn shades() -> impl Iterator<Item = Color> {
    let dark = theme::MIDDLE.mix(theme::INK, 0.62);
    let light = theme::MIDDLE.mix(theme::PAPER, 0.72);
    (0..SHADES).map(move |shade| dark.mix(light, shade as f32 / (SHADES - 1) as f32))
}

/// Whether the scene has a skin to draw.
pub(super) fn has_skin(scene: &Scene) -> bool {
    skin_meshes(scene).next().is_some()
}

/// Whether a skin has its own colours.
pub(super) fn has_colors(figure: &DrawnClip<'_>) -> bool {
    let scene = figure.clip.scene;
    skin_meshes(scene).any(|mesh| figure.images().paint(scene, mesh).is_some())
}

/// Depths and colours of samples within a rectangle of a drawing.
pub struct Buffer {
    left: usize,
    top: usize,
    /// The width in samples.
    width: usize,
    height: usize,
    /// Larger depths are nearer to the camera. Empty samples have minus infinity.
    depths: Vec<f32>,
    pub colors: Vec<[u8; 3]>,
}

impl Buffer {
    /// The bounding rectangle of points in the drawing, clipped to the drawing.
    pub fn around(points: impl Iterator<Item = Point>, drawing: &Drawing) -> Option<Self> {
        let (mut from, mut to) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for point in points.map(Vec2::from).filter(|point| point.is_finite()) {
            (from, to) = (from.min(point), to.max(point));
        }
        let edge = Vec2::new(drawing.width as f32, drawing.height as f32);
        let (from, to) = (from.clamp(Vec2::ZERO, edge).floor(), to.clamp(Vec2::ZERO, edge).ceil());
        let size = (to - from).max(Vec2::ZERO);
        let (width, height) = (size.x as usize * SAMPLES, size.y as usize * SAMPLES);
        (width > 0 && height > 0).then(|| Self {
            left: from.x as usize,
            top: from.y as usize,
            width,
            height,
            depths: vec![f32::NEG_INFINITY; width * height],
            colors: vec![[0; 3]; width * height],
        })
    }

    /// Fills a triangle with corners in pixels and depths. For each sample, `color` gets the weights of the corners. If
    /// `color` returns `None`, the sample stays empty.
    pub fn fill(&mut self, corners: [(Vec2, f32); 3], color: impl Fn([f32; 3]) -> Option<[u8; 3]>) {
        let origin = Vec2::new(self.left as f32, self.top as f32);
        let [a, b, c] = corners.map(|(point, _)| (point - origin) * SAMPLES as f32 - 0.5);
        let area = (b - a).perp_dot(c - a);
        if !(area.is_finite() && area != 0.0) {
            return;
        }
        let edge = Vec2::new((self.width - 1) as f32, (self.height - 1) as f32);
        let from = a.min(b).min(c).ceil().max(Vec2::ZERO);
        let to = a.max(b).max(c).floor().min(edge);
        if from.x > to.x || from.y > to.y {
            return;
        }
        for row in from.y as usize..=to.y as usize {
            for column in from.x as usize..=to.x as usize {
                let sample = Vec2::new(column as f32, row as f32);
                let parts = [(b, c), (c, a), (a, b)].map(|(from, to)| (to - from).perp_dot(sample - from) / area);
                if parts.iter().any(|part| *part < 0.0) {
                    continue;
                }
                let depth: f32 = parts.iter().zip(&corners).map(|(part, (_, depth))| part * depth).sum();
                let at = row * self.width + column;
                if depth > self.depths[at]
                    && let Some(color) = color(parts)
                {
                    (self.depths[at], self.colors[at]) = (depth, color);
                }
            }
        }
    }

    fn pixels(&self) -> Pixels {
        let (width, height) = (self.width / SAMPLES, self.height / SAMPLES);
        let mut rgba = Vec::with_capacity(4 * width * height);
        for row in 0..height {
            for column in 0..width {
                let samples = (0..SAMPLES * SAMPLES).map(|sample| {
                    let (down, right) = (sample / SAMPLES, sample % SAMPLES);
                    (SAMPLES * row + down) * self.width + SAMPLES * column + right
                });
                let (mut sum, mut count) = ([0u32; 3], 0);
                for at in samples.filter(|at| self.depths[*at].is_finite()) {
                    sum.iter_mut()
                        .zip(self.colors[at])
                        .for_each(|(sum, value)| *sum += u32::from(value));
                    count += 1;
                }
                rgba.extend(sum.map(|sum| (sum / count.max(1)) as u8));
                rgba.push((255 * count / (SAMPLES * SAMPLES) as u32) as u8);
            }
        }
        Pixels {
            left: self.left,
            top: self.top,
            width,
            height,
            rgba,
        }
    }
}

/// A figure in a pose: its skin, or its bones if it has no skin.
pub(super) struct Body<'a> {
    figure: &'a DrawnClip<'a>,
    positions: &'a [Vec3],
    /// The meshes of the skin, with their vertices.
    skins: Vec<(&'a Mesh, Vec<Vec3>)>,
}

impl<'a> Body<'a> {
    /// A figure in its current pose, in which its nodes have these positions.
    pub(super) fn new(figure: &'a DrawnClip<'a>, positions: &'a [Vec3]) -> Self {
        Self {
            figure,
            positions,
            skins: figure.skins().collect(),
        }
    }

    /// Paints the shadow on the ground, in light from straight above.
    pub(super) fn paint_shadow(&self, drawing: &mut Drawing, camera: &Camera) {
        if self.skins.is_empty() {
            paint_shadow_of_bones(drawing, camera, self.figure, self.positions);
            return;
        }
        let shadow = |position: Vec3| camera.project(self.figure.ground_below(position));
        let points = self.skins.iter().flat_map(|(_, positions)| positions);
        let Some(mut buffer) = Buffer::around(points.map(|position| shadow(*position)), drawing) else {
            return;
        };
        for (mesh, positions) in &self.skins {
            for face in mesh.faces() {
                let corners = [face[0], face[1], face[2]].map(|vertex| shadow(positions[vertex as usize]));
                buffer.fill(corners.map(|corner| (corner.into(), 0.0)), |_| Some(theme::SHADOW.rgb));
            }
        }
        drawing.pixels(buffer.pixels());
    }

    /// Paints the figure.
    pub(super) fn paint(&self, drawing: &mut Drawing, camera: &Camera) {
        match self.skins.is_empty() {
            true => paint_figure(drawing, camera, self.figure, self.positions),
            false => paint_skin(drawing, camera, self.figure, &self.skins),
        }
    }
}

fn paint_skin(drawing: &mut Drawing, camera: &Camera, figure: &DrawnClip<'_>, skins: &[(&Mesh, Vec<Vec3>)]) {
    let points = skins.iter().flat_map(|(_, positions)| positions);
    let Some(mut buffer) = Buffer::around(points.map(|position| camera.project(*position)), drawing) else {
        return;
    };
    let light = LIGHT.normalize();
    let greys: Vec<Color> = shades().collect();
    for (mesh, positions) in skins {
        let paint = figure.images().paint(figure.clip.scene, mesh);
        for face in mesh.faces() {
            let corners = [face[0], face[1], face[2]].map(|vertex| positions[vertex as usize]);
            let [a, b, c] = corners.map(|corner| camera.see(corner));
            // Faces are visible from both sides.
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let normal = if normal.z < 0.0 { -normal } else { normal };
            let brightness = 0.25 + 0.75 * normal.dot(light).max(0.0);
            let grey = greys[(brightness * (SHADES - 1) as f32).round() as usize].rgb;
            let coords = [0, 1, 2].map(|corner| {
                let coords = mesh.texture_coords.get(face[corner] as usize);
                coords.copied().unwrap_or_default()
            });
            let corners = corners.map(|corner| (camera.project(corner).into(), camera.see(corner).z));
            buffer.fill(corners, |weights| match &paint {
                None => Some(grey),
                Some(paint) => {
                    let at: Vec2 = coords
                        .iter()
                        .zip(weights)
                        .map(|(coords, weight)| *coords * weight)
                        .sum();
                    // The light is brighter for colours than for grey, so that the colours match the colours of the
                    // file.
                    paint.color(at, 0.45 + 0.55 * brightness)
                }
            });
        }
    }
    drawing.pixels(buffer.pixels());
}
