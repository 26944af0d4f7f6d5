//! Tests how textures are read and sampled.

use mocap::glam::Vec2;
use mocap::scene::{AlphaMode, Surface, Wrap};
use mocap_render::internals::png_of;
use mocap_render::internals::texture::{Image, Paint};

/// The upper row is red and green, the lower row blue and transparent.
fn image() -> Image {
    let pixels = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [9, 9, 9, 0]];
    Image {
        width: 2,
        height: 2,
        pixels,
    }
}

#[test]
fn a_texture_goes_on_beyond_its_edges() {
    let (image, beyond) = (image(), Vec2::new(1.25, 0.75));
    assert_eq!(image.at(beyond, [Wrap::Repeat; 2]), [0, 0, 255, 255]);
    assert_eq!(image.at(beyond, [Wrap::Mirror; 2])[3], 0);
    assert_eq!(image.at(beyond, [Wrap::Clamp; 2])[3], 0);
    assert_eq!(image.at(Vec2::new(0.25, 0.25), [Wrap::Repeat; 2]), [255, 0, 0, 255]);
    assert_eq!(image.at(Vec2::new(f32::NAN, f32::INFINITY), [Wrap::Repeat; 2]).len(), 4);
}

#[test]
fn what_is_transparent_is_not_there() {
    let image = image();
    let mut paint = Paint {
        surface: Surface::default(),
        image: Some(&image),
    };
    let nothing = Vec2::new(0.75, 0.75);
    assert_eq!(paint.color(nothing, 1.0), Some([9; 3]));
    paint.surface.alpha = AlphaMode::Mask(0.5);
    assert_eq!(paint.color(nothing, 1.0), None);
    assert_eq!(paint.color(Vec2::new(0.25, 0.25), 0.5), Some([128, 0, 0]));
}

#[test]
fn images_that_are_broken_or_too_large_are_not_read() {
    let png = png_of(2, 1, png::ColorType::Rgb, &[1, 2, 3, 4, 5, 6]);
    let read = Image::read(&png, &mut 2).unwrap();
    assert_eq!(
        (read.width, read.height, read.pixels),
        (2, 1, vec![[1, 2, 3, 255], [4, 5, 6, 255]])
    );
    assert!((0..png.len() - 12).all(|length| Image::read(&png[..length], &mut 2).is_none()));
    assert!(Image::read(&png, &mut 1).is_none());
    let mut wide = png.clone();
    wide[16..20].copy_from_slice(&100_000_u32.to_be_bytes());
    assert!(Image::read(&wide, &mut { usize::MAX }).is_none());
    assert!(Image::read(b"RIFF    WEBP", &mut 2).is_none());
}
