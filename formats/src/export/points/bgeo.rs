//! Particles as Houdini's classic binary geometry (`.bgeo`, version 5), as partio writes and reads it (Walt Disney
//! Animation Studios, `BGEO.cpp`): big-endian, not compressed.

use super::{Points, Values};
use crate::export::{ExportError, publish_to};
use std::path::Path;

/// Houdini's numbers of the types.
const FLOAT: i32 = 0;
const INTEGER: i32 = 1;
const VECTOR: i32 = 5;

/// Writes particles, places in single precision. Integers are signed in this format: those above 2^31 - 1 become
/// negative.
///
/// # Errors
/// Lists of different lengths, more than 2^31 - 1 points, or a file that can't be written.
pub fn write(path: &Path, points: &Points) -> Result<(), ExportError> {
    points.check(i32::MAX as usize).map_err(|error| ExportError::Io(error).in_file(path))?;
    publish_to(path, &to_bytes(points))
}

fn to_bytes(points: &Points) -> Vec<u8> {
    let count = points.positions.len();
    // The fourth coordinate is a word more.
    let mut bytes = Vec::with_capacity(256 + count * (points.point_bytes() + 4));
    bytes.extend(b"BgeoV");
    // Version; points, primitives; groups of points, of primitives; attributes of points, vertices, primitives, of
    // the whole.
    let numbers = [5, count as i32, 0, 0, 0, points.arrays.len() as i32, 0, 0, 0];
    bytes.extend(numbers.iter().flat_map(|n| n.to_be_bytes()));
    for (name, values) in &points.arrays {
        let kind = match values {
            Values::F32(_) => FLOAT,
            Values::U32(_) => INTEGER,
            Values::Vector(_) => VECTOR,
        };
        bytes.extend((name.len() as u16).to_be_bytes());
        bytes.extend(name.as_bytes());
        bytes.extend((values.components() as u16).to_be_bytes());
        bytes.extend(kind.to_be_bytes());
        // What a new point gets.
        bytes.extend(std::iter::repeat_n(0, 4 * values.components()));
    }
    for point in 0..count {
        let position = points.positions.rounded(point).map(f32::to_bits);
        let coordinates = position.into_iter().chain([1.0f32.to_bits()]);
        let values = points.arrays.iter().flat_map(|(_, values)| values.words(point));
        bytes.extend(coordinates.chain(values).flat_map(u32::to_be_bytes));
    }
    // No more attributes, end of the file.
    bytes.extend([0x00, 0xff]);
    bytes
}

#[cfg(test)]
mod tests {
    use super::super::tests::with_sample;
    use super::*;

    #[test]
    fn layout_is_that_of_partio() {
        let bytes = with_sample(to_bytes);
        assert_eq!(&bytes[..13], b"BgeoV\0\0\0\x05\0\0\0\x32", "50 points");
        let attributes = 41 + 3 * 8 + "velocitydensityid".len() + 4 * 5;
        assert_eq!(&bytes[41..51], b"\0\x08velocity");
        assert_eq!(bytes.len(), attributes + 50 * 4 * 9 + 2);
        let word = |n: usize| <[u8; 4]>::try_from(&bytes[attributes + 4 * n..][..4]).unwrap();
        assert_eq!(f32::from_be_bytes(word(9 + 3)), 1.0, "the fourth coordinate");
        assert_eq!(f32::from_be_bytes(word(9 + 5)), 1.0, "velocity of point 1 along y");
        assert_eq!(i32::from_be_bytes(word(9 + 8)), 48, "its id");
    }
}
