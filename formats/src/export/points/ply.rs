//! Particles as binary PLY, one vertex each. Turk 1994, *The PLY Polygon File Format*.
//!
//! Numbers of things, such as ids, are `int`: Blender 4.5 and Open3D drop `uint`. Only where one is 2^31 or more, they
//! are `uint`. The vector `velocity` becomes the properties `vx`, `vy`, `vz`; other vectors `name_x` and so on.

use super::{Points, Positions, Values};
use crate::export::{ExportError, publish_to};
use std::path::Path;

/// Writes particles.
///
/// # Errors
/// Lists of different lengths, or a file that can't be written.
pub fn write(path: &Path, points: &Points) -> Result<(), ExportError> {
    points.check(usize::MAX).map_err(|error| ExportError::Io(error).in_file(path))?;
    publish_to(path, &to_bytes(points))
}

fn to_bytes(points: &Points) -> Vec<u8> {
    let count = points.positions.len();
    let mut header = "ply\nformat binary_little_endian 1.0\n".to_owned();
    for (name, numbers) in &points.facts {
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        header += &format!("comment {name} {}\n", numbers.join(" "));
    }
    header += &format!("element vertex {count}\n");
    let mut property = |kind: &str, name: &str| header += &format!("property {kind} {name}\n");
    let kind = if matches!(points.positions, Positions::F32(_)) { "float" } else { "double" };
    ["x", "y", "z"].iter().for_each(|name| property(kind, name));
    for (name, values) in &points.arrays {
        match values {
            Values::F32(_) => property("float", name),
            Values::U32(v) if v.iter().all(|&n| i32::try_from(n).is_ok()) => property("int", name),
            Values::U32(_) => property("uint", name),
            Values::Vector(_) if *name == "velocity" => {
                ["vx", "vy", "vz"].iter().for_each(|n| property("float", n))
            }
            Values::Vector(_) => {
                ["x", "y", "z"].iter().for_each(|c| property("float", &format!("{name}_{c}")))
            }
        }
    }
    header += "end_header\n";
    let mut bytes = Vec::with_capacity(header.len() + count * points.point_bytes());
    bytes.extend(header.as_bytes());
    for point in 0..count {
        points.positions.add(point, &mut bytes);
        let words = points.arrays.iter().flat_map(|(_, values)| values.words(point));
        bytes.extend(words.flat_map(u32::to_le_bytes));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::super::tests::with_sample;
    use super::*;

    #[test]
    fn points_follow_the_header() {
        let bytes = with_sample(to_bytes);
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let header = std::str::from_utf8(&bytes[..end]).unwrap();
        assert!(header.contains("comment TimeValue 0.25\nelement vertex 50\nproperty float x\n"), "{header}");
        let properties = ["float vx", "float vy", "float vz", "float density", "int id"];
        let end_of_header = format!("property {}\nend_header\n", properties.join("\nproperty "));
        assert!(header.ends_with(&end_of_header), "{header}");
        assert_eq!(bytes.len() - end, 50 * 4 * 8);
        let word = |n: usize| <[u8; 4]>::try_from(&bytes[end + 4 * n..][..4]).unwrap();
        assert_eq!(f32::from_le_bytes(word(3 * 8 + 4)), 3.0, "velocity of point 3 along y");
        assert_eq!(u32::from_le_bytes(word(3 * 8 + 7)), 46, "its id");
        let ids = Values::U32(&[1 << 31]);
        let bytes = to_bytes(&Points {
            positions: Positions::F32(&[[0.0; 3]]),
            arrays: vec![("id", ids)],
            ..Points::default()
        });
        assert!(String::from_utf8_lossy(&bytes).contains("property uint id"));
    }

    #[test]
    fn places_may_be_double() {
        let places = [[500_000.025, 0.0, 4_650_000.125]; 2];
        let bytes = to_bytes(&Points { positions: Positions::F64(&places), ..Points::default() });
        assert!(bytes.windows(17).any(|w| w == b"property double z"));
        assert!(bytes.ends_with(&4_650_000.125_f64.to_le_bytes()));
    }
}
