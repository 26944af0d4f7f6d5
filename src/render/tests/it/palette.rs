//! Tests the palettes of 256 colours for GIF files.

use mocap_render::internals::palette::{MOST, Palette, median_cut};
use mocap_render::internals::{Color, theme};

#[test]
fn the_palette_fits_and_holds_what_is_painted() {
    let mut palette = Palette::new(false);
    assert!(palette.colors.len() <= MOST);
    for Color { rgb, .. } in [
        theme::PAPER,
        theme::RULE,
        theme::SHADOW,
        theme::LEFT.mix(theme::INK, 0.12),
    ] {
        let index = usize::from(palette.index(rgb));
        assert_eq!(palette.colors[index], rgb);
    }
}

/// Every grey and red is near one of these colours.
#[test]
fn many_colours_become_256() {
    let pixels: Vec<u8> = (0..=255u8)
        .flat_map(|value| [[value; 3], [value, 0, 0]])
        .flatten()
        .collect();
    let mut palette = Palette::with(&pixels);
    assert!(palette.colors.len() <= MOST);
    for rgb in pixels.as_chunks::<3>().0 {
        let index = usize::from(palette.index(*rgb));
        let nearest = palette.colors[index];
        assert!(
            std::iter::zip(rgb, nearest).all(|(a, b)| a.abs_diff(b) <= 4),
            "{rgb:?} {nearest:?}"
        );
    }
    assert_eq!(median_cut(Vec::new(), 9), Vec::<[u8; 3]>::new());
}
