//! Outlines: what bounds a solid in two dimensions. The line elements `l` of an OBJ ("Object Files (.obj)", appendix B1
//! of the Advanced Visualizer manual), as Blender and Inkscape write curves.

use std::path::Path;

use super::error::MeshError;
use super::format::obj::{self, LeftOut, face, logical_line, position};
use super::guard;
use super::skipped::Skipped;
use super::text::{Words, words};

/// Closed lines in the plane. What they enclose an odd number of times is inside, whichever way round they run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Positions, in the file's unit.
    pub points: Vec<[f64; 2]>,
    /// Pairs of indices into `points`, which are in range and of different places. Every point has an even number of
    /// segments.
    pub segments: Vec<[u32; 2]>,
    /// What was left out of the file: a sentence each, for warnings.
    pub notes: Vec<String>,
}

/// Reads the outline in the bytes of an OBJ file; `path` is named in errors.
///
/// # Errors
/// A [`MeshError`] that names the file: no OBJ, no lines, lines that aren't closed, vertices that aren't in one plane
/// z.
pub fn parse_outline(path: &Path, bytes: &[u8]) -> Result<Outline, MeshError> {
    guard::contain(obj::NAME, || read(bytes)).map_err(|error| error.in_file(path))
}

fn read(bytes: &[u8]) -> Result<Outline, MeshError> {
    let mut lines = Words::new(bytes, obj::NAME);
    let mut reader = Reader::default();
    loop {
        let here = lines.clone();
        let Some(line) = logical_line(&mut lines) else { break };
        let mut words = words(&line);
        match words.next() {
            Some(b"v" | b"V") => reader.positions.push(position(&here, words)?),
            Some(b"l" | b"L") => reader.add_line(&here, words)?,
            Some(b"f" | b"fo" | b"F" | b"FO") => reader.skipped.other += 1,
            Some(b"p" | b"P") => reader.skipped.points += 1,
            Some(word) => reader.left_out.add(word, &here, &mut reader.skipped),
            None => {}
        }
    }
    reader.finish(&lines)
}

#[derive(Default)]
struct Reader {
    positions: Vec<[f64; 3]>,
    segments: Vec<[u32; 2]>,
    /// Faces and curves are the other elements.
    skipped: Skipped,
    left_out: LeftOut,
}

impl Reader {
    fn add_line<'a>(&mut self, here: &Words, words: impl Iterator<Item = &'a [u8]>) -> Result<(), MeshError> {
        let mut corners = Vec::new();
        face(here, words, self.positions.len(), &mut corners)?;
        if corners.iter().any(|&corner| corner as usize >= self.positions.len()) {
            return Err(
                here.bad("the line refers to a vertex that comes after it or is missing; put vertices first")
            );
        }
        self.segments.extend(corners.windows(2).map(|pair| [pair[0], pair[1]]));
        Ok(())
    }

    fn finish(self, end: &Words) -> Result<Outline, MeshError> {
        let Reader { positions, mut segments, skipped, left_out } = self;
        segments.retain(|&[a, b]| positions[a as usize][..2] != positions[b as usize][..2]);
        if segments.is_empty() {
            let instead = if skipped.other > 0 { "faces: read it as a mesh" } else { "none" };
            return Err(end.bad(format!(
                "an outline is made of line elements, `l 1 2 3 1`, and the file has {instead}"
            )));
        }
        check_flat(&positions, &segments, end)?;
        check_closed(&positions, &segments, end)?;
        let mut notes: Vec<String> = left_out.note().into_iter().collect();
        if skipped.total() > 0 {
            notes.push(format!("left out, for they are no lines: {skipped}"));
        }
        Ok(Outline { points: positions.iter().map(|&[x, y, _]| [x, y]).collect(), segments, notes })
    }
}

fn check_flat(positions: &[[f64; 3]], segments: &[[u32; 2]], end: &Words) -> Result<(), MeshError> {
    let z = |vertex: u32| positions[vertex as usize][2];
    let plane = z(segments[0][0]);
    match segments.iter().flatten().find(|&&vertex| z(vertex) != plane) {
        None => Ok(()),
        Some(&vertex) => Err(end.bad(format!(
            "vertex {} is at z = {}, but the outline begins at z = {plane}; an outline lies in one \
             plane z: turn it there",
            vertex + 1,
            z(vertex)
        ))),
    }
}

/// Then every point but those on the lines is inside or outside.
fn check_closed(positions: &[[f64; 3]], segments: &[[u32; 2]], end: &Words) -> Result<(), MeshError> {
    let mut ends = vec![0u32; positions.len()];
    segments.iter().flatten().for_each(|&vertex| ends[vertex as usize] += 1);
    match ends.iter().position(|count| count % 2 == 1) {
        None => Ok(()),
        Some(vertex) => {
            let [x, y, _] = positions[vertex];
            Err(end.bad(format!(
                "the outline is open: a line ends at vertex {} at ({x}, {y}); close it by the number of the \
                 vertex where it begins, and join vertices that lie together",
                vertex + 1
            )))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Outline, String> {
        parse_outline(Path::new("a.obj"), text.as_bytes()).map_err(|error| error.to_string())
    }

    const SQUARE: &str = "v 0 0 1\nv 2 0 1 # corner\nv 2 1 1\nv 0 1 1\n";

    #[test]
    fn lines_of_any_length_are_read() {
        let segments = vec![[0, 1], [1, 2], [2, 3], [3, 0]];
        let expected =
            Outline { points: vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]], segments, notes: vec![] };
        for lines in ["l 1 2 3 4 1", "l 1 2\nl 2 3 \\\n 4\nl 4 1", "l -4/1 -3/2 -2\nl 3 4 4 1\nvn 0 0 1"] {
            assert_eq!(parse(&format!("{SQUARE}{lines}\n")).as_ref(), Ok(&expected), "{lines}");
        }
    }

    #[test]
    fn what_is_no_outline_is_refused_with_the_place() {
        let bad = [
            ("l 1 2 3 4", "vertex 1 at (0, 0)"),
            ("l 1 2 9 1", "line 5"),
            ("l 1 2 0 1", "`0` is not a corner"),
            ("l 1 x", "`x`"),
            ("f 1 2 3", "read it as a mesh"),
            ("l 1 1", "line elements"),
            ("v 5 5 0\nl 1 2 5 1", "vertex 5 is at z = 0"),
            ("v 5 nan 0\nl 1 2 3 1", "line 5"),
        ];
        for (lines, part) in bad {
            let error = parse(&format!("{SQUARE}{lines}\n")).unwrap_err();
            assert!(error.starts_with("a.obj: ") && error.contains(part), "{error}");
        }
        assert!(parse("").unwrap_err().contains("none"));
    }

    #[test]
    fn damaged_files_are_outlines_or_errors() {
        let whole = format!("{SQUARE}l 1 2 3 4 1\n");
        let mut outlines = 0;
        for at in 0..whole.len() {
            for byte in [0, b'9', b'-', b' ', b'\n', b'e', 0xFF] {
                let mut bytes = whole.clone().into_bytes();
                bytes[at] = byte;
                let Ok(outline) = parse_outline(Path::new("a.obj"), &bytes) else { continue };
                outlines += 1;
                assert!(outline.segments.iter().flatten().all(|&v| (v as usize) < outline.points.len()));
                assert!(outline.points.iter().flatten().all(|x| x.is_finite()));
            }
        }
        assert!(outlines > 0 && outlines < 7 * whole.len());
    }
}
