//! Raw triangles: text with a triangle a line, as nine numbers: x, y, z of each corner, counter-clockwise seen from
//! outside. There is no specification; Blender, Rhino and POV-Ray's tools write `.raw` files so.
//!
//! Nothing but nine numbers is a triangle: three numbers a line are mostly a point cloud, six its normals, too.

use crate::mesh::error::{MeshError, RECONSTRUCT};
use crate::mesh::raw::RawMesh;
use crate::mesh::text::{Words, not_a_number, number, words};

pub const NAME: &str = "RAW";

/// Reads raw triangles. A comment begins with `#`. Every triangle has three vertices of its own: welding joins them.
pub fn read(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut lines = Words::new(bytes, NAME);
    let mut raw = RawMesh::new(NAME);
    loop {
        let here = lines.clone();
        let Some(line) = lines.next_line() else { break };
        let end = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
        let Some(corners) = triangle(&here, &line[..end])? else { continue };
        let first = u32::try_from(raw.positions.len()).ok().filter(|&first| first < u32::MAX - 3);
        let Some(first) = first else {
            return Err(here.bad("too many triangles; split the mesh"));
        };
        raw.positions.extend(corners);
        raw.faces.push(&[first, first + 1, first + 2]);
    }
    Ok(raw)
}

/// The corners that a line holds; `None` of an empty one.
fn triangle(here: &Words, line: &[u8]) -> Result<Option<[[f64; 3]; 3]>, MeshError> {
    let mut numbers = [0.0; 9];
    let mut count = 0;
    for word in words(line) {
        let value = number(word).ok_or_else(|| here.bad(not_a_number(word, "corner of a triangle")))?;
        if let Some(place) = numbers.get_mut(count) {
            *place = value;
        }
        count += 1;
    }
    let corner = |k: usize| [numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]];
    match count {
        0 => Ok(None),
        9 => Ok(Some([corner(0), corner(1), corner(2)])),
        _ => Err(here.bad(wrong_count(count))),
    }
}

fn wrong_count(count: usize) -> String {
    let cure = match count {
        3 => &format!(
            "if these are points, {RECONSTRUCT}; if every three lines are a triangle, join them into one"
        ),
        6 => &format!("if these are points with normals, {RECONSTRUCT}"),
        12 => "split quadrilaterals into triangles",
        _ => "the line was cut or is damaged: export the file again",
    };
    let numbers = if count == 1 { "number" } else { "numbers" };
    format!("{count} {numbers}, but a triangle is nine: x, y, z of its three corners; {cure}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        read(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn nine_numbers_are_a_triangle() {
        let text = "\u{FEFF}# a comment\n0 0 0  1 0 0\t0 1 0 # one\r\n\n-1e2 .5 0 1 0 0 0 1 0";
        let raw = read(text.as_bytes()).unwrap();
        assert_eq!(raw.faces.iter().collect::<Vec<_>>(), [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(raw.positions[2..4], [[0.0, 1.0, 0.0], [-100.0, 0.5, 0.0]]);
    }

    #[test]
    fn any_other_count_is_an_error_with_the_line_and_a_cure() {
        let good = "0 0 0 1 0 0 0 1 0\n";
        for (line, part) in [
            ("1 2 3", "reconstruct a surface"),
            ("1 2 3", "join them into one"),
            ("1 2 3 0 0 1", "points with normals"),
            ("0 0 0 1 0 0 1 1 0 0 1 0", "split quadrilaterals"),
            ("1", "1 number, but"),
            ("1 2 3 4 5 6 7 8", "8 numbers, but"),
            ("1 2 3 4 5 6 7 8 9 10", "10 numbers, but"),
            ("Cube", "`Cube` is not a number"),
            ("1,2,3", "decimal point"),
            ("nan 0 0 1 0 0 0 1 0", "not finite"),
        ] {
            let error = error(&format!("{good}# c\n{line}\n{good}"));
            assert!(error.starts_with("RAW, line 3: ") && error.contains(part), "{error}");
        }
    }
}
