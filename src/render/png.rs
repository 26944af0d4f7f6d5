//! PNG files, still and animated: W3C, Portable Network Graphics, third edition, <https://www.w3.org/TR/png-3/>.

use zlib_rs::{DeflateConfig, compress_bound, compress_slice, crc32::crc32};

const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Of the ten levels of zlib. A higher one takes longer and saves little of flat colours.
const LEVEL: i32 = 6;

/// What a pixel has, one byte each.
#[derive(Clone, Copy)]
pub(super) enum Channels {
    Rgb,
    Rgba,
}

impl Channels {
    const fn count(self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::Rgba => 4,
        }
    }

    /// The format's number for it.
    const fn color_type(self) -> u8 {
        match self {
            Self::Rgb => 2,
            Self::Rgba => 6,
        }
    }
}

/// A file that is being written.
pub(super) struct Png {
    bytes: Vec<u8>,
    width: u32,
    height: u32,
    channels: Channels,
    /// The milliseconds that each picture is shown, if there are several.
    delay: Option<u16>,
    pictures: u32,
    /// Chunks of the animation so far, which are numbered.
    sequence: u32,
}

impl Png {
    /// One picture. Width and height are above 0.
    pub(super) fn new(width: u32, height: u32, channels: Channels) -> Self {
        let mut png = Self {
            bytes: SIGNATURE.to_vec(),
            width,
            height,
            channels,
            delay: None,
            pictures: 0,
            sequence: 0,
        };
        const BITS: u8 = 8;
        // Compression, filters and interlacing: there is one number of the first two, and 0 is without the last.
        let depth = [BITS, channels.color_type(), 0, 0, 0];
        png.chunk(b"IHDR", &[&width.to_be_bytes(), &height.to_be_bytes(), &depth]);
        png
    }

    /// So many pictures, each shown for so many milliseconds, without end.
    pub(super) fn animated(mut self, pictures: u32, delay: u16) -> Self {
        const WITHOUT_END: u32 = 0;
        self.chunk(b"acTL", &[&pictures.to_be_bytes(), &WITHOUT_END.to_be_bytes()]);
        self.delay = Some(delay);
        self
    }

    /// Adds a picture: its pixels, row by row from the top.
    pub(super) fn add(&mut self, pixels: &[u8]) {
        if let Some(delay) = self.delay {
            const MILLISECONDS: u16 = 1000;
            // At the left and the top; it stays until the next, and covers the one before.
            let (corner, stays_and_covers) = ([0; 8], [0; 2]);
            let [sequence, width, height] = [self.next(), self.width, self.height].map(u32::to_be_bytes);
            let shown = [delay, MILLISECONDS].map(u16::to_be_bytes);
            self.chunk(
                b"fcTL",
                &[
                    &sequence,
                    &width,
                    &height,
                    &corner,
                    shown.as_flattened(),
                    &stays_and_covers,
                ],
            );
        }
        let data = compressed(&filtered(pixels, self.width as usize, self.channels.count()));
        if self.pictures == 0 {
            self.chunk(b"IDAT", &[&data]);
        } else {
            let sequence = self.next().to_be_bytes();
            self.chunk(b"fdAT", &[&sequence, &data]);
        }
        self.pictures += 1;
    }

    pub(super) fn finish(mut self) -> Vec<u8> {
        self.chunk(b"IEND", &[]);
        self.bytes
    }

    fn next(&mut self) -> u32 {
        self.sequence += 1;
        self.sequence - 1
    }

    /// The length of the data, the type, the data, and the sum of both.
    fn chunk(&mut self, kind: &[u8; 4], data: &[&[u8]]) {
        let length: usize = data.iter().map(|part| part.len()).sum();
        self.bytes.extend((length as u32).to_be_bytes());
        let begin = self.bytes.len();
        self.bytes.extend(kind);
        data.iter().for_each(|part| self.bytes.extend(*part));
        let sum = crc32(0, &self.bytes[begin..]);
        self.bytes.extend(sum.to_be_bytes());
    }
}

fn compressed(plain: &[u8]) -> Vec<u8> {
    let mut stream = vec![0; compress_bound(plain.len())];
    let length = compress_slice(&mut stream, plain, DeflateConfig::new(LEVEL)).0.len();
    stream.truncate(length);
    stream
}

/// The rows, each behind the number of its filter, which takes the left pixel or the upper one from each. Of these the
/// one whose differences are smallest in sum is chosen, as the specification recommends (12.7).
fn filtered(pixels: &[u8], width: usize, channels: usize) -> Vec<u8> {
    let length = width * channels;
    let mut rows = Vec::with_capacity(pixels.len() + pixels.len() / length);
    let mut upper: &[u8] = &vec![0; length];
    let (mut by_left, mut by_upper) = (Vec::with_capacity(length), Vec::with_capacity(length));
    for row in pixels.chunks_exact(length) {
        by_left.clear();
        by_left.extend(&row[..channels]);
        by_left.extend(std::iter::zip(&row[channels..], row).map(|(here, left)| here.wrapping_sub(*left)));
        by_upper.clear();
        by_upper.extend(std::iter::zip(row, upper).map(|(here, above)| here.wrapping_sub(*above)));
        let sum = |values: &[u8]| -> u64 {
            let sizes = values.iter().map(|value| u64::from(value.cast_signed().unsigned_abs()));
            sizes.sum()
        };
        let filters = [(0, row), (1, by_left.as_slice()), (2, by_upper.as_slice())];
        let (filter, values) = filters
            .into_iter()
            .min_by_key(|(_, values)| sum(values))
            .unwrap_or((0, row));
        rows.push(filter);
        rows.extend(values);
        upper = row;
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows for which each of the filters is chosen.
    fn picture(width: u32, height: u32, channels: usize, seed: u32) -> Vec<u8> {
        let at = |row: u32, column: u32, channel: u32| match row % 3 {
            0 => (row * 91 + column * 7 * seed + channel * 40) as u8,
            1 => (row / 3 * 5 + channel + (column * column * 31) % 251) as u8,
            _ => u8::from((row + column).is_multiple_of(5)) * 3,
        };
        let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (row, column)));
        pixels
            .flat_map(|(row, column)| (0..channels as u32).map(move |channel| at(row, column, channel)))
            .collect()
    }

    /// Read by another's decoder.
    #[test]
    fn pixels_come_back() {
        let kinds = [
            (Channels::Rgb, png::ColorType::Rgb),
            (Channels::Rgba, png::ColorType::Rgba),
        ];
        for (channels, color) in kinds {
            for (width, height) in [(1, 1), (1, 9), (64, 48), (333, 7)] {
                let pixels = picture(width, height, channels.count(), 3);
                let mut file = Png::new(width, height, channels);
                file.add(&pixels);
                let bytes = file.finish();
                let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
                assert_eq!((reader.info().width, reader.info().height), (width, height));
                assert_eq!(reader.info().color_type, color);
                let mut found = vec![0; pixels.len()];
                reader.next_frame(&mut found).unwrap();
                reader.finish().unwrap();
                assert!(found == pixels, "{width} x {height}");
            }
        }
    }

    #[test]
    fn every_picture_of_a_film_comes_back() {
        let (width, height) = (40, 30);
        let mut file = Png::new(width, height, Channels::Rgb).animated(3, 40);
        let pictures = [1, 2, 3].map(|seed| picture(width, height, 3, seed));
        pictures.iter().for_each(|pixels| file.add(pixels));
        let bytes = file.finish();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let animation = reader.info().animation_control().unwrap();
        assert_eq!((animation.num_frames, animation.num_plays), (3, 0));
        for pixels in &pictures {
            let mut found = vec![0; pixels.len()];
            reader.next_frame(&mut found).unwrap();
            assert!(found == *pixels);
            let frame = reader.info().frame_control().unwrap();
            assert_eq!((frame.delay_num, frame.delay_den), (40, 1000));
        }
        reader.finish().unwrap();
    }
}
