//! A clip as a movie: GIF and animated PNG.

use glam::Vec3;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::options::setters;

use super::camera::{Camera, Extent};
use super::drawing::{Anchor, Drawing};
use super::figure::{Clip, DrawnClip, short};
use super::palette::Palette;
use super::surface::{Body, has_colors, has_skin};
use super::theme;

/// The options of a movie.
///
/// [`Movie`](crate::Movie) has an example.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MovieOptions {
    /// Width in pixels. Default: 360.
    pub width: u32,
    /// Height in pixels. Default: 360.
    pub height: u32,
    /// Pictures per second, independent of the clip's frame rate. Default: 25.
    pub frames_per_second: f64,
    /// The playback speed; 1 is real time. Default: 1.
    pub speed: f64,
    /// Whether the camera follows the root. If not, the picture shows the whole path. Default: `true`.
    pub follow: bool,
}

impl Default for MovieOptions {
    fn default() -> Self {
        Self {
            width: 360,
            height: 360,
            frames_per_second: 25.0,
            speed: 1.0,
            follow: true,
        }
    }
}

setters! {
    MovieOptions {
        width: u32,
        height: u32,
        frames_per_second: f64,
        speed: f64,
        follow: bool,
    }
}

/// A movie of a clip, drawn picture by picture.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::render::{Clip, Movie, MovieOptions};
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let options = MovieOptions::new().width(64).height(64);
/// let gif = Movie::new(Clip { name: "Test", scene: &scene }, &options)?.to_gif()?;
/// assert!(gif.starts_with(b"GIF89a"));
/// # Ok::<(), mocap::Error>(())
/// ```
pub struct Movie<'a> {
    figure: DrawnClip<'a>,
    options: MovieOptions,
    camera: Camera,
    /// The camera's target for each picture.
    targets: Vec<Vec3>,
    ticks: Vec<f64>,
}

impl<'a> Movie<'a> {
    /// The largest number of pictures: an hour at 25 per second.
    const MOST_PICTURES: f64 = 90_000.0;

    /// Prepares the movie: its pictures and the camera's path.
    ///
    /// # Errors
    /// - [`Code::InvalidValue`]: a rate or a speed is not above 0, or a picture is empty or too large.
    /// - [`Code::LimitExceeded`]: the movie would have more than 90,000 pictures.
    pub fn new(clip: Clip<'a>, options: &MovieOptions) -> Result<Self> {
        for (what, value) in [("frame rate", options.frames_per_second), ("speed", options.speed)] {
            if !(value.is_finite() && value > 0.0) {
                let diagnostic = Diagnostic::new(
                    Code::InvalidValue,
                    format!("the {what} of a movie must be finite and above 0"),
                );
                return Err(diagnostic.expected_found("a number above 0", format!("{value}")).into());
            }
        }
        super::raster::check_size(options.width, options.height, Code::InvalidValue)?;
        let mut figure = DrawnClip::new(clip);
        let per_second = clip.animation().map_or(1.0, |animation| animation.ticks_per_second);
        let seconds = clip.seconds() - figure.first_tick / per_second;
        let pictures = seconds / options.speed * options.frames_per_second + 1.0;
        if pictures > Self::MOST_PICTURES {
            return Err(Diagnostic::new(Code::LimitExceeded, "the movie has too many pictures")
                .expected_found(
                    format!("at most {} pictures", Self::MOST_PICTURES),
                    format!("{pictures:.0}"),
                )
                .help("choose fewer pictures per second, or a higher speed")
                .into());
        }
        let ticks_per_picture = per_second * options.speed / options.frames_per_second;
        let ticks: Vec<f64> = (0..pictures as usize)
            .map(|index| figure.first_tick + index as f64 * ticks_per_picture)
            .collect();
        let roots: Vec<Vec3> = ticks
            .iter()
            .map(|&tick| {
                let positions = figure.positions(tick);
                figure.ground_below(figure.root(&positions))
            })
            .collect();
        let targets = if options.follow {
            smoothed(&roots, (0.4 * options.frames_per_second) as usize)
        } else {
            vec![roots.iter().sum::<Vec3>() / roots.len() as f32; roots.len()]
        };
        let camera = fitting_camera(&mut figure, &ticks, &targets, options);
        Ok(Self {
            figure,
            options: *options,
            camera,
            targets,
            ticks,
        })
    }

    /// The number of pictures; at least 1.
    pub fn picture_count(&self) -> usize {
        self.ticks.len()
    }

    /// The picture at `index`. Beyond the end, the last picture.
    fn picture(&mut self, index: usize) -> Drawing {
        let index = index.min(self.ticks.len() - 1);
        let tick = self.ticks[index];
        let positions = self.figure.positions(tick);
        let MovieOptions { width, height, .. } = self.options;
        let name = self.figure.clip.name;
        let mut drawing = Drawing::new(width, height, theme::PAPER, name);
        let mut camera = self.camera;
        camera.target = self.targets[index];
        paint_ground(&mut drawing, &camera, &self.figure);
        let body = Body::new(&self.figure, &positions);
        body.paint_shadow(&mut drawing, &camera);
        body.paint(&mut drawing, &camera);
        let per_second = self
            .figure
            .clip
            .animation()
            .map_or(1.0, |animation| animation.ticks_per_second);
        let time = format!("{:.2} s", tick / per_second);
        let (bottom, size) = (height as f32 - 10.0, 11.0);
        let room = width as f32 - 90.0;
        drawing.text(
            [10.0, bottom],
            super::raster::shortened(name, size, room),
            size,
            Anchor::Start,
            theme::FADED,
        );
        drawing.text([width as f32 - 10.0, bottom], time, size, Anchor::End, theme::FADED);
        drawing
    }

    /// The movie as a looping animated GIF. GIF measures time in hundredths of a second.
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] if the width or the height is 0 or too large.
    pub fn to_gif(&mut self) -> Result<Vec<u8>> {
        let mut palette = self.palette()?;
        let (width, height) = (self.options.width as u16, self.options.height as u16);
        let mut bytes = Vec::new();
        // Drawing the first picture checks the size.
        let mut pixels = self.picture(0).to_rgb()?;
        {
            let mut encoder =
                gif::Encoder::new(&mut bytes, width, height, &palette.colors()).expect("memory takes all");
            encoder.set_repeat(gif::Repeat::Infinite).expect("memory takes all");
            for index in 0..self.picture_count() {
                if index > 0 {
                    pixels = self.picture(index).to_rgb()?;
                }
                let indices: Vec<u8> = pixels
                    .as_chunks::<3>()
                    .0
                    .iter()
                    .map(|&rgb| palette.index(rgb))
                    .collect();
                let mut frame = gif::Frame {
                    width,
                    height,
                    buffer: indices.into(),
                    ..gif::Frame::default()
                };
                frame.delay = self.hundredths(index);
                encoder.write_frame(&frame).expect("memory takes all");
            }
        }
        Ok(bytes)
    }

    /// The colours of the whole movie.
    fn palette(&mut self) -> Result<Palette> {
        /// The number of pictures from which the colours of a skin are sampled.
        const SAMPLES: usize = 6;
        if !has_colors(&self.figure) {
            return Ok(Palette::new(has_skin(self.figure.clip.scene)));
        }
        let mut pixels = Vec::new();
        for index in (0..self.picture_count()).step_by(self.picture_count().div_ceil(SAMPLES)) {
            pixels.extend(self.picture(index).to_rgb()?);
        }
        Ok(Palette::with(&pixels))
    }

    /// The duration of a picture. Rounding errors are carried over, so that the movie keeps its length.
    fn hundredths(&self, index: usize) -> u16 {
        let at = |index: usize| (100.0 * index as f64 / self.options.frames_per_second).round();
        (at(index + 1) - at(index)) as u16
    }

    /// The movie as a looping animated PNG. A viewer without support shows the first picture.
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] if the width or the height is 0 or too large.
    pub fn to_apng(&mut self) -> Result<Vec<u8>> {
        const STEADY: &str = "the header is one of an animation of this length, and memory takes all";
        let mut pixels = self.picture(0).to_rgb()?;
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.options.width, self.options.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_animated(self.picture_count() as u32, 0).expect(STEADY);
        let milliseconds = (1000.0 / self.options.frames_per_second).round().clamp(1.0, 65_535.0);
        encoder.set_frame_delay(milliseconds as u16, 1000).expect(STEADY);
        let mut writer = encoder.write_header().expect(STEADY);
        for index in 0..self.picture_count() {
            if index > 0 {
                pixels = self.picture(index).to_rgb()?;
            }
            writer.write_image_data(&pixels).expect(STEADY);
        }
        writer.finish().expect(STEADY);
        Ok(bytes)
    }
}

/// A camera that shows the figure and its shadow in every picture, with a margin. A few dozen pictures determine the
/// bounds.
fn fitting_camera(figure: &mut DrawnClip<'_>, ticks: &[f64], targets: &[Vec3], options: &MovieOptions) -> Camera {
    /// The largest number of frames to which the camera is fitted. In other frames, the figure is between the poses of
    /// these frames.
    const SAMPLES: usize = 48;
    let step = ticks.len().div_ceil(SAMPLES).max(1);
    let poses: Vec<Vec<Vec3>> = ticks.iter().step_by(step).map(|tick| figure.positions(*tick)).collect();
    let mut camera = Camera::three_quarters(figure.heading(poses.iter().map(Vec::as_slice)));
    let mut extent = Extent::default();
    for (&tick, &target) in std::iter::zip(ticks, targets).step_by(step) {
        camera.target = target;
        let positions = figure.positions(tick);
        extent.include(&camera, figure, &positions);
    }
    let (width, height) = (options.width as f32, options.height as f32);
    camera.scale = extent.scale_to(0.8 * width, 0.76 * height);
    camera.middle = [
        0.5 * width - extent.middle() * camera.scale,
        0.86 * height + extent.bottom * camera.scale,
    ];
    camera
}

/// A moving average over `half` pictures on both sides, so that the camera does not sway with the hips.
fn smoothed(path: &[Vec3], half: usize) -> Vec<Vec3> {
    let around = |index: usize| &path[index.saturating_sub(half)..(index + half + 1).min(path.len())];
    (0..path.len())
        .map(|index| around(index).iter().sum::<Vec3>() / around(index).len() as f32)
        .collect()
}

/// Paints a round section of a floor grid. The grid moves under the figure, which makes root motion visible.
fn paint_ground(drawing: &mut Drawing, camera: &Camera, figure: &DrawnClip<'_>) {
    const LINES: i32 = 7;
    let step = figure.reach * 0.5;
    let radius = step * LINES as f32;
    let middle = figure.ground_below(camera.target);
    for (across, along) in [(Vec3::X, Vec3::Z), (Vec3::Z, Vec3::X)] {
        let nearest = (middle.dot(across) / step).round() as i32;
        for line in nearest - LINES..=nearest + LINES {
            let aside = line as f32 * step - middle.dot(across);
            let half = (radius * radius - aside * aside).max(0.0).sqrt();
            let foot = middle + across * aside;
            let ends = [foot - along * half, foot + along * half].map(|end| camera.project(end));
            drawing.line(ends.to_vec(), 1.0, theme::RULE);
        }
    }
}

/// A summary in one line, such as `110 pictures, 4.36 s`.
impl std::fmt::Display for Movie<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let seconds = self.picture_count() as f64 / self.options.frames_per_second;
        let pictures = mocap_scene::report::counted(self.picture_count(), "picture");
        write!(f, "{pictures}, {} s", short(seconds))
    }
}
