//! PNG files (ISO/IEC 15948) of 8-bit RGB, by the crate `png`: the same bytes everywhere.

use png::{BitDepth, ColorType, Decoder, DeflateCompression, Encoder, Filter, PixelDimensions, Unit};
use std::io::{Cursor, Write};

/// Dots a metre: 300 an inch.
const DENSITY: u32 = 11_811;
/// Most bytes that a byte of a Deflate stream (RFC 1951) can become.
const MOST_EXPANSION: usize = 1032;

/// How files are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Small.
    Small,
    /// In less time; the file is somewhat larger.
    Fast,
}

/// A PNG file of width x height pixels, red, green, blue, from the upper row down.
///
/// # Panics
/// If there aren't 3 bytes a pixel.
pub fn encode([width, height]: [u32; 2], rgb: &[u8], effort: Effort) -> Vec<u8> {
    assert_eq!(rgb.len(), 3 * width as usize * height as usize, "three bytes a pixel");
    let mut out = Vec::new();
    let mut encoder = encoder(&mut out, [width, height], effort);
    let density = PixelDimensions { xppu: DENSITY, yppu: DENSITY, unit: Unit::Meter };
    encoder.set_pixel_dims(Some(density));
    let mut writer = encoder.write_header().expect("a vector takes all");
    writer.write_image_data(rgb).expect("as many bytes as announced");
    writer.finish().expect("a vector takes all");
    out
}

/// An encoder of 8-bit RGB.
pub(super) fn encoder<'a, W: Write>(out: W, [width, height]: [u32; 2], effort: Effort) -> Encoder<'a, W> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_filter(Filter::Adaptive);
    encoder.set_deflate_compression(DeflateCompression::Level(match effort {
        Effort::Small => 6,
        Effort::Fast => 1,
    }));
    encoder
}

/// The size and the pixels of a file of 8-bit RGB, if it is one and whole.
pub fn decode(file: &[u8]) -> Option<([u32; 2], Vec<u8>)> {
    let mut reader = Decoder::new(Cursor::new(file)).read_info().ok()?;
    let bytes = reader.output_buffer_size().filter(|bytes| bytes / MOST_EXPANSION <= file.len())?;
    let mut rgb = vec![0; bytes];
    let frame = reader.next_frame(&mut rgb).ok()?;
    let is_rgb = frame.color_type == ColorType::Rgb && frame.bit_depth == BitDepth::Eight;
    is_rgb.then_some(([frame.width, frame.height], rgb))
}

/// Width and height of a PNG file, if it is one.
pub fn size(file: &[u8]) -> Option<[u32; 2]> {
    let mut decoder = Decoder::new(Cursor::new(file));
    let header = decoder.read_header_info().ok()?;
    Some([header.width, header.height])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_come_back() {
        let (width, height) = (7, 5);
        let rgb: Vec<u8> = (0..3 * width * height).map(|n| (n * n % 251) as u8).collect();
        for effort in [Effort::Small, Effort::Fast] {
            let file = encode([width, height], &rgb, effort);
            assert_eq!(size(&file), Some([7, 5]));
            assert_eq!(decode(&file), Some(([7, 5], rgb.clone())));
            for length in 0..file.len() - 12 {
                assert_eq!(decode(&file[..length]), None, "{length} bytes");
            }
            assert_eq!(size(&file[..18]), None);
        }
        assert_eq!(size(b"no picture at all, but long enough"), None);
    }

    #[test]
    fn what_announces_too_much_is_no_picture() {
        let mut file = encode([7, 5], &[0; 105], Effort::Small);
        // Width and height of the header, and its checksum.
        file[16..24].copy_from_slice(&[0x40, 0, 0, 0, 0x40, 0, 0, 0]);
        let mut crc = flate2::Crc::new();
        crc.update(&file[12..29]);
        file[29..33].copy_from_slice(&crc.sum().to_be_bytes());
        assert_eq!(size(&file), Some([1 << 30; 2]));
        assert_eq!(decode(&file), None);
    }
}
