//! Grey images from PNG files, sampled by texture coordinates.

use crate::read::{IMAGE_LIMIT, read_file};
use std::fmt;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Largest number of pixels of an image: 8192 x 8192.
pub const MOST_PIXELS: u64 = 1 << 26;

/// An image of one grey value of 8 bits a pixel.
#[derive(Clone, PartialEq, Eq)]
pub struct GreyImage {
    width: usize,
    height: usize,
    pixels: Vec<u8>, // row after row from the top (height x width)
}

/// Error of reading an image.
#[derive(Debug, Error)]
#[error("{}: {problem}", file.display())]
pub struct ImageError {
    /// The file, as named by the caller.
    pub file: PathBuf,
    /// What is wrong with it.
    pub problem: ImageProblem,
}

/// What is wrong with an image.
#[derive(Debug, Error)]
pub enum ImageProblem {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Read(io::Error),
    /// The bytes are not those of a PNG file, or end too soon.
    #[error("not a PNG image that can be decoded: {0}")]
    Decode(#[from] png::DecodingError),
    /// The pixels are of a kind that is not read.
    #[error("{bits} bits a channel, {colour}; allowed is 8 bits a channel, grey or RGB, with or without alpha")]
    Format {
        /// Bits a channel; of an indexed image, bits a pixel.
        bits: u8,
        /// `grey`, `grey and alpha`, `RGB`, `RGBA` or `indexed by a palette`.
        colour: &'static str,
    },
    /// There are too many pixels.
    #[error("{width} x {height} pixels; allowed is at most {MOST_PIXELS} pixels, as of 8192 x 8192")]
    TooLarge {
        /// Pixels in a row.
        width: u32,
        /// Number of rows.
        height: u32,
    },
}

impl fmt::Debug for GreyImage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} x {} pixels", self.width, self.height)
    }
}

impl GreyImage {
    /// Reads the PNG file at `path`.
    ///
    /// # Errors
    /// As for [`GreyImage::parse`], and a file that is not regular, larger than [`IMAGE_LIMIT`] or not readable.
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        let wrong = |problem| ImageError { file: path.into(), problem };
        let bytes = read_file(path, IMAGE_LIMIT).map_err(|error| wrong(ImageProblem::Read(error)))?;
        Self::parse(&bytes).map_err(wrong)
    }

    /// Decodes the bytes of a PNG file, as stored: without gamma. Of colours the luma of Rec. ITU-R BT.709 counts, alpha does not.
    ///
    /// # Errors
    /// [`ImageProblem`] for bytes that are not a whole PNG image, other than 8 bits a channel, palettes, and more than [`MOST_PIXELS`].
    pub fn parse(bytes: &[u8]) -> Result<Self, ImageProblem> {
        let mut decoder = png::Decoder::new(Cursor::new(bytes));
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        // Pixels as they are: no palette is expanded, no channel cut down to 8 bits.
        decoder.set_transformations(png::Transformations::IDENTITY);
        let header = decoder.read_header_info()?;
        let (width, height) = header.size();
        if u64::from(width) * u64::from(height) > MOST_PIXELS {
            return Err(ImageProblem::TooLarge { width, height });
        }
        let (channels, colour) = match header.color_type {
            png::ColorType::Grayscale => (1, "grey"),
            png::ColorType::GrayscaleAlpha => (2, "grey and alpha"),
            png::ColorType::Rgb => (3, "RGB"),
            png::ColorType::Rgba => (4, "RGBA"),
            png::ColorType::Indexed => (0, "indexed by a palette"),
        };
        if channels == 0 || header.bit_depth != png::BitDepth::Eight {
            return Err(ImageProblem::Format { bits: header.bit_depth as u8, colour });
        }
        let mut reader = decoder.read_info()?;
        let mut stored = vec![0; channels * width as usize * height as usize];
        reader.next_frame(&mut stored)?;
        let pixels = stored.chunks_exact(channels).map(grey).collect();
        Ok(Self { width: width as usize, height: height as usize, pixels })
    }

    /// The value, from 0 (black) to 1 (white), at texture coordinates: u goes right and v up from the lower left corner, and the image repeats
    /// outside of 0 and 1. The value is bilinear between the middles of pixels and constant from the outermost ones to the border, so that
    /// nothing of the opposite border shows where a coordinate is 0 or 1.
    pub fn sample(&self, [u, v]: [f64; 2]) -> f64 {
        let column = neighbours(within_tile(u), self.width);
        let row = neighbours(1.0 - within_tile(v), self.height);
        let value = |x: usize, y: usize| f64::from(self.pixels[y * self.width + x]) / 255.0;
        let between = |a: f64, b: f64, share: f64| a + share * (b - a);
        let along = |y: usize| between(value(column.first, y), value(column.second, y), column.share);
        between(along(row.first), along(row.second), row.share)
    }

    /// Least and greatest value of a pixel, 0 to 1.
    pub fn range(&self) -> [f64; 2] {
        let (low, high) = self.pixels.iter().fold((u8::MAX, 0), |(low, high), p| (low.min(*p), high.max(*p)));
        [low, high].map(|value| f64::from(value) / 255.0)
    }
}

/// Two neighbouring pixels along an axis, and the share of the second.
struct Neighbours {
    first: usize,
    second: usize,
    share: f64,
}

/// A texture coordinate in the tile from 0 to 1, both included.
fn within_tile(at: f64) -> f64 {
    if (0.0..=1.0).contains(&at) { at } else { at - at.floor() }
}

/// The pixels around a place from 0 to 1 along an axis of `count` pixels.
fn neighbours(at: f64, count: usize) -> Neighbours {
    let last = count - 1;
    let from_first_middle = (at * count as f64 - 0.5).clamp(0.0, last as f64);
    let first = from_first_middle as usize;
    Neighbours { first, second: (first + 1).min(last), share: from_first_middle - first as f64 }
}

/// Grey of a pixel with 1 to 4 channels of 8 bits. Luma of equal channels is their value.
fn grey(channels: &[u8]) -> u8 {
    match *channels {
        [red, green, blue] | [red, green, blue, _] => {
            let weighted = 2126 * u32::from(red) + 7152 * u32::from(green) + 722 * u32::from(blue);
            ((weighted + 5000) / 10_000) as u8
        }
        [value, ..] => value,
        [] => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Random, grey_png, png_bytes};

    /// The value at a place from the definition: the sum of the hat functions of all pixels, at the nearest place where they add up to 1.
    fn by_hats(values: &[u8], width: usize, height: usize, [u, v]: [f64; 2]) -> f64 {
        let hat = |at: f64, middle: f64, count: f64| (1.0 - (at.clamp(0.5, count - 0.5) - middle).abs()).max(0.0);
        let (x, y) = (u.rem_euclid(1.0) * width as f64, (1.0 - v.rem_euclid(1.0)) * height as f64);
        let weight = |i: usize| {
            let (column, row) = ((i % width) as f64, (i / width) as f64);
            hat(x, column + 0.5, width as f64) * hat(y, row + 0.5, height as f64)
        };
        values.iter().enumerate().map(|(i, value)| weight(i) * f64::from(*value) / 255.0).sum()
    }

    #[test]
    fn samples_are_bilinear_and_repeat() {
        let mut random = Random(1);
        for _ in 0..50 {
            let [width, height] = [1 + random.below(9) as usize, 1 + random.below(9) as usize];
            let values: Vec<u8> = (0..width * height).map(|_| random.next_u64() as u8).collect();
            let image = GreyImage::parse(&grey_png(width, height, &values)).unwrap();
            for _ in 0..100 {
                let at = [6.0 * random.unit() - 3.0, 6.0 * random.unit() - 3.0];
                let (found, exact) = (image.sample(at), by_hats(&values, width, height, at));
                assert!((found - exact).abs() < 1e-12, "{width} x {height} at {at:?}: {found}, exact {exact}");
            }
            // The borders of the first tile belong to it.
            assert_eq!(image.sample([1.0, 1.0]), f64::from(values[width - 1]) / 255.0);
            assert_eq!(image.sample([0.0, 0.0]), f64::from(values[(height - 1) * width]) / 255.0);
            let least = f64::from(*values.iter().min().unwrap()) / 255.0;
            assert_eq!(image.range()[0], least);
        }
    }

    #[test]
    fn middles_of_pixels_have_their_values_whatever_the_channels_are() {
        use png::ColorType::{Grayscale, GrayscaleAlpha, Rgb, Rgba};
        let grey: Vec<u8> = (0..=255).collect();
        for (colour, channels) in [(Grayscale, 1), (GrayscaleAlpha, 2), (Rgb, 3), (Rgba, 4)] {
            let stored: Vec<u8> = grey.iter().flat_map(|value| vec![*value; channels]).collect();
            let image = GreyImage::parse(&png_bytes(16, 16, colour, png::BitDepth::Eight, &stored)).unwrap();
            for (i, value) in grey.iter().enumerate() {
                let at = [(i % 16) as f64 / 16.0 + 1.0 / 32.0, 1.0 - (i / 16) as f64 / 16.0 - 1.0 / 32.0];
                assert_eq!(image.sample(at), f64::from(*value) / 255.0, "{colour:?} {at:?}");
            }
        }
    }

    #[test]
    fn what_is_not_read_is_named() {
        use png::BitDepth::{Eight, Four, Sixteen};
        use png::ColorType::{Grayscale, Indexed, Rgb};
        let said = |bytes: &[u8]| GreyImage::parse(bytes).unwrap_err().to_string();
        assert!(said(&png_bytes(2, 2, Rgb, Sixteen, &[7; 24])).contains("16 bits a channel, RGB; allowed is 8"));
        assert!(said(&png_bytes(2, 2, Grayscale, Four, &[7; 2])).contains("4 bits a channel, grey; allowed is 8"));
        assert!(said(&png_bytes(2, 2, Indexed, Eight, &[0; 4])).contains("indexed by a palette; allowed is"));
        let whole = png_bytes(32, 32, Grayscale, Eight, &[7; 1024]);
        for length in 0..whole.len() - 12 {
            assert!(said(&whole[..length]).contains("not a PNG image"), "{length} bytes of {}", whole.len());
        }
        // A header of 2^31 - 1 pixels each way, with the checksum of its chunk.
        let mut huge = whole;
        let side = (i32::MAX as u32).to_be_bytes();
        huge[16..20].copy_from_slice(&side);
        huge[20..24].copy_from_slice(&side);
        let checksum = crc32(&huge[12..29]).to_be_bytes();
        huge[29..33].copy_from_slice(&checksum);
        assert!(said(&huge).contains("2147483647 x 2147483647 pixels; allowed is at most"), "{}", said(&huge));
    }

    /// CRC-32 of PNG chunks (ISO 3309), bit by bit.
    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(u32::MAX, |sum, byte| {
            (0..8).fold(sum ^ u32::from(*byte), |s, _| if s & 1 == 1 { s >> 1 ^ 0xedb8_8320 } else { s >> 1 })
        })
    }
}
