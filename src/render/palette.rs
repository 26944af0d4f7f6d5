//! The 256 colours of a GIF.

use std::collections::HashMap;

use super::surface::shades;
use super::theme;

/// All painted colours, and their blends with the background.
pub struct Palette {
    pub colors: Vec<[u8; 3]>,
    nearest: HashMap<[u8; 3], u8>,
}

/// The largest number of colours in a GIF.
pub const MOST: usize = 256;

impl Palette {
    /// The palette for a grey skin, or for a skeleton.
    pub fn new(has_skin: bool) -> Self {
        let sides = [theme::LEFT, theme::RIGHT, theme::MIDDLE];
        let bones = sides.map(|color| {
            [
                color.mix(theme::PAPER, 0.22),
                color.mix(theme::INK, 0.12),
                color.mix(theme::INK, 0.35),
            ]
        });
        let mut colors = Self::blends(bones.into_iter().flatten());
        if has_skin {
            for shade in shades() {
                colors.push(shade.rgb);
                colors.push(theme::PAPER.mix(shade, 0.5).rgb);
            }
        }
        Self::of(colors)
    }

    /// The palette for a coloured skin, from the pixels of some pictures.
    pub fn with(pixels: &[u8]) -> Self {
        let mut colors = Self::blends(std::iter::empty());
        let mut counts: HashMap<[u8; 3], usize> = HashMap::new();
        for rgb in pixels.as_chunks::<3>().0 {
            *counts.entry(*rgb).or_default() += 1;
        }
        for known in &colors {
            counts.remove(known);
        }
        let mut counted: Vec<_> = counts.into_iter().collect();
        // A map has no order. Sort, so that every run gives the same colours.
        counted.sort_unstable();
        let room = MOST - colors.len();
        colors.extend(median_cut(counted, room));
        Self::of(colors)
    }

    /// The blends of colours with the background and the shadow, and the colours of ground and text.
    fn blends(painted: impl Iterator<Item = super::drawing::Color>) -> Vec<[u8; 3]> {
        /// The number of shades between a colour and the background. A dozen makes edges smooth.
        const STEPS: usize = 12;
        let mut colors = vec![theme::PAPER.rgb];
        for color in painted.chain([theme::FADED, theme::RULE, theme::SHADOW]) {
            let step = |step: usize| 1.0 - step as f32 / STEPS as f32;
            colors.extend((0..STEPS).map(|index| theme::PAPER.mix(color, step(index)).rgb));
            colors.extend((1..STEPS / 2).map(|index| theme::SHADOW.mix(color, step(2 * index)).rgb));
        }
        colors
    }

    fn of(mut colors: Vec<[u8; 3]>) -> Self {
        colors.truncate(MOST);
        Self {
            colors,
            nearest: HashMap::new(),
        }
    }

    pub(super) fn colors(&self) -> Vec<u8> {
        self.colors.concat()
    }

    pub fn index(&mut self, rgb: [u8; 3]) -> u8 {
        let colors = &self.colors;
        *self.nearest.entry(rgb).or_insert_with(|| {
            let distance = |color: &[u8; 3]| -> i32 {
                std::iter::zip(color, rgb)
                    .map(|(&a, b)| (i32::from(a) - i32::from(b)).pow(2))
                    .sum()
            };
            let closest = (0..colors.len()).min_by_key(|&index| distance(&colors[index]));
            closest.unwrap_or(0) as u8
        })
    }
}

/// Reduces many colours, each with its count, to at most `room`. The box with the widest range is cut at its median
/// (Heckbert, "Color image quantization for frame buffer display", 1982).
pub fn median_cut(counted: Vec<([u8; 3], usize)>, room: usize) -> Vec<[u8; 3]> {
    let range = |part: usize, colors: &[([u8; 3], usize)]| {
        let values = || colors.iter().map(|(rgb, _)| rgb[part]);
        values().max().unwrap_or(0) - values().min().unwrap_or(0)
    };
    let widest =
        |colors: &Vec<([u8; 3], usize)>| (0..3).map(|part| (range(part, colors), part)).max().unwrap_or((0, 0));
    let mut boxes = vec![counted];
    while boxes.len() < room {
        let found = (0..boxes.len()).max_by_key(|index| {
            let pixels: usize = boxes[*index].iter().map(|(_, count)| count).sum();
            usize::from(widest(&boxes[*index]).0) * pixels.min(4096)
        });
        let Some(index) = found.filter(|index| boxes[*index].len() > 1) else {
            break;
        };
        let (_, part) = widest(&boxes[index]);
        let mut colors = std::mem::take(&mut boxes[index]);
        colors.sort_unstable_by_key(|(rgb, _)| (rgb[part], *rgb));
        let half: usize = colors.iter().map(|(_, count)| count).sum::<usize>() / 2;
        let mut seen = 0;
        let middle = colors.iter().position(|(_, count)| {
            seen += count;
            seen > half
        });
        let upper = colors.split_off(middle.unwrap_or(1).clamp(1, colors.len() - 1));
        boxes[index] = colors;
        boxes.push(upper);
    }
    let mean = |colors: &Vec<([u8; 3], usize)>| {
        let count: usize = colors.iter().map(|(_, count)| count).sum();
        [0, 1, 2].map(|part| {
            let sum: usize = colors.iter().map(|(rgb, count)| usize::from(rgb[part]) * count).sum();
            (sum as f64 / count as f64).round() as u8
        })
    };
    boxes.iter().filter(|colors| !colors.is_empty()).map(mean).collect()
}
