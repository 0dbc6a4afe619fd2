//! PNG files (ISO/IEC 15948) of 8-bit RGB: the same bytes everywhere.

use flate2::Crc;
use flate2::{Compression, read::ZlibDecoder, write::ZlibEncoder};
use std::io::{Read, Write};

/// Dots a metre: 300 an inch.
const DENSITY: u32 = 11_811;
pub(super) const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// How files are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Small, in some 40 ms a megapixel.
    Small,
    /// Fast.
    Fast,
}

/// A PNG file of width x height pixels, red, green, blue, from the upper row down.
///
/// # Panics
/// If there aren't 3 bytes a pixel.
pub fn encode([width, height]: [u32; 2], rgb: &[u8], effort: Effort) -> Vec<u8> {
    let row = 3 * width as usize;
    assert_eq!(rgb.len(), row * height as usize, "three bytes a pixel");
    let mut out = SIGNATURE.to_vec();
    let mut header = [width.to_be_bytes(), height.to_be_bytes()].concat();
    // 8 bits, RGB, the only compression and filtering, not interlaced.
    header.extend([8, 2, 0, 0, 0]);
    chunk(&mut out, b"IHDR", &header);
    chunk(&mut out, b"pHYs", &[&DENSITY.to_be_bytes()[..], &DENSITY.to_be_bytes(), &[1]].concat());
    chunk(&mut out, b"IDAT", &compressed(rgb, row, effort));
    chunk(&mut out, b"IEND", &[]);
    out
}

/// Filtered and compressed rows of `row` bytes.
pub(super) fn compressed(rgb: &[u8], row: usize, effort: Effort) -> Vec<u8> {
    let level = match effort {
        Effort::Small => 6,
        Effort::Fast => 1,
    };
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(level));
    let mut above = vec![0; row];
    for line in rgb.chunks(row.max(1)) {
        encoder.write_all(&filtered(line, &above)).expect("a vector takes all");
        above.copy_from_slice(line);
    }
    encoder.finish().expect("a vector takes all")
}

/// The pixels of a file that [`encode`] made, if it is one, and its size.
pub fn decode(file: &[u8]) -> Option<([u32; 2], Vec<u8>)> {
    let [width, height] = size(file)?;
    let row = 3usize.checked_mul(width as usize)?;
    let mut rest = file.get(SIGNATURE.len()..)?;
    let mut data = Vec::new();
    while let Some((head, body)) = rest.split_first_chunk::<8>() {
        let length = u32::from_be_bytes(*head.first_chunk()?) as usize;
        match &head[4..] {
            b"IHDR" if body.get(8..13)? != [8, 2, 0, 0, 0] => return None,
            b"IDAT" => data.extend(body.get(..length)?),
            _ => (),
        }
        rest = body.get(length.checked_add(4)?..)?;
    }
    // Zlib can't make more than about a thousandfold of its bytes.
    let bytes = (row + 1).checked_mul(height as usize).filter(|&bytes| bytes / 1040 <= data.len())?;
    let mut rows = vec![0; bytes];
    ZlibDecoder::new(&data[..]).read_exact(&mut rows).ok()?;
    let mut rgb: Vec<u8> = Vec::with_capacity(row * height as usize);
    for line in rows.chunks(row + 1) {
        for (at, &x) in line[1..].iter().enumerate() {
            let from = |there: bool, back: usize| if there { rgb[rgb.len() - back] } else { 0 };
            let predicted = match line[0] {
                0 => 0,
                1 => from(at >= 3, 3),
                2 => from(rgb.len() >= row, row),
                _ => return None,
            };
            rgb.push(x.wrapping_add(predicted));
        }
    }
    Some(([width, height], rgb))
}

/// Width and height of a PNG file, if it is one.
pub fn size(file: &[u8]) -> Option<[u32; 2]> {
    let number = |at: usize| file.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_be_bytes);
    if !file.starts_with(&SIGNATURE) {
        return None;
    }
    Some([number(16)?, number(20)?])
}

pub(super) fn chunk(out: &mut Vec<u8>, name: &[u8; 4], data: &[u8]) {
    out.extend((data.len() as u32).to_be_bytes());
    let start = out.len();
    out.extend(name);
    out.extend(data);
    let mut crc = Crc::new();
    crc.update(&out[start..]);
    out.extend(crc.sum().to_be_bytes());
}

/// A row as differences to the left, above or neither: the one with the smallest sum, as the standard
/// advises.
fn filtered(line: &[u8], above: &[u8]) -> Vec<u8> {
    let left = |at: usize| if at < 3 { 0 } else { line[at - 3] };
    let differences: [(u8, Vec<u8>); 3] = [
        (2, line.iter().zip(above).map(|(x, up)| x.wrapping_sub(*up)).collect()),
        (1, line.iter().enumerate().map(|(at, x)| x.wrapping_sub(left(at))).collect()),
        (0, line.to_vec()),
    ];
    let cost = |bytes: &[u8]| bytes.iter().map(|&x| u64::from((x as i8).unsigned_abs())).sum::<u64>();
    let best = differences.into_iter().min_by_key(|(_, bytes)| cost(bytes));
    let (kind, bytes) = best.expect("there are three");
    [&[kind], &bytes[..]].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back() {
        let (width, height) = (7, 5);
        let rgb: Vec<u8> = (0..3 * width * height).map(|n| (n * n % 251) as u8).collect();
        let file = encode([width, height], &rgb, Effort::Small);
        assert_eq!(size(&file), Some([7, 5]));
        let start = file.windows(4).position(|w| w == b"IDAT").unwrap();
        let length = u32::from_be_bytes(file[start - 4..start].try_into().unwrap()) as usize;
        let mut rows = Vec::new();
        ZlibDecoder::new(&file[start + 4..start + 4 + length]).read_to_end(&mut rows).unwrap();
        let mut back: Vec<u8> = Vec::new();
        for (n, line) in rows.chunks(22).enumerate() {
            for (at, x) in line[1..].iter().enumerate() {
                let from = match line[0] {
                    1 if at >= 3 => back[back.len() - 3],
                    2 if n > 0 => back[back.len() - 21],
                    _ => 0,
                };
                back.push(x.wrapping_add(from));
            }
        }
        assert_eq!(back, rgb);
        assert_eq!(decode(&encode([width, height], &rgb, Effort::Fast)), Some(([7, 5], rgb.clone())));
        assert_eq!(decode(&file), Some(([7, 5], rgb)));
        for length in 0..file.len() - 12 {
            assert_eq!(decode(&file[..length]), None, "{length} bytes");
        }
        assert_eq!(size(b"no picture at all, but long enough"), None);
        assert_eq!(size(&file[..18]), None);
    }
}
