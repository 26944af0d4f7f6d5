//! Textures and material colours for drawing a skin.

use glam::{Vec2, Vec3, Vec4};
use mocap_scene::scene::{AlphaMode, Mesh, Scene, Surface, Wrap};

use super::image_size::image_size;

/// The largest width or height of a texture in pixels.
const WIDEST: u32 = 4096;
/// The number of pixels that the textures of any scene may have together, however small their files are: one texture of
/// the largest size.
const ANY_PIXELS: usize = 4096 * 4096;
/// The number of pixels allowed for each byte of the texture files. Reading a texture takes 8 bytes per pixel.
const PIXELS_PER_BYTE: usize = 8;

/// The smallest opacity at which a half-transparent surface is drawn, as a fraction: nearer to opaque than to
/// invisible.
const HALF: f32 = 0.5;

/// An image, row by row from the top: red, green, blue and opacity, in sRGB.
pub struct Image {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[u8; 4]>,
}

impl Image {
    /// Decodes a PNG or JPEG file. `None` for other and broken files, for images that are too large, and if the pixel
    /// budget is used up.
    pub fn read(bytes: &[u8], left: &mut usize) -> Option<Self> {
        let (media_type, [width, height]) = image_size(bytes)?;
        if width.max(height) > WIDEST || width.min(height) == 0 {
            return None;
        }
        let (width, height) = (width as usize, height as usize);
        *left = left.checked_sub(width * height)?;
        let pixels = match media_type {
            "image/png" => of_png(bytes)?,
            "image/jpeg" => of_jpeg(bytes)?,
            _ => return None,
        };
        (pixels.len() == width * height).then_some(Self { width, height, pixels })
    }

    /// The pixel at texture coordinates, which start at the upper left.
    pub fn at(&self, coords: Vec2, wrap: [Wrap; 2]) -> [u8; 4] {
        let pixel = |coordinate: f32, wrap: Wrap, count: usize| {
            let within = match wrap {
                Wrap::Repeat => coordinate.rem_euclid(1.0),
                Wrap::Mirror => 1.0 - (coordinate.rem_euclid(2.0) - 1.0).abs(),
                Wrap::Clamp => coordinate.clamp(0.0, 1.0),
            };
            ((within * count as f32) as usize).min(count - 1)
        };
        let column = pixel(coords.x, wrap[0], self.width);
        let row = pixel(coords.y, wrap[1], self.height);
        self.pixels[row * self.width + column]
    }
}

fn of_png(bytes: &[u8]) -> Option<Vec<[u8; 4]>> {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8() | png::Transformations::ALPHA);
    let mut reader = decoder.read_info().ok()?;
    let mut buffer = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut buffer).ok()?;
    let bytes = &buffer[..info.buffer_size()];
    Some(match info.color_type {
        png::ColorType::Rgba => bytes.as_chunks::<4>().0.to_vec(),
        png::ColorType::GrayscaleAlpha => {
            let pixels = bytes.as_chunks::<2>().0.iter();
            pixels.map(|&[grey, alpha]| [grey, grey, grey, alpha]).collect()
        }
        _ => return None,
    })
}

fn of_jpeg(bytes: &[u8]) -> Option<Vec<[u8; 4]>> {
    let mut decoder = jpeg_decoder::Decoder::new(bytes);
    let pixels = decoder.decode().ok()?;
    match decoder.info()?.pixel_format {
        jpeg_decoder::PixelFormat::RGB24 => {
            let pixels = pixels.as_chunks::<3>().0.iter();
            Some(pixels.map(|&[red, green, blue]| [red, green, blue, 255]).collect())
        }
        jpeg_decoder::PixelFormat::L8 => Some(pixels.into_iter().map(|grey| [grey, grey, grey, 255]).collect()),
        _ => None,
    }
}

/// The images that the materials of a scene use.
pub(super) struct Images(Vec<Option<Image>>);

impl Images {
    pub(super) fn of(scene: &Scene) -> Self {
        let named: Vec<usize> = scene
            .materials
            .iter()
            .filter_map(|material| material.surface?.texture)
            .collect();
        let bytes: usize = scene.textures.iter().map(|texture| texture.bytes.len()).sum();
        let mut left = bytes.saturating_mul(PIXELS_PER_BYTE).saturating_add(ANY_PIXELS);
        let textures = scene.textures.iter().enumerate();
        Self(
            textures
                .map(|(index, texture)| {
                    named
                        .contains(&index)
                        .then(|| Image::read(&texture.bytes, &mut left))
                        .flatten()
                })
                .collect(),
        )
    }

    /// The colours of a mesh. `None` if the file states no colours, or if the colour is white without an image.
    pub(super) fn paint<'a>(&'a self, scene: &Scene, mesh: &'a Mesh) -> Option<Paint<'a>> {
        let surface = scene.materials.get(mesh.material_index)?.surface?;
        let image = surface.texture.and_then(|texture| self.0.get(texture)?.as_ref());
        let image = image.filter(|_| mesh.texture_coords.len() == mesh.vertices.len());
        let is_plain = image.is_none() && surface.base_color.truncate() == Vec3::ONE;
        (!is_plain).then_some(Paint { surface, image })
    }
}

/// The colouring of a mesh.
pub struct Paint<'a> {
    pub surface: Surface,
    pub image: Option<&'a Image>,
}

impl Paint<'_> {
    /// The colour at texture coordinates in light of a brightness from 0 to 1; `None` if the surface is invisible
    /// there.
    pub fn color(&self, coords: Vec2, brightness: f32) -> Option<[u8; 3]> {
        let base = self.surface.base_color;
        let texel = self.image.map_or([255; 4], |image| image.at(coords, self.surface.wrap));
        let alpha = f32::from(texel[3]) / 255.0 * base.w;
        let least = match self.surface.alpha {
            AlphaMode::Opaque => f32::NEG_INFINITY,
            AlphaMode::Mask(cutoff) => cutoff,
            AlphaMode::Blend => HALF,
        };
        let tint = Vec4::ONE
            .min(base.max(Vec4::ZERO))
            .to_array()
            .map(|linear| linear.powf(1.0 / 2.2));
        let value = |part: usize| (f32::from(texel[part]) * tint[part] * brightness).round() as u8;
        (alpha >= least).then(|| [value(0), value(1), value(2)])
    }
}
